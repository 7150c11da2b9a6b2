
#[path = "../benches/common/mod.rs"]
mod common;
fn main() {
    for (n, mut c) in [("slopes", common::running_on_slopes()), ("room", common::running_in_a_room()), ("crowd", common::crowd(50))] {
        for f in 0..240 {
            c.step();
            if f % 8 == 0 {
                let e = c.world.entity(c.moving[0]).unwrap();
                println!("{n} {f} {:08X} {:?} {:?} {:?} n {:?} {}", e.body.position.cell.0, e.body.position.frame.origin, e.kin.transient, e.steps.last().map(|s| s.outcome), e.kin.contact_plane.n, e.body.shadows.len());
            }
        }
    }
    let mut c = common::mostly_idle(10000, 0);
    c.run(100);
    let n = c.world.entities.table().len();
    let mut act = 0;
    let (mut lo, mut hi) = (1e9f32, -1e9f32);
    for i in c.world.entities.table() { let e = c.world.entity(*i).unwrap(); if e.kin.transient.bits() & 0x80 != 0 { act += 1; } let z = e.body.position.frame.origin.z; lo = lo.min(z); hi = hi.max(z); }
    println!("{n} {act} {lo} {hi}");
}
