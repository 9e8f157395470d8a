//! Levels of detail in a running world: each sheet with levels uses the level of its distance from
//! the viewpoint, or a coarser one where the budget of the world requires it.
//!
//! After every step the cost of each sheet is computed by the model of [`crate::world::lod_cost`],
//! and levels are planned twice: for the budget and for a part of it. A sheet finer than the budget
//! allows is coarsened at once. A sheet is refined when the cost stays below the smaller part and
//! half a second has passed since its last change. Resting sheets cost nothing and are left. All
//! inputs belong to the world, so a run is reproducible; a world without levels stores no state for
//! them.

use glam::DVec3;

use crate::error::InputError;
use crate::mesh::structure::nodes_of;
use crate::rigid::RigidView;
use crate::scene::{DetailSpec, Scene};
use crate::serialize::{CorruptState, ReadResult, State, StateReader, StateWriter, state};
use crate::sheet::{Sheet, Status, node_contact};
use crate::units::parameters::ParameterId as Id;
use crate::world::World;
use crate::world::lod_cost::{LodCandidate, LodPlanner, cost_of};
use crate::world::remap::{Grid, GridChange, grid_of};

/// Fraction of the budget that is planned for, with a margin for steps that cost more than the
/// mean; and fraction up to which sheets are refined.
const PLANNED_FRACTION: f64 = 0.88;
const REFINEMENT_FRACTION: f64 = 0.6;
/// Minimum time on a grid before refinement, s.
const MIN_TIME_ON_GRID: f64 = 0.5;
/// Time after a change within which coarsening by the budget counts as a premature refinement, and
/// the additional time before the next refinement, s. A change costs about one step, and the first
/// steps after it need more solves.
const PREMATURE_TIME: f64 = 2.0;
const PREMATURE_DELAY: f64 = 4.0;
/// Maximum number of changes in one step: to coarser grids, which are cheap, and to finer ones.
const MAX_CHANGES: (usize, usize) = (8, 1);
/// Weight of the present step in the running mean.
const MEAN_WEIGHT: f64 = 0.1;
/// Number of solves per step assumed before the first measurement.
const DEFAULT_SOLVES: f64 = 3.0;
/// Minimum distance in the measure of importance, m.
const MIN_DISTANCE: f64 = 1e-3;

/// Level-of-detail state of a world.
#[derive(Default)]
pub(crate) struct LodState {
    viewpoint: Option<DVec3>,
    /// Budget, ms per step.
    budget: Option<f64>,
    sheets: Vec<SheetLod>,
    /// Cost of the last step by the model, ns.
    last: f64,
    work: LodWorkspace,
}

/// Working arrays, reused so that later steps allocate nothing.
#[derive(Default)]
struct LodWorkspace {
    planner: LodPlanner,
    candidates: Vec<LodCandidate>,
    /// Levels for the budget, and for a part of it.
    tight: Vec<usize>,
    roomy: Vec<usize>,
    coarser: Vec<(usize, Grid)>,
    finer: Vec<(usize, Grid)>,
}

/// Level-of-detail state of a sheet.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct SheetLod {
    /// Mean number of solves, or force evaluations, per step; `None` before the first step.
    solves: Option<f64>,
    /// Number counted so far.
    counted: u64,
    /// Time on the present grid, s.
    since: f64,
    /// Time until a change that a body prevented is tried again, s.
    retry: f64,
    /// Whether a change of grid has failed, as after fracture; the sheet then keeps its grid.
    stays: bool,
}

impl LodState {
    /// State for a scene; `None` when no sheet has levels.
    pub fn of(scene: &Scene, sheets: &[Sheet]) -> Option<Box<Self>> {
        let any = scene.sheets.iter().any(|s| s.detail.is_some());
        let state = |s: &Sheet| SheetLod { counted: s.state.counters.evaluations, ..SheetLod::default() };
        any.then(|| {
            let viewpoint = scene.camera.map(|c| c.eye);
            let sheets = sheets.iter().map(state).collect();
            Box::new(Self { viewpoint, budget: scene.detail_budget, sheets, ..Self::default() })
        })
    }

    /// State for these sheets, with or without levels.
    pub fn with_sheets(scene: &Scene, sheets: &[Sheet]) -> Box<Self> {
        Self::of(scene, sheets).unwrap_or_else(|| {
            let sheets = vec![SheetLod::default(); sheets.len()];
            Box::new(Self { sheets, ..Self::default() })
        })
    }

