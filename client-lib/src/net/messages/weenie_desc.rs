//! An object's public game description (`spec/10-messages.md`, 4.3).

use super::common::{IconDid, PackedU32, Table, Text};
use super::wire::{ReadError, Reader, Wire, Writer, optional_fields, wire_struct};

wire_struct! {
    /// Who may do what in a house.
    pub struct HouseRestrictions {
        /// Version.
        version: u32,
        /// Open to everybody.
        open: u32,
        /// Monarch.
        monarch: u32,
        /// Storage permission by GUID.
        guests: Table<u32, u32>,
    }
}

optional_fields! {
    /// The fields after the fixed part; in the order of the layout, which is not that of the bits.
    pub struct WeenieFields {
        /// Plural name.
        plural_name: Text = 0, 0x0000_0001;
        /// Items that fit in.
        items_capacity: u8 = 0, 0x0000_0002;
        /// Containers that fit in.
        containers_capacity: u8 = 0, 0x0000_0004;
        /// Ammunition type.
        ammunition: u16 = 0, 0x0000_0100;
        /// Value, pyreals.
        value: u32 = 0, 0x0000_0008;
        /// How it is used.
        usable: u32 = 0, 0x0000_0010;
        /// Use range, m.
        use_radius: f32 = 0, 0x0000_0020;
        /// What it can be used on.
        target_type: u32 = 0, 0x0008_0000;
        /// Effects in the interface.
        ui_effects: u32 = 0, 0x0000_0080;
        /// Use in combat.
        combat_use: u8 = 0, 0x0000_0200;
        /// Structure.
        structure: u16 = 0, 0x0000_0400;
        /// Maximum structure.
        max_structure: u16 = 0, 0x0000_0800;
        /// Stack size.
        stack_size: u16 = 0, 0x0000_1000;
        /// Maximum stack size.
        max_stack_size: u16 = 0, 0x0000_2000;
        /// GUID of the container.
        container: u32 = 0, 0x0000_4000;
        /// GUID of the wielder.
        wielder: u32 = 0, 0x0000_8000;
        /// Where it can be worn.
        valid_locations: u32 = 0, 0x0001_0000;
        /// Where it is worn.
        location: u32 = 0, 0x0002_0000;
        /// Order of clothing.
        priority: u32 = 0, 0x0004_0000;
        /// Colour on the radar.
        radar_colour: u8 = 0, 0x0010_0000;
        /// Behaviour on the radar.
        radar_behaviour: u8 = 0, 0x0080_0000;
        /// Physics script.
        script: u16 = 0, 0x0800_0000;
        /// Workmanship.
        workmanship: f32 = 0, 0x0100_0000;
        /// Burden.
        burden: u16 = 0, 0x0020_0000;
        /// Spell.
        spell: u16 = 0, 0x0040_0000;
        /// GUID of the house's owner.
        house_owner: u32 = 0, 0x0200_0000;
        /// Who may do what in the house.
        restrictions: HouseRestrictions = 0, 0x0400_0000;
        /// Item types of a hook.
        hook_item_types: u32 = 0, 0x2000_0000;
        /// Monarch.
        monarch: u32 = 0, 0x0000_0040;
        /// Type of hook.
        hook_type: u16 = 0, 0x1000_0000;
        /// Icon over the icon.
        icon_overlay: IconDid = 0, 0x4000_0000;
        /// Icon under the icon.
        icon_underlay: IconDid = 1, 0x1;
        /// Material.
        material: u32 = 0, 0x8000_0000;
        /// Cooldown group.
        cooldown: u32 = 1, 0x2;
        /// Cooldown, s.
        cooldown_duration: f64 = 1, 0x4;
        /// GUID of the pet's owner.
        pet_owner: u32 = 1, 0x8;
    }
}

/// Bits of an object that physics looks at.
#[allow(missing_docs, reason = "names of the field")]
pub mod object_bits {
    pub const PLAYER: u32 = 0x8;
    pub const ATTACKABLE: u32 = 0x10;
    pub const PLAYER_KILLER: u32 = 0x20;
    pub const DOOR: u32 = 0x1000;
    pub const CORPSE: u32 = 0x2000;
    pub const FREE_PK: u32 = 0x20_0000;
    pub const PK_LITE: u32 = 0x200_0000;
    pub const SECOND_HEADER: u32 = 0x400_0000;
}

/// An object's public game description, as sent.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct WeenieDesc {
    /// Name.
    pub name: Text,
    /// Weenie class id.
    pub class: PackedU32,
    /// Icon.
    pub icon: IconDid,
    /// Item type word.
    pub item_type: u32,
    /// What the object is ([`object_bits`]); the bit of the second header is set by itself when a field needs it.
    pub object_bits: u32,
    /// Bits of the second header that no layout knows: what they announce is in the message's extra bytes.
    pub unknown_header: u32,
    /// The other fields.
    pub fields: WeenieFields,
}

impl Wire for WeenieDesc {
    const MIN: usize = 24;

    fn read(r: &mut Reader<'_>) -> Result<Self, ReadError> {
        let header = r.get::<u32>()?;
        let (name, class, icon) = (r.get()?, r.get()?, r.get()?);
        let [item_type, object_bits] = r.get::<[u32; 2]>()?;
        r.align();
        let second = match object_bits & object_bits::SECOND_HEADER {
            0 => 0,
            _ => r.get::<u32>()?,
        };
        let fields = WeenieFields::read_fields([header, second], r)?;
        r.align();
        Ok(Self {
            name,
            class,
            icon,
            item_type,
            object_bits,
            unknown_header: second & !WeenieFields::KNOWN[1],
            fields,
        })
    }

    fn write(&self, w: &mut Writer) {
        let [header, second] = self.fields.flags();
        let second = second | self.unknown_header;
        let mut bits = self.object_bits;
        if second != 0 {
            bits |= object_bits::SECOND_HEADER;
        }
        header.write(w);
        self.name.write(w);
        self.class.write(w);
        self.icon.write(w);
        [self.item_type, bits].write(w);
        w.align();
        if bits & object_bits::SECOND_HEADER != 0 {
            second.write(w);
        }
        self.fields.write_fields(w);
        w.align();
    }
}
