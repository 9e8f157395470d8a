//! Events of the sheets of a world, with their times.

use glam::DVec3;
use serde::Serialize;

use crate::sheet::{FractureOpening, Sheet, instability, node_contact};

/// Kind of an event.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum EventKind {
    /// First contact of a sheet with a body.
    FirstContact,
    /// End of contact with a body for a tenth of a second; the time is that of the last contact.
    SlidOff,
    /// First time that a sheet lies flat on one body: it touches no other body, the number of nodes
    /// in contact is at least 95 % of those of the bottom layer, and the layer is plane to 2 % of
    /// the sheet's diagonal.
    Flat,
    /// Start of sleeping: every node was slower than 1 mm/s for half a second. Alternates with
    /// [`EventKind::Woke`].
    AtRest,
    /// End of sleeping.
    Woke,
    /// Instability; the sheet is stopped.
    Unstable,
    /// Detected instability, with the recovery action of `when_unstable`.
    Contained,
    /// The contact solver had no solution of a substep, and the barrier method that replaced it
    /// ended before it converged: motion may lag. Sent once per episode.
    GivenUp,
    /// Penetration of a body, another sheet or itself by more than a tenth of the thickness:
    /// tested where the contact solution of a step was not accepted, or in every step with
    /// [`crate::world::World::set_penetration_check`].
    Penetration,
    /// Interpenetration with another sheet, as from initial positions. Contact between the two is
    /// disabled until they are apart.
    Crossing,
    /// Return to normal stepping after a time without detected instability.
    Recovered,
    /// Buckling, snap-through or crumpling ([`crate::sheet::Buckling`]). Sent only when
    /// [`crate::world::World::set_buckling_detection`] enables it.
    Buckled,
    /// First fracture or melting of a sheet.
    Torn,
    /// Change to another grid ([`crate::world::World::remap`], or a level of detail).
    Resampled,
}

/// An event.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Event {
    /// Simulated time, s.
    pub time_s: f64,
    /// Kind of the event.
    pub kind: EventKind,
    /// Name of the sheet.
    pub sheet: String,
    /// Name of the body, where one is involved.
    pub body: Option<String>,
    /// Name of the other sheet of a penetration; the sheet's own name for one of itself.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub other: Option<String>,
    /// Depth of a penetration, m.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub depth_m: Option<f64>,
    /// Place of a local event, m.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub place_m: Option<[f64; 3]>,
    /// Released energy of a buckling event, J.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub energy_j: Option<f64>,
    /// Data of a fracture event.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub opening: Option<FractureOpening>,
    /// Numbers of nodes along length and width after a change of the grid.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub grid: Option<(u32, u32)>,
    /// Data of an instability event and its recovery action.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub alarm: Option<InstabilityReport>,
    /// Contact impulse of the step of a first contact, N s; `None` unless forces are recorded.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub impulse_n_s: Option<f64>,
    /// User data of the collider, where the body belongs to the caller's rigid world.
    #[serde(skip)]
    pub user_data: Option<u128>,
}

/// Recovery action for an unstable sheet.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum RecoveryAction {
    /// The sheet was stopped.
    Stopped,
    /// The sheet was frozen.
    Frozen,
    /// The integrator takes a step in several substeps.
    StepReduced {
        /// Number of substeps.
        parts: u32,
    },
    /// The implicit integrator takes over.
    Implicit,
    /// The strain of springs is limited.
    Limited {
        /// Strain limit.
        strain: f64,
    },
}

/// Data of the rejected step in which a sheet was detected as unstable. Infinity replaces NaN.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct InstabilityReport {
    /// Energy at the start of the step, J; `None` when an implicit integrator did not store it.
    pub energy_before_j: Option<f64>,
    /// Energy at the end of the step, J.
    pub energy_after_j: f64,
    /// Index of the fastest node.
    pub mass: u32,
    /// Speed of the fastest node, m/s.
    pub speed_m_s: f64,
    /// Position of the fastest node at the start of the step, m.
    pub place_m: [f64; 3],
    /// Largest strain of a spring, or between neighbours of a shell, at the end of the step.
    pub strain: f64,
    /// Length of the step, s.
    pub step_s: f64,
    /// Recovery action.
    pub handled: RecoveryAction,
}

impl InstabilityReport {
    /// Data of `sheet` at the end of a step of `step_s` (s) from `work.x_before`, under `gravity`
    /// (m/s²).
    pub(crate) fn new(sheet: &mut Sheet, gravity: DVec3, step_s: f64) -> Self {
        let number = |value: f64| if value.is_nan() { f64::INFINITY } else { value };
        let squared = |i: usize| number(sheet.state.v.get(i).length_squared());
        let mass = (0..sheet.node_count()).max_by(|a, b| squared(*a).total_cmp(&squared(*b))).unwrap_or(0);
        let speed_m_s = squared(mass).sqrt();
        let energy_after_j = number(sheet.energy(gravity).total);
        let strain = instability::largest_strain(sheet);
        // Implicit integrators store their initial state only with an instability policy.
        let known = node_contact::is_explicit(sheet) || sheet.recovery.is_some();
        let energy_before_j = (known && sheet.work.v_before.len() == sheet.node_count()).then(|| {
            node_contact::swap_with_step_start(sheet);
            let energy = sheet.energy(gravity).total;
            node_contact::swap_with_step_start(sheet);
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
            handled: RecoveryAction::Stopped,
        }
    }
}

impl Event {
    /// Event of `sheet` without a place.
    pub(crate) fn new(time_s: f64, kind: EventKind, sheet: &str, body: Option<String>) -> Self {
        Self {
            time_s,
            kind,
            sheet: sheet.to_owned(),
            body,
            other: None,
            depth_m: None,
            place_m: None,
            energy_j: None,
            opening: None,
            grid: None,
            alarm: None,
            impulse_n_s: None,
            user_data: None,
        }
    }
}

impl EventKind {
    /// Whether events of this kind carry an [`InstabilityReport`].
    pub(crate) fn has_alarm(self) -> bool {
        matches!(self, Self::Unstable | Self::Contained)
    }
}
