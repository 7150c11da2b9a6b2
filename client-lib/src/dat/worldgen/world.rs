//! Whole worlds: region, landscape, rooms and objects.

use std::collections::BTreeMap;
use std::path::Path;

use super::region::flat_region;
use super::shape::{Room, SURFACE, shape};
use crate::dat::worldgen::mesh::Face;
use crate::dat::{
    AnimFrame, Animation, Building, BuildingPortal, CELL_FILE, CellPortal, CylSphere, DatBuilder,
    DatError, DatFile, DatSet, DataSet, EnvCell, EnvCellFlags, Environment, GfxObj, KeyedList,
    Landblock, LandblockInfo, LandblockInfoMask, MotionTable, PORTAL_FILE, PortalFlags, Problem,
    Record, Region, Setup, SetupFlags, Stab, StoredFrame, Strictness, Surface, SurfaceFill,
    SurfaceFlags, TerrainWord, VERTICES,
};
use crate::math::{Quat, Sphere, Vec3, trig};

/// A rotation about +z, counter-clockwise seen from above, degrees.
#[must_use]
pub fn yaw(degrees: f32) -> Quat {
    let half = degrees.to_radians() / 2.0;
    Quat {
        w: trig::cos(half),
        x: 0.0,
        y: 0.0,
        z: trig::sin(half),
    }
}

/// Builds a world record by record; ids of shapes, setups, animations, motion tables and environments are given out in order from 1.
#[derive(Debug, Clone)]
pub struct WorldBuilder {
    /// The region; change it before [`WorldBuilder::build`].
    pub region: Region,
    portal: DatBuilder,
    next: BTreeMap<u32, u32>,
    blocks: BTreeMap<u16, BlockBuilder>,
    error: Option<DatError>,
}

impl Default for WorldBuilder {
    fn default() -> Self {
        Self::new()
    }
}

impl WorldBuilder {
    /// An empty world: a region whose height index is worth 2 metres, and one surface.
    #[must_use]
    pub fn new() -> Self {
        let mut world = Self {
            region: flat_region(),
            portal: DatBuilder::new(DataSet::Portal),
            next: BTreeMap::new(),
            blocks: BTreeMap::new(),
            error: None,
        };
        let grey = SurfaceFill::Color(0xFF80_8080);
        world.add(&Surface {
            id: SURFACE,
            flags: SurfaceFlags::SOLID,
            fill: grey,
            translucency: 0.0,
            luminosity: 0.0,
            diffuse: 1.0,
        });
        world
    }

    fn give_id(&mut self, base: u32) -> u32 {
        let n = self.next.entry(base).or_insert(0);
        *n += 1;
        base + *n
    }

    /// Adds any record to the portal file. A record that cannot be written is reported by [`WorldBuilder::build`].
    pub fn add<T: Record>(&mut self, record: &T) -> &mut Self {
        if let Err(e) = self.portal.add(record) {
            self.error.get_or_insert(e);
        }
        self
    }

    /// Adds a solid shape that is drawn as it collides; answers its id.
    pub fn solid(&mut self, faces: &[Face]) -> u32 {
        self.shape(faces, faces)
    }

    /// Adds a shape with different faces to collide with and to draw; answers its id.
    pub fn shape(&mut self, physics: &[Face], drawing: &[Face]) -> u32 {
        let id = self.give_id(0x0100_0000);
        let record: GfxObj = shape(id, physics, drawing);
        self.add(&record);
        id
    }

    /// Adds a setup; its id is given out. Answers it.
    pub fn setup(&mut self, setup: SetupBuilder) -> u32 {
        let id = self.give_id(0x0200_0000);
        self.add(&setup.build(id));
        id
    }

    /// Adds an animation of `parts` parts from its frames: part frames with hooks, and root motion for all or none. Answers its id.
    pub fn animation(
        &mut self,
        parts: u32,
        frames: impl IntoIterator<Item = (AnimFrame, Option<StoredFrame>)>,
    ) -> u32 {
        let id = self.give_id(0x0300_0000);
        let mut animation = Animation::new(id, parts);
        for (frame, root) in frames {
            animation.push(frame, root);
        }
        self.add(&animation);
        id
    }

    /// Adds a motion table; its id is given out. Answers it.
    pub fn motion_table(&mut self, mut table: MotionTable) -> u32 {
        table.id = self.give_id(0x0900_0000);
        self.add(&table);
        table.id
    }

