//! The player's description (`spec/10-messages.md`, 7.2).

use super::common::{List, Table, Text, WideText, WirePosition};
use super::property::{Attribute, Skill, Vital};
use super::wire::{Problem, ReadError, Reader, Wire, Writer, optional_fields, wire_struct};

optional_fields! {
    /// Properties of a character.
    pub struct Properties {
        /// Ints.
        ints: Table<u32, i32> = 0, 0x01;
        /// 64-bit ints.
        int64s: Table<u32, i64> = 0, 0x80;
        /// Bools.
        bools: Table<u32, u32> = 0, 0x02;
        /// Floats.
        floats: Table<u32, f64> = 0, 0x04;
        /// Texts.
        texts: Table<u32, Text> = 0, 0x10;
        /// Data ids.
        data_ids: Table<u32, u32> = 0, 0x08;
        /// Instance ids.
        instance_ids: Table<u32, u32> = 0, 0x40;
        /// Positions.
        positions: Table<u32, WirePosition> = 0, 0x20;
    }
}

optional_fields! {
    /// Attributes and vitals behind their mask.
    pub struct AttributeFields {
        /// Strength.
        strength: Attribute = 0, 0x01;
        /// Endurance.
        endurance: Attribute = 0, 0x02;
        /// Quickness.
        quickness: Attribute = 0, 0x04;
        /// Coordination.
        coordination: Attribute = 0, 0x08;
        /// Focus.
        focus: Attribute = 0, 0x10;
        /// Self.
        own: Attribute = 0, 0x20;
        /// Health.
        health: Vital = 0, 0x40;
        /// Stamina.
        stamina: Vital = 0, 0x80;
        /// Mana.
        mana: Vital = 0, 0x100;
    }
}

optional_fields! {
    /// Enchantments behind their mask.
    pub struct EnchantmentFields {
        /// Life and creature spells that multiply.
        multiplicative: List<Enchantment> = 0, 0x1;
        /// Those that add.
        additive: List<Enchantment> = 0, 0x2;
        /// Cooldowns.
        cooldowns: List<Enchantment> = 0, 0x8;
        /// Vitae.
        vitae: Enchantment = 0, 0x4;
    }
}

