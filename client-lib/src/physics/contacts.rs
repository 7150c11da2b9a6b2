//! What a finished transition did to an object: collision records, reports to the weenie, bounce, and the count of steps without progress
//! (`spec/06-physics-object.md`, C7 and C8).

use crate::entity::{
    AttackReport, CollisionProfile, CollisionRecord, CollisionReport, Entity, EnvironmentReport,
    ObjectReport,
};
use crate::math::Vec3;
use crate::physics::body::ObjectRef;
use crate::physics::state::{PhysicsState, TransientState};
use crate::physics::transition::CollisionInfo;
use crate::profile::{CollisionClock, EnvironmentResult, Reports, Width};
use crate::world::World;

/// Age from which on a contact is over, s.
const COLLISION_EXPIRY: f64 = 1.0;
/// Bits that a missile loses when it hits something.
const MISSILE_BITS: PhysicsState = PhysicsState::MISSILE
    .union(PhysicsState::ALIGN_PATH)
    .union(PhysicsState::PATH_CLIPPED);
/// The three bits that count steps without progress.
const STATIONARY_BITS: TransientState = TransientState::STATIONARY_FALL
    .union(TransientState::STATIONARY_STOP)
    .union(TransientState::STATIONARY_STUCK);

/// Bits of a [`CollisionProfile`] that say how the two met.
mod profile_bits {
    pub const MISSILE: u32 = 0x08;
    pub const CONTACT: u32 = 0x10;
    pub const MY_CONTACT: u32 = 0x20;
}

/// What a report needs of the other party, by value.
#[derive(Debug, Clone, Copy)]
struct Other {
    object: ObjectRef,
    guid: u32,
    state: PhysicsState,
    velocity: Vec3,
    contact: bool,
    has_weenie: bool,
    profile: Option<CollisionProfile>,
}

impl Other {
    fn of(entity: &Entity) -> Self {
        Self {
            object: entity.object_ref(),
            guid: entity.guid(),
            state: entity.body.state,
            velocity: entity.kin.velocity,
            contact: entity.kin.transient.contains(TransientState::CONTACT),
            has_weenie: entity.weenie.is_some(),
            profile: entity.weenie.as_ref().and_then(|w| w.profile),
        }
    }
}

impl World {
    /// Clock of collision ages and of the target manager's interval (O-20), s.
    pub(super) fn collision_clock(&self) -> f64 {
        match self.profile.collision_clock {
            CollisionClock::SimTime => self.clock.sim_time,
            CollisionClock::Now => self.clock.now,
        }
    }
}

impl Entity {
    /// Works through what a transition or placement met: records and reports contacts, bounces, and counts steps without progress (C7).
    ///
    /// `was_contact` and `was_walkable` are the bits before the commit. Answers whether something was reported (O-17).
    pub fn handle_all_collisions(
        &mut self,
        info: &CollisionInfo,
        was_contact: bool,
        was_walkable: bool,
        world: &mut World,
    ) -> bool {
        let on_walkable = self.kin.transient.contains(TransientState::ON_WALKABLE);
        let sleds = self.body.state.contains(PhysicsState::SLEDDING);
        let bounces = !(was_walkable && on_walkable && !sleds);
        let mut result = false;
        for &object in &info.collide_object {
            result |= self.track_object_collision(object, was_contact, world);
        }
        self.touched_environment |= info.collided_with_environment;
        self.report_collision_end(false, world);
        let landed = !was_walkable && on_walkable;
        if self.kin.colliding_with_environment {
            self.kin.colliding_with_environment = info.collided_with_environment;
        } else if info.collided_with_environment || landed {
            let reported = self.report_environment_collision(was_contact, world);
            result |= reported || world.profile.environment_result == EnvironmentResult::OnEntry;
        }
        let stationary = info.frames_stationary_fall;
        if stationary > 1 {
            self.kin.velocity = Vec3::ZERO;
            if stationary == 3 {
                self.kin.transient.remove(STATIONARY_BITS);
                return result;
            }
        } else if bounces && info.collision_normal_valid {
            self.bounce(info.collision_normal, was_contact, world);
        }
        match stationary {
            0 => self.kin.transient.remove(STATIONARY_BITS),
            1 => self.kin.transient.insert(TransientState::STATIONARY_FALL),
            2 => self.kin.transient.insert(TransientState::STATIONARY_STOP),
            _ => self.kin.transient.insert(TransientState::STATIONARY_STUCK),
        }
        result
    }

