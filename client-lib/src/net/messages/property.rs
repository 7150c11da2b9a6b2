//! Property updates (`spec/10-messages.md`, 7.1).

use super::common::{Text, WirePosition};
use super::wire::{ReadError, Reader, Wire, Writer, wire_struct};

wire_struct! {
    /// A skill.
    #[derive(Copy)]
    pub struct Skill {
        /// Ranks bought.
        ranks: u16,
        /// Adjustment.
        adjust: u16,
        /// 0 inactive, 1 untrained, 2 trained, 3 specialised.
        training: u32,
        /// Experience spent.
        experience: u32,
        /// Starting value.
        start: u32,
        /// Resistance of the last check.
        resistance: u32,
        /// When it was last used, s of game time.
        last_used: f64,
    }

    /// An attribute.
    #[derive(Copy, Eq)]
    pub struct Attribute {
        /// Ranks bought.
        ranks: u32,
        /// Starting value.
        start: u32,
        /// Experience spent.
        experience: u32,
    }

    /// Health, stamina or mana.
    #[derive(Copy, Eq)]
    pub struct Vital {
        /// Its attribute part.
        attribute: Attribute,
        /// Present value.
        current: u32,
    }
}

/// Kinds of values in the order of their opcodes, private and public alternating from 0x02CD.
#[derive(Debug, Clone, PartialEq)]
#[allow(missing_docs, reason = "names of the field")]
pub enum PropertyValue {
    Int(i32),
    Int64(i64),
    Bool(u32),
    Float(f64),
    Text(Text),
    DataId(u32),
    InstanceId(u32),
    Position(WirePosition),
    Skill(Skill),
    SkillLevel(u32),
    SkillTraining(u32),
    Attribute(Attribute),
    AttributeLevel(u32),
    Vital(Vital),
    VitalCurrent(u32),
    /// The property is gone.
    Removed(RemovedKind),
}

/// Kind of a property that is gone, in the order of the opcodes from 0x01D1; `Int64` has its own pair.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[allow(missing_docs, reason = "names of the field")]
pub enum RemovedKind {
    Int,
    Bool,
    Float,
    Text,
    DataId,
    InstanceId,
    Position,
    Int64,
}

/// A change of one property of the own character (no GUID) or of an object.
#[derive(Debug, Clone, PartialEq)]
pub struct PropertyUpdate {
    /// Counts per object, kind and key.
    pub sequence: u8,
    /// The object; `None` for the own character.
    pub guid: Option<u32>,
    /// Which property.
    pub key: u32,
    /// Its value.
    pub value: PropertyValue,
}

const FIRST_UPDATE: u32 = 0x02CD;
const FIRST_REMOVAL: u32 = 0x01D1;
const REMOVE_INT64: u32 = 0x02B8;

const REMOVALS: [RemovedKind; 7] = [
    RemovedKind::Int,
    RemovedKind::Bool,
    RemovedKind::Float,
    RemovedKind::Text,
    RemovedKind::DataId,
    RemovedKind::InstanceId,
    RemovedKind::Position,
];

fn read_value(kind: u32, r: &mut Reader<'_>) -> Result<PropertyValue, ReadError> {
    use PropertyValue as V;
    Ok(match kind {
        0 => V::Int(r.get()?),
        1 => V::Int64(r.get()?),
        2 => V::Bool(r.get()?),
        3 => V::Float(r.get()?),
        4 => V::Text(r.get()?),
        5 => V::DataId(r.get()?),
        6 => V::InstanceId(r.get()?),
        7 => V::Position(r.get()?),
        8 => V::Skill(r.get()?),
        9 => V::SkillLevel(r.get()?),
        10 => V::SkillTraining(r.get()?),
        11 => V::Attribute(r.get()?),
        12 => V::AttributeLevel(r.get()?),
        13 => V::Vital(r.get()?),
        _ => V::VitalCurrent(r.get()?),
    })
}

