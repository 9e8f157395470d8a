//! Variant of a scene: a field with another value.

use sheetwork::mesh::structure::StructureKind;
use sheetwork::scene::Scene;
use sheetwork::{InputError, ParameterId};

use crate::document::path::{numbered, with_value};
use crate::units::format_si;

/// Field and value of a variant: `sheets.0.structure`, `trimm`.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Variant {
    /// Path of the field.
    pub path: String,
    /// Value of the field.
    pub value: String,
}

impl Variant {
    /// Name beside the other variants: last part of the path, and value with unit.
    pub fn label(&self) -> String {
        let field = self.path.rsplit('.').next().unwrap_or_default();
        let field = match field {
            "dt" => "step",
            "young" => "Young",
            other => other,
        };
        let unit = ParameterId::from_path(&self.path).map_or("", |id| id.row().unit);
        match self.value.parse::<f64>() {
            Ok(number) if matches!(unit, "Pa" | "m" | "s") => format!("{field} {}", format_si(number, unit)),
            _ => format!("{field} {}", self.value),
        }
    }

    pub(super) fn applied_to(&self, scene: &Scene, sheets: &[sheetwork::sheet::Sheet]) -> Result<Scene, InputError> {
        let path = numbered(sheets, &self.path);
        let structure = path.strip_prefix("sheets.").and_then(|p| p.strip_suffix(".structure"));
        let Some(index) = structure.and_then(|i| i.parse::<usize>().ok()) else {
            return with_value(scene, &path, &self.value);
        };
        // The number of layers is clamped to those of the structure.
        let (kind, mut scene) = (self.value.parse::<StructureKind>()?, scene.clone());
        if let Some(sheet) = scene.sheets.get_mut(index) {
            let (low, high) = kind.info().layers;
            (sheet.structure, sheet.grid.1) = (kind, sheet.grid.1.clamp(low, high));
        }
        Ok(scene)
    }
}
