//! Motion table: which animations belong to which motion command, 0x09......
//! Source: `spec/11-dat-files.md, 9.4`, `spec/07-animation.md, 3.3`.

use serde::Serialize;

use super::keyed::{KeyedList, keyed};
use super::kind::RecordKind;
use super::motion_data::MotionData;
use super::reader::{Read, Reader};
use super::record::Record;
use super::writer::Writer;

/// A motion table. Keys are described in `spec/07-animation.md, 3.3`; see [`motion_key`].
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct MotionTable {
    /// Own id.
    #[serde(serialize_with = "super::json::hex")]
    pub id: u32,
    /// Style in which an object starts, a motion command 0x8000....
    #[serde(serialize_with = "super::json::hex")]
    pub default_style: u32,
    /// Full style command to full command of its default substate.
    pub style_defaults: KeyedList<u32, u32>,
    /// Cycles by `motion_key(style, substate)`.
    pub cycles: KeyedList<u32, MotionData>,
    /// Modifiers by `motion_key(style, motion)`, or `motion & 0xFFFFFF` for all styles.
    pub modifiers: KeyedList<u32, MotionData>,
    /// From `motion_key(style, substate)`, or `style << 16` for any substate, to full target command to motion.
    pub links: KeyedList<u32, KeyedList<u32, MotionData>>,
}

/// Key of a style and a motion: `style << 16` without the bits that fall out, and the low 24 bits of the motion.
#[must_use]
pub fn motion_key(style: u32, motion: u32) -> u32 {
    style << 16 | motion & 0x00FF_FFFF
}

impl MotionTable {
    /// A table without motions.
    #[must_use]
    pub fn new(id: u32, default_style: u32) -> Self {
        Self {
            id,
            default_style,
            style_defaults: KeyedList::default(),
            cycles: KeyedList::default(),
            modifiers: KeyedList::default(),
            links: KeyedList::default(),
        }
    }

    /// Adds a style and its default substate, full commands.
    #[must_use]
    pub fn with_style(mut self, style: u32, default_substate: u32) -> Self {
        self.style_defaults.push(style, default_substate);
        self
    }

    /// Adds the cycle of a substate.
    #[must_use]
    pub fn with_cycle(mut self, style: u32, substate: u32, motion: MotionData) -> Self {
        self.cycles.push(motion_key(style, substate), motion);
        self
    }

    /// Adds a modifier for all styles.
    #[must_use]
    pub fn with_modifier(mut self, motion: u32, data: MotionData) -> Self {
        self.modifiers.push(motion & 0x00FF_FFFF, data);
        self
    }

    /// Adds a modifier for one style.
    #[must_use]
    pub fn with_style_modifier(mut self, style: u32, motion: u32, data: MotionData) -> Self {
        self.modifiers.push(motion_key(style, motion), data);
        self
    }

    /// Adds a link from a substate (0: from any) to a full target command.
    #[must_use]
    pub fn with_link(mut self, style: u32, from: u32, to: u32, motion: MotionData) -> Self {
        let key = motion_key(style, from);
        match self.links.get_mut(key) {
            Some(targets) => targets.push(to, motion),
            None => self.links.push(key, KeyedList::new(vec![(to, motion)])),
        }
        self
    }

    /// Motion from one link key to a full target command.
    #[must_use]
    pub fn link(&self, from: u32, to: u32) -> Option<&MotionData> {
        self.links.get(from)?.get(to)
    }
}

impl Record for MotionTable {
    const KIND: RecordKind = RecordKind::MotionTable;

    fn parse(r: &mut Reader<'_>) -> Read<Self> {
        let id = r.own_id()?;
        let default_style = r.u32()?;
        let n = r.count_u32("style defaults", 8)?;
        let defaults = r.many(n, |r| Ok((r.u32()?, r.u32()?)))?;
        let style_defaults = keyed(r, "style default", defaults)?;
        let cycles = parse_motions(r, "cycle")?;
        let modifiers = parse_motions(r, "modifier")?;
        let n = r.count_u32("links", 8)?;
        let links = r.many(n, |r| Ok((r.u32()?, parse_motions(r, "link target")?)))?;
        let links = keyed(r, "link", links)?;
        r.align4()?;
        Ok(Self {
            id,
            default_style,
            style_defaults,
            cycles,
            modifiers,
            links,
        })
    }

    fn write(&self, w: &mut Writer) {
        w.u32(self.id);
        w.u32(self.default_style);
        w.count_u32("style defaults", self.style_defaults.len());
        for (style, substate) in &self.style_defaults {
            w.u32(*style);
            w.u32(*substate);
        }
        write_motions(w, &self.cycles);
        write_motions(w, &self.modifiers);
        w.count_u32("links", self.links.len());
        for (from, targets) in &self.links {
            w.u32(*from);
            write_motions(w, targets);
        }
        w.align4();
    }

    fn id(&self) -> u32 {
        self.id
    }
}

fn parse_motions(r: &mut Reader<'_>, what: &'static str) -> Read<KeyedList<u32, MotionData>> {
    let n = r.count_u32(what, MotionData::LEAST)?;
    let list = r.many(n, |r| Ok((r.u32()?, MotionData::parse(r)?)))?;
    keyed(r, what, list)
}

fn write_motions(w: &mut Writer, motions: &KeyedList<u32, MotionData>) {
    w.count_u32("motions", motions.len());
    for (key, motion) in motions {
        w.u32(*key);
        motion.write(w);
    }
}
