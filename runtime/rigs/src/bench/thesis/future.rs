//! Proposals of the thesis for further work (7.3 and 7.4) that are built here.

use sheetwork::InputError;
use sheetwork::islands::event::EventKind;
use sheetwork::scene::IntegratorKind;
use sheetwork::sheet::Sheet;

use crate::bench::thesis::engines::first_order_trial;
use crate::bench::thesis::experiment::{Experiment, rest, seconds};
use crate::bench::thesis::measures::{probe, yaw};
use crate::bench::thesis::picture::Strip;
use crate::bench::thesis::{Finding, Row, Verdict};

/// Runs a scene to its end with prints at `times` (s); the movement of its last tenth of a second
/// (m) tells rest.
fn to_the_end(scene: &str, times: [f64; 3]) -> Result<(Experiment, f64), InputError> {
    let mut run = Experiment::new(scene, &[])?;
    run.print_at(&times);
    let before = run.sheet().state.x.clone();
    run.run_to(times[2] + 0.1);
    let moved = before.iter().zip(run.sheet().state.x.iter()).map(|(a, b)| a.distance(b)).fold(0.0, f64::max);
    Ok((run, moved))
}

/// Height of a column of the inner layer of a tube, m.
fn column_height(sheet: &Sheet, column: u32) -> f64 {
    let layer = sheet.model.layers[0];
    let heights = (0..layer.nz).map(|j| sheet.state.x.get(layer.at(column, j) as usize).y);
    let (low, high) = heights.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), y| (l.min(y), h.max(y)));
    high - low
}

pub(crate) const BODIES: Row = Row {
    name: "7.4i-bodies",
    title: "7.4 i: bodies that are no sheets",
    says: "Proposed and not built: other bodies from the same masses and springs.",
    here: "Scenes tube, bag and cable.",
    run: || {
        let (mut tube, tube_moved) = to_the_end("tube", [0.2, 0.4, 7.9])?;
        let (mut bag, bag_moved) = to_the_end("bag", [0.0, 0.3, 5.9])?;
        let (mut cable, cable_moved) = to_the_end("cable", [0.0, 0.35, 7.9])?;
        let [ridge, end] = [12, 0].map(|column| 1e3 * column_height(tube.sheet(), column));
        let rim = 1e3 * (probe(bag.sheet(), "rim").y - probe(bag.sheet(), "bottom").y).abs();
        let hangs = 1e3 * (tube_top(&cable) - probe(cable.sheet(), "end").y);
        let moved = tube_moved.max(bag_moved).max(cable_moved);
        let measured = format!(
            "tube on a wedge: {ridge:.1} mm high over the ridge, {end:.1} mm at its ends (16 mm at first); bag: rim {rim:.1} \
             mm over the bottom (25 mm); cable of 100 mm has its free end {hangs:.0} mm below the fixed one; the largest movement in the \
             last tenth of a second is {:.3} mm",
            1e3 * moved
        );
        let holds = ridge < 0.6 * end && end > 13.0 && rim > 20.0 && hangs > 95.0 && moved < 1e-4;
        let mut strip = tube.strip("A tube falls across a wedge, a bag on the floor, and a cable swings down");
        for mut other in [bag.strip(""), cable.strip("")] {
            strip.prints.append(&mut other.prints);
        }
        Ok(Finding::new(measured, Verdict::proposal(holds, "a body collapses or does not rest")).with(strip))
    },
};

/// Height of the highest node, m.
fn tube_top(run: &Experiment) -> f64 {
    run.sheet().state.x.y.iter().fold(f64::NEG_INFINITY, |high, y| high.max(*y))
}

