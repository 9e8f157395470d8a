//! What happened to the sheets of a world, and when.

use glam::DVec3;
use rapier3d::prelude::{ColliderHandle, RigidBodyHandle};
use serde::Serialize;

use crate::contact::node::detection::Touch;
use crate::rigid::RigidView;
use crate::serialize::{Keeper, Taken, Taker};
use crate::sheet::{Opening, Sheet};

/// Kinds of events.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum EventKind {
    /// A sheet touched a body for the first time.
    FirstContact,
    /// A sheet that had touched a body has not done so for a tenth of a second; the time is that of the last touch.
    SlidOff,
    /// A sheet lay flat on one body for the first time: it had left every other, at least as many masses touched it in one step
    /// as 95 % of the bottom layer has, and that layer was plane to 2 % of the sheet's diagonal.
    Flat,
    /// Every mass was slower than a millimetre a second for half a second; the sheet sleeps.
    AtRest,
    /// A sleeping sheet was woken.
    Woke,
    /// A sheet went unstable and was stopped.
    Unstable,
    /// A sheet was about to go unstable and was dealt with as its `when_unstable` says.
    Contained,
    /// Contact was given up in a part of a step, and not in the step before: for that part it went on as one stiff body with the free bodies that
    /// it would have gone into, or stayed where it was.
    GivenUp,
    /// It was found to go through another sheet, as where it was put there: contact between the two is left out until they are apart.
    Crossing,
    /// It has been well for long enough to be stepped as before.
    Recovered,
    /// A sheet gave way: it buckled, snapped through or crumpled ([`crate::sheet::Buckle`]). Told of only where
    /// [`crate::world::World::watch_buckling`] asks for it.
    Buckled,
    /// A sheet opened for the first time: it tore or melted.
    Torn,
    /// A sheet went to another grid ([`crate::world::World::resample`], or a level of detail).
    Resampled,
}

/// Something that happened.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Event {
    /// Simulated time, s.
    pub time_s: f64,
    /// What.
    pub kind: EventKind,
    /// To which sheet.
    pub sheet: String,
    /// With which body, where there is one.
    pub body: Option<String>,
    /// Where, m, for what happens at one place of the sheet.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub place_m: Option<[f64; 3]>,
    /// Energy that was set free, J, where some was.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub energy_j: Option<f64>,
    /// Of what it opened, when it did.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub opening: Option<Opening>,
    /// Masses along its length and width, where it went to another grid.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub grid: Option<(u32, u32)>,
    /// What showed that it was unstable, and what was done about it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub alarm: Option<Alarm>,
}

/// What was done about a sheet that was about to go unstable.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Handled {
    /// It was stopped.
    Stopped,
    /// It was frozen.
    Frozen,
    /// Its engine takes a step in parts.
    StepReduced {
        /// In how many.
        parts: u32,
    },
    /// The implicit engine takes over.
    Implicit,
    /// Its springs are held to a limit.
    Limited {
        /// Strain they are held to.
        strain: f64,
    },
}

/// The numbers that showed that a sheet is unstable, of the step that was thrown away. What is not a number is infinite.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Alarm {
    /// Energy at the start of the step, J; none where an implicit engine did not keep it.
    pub energy_before_j: Option<f64>,
    /// Energy at its end, J.
    pub energy_after_j: f64,
    /// Mass that was fastest.
    pub mass: u32,
    /// Its speed, m/s.
    pub speed_m_s: f64,
    /// Where it was at the start of the step, m.
    pub place_m: [f64; 3],
    /// Largest strain of a spring, or between neighbours of a shell, at the end of the step.
    pub strain: f64,
    /// Length of the step, s.
    pub step_s: f64,
    /// What was done.
    pub handled: Handled,
}

impl Alarm {
    /// Of `sheet` at the end of a step of `step_s` (s) from where it was in `work.x_before`, under `gravity` (m/s²).
    pub(crate) fn of(sheet: &mut Sheet, gravity: DVec3, step_s: f64) -> Self {
        let number = |value: f64| if value.is_nan() { f64::INFINITY } else { value };
        let squared = |i: usize| number(sheet.v.get(i).length_squared());
        let mass = (0..sheet.masses()).max_by(|a, b| squared(*a).total_cmp(&squared(*b))).unwrap_or(0);
        let speed_m_s = squared(mass).sqrt();
        let energy_after_j = number(sheet.energy(gravity).total);
        let strain = sheet.largest_strain();
        // What implicit engines begin with is kept where somebody asks for it.
        let known = sheet.is_explicit() || sheet.guard.is_some();
        let energy_before_j = (known && sheet.work.v_before.len() == sheet.masses()).then(|| {
            sheet.swap_before();
            let energy = sheet.energy(gravity).total;
            sheet.swap_before();
            number(energy)
        });
        let place_m = sheet.work.x_before.get(mass).to_array();
        Self {
            energy_before_j,
            energy_after_j,
            mass: mass as u32,
            speed_m_s,
            place_m,
            strain,
            step_s,
            handled: Handled::Stopped,
        }
    }
}

impl Event {
    /// What happened to `sheet`, at no place that is known.
    pub(crate) fn new(time_s: f64, kind: EventKind, sheet: &str, body: Option<String>) -> Self {
        let sheet = sheet.to_owned();
        Self { time_s, kind, sheet, body, place_m: None, energy_j: None, opening: None, grid: None, alarm: None }
    }
}

/// How long a sheet must be away from a body to count as off it, s.
const OFF_AFTER: f64 = 0.1;

/// Share of a layer's masses that must touch for the sheet to lie flat.
const FLAT_SHARE: f64 = 0.95;

