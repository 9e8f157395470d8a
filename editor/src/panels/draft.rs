//! Sheet that is being generated, and its preview.

use glam::DVec3;
use sheetwork::scene::{Scene, SheetSpec};
use sheetwork::sheet::Sheet;

use crate::session::Session;

/// Sheet that is being generated.
#[derive(Clone, Debug)]
pub struct Draft {
    pub(super) spec: SheetSpec,
    pub(super) file: String,
    /// Description and the preview built from it.
    pub(super) built: Option<(SheetSpec, Result<Preview, String>)>,
}

/// Preview of a built sheet.
#[derive(Clone, Debug)]
pub(super) struct Preview {
    pub(super) masses: usize,
    pub(super) springs: usize,
    pub(super) grams: f64,
    /// Lines in the plane (length, width), m.
    pub(super) lines: Vec<[(f64, f64); 2]>,
}

impl Draft {
    /// Draft with the description of sheet `index`, without name, pins and probes.
    pub fn from_sheet(session: &Session, index: usize) -> Self {
        let like = session.scene().sheets.get(index).cloned().unwrap_or_default();
        let spec = SheetSpec { name: String::new(), file: None, pins: Vec::new(), probes: Default::default(), ..like };
        Self { spec, file: "sheet.sht".into(), built: None }
    }

    pub(super) fn build(&mut self, session: &Session) {
        if self.built.as_ref().is_some_and(|(of, _)| *of == self.spec) {
            return;
        }
        let found = preview(session.scene(), &self.spec).map_err(|e| e.to_string());
        self.built = Some((self.spec.clone(), found));
    }
}

pub(super) fn one(scene: &Scene, spec: &SheetSpec) -> Result<Sheet, sheetwork::InputError> {
    let alone = Scene { sheets: vec![spec.clone()], base: scene.base.clone(), ..Scene::default() };
    sheetwork::scene::validate::scene(&alone)?;
    Sheet::build(&alone, 0)
}

fn preview(scene: &Scene, spec: &SheetSpec) -> Result<Preview, sheetwork::InputError> {
    let flat = SheetSpec { placement: Default::default(), velocity: DVec3::ZERO, ..spec.clone() };
    let sheet = one(scene, &flat)?;
    let at = |i: u32| sheet.state.x.get(i as usize);
    let line = |a: u32, b: u32| [(at(a).x, at(a).z), (at(b).x, at(b).z)];
    let springs = sheet.springs();
    let lines = if springs.is_empty() {
        sheet.edges().into_iter().map(|[a, b]| line(a, b)).collect()
    } else {
        (0..springs.len()).map(|i| line(springs.a[i], springs.b[i])).collect()
    };
    let (masses, springs, grams) = (sheet.node_count(), springs.len(), 1e3 * sheet.total_mass());
    Ok(Preview { masses, springs, grams, lines })
}