pub(crate) const FLEXION: Row = Row {
    name: "7.4iii-flexion",
    title: "7.4 iii: TRiMM with the springs of the 3D Provot sheet",
    says: "Proposed and not built: TRiMM with additional cross-over springs like those of the 3D Provot sheet.",
    here: "Scene wedge with sheets.0.structure=provot-trimm.",
    run: || {
        let mut lines = Vec::new();
        let mut strip = None;
        let mut holds = true;
        for limit in ["60", "20"] {
            let set = [("sheets.0.structure", "provot-trimm"), ("sheets.0.flexion_limit", limit)];
            let mut run = Experiment::new("wedge", &set)?;
            let mut most = 0.0_f64;
            for time in [0.18, 0.26, 0.34, 0.5, 1.0, 8.0] {
                run.run_watching(time, |world| {
                    most = most.max(world.sheets()[0].largest_flexion_angle().unwrap_or(f64::INFINITY));
                });
                run.print();
            }
            let turned = yaw(run.first(), run.sheet());
            let wanted: f64 = limit.parse().unwrap_or(f64::NAN);
            holds &= most < wanted + 1.0 && run.is_sound() && turned.abs() < 0.5;
            lines.push(format!("limit {limit}°: at most {most:.2}°, yaw {turned:.2}°, {}", rest(&run)));
            strip = Some(run.strip("TRiMM with flexion springs and a limit of 20° on a wedge"));
        }
        let found =
            Finding::new(lines.join("; "), Verdict::proposal(holds, "the limit is exceeded, or the sheet yaws"));
        Ok(Finding { strip, ..found })
    },
};

pub(crate) const VERLET: Row = Row {
    name: "7.3h-verlet",
    title: "7.3 h: Verlet integration",
    says: "Proposed and not built: Verlet in place of the Euler methods; performance and stability to be evaluated.",
    here: "A free TRiMM sheet of 11x2x11 with 0.06 N/m and 0.4 g: limits from its fastest mode.",
    run: || {
        let mut lines = Vec::new();
        let mut longer = true;
        for damping in [0.0, 0.02, 0.14] {
            let longest = |engine| first_order_trial(engine, damping).predict_longest_step();
            let (verlet, cromer, richardson) = (
                longest(IntegratorKind::Verlet)?,
                longest(IntegratorKind::EulerCromer)?,
                longest(IntegratorKind::EulerRichardson)?,
            );
            longer &= verlet >= richardson && (damping > 0.02 || verlet >= 0.95 * cromer);
            lines.push(format!(
                "damping {:.0} %: Verlet {:.1} ms, Euler-Cromer {:.1} ms, Euler-Richardson {:.1} ms",
                100.0 * damping,
                1e3 * verlet,
                1e3 * cromer,
                1e3 * richardson
            ));
        }
        let measured = format!(
            "longest step at 0.06 N/m and 0.4 g, predicted from the fastest mode, {}; a step costs as much as one of \
             Euler-Richardson (row 5.3.5-side-by-side), and both are of second order",
            lines.join("; ")
        );
        Ok(Finding::new(measured, Verdict::proposal(longer, "it bears no longer steps than the Euler methods")))
    },
};

pub(crate) const RETENTION: Row = Row {
    name: "7.4iv-retention",
    title: "7.4 iv: spring retention",
    says: "Begun and left out: an algorithm that retains stability in runs of high energy and little damping.",
    here: "Scene wedge with sheets.0.damping=0.01, dt=0.008, 0.01 or 0.015, and sheets.0.when_unstable=\"limit 0.3\".",
    run: || {
        let mut lines = Vec::new();
        let mut strip = None;
        let mut holds = true;
        for dt in ["0.008", "0.01", "0.015"] {
            let set = |policy| [("sheets.0.damping", "0.01"), ("dt", dt), ("sheets.0.when_unstable", policy)];
            let mut plain = Experiment::new("wedge", &set("stop"))?;
            plain.run();
            let mut limited = Experiment::new("wedge", &set("limit 0.3"))?;
            limited.print_at(&[0.18, 0.3, 0.45, 0.6, 0.9, 8.0]);
            let longest = longest_spring(limited.sheet());
            let unstable = plain.world.unstable().is_some();
            lines.push(format!(
                "step {dt} s: {} without a limit; with springs limited to a strain of 0.3 while it is unstable, {}, longest \
                 spring {longest:.2} of its length",
                if unstable { format!("unstable at {:.2} s", plain.world.time()) } else { rest(&plain) },
                if limited.world.unstable().is_some() { "unstable".to_owned() } else { rest(&limited) },
            ));
            holds &= unstable && limited.is_sound();
            strip = strip.or(Some(limited.strip("Spring retention: a step that is too long for the sheet")));
        }
        let mut stable = Experiment::new("wedge", &[("sheets.0.damping", "0.01"), ("dt", "0.002")])?;
        stable.run();
        lines.push(format!(
            "at a stable step of 0.002 s without a limit: {}, longest spring {:.2}",
            rest(&stable),
            longest_spring(stable.sheet())
        ));
        let found = Finding::new(lines.join("; "), Verdict::proposal(holds, "it does not retain stability"));
        Ok(Finding { strip, ..found })
    },
};

