//! Specification of local refinement: a triangle mesh that is finer where the sheet folds or is
//! about to tear.

use serde::{Deserialize, Serialize};

use crate::error::InputError;
use crate::mesh::structure::StructureKind;
use crate::scene::{Region, SheetSpec};
use crate::units::parameters::ParameterId as Id;

/// Local refinement of a triangle mesh during a run.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct RefineSpec {
    /// Largest number of times that an edge is halved, 1 to 3.
    pub levels: u32,
    /// Largest fold angle per edge, degrees, 0.5 to 90: edges are halved where their length times
    /// the curvature of the sheet exceeds it.
    pub fold: f64,
    /// Strain as a fraction of the material's `tears_at`, 0.01 to 1, above which a triangle has all
    /// levels; `None` refines by the fold angle only.
    pub strain: Option<f64>,
    /// Part of both limits, 0 to 0.9, below which edges that would be twice as long must stay for
    /// the mesh to be coarsened.
    pub hysteresis: f64,
    /// Number of steps from one change of the mesh to the next possible one, 1 to 100000.
    pub every: u32,
}

impl Default for RefineSpec {
    fn default() -> Self {
        Self { levels: 2, fold: 10.0, strain: None, hysteresis: 0.5, every: 10 }
    }
}

/// Check the refinement of a sheet.
///
/// # Errors
/// When a value is out of range or the sheet has no mesh that can be refined.
pub(crate) fn check(s: &SheetSpec) -> Result<(), InputError> {
    let Some(refine) = &s.refine else { return Ok(()) };
    Id::RefineLevels.check("refine.levels", refine.levels.into())?;
    Id::RefineFold.check("refine.fold", refine.fold)?;
    Id::RefineStrain.check_option("refine.strain", refine.strain)?;
    Id::RefineHysteresis.check("refine.hysteresis", refine.hysteresis)?;
    Id::RefineEvery.check("refine.every", refine.every.into())?;
    let refused = |problem: String| Err(InputError::new("refine", problem));
    if s.file.is_some() || s.structure != StructureKind::Shell {
        let what = if s.file.is_some() { "a sheet from a file".to_owned() } else { s.structure.to_string() };
        return refused(format!("is for triangle meshes, not for {what}: use structure \"shell\" with an outline"));
    }
    if s.outline.is_none() && s.holes.is_empty() && s.cuts.is_empty() {
        let (x, z) = (0.5 * s.size.0, 0.5 * s.size.1);
        let rectangle = format!("Polygon([({}, {}), ({x}, {}), ({x}, {z}), ({}, {z})])", -x, -z, -z, -x);
        return refused(format!("is for triangle meshes: give this rectangle its outline, {rectangle}"));
    }
    let by_number = |r: &Region| matches!(r, Region::Masses(_));
    let refusals = [
        (s.detail.is_some(), "does not go with detail: one of the two chooses the mesh"),
        (!s.slits.is_empty(), "does not go with slits, which are open triangles of one mesh: use cuts"),
        (s.sticky, "does not go with sticky: what sticks does so by its masses"),
        (s.node_mass.is_some(), "does not go with node_mass: masses follow from the areas of the mesh"),
        (s.pins.iter().any(|p| p.body.is_some()), "does not go with glue: it is by masses"),
        (s.pins.iter().any(|p| by_number(&p.region)), "does not go with pins by number: give a region"),
    ];
    match refusals.into_iter().find(|(refused, _)| *refused) {
        Some((_, why)) => refused(why.into()),
        None if refine.strain.is_none() => Ok(()),
        None => s.material.check(|material| match material.tears_at {
            Some(_) => Ok(()),
            None => Err(InputError::new("refine.strain", "asks for tears_at, which the material does not have")),
        }),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::outline::OutlineSpec;
    use crate::scene::{DetailSpec, PinSpec};

    #[test]
    fn sheets_without_a_mesh_and_values_out_of_range_are_rejected_with_the_remedy() {
        let spec = SheetSpec {
            outline: Some(OutlineSpec::Disc { radius: 0.1 }),
            refine: Some(RefineSpec::default()),
            ..SheetSpec::default()
        };
        assert!(check(&spec).is_ok());
        let refused = |s: SheetSpec| {
            let e = check(&s).expect_err("refused");
            format!("{} {}", e.field, e.problem)
        };
        let with = |refine| SheetSpec { refine: Some(refine), ..spec.clone() };
        assert!(refused(with(RefineSpec { levels: 4, ..RefineSpec::default() })).starts_with("refine.levels "));
        assert!(refused(with(RefineSpec { fold: 0.0, ..RefineSpec::default() })).starts_with("refine.fold "));
        assert!(refused(with(RefineSpec { strain: Some(2.0), ..RefineSpec::default() })).contains("strain"));
        assert!(refused(with(RefineSpec { every: 0, ..RefineSpec::default() })).starts_with("refine.every "));
        let plain = SheetSpec { outline: None, size: (0.2, 0.1), ..spec.clone() };
        assert!(refused(plain).contains("Polygon([(-0.1, -0.05), (0.1, -0.05), (0.1, 0.05), (-0.1, 0.05)])"));
        let lattice = SheetSpec { structure: StructureKind::Slamm, ..spec.clone() };
        assert!(refused(lattice).contains("slamm: use structure \"shell\" with an outline"));
        let both = SheetSpec { detail: Some(DetailSpec::new([((21, 21), None)])), ..spec.clone() };
        assert!(refused(both).contains("detail"));
        let glued = SheetSpec { pins: vec![PinSpec::attached(Region::Left, "box")], ..spec };
        assert!(refused(glued).contains("glue"));
    }
}