    /// Turns the velocity's component into a surface back, times the elasticity.
    fn bounce(&mut self, normal: Vec3, was_contact: bool, world: &mut World) {
        if self.body.state.contains(PhysicsState::INELASTIC) {
            self.kin.velocity = Vec3::ZERO;
            if world.profile.environment_result == EnvironmentResult::IfReportedTwice {
                self.report_environment_collision(was_contact, world);
            }
            return;
        }
        let p = self.kin.velocity.dot(normal);
        if p < 0.0 {
            let k = match world.profile.bounce_factor {
                Width::F32 => -(p * (self.kin.elasticity + 1.0)),
                Width::F64 => -(f64::from(p) * (f64::from(self.kin.elasticity) + 1.0)) as f32,
            };
            self.kin.velocity += normal * k;
        }
    }

    /// Remembers a touch; the first of a contact is reported (`track_object_collision`).
    fn track_object_collision(
        &mut self,
        object: ObjectRef,
        was_contact: bool,
        world: &mut World,
    ) -> bool {
        let other = match object {
            ObjectRef::Entity(id) => world.entity(id).map(Other::of),
            ObjectRef::Static(_) => None,
        };
        let Some(other) = other else {
            // A static object is environment; it never gets into the list of touched objects.
            return matches!(object, ObjectRef::Static(_))
                && self.report_environment_collision(was_contact, world);
        };
        self.touched.push(other.guid);
        if other.state.contains(PhysicsState::STATIC) {
            return self.report_environment_collision(was_contact, world);
        }
        let record = CollisionRecord {
            guid: other.guid,
            touched: world.collision_clock(),
            ethereal: other.state.contains(PhysicsState::ETHEREAL),
        };
        let known = self
            .collision_table
            .iter_mut()
            .find(|r| r.guid == other.guid);
        let continues = known.is_some();
        match known {
            Some(known) => *known = record,
            None => self.collision_table.push(record),
        }
        if continues && world.profile.reports == Reports::OncePerContact {
            return false;
        }
        self.report_object_collision(other, was_contact, world)
    }

    /// Tells both weenies of a touch (`report_object_collision`).
    fn report_object_collision(
        &mut self,
        other: Other,
        was_contact: bool,
        world: &mut World,
    ) -> bool {
        if other
            .state
            .contains(PhysicsState::REPORT_COLLISIONS_AS_ENVIRONMENT)
        {
            return self.report_environment_collision(was_contact, world);
        }
        let relative = self.kin.velocity - other.velocity;
        let mut result = false;
        if !other.state.contains(PhysicsState::IGNORE_COLLISIONS) {
            if self.reports_collisions() {
                self.report_to_self(&other, relative, was_contact, world);
                result = true;
            }
            if self.body.state.contains(PhysicsState::MISSILE) {
                self.body.state.remove(MISSILE_BITS);
            }
        }
        let tells_other = other.state.contains(PhysicsState::REPORT_COLLISIONS)
            && !self.body.state.contains(PhysicsState::IGNORE_COLLISIONS)
            && other.has_weenie;
        if tells_other {
            self.report_to_other(&other, relative, was_contact, world);
            result = true;
        }
        result
    }

    fn reports_collisions(&self) -> bool {
        self.body.state.contains(PhysicsState::REPORT_COLLISIONS) && self.weenie.is_some()
    }

    fn report_to_self(&mut self, other: &Other, relative: Vec3, was_contact: bool, world: &World) {
        if !self.weenie.as_ref().is_some_and(|w| w.collects_reports) {
            return;
        }
        let ObjectRef::Entity(id) = other.object else {
            return;
        };
        let report = if self.body.state.contains(PhysicsState::MISSILE) {
            let quadrant = world.entity(id).map_or(0, |o| {
                o.body
                    .position
                    .quadrant_of(o.height(), &self.body.position, &world.profile)
            });
            CollisionReport::Attack(AttackReport {
                guid: other.guid,
                quadrant,
                part: AttackReport::WHOLE,
            })
        } else {
            let asked = match world.profile.reports {
                Reports::OncePerContact => other.profile,
                Reports::EachTouch => self.weenie.as_ref().and_then(|w| w.profile),
            };
            CollisionReport::Object(ObjectReport {
                guid: other.guid,
                velocity: relative,
                profile: asked.map(|mut profile| {
                    profile.flags |= meeting_bits(
                        other.state.contains(PhysicsState::MISSILE),
                        other.contact,
                        was_contact,
                    );
                    profile
                }),
            })
        };
        self.reports.push(report);
    }

