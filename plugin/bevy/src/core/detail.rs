//! Level of detail in a game: grids follow the distance to the camera and a time budget.

use bevy::math::DVec3;
use bevy::prelude::*;

use super::{SheetClock, SheetWorld};

/// Relative change of the budget below which the world's budget is kept, to avoid frequent
/// regridding.
const BUDGET_TOLERANCE: f64 = 0.15;
/// Weight of a new measurement in the exponential mean of step times.
const MEAN_WEIGHT: f64 = 0.05;

/// Resource that enables levels of detail.
///
/// Sheets with levels ([`Sheet::detail_within`](super::Sheet::detail_within)) use coarser grids far
/// from the camera, and when all sheets together exceed the time budget.
///
/// ```
/// # use bevy::prelude::*;
/// # use bevy_sheetwork::prelude::*;
/// # let mut app = App::new();
/// app.insert_resource(SheetDetail::budget(4.0)); // ms a tick
/// ```
///
/// The cost model is [`sheetwork::world::lod_cost`], scaled by measured step times. A game that
/// rolls back, or that needs identical runs on every machine, sets [`SheetDetail::measured`] to
/// false: the budget then depends on the model alone, not on a clock.
#[derive(Resource, Reflect, Clone, Debug, PartialEq)]
#[reflect(Resource, Clone, Debug, Default, PartialEq)]
pub struct SheetDetail {
    /// Time budget of all sheets per tick, ms, 1e-3 to 1e6; `None` for levels by distance alone.
    pub budget_ms: Option<f64>,
    /// Entity at the viewpoint; `None` for the first active camera, or without the feature `render`
    /// for the levels of the budget alone.
    pub viewer: Option<Entity>,
    /// Whether measured step times scale the cost model.
    pub measured: bool,
    /// Measured step times.
    pub times: StepTimes,
}

/// Ratio of measured to modelled step times.
#[derive(Reflect, Clone, Copy, Debug, Default, PartialEq)]
#[reflect(Clone, Debug, Default, PartialEq)]
pub struct StepTimes {
    /// Exponential mean of the ratio.
    ratio: Option<f64>,
    /// Number of world steps at the last measurement.
    seen: u64,
}

impl Default for SheetDetail {
    fn default() -> Self {
        Self { budget_ms: None, viewer: None, measured: true, times: StepTimes::default() }
    }
}

impl SheetDetail {
    /// Levels of detail with this budget, ms per tick.
    pub fn budget(milliseconds: impl Into<f64>) -> Self {
        Self { budget_ms: Some(milliseconds.into()), ..Self::default() }
    }

    /// Ratio of measured to modelled step time; 1 before the first measurement.
    pub fn ratio(&self) -> f64 {
        self.times.ratio.unwrap_or(1.0)
    }

    /// Add the step time of the last tick to the mean.
    fn measure(&mut self, world: &SheetWorld) {
        let steps = world.steps().saturating_sub(std::mem::replace(&mut self.times.seen, world.steps()));
        let taken = 1e3 * world.step_time().as_secs_f64() / steps.max(1) as f64;
        let Some(model) = world.detail_cost().filter(|c| *c > 0.0 && steps > 0 && taken > 0.0) else { return };
        let now = taken / model;
        let mean = self.times.ratio.unwrap_or(now);
        self.times.ratio = Some(mean + MEAN_WEIGHT * (now - mean));
    }
}

/// Pass the viewpoint and the cost budget of a step to the world.
pub(super) fn follow(
    mut detail: ResMut<SheetDetail>,
    mut world: ResMut<SheetWorld>,
    clock: Res<SheetClock>,
    #[cfg(feature = "render")] cameras: Query<(&GlobalTransform, &Camera)>,
    places: Query<&GlobalTransform>,
) {
    if !world.has_detail() {
        return;
    }
    let eye = detail.viewer.and_then(|viewer| places.get(viewer).ok());
    #[cfg(feature = "render")]
    let eye = eye.or_else(|| cameras.iter().find(|(_, camera)| camera.is_active).map(|(there, _)| there));
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
    let near = |a: f64, b: f64| (a / b - 1.0).abs() < BUDGET_TOLERANCE;
    let same = match (wanted, world.detail_budget()) {
        (Some(wanted), Some(now)) => near(wanted, now),
        (None, None) => true,
        _ => false,
    };
    if !same && let Err(problem) = world.set_detail_budget(wanted) {
        warn_once!("{problem}");
    }
}
