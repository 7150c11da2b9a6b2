//! An object's physics (`spec/10-messages.md`, 4.2).

use super::common::{List, WirePosition};
use super::movement::MovementData;
use super::wire::{Problem, ReadError, Reader, Wire, Writer, optional_fields};

optional_fields! {
    /// The fields after the movement, present by the bits of the flag word.
    pub struct PhysicsFields {
        /// Place.
        position: WirePosition = 0, 0x0_8000;
        /// Motion table, 0x09......
        motion_table: u32 = 0, 0x0_0002;
        /// Sound table, 0x20......
        sound_table: u32 = 0, 0x0_0800;
        /// Table of physics scripts, 0x34......
        script_table: u32 = 0, 0x0_1000;
        /// Setup, 0x02......
        setup: u32 = 0, 0x0_0001;
        /// GUID of the parent and holding location.
        parent: (u32, u32) = 0, 0x0_0020;
        /// GUIDs of children and their holding locations.
        children: List<(u32, u32)> = 0, 0x0_0040;
        /// Scale.
        scale: f32 = 0, 0x0_0080;
        /// Friction, 0..1.
        friction: f32 = 0, 0x0_0100;
        /// Elasticity.
        elasticity: f32 = 0, 0x0_0200;
        /// Translucency, 0 opaque to 1 invisible.
        translucency: f32 = 0, 0x4_0000;
        /// World axes, m/s.
        velocity: [f32; 3] = 0, 0x0_0004;
        /// World axes, m/s².
        acceleration: [f32; 3] = 0, 0x0_0008;
        /// World axes, rad/s.
        omega: [f32; 3] = 0, 0x0_0010;
        /// Default script.
        default_script: u32 = 0, 0x0_2000;
        /// Its intensity.
        default_script_intensity: f32 = 0, 0x0_4000;
    }
}

/// What comes before the fields.
#[derive(Debug, Clone, PartialEq, Default)]
pub enum Motion {
    /// Neither.
    #[default]
    Absent,
    /// A movement; `None` for one of length 0. `autonomous` is sent only with a movement. `shadows` keeps a placement bit that is ignored.
    Movement {
        /// The movement and whether it came from the object's own input.
        data: Option<(MovementData, u32)>,
        /// The bit of a placement frame is set too.
        shadows: bool,
    },
    /// A placement frame.
    Placement(u32),
}

/// An object's physics, as sent.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct PhysicsDesc {
    /// State word.
    pub state: u32,
    /// Movement or placement frame.
    pub motion: Motion,
    /// The other fields.
    pub fields: PhysicsFields,
    /// The bit of the stamps, which means nothing: they are always there.
    pub timestamps_bit: bool,
    /// The nine stamps.
    pub timestamps: [u16; 9],
}

const TIMESTAMPS: u32 = 0x0_0400;
const MOVEMENT: u32 = 0x1_0000;
const PLACEMENT: u32 = 0x2_0000;
const KNOWN: u32 = 0x7_FFFF;

impl Motion {
    fn read(flags: u32, r: &mut Reader<'_>) -> Result<Self, ReadError> {
        if flags & MOVEMENT != 0 {
            let n = r.get::<u32>()? as usize;
            let window = r.bytes(n)?;
            let data = match n {
                0 => None,
                _ => Some((MovementData::from_window(window), r.get()?)),
            };
            let shadows = flags & PLACEMENT != 0;
            return Ok(Self::Movement { data, shadows });
        }
        if flags & PLACEMENT != 0 {
            return r.get().map(Self::Placement);
        }
        Ok(Self::Absent)
    }

    const fn flags(&self) -> u32 {
        match self {
            Self::Absent => 0,
            Self::Movement { shadows: false, .. } => MOVEMENT,
            Self::Movement { shadows: true, .. } => MOVEMENT | PLACEMENT,
            Self::Placement(_) => PLACEMENT,
        }
    }

    fn write(&self, w: &mut Writer) {
        match self {
            Self::Absent => {}
            Self::Movement { data: None, .. } => 0u32.write(w),
            Self::Movement {
                data: Some((data, autonomous)),
                ..
            } => {
                (data.bytes().len() as u32).write(w);
                data.write(w);
                autonomous.write(w);
            }
            Self::Placement(id) => id.write(w),
        }
    }
}

impl Wire for PhysicsDesc {
    const MIN: usize = 26;

    fn read(r: &mut Reader<'_>) -> Result<Self, ReadError> {
        let start = r.offset();
        let [flags, state] = r.get::<[u32; 2]>()?;
        // The stamps come after everything that an unknown bit could announce.
        if flags & !KNOWN != 0 {
            return Err(ReadError {
                offset: start,
                problem: Problem::UnknownFlags(flags & !KNOWN),
            });
        }
        let motion = Motion::read(flags, r)?;
        let fields = PhysicsFields::read_fields([flags, 0], r)?;
        let timestamps = r.get()?;
        r.align();
        Ok(Self {
            state,
            motion,
            fields,
            timestamps_bit: flags & TIMESTAMPS != 0,
            timestamps,
        })
    }

    fn write(&self, w: &mut Writer) {
        let stamps = if self.timestamps_bit { TIMESTAMPS } else { 0 };
        (self.fields.flags()[0] | self.motion.flags() | stamps).write(w);
        self.state.write(w);
        self.motion.write(w);
        self.fields.write_fields(w);
        self.timestamps.write(w);
        w.align();
    }
}
