//! Game messages: the layouts of everything that is read or written, and the names of the rest (`spec/10-messages.md`).
//!
//! A message is an opcode and a body; game events and game actions are envelopes with an opcode of their own inside. [`ServerMessage`] and
//! [`ClientMessage`] read a message's bytes completely or not at all; bytes after a complete message are kept ([`Parsed::extra`]), messages
//! without a known layout are kept whole. Writing gives the bytes of the layouts; presence bits that a sender may choose are kept, so what
//! was read is written the same.

pub mod action;
pub mod chat;
pub mod common;
pub mod event;
pub mod movement;
pub mod names;
pub mod obj_desc;
pub mod object;
pub mod physics_desc;
pub mod player_description;
pub mod position;
pub mod property;
pub mod session;
pub mod weenie_desc;
pub mod wire;

#[cfg(test)]
mod tests;

use std::borrow::Cow;

pub use common::Text;
use common::{IfLeft, Rest};
pub use names::message_name;
pub use property::PropertyUpdate;
use wire::{ReadError, Reader, Wire, Writer};

/// Opcode of the envelope of a game event.
pub const GAME_EVENT: u32 = 0xF7B0;
/// Opcode of the envelope of a game action.
pub const GAME_ACTION: u32 = 0xF7B1;

/// Which way a message goes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Direction {
    /// From the server.
    ToClient,
    /// From the client.
    ToServer,
}

/// Why a message could not be read; it has no effect.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("message {name}: {error}")]
pub struct MessageError {
    /// Name of the message.
    pub name: Cow<'static, str>,
    /// What is wrong, and where.
    pub error: ReadError,
}

/// A message, and the bytes after it.
#[derive(Debug, Clone, PartialEq)]
pub struct Parsed<M> {
    /// The message.
    pub message: M,
    /// Bytes after the complete message: the message is valid all the same.
    pub extra: Vec<u8>,
}

