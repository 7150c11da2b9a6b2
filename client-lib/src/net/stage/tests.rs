//! Counters of the network stage.

use super::*;

#[test]
fn gaps_in_the_events_are_counted() {
    let mut stage = NetworkStage::new();
    // The first number of a session may be any; a server may begin again.
    for sequence in [7, 8, 9, 12, 13, 1, 2] {
        stage.count_event(sequence);
    }
    assert_eq!(stage.stats.event_gaps, 1);
    let gap = StageNote::EventGap {
        expected: 10,
        found: 12,
    };
    assert_eq!(stage.notes, [gap]);
}
