//! Models of damping (thesis 3.6.1, figures 3.8 to 3.13): strain of a strip under a constant load
//! and after its removal, and the instability of figure 3.15.
//!
//! A strip clamped at one end hangs under a small weight for a time T and then without weight. All
//! models are limits of Burgers' model, whose strain over the elastic one is
//!
//!   J(t) = 1 + t/τ₁ + r (1 - e^(-t/τ₂)) under the load, and after it
//!   J(t) - J(t - T) = T/τ₁ + r (e^(-(t - T)/τ₂) - e^(-t/τ₂)):
//!
//! a spring has none of the terms but 1, a dashpot T ≫ τ₁, the Maxwell element r = 0, the
//! Kelvin-Voigt element r ≫ 1.

use glam::DVec3;
use sheetwork::scene::{BurgersCreep, Material, MaterialChoice, PinSpec, Region, Scene, SheetSpec};
use sheetwork::{InputError, World};

use crate::bench::thesis::diagram::Diagram;
use crate::bench::thesis::experiment::Experiment;
use crate::bench::thesis::{Finding, Row, Verdict};

/// Time under load, and as long without, s.
const LOADED: f64 = 1.0;
/// Steps of each half.
const STEPS: u32 = 200;
/// Size of the strip, m.
const LENGTH: f64 = 0.1;
/// Gravity under load, m/s²; the elastic deflection is a millionth of the length, so that a
/// thousandfold one is still small.
const GRAVITY: f64 = 1e-4;

/// Strain over the elastic strain at each time.
type Curve = Vec<(f64, f64)>;

/// Curve of a material with this creep law.
fn curve(burgers: BurgersCreep) -> Result<Curve, InputError> {
    let material = Material {
        young: 1e8,
        poisson: 0.3,
        density: 1000.0,
        thickness: 1e-3,
        glass_transition: None,
        burgers: Some(burgers),
        ..Material::default()
    };
    let sheet = SheetSpec {
        grid: (11, 1, 3),
        size: (LENGTH, 0.02),
        material: MaterialChoice::Inline(material),
        creep: true,
        pins: vec![PinSpec::clamped(Region::Left)],
        ..SheetSpec::default()
    };
    let scene = Scene { gravity: DVec3::new(0.0, -GRAVITY, 0.0), sheets: vec![sheet], ..Scene::default() };
    let mut world = World::new(&scene)?;
    let tip = |world: &World| {
        let sheet = &world.sheets()[0];
        -sheet.state.x.get(sheet.model.layers[0].at(10, 1) as usize).y
    };
    let tolerance = 1e-12 * LENGTH;
    world.find_equilibrium(tolerance);
    let elastic = tip(&world);
    let dt = LOADED / f64::from(STEPS);
    let mut curve = vec![(0.0, 0.0), (0.0, 1.0)];
    for step in 1..=STEPS {
        world.creep_in_equilibrium(dt, tolerance);
        curve.push((f64::from(step) * dt, tip(&world) / elastic));
    }
    world.set_gravity(DVec3::ZERO)?;
    world.find_equilibrium(tolerance);
    curve.push((LOADED, tip(&world) / elastic));
    for step in 1..=STEPS {
        world.creep_in_equilibrium(dt, tolerance);
        curve.push((LOADED + f64::from(step) * dt, tip(&world) / elastic));
    }
    Ok(curve)
}

/// Largest difference of a curve from the closed form, over the largest strain.
fn error(curve: &Curve, law: BurgersCreep) -> f64 {
    let compliance = |t: f64| 1.0 + t / law.relaxation_time - law.retarded * (-t / law.retardation_time).exp_m1();
    let most = compliance(LOADED);
    let off = |(index, (t, strain)): (usize, &(f64, f64))| {
        let loaded = index < STEPS as usize + 2;
        let wanted = if loaded { compliance(*t) } else { compliance(*t) - compliance(t - LOADED) };
        if index == 0 { 0.0 } else { (strain - wanted).abs() / most }
    };
    curve.iter().enumerate().map(off).fold(0.0, f64::max)
}

