//! Report of a material in a given sheet and of the stiffness that its structure delivers, computed
//! without a step.
//!
//! - Plate stiffness D = E t³/(12 (1-ν²)), plate modulus E' = E/(1-ν²), mass per area ρ t.
//! - Gravito-bending length l = (D/(ρ g t))^(1/3), over which weight bends a sheet visibly, and Γ =
//!   (L/l)³, which determines the droop of a heavy cantilever of length L (Romero et al., *Physical
//!   Validation of Simulators in Computer Graphics*, ACM TOG 40(4), 2021).
//! - Effect of the soft membrane of a two-layer lattice: the stiffness lost at the root of a
//!   cantilever of this sheet, where its curvature is largest. The curvature is Γ/(2 L) at small
//!   droop and √(2 Γ)/L when the sheet hangs (from ½ D κ² = ρ g t L at the root of a sheet that
//!   hangs straight down); the smaller is used.

use serde::Serialize;

use crate::error::{InputError, check_range};
use crate::material::calibration::{CalibrationRequest, DeliveredRatios, Orthotropic, calibrate, strip_bending};
use crate::mesh::structure::StructureKind;
use crate::scene::{Material, validate};

/// Request for a report.
#[derive(Clone, Debug, PartialEq)]
pub struct ReportRequest {
    /// Constants, with the thickness of the sheet.
    pub material: Material,
    /// Structure.
    pub structure: StructureKind,
    /// Nodes along the length, layers, nodes along the width.
    pub grid: (u32, u32, u32),
    /// Length and width, m.
    pub size: (f64, f64),
    /// Distance between layers, m; `None` for that of the calibration.
    pub gap: Option<f64>,
    /// Gravity, m/s², 1e-6 to 1000.
    pub gravity: f64,
}

/// Moduli of a narrow strip that is cut at an angle to the warp (thesis equations 1.14 and 1.15).
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[allow(missing_docs)] // Each key says what it is and in which unit.
pub struct DirectionalModuli {
    pub degrees_from_warp: f64,
    pub tensile_n_m: f64,
    pub bending_n_m: f64,
}

/// Requested and delivered properties of a material in a sheet. Keys carry their units.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[allow(missing_docs)] // Each key says what it is and in which unit; the module has the formulas.
pub struct MaterialReport {
    pub young_pa: f64,
    pub poisson: f64,
    pub density_kg_m3: f64,
    pub thickness_m: f64,
    pub damping_ratio: f64,
    pub yield_stress_pa: Option<f64>,
    pub glass_transition_c: Option<f64>,
    pub orthotropic: bool,
    pub directions: Vec<DirectionalModuli>,
    pub plate_stiffness_n_m: f64,
    pub plate_stiffness_across_n_m: f64,
    pub twist_stiffness_n_m: f64,
    pub plate_modulus_pa: f64,
    pub membrane_stiffness_n_m: f64,
    pub areal_mass_kg_m2: f64,
    pub gravito_bending_length_m: f64,
    pub gamma_plate: f64,
    pub structure: &'static str,
    pub grid: [u32; 3],
    pub length_m: f64,
    pub width_m: f64,
    pub gap_m: Option<f64>,
    pub bending_0_45_90_135: [f64; 4],
    pub twist: f64,
    pub bend_to_twist: f64,
    pub membrane: f64,
    pub poisson_ratio: f64,
    pub bending_residual: f64,
    pub shear_loss: Option<f64>,
    pub soft_membrane_loss: f64,
    pub notes: Vec<String>,
}

/// Report of a material in a sheet.
///
/// # Errors
/// When a value is out of range; the error names the field.
pub fn material_report(request: &ReportRequest) -> Result<MaterialReport, InputError> {
    let material = &request.material;
    validate::material("material", material)?;
    check_range("gravity", request.gravity, 1e-6, 1e3, "m/s²")?;
    let target = material.target();
    let base = CalibrationRequest::new(request.structure, request.grid, request.size, target, material.areal_mass());
    let found = calibrate(&CalibrationRequest { gap: request.gap, ..base })?;
    let delivered = found.delivered;
    let bending = target.bending[0][0];
    let length = (bending / (material.areal_mass() * request.gravity)).cbrt();
    let gamma = (request.size.0 / length).powi(3);
    let loss = soft_membrane_loss(request, &delivered, gamma);
    // A measured sheet has no modulus: use that of its warp, divided by the thickness.
    let measured = material.orthotropic.map(|o| (o.young_warp / material.thickness, o.poisson));
    let (young_pa, poisson) = measured.unwrap_or((material.young, material.poisson));
    let mut notes = delivered.notes;
    if loss > 0.002 {
        notes.push(format!(
            "the soft membrane makes a cantilever of this sheet {:.1} % softer where it is bent most",
            100.0 * loss
        ));
    }
    Ok(MaterialReport {
        young_pa,
        poisson,
        density_kg_m3: material.density,
        thickness_m: material.thickness,
        damping_ratio: material.damping(),
        yield_stress_pa: material.yield_stress,
        glass_transition_c: material.glass_transition,
        orthotropic: material.orthotropic.is_some(),
        directions: material.orthotropic.as_ref().map_or_else(Vec::new, directions),
        plate_stiffness_n_m: bending,
        plate_stiffness_across_n_m: target.bending[1][1],
        twist_stiffness_n_m: target.bending[2][2],
        plate_modulus_pa: target.membrane[0][0] / material.thickness,
        membrane_stiffness_n_m: target.membrane[0][0],
        areal_mass_kg_m2: material.areal_mass(),
        gravito_bending_length_m: length,
        gamma_plate: gamma,
        structure: request.structure.name(),
        grid: [request.grid.0, request.grid.1, request.grid.2],
        length_m: request.size.0,
        width_m: request.size.1,
        gap_m: (request.grid.1 > 1).then_some(found.spec.gap),
        bending_0_45_90_135: delivered.bending,
        twist: delivered.twist,
        bend_to_twist: delivered.bend_to_twist,
        membrane: delivered.membrane,
        poisson_ratio: delivered.poisson_ratio,
        bending_residual: delivered.residual,
        shear_loss: delivered.shear_loss,
        soft_membrane_loss: loss,
        notes,
    })
}

