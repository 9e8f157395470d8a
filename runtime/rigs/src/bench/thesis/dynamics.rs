//! Drops of the thesis's sheet (thesis 5.3.4): restitution, friction, structures, two walls, dome.

use sheetwork::InputError;
use sheetwork::islands::event::EventKind;

use crate::bench::thesis::experiment::{Experiment, rest, seconds};
use crate::bench::thesis::measures::{half_stretch, layer_distance, probe, stretch_x, stretch_z, turned_over, yaw};
use crate::bench::thesis::{Finding, Row, Verdict};

/// Largest height of the centre of mass in the tenth of a second after the first contact with the
/// floor, above its lowest point before, m; and smallest mean distance of the layers.
fn rebound(run: &mut Experiment) -> (f64, f64) {
    let (mut lowest, mut highest, mut squeezed) = (f64::INFINITY, 0.0_f64, 1.0_f64);
    let start = Experiment::new("flat_floor_e0", &[]);
    run.run_watching(2.0, |world| {
        let sheet = &world.sheets()[0];
        if world.events().is_empty() {
            return;
        }
        let height = sheet.centre_of_mass().y;
        lowest = lowest.min(height);
        highest = highest.max(height - lowest);
        if let Ok(start) = &start {
            squeezed = squeezed.min(layer_distance(start.first(), sheet));
        }
    });
    (highest, squeezed)
}

pub(crate) const RESTITUTION: Row = Row {
    name: "figure-5.10",
    title: "Figure 5.10: restitution 0.1 and 0 on a flat floor",
    says: "With restitution the outer masses move along the floor and the whole sheet lifts off once before it \
           rests. Without, the layers are pressed together and restored, and the sheet does not bounce.",
    here: "Scenes flat_floor_e01 and flat_floor_e0, whose springs between the layers are stiffer than those in them \
           (inter_layer: SumModulus).",
    run: || {
        let (mut with, mut without) = (Experiment::new("flat_floor_e01", &[])?, Experiment::new("flat_floor_e0", &[])?);
        let (first, second) = (rebound(&mut with), rebound(&mut without));
        with.run();
        without.run();
        let restored = layer_distance(without.first(), without.sheet());
        let mut equal = Experiment::new("flat_floor_e0", &[("sheets.0.inter_layer", "Planar")])?;
        equal.run();
        let pressed = layer_distance(equal.first(), equal.sheet());
        let measured = format!(
            "rebound of the centre of mass {:.2} mm with, {:.2} mm without; layers at least {:.2} of their distance apart \
             at the impact, {restored:.2} at rest ({pressed:.2} with equal springs); {}, {}",
            1e3 * first.0,
            1e3 * second.0,
            second.1,
            rest(&with),
            rest(&without)
        );
        let mut prints = Experiment::new("flat_floor_e01", &[])?;
        prints.print_at(&[0.22, 0.26, 0.32, 0.4, 0.6, 2.0]);
        let holds = first.0 > 2.0 * second.0 && restored > 0.8 && with.is_sound() && without.is_sound();
        let reason = "the layers stay pressed together after the landing";
        Ok(Finding::new(measured, Verdict::of(holds, reason)).with(prints.strip("A flat landing with restitution 0.1")))
    },
};

pub(crate) const FRICTION_HIGH: Row = Row {
    name: "figure-5.11a",
    title: "Figure 5.11a: friction 0.9 on a slope",
    says: "The sheet lands on the slope, creeps down it to the flat ground, and rests there.",
    here: "Scene slope_friction_09.",
    run: || {
        let mut run = Experiment::new("slope_friction_09", &[])?;
        run.print_at(&[0.15, 0.2, 0.3, 0.6, 1.0]);
        run.run();
        run.print();
        let moved = run.sheet().centre_of_mass() - run.first().centre_of_mass();
        let measured = format!(
            "{}, {:.1} mm down the slope of 40° from where it landed; it stays on it",
            rest(&run),
            1e3 * moved.x.max(0.0)
        );
        let reason = "the thesis prints no angle; on the 40° of this scene tan 40° = 0.84 is below 0.9, and Coulomb friction \
                      slows the sheet and stops it before the ground";
        let verdict = Verdict::of(run.time_of(EventKind::SlidOff, "slope").is_some(), reason);
        Ok(Finding::new(measured, verdict).with(run.strip("Friction 0.9 on a slope")))
    },
};