/// Runs a law: strain at the end of the load, at its removal and at the end, each over the elastic.
fn finding(law: BurgersCreep, name: &str, holds: fn([f64; 3]) -> bool) -> Result<Finding, InputError> {
    let curve = curve(law)?;
    let at = |index: usize| curve[index].1;
    let strains = [at(STEPS as usize + 1), at(STEPS as usize + 2), at(curve.len() - 1)];
    let off = error(&curve, law);
    let measured = format!(
        "strain over the elastic one {:.3} under load for 1 s, {:.3} at its removal, {:.3} a second later; largest \
         difference from the closed form {:.2} % of the largest strain",
        strains[0],
        strains[1],
        strains[2],
        100.0 * off
    );
    let verdict = Verdict::of(holds(strains) && off < 0.01, "the strain has another course");
    let diagram = Diagram {
        caption: format!("Strain of a strip under a load of one second: {name}"),
        axes: ("time, s", "strain over the elastic strain"),
        curves: vec![(name.to_owned(), curve)],
    };
    Ok(Finding::new(measured, verdict).with_diagram(diagram))
}

const fn law(relaxation_time: f64, retardation_time: f64, retarded: f64) -> BurgersCreep {
    BurgersCreep { relaxation_time, retardation_time, retarded }
}

pub(crate) const SPRING: Row = Row {
    name: "figure-3.8",
    title: "Figure 3.8: strain of a spring",
    says: "The strain is there with the force, and falls to zero at once when the force is removed.",
    here: "A clamped strip under a small weight for 1 s, then without it, against the closed form.",
    run: || {
        finding(law(1e12, 1.0, 0.0), "spring", |[on, off, end]| {
            (on - 1.0).abs() < 1e-6 && off.abs() < 1e-6 && end.abs() < 1e-6
        })
    },
};

pub(crate) const DASHPOT: Row = Row {
    name: "figure-3.9",
    title: "Figure 3.9: strain of a dashpot",
    says: "The strain grows in proportion to time under the force, and stays when the force is removed.",
    here: "A clamped strip under a small weight for 1 s, then without it, against the closed form.",
    run: || {
        finding(law(1e-3, 1.0, 0.0), "dashpot", |[on, off, end]| {
            (on / 1001.0 - 1.0).abs() < 0.01 && (off / on - 1.0).abs() < 0.01 && (end / off - 1.0).abs() < 1e-3
        })
    },
};

pub(crate) const MAXWELL: Row = Row {
    name: "figure-3.10",
    title: "Figure 3.10: strain of a Maxwell element",
    says: "The strain grows in proportion to time; at the removal of the force it falls to a lower level and stays \
           there.",
    here: "A clamped strip under a small weight for 1 s, then without it, against the closed form.",
    run: || {
        finding(law(0.5, 1.0, 0.0), "Maxwell element", |[on, off, end]| {
            (on - off - 1.0).abs() < 0.02 && (end - off).abs() < 0.01 && off > 1.0
        })
    },
};

pub(crate) const KELVIN_VOIGT: Row = Row {
    name: "figure-3.11",
    title: "Figure 3.11: strain of a Kelvin-Voigt element",
    says: "The strain increases smoothly to a steady level under the force and returns gradually to zero without it.",
    here: "A clamped strip under a small weight for 1 s, then without it, against the closed form.",
    run: || {
        finding(law(1e12, 0.15, 200.0), "Kelvin-Voigt element", |[on, off, end]| {
            on > 195.0 && off > 0.99 * (on - 1.0) && end < 0.01 * off
        })
    },
};

pub(crate) const BURGERS: Row = Row {
    name: "figure-3.13",
    title: "Figures 3.13 and 3.14: the advanced damping model",
    says: "Proposed and not built: an elastic, a viscoelastic and a viscous part in series. At the removal of the \
           force the elastic strain is recovered at once, the viscoelastic one with time, the viscous one never.",
    here: "A clamped strip under a small weight for 1 s, then without it, against the closed form.",
    run: || {
        finding(law(1.0, 0.15, 1.0), "Burgers' model", |[on, off, end]| {
            (on - off - 1.0).abs() < 0.02 && end < off && (end - 1.0).abs() < 0.01
        })
    },
};

pub(crate) const INSTABILITY: Row = Row {
    name: "figure-3.15",
    title: "Figure 3.15: an unstable sheet",
    says: "With a step that is too long the sheet gains energy until it explodes.",
    here: "Scene wedge with dt=0.015.",
    run: || {
        let mut run = Experiment::new("wedge", &[("dt", "0.015")])?;
        let mut before = 0.0;
        run.run_watching(2.0, |world| before = f64::max(before, world.sheets()[0].max_speed()));
        let measured = match run.world.unstable() {
            Some(_) => format!("unstable at {:.3} s; the sheet is stopped and reported", run.world.time()),
            None => format!("stable for {:.1} s, fastest mass {before:.2} m/s", run.world.time()),
        };
        Ok(Finding::new(measured, Verdict::of(run.world.unstable().is_some(), "it stays stable")))
    },
};
