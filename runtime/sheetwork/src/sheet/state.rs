//! State of a sheet: all that evolves, apart from the histories that its elements and its integrator
//! keep. SI units.
//!
//! [`SheetState::serialise`](SheetState) and its inverse take the struct apart field by field: a
//! field that is added and not serialised does not compile.

use glam::DVec3;

use crate::math::Vectors;
use crate::sheet::bonds::AdhesionState;
use crate::sheet::buckling::BuckleDetector;
use crate::sheet::creep::InelasticState;
use crate::sheet::fracture::FractureState;
use crate::sheet::temperature::SheetTemperature;

/// Motion status of a sheet.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Status {
    /// Stepped.
    #[default]
    Awake,
    /// Asleep: not stepped until an event wakes the sheet.
    Asleep,
    /// Stopped after an instability; the rest of the scene continues.
    Unstable {
        /// Simulated time of the detection, s.
        time: f64,
        /// Node with the largest speed at that time.
        mass: u32,
        /// Position of that node before the rejected step, m.
        place: DVec3,
        /// Speed of that node, m/s; infinite for a non-finite value.
        speed: f64,
    },
    /// Frozen before an instability until a parameter of the sheet changes
    /// ([`crate::scene::WhenUnstable`]).
    Frozen {
        /// Simulated time of the detection, s.
        time: f64,
    },
}

/// Interpenetration with another sheet, as in an initial placement. Motion cannot resolve it,
/// because neighbouring triangles see opposite sides; contact between the two sheets is left out
/// until they are apart.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) enum Interpenetration {
    /// Unknown; tested before the next step.
    #[default]
    Unknown,
    /// No interpenetration.
    None,
    /// Interpenetration that has not been reported.
    Detected,
    /// Interpenetration that has been reported.
    Reported,
}

/// Counters of the steps of a sheet since its start.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Counters {
    /// Accepted integrator steps.
    pub accepted: u64,
    /// Integrator steps rejected by error control.
    pub rejected: u64,
    /// Force evaluations of the whole sheet; linear solves of an implicit integrator.
    pub evaluations: u64,
    /// Implicit stages finished by the globalised Newton method.
    pub guarded: u64,
    /// Contacts between a node and the surface of a body.
    pub contacts: u64,
}

/// State of a sheet at one time.
#[derive(Default)]
pub struct SheetState {
    /// Node positions, m.
    pub x: Vectors,
    /// Node velocities, m/s.
    pub v: Vectors,
    /// Motion status.
    pub status: Status,
    /// Counters of its steps.
    pub counters: Counters,
    /// Time below the sleep threshold, s; `rest_positions` are the positions (m) at its start.
    pub(crate) rest_time: f64,
    pub(crate) rest_positions: Vectors,
    /// Interpenetration with another sheet.
    pub(crate) interpenetration: Interpenetration,
    /// Whether the nodes or their mobility may have changed other than by a step.
    pub(crate) displaced: bool,
    /// Nodes that touched a body in the last step.
    pub(crate) touching: Vec<bool>,
    /// Adhesive bonds.
    pub(crate) adhesion: Option<Box<AdhesionState>>,
    /// Temperatures; `None` for a sheet without a thermal network.
    pub(crate) heat: Option<Box<SheetTemperature>>,
    /// State of creep and plasticity; `None` for an elastic sheet.
    pub(crate) inelastic: Option<Box<InelasticState>>,
    /// Fracture state; `None` for a sheet whose cells cannot open.
    pub(crate) fracture: Option<Box<FractureState>>,
    /// Buckling detector; `None` where buckling is not reported.
    pub(crate) buckle_detector: Option<Box<BuckleDetector>>,
}
