//! Engines: time of the sliding sheet (figures 5.27 to 5.30), cost, tolerance (5.3.5, table 5.4).

use sheetwork::InputError;
use sheetwork::islands::event::EventKind;
use sheetwork::mesh::structure::StructureKind;
use sheetwork::scene::IntegratorKind;

use crate::bench::thesis::experiment::{Experiment, seconds};
use crate::bench::thesis::picture::Strip;
use crate::bench::thesis::{Finding, Row, Verdict};
use crate::measure::stability_limit::{StabilityTrial, VariedParameter};

/// Simulated times of the four events, and CPU time up to each, s.
struct Slide {
    events: [Option<f64>; 4],
    cpu: f64,
    unstable: bool,
    run: Experiment,
}

impl Slide {
    fn new(scene: &str, overrides: &[(&str, &str)]) -> Result<Self, InputError> {
        let mut run = Experiment::new(scene, overrides)?;
        run.run();
        let events = [
            run.time_of(EventKind::FirstContact, "first"),
            run.time_of(EventKind::FirstContact, "second"),
            run.time_of(EventKind::SlidOff, "second"),
            run.time_of(EventKind::Flat, "floor"),
        ];
        Ok(Self { events, cpu: run.cpu, unstable: run.world.unstable().is_some(), run })
    }

    /// Whether the four events happen in order.
    fn is_complete(&self) -> bool {
        self.events.iter().all(Option::is_some) && self.events.is_sorted()
    }

    fn text(&self, name: &str) -> String {
        if self.unstable {
            return format!("{name}: unstable at {:.2} s", self.run.world.time());
        }
        let [first, second, off, flat] = self.events.map(seconds);
        format!("{name}: first body {first}, second {second}, off {off}, flat {flat}; {:.1} ms CPU", 1e3 * self.cpu)
    }
}

pub(crate) const SLIDES: Row = Row {
    name: "figures-5.27-5.28",
    title: "Figures 5.27 and 5.28: sheets of four sizes slide over two bodies",
    says: "First contact, second contact, slid off, flat on the floor; the time grows exponentially with the size, \
           and 11x2x11 runs in real time.",
    here: "Scenes slide_8, slide_11, slide_14, slide_17.",
    run: || {
        let mut lines = Vec::new();
        let mut cost = Vec::new();
        let mut complete = true;
        for name in ["slide_8", "slide_11", "slide_14", "slide_17"] {
            let slide = Slide::new(name, &[])?;
            complete &= slide.is_complete();
            let masses = slide.run.sheet().node_count() as f64;
            cost.push((masses, slide.cpu / slide.run.world.steps() as f64));
            lines.push(slide.text(name));
        }
        let growth = (cost[3].1 / cost[0].1).ln() / (cost[3].0 / cost[0].0).ln();
        let mut prints = Experiment::new("slide_11", &[])?;
        prints.print_at(&[0.1, 0.2, 0.4, 0.7, 1.2, 6.0]);
        let measured = format!("{}; CPU time of a step grows as the {growth:.2} power of the masses", lines.join("; "));
        let reason = "the events come in the order of the thesis, but its exponential growth is a power law: springs and \
                      contacts are proportional to the masses, and the steps get shorter with the spacing";
        let verdict =
            if complete { Verdict::Disagrees(reason.to_owned()) } else { Verdict::of(false, "an event is missing") };
        Ok(Finding::new(measured, verdict).with(prints.strip("TRiMM 11x2x11 slides over two bodies")))
    },
};

/// The three engines with these steps (s).
fn engines(steps: [&str; 3]) -> Result<[Slide; 3], InputError> {
    let run = |engine: &str, dt: &str| Slide::new("slide_11", &[("engine", engine), ("dt", dt)]);
    Ok([run("euler-cromer", steps[0])?, run("euler-richardson", steps[1])?, run("rk4", steps[2])?])
}

fn engine_text(slides: &[Slide; 3]) -> String {
    let names = ["Euler-Cromer", "Euler-Richardson", "Runge-Kutta"];
    let lines: Vec<String> = slides.iter().zip(names).map(|(slide, name)| slide.text(name)).collect();
    lines.join("; ")
}

pub(crate) const SAME_STEP: Row = Row {
    name: "figure-5.29",
    title: "Figure 5.29: the engines with one step",
    says: "At one step (printed 0.20 s) the fourth order takes more than twice the time of the second; the first \
           order gets entangled and takes longest.",
    here: "Scene slide_11 with engine=..., 5 ms.",
    run: || {
        let slides = engines(["0.005"; 3])?;
        let ratio = slides[2].cpu / slides[1].cpu;
        let measured = format!("{}; fourth over second order {ratio:.2}", engine_text(&slides));
        let reason = "at a stable step all three follow the same path (row 5.3.5-cost has the cost of a step), and contact, which costs all of them the same, takes \
                      more time than the springs; 0.20 s is past the limit of each, and the entangled sheet of the first \
                      order is its sign";
        let entangled = !slides[0].is_complete() || slides[0].cpu > slides[1].cpu;
        Ok(Finding::new(measured, Verdict::of(ratio > 1.5 && entangled, reason)))
    },
};

