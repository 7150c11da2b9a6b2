use super::*;
use crate::{
    compare::Class,
    gate::Skipped,
    run::{Mode, StageCount},
};

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
        class: Class::Diverged,
        tolerated: BTreeMap::new(),
        not_run: 0,
        stages: BTreeMap::from([("commit".into(), StageCount::default())]),
    }
}

#[test]
fn strings_of_a_trace_stay_strings() {
    let skipped = Skipped {
        scene: NASTY.into(),
        reason: NASTY.into(),
    };
    let document = Document {
        results: vec![result()],
        series: vec![Series::new(NASTY, "ace", Mode::Free, 1)],
        skipped: vec![skipped],
        errors: vec![NASTY.into()],
        ..Document::default()
    };
    let text = page(&document, &Policy::default(), &Baseline::default());
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
    let row = row(&result(), Verdict::New, &Baseline::default(), None);
    assert_eq!(row[10][3], "1.0");
    assert_eq!(row[10][4], "1.0000001192092896");
    assert_eq!(row[10][5], "1");
    assert!(row[10][7].as_str().unwrap().contains("spec/06"));
}

#[test]
fn nothing_is_loaded_from_elsewhere() {
    let text = page(
        &Document::default(),
        &Policy::default(),
        &Baseline::default(),
    );
    for reference in ["src=", "@import", "url(", "fetch(", "XMLHttpRequest"] {
        assert!(!text.contains(reference), "{reference}");
    }
    let links = text.matches("http").count() - text.matches("http://www.w3.org/2000/svg").count();
    assert_eq!(links, text.matches("http-equiv").count());
}

#[test]
fn verdicts_rules_and_skipped_scenes_are_in_the_data() {
    let policy = Policy::parse(
        "[[tolerance]]\nscene = 'jump/*'\nfield = 'velocity'\nulp = 4\nreason = 'rounded once more'\n\
         [[tolerance]]\nfield = 'time'\nabs = 1\nreason = 'never'\n",
    )
    .unwrap();
    let mut within = result();
    within.first_divergence = None;
    within.class = Class::WithinTolerance;
    let rule = policy.rules[0].title();
    within.tolerated.insert(rule.clone(), 3);
    let skipped = Skipped {
        scene: "c/skipped".into(),
        reason: "takes hours".into(),
    };
    let document = Document {
        results: vec![result(), within],
        skipped: vec![skipped],
        ..Document::default()
    };
    let text = page(&document, &policy, &Baseline::default());
    let start = text.find("id=\"data\">").unwrap() + "id=\"data\">".len();
    let end = start + text[start..].find("</script>").unwrap();
    let data: Value = serde_json::from_str(&text[start..end]).unwrap();
    let verdict =
        |row: usize| &data["verdicts"][data["results"][row][6].as_u64().unwrap() as usize];
    assert_eq!(
        (verdict(0), verdict(1)),
        (&json!("new"), &json!("within tolerance"))
    );
    assert_eq!(data["results"][1][15], json!([[rule, 3]]));
    assert_eq!(data["rules"][0], json!(["scene jump/*", rule, 3]));
    assert_eq!(data["rules"][1][2], 0);
    assert_eq!(data["skipped"], json!([["c/skipped", "takes hours"]]));
}
