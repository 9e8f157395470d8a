//! Removal of redundant constraints between two sheets.
//!
//! A node over an edge or a corner of the other sheet's triangles is over all triangles there, and
//! two coincident nodes are each over the other. These constraints are equivalent; duplicates cost
//! solver time and leave the distribution of the force undetermined.

use glam::DVec3;

use crate::collision::constraint::{Contact, SheetPoint, Side};
use crate::collision::narrow_phase::feature_keys::{Kind, name};
use crate::collision::narrow_phase::{Problem, SheetMotion};
use crate::collision::settings::{DetectionSettings, DuplicateSettings};

const SETTINGS: DuplicateSettings = DetectionSettings::DEFAULT.duplicates;

/// Remove from `rows` those equivalent to an earlier one. `rows` is sorted by unique keys; `keep`
/// is a buffer.
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

/// Sheet and point touched by the node of a constraint; `None` for other kinds of constraints.
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
    row.normal.dot(other.normal) > SETTINGS.normal_cosine
        && apart.is_some_and(|d| d < SETTINGS.point_distance * row.offset)
}

/// Whether constraint `i`, of a node at a node of `sheet`, exists with both nodes exchanged and a
/// lower key.
fn is_told_by_other(
    problem: &Problem,
    rows: &[Contact],
    keep: &[bool],
    i: usize,
    (sheet, on): (u32, &SheetPoint),
) -> bool {
    let Side::Sheet { sheet: own, point } = rows[i].a else { return false };
    let Some(at) = (0..3).find(|k| on.weights[*k] > SETTINGS.node_weight).map(|k| on.masses[k]) else { return false };
    let Some(id) = problem.sheets.get(sheet as usize).map(|s| s.id) else { return false };
    let key = name(Kind::Mass, id, at);
    if key >= rows[i].key[0] {
        return false;
    }
    let from = rows.partition_point(|row| row.key[0] < key);
    let others = rows[from..].iter().zip(&keep[from..]).take_while(|(row, _)| row.key[0] == key);
    others.filter(|(_, keep)| **keep).any(|(row, _)| {
        let back = mass_on_sheet(row).filter(|(s, _)| *s == own);
        let meets = back.is_some_and(|(_, p)| {
            (0..3).any(|k| p.weights[k] > SETTINGS.node_weight && p.masses[k] == point.masses[0])
        });
        meets && row.normal.dot(rows[i].normal) < -SETTINGS.normal_cosine
    })
}