    /// Adds an environment with these rooms as structures 0, 1, ...; answers its id.
    pub fn environment(&mut self, rooms: &[Room]) -> u32 {
        let id = self.give_id(0x0D00_0000);
        self.add(&Environment {
            id,
            structures: rooms.iter().map(Room::structure).collect(),
        });
        id
    }

    /// The landblock (x, y); flat at height index 0 if it is new.
    pub fn block(&mut self, x: u8, y: u8) -> &mut BlockBuilder {
        let key = u16::from(x) << 8 | u16::from(y);
        self.blocks
            .entry(key)
            .or_insert_with(|| BlockBuilder::new(u32::from(key) << 16))
    }

    /// Adds missing blocks around all blocks: flat ones at height index 0. Both references need them around whatever is walked.
    pub fn surround(&mut self) -> &mut Self {
        for key in self.blocks.keys().copied().collect::<Vec<_>>() {
            let (x, y) = ((key >> 8) as i32, (key & 0xFF) as i32);
            for (dx, dy) in (-1..=1).flat_map(|dx| (-1..=1).map(move |dy| (dx, dy))) {
                if let (Ok(x @ 0..=0xFE), Ok(y @ 0..=0xFE)) =
                    (u8::try_from(x + dx), u8::try_from(y + dy))
                {
                    self.block(x, y);
                }
            }
        }
        self
    }

    /// Bytes of the portal file and of the cell file.
    ///
    /// # Errors
    /// The first record that cannot be written.
    pub fn write(&self) -> Result<[Vec<u8>; 2], DatError> {
        if let Some(e) = &self.error {
            return Err(e.clone());
        }
        let mut portal = self.portal.clone();
        portal.add(&self.region)?;
        let mut cell = DatBuilder::new(DataSet::Cell);
        for block in self.blocks.values() {
            block.write(&mut cell)?;
        }
        Ok([portal.write()?, cell.write()?])
    }

    /// The world, opened from memory and read strictly.
    ///
    /// # Errors
    /// As [`WorldBuilder::write`].
    pub fn build(&self) -> Result<DatSet, DatError> {
        let [portal, cell] = self.write()?;
        DatSet::from_files(
            DatFile::from_bytes(
                PORTAL_FILE,
                portal,
                Some(DataSet::Portal),
                Strictness::Strict,
            )?,
            DatFile::from_bytes(CELL_FILE, cell, Some(DataSet::Cell), Strictness::Strict)?,
        )
    }

    /// Writes both files into a folder that exists.
    ///
    /// # Errors
    /// As [`WorldBuilder::write`], and [`Problem::Io`].
    pub fn save(&self, folder: &Path) -> Result<(), DatError> {
        for (name, bytes) in [PORTAL_FILE, CELL_FILE].into_iter().zip(self.write()?) {
            let path = folder.join(name);
            std::fs::write(&path, bytes).map_err(|e| {
                let problem = Problem::Io {
                    operation: "write the file",
                    message: e.to_string(),
                };
                DatError::in_file(&path.display().to_string(), 0, problem)
            })?;
        }
        Ok(())
    }
}

/// A room of a block, by the number in which it was added.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct RoomId(u16);

impl RoomId {
    /// Low 16 bits of the room's cell id.
    #[must_use]
    pub fn low(self) -> u16 {
        0x0100 + self.0
    }
}

/// One landblock: terrain, static objects, buildings, rooms.
#[derive(Debug, Clone)]
pub struct BlockBuilder {
    id: u32,
    terrain: [TerrainWord; VERTICES * VERTICES],
    heights: [u8; VERTICES * VERTICES],
    statics: Vec<Stab>,
    buildings: Vec<Building>,
    restrictions: Vec<(u32, u32)>,
    rooms: Vec<EnvCell>,
}

impl BlockBuilder {
    fn new(id: u32) -> Self {
        Self {
            id,
            terrain: [TerrainWord::default(); VERTICES * VERTICES],
            heights: [0; VERTICES * VERTICES],
            statics: Vec::new(),
            buildings: Vec::new(),
            restrictions: Vec::new(),
            rooms: Vec::new(),
        }
    }

    /// Sets the height index of every vertex (x east, y north, 0..=8).
    pub fn heights(&mut self, f: impl Fn(usize, usize) -> u8) -> &mut Self {
        self.heights = std::array::from_fn(|i| f(i / VERTICES, i % VERTICES));
        self
    }

