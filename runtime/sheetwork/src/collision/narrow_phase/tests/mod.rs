//! Detection cases whose contacts follow from geometry alone.

pub(crate) mod bodies;
pub(crate) mod random;
pub(crate) mod sheets;

use glam::DVec3;

use crate::collision::constraint::{ContactSide, SheetPoint};
use crate::collision::features::ColliderFeatures;
use crate::collision::narrow_phase::*;

/// Half thickness of the test sheets, m.
pub const HALF: f64 = 2.5e-4;

/// Detection margin of the tests, m.
pub const MARGIN: f64 = 2e-4;

/// A grid of `n` by `n` nodes over a square of side `size` (m), centred at the origin in the plane
/// y = 0.
pub fn square(n: u32, size: f64) -> Vectors {
    let mut x = Vectors::default();
    let step = size / f64::from(n - 1);
    for j in 0..n {
        for i in 0..n {
            x.push(DVec3::new(f64::from(i) * step - 0.5 * size, 0.0, f64::from(j) * step - 0.5 * size));
        }
    }
    x
}

/// Collision surface of such a grid, with alternating diagonals.
pub fn ensure_collision_surface(n: u32, rest: &Vectors) -> CollisionSurface {
    let mut triangles = Vec::new();
    for j in 0..n - 1 {
        for i in 0..n - 1 {
            let (a, c) = (j * n + i, (j + 1) * n + i);
            let (b, d) = (a + 1, c + 1);
            let halves = if (i + j) % 2 == 0 { [[a, c, d], [a, d, b]] } else { [[a, c, b], [b, c, d]] };
            triangles.extend(halves);
        }
    }
    CollisionSurface::new(&triangles, rest, HALF, true)
}

/// Positions mapped by a function.
pub fn mapped(x: &Vectors, f: impl Fn(DVec3) -> DVec3) -> Vectors {
    let mut y = Vectors::default();
    x.iter().for_each(|p| y.push(f(p)));
    y
}

pub fn shifted(x: &Vectors, by: DVec3) -> Vectors {
    mapped(x, |p| p + by)
}

pub fn still(id: u32, features: &ColliderFeatures) -> BodyStageMotion<'_> {
    let here = RigidFrame::IDENTITY;
    BodyStageMotion { id, features, start: here, base: here, end: here, awake: false }
}

pub fn moved<'a>(id: u32, skin: &'a CollisionSurface, start: &'a Vectors, end: &'a Vectors) -> SheetStageMotion<'a> {
    SheetStageMotion { id, skin, start, base: start, end, awake: true }
}

/// All constraints of some sheets and bodies in a stage of 10 ms.
pub fn rows(sheets: &[SheetStageMotion], bodies: &[BodyStageMotion]) -> Vec<ContactConstraint> {
    let problem =
        DetectionInput { sheets, bodies, margin: MARGIN, fall: 1e-3, between: Some(MARGIN), surfaces: &|_| (0.3, 0.1) };
    let mut finder = CollisionDetector::default();
    finder.run_broad_phase(&problem, 10.0);
    let mut out = Vec::new();
    finder.detect_contacts(&problem, &mut out);
    for row in &out {
        assert!((row.normal.length() - 1.0).abs() < 1e-9, "{row:?}");
        let ContactSide::Sheet { point, .. } = row.a else { panic!("a sheet is always the first side") };
        assert!((point.weights.iter().sum::<f64>() - 1.0).abs() < 1e-9 && point.weights.iter().all(|w| *w >= 0.0));
    }
    assert!(out.windows(2).all(|w| w[0].key < w[1].key), "doubled or out of order");
    out
}

/// World position of one side of a constraint, with the sheets at `x` and the bodies at `frames`,
/// m.
pub fn place(side: &ContactSide, x: &[&Vectors], frames: &[RigidFrame]) -> DVec3 {
    match side {
        ContactSide::Sheet { sheet, point } => point.position(x[*sheet as usize]),
        ContactSide::Body { body, local } => frames[*body as usize].world(*local),
    }
}

pub fn gap(row: &ContactConstraint, x: &[&Vectors], frames: &[RigidFrame]) -> f64 {
    row.normal.dot(place(&row.a, x, frames) - place(&row.b, x, frames)) - row.offset
}

/// Number of nodes on the first side of a constraint.
pub fn carriers(row: &ContactConstraint) -> usize {
    let ContactSide::Sheet { point, .. } = row.a else { return 0 };
    point.terms().count()
}
