//! Which sheets may open, in a scene.

use super::{Material, MaterialChoice, SheetSpec, material};
use crate::error::InputError;

/// Checks what a sheet says of it.
///
/// # Errors
/// When the sheet has no square cells that could open, or the material no limit.
pub(super) fn check(s: &SheetSpec) -> Result<(), InputError> {
    if !s.tearing {
        return Ok(());
    }
    let refused = |problem: String| Err(InputError::new("tearing", problem));
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
    match &s.material {
        MaterialChoice::Named(name) => of_material(&material::by_name(name)?),
        MaterialChoice::Inline(constants) => of_material(constants),
        MaterialChoice::File(_) => Ok(()),
    }
}

/// Checks that the material has a limit.
///
/// # Errors
/// When it has none.
pub fn of_material(material: &Material) -> Result<(), InputError> {
    if material.tears_at.is_none() && material.melts_at.is_none() {
        return Err(InputError::new("tearing", "asks for tears_at or melts_at, which the material does not have"));
    }
    Ok(())
}
