//! Findings of 5.3.4 and 5.3.5 that the thesis states without a figure: high forces on each
//! structure, weak springs under each engine, and the moment at which heat acts.

use sheetwork::islands::event::EventKind;
use sheetwork::sheet::Sheet;
use sheetwork::{InputError, World};

use crate::bench::thesis::experiment::Experiment;
use crate::bench::thesis::measures::{half_stretch, stretch_x, turned_over};
use crate::bench::thesis::{Finding, Row, Verdict};

pub(crate) const HIGH_FORCES: Row = Row {
    name: "5.3.4-high-forces",
    title: "5.3.4: structures under high contact forces",
    says: "SaMM is more likely than the others to become unstable when it meets high contact forces.",
    here: "Scene wedge with sheets.0.structure=..., equal springs and sheets.0.velocity=(0,-v,0), v = 0.25 to 4 m/s.",
    run: || {
        let mut lines = Vec::new();
        let mut stable = Vec::new();
        for structure in ["samm", "slamm", "trimm"] {
            let mut ends = Vec::new();
            for speed in 1..=16 {
                let velocity = format!("(0, {}, 0)", -0.25 * f64::from(speed));
                let set = [
                    ("sheets.0.structure", structure),
                    ("sheets.0.inter_layer", "Planar"),
                    ("sheets.0.velocity", &velocity),
                ];
                let mut run = Experiment::new("wedge", &set)?;
                run.run_to(2.0);
                ends.push(run.world.unstable().is_none());
            }
            let count = ends.iter().filter(|end| **end).count();
            let first = ends.iter().position(|end| !end).map(|i| 0.25 * (i + 1) as f64);
            let first = first.map_or_else(|| "none unstable".to_owned(), |v| format!("the first unstable at {v} m/s"));
            lines.push(format!("{structure}: {count} of 16 throws stable, {first}"));
            stable.push(count);
        }
        let holds = stable[0] < stable[1] && stable[0] < stable[2];
        let reason = "SaMM, with the fewest springs a mass, has the slowest fastest mode and bears every impact";
        Ok(Finding::new(lines.join("; "), Verdict::of(holds, reason)))
    },
};

pub(crate) const WEAK_SPRINGS: Row = Row {
    name: "5.3.5-weak-springs",
    title: "5.3.4, 5.3.5: weak springs",
    says: "With weak springs and little damping the second and the fourth order become unstable, and the first order \
           needs weak springs and much damping. Where weak springs contract, the sheet springs back upon itself.",
    here: "Scene cube with equal springs of 0.01 to 0.185 N/m, damping 2 to 34 %, and each engine, at 5 ms.",
    run: || {
        let mut lines = Vec::new();
        let (mut unstable, mut over) = (0, 0.0_f64);
        for engine in ["euler-cromer", "euler-richardson", "rk4"] {
            let (mut here, mut longest, mut folded) = (0, 1.0_f64, 0.0_f64);
            for young in ["10", "20", "40", "60", "100", "185"] {
                for damping in ["0.02", "0.14", "0.34"] {
                    let set = [
                        ("engine", engine),
                        ("sheets.0.material.young", young),
                        ("sheets.0.damping", damping),
                        ("sheets.0.inter_layer", "Planar"),
                    ];
                    let mut run = Experiment::new("cube", &set)?;
                    let start = Experiment::new("cube", &set)?;
                    run.run_watching(4.0, |world| {
                        longest = longest.max(stretch_x(start.first(), &world.sheets()[0]));
                        folded = folded.max(turned_over(&world.sheets()[0]));
                    });
                    here += usize::from(run.world.unstable().is_some());
                }
            }
            (unstable, over) = (unstable + here, over.max(folded));
            lines.push(format!(
                "{engine}: {here} of 18 unstable, at most {longest:.2} of its length, {:.0} % turned over",
                100.0 * folded
            ));
        }
        for (engine, dt) in [("euler-richardson", "0.02"), ("rk4", "0.045")] {
            let ends = ["10", "60", "185"].map(|young| -> Result<String, InputError> {
                let set =
                    [("engine", engine), ("dt", dt), ("sheets.0.material.young", young), ("sheets.0.damping", "0.02")];
                let mut run = Experiment::new("cube", &[&set[..], &[("sheets.0.inter_layer", "Planar")]].concat())?;
                run.run_to(4.0);
                let end = if run.world.unstable().is_some() { "unstable" } else { "stable" };
                Ok(format!("{young} mN/m {end}"))
            });
            let ends = ends.into_iter().collect::<Result<Vec<String>, InputError>>()?;
            lines.push(format!("{engine} at {dt} s and 2 %: {}", ends.join(", ")));
        }
        let reason = "weak springs make every mode slower, and with it a given step more stable, whatever the damping: \
                      only the weakest bear the thesis's steps. That the sheet springs back upon itself agrees";
        Ok(Finding::new(lines.join("; "), Verdict::of(unstable > 0 && over > 0.05, reason)))
    },
};