/// A masked group of fields: the mask keeps bits that announce nothing.
macro_rules! masked {
    ($($(#[$m:meta])* $name:ident of $fields:ident;)*) => {$(
        $(#[$m])*
        #[derive(Debug, Clone, PartialEq, Default)]
        pub struct $name {
            /// Bits that announce nothing.
            pub other_bits: u32,
            /// The fields.
            pub fields: $fields,
        }

        impl Wire for $name {
            const MIN: usize = 4;
            fn read(r: &mut Reader<'_>) -> Result<Self, ReadError> {
                let mask = r.get::<u32>()?;
                let fields = $fields::read_fields([mask, 0], r)?;
                Ok(Self { other_bits: mask & !$fields::KNOWN[0], fields })
            }
            fn write(&self, w: &mut Writer) {
                (self.fields.flags()[0] | self.other_bits).write(w);
                self.fields.write_fields(w);
            }
        }
    )*};
}

masked! {
    /// Attributes and vitals.
    Attributes of AttributeFields;
    /// Enchantments.
    Enchantments of EnchantmentFields;
    /// Generic options.
    GenericOptions of GenericOptionFields;
}

optional_fields! {
    /// Generic options behind their mask.
    pub struct GenericOptionFields {
        /// Ints.
        ints: Table<u32, i32> = 0, 0x1;
        /// Bools.
        bools: Table<u32, u32> = 0, 0x2;
        /// Floats.
        floats: Table<u32, f64> = 0, 0x4;
        /// Texts.
        texts: Table<u32, Text> = 0, 0x8;
    }
}

optional_fields! {
    /// What the vector flags announce.
    pub struct Vectors {
        /// Attributes and vitals.
        attributes: Attributes = 0, 0x0001;
        /// Skills.
        skills: Table<u32, Skill> = 0, 0x0002;
        /// Spell book.
        spells: Table<u32, f32> = 0, 0x0100;
        /// Enchantments.
        enchantments: Enchantments = 0, 0x0200;
    }
}

wire_struct! {
    /// The fixed part of an enchantment.
    #[derive(Copy)]
    pub struct EnchantmentBody {
        /// Spell.
        spell: u16,
        /// Layer.
        layer: u16,
        /// Category.
        category: u16,
        /// A set follows.
        has_set: u16,
        /// Power.
        power: u32,
        /// Start, s.
        start: f64,
        /// Duration, s.
        duration: f64,
        /// GUID of the caster.
        caster: u32,
        /// Degrade modifier.
        degrade_modifier: f32,
        /// Degrade limit.
        degrade_limit: f32,
        /// When it last degraded, s.
        last_degraded: f64,
        /// Kind of what it changes.
        kind: u32,
        /// What it changes.
        key: u32,
        /// By how much.
        value: f32,
    }

    /// A shortcut of the interface.
    #[derive(Copy, Eq)]
    pub struct Shortcut {
        /// Place.
        index: i32,
        /// Object.
        object: u32,
        /// Spell.
        spell: u32,
    }

    /// An entry of the inventory: kind 0 item, 1 container, 2 foci.
    #[derive(Copy, Eq)]
    pub struct ContentProfile {
        /// Object.
        guid: u32,
        /// Kind.
        kind: u32,
    }

    /// A wielded object.
    #[derive(Copy, Eq)]
    pub struct Placement {
        /// Object.
        guid: u32,
        /// Equip location.
        location: u32,
        /// Priority.
        priority: u32,
    }
}

/// An enchantment.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Enchantment {
    /// The fixed part.
    pub body: EnchantmentBody,
    /// The set, if the body says so.
    pub set: u32,
}

impl Wire for Enchantment {
    const MIN: usize = 60;
    fn read(r: &mut Reader<'_>) -> Result<Self, ReadError> {
        let body = r.get::<EnchantmentBody>()?;
        let set = if body.has_set == 0 { 0 } else { r.get()? };
        Ok(Self { body, set })
    }
    fn write(&self, w: &mut Writer) {
        self.body.write(w);
        if self.body.has_set != 0 {
            self.set.write(w);
        }
    }
}

/// Window placements and the like. The bytes are kept; their layout is only followed to find the end.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct GameplayOptions {
    /// As sent.
    pub bytes: Vec<u8>,
    /// The end was found from the back of the message, not by the layout.
    pub guessed: bool,
}

/// Depth of structures inside each other.
const MAX_DEPTH: usize = 4;

fn skip_property(r: &mut Reader<'_>, depth: usize) -> Result<(), ReadError> {
    let key = r.get::<u32>()?;
    match key {
        0x1000_0080 | 0x1000_0081 => r.bytes(8).map(drop),
        0x1000_0086..=0x1000_0089 => r.bytes(8).map(drop),
        0x1000_008A => r.bytes(5).map(drop),
        0x1000_007F => r.bytes(12).map(drop),
        0x1000_008D => {
            r.bytes(4)?;
            if r.get::<u8>()? == 1 {
                r.get::<WideText>()?;
            } else {
                r.bytes(8)?;
            }
            r.bytes(6).map(drop)
        }
        0x1000_008B | 0x1000_008C => {
            if depth == MAX_DEPTH {
                return Err(r.error(Problem::Depth));
            }
            let n = if key == 0x1000_008C {
                r.bytes(4)?;
                r.get::<u32>()? as usize
            } else {
                usize::from(r.get::<[u8; 2]>()?[1])
            };
            skip_properties(r.count(n, 4)?, r, depth + 1)
        }
        _ => Err(r.error(Problem::UnknownFlags(key))),
    }
}

