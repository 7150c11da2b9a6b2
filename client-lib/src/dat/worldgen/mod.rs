//! Small synthetic worlds for tests: real records in a real container, invented content.
//!
//! A world is put together from polygon soups ([`block`], [`ramp`], [`prism`], [`wall`]), rooms ([`Room`]), kinds of objects
//! ([`SetupBuilder`]), animations and motion tables, and landblocks ([`BlockBuilder`]). The same calls always give the same bytes.
//! Geometry keeps the rules of `spec/11-dat-files.md, 11`: trees are solid-leaf trees, spheres of nodes hold all polygons below them,
//! portals face out of their room.
//!
//! ```
//! use ac_client::dat::worldgen::{Rect, Room, SetupBuilder, Side, WorldBuilder, block, ramp};
//! use ac_client::dat::StoredFrame;
//! use ac_client::math::Vec3;
//!
//! let mut world = WorldBuilder::new();
//! let crate_shape = world.solid(&block(Vec3::new(-1.0, -1.0, 0.0), Vec3::new(1.0, 1.0, 2.0)));
//! let ramp_shape = world.solid(&ramp(6.0, 3.0, 2.0));
//! let crate_setup = world.setup(SetupBuilder::of_shape(crate_shape));
//! let door = Rect { u: [-1.0, 1.0], v: [0.0, 2.5] };
//! let rooms = world.environment(&[
//!     Room::new(Vec3::new(-4.0, -4.0, 0.0), Vec3::new(4.0, 4.0, 3.0)).doorway(Side::North, door),
//!     Room::new(Vec3::new(-4.0, -4.0, 0.0), Vec3::new(4.0, 4.0, 3.0)).doorway(Side::South, door),
//! ]);
//! let home = world.block(0x10, 0x20);
//! home.heights(|x, _| x as u8);
//! home.object(crate_setup, Vec3::new(30.0, 30.0, 2.5), 45.0);
//! home.object(ramp_shape, Vec3::new(60.0, 30.0, 5.0), 0.0);
//! let a = home.room(rooms, 0, StoredFrame::at(Vec3::new(96.0, 96.0, -50.0)), 1);
//! let b = home.room(rooms, 1, StoredFrame::at(Vec3::new(96.0, 104.0, -50.0)), 1);
//! home.connect((a, 0), (b, 0));
//! let dats = world.surround().build()?;
//! assert_eq!(dats.env_cell(0x1020_0101)?.expect("just built").portals[0].other_room, 0x0100);
//! # Ok::<(), ac_client::dat::DatError>(())
//! ```

mod mesh;
mod region;
mod shape;
mod tree;
mod world;

pub use mesh::{Axis, Face, Rect, block, prism, ramp, rectangle, wall};
pub use shape::{Room, SURFACE, Side, shape, structure};
pub use tree::{cell_tree, drawing_tree, physics_tree};
pub use world::{BlockBuilder, RoomId, SetupBuilder, WorldBuilder, yaw};
