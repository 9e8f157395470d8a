//! Conversion of triangles in the plane to the mesh of a sheet: nodes doubled along cuts, numbered
//! row by row.
//!
//! At a node on a cut, the triangles around it form groups joined by uncut sides; each group gets a
//! node of its own. The end of a cut inside the sheet has one group, and remains one node.

use std::collections::{BTreeMap, BTreeSet};

use glam::DVec2;

use crate::error::InputError;
use crate::mesh::outline::mesh::TriangleMesh;

fn key(a: u32, b: u32) -> (u32, u32) {
    (a.min(b), a.max(b))
}

/// Mesh of `triangles` over `positions` (m), cut along `slits`. Nodes are ordered by `rows`, then
/// along x.
pub fn finish(
    mut positions: Vec<DVec2>,
    mut rows: Vec<i64>,
    mut triangles: Vec<[u32; 3]>,
    slits: &[[u32; 2]],
) -> Result<TriangleMesh, InputError> {
    double(&mut positions, &mut rows, &mut triangles, slits);
    let mut used: Vec<u32> = triangles.iter().flatten().copied().collect::<BTreeSet<_>>().into_iter().collect();
    used.sort_by(|a, b| {
        let (p, q) = (positions[*a as usize], positions[*b as usize]);
        let row = rows[*a as usize].cmp(&rows[*b as usize]);
        row.then(p.x.total_cmp(&q.x)).then(p.y.total_cmp(&q.y)).then(a.cmp(b))
    });
    let mut number = vec![0; positions.len()];
    for (new, old) in used.iter().enumerate() {
        number[*old as usize] = new as u32;
    }
    for t in &mut triangles {
        let [a, b, c] = t.map(|v| number[v as usize]);
        let first = a.min(b).min(c);
        *t = if first == a {
            [a, b, c]
        } else if first == b {
            [b, c, a]
        } else {
            [c, a, b]
        };
    }
    triangles.sort();
    TriangleMesh::new(used.iter().map(|v| positions[*v as usize].to_array()).collect(), triangles)
}

/// Double the nodes on cuts.
fn double(positions: &mut Vec<DVec2>, rows: &mut Vec<i64>, triangles: &mut [[u32; 3]], slits: &[[u32; 2]]) {
    let cut: BTreeSet<(u32, u32)> = slits.iter().map(|s| key(s[0], s[1])).collect();
    let ends: BTreeSet<u32> = slits.iter().flatten().copied().collect();
    let mut around: BTreeMap<u32, Vec<u32>> = ends.iter().map(|v| (*v, Vec::new())).collect();
    for (k, t) in triangles.iter().enumerate() {
        for v in t {
            if let Some(list) = around.get_mut(v) {
                list.push(k as u32);
            }
        }
    }
    // Groups are determined before any node is renumbered.
    let mut renamed: Vec<(u32, u32, u32)> = Vec::new();
    for (v, list) in &around {
        for group in groups(*v, list, triangles, &cut).into_iter().skip(1) {
            let new = positions.len() as u32;
            positions.push(positions[*v as usize]);
            rows.push(rows[*v as usize]);
            renamed.extend(group.into_iter().map(|k| (k, *v, new)));
        }
    }
    for (k, old, new) in renamed {
        for v in triangles[k as usize].iter_mut().filter(|v| **v == old) {
            *v = new;
        }
    }
}

/// Triangles around a node in groups joined by uncut sides.
fn groups(v: u32, around: &[u32], triangles: &[[u32; 3]], cut: &BTreeSet<(u32, u32)>) -> Vec<Vec<u32>> {
    let mut left: Vec<u32> = around.to_vec();
    let mut groups = Vec::new();
    while !left.is_empty() {
        let mut group = vec![left.remove(0)];
        let mut at = 0;
        while at < group.len() {
            let own = triangles[group[at] as usize];
            let joined = |k: &u32| {
                let other = triangles[*k as usize];
                own.iter().any(|w| *w != v && other.contains(w) && !cut.contains(&key(v, *w)))
            };
            let (next, rest): (Vec<u32>, Vec<u32>) = left.iter().partition(|k| joined(k));
            group.extend(next);
            left = rest;
            at += 1;
        }
        groups.push(group);
    }
    groups
}
