//! Free edges: stiffness factors of the springs beside them.
//!
//! A lattice with a free edge is not a plate with a free edge: rows on the outline represent half a
//! cell, and the smaller layers in between end half a cell inside it. The missing width is measured
//! on a strip of the lattice between two free edges, periodic along its length: curvature or twist
//! is imposed, all else is relaxed, and its stiffness H is compared with that of a plate strip of
//! the same width W (condensed over the curvature across, which is free):
//!
//!   width missing in bending = H11/(D11 - D12²/D22) - W, in twist = H66/(D66 - D26²/D22) - W.
//!
//! Neither depends on W beyond a few cells, so factors on the springs of the edge that make both
//! vanish are a property of the edge. Rows on the outline have the factor ½. The adjusted factors
//! are those of the layers that end inside the outline (of three layers, where only the outer two
//! bend, of those): their outermost row, and the slanting springs between it and the next.
//! Levenberg's method finds them in the logarithms of the factors, with a small weight towards 1
//! that decides only where the strip does not.
//!
//! The zigzag ends of a triangular lattice have no row to adjust and keep 1.

use glam::DVec3;

use crate::material::calibration::ClampedEdges;
use crate::material::calibration::cell::{CellSpring, LatticePattern, LatticeSite, PeriodicCell};
use crate::material::calibration::dense::SymmetricMatrix;
use crate::material::calibration::fit::BulkStiffness;
use crate::material::calibration::homogenise::{relaxed, uniform};
use crate::material::calibration::target::{Voigt, ratio};
use crate::mesh::spring_class::SpringClass;

/// Width of the strip, cells: enough to make its edges independent.
const STRIP_CELLS: u32 = 8;

/// Maximum number of layers for which strips are solved; their cost grows with the third power.
const MAX_STRIP_LAYERS: u32 = 6;

/// Factors of the springs beside a pair of opposite free edges.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct EdgeFactors {
    /// Outermost rows along the edge: in layers that reach it, and in layers that end inside it.
    pub row: [f64; 2],
    /// Slanting springs between those and the next rows, in the same order.
    pub slant: [f64; 2],
    /// Remaining missing width in bending and in twist, both edges together, in cells.
    pub missing: (f64, f64),
}

impl EdgeFactors {
    const PLAIN: Self = Self { row: [0.5, 1.0], slant: [1.0, 1.0], missing: (0.0, 0.0) };
}

/// Factors of all edges of a sheet.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct EdgeStiffness {
    /// Back and front: edges along x.
    pub sides: EdgeFactors,
    /// Left and right: edges along z.
    pub ends: EdgeFactors,
    /// Whether the left and right edges are zigzags.
    pub zigzag: bool,
}

impl EdgeStiffness {
    /// Factors of a lattice with springs `bulk` and plate bending stiffness `bending`.
    pub fn new(pattern: &LatticePattern, bulk: &BulkStiffness, bending: &Voigt) -> Self {
        let zigzag = pattern.structure.info().triangular;
        let mut found = Self { sides: EdgeFactors::PLAIN, ends: EdgeFactors::PLAIN, zigzag };
        if pattern.layers < 2 || pattern.layers > MAX_STRIP_LAYERS {
            return found;
        }
        let along_x = EdgeStrip::new(pattern.strip_along_x(STRIP_CELLS), bulk, bending, zigzag, false);
        found.sides = along_x.balanced(pattern.spacing.1);
        let along_z = EdgeStrip::new(pattern.strip_along_z(STRIP_CELLS), bulk, bending, zigzag, true);
        found.ends = along_z.balanced(pattern.spacing.0);
        found
    }