fn skip_properties(n: usize, r: &mut Reader<'_>, depth: usize) -> Result<(), ReadError> {
    (0..n).try_for_each(|_| skip_property(r, depth))
}

/// Inventory and wielded objects, if they fill the rest of the message exactly.
fn fills(mut r: Reader<'_>) -> bool {
    let parsed = r.get::<List<ContentProfile>>().is_ok() && r.get::<List<Placement>>().is_ok();
    parsed && r.left() == 0
}

impl GameplayOptions {
    fn read(r: &mut Reader<'_>) -> Result<Self, ReadError> {
        let start = r.offset();
        let mut known = r.clone();
        let by_layout = known
            .get::<(u32, [u8; 2])>()
            .and_then(|(_, [_, n])| skip_properties(n.into(), &mut known, 0));
        let guessed = by_layout.is_err();
        if guessed {
            Self::find_end(r, known.error(Problem::Depth))?;
        } else {
            *r = known;
        }
        Ok(Self {
            bytes: r.since(start).to_vec(),
            guessed,
        })
    }

    /// Advances to the first aligned offset from which the last two lists end with the message. Only offsets whose first count could
    /// be true are tried, so that the work stays linear.
    fn find_end(r: &mut Reader<'_>, failure: ReadError) -> Result<(), ReadError> {
        r.align();
        while r.left() >= 8 {
            let left = r.left();
            let mut peek = r.clone();
            let n = peek.get::<u32>()? as usize;
            let second = n.checked_mul(8).filter(|&b| b + 8 <= left);
            if let Some(bytes) = second {
                peek.bytes(bytes)?;
                let m = peek.get::<u32>()? as usize;
                if m.checked_mul(12) == Some(peek.left()) && fills(r.clone()) {
                    return Ok(());
                }
            }
            r.bytes(4)?;
        }
        Err(failure)
    }
}

/// The player module: options of the interface.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct PlayerOptions {
    /// Presence bits, with those of the spell bars; the bits of the other fields follow the fields.
    pub bits: u32,
    /// First word of options.
    pub options: u32,
    /// Shortcuts.
    pub shortcuts: Option<List<Shortcut>>,
    /// Spell bars: 1, 5, 7 or 8 by the bits.
    pub spell_bars: Vec<List<u32>>,
    /// Wanted spell components.
    pub components: Option<Table<u32, i32>>,
    /// Filter of the spell book.
    pub spell_filters: Option<u32>,
    /// Second word of options.
    pub options2: Option<u32>,
    /// Format of time stamps.
    pub time_format: Option<Text>,
    /// Generic options.
    pub generic: Option<GenericOptions>,
    /// Window placements.
    pub gameplay: Option<GameplayOptions>,
}

impl PlayerOptions {
    const SHORTCUTS: u32 = 0x001;
    const COMPONENTS: u32 = 0x008;
    const FILTERS: u32 = 0x020;
    const OPTIONS2: u32 = 0x040;
    const TIME_FORMAT: u32 = 0x080;
    const GENERIC: u32 = 0x100;
    const GAMEPLAY: u32 = 0x200;
    const OWN: u32 = 0x3E9;

    const fn bars(bits: u32) -> usize {
        match bits {
            b if b & 0x4 != 0 => 5,
            b if b & 0x10 != 0 => 7,
            b if b & 0x400 != 0 => 8,
            _ => 1,
        }
    }
}

impl Wire for PlayerOptions {
    const MIN: usize = 12;

