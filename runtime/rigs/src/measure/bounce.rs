//! A flat drop on a floor with restitution e. The rebound heights are h e², h e⁴, ..., and the
//! energy after the first impact is e² times the energy before it.

use glam::DVec3;
use serde_json::json;

use crate::measure::contact_observer::{self, ContactObserver};
use crate::measure::{RigResult, Runner, Setup, plane};
use sheetwork::World;
use sheetwork::scene::Placement;

/// Number of rebounds to wait for.
const REBOUNDS: usize = 3;

/// Height of the centre of mass above its resting height on the floor, m.
#[derive(Default)]
struct Flight {
    last_height: f64,
    last_rise: f64,
    heights: Vec<f64>,
    /// Energy at the top of the first rebound, or at the end without a rebound, J.
    energy_after_impact: Option<f64>,
    /// Largest height after the first contact.
    highest: f64,
    met: bool,
}

pub(crate) fn run(setup: &Setup) -> RigResult {
    let mut scene = setup.scene();
    scene.bodies.push(plane("floor", Placement::default()));
    scene.sheets[0].placement.position = DVec3::new(0.0, setup.height + setup.contact_offset()?, 0.0);
    let mut runner = Runner::new(setup.world(&scene)?);
    let mut watch = ContactObserver::new(&runner.world);
    let centre = |world: &World| world.sheets()[0].centre_of_mass().y;
    let lying = centre(&runner.world) - setup.height;
    let scale = contact_observer::fall_energy(&runner.world, setup.height);
    let level = contact_observer::energy(&runner.world) - scale;
    let mut flight = Flight { last_height: setup.height, ..Flight::default() };
    // Duration of the fall plus twice the rise of each rebound.
    let e = setup.restitution;
    let fall = setup.fall_time(setup.height)?;
    let duration = fall * (1.05 + 2.0 * (e + e * e + e * e * e)) + 0.3 * fall + 0.05;
    runner.run(duration.min(1e3), |world| {
        watch.observe_step(world);
        flight.see(world, centre(world) - lying, setup.gravity);
        flight.heights.len() < REBOUNDS
    });
    let kept = flight.energy_after_impact.unwrap_or_else(|| contact_observer::energy(&runner.world)) - level;
    let expected: Vec<f64> = (1..=REBOUNDS as i32).map(|n| setup.height * e.powi(2 * n)).collect();
    let own = json!({
        "height_m": setup.height,
        "restitution": e,
        "friction": setup.friction,
        "heights_m": flight.heights,
        "expected_heights_m": expected,
        "energy_ratio": kept / scale.max(f64::MIN_POSITIVE),
        "rebound_ratio": flight.met.then_some(flight.highest / setup.height),
    });
    Ok(runner.contact_outcome(&watch, scale, own))
}

impl Flight {
    fn see(&mut self, world: &World, height: f64, gravity: f64) {
        let rise = world.sheets().first().map_or(0.0, |s| s.momentum().y / s.total_mass());
        if self.last_rise > 0.0 && rise <= 0.0 {
            // Between two steps the flight is a parabola: its top is v²/2g above the last rising
            // point.
            let top = self.last_height + self.last_rise * self.last_rise / (2.0 * gravity);
            self.heights.push(top);
            self.highest = self.highest.max(top);
            self.energy_after_impact.get_or_insert(contact_observer::energy(world));
        }
        if self.met {
            self.highest = self.highest.max(height);
        }
        self.met |= contact_observer::has_touched(world);
        (self.last_height, self.last_rise) = (height, rise);
    }
}