pub(crate) const SIDE_BY_SIDE: Row = Row {
    name: "5.3.5-side-by-side",
    title: "5.3.5: the engines side by side",
    says: "Three engines are compared, each with its own step, and the analytical one is not tested further.",
    here: "Six run one scene: slide_11 with engine=..., 5 ms (analytical 2 ms); in the editor, `--screenshot FILE \
           --beside engine=rk4`.",
    run: || {
        let engines = [
            ("analytical", "0.002"),
            ("euler-cromer", "0.005"),
            ("euler-richardson", "0.005"),
            ("verlet", "0.005"),
            ("rk4", "0.005"),
            ("rk45", "0.005"),
        ];
        let mut prints = Vec::new();
        let mut lines = Vec::new();
        let mut flat = Vec::new();
        let mut complete = true;
        for (name, dt) in engines {
            let set = [("engine", name), ("dt", dt)];
            let mut at_mid_slide = Experiment::new("slide_11", &set)?;
            at_mid_slide.run_to(0.7);
            at_mid_slide.print_as(name);
            prints.append(&mut at_mid_slide.strip("").prints);
            let slide = Slide::new("slide_11", &set)?;
            complete &= slide.is_complete();
            flat.push(slide.events[3].unwrap_or(f64::INFINITY));
            lines.push(slide.text(name));
        }
        let spread = flat.iter().fold(0.0, |most: f64, t| most.max((t / flat[4] - 1.0).abs()));
        let measured = format!("{}; times to lie flat differ by at most {:.0} %", lines.join("; "), 100.0 * spread);
        let strip = Strip { caption: "Six engines at 0.7 s".to_owned(), prints };
        Ok(Finding::new(measured, Verdict::of(complete, "an engine does not bring the sheet to the floor")).with(strip))
    },
};

/// Longest stable step (s) of an engine on `slide_11`, to 2 %.
fn longest(engine: &str) -> Result<f64, InputError> {
    let (mut stable, mut unstable) = (1e-3, 0.1);
    while unstable / stable > 1.02 {
        let middle: f64 = f64::sqrt(stable * unstable);
        let dt = middle.to_string();
        if Slide::new("slide_11", &[("engine", engine), ("dt", &dt), ("duration", "3")])?.unstable {
            unstable = middle;
        } else {
            stable = middle;
        }
    }
    Ok(stable)
}

pub(crate) const OWN_STEP: Row = Row {
    name: "figure-5.30",
    title: "Figure 5.30: each engine with its own step",
    says: "The fourth order bears the largest step, 0.045 s against 0.020 s of the second, and is then less than a \
           second slower than it; the first order falls behind.",
    here: "Scene slide_11 with engine=..., dt at 0.85 of the longest stable step.",
    run: || {
        let steps = [longest("euler-cromer")?, longest("euler-richardson")?, longest("rk4")?];
        let own = steps.map(|dt| (0.85 * dt).to_string());
        let slides = engines([&own[0], &own[1], &own[2]])?;
        let measured = format!(
            "longest stable steps {:.1}, {:.1} and {:.1} ms; at 0.85 of them {}",
            1e3 * steps[0],
            1e3 * steps[1],
            1e3 * steps[2],
            engine_text(&slides)
        );
        let order = steps[2] > 1.5 * steps[1] && slides[2].cpu < 1.5 * slides[1].cpu;
        let behind = slides[0].cpu > 1.2 * slides[1].cpu;
        let reason = if order {
            "the fourth order bears the largest step and makes up for its cost with it, but the first order does not fall \
             behind: at a stable step it takes the same path at less cost"
        } else {
            "the fourth order does not make up for its cost with its step"
        };
        Ok(Finding::new(measured, Verdict::of(order && behind, reason)))
    },
};

pub(crate) const COST: Row = Row {
    name: "5.3.5-cost",
    title: "5.3.5: cost of the fourth order",
    says: "The fourth order costs only 15 to 20 % more real time than the second (and, in figure 5.29, more than \
           twice).",
    here: "Scene slide_17 with engine=...: CPU time of a step of 0.6 s, the least of three runs.",
    run: || {
        let mut cost = [f64::INFINITY; 2];
        for _ in 0..3 {
            for (engine, least) in ["euler-richardson", "rk4"].iter().zip(&mut cost) {
                let mut run = Experiment::new("slide_17", &[("engine", engine)])?;
                run.run_to(0.6);
                *least = least.min(run.cpu / run.world.steps() as f64);
            }
        }
        let ratio = cost[1] / cost[0];
        let measured = format!(
            "CPU time of a step {:.3} ms with Euler-Richardson, {:.3} ms with Runge-Kutta: {:+.0} %",
            1e3 * cost[0],
            1e3 * cost[1],
            100.0 * (ratio - 1.0)
        );
        let reason = "four evaluations of the forces cost twice two of them, less what collision and drawing cost with both; \
                      15 to 20 % says that drawing took most of the thesis's time";
        Ok(Finding::new(measured, Verdict::of((1.1..1.25).contains(&ratio), reason)))
    },
};

