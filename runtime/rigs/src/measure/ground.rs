//! Ground below the sheet of a rig: a plane, or another sheet with all nodes fixed.
//!
//! The node spacing of the ground sheet is 1.37 times that of the sliding sheet, so that nodes of
//! both cross mesh lines wherever they slide. Lengths in m.

use glam::{DVec3, IVec2};

use crate::measure::{Setup, plane};
use sheetwork::InputError;
use sheetwork::mesh::structure::StructureKind;
use sheetwork::scene::{PinSpec, Placement, Region, Scene, SheetSpec};

/// Node spacing of the ground sheet over that of the sliding sheet.
const SPACING_RATIO: f64 = 1.37;
/// Width of the ground sheet, and its length without the sliding distance, over that of the sliding
/// sheet.
const SIZE_RATIO: f64 = 1.5;
/// Maximum number of nodes along a side.
const MAXIMUM_NODES_PER_SIDE: i32 = 1000;

/// Adds the ground at `place` and places the scene's sheet on it in contact. The ground is long
/// enough for a slide of `way` (m) along x.
///
/// # Errors
/// Those of the construction of the sheet.
pub(crate) fn place_on_ground(setup: &Setup, scene: &mut Scene, place: Placement, way: f64) -> Result<(), InputError> {
    let turned = place.quaternion();
    let mut height = setup.contact_offset()?;
    if setup.on_sheet {
        let sheet = &scene.sheets[0];
        let spacing = setup.length / f64::from(sheet.grid.0 - 1);
        let size = (SIZE_RATIO * sheet.size.0 + way, SIZE_RATIO * sheet.size.1);
        let masses = |size: f64| 1 + (size / (SPACING_RATIO * spacing)).ceil() as i32;
        let grid = IVec2::new(masses(size.0), masses(size.1))
            .clamp(IVec2::splat(2), IVec2::splat(MAXIMUM_NODES_PER_SIDE))
            .as_uvec2();
        let ground = SheetSpec {
            name: "ground".into(),
            structure: StructureKind::Shell,
            grid: (grid.x, 1, grid.y),
            size,
            material: sheet.material.clone(),
            pins: vec![PinSpec::fixed(Region::All)],
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
