//! Cuts: the parts of the given polylines inside the sheet, and their junctions with the boundary
//! and each other.
//!
//! All in cells. A cut that ends near the boundary ends on it; one that extends out of the sheet is
//! clipped there.

use glam::DVec2;

use crate::error::{InputError, reject_if};
use crate::mesh::outline::Outline;
use crate::mesh::outline::line::{CellScale, OutlineLine};
use crate::mesh::outline::ring::{foot, meeting};

/// Distance from a line below which a point is on it, cells.
const ON_LINE_DISTANCE: f64 = 0.05;
/// Distance of a junction from a corner or another junction below which they are merged, cells.
const MERGE_DISTANCE: f64 = 0.3;
/// Minimum length of a part of a cut, and minimum distance of its end from the boundary, cells.
const MIN_CUT_LENGTH: f64 = 0.5;

/// Junction of a polyline with a ring.
#[derive(Clone, Copy, Debug)]
struct Junction {
    /// Arc length on the cut.
    at: f64,
    ring: usize,
    /// Arc length on the ring.
    on_ring: f64,
}

/// Parts of all cuts inside the sheet. Their junctions become stops of `rings`.
///
/// # Errors
/// When a cut lies outside the sheet, or a feature of it is smaller than half a cell.
pub fn pieces(outline: &Outline, rings: &mut [OutlineLine], cells: &CellScale) -> Result<Vec<OutlineLine>, InputError> {
    let mut pieces = Vec::new();
    for (i, cut) in outline.cuts().iter().enumerate() {
        let field = format!("cuts.{i}");
        let line = OutlineLine::new(cut, false, &field, cells)?;
        reject_if!(line.points.len() < 2, field, "has no length");
        let before = pieces.len();
        inside(outline, &line, rings, cells, &mut pieces)?;
        reject_if!(pieces.len() == before, field, "lies outside the sheet");
    }
    cross(&mut pieces, cells)?;
    Ok(pieces)
}

fn nearest_on(line: &OutlineLine, p: DVec2) -> (f64, f64) {
    let mut best = (f64::INFINITY, 0.0);
    for (i, (a, b)) in line.sides().enumerate() {
        let t = foot(p, a, b);
        let d = p.distance(a.lerp(b, t));
        if d < best.0 {
            best = (d, line.arc[i] + t * a.distance(b));
        }
    }
    best
}

fn meetings(line: &OutlineLine, rings: &[OutlineLine]) -> Vec<Junction> {
    let length = line.length();
    let mut found = Vec::new();
    for (ring, r) in rings.iter().enumerate() {
        for (at, end) in [(0.0, line.points[0]), (length, line.points[line.points.len() - 1])] {
            let (d, on_ring) = nearest_on(r, end);
            if d < ON_LINE_DISTANCE {
                found.push(Junction { at, ring, on_ring });
            }
        }
        for (i, side) in line.sides().enumerate() {
            for (j, other) in r.sides().enumerate() {
                let Some((s, t)) = meeting(side, other) else { continue };
                let at = line.arc[i] + s * side.0.distance(side.1);
                if at > ON_LINE_DISTANCE && at < length - ON_LINE_DISTANCE {
                    found.push(Junction { at, ring, on_ring: r.arc[j] + t * other.0.distance(other.1) });
                }
            }
        }
    }
    found.sort_by(|a, b| a.at.total_cmp(&b.at).then(a.ring.cmp(&b.ring)));
    // A line through a point of a ring meets both its sides.
    found.dedup_by(|b, a| (b.at - a.at).abs() < 1e-9);
    found
}

