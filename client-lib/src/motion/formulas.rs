//! Burden, run rate and jump height of a character (`spec/08-motion.md`, 12.2 to 12.4; retail: `EncumbranceSystem`, `MovementSystem`).

use crate::profile::{Profile, RunRateRule};

/// Burden units that a character can carry, from its strength and its carrying augmentations.
pub fn encumbrance_capacity(strength: i32, augmentations: i32) -> i32 {
    if strength <= 0 {
        return 0;
    }
    let plain = strength.wrapping_mul(150);
    let bonus = augmentations.wrapping_mul(30);
    if bonus < 0 {
        plain
    } else {
        plain.wrapping_add(strength.wrapping_mul(bonus.min(150)))
    }
}

/// Burden carried in units of the capacity; 3 without any capacity.
pub fn load(capacity: i32, encumbrance: i32) -> f32 {
    if capacity <= 0 {
        3.0
    } else if encumbrance < 0 {
        0.0
    } else {
        (f64::from(encumbrance) / f64::from(capacity)) as f32
    }
}

/// Fraction of speed and jump height left under a load: 1 up to load 1, 0 from load 2 on.
pub fn load_mod(load: f32) -> f32 {
    if load >= 2.0 {
        0.0
    } else if load >= 1.0 {
        2.0 - load
    } else {
        1.0
    }
}

/// Run rate from load and Run skill; 1 is 4 m/s (`D23`, `D24`).
pub fn run_rate(load: f32, skill: i32, profile: &Profile) -> f32 {
    let (capped, wide) = match profile.run_rate_rule {
        RunRateRule::Exactly800 => (skill == 800, true),
        RunRateRule::From800 => (skill >= 800, false),
    };
    if capped {
        4.5
    } else if wide {
        let (skill, modifier) = (f64::from(skill), f64::from(load_mod(load)));
        ((modifier * (skill / (skill + 200.0) * 11.0) + 4.0) / 4.0) as f32
    } else {
        let skill = skill as f32;
        (load_mod(load) * (skill / (skill + 200.0) * 11.0) + 4.0) / 4.0
    }
}

/// Height (m) of a jump with `power` in 0..=1; never below 0.35 m.
pub fn jump_height(load: f32, skill: i32, power: f32, profile: &Profile) -> f32 {
    let power = if power < 0.0 {
        0.0
    } else if power <= 1.0 {
        power
    } else {
        1.0
    };
    let height = match profile.run_rate_rule {
        RunRateRule::Exactly800 => {
            let (s, m) = (f64::from(skill), f64::from(load_mod(load)));
            let base = s / (s + 1300.0) * f64::from(22.2f32) + f64::from(0.05f32);
            (m * base * f64::from(power)) as f32
        }
        RunRateRule::From800 => {
            let s = skill as f32;
            load_mod(load) * (s / (s + 1300.0) * 22.2 + 0.05) * power
        }
    };
    if height < 0.35 { 0.35 } else { height }
}

/// Vertical launch speed (m/s) that reaches a height (m).
pub fn jump_velocity(height: f32) -> f32 {
    (f64::from(height) * 19.6).sqrt() as f32
}

/// Stamina that a jump costs; `pk`: a player killer who has attacked a player within 20 s.
pub fn jump_stamina_cost(power: f32, load: f32, pk: bool, profile: &Profile) -> i32 {
    match (profile.run_rate_rule, pk) {
        (RunRateRule::Exactly800, true) => ((f64::from(power) + 1.0) * 100.0) as i32,
        (RunRateRule::Exactly800, false) => {
            ((f64::from(load) + 0.5) * f64::from(power) * 8.0 + 2.0).ceil() as i32
        }
        (RunRateRule::From800, true) => ((power + 1.0) * 100.0) as i32,
        (RunRateRule::From800, false) => ((load + 0.5) * power * 8.0 + 2.0).ceil() as i32,
    }
}

