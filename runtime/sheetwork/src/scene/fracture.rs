//! Checks of fracture in a scene.

use crate::error::{InputError, reject_if};
use crate::scene::{Material, SheetSpec};
use crate::units::parameters::ParameterId as Id;

/// Check the fracture settings of a sheet.
///
/// # Errors
/// When the sheet comes from a file, an end of a slit is out of range, or the material has no
/// limit.
pub(crate) fn check(s: &SheetSpec) -> Result<(), InputError> {
    if !s.tearing && s.slits.is_empty() {
        return Ok(());
    }
    for (i, ((u0, v0), (u1, v1))) in s.slits.iter().enumerate() {
        Id::SlitEnd.check_each(&format!("slits.{i}.0"), [*u0, *v0])?;
        Id::SlitEnd.check_each(&format!("slits.{i}.1"), [*u1, *v1])?;
        reject_if!((u0, v0) == (u1, v1), format!("slits.{i}"), "has no length: its ends are the same point");
    }
    let field = if s.tearing { "tearing" } else { "slits" };
    reject_if!(s.file.is_some(), field, "does not go with a sheet from a file, whose masses may lie anywhere at rest");
    if s.tearing { s.material.check(check_material) } else { Ok(()) }
}

/// Check that the material has a fracture strain or a melting temperature.
///
/// # Errors
/// When it has none.
pub(crate) fn check_material(material: &Material) -> Result<(), InputError> {
    let has_no_limit = material.tears_at.is_none() && material.melts_at.is_none();
    reject_if!(has_no_limit, "tearing", "asks for tears_at or melts_at, which the material does not have");
    Ok(())
}
