//! Every bundled vector of every family and oracle is met bit for bit under the oracle's own profile.

use ac_conformance::vectors::{FAMILIES, run_file};
use ac_golden_traces::corpus;

#[test]
fn every_vector_is_met() {
    let files = corpus::find(&corpus::bundled().join("vectors"), &[".jsonl.gz"])
        .expect("the bundled vectors are there");
    for oracle in ["ace", "gdle"] {
        let of_oracle = files
            .iter()
            .filter(|f| f.components().any(|c| c.as_os_str() == oracle))
            .count();
        assert_eq!(of_oracle, FAMILIES.len(), "families of {oracle}");
    }
    let mut exact = 0;
    for file in &files {
        for result in run_file(file, None).expect("a readable vector file") {
            assert!(result.all_exact(), "{}: {result:?}", file.display());
            exact += result.exact;
        }
    }
    assert!(exact > 30_000, "{exact} vectors compared");
}
