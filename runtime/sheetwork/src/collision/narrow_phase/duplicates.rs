//! Rows of two sheets that say the same.
//!
//! A mass over an edge or a corner of the other sheet's triangles is over all the triangles there, and where two masses meet each
//! is over the other's. The constraints are one; more than one row for it costs the solver time, and leaves open how they share
//! their force.

use glam::DVec3;

use crate::collision::constraint::{Contact, SheetPoint, Side};
use crate::collision::narrow_phase::feature_keys::{Kind, name};
use crate::collision::narrow_phase::{Problem, SheetMotion};

/// Cosine between normals above which two rows may be one.
const ALIKE: f64 = 0.98;
/// Distance between the points of two rows, as a fraction of the touching distance, below which they may be one.
const SAME: f64 = 0.05;
/// Weight of a mass above which the point is taken for it.
const MASS: f64 = 0.98;

/// Removes from `rows`, which are sorted by their keys and of which each is there once, those that an earlier one says too.
pub(crate) fn prune(problem: &Problem, rows: &mut Vec<Contact>, keep: &mut Vec<bool>) {
    keep.clear();
    keep.resize(rows.len(), true);
    let mut first = 0;
    while first < rows.len() {
        let key = rows[first].key[0];
        let count = rows[first..].iter().take_while(|row| row.key[0] == key).count();
        for i in first..first + count {
            let Some((sheet, on)) = mass_on_sheet(&rows[i]) else { continue };
            let again = |j: usize| {
                keep[j] && mass_on_sheet(&rows[j]).is_some_and(|(s, _)| s == sheet) && same(problem, &rows[i], &rows[j])
            };
            let twice = (first..i).any(again) || is_told_by_other(problem, rows, keep, i, (sheet, &on));
            keep[i] = !twice;
        }
        first += count;
    }
    let mut kept = keep.iter();
    rows.retain(|_| kept.next().is_none_or(|k| *k));
}

/// Of a row of a mass with a sheet, the sheet and the point on it.
fn mass_on_sheet(row: &Contact) -> Option<(u32, SheetPoint)> {
    match (row.a, row.b) {
        (Side::Sheet { point, .. }, Side::Sheet { sheet, point: on }) if point.weights[0] == 1.0 => Some((sheet, on)),
        _ => None,
    }
}

fn place(problem: &Problem, side: &Side) -> Option<DVec3> {
    match side {
        Side::Sheet { sheet, point } => problem.sheets.get(*sheet as usize).map(|s: &SheetMotion| point.of(s.end)),
        Side::Body { .. } => None,
    }
}

fn same(problem: &Problem, row: &Contact, other: &Contact) -> bool {
    let apart = place(problem, &row.b).zip(place(problem, &other.b)).map(|(p, q)| p.distance(q));
    row.normal.dot(other.normal) > ALIKE && apart.is_some_and(|d| d < SAME * row.offset)
}

/// Whether row `i`, of a mass at a mass of `sheet`, is there the other way round, and that is the one to keep.
fn is_told_by_other(
    problem: &Problem,
    rows: &[Contact],
    keep: &[bool],
    i: usize,
    (sheet, on): (u32, &SheetPoint),
) -> bool {
    let Side::Sheet { sheet: own, point } = rows[i].a else { return false };
    let Some(at) = (0..3).find(|k| on.weights[*k] > MASS).map(|k| on.masses[k]) else { return false };
    let Some(id) = problem.sheets.get(sheet as usize).map(|s| s.id) else { return false };
    let key = name(Kind::Mass, id, at);
    if key >= rows[i].key[0] {
        return false;
    }
    let from = rows.partition_point(|row| row.key[0] < key);
    let others = rows[from..].iter().zip(&keep[from..]).take_while(|(row, _)| row.key[0] == key);
    others.filter(|(_, keep)| **keep).any(|(row, _)| {
        let back = mass_on_sheet(row).filter(|(s, _)| *s == own);
        let meets = back.is_some_and(|(_, p)| (0..3).any(|k| p.weights[k] > MASS && p.masses[k] == point.masses[0]));
        meets && row.normal.dot(rows[i].normal) < -ALIKE
    })
}
