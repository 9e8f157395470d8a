//! Layers of the sheet: the layer that is drawn (figures 5.12 and 5.13), and their number (3.6.3).

use sheetwork::World;
use sheetwork::sheet::surface::SurfaceSmoothing;

use crate::bench::thesis::experiment::{Experiment, rest};
use crate::bench::thesis::measures::layer_distance;
use crate::bench::thesis::picture::Strip;
use crate::bench::thesis::{Finding, Row, Verdict};
use crate::drawn_surface::drawn_surfaces;
use crate::measure::stability_limit::longest_step;

pub(crate) const BOTTOM: Row = Row {
    name: "figures-5.12-5.13",
    title: "Figures 5.12 and 5.13: bottom and top layer over a wedge and a cube",
    says: "Drawing the bottom or the top layer makes no significant difference to the behaviour; smoothed, the \
           bottom layer sinks into what it touches.",
    here: "Scene wedge_and_cube.",
    run: || {
        let mut run = Experiment::new("wedge_and_cube", &[])?;
        for time in [0.22, 0.3, 8.0] {
            run.run_to(time);
            let time = run.world.time();
            for (layer, name) in ["bottom layer", "top layer"].iter().enumerate() {
                run.print_layer(&format!("{time:.2} s, {name}"), layer, Some(SurfaceSmoothing::BSpline));
            }
        }
        let distance = layer_distance(run.first(), run.sheet());
        let all = drawn_surfaces(&run.world);
        let depth = |layer: usize| {
            let found = all.iter().find(|s| s.layer == layer && s.smoothing == "b-spline");
            found.and_then(|s| s.depth_m).unwrap_or(0.0)
        };
        let [bottom, top] = [0, 1].map(depth);
        let measured = format!(
            "both layers are of one run, pressed to {distance:.2} of their distance at rest (the springs between them are as \
             stiff as the planar ones); smoothed by a B-spline, the bottom layer is {:.2} mm and the top layer {:.2} mm deep \
             in the bodies; {}",
            1e3 * bottom,
            1e3 * top,
            rest(&run)
        );
        let holds = run.is_sound() && bottom > 1e-4 && top < 0.2 * bottom;
        let reason = "the smoothed bottom layer sinks into wedge and cube as described, and the top layer nearly as far: the \
                      layers lie close to each other there";
        let strip = run.strip("A sheet over a wedge and a cube");
        Ok(Finding::new(measured, Verdict::of(holds, reason)).with(strip))
    },
};

pub(crate) const SMOOTHED: Row = Row {
    name: "figure-5.14",
    title: "Figure 5.14: the sheet with and without NURBS",
    says: "Without smoothing the edges of the sheet are ragged; the smoothed sheet looks better, but sinks into \
           bodies, as contact knows only the masses.",
    here: "Scene cube during the impact.",
    run: || {
        let mut run = Experiment::new("cube", &[])?;
        run.run_to(0.3);
        let all = drawn_surfaces(&run.world);
        let of = |name: &str| all.iter().find(|s| s.layer == 1 && s.smoothing == name);
        let text = |name: &str| {
            let found = of(name)?;
            let depth = 1e3 * found.depth_m.unwrap_or(0.0);
            Some(format!(
                "{name}: sharpest bend of its edge {:.0}°, {depth:.2} mm deep in the cube",
                found.edge_kink_deg
            ))
        };
        let names = ["flat", "interpolating", "b-spline", "bezier"];
        let lines: Vec<String> = names.into_iter().filter_map(text).collect();
        let kink = |name: &str| of(name).map_or(f64::NAN, |s| s.edge_kink_deg);
        let depth = |name: &str| of(name).and_then(|s| s.depth_m).unwrap_or(0.0);
        let holds = kink("b-spline") < 0.5 * kink("flat") && depth("b-spline") > depth("interpolating");
        let kinds = [("without smoothing", None), ("NURBS (B-spline)", Some(SurfaceSmoothing::BSpline))];
        for time in [0.3, 0.36, 0.5] {
            run.run_to(time);
            for (name, smoothing) in kinds {
                run.print_layer(&format!("{time} s, {name}"), 1, smoothing);
            }
        }
        let reason = "the smoothed surface does not sink deeper, or its edge is as ragged";
        Ok(Finding::new(lines.join("; "), Verdict::of(holds, reason)).with(run.strip("A sheet falls on a cube")))
    },
};

