//! Frame clocks.

use super::*;

#[test]
fn clocks_are_read() {
    assert_eq!("fixed:30".parse(), Ok(FrameClock::Fixed(30.0)));
    assert_eq!("recorded".parse(), Ok(FrameClock::Recorded));
    for bad in ["", "fixed", "fixed:0", "fixed:nan", "fixed:1e9", "30"] {
        assert!(bad.parse::<FrameClock>().is_err(), "{bad}");
    }
}
