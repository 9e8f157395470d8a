//! Sheets of random material, size, pose and clamp with a random velocity of every node, as a
//! search for instability.
//!
//! White noise in the velocities is the harshest input of a game: it demands strains of many times
//! the sheet's length. The sheet must stay finite and in one piece, without energy gain.

use glam::DVec3;

use crate::measure::random_sequence::RandomSequence;
use sheetwork::mesh::structure::StructureKind;
use sheetwork::scene::{IntegratorKind, MaterialChoice, PinSpec, Placement, Region, Scene, SheetSpec};
use sheetwork::{InputError, World};

/// A kicked sheet and its result.
#[derive(Clone, Debug, PartialEq)]
pub struct Kick {
    /// Number of the random draw.
    pub index: u64,
    /// Description of the draw.
    pub what: String,
    /// Simulated time, s.
    pub simulated: f64,
    /// Largest energy after the start over the energy at the start, both relative to the lowest
    /// point of the fall.
    pub energy_ratio: f64,
    /// Stages that needed the globalised Newton method, and all stages.
    pub guarded: (u64, u64),
    /// Linear solves.
    pub solves: u64,
    /// Description of the instability; `None` for a stable run.
    pub unstable: Option<String>,
}

/// Draws sheet number `index`, kicks it and steps it for `seconds` of simulated time at 60 Hz.
///
/// # Errors
/// A scene that fails validation, which is a defect of the random draw.
pub fn kick(index: u64, structures: &[StructureKind], seconds: f64) -> Result<Kick, InputError> {
    let mut draw = RandomSequence::new(0, index);
    let (sheet, speed, what) = draw_sheet(&mut draw, structures);
    let length = sheet.size.0;
    let scene = Scene { engine: IntegratorKind::TrBdf2, dt: 1.0 / 60.0, sheets: vec![sheet], ..Scene::default() };
    let mut world = World::new(&scene)?;
    world.set_sleep(false);
    let sheet = &mut world.sheets_mut()[0];
    for i in 0..sheet.node_count() {
        if !sheet.is_held(i) {
            let v = DVec3::new(draw.between(-1.0, 1.0), draw.between(-1.0, 1.0), draw.between(-1.0, 1.0)) * speed;
            sheet.state.v.set(i, v);
        }
    }
    let start = sheet.energy(scene.gravity);
    let weight = sheet.total_mass() * scene.gravity.length();
    let steps = (seconds / scene.dt).round() as u64;
    let mut highest = 0.0_f64;
    for _ in 0..steps {
        world.step();
        if world.unstable().is_some() {
            break;
        }
        highest = highest.max(world.sheets()[0].energy(scene.gravity).total - start.total);
    }
    let counters = world.sheets()[0].state.counters;
    Ok(Kick {
        index,
        what,
        simulated: world.time(),
        // Energy of the kick plus a fall of the sheet's own length.
        energy_ratio: 1.0 + highest / (start.kinetic + start.elastic + weight * length).max(f64::MIN_POSITIVE),
        guarded: (counters.guarded, 2 * counters.accepted),
        solves: counters.evaluations,
        unstable: world.unstable().map(|s| format!("{:?}", s.state.status)),
    })
}

/// Draw a sheet, the speed (m/s) of its kick, and their description.
fn draw_sheet(draw: &mut RandomSequence, structures: &[StructureKind]) -> (SheetSpec, f64, String) {
    let (name, mut material) = draw.material();
    material.thickness *= draw.scale(0.5, 2.0);
    let structure = draw.pick(structures);
    let length = draw.scale(0.03, 2.0);
    let width = length * draw.scale(0.25, 1.0);
    let nx = draw.between(4.0, 22.0) as u32;
    let nz = ((f64::from(nx - 1) * width / length).round() as u32 + 1).max(3);
    let pins = match (draw.unit() * 4.0) as u32 {
        0 => Vec::new(),
        1 => vec![PinSpec::clamped(Region::Left)],
        2 => vec![PinSpec::fixed(Region::Left)],
        _ => vec![PinSpec::fixed(Region::Point(0.0, 0.0)), PinSpec::fixed(Region::Point(1.0, 0.0))],
    };
    let speed = draw.scale(0.1, 20.0);
    let damping = draw.pick(&[0.0, 0.0, 0.01, 0.1, 1.0]);
    let (fewest, most) = structure.info().layers;
    let sheet = SheetSpec {
        structure,
        grid: (nx, 2.clamp(fewest, most), nz),
        size: (length, width),
        gap: 0.25 * length / f64::from(nx - 1),
        material: MaterialChoice::Inline(material.clone()),
        damping_ratio: Some(damping),
        placement: Placement { rotation: draw.turns(), ..Placement::default() },
        pins,
        ..SheetSpec::thesis()
    };
    let what = format!(
        "{name} {structure} {nx}x{nz} {length:.3}x{width:.3} m, t {:.2e} m, {speed:.2} m/s, damping {damping}",
        material.thickness
    );
    (sheet, speed, what)
}