/// Stretch of the right half at the end of `heater_wedge` over that without the heater, less 1,
/// %; the heater is on from one time to another (s).
fn heated(from: f64, to: f64) -> Result<f64, InputError> {
    let run = |times: &[(f64, &str)]| -> Result<f64, InputError> {
        let mut run = Experiment::new("heater_wedge", &[("heaters.0.on", "false")])?;
        let whole = run.world.scene().duration;
        let advance = |world: &mut World, until: f64| world.advance(until - world.time());
        for &(time, on) in times.iter().filter(|(time, _)| *time < whole) {
            advance(&mut run.world, time);
            run.world.set("heaters.panel.on", on)?;
        }
        advance(&mut run.world, whole);
        Ok(half_stretch(run.first(), run.sheet(), true))
    };
    Ok(100.0 * (run(&[(from, "true"), (to, "false")])? / run(&[])? - 1.0))
}

pub(crate) const HEAT_IN_THE_FALL: Row = Row {
    name: "5.3.4-heat-in-the-fall",
    title: "5.3.4: heat before the impact",
    says: "The oven can be switched on at any moment and its heat varied. The heater cannot, and the whole sheet receives \
           much of its heat before it meets the polyhedron.",
    here: "Scene heater_wedge, and with --at \"2:heaters.panel.on=true\"; scene oven_wedge, its oven at 21 and 22 °C.",
    run: || {
        let mut run = Experiment::new("heater_wedge", &[])?;
        let mut at_contact = None;
        let stiffness = |sheet: &Sheet| sheet.springs().stiffness.iter().sum::<f64>();
        let start = Experiment::new("heater_wedge", &[])?;
        run.run_watching(2.0, |world| {
            if at_contact.is_none() && world.events().iter().any(|e| e.kind == EventKind::FirstContact) {
                at_contact = Some(stiffness(&world.sheets()[0]) / stiffness(start.first()));
            }
        });
        let (at_contact, end) = (at_contact.unwrap_or(f64::NAN), stiffness(run.sheet()) / stiffness(run.first()));
        let (contact, ever) = (run.time_of(EventKind::FirstContact, "wedge").unwrap_or(0.0), f64::INFINITY);
        let (early, after, late) = (heated(0.0, contact)?, heated(contact, ever)?, heated(2.0, ever)?);
        let oven = |celsius: u32| -> Result<f64, InputError> {
            let schedule = format!("[(time: 2.5, temperature: {celsius})]");
            let mut run = Experiment::new("oven_wedge", &[("oven.schedule", &schedule)])?;
            run.world.advance(7.5);
            Ok(stretch_x(run.first(), run.sheet()))
        };
        let (cold, warm, hot) = (oven(20)?, oven(21)?, oven(22)?);
        let measured = format!(
            "stiffness {at_contact:.2} of the first at the contact after {contact:.3} s, {end:.2} at 2 s; right arm \
             {early:+.1} % with the heater on until the contact, {after:+.1} % from then on, {late:+.1} % from 2 s on; oven \
             at 20, 21 and 22 °C from 2.5 s on: {cold:.3}, {warm:.3} and {hot:.3} of its length"
        );
        let holds = cold < warm && warm < hot && early > after;
        let reason = "oven and heater act from the moment at which they are switched on, here both of them live; the heater \
                      stands beside the wedge and below the start, so that the heat of the fall changes nothing";
        Ok(Finding::new(measured, Verdict::of(holds, reason)))
    },
};