pub(crate) const FRICTION_NONE: Row = Row {
    name: "figure-5.11b",
    title: "Figure 5.11b: no friction on a slope",
    says: "Gravity takes the sheet down the slope with growing speed, and over the floor until it leaves the scene.",
    here: "Scene slope_friction_0.",
    run: || {
        let mut run = Experiment::new("slope_friction_0", &[])?;
        run.print_at(&[0.15, 0.3, 0.45, 0.6, 0.9, 1.3]);
        run.run();
        let off = run.time_of(EventKind::SlidOff, "slope");
        let speed = run.sheet().momentum().x / run.sheet().total_mass();
        let measured = format!(
            "off the slope after {}, then {:.0} mm/s over the floor, {:.0} mm from where it landed at {:.1} s",
            seconds(off),
            1e3 * speed,
            1e3 * (run.sheet().centre_of_mass() - run.first().centre_of_mass()).x,
            run.world.time()
        );
        let right = run.world.scene().room.as_ref().map_or(0.0, |room| room.x.1);
        let left = run.sheet().state.x.iter().all(|p| p.x > right);
        let reason = "it leaves the slope with growing speed, but the scene's air, which takes 3 % of the speed in every \
                      15 ms, stops it on the floor at the border of the room";
        let verdict = Verdict::of(off.is_some() && left, reason);
        Ok(Finding::new(measured, verdict).with(run.strip("No friction on a slope")))
    },
};

/// The sheet of a structure on the wedge, with the printed springs between the layers: the run, its
/// yaw (degrees), and its greatest extension.
fn on_wedge(structure: &str) -> Result<(Experiment, f64, f64), InputError> {
    let set = [("sheets.0.structure", structure), ("sheets.0.inter_layer", "Planar")];
    let mut run = Experiment::new("wedge", &set)?;
    let start = Experiment::new("wedge", &set)?;
    let mut most = 1.0_f64;
    for time in [0.15, 0.22, 0.3, 0.4, 0.6, 3.0] {
        run.run_watching(time, |world| most = most.max(stretch_x(start.first(), &world.sheets()[0])));
        run.print();
    }
    run.run();
    let turned = yaw(run.first(), run.sheet());
    Ok((run, turned, most))
}

fn wedge_text(run: &Experiment, turned: f64, most: f64) -> String {
    format!(
        "{}; yaw {turned:.2}°, longest {most:.3} of its length at the impact, {:.3} at rest",
        rest(run),
        stretch_x(run.first(), run.sheet())
    )
}

pub(crate) const SAMM: Row = Row {
    name: "figure-5.16",
    title: "Figure 5.16: SaMM on a wedge",
    says: "The weakest structure: it deforms and stretches more than the others. It does not yaw.",
    here: "Scene wedge with sheets.0.structure=samm and sheets.0.inter_layer=Planar.",
    run: || {
        let (mut samm, turned, most) = on_wedge("samm")?;
        let others = [on_wedge("slamm")?.2, on_wedge("trimm")?.2];
        let measured =
            format!("{}; SLaMM at most {:.3}, TRiMM {:.3}", wedge_text(&samm, turned, most), others[0], others[1]);
        let verdict = Verdict::of(
            turned.abs() < 1.0 && most > others[0].max(others[1]),
            "it does not yaw and stretches more than SLaMM, but no more than TRiMM: on this wedge the squares of SaMM are \
             loaded along their sides, where it has as many springs; its weakness is in shear",
        );
        Ok(Finding::new(measured, verdict).with(samm.strip("SaMM on a wedge")))
    },
};

pub(crate) const SLAMM: Row = Row {
    name: "figure-5.17",
    title: "Figure 5.17: SLaMM on a wedge",
    says: "The single diagonal distorts the sheet, which yaws as it slides; SaMM in its place does not.",
    here: "Scene wedge with sheets.0.structure=slamm and sheets.0.inter_layer=Planar.",
    run: || {
        let ((mut slamm, turned, most), (_, without, _)) = (on_wedge("slamm")?, on_wedge("samm")?);
        let measured = format!("{}; SaMM {without:.2}°", wedge_text(&slamm, turned, most));
        let verdict = Verdict::of(turned.abs() > 1.5 && turned.abs() > 4.0 * without.abs(), "it does not yaw");
        Ok(Finding::new(measured, verdict).with(slamm.strip("SLaMM on a wedge")))
    },
};

pub(crate) const TRIMM: Row = Row {
    name: "figure-5.18",
    title: "Figure 5.18: TRiMM on a wedge",
    says: "The most robust structure: regular deformation, stable and rigid under gentle loads.",
    here: "Scene wedge with sheets.0.inter_layer=Planar.",
    run: || {
        let ((mut trimm, turned, most), (_, slamm, longest)) = (on_wedge("trimm")?, on_wedge("slamm")?);
        let text = wedge_text(&trimm, turned, most);
        let measured = format!("{text}; SLaMM yaws {slamm:.2}° and is at most {longest:.3} long");
        let steady = trimm.is_sound() && turned.abs() < 0.2 * slamm.abs();
        let reason =
            "it is stable and does not yaw, but it stretches more than SLaMM, and its edge at the ridge is ragged";
        let verdict = Verdict::of(steady && most < longest, reason);
        Ok(Finding::new(measured, verdict).with(trimm.strip("TRiMM on a wedge")))
    },
};

