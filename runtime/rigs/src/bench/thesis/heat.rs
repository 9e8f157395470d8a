//! Heat: the real experiments on hot wedges (5.2.4: figures 5.8 and 5.9), and the formulas of the
//! thesis (4.11, 5.3.4: figures 5.23 to 5.26).

use sheetwork::islands::event::EventKind;
use sheetwork::scene::Scene;
use sheetwork::sheet::Sheet;
use sheetwork::{BuildError, InputError, World};

use crate::bench::thesis::experiment::Experiment;
use crate::bench::thesis::measures::{half_stretch, probe, stretch_x, stretch_z};
use crate::bench::thesis::picture::Strip;
use crate::bench::thesis::{Finding, Row, Verdict};
use crate::measure::hot_wedge::{WedgeCriteria, WedgeEvent, figure_5_8, figure_5_9};

/// Times of the prints: fall, impact, settling, and the oven that is on from 3 s.
const TIMES: [f64; 6] = [0.18, 0.28, 1.0, 2.9, 4.0, 8.0];

/// Runs an oven scene: stretch along x and z before the oven goes on, and at the end.
fn oven(scene: &str, overrides: &[(&str, &str)]) -> Result<(Experiment, [f64; 2], [f64; 2]), InputError> {
    let mut run = Experiment::new(scene, overrides)?;
    let stretch = |run: &Experiment| [stretch_x(run.first(), run.sheet()), stretch_z(run.first(), run.sheet())];
    let mut before = [1.0; 2];
    for time in TIMES {
        let mut awake = Experiment::new(scene, overrides)?;
        std::mem::swap(&mut awake.world, &mut run.world);
        // A sheet at rest sleeps until the oven wakes it.
        while awake.world.time() < time - 0.5 * awake.world.dt() && awake.world.unstable().is_none() {
            awake.world.step();
        }
        std::mem::swap(&mut awake.world, &mut run.world);
        run.print();
        if time < 3.0 {
            before = stretch(&run);
        }
    }
    let end = stretch(&run);
    Ok((run, before, end))
}

/// Runs a hot wedge: the events of its figure, each within a fifth of its time in the thesis, and
/// prints at thermal times (s) after the heating begins at `start` (s).
fn hot_wedge(
    scene: &str,
    events: fn(&Scene, &WedgeCriteria) -> Result<Vec<WedgeEvent>, BuildError>,
    (start, times): (f64, &[f64]),
    caption: &str,
) -> Result<Finding, InputError> {
    let mut run = Experiment::new(scene, &[])?;
    let found = events(run.world.scene(), &WedgeCriteria::default())?;
    let lapse = run.world.scene().time_lapse;
    for time in times {
        let until = start + time / lapse - run.world.time();
        run.world.advance(until);
        run.print_as(&format!("{:.1} min of heat", time / 60.0));
    }
    let line = |event: &WedgeEvent| {
        let (from, to) = event.thesis_s;
        let wanted = if from == to { format!("{from:.0}") } else { format!("{from:.0} to {to:.0}") };
        let at = event.time_s.map_or_else(|| "never".to_owned(), |t| format!("{t:.0} s"));
        format!("{}: {at} (thesis {wanted} s)", event.name)
    };
    let lines: Vec<String> = found.iter().map(line).collect();
    let late: Vec<&str> = found.iter().filter(|e| !e.agrees(0.2)).map(|e| e.name).collect();
    let reason = format!("not within a fifth of the time: {}", late.join(", "));
    let measured = format!(
        "{}. Temperatures of wedge and air, and the thresholds of the events, are fitted to these times; order and \
         materials are not",
        lines.join("; ")
    );
    let verdict = if late.is_empty() { Verdict::Fitted } else { Verdict::Disagrees(reason) };
    Ok(Finding::new(measured, verdict).with(run.strip(caption)))
}

pub(crate) const STYRENE: Row = Row {
    name: "figure-5.8",
    title: "Figure 5.8: styrene of 0.25 mm melts over a hot wedge",
    says: "Creases at 1 to 3 minutes, a sharper ridge at 6, warp at 9.5 to 15, the overhang bends over the front at \
           20, crumples at 22 and encloses it at 26.",
    here: "Scene hot_wedge; its comment names the three fitted numbers.",
    run: || {
        let times = [0.0, 180.0, 570.0, 1200.0, 1320.0, 1560.0];
        hot_wedge("hot_wedge", figure_5_8, (1.0, &times), "Styrene of 0.25 mm on a wedge that warms up")
    },
};

