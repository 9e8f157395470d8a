//! Run as shapes in time: node positions of each sheet's displayed layer, and poses of bodies, at
//! each moment.
//!
//! A triangle that opens during the run has vertices of its own, which then collapse to one point:
//! meshes of portable formats have a fixed set of triangles.

use bevy::mesh::{Mesh, VertexAttributeValues};
use bevy_sheetwork::render::polyhedra_mesh;
use glam::{DQuat, DVec3, Vec3};
use sheetwork::World;
use sheetwork::scene::{Scene, Shape};
use sheetwork::sheet::Sheet;

/// Rigid mesh: vertices, normals, triangles.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct RigidMesh {
    /// Vertices, m.
    pub positions: Vec<Vec3>,
    /// Unit normals.
    pub normals: Vec<Vec3>,
    /// Counter-clockwise from outside.
    pub triangles: Vec<[u32; 3]>,
}

/// Sheet in time.
#[derive(Clone, Debug)]
pub struct SheetTrack {
    /// Name of the sheet.
    pub name: String,
    masses: Vec<u32>,
    /// Material coordinates of each node of the layer.
    uvs: Vec<[f32; 2]>,
    triangles: Vec<[u32; 3]>,
    /// Node positions at each moment, m.
    places: Vec<Vec<Vec3>>,
    /// Closed triangles at each moment; empty for all.
    closed: Vec<Vec<bool>>,
}

/// Body in time.
#[derive(Clone, Debug)]
pub struct BodyTrack {
    /// Name of the body.
    pub name: String,
    /// Shape about its own origin.
    pub shape: RigidMesh,
    /// Pose at each moment.
    pub poses: Vec<(DVec3, DQuat)>,
    source: TrackSource,
}

/// Origin of a [`BodyTrack`].
#[derive(Clone, Copy, Debug)]
enum TrackSource {
    /// Rigid body, by index.
    Body(usize),
    /// Heater at a fixed pose.
    Heater(DVec3, DQuat),
}

/// Sheet with the same vertices at all moments.
#[derive(Clone, Debug, PartialEq)]
pub struct Shapes {
    /// Material coordinates.
    pub uvs: Vec<[f32; 2]>,
    /// Triangles.
    pub triangles: Vec<[u32; 3]>,
    /// Vertices and normals at each moment.
    pub moments: Vec<(Vec<Vec3>, Vec<Vec3>)>,
}

/// Track of a run.
#[derive(Clone, Debug, Default)]
pub struct Track {
    /// Times, s.
    pub times: Vec<f64>,
    /// Sheets.
    pub sheets: Vec<SheetTrack>,
    /// Bounded bodies.
    pub bodies: Vec<BodyTrack>,
}

impl Track {
    /// Empty track of `world`.
    pub fn from_world(world: &World) -> Self {
        let rigid = world.rigid().map(|r| r.bodies()).unwrap_or_default().iter().enumerate();
        let bodies = rigid.filter_map(|(index, body)| {
            let shape = match &body.shape {
                Shape::HalfSpace => return None,
                Shape::Ball(radius) => ball(*radius as f32),
                _ => still(&polyhedra_mesh(&body.polyhedra)),
            };
            (!shape.triangles.is_empty()).then(|| BodyTrack {
                name: body.name.clone(),
                shape,
                poses: Vec::new(),
                source: TrackSource::Body(index),
            })
        });
        let bodies = bodies.chain(heaters(world.scene()));
        let sheets = world.sheets().iter().filter_map(SheetTrack::from_sheet);
        Self { times: Vec::new(), sheets: sheets.collect(), bodies: bodies.collect() }
    }

    /// Append the state of `world`, `time` s after the start.
    pub fn record(&mut self, world: &World, time: f64) {
        self.times.push(time);
        for (track, sheet) in self.sheets.iter_mut().zip(world.sheets()) {
            track.places.push(track.masses.iter().map(|m| sheet.state.x.get(*m as usize).as_vec3()).collect());
            let whole = sheet.open_count() == 0;
            track.closed.push(if whole {
                Vec::new()
            } else {
                track.triangles.iter().map(|t| track.is_closed(sheet, *t)).collect()
            });
        }
        for body in &mut self.bodies {
            let last = body.poses.last().copied().unwrap_or((DVec3::ZERO, DQuat::IDENTITY));
            let mut pose = match body.source {
                TrackSource::Body(index) => world.rigid().and_then(|r| r.pose(index)).unwrap_or(last),
                TrackSource::Heater(place, turn) => (place, turn),
            };
            // The quaternion closer to the previous one: players interpolate along the shorter way.
            if pose.1.dot(last.1) < 0.0 {
                pose.1 = -pose.1;
            }
            body.poses.push(pose);
        }
    }
}

impl SheetTrack {
    fn from_sheet(sheet: &Sheet) -> Option<Self> {
        let layer = sheet.model.layers.last()?;
        let all = sheet.model.triangles.clone().unwrap_or_else(|| layer.triangles());
        let mut masses: Vec<u32> = all.iter().flatten().copied().collect();
        masses.sort_unstable();
        masses.dedup();
        let place = |m: u32| masses.binary_search(&m).unwrap_or(0) as u32;
        let triangles = all.iter().map(|t| t.map(place)).collect();
        let uv = |m: &u32| sheet.model.uv.get(*m as usize).map_or([0.0; 2], |(u, v)| [*u as f32, *v as f32]);
        let uvs = masses.iter().map(uv).collect();
        Some(Self { name: sheet.name.clone(), masses, uvs, triangles, places: Vec::new(), closed: Vec::new() })
    }

