//! Specification of rest shape and permanent deformation of a sheet: creases, curl, plasticity,
//! creep.

use serde::{Deserialize, Serialize};

use crate::error::{InputError, reject_if};
use crate::mesh::structure::StructureKind;
use crate::scene::{Material, SheetSpec};
use crate::units::parameters::ParameterId as Id;

/// Crease: line along which the rest shape of the sheet is folded by `angle`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CreaseSpec {
    /// Start of the line, (u, v), each 0 to 1.
    pub from: (f64, f64),
    /// End of the line, (u, v).
    pub to: (f64, f64),
    /// Rest angle across the line, degrees, -175 to 175: 0 is flat; with a positive angle the sides
    /// rise towards the upper side.
    pub angle: f64,
}

/// Check creases, curl, plasticity and creep of a sheet.
///
/// # Errors
/// When a value is out of range, or requires a property that the structure or the material lacks.
pub(crate) fn check(s: &SheetSpec) -> Result<(), InputError> {
    for (i, crease) in s.creases.iter().enumerate() {
        let at = |name: &str| format!("creases.{i}.{name}");
        Id::CreaseFrom.check_each(&at("from"), [crease.from.0, crease.from.1])?;
        Id::CreaseTo.check_each(&at("to"), [crease.to.0, crease.to.1])?;
        Id::CreaseAngle.check(&at("angle"), crease.angle)?;
        reject_if!(crease.from == crease.to, at("to"), "is where the crease begins");
    }
    Id::Curl.check_each("curl", [s.curl.0, s.curl.1])?;
    let given = [("plastic", s.plastic), ("creases", !s.creases.is_empty()), ("curl", s.curl != (0.0, 0.0))];
    let is_shell = s.file.is_none() && s.structure == StructureKind::Shell;
    if let Some((field, _)) = given.into_iter().find(|g| g.1 && !is_shell) {
        let what = if s.file.is_some() { "a sheet from a file".to_owned() } else { s.structure.to_string() };
        return Err(InputError::new(field, format!("is for the shell only, not for {what}")));
    }
    s.material.check(|material| check_material(s, material))
}

/// Check that the material has the constants that the sheet requires.
///
/// # Errors
/// When it lacks one.
pub(crate) fn check_material(s: &SheetSpec, material: &Material) -> Result<(), InputError> {
    let lacks = "which the material does not have";
    reject_if!(s.plastic && material.yield_stress.is_none(), "plastic", "asks for a yield stress, {lacks}");
    reject_if!(s.creep && material.burgers.is_none(), "creep", "asks for burgers, {lacks}");
    Ok(())
}