    /// Add a sheet that has had so many evaluations.
    pub fn add(&mut self, evaluations: u64) {
        self.sheets.push(SheetLod { counted: evaluations, ..SheetLod::default() });
    }

    pub fn remove(&mut self, index: usize) {
        self.sheets.remove(index);
    }

    /// Serialise the settings for a snapshot.
    pub fn serialise_settings(&self, to: &mut StateWriter) {
        self.viewpoint.serialise(to);
        self.budget.serialise(to);
    }

    pub fn deserialise_settings(&mut self, from: &mut StateReader) -> ReadResult {
        self.viewpoint.deserialise(from)?;
        self.budget.deserialise(from)?;
        let sound = self.viewpoint.is_none_or(|v| v.is_finite()) && self.budget.is_none_or(|b| b > 0.0);
        if sound { Ok(()) } else { Err(CorruptState) }
    }
}

state!(LodState: sheets, last);
state!(SheetLod { solves, counted, since, retry, stays });

impl SheetLod {
    /// Add a step of `dt` (s) to the counters. Returns its cost, ns.
    fn record_step(&mut self, sheet: &Sheet, dt: f64) -> f64 {
        self.since += dt;
        self.retry = (self.retry - dt).max(0.0);
        let taken = sheet.state.counters.evaluations.saturating_sub(self.counted);
        self.counted = sheet.state.counters.evaluations;
        if sheet.state.status == Status::Awake && taken > 0 {
            let mean = self.solves.unwrap_or(taken as f64);
            self.solves = Some(mean + MEAN_WEIGHT * (taken as f64 - mean));
        }
        taken as f64 * cost_of(sheet.node_count(), !node_contact::is_explicit(sheet))
    }

    /// Cost of a step of `sheet` on `grid`, ns.
    fn cost(&self, sheet: &Sheet, grid: Grid) -> f64 {
        if sheet.state.status != Status::Awake {
            return 0.0;
        }
        let masses = nodes_of((grid.0, sheet.model.grid.1, grid.1)) as usize;
        self.solves.unwrap_or(DEFAULT_SOLVES) * cost_of(masses, !node_contact::is_explicit(sheet))
    }
}

/// Distance of the bounding box of `sheet` from `eye`, m; 0 without a viewpoint.
fn distance(sheet: &Sheet, eye: Option<DVec3>) -> f64 {
    let Some((eye, (low, high))) = eye.zip(sheet.state.x.bounds()) else { return 0.0 };
    eye.distance(eye.clamp(low, high))
}

/// Visual importance: size and speed over distance.
fn importance(sheet: &Sheet, distance: f64) -> f64 {
    let size = sheet.rest_size().0.max(sheet.rest_size().1);
    (size + sheet.max_speed()) / distance.max(MIN_DISTANCE)
}

/// Level of `spec` with this grid.
fn level_of(spec: &DetailSpec, grid: Grid) -> Option<usize> {
    spec.levels.iter().position(|l| l.grid == grid)
}

impl World {
    /// Viewpoint of the levels of detail, m; initially the scene's camera. `None` treats all sheets
    /// as near.
    pub fn viewpoint(&self) -> Option<DVec3> {
        self.lod.as_ref().and_then(|d| d.viewpoint)
    }

    /// Set the viewpoint (m, each coordinate within ±1e6). Without effect when no sheet has levels.
    ///
    /// # Errors
    /// When it is out of range; nothing changes then.
    pub fn set_viewpoint(&mut self, eye: Option<DVec3>) -> Result<(), InputError> {
        Id::Viewpoint.check_each("viewpoint", eye.iter().flat_map(|e| e.to_array()))?;
        if let Some(detail) = &mut self.lod {
            detail.viewpoint = eye;
        }
        Ok(())
    }

    /// Maximum cost of a step by the model of [`crate::world::lod_cost`], ms; `None` when only the
    /// distance counts.
    pub fn detail_budget(&self) -> Option<f64> {
        self.lod.as_ref().and_then(|d| d.budget)
    }

    /// Set the budget, 1e-3 to 1e6 ms. Without effect when no sheet has levels.
    ///
    /// # Errors
    /// When it is out of range; nothing changes then.
    pub fn set_detail_budget(&mut self, budget: Option<f64>) -> Result<(), InputError> {
        Id::DetailBudget.check_option("detail_budget", budget)?;
        if let Some(detail) = &mut self.lod {
            detail.budget = budget;
        }
        Ok(())
    }

