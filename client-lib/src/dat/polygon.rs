//! Polygons as they are stored: indices into a vertex array, without a plane. Source: `spec/11-dat-files.md, 5.2`.
//!
//! The plane is computed from the points by whoever needs it (`spec/04-collision-primitives.md, 7.1`). Points are counter-clockwise seen
//! from the front. All points of a set lie in one pool, so that reading a shape does not allocate for every polygon.

use bitflags::bitflags;
use serde::ser::SerializeSeq;
use serde::{Serialize, Serializer};

use super::error::Problem;
use super::reader::{Read, Reader};
use super::vertex::VertexArray;
use super::writer::Writer;

bitflags! {
    /// Stippling bits; they also say which texture indices are present.
    #[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
    pub struct Stippling: u8 {
        /// The front is stippled.
        const POSITIVE = 0x01;
        /// The back is stippled.
        const NEGATIVE = 0x02;
        /// The front has no texture indices: physics polygons, and portals that are never drawn.
        const NO_FRONT_UV = 0x04;
        /// The back has no texture indices.
        const NO_BACK_UV = 0x08;
        /// Seen together with `NO_FRONT_UV`; no effect.
        const NO_UVS = 0x10;
    }
}

/// Which sides are drawn; a raw number, since only 2 changes the layout and nothing refuses others.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(transparent)]
pub struct Sides(pub i32);

impl Sides {
    /// Front only (`Landblock` in the references): the ray test rejects rays from behind.
    pub const FRONT: Self = Self(0);
    /// Both sides alike (`None`): the back uses surface and texture indices of the front.
    pub const BOTH_ALIKE: Self = Self(1);
    /// Both sides, the back with its own data (`Clockwise`).
    pub const BOTH: Self = Self(2);
    /// Counter-clockwise; does not occur.
    pub const COUNTER_CLOCKWISE: Self = Self(3);
}

/// One polygon, a view into a [`PolygonSet`].
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Polygon<'a> {
    /// Key: the position in the set.
    pub key: u16,
    /// Stippling bits.
    pub stippling: Stippling,
    /// Which sides are drawn.
    pub sides: Sides,
    /// Index into the owner's surfaces, -1 none.
    pub front_surface: i16,
    /// Index into the owner's surfaces for the back, as stored.
    pub back_surface: i16,
    /// Vertex keys, at least three.
    pub points: &'a [u16],
    /// For each point the index into that vertex' texture coordinates; empty if absent.
    pub front_uvs: &'a [u8],
    /// The same for the back; empty if absent.
    pub back_uvs: &'a [u8],
}

impl Polygon<'_> {
    /// Surface of the back in effect: that of the front if both sides are alike.
    #[must_use]
    pub fn effective_back_surface(&self) -> i16 {
        if self.sides == Sides::BOTH_ALIKE {
            self.front_surface
        } else {
            self.back_surface
        }
    }
}

#[derive(Debug, Clone, Copy, PartialEq)]
struct Head {
    stippling: Stippling,
    sides: Sides,
    front_surface: i16,
    back_surface: i16,
    points: u8,
    first_point: u32,
    first_uv: u32,
}

impl Head {
    fn has_front_uvs(&self) -> bool {
        !self.stippling.contains(Stippling::NO_FRONT_UV)
    }

    fn has_back_uvs(&self) -> bool {
        self.sides == Sides::BOTH && !self.stippling.contains(Stippling::NO_BACK_UV)
    }
}

/// Polygons in order of key; key i is the i-th.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct PolygonSet {
    heads: Vec<Head>,
    points: Vec<u16>,
    uvs: Vec<u8>,
}

/// What the indices of a polygon may refer to.
#[derive(Debug, Clone, Copy)]
pub(super) struct PolygonLimits<'a> {
    /// The vertices of the owner.
    pub vertices: &'a VertexArray,
    /// Number of surfaces; `None` where any index is allowed (physics polygons, rooms: their surfaces are in another record).
    pub surfaces: Option<usize>,
}

impl PolygonSet {
    /// Least bytes of one polygon with its key.
    pub const LEAST: usize = 12;

    /// Number of polygons.
    #[must_use]
    pub fn len(&self) -> usize {
        self.heads.len()
    }

