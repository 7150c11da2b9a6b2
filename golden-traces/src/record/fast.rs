//! Reads the canonical form without building a tree. `None` means "not recognised": the caller takes the other path.
//!
//! What is accepted is a subset of JSON: known fields, each at most once, in the order of the specification, without white
//! space. Strictly less than what [`super::tree`] accepts, with the same result.

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
    cursor.rest(state)?;
    cursor.text.is_empty().then_some(())
}

/// A message with all records of a frame.
pub(super) fn message(text: &[u8], states: &mut FrameStates) -> Option<(i32, f64)> {
    let mut cursor = Cursor { text };
    cursor.literal(b"{\"frame\":")?;
    let frame = cursor.integer()?;
    cursor.literal(b",\"time\":")?;
    let time = cursor.double()?;
    cursor.literal(b",\"entities\":[")?;
    if cursor.literal(b"]").is_none() {
        loop {
            cursor.literal(b"{\"guid\":")?;
            let guid = cursor.hex()?;
            cursor.rest(states.push(frame, time, guid))?;
            if cursor.literal(b",").is_none() {
                break;
            }
        }
        cursor.literal(b"]")?;
    }
    cursor.literal(b"}")?;
    cursor.text.is_empty().then_some((frame, time))
}

struct Cursor<'a> {
    text: &'a [u8],
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
    fn literal(&mut self, literal: &[u8]) -> Option<()> {
        self.text = self.text.strip_prefix(literal)?;
        Some(())
    }

    /// From `cell` to the closing brace.
    fn rest(&mut self, state: &mut FrameState) -> Option<()> {
        let mut has = Fields::empty();
        self.literal(b",\"cell\":")?;
        state.cell = self.hex()?;
        if self.literal(b",\"origin\":").is_some() {
            state.origin = self.floats()?;
            has |= Fields::ORIGIN;
        }
        if self.literal(b",\"rotation\":").is_some() {
            state.rotation = self.floats()?;
            has |= Fields::ROTATION;
        }
        if self.literal(b",\"velocity\":").is_some() {
            state.velocity = self.floats()?;
            has |= Fields::VELOCITY;
        }
        if self.literal(b",\"acceleration\":").is_some() {
            state.acceleration = self.floats()?;
            has |= Fields::ACCELERATION;
        }
        if self.literal(b",\"omega\":").is_some() {
            state.omega = self.floats()?;
            has |= Fields::OMEGA;
        }
        if self.literal(b",\"state\":").is_some() {
            state.state = self.hex()?;
            has |= Fields::STATE;
        }
        if self.literal(b",\"transient\":").is_some() {
            state.transient = self.hex()?;
            has |= Fields::TRANSIENT;
        }
        has |= self.nullables(state)?;
        has |= self.lists(state)?;
        state.has = has;
        self.literal(b"}")
    }

    fn nullables(&mut self, state: &mut FrameState) -> Option<Fields> {
        let mut has = Fields::empty();
        if self.literal(b",\"contact_plane\":").is_some() {
            has |= Fields::CONTACT_PLANE;
            if self.literal(b"null").is_none() {
                state.contact_plane = Some(self.plane()?);
                has |= Fields::PLANE_PARTS;
            }
        }
        if self.literal(b",\"sliding_normal\":").is_some() {
            has |= Fields::SLIDING_NORMAL;
            if self.literal(b"null").is_none() {
                state.sliding_normal = Some(self.floats()?);
            }
        }
        let mut anim = state.anim.take();
        if self.literal(b",\"anim\":").is_some() {
            has |= Fields::ANIM;
            if self.literal(b"null").is_none() {
                let anim = anim.get_or_insert_default();
                self.anim(anim)?;
                has |= Fields::ANIM_PARTS;
            } else {
                anim = None;
            }
            state.anim = anim;
        }
        if self.literal(b",\"motion\":").is_some() {
            has |= Fields::MOTION;
            if self.literal(b"null").is_none() {
                let (motion, parts) = self.motion()?;
                state.motion = Some(motion);
                has |= parts;
            }
        }
        Some(has)
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

    fn lists(&mut self, state: &mut FrameState) -> Option<Fields> {
        let mut has = Fields::empty();
        if self.literal(b",\"steps\":[").is_some() {
            self.list(Self::step, &mut state.steps)?;
            has |= Fields::STEPS;
        }
        if self.literal(b",\"collisions\":[").is_some() {
            self.list(Self::collision, &mut state.collisions)?;
            has |= Fields::COLLISIONS;
        }
        if self.literal(b",\"events\":[").is_some() {
            self.list(Self::event, &mut state.events)?;
            has |= Fields::EVENTS;
        }
        Some(has)
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