pub(crate) const PACKAGING: Row = Row {
    name: "figure-5.9",
    title: "Figure 5.9: packaging PVC melts over a hot wedge",
    says: "The overhang drapes at 14 s, melts first at 24 to 44 s, a hole opens at 54 s and is wider at 64 s; a \
           patch of the face is liquid at 4 minutes, the whole face at 6.",
    here: "Scene pvc_hot_wedge; its comment names the fitted numbers.",
    run: || {
        let times = [0.0, 14.0, 54.0, 64.0, 240.0, 360.0];
        hot_wedge("pvc_hot_wedge", figure_5_9, (0.0, &times), "Packaging PVC on a hot wedge")
    },
};

pub(crate) const OVEN_DOME: Row = Row {
    name: "figure-5.23",
    title: "Figure 5.23: SLaMM softened by the oven on a dome",
    says: "The sheet drapes, contracts and settles; at 21 °C it extends along x and draws together along z, so that \
           its area hardly grows, and the square becomes a rectangle.",
    here: "Scene oven_hemisphere.",
    run: || {
        let (mut run, before, end) = oven("oven_hemisphere", &[])?;
        let measured = format!(
            "length along x {:.3} before and {:.3} after, along z {:.3} and {:.3}",
            before[0], end[0], before[1], end[1]
        );
        let grows = end[0] > 1.05 * before[0];
        let longer = end[0] / before[0] > 1.02 * end[1] / before[1];
        let reason = if grows {
            "both directions extend, and nearly alike, as sheet, diagonals and dome are the same with x and z exchanged; \
             equal springs have no law that keeps the area"
        } else {
            "it does not extend"
        };
        Ok(Finding::new(measured, Verdict::of(grows && longer, reason)).with(run.strip("SLaMM on a dome in the oven")))
    },
};

pub(crate) const OVEN_WEDGE: Row = Row {
    name: "figure-5.24",
    title: "Figure 5.24: softened by the oven on a wedge",
    says: "Once the sheet has settled the oven weakens its springs: it elongates, its curve flattens and its ends \
           come closer to the floor.",
    here: "Scene oven_wedge.",
    run: || {
        let (mut run, before, end) = oven("oven_wedge", &[])?;
        let mut cold = Experiment::new("oven_wedge", &[])?;
        cold.run_to(2.9);
        let drop = |run: &Experiment| probe(run.sheet(), "centre").y - probe(run.sheet(), "edge").y;
        let measured = format!(
            "length along x {:.3} before and {:.3} after; edge {:.1} mm below the ridge, and {:.1} mm before",
            before[0],
            end[0],
            1e3 * drop(&run),
            1e3 * drop(&cold)
        );
        let lower = drop(&run) > 1.05 * drop(&cold);
        let verdict =
            Verdict::of(end[0] > 1.05 * before[0] && lower, "it does not elongate, or its ends stay where they were");
        Ok(Finding::new(measured, verdict).with(run.strip("TRiMM on a wedge in the oven")))
    },
};

/// A heater scene with the heater on and off: stretch of the left and right half over that without.
fn heater(scene: &str) -> Result<(Experiment, [f64; 2]), InputError> {
    let mut cold = Experiment::new(scene, &[("heaters.0.on", "false")])?;
    let mut hot = Experiment::new(scene, &[])?;
    let duration = hot.world.scene().duration;
    cold.world.advance(duration);
    for time in [0.18, 0.3, 1.0, 2.0, 4.0, duration] {
        let left = time - hot.world.time();
        hot.world.advance(left);
        hot.print();
    }
    let halves = [false, true]
        .map(|right| half_stretch(hot.first(), hot.sheet(), right) / half_stretch(cold.first(), cold.sheet(), right));
    Ok((hot, halves))
}

pub(crate) const HEATER_WEDGE: Row = Row {
    name: "figure-5.25",
    title: "Figure 5.25: SaMM on a wedge beside a heater",
    says: "The right side softens and extends along the wedge while the left side stays.",
    here: "Scene heater_wedge.",
    run: || {
        let (mut run, [left, right]) = heater("heater_wedge")?;
        let measured = format!(
            "right arm {:+.1} %, left arm {:+.1} % against the same sheet without the heater",
            100.0 * (right - 1.0),
            100.0 * (left - 1.0)
        );
        let verdict = Verdict::of(right > 1.1 && left < 1.05, "the sides extend alike");
        Ok(Finding::new(measured, verdict).with(run.strip("SaMM on a wedge beside a heater")))
    },
};