    /// True without polygons.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.heads.is_empty()
    }

    /// The polygon with this key.
    #[must_use]
    pub fn get(&self, key: u16) -> Option<Polygon<'_>> {
        let head = self.heads.get(usize::from(key))?;
        let n = usize::from(head.points);
        let (front, uvs) =
            self.uvs[head.first_uv as usize..].split_at(if head.has_front_uvs() { n } else { 0 });
        Some(Polygon {
            key,
            stippling: head.stippling,
            sides: head.sides,
            front_surface: head.front_surface,
            back_surface: head.back_surface,
            points: &self.points[head.first_point as usize..][..n],
            front_uvs: front,
            back_uvs: &uvs[..if head.has_back_uvs() { n } else { 0 }],
        })
    }

    /// All polygons in order of key.
    pub fn iter(&self) -> impl Iterator<Item = Polygon<'_>> {
        (0..=u16::MAX).map_while(|key| self.get(key))
    }

    /// Adds a polygon and answers its key; `polygon.key` is not looked at.
    ///
    /// Texture indices that the polygon's stippling and sides announce but that are missing count as 0, others are dropped, so that the
    /// set is always one that can be written.
    pub fn push(&mut self, polygon: Polygon<'_>) -> u16 {
        let key = self.heads.len() as u16;
        let points = &polygon.points[..polygon.points.len().min(255)];
        let head = Head {
            stippling: polygon.stippling,
            sides: polygon.sides,
            front_surface: polygon.front_surface,
            back_surface: polygon.back_surface,
            points: points.len() as u8,
            first_point: self.points.len() as u32,
            first_uv: self.uvs.len() as u32,
        };
        self.points.extend_from_slice(points);
        for (wanted, uvs) in [
            (head.has_front_uvs(), polygon.front_uvs),
            (head.has_back_uvs(), polygon.back_uvs),
        ] {
            if wanted {
                self.uvs
                    .extend((0..points.len()).map(|i| uvs.get(i).copied().unwrap_or(0)));
            }
        }
        self.heads.push(head);
        key
    }

    /// Reads `n` polygons; `n` must have been checked.
    pub(super) fn parse(r: &mut Reader<'_>, n: usize, limits: PolygonLimits<'_>) -> Read<Self> {
        if n > 65536 {
            return Err(r.error(Problem::TooLarge {
                size: n as u64,
                limit: 65536,
            }));
        }
        let mut set = Self {
            heads: Vec::with_capacity(n),
            points: Vec::with_capacity(n * 4),
            uvs: Vec::new(),
        };
        for i in 0..n {
            let key = r.u16()?;
            if usize::from(key) != i {
                return Err(r.error_at(
                    r.offset() - 2,
                    Problem::KeyOrder {
                        what: "polygon",
                        expected: i as u32,
                        found: u32::from(key),
                    },
                ));
            }
            set.parse_one(r, limits)?;
        }
        Ok(set)
    }

    fn parse_one(&mut self, r: &mut Reader<'_>, limits: PolygonLimits<'_>) -> Read<()> {
        let points = r.u8()?;
        if points < 3 {
            return Err(r.error_at(
                r.offset() - 1,
                Problem::Value {
                    what: "number of points",
                    found: i64::from(points),
                    expected: "at least 3",
                },
            ));
        }
        let head = Head {
            points,
            stippling: Stippling::from_bits_retain(r.u8()?),
            sides: Sides(r.i32()?),
            front_surface: r.i16()?,
            back_surface: r.i16()?,
            first_point: self.points.len() as u32,
            first_uv: self.uvs.len() as u32,
        };
        check_surface(r, head.front_surface, limits)?;
        if head.sides == Sides::BOTH {
            check_surface(r, head.back_surface, limits)?;
        }
        let n = r.fits("points", u64::from(points), 2)?;
        for _ in 0..n {
            let v = r.u16()?;
            if usize::from(v) >= limits.vertices.len() {
                return Err(r.error_at(
                    r.offset() - 2,
                    Problem::Index {
                        what: "vertex",
                        found: i64::from(v),
                        limit: limits.vertices.len(),
                    },
                ));
            }
            self.points.push(v);
        }
        for present in [head.has_front_uvs(), head.has_back_uvs()] {
            if present {
                self.parse_uvs(r, &head, limits.vertices)?;
            }
        }
        self.heads.push(head);
        Ok(())
    }

    fn parse_uvs(&mut self, r: &mut Reader<'_>, head: &Head, vertices: &VertexArray) -> Read<()> {
        for i in 0..usize::from(head.points) {
            let uv = r.u8()?;
            let limit = vertices
                .uvs(self.points[head.first_point as usize + i])
                .len();
            if usize::from(uv) >= limit {
                return Err(r.error_at(
                    r.offset() - 1,
                    Problem::Index {
                        what: "texture coordinate",
                        found: i64::from(uv),
                        limit,
                    },
                ));
            }
            self.uvs.push(uv);
        }
        Ok(())
    }

    /// Writes the polygons with their keys, without a count.
    pub fn write(&self, w: &mut Writer) {
        if self.heads.len() > 65536 {
            w.fail("polygons", self.heads.len() as u64, 65536);
        }
        for p in self.iter() {
            w.u16(p.key);
            w.u8(p.points.len() as u8);
            w.u8(p.stippling.bits());
            w.i32(p.sides.0);
            w.i16(p.front_surface);
            w.i16(p.back_surface);
            for &v in p.points {
                w.u16(v);
            }
            w.bytes(p.front_uvs);
            w.bytes(p.back_uvs);
        }
    }
}

fn check_surface(r: &Reader<'_>, surface: i16, limits: PolygonLimits<'_>) -> Read<()> {
    match limits.surfaces {
        Some(limit) if surface < -1 || i64::from(surface) >= limit as i64 => Err(r.error_at(
            r.offset() - 4,
            Problem::Index {
                what: "surface",
                found: i64::from(surface),
                limit,
            },
        )),
        _ => Ok(()),
    }
}

impl Serialize for PolygonSet {
    fn serialize<S: Serializer>(&self, s: S) -> Result<S::Ok, S::Error> {
        let mut seq = s.serialize_seq(Some(self.len()))?;
        for p in self.iter() {
            seq.serialize_element(&p)?;
        }
        seq.end()
    }
}
