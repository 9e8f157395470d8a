//! Stiffness of the springs between the layers (thesis 2.7, 3.4, 6.5), the central freedom of
//! three-dimensional sheets: droop, rebound and distance of the layers over it.

use sheetwork::InputError;

use crate::bench::thesis::diagram::Diagram;
use crate::bench::thesis::experiment::Experiment;
use crate::bench::thesis::measures::{layer_distance, probe};
use crate::bench::thesis::{Finding, Row, Verdict};

/// Stiffness of the springs at a node, ΣK cos θ, N/m.
const STIFFNESSES: [f64; 7] = [0.03, 0.1, 0.3, 0.8, 1.2, 2.4, 4.8];

/// A flat landing: rebound of the centre of mass after its lowest point, m, and mean distance of
/// the layers at rest over that at the start.
fn landing(law: &str) -> Result<(f64, f64), InputError> {
    let set = [("sheets.0.inter_layer", law), ("dt", "0.002")];
    let mut run = Experiment::new("flat_floor_e0", &set)?;
    let (mut lowest, mut rebound) = (f64::INFINITY, 0.0_f64);
    run.run_watching(6.0, |world| {
        if !world.events().is_empty() {
            let height = world.sheets()[0].centre_of_mass().y;
            lowest = lowest.min(height);
            rebound = rebound.max(height - lowest);
        }
    });
    Ok((rebound, layer_distance(run.first(), run.sheet())))
}

/// Droop of the free edge of the sheet clamped at its left edge, m, with all springs a hundred
/// times as stiff and a tenth of the scene's gravity: the sheet of the thesis would hang limp.
fn droop(stiffness: f64) -> Result<f64, InputError> {
    let law = format!("SumStiffness({})", 100.0 * stiffness);
    let set = [
        ("sheets.0.inter_layer", law.as_str()),
        ("sheets.0.material", "(young: 18500.0)"),
        ("sheets.0.pins", "[(region: Left)]"),
        ("gravity", "(0, -0.0981, 0)"),
        ("room", "none"),
        ("dt", "0.0002"),
        ("duration", "6"),
    ];
    let mut run = Experiment::new("flat_floor_e0", &set)?;
    run.run();
    Ok(probe(run.first(), "edge").y - probe(run.sheet(), "edge").y)
}

pub(crate) const SWEEP: Row = Row {
    name: "2.7-inter-layer",
    title: "2.7, 3.4, 6.5: stiffness between the layers",
    says: "The springs between the layers carry bending: their stiffness, apart from that of the planar springs, \
           sets the bending stiffness of the sheet, and may remove its unwarranted bending moment.",
    here: "Scene flat_floor_e0 with sheets.0.inter_layer=SumStiffness(...): its landing, and its droop clamped at one edge.",
    run: || {
        let mut curves = [Vec::new(), Vec::new(), Vec::new()];
        let mut lines = Vec::new();
        for stiffness in STIFFNESSES {
            let law = format!("SumStiffness({stiffness})");
            let (rebound, distance) = landing(&law)?;
            let droop = droop(stiffness)?;
            for (curve, value) in curves.iter_mut().zip([droop / 0.025, rebound / 0.001, distance]) {
                curve.push((stiffness, value));
            }
            lines.push(format!(
                "{stiffness} N/m a node: droop {:.1} mm of 25, rebound {:.2} mm, layers {distance:.2} of their distance",
                1e3 * droop,
                1e3 * rebound
            ));
        }
        let last = STIFFNESSES.len() - 1;
        let [droops, _, distances] = &curves;
        lines.push(format!(
            "the droop depends on it where the layers collapse, and from {} N/m on by {:.0} % only",
            STIFFNESSES[1],
            100.0 * (1.0 - droops[last].1 / droops[1].1)
        ));
        let droop_ratio = droops[last].1 / droops[0].1;
        let restored = distances[last].1 > 0.9 && distances[0].1 < 0.6;
        let bends = droops[last].1 < 0.5 * droops[1].1;
        let reason = if restored && droop_ratio < 0.5 {
            "it keeps the layers apart and ends the rebound, and where they do not collapse the bending stiffness hardly \
             depends on it: bending then stretches the planar springs of the two layers"
        } else {
            "neither droop nor layer distance depends on it"
        };
        let verdict = Verdict::of(restored && bends, reason);
        let names = ["droop / length", "rebound / mm", "layer distance / rest"];
        let diagram = Diagram {
            caption: "Droop, rebound and layer distance over the stiffness between the layers".to_owned(),
            axes: ("stiffness of the springs at a node, N/m", "fraction"),
            curves: names.iter().map(|n| (*n).to_owned()).zip(curves).collect(),
        };
        Ok(Finding::new(lines.join("; "), verdict).with_diagram(diagram))
    },
};