pub(crate) const SECOND_DIAGONAL: Row = Row {
    name: "5.3.4-second-diagonal",
    title: "5.3.4: a second diagonal in SLaMM",
    says: "Proposed and not built: a second diagonal in each cell would give a stronger, more uniform structure.",
    here: "Scene wedge with sheets.0.structure=double-diagonal and sheets.0.inter_layer=Planar.",
    run: || {
        let ((mut both, turned, most), (_, single, _)) = (on_wedge("double-diagonal")?, on_wedge("slamm")?);
        let measured = format!("{}; with one diagonal {single:.2}°", wedge_text(&both, turned, most));
        let verdict = Verdict::of(turned.abs() < 0.25 * single.abs(), "it yaws all the same");
        Ok(Finding::new(measured, verdict).with(both.strip("Both diagonals on a wedge")))
    },
};

pub(crate) const TWO_WALLS: Row = Row {
    name: "figure-5.21",
    title: "Figure 5.21: a stiff sheet between two walls",
    says: "It comes to rest bent between the walls without the spring-back of softer sheets.",
    here: "Scene two_walls.",
    run: || {
        let mut run = Experiment::new("two_walls", &[])?;
        let (mut lowest, mut back) = (f64::INFINITY, 0.0_f64);
        for time in [0.15, 0.25, 0.4, 0.6, 1.0, 8.0] {
            run.run_watching(time, |world| {
                let height = probe(&world.sheets()[0], "centre").y;
                lowest = lowest.min(height);
                back = back.max(height - lowest);
            });
            run.print();
        }
        let sag = probe(run.sheet(), "edge").y - probe(run.sheet(), "centre").y;
        let text = rest(&run);
        let measured =
            format!("{text}; the centre {:.1} mm below the edges, after {:.1} mm back up", 1e3 * sag, 1e3 * back);
        let reason = "it rests bent between the walls, but swings back once before: the thesis prints no stiffness and \
                      damping for this figure, and those of the scene (0.14) do not suppress it";
        let verdict = Verdict::of(run.is_sound() && sag > 1e-3 && back < 0.1 * sag, reason);
        Ok(Finding::new(measured, verdict).with(run.strip("A stiff sheet between two walls")))
    },
};

pub(crate) const DOME: Row = Row {
    name: "figure-5.22",
    title: "Figure 5.22: folding over itself on a dome",
    says: "The sheet stretches over the dome, draws together to its unloaded shape, slides down, folds over itself, \
           and rests folded.",
    here: "Scene dome_fold.",
    run: || {
        let mut run = Experiment::new("dome_fold", &[])?;
        let start = Experiment::new("dome_fold", &[])?;
        let mut most = 1.0_f64;
        for time in [0.2, 0.28, 0.4, 0.6, 0.9, 4.0] {
            run.run_watching(time, |world| {
                let sheet = &world.sheets()[0];
                most = most.max(stretch_x(start.first(), sheet)).max(stretch_z(start.first(), sheet));
            });
            run.print();
        }
        let (over, end) = (turned_over(run.sheet()), half_stretch(run.first(), run.sheet(), true));
        let measured = format!(
            "longest {most:.2} of its length at the impact, {end:.2} at the end; {:.0} % of it turned over; off the dome \
             after {}; {}",
            100.0 * over,
            seconds(run.time_of(EventKind::SlidOff, "dome")),
            rest(&run)
        );
        let verdict = Verdict::of(most > 1.1 && end < 1.1 && over > 0.05, "it does not fold over itself");
        Ok(Finding::new(measured, verdict).with(run.strip("A sheet folds over itself on a dome")))
    },
};

pub(crate) const FLEXION: Row = Row {
    name: "6.2-flexion",
    title: "6.2, figure 6.2: limit of the flexion angle",
    says: "Where the angle between two springs in line exceeds a preset value, it is held at that value.",
    here: "Scene wedge with sheets.0.flexion_limit and structure=provot3d, or provot2d with grid=(11,1,11).",
    run: || {
        let mut lines = Vec::new();
        let mut holds = true;
        for (structure, grid) in [("provot2d", "(11, 1, 11)"), ("provot3d", "(11, 2, 11)")] {
            for limit in ["60", "40", "20", "10"] {
                let set =
                    [("sheets.0.structure", structure), ("sheets.0.grid", grid), ("sheets.0.flexion_limit", limit)];
                let mut run = Experiment::new("wedge", &set)?;
                let mut most = 0.0_f64;
                run.run_watching(8.0, |world| {
                    most = most.max(world.sheets()[0].largest_flexion_angle().unwrap_or(f64::INFINITY));
                });
                let end = run.sheet().largest_flexion_angle().unwrap_or(f64::INFINITY);
                let wanted: f64 = limit.parse().unwrap_or(f64::NAN);
                holds &= most < wanted + 1.0 && run.is_sound();
                lines.push(format!("{structure} {limit}°: at most {most:.2}°, {end:.2}° at the end, {}", rest(&run)));
            }
        }
        Ok(Finding::new(lines.join("; "), Verdict::of(holds, "the limit is exceeded, or the sheet does not rest")))
    },
};