/// Moduli in steps of 15 degrees from warp to weft.
fn directions(measured: &Orthotropic) -> Vec<DirectionalModuli> {
    let at = |degrees| DirectionalModuli {
        degrees_from_warp: degrees,
        tensile_n_m: measured.young_at(degrees),
        bending_n_m: measured.bending_at(degrees),
    };
    [0.0, 15.0, 30.0, 45.0, 60.0, 75.0, 90.0].map(at).to_vec()
}

/// Fraction of its bending stiffness that a cantilever of the sheet loses at its root because the
/// membrane is softer than requested.
fn soft_membrane_loss(request: &ReportRequest, delivered: &DeliveredRatios, gamma: f64) -> f64 {
    let target = request.material.target();
    let curvature = (0.5 * gamma).min((2.0 * gamma).sqrt()) / request.size.0;
    let asked = DeliveredRatios::exact(&target).stretch;
    // Both have one Poisson's ratio, so that only the membrane differs.
    let strip =
        |stretch: f64| strip_bending(target.bending[0][0], stretch, delivered.poisson_ratio, curvature, request.size.1);
    (1.0 - strip(delivered.stretch) / strip(asked)).max(0.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::material;

    fn request(structure: StructureKind, layers: u32) -> ReportRequest {
        let material =
            Material { young: 3e9, poisson: 1.0 / 3.0, density: 1050.0, thickness: 5e-4, ..Material::default() };
        ReportRequest { material, structure, grid: (21, layers, 21), size: (0.25, 0.25), gap: None, gravity: 9.81 }
    }

    #[test]
    fn numbers_are_those_of_the_formulas() {
        let found = material_report(&request(StructureKind::Shell, 1)).expect("valid");
        let d = 3e9 * 1.25e-10 / 12.0 / (8.0 / 9.0);
        assert!((found.plate_stiffness_n_m / d - 1.0).abs() < 1e-12);
        assert!((found.areal_mass_kg_m2 - 0.525).abs() < 1e-12);
        assert!((found.gamma_plate - 0.525 * 9.81 * 0.25_f64.powi(3) / d).abs() < 1e-9);
        assert!((found.plate_modulus_pa / 3e9 - 9.0 / 8.0).abs() < 1e-12);
        assert_eq!((found.bending_0_45_90_135, found.twist, found.soft_membrane_loss), ([1.0; 4], 1.0, 0.0));
        assert!(found.notes.is_empty() && found.gap_m.is_none());
    }

    #[test]
    fn the_soft_membrane_loss_is_reported() {
        // The tip of this lattice lies 1.2 % lower than that of its continuum, by the soft membrane
        // alone; the loss at the root is larger.
        let found = material_report(&request(StructureKind::DoubleDiagonal, 2)).expect("valid");
        assert!(found.soft_membrane_loss > 0.01 && found.soft_membrane_loss < 0.03, "{}", found.soft_membrane_loss);
        assert!(found.notes.iter().any(|n| n.contains("softer where it is bent most")));
        let three = material_report(&request(StructureKind::DoubleDiagonal, 3)).expect("valid");
        assert!(three.soft_membrane_loss < 1e-4, "{}", three.soft_membrane_loss);
    }

    #[test]
    fn every_material_in_every_structure_has_a_report() {
        for (name, _, material) in material::LIBRARY {
            for row in crate::mesh::structure::TABLE {
                let layers = 2_u32.clamp(row.layers.0, row.layers.1);
                let request = ReportRequest { material: material.clone(), ..request(row.kind, layers) };
                let found = material_report(&request).expect(name);
                let text = serde_json::to_string(&found).expect("plain numbers");
                assert!(!text.contains(":null,\"plate") && !text.contains("NaN"), "{name} {}: {text}", row.name);
                assert_eq!(found.bending_0_45_90_135[0] > 0.5, layers == 2 || row.kind == StructureKind::Shell);
            }
        }
    }
}
