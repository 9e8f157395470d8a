//! Checks of adhesion in a scene.

use crate::error::{InputError, check_range, reject_if};
use crate::scene::{Adhesion, Material, SheetSpec};
use crate::units::parameters::ParameterId as Id;
use crate::units::temperature::COLDEST;

/// Check the adhesion settings of a sheet.
///
/// # Errors
/// When its material has no adhesion constants.
pub(crate) fn check(s: &SheetSpec) -> Result<(), InputError> {
    if s.sticky { s.material.check(check_material) } else { Ok(()) }
}

/// Check the adhesion constants of a material; fields are below its `tack`.
///
/// # Errors
/// When a value is out of range.
pub(crate) fn check_tack(tack: &Adhesion) -> Result<(), InputError> {
    Id::TackStrength.check("strength", tack.strength)?;
    Id::TackAbove.check("above", tack.above)?;
    tack.lets_go_below.map_or(Ok(()), |limit| check_range("lets_go_below", limit, COLDEST, tack.above, "°C"))
}

/// Check that the material has adhesion constants.
///
/// # Errors
/// When it has none.
pub(crate) fn check_material(material: &Material) -> Result<(), InputError> {
    reject_if!(material.tack.is_none(), "sticky", "asks for tack, which the material does not have");
    Ok(())
}
