//! What of a world belongs together: which blocks and rooms have to be loaded with each other.
//!
//! A static object is tested in every cell that it reaches, and the order of a cell's list is the order of the tests. So a block that is
//! loaded later than another, or not at all, changes results only through static objects that reach from one into the other. The index
//! lists, for a world and a profile, the groups of blocks and rooms that are connected so; what it does not list stands alone. Whoever
//! loads a member loads its whole group, in the order of ids: then every list is what it would be had everything been loaded at the start.
//!
//! Source: `spec/02-terrain.md`, 22 ("no object of it has shadow entries in a visited block"); `spec/03-cells.md`, 19.3.

use std::collections::BTreeMap;
use std::sync::Arc;

use serde::{Deserialize, Serialize};

use super::hex;
use crate::math::CellId;
use crate::profile::Profile;
use crate::world::{Demand, Landscape, World, WorldSource};

/// Schema of a stored index.
pub const INDEX_SCHEMA: &str = "ac-world-index/1";

/// Blocks (0xXXYYFFFF) and rooms (0xXXYYNNNN) of a world that must be loaded together, under one profile.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct WorldIndex {
    /// [`INDEX_SCHEMA`].
    pub schema: String,
    /// What it was measured on, so that it is not used for anything else: set by the owner of the files.
    pub world: String,
    /// Name of the profile.
    pub profile: String,
    /// Groups of more than one member, each in the order of ids.
    #[serde(with = "hex::lists")]
    groups: Vec<Vec<u32>>,
    /// Blocks and rooms with static objects that are animated, in the order of ids.
    #[serde(with = "hex::list")]
    animated: Vec<u32>,
    /// By member: its group.
    #[serde(skip)]
    group_of: BTreeMap<u32, u32>,
}

impl WorldIndex {
    /// Loads every block and room alone, once, and notes what it brought along. `ids` are the ids of the cell file's records.
    ///
    /// Takes about as long as loading the world twice; [`WorldIndex::from_json`] takes none of it.
    pub fn measure(
        source: &Arc<dyn WorldSource>,
        profile: &Profile,
        ids: impl IntoIterator<Item = u32>,
    ) -> Self {
        let mut world = World::with_source(profile.clone(), 0.0, Arc::clone(source));
        let mut links = Links::default();
        let mut animated = Vec::new();
        for key in ids.into_iter().filter(|&id| is_member(id)) {
            world.land = Landscape::new(Arc::clone(source));
            world.load(Demand {
                cell: cell_of(key),
                without_statics: false,
            });
            for other in world.land.loaded_members() {
                links.join(key, other);
            }
            let moves = |&id: &_| {
                let object = world.land.static_object(id);
                object.is_some_and(|o| member_of(o.body.position.cell) == key)
            };
            if world.land.animated_statics().iter().any(moves) {
                animated.push(key);
            }
        }
        animated.sort_unstable();
        animated.dedup();
        Self {
            schema: INDEX_SCHEMA.into(),
            world: String::new(),
            profile: String::new(),
            groups: links.groups(),
            animated,
            group_of: BTreeMap::new(),
        }
        .with_table()
    }

    fn with_table(mut self) -> Self {
        let members = |(number, group): (usize, &Vec<u32>)| {
            let of: Vec<_> = group.iter().map(|&m| (m, number as u32)).collect();
            of
        };
        self.group_of = self.groups.iter().enumerate().flat_map(members).collect();
        self
    }

    /// Reads a stored index.
    ///
    /// # Errors
    /// When the text is no index of [`INDEX_SCHEMA`].
    pub fn from_json(text: &[u8]) -> Result<Self, serde_json::Error> {
        let index: Self = serde_json::from_slice(text)?;
        if index.schema != INDEX_SCHEMA {
            let reason = format!(
                "schema `{}`, this version reads {INDEX_SCHEMA}",
                index.schema
            );
            return Err(serde::de::Error::custom(reason));
        }
        Ok(index.with_table())
    }

    /// The text that [`WorldIndex::from_json`] reads.
    ///
    /// # Errors
    /// None that can be named: the index holds nothing but ids.
    pub fn to_json(&self) -> Result<String, serde_json::Error> {
        serde_json::to_string_pretty(self).map(|text| text + "\n")
    }

    /// The group of a block or room, in the order of ids; `None` if it stands alone.
    pub fn group(&self, member: u32) -> Option<&[u32]> {
        let group = self.group_of.get(&member)?;
        self.groups.get(*group as usize).map(Vec::as_slice)
    }

    /// Every group of more than one member.
    pub fn groups(&self) -> &[Vec<u32>] {
        &self.groups
    }

