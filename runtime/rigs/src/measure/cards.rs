//! Playing cards: a dropped pack that must come to rest without overlap, and a house of cards that
//! must stand until a ball hits it. The scenes are those of `card_scenes`; integrator, step and
//! threads come from the set-up.

use std::time::Instant;

use serde_json::{Map, Value, json};

use crate::card_scenes::{CardScene, DROP, LENGTH, THICKNESS, WIDTH};
use crate::measure::contact_observer::{self, ContactObserver};
use crate::measure::{RigOutcome, RigResult, Runner, Setup, object};
use sheetwork::collision::overlap::between;
use sheetwork::scene::Scene;
use sheetwork::{InputError, World};

/// Time limit for the pack to come to rest, s.
const REST_TIMEOUT: f64 = 6.0;
/// Time for which the house must stand, and time for its collapse, s.
const STANDING: f64 = 10.0;
const FALLING: f64 = 3.0;
/// Steps between two overlap evaluations during the collapse. A card that has passed through
/// another remains detectable.
const OVERLAP_CHECK_INTERVAL: u32 = 5;

/// Wall-clock time of steps, the time that threads reduce.
#[derive(Default)]
struct StepDurations {
    total: f64,
    worst: f64,
    count: u32,
}

impl StepDurations {
    /// Takes one step.
    fn step(&mut self, runner: &mut Runner) {
        let start = Instant::now();
        runner.run(runner.world.dt(), |_| true);
        let taken = start.elapsed().as_secs_f64();
        (self.total, self.worst, self.count) = (self.total + taken, self.worst.max(taken), self.count + 1);
    }

    fn keys(&self) -> Map<String, Value> {
        object(json!({
            "wall_ms_per_step": 1e3 * self.total / f64::from(self.count.max(1)),
            "worst_wall_step_ms": 1e3 * self.worst,
        }))
    }
}

/// JSON keys of the card's size, in place of those of the rig's flags.
fn size(world: &World) -> Map<String, Value> {
    let grid = world.scene().sheets.first().map(|sheet| format!("{}x{}", sheet.grid.0, sheet.grid.2));
    object(json!({ "grid": grid, "length_m": LENGTH, "width_m": WIDTH }))
}

fn world(setup: &Setup, cards: CardScene) -> Result<World, InputError> {
    let mut scene = Scene::parse(&cards.text())?;
    scene.engine = setup.engine;
    scene.dt = setup.dt.unwrap_or(scene.dt);
    let mut world = World::new(&scene)?;
    world.set_threads(setup.threads as usize)?;
    Ok(world)
}

/// Steps and observes the cards while they are stable and `goes_on`, given the time (s), holds.
fn watched(runner: &mut Runner, goes_on: impl Fn(&ContactObserver, f64) -> bool) -> (ContactObserver, StepDurations) {
    let (mut watch, mut frames) = (ContactObserver::new(&runner.world), StepDurations::default());
    // An overlap evaluation of 52 cards costs more than a step.
    watch.every = 30;
    while goes_on(&watch, runner.world.time()) && runner.world.unstable().is_none() {
        frames.step(runner);
        watch.observe_step(&runner.world);
    }
    (watch, frames)
}

pub(crate) fn pack(setup: &Setup) -> RigResult {
    let mut runner = Runner::new(world(setup, CardScene::Pack)?);
    let start = contact_observer::centres(&runner.world);
    let (watch, frames) = watched(&mut runner, |watch, time| time < REST_TIMEOUT && !watch.asleep());
    let overlap = between(runner.world.sheets());
    let mut keys = watch.keys(&runner.world, contact_observer::fall_energy(&runner.world, DROP));
    keys.extend(frames.keys());
    keys.extend(object(json!({
        "cards": runner.world.sheets().len(),
        "threads": setup.threads,
        "overlap_at_rest_m": overlap,
        "overlap_ratio": overlap / THICKNESS,
        "drift_m": contact_observer::drift(&runner.world, &start),
        "in_order": contact_observer::is_in_order(&runner.world),
    })));
    keys.extend(size(&runner.world));
    let settled = Some(watch.still_since().is_some());
    Ok(RigOutcome { settled, ..runner.outcome(Value::Object(keys)) })
}

pub(crate) fn house(setup: &Setup) -> RigResult {
    let mut runner = Runner::new(world(setup, CardScene::House)?);
    let start = top(&runner.world);
    let (watch, frames) = watched(&mut runner, |_, time| time < STANDING);
    let stood = top(&runner.world);
    let stands = runner.world.unstable().is_none() && stood > 0.98 * start;
    let (overlap, asleep) = (between(runner.world.sheets()), watch.asleep());
    let mut keys = watch.keys(&runner.world, contact_observer::fall_energy(&runner.world, start));
    keys.extend(frames.keys());
    let thrown = Scene::parse(&CardScene::HouseAndBall.text())?;
    for mut ball in thrown.bodies {
        ball.velocity *= setup.throw;
        runner.world.add_body(&ball)?;
    }
    let (mut falling, mut deepest) = (StepDurations::default(), 0.0_f64);
    while runner.world.time() < STANDING + FALLING && runner.world.unstable().is_none() {
        falling.step(&mut runner);
        if falling.count.is_multiple_of(OVERLAP_CHECK_INTERVAL) {
            deepest = deepest.max(between(runner.world.sheets()));
        }
    }
    let left = top(&runner.world);
    keys.extend(object(json!({
        "cards": runner.world.sheets().len(),
        "threads": setup.threads,
        "top_m": start,
        "top_after_10_s_m": stood,
        "stands": stands,
        "asleep_after_10_s": asleep,
        "overlap_after_10_s_m": overlap,
        "throw": setup.throw,
        "top_after_ball_m": left,
        "max_overlap_falling_m": deepest,
        "falls_to_the_ball": stands.then_some(left < 0.7 * start),
        "wall_ms_per_step_falling": falling.keys()["wall_ms_per_step"],
        "worst_wall_step_falling_ms": falling.keys()["worst_wall_step_ms"],
    })));
    keys.extend(size(&runner.world));
    Ok(runner.outcome(Value::Object(keys)))
}

/// Height of the highest node, m.
fn top(world: &World) -> f64 {
    world.sheets().iter().flat_map(|s| s.state.x.y.iter().copied()).fold(0.0, f64::max)
}
