//! Animation (`spec/07-animation.md`, 16): sequences and motion tables made by hand, and scenes with a broken part.

use std::sync::Arc;

use ac_client::{
    animation::{
        AnimHookQueue, AnimationError, AnimationSource, MotionRequest, MotionTableError,
        MotionTableManager, Sequence,
    },
    dat::{
        AnimFrame, AnimRange, Animation, AnimationHook, HookAction, HookDirection, MotionBits,
        MotionData, MotionTable, Setup, StoredFrame,
    },
    math::{EPSILON, Frame, Vec3},
    physics::collision::GfxShape,
};
use ac_golden_traces::scene::Action;

use super::{
    super::{
        stage::{WALK, motion},
        trial::Trial,
        worlds::spots,
    },
    cases,
    transition::{play, stage},
};

cases! { "07";
    1 "rate·dt a hair below 1" => hair_below;
    2 "end exactly on the last frame" => exact_end;
    3 "4097 frames played down" => long_reverse;
    4 "very small quantum" => tiny_quantum;
    5 "small omega" => small_omega;
    6 "huge quantum" => huge_quantum;
    7 "infinite rate or time" => endless;
    8 "cycle of one frame" => one_frame;
    9 "low frame above the high one" => swapped_bounds;
    10 "speed 0" => speed_zero;
    11 "speed −0.0" => speed_negative_zero;
    12 "speed not a number" => speed_nan;
    13 "motion without animations" => no_animations;
    14 "missing animation" => missing_animation;
    15 "several ends of animations in one update" => several_done;
    16 "modifiers that install each other" => endless_table;
    17 "cycle that clears modifiers while they are put back" => clearing_cycle;
    18 "substate of the default style" => default_style;
    19 "style without default" => no_default;
    20 "action during a link" => action_in_link;
    21 "same substate while its link plays" => same_substate;
    22 "pose of more parts than there are" => too_many_parts;
}

const A: u32 = 0x0300_0001;
const B: u32 = 0x0300_0002;
const TABLE: u32 = 0x0900_0001;
const STYLE: u32 = 0x8000_003D;
const OTHER: u32 = 0x8000_003C;
const READY: u32 = 0x4100_0003;
const RUN: u32 = 0x4400_0007;
const TURN: u32 = 0x6500_000D;
const SIDE: u32 = 0x6500_000F;
const WAVE: u32 = 0x1000_0087;

/// Records by id.
#[derive(Default)]
struct Shelf {
    animations: Vec<Arc<Animation>>,
    table: Option<Arc<MotionTable>>,
}

impl AnimationSource for Shelf {
    fn animation(&mut self, id: u32) -> Option<Arc<Animation>> {
        self.animations.iter().find(|a| a.id == id).cloned()
    }
    fn motion_table(&mut self, _id: u32) -> Option<Arc<MotionTable>> {
        self.table.clone()
    }
    fn setup(&mut self, _id: u32) -> Option<Arc<Setup>> {
        None
    }
    fn shape(&mut self, _id: u32) -> Option<Arc<GfxShape>> {
        None
    }
}

/// An object that is nothing but its animation.
struct Puppet {
    shelf: Shelf,
    sequence: Sequence,
    manager: MotionTableManager,
    hooks: AnimHookQueue,
}

fn animation(id: u32, frames: u32, root: Option<Vec3>) -> Arc<Animation> {
    let mut animation = Animation::new(id, 0);
    for frame in 0..frames {
        let hook = AnimationHook {
            direction: HookDirection(0),
            action: HookAction::Sound { wave: frame },
        };
        let pose = AnimFrame {
            parts: Vec::new(),
            hooks: vec![hook],
        };
        animation.push(pose, root.map(StoredFrame::at));
    }
    Arc::new(animation)
}

impl Puppet {
    fn new(animations: Vec<Arc<Animation>>) -> Self {
        Self {
            shelf: Shelf {
                animations,
                table: None,
            },
            sequence: Sequence::new(),
            manager: MotionTableManager::default(),
            hooks: AnimHookQueue::new(),
        }
    }

