//! Fields of a sheet for display, one value per node: strain, curvature, contact force, speed.

use bevy::math::DVec3;
use sheetwork::sheet::Sheet;

/// Largest strain of the edges at each node, in tension or compression, %.
pub fn stretch(sheet: &Sheet, out: &mut Vec<f64>) {
    out.clear();
    out.resize(sheet.node_count(), 0.0);
    let mut see = |a: u32, b: u32, rest: f64| {
        let (a, b) = (a as usize, b as usize);
        if rest > 0.0 {
            let strain = 100.0 * (sheet.state.x.get(a).distance(sheet.state.x.get(b)) / rest - 1.0).abs();
            out[a] = out[a].max(strain);
            out[b] = out[b].max(strain);
        }
    };
    let springs = sheet.springs();
    for i in 0..springs.len() {
        let (a, b) = (springs.a[i], springs.b[i]);
        if sheet.model.layer_of[a as usize] == sheet.model.layer_of[b as usize] {
            see(a, b, springs.rest[i]);
        }
    }
    if springs.is_empty() {
        let (length, width) = sheet.rest_size();
        for [a, b] in sheet.edges() {
            let (p, q) = (sheet.model.uv[a as usize], sheet.model.uv[b as usize]);
            see(a, b, ((q.0 - p.0) * length).hypot((q.1 - p.1) * width));
        }
    }
}

/// Largest curvature along the edges at each node, in either direction, 1/m: change of the normal
/// per length of the edge.
pub fn bending(sheet: &Sheet, out: &mut Vec<f64>) {
    out.clear();
    out.resize(sheet.node_count(), 0.0);
    let mut normals = vec![DVec3::ZERO; sheet.node_count()];
    let triangles = match &sheet.model.triangles {
        Some(all) => all.clone(),
        None => sheet.model.layers.iter().flat_map(|layer| layer.triangles()).collect(),
    };
    for corners in triangles {
        let [p, q, r] = corners.map(|i| sheet.state.x.get(i as usize));
        let normal = (q - p).cross(r - p);
        corners.iter().for_each(|i| normals[*i as usize] += normal);
    }
    for [a, b] in sheet.edges() {
        let (a, b) = (a as usize, b as usize);
        let along = sheet.state.x.get(b) - sheet.state.x.get(a);
        let turn = normals[b].normalize_or_zero() - normals[a].normalize_or_zero();
        let squared = along.length_squared();
        if squared > 0.0 {
            let curvature = (turn.dot(along) / squared).abs();
            out[a] = out[a].max(curvature);
            out[b] = out[b].max(curvature);
        }
    }
}

/// Contact force at each node, mN, from static equilibrium.
pub fn contact(sheet: &Sheet, gravity: DVec3, out: &mut Vec<f64>) {
    let mut forces = Vec::new();
    sheet.contact_forces(gravity, &mut forces);
    out.clear();
    out.extend(forces.iter().map(|force| 1e3 * force.length()));
}

/// Speed of each node, m/s.
pub fn speed(sheet: &Sheet, out: &mut Vec<f64>) {
    out.clear();
    out.extend(sheet.state.v.iter().map(DVec3::length));
}

#[cfg(test)]
mod tests {
    use super::*;
    use sheetwork::World;
    use sheetwork::scene::{Scene, SheetSpec};

    fn sheet(structure: &str) -> World {
        let layers = if structure == "shell" { 1 } else { 2 };
        let (structure, size) = (structure.parse().expect("known"), (0.2, 0.2));
        let spec = SheetSpec { structure, grid: (9, layers, 9), size, material: "hips".into(), ..SheetSpec::thesis() };
        World::new(&Scene { sheets: vec![spec], ..Scene::thesis() }).expect("valid")
    }

    #[test]
    fn a_flat_sheet_at_rest_has_nothing_to_show_and_a_stretched_one_has() {
        for structure in ["shell", "slamm", "trimm"] {
            let mut world = sheet(structure);
            let mut out = Vec::new();
            for of in [stretch, bending, speed] {
                of(&world.sheets()[0], &mut out);
                assert!(out.iter().all(|v| *v < 1e-6), "{structure}: {out:?}");
            }
            let sheet = &mut world.sheets_mut()[0];
            for i in 0..sheet.node_count() {
                let p = sheet.state.x.get(i);
                sheet.state.x.set(i, DVec3::new(1.02 * p.x, p.y, p.z));
                sheet.state.v.set(i, DVec3::new(3.0, 0.0, 4.0));
            }
            stretch(sheet, &mut out);
            assert!(out.iter().all(|v| (v - 2.0).abs() < 1e-6 || *v <= 2.0), "{structure}: {out:?}");
            assert!(out.iter().any(|v| (v - 2.0).abs() < 1e-6));
            speed(sheet, &mut out);
            assert!(out.iter().all(|v| (v - 5.0).abs() < 1e-12));
        }
    }

    #[test]
    fn a_sheet_around_a_cylinder_has_its_curvature() {
        let mut world = sheet("shell");
        let sheet = &mut world.sheets_mut()[0];
        let radius = 0.2;
        for i in 0..sheet.node_count() {
            let p = sheet.state.x.get(i);
            let angle = p.x / radius;
            sheet.state.x.set(i, DVec3::new(radius * angle.sin(), radius * angle.cos(), p.z));
        }
        let mut out = Vec::new();
        bending(sheet, &mut out);
        let middle = out[4 * 9 + 4];
        assert!((middle / 5.0 - 1.0).abs() < 0.02, "{middle}");
    }
}