    fn read(r: &mut Reader<'_>) -> Result<Self, ReadError> {
        fn some<T: Wire>(has: bool, r: &mut Reader<'_>) -> Result<Option<T>, ReadError> {
            if has { r.get().map(Some) } else { Ok(None) }
        }
        let [bits, options] = r.get::<[u32; 2]>()?;
        let has = |bit: u32| bits & bit != 0;
        let shortcuts = some(has(Self::SHORTCUTS), r)?;
        let spell_bars = (0..Self::bars(bits))
            .map(|_| r.get())
            .collect::<Result<_, _>>()?;
        let read = Self {
            bits: bits & !Self::OWN,
            options,
            shortcuts,
            spell_bars,
            components: some(has(Self::COMPONENTS), r)?,
            spell_filters: some(has(Self::FILTERS), r)?,
            options2: some(has(Self::OPTIONS2), r)?,
            time_format: some(has(Self::TIME_FORMAT), r)?,
            generic: some(has(Self::GENERIC), r)?,
            gameplay: if has(Self::GAMEPLAY) {
                Some(GameplayOptions::read(r)?)
            } else {
                None
            },
        };
        r.align();
        Ok(read)
    }

    fn write(&self, w: &mut Writer) {
        let mut bits = self.bits & !Self::OWN;
        for (there, bit) in [
            (self.shortcuts.is_some(), Self::SHORTCUTS),
            (self.components.is_some(), Self::COMPONENTS),
            (self.spell_filters.is_some(), Self::FILTERS),
            (self.options2.is_some(), Self::OPTIONS2),
            (self.time_format.is_some(), Self::TIME_FORMAT),
            (self.generic.is_some(), Self::GENERIC),
            (self.gameplay.is_some(), Self::GAMEPLAY),
        ] {
            bits |= if there { bit } else { 0 };
        }
        fn put<T: Wire>(value: Option<&T>, w: &mut Writer) {
            if let Some(value) = value {
                value.write(w);
            }
        }
        [bits, self.options].write(w);
        put(self.shortcuts.as_ref(), w);
        let empty = List::default();
        for i in 0..Self::bars(bits) {
            self.spell_bars.get(i).unwrap_or(&empty).write(w);
        }
        put(self.components.as_ref(), w);
        put(self.spell_filters.as_ref(), w);
        put(self.options2.as_ref(), w);
        put(self.time_format.as_ref(), w);
        put(self.generic.as_ref(), w);
        if let Some(options) = &self.gameplay {
            w.put(&options.bytes);
        }
        w.align();
    }
}

/// Everything about the own character.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct PlayerDescription {
    /// Property bits that announce nothing.
    pub other_property_bits: u32,
    /// Weenie type.
    pub weenie_type: u32,
    /// Properties.
    pub properties: Properties,
    /// Vector bits that announce nothing.
    pub other_vector_bits: u32,
    /// Has health.
    pub has_health: u32,
    /// Attributes, skills, spells, enchantments.
    pub vectors: Vectors,
    /// Options of the interface.
    pub options: PlayerOptions,
    /// Inventory in display order.
    pub inventory: List<ContentProfile>,
    /// Wielded objects.
    pub wielded: List<Placement>,
}

impl Wire for PlayerDescription {
    const MIN: usize = 36;

    fn read(r: &mut Reader<'_>) -> Result<Self, ReadError> {
        let [property_flags, weenie_type] = r.get::<[u32; 2]>()?;
        let properties = Properties::read_fields([property_flags, 0], r)?;
        let [vector_flags, has_health] = r.get::<[u32; 2]>()?;
        Ok(Self {
            other_property_bits: property_flags & !Properties::KNOWN[0],
            weenie_type,
            properties,
            other_vector_bits: vector_flags & !Vectors::KNOWN[0],
            has_health,
            vectors: Vectors::read_fields([vector_flags, 0], r)?,
            options: r.get()?,
            inventory: r.get()?,
            wielded: r.get()?,
        })
    }

    fn write(&self, w: &mut Writer) {
        (self.properties.flags()[0] | self.other_property_bits).write(w);
        self.weenie_type.write(w);
        self.properties.write_fields(w);
        (self.vectors.flags()[0] | self.other_vector_bits).write(w);
        self.has_health.write(w);
        self.vectors.write_fields(w);
        self.options.write(w);
        self.inventory.write(w);
        self.wielded.write(w);
    }
}