fn inside(
    outline: &Outline,
    line: &OutlineLine,
    rings: &mut [OutlineLine],
    cells: &CellScale,
    pieces: &mut Vec<OutlineLine>,
) -> Result<(), InputError> {
    let length = line.length();
    let found = meetings(line, rings);
    let mut ends: Vec<(f64, Option<Junction>)> = found.iter().map(|m| (m.at, Some(*m))).collect();
    if ends.first().is_none_or(|e| e.0 > 0.0) {
        ends.insert(0, (0.0, None));
    }
    if ends.last().is_none_or(|e| e.0 < length) {
        ends.push((length, None));
    }
    for pair in ends.windows(2) {
        let (from, to) = (pair[0], pair[1]);
        let middle = line.at(0.5 * (from.0 + to.0));
        if !outline.contains(cells.metres(middle)) {
            continue;
        }
        let mut piece = line.part(from.0, to.0);
        for (last, end) in [(false, from), (true, to)] {
            if let Some(m) = end.1 {
                let junction = rings[m.ring].stop(m.on_ring, MERGE_DISTANCE);
                piece.move_end(last, junction);
            } else {
                check_end(&piece, last, rings, cells)?;
            }
        }
        if piece.length() < MIN_CUT_LENGTH {
            let size = cells.distance(piece.points[0], line.at(to.0));
            return Err(cells.too_small(&piece.field, "has a part of", size, middle));
        }
        pieces.push(piece);
    }
    Ok(())
}

fn check_end(piece: &OutlineLine, last: bool, rings: &[OutlineLine], cells: &CellScale) -> Result<(), InputError> {
    let p = piece.points[if last { piece.points.len() - 1 } else { 0 }];
    for ring in rings {
        let (d, s) = nearest_on(ring, p);
        if d < MIN_CUT_LENGTH {
            let size = cells.distance(p, ring.at(s));
            return Err(cells.too_small(&piece.field, &format!("leaves, to {},", ring.field), size, p));
        }
    }
    Ok(())
}

/// Add stops where pieces cross or end on each other.
fn cross(pieces: &mut [OutlineLine], cells: &CellScale) -> Result<(), InputError> {
    for i in 0..pieces.len() {
        for j in 0..pieces.len() {
            if i == j {
                continue;
            }
            for last in [false, true] {
                let end = pieces[i].points[if last { pieces[i].points.len() - 1 } else { 0 }];
                let (d, s) = nearest_on(&pieces[j], end);
                if d < ON_LINE_DISTANCE && s > MERGE_DISTANCE && s < pieces[j].length() - MERGE_DISTANCE {
                    let to = pieces[j].stop(s, MERGE_DISTANCE);
                    pieces[i].move_end(last, to);
                } else if d < ON_LINE_DISTANCE {
                    let to = pieces[j].points[if s > MERGE_DISTANCE { pieces[j].points.len() - 1 } else { 0 }];
                    pieces[i].move_end(last, to);
                }
            }
        }
    }
    for j in 0..pieces.len() {
        for i in 0..=j {
            for (s, t) in crossings(&pieces[i], &pieces[j], i == j) {
                let point = pieces[i].stop(s, MERGE_DISTANCE);
                let other = pieces[j].stop(t, MERGE_DISTANCE);
                if point.distance(other) > MERGE_DISTANCE {
                    let size = cells.distance(point, other);
                    let what = format!("has corners and crossings with {} within", pieces[i].field);
                    return Err(cells.too_small(&pieces[j].field, &what, size, point));
                }
                pieces[j].replace_stop(other, point);
            }
        }
    }
    Ok(())
}

/// Arc lengths at which two lines cross, or one (`same`) crosses itself.
fn crossings(a: &OutlineLine, b: &OutlineLine, same: bool) -> Vec<(f64, f64)> {
    let mut found: Vec<(f64, f64)> = Vec::new();
    let within = |line: &OutlineLine, s: f64| s > ON_LINE_DISTANCE && s < line.length() - ON_LINE_DISTANCE;
    for (i, p) in a.sides().enumerate() {
        for (j, q) in b.sides().enumerate().skip(if same { i + 2 } else { 0 }) {
            if let Some((s, t)) = meeting(p, q) {
                let at = (a.arc[i] + s * p.0.distance(p.1), b.arc[j] + t * q.0.distance(q.1));
                if within(a, at.0) && within(b, at.1) && found.iter().all(|f| (f.0 - at.0).abs() > 1e-9) {
                    found.push(at);
                }
            }
        }
    }
    found
}