    fn with_table(table: MotionTable, t: &Trial) -> Self {
        let mut puppet = Self::new(vec![animation(A, 4, None), animation(B, 6, None)]);
        puppet.shelf.table = Some(Arc::new(table));
        puppet.manager = MotionTableManager::new(TABLE, &mut puppet.shelf, &t.profile);
        puppet
            .manager
            .initialize_state(&mut puppet.sequence, &mut puppet.shelf, &t.profile);
        puppet
    }

    fn playing(frames: u32, rate: f32, t: &Trial) -> Self {
        let mut puppet = Self::new(vec![animation(A, frames, Some(Vec3::Y))]);
        puppet.append(A, 0, -1, rate, t);
        puppet
    }

    fn append(
        &mut self,
        animation: u32,
        low_frame: i32,
        high_frame: i32,
        framerate: f32,
        t: &Trial,
    ) {
        let range = AnimRange {
            animation,
            low_frame,
            high_frame,
            framerate,
        };
        self.sequence
            .append_animation(&range, &mut self.shelf, &t.profile);
    }

    fn update(&mut self, seconds: f64, t: &Trial) -> Result<Frame, AnimationError> {
        let mut offset = Frame::IDENTITY;
        self.sequence
            .update(seconds, Some(&mut offset), &mut self.hooks, &t.profile)?;
        Ok(offset)
    }

    fn play(&mut self, motion: u32, speed: f32, t: &Trial) -> Result<(), MotionTableError> {
        self.manager.perform(
            MotionRequest::Do { motion, speed },
            &mut self.sequence,
            &mut self.shelf,
            &t.profile,
        )
    }

    /// The frame number is inside the animation that plays.
    fn inside(&self) -> bool {
        self.sequence.current_node().is_none_or(|node| {
            (f64::from(node.low)..=f64::from(node.high) + 1.0)
                .contains(&self.sequence.frame_number())
        })
    }
}

/// Ready and run in one style, with a link, a wave, and two modifiers.
fn table() -> MotionTable {
    MotionTable::new(TABLE, STYLE)
        .with_style(STYLE, READY)
        .with_cycle(STYLE, READY, MotionData::playing(A, 0, -1, 10.0))
        .with_cycle(
            STYLE,
            RUN,
            MotionData::playing(B, 0, -1, 30.0).with_velocity(Vec3::Y),
        )
        .with_link(STYLE, READY, RUN, MotionData::playing(A, 0, 2, 30.0))
        .with_link(STYLE, RUN, READY, MotionData::playing(A, 0, 2, 30.0))
        .with_link(STYLE, READY, WAVE, MotionData::playing(B, 0, -1, 30.0))
        .with_modifier(
            TURN,
            MotionData::playing(A, 0, -1, 10.0).with_omega(Vec3::Z),
        )
}

fn hair_below(t: &mut Trial) {
    for rate in [25.0_f32, 29.0, 31.0, 43.0, 49.0, 50.0, 58.0] {
        let dt = f64::from(1.0 / rate);
        let mut puppet = Puppet::playing(10, rate, t);
        let done = puppet.update(dt, t);
        let crossed = f64::from(rate) * dt >= 1.0;
        t.promise(done.is_ok(), || format!("rate {rate}: {done:?}"));
        t.same("frame", puppet.sequence.current_frame(), i32::from(crossed));
        // A long run: at most one crossing is missing.
        for _ in 1..rate as u32 {
            let _ = puppet.update(dt, t);
        }
        t.promise(puppet.inside(), || {
            format!("frame {}", puppet.sequence.frame_number())
        });
    }
}

fn exact_end(t: &mut Trial) {
    let mut puppet = Puppet::playing(4, 8.0, t);
    puppet.append(A, 0, -1, 8.0, t);
    let done = puppet.update(0.5, t);
    t.promise(done.is_ok(), || format!("{done:?}"));
    t.same("frame number", puppet.sequence.frame_number(), 0.0);
}

