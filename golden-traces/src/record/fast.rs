//! Reads the canonical form without building a tree. `None` means "not recognised": the caller takes the other path.
//!
//! What is accepted is a subset of JSON: known fields, each at most once, in the order of the specification, without white
//! space. Strictly less than what [`super::tree`] accepts, with the same result.
//!
//! A record is read field by field; [`super::repeat`] reads only those that are not as in the record before.

use ac_client::frame::state::{
    AnimState, Collision, ContactPlane, Fields, FrameEvent, FrameState, FrameStates, MotionState,
    Outcome, Step,
};

/// A line with `frame` and `time`.
pub(super) fn line(text: &[u8], state: &mut FrameState) -> Option<()> {
    let mut cursor = Cursor {
        text: text.trim_ascii_end(),
    };
    cursor.literal(b"{\"frame\":")?;
    let frame = cursor.integer()?;
    cursor.literal(b",\"time\":")?;
    let time = cursor.double()?;
    cursor.literal(b",\"guid\":")?;
    let guid = cursor.hex()?;
    state.reset(frame, time, guid);
    cursor.literal(b",\"cell\":")?;
    cursor.fields(state, &mut [Part::default(); FIELDS.len()])?;
    cursor.text.is_empty().then_some(())
}

/// A message with all records of a frame.
pub(super) fn message(text: &[u8], states: &mut FrameStates) -> Option<(i32, f64)> {
    let mut cursor = Cursor { text };
    let (frame, time) = cursor.message_head()?;
    if cursor.literal(b"]").is_none() {
        loop {
            let state = states.push(frame, time, 0);
            cursor.record(state, &mut [Part::default(); FIELDS.len()])?;
            if cursor.literal(b",").is_none() {
                break;
            }
        }
        cursor.literal(b"]")?;
    }
    cursor.literal(b"}")?;
    cursor.text.is_empty().then_some((frame, time))
}

/// The fields of a record in their order, as they begin. The first two are always there.
pub(super) const FIELDS: [&[u8]; 16] = [
    b"{\"guid\":",
    b",\"cell\":",
    b",\"origin\":",
    b",\"rotation\":",
    b",\"velocity\":",
    b",\"acceleration\":",
    b",\"omega\":",
    b",\"state\":",
    b",\"transient\":",
    b",\"contact_plane\":",
    b",\"sliding_normal\":",
    b",\"anim\":",
    b",\"motion\":",
    b",\"steps\":",
    b",\"collisions\":",
    b",\"events\":",
];

/// A field in the text of a record.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Part {
    /// Length of key and value; 0: the field is not there.
    pub length: u32,
    /// What its presence says.
    pub has: Fields,
}

/// The fields of one record.
pub(super) type Parts = [Part; FIELDS.len()];

pub(super) struct Cursor<'a> {
    pub text: &'a [u8],
}

/// A decimal: `±digits · 10^exponent`, and its text for when that does not suffice.
struct Decimal<'a> {
    negative: bool,
    digits: u64,
    exponent: i32,
    text: &'a [u8],
}

impl<'a> Cursor<'a> {
    #[inline(always)]
    pub fn literal(&mut self, literal: &[u8]) -> Option<()> {
        self.text = self.text.strip_prefix(literal)?;
        Some(())
    }

    /// From the beginning of a message to the bracket before its records.
    pub fn message_head(&mut self) -> Option<(i32, f64)> {
        self.literal(b"{\"frame\":")?;
        let frame = self.integer()?;
        self.literal(b",\"time\":")?;
        let time = self.double()?;
        self.literal(b",\"entities\":[")?;
        Some((frame, time))
    }

    /// A record of a message into a state that was reset; where its fields are goes into `parts`.
    pub fn record(&mut self, state: &mut FrameState, parts: &mut Parts) -> Option<()> {
        let start = self.text.len();
        self.literal(FIELDS[0])?;
        state.guid = self.hex()?;
        parts[0].length = (start - self.text.len()) as u32;
        self.literal(FIELDS[1])?;
        self.fields(state, parts)
    }

    /// From the value of `cell` to the closing brace.
    fn fields(&mut self, state: &mut FrameState, parts: &mut Parts) -> Option<()> {
        let mut has = Fields::empty();
        for (field, part) in parts.iter_mut().enumerate().skip(1) {
            // The key of the cell has been read.
            let start = self.text.len() + if field == 1 { FIELDS[1].len() } else { 0 };
            *part = Part::default();
            if field == 1 || self.literal(FIELDS[field]).is_some() {
                part.has = self.value(field, state)?;
                part.length = (start - self.text.len()) as u32;
                has |= part.has;
            }
        }
        if !has.contains(Fields::ANIM) {
            // Kept until now for its memory.
            state.anim = None;
        }
        state.has = has;
        self.literal(b"}")
    }

