//! Game events (`spec/10-messages.md`, 8.1).

use super::common::{List, Table, Text};
use super::player_description::ContentProfile;
use super::wire::{ReadError, Reader, Wire, Writer, optional_fields, wire_struct};

wire_struct! {
    /// InventoryPutObjInContainer.
    #[derive(Copy, Eq)]
    pub struct PutInContainer {
        /// Item.
        item: u32,
        /// Container.
        container: u32,
        /// Slot.
        slot: u32,
        /// 0 item, 1 container, 2 foci.
        kind: u32,
    }

    /// ViewContents.
    pub struct ViewContents {
        /// Container.
        container: u32,
        /// What is in it.
        contents: List<ContentProfile>,
    }

    /// UpdateHealth.
    #[derive(Copy)]
    pub struct UpdateHealth {
        /// Object.
        guid: u32,
        /// 0..1.
        fraction: f32,
    }

    /// WeenieErrorWithString.
    pub struct ErrorWithText {
        /// Code.
        code: u32,
        /// What it is about.
        text: Text,
    }

    /// Tell.
    pub struct TellFrom {
        /// What is said.
        text: Text,
        /// Who says it.
        sender: Text,
        /// Their GUID.
        sender_guid: u32,
        /// To whom.
        target_guid: u32,
        /// Chat type.
        kind: u32,
        /// 0.
        zero: u32,
    }

    /// ChannelBroadcast; no sender: oneself.
    pub struct ChannelBroadcast {
        /// Channel.
        channel: u32,
        /// Who says it.
        sender: Text,
        /// What is said.
        text: Text,
    }

    /// ConfirmationRequest.
    pub struct ConfirmationRequest {
        /// Kind of question.
        kind: u32,
        /// Which question.
        context: u32,
        /// The question.
        text: Text,
    }

    /// CharacterTitle.
    pub struct CharacterTitles {
        /// 1.
        one: u32,
        /// Present title.
        current: u32,
        /// All titles.
        titles: List<u32>,
    }

    /// A friend.
    pub struct Friend {
        /// GUID.
        guid: u32,
        /// Online.
        online: u32,
        /// Shown offline.
        appears_offline: u32,
        /// Name.
        name: Text,
        /// Friends of theirs.
        friends: List<u32>,
        /// Who has them as a friend.
        friend_of: List<u32>,
    }

    /// FriendsListUpdate.
    pub struct Friends {
        /// Friends.
        friends: List<Friend>,
        /// Kind of update.
        kind: u32,
    }

    /// The weapon of an appraisal.
    #[derive(Copy)]
    pub struct WeaponProfile {
        /// Damage type, speed, skill, damage.
        words: [u32; 4],
        /// Variance, modifiers, power.
        numbers: [f64; 5],
        /// Maximum velocity estimated.
        last: u32,
    }
}

/// The creature of an appraisal.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct CreatureProfile {
    /// Presence bits.
    pub flags: u32,
    /// Health and its maximum.
    pub health: [u32; 2],
    /// Attributes, if bit 8 is set.
    pub attributes: [u32; 10],
    /// Highlighting, if bit 1 is set.
    pub highlight: [u16; 2],
}

impl Wire for CreatureProfile {
    const MIN: usize = 12;
    fn read(r: &mut Reader<'_>) -> Result<Self, ReadError> {
        let (flags, health) = r.get::<(u32, [u32; 2])>()?;
        Ok(Self {
            flags,
            health,
            attributes: if flags & 8 != 0 { r.get()? } else { [0; 10] },
            highlight: if flags & 1 != 0 { r.get()? } else { [0; 2] },
        })
    }
    fn write(&self, w: &mut Writer) {
        self.flags.write(w);
        self.health.write(w);
        if self.flags & 8 != 0 {
            self.attributes.write(w);
        }
        if self.flags & 1 != 0 {
            self.highlight.write(w);
        }
    }
}

optional_fields! {
    /// What an appraisal tells.
    pub struct AppraisalFields {
        /// Ints.
        ints: Table<u32, i32> = 0, 0x0001;
        /// 64-bit ints.
        int64s: Table<u32, i64> = 0, 0x2000;
        /// Bools.
        bools: Table<u32, u32> = 0, 0x0002;
        /// Floats.
        floats: Table<u32, f64> = 0, 0x0004;
        /// Texts.
        texts: Table<u32, Text> = 0, 0x0008;
        /// Data ids.
        data_ids: Table<u32, u32> = 0, 0x1000;
        /// Spells.
        spells: List<u32> = 0, 0x0010;
        /// Armour.
        armour: [f32; 8] = 0, 0x0080;
        /// Creature.
        creature: CreatureProfile = 0, 0x0100;
        /// Weapon.
        weapon: WeaponProfile = 0, 0x0020;
        /// Hook.
        hook: [u32; 3] = 0, 0x0040;
        /// Highlighting of armour.
        armour_highlight: [u16; 2] = 0, 0x0200;
        /// Highlighting of a weapon.
        weapon_highlight: [u16; 2] = 0, 0x0800;
        /// Highlighting of resistances.
        resistance_highlight: [u16; 2] = 0, 0x0400;
        /// Armour levels.
        armour_levels: [u32; 9] = 0, 0x4000;
    }
}

/// IdentifyObjectResponse.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Appraisal {
    /// Object.
    pub guid: u32,
    /// Bits that announce nothing known; what follows them is extra.
    pub other_bits: u32,
    /// 0: failed.
    pub success: u32,
    /// What it tells.
    pub fields: AppraisalFields,
}

impl Wire for Appraisal {
    const MIN: usize = 12;
    fn read(r: &mut Reader<'_>) -> Result<Self, ReadError> {
        let [guid, flags, success] = r.get::<[u32; 3]>()?;
        Ok(Self {
            guid,
            other_bits: flags & !AppraisalFields::KNOWN[0],
            success,
            fields: AppraisalFields::read_fields([flags, 0], r)?,
        })
    }
    fn write(&self, w: &mut Writer) {
        let flags = self.fields.flags()[0] | self.other_bits;
        [self.guid, flags, self.success].write(w);
        self.fields.write_fields(w);
    }
}