fn long_reverse(t: &mut Trial) {
    for (frames, starts_beyond) in [(4096, false), (4097, true), (100_000, true)] {
        let mut puppet = Puppet::playing(frames, -10.0, t);
        let beyond = puppet.sequence.frame_number() >= f64::from(frames);
        t.same("the hair is lost", beyond, starts_beyond);
        for _ in 0..50 {
            let done = puppet.update(0.1, t);
            t.promise(done.is_ok() && puppet.inside(), || {
                format!("{done:?} at {}", puppet.sequence.frame_number())
            });
        }
    }
}

fn tiny_quantum(t: &mut Trial) {
    let mut puppet = Puppet::playing(4, 30.0, t);
    for seconds in [0.0, f64::MIN_POSITIVE, 1e-9, 1e-4] {
        let done = puppet.update(seconds, t);
        t.promise(done.is_ok() && puppet.inside(), || {
            format!("{seconds}: {done:?}")
        });
    }
    let mut standing = Puppet::playing(4, 0.0, t);
    standing.sequence.velocity = Vec3::X;
    let offset = standing.update(1e-5, t).unwrap_or_default();
    t.same("a standing cycle moves by", offset.origin, Vec3::ZERO);
}

fn small_omega(t: &mut Trial) {
    let mut puppet = Puppet::playing(4, 10.0, t);
    puppet.sequence.omega = Vec3::new(0.0, 0.0, EPSILON * 9.0);
    let offset = puppet.update(0.15, t).unwrap_or_default();
    t.same(
        "turn of a small omega",
        offset.rotation(),
        Frame::IDENTITY.rotation(),
    );
    puppet.sequence.omega = Vec3::new(0.0, 0.0, EPSILON * 11.0);
    let offset = puppet.update(0.1, t).unwrap_or_default();
    t.promise(offset.rotation() != Frame::IDENTITY.rotation(), || {
        "a larger one is lost too".into()
    });
}

fn huge_quantum(t: &mut Trial) {
    for seconds in [1.0, 10.0, 1000.0] {
        let mut puppet = Puppet::playing(4, 30.0, t);
        let done = puppet.update(seconds, t);
        t.promise(
            done.is_ok() || matches!(done, Err(AnimationError::TooManyHooks { .. })),
            || format!("{seconds} s: {done:?}"),
        );
        t.promise(puppet.inside(), || {
            format!("frame {}", puppet.sequence.frame_number())
        });
    }
}

fn endless(t: &mut Trial) {
    let mut puppet = Puppet::playing(4, 10.0, t);
    let done = puppet.update(f64::INFINITY, t);
    t.promise(done.is_err(), || "infinite time ends".into());
    let mut puppet = Puppet::playing(1, 1e30, t);
    let done = puppet.update(1.0, t);
    t.promise(done.is_err(), || "a rate of 1e30 ends".into());
    let mut puppet = Puppet::playing(4, f32::INFINITY, t);
    let done = puppet.update(0.1, t);
    t.promise(done.is_ok() || done.is_err(), || "it hangs".into());
}

fn one_frame(t: &mut Trial) {
    for rate in [1.0_f32, 30.0, 1e3, 1e4] {
        let mut puppet = Puppet::playing(1, rate, t);
        for _ in 0..20 {
            let done = puppet.update(0.1, t);
            t.promise(done.is_ok() && puppet.inside(), || {
                format!("rate {rate}: {done:?}")
            });
            puppet.hooks = AnimHookQueue::new();
        }
    }
}

fn swapped_bounds(t: &mut Trial) {
    for (low, high) in [
        (3, 1),
        (-5, 2),
        (9, 9),
        (0, 99),
        (i32::MAX, 0),
        (i32::MIN, i32::MIN),
    ] {
        for rate in [10.0, -10.0] {
            let mut puppet = Puppet::new(vec![animation(A, 4, None)]);
            puppet.append(A, low, high, rate, t);
            for _ in 0..30 {
                let done = puppet.update(0.1, t);
                t.promise(done.is_ok() && puppet.inside(), || {
                    format!(
                        "{low}..{high}: {done:?} at {}",
                        puppet.sequence.frame_number()
                    )
                });
            }
        }
    }
    let mut puppet = Puppet::playing(4, 10.0, t);
    puppet.sequence.multiply_cyclic_rate(-1.0);
    for _ in 0..30 {
        let done = puppet.update(0.1, t);
        // The bounds are the wrong way round: the guard of 8.10 ends it.
        let guarded = matches!(done, Err(AnimationError::Endless { .. }));
        t.promise(guarded || puppet.inside(), || {
            format!("reversed: {done:?} at {}", puppet.sequence.frame_number())
        });
    }
}