/// Longest spring over its length at rest.
fn longest_spring(sheet: &Sheet) -> f64 {
    let springs = sheet.springs();
    let length = |i: usize| sheet.state.x.get(springs.a[i] as usize).distance(sheet.state.x.get(springs.b[i] as usize));
    (0..springs.len()).map(|i| length(i) / springs.rest[i]).fold(0.0, f64::max)
}

/// Frame of the adaptive integrator, s.
const FRAME: f64 = 0.05;

pub(crate) const ADAPTIVE: Row = Row {
    name: "7.4ix-adaptive",
    title: "7.4 ix: fifth order with error control",
    says: "Proposed and not built: a fifth-order Runge-Kutta method whose error control chooses the steps.",
    here: "Scene slide_11 with engine=rk45 and dt=0.05.",
    run: || {
        let mut fine = Experiment::new("slide_11", &[("engine", "rk4"), ("dt", "0.0025")])?;
        let mut fixed = Experiment::new("slide_11", &[("engine", "rk4"), ("dt", "0.05")])?;
        let mut adaptive = Experiment::new("slide_11", &[("engine", "rk45"), ("dt", "0.05")])?;
        [&mut fine, &mut fixed].into_iter().for_each(Experiment::run);
        adaptive.print_at(&[0.2, 0.4, 0.6, 0.8, 1.0, 8.0]);
        let first = |run: &Experiment| run.time_of(EventKind::FirstContact, "first");
        let flat = |run: &Experiment| run.time_of(EventKind::Flat, "floor");
        let text = |name: &str, run: &Experiment| {
            let end = match run.world.unstable() {
                Some(_) => format!("unstable at {:.2} s", run.world.time()),
                None => {
                    let (first, flat) = (seconds(first(run)), seconds(flat(run)));
                    format!("first contact {first}, flat {flat}, {:.0} ms of CPU", 1e3 * run.cpu)
                }
            };
            format!("{name}: {end}")
        };
        let measured = [
            text("fourth order, 2.5 ms", &fine),
            text("fourth order, 0.05 s", &fixed),
            text("fifth order, frames of 0.05 s", &adaptive),
        ];
        let near = |a: Option<f64>, b: Option<f64>| a.zip(b).is_some_and(|(a, b)| (a - b).abs() < FRAME + 0.1 * b);
        let holds = fixed.world.unstable().is_some()
            && near(first(&adaptive), first(&fine))
            && near(flat(&adaptive), flat(&fine));
        let strip: Strip = adaptive.strip("The fifth order chooses its own steps within frames of 0.05 s");
        let measured =
            format!("{}; contact is solved, and events are seen, at the end of a frame", measured.join("; "));
        Ok(Finding::new(measured, Verdict::proposal(holds, "its times differ")).with(strip))
    },
};

/// Ripples of the sheet along the rows of its bottom layer: mean number of reversals of the slope
/// in a row, and largest height from crest to trough between neighbouring reversals, m.
fn ripples(sheet: &Sheet) -> (f64, f64) {
    let layer = sheet.model.layers[0];
    let (mut reversals, mut highest) = (0_u32, 0.0_f64);
    for j in 1..layer.nz - 1 {
        let heights: Vec<f64> = (0..layer.nx).map(|i| sheet.state.x.get(layer.at(i, j) as usize).y).collect();
        let mut turn = heights[0];
        for w in heights.windows(3) {
            // A rise of a micrometre is a ripple; less is rounding of a flat sheet.
            if (w[1] - w[0]) * (w[2] - w[1]) < 0.0 && (w[1] - turn).abs() > 1e-6 {
                reversals += 1;
                highest = highest.max((w[1] - turn).abs());
                turn = w[1];
            }
        }
    }
    (f64::from(reversals) / f64::from(layer.nz - 2), highest)
}