    /// Stiffness factor of a spring between two sites, of layers with `grid` nodes along x and z.
    pub fn factor(
        &self,
        class: SpringClass,
        a: LatticeSite,
        b: LatticeSite,
        grid: (i64, i64),
        clamped: ClampedEdges,
    ) -> f64 {
        if class == SpringClass::Inter {
            return 1.0;
        }
        let kind = (a.layer % 2) as usize;
        let slants = matches!(class, SpringClass::Diagonal | SpringClass::AntiDiagonal);
        let mut row: f64 = 1.0;
        let mut slant: f64 = 0.0;
        let mut edge = |factors: &EdgeFactors, ends: (i64, i64), border: i64| match (ends.0 == border, ends.1 == border)
        {
            (true, true) => row *= factors.row[kind],
            // A spring in the corner is beside two edges and is adjusted once.
            (true, false) | (false, true) if slants => slant = slant.max(factors.slant[kind]),
            _ => {}
        };
        let borders = [(clamped.back, 0), (clamped.front, grid.1 - 1)];
        borders.iter().filter(|(clamped, _)| !clamped).for_each(|(_, at)| edge(&self.sides, (a.j, b.j), *at));
        if !self.zigzag {
            let borders = [(clamped.left, 0), (clamped.right, grid.0 - 1)];
            borders.iter().filter(|(clamped, _)| !clamped).for_each(|(_, at)| edge(&self.ends, (a.i, b.i), *at));
        }
        if slant > 0.0 { row * slant } else { row }
    }
}

/// Strip between two free edges, and the plate strip that it represents.
struct EdgeStrip {
    cell: PeriodicCell,
    plain: Vec<f64>,
    zigzag: bool,
    /// Whether the strip runs along z, with edges left and right.
    along_z: bool,
    /// Stiffness of the plate per width, N m: bending along the strip, twist.
    plate: (f64, f64),
    /// Adjusted layers: 0 those that reach the edge, 1 those that end inside it.
    adjusted: usize,
}

impl EdgeStrip {
    fn new(cell: PeriodicCell, bulk: &BulkStiffness, d: &Voigt, zigzag: bool, along_z: bool) -> Self {
        let (along, across) = if along_z { (1, 0) } else { (0, 1) };
        let over = |i: usize, j: usize| ratio(d[i][across] * d[j][across], d[across][across]);
        let plate = (d[along][along] - over(along, along), d[2][2] - over(2, 2));
        let adjusted = if cell.grid.len() == 3 { 0 } else { 1 };
        Self { plain: bulk.of_cell(&cell), cell, zigzag, along_z, plate, adjusted }
    }

    /// Width missing in bending and twist, m; zero where the plate has no such stiffness.
    fn missing(&self, factors: &EdgeFactors) -> (f64, f64) {
        let boundary = EdgeStiffness { sides: *factors, ends: *factors, zigzag: self.zigzag };
        // Edges that the strip lacks are marked as clamped: no factor.
        let (ends, sides) = (!self.along_z, self.along_z);
        let none = ClampedEdges { left: ends, right: ends, back: sides, front: sides };
        let stiffness = self.cell.springs.iter().zip(&self.plain).map(|(bond, k)| {
            k * boundary.factor(bond.class, bond.site_a, bond.site_b, self.cell.grid[bond.layer as usize], none)
        });
        let stiffness: Vec<f64> = stiffness.collect();
        let h = relaxed(&self.cell, &stiffness, |bond| self.stretches(bond));
        let (period, width) = if self.along_z { (self.cell.extent.1, self.cell.extent.0) } else { self.cell.extent };
        let (bend, twist) = (free_of(&h, 2), free_of(&h, 3));
        let short = |h: f64, plate: f64| if plate > 1e-6 * self.plate.0 { h / period / plate - width } else { 0.0 };
        (short(bend, self.plate.0), short(twist, self.plate.1))
    }

