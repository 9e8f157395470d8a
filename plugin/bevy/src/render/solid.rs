//! Closed surface of a sheet with thickness: upper face, lower face, and the rim between them.
//!
//! Both faces lie at fixed distances from the displayed surface, along its vertex normals. The rim
//! is one quadrilateral with a flat normal for each boundary side of the displayed surface: along
//! the outline, holes, cuts and tears.

use std::collections::HashSet;

use bevy::mesh::VertexAttributeValues;
use bevy::prelude::*;

use super::mesh_arrays::{to_local, write_arrays};
use super::tangents::update_tangents;
use super::triangle_mesh::triangle_mesh;

/// Part of the closed surface.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Face {
    Upper,
    Lower,
    Rim,
}

/// Closed surface of a sheet, distributed over one or more meshes, and the state to be written.
pub(super) struct Solid {
    /// Distances of the upper and the lower face from the displayed surface along its normals, m.
    offsets: (f32, f32),
    /// Boundary sides of the displayed surface, directed as in its triangles.
    boundary: Vec<[u32; 2]>,
    /// Number of vertices at the end that coincide with as many at the beginning: the seam of a
    /// tube.
    seam: usize,
    /// Displayed surface in world space, m.
    positions: Vec<[f32; 3]>,
    normals: Vec<[f32; 3]>,
    /// Vertex colours of upper and lower face; empty without colours.
    colours: [Vec<[f32; 4]>; 2],
    parts: Vec<SolidPart>,
}

/// Faces in one mesh, with its triangles.
struct SolidPart {
    faces: Vec<Face>,
    triangles: Vec<[u32; 3]>,
}

impl Solid {
    /// Closed surface around a surface of `vertices` vertices and `triangles`, of which the last
    /// `seam` vertices coincide with the first.
    pub fn new(vertices: usize, triangles: &[[u32; 3]], seam: usize, offsets: (f32, f32)) -> Self {
        Self {
            offsets,
            boundary: boundary_sides(triangles, vertices, seam),
            seam,
            positions: vec![[0.0; 3]; vertices],
            normals: vec![[0.0; 3]; vertices],
            colours: default(),
            parts: Vec::new(),
        }
    }

    /// Add a mesh of `faces`; `triangles` and `uvs` are those of the displayed surface. Positions
    /// are zero until the mesh is written.
    pub fn add_mesh(&mut self, faces: &[Face], triangles: &[[u32; 3]], uvs: &[[f32; 2]], coloured: bool) -> Mesh {
        let mut part = SolidPart { faces: faces.to_vec(), triangles: Vec::new() };
        let mut coordinates: Vec<[f32; 2]> = Vec::new();
        for face in faces {
            let first = coordinates.len() as u32;
            match face {
                Face::Upper => part.triangles.extend(triangles.iter().map(|t| t.map(|i| first + i))),
                Face::Lower => part.triangles.extend(triangles.iter().map(|[a, b, c]| [a, c, b].map(|i| first + i))),
                Face::Rim => {
                    // Upper start, upper end, lower end, lower start of each side.
                    let quads = (0..self.boundary.len() as u32).map(|side| first + 4 * side);
                    part.triangles.extend(quads.flat_map(|q| [[q + 3, q + 2, q + 1], [q + 3, q + 1, q]]));
                    let ends = |[a, b]: [u32; 2]| [a, b, b, a].map(|i| uvs[i as usize]);
                    coordinates.extend(self.boundary.iter().flat_map(|side| ends(*side)));
                    continue;
                }
            }
            coordinates.extend_from_slice(uvs);
        }
        let count = coordinates.len();
        let (zeros, indices) = (vec![[0.0; 3]; count], part.triangles.iter().flatten().copied().collect());
        let mut mesh = triangle_mesh(zeros.clone(), zeros, coordinates, indices);
        if coloured {
            mesh.insert_attribute(Mesh::ATTRIBUTE_COLOR, vec![[1.0_f32; 4]; count]);
            self.colours = [vec![[1.0; 4]; uvs.len()], vec![[1.0; 4]; uvs.len()]];
        }
        self.parts.push(part);
        mesh
    }

    /// Distances of the faces from the displayed surface, m.
    pub fn offsets(&self) -> (f32, f32) {
        self.offsets
    }

    /// Positions and normals of the displayed surface in world space, to be written before the
    /// meshes.
    pub fn surface_arrays(&mut self) -> (&mut [[f32; 3]], &mut [[f32; 3]]) {
        (&mut self.positions, &mut self.normals)
    }

    /// Vertex colours of the upper and the lower face, to be written before the meshes.
    pub fn colours(&mut self) -> &mut [Vec<[f32; 4]>; 2] {
        &mut self.colours
    }

    /// Give both vertices at each point of a seam one normal, so that the faces are closed there.
    pub fn join_seam(&mut self) {
        let first = self.normals.len() - self.seam;
        for k in 0..self.seam {
            let sum = Vec3::from(self.normals[k]) + Vec3::from(self.normals[first + k]);
            let joined = sum.normalize_or(Vec3::Y).to_array();
            (self.normals[k], self.normals[first + k]) = (joined, joined);
        }
    }