    /// Sets the terrain word of every vertex (x east, y north, 0..=8).
    pub fn terrain(&mut self, f: impl Fn(usize, usize) -> TerrainWord) -> &mut Self {
        self.terrain = std::array::from_fn(|i| f(i / VERTICES, i % VERTICES));
        self
    }

    /// Adds a static object; landblock coordinates.
    pub fn object(&mut self, model: u32, origin: Vec3, degrees: f32) -> &mut Self {
        self.statics.push(Stab {
            model,
            frame: StoredFrame {
                origin,
                rotation: yaw(degrees),
            },
        });
        self
    }

    /// Adds a building: its shell, and its openings as (room, number of that room's portal, rooms seen through it).
    pub fn building(
        &mut self,
        model: u32,
        frame: StoredFrame,
        openings: &[(RoomId, u16, &[RoomId])],
    ) -> &mut Self {
        let portals = openings
            .iter()
            .map(|(room, portal, visible)| BuildingPortal {
                flags: PortalFlags::EXACT_MATCH,
                room: room.low(),
                room_portal: *portal,
                visible_rooms: visible.iter().map(|r| r.low()).collect(),
            });
        self.buildings.push(Building {
            model,
            frame,
            leaf_count: 0,
            portals: portals.collect(),
        });
        self
    }

    /// Adds a room with `doors` doorways, none of which leads anywhere yet; landblock coordinates.
    pub fn room(
        &mut self,
        environment: u32,
        structure: u16,
        frame: StoredFrame,
        doors: usize,
    ) -> RoomId {
        let number = self.rooms.len() as u16;
        let closed = |i| CellPortal {
            // Generated portals face out of the room: the inverted mark is clear.
            flags: PortalFlags::EXACT_MATCH | PortalFlags::OUTSIDE,
            polygon: i as u16,
            other_room: 0xFFFF,
            other_portal: 0xFFFF,
        };
        self.rooms.push(EnvCell {
            id: self.id | (0x0100 + u32::from(number)),
            flags: EnvCellFlags::empty(),
            surfaces: vec![SURFACE as u16],
            environment: environment as u16,
            structure,
            frame,
            portals: (0..doors).map(closed).collect(),
            visible_rooms: Vec::new(),
            statics: Vec::new(),
            restriction: 0,
        });
        RoomId(number)
    }

    /// Joins two doorways. Both rooms see each other from then on.
    pub fn connect(&mut self, a: (RoomId, u16), b: (RoomId, u16)) -> &mut Self {
        for ((room, portal), (other, other_portal)) in [(a, b), (b, a)] {
            let Some(cell) = self.rooms.get_mut(usize::from(room.0)) else {
                continue;
            };
            if let Some(p) = cell.portals.get_mut(usize::from(portal)) {
                *p = CellPortal {
                    flags: PortalFlags::EXACT_MATCH,
                    other_room: other.low(),
                    other_portal,
                    ..*p
                };
            }
            if !cell.visible_rooms.contains(&other.low()) {
                cell.visible_rooms.push(other.low());
            }
        }
        self
    }

    /// The room, to change what the builder has no word for.
    pub fn room_mut(&mut self, room: RoomId) -> Option<&mut EnvCell> {
        self.rooms.get_mut(usize::from(room.0))
    }

    /// Adds a static object to a room; landblock coordinates.
    pub fn room_object(
        &mut self,
        room: RoomId,
        model: u32,
        origin: Vec3,
        degrees: f32,
    ) -> &mut Self {
        if let Some(cell) = self.room_mut(room) {
            cell.flags |= EnvCellFlags::STATICS;
            cell.statics.push(Stab {
                model,
                frame: StoredFrame {
                    origin,
                    rotation: yaw(degrees),
                },
            });
        }
        self
    }

    /// Restricts a room to what `object` allows.
    pub fn restrict(&mut self, room: RoomId, object: u32) -> &mut Self {
        let id = self.id | u32::from(room.low());
        self.restrictions.push((id, object));
        if let Some(cell) = self.room_mut(room) {
            cell.flags |= EnvCellFlags::RESTRICTION;
            cell.restriction = object;
        }
        self
    }

