//! Faces, edges and corners of a triangulated surface.
//!
//! Coincident vertices are merged; triangles without area are removed; adjacent triangles in one
//! plane, within 1 mrad, form one face. An edge is convex if each adjacent face falls behind the
//! plane of the other.

use std::collections::BTreeMap;

use glam::DVec3;

use crate::collision::features::mesh::{ColliderCorner, ColliderEdge, ColliderFace};
use crate::collision::settings::{BodySurfaceSettings, DetectionSettings};

const SETTINGS: BodySurfaceSettings = DetectionSettings::DEFAULT.surface;

/// Topology of a surface.
pub(crate) struct MeshTopology {
    pub vertices: Vec<DVec3>,
    pub triangles: Vec<[u32; 3]>,
    /// Face of each triangle.
    pub face_of: Vec<u32>,
    pub faces: Vec<ColliderFace>,
    pub edges: Vec<ColliderEdge>,
    pub corners: Vec<ColliderCorner>,
    /// Whether each side has two triangles.
    pub closed: bool,
}

/// A side of triangles: its vertices in the order of the first triangle, and the triangles.
struct TopologyEdge {
    ends: [u32; 2],
    triangles: Vec<usize>,
}

impl MeshTopology {
    /// Topology of triangles; `None` if all have zero area.
    pub fn from_triangles(vertices: &[DVec3], triangles: &[[u32; 3]]) -> Option<Self> {
        let (vertices, renamed) = weld(vertices)?;
        let size = vertices.iter().map(|v| v.abs().max_element()).fold(0.0, f64::max);
        let corners = |t: [u32; 3]| t.map(|i| vertices[i as usize]);
        let named = triangles.iter().filter_map(|t| {
            let [a, b, c] = t.map(|i| renamed.get(i as usize).copied());
            Some([a?, b?, c?])
        });
        let weld = SETTINGS.weld_distance;
        let triangles: Vec<[u32; 3]> =
            named.filter(|t| area_vector(corners(*t)).length() > weld * weld * size * size).collect();
        if triangles.is_empty() {
            return None;
        }
        let normals: Vec<DVec3> = triangles.iter().map(|t| area_vector(corners(*t)).normalize_or_zero()).collect();
        let sides = sides_of(&triangles);
        let closed = sides.iter().all(|s| s.triangles.len() == 2);
        let face_of = faces_of(&normals, &sides);
        let count = face_of.iter().map(|f| *f + 1).max().unwrap_or(0);
        let mut faces: Vec<(DVec3, f64, f64)> = vec![(DVec3::ZERO, 0.0, 0.0); count as usize];
        for (t, face) in triangles.iter().zip(&face_of) {
            let [a, b, c] = corners(*t);
            let area = area_vector([a, b, c]);
            let (normal, moment, weight) = &mut faces[*face as usize];
            *normal += area;
            *moment += area.length() * area.normalize_or_zero().dot((a + b + c) / 3.0);
            *weight += area.length();
        }
        let faces = faces
            .into_iter()
            .map(|(n, m, w)| ColliderFace { normal: n.normalize_or_zero(), distance: m / w })
            .collect();
        let mut topology = Self { vertices, triangles, face_of, faces, edges: Vec::new(), corners: Vec::new(), closed };
        topology.find_convex_features(&sides);
        Some(topology)
    }

    /// Collect convex edges, and corners at which only convex edges meet.
    fn find_convex_features(&mut self, sides: &[TopologyEdge]) {
        let mut meeting: Vec<(Vec<DVec3>, bool)> = vec![(Vec::new(), true); self.vertices.len()];
        for side in sides {
            let ends = side.ends.map(|i| self.vertices[i as usize]);
            let along = (ends[1] - ends[0]).normalize_or_zero();
            let faces: Vec<u32> = side.triangles.iter().map(|t| self.face_of[*t]).collect();
            let convex = match faces[..] {
                [f, g] if f == g => continue,
                [f, g] => {
                    let normals = [f, g].map(|i| self.faces[i as usize].normal);
                    let convex = normals[0].cross(normals[1]).dot(along) > SETTINGS.plane_sine;
                    if convex {
                        self.edges.push(ColliderEdge { ends, normals });
                    }
                    convex
                }
                _ => false,
            };
            for (end, direction) in side.ends.into_iter().zip([along, -along]) {
                let (edges, all_convex) = &mut meeting[end as usize];
                edges.push(direction);
                *all_convex &= convex;
            }
        }
        let corners = self.vertices.iter().zip(meeting);
        self.corners = corners
            .filter(|(_, (edges, all_convex))| *all_convex && edges.len() >= 3)
            .map(|(place, (edges, _))| ColliderCorner { position: *place, edges })
            .collect();
    }
}

fn area_vector([a, b, c]: [DVec3; 3]) -> DVec3 {
    (b - a).cross(c - a)
}

/// Distinct vertices, and the new index of each old one; `None` if a coordinate is not finite.
fn weld(vertices: &[DVec3]) -> Option<(Vec<DVec3>, Vec<u32>)> {
    if !vertices.iter().all(|v| v.is_finite()) {
        return None;
    }
    let size = vertices.iter().map(|v| v.abs().max_element()).fold(0.0, f64::max);
    let cell = (SETTINGS.weld_distance * size).max(f64::MIN_POSITIVE);
    let mut names: BTreeMap<[i64; 3], u32> = BTreeMap::new();
    let mut kept = Vec::new();
    let renamed = vertices.iter().map(|v| {
        *names.entry((*v / cell).round().to_array().map(|x| x as i64)).or_insert_with(|| {
            kept.push(*v);
            kept.len() as u32 - 1
        })
    });
    let renamed = renamed.collect();
    Some((kept, renamed))
}

fn sides_of(triangles: &[[u32; 3]]) -> Vec<TopologyEdge> {
    let mut sides: BTreeMap<[u32; 2], TopologyEdge> = BTreeMap::new();
    for (t, m) in triangles.iter().enumerate() {
        for k in 0..3 {
            let (a, b) = (m[k], m[(k + 1) % 3]);
            let side =
                sides.entry([a.min(b), a.max(b)]).or_insert(TopologyEdge { ends: [a, b], triangles: Vec::new() });
            side.triangles.push(t);
        }
    }
    sides.into_values().collect()
}

/// Face of each triangle, numbered from 0 in the order of their first triangles.
fn faces_of(normals: &[DVec3], sides: &[TopologyEdge]) -> Vec<u32> {
    let mut root: Vec<usize> = (0..normals.len()).collect();
    let find = |root: &[usize], mut i: usize| {
        while root[i] != i {
            i = root[i];
        }
        i
    };
    for side in sides {
        let [a, b] = side.triangles[..] else { continue };
        // The comparison with the first triangle of the face keeps a fine curve from merging step
        // by step.
        let (a, b) = (find(&root, a), find(&root, b));
        if normals[a].dot(normals[b]) > 0.0 && normals[a].cross(normals[b]).length() < SETTINGS.plane_sine {
            root[a.max(b)] = a.min(b);
        }
    }
    let mut number = vec![u32::MAX; normals.len()];
    let mut next = 0;
    let faces = (0..normals.len()).map(|i| {
        let first = find(&root, i);
        if number[first] == u32::MAX {
            number[first] = next;
            next += 1;
        }
        number[first]
    });
    faces.collect()
}
