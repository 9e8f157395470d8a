//! Level of detail in a game: sheets that have levels follow the camera, and what time a tick may take.

use bevy::math::DVec3;
use bevy::prelude::*;

use super::{SheetClock, SheetWorld};

/// Part by which what a step costs must be another than was thought before the budget is corrected.
const CHANGE: f64 = 0.15;
/// Part of what is new in the mean of what a step takes.
const NEW: f64 = 0.05;

/// Insert it, and sheets that have levels ([`Sheet::detail_within`](super::Sheet::detail_within)) go to coarser grids where they are far from the
/// camera, and where all sheets together would take longer than the budget.
///
/// ```
/// # use bevy::prelude::*;
/// # use bevy_sheetwork::prelude::*;
/// # let mut app = App::new();
/// app.insert_resource(SheetDetail::budget(4.0)); // ms a tick
/// ```
///
/// The budget is kept by the model of [`sheetwork::world::lod_cost`], corrected by what steps take on this machine. A game that rolls back, or whose runs must be
/// the same on every machine, sets [`SheetDetail::measured`] to false: the budget is then the model's own, and nothing depends on a clock.
#[derive(Resource, Reflect, Clone, Debug, PartialEq)]
#[reflect(Resource, Clone, Debug, Default, PartialEq)]
pub struct SheetDetail {
    /// What the sheets of a tick may take, ms, 1e-3 to 1e6; none for distance alone.
    pub budget_ms: Option<f64>,
    /// Whose place is the viewpoint; the first active camera where none is given.
    pub viewer: Option<Entity>,
    /// Whether the budget is of the time that steps really take.
    pub measured: bool,
    /// What has been measured so far.
    pub times: StepTimes,
}

/// What steps have taken, over what the model says.
#[derive(Reflect, Clone, Copy, Debug, Default, PartialEq)]
#[reflect(Clone, Debug, Default, PartialEq)]
pub struct StepTimes {
    /// In the mean.
    ratio: Option<f64>,
    /// Steps that had been taken at the last look.
    seen: u64,
}

impl Default for SheetDetail {
    fn default() -> Self {
        Self { budget_ms: None, viewer: None, measured: true, times: StepTimes::default() }
    }
}

impl SheetDetail {
    /// With this budget, ms a tick.
    pub fn budget(milliseconds: impl Into<f64>) -> Self {
        Self { budget_ms: Some(milliseconds.into()), ..Self::default() }
    }

    /// Time that a step takes over what the model says: 1 until one was measured.
    pub fn ratio(&self) -> f64 {
        self.times.ratio.unwrap_or(1.0)
    }

    /// Takes up what the last tick took.
    fn measure(&mut self, world: &SheetWorld) {
        let steps = world.steps().saturating_sub(std::mem::replace(&mut self.times.seen, world.steps()));
        let taken = 1e3 * world.step_time().as_secs_f64() / steps.max(1) as f64;
        let Some(model) = world.detail_cost().filter(|c| *c > 0.0 && steps > 0 && taken > 0.0) else { return };
        let now = taken / model;
        let mean = self.times.ratio.unwrap_or(now);
        self.times.ratio = Some(mean + NEW * (now - mean));
    }
}

/// Tells the world where sheets are looked at from, and what a step may cost.
pub(super) fn follow(
    mut detail: ResMut<SheetDetail>,
    mut world: ResMut<SheetWorld>,
    clock: Res<SheetClock>,
    cameras: Query<(&GlobalTransform, &Camera)>,
    places: Query<&GlobalTransform>,
) {
    if !world.has_detail() {
        return;
    }
    let active = || cameras.iter().find(|(_, camera)| camera.is_active).map(|(there, _)| there);
    let eye = detail.viewer.and_then(|viewer| places.get(viewer).ok()).or_else(active);
    let eye: Option<DVec3> = eye.map(|there| there.translation().as_dvec3()).filter(|eye| eye.is_finite());
    if eye != world.viewpoint()
        && let Err(problem) = world.set_viewpoint(eye)
    {
        warn_once!("the camera is no viewpoint for sheets: {problem}");
    }
    let own = detail.bypass_change_detection();
    own.measure(&world);
    let ratio = if own.measured { own.ratio() } else { 1.0 };
    let steps = (clock.due() / world.dt()).max(1.0);
    let wanted = own.budget_ms.map(|ms| (ms / (steps * ratio)).clamp(1e-3, 1e6));
    let near = |a: f64, b: f64| (a / b - 1.0).abs() < CHANGE;
    let same = match (wanted, world.detail_budget()) {
        (Some(wanted), Some(now)) => near(wanted, now),
        (None, None) => true,
        _ => false,
    };
    if !same && let Err(problem) = world.set_detail_budget(wanted) {
        warn_once!("{problem}");
    }
}
