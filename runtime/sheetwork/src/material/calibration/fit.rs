//! Spring stiffness from plate stiffness.
//!
//! The springs of a layer run along at most four lines (x, z, two diagonals). Springs of unit
//! stiffness along one line make a plate of known A, B, D; a sheet is a sum of such plates with
//! non-negative stiffnesses, so the best sheet is found by [`nonnegative_least_squares`] on the
//! stiffness tensors (their norms do not depend on the choice of axes).
//!
//! Bending has priority: layers with the membrane stiffness of the material would have to be t/√3
//! apart, so thin that bending snaps one through the other. The membrane is therefore fitted with a
//! weight too small to affect bending. All layers are equal; with an odd number of three or more,
//! the middle one, which bending does not strain, supplies the membrane. One layer has no bending
//! stiffness when flat, and its membrane is fitted.
//!
//! - Springs between layers are chosen first, from the transverse shear that they transmit: k = 8
//!   D/s² shared by the gaps between layers. That is 4 A_l for two layers, with A_l the membrane
//!   stiffness of each (D = A_l s²/2). They do not contribute to the D of two layers; where more
//!   layers make them resist twist, they are reduced to the twist stiffness of the target.
//! - Second neighbours (flexion, cross-over) run along the same lines: on a flat sheet they are
//!   longer springs of that line, without linear bending stiffness of their own. They get a given
//!   fraction of the stiffness of their line.

use glam::{DVec2, DVec3};

use crate::material::calibration::cell::{CellSpring, LatticePattern, PeriodicCell};
use crate::material::calibration::homogenise::{PlateStiffness, affine, homogenise};
use crate::material::calibration::nnls::nonnegative_least_squares;
use crate::material::calibration::target::{ENTRIES, StiffnessTarget, Voigt, norm};
use crate::mesh::spring_class::SpringClass;

/// Stiffness of springs between layers, all gaps together, in bending stiffnesses per gap squared.
const INTER_LAYER_STIFFNESS: f64 = 8.0;

/// Weight of the membrane in a fit for bending: its square must be negligible.
const MEMBRANE_WEIGHT: f64 = 1e-4;

/// Lines of the springs of a layer, as directions in (x, z); `None` where the structure has no such
/// spring.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct SpringLines([Option<DVec2>; 4]);

impl SpringLines {
    /// Lines of a cell.
    pub fn of(cell: &PeriodicCell) -> Self {
        let mut lines = Self::default();
        for bond in &cell.springs {
            if let Some(line) = first_neighbour(bond.class) {
                lines.0[line] = Some(flat(bond.to - bond.from).normalize_or_zero());
            }
        }
        lines
    }

    /// Line of a spring, and whether it joins second neighbours; `None` between layers.
    pub fn of_spring(&self, class: SpringClass, span: DVec3) -> Option<(usize, bool)> {
        if let Some(line) = first_neighbour(class) {
            return Some((line, false));
        }
        let along = flat(span).normalize_or_zero();
        let parallel = |d: &Option<DVec2>| d.is_some_and(|d| d.perp_dot(along).abs() < 1e-9);
        (class != SpringClass::Inter).then(|| self.0.iter().position(parallel)).flatten().map(|line| (line, true))
    }

    fn count(&self) -> usize {
        self.0.len()
    }
}

fn flat(v: DVec3) -> DVec2 {
    DVec2::new(v.x, v.z)
}

fn first_neighbour(class: SpringClass) -> Option<usize> {
    match class {
        SpringClass::X => Some(0),
        SpringClass::Z => Some(1),
        SpringClass::Diagonal => Some(2),
        SpringClass::AntiDiagonal => Some(3),
        SpringClass::Inter | SpringClass::Flexion | SpringClass::CrossOver => None,
    }
}

/// Stiffness of every spring of a lattice far from its edges.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct BulkStiffness {
    /// Lines of the layers.
    pub lines: SpringLines,
    /// Stiffness of springs along each line, in every layer, N/m.
    pub line: [f64; 4],
    /// Additional stiffness along each line in the middle layer, N/m.
    pub middle: [f64; 4],
    /// Middle layer, where it has additional stiffness.
    pub middle_layer: Option<u32>,
    /// Stiffness of springs between layers, N/m.
    pub inter: f64,
    /// Stiffness of second neighbours, as a fraction of the first neighbours' in the same layer and
    /// line.
    pub second: f64,
}

impl BulkStiffness {
    /// Stiffness of a spring that spans `span` (m) in `layer`, N/m.
    pub fn stiffness(&self, class: SpringClass, layer: u32, span: DVec3) -> f64 {
        let Some((line, second)) = self.lines.of_spring(class, span) else { return self.inter };
        let extra = if self.middle_layer == Some(layer) { self.middle[line] } else { 0.0 };
        (self.line[line] + extra) * if second { self.second } else { 1.0 }
    }