    /// Cost of the last step of all sheets by the model, ms; `None` when no sheet has levels.
    pub fn detail_cost(&self) -> Option<f64> {
        self.lod.as_ref().map(|d| d.last * 1e-6)
    }

    /// Whether a sheet has levels.
    pub fn has_detail(&self) -> bool {
        self.lod.is_some()
    }

    /// Update the cost after a step of `dt` (s), and change grids, apart from the bodies of `lent`,
    /// the caller's rigid world, or of the world.
    pub(crate) fn update_lod(&mut self, dt: f64, lent: Option<&RigidView>) {
        let Some(mut detail) = self.lod.take() else { return };
        let LodState { sheets, last, .. } = &mut *detail;
        *last = sheets.iter_mut().zip(&self.sheets).map(|(state, sheet)| state.record_step(sheet, dt)).sum();
        let mut work = std::mem::take(&mut detail.work);
        self.plan_levels(&detail, &mut work);
        self.find_changes(&detail, &mut work);
        for (k, (index, grid)) in work.coarser.iter().chain(&work.finer).enumerate() {
            let state = &mut detail.sheets[*index];
            let change = self.remap_index(*index, *grid, lent);
            state.stays = change.is_err();
            if change == Ok(GridChange::Deferred) {
                state.retry = MIN_TIME_ON_GRID;
                continue;
            }
            let too_early = k < work.coarser.len() && detail.budget.is_some() && state.since < PREMATURE_TIME;
            state.since = if too_early { -PREMATURE_DELAY } else { 0.0 };
        }
        detail.work = work;
        self.lod = Some(detail);
    }

    /// Sheets that follow their levels, by index, with the levels.
    fn following<'a>(&'a self, detail: &'a LodState) -> impl Iterator<Item = (usize, &'a DetailSpec)> {
        let levels = |i: usize| self.scene.sheets[i].detail.as_ref().filter(|_| !detail.sheets[i].stays);
        (0..self.sheets.len()).filter_map(move |i| Some((i, levels(i)?)))
    }

    /// Plan a level for each of these sheets, for the budget and for its part for refinement.
    fn plan_levels(&self, detail: &LodState, work: &mut LodWorkspace) {
        let LodWorkspace { planner, candidates, tight, roomy, .. } = work;
        let count = self.following(detail).count();
        candidates.resize_with(count, LodCandidate::default);
        let mut others: f64 =
            detail.sheets.iter().zip(&self.sheets).map(|(state, sheet)| state.cost(sheet, grid_of(sheet))).sum();
        for ((i, spec), candidate) in self.following(detail).zip(candidates.iter_mut()) {
            let (sheet, state) = (&self.sheets[i], &detail.sheets[i]);
            let far = distance(sheet, detail.viewpoint);
            candidate.wanted = spec.wanted(far, level_of(spec, grid_of(sheet)));
            candidate.importance = importance(sheet, far);
            candidate.costs.clear();
            candidate.costs.extend(spec.levels.iter().map(|l| state.cost(sheet, l.grid)));
            others -= state.cost(sheet, grid_of(sheet));
        }
        let budget = detail.budget.map_or(f64::INFINITY, |ms| ms * 1e6);
        planner.plan(candidates, others, PLANNED_FRACTION * budget, tight);
        planner.plan(candidates, others, REFINEMENT_FRACTION * budget, roomy);
    }

    /// Select the sheets that change their grid in this step.
    fn find_changes(&self, detail: &LodState, work: &mut LodWorkspace) {
        let LodWorkspace { tight, roomy, coarser, finer, .. } = work;
        coarser.clear();
        finer.clear();
        for (((i, spec), tight), roomy) in self.following(detail).zip(tight.iter()).zip(roomy.iter()) {
            let level = level_of(spec, grid_of(&self.sheets[i]));
            if detail.sheets[i].retry > 0.0 {
                continue;
            }
            if level.is_none_or(|level| level < *tight) {
                coarser.push((i, spec.levels[*tight].grid));
            } else if level.is_some_and(|level| level > *roomy) && detail.sheets[i].since >= MIN_TIME_ON_GRID {
                finer.push((i, spec.levels[*roomy].grid));
            }
        }
        coarser.truncate(MAX_CHANGES.0);
        finer.truncate(MAX_CHANGES.1);
    }
}