    /// Blocks and rooms with static objects that are animated.
    pub fn animated(&self) -> &[u32] {
        &self.animated
    }
}

/// The record of the cell file that stands for a cell: its block's, or its own.
pub(super) fn member_of(cell: CellId) -> u32 {
    if cell.is_indoor() && cell.low() != 0xFFFF {
        cell.0
    } else {
        cell.0 | 0xFFFF
    }
}

/// A cell that brings the member when it is loaded.
pub(super) fn cell_of(member: u32) -> CellId {
    if member & 0xFFFF == 0xFFFF {
        CellId(member & 0xFFFF_0000 | 1)
    } else {
        CellId(member)
    }
}

/// Whether an id of the cell file is that of a block or a room.
fn is_member(id: u32) -> bool {
    let low = id & 0xFFFF;
    low == 0xFFFF || (0x0100..=0xFFFD).contains(&low)
}

/// What was found to belong together.
#[derive(Default)]
struct Links(BTreeMap<u32, u32>);

impl Links {
    fn root(&mut self, mut id: u32) -> u32 {
        let mut path = Vec::new();
        while let Some(&up) = self.0.get(&id) {
            path.push(id);
            id = up;
        }
        for below in path {
            self.0.insert(below, id);
        }
        id
    }

    fn join(&mut self, a: u32, b: u32) {
        let (a, b) = (self.root(a), self.root(b));
        if a != b {
            // The smaller id stands for both.
            self.0.insert(a.max(b), a.min(b));
        }
    }

    fn groups(mut self) -> Vec<Vec<u32>> {
        let mut groups: BTreeMap<u32, Vec<u32>> = BTreeMap::new();
        for id in self.0.keys().copied().collect::<Vec<_>>() {
            let root = self.root(id);
            groups.entry(root).or_insert_with(|| vec![root]).push(id);
        }
        let mut groups: Vec<_> = groups.into_values().collect();
        groups.iter_mut().for_each(|group| group.sort_unstable());
        groups
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::dat::StoredFrame;
    use crate::dat::worldgen::{Room, SetupBuilder, WorldBuilder, block};
    use crate::math::Vec3;

    fn index_of(world: &WorldBuilder) -> WorldIndex {
        let set = Arc::new(world.build().expect("the world is well formed"));
        let ids = set.cell().ids().expect("just written");
        let source: Arc<dyn WorldSource> = set;
        WorldIndex::measure(&source, &Profile::retail(), ids)
    }

    #[test]
    fn what_reaches_over_a_border_belongs_together() {
        let mut world = WorldBuilder::new();
        let shape = world.solid(&block(Vec3::new(-2.0, -2.0, 0.0), Vec3::new(2.0, 2.0, 3.0)));
        let post = world.setup(SetupBuilder::of_shape(shape));
        // One near the western border of its block, one in the middle.
        world
            .block(10, 10)
            .object(post, Vec3::new(1.0, 100.0, 0.0), 0.0);
        world
            .block(20, 20)
            .object(post, Vec3::new(100.0, 100.0, 0.0), 0.0);
        world.surround();
        let index = index_of(&world);
        assert_eq!(index.groups(), [[0x090A_FFFF, 0x0A0A_FFFF]]);
        assert_eq!(
            index.group(0x0A0A_FFFF),
            Some(&[0x090A_FFFF, 0x0A0A_FFFF][..])
        );
        assert_eq!(index.group(0x1414_FFFF), None);
        assert!(index.animated().is_empty());
        let text = index.to_json().expect("it is plain data");
        assert_eq!(
            WorldIndex::from_json(text.as_bytes()).expect("just written"),
            index
        );
    }

    #[test]
    fn empty_rooms_stand_alone() {
        let mut world = WorldBuilder::new();
        let rooms = world.environment(&[Room::new(Vec3::splat(-4.0), Vec3::splat(4.0))]);
        let home = world.block(10, 10);
        home.room(rooms, 0, StoredFrame::at(Vec3::new(96.0, 96.0, -50.0)), 0);
        home.room(rooms, 0, StoredFrame::at(Vec3::new(50.0, 96.0, -50.0)), 0);
        assert!(index_of(&world).groups().is_empty());
    }

    #[test]
    fn another_schema_is_refused() {
        let text =
            br#"{"schema":"ac-world-index/9","world":"","profile":"","groups":[],"animated":[]}"#;
        let error = WorldIndex::from_json(text).unwrap_err().to_string();
        assert!(error.contains("ac-world-index/9"), "{error}");
    }
}
