//! The committed state hashes: the same bits in every build, with any number of threads.

use std::fs;

use ac_client::profile::Profile;
use ac_conformance::{
    hash::{HashFile, check, hash_all},
    run::cases,
};
use ac_golden_traces::corpus;
use ac_replayer::client::ClientSimulator;

#[test]
fn the_bundled_scenes_have_the_committed_hashes_with_one_and_two_threads() {
    let root = corpus::bundled();
    let text = fs::read_to_string(root.join("hashes.txt")).expect("the file of hashes is there");
    let file = HashFile::parse(&text).expect("it is readable");
    let cases = cases::find(&[root.join("traces")], None, None).expect("the traces are there");
    let profile = Profile::named(&file.profile).expect("its profile exists");
    let simulator = ClientSimulator::new(root.join("worlds"));
    for threads in [1, 2] {
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()
            .expect("threads start");
        let (hashes, errors) = pool.install(|| hash_all(&simulator, &cases, &profile, || ()));
        assert!(errors.is_empty(), "could not run: {}", errors[0]);
        let differences = check(&file, &hashes);
        assert!(
            differences.is_empty(),
            "{threads} threads; if the change is wanted, write `ac-conform hash > golden-traces/hashes.txt`: {differences:#?}"
        );
    }
}
