//! What happened to the sheets of a world, and when.

use rapier3d::prelude::{ColliderHandle, RigidBodyHandle};
use serde::Serialize;

use crate::contact::detect::Touch;
use crate::contact::rigid::RigidView;

/// Kinds of events.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum EventKind {
    /// A sheet touched a body for the first time.
    FirstContact,
    /// A sheet that had touched a body has not done so for a tenth of a second; the time is that of the last touch.
    SlidOff,
    /// At least 95 % of the masses of a sheet's bottom (or top) layer touched one body in one step, for the first time.
    Flat,
    /// Every mass was slower than a millimetre a second for half a second; the sheet sleeps.
    AtRest,
    /// A sleeping sheet was woken.
    Woke,
    /// A sheet went unstable and was stopped.
    Unstable,
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
}

/// How long a sheet must be away from a body to count as off it, s.
const OFF_AFTER: f64 = 0.1;

/// Share of a layer's masses that must touch for the sheet to lie flat.
const FLAT_SHARE: f64 = 0.95;

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

impl Touches {
    /// Forgets this step's counts before a step begins.
    pub fn begin(&mut self) {
        self.list.iter_mut().for_each(|t| t.masses = 0);
    }

    /// Bodies touched in this step.
    pub fn count(&self) -> usize {
        self.list.iter().filter(|t| t.masses > 0).count()
    }

    /// Turns this step's counts into events; `layer` is the number of masses of the bottom layer.
    pub fn end(&mut self, time: f64, layer: usize) {
        for t in &mut self.list {
            if t.masses > 0 {
                if !t.known {
                    t.known = true;
                    self.events.push((time, EventKind::FirstContact, Some(t.collider)));
                }
                t.last = time;
                t.off = false;
                if !t.flat && f64::from(t.masses) >= FLAT_SHARE * layer as f64 {
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