    /// The value of a field, whatever the state had in its place.
    #[inline]
    pub fn value(&mut self, field: usize, state: &mut FrameState) -> Option<Fields> {
        Some(match field {
            0 => {
                state.guid = self.hex()?;
                Fields::empty()
            }
            1 => {
                state.cell = self.hex()?;
                Fields::empty()
            }
            2 => {
                state.origin = self.floats()?;
                Fields::ORIGIN
            }
            3 => {
                state.rotation = self.floats()?;
                Fields::ROTATION
            }
            4 => {
                state.velocity = self.floats()?;
                Fields::VELOCITY
            }
            5 => {
                state.acceleration = self.floats()?;
                Fields::ACCELERATION
            }
            6 => {
                state.omega = self.floats()?;
                Fields::OMEGA
            }
            7 => {
                state.state = self.hex()?;
                Fields::STATE
            }
            8 => {
                state.transient = self.hex()?;
                Fields::TRANSIENT
            }
            9..=12 => self.nullable(field, state)?,
            _ => self.list_field(field, state)?,
        })
    }

    fn nullable(&mut self, field: usize, state: &mut FrameState) -> Option<Fields> {
        let null = self.literal(b"null").is_some();
        Some(match field {
            9 => {
                state.contact_plane = if null { None } else { Some(self.plane()?) };
                let parts = state
                    .contact_plane
                    .map_or(Fields::empty(), |_| Fields::PLANE_PARTS);
                Fields::CONTACT_PLANE | parts
            }
            10 => {
                state.sliding_normal = if null { None } else { Some(self.floats()?) };
                Fields::SLIDING_NORMAL
            }
            11 if null => {
                state.anim = None;
                Fields::ANIM
            }
            11 => {
                self.anim(state.anim.get_or_insert_default())?;
                Fields::ANIM | Fields::ANIM_PARTS
            }
            _ if null => {
                state.motion = None;
                Fields::MOTION
            }
            _ => {
                let (motion, parts) = self.motion()?;
                state.motion = Some(motion);
                Fields::MOTION | parts
            }
        })
    }

    fn list_field(&mut self, field: usize, state: &mut FrameState) -> Option<Fields> {
        self.literal(b"[")?;
        Some(match field {
            13 => {
                state.steps.clear();
                self.list(Self::step, &mut state.steps)?;
                Fields::STEPS
            }
            14 => {
                state.collisions.clear();
                self.list(Self::collision, &mut state.collisions)?;
                Fields::COLLISIONS
            }
            _ => {
                state.events.clear();
                self.list(Self::event, &mut state.events)?;
                Fields::EVENTS
            }
        })
    }

    fn plane(&mut self) -> Option<ContactPlane> {
        self.literal(b"{\"n\":")?;
        let n = self.floats()?;
        self.literal(b",\"d\":")?;
        let d = self.float()?;
        self.literal(b",\"cell\":")?;
        let cell = self.hex()?;
        self.literal(b"}")?;
        Some(ContactPlane { n, d, cell })
    }

    fn anim(&mut self, anim: &mut AnimState) -> Option<()> {
        self.literal(b"{\"frame_number\":")?;
        anim.frame_number = self.double()?;
        self.literal(b",\"id\":")?;
        anim.id = self.hex()?;
        self.literal(b",\"first_cyclic\":")?;
        anim.first_cyclic = if self.literal(b"true").is_some() {
            true
        } else {
            self.literal(b"false")?;
            false
        };
        self.literal(b",\"queue\":[")?;
        anim.queue.clear();
        self.list(|cursor| cursor.hex(), &mut anim.queue)?;
        self.literal(b",\"velocity\":")?;
        anim.velocity = self.floats()?;
        self.literal(b",\"omega\":")?;
        anim.omega = self.floats()?;
        self.literal(b"}")
    }