fn with_speed(t: &mut Trial, speed: f32) -> Puppet {
    let mut puppet = Puppet::with_table(table(), t);
    let answer = puppet.play(RUN, speed, t);
    t.promise(answer.is_ok(), || {
        format!("run with speed {speed}: {answer:?}")
    });
    for _ in 0..40 {
        let done = puppet.update(0.04, t);
        t.promise(done.is_ok(), || format!("speed {speed}: {done:?}"));
    }
    puppet
}

fn speed_zero(t: &mut Trial) {
    let mut puppet = with_speed(t, 0.0);
    // The link has rate 0 and blocks.
    t.promise(!puppet.sequence.plays_cycle(), || "the link ended".into());
    let answer = puppet.play(RUN, 1.5, t);
    t.promise(answer.is_ok(), || format!("{answer:?}"));
    let _ = puppet.update(1.0, t);
    t.promise(puppet.inside(), || {
        format!("frame {}", puppet.sequence.frame_number())
    });
}

fn speed_negative_zero(t: &mut Trial) {
    let puppet = with_speed(t, -0.0);
    t.promise(!puppet.sequence.plays_cycle() && puppet.inside(), || {
        "−0 is not positive".into()
    });
}

fn speed_nan(t: &mut Trial) {
    let mut puppet = Puppet::with_table(table(), t);
    let _ = puppet.play(RUN, f32::NAN, t);
    for _ in 0..40 {
        // Whatever it answers: it answers.
        let _ = puppet.update(0.04, t);
    }
    t.promise(puppet.play(READY, 1.0, t).is_ok(), || {
        "it cannot be stopped".into()
    });
}

fn no_animations(t: &mut Trial) {
    let table = table()
        .with_link(STYLE, RUN, WAVE, MotionData::default())
        .with_cycle(
            STYLE,
            0x4400_0009,
            MotionData::default().with_velocity(Vec3::X),
        );
    let mut puppet = Puppet::with_table(table, t);
    let answer = puppet.play(0x4400_0009, 1.0, t);
    t.promise(answer.is_ok(), || format!("{answer:?}"));
    let mut gone = Vec3::ZERO;
    for _ in 0..40 {
        gone += puppet.update(0.05, t).unwrap_or_default().origin;
    }
    t.promise(gone.is_finite(), || format!("went {gone}"));
}

fn missing_animation(t: &mut Trial) {
    let table = table()
        .with_link(
            STYLE,
            READY,
            0x4400_0009,
            MotionData::playing(0x0300_0099, 0, -1, 30.0),
        )
        .with_cycle(
            STYLE,
            0x4400_0009,
            MotionData::playing(0x0300_0098, 0, -1, 30.0),
        );
    let mut puppet = Puppet::with_table(table, t);
    let _ = puppet.play(0x4400_0009, 1.0, t);
    for _ in 0..20 {
        let done = puppet.update(0.05, t);
        t.promise(done.is_ok() && puppet.inside(), || format!("{done:?}"));
    }
    t.promise(puppet.play(READY, 1.0, t).is_ok(), || {
        "it cannot go back".into()
    });
}

fn several_done(t: &mut Trial) {
    let mut puppet = Puppet::with_table(table(), t);
    for motion in [WAVE, WAVE, RUN, WAVE, READY] {
        let _ = puppet.play(motion, 1.0, t);
    }
    let pending = puppet.manager.pending().len();
    t.promise(pending > 0, || "nothing is pending".into());
    let done = puppet.update(20.0, t);
    t.promise(done.is_ok() && puppet.inside(), || format!("{done:?}"));
}

