//! Surface of a sheet that meets kinematic and static bodies, and its checks in a scene.

use serde::{Deserialize, Serialize};

use crate::error::{InputError, reject_if};
use crate::scene::{IntegratorKind, SheetSpec};

/// Surface of a sheet that meets kinematic and static bodies (explicit integrators).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum ContactSurface {
    /// The nodes alone.
    #[default]
    Masses,
    /// The nodes, and the drawn surface through them.
    Smooth,
    /// The nodes, and the drawn B-spline surface that has them as control points.
    BSpline,
}

/// Check the contact surface of a sheet.
///
/// # Errors
/// When the sheet has features that its drawn surface does not follow.
pub(crate) fn check(s: &SheetSpec) -> Result<(), InputError> {
    if s.contact_surface == ContactSurface::Masses {
        return Ok(());
    }
    let is_outlined = s.outline.is_some() || !s.holes.is_empty() || !s.cuts.is_empty();
    reject_if!(is_outlined, "contact_surface", "is for rectangles: it does not go with outline, holes or cuts");
    let opens = s.tearing || !s.slits.is_empty();
    reject_if!(opens, "contact_surface", "does not go with tearing or slits: an opened sheet is drawn flat");
    let is_limited = s.flexion_limit.is_some();
    reject_if!(is_limited, "contact_surface", "does not go with flexion_limit, which is solved with the nodes");
    Ok(())
}

/// Check that the integrator supports the contact surface.
///
/// # Errors
/// When it is implicit.
pub(crate) fn check_integrator(surface: ContactSurface, engine: IntegratorKind) -> Result<(), InputError> {
    let is_refused = surface != ContactSurface::Masses && engine.info().implicit;
    let problem = format!("is for explicit engines (euler-richardson, rk4, ...), not for {}", engine.name());
    let reason = "contact of implicit engines is that of the flat triangles between the nodes";
    reject_if!(is_refused, "contact_surface", "{problem}: {reason}");
    Ok(())
}

/// Check the contact surface of a built sheet.
///
/// # Errors
/// As [`check_integrator`], and when it is the B-spline surface of a tube.
pub(crate) fn check_built(surface: ContactSurface, engine: IntegratorKind, is_tube: bool) -> Result<(), InputError> {
    let is_refused = is_tube && surface == ContactSurface::BSpline;
    let problem = "BSpline is not for tubes, which are drawn through their nodes; use Smooth";
    reject_if!(is_refused, "contact_surface", "{problem}");
    check_integrator(surface, engine)
}
