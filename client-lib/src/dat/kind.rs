//! Kinds of records and how ids tell them. Source: `spec/11-dat-files.md, 8, 10`.

use std::fmt;

use serde::Serialize;

/// Which of the client's files a record is looked up in.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize)]
pub enum DataSet {
    /// `client_portal.dat`, also `client_highres.dat`: shapes, animations, tables.
    Portal,
    /// `client_cell_1.dat`: landblocks and rooms.
    Cell,
    /// `client_local_English.dat`: texts, user interface.
    Local,
}

impl DataSet {
    /// The number in the header.
    #[must_use]
    pub fn value(self) -> u32 {
        match self {
            Self::Portal => 1,
            Self::Cell => 2,
            Self::Local => 3,
        }
    }

    /// From the number in the header.
    #[must_use]
    pub fn from_value(value: u32) -> Option<Self> {
        [Self::Portal, Self::Cell, Self::Local]
            .into_iter()
            .find(|d| d.value() == value)
    }
}

macro_rules! kinds {
    ($($(#[$doc:meta])* $variant:ident = $name:literal,)*) => {
        /// Kind of a record.
        #[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize)]
        pub enum RecordKind {
            $($(#[$doc])* $variant,)*
        }

        impl RecordKind {
            /// All kinds.
            pub const ALL: &[Self] = &[$(Self::$variant,)*];

            /// Name for people and for the command line, in kebab case.
            #[must_use]
            pub fn name(self) -> &'static str {
                match self {
                    $(Self::$variant => $name,)*
                }
            }
        }
    };
}

kinds! {
    /// Cell file, 0xXXYYFFFF.
    Landblock = "landblock",
    /// Cell file, 0xXXYYFFFE.
    LandblockInfo = "landblock-info",
    /// Cell file, 0xXXYY0100..=0xXXYYFFFD.
    EnvCell = "env-cell",
    /// 0x01......: shape.
    GfxObj = "gfx-obj",
    /// 0x02......: parts, collision shapes, sizes.
    Setup = "setup",
    /// 0x03......
    Animation = "animation",
    /// 0x04......
    Palette = "palette",
    /// 0x05......
    SurfaceTexture = "surface-texture",
    /// 0x06......, 0x07......
    RenderSurface = "render-surface",
    /// 0x08......
    Surface = "surface",
    /// 0x09......
    MotionTable = "motion-table",
    /// 0x0A......
    Wave = "wave",
    /// 0x0D......: room structures.
    Environment = "environment",
    /// 0x0F......
    PaletteSet = "palette-set",
    /// 0x11......
    DegradeInfo = "degrade-info",
    /// 0x12......: scenery.
    Scene = "scene",
    /// 0x13......
    Region = "region",
    /// 0x15......: laid out as a surface texture.
    RenderTexture = "render-texture",
    /// 0x20......
    SoundTable = "sound-table",
    /// 0x32......
    ParticleEmitter = "particle-emitter",
    /// 0x33......
    PhysicsScript = "physics-script",
    /// 0x34......
    PhysicsScriptTable = "physics-script-table",
    /// 0xFFFF0001 of every file.
    Iteration = "iteration",
    /// A kind whose layout this library does not know.
    Other = "other",
}

/// Id of the iteration record, in every file.
pub const ITERATION_ID: u32 = 0xFFFF_0001;
/// Id of the region record.
pub const REGION_ID: u32 = 0x1300_0000;

impl RecordKind {
    /// Kind of the record with this id.
    ///
    /// In a cell file 0xFFFF0001 is the iteration record and not a room.
    #[must_use]
    pub fn of(data_set: DataSet, id: u32) -> Self {
        if id == ITERATION_ID {
            return Self::Iteration;
        }
        match data_set {
            DataSet::Cell => match id & 0xFFFF {
                0xFFFF => Self::Landblock,
                0xFFFE => Self::LandblockInfo,
                0x0100..=0xFFFD => Self::EnvCell,
                _ => Self::Other,
            },
            DataSet::Portal | DataSet::Local => Self::of_portal_id(id),
        }
    }

    fn of_portal_id(id: u32) -> Self {
        // The wide ranges use 24 bits, the others 16.
        match id >> 24 {
            0x05 => return Self::SurfaceTexture,
            0x06 | 0x07 => return Self::RenderSurface,
            0x15 => return Self::RenderTexture,
            _ => {}
        }
        match id >> 16 {
            0x0100 => Self::GfxObj,
            0x0200 => Self::Setup,
            0x0300 => Self::Animation,
            0x0400 => Self::Palette,
            0x0800 => Self::Surface,
            0x0900 => Self::MotionTable,
            0x0A00 => Self::Wave,
            0x0D00 => Self::Environment,
            0x0F00 => Self::PaletteSet,
            0x1100 => Self::DegradeInfo,
            0x1200 => Self::Scene,
            0x1300 => Self::Region,
            0x2000 => Self::SoundTable,
            0x3200 => Self::ParticleEmitter,
            0x3300 => Self::PhysicsScript,
            0x3400 => Self::PhysicsScriptTable,
            _ => Self::Other,
        }
    }

    /// The kind with this name.
    #[must_use]
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.iter().copied().find(|k| k.name() == name)
    }

    /// Name of the id's range where [`RecordKind::of`] answers [`RecordKind::Other`].
    #[must_use]
    pub fn range_name(id: u32) -> &'static str {
        match id {
            0x0000_0001..=0x0000_FFFF => "weenie defaults",
            0x0E00_0002 => "character creation",
            0x0E00_0003 => "secondary attribute table",
            0x0E00_0004 => "skill table",
            0x0E00_0007 => "chat pose table",
            0x0E00_000D => "object hierarchy",
            0x0E00_000E => "spell table",
            0x0E00_000F => "spell component table",
            0x0E00_0011 => "treasure table",
            0x0E00_0018 => "experience table",
            0x0E00_0019 => "craft table",
            0x0E00_001A => "bad data table",
            0x0E00_001B | 0x0E00_001C => "event table",
            0x0E00_001D => "contract table",
            0x0E00_001E => "taboo table",
            0x0E00_001F => "file-to-id table",
            0x0E00_0020 => "name filter table",
            0x0E01_0000..=0x0E01_FFFF => "quality filter",
            0x0E02_0000..=0x0E02_FFFF => "monitored properties",
            0x1000_0000..=0x1000_FFFF => "clothing table",
            0x1400_0000..=0x1400_FFFF => "key map",
            0x1600_0000..=0x18FF_FFFF => "render material",
            0x1900_0000..=0x19FF_FFFF => "render mesh",
            0x2100_0000..=0x21FF_FFFF => "user-interface layout",
            0x2200_0000..=0x22FF_FFFF => "enum mapper",
            0x2300_0000..=0x24FF_FFFF => "string table",
            0x2500_0000..=0x25FF_FFFF => "id mapper",
            0x2600_0000..=0x2600_FFFF => "action map",
            0x2700_0000..=0x27FF_FFFF => "dual id mapper",
            0x3000_0000..=0x3000_FFFF => "combat maneuver table",
            0x3100_0000..=0x3100_FFFF => "language strings",
            0x3800_0000..=0x3800_FFFF => "mutation filter",
            0x3900_0000..=0x39FF_FFFF => "master property",
            0x4000_0000..=0x400F_FFFF => "font",
            0x4100_0000..=0x41FF_FFFF => "string state",
            0x7800_0000..=0x7FFF_FFFF => "properties",
            _ => "unknown",
        }
    }
}

impl fmt::Display for RecordKind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name())
    }
}
