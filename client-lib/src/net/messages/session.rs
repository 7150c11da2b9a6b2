//! Messages of the login phase (`spec/09-network.md`, 11.6).

use super::common::{IfLeft, List, Rest, Text};
use super::wire::{ReadError, Reader, Wire, Writer, wire_struct};

wire_struct! {
    /// A character of an account.
    pub struct CharacterEntry {
        /// GUID.
        guid: u32,
        /// Name.
        name: Text,
        /// Seconds until deletion; 0: not being deleted.
        deletion: u32,
    }

    /// The character list.
    pub struct CharacterList {
        /// 0.
        status: u32,
        /// Characters.
        characters: List<CharacterEntry>,
        /// Deleted ones; servers send none.
        deleted: List<CharacterEntry>,
        /// Slots of the account.
        slots: u32,
        /// Account, in the server's spelling.
        account: Text,
        /// Turbine chat is used.
        turbine_chat: u32,
        /// 1.
        expansion: u32,
    }

    /// The server's name.
    pub struct ServerName {
        /// Players online.
        connections: i32,
        /// Most that can be; −1 unknown.
        maximum: i32,
        /// Name.
        name: Text,
    }

    /// DDD interrogation.
    pub struct DddInterrogation {
        /// Region.
        region: u32,
        /// Language of the name rules.
        name_rules: u32,
        /// Product.
        product: u32,
        /// Languages.
        languages: List<u32>,
    }

    /// What a client has of one file.
    pub struct FileIterations {
        /// File type.
        file_type: i32,
        /// File id.
        file_id: i32,
        /// Iterations.
        iterations: IntSet,
    }

    /// DDD interrogation response. Retail appends a second list and flags: extra bytes.
    pub struct DddInterrogationResponse {
        /// Language.
        language: u32,
        /// Files.
        files: List<FileIterations>,
    }

    /// A file to be patched.
    pub struct DddFile {
        /// File type.
        file_type: i32,
        /// File id.
        file_id: i32,
        /// Iteration.
        iteration: i32,
        /// Records to download.
        download: List<u32>,
        /// Records to purge.
        purge: List<u32>,
    }

    /// Begin of a patch.
    pub struct DddBegin {
        /// Bytes that will come.
        bytes: u32,
        /// Files.
        files: List<DddFile>,
    }

    /// A record of a patch.
    pub struct DddData {
        /// File type and id.
        file: [i32; 2],
        /// Record type and id.
        record: [u32; 2],
        /// Iteration.
        iteration: i32,
        /// Compressed.
        compressed: u8,
        /// 3.
        version: u32,
        /// Length + 4.
        length: u32,
        /// Content.
        data: Rest,
    }

    /// DDD error: type, id, error.
    #[derive(Copy, Eq)]
    pub struct DddError {
        /// Type, id, error.
        words: [u32; 3],
    }

    /// Enter world.
    pub struct EnterWorld {
        /// Character.
        guid: u32,
        /// Account, in the server's spelling.
        account: Text,
    }

    /// Account banned.
    pub struct AccountBanned {
        /// Seconds.
        seconds: u32,
        /// Why; may be absent.
        reason: IfLeft<Text>,
    }

    /// Delete character, from the client.
    pub struct DeleteCharacter {
        /// Account.
        account: Text,
        /// Slot in the list.
        slot: i32,
    }

    /// Answer to creating or restoring a character.
    pub struct CharacterResponse {
        /// 1: ok.
        code: u32,
        /// The character, if ok.
        character: IfLeft<CharacterEntry>,
    }

    /// Create character: the creation data is kept as bytes.
    pub struct CreateCharacter {
        /// Account.
        account: Text,
        /// Creation data.
        data: Rest,
    }
}

/// A set of integers: entries −k cover k − 1 further integers, any other entry covers one.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct IntSet {
    /// Integers that the set covers.
    pub covered: i32,
    /// As sent.
    pub entries: Vec<i32>,
}

impl Wire for IntSet {
    const MIN: usize = 4;

    fn read(r: &mut Reader<'_>) -> Result<Self, ReadError> {
        let covered = r.get::<i32>()?;
        let (mut entries, mut left) = (Vec::new(), i64::from(covered));
        while left > 0 {
            let entry = r.get::<i32>()?;
            let covers = if entry < 0 { -i64::from(entry) - 1 } else { 1 };
            // An entry of -1 covers nothing: an endless set of them ends with the message.
            left -= covers;
            entries.push(entry);
        }
        Ok(Self { covered, entries })
    }

    fn write(&self, w: &mut Writer) {
        self.covered.write(w);
        self.entries.iter().for_each(|e| e.write(w));
    }
}
