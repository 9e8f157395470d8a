//! Remaining angle of a card that is folded and released.
//!
//! The bending part, of length `length`, is fixed at one end and rotated at the other into an arc
//! of angle θ with curvature κ = θ/length. Then the end is released. For D κ > M_y, return mapping
//! gives κ_p = (D κ - M_y)/(D + H) and the angle
//!
//!   θ_p = length κ_p, M_y = σ_y t²/4,
//!
//! and otherwise zero. The whole section yields at once; D is the stiffness of cylindrical bending,
//! which applies to a card wider than its bending part. The card is in equilibrium throughout,
//! without weight; the fold is applied in increments.

use glam::DVec3;
use serde_json::json;

use crate::measure::{RigResult, Runner, Setup};
use sheetwork::InputError;
use sheetwork::mesh::structure::StructureKind;
use sheetwork::scene::{PinSpec, Region};
use sheetwork::sheet::{Sheet, attachment};

/// Number of increments of the fold.
const STEPS: u32 = 20;

/// Check that the card of the set-up can be folded. Returns its yield stress, Pa.
fn check(setup: &Setup) -> Result<f64, InputError> {
    let nx = setup.grid.0;
    if setup.structure != StructureKind::Shell {
        return Err(InputError::new("structure", format!("only the shell yields, not {}", setup.structure)));
    }
    if nx < 4 {
        return Err(InputError::new("grid", format!("{nx} masses along the card are too few to fold it; it takes 4")));
    }
    let Some(stress) = setup.material.yield_stress else {
        return Err(InputError::new("yield-stress", "is not known of this material"));
    };
    if setup.outlined {
        return Err(InputError::new("outlined", "does not go with a fold, which takes a grid along the card"));
    }
    Ok(stress)
}

pub(crate) fn run(setup: &Setup) -> RigResult {
    let stress = check(setup)?;
    let (nx, nz) = setup.grid;
    // The first and last cell are fixed and straight: half of each is excluded from the bending
    // length.
    let cells = f64::from(nx) - 2.0;
    let spacing = setup.length / cells;
    let length = spacing * f64::from(nx - 1);
    let mut scene = Setup { gravity: 0.0, length, ..setup.clone() }.scene();
    let grip = |first: u32| Region::Masses((0..nz).flat_map(|j| [j * nx + first, j * nx + first + 1]).collect());
    scene.sheets[0].pins.push(PinSpec::fixed(grip(0)));
    scene.sheets[0].pins.push(PinSpec { until: Some(1.0), ..PinSpec::fixed(grip(nx - 2)) });
    scene.sheets[0].plastic = true;
    let mut runner = Runner::new(setup.world(&scene)?);
    let start = scene.sheets[0].placement.position.x - 0.5 * length;
    let angle = setup.angle.to_radians();
    for step in 1..=STEPS {
        bend(
            &mut runner.world.sheets_mut()[0],
            nx,
            (start, spacing),
            angle * f64::from(step) / f64::from(STEPS) / cells,
        );
        runner.world.creep_in_equilibrium(1.0, 1e-9 * length);
    }
    let folded = turned(&runner.world.sheets()[0], nx);
    let stored = runner.world.sheets()[0].energy(DVec3::ZERO).elastic;
    attachment::release_pins(&mut runner.world.sheets_mut()[0], 1.0);
    let solves = runner.bring_to_rest(&Setup { dynamic: false, ..setup.clone() });
    runner.world.creep_in_equilibrium(1.0, 1e-9 * length);
    let sheet = &runner.world.sheets()[0];
    let stiffness = setup.material.plate_stiffness();
    let thickness = setup.material.thickness;
    let moment = 0.25 * stress * thickness * thickness;
    let hardening = setup.material.hardening * thickness.powi(3) / 12.0;
    let curvature = angle / setup.length;
    let stays = ((stiffness * curvature - moment) / (stiffness + hardening)).max(0.0);
    let kept = turned(sheet, nx);
    let keys = json!({
        "angle_deg": kept.to_degrees(),
        "predicted_deg": (stays * setup.length).to_degrees(),
        "folded_deg": folded.to_degrees(),
        "springback_deg": (folded - kept).to_degrees(),
        "fold_length_m": setup.length,
        "yield_stress_pa": stress,
        "yield_moment_n": moment,
        "yield_curvature_per_m": moment / stiffness,
        "stored_when_folded_j": stored,
        "stored_after_j": sheet.energy(DVec3::ZERO).elastic,
        "linear_solves": solves,
    });
    Ok(runner.outcome(keys))
}

/// Places the nodes on an arc that turns by `turn` (rad) from cell to cell of `spacing` (m), from x
/// = `start` (m).
fn bend(sheet: &mut Sheet, nx: u32, (start, spacing): (f64, f64), turn: f64) {
    for i in 0..sheet.node_count() {
        let column = i as u32 % nx;
        let mut place = DVec3::new(start, 0.0, sheet.state.x.get(i).z);
        for cell in 0..column {
            let angle = turn * f64::from(cell);
            place += DVec3::new(angle.cos(), angle.sin(), 0.0) * spacing;
        }
        sheet.state.x.set(i, place);
    }
}

/// Rotation of the end of the middle row, rad: the sum of the angles between its segments.
fn turned(sheet: &Sheet, nx: u32) -> f64 {
    let row = sheet.model.grid.2 / 2 * nx;
    let mut before = DVec3::X;
    let mut sum = 0.0;
    for i in row..row + nx - 1 {
        let along = sheet.state.x.get(i as usize + 1) - sheet.state.x.get(i as usize);
        sum += before.cross(along).z.atan2(before.dot(along));
        before = along;
    }
    sum
}