pub(crate) const HOT_SPOTS: Row = Row {
    name: "7.4x-hot-spots",
    title: "5.4, 7.4 vi and x: hot spots, ripples and holes",
    says: "Seen in the real tests and not built: hot spots of the covered body let the plastic ripple, and holes \
           form there.",
    here: "Scene hot_spots.",
    run: || {
        let mut even = Experiment::new("hot_spots", &[("bodies.0.hot_spots", "[]")])?;
        even.run_to(0.5);
        let mut run = Experiment::new("hot_spots", &[])?;
        run.print();
        run.run_to(1.1);
        let (cold, warm) = (ripples(even.sheet()), ripples(run.sheet()));
        run.print_at(&[1.1, 1.3, 1.7, 2.5, 6.0]);
        let opened = run.time_of(EventKind::Torn, "").map(|t| t * run.world.scene().time_lapse);
        let whole = run.sheet().open_cells().map_or(0, <[bool]>::len);
        let holes =
            run.sheet().open_cells().map_or(0, |open| count_holes(open, run.sheet().model.layers[0].nx as usize - 1));
        let measured = format!(
            "after 2.2 s of heat (which runs twice as fast as motion) {:.1} reversals of slope along a row of nodes, ripples \
             at most {:.2} mm high, against {:.1} and {:.2} mm without hot spots; holes from {} of heat on, {holes} holes of {} cells out of {whole} at the end",
            warm.0,
            1e3 * warm.1,
            cold.0,
            1e3 * cold.1,
            seconds(opened),
            run.sheet().open_count(),
        );
        let holds = warm.1 > 1.2 * cold.1 && holes == 2;
        let strip = run.strip("A film over a plate with two hot spots");
        Ok(Finding::new(measured, Verdict::proposal(holds, "no ripples, or no holes over the spots")).with(strip))
    },
};

pub(crate) const TEARING: Row = Row {
    name: "7.4vi-tearing",
    title: "7.4 v and vi: tears and holes",
    says: "Proposed and not built: tears along the surface and holes in it.",
    here: "Scene torn_strip with sheets.0.structure=trimm and sheets.0.grid=(21,2,9); scene torn_disc with \
           sheets.0.grid=(13,1,13).",
    run: || {
        let trimm = [("sheets.0.structure", "trimm"), ("sheets.0.grid", "(21, 2, 9)")];
        let mut strip = Experiment::new("torn_strip", &trimm)?;
        let mut disc = Experiment::new("torn_disc", &[("sheets.0.grid", "(13, 1, 13)")])?;
        let open = |run: &Experiment| (run.sheet().open_count(), run.sheet().open_cells().map_or(0, <[bool]>::len));
        let (slit, _) = open(&disc);
        // It tears at 2.33 s, along the clamp.
        strip.print_at(&[2.3, 2.4, 2.7]);
        disc.print_at(&[0.0, 1.5, 3.0]);
        let (torn, cells) = open(&strip);
        let (wide, of) = open(&disc);
        let measured = format!(
            "a strip of TRiMM, drawn out by two fifths: {torn} of {cells} triangles open; a disc with a cross of {slit} open \
             triangles, pushed open by a ball: {wide} of {of}"
        );
        let stable = [&strip, &disc].iter().all(|run| run.world.unstable().is_none());
        let holds = stable && torn > 0 && wide > slit;
        let mut prints = strip.strip("A strip of TRiMM and a slit disc tear");
        prints.prints.append(&mut disc.strip("").prints);
        Ok(Finding::new(measured, Verdict::proposal(holds, "nothing tears")).with(prints))
    },
};

/// Number of connected groups of open cells of a grid with `columns` columns.
fn count_holes(open: &[bool], columns: usize) -> usize {
    let mut seen = vec![false; open.len()];
    let mut holes = 0;
    for start in 0..open.len() {
        if !open[start] || seen[start] {
            continue;
        }
        holes += 1;
        let mut todo = vec![start];
        while let Some(cell) = todo.pop() {
            if !open[cell] || std::mem::replace(&mut seen[cell], true) {
                continue;
            }
            let column = cell % columns;
            let sides = [
                (column > 0).then(|| cell - 1),
                (column + 1 < columns).then(|| cell + 1),
                cell.checked_sub(columns),
                (cell + columns < open.len()).then(|| cell + columns),
            ];
            todo.extend(sides.into_iter().flatten());
        }
    }
    holes
}
