//! Parents and children (D4; H3: 13, 27; H4: 16).

use proptest::prelude::*;

use super::*;
use crate::entity::Child;
use crate::math::Frame;
use crate::physics::attachment::Attachment;
use crate::physics::fuzzing::check_membership;

fn on(part: u32, frame: Frame) -> Attachment {
    Attachment::Part { part, frame }
}

fn attach(world: &mut World, child: EntityId, parent: EntityId, to: Attachment) -> bool {
    world
        .with_entity(child, |e, w| e.set_parent(parent, to, w))
        .expect("there")
}

const HERE: Attachment = Attachment::Part {
    part: Child::NO_PART,
    frame: Frame::IDENTITY,
};

/// H4, 16: nobody carries himself, directly or not.
#[test]
fn cycles_are_refused() {
    let mut world = world();
    let [a, b, c] = [0.0, 6.0, 12.0].map(|x| walker(&mut world, at(30.0 + x, 30.0, 0.0)));
    assert!(!attach(&mut world, a, a, HERE));
    assert!(attach(&mut world, b, a, HERE));
    assert!(attach(&mut world, c, b, HERE));
    assert!(!attach(&mut world, a, b, HERE));
    assert!(!attach(&mut world, a, c, HERE));
    frame(&mut world, 100.1);
    for id in [a, b, c] {
        check_membership(&world, id);
    }
    let guid = |id: EntityId| world.entity(id).expect("there").guid();
    let carrier = world.entity(a).expect("there");
    assert_eq!(carrier.child_of_guid(guid(b), &world), Some(b));
    assert_eq!(
        carrier.child_of_guid(guid(c), &world),
        None,
        "a child's child"
    );
    // The carried ones leave with their carrier.
    world.with_entity(a, |e, w| e.leave_world(w));
    assert!(
        [a, b, c]
            .iter()
            .all(|&id| world.entity(id).expect("there").body.cell.is_none())
    );
}

#[test]
fn parts_and_carriers_that_are_not_there() {
    let mut world = world();
    let a = walker(&mut world, at(30.0, 30.0, 0.0));
    let b = walker(&mut world, at(36.0, 30.0, 0.0));
    assert!(
        !attach(&mut world, b, a, on(1, Frame::IDENTITY)),
        "there is one part"
    );
    assert!(
        !attach(&mut world, b, a, Attachment::Location(7)),
        "no such location"
    );
    assert!(!attach(&mut world, b, EntityId(99), HERE));
    let entity = world.entity(b).expect("there");
    assert!(entity.body.parent.is_none() && entity.body.cell.is_some());
    // A carrier outside the world takes its child out of it.
    let outside = object(&mut world, WALKER, 0x408, None);
    assert!(attach(&mut world, b, outside, HERE));
    let entity = world.entity(b).expect("there");
    assert!(entity.body.cell.is_none() && entity.kin.transient.is_empty());
}

/// To the same parent again: the list holds the child once.
#[test]
fn attaching_anew_replaces_the_old_link() {
    let mut world = world();
    let a = walker(&mut world, at(30.0, 30.0, 0.0));
    let b = walker(&mut world, at(36.0, 30.0, 0.0));
    assert!(attach(&mut world, b, a, HERE));
    assert!(attach(&mut world, b, a, on(0, Frame::from_origin(Vec3::X))));
    let children = &world.entity(a).expect("there").children;
    assert_eq!(children.len(), 1);
    world.with_entity(b, |e, w| e.unset_parent(w));
    assert!(world.entity(a).expect("there").children.is_empty());
    let entity = world.entity(b).expect("there");
    assert!(entity.kin.transient.is_empty(), "H3, 13");
    assert!(
        entity.body.cell.is_some(),
        "it keeps its cell until it is placed"
    );
}

#[test]
fn a_destroyed_carrier_lets_go() {
    let mut world = world();
    let a = walker(&mut world, at(30.0, 30.0, 0.0));
    let b = walker(&mut world, at(36.0, 30.0, 0.0));
    assert!(attach(&mut world, b, a, HERE));
    world.with_entity(a, |e, w| e.leave_for_good(w));
    world.forget(a);
    let entity = world.entity(b).expect("there");
    assert!(entity.body.parent.is_none());
    frame(&mut world, 100.1);
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    /// H3, 27: the child is where its parent's frame and the attachment put it, whatever the parent does.
    #[test]
    fn the_child_follows(
        part in prop::sample::select(vec![0, Child::NO_PART]),
        offset in (-3.0_f32..3.0, -3.0_f32..3.0, -3.0_f32..3.0), turn in 0.0_f32..360.0,
        moves in prop::collection::vec((-9.0_f32..9.0, -9.0_f32..9.0, 0.0_f32..5.0, 0.0_f32..360.0), 1..8),
    ) {
        let mut world = world();
        let profile = Profile::retail();
        let a = walker(&mut world, at(50.0, 46.0, 0.0));
        let b = walker(&mut world, at(36.0, 30.0, 0.0));
        let mut link = Frame::from_origin(Vec3::new(offset.0, offset.1, offset.2));
        link.set_heading(turn, &profile);
        prop_assert!(attach(&mut world, b, a, on(part, link)));
        let mut now = 100.0;
        for (x, y, z, heading) in moves {
            world.with_entity(a, |e, w| {
                e.set_heading(heading, w);
                e.set_velocity(Vec3::new(x, y, z), w);
            });
            now += 0.1;
            frame(&mut world, now);
            let parent = &world.entity(a).expect("there").body;
            let base = if part == 0 {
                parent.part_array.as_ref().expect("parts").parts[0].as_ref().expect("a part").position.frame
            } else {
                parent.position.frame
            };
            let child = &world.entity(b).expect("there").body;
            prop_assert_eq!(child.position.frame.bits(), base.combine(&link, &profile).bits());
            prop_assert_eq!((child.cell, child.position.cell), (parent.cell, parent.position.cell));
            check_membership(&world, a);
            check_membership(&world, b);
        }
    }
}
