//! State of a sheet: all that evolves, apart from the histories that its elements and its
//! integrator keep. SI units.
//!
//! `serialization.rs` takes the struct apart field by field: a field that is added and not
//! serialised does not compile.

use glam::DVec3;

use crate::elements::flexion_limit::solver::LimitImpulses;
use crate::math::Vectors;
use crate::serialize::{CorruptState, ReadResult, State, StateReader, StateWriter, state};
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

state!(Counters { accepted, rejected, evaluations, guarded, contacts });

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
    /// Impulses of the flexion limit, and of the thickness limit solved with it, in the last step.
    pub(crate) flexion_impulses: LimitImpulses,
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

/// Whether and for how long a sheet rests.
#[derive(Clone, Copy)]
pub(crate) struct RestState {
    status: Status,
    interpenetration: Interpenetration,
    rest_time: f64,
}

impl SheetState {
    /// Serialise positions, velocities, counters and rest.
    pub(crate) fn serialise_motion(&self, to: &mut StateWriter) {
        serialise_status(&self.status, to);
        to.byte(self.interpenetration as u8);
        to.number(self.rest_time);
        self.counters.serialise(to);
        self.x.serialise(to);
        self.v.serialise(to);
        if self.rest_time > 0.0 {
            to.vector_list(&self.rest_positions);
        }
    }

    /// Deserialise the output of [`SheetState::serialise_motion`]. The returned rest is set at the
    /// end of the deserialisation, because changes of the sheet wake it.
    pub(crate) fn deserialise_motion(&mut self, from: &mut StateReader) -> ReadResult<RestState> {
        let (status, interpenetration) = (deserialise_status(from)?, deserialise_interpenetration(from)?);
        let rest_time = from.number()?;
        self.counters.deserialise(from)?;
        self.x.deserialise(from)?;
        self.v.deserialise(from)?;
        if rest_time > 0.0 {
            let nodes = self.x.len();
            from.vector_list(&mut self.rest_positions, nodes)?;
        }
        Ok(RestState { status, interpenetration, rest_time })
    }

    /// Set status and rest.
    pub(crate) fn set_rest(&mut self, rest: RestState) {
        (self.status, self.interpenetration, self.rest_time) = (rest.status, rest.interpenetration, rest.rest_time);
    }
}

fn serialise_status(status: &Status, to: &mut StateWriter) {
    match status {
        Status::Awake => to.byte(0),
        Status::Asleep => to.byte(1),
        Status::Unstable { time, mass, place, speed } => {
            to.byte(2);
            to.numbers(&[*time, *speed]);
            to.count(u64::from(*mass));
            to.vector(*place);
        }
        Status::Frozen { time } => {
            to.byte(3);
            to.number(*time);
        }
    }
}

fn deserialise_status(from: &mut StateReader) -> ReadResult<Status> {
    Ok(match from.byte()? {
        0 => Status::Awake,
        1 => Status::Asleep,
        2 => {
            let (time, speed, mass) = (from.number()?, from.number()?, from.count_u32()?);
            let place: DVec3 = from.vector()?;
            Status::Unstable { time, mass, place, speed }
        }
        3 => Status::Frozen { time: from.number()? },
        _ => return Err(CorruptState),
    })
}

fn deserialise_interpenetration(from: &mut StateReader) -> ReadResult<Interpenetration> {
    Ok(match from.byte()? {
        0 => Interpenetration::Unknown,
        1 => Interpenetration::None,
        2 => Interpenetration::Detected,
        3 => Interpenetration::Reported,
        _ => return Err(CorruptState),
    })
}