    /// Write the faces of mesh number `part` in the space of an entity at `there`. Returns the
    /// corners of its bounding box; `None` for a mesh without positions.
    pub fn write(&self, part: usize, mesh: &mut Mesh, there: &GlobalTransform) -> Option<(Vec3, Vec3)> {
        let part = self.parts.get(part)?;
        let mut corners = (Vec3::INFINITY, Vec3::NEG_INFINITY);
        let written = write_arrays(mesh, |positions, normals| {
            let mut first = 0;
            for face in &part.faces {
                let end = first + self.vertex_count(*face);
                if let (Some(positions), Some(normals)) = (positions.get_mut(first..end), normals.get_mut(first..end)) {
                    self.write_face(*face, positions, normals);
                }
                first = end;
            }
            to_local(there, positions, normals);
            for p in positions.iter().map(|p| Vec3::from(*p)) {
                corners = (corners.0.min(p), corners.1.max(p));
            }
        });
        if written && mesh.contains_attribute(Mesh::ATTRIBUTE_TANGENT) {
            update_tangents(mesh, &part.triangles);
        }
        written.then_some(corners)
    }

    /// Compute the tangents of mesh number `part` in each further [`Solid::write`].
    pub fn add_tangents(&self, part: usize, mesh: &mut Mesh) {
        if let Some(part) = self.parts.get(part) {
            update_tangents(mesh, &part.triangles);
        }
    }

    /// Write the colours of mesh number `part`, if it has any.
    pub fn write_colours(&self, part: usize, mesh: &mut Mesh) {
        let Some(part) = self.parts.get(part) else { return };
        let Ok(VertexAttributeValues::Float32x4(out)) = mesh.try_attribute_mut(Mesh::ATTRIBUTE_COLOR) else { return };
        let [upper, lower] = &self.colours;
        out.clear();
        for face in &part.faces {
            match face {
                Face::Upper => out.extend_from_slice(upper),
                Face::Lower => out.extend_from_slice(lower),
                Face::Rim => out.extend(self.boundary.iter().flat_map(|side| {
                    let [a, b] = side.map(|i| i as usize);
                    [upper[a], upper[b], lower[b], lower[a]]
                })),
            }
        }
    }

    fn vertex_count(&self, face: Face) -> usize {
        if face == Face::Rim { 4 * self.boundary.len() } else { self.positions.len() }
    }

    fn write_face(&self, face: Face, positions: &mut [[f32; 3]], normals: &mut [[f32; 3]]) {
        let (above, below) = self.offsets;
        let (offset, sign) = if face == Face::Lower { (below, -1.0) } else { (above, 1.0) };
        match face {
            Face::Upper | Face::Lower => {
                for (i, (p, n)) in positions.iter_mut().zip(normals).enumerate() {
                    *p = self.point(i, offset);
                    *n = (sign * Vec3::from(self.normals[i])).to_array();
                }
            }
            Face::Rim => {
                let (quads, normals) = (positions.chunks_exact_mut(4), normals.chunks_exact_mut(4));
                for (side, (quad, normals)) in self.boundary.iter().zip(quads.zip(normals)) {
                    let [a, b] = side.map(|i| i as usize);
                    for (p, (i, offset)) in quad.iter_mut().zip([(a, above), (b, above), (b, below), (a, below)]) {
                        *p = self.point(i, offset);
                    }
                    normals.fill(self.rim_normal(a, b));
                }
            }
        }
    }

    /// Point at `offset` (m) from vertex `i` along its normal.
    fn point(&self, i: usize, offset: f32) -> [f32; 3] {
        (Vec3::from(self.positions[i]) + offset * Vec3::from(self.normals[i])).to_array()
    }

    /// Outward normal of the rim along the boundary side from `a` to `b`.
    fn rim_normal(&self, a: usize, b: usize) -> [f32; 3] {
        let side = Vec3::from(self.positions[b]) - Vec3::from(self.positions[a]);
        let up = Vec3::from(self.normals[a]) + Vec3::from(self.normals[b]);
        let across = || Vec3::from(self.normals[a]).any_orthonormal_vector();
        side.cross(up).try_normalize().unwrap_or_else(across).to_array()
    }
}

/// Sides of `triangles` that no other triangle has in the opposite direction, with the vertices of
/// a seam taken as one.
fn boundary_sides(triangles: &[[u32; 3]], vertices: usize, seam: usize) -> Vec<[u32; 2]> {
    let last = (vertices - seam.min(vertices)) as u32;
    let join = |i: u32| if seam > 0 && i >= last { i - last } else { i };
    let sides = || triangles.iter().flat_map(|[a, b, c]| [[*a, *b], [*b, *c], [*c, *a]]);
    let present: HashSet<[u32; 2]> = sides().map(|side| side.map(join)).collect();
    sides().filter(|[a, b]| !present.contains(&[join(*b), join(*a)])).collect()
}