    /// Stiffness of every bond of a cell, N/m.
    pub fn of_cell(&self, cell: &PeriodicCell) -> Vec<f64> {
        cell.springs.iter().map(|b| self.stiffness(b.class, b.layer, b.to - b.from)).collect()
    }
}

/// Stiffnesses of the lattice closest to `target`. `second` as in [`BulkStiffness`].
pub(crate) fn fit(
    pattern: &LatticePattern,
    cell: &PeriodicCell,
    target: &StiffnessTarget,
    second: f64,
) -> BulkStiffness {
    let lines = SpringLines::of(cell);
    let gaps = f64::from(pattern.layers - 1);
    let inter = if gaps > 0.0 {
        INTER_LAYER_STIFFNESS * target.largest_bending() / (gaps * pattern.gap * pattern.gap)
    } else {
        0.0
    };
    let middle_layer = (pattern.layers >= 3 && pattern.layers % 2 == 1).then_some(pattern.layers / 2);
    let zero = [0.0; 4];
    let mut bulk = BulkStiffness { lines, line: zero, middle: zero, middle_layer, inter, second };
    let mut already = homogenise(cell, &bulk.of_cell(cell));
    let share = inter_share(&lines, target, already.bending[2][2]);
    if share < 1.0 {
        bulk.inter *= share;
        already = homogenise(cell, &bulk.of_cell(cell));
    }
    let weigh = FitWeights::new(pattern, target);
    let wanted = weigh.wanted(&already);
    let unit = |line: usize, middle: bool| {
        affine(cell, |bond: &CellSpring| match lines.of_spring(bond.class, bond.to - bond.from) {
            Some((l, far)) if l == line && (!middle || Some(bond.layer) == middle_layer) => {
                if far {
                    second
                } else {
                    1.0
                }
            }
            _ => 0.0,
        })
    };
    let mut columns: Vec<Vec<f64>> = (0..lines.count()).map(|line| weigh.column(&unit(line, false))).collect();
    if middle_layer.is_some() {
        columns.extend((0..lines.count()).map(|line| weigh.column(&unit(line, true))));
    }
    let found = nonnegative_least_squares(&columns, &wanted);
    for (line, k) in found.iter().enumerate() {
        if line < 4 {
            bulk.line[line] = *k;
        } else {
            bulk.middle[line - 4] = *k;
        }
    }
    bulk
}

/// Fraction of the stiffness between layers that can be kept; `twist` is the D66 (N m) that it
/// contributes.
///
/// The four springs over a square cell resist its in-plane shear, so three or more layers of them
/// resist twist. This contribution may replace missing diagonals, but must leave a part to existing
/// ones.
fn inter_share(lines: &SpringLines, target: &StiffnessTarget, twist: f64) -> f64 {
    let diagonals = lines.0[2].is_some() || lines.0[3].is_some();
    let room = if diagonals { 0.5 } else { 1.0 } * target.bending[2][2];
    if twist > room { room / twist } else { 1.0 }
}

/// Weighting of the stiffness tensors of a plate in a column.
struct FitWeights<'a> {
    target: &'a StiffnessTarget,
    /// Weights of A (m/N), B (1/N) and D (1/(N m)).
    weights: [f64; 3],
}

impl<'a> FitWeights<'a> {
    fn new(pattern: &LatticePattern, target: &'a StiffnessTarget) -> Self {
        let (membrane, bending) = (norm(&target.membrane), norm(&target.bending));
        let layers = f64::from(pattern.layers);
        // Σ y² over layers a gap apart about their middle.
        let spread = layers * (layers * layers - 1.0) / 12.0 * pattern.gap * pattern.gap;
        let weights = if spread > 0.0 {
            // In units of the larger of the requested membrane and that implied by bending: a
            // lattice thinner than the sheet has a stiffer one, which must not affect bending
            // either.
            let scale = membrane.max(layers * bending / spread);
            [MEMBRANE_WEIGHT / scale, pattern.gap / bending, 1.0 / bending]
        } else {
            [1.0 / membrane, 0.0, 0.0]
        };
        Self { target, weights }
    }

    fn column(&self, plate: &PlateStiffness) -> Vec<f64> {
        let entries = |m: &Voigt, scale: f64| ENTRIES.map(|(i, j, weight)| scale * weight.sqrt() * m[i][j]);
        let [membrane, coupling, bending] = self.weights;
        let mut column = Vec::with_capacity(18);
        column.extend(entries(&plate.bending, bending));
        column.extend(entries(&plate.coupling, coupling));
        column.extend(entries(&plate.membrane, membrane));
        column
    }

    /// Request minus the contribution of `already`.
    fn wanted(&self, already: &PlateStiffness) -> Vec<f64> {
        let asked =
            PlateStiffness { membrane: self.target.membrane, coupling: Voigt::default(), bending: self.target.bending };
        self.column(&asked).iter().zip(self.column(already)).map(|(asked, done)| asked - done).collect()
    }
}