    fn report_to_other(
        &mut self,
        other: &Other,
        relative: Vec3,
        was_contact: bool,
        world: &mut World,
    ) {
        let rules = world.profile.reports;
        let ObjectRef::Entity(id) = other.object else {
            return;
        };
        let (own_height, own_missile) = (
            self.height(),
            self.body.state.contains(PhysicsState::MISSILE),
        );
        let own_profile = self.weenie.as_ref().and_then(|w| w.profile);
        let quadrant = world.entity(id).map_or(0, |o| {
            self.body
                .position
                .quadrant_of(own_height, &o.body.position, &world.profile)
        });
        let Some(receiver) = world.entity_mut(id) else {
            return;
        };
        if !receiver.weenie.as_ref().is_some_and(|w| w.collects_reports) {
            return;
        }
        let report = if other.state.contains(PhysicsState::MISSILE) {
            CollisionReport::Attack(AttackReport {
                guid: self.body.guid,
                quadrant,
                part: AttackReport::WHOLE,
            })
        } else {
            // The client exchanges the two bits of this profile (O-21).
            let (asked, missile, contact) = match rules {
                Reports::OncePerContact => (own_profile, was_contact, own_missile),
                Reports::EachTouch => (other.profile, own_missile, was_contact),
            };
            CollisionReport::Object(ObjectReport {
                guid: self.body.guid,
                velocity: relative,
                profile: asked.map(|mut profile| {
                    profile.flags |= meeting_bits(missile, contact, other.contact);
                    profile
                }),
            })
        };
        receiver.reports.push(report);
    }

    /// Tells the weenie that the environment was touched, once per contact (`report_environment_collision`).
    fn report_environment_collision(&mut self, was_contact: bool, world: &World) -> bool {
        if self.kin.colliding_with_environment {
            return false;
        }
        // Profile `ace` counts the report as made also without a weenie.
        let result = self.reports_collisions()
            || (self.body.state.contains(PhysicsState::REPORT_COLLISIONS)
                && world.profile.reports == Reports::EachTouch);
        if result && self.weenie.as_ref().is_some_and(|w| w.collects_reports) {
            self.reports
                .push(CollisionReport::Environment(EnvironmentReport {
                    velocity: self.kin.velocity,
                    my_contact: was_contact,
                }));
        }
        self.kin.colliding_with_environment = true;
        if self.body.state.contains(PhysicsState::MISSILE) {
            self.body.state.remove(match world.profile.reports {
                Reports::OncePerContact => MISSILE_BITS,
                Reports::EachTouch => PhysicsState::MISSILE,
            });
        }
        result
    }

    /// Forgets contacts that are over, all of them when `force`, and tells the weenies (`report_collision_end`).
    pub fn report_collision_end(&mut self, force: bool, world: &mut World) {
        if self.collision_table.is_empty() {
            return;
        }
        let now = world.collision_clock();
        let mut expired = std::mem::take(&mut world.scratch.guids);
        expired.clear();
        self.collision_table.retain(|record| {
            let age = now - record.touched;
            let over = age > COLLISION_EXPIRY || (record.ethereal && age > 0.0) || force;
            if over {
                expired.push(record.guid);
            }
            !over
        });
        for &guid in &expired {
            self.report_object_collision_end(guid, world);
        }
        world.scratch.guids = expired;
    }

    fn report_object_collision_end(&mut self, guid: u32, world: &mut World) {
        let own_reports = self.reports_collisions();
        let own_guid = self.body.guid;
        let other = world
            .entity_of_guid(guid)
            .and_then(|id| world.entity_mut(id));
        let tells_self = match other {
            Some(other) => {
                let environment = other
                    .body
                    .state
                    .contains(PhysicsState::REPORT_COLLISIONS_AS_ENVIRONMENT);
                if !environment && other.reports_collisions() {
                    other.tell_end(own_guid);
                }
                !environment
            }
            None => world.profile.reports == Reports::OncePerContact,
        };
        if tells_self && own_reports {
            self.tell_end(guid);
        }
    }

    fn tell_end(&mut self, guid: u32) {
        if self.weenie.as_ref().is_some_and(|w| w.collects_reports) {
            self.reports.push(CollisionReport::End(guid));
        }
    }

    /// Reports every remembered contact again: a hidden object appears (`report_collision_start`).
    pub(crate) fn report_collision_start(&mut self, world: &mut World) {
        let contact = self.kin.transient.contains(TransientState::CONTACT);
        for index in 0..self.collision_table.len() {
            let guid = self.collision_table[index].guid;
            let other = world.entity_of_guid(guid).and_then(|id| world.entity(id));
            if let Some(other) = other.map(Other::of) {
                self.report_object_collision(other, contact, world);
            }
        }
    }
}

const fn meeting_bits(missile: bool, contact: bool, my_contact: bool) -> u32 {
    (if missile { profile_bits::MISSILE } else { 0 })
        | (if contact { profile_bits::CONTACT } else { 0 })
        | (if my_contact {
            profile_bits::MY_CONTACT
        } else {
            0
        })
}
