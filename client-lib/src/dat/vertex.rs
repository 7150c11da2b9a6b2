//! The vertex array that polygons of a shape or room structure refer to. Source: `spec/11-dat-files.md, 5.1`.

use serde::Serialize;

use super::error::Problem;
use super::reader::{Read, Reader};
use super::writer::Writer;
use crate::math::Vec3;

/// One vertex. Its key is its position in the array.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Vertex {
    /// Position in the owner's space, metres.
    pub position: Vec3,
    /// Normal for lighting.
    pub normal: Vec3,
    first_uv: u32,
    uv_count: u16,
}

/// Vertices, and the texture coordinates of all of them in one list.
#[derive(Debug, Clone, PartialEq, Default, Serialize)]
pub struct VertexArray {
    vertices: Vec<Vertex>,
    uvs: Vec<[f32; 2]>,
}

impl VertexArray {
    /// Vertices in order of key.
    #[must_use]
    pub fn vertices(&self) -> &[Vertex] {
        &self.vertices
    }

    /// The vertex with this key.
    #[must_use]
    pub fn get(&self, key: u16) -> Option<&Vertex> {
        self.vertices.get(usize::from(key))
    }

    /// Number of vertices.
    #[must_use]
    pub fn len(&self) -> usize {
        self.vertices.len()
    }

    /// True without vertices.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.vertices.is_empty()
    }

    /// Texture coordinates (u, v) of a vertex.
    #[must_use]
    pub fn uvs(&self, key: u16) -> &[[f32; 2]] {
        match self.get(key) {
            Some(v) => &self.uvs[v.first_uv as usize..][..usize::from(v.uv_count)],
            None => &[],
        }
    }

    /// Adds a vertex and answers its key. Keys wrap after 65536 vertices, which [`VertexArray::write`] refuses.
    pub fn push(&mut self, position: Vec3, normal: Vec3, uvs: &[[f32; 2]]) -> u16 {
        let key = self.vertices.len() as u16;
        self.vertices.push(Vertex {
            position,
            normal,
            first_uv: self.uvs.len() as u32,
            uv_count: uvs.len() as u16,
        });
        self.uvs.extend_from_slice(uvs);
        key
    }

    /// Reads the array.
    ///
    /// # Errors
    /// Unknown vertex type, keys that do not count up from 0, and those of the reader.
    pub fn parse(r: &mut Reader<'_>) -> Read<Self> {
        let kind = r.i32()?;
        if kind != 1 {
            return Err(r.error_at(
                r.offset() - 4,
                Problem::Unknown {
                    what: "vertex type",
                    found: kind as u32,
                },
            ));
        }
        let n = r.count_u32("vertices", 28)?;
        if n > 65536 {
            return Err(r.error(Problem::TooLarge {
                size: n as u64,
                limit: 65536,
            }));
        }
        let mut array = Self {
            vertices: Vec::with_capacity(n),
            uvs: Vec::new(),
        };
        for i in 0..n {
            let key = r.u16()?;
            if usize::from(key) != i {
                return Err(r.error_at(
                    r.offset() - 2,
                    Problem::KeyOrder {
                        what: "vertex",
                        expected: i as u32,
                        found: u32::from(key),
                    },
                ));
            }
            let uv_count = r.u16()?;
            let vertex = Vertex {
                position: r.vec3("vertex position")?,
                normal: r.vec3("vertex normal")?,
                first_uv: array.uvs.len() as u32,
                uv_count,
            };
            let m = r.fits("texture coordinates", u64::from(uv_count), 8)?;
            array.uvs.reserve(m);
            for _ in 0..m {
                array.uvs.push([r.f32()?, r.f32()?]);
            }
            array.vertices.push(vertex);
        }
        Ok(array)
    }

    /// Writes the array.
    pub fn write(&self, w: &mut Writer) {
        w.i32(1);
        if self.vertices.len() > 65536 {
            w.fail("vertices", self.vertices.len() as u64, 65536);
        }
        w.count_u32("vertices", self.vertices.len());
        for (i, v) in self.vertices.iter().enumerate() {
            w.u16(i as u16);
            w.u16(v.uv_count);
            w.vec3(v.position);
            w.vec3(v.normal);
            for uv in &self.uvs[v.first_uv as usize..][..usize::from(v.uv_count)] {
                w.f32(uv[0]);
                w.f32(uv[1]);
            }
        }
    }
}
