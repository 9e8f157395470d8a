//! Local refinement of a sheet: the level that each triangle of its base mesh needs.
//!
//! With θ the angle between the normals of the triangles of areas A₁ and A₂ (m²) at an edge
//! of length l (m), the curvature across it is θ over the distance of their centres,
//! κ = 3 θ l / (2 (A₁ + A₂)), in 1/m. On a cylinder along a row of halved cells this is 3/2 of
//! its curvature: half of the edges across the row carry the whole angle. A base triangle of area A
//! has edges of h = √(2 A); with κ the largest of its edges it needs the smallest level L with
//!
//!   2^-L h κ ≤ φ,
//!
//! φ (rad) being the largest fold angle per edge, and all levels where the largest principal
//! strain λ/(1 + α (T - 20 °C)) - 1 exceeds a fraction of the strain at which the material
//! tears. It keeps a level that it would need for a part of φ and of that strain (hysteresis), so
//! that the mesh does not alternate. The thesis proposes to insert and remove masses where a sheet
//! interacts strongly (7.3 c, 7.4 v and vi).

use std::sync::Arc;

use glam::DVec3;

use crate::mesh::outline::TriangleMesh;
use crate::mesh::outline::refine::Refinement;
use crate::scene::RefineSpec;
use crate::sheet::Sheet;
use crate::units::temperature::REFERENCE;

/// Grid of a sheet, and the levels of its base mesh.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Resolution {
    /// Nodes along length and width.
    pub grid: (u32, u32),
    /// Level of each triangle of the base mesh; `None` for a sheet without refinement, and for
    /// levels of 0.
    pub levels: Option<Arc<[u8]>>,
}

/// Workspace, reused so that a test of the mesh does not allocate.
#[derive(Default)]
pub(crate) struct RefineWorkspace {
    /// Largest curvature (1/m) and strain of each base triangle.
    largest: Vec<(f64, f64)>,
    /// Level that each base triangle should have.
    pub levels: Vec<u8>,
}

/// Grid and levels of a sheet.
pub(crate) fn resolution_of(sheet: &Sheet) -> Resolution {
    Resolution { grid: (sheet.model.grid.0, sheet.model.grid.2), levels: sheet.model.refinement.clone() }
}

/// Set `work.levels` to those that the present shape needs. Returns whether they differ from those
/// of the mesh.
pub(crate) fn plan_levels(sheet: &Sheet, spec: &RefineSpec, work: &mut RefineWorkspace) -> bool {
    let meshes = &sheet.model.meshes;
    let Some((mesh, refinement)) = meshes.present.as_deref().zip(meshes.refinement.as_ref()) else { return false };
    work.largest.clear();
    work.largest.resize(refinement.levels.len(), (0.0, 0.0));
    find_curvatures(sheet, mesh, refinement, &mut work.largest);
    let limit = spec.strain.zip(sheet.parameters.material.tears_at).map_or(f64::INFINITY, |(part, at)| part * at);
    if limit.is_finite() {
        find_strains(sheet, mesh, refinement, &mut work.largest);
    }
    let most = spec.levels as u8;
    work.levels.clear();
    for (((curvature, strain), area), now) in
        work.largest.iter().zip(&refinement.base.areas).zip(refinement.levels.iter())
    {
        let angle = (2.0 * area).sqrt() * curvature;
        let needed = |part: f64| {
            let by_strain = if *strain > part * limit { most } else { 0 };
            let fold = part * spec.fold.to_radians();
            let fits = |level: &u8| angle <= fold * f64::from(1_u32 << level);
            (0..most).find(fits).unwrap_or(most).max(by_strain)
        };
        let (least, kept) = (needed(1.0), needed(spec.hysteresis));
        work.levels.push((*now).clamp(least, kept.max(least)));
    }
    work.levels[..] != refinement.levels[..]
}

/// Raise the curvature of the base triangles at each edge to that across it.
fn find_curvatures(sheet: &Sheet, mesh: &TriangleMesh, refinement: &Refinement, largest: &mut [(f64, f64)]) {
    let normal = |k: u32| {
        let [a, b, c] = mesh.triangles[k as usize].map(|v| sheet.state.x.get(v as usize));
        (b - a).cross(c - a)
    };
    for edge in mesh.edges.iter().filter(|e| !e.is_boundary()) {
        let [p, q] = edge.triangles.map(normal);
        let angle = p.cross(q).length().atan2(p.dot(q));
        let areas: f64 = edge.triangles.iter().map(|k| mesh.areas[*k as usize]).sum();
        let curvature = 1.5 * angle * mesh.direction(edge).0 / areas;
        for k in edge.triangles {
            let most = &mut largest[refinement.parents[k as usize] as usize].0;
            *most = most.max(curvature);
        }
    }
}

