//! In the steady state a tick allocates nothing.

#[path = "../benches/common/mod.rs"]
mod common;

use common::Case;

#[track_caller]
fn assert_no_allocation(mut case: Case) {
    case.run(200);
    let info = allocation_counter::measure(|| case.run(200));
    assert_eq!(info.count_total, 0, "{info:?}");
}

#[test]
fn resting() {
    assert_no_allocation(common::resting());
}

#[test]
fn sliding() {
    assert_no_allocation(common::sliding());
}

#[test]
fn idle_npc() {
    assert_no_allocation(common::idle_npcs(1));
}

#[test]
fn walking() {
    assert_no_allocation(common::walking());
}

#[test]
fn running_on_slopes() {
    assert_no_allocation(common::running_on_slopes());
}

#[test]
fn running_in_a_room() {
    assert_no_allocation(common::running_in_a_room());
}