    fn write(&self, cell: &mut DatBuilder) -> Result<(), DatError> {
        let info = !(self.statics.is_empty() && self.buildings.is_empty() && self.rooms.is_empty());
        cell.add(&Landblock {
            id: self.id | 0xFFFF,
            has_info: u32::from(info),
            terrain: self.terrain,
            heights: self.heights,
        })?;
        if info {
            let mask = if self.restrictions.is_empty() {
                LandblockInfoMask::empty()
            } else {
                LandblockInfoMask::RESTRICTIONS
            };
            cell.add(&LandblockInfo {
                id: self.id | 0xFFFE,
                room_count: self.rooms.len() as u32,
                statics: self.statics.clone(),
                buildings: self.buildings.clone(),
                mask,
                restrictions: KeyedList::new(self.restrictions.clone()),
                restriction_buckets: 8,
            })?;
        }
        for room in &self.rooms {
            let mut room = room.clone();
            if room.portals.iter().any(CellPortal::is_outside) {
                room.flags |= EnvCellFlags::SEEN_OUTSIDE;
            }
            cell.add(&room)?;
        }
        Ok(())
    }
}

/// A kind of object.
#[derive(Debug, Clone)]
pub struct SetupBuilder(Setup);

impl Default for SetupBuilder {
    fn default() -> Self {
        Self::new()
    }
}

impl SetupBuilder {
    /// No parts, no collision shapes, free heading.
    #[must_use]
    pub fn new() -> Self {
        Self(Setup::empty(0))
    }

    /// An object of one shape with a physics tree.
    #[must_use]
    pub fn of_shape(shape: u32) -> Self {
        let mut builder = Self::new().part(shape, StoredFrame::IDENTITY);
        builder.0.flags |= SetupFlags::PHYSICS_BSP;
        builder
    }

    /// A creature: two spheres, one above the other, as a player has them.
    #[must_use]
    pub fn humanoid(shape: u32, height: f32, radius: f32) -> Self {
        Self::new()
            .part(shape, StoredFrame::IDENTITY)
            .sphere(Vec3::new(0.0, 0.0, radius), radius)
            .sphere(Vec3::new(0.0, 0.0, height - radius), radius)
            .size(height, radius)
            .steps(0.6, 1.5)
    }

    /// Adds a part with its place in the default placement (key 0).
    #[must_use]
    pub fn part(mut self, shape: u32, frame: StoredFrame) -> Self {
        self.0.parts.push(shape);
        match self.0.placements.get_mut(0) {
            Some(placement) => placement.parts.push(frame),
            None => self.0.placements.push(
                0,
                AnimFrame {
                    parts: vec![frame],
                    hooks: Vec::new(),
                },
            ),
        }
        self
    }

    /// Adds another placement; one frame per part.
    #[must_use]
    pub fn placement(mut self, key: i32, parts: Vec<StoredFrame>) -> Self {
        self.0.placements.push(
            key,
            AnimFrame {
                parts,
                hooks: Vec::new(),
            },
        );
        self
    }

    /// Adds a collision sphere.
    #[must_use]
    pub fn sphere(mut self, center: Vec3, radius: f32) -> Self {
        self.0.spheres.push(Sphere { center, radius });
        self
    }

    /// Adds a collision cylinder.
    #[must_use]
    pub fn cyl_sphere(mut self, low: Vec3, radius: f32, height: f32) -> Self {
        self.0.cyl_spheres.push(CylSphere {
            low,
            radius,
            height,
        });
        self
    }

    /// Sets height and radius, and the sorting and selection spheres around them.
    #[must_use]
    pub fn size(mut self, height: f32, radius: f32) -> Self {
        (self.0.height, self.0.radius) = (height, radius);
        let sphere = Sphere {
            center: Vec3::new(0.0, 0.0, height / 2.0),
            radius: radius.max(height / 2.0),
        };
        (self.0.sorting_sphere, self.0.selection_sphere) = (sphere, sphere);
        self
    }

    /// Sets step-up and step-down height.
    #[must_use]
    pub fn steps(mut self, up: f32, down: f32) -> Self {
        (self.0.step_up_height, self.0.step_down_height) = (up, down);
        self
    }

    /// Sets the default motion table.
    #[must_use]
    pub fn motion_table(mut self, id: u32) -> Self {
        self.0.default_motion_table = id;
        self
    }

    /// Sets the default animation.
    #[must_use]
    pub fn animation(mut self, id: u32) -> Self {
        self.0.default_animation = id;
        self
    }

    /// Changes what the builder has no word for.
    #[must_use]
    pub fn with(mut self, change: impl FnOnce(&mut Setup)) -> Self {
        change(&mut self.0);
        self
    }

    fn build(mut self, id: u32) -> Setup {
        self.0.id = id;
        self.0
    }
}
