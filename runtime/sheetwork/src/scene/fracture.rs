//! Checks of fracture in a scene.

use crate::error::InputError;
use crate::scene::{Material, SheetSpec};
use crate::units::parameters::ParameterId as Id;

/// Check the fracture settings of a sheet.
///
/// # Errors
/// When the sheet has no square cells that could open, or the material no limit.
pub(crate) fn check(s: &SheetSpec) -> Result<(), InputError> {
    if !s.tearing && s.slits.is_empty() {
        return Ok(());
    }
    for (i, ((u0, v0), (u1, v1))) in s.slits.iter().enumerate() {
        Id::SlitEnd.check_each(&format!("slits.{i}.0"), [*u0, *v0])?;
        Id::SlitEnd.check_each(&format!("slits.{i}.1"), [*u1, *v1])?;
    }
    let field = if s.tearing { "tearing" } else { "slits" };
    let refused = |problem: String| Err(InputError::new(field, problem));
    let outlined = [("outline", s.outline.is_some()), ("holes", !s.holes.is_empty()), ("cuts", !s.cuts.is_empty())];
    if let Some((field, _)) = outlined.into_iter().find(|g| g.1) {
        return refused(format!("is for rectangles: it does not go with {field}"));
    }
    if s.file.is_some() {
        return refused("does not go with a sheet from a file, whose masses may lie anywhere at rest".to_owned());
    }
    if s.structure.info().triangular {
        return refused(format!("is for structures of square cells, not for {}", s.structure));
    }
    if s.tearing { s.material.check(check_material) } else { Ok(()) }
}

/// Check that the material has a fracture strain or a melting temperature.
///
/// # Errors
/// When it has none.
pub(crate) fn check_material(material: &Material) -> Result<(), InputError> {
    if material.tears_at.is_none() && material.melts_at.is_none() {
        return Err(InputError::new("tearing", "asks for tears_at or melts_at, which the material does not have"));
    }
    Ok(())
}
