//! Configurations of the benchmark of run time against error: structures x integrators x grids x
//! steps on each rig.
//!
//! The sheet is the one that peers simulate: 0.25 m square, 0.5 mm thick, 3 GPa, 1050 kg/m³. The
//! shell has Poisson's ratio 0, for which independent references exist. Lattices of springs are
//! isotropic at 1/3 only and have that ratio. The droop of the thesis's lattices, whose springs all
//! have k = E t and whose layers are the thickness apart, stands beside them.

use crate::measure::{Setup, TABLE, measure};
use sheetwork::InputError;
use sheetwork::mesh::structure::StructureKind;
use sheetwork::scene::{IntegratorKind, Material, SpringLaw};

use crate::bench::point::ParetoPoint;
use crate::bench::reference::References;
use crate::bench::verdict::compare_with_targets;

/// Rigs, in the order of the panels.
pub const CASES: &[&str] = &["cantilever", "release", "frequency", "pedestal"];

/// Ending of the structure's name where all springs are equal, as in the thesis.
pub(crate) const EQUAL_SPRINGS: &str = ", equal springs";

/// Nodes along the side of the sheets of the thesis.
const THESIS_SIDE: u32 = 11;

const SPRINGS: f64 = 1.0 / 3.0;

/// One configuration.
#[derive(Clone, Debug, PartialEq)]
pub struct Configuration {
    case: &'static str,
    structure: StructureKind,
    springs: SpringLaw,
    engine: IntegratorKind,
    side: u32,
    /// Step, s; none for the largest stable one.
    dt: Option<f64>,
    poisson: f64,
}

/// The sheet of the benchmark: a shell with an implicit integrator, damped at 0.35 of critical so
/// that it settles soon.
pub fn setup(poisson: f64) -> Setup {
    let defaults = Setup::default();
    Setup {
        material: Material { poisson, ..defaults.material },
        damping_ratio: 0.35,
        // A fifth of the side: its border lies on a line of every grid of the sweep.
        patch: 0.05,
        ..defaults
    }
}

/// All configurations, ordered by rig; `quick` selects a few of each kind.
pub fn plan(quick: bool) -> Vec<Configuration> {
    use IntegratorKind::{BackwardEuler, Bdf2, Rk4, TrBdf2, Verlet};
    use StructureKind::{DoubleDiagonal, Samm, Shell, Slamm, Trimm};
    let sides: &[u32] = if quick { &[6, 11, 21] } else { &[6, 11, 16, 21, 31, 41] };
    let rates: &[f64] = if quick { &[60.0] } else { &[30.0, 60.0, 120.0, 240.0] };
    let springs = SpringLaw::Calibrated;
    let mut all = Vec::new();
    let mut add = |structure: StructureKind, engines: &[IntegratorKind], sides: &[u32], steps: &[Option<f64>]| {
        let poisson = if structure == Shell { 0.0 } else { SPRINGS };
        for &engine in engines {
            for &side in sides {
                let one = Configuration { case: "", structure, springs, engine, side, dt: None, poisson };
                all.extend(steps.iter().map(|&dt| Configuration { dt, ..one.clone() }));
            }
        }
    };
    let steps: Vec<Option<f64>> = rates.iter().map(|rate| Some(1.0 / rate)).collect();
    let implicit: &[IntegratorKind] = if quick { &[TrBdf2] } else { &[TrBdf2, Bdf2, BackwardEuler] };
    add(Shell, implicit, sides, &steps);
    let lattices: &[StructureKind] = if quick { &[DoubleDiagonal] } else { &[DoubleDiagonal, Trimm, Slamm, Samm] };
    for &structure in lattices {
        add(structure, &[TrBdf2], if quick { &[6, 11] } else { &[6, 11, 21, 31] }, &steps[..steps.len().min(2)]);
    }
    let explicit: &[IntegratorKind] = if quick { &[Verlet] } else { &[Verlet, Rk4] };
    for structure in [Shell, DoubleDiagonal] {
        add(structure, explicit, if quick { &[6] } else { &[6, 11] }, &[None]);
    }
    // To the grid of the thesis: on finer ones the layers are too close to stay apart.
    let of_the_thesis =
        all.iter().filter(|c| lattices.contains(&c.structure) && c.engine == TrBdf2 && c.side <= THESIS_SIDE);
    let equal = of_the_thesis.map(|c| Configuration { springs: SpringLaw::Uniform, case: "cantilever", ..c.clone() });
    let equal: Vec<Configuration> = equal.collect();
    let there = CASES.iter().filter(|case| TABLE.iter().any(|row| row.name == **case));
    let with = |case| all.iter().map(move |one| Configuration { case, ..one.clone() });
    there.flat_map(|&case| with(case)).chain(equal).collect()
}

impl Configuration {
    /// Runs the configuration and compares it with its reference.
    ///
    /// # Errors
    /// A missing reference. Errors of the run itself are in the point's status.
    pub fn run(&self, references: &mut References) -> Result<ParetoPoint, InputError> {
        let targets = references.get(self.case, self.poisson)?;
        let found = measure(self.case, &self.setup())
            .unwrap_or_else(|error| serde_json::json!({ "status": error.to_string().replace('\n', " ") }));
        let verdict = compare_with_targets(self.case, &found, &targets);
        Ok(ParetoPoint {
            case: self.case.into(),
            structure: self.structure_name(),
            engine: self.engine.name().into(),
            grid: found["grid"].as_str().map_or_else(|| format!("{0}x{0}", self.side), Into::into),
            dt_s: found["dt_s"].as_f64().or(self.dt).unwrap_or(0.0),
            poisson: self.poisson,
            cpu_ms_per_simulated_s: found["cpu_ms_per_simulated_s"].as_f64().unwrap_or(0.0),
            error: verdict.error,
            quantity: verdict.quantity.into(),
            measured: verdict.measured,
            reference: verdict.reference,
            settled: found["settled"].as_bool(),
            status: found["status"].as_str().unwrap_or("nothing came out").into(),
            peer: false,
        })
    }

    /// Description in one line.
    pub fn name(&self) -> String {
        let Self { case, engine, side, .. } = self;
        let step = self.dt.map_or_else(|| "largest stable step".into(), |dt| format!("1/{:.0} s", 1.0 / dt));
        format!("{case}: {} {side}x{side}, {}, {step}", self.structure_name(), engine.name())
    }

    /// Structure, with the law of its springs where that is not the calibrated one.
    fn structure_name(&self) -> String {
        let equal = self.springs == SpringLaw::Uniform;
        format!("{}{}", self.structure.name(), if equal { EQUAL_SPRINGS } else { "" })
    }

    fn setup(&self) -> Setup {
        let setup = setup(self.poisson);
        Setup {
            // The layers of a sheet of equal springs are its thickness apart.
            gap: (self.springs == SpringLaw::Uniform).then_some(setup.material.thickness),
            structure: self.structure,
            springs: self.springs,
            engine: self.engine,
            grid: (self.side, self.side),
            dt: self.dt,
            // Dynamic, because the benchmark measures the cost of steps.
            dynamic: true,
            ..setup
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_plan_has_no_duplicates() {
        for quick in [false, true] {
            let plan = plan(quick);
            assert!(!plan.is_empty());
            for (i, a) in plan.iter().enumerate() {
                assert!(plan[..i].iter().all(|b| a != b), "{}", a.name());
            }
        }
    }
}
