//! Removal of redundant constraints between two sheets.
//!
//! A node over an edge or a corner of the other sheet's triangles is over all triangles there, and
//! two coincident nodes are each over the other. These constraints are equivalent; duplicates cost
//! solver time and leave the distribution of the force undetermined.

use glam::DVec3;

use crate::collision::constraint::{ContactConstraint, ContactSide, SheetPoint};
use crate::collision::narrow_phase::feature_keys::{FeatureKind, feature_key};
use crate::collision::narrow_phase::{DetectionInput, SheetStageMotion};
use crate::collision::settings::{DetectionSettings, DuplicateSettings};

const SETTINGS: DuplicateSettings = DetectionSettings::DEFAULT.duplicates;

/// Remove from `constraints` those equivalent to an earlier one. `constraints` is sorted by unique
/// keys; `keep` is a buffer.
pub(crate) fn prune(problem: &DetectionInput, constraints: &mut Vec<ContactConstraint>, keep: &mut Vec<bool>) {
    keep.clear();
    keep.resize(constraints.len(), true);
    let mut first = 0;
    while first < constraints.len() {
        let key = constraints[first].key[0];
        let count = constraints[first..].iter().take_while(|row| row.key[0] == key).count();
        for i in first..first + count {
            let Some((sheet, on)) = node_on_sheet(&constraints[i]) else { continue };
            let again = |j: usize| {
                keep[j]
                    && node_on_sheet(&constraints[j]).is_some_and(|(s, _)| s == sheet)
                    && is_equivalent(problem, &constraints[i], &constraints[j])
            };
            let twice = (first..i).any(again) || is_mirrored(problem, constraints, keep, i, (sheet, &on));
            keep[i] = !twice;
        }
        first += count;
    }
    let mut kept = keep.iter();
    constraints.retain(|_| kept.next().is_none_or(|k| *k));
}

/// Sheet and point touched by the node of a constraint; `None` for other kinds of constraints.
fn node_on_sheet(row: &ContactConstraint) -> Option<(u32, SheetPoint)> {
    match (row.a, row.b) {
        (ContactSide::Sheet { point, .. }, ContactSide::Sheet { sheet, point: on }) if point.weights[0] == 1.0 => {
            Some((sheet, on))
        }
        _ => None,
    }
}

fn place(problem: &DetectionInput, side: &ContactSide) -> Option<DVec3> {
    match side {
        ContactSide::Sheet { sheet, point } => {
            problem.sheets.get(*sheet as usize).map(|s: &SheetStageMotion| point.position(s.end))
        }
        ContactSide::Body { .. } => None,
    }
}

fn is_equivalent(problem: &DetectionInput, row: &ContactConstraint, other: &ContactConstraint) -> bool {
    let apart = place(problem, &row.b).zip(place(problem, &other.b)).map(|(p, q)| p.distance(q));
    row.normal.dot(other.normal) > SETTINGS.normal_cosine
        && apart.is_some_and(|d| d < SETTINGS.point_distance * row.offset)
}

/// Whether constraint `i`, of a node at a node of `sheet`, exists with both nodes exchanged and a
/// lower key.
fn is_mirrored(
    problem: &DetectionInput,
    constraints: &[ContactConstraint],
    keep: &[bool],
    i: usize,
    (sheet, on): (u32, &SheetPoint),
) -> bool {
    let ContactSide::Sheet { sheet: own, point } = constraints[i].a else { return false };
    let Some(at) = (0..3).find(|k| on.weights[*k] > SETTINGS.node_weight).map(|k| on.nodes[k]) else { return false };
    let Some(id) = problem.sheets.get(sheet as usize).map(|s| s.id) else { return false };
    let key = feature_key(FeatureKind::Node, id, at);
    if key >= constraints[i].key[0] {
        return false;
    }
    let from = constraints.partition_point(|row| row.key[0] < key);
    let others = constraints[from..].iter().zip(&keep[from..]).take_while(|(row, _)| row.key[0] == key);
    others.filter(|(_, keep)| **keep).any(|(row, _)| {
        let back = node_on_sheet(row).filter(|(s, _)| *s == own);
        let meets = back
            .is_some_and(|(_, p)| (0..3).any(|k| p.weights[k] > SETTINGS.node_weight && p.nodes[k] == point.nodes[0]));
        meets && row.normal.dot(constraints[i].normal) < -SETTINGS.normal_cosine
    })
}