    fn motion(&mut self) -> Option<(MotionState, Fields)> {
        let mut motion = MotionState::default();
        let mut parts = Fields::MOTION_TABLE_PARTS;
        self.literal(b"{\"style\":")?;
        motion.style = self.hex()?;
        self.literal(b",\"substate\":")?;
        motion.substate = self.hex()?;
        self.literal(b",\"substate_speed\":")?;
        motion.substate_speed = self.float()?;
        if self.literal(b",\"forward\":").is_some() {
            parts |= Fields::MOTION_INTERPRETED_PARTS;
            motion.forward = self.hex()?;
            self.literal(b",\"forward_speed\":")?;
            motion.forward_speed = self.float()?;
            self.literal(b",\"sidestep\":")?;
            motion.sidestep = self.hex()?;
            self.literal(b",\"sidestep_speed\":")?;
            motion.sidestep_speed = self.float()?;
            self.literal(b",\"turn\":")?;
            motion.turn = self.hex()?;
            self.literal(b",\"turn_speed\":")?;
            motion.turn_speed = self.float()?;
        }
        self.literal(b"}")?;
        Some((motion, parts))
    }

    /// Items up to the closing bracket; the opening one is gone.
    fn list<T>(&mut self, item: impl Fn(&mut Self) -> Option<T>, into: &mut Vec<T>) -> Option<()> {
        if self.literal(b"]").is_some() {
            return Some(());
        }
        loop {
            into.push(item(self)?);
            if self.literal(b",").is_none() {
                return self.literal(b"]");
            }
        }
    }

    fn step(&mut self) -> Option<Step> {
        self.literal(b"{\"dt\":")?;
        let dt = self.float()?;
        self.literal(b",\"outcome\":\"")?;
        let outcome = Outcome::ALL
            .into_iter()
            .find(|outcome| self.literal(outcome.name().as_bytes()).is_some())?;
        self.literal(b"\"}")?;
        Some(Step { dt, outcome })
    }

    fn collision(&mut self) -> Option<Collision> {
        if self.literal(b"\"environment\"").is_some() {
            return Some(Collision::Environment);
        }
        self.hex().map(Collision::Object)
    }

    fn event(&mut self) -> Option<FrameEvent> {
        if self.literal(b"\"motion_done:").is_some() {
            return self.hex_digits().map(FrameEvent::MotionDone);
        }
        self.literal(b"\"")?;
        let end = self.text.iter().position(|byte| *byte == b'"')?;
        let event = FrameEvent::parse(std::str::from_utf8(&self.text[..end]).ok()?)?;
        self.text = &self.text[end + 1..];
        Some(event)
    }

    #[inline]
    fn hex(&mut self) -> Option<u32> {
        self.literal(b"\"")?;
        self.hex_digits()
    }

    /// `0x`, 1 to 8 digits and the closing quote.
    #[inline]
    fn hex_digits(&mut self) -> Option<u32> {
        self.literal(b"0x")?;
        let mut id = 0;
        for (count, byte) in self.text.iter().take(9).enumerate() {
            let digit = match byte {
                b'0'..=b'9' => byte - b'0',
                b'A'..=b'F' => byte - b'A' + 10,
                b'a'..=b'f' => byte - b'a' + 10,
                b'"' if count > 0 => {
                    self.text = &self.text[count + 1..];
                    return Some(id);
                }
                _ => return None,
            };
            if count == 8 {
                return None;
            }
            id = id << 4 | u32::from(digit);
        }
        None
    }

    fn integer(&mut self) -> Option<i32> {
        let decimal = self.decimal()?;
        if decimal.exponent != 0
            || decimal
                .text
                .iter()
                .any(|byte| !matches!(byte, b'-' | b'0'..=b'9'))
        {
            return None;
        }
        let magnitude = i64::try_from(decimal.digits).ok()?;
        i32::try_from(if decimal.negative {
            -magnitude
        } else {
            magnitude
        })
        .ok()
    }

    #[inline]
    fn floats<const N: usize>(&mut self) -> Option<[f32; N]> {
        let mut numbers = [0.0; N];
        for (index, number) in numbers.iter_mut().enumerate() {
            self.literal(if index == 0 { b"[" } else { b"," })?;
            *number = self.float()?;
        }
        self.literal(b"]")?;
        Some(numbers)
    }

    #[inline]
    fn float(&mut self) -> Option<f32> {
        // Zeros and ones are most of the numbers of a record.
        if let [digit @ b'0'..=b'9', b',' | b']' | b'}', ..] = self.text {
            self.text = &self.text[1..];
            return Some(f32::from(digit - b'0'));
        }
        match self.decimal() {
            Some(decimal) => decimal.float(),
            None => self.special().map(|wide| wide as f32),
        }
    }

    fn double(&mut self) -> Option<f64> {
        match self.decimal() {
            Some(decimal) => decimal.double(),
            None => self.special(),
        }
    }

