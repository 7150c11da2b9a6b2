use super::*;
use crate::run::{Mode, StageCount};

const NASTY: &str = "x/</script><script>alert(1)</script><!--";

fn result() -> RunResult {
    RunResult {
        scene: NASTY.into(),
        area: "x".into(),
        oracle: "ace".into(),
        profile: "ace".into(),
        mode: Mode::Free,
        guid: "0x1".into(),
        frames_compared: 3,
        frames_exact: 1,
        first_divergence: Some(Divergence {
            frame: 1,
            stage: None,
            field: "origin[0]".into(),
            expected: json!(1.0),
            actual: json!(f64::from(1.0f32.next_up())),
        }),
        max_error: BTreeMap::new(),
        undefined: 0,
        class: Class::WithinTolerance,
        tolerated: BTreeMap::new(),
        not_run: 0,
        stages: BTreeMap::from([("commit".into(), StageCount::default())]),
    }
}

#[test]
fn strings_of_a_trace_stay_strings() {
    let results = [result()];
    let baseline = Baseline::default();
    let series = [Series::new(NASTY, "ace", Mode::Free, 1)];
    let text = page(
        &results,
        &series,
        &Totals::of(&results, &baseline),
        &baseline,
    );
    assert!(!text.contains("<script>alert"));
    // Data, one detail, the program: nothing else opens or closes a script.
    assert_eq!(text.matches("<script").count(), 3);
    assert_eq!(text.matches("</script>").count(), 3);
    assert!(
        !text.contains("<!--"),
        "a placeholder is left, or data opened a comment"
    );
}

#[test]
fn the_card_has_exact_values_and_ulps() {
    let row = row(&result(), &Baseline::default(), None);
    assert_eq!(row[10][3], "1.0");
    assert_eq!(row[10][4], "1.0000001192092896");
    assert_eq!(row[10][5], "1");
    assert!(row[10][7].as_str().unwrap().contains("spec/06"));
}

#[test]
fn nothing_is_loaded_from_elsewhere() {
    let text = page(&[], &[], &Totals::default(), &Baseline::default());
    for reference in ["src=", "@import", "url(", "fetch(", "XMLHttpRequest"] {
        assert!(!text.contains(reference), "{reference}");
    }
    let links = text.matches("http").count() - text.matches("http://www.w3.org/2000/svg").count();
    assert_eq!(links, text.matches("http-equiv").count());
}
