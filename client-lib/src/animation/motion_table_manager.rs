//! Bookkeeping of unfinished motions (`spec/07-animation.md`, 12; retail `MotionTableManager`).

use std::collections::VecDeque;
use std::sync::Arc;

use super::error::MotionTableError;
use super::motion_class::{ACTION, MODIFIER, READY, STYLE, SUBSTATE, has};
use super::motion_player::MotionPlayer;
use super::motion_state::MotionState;
use super::sequence::Sequence;
use super::source::AnimationSource;
use crate::dat::MotionTable;
use crate::profile::{MissingTables, Profile};

/// A motion that is not reported done yet.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct PendingMotion {
    /// Motion command; Ready for every stop.
    pub motion: u32,
    /// Animations that must end first (`num_anims`). `u32::MAX`: it never completes by itself.
    pub animations: u32,
    /// Tells entries apart that look alike.
    pub(crate) serial: u64,
}

/// What a motion table is asked to do (`PerformMovement`, types 2, 4 and 5).
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum MotionRequest {
    /// Start a motion.
    Do {
        /// Motion command.
        motion: u32,
        /// Factor on rates and velocities.
        speed: f32,
    },
    /// Stop a motion.
    Stop {
        /// Motion command.
        motion: u32,
    },
    /// Stop everything.
    StopCompletely,
}

/// The motion table of an object, what it is doing, and the motions that wait for their animations to end.
#[derive(Debug, Clone, Default)]
pub struct MotionTableManager {
    pub(crate) table: Option<Arc<MotionTable>>,
    /// What is being done.
    pub state: MotionState,
    /// Animations that ended since the head of the queue was reached.
    pub animation_counter: u32,
    /// Motions that are not reported done yet, oldest first.
    pub(crate) pending: VecDeque<PendingMotion>,
    pub(crate) next_serial: u64,
}

impl MotionTableManager {
    /// A manager for a table; without the table every command is refused (`N-18`).
    pub fn new(id: u32, source: &mut dyn AnimationSource, profile: &Profile) -> Self {
        let missing = || match profile.missing_tables {
            MissingTables::Absent => None,
            MissingTables::Empty => Some(Arc::new(MotionTable::new(0, 0))),
        };
        Self {
            table: source.motion_table(id).or_else(missing),
            ..Self::default()
        }
    }

    /// Id of the loaded table; 0 if it is missing.
    pub fn table_id(&self) -> u32 {
        self.table.as_ref().map_or(0, |t| t.id)
    }

    /// Motions that are not reported done yet, oldest first.
    pub fn pending(&self) -> impl ExactSizeIterator<Item = &PendingMotion> {
        self.pending.iter()
    }

    /// Replaces the queue by (motion, animations) pairs, oldest first: for state that was stored.
    pub fn set_pending(&mut self, entries: impl IntoIterator<Item = (u32, u32)>) {
        self.pending.clear();
        for (motion, animations) in entries {
            self.push(motion, animations);
        }
    }

    fn push(&mut self, motion: u32, animations: u32) {
        let serial = self.next_serial;
        self.next_serial += 1;
        self.pending.push_back(PendingMotion {
            motion,
            animations,
            serial,
        });
    }

    /// Carries a request out on the sequence and queues it.
    ///
    /// # Errors
    /// No table, no such motion in the present state, or a table on which the references recurse for ever.
    pub fn perform(
        &mut self,
        request: MotionRequest,
        sequence: &mut Sequence,
        source: &mut dyn AnimationSource,
        profile: &Profile,
    ) -> Result<(), MotionTableError> {
        let table = self
            .table
            .as_deref()
            .ok_or(MotionTableError::NoAnimationTable)?;
        let mut player = MotionPlayer::new(table, &mut self.state, sequence, source, profile);
        let (queued_as, answer) = match request {
            MotionRequest::Do { motion, speed } => (motion, player.play(motion, speed, false)),
            MotionRequest::Stop { motion } => (READY, player.stop(motion)),
            MotionRequest::StopCompletely => (READY, Some(player.stop_completely().unwrap_or(0))),
        };
        let endless = player.is_endless();
        let table = table.id;
        if let Some(animations) = answer {
            self.add_to_queue(queued_as, animations, sequence);
        }
        if endless {
            return Err(MotionTableError::Endless { table });
        }
        answer.map(|_| ()).ok_or(MotionTableError::NoMotionData)
    }

    /// Starts the default motion and queues Ready. What is pending stays.
    pub fn initialize_state(
        &mut self,
        sequence: &mut Sequence,
        source: &mut dyn AnimationSource,
        profile: &Profile,
    ) {
        let animations = self.table.as_deref().and_then(|table| {
            MotionPlayer::new(table, &mut self.state, sequence, source, profile).set_default_state()
        });
        self.add_to_queue(READY, animations.unwrap_or(0), sequence);
    }

    fn add_to_queue(&mut self, motion: u32, animations: u32, sequence: &mut Sequence) {
        self.push(motion, animations);
        self.remove_redundant_links(sequence);
    }

    /// If the newest motions repeat an earlier one that is not finished, drops the links in between (12.3).
    fn remove_redundant_links(&mut self, sequence: &mut Sequence) {
        for newest in (0..self.pending.len()).rev() {
            let Some(entry) = self.pending.get(newest).copied() else {
                return;
            };
            if entry.animations == 0 {
                continue;
            }
            match self.find_repeated(newest, entry) {
                Scan::Found(earlier) => return self.truncate(earlier, sequence),
                Scan::Blocked => return,
                Scan::Nothing => {}
            }
        }
    }

    /// Looks for an earlier entry that `entry`, at `index`, repeats.
    fn find_repeated(&self, index: usize, entry: PendingMotion) -> Scan {
        let pure_substate = has(entry.motion, SUBSTATE) && !has(entry.motion, MODIFIER);
        if !pure_substate && !has(entry.motion, STYLE) {
            // An unfinished action or modifier blocks everything.
            return Scan::Blocked;
        }
        let blocking = if pure_substate {
            STYLE | MODIFIER | ACTION
        } else {
            SUBSTATE | MODIFIER | ACTION
        };
        for (i, earlier) in self.pending.iter().enumerate().take(index).rev() {
            let unfinished = earlier.animations != 0;
            if earlier.motion == entry.motion && (unfinished || !pure_substate) {
                return Scan::Found(i);
            }
            if unfinished && has(earlier.motion, blocking) {
                return Scan::Blocked;
            }
        }
        Scan::Nothing
    }

    /// Drops the links of all entries after `position`; they complete at the next check.
    fn truncate(&mut self, position: usize, sequence: &mut Sequence) {
        let mut total = 0_u32;
        for entry in self.pending.iter_mut().skip(position + 1) {
            total = total.wrapping_add(entry.animations);
            entry.animations = 0;
        }
        sequence.remove_link_animations(total);
    }
}

enum Scan {
    Found(usize),
    Blocked,
    Nothing,
}