/// Kinds of messages by opcode: an enum with a variant for each layout and one for all that have none.
macro_rules! messages {
    ($(#[$m:meta])* pub enum $name:ident, $names:expr; { $($code:literal => $variant:ident($t:ty)),* $(,)? }) => {
        $(#[$m])*
        #[derive(Debug, Clone, PartialEq)]
        #[allow(missing_docs, reason = "variants are named after their content")]
        pub enum $name {
            $($variant($t),)*
            /// A message whose layout is not read.
            Unread(u32, Rest),
        }

        impl $name {
            /// The number that says which message it is.
            pub const fn code(&self) -> u32 {
                match self {
                    $(Self::$variant(_) => $code,)*
                    Self::Unread(code, _) => *code,
                }
            }

            /// Name of the message.
            pub fn name(&self) -> Cow<'static, str> {
                let name: fn(u32) -> Cow<'static, str> = $names;
                name(self.code())
            }

            /// Reads the body that belongs to a number.
            ///
            /// # Errors
            /// Why the bytes are none.
            pub fn read_body(code: u32, r: &mut Reader<'_>) -> Result<Self, ReadError> {
                Ok(match code {
                    $($code => Self::$variant(r.get()?),)*
                    _ => Self::Unread(code, r.get()?),
                })
            }

            /// Appends the body.
            pub fn write_body(&self, w: &mut Writer) {
                match self {
                    $(Self::$variant(value) => value.write(w),)*
                    Self::Unread(_, rest) => rest.write(w),
                }
            }
        }
    };
}

messages! {
    /// What a game event says.
    pub enum GameEvent, names::event_name; {
        0x0004 => PopupString(Text),
        0x0013 => PlayerDescription(Box<player_description::PlayerDescription>),
        0x0021 => FriendsListUpdate(event::Friends),
        0x0022 => InventoryPutObjInContainer(event::PutInContainer),
        0x0023 => WieldObject([u32; 2]),
        0x0029 => CharacterTitle(event::CharacterTitles),
        0x0052 => CloseGroundContainer(u32),
        0x00A0 => InventoryServerSaveFailed([u32; 2]),
        0x00C9 => IdentifyObjectResponse(Box<event::Appraisal>),
        0x0147 => ChannelBroadcast(event::ChannelBroadcast),
        0x0196 => ViewContents(event::ViewContents),
        0x019A => InventoryPutObjectIn3D(u32),
        0x01A7 => AttackDone(u32),
        0x01B8 => CombatCommenceAttack(()),
        0x01C0 => UpdateHealth(event::UpdateHealth),
        0x01C7 => UseDone(u32),
        0x01EA => PingResponse(()),
        0x0274 => ConfirmationRequest(event::ConfirmationRequest),
        0x0276 => ConfirmationDone([u32; 2]),
        0x028A => WeenieError(u32),
        0x028B => WeenieErrorWithString(event::ErrorWithText),
        0x0295 => SetTurbineChatChannels([u32; 10]),
        0x02BD => Tell(event::TellFrom),
        0x02EB => TransientString(Text),
    }
}

messages! {
    /// What a game action says.
    pub enum GameAction, names::action_name; {
        0x0005 => SetSingleCharacterOption([u32; 2]),
        0x0008 => TargetedMeleeAttack(action::TargetedAttack),
        0x000A => TargetedMissileAttack(action::TargetedAttack),
        0x0015 => Talk(Text),
        0x0019 => PutItemInContainer(action::PutItemInContainer),
        0x001A => GetAndWieldItem([u32; 2]),
        0x001B => DropItem(u32),
        0x0032 => TalkDirect(action::TalkDirect),
        0x0035 => UseWithTarget([u32; 2]),
        0x0036 => Use(u32),
        0x0048 => CastUntargetedSpell(u32),
        0x004A => CastTargetedSpell([u32; 2]),
        0x0053 => ChangeCombatMode(u32),
        0x0054 => StackableMerge(action::StackableMerge),
        0x0055 => StackableSplitToContainer(action::StackableSplitToContainer),
        0x0056 => StackableSplitTo3D(action::StackableSplitTo3D),
        0x005D => Tell(action::TellTo),
        0x00A1 => LoginComplete(()),
        0x00C8 => IdentifyObject(u32),
        0x00CD => GiveObject(action::GiveObject),
        0x0147 => ChatChannel(action::ChatChannel),
        0x0195 => NoLongerViewingContents(u32),
        0x019B => StackableSplitToWield(action::StackableSplitToWield),
        0x01B7 => CancelAttack(()),
        0x01BF => QueryHealth(u32),
        0x01DF => Emote(Text),
        0x01E1 => SoulEmote(Text),
        0x01E9 => Ping(()),
        0x0275 => ConfirmationResponse(action::ConfirmationResponse),
        0xF61B => Jump(action::Jump),
        0xF61C => MoveToState(action::MoveToState),
        0xF61E => DoMovementCommand(action::DoMovementCommand),
        0xF661 => StopMovementCommand(action::StopMovementCommand),
        0xF752 => AutonomyLevel(u32),
        0xF753 => AutonomousPosition(action::AutonomousPosition),
        0xF7C9 => JumpNonAutonomous(f32),
    }
}

messages! {
    /// A plain message of the server.
    pub enum PlainServerMessage, |code| names::opcode_name(code, Direction::ToClient); {
        0x0024 => InventoryRemoveObject(object::Guid),
        0x0197 => SetStackSize(object::SetStackSize),
        0x019E => PlayerKilled(chat::PlayerKilled),
        0x01E0 => EmoteText(chat::EmoteText),
        0x01E2 => SoulEmote(chat::EmoteText),
        0x02BB => HearSpeech(chat::HearSpeech),
        0x02BC => HearRangedSpeech(chat::HearRangedSpeech),
        0xEA60 => AdminEnvirons(u32),
        0xF619 => PositionAndMovement(object::PositionAndMovement),
        0xF625 => ObjDescEvent(object::ObjDescEvent),
        0xF643 => CharacterResponse(session::CharacterResponse),
        0xF653 => LogOff(()),
        0xF655 => CharacterDeleted(()),
        0xF658 => CharacterList(session::CharacterList),
        0xF659 => CharacterError(u32),
        0xF745 => CreateObject(Box<object::ObjectDescription>),
        0xF746 => PlayerCreate(object::Guid),
        0xF747 => DeleteObject(object::DeleteObject),
        0xF748 => UpdatePosition(object::UpdatePosition),
        0xF749 => ParentEvent(object::ParentEvent),
        0xF74A => PickupEvent(object::PickupEvent),
        0xF74B => SetState(object::SetState),
        0xF74C => UpdateMotion(object::UpdateMotion),
        0xF74E => VectorUpdate(object::VectorUpdate),
        0xF750 => Sound(object::Sound),
        0xF751 => PlayerTeleport(object::PlayerTeleport),
        0xF752 => AutonomyLevel(object::AutonomyLevel),
        0xF753 => AutonomousPosition(object::ServerAutonomousPosition),
        0xF754 => PlayScriptId(object::PlayScriptId),
        0xF755 => PlayScript(object::PlayScript),
        0xF7C1 => AccountBanned(session::AccountBanned),
        0xF7DB => UpdateObject(Box<object::ObjectDescription>),
        0xF7DC => AccountBooted(IfLeft<Text>),
        0xF7DE => TurbineChat(chat::TurbineChat),
        0xF7DF => ServerReady(()),
        0xF7E0 => ServerText(chat::ServerText),
        0xF7E1 => ServerName(session::ServerName),
        0xF7E2 => DddData(session::DddData),
        0xF7E4 => DddError(session::DddError),
        0xF7E5 => DddInterrogation(session::DddInterrogation),
        0xF7E7 => DddBegin(session::DddBegin),
        0xF7EA => DddEnd(()),
    }
}

messages! {
    /// A plain message of the client.
    pub enum PlainClientMessage, |code| names::opcode_name(code, Direction::ToServer); {
        0xF653 => LogOff(IfLeft<u32>),
        0xF655 => DeleteCharacter(session::DeleteCharacter),
        0xF656 => CreateCharacter(session::CreateCharacter),
        0xF657 => EnterWorld(session::EnterWorld),
        0xF6EA => ForceObjectDescSend(u32),
        0xF7C8 => EnterWorldRequest(()),
        0xF7CC => GetServerVersion(()),
        0xF7D9 => RestoreCharacter(u32),
        0xF7DE => TurbineChat(chat::TurbineChat),
        0xF7E3 => DddRequestData([u32; 2]),
        0xF7E6 => DddInterrogationResponse(session::DddInterrogationResponse),
        0xF7EA => DddEnd(()),
    }
}

/// A message of the server.
#[derive(Debug, Clone, PartialEq)]
pub enum ServerMessage {
    /// A plain message.
    Plain(PlainServerMessage),
    /// A change of a property.
    Property(PropertyUpdate),
    /// A game event.
    Event {
        /// GUID of the player.
        guid: u32,
        /// +1 per event of the session.
        sequence: u32,
        /// What it says.
        event: GameEvent,
    },
}

/// A message of the client.
#[derive(Debug, Clone, PartialEq)]
pub enum ClientMessage {
    /// A plain message.
    Plain(PlainClientMessage),
    /// A game action.
    Action {
        /// +1 per action, from 1.
        sequence: u32,
        /// What it says.
        action: GameAction,
    },
}

fn parse<M>(
    bytes: &[u8],
    direction: Direction,
    read: impl FnOnce(&mut Reader<'_>) -> Result<M, ReadError>,
) -> Result<Parsed<M>, MessageError> {
    let mut r = Reader::new(bytes);
    match read(&mut r) {
        Ok(message) => Ok(Parsed {
            message,
            extra: r.rest().to_vec(),
        }),
        Err(error) => Err(MessageError {
            name: message_name(bytes, direction),
            error,
        }),
    }
}

impl ServerMessage {
    /// Reads a message from its bytes, the opcode first.
    ///
    /// # Errors
    /// The name of the message, the offset, and what is wrong there.
    pub fn parse(bytes: &[u8]) -> Result<Parsed<Self>, MessageError> {
        parse(bytes, Direction::ToClient, |r| {
            Ok(match r.get::<u32>()? {
                GAME_EVENT => {
                    let [guid, sequence, kind] = r.get::<[u32; 3]>()?;
                    let event = GameEvent::read_body(kind, r)?;
                    Self::Event {
                        guid,
                        sequence,
                        event,
                    }
                }
                opcode if PropertyUpdate::is_opcode(opcode) => {
                    Self::Property(PropertyUpdate::read(opcode, r)?)
                }
                opcode => Self::Plain(PlainServerMessage::read_body(opcode, r)?),
            })
        })
    }

    /// The message's bytes.
    pub fn to_bytes(&self) -> Vec<u8> {
        let mut w = Writer::default();
        match self {
            Self::Plain(message) => {
                message.code().write(&mut w);
                message.write_body(&mut w);
            }
            Self::Property(update) => {
                update.opcode().write(&mut w);
                update.write(&mut w);
            }
            Self::Event {
                guid,
                sequence,
                event,
            } => {
                [GAME_EVENT, *guid, *sequence, event.code()].write(&mut w);
                event.write_body(&mut w);
            }
        }
        w.bytes
    }

    /// Name of the message, or of the event in it.
    pub fn name(&self) -> Cow<'static, str> {
        match self {
            Self::Plain(message) => message.name(),
            Self::Property(update) => names::opcode_name(update.opcode(), Direction::ToClient),
            Self::Event { event, .. } => event.name(),
        }
    }

    /// Whether the message's layout is not read.
    pub const fn is_unread(&self) -> bool {
        matches!(
            self,
            Self::Plain(PlainServerMessage::Unread(..))
                | Self::Event {
                    event: GameEvent::Unread(..),
                    ..
                }
        )
    }

    /// Whether bits are set that no layout knows; such a message is to be reported (14.7).
    pub fn has_unknown_bits(&self) -> bool {
        use PlainServerMessage as P;
        let Self::Plain(message) = self else {
            return false;
        };
        match message {
            P::CreateObject(o) | P::UpdateObject(o) => o.weenie.unknown_header != 0,
            P::UpdatePosition(p) => p.position.unknown_bits() != 0,
            P::UpdateMotion(m) => m.movement.data.has_unknown_bits(),
            P::PositionAndMovement(m) => {
                m.position.unknown_bits() != 0 || m.movement.data.has_unknown_bits()
            }
            _ => false,
        }
    }
}

impl ClientMessage {
    /// Reads a message from its bytes, the opcode first.
    ///
    /// # Errors
    /// The name of the message, the offset, and what is wrong there.
    pub fn parse(bytes: &[u8]) -> Result<Parsed<Self>, MessageError> {
        parse(bytes, Direction::ToServer, |r| {
            Ok(match r.get::<u32>()? {
                GAME_ACTION => {
                    let [sequence, kind] = r.get::<[u32; 2]>()?;
                    let action = GameAction::read_body(kind, r)?;
                    Self::Action { sequence, action }
                }
                opcode => Self::Plain(PlainClientMessage::read_body(opcode, r)?),
            })
        })
    }

    /// The message's bytes.
    pub fn to_bytes(&self) -> Vec<u8> {
        let mut w = Writer::default();
        match self {
            Self::Plain(message) => {
                message.code().write(&mut w);
                message.write_body(&mut w);
            }
            Self::Action { sequence, action } => {
                [GAME_ACTION, *sequence, action.code()].write(&mut w);
                action.write_body(&mut w);
            }
        }
        w.bytes
    }

    /// Name of the message, or of the action in it.
    pub fn name(&self) -> Cow<'static, str> {
        match self {
            Self::Plain(message) => message.name(),
            Self::Action { action, .. } => action.name(),
        }
    }
}

/// Reads a message of either direction and answers with the number of extra bytes after it.
///
/// # Errors
/// As [`ServerMessage::parse`] and [`ClientMessage::parse`].
pub fn check(bytes: &[u8], direction: Direction) -> Result<usize, MessageError> {
    match direction {
        Direction::ToClient => ServerMessage::parse(bytes).map(|p| p.extra.len()),
        Direction::ToServer => ClientMessage::parse(bytes).map(|p| p.extra.len()),
    }
}