    fn special(&mut self) -> Option<f64> {
        [
            (&b"\"nan\""[..], f64::NAN),
            (b"\"inf\"", f64::INFINITY),
            (b"\"-inf\"", f64::NEG_INFINITY),
        ]
        .into_iter()
        .find(|(text, _)| self.literal(text).is_some())
        .map(|(_, number)| number)
    }

    /// A JSON number. Leaves the cursor where it is if there is none.
    #[inline]
    fn decimal(&mut self) -> Option<Decimal<'a>> {
        let text = self.text;
        let negative = text.first() == Some(&b'-');
        let mut at = usize::from(negative);
        let (whole, mut digits) = scan_digits(&text[at..], 0);
        // JSON has no leading zeros.
        if whole == 0 || whole > 1 && text[at] == b'0' {
            return None;
        }
        at += whole;
        let mut exponent = 0;
        let mut count = whole;
        if text.get(at) == Some(&b'.') {
            let (fraction, all) = scan_digits(&text[at + 1..], digits);
            if fraction == 0 {
                return None;
            }
            digits = all;
            count += fraction;
            exponent = -i32::try_from(fraction).ok()?;
            at += 1 + fraction;
        }
        if let Some(b'e' | b'E') = text.get(at) {
            let (length, shift) = scan_exponent(&text[at + 1..])?;
            exponent += shift;
            at += 1 + length;
        }
        // 19 digits always fit into 64 bits. More: `digits` is meaningless, the text is used.
        if count > 19 {
            exponent = i32::MAX;
        }
        self.text = &text[at..];
        Some(Decimal {
            negative,
            digits,
            exponent,
            text: &text[..at],
        })
    }
}

/// How many digits the text begins with, and `start` continued by them.
#[inline]
fn scan_digits(text: &[u8], start: u64) -> (usize, u64) {
    let mut value = start;
    for (count, byte) in text.iter().enumerate() {
        let digit = byte.wrapping_sub(b'0');
        if digit > 9 {
            return (count, value);
        }
        value = value.wrapping_mul(10).wrapping_add(digit.into());
    }
    (text.len(), value)
}

/// What follows the `e`: its length and value.
fn scan_exponent(text: &[u8]) -> Option<(usize, i32)> {
    let sign = usize::from(matches!(text.first(), Some(b'+' | b'-')));
    let (count, value) = scan_digits(&text[sign..], 0);
    if count == 0 || count > 4 {
        return None;
    }
    let value = i32::try_from(value).ok()?;
    Some((sign + count, if text[0] == b'-' { -value } else { value }))
}

/// Powers of ten that a double holds exactly.
const POWERS: [f64; 23] = [
    1e0, 1e1, 1e2, 1e3, 1e4, 1e5, 1e6, 1e7, 1e8, 1e9, 1e10, 1e11, 1e12, 1e13, 1e14, 1e15, 1e16,
    1e17, 1e18, 1e19, 1e20, 1e21, 1e22,
];

impl Decimal<'_> {
    /// The number as the nearest double.
    #[inline]
    fn double(&self) -> Option<f64> {
        // Digits and power both exact in a double: one rounding, which is the right one.
        if self.digits < 1 << 53
            && let Some(number) = self.scaled()
        {
            return Some(number);
        }
        self.slow_double()
    }

    #[cold]
    fn slow_double(&self) -> Option<f64> {
        std::str::from_utf8(self.text)
            .ok()?
            .parse()
            .ok()
            .filter(|number: &f64| number.is_finite())
    }

    /// The nearest double, narrowed.
    #[inline]
    fn float(&self) -> Option<f32> {
        if let Some(near) = self.scaled() {
            // `near` is at most two last places of a double away from the number: the digits and the scaling were rounded
            // once each. Narrowing gives the same float unless the number is that close to the middle between two floats,
            // which shows in the 29 bits that are cut off. In the subnormal range other bits are.
            let cut = near.to_bits() & 0x1FFF_FFFF;
            let normal = near == 0.0 || near.abs() >= 2.0 * f64::from(f32::MIN_POSITIVE);
            if cut.abs_diff(0x1000_0000) > 8 && normal {
                return Some(near as f32);
            }
        }
        self.slow_double().map(|wide| wide as f32)
    }

    /// Digits times power, when the power is exact.
    #[inline]
    fn scaled(&self) -> Option<f64> {
        let digits = self.digits as f64;
        let power = *POWERS.get(self.exponent.unsigned_abs() as usize)?;
        let magnitude = if self.exponent < 0 {
            digits / power
        } else {
            digits * power
        };
        Some(if self.negative { -magnitude } else { magnitude })
    }
}