/// Settings of table 5.4: engine, stiffness (N/m), damping, step (s).
const SETTINGS: [(IntegratorKind, f64, f64, f64); 3] = [
    (IntegratorKind::EulerCromer, 0.06, 0.34, 0.010),
    (IntegratorKind::EulerRichardson, 0.2, 0.14, 0.020),
    (IntegratorKind::Rk4, 0.4, 0.14, 0.040),
];

fn trial((engine, stiffness, damping, _): (IntegratorKind, f64, f64, f64)) -> StabilityTrial {
    StabilityTrial {
        structure: StructureKind::Trimm,
        engine,
        grid: (11, 11),
        stiffness,
        damping,
        mass: 4e-4,
        ..StabilityTrial::default()
    }
}

/// An engine with the stiffness and mass of the first order's setting, and another damping.
pub(crate) fn first_order_trial(engine: IntegratorKind, damping: f64) -> StabilityTrial {
    StabilityTrial { engine, damping, ..trial(SETTINGS[0]) }
}

pub(crate) const TABLE_5_4: Row = Row {
    name: "table-5.4",
    title: "Table 5.4: typical parameters of the engines",
    says: "First order 0.06 N/m, 34 %, 0.010 s; second order 0.2 N/m, 14 %, 0.020 s; fourth order 0.4 N/m, 14 %, \
           0.040 s.",
    here: "A free TRiMM sheet of 11x2x11 with these settings: limits from its fastest mode.",
    run: || {
        let mut lines = Vec::new();
        let mut stable = Vec::new();
        for setting in SETTINGS {
            let trial = trial(setting);
            let (omega, _) = trial.frequency()?;
            let longest = trial.predict_longest_step()?;
            stable.push(setting.3 < longest);
            lines.push(format!(
                "{}: {:.2} rad a step at 0.4 g a mass ({:.1} at 0.04 g), longest step {:.1} ms",
                setting.0,
                omega * setting.3,
                omega * 10f64.sqrt() * setting.3,
                1e3 * longest
            ));
        }
        let reason = "with 0.4 g the first two settings are stable; 0.040 s with 0.4 N/m is beyond the limit of Runge-Kutta, \
                      2.83 rad less what the damping takes";
        Ok(Finding::new(lines.join("; "), Verdict::of(stable.iter().all(|s| *s), reason)))
    },
};

pub(crate) const TOLERANCE: Row = Row {
    name: "5.4-tolerance",
    title: "5.4: what the settings bear",
    says: "Runge-Kutta bears a change of its parameters by 100 %, Euler-Richardson by 40 %, Euler-Cromer hardly any.",
    here: "A free TRiMM sheet of 11x2x11 with the settings of table 5.4 (a step of at most 0.85 of the limit): limits from \
           its fastest mode.",
    run: || {
        let mut lines = Vec::new();
        let mut margins = Vec::new();
        for setting in SETTINGS {
            let trial = trial(setting);
            let dt = setting.3.min(0.85 * trial.predict_longest_step()?);
            let stiffness = trial.margin(VariedParameter::Stiffness, dt)?.unwrap_or(f64::INFINITY);
            let step = trial.margin(VariedParameter::Step, dt)?.unwrap_or(f64::INFINITY);
            margins.push(stiffness);
            lines.push(format!("{} at {:.1} ms: stiffness x {stiffness:.2}, step x {step:.2}", setting.0, 1e3 * dt));
        }
        let holds = margins[2] > margins[1] && margins[1] > margins[0];
        let reason = "the margin is the distance of the chosen step from the limit, not a property of the engine: the first \
                      order was set far below its limit, the fourth at it";
        Ok(Finding::new(lines.join("; "), Verdict::of(holds, reason)))
    },
};

pub(crate) const ANALYTICAL: Row = Row {
    name: "5.3.5-analytical",
    title: "5.3.5: the analytical engine",
    says: "It behaves as the first order does, is more sensitive, and needs more damping and smaller steps.",
    here: "A free TRiMM sheet of 11x2x11 with 0.06 N/m and 0.4 g: limits from its fastest mode.",
    run: || {
        let mut lines = Vec::new();
        let mut shorter = Vec::new();
        for damping in [0.02, 0.14, 0.34] {
            let longest = |engine| first_order_trial(engine, damping).predict_longest_step();
            let (cromer, analytical) = (longest(IntegratorKind::EulerCromer)?, longest(IntegratorKind::Analytical)?);
            shorter.push(analytical < cromer);
            lines.push(format!(
                "damping {:.0} %: Euler-Cromer {:.1} ms, analytical {:.1} ms",
                100.0 * damping,
                1e3 * cromer,
                1e3 * analytical
            ));
        }
        let measured = format!("longest step at 0.06 N/m and 0.4 g, {}", lines.join("; "));
        let reason = "at low damping it needs smaller steps, as described; with the 34 % of the first order it bears longer \
                      ones";
        Ok(Finding::new(measured, Verdict::of(shorter.iter().all(|s| *s), reason)))
    },
};
