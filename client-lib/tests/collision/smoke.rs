//! Spheres moved at random through random soups under every profile: nothing panics, nothing takes unbounded steps, and every run
//! gives the same bits again.

use ac_client::math::{Sphere, Vec3};
use ac_client::physics::collision::{CylSphere, GfxShape, PlacedPart, find_part_collisions};
use ac_client::physics::transition::{InsertType, ObjectInfoState, TransitionState};
use ac_client::profile::Profile;
use ac_client::world::World;

use crate::soup::tree;
use crate::support::{Mover, at, records};

/// Attempts of a caller before it gives up; no obstacle may need more to be asked than the caller grants.
const ATTEMPTS: usize = 30;

/// xorshift: the same numbers everywhere.
struct Random(u64);

impl Random {
    fn next(&mut self) -> u64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        self.0
    }

    fn unit(&mut self) -> f32 {
        (self.next() >> 40) as f32 / (1_u64 << 24) as f32
    }

    fn vector(&mut self, reach: f32) -> Vec3 {
        let mut one = || (self.unit() - 0.5) * 2.0 * reach;
        Vec3::new(one(), one(), one())
    }

    fn polygon(&mut self) -> Vec<Vec3> {
        let center = self.vector(2.0);
        let n = 3 + (self.next() % 4) as usize;
        // Not flat, not convex, sometimes with repeated corners: what a broken file may hold.
        let mut corners: Vec<Vec3> = (0..n).map(|_| center + self.vector(1.5)).collect();
        if self.next().is_multiple_of(8) {
            corners[0] = corners[1];
        }
        corners
    }

    fn mover(&mut self) -> Mover {
        let from = self.vector(2.0);
        let step = self.vector(0.8);
        let mut mover = Mover::new(0.05 + self.unit(), from, from + step);
        mover.upper = self.next().is_multiple_of(2).then(|| self.unit());
        mover.state = ObjectInfoState::from_bits_retain(self.next() as u32 & 0x4B);
        mover.step_up_height = self.unit();
        mover.walk_interp = self.unit();
        mover
    }
}

fn run(seed: u64, profile: &Profile) -> String {
    let mut random = Random(seed);
    let polygons: Vec<Vec<Vec3>> = (0..1 + random.next() % 12)
        .map(|_| random.polygon())
        .collect();
    let shape = GfxShape::new(
        Some(tree(&polygons, profile)),
        None,
        polygons.into_iter().flatten(),
    );
    let (position, scale) = (at(random.vector(0.5)), Vec3::splat(0.5 + random.unit()));
    let ball = Sphere::new(random.vector(1.0), 0.1 + random.unit());
    let post = CylSphere {
        low: random.vector(1.0),
        radius: 0.1 + random.unit(),
        height: random.unit() * 2.0,
    };
    let world = World::new(profile.clone(), 0.0);
    let mover = random.mover();
    let mut t = mover.transition(&world);
    let mut log = String::new();
    for _ in 0..ATTEMPTS {
        match random.next() % 8 {
            0 => t.path.step_down ^= true,
            1 => t.path.check_walkable ^= true,
            2 => t.path.insert_type = InsertType::InitialPlacement,
            3 => t.path.insert_type = InsertType::Transition,
            4 => t.path.bldg_check ^= true,
            _ => {}
        }
        let part = PlacedPart {
            shape: Some(&shape),
            position: &position,
            scale,
        };
        let states = [
            find_part_collisions([part], &mut t),
            ball.intersects_sphere_at(&position, scale.z, &mut t, false),
            post.intersects_sphere_at(&position, scale.z, &mut t),
        ];
        assert!(!states.contains(&TransitionState::Invalid));
        log += &format!("{states:?}");
    }
    log + &records(&t)
}

#[test]
fn random_soups_neither_panic_nor_vary() {
    for name in Profile::NAMES {
        let profile = Profile::named(name).expect("a preset");
        for seed in 1..150 {
            assert_eq!(
                run(seed, &profile),
                run(seed, &profile),
                "{name}, seed {seed}"
            );
        }
    }
}
