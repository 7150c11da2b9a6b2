//! Collision with one object (`spec/05-transition.md`, section 11; `spec/06-physics-object.md`, C6).

use super::state::{InsertType, ObjectInfoState, Transition, TransitionState};
use crate::physics::body::{Body, ObjectRef};
use crate::physics::collision::{PlacedPart, find_part_collisions};
use crate::physics::state::PhysicsState;

impl<'w> Transition<'w> {
    /// Tests the mover against one object, `target`, whose body is `body` (`FindObjCollisions`), and records what was touched.
    ///
    /// The caller has left out the mover itself and objects with a parent. The shapes are, in this order, the physics BSPs of the parts, the
    /// cylspheres, the spheres: an object with a physics BSP is tested only by that.
    pub fn find_obj_collisions(&mut self, target: ObjectRef, body: &'w Body) -> TransitionState {
        let profile = self.profile();
        let has = |bit| body.state.contains(bit);
        let weenie_creature = body.weenie.present && body.weenie.creature;
        if has(PhysicsState::ETHEREAL) && has(PhysicsState::IGNORE_COLLISIONS) {
            return TransitionState::Ok;
        }
        if weenie_creature && self.object.is_viewer() {
            return TransitionState::Ok;
        }
        let passable =
            has(PhysicsState::ETHEREAL) || (self.object.ethereal && !has(PhysicsState::STATIC));
        if passable && self.path.step_down {
            return TransitionState::Ok;
        }
        self.path.obstruction_ethereal = passable;
        let ignored = self.object.player_exempt(body) || self.object.missile_ignore(body, profile);
        let creature = has(PhysicsState::MISSILE) || weenie_creature;
        let mut result = TransitionState::Ok;
        if !ignored {
            result = self.test_shapes(body, creature);
        }
        if result != TransitionState::Ok && !self.path.step_down {
            result = self.record_touch(target, body, passable, creature, result);
        }
        self.path.obstruction_ethereal = false;
        result
    }

    /// Tests the shapes of `body`: the first outcome that is not OK.
    fn test_shapes(&mut self, body: &'w Body, creature: bool) -> TransitionState {
        let Some(parts) = &body.part_array else {
            return TransitionState::Ok;
        };
        if body.state.contains(PhysicsState::HAS_PHYSICS_BSP) {
            let placed = parts.existing_parts().map(|part| PlacedPart {
                shape: Some(&part.shape),
                position: &part.position,
                scale: part.scale,
            });
            return find_part_collisions(placed, self);
        }
        let (position, scale) = (&body.position, body.scale);
        let cylinders = parts.cyl_spheres();
        if !cylinders.is_empty() {
            return first_hit(cylinders, |c| c.intersects_sphere_at(position, scale, self));
        }
        first_hit(parts.spheres(), |s| {
            s.intersects_sphere_at(position, scale, self, creature)
        })
    }

    /// Notes that `body` was hit, and answers what the hit counts for: nothing if the mover passes through it.
    fn record_touch(
        &mut self,
        target: ObjectRef,
        body: &Body,
        passable: bool,
        creature: bool,
        result: TransitionState,
    ) -> TransitionState {
        let ignores_creatures = ObjectInfoState::IGNORE_CREATURES;
        if body.state.contains(PhysicsState::STATIC) {
            if !self.object.in_contact() {
                self.info.collided_with_environment = true;
            }
            result
        } else if passable || (creature && self.object.state.contains(ignores_creatures)) {
            // Also forgets the normal of an earlier, real collision in the same step.
            self.info.collision_normal_valid = false;
            self.info.add_object(target, TransitionState::Ok);
            TransitionState::Ok
        } else {
            self.info.add_object(target, result);
            result
        }
    }

    /// Would the mover, where it stands, touch `target`? (10.15). The path must go from its position to its position.
    pub fn check_collisions(&mut self, target: ObjectRef, body: &'w Body) -> bool {
        self.path.insert_type = InsertType::Placement;
        self.check_pos_to_curr_pos();
        self.find_obj_collisions(target, body) != TransitionState::Ok
    }
}

fn first_hit<S>(shapes: &[S], test: impl FnMut(&S) -> TransitionState) -> TransitionState {
    shapes
        .iter()
        .map(test)
        .find(|&ts| ts != TransitionState::Ok)
        .unwrap_or(TransitionState::Ok)
}

impl super::state::CollisionInfo {
    /// Notes an object that was touched, once: a second touch changes nothing (9).
    pub fn add_object(&mut self, object: ObjectRef, state: TransitionState) {
        if self.collide_object.contains(&object) {
            return;
        }
        self.collide_object.push(object);
        if state != TransitionState::Ok {
            self.last_collided_object = Some(object);
        }
    }
}
