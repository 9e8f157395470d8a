//! A variant: a field of the scene with another value.

use sheetwork::InputError;
use sheetwork::mesh::structure::StructureKind;
use sheetwork::scene::Scene;

use crate::document::path::{numbered, with_value};
use crate::units::format_si;

/// A field and the value it has in place of the scene's: `sheets.0.structure`, `trimm`.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Variant {
    /// The field, by path.
    pub path: String,
    /// Its value.
    pub value: String,
}

impl Variant {
    /// What it is called beside the others: the last name of its path and its value, with a unit.
    pub fn label(&self) -> String {
        let field = self.path.rsplit('.').next().unwrap_or_default();
        let (field, unit) = match field {
            "dt" => ("step", "s"),
            "young" => ("Young", "Pa"),
            "thickness" => ("thickness", "m"),
            other => (other, ""),
        };
        match self.value.parse::<f64>() {
            Ok(number) if !unit.is_empty() => format!("{field} {}", format_si(number, unit)),
            _ => format!("{field} {}", self.value),
        }
    }

    pub(super) fn of(&self, scene: &Scene, sheets: &[sheetwork::sheet::Sheet]) -> Result<Scene, InputError> {
        let path = numbered(sheets, &self.path);
        let structure = path.strip_prefix("sheets.").and_then(|p| p.strip_suffix(".structure"));
        let Some(index) = structure.and_then(|i| i.parse::<usize>().ok()) else {
            return with_value(scene, &path, &self.value);
        };
        // As many layers as it may have: others are not to be compared with.
        let (kind, mut scene) = (self.value.parse::<StructureKind>()?, scene.clone());
        if let Some(sheet) = scene.sheets.get_mut(index) {
            let (low, high) = kind.info().layers;
            (sheet.structure, sheet.grid.1) = (kind, sheet.grid.1.clamp(low, high));
        }
        Ok(scene)
    }
}
