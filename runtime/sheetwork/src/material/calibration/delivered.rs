//! Delivered stiffness of a lattice, compared with the request.
//!
//! Ratios of the homogenised lattice to the target: bending and membrane stiffness along four
//! directions, twist, Poisson's ratio, and the loss to transverse shear in a wave as long as the
//! sheet. Notes describe the limits of the structure.

use crate::material::calibration::cell::{LatticePattern, PeriodicCell};
use crate::material::calibration::free_edge::EdgeStiffness;
use crate::material::calibration::homogenise::{PlateStiffness, homogenise, wave_bending};
use crate::material::calibration::target::{ENTRIES, StiffnessTarget, Voigt, along, norm, ratio};
use crate::material::calibration::{CalibrationRequest, isotropic_rows};

/// Delivered stiffness of a sheet's structure.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct DeliveredRatios {
    /// Bending stiffness along 0, 45, 90 and 135 degrees from the length, over that requested.
    pub bending: [f64; 4],
    /// Twisting stiffness D66 over that requested.
    pub twist: f64,
    /// Coupling of bending along the length with twist, D16/D11; 0 without coupling.
    pub bend_to_twist: f64,
    /// Membrane stiffness over that requested: mean of the four directions.
    pub membrane: f64,
    /// Membrane stiffness along the length with free contraction across, N/m.
    pub stretch: f64,
    /// Poisson's ratio in bending: D12 over the geometric mean of D11 and D22; 0 without bending
    /// stiffness.
    pub poisson_ratio: f64,
    /// Fraction of the bending stiffness that transverse shear and the grid remove in a wave of the
    /// given length, the largest of the four directions; `None` without bending stiffness.
    pub shear_loss: Option<f64>,
    /// Wavelength of `shear_loss`, m.
    pub wavelength: f64,
    /// Norm of the difference of the bending stiffness from the target over the norm of the target.
    pub residual: f64,
    /// Width missing in bending and in twist of a strip along the length between two free sides, m;
    /// negative is missing.
    pub missing_sides: (f64, f64),
    /// Width missing in bending and in twist of a strip along the width between two free ends, m.
    pub missing_ends: (f64, f64),
    /// Limits of the structure, in plain words.
    pub notes: Vec<String>,
}

/// Directions in which stiffness is compared, degrees from the length.
const DIRECTIONS: [f64; 4] = [0.0, 45.0, 90.0, 135.0];

impl DeliveredRatios {
    /// Values of a structure that has the requested stiffness by construction.
    pub fn exact(target: &StiffnessTarget) -> Self {
        Self {
            bending: [1.0; 4],
            twist: 1.0,
            membrane: 1.0,
            stretch: uniaxial(&target.membrane),
            poisson_ratio: target.poisson(),
            shear_loss: Some(0.0),
            ..Self::default()
        }
    }

    /// Values of a calibrated lattice.
    pub(crate) fn of(
        request: &CalibrationRequest,
        pattern: &LatticePattern,
        cell: &PeriodicCell,
        k: &[f64],
        edges: &EdgeStiffness,
    ) -> Self {
        let plate = homogenise(cell, k);
        let (bending, membrane) = (plate.free_bending(), plate.free_membrane());
        let target = &request.target;
        let over = |found: &Voigt, asked: &Voigt| DIRECTIONS.map(|a| share(found, asked, a.to_radians()));
        let poisson_ratio = ratio(bending[0][1], (bending[0][0] * bending[1][1]).sqrt());
        let wavelength = request.wavelength.unwrap_or(request.size.0.max(request.size.1));
        let in_metres = |(bend, twist): (f64, f64), spacing: f64| (bend * spacing, twist * spacing);
        let mut found = Self {
            bending: over(&bending, &target.bending),
            twist: ratio(bending[2][2], target.bending[2][2]),
            bend_to_twist: ratio(bending[0][2], bending[0][0]),
            membrane: over(&membrane, &target.membrane).iter().sum::<f64>() / 4.0,
            stretch: uniaxial(&membrane),
            poisson_ratio,
            shear_loss: shear_loss(cell, k, &bending, target, wavelength),
            wavelength,
            residual: difference(&bending, &target.bending),
            missing_sides: in_metres(edges.sides.missing, pattern.spacing.1),
            missing_ends: in_metres(edges.ends.missing, pattern.spacing.0),
            notes: Vec::new(),
        };
        found.clean();
        found.notes = notes(&found, request, pattern, edges, &plate);
        found
    }

    /// Whether the bending stiffness is as requested in every direction, within `tolerance` (a
    /// fraction).
    pub fn bends_within(&self, tolerance: f64) -> bool {
        self.bending.iter().all(|b| (b - 1.0).abs() <= tolerance)
    }

    /// Set rounding errors of the elimination to zero.
    fn clean(&mut self) {
        let values = [&mut self.twist, &mut self.bend_to_twist, &mut self.poisson_ratio];
        values.into_iter().filter(|v| v.abs() < 1e-9).for_each(|v| *v = 0.0);
        self.bending.iter_mut().filter(|v| v.abs() < 1e-9).for_each(|v| *v = 0.0);
    }
}