/// Raise the strain of the base triangles to that of each of their parts.
fn find_strains(sheet: &Sheet, mesh: &TriangleMesh, refinement: &Refinement, largest: &mut [(f64, f64)]) {
    let expansion = sheet.parameters.material.expansion;
    let celsius = sheet.temperatures();
    for ((t, area), parent) in mesh.triangles.iter().zip(&mesh.areas).zip(&refinement.parents) {
        let [a, b, c] = t.map(|v| sheet.state.x.get(v as usize));
        let [p, q, r] = t.map(|v| mesh.positions[v as usize]);
        let (e, f) = ([q[0] - p[0], q[1] - p[1]], [r[0] - p[0], r[1] - p[1]]);
        let per_metre = |x: f64, y: f64| ((b - a) * x + (c - a) * y) / (2.0 * area);
        let (u, v): (DVec3, DVec3) = (per_metre(f[1], -e[1]), per_metre(-f[0], e[0]));
        let (mean, half) = (0.5 * (u.dot(u) + v.dot(v)), 0.5 * (u.dot(u) - v.dot(v)));
        let stretch = (mean + half.hypot(u.dot(v))).sqrt();
        let warm = celsius.map_or(0.0, |all| t.iter().map(|v| all[*v as usize]).sum::<f64>() / 3.0 - REFERENCE);
        let most = &mut largest[*parent as usize].1;
        *most = most.max(stretch / (1.0 + expansion * warm) - 1.0);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::Scene;

    /// A strip bent to a cylinder of the curvature `bend` (1/m) along its length, stretched across.
    fn levels(bend: f64, stretch: f64, spec: RefineSpec) -> Vec<u8> {
        let text = r#"(sheets: [(structure: "shell", grid: (21, 1, 6), size: (0.2, 0.05), material: "hips",
            outline: Polygon([(-0.1, -0.025), (0.1, -0.025), (0.1, 0.025), (-0.1, 0.025)]), refine: ())])"#;
        let mut sheet = Sheet::build(&Scene::parse(text).expect("valid"), 0).expect("valid");
        sheet.parameters.material.tears_at = Some(0.02);
        for i in 0..sheet.node_count() {
            let p = sheet.state.x.get(i);
            let s = if p.x > 0.0 { p.x } else { 0.0 };
            let (x, y) = if bend == 0.0 || s == 0.0 {
                (p.x, 0.0)
            } else {
                ((bend * s).sin() / bend, (1.0 - (bend * s).cos()) / bend)
            };
            sheet.state.x.set(i, DVec3::new(x, y, p.z * (1.0 + stretch)));
        }
        let mut work = RefineWorkspace::default();
        plan_levels(&sheet, &spec, &mut work);
        let mesh = sheet.mesh().expect("a mesh");
        // The flat half, and the bent half without its ends.
        let of = |low: f64, high: f64| {
            let inside = |k: &usize| (low..high).contains(&mesh.middle_of(*k)[0]);
            (0..mesh.triangles.len()).filter(inside).map(|k| work.levels[k]).max().unwrap_or(0)
        };
        vec![of(-0.1, -0.012), of(0.02, 0.08)]
    }

    #[test]
    fn levels_follow_the_angle_per_edge_and_the_strain() {
        // Edges of 10 mm, and 3/2 of the curvature: 0.859 degrees per 1/m.
        let spec = RefineSpec { levels: 3, fold: 10.0, ..RefineSpec::default() };
        for (bend, level) in [(10.0, 0), (13.0, 1), (22.0, 1), (27.0, 2), (53.0, 3), (200.0, 3)] {
            assert_eq!(levels(bend, 0.0, spec), [0, level], "{bend}");
        }
        let spec = RefineSpec { strain: Some(0.5), ..spec };
        assert_eq!(levels(0.0, 0.009, spec), [0, 0]);
        assert_eq!(levels(0.0, 0.011, spec), [3, 3]);
    }
}
