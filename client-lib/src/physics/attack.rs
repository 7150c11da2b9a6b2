//! Attack cones: whom an attack of an animation reaches (`spec/06-physics-object.md`, C9). No state of movement is changed.

use crate::dat::AttackCone;
use crate::entity::{AttackReport, CollisionReport, Entity};
use crate::math::{Position, Sphere, Vec3};
use crate::physics::body::{EntityId, ObjectRef};
use crate::physics::state::PhysicsState;
use crate::physics::transition::CellArray;
use crate::world::{SpheresAt, World};

/// Somebody an attack reaches.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct AttackHit {
    /// Who.
    pub object: EntityId,
    /// Where: High 0x1, Medium 0x2, Low 0x4, Left 0x8, Right 0x10, Front 0x20, Back 0x40.
    pub quadrant: u32,
    /// The attacking part.
    pub part: u32,
}

impl Entity {
    /// Carries out the attack of an animation: every hit is told to the own weenie. Whether anybody listens changes nothing else: the cells
    /// around are looked up, and loaded, in either case.
    pub(crate) fn strike(&mut self, cone: &AttackCone, world: &mut World) {
        let mut hits = std::mem::take(&mut world.scratch.hits);
        hits.clear();
        self.attack(cone, world, &mut hits);
        if self.weenie.as_ref().is_some_and(|w| w.collects_reports) {
            let told = hits.iter().filter_map(|hit| {
                Some(CollisionReport::Attack(AttackReport {
                    guid: world.entity(hit.object)?.guid(),
                    quadrant: hit.quadrant,
                    part: hit.part,
                }))
            });
            self.reports.extend(told);
        }
        world.scratch.hits = hits;
    }

    /// Appends everyone whom the cone of an attack reaches to `hits`, each once, in order of cells and their lists.
    pub fn attack(&self, cone: &AttackCone, world: &mut World, hits: &mut Vec<AttackHit>) {
        if self.body.cell.is_none() {
            return;
        }
        let cells = self.attacked_cells(cone, world);
        for entry in cells.entries() {
            let cell = entry.cell.and_then(|cell| world.land.cell(cell));
            let shadows = cell.map_or(&[][..], |cell| &cell.base().shadows);
            for object in shadows {
                let ObjectRef::Entity(id) = *object else {
                    continue;
                };
                let Some(target) = world.entity(id).filter(|_| id != self.id) else {
                    continue;
                };
                if target.body.state.contains(PhysicsState::STATIC)
                    || hits.iter().any(|hit| hit.object == id)
                {
                    continue;
                }
                let place = &self.body.position;
                let reach = self.attack_radius;
                if let Some(quadrant) =
                    target.check_attack(place, self.body.scale, cone, reach, world)
                {
                    hits.push(AttackHit {
                        object: id,
                        quadrant,
                        part: cone.part,
                    });
                }
            }
        }
    }

    /// The cells that the sphere around the attack touches.
    fn attacked_cells(&self, cone: &AttackCone, world: &mut World) -> CellArray {
        let (position, scale) = (self.body.position, self.body.scale);
        let center = Vec3::new(0.0, 0.0, cone.height * scale);
        let sphere = Sphere {
            center: position.frame.local_to_global(center, &world.profile),
            radius: self.attack_radius + cone.radius * scale,
        };
        let mut cells = CellArray::default();
        world.with_loading(|land, profile, missing| {
            let at = SpheresAt {
                position: &position,
                spheres: &[sphere],
                is_path: false,
                want_current: false,
            };
            *missing = land.find_cell_list(at, &mut cells, profile).missing;
        });
        cells
    }

    /// Where an attack hits this object, if it does (`check_attack`). `attacker` is the attacker's place, `scale` its scale, `reach` (m) is
    /// added to the radius of the cone.
    pub fn check_attack(
        &self,
        attacker: &Position,
        scale: f32,
        cone: &AttackCone,
        reach: f32,
        world: &World,
    ) -> Option<u32> {
        let exempt =
            PhysicsState::IGNORE_COLLISIONS | PhysicsState::REPORT_COLLISIONS_AS_ENVIRONMENT;
        if self.body.parent.is_some() || self.body.state.intersects(exempt) {
            return None;
        }
        let own = &self.body.position;
        let (height, range) = (scale * cone.height, scale * cone.radius + reach);
        let (own_radius, own_height) = (self.radius(), self.height());
        let way = attacker.offset_to(own);
        let center = attacker.frame.global_to_local_vec(way, &world.profile);
        let distance = center.x * center.x + center.y * center.y;
        let limit = own_radius + range;
        if height < 0.0 || height > own_height || distance > limit * limit {
            return None;
        }
        if !is_in_cone(center, cone, own_radius) {
            return None;
        }
        let way = own.offset_to(attacker);
        let from = own.frame.global_to_local_vec(way, &world.profile);
        Some(quadrant(from, height, own_height))
    }
}

/// Other rules for the edges than those of a collision (C8).
fn quadrant(from: Vec3, height: f32, own_height: f32) -> u32 {
    let side = if from.x <= 0.0 { 0x8 } else { 0x10 };
    let face = if from.y > 0.0 { 0x20 } else { 0x40 };
    let level = if height < own_height / 3.0 {
        0x4
    } else if height < 2.0 * own_height / 3.0 {
        0x2
    } else {
        0x1
    };
    side | face | level
}

/// Whether a circle around `c` touches the sector between the cone's edges.
fn is_in_cone(c: Vec3, cone: &AttackCone, radius: f32) -> bool {
    let ([lx, ly], [qx, qy]) = (cone.left, cone.right);
    let a = c.y * lx - c.x * ly;
    let b = c.x * qy - c.y * qx;
    if a <= 0.0 && b <= 0.0 {
        return true;
    }
    if lx * qy - ly * qx >= 0.0 {
        return a * b <= 0.0 || a <= radius || b <= radius;
    }
    if a < 0.0 {
        b <= radius
    } else if b >= 0.0 {
        c.x * c.x + c.y * c.y <= radius * radius
    } else {
        a <= radius
    }
}