/// Power of a jump that a server reads back from the stamina it cost.
pub fn jump_power(stamina: u32, load: f32, pk: bool) -> f32 {
    let stamina = stamina as f32;
    if pk {
        stamina / 100.0 - 1.0
    } else {
        (stamina - 2.0) / (load * 8.0 + 4.0)
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    #[test]
    fn run_rates_of_the_specification() {
        let p = Profile::retail();
        for (skill, light, heavy) in [
            (0, 1.0, 1.0),
            (50, 1.55, 1.275),
            (100, 1.916_666_6, 1.458_333_3),
            (200, 2.375, 1.6875),
            (300, 2.65, 1.825),
            (400, 2.833_333_3, 1.916_666_7),
            (500, 2.964_285_6, 1.982_142_9),
            (799, 3.199_449_5, 2.099_724_7),
            (800, 4.5, 4.5),
            (801, 3.200_549_4, 2.100_274_7),
        ] {
            assert_eq!(run_rate(1.0, skill, &p), light, "skill {skill}");
            let slow = f64::from(run_rate(1.5, skill, &p));
            assert!((slow - heavy).abs() < 1.2e-7, "skill {skill}, load 1.5");
        }
        assert_eq!(run_rate(1.0, 801, &Profile::ace()), 4.5);
    }

    #[test]
    fn jumps_of_the_specification() {
        let p = Profile::retail();
        for (skill, rows) in [
            (
                100,
                [
                    (0.25, 0.408_928_6, 2.831_077_6),
                    (0.5, 0.817_857_2, 4.003_748_3),
                    (1.0, 1.635_714_3, 5.662_155_2),
                ],
            ),
            (
                300,
                [
                    (0.25, 1.053_125, 4.543_264_3),
                    (0.5, 2.106_250_1, 6.425_146),
                    (1.0, 4.212_500_1, 9.086_528_6),
                ],
            ),
            (
                500,
                [
                    (0.25, 1.554_166_7, 5.519_209),
                    (0.5, 3.108_333_4, 7.805_340_2),
                    (1.0, 6.216_666_9, 11.038_418),
                ],
            ),
        ] {
            for (power, height, velocity) in rows {
                let h = jump_height(0.5, skill, power, &p);
                let (dh, dv) = (
                    f64::from(h) - height,
                    f64::from(jump_velocity(h)) - velocity,
                );
                assert!(dh.abs() < 3e-7 && dv.abs() < 6e-7, "{skill} {power}");
            }
        }
        let least = jump_height(0.0, 0, 1.0, &p);
        assert_eq!((least, jump_velocity(least)), (0.35, 2.619_160_2));
        assert_eq!(jump_height(2.0, 500, 1.0, &p), 0.35);
        assert_eq!(
            jump_height(0.0, 500, f32::NAN, &p),
            jump_height(0.0, 500, 1.0, &p)
        );
    }

    #[test]
    fn burden() {
        assert_eq!(encumbrance_capacity(0, 5), 0);
        assert_eq!(encumbrance_capacity(100, 0), 15_000);
        assert_eq!(encumbrance_capacity(100, 2), 21_000);
        assert_eq!(encumbrance_capacity(100, 9), 30_000);
        assert_eq!(encumbrance_capacity(100, -1), 15_000);
        assert_eq!(load(0, 10), 3.0);
        assert_eq!(load(100, -1), 0.0);
        assert_eq!(load(100, 150), 1.5);
        assert_eq!(jump_stamina_cost(1.0, 0.5, false, &Profile::retail()), 10);
        assert_eq!(jump_stamina_cost(0.5, 3.0, true, &Profile::retail()), 150);
        assert_eq!(jump_power(150, 0.0, true), 0.5);
        assert_eq!(jump_power(10, 0.5, false), 1.0);
    }

    proptest! {
        #[test]
        fn invariant_25(a in 0.0f32..4.0, b in 0.0f32..4.0, skill in 0i32..2000, power in 0.0f32..1.0, q in 0.0f32..1.0) {
            for p in [Profile::retail(), Profile::ace()] {
                let (light, heavy) = (a.min(b), a.max(b));
                prop_assert!((0.0..=1.0).contains(&load_mod(a)));
                prop_assert!(load_mod(light) >= load_mod(heavy));
                prop_assert!(run_rate(a, skill, &p) >= 1.0);
                prop_assert!(jump_height(a, skill, power, &p) >= 0.35);
                let (weak, strong) = (power.min(q), power.max(q));
                let cost = jump_stamina_cost(weak, light, false, &p);
                prop_assert!(cost >= 2);
                prop_assert!(jump_stamina_cost(strong, light, false, &p) >= cost);
                prop_assert!(jump_stamina_cost(weak, heavy, false, &p) >= cost);
            }
        }
    }
}