pub(crate) const CONTACT_SURFACE: Row = Row {
    name: "7.3e-contact-surface",
    title: "7.3 e: contact that knows the smoothed surface",
    says: "Proposed and not built: the smoothed surface goes into the collision test, so that it does not sink into \
           bodies.",
    here: "Scene wedge with `contact_surface`.",
    run: || {
        let kinds =
            [("Masses", "interpolating"), ("Smooth", "interpolating"), ("Masses", "b-spline"), ("BSpline", "b-spline")];
        let (mut lines, mut at_rest, mut sound) = (Vec::new(), Vec::new(), true);
        let mut prints = Vec::new();
        for (surface, drawn) in kinds {
            let mut run = Experiment::new("wedge", &[("sheets.0.contact_surface", surface)])?;
            let mut impact = 0.0_f64;
            run.run_watching(0.6, |world| impact = impact.max(depth_of(world, drawn)));
            run.run();
            run.print_as(&format!("contact of {surface}"));
            let depth = depth_of(&run.world, drawn);
            lines.push(format!(
                "{drawn}, contact of {surface}: {:.3} mm deep at impact, {:.3} mm at the end, {}",
                1e3 * impact,
                1e3 * depth,
                rest(&run)
            ));
            at_rest.push(depth);
            sound &= run.is_sound();
            if drawn == "interpolating" || surface == "BSpline" {
                prints.append(&mut run.strip("").prints);
            }
        }
        let sinks = |i: usize| at_rest[i] > 3e-4 && at_rest[i + 1] < 1e-4;
        let finding = Finding::new(
            lines.join("; "),
            Verdict::proposal(sound && sinks(0) && sinks(2), "the surface sinks, or does not rest"),
        );
        let caption = "Contact of the nodes, of the surface through them, and of the B-spline surface".to_owned();
        Ok(finding.with(Strip { caption, prints }))
    },
};

/// Depth of the drawn bottom layer of the first sheet in bodies, m.
fn depth_of(world: &World, smoothing: &str) -> f64 {
    let all = drawn_surfaces(world);
    all.iter().find(|s| s.layer == 0 && s.smoothing == smoothing).and_then(|s| s.depth_m).unwrap_or(0.0)
}

pub(crate) const LAYERS: Row = Row {
    name: "3.6.3-layers",
    title: "3.6.3: layers and stability",
    says: "Layers with additional springs between them support the structure and help to keep the simulation stable, \
           compared with a single layer.",
    here: "Scene wedge with sheets.0.grid=(11,N,11).",
    run: || {
        let mut lines = Vec::new();
        let mut steps = Vec::new();
        for layers in 1..=6 {
            let grid = format!("(11, {layers}, 11)");
            let mut fall = Experiment::new("wedge", &[("sheets.0.grid", &grid)])?;
            let sheet = fall.first();
            let springs = sheet.springs();
            let omega = sheet.largest_frequency(400);
            let tau = springs.damping[0] / springs.stiffness[0];
            let longest = longest_step(fall.world.engine(), omega, tau);
            steps.push(longest);
            fall.run();
            let end = match fall.world.unstable() {
                Some(_) => "unstable".to_owned(),
                None if fall.world.is_resting() => "at rest".to_owned(),
                None => format!("{:.2} m/s after 8 s", fall.sheet().max_speed()),
            };
            lines.push(format!("{layers}: {omega:.0} rad/s, {:.1} ms, {end} at 5 ms", 1e3 * longest));
        }
        let measured = format!("layers: fastest mode, longest step of Euler-Richardson: {}", lines.join("; "));
        let reason = "more springs on a mass make its fastest mode faster, and the longest explicit step shorter; layers \
                      support the shape of the sheet, not its integration; four and more need a shorter one than 5 ms to \
                      come to rest in order";
        Ok(Finding::new(measured, Verdict::of(steps[1] >= steps[0], reason)))
    },
};