/// Deviation from a plane below which a sheet is flat, as a fraction of its diagonal.
const FLATNESS: f64 = 0.02;

/// Whether the bottom layer is plane: every mass near the plane through three of its corners.
fn is_flat(sheet: &Sheet) -> bool {
    let Some(layer) = sheet.layers.first() else { return false };
    let (i, j) = (layer.nx.saturating_sub(1), layer.nz.saturating_sub(1));
    let corners = match &sheet.triangles {
        Some(list) => list.first().copied().unwrap_or_default(),
        None => [layer.at(0, 0), layer.at(i, 0), layer.at(0, j)],
    };
    let [origin, a, b] = corners.map(|m| sheet.x.get(m as usize));
    let normal = (a - origin).cross(b - origin).normalize_or_zero();
    let bound = FLATNESS * sheet.spread;
    layer.range().all(|m| (sheet.x.get(m) - origin).dot(normal).abs() < bound)
}

/// A body that a sheet has touched, with the masses that did so in this step.
#[derive(Clone, Debug)]
struct Touched {
    collider: ColliderHandle,
    body: Option<RigidBodyHandle>,
    masses: u32,
    last: f64,
    off: bool,
    flat: bool,
    known: bool,
}

/// Which bodies a sheet has touched: one of these a sheet, updated every step.
#[derive(Clone, Debug, Default)]
pub(crate) struct Touches {
    list: Vec<Touched>,
    /// Filled in during the step; drained by the world.
    pub events: Vec<(f64, EventKind, Option<ColliderHandle>)>,
    /// Of those events that have one, in their order.
    pub alarms: Vec<Alarm>,
}

/// Adds contacts to a sheet's record, knowing which collider belongs to which body.
pub(crate) struct Recorder<'a> {
    pub touches: &'a mut Touches,
    pub view: &'a RigidView<'a>,
}

impl Touch for Recorder<'_> {
    fn touched(&mut self, collider: ColliderHandle, _mass: usize) {
        let body = self.view.colliders.get(collider).and_then(|c| c.parent());
        let list = &mut self.touches.list;
        let same = |t: &Touched| t.collider == collider || (body.is_some() && t.body == body);
        let index = list.iter().position(same).unwrap_or_else(|| {
            let new = Touched { collider, body, masses: 0, last: 0.0, off: false, flat: false, known: false };
            list.push(new);
            list.len() - 1
        });
        list[index].masses += 1;
    }
}

impl EventKind {
    /// Whether it comes with an [`Alarm`].
    pub(crate) fn has_alarm(self) -> bool {
        matches!(self, Self::Unstable | Self::Contained)
    }
}

impl Touches {
    /// Tells of an alarm.
    pub fn tell(&mut self, time: f64, kind: EventKind, alarm: Alarm) {
        self.events.push((time, kind, None));
        self.alarms.push(alarm);
    }

    /// Forgets the last step's counts before a step that begins at `time` (s). What touched then has touched until now, however long the sheet
    /// has slept in between.
    pub fn begin(&mut self, time: f64) {
        for t in &mut self.list {
            if std::mem::take(&mut t.masses) > 0 {
                t.last = t.last.max(time);
            }
        }
    }

    /// Bodies touched in this step.
    pub fn count(&self) -> usize {
        self.list.iter().filter(|t| t.masses > 0).count()
    }

    /// Keeps it for a snapshot, after a step.
    pub fn keep(&self, to: &mut Keeper) {
        to.count(self.list.len() as u64);
        for t in &self.list {
            let (collider, body) = (t.collider.into_raw_parts(), t.body.map(RigidBodyHandle::into_raw_parts));
            to.flag(body.is_some());
            for v in [collider.0, collider.1].into_iter().chain(body.into_iter().flat_map(|b| [b.0, b.1])) {
                to.count(u64::from(v));
            }
            to.count(u64::from(t.masses));
            to.number(t.last);
            [t.off, t.flat, t.known].into_iter().for_each(|f| to.flag(f));
        }
    }

    /// Takes it back.
    pub fn take(&mut self, from: &mut Taker) -> Taken {
        self.events.clear();
        self.alarms.clear();
        self.list.clear();
        for _ in 0..from.length(14)? {
            let has_body = from.flag()?;
            let collider = ColliderHandle::from_raw_parts(from.small()?, from.small()?);
            let body =
                if has_body { Some(RigidBodyHandle::from_raw_parts(from.small()?, from.small()?)) } else { None };
            let (masses, last) = (from.small()?, from.number()?);
            let (off, flat, known) = (from.flag()?, from.flag()?, from.flag()?);
            self.list.push(Touched { collider, body, masses, last, off, flat, known });
        }
        Ok(())
    }

    /// Turns this step's counts into events.
    pub fn end(&mut self, time: f64, sheet: &Sheet) {
        let layer = sheet.layers.first().map_or(0, |l| l.len());
        let here = |t: &Touched| t.known && time - t.last <= OFF_AFTER;
        let alone = self.list.iter().filter(|t| here(t) || t.masses > 0).count() == 1;
        for t in &mut self.list {
            if t.masses > 0 {
                if !t.known {
                    t.known = true;
                    self.events.push((time, EventKind::FirstContact, Some(t.collider)));
                }
                t.last = time;
                t.off = false;
                if !t.flat && alone && f64::from(t.masses) >= FLAT_SHARE * f64::from(layer) && is_flat(sheet) {
                    t.flat = true;
                    self.events.push((time, EventKind::Flat, Some(t.collider)));
                }
            } else if !t.off && time - t.last > OFF_AFTER {
                t.off = true;
                self.events.push((t.last, EventKind::SlidOff, Some(t.collider)));
            }
        }
    }
}
