//! What the sheet of a rig lies and slides on: a plane, or another sheet that is held everywhere.
//!
//! The lines of that sheet's mesh are 1.37 times as far apart as the other's, so that masses of both cross them wherever they slide. Lengths in m.

use glam::{DVec3, IVec2};

use super::{Setup, plane};
use crate::error::InputError;
use crate::lattice::StructureKind;
use crate::scene::{PinSpec, Placement, Region, Scene, SheetSpec};

/// Spacing of the masses of a sheet that is slid on, over that of the one that slides.
const COARSER: f64 = 1.37;
/// Its size across, and along before what the other slides, over that of the other.
const LARGER: f64 = 1.5;
/// The most masses along a side.
const MOST: i32 = 1000;

/// Lays the sheet of `scene` at the distance at which it touches on what is put under it at `place`, and lets it slide there by as much as
/// `way` along x.
///
/// # Errors
/// Those of building the sheet.
pub(super) fn lay(setup: &Setup, scene: &mut Scene, place: Placement, way: f64) -> Result<(), InputError> {
    let turned = place.quaternion();
    let mut height = setup.half_thickness()?;
    if setup.on_sheet {
        let sheet = &scene.sheets[0];
        let spacing = setup.length / f64::from(sheet.grid.0 - 1);
        let size = (LARGER * sheet.size.0 + way, LARGER * sheet.size.1);
        let masses = |size: f64| 1 + (size / (COARSER * spacing)).ceil() as i32;
        let grid = IVec2::new(masses(size.0), masses(size.1)).clamp(IVec2::splat(2), IVec2::splat(MOST)).as_uvec2();
        let ground = SheetSpec {
            name: "ground".into(),
            structure: StructureKind::Shell,
            grid: (grid.x, 1, grid.y),
            size,
            material: sheet.material.clone(),
            pins: vec![PinSpec::held(Region::All)],
            placement: Placement { position: place.position + turned * DVec3::new(0.5 * way, 0.0, 0.0), ..place },
            ..SheetSpec::default()
        };
        height += 0.5 * setup.material.thickness;
        scene.sheets.push(ground);
    } else {
        scene.bodies.push(plane("ground", place));
    }
    scene.sheets[0].placement = Placement { position: place.position + turned * DVec3::Y * height, ..place };
    Ok(())
}
