//! The key stream: Jenkins' ISAAC with 256 words of state, seeded by one word (`spec/09`, 7.1).

/// A stream of key words.
#[derive(Clone)]
pub struct Isaac {
    mem: [u32; 256],
    out: [u32; 256],
    a: u32,
    b: u32,
    c: u32,
    /// Words of `out` that are still unused; they are taken from the end.
    left: usize,
}

impl Isaac {
    /// The stream of a seed.
    pub fn new(seed: u32) -> Self {
        let mut s = Self {
            mem: [0; 256],
            out: [0; 256],
            a: seed,
            b: seed,
            c: seed,
            left: 0,
        };
        let mut v = [0x9E37_79B9u32; 8];
        for _ in 0..4 {
            mix(&mut v);
        }
        for second in [false, true] {
            for j in (0..256).step_by(8) {
                if second {
                    for (v, m) in v.iter_mut().zip(&s.mem[j..j + 8]) {
                        *v = v.wrapping_add(*m);
                    }
                }
                mix(&mut v);
                s.mem[j..j + 8].copy_from_slice(&v);
            }
        }
        s.generate();
        s
    }

    /// The next word.
    pub fn next_word(&mut self) -> u32 {
        if self.left == 0 {
            self.generate();
        }
        self.left -= 1;
        self.out[self.left]
    }

    fn generate(&mut self) {
        self.c = self.c.wrapping_add(1);
        self.b = self.b.wrapping_add(self.c);
        for i in 0..256 {
            let x = self.mem[i];
            self.a ^= match i % 4 {
                0 => self.a << 13,
                1 => self.a >> 6,
                2 => self.a << 2,
                _ => self.a >> 16,
            };
            self.a = self.a.wrapping_add(self.mem[(i + 128) % 256]);
            let y = self.mem[(x >> 2) as usize % 256]
                .wrapping_add(self.a)
                .wrapping_add(self.b);
            self.mem[i] = y;
            self.b = self.mem[(y >> 10) as usize % 256].wrapping_add(x);
            self.out[i] = self.b;
        }
        self.left = 256;
    }
}

impl core::fmt::Debug for Isaac {
    /// Without the state: it is long, and a key.
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.debug_struct("Isaac")
            .field("left", &self.left)
            .finish_non_exhaustive()
    }
}

fn mix(v: &mut [u32; 8]) {
    let shifted = |x: u32, i: usize| match i {
        0 => x << 11,
        1 => x >> 2,
        2 => x << 8,
        3 => x >> 16,
        4 => x << 10,
        5 => x >> 4,
        6 => x << 8,
        _ => x >> 9,
    };
    for i in 0..8 {
        v[i] ^= shifted(v[(i + 1) % 8], i);
        v[(i + 3) % 8] = v[(i + 3) % 8].wrapping_add(v[i]);
        v[(i + 1) % 8] = v[(i + 1) % 8].wrapping_add(v[(i + 2) % 8]);
    }
}

#[cfg(test)]
mod tests {
    use super::Isaac;

    #[test]
    fn streams_of_the_table() {
        type Row = (u32, [u32; 8], [u32; 3]);
        let rows: [Row; 5] = [
            (
                0,
                [
                    0x182600F3, 0x300B4A8D, 0x301B6622, 0xB08ACD21, 0x296FD679, 0x995206E9,
                    0xB3FFA8B5, 0x0FC99C24,
                ],
                [0xE76DD339, 0x7A68710F, 0x6554ABDA],
            ),
            (
                0x12345678,
                [
                    0xFDD4AFEB, 0x398311D2, 0xC71829A4, 0xB19DF96A, 0x7ED4A1E7, 0xB718A446,
                    0x5FA77DF1, 0x5CB793D2,
                ],
                [0xDF7CA7E9, 0xA608787A, 0x2271E865],
            ),
            (
                0x99E77855,
                [
                    0xAD497DF3, 0x70FAAA14, 0xECF9E209, 0x7B9F5809, 0xA4B1AB73, 0xA3000286,
                    0xF4ED69DA, 0x6B6751CC,
                ],
                [0x9E581074, 0x4B856A36, 0xCD153315],
            ),
            (
                0xFFFFFFFF,
                [
                    0x4317C641, 0x1D124727, 0xE877449D, 0x5C326457, 0x38523B75, 0x7172F54C,
                    0x9F8FF2B9, 0x50803842,
                ],
                [0xFE83B016, 0xE28DC1F7, 0x7B3C165A],
            ),
            (
                1,
                [
                    0x38168FDD, 0x173FF3D7, 0x832DDC13, 0xC4291D70, 0x56EA8D9B, 0xC41D285C,
                    0x10DABB10, 0x8D81F41A,
                ],
                [0xFE83B016, 0x1BA8A003, 0x061C754F],
            ),
        ];
        for (seed, first, later) in rows {
            let mut isaac = Isaac::new(seed);
            let words: Vec<u32> = (0..258).map(|_| isaac.next_word()).collect();
            assert_eq!(words[..8], first, "seed {seed:#X}");
            assert_eq!(words[255..], later, "seed {seed:#X}");
        }
    }
}