    /// Whether the cell of `triangle` is closed.
    fn is_closed(&self, sheet: &Sheet, triangle: [u32; 3]) -> bool {
        sheet.cells().is_triangle_closed(triangle.map(|k| self.masses[k as usize]))
    }

    /// Shapes with the same vertices at all moments.
    pub fn shapes(&self) -> Shapes {
        let opens = |t: usize| self.closed.iter().any(|c| c.get(t) == Some(&false));
        let parted: Vec<usize> = (0..self.triangles.len()).filter(|t| opens(*t)).collect();
        let (mut uvs, mut triangles) = (self.uvs.clone(), self.triangles.clone());
        for t in &parted {
            for corner in &mut triangles[*t] {
                uvs.push(self.uvs[*corner as usize]);
                *corner = uvs.len() as u32 - 1;
            }
        }
        let moments = self.places.iter().zip(&self.closed).map(|(places, closed)| {
            let normals = self.normals(places, closed);
            let (mut corners, mut turned) = (places.clone(), normals.clone());
            for t in &parted {
                let own = self.triangles[*t].map(|k| k as usize);
                let middle = own.iter().map(|k| places[*k]).sum::<Vec3>() / 3.0;
                let is_closed = closed.get(*t) != Some(&false);
                corners.extend(own.map(|k| if is_closed { places[k] } else { middle }));
                turned.extend(own.map(|k| normals[k]));
            }
            (corners, turned)
        });
        Shapes { moments: moments.collect(), uvs, triangles }
    }

    /// Node normals: mean of the adjacent closed triangles, weighted by area.
    fn normals(&self, places: &[Vec3], closed: &[bool]) -> Vec<Vec3> {
        let mut sums = vec![Vec3::ZERO; places.len()];
        for (index, triangle) in self.triangles.iter().enumerate() {
            if closed.get(index) == Some(&false) {
                continue;
            }
            let [a, b, c] = triangle.map(|k| places[k as usize]);
            let area = (b - a).cross(c - a);
            triangle.iter().for_each(|k| sums[*k as usize] += area);
        }
        sums.iter().map(|n| n.try_normalize().unwrap_or(Vec3::Y)).collect()
    }
}

/// Heaters of a scene.
fn heaters(scene: &Scene) -> impl Iterator<Item = BodyTrack> + '_ {
    scene.heaters.iter().enumerate().filter_map(|(index, spec)| {
        // The files were validated when the world was built.
        let parts: Vec<_> = spec.resolve(&scene.base).ok()?.into_iter().map(|heater| heater.polyhedron).collect();
        let name = if spec.name.is_empty() { format!("heater {index}") } else { spec.name.clone() };
        let source = TrackSource::Heater(spec.placement.position, spec.placement.quaternion());
        let shape = still(&polyhedra_mesh(&parts));
        (!shape.triangles.is_empty()).then(|| BodyTrack { name, shape, poses: Vec::new(), source })
    })
}

/// Ball of `radius`, with 32 by 16 faces.
fn ball(radius: f32) -> RigidMesh {
    const AROUND: u32 = 32;
    const ALONG: u32 = 16;
    let mut shape = RigidMesh::default();
    for j in 0..=ALONG {
        let (sin, cos) = (std::f32::consts::PI * j as f32 / ALONG as f32).sin_cos();
        for i in 0..=AROUND {
            let (across, along) = (std::f32::consts::TAU * i as f32 / AROUND as f32).sin_cos();
            shape.normals.push(Vec3::new(sin * along, cos, sin * across));
        }
    }
    shape.positions = shape.normals.iter().map(|n| radius * n).collect();
    for j in 0..ALONG {
        for i in 0..AROUND {
            let (a, b) = (j * (AROUND + 1) + i, (j + 1) * (AROUND + 1) + i);
            // At a pole one of the two triangles has no area.
            if j > 0 {
                shape.triangles.push([a, a + 1, b]);
            }
            if j + 1 < ALONG {
                shape.triangles.push([a + 1, b + 1, b]);
            }
        }
    }
    shape
}

/// Vertices, normals and triangles of a mesh.
fn still(mesh: &Mesh) -> RigidMesh {
    let read = |attribute| match mesh.attribute(attribute) {
        Some(VertexAttributeValues::Float32x3(values)) => values.iter().map(|v| Vec3::from(*v)).collect(),
        _ => Vec::new(),
    };
    let indices: Vec<u32> = mesh.indices().map(|i| i.iter().map(|k| k as u32).collect()).unwrap_or_default();
    RigidMesh {
        positions: read(Mesh::ATTRIBUTE_POSITION),
        normals: read(Mesh::ATTRIBUTE_NORMAL),
        triangles: indices.chunks_exact(3).map(|t| [t[0], t[1], t[2]]).collect(),
    }
}
