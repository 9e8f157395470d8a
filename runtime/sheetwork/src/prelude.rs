//! The types that a program with sheets names.

pub use crate::mesh::outline::{HoleSpec, OutlineSpec};
pub use crate::scene::{
    Air, BodySpec, ContactDefaults, IntegratorKind, Material, MaterialChoice, PathKey, PinSpec, Placement, Region,
    Scene, Shape, SheetSpec, SpringLaw,
};
pub use crate::{
    BodyId, BodyState, BuildError, Energy, Event, EventKind, HeaterId, InputError, JointId, Parameter, ParameterError,
    ParameterId, RigidView, SceneError, Sheet, SheetId, Snapshot, SnapshotError, Status, StepOutcome, StepReport,
    StructureKind, Vectors, World,
};