    /// Elongation of a bond under extension of the strip, bending in its plane, bending out of it,
    /// and twist.
    fn stretches(&self, bond: &CellSpring) -> [f64; 4] {
        // A strip along z is treated with x and z exchanged.
        let turned = |p: DVec3| if self.along_z { DVec3::new(p.z, p.y, p.x) } else { p };
        let (from, to) = (turned(bond.from), turned(bond.to));
        let n = turned(bond.direction());
        let origin = DVec3::X * (0.5 * (from.x + to.x));
        let in_plane = |p: DVec3| DVec3::new(-p.z * p.x, 0.0, 0.5 * p.x * p.x);
        let field = |mode: usize, p: DVec3| match mode {
            0 => uniform(0, p),
            1 => in_plane(p),
            2 => uniform(3, p),
            _ => uniform(5, p),
        };
        std::array::from_fn(|mode| n.dot(field(mode, to - origin) - field(mode, from - origin)))
    }

    /// Factors with the least missing width; `spacing` across the strip, m.
    fn balanced(&self, spacing: f64) -> EdgeFactors {
        let zigzag = self.zigzag && self.along_z;
        let factors = |p: &[f64; 2]| {
            let mut factors = EdgeFactors::PLAIN;
            factors.row[self.adjusted] *= p[0].exp();
            factors.slant[self.adjusted] *= p[1].exp();
            factors
        };
        let residual = |p: &[f64; 2]| {
            let (bend, twist) = self.missing(&factors(p));
            [bend / spacing, twist / spacing, REGULARISATION * p[0], REGULARISATION * p[1]]
        };
        let p = if zigzag { [0.0; 2] } else { levenberg(residual) };
        let [bend, twist, ..] = residual(&p);
        EdgeFactors { missing: (bend, twist), ..factors(&p) }
    }
}

/// Weight of the logarithm of a factor against a missing cell.
const REGULARISATION: f64 = 0.01;

/// Bounds of the logarithms of the factors: rows within a factor of 2, slanting springs within a
/// factor of 5.
const BOUNDS: [f64; 2] = [0.69, 1.61];

/// Energy of mode `kept` when the first two modes are free.
fn free_of(h: &[[f64; 4]; 4], kept: usize) -> f64 {
    let mut matrix = SymmetricMatrix::zeros(2);
    for i in 0..2 {
        for j in 0..2 {
            matrix.add(i, j, h[i][j]);
        }
    }
    let mut load = [vec![h[0][kept], h[1][kept]]];
    matrix.solve(&mut load);
    h[kept][kept] - h[0][kept] * load[0][0] - h[1][kept] * load[0][1]
}

/// Minimise the sum of squares of `residual`, within the bounds, from (0, 0).
fn levenberg(residual: impl Fn(&[f64; 2]) -> [f64; 4]) -> [f64; 2] {
    let cost = |r: &[f64; 4]| r.iter().map(|r| r * r).sum::<f64>();
    let mut p = [0.0_f64; 2];
    let mut r = residual(&p);
    let mut damping = 1e-3;
    for _ in 0..30 {
        let slopes: [[f64; 4]; 2] = std::array::from_fn(|i| {
            let mut moved = p;
            moved[i] += STEP;
            let there = residual(&moved);
            std::array::from_fn(|m| (there[m] - r[m]) / STEP)
        });
        let product = |a: &[f64; 4], b: &[f64; 4]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
        let (a, b, c) = (
            product(&slopes[0], &slopes[0]) + damping,
            product(&slopes[0], &slopes[1]),
            product(&slopes[1], &slopes[1]) + damping,
        );
        let (g, h) = (product(&slopes[0], &r), product(&slopes[1], &r));
        let determinant = a * c - b * b;
        let step = [-(c * g - b * h) / determinant, -(a * h - b * g) / determinant];
        let trial: [f64; 2] = std::array::from_fn(|i| (p[i] + step[i]).clamp(-BOUNDS[i], BOUNDS[i]));
        let there = residual(&trial);
        if cost(&there) < cost(&r) {
            let gain = 1.0 - cost(&there) / cost(&r);
            (p, r) = (trial, there);
            damping *= 0.1;
            if gain < 1e-6 {
                break;
            }
        } else {
            damping *= 10.0;
            if damping > 1e6 {
                break;
            }
        }
    }
    p
}

/// Step of the numerical derivatives.
const STEP: f64 = 1e-4;
