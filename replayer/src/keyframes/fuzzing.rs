//! Body of the fuzz target `keyframe` in `fuzz/`. It is here so that a deterministic smoke of the very same body runs with the tests.

use std::sync::OnceLock;

use ac_client::{frame::FrameStates, profile::Profile};
use ac_golden_traces::{Scene, corpus, trace::TraceReader};

use super::{decode, encode};
use crate::{Simulator, client::ClientSimulator};

/// A small scene of the bundled ones.
pub(super) const SCENE: &str = "terrain/cliff-jump";

fn scene() -> Option<&'static (ClientSimulator, Scene)> {
    static SCENE_OF_ALL: OnceLock<Option<(ClientSimulator, Scene)>> = OnceLock::new();
    let made = SCENE_OF_ALL.get_or_init(|| {
        let path = corpus::bundled().join(format!("traces/{SCENE}.mcap"));
        let scene = TraceReader::open(&path).ok()?.scene().clone();
        let simulator = ClientSimulator::new(corpus::bundled().join("worlds"));
        Some((simulator, scene))
    });
    made.as_ref()
}

/// Reads any bytes as a keyframe, and as the snapshot in one. What can be restored runs some frames and is stored again; nothing panics, and
/// no memory is taken out of proportion.
pub fn keyframe(data: &[u8]) {
    if let Ok((header, snapshot)) = decode(data) {
        let again = encode(&header, &snapshot).expect("what was read can be written");
        let (same, bytes) = decode(&again).expect("what was written can be read");
        assert!(same == header && bytes == snapshot, "writing is stable");
        self::snapshot(&snapshot);
    }
    snapshot(data);
}

/// Restores any bytes as a snapshot.
pub fn snapshot(data: &[u8]) {
    let Some((simulator, scene)) = scene() else {
        return;
    };
    let profile = Profile::gdle();
    let Ok(mut simulation) = simulator.resume(scene, &profile, data) else {
        return;
    };
    let mut states = FrameStates::new();
    let first = simulation.snapshot().expect("what was restored is stored");
    let first = first.expect("this client takes snapshots");
    let restored = simulator.resume(scene, &profile, &first);
    let again = restored.map(|again| again.snapshot());
    assert!(
        again.is_ok_and(|again| again.is_ok_and(|again| again.is_some_and(|again| again == first))),
        "storing is stable"
    );
    for frame in 0..4 {
        states.clear();
        if simulation.step(frame, &mut states).is_err() {
            return;
        }
    }
}
