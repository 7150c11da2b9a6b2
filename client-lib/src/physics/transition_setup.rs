//! What an object puts into a transition (`spec/06-physics-object.md`, C1; `spec/05-transition.md`, 6.9).

use crate::entity::Entity;
use crate::frame::probe::{Probe, StageData, TickStage};
use crate::math::Position;
use crate::physics::body::ObjectRef;
use crate::physics::state::{PhysicsState, TransientState};
use crate::physics::transition::{
    ContactPlane, ContactSeed, MoverSpheres, ObjectInfo, ObjectInfoState, Path, SphereUse, Transit,
    TransitionInput,
};
use crate::physics::update::{Side, observe};
use crate::world::World;

impl Entity {
    /// The mover as a transition sees it, with these bits and the weenie's (`init_object`).
    fn object_info(&self, bits: ObjectInfoState, world: &World) -> ObjectInfo {
        let (up, down) = self
            .body
            .part_array
            .as_ref()
            .map_or((0.0, 0.0), |p| (p.step_up_height(), p.step_down_height()));
        ObjectInfo::of_body(
            self.object_ref(),
            &self.body,
            bits,
            up,
            down,
            &world.profile,
        )
    }

    /// The own spheres, scaled, or what stands in for them.
    fn mover_spheres(&self, purpose: SphereUse, world: &World) -> MoverSpheres {
        let spheres = self
            .body
            .part_array
            .as_ref()
            .map_or(&[][..], |p| p.spheres());
        MoverSpheres::new(spheres, self.body.scale, purpose, &world.profile)
    }

    /// The contact plane as the object remembers it.
    fn known_plane(&self) -> ContactPlane {
        ContactPlane {
            valid: true,
            plane: self.kin.contact_plane,
            cell_id: self.kin.contact_plane_cell_id,
            is_water: self.kin.transient.contains(TransientState::WATER_CONTACT),
        }
    }

    /// Bits and seeds of a movement (`get_object_info` without `admin_move`).
    fn movement_bits(&self) -> (ObjectInfoState, ContactSeed) {
        let transient = self.kin.transient;
        let mut bits = ObjectInfoState::empty();
        bits.set(
            ObjectInfoState::EDGE_SLIDE,
            self.body.state.contains(PhysicsState::EDGE_SLIDE),
        );
        let mut seed = ContactSeed::None;
        if transient.contains(TransientState::CONTACT) {
            if self.kin.check_contact(true) {
                seed = ContactSeed::Contact(self.known_plane());
                bits |= ObjectInfoState::CONTACT;
                bits.set(
                    ObjectInfoState::ON_WALKABLE,
                    transient.contains(TransientState::ON_WALKABLE),
                );
            } else {
                seed = ContactSeed::Leaving(self.known_plane());
            }
        }
        let free = self
            .body
            .part_array
            .as_ref()
            .is_some_and(|p| p.allows_free_heading());
        bits.set(ObjectInfoState::FREE_ROTATE, free);
        // The state bit PATH_CLIPPED is not consulted.
        bits.set(
            ObjectInfoState::PATH_CLIPPED,
            self.body.state.contains(PhysicsState::MISSILE),
        );
        (bits, seed)
    }

    /// A movement from here to `goal`.
    pub fn movement_input(&self, goal: &Position, world: &World) -> TransitionInput {
        let (bits, contact) = self.movement_bits();
        let transient = self.kin.transient;
        TransitionInput {
            mover: self.object_info(bits, world),
            spheres: self.mover_spheres(SphereUse::Move, world),
            begin_cell: self.body.cell,
            path: Path::Move {
                begin: self.body.position,
                end: *goal,
            },
            contact,
            sliding_normal: transient
                .contains(TransientState::SLIDING)
                .then_some(self.kin.sliding_normal),
            frames_stationary_fall: self.stationary_count(),
        }
    }

    fn stationary_count(&self) -> u32 {
        let transient = self.kin.transient;
        if transient.contains(TransientState::STATIONARY_STUCK) {
            3
        } else if transient.contains(TransientState::STATIONARY_STOP) {
            2
        } else {
            u32::from(transient.contains(TransientState::STATIONARY_FALL))
        }
    }

    /// A placement at `place`, in `cell`.
    pub(crate) fn placement_input(
        &self,
        cell: Option<crate::world::CellHandle>,
        place: &Position,
        slide: bool,
        do_not_load_cells: bool,
        world: &World,
    ) -> TransitionInput {
        TransitionInput {
            mover: self.object_info(ObjectInfoState::empty(), world),
            spheres: self.mover_spheres(SphereUse::Place, world),
            begin_cell: cell,
            path: Path::Place {
                at: *place,
                slide,
                do_not_load_cells,
            },
            contact: ContactSeed::None,
            sliding_normal: None,
            frames_stationary_fall: 0,
        }
    }

    /// Runs the transition to `goal` (`transition`, C1): the transit, if it found a valid position. The transit is given back either way.
    pub(crate) fn transition<P: Probe>(
        &mut self,
        goal: &Position,
        quantum: f32,
        world: &mut World,
        probe: &mut P,
    ) -> Option<Box<Transit>> {
        let mut transit = world.slots.make(&world.profile)?;
        let input = self.movement_input(goal, world);
        let data = StageData::Transition {
            input: &input,
            result: None,
        };
        observe(
            self,
            world,
            probe,
            TickStage::Transition,
            quantum,
            data,
            Side::Before,
        );
        let valid = world.run_transition(&mut transit, &input);
        world.slots.cleanup();
        if transit.result.velocity_killed {
            self.set_velocity(crate::math::Vec3::ZERO, world);
        }
        let data = StageData::Transition {
            input: &input,
            result: Some(&transit.result),
        };
        observe(
            self,
            world,
            probe,
            TickStage::Transition,
            quantum,
            data,
            Side::After,
        );
        if valid {
            return Some(transit);
        }
        world.slots.recycle(transit);
        None
    }

    /// Would this object, where it is, touch `target`? (`check_collision`, C6.) Static objects touch nothing.
    ///
    /// A direct test without a search for cells. `target` is given with its body because it may be taken out of the world.
    fn check_collision(&self, target: &Entity, world: &mut World) -> bool {
        if self.body.state.contains(PhysicsState::STATIC) {
            return false;
        }
        let Some(mut transit) = world.slots.make(&world.profile) else {
            return false;
        };
        let mut input = self.movement_input(&self.body.position, world);
        input.spheres = self.mover_spheres(SphereUse::Check, world);
        let touches =
            world.run_collision_check(&mut transit, &input, target.object_ref(), &target.body);
        world.slots.cleanup();
        world.slots.recycle(transit);
        touches
    }

    /// Whether some other object stands in this one (`ethereal_check_for_collisions`).
    pub(crate) fn ethereal_check_for_collisions(&mut self, world: &mut World) -> bool {
        for index in 0..self.body.shadows.len() {
            let Some(cell) = self.body.shadows[index].cell else {
                continue;
            };
            let mut at = 0;
            while let Some(object) = world
                .land
                .cell(cell)
                .and_then(|c| c.base().shadows.get(at).copied())
            {
                at += 1;
                let ObjectRef::Entity(id) = object else {
                    // Static objects never report.
                    continue;
                };
                let touches = world.with_entity(id, |other, world| {
                    other.body.parent.is_none() && other.check_collision(self, world)
                });
                if touches == Some(true) {
                    return true;
                }
            }
        }
        false
    }
}
