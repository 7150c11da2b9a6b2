//! Owners of collision geometry: graphics objects, cells, and objects made of parts (`spec/04-collision-primitives.md`, section 12).

use super::cell_tree::{BoundingType, CellTree};
use super::physics_tree::PhysicsTree;
use super::polygon::Polygon;
use super::polygon_list::PolygonList;
use crate::math::{BoundingBox, EPSILON, Position, Sphere, Vec3};
use crate::physics::transition::{InsertType, Transition, TransitionState};

/// Distance, m, from which on a sphere is surely not near a bounding sphere: the exact test compares squares with a tolerance.
const SHAPE_MARGIN: f32 = 0.2;

/// Collision and bounds of one graphics object, in its own space. Shared by all parts that show it.
#[derive(Debug, Clone, Default)]
pub struct GfxShape {
    /// Own id, 0x01......; 0 for a shape that no file holds.
    pub id: u32,
    /// Always drawn facing the viewer: for its cells a part of this shape is as large as its sphere (`spec/03`, 10.4).
    pub always_2d: bool,
    /// Tree of the collision polygons; absent for an object that nothing collides with.
    pub physics: Option<PhysicsTree>,
    /// Bounding sphere of the drawing tree; absent without one.
    pub drawing_sphere: Option<Sphere>,
    /// Box of all vertices, of drawing and physics alike.
    pub bounds: BoundingBox,
}

/// One part of an object, placed in the world.
#[derive(Debug, Clone, Copy)]
pub struct PlacedPart<'w> {
    /// What the part shows; absent for a part without a record.
    pub shape: Option<&'w GfxShape>,
    /// Animated place of the part.
    pub position: &'w Position,
    /// Scale of the part; collision uses only its z.
    pub scale: Vec3,
}

/// Collision geometry and volume of one kind of indoor cell, in cell space. Shared by all cells of the kind.
#[derive(Debug, Clone, Default)]
pub struct CellShape {
    /// Drawing polygons by key; some of them are portals.
    pub polygons: PolygonList,
    /// Keys of the portal polygons, in order.
    pub portals: Vec<u16>,
    /// Volume of the cell.
    pub volume: CellTree,
    /// Tree of the collision polygons.
    pub physics: PhysicsTree,
}

/// Box of all points; zero without any (6.6).
fn box_of(points: impl IntoIterator<Item = Vec3>) -> BoundingBox {
    let mut points = points.into_iter();
    let first = points.next().unwrap_or(Vec3::ZERO);
    let mut bounds = BoundingBox {
        min: first,
        max: first,
    };
    points.for_each(|p| bounds.adjust(p));
    bounds
}

impl GfxShape {
    /// A shape of a collision tree and the vertices of everything that the object shows.
    pub fn new(
        physics: Option<PhysicsTree>,
        drawing_sphere: Option<Sphere>,
        vertices: impl IntoIterator<Item = Vec3>,
    ) -> Self {
        Self {
            id: 0,
            always_2d: false,
            physics,
            drawing_sphere,
            bounds: box_of(vertices),
        }
    }

    /// Bounding sphere of the collision tree; absent without one.
    pub fn physics_sphere(&self) -> Option<Sphere> {
        self.physics.as_ref()?.sphere()
    }

    /// Whether there is a tree of collision polygons.
    pub const fn has_physics_bsp(&self) -> bool {
        self.physics.is_some()
    }

    /// Sphere of the collision tree, else of the drawing tree, else a zero sphere.
    pub fn bounding_sphere(&self) -> Sphere {
        self.physics_sphere()
            .or(self.drawing_sphere)
            .unwrap_or(Sphere {
                center: Vec3::ZERO,
                radius: 0.0,
            })
    }

    /// Tests the shape against the mover, whose spheres are in the shape's space already (12.1).
    pub fn find_obj_collisions<'w>(
        &'w self,
        t: &mut Transition<'w>,
        scale: f32,
    ) -> TransitionState {
        let Some(tree) = &self.physics else {
            return TransitionState::Ok;
        };
        let Some(bound) = tree.sphere() else {
            return TransitionState::Ok;
        };
        let near = t.path.localspace_sphere[..t.path.num_sphere.min(2)]
            .iter()
            .any(|sphere| {
                let distance_squared = (bound.center - sphere.center).length_squared();
                let sum = bound.radius + sphere.radius;
                distance_squared - sum * sum < EPSILON
            });
        if !near {
            return TransitionState::Ok;
        }
        if t.path.insert_type == InsertType::InitialPlacement {
            tree.placement_insert(t)
        } else {
            tree.find_collisions(t, scale)
        }
    }
}

impl<'w> PlacedPart<'w> {
    /// Tests the part against the mover (12.2): Ok for a part without a shape or without collision polygons.
    pub fn find_obj_collisions(&self, t: &mut Transition<'w>) -> TransitionState {
        let Some(shape) = self.shape else {
            return TransitionState::Ok;
        };
        let Some(bound) = shape.physics_sphere() else {
            return TransitionState::Ok;
        };
        let scale = self.scale.z.abs();
        let reach = (bound.center.length() + bound.radius.abs() + SHAPE_MARGIN) * scale;
        if t.is_apart(self.position, reach) {
            return TransitionState::Ok;
        }
        t.cache_localspace_sphere(self.position, self.scale.z);
        shape.find_obj_collisions(t, self.scale.z)
    }
}

/// Tests the parts of an object in order (12.3): the first outcome that is not Ok.
pub fn find_part_collisions<'w>(
    parts: impl IntoIterator<Item = PlacedPart<'w>>,
    t: &mut Transition<'w>,
) -> TransitionState {
    for part in parts {
        let state = part.find_obj_collisions(t);
        if state != TransitionState::Ok {
            return state;
        }
    }
    TransitionState::Ok
}

impl CellShape {
    /// Whether a point of cell space is in the cell.
    pub fn contains(&self, point: Vec3) -> bool {
        self.volume.contains(point)
    }

    /// How much of a sphere in cell space is in the cell.
    pub fn intersects_sphere(&self, sphere: &Sphere) -> BoundingType {
        self.volume.intersects_sphere(sphere)
    }

    /// Whether a box in cell space may reach into the cell.
    pub fn intersects_box(&self, bounds: &BoundingBox) -> bool {
        self.volume.intersects_box(bounds)
    }

    /// The portal polygon with that key (12.4); `None` if no portal has it.
    pub fn portal(&self, key: u16) -> Option<Polygon<'_>> {
        self.portals
            .contains(&key)
            .then(|| self.polygons.get(usize::from(key)))?
    }
}