pub(crate) const HEATER_DOME: Row = Row {
    name: "figure-5.26",
    title: "Figure 5.26: SaMM on a dome beside a heater",
    says: "Both sides melt and extend alike, hard to tell from the oven.",
    here: "Scene heater_hemisphere.",
    run: || {
        let (mut run, [left, right]) = heater("heater_hemisphere")?;
        let (mut warmed, ..) = oven("oven_hemisphere", &[("sheets.0.structure", "samm")])?;
        warmed.strip("");
        warmed.print_as("in the oven");
        let halves = |run: &Experiment| [false, true].map(|right| half_stretch(run.first(), run.sheet(), right));
        let ([a, b], [c, d]) = (halves(&run), halves(&warmed));
        let measured = format!(
            "right half {:+.1} %, left half {:+.1} % against the same sheet without the heater; {b:.2} and {a:.2} of their \
             length, and {d:.2} and {c:.2} in the oven",
            100.0 * (right - 1.0),
            100.0 * (left - 1.0)
        );
        let both = left > 1.02 && right > 1.02 && (right - left).abs() < 0.5 * (right - 1.0).max(left - 1.0);
        let verdict = Verdict::of(both, "the side of the heater extends more than the other");
        let mut strip = run.strip("SaMM on a dome beside a heater, and in the oven");
        strip.prints.pop();
        strip.prints.append(&mut warmed.strip("").prints);
        Ok(Finding::new(measured, verdict).with(strip))
    },
};

pub(crate) const STRUCTURES: Row = Row {
    name: "5.3.4-heated-structures",
    title: "5.3.4: structures under heat",
    says: "Modest heat has more influence on SaMM than on the others; SLaMM distorts diagonally, against its \
           diagonals; TRiMM stands the most.",
    here: "Scene oven_wedge with each structure.",
    run: || {
        let mut grown = Vec::new();
        let mut lines = Vec::new();
        for structure in ["samm", "slamm", "trimm"] {
            let (run, before, end) = oven("oven_wedge", &[("sheets.0.structure", structure)])?;
            let growth = end[0] / before[0];
            let slid = run.time_of(EventKind::SlidOff, "wedge").is_some();
            grown.push(growth);
            let end = if slid { ", slid off" } else { "" };
            lines.push(format!("{structure}: {:+.1} % along x{end}", 100.0 * (growth - 1.0)));
        }
        let holds = grown[0] > grown[1] && grown[0] > grown[2];
        let reason = "on the wedge the load is along x, where the springs of SaMM are as many as those of the others";
        Ok(Finding::new(lines.join("; "), Verdict::of(holds, reason)))
    },
};

pub(crate) const STICKING: Row = Row {
    name: "7.4viii-sticking",
    title: "7.4 viii: hot sheets that stick",
    says: "Seen in the real tests and not built: hot sheets stick to each other and crumple (here they stick; row \
           figure-5.8 crumples).",
    here: "Scene sticky_wedge.",
    run: || {
        let mut lines = Vec::new();
        let mut slid = Vec::new();
        let mut prints = Vec::new();
        for sticky in ["true", "false"] {
            let fields = ["sheets.0.sticky", "sheets.1.sticky"].map(|field| (field, sticky));
            let mut run = Experiment::new("sticky_wedge", &fields)?;
            let apart = |world: &World| world.sheets()[1].centre_of_mass() - world.sheets()[0].centre_of_mass();
            let start = apart(&run.world);
            if sticky == "true" {
                run.print_at(&[0.15, 0.3, 0.4, 0.5]);
            }
            run.run();
            run.print_as(if sticky == "true" { "at the end" } else { "at the end, without adhesion" });
            let way = (apart(&run.world) - start).x.abs();
            let bonds: usize = run.world.sheets().iter().map(Sheet::bonds).sum();
            lines.push(format!(
                "sticky {sticky}: {bonds} bonds, the upper sheet slides {:.2} mm over the lower one",
                1e3 * way
            ));
            slid.push(way);
            prints.append(&mut run.strip("").prints);
        }
        let verdict = Verdict::proposal(slid[0] < 0.3 * slid[1], "the sheets slide as without adhesion");
        let finding = Finding::new(lines.join("; "), verdict);
        let caption = "Two hot sheets fall on a hot wedge and stick".to_owned();
        Ok(finding.with(Strip { caption, prints }))
    },
};