impl PropertyValue {
    /// Which pair of opcodes, counted from 0x02CD; `None` for removals.
    const fn kind(&self) -> Option<u32> {
        Some(match self {
            Self::Int(_) => 0,
            Self::Int64(_) => 1,
            Self::Bool(_) => 2,
            Self::Float(_) => 3,
            Self::Text(_) => 4,
            Self::DataId(_) => 5,
            Self::InstanceId(_) => 6,
            Self::Position(_) => 7,
            Self::Skill(_) => 8,
            Self::SkillLevel(_) => 9,
            Self::SkillTraining(_) => 10,
            Self::Attribute(_) => 11,
            Self::AttributeLevel(_) => 12,
            Self::Vital(_) => 13,
            Self::VitalCurrent(_) => 14,
            Self::Removed(_) => return None,
        })
    }

    fn write(&self, w: &mut Writer) {
        match self {
            Self::Int(v) => v.write(w),
            Self::Int64(v) => v.write(w),
            Self::Float(v) => v.write(w),
            Self::Text(v) => v.write(w),
            Self::Position(v) => v.write(w),
            Self::Skill(v) => v.write(w),
            Self::Attribute(v) => v.write(w),
            Self::Vital(v) => v.write(w),
            Self::Bool(v)
            | Self::DataId(v)
            | Self::InstanceId(v)
            | Self::SkillLevel(v)
            | Self::SkillTraining(v)
            | Self::AttributeLevel(v)
            | Self::VitalCurrent(v) => v.write(w),
            Self::Removed(_) => {}
        }
    }
}

impl PropertyUpdate {
    /// Whether an opcode is that of a property update.
    pub const fn is_opcode(opcode: u32) -> bool {
        matches!(opcode, 0x02CD..=0x02EA | 0x01D1..=0x01DE | 0x02B8 | 0x02B9)
    }

    /// Opcode of this update.
    pub fn opcode(&self) -> u32 {
        let public = u32::from(self.guid.is_some());
        let base = match (&self.value, self.value.kind()) {
            (_, Some(kind)) => FIRST_UPDATE + 2 * kind,
            (PropertyValue::Removed(removed), None) => {
                match REMOVALS.iter().position(|k| k == removed) {
                    Some(i) => FIRST_REMOVAL + 2 * i as u32,
                    None => REMOVE_INT64,
                }
            }
            (_, None) => REMOVE_INT64,
        };
        base + public
    }

    /// Reads the body of an update with this opcode.
    ///
    /// # Errors
    /// Why the bytes are none.
    pub fn read(opcode: u32, r: &mut Reader<'_>) -> Result<Self, ReadError> {
        let (kind, removed) = match opcode {
            FIRST_UPDATE.. => (Some((opcode - FIRST_UPDATE) / 2), RemovedKind::Int64),
            REMOVE_INT64.. => (None, RemovedKind::Int64),
            _ => {
                let i = (opcode.saturating_sub(FIRST_REMOVAL) / 2) as usize;
                (None, REMOVALS.get(i).copied().unwrap_or(RemovedKind::Int64))
            }
        };
        let base = match (kind, opcode) {
            (Some(kind), _) => FIRST_UPDATE + 2 * kind,
            (None, REMOVE_INT64..) => REMOVE_INT64,
            (None, _) => FIRST_REMOVAL + 2 * (opcode.saturating_sub(FIRST_REMOVAL) / 2),
        };
        let public = opcode != base;
        let sequence = r.get()?;
        let text = kind == Some(4);
        // A text's key comes before the GUID.
        let (guid, key) = match (public, text) {
            (false, _) => (None, r.get()?),
            (true, false) => (Some(r.get()?), r.get()?),
            (true, true) => {
                let key = r.get()?;
                (Some(r.get()?), key)
            }
        };
        if text {
            r.align();
        }
        let value = match kind {
            Some(kind) => read_value(kind, r)?,
            None => PropertyValue::Removed(removed),
        };
        Ok(Self {
            sequence,
            guid,
            key,
            value,
        })
    }

    /// Appends the body.
    pub fn write(&self, w: &mut Writer) {
        self.sequence.write(w);
        let text = matches!(self.value, PropertyValue::Text(_));
        match self.guid {
            None => self.key.write(w),
            Some(guid) if text => [self.key, guid].write(w),
            Some(guid) => [guid, self.key].write(w),
        }
        if text {
            w.align();
        }
        self.value.write(w);
    }
}
