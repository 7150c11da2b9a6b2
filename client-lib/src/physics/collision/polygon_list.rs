//! Polygons in one piece of memory: headers in one list, all corners in another.

use super::polygon::{Polygon, make_plane};
use crate::math::{EPSILON, Plane, Sphere, Vec3};
use crate::profile::Profile;

/// Polygons of one owner, found by position, which is their key in the dat files.
#[derive(Debug, Clone, Default)]
pub struct PolygonList {
    headers: Vec<Header>,
    vertices: Vec<Vec3>,
}

#[derive(Debug, Clone, Copy)]
struct Header {
    plane: Plane,
    first_vertex: u32,
    vertex_count: u16,
    key: u16,
    single_sided: bool,
}

impl PolygonList {
    /// Number of polygons.
    pub fn len(&self) -> usize {
        self.headers.len()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.headers.is_empty()
    }

    /// The polygon at that position.
    #[inline]
    pub fn get(&self, index: usize) -> Option<Polygon<'_>> {
        let header = self.headers.get(index)?;
        let first = header.first_vertex as usize;
        Some(Polygon {
            plane: header.plane,
            vertices: self
                .vertices
                .get(first..first + usize::from(header.vertex_count))?,
            single_sided: header.single_sided,
        })
    }

    /// Whether a sphere reaches the plane of the polygon at that position: only then can it touch the polygon. As the overlap of
    /// [`Polygon`]; a plane that is not a number is reached.
    #[inline]
    pub(super) fn is_reached(&self, index: usize, sphere: &Sphere) -> bool {
        self.headers.get(index).is_some_and(|header| {
            let beyond = header.plane.distance(sphere.center).abs() > sphere.radius - EPSILON;
            !beyond
        })
    }

    /// Key in the dat files of the polygon at that position.
    pub fn key(&self, index: usize) -> Option<u16> {
        self.headers.get(index).map(|h| h.key)
    }

    /// Appends a polygon of these corners; its plane is computed. At most 65535 corners are kept.
    pub fn push(
        &mut self,
        key: u16,
        vertices: impl IntoIterator<Item = Vec3>,
        single_sided: bool,
        profile: &Profile,
    ) {
        let first = self.vertices.len();
        self.vertices
            .extend(vertices.into_iter().take(usize::from(u16::MAX)));
        let own = &self.vertices[first..];
        self.headers.push(Header {
            plane: make_plane(own, profile),
            first_vertex: first as u32,
            vertex_count: own.len() as u16,
            key,
            single_sided,
        });
    }

    /// Appends a copy of a polygon of another list.
    pub(super) fn push_copy(&mut self, from: &Self, index: usize) {
        let Some(header) = from.headers.get(index) else {
            return;
        };
        let first = self.vertices.len() as u32;
        let start = header.first_vertex as usize;
        self.vertices
            .extend_from_slice(&from.vertices[start..start + usize::from(header.vertex_count)]);
        self.headers.push(Header {
            first_vertex: first,
            ..*header
        });
    }
}
