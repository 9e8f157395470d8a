//! Sheet and heater of the campaigns.

use glam::DVec3;
use sheetwork::mesh::structure::StructureKind;
use sheetwork::scene::{
    HeaterSpec, HotFaceSpec, Material, MaterialChoice, PinSpec, Placement, Region, SheetSpec, SpringLaw,
};

/// A box of 10 cm by 2 cm by 10 cm with its centre 10 cm above the origin, its faces at 300 °C with
/// an emissivity of 0.9.
pub fn hot_box() -> HeaterSpec {
    HeaterSpec {
        size: Some(DVec3::new(0.1, 0.02, 0.1)),
        hot: (0..6).map(|face| HotFaceSpec { face, temperature: 300.0, emissivity: 0.9 }).collect(),
        placement: Placement { position: DVec3::new(0.0, 0.1, 0.0), ..Placement::default() },
        ..HeaterSpec::default()
    }
}

/// A polystyrene of 0.5 mm.
pub fn polystyrene() -> MaterialChoice {
    let material = Material { young: 3e9, poisson: 0.35, density: 1050.0, thickness: 5e-4, ..Material::default() };
    MaterialChoice::Inline(material)
}

/// A square shell with `grid` nodes and `side` m along each side.
pub fn shell(grid: u32, side: f64, material: MaterialChoice) -> SheetSpec {
    SheetSpec {
        structure: StructureKind::Shell,
        springs: SpringLaw::Calibrated,
        grid: (grid, 1, grid),
        size: (side, side),
        material,
        ..SheetSpec::default()
    }
}

/// The shell of 0.25 m, clamped along one edge.
pub fn clamped_shell(grid: u32, material: MaterialChoice) -> SheetSpec {
    SheetSpec { pins: vec![PinSpec::clamped(Region::Left)], ..shell(grid, 0.25, material) }
}