fn endless_table(t: &mut Trial) {
    // Two cycles that are modifiers, without the bit that ends it.
    let turning = || MotionData::playing(A, 0, -1, 10.0).with_omega(Vec3::Z);
    let table = table()
        .with_cycle(STYLE, TURN, turning())
        .with_cycle(STYLE, SIDE, turning())
        .with_modifier(SIDE, turning());
    let mut puppet = Puppet::with_table(table, t);
    let mut refused = 0;
    for motion in [TURN, SIDE, RUN, TURN, SIDE, READY, SIDE, TURN] {
        refused += u32::from(puppet.play(motion, 1.0, t).is_err());
    }
    t.promise(refused <= 8, || format!("{refused} refusals"));
    t.promise(puppet.update(0.1, t).is_ok(), || "it cannot go on".into());
}

fn clearing_cycle(t: &mut Trial) {
    let clears = MotionData::playing(B, 0, -1, 30.0).with_bits(MotionBits::from_bits_retain(1));
    let table = table().with_cycle(STYLE, 0x4400_0009, clears);
    let mut puppet = Puppet::with_table(table, t);
    for motion in [TURN, 0x4400_0009, TURN, RUN, READY] {
        let _ = puppet.play(motion, 1.0, t);
        let done = puppet.update(0.1, t);
        t.promise(done.is_ok() && puppet.inside(), || format!("{done:?}"));
    }
}

fn default_style(t: &mut Trial) {
    let table = table()
        .with_style(OTHER, READY)
        .with_cycle(OTHER, READY, MotionData::playing(A, 0, -1, 10.0))
        .with_link(STYLE, READY, OTHER, MotionData::playing(A, 0, 1, 30.0));
    let mut puppet = Puppet::with_table(table, t);
    let _ = puppet.play(OTHER, 1.0, t);
    // The other style has no run of its own: the default style's is taken.
    let run = puppet.play(RUN, 1.0, t);
    let wave = puppet.play(WAVE, 1.0, t);
    t.promise(run.is_ok(), || format!("run: {run:?}"));
    t.promise(wave.is_err(), || {
        "an action of the default style is played".into()
    });
}

fn no_default(t: &mut Trial) {
    let table = table().with_cycle(OTHER, RUN, MotionData::playing(B, 0, -1, 30.0));
    let mut puppet = Puppet::with_table(table, t);
    let answer = puppet.play(OTHER, 1.0, t);
    t.promise(answer.is_err(), || {
        "a style without default is entered".into()
    });
    t.promise(puppet.update(0.1, t).is_ok() && puppet.inside(), || {
        "it cannot go on".into()
    });
}

fn action_in_link(t: &mut Trial) {
    let mut puppet = Puppet::with_table(table(), t);
    let _ = puppet.play(RUN, 1.0, t);
    let _ = puppet.update(0.02, t);
    let answer = puppet.play(WAVE, 1.0, t);
    for _ in 0..60 {
        let done = puppet.update(0.04, t);
        t.promise(done.is_ok() && puppet.inside(), || {
            format!("{answer:?}, {done:?}")
        });
    }
    t.promise(puppet.sequence.plays_cycle(), || "no cycle after it".into());
}

fn same_substate(t: &mut Trial) {
    let mut puppet = Puppet::with_table(table(), t);
    let _ = puppet.play(RUN, 1.0, t);
    let link = puppet.sequence.current_node().map(|node| node.rate);
    let answer = puppet.play(RUN, 2.0, t);
    t.promise(answer.is_ok(), || format!("{answer:?}"));
    t.same(
        "rate of the link",
        puppet.sequence.current_node().map(|node| node.rate),
        link,
    );
    let cycle = puppet.sequence.nodes().last().map(|node| node.rate);
    t.same("rate of the cycle", cycle, Some(60.0));
}

fn too_many_parts(t: &mut Trial) {
    let Some(play) = play(t) else { return };
    // The walker has one part; its animation has poses of one. A crate with the walker's table has a part for none of them.
    let run = t.scene(
        &stage(play, 60)
            .entity(play.ghost, spots::OPEN, |spec| {
                spec.motion_table = play.table;
                spec.kind = ac_golden_traces::scene::EntityKind::Creature;
            })
            .at(3, 0, motion(WALK, 1.0))
            .at(30, 0, Action::StopCompletely),
    );
    t.same("frames", run.frames(), 60);
}
