//! Speed of the animation layer: a quantum of an idle cycle and of a walk, placing parts, and a motion command.

use std::hint::black_box;
use std::sync::Arc;

use ac_client::animation::{AnimSequenceNode, AnimationSource, MotionRequest, PartArray, Sequence};
use ac_client::dat::{
    AnimFrame, AnimRange, Animation, MotionData, MotionTable, Setup, StoredFrame, motion_key,
};
use ac_client::math::{Frame, Quat, Vec3};
use ac_client::physics::collision::GfxShape;
use ac_client::profile::Profile;
use criterion::{Criterion, criterion_group, criterion_main};

const SETUP: u32 = 0x0200_0001;
const SHAPE: u32 = 0x0100_0001;
const IDLE: u32 = 0x0300_0001;
const WALK_ANIMATION: u32 = 0x0300_0002;
const LINK: u32 = 0x0300_0003;
const TABLE: u32 = 0x0900_0001;
const STYLE: u32 = 0x8000_003D;
const READY: u32 = 0x4100_0003;
const WALK: u32 = 0x4500_0005;
/// Parts of a humanoid.
const PARTS: usize = 34;
const QUANTUM: f64 = 0.04;

/// The records of a humanoid.
struct Records {
    animations: Vec<Arc<Animation>>,
    table: Arc<MotionTable>,
    setup: Arc<Setup>,
    shape: Arc<GfxShape>,
}

impl AnimationSource for Records {
    fn animation(&mut self, id: u32) -> Option<Arc<Animation>> {
        self.animations.iter().find(|a| a.id == id).cloned()
    }

    fn motion_table(&mut self, _id: u32) -> Option<Arc<MotionTable>> {
        Some(Arc::clone(&self.table))
    }

    fn setup(&mut self, _id: u32) -> Option<Arc<Setup>> {
        Some(Arc::clone(&self.setup))
    }

    fn shape(&mut self, _id: u32) -> Option<Arc<GfxShape>> {
        Some(Arc::clone(&self.shape))
    }
}

fn part_frame(i: usize) -> StoredFrame {
    StoredFrame {
        origin: Vec3::new(i as f32, 1.0, 0.5),
        rotation: Quat::new(0.8, 0.0, 0.6, 0.0),
    }
}

fn animation(id: u32, frames: usize, root: Option<StoredFrame>) -> Arc<Animation> {
    let mut animation = Animation::new(id, PARTS as u32);
    for _ in 0..frames {
        let pose = AnimFrame {
            parts: (0..PARTS).map(part_frame).collect(),
            hooks: Vec::new(),
        };
        animation.push(pose, root);
    }
    Arc::new(animation)
}

fn range(animation: u32, framerate: f32) -> AnimRange {
    AnimRange {
        animation,
        low_frame: 0,
        high_frame: -1,
        framerate,
    }
}

fn motion(animation: u32, framerate: f32) -> MotionData {
    MotionData {
        anims: vec![range(animation, framerate)],
        ..MotionData::default()
    }
}

fn records() -> Records {
    let root = StoredFrame::at(Vec3::new(0.0, 0.1, 0.0));
    let mut table = MotionTable::new(TABLE, STYLE);
    table.style_defaults = std::iter::once((STYLE, READY)).collect();
    table.cycles = [
        (motion_key(STYLE, READY), motion(IDLE, 30.0)),
        (motion_key(STYLE, WALK), motion(WALK_ANIMATION, 30.0)),
    ]
    .into_iter()
    .collect();
    let link = |from, to| {
        let targets = std::iter::once((to, motion(LINK, 30.0))).collect();
        (motion_key(STYLE, from), targets)
    };
    table.links = [link(READY, WALK), link(WALK, READY)].into_iter().collect();
    let mut setup = Setup::empty(SETUP);
    setup.parts = vec![SHAPE; PARTS];
    Records {
        animations: vec![
            animation(IDLE, 60, None),
            animation(WALK_ANIMATION, 24, Some(root)),
            animation(LINK, 8, Some(root)),
        ],
        table: Arc::new(table),
        setup: Arc::new(setup),
        shape: Arc::new(GfxShape::default()),
    }
}

fn humanoid(records: &mut Records, profile: &Profile) -> PartArray {
    let mut parts = PartArray::with_setup(SETUP, records, profile).expect("the setup exists");
    parts.set_motion_table(TABLE, records, profile);
    parts.initialize_motion_tables(records, profile);
    parts
}

fn sequence_of(node: AnimSequenceNode) -> Sequence {
    Sequence::from_state([node], Some(0), 0.0, Vec3::new(0.0, 3.0, 0.0), Vec3::ZERO)
}

fn benches(c: &mut Criterion) {
    let profile = Profile::retail();
    let mut records = records();
    let mut hooks = Vec::new();

    let mut update = |name: &str, id: u32, rate: f32| {
        let node = AnimSequenceNode::new(&range(id, rate), &mut records, &profile);
        let mut sequence = sequence_of(node.expect("the animation exists"));
        c.bench_function(name, |b| {
            b.iter(|| {
                let mut offset = Frame::IDENTITY;
                let result = sequence.update(QUANTUM, Some(&mut offset), &mut hooks, &profile);
                black_box(result.is_ok());
                black_box(offset)
            });
        });
    };
    update("sequence/update/idle cycle", IDLE, 30.0);
    update("sequence/update/idle, no frame crossed", IDLE, 0.001);
    update("sequence/update/walk cycle", WALK_ANIMATION, 30.0);

    let mut parts = humanoid(&mut records, &profile);
    let at = Frame::new(Vec3::new(10.0, 20.0, 30.0), Quat::new(0.6, 0.0, 0.0, 0.8));
    c.bench_function("part array/update parts/34 parts", |b| {
        b.iter(|| parts.update_parts(black_box(&at), &profile));
    });

    c.bench_function("motion table/walk and stop, both completed", |b| {
        b.iter(|| {
            for request in [
                MotionRequest::Do {
                    motion: WALK,
                    speed: 1.0,
                },
                MotionRequest::Stop { motion: WALK },
            ] {
                let answer = parts.perform_motion(request, &mut records, &profile);
                black_box(answer.is_ok());
                let mut run = parts.handle_enter_world();
                while parts.next_completion(&mut run).is_some() {}
            }
        });
    });
}

criterion_group!(group, benches);
criterion_main!(group);