fn share(found: &Voigt, asked: &Voigt, angle: f64) -> f64 {
    ratio(along(found, angle), along(asked, angle))
}

/// Norm of the difference over the norm of the request.
fn difference(found: &Voigt, asked: &Voigt) -> f64 {
    let mut apart = Voigt::default();
    for (i, j, _) in ENTRIES {
        apart[i][j] = found[i][j] - asked[i][j];
    }
    ratio(norm(&apart), norm(asked))
}

/// Membrane stiffness along the length with free contraction across.
fn uniaxial(a: &Voigt) -> f64 {
    a[0][0] - ratio(a[0][1] * a[0][1], a[1][1])
}

fn shear_loss(
    cell: &PeriodicCell,
    k: &[f64],
    bending: &Voigt,
    target: &StiffnessTarget,
    wavelength: f64,
) -> Option<f64> {
    let stiff = |angle: f64| share(bending, &target.bending, angle) > 1e-6;
    let angles = DIRECTIONS.iter().map(|a| a.to_radians()).filter(|a| stiff(*a));
    let losses = angles.filter_map(|a| Some(1.0 - wave_bending(cell, k, wavelength, a)? / along(bending, a)));
    losses.reduce(f64::max)
}

/// Notes on the limits of the structure.
fn notes(
    found: &DeliveredRatios,
    request: &CalibrationRequest,
    pattern: &LatticePattern,
    edges: &EdgeStiffness,
    plate: &PlateStiffness,
) -> Vec<String> {
    let mut notes = Vec::new();
    if norm(&plate.bending) < 1e-9 * norm(&request.target.bending) {
        let name = request.structure;
        let skips = if name.info().flexion || request.cross_over {
            ": second neighbours resist only a fold already made, with an energy of the fourth power of its angle"
        } else {
            ""
        };
        notes.push(format!(
            "one layer of {name} has no bending stiffness while it is flat{skips}; only its membrane is as asked"
        ));
    } else {
        bending_notes(found, request, pattern, &mut notes);
        edge_notes(edges, pattern, &mut notes);
    }
    membrane_note(found, &mut notes);
    notes
}

fn bending_notes(
    found: &DeliveredRatios,
    request: &CalibrationRequest,
    pattern: &LatticePattern,
    notes: &mut Vec<String>,
) {
    let name = request.structure;
    if found.twist < 0.05 {
        notes.push(format!("{name} has no twist stiffness: a strip bends as asked, a plate folds along its diagonals"));
    }
    if found.bend_to_twist.abs() > 0.01 {
        notes.push(format!(
            "one diagonal a cell: bending turns into twist, D16/D11 = {:.2}; stiffness along 45 and 135 degrees \
             differs {:.2} to {:.2}",
            found.bend_to_twist, found.bending[1], found.bending[3]
        ));
    }
    if !found.bends_within(0.005) {
        let [low, high] = [f64::min, f64::max].map(|pick| found.bending.iter().copied().fold(found.bending[0], pick));
        notes.push(format!("bends with {low:.3} to {high:.3} of the stiffness asked, by direction"));
    }
    let rows = isotropic_rows(request.structure, request.grid.0, request.size);
    if let Some(rows) = rows.filter(|rows| *rows != request.grid.2) {
        notes.push(format!(
            "rows are {:.3} of the spacing apart; triangles are equilateral, and bend alike in all directions, at \
             0.866: nearest with {rows} rows",
            pattern.spacing.1 / pattern.spacing.0
        ));
    }
    let asked = request.target.poisson();
    if (found.poisson_ratio - asked).abs() > 0.005 {
        notes.push(format!(
            "Poisson's ratio is {:.3}, asked {asked:.3}: springs have one of their own; twist is {:.3} of that asked",
            found.poisson_ratio, found.twist
        ));
    }
    if let Some(loss) = found.shear_loss.filter(|loss| *loss > 0.02) {
        let percent = 100.0 * loss;
        notes.push(format!(
            "a wave of {:.3} m bends {percent:.1} % too softly: shear between the layers",
            found.wavelength
        ));
    }
}

fn edge_notes(edges: &EdgeStiffness, pattern: &LatticePattern, notes: &mut Vec<String>) {
    for (name, factors, spacing) in
        [("sides", &edges.sides, pattern.spacing.1), ("ends", &edges.ends, pattern.spacing.0)]
    {
        let (bend, twist) = factors.missing;
        if bend.abs().max(twist.abs()) > 0.05 {
            let zigzag = if edges.zigzag && name == "ends" { " (zigzags, which no factor mends)" } else { "" };
            notes.push(format!(
                "between free {name}{zigzag} the sheet is {:.2} mm narrower in bending and {:.2} mm in twist",
                -1e3 * bend * spacing,
                -1e3 * twist * spacing
            ));
        }
    }
}

fn membrane_note(found: &DeliveredRatios, notes: &mut Vec<String>) {
    if found.membrane < 0.9 {
        notes.push(format!(
            "membrane {:.0} times softer than the sheet's: right for sag, wrong for stretch; curling across the width \
             is held back less",
            1.0 / found.membrane.max(1e-12)
        ));
    } else if found.membrane > 1.1 {
        notes.push(format!("membrane {:.1} times stiffer than the sheet's", found.membrane));
    }
}
