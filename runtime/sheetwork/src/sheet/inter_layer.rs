//! Springs between the layers of a running sheet: their stiffness as a value of its own (thesis
//! 2.7, 3.4, table 4.3), and the distance of the layers.
//!
//! A spring between layers has K = κ U. κ is its stiffness per N/m of E t, as of every spring. U
//! (N/m) is E t for springs that follow the material, and K_own/κ_mean for springs of a mean
//! stiffness K_own of their own, which a change of the material leaves as it is.

use glam::DVec3;

use crate::error::{InputError, reject_if};
use crate::mesh::spring_class::SpringClass;
use crate::scene::{InterLayerLaw, SheetSpec, SpringLaw};
use crate::sheet::{Sheet, remap};
use crate::units::parameters::ParameterId as Id;

/// Stiffness of the springs between layers.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct InterLayerSprings {
    /// Mean stiffness per N/m of E t; 0 for a sheet whose springs between layers cannot be set.
    mean_per_unit: f64,
    /// Mean stiffness by the law of the scene, N/m; `None` for springs that follow the material.
    by_law: Option<f64>,
    /// Mean stiffness of their own, N/m; `None` for springs that follow the material.
    own: Option<f64>,
}

impl InterLayerSprings {
    /// Stiffness (N/m) of a spring of one unit; `planar` is that of planar springs.
    pub fn unit(&self, planar: f64) -> f64 {
        self.own.map_or(planar, |k| k / self.mean_per_unit)
    }
}

/// Take the stiffness between layers from the description of the sheet.
///
/// # Errors
/// When the sheet has no springs that can have it.
pub(crate) fn initialise(sheet: &mut Sheet, spec: &SheetSpec) -> Result<(), InputError> {
    let from_file = spec.file.is_some();
    if !from_file && spec.springs != SpringLaw::Uniform {
        return Ok(());
    }
    let each = || sheet.springs.class.iter().zip(&sheet.parameters.springs.per_unit);
    let inter = || each().filter(|(class, _)| **class == SpringClass::Inter).map(|(_, k)| k);
    let mean = inter().sum::<f64>() / inter().count().max(1) as f64;
    let follows = from_file || spec.inter_layer == InterLayerLaw::Planar;
    let by_law = (!follows).then_some(mean * sheet.parameters.material.young * sheet.parameters.material.thickness);
    sheet.parameters.springs.inter_layer = InterLayerSprings { mean_per_unit: mean, by_law, own: by_law };
    spec.inter_layer_stiffness.map_or(Ok(()), |k| sheet.set_inter_layer_stiffness(Some(k)))
}

/// Give `sheet` the stiffness between layers that `old`, its present form on another grid, was set
/// to; a stiffness by law is that of the grid.
///
/// # Errors
/// When the sheet has no such springs.
pub(crate) fn copy_stiffness(sheet: &mut Sheet, old: &Sheet) -> Result<(), InputError> {
    let before = &old.parameters.springs.inter_layer;
    if before.own == before.by_law { Ok(()) } else { sheet.set_inter_layer_stiffness(before.own) }
}

/// Mean stiffness of the springs between layers without heat, N/m; `None` for a sheet without such
/// springs or with calibrated ones.
pub fn stiffness(sheet: &Sheet) -> Option<f64> {
    let inter = &sheet.parameters.springs.inter_layer;
    let unit = sheet.parameters.material.young * sheet.parameters.material.thickness;
    (inter.mean_per_unit > 0.0).then(|| inter.own.unwrap_or(inter.mean_per_unit * unit))
}

/// Stiffness of the springs between layers of their own, N/m; `None` where it follows the material.
pub fn own_stiffness(sheet: &Sheet) -> Option<f64> {
    sheet.parameters.springs.inter_layer.own
}

impl Sheet {
    /// Set the mean stiffness of the springs between layers, N/m, 1e-9 to 1e12; `None` for that of
    /// the scene's law.
    ///
    /// # Errors
    /// When out of range or the sheet has no such springs; nothing is changed then.
    pub fn set_inter_layer_stiffness(&mut self, stiffness: Option<f64>) -> Result<(), InputError> {
        let field = "inter_layer_stiffness";
        Id::InterLayerStiffness.check_option(field, stiffness)?;
        let inter = &mut self.parameters.springs.inter_layer;
        let problem = "needs springs between layers: a lattice of two layers or more with springs: Uniform";
        reject_if!(stiffness.is_some() && inter.mean_per_unit <= 0.0, field, "{problem}");
        inter.own = stiffness.or(inter.by_law);
        self.refresh_springs();
        if self.parameters.max_step.is_finite() {
            remap::update_max_step(self);
        }
        Ok(())
    }
}

/// Mean distance of the nodes of every other layer from the cells below and above them, m,
/// negative where a node has passed through its cell; `None` for a single layer.
pub fn distance(sheet: &Sheet) -> Option<f64> {
    let height = |(apex, corners): (u32, &[u32])| {
        let place = |i: u32| sheet.state.x.get(i as usize);
        let sides = match corners {
            [a, b, c] => [(*a, *b), (*a, *c)],
            // Four corners come row by row; the diagonals of the cell span its plane.
            [a, b, d, c] => [(*a, *c), (*b, *d)],
            _ => return None,
        };
        let [first, second] = sides.map(|(from, to)| place(to) - place(from));
        let [p, q] = sides.map(|(from, to)| {
            let (f, t) = (sheet.model.place(from), sheet.model.place(to));
            [t[0] - f[0], t[1] - f[1]]
        });
        // Material axes u, v and the normal form a left-handed system.
        let orientation = -(p[0] * q[1] - p[1] * q[0]).signum();
        let normal = (first.cross(second) * orientation).try_normalize()?;
        let mean = corners.iter().map(|i| place(*i)).sum::<DVec3>() / corners.len() as f64;
        let is_above = sheet.model.layer_of[apex as usize] > sheet.model.layer_of[corners[0] as usize];
        Some((place(apex) - mean).dot(normal) * if is_above { 1.0 } else { -1.0 })
    };
    let (count, sum) =
        sheet.stack.cells().filter_map(height).fold((0.0, 0.0), |(n, sum), distance| (n + 1.0, sum + distance));
    (count > 0.0).then(|| sum / count)
}
