//! Laws of the stiffness of the springs between the layers of a lattice.
//!
//! Planar springs resist stretching; inter-layer springs resist bending and hold the layers apart
//! (thesis 2.7, 3.4). With w and l (m) the distances of nodes along the two sides of a cell and h
//! (m) that of the layers, the part of the sheet below one node has across the thickness
//!
//!   A_xx = w l (thesis 3.6b),  K_xx = E w l/h (3.7b, 3.10a),
//!
//! with a modulus E (Pa). The springs of a lattice are inclined by θ from the thickness. The
//! thesis lets the springs between a node and a layer share that stiffness by
//!
//!   Σ K cos θ = K_xx (3.11).
//!
//! A force across the thickness meets Σ K cos² θ, which is less; and a spring that is pressed
//! flat loses its resistance: layers at distance y carry at most about 3 K (L₀ - L) y/L per node
//! of three springs, the load at which they snap through.

use std::collections::BTreeMap;
use std::str::FromStr;

use serde::{Deserialize, Serialize};

use crate::error::{InputError, reject_if};
use crate::mesh::spring_class::SpringClass;
use crate::mesh::structure::{Lattice, LatticeSpec, LatticeSpring, StructureKind};
use crate::scene::{SheetSpec, SpringLaw};
use crate::units::parameters::ParameterId as Id;

/// Law of the stiffness K of inter-layer springs, for the spring law `Uniform`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub enum InterLayerLaw {
    /// K of a planar spring, as in table 4.3 of the thesis.
    #[default]
    Planar,
    /// K = E w l/h for every spring, with this modulus E (Pa, 1e-3 to 2e12): thesis 3.7b, 3.10a.
    Modulus(f64),
    /// Σ K cos θ = E w l/h over the springs between a node and a layer, with this modulus E (Pa,
    /// 1e-3 to 2e12): thesis 3.10a, 3.11.
    SumModulus(f64),
    /// Σ K cos θ = K_xx over these springs, with this K_xx (N/m, 1e-9 to 1e12): thesis 3.11.
    SumStiffness(f64),
}

impl FromStr for InterLayerLaw {
    type Err = InputError;

    fn from_str(text: &str) -> Result<Self, InputError> {
        let law: Self = ron::from_str(text).map_err(|_| {
            let laws = "Planar, Modulus(Pa), SumModulus(Pa), SumStiffness(N/m)";
            InputError::new("inter_layer", format!("\"{text}\" is none of {laws} with a plain number"))
        })?;
        law.check().map(|()| law)
    }
}

impl InterLayerLaw {
    /// Check the range of the modulus or stiffness.
    ///
    /// # Errors
    /// When it is out of range.
    pub fn check(self) -> Result<(), InputError> {
        match self {
            Self::Planar => Ok(()),
            Self::Modulus(e) | Self::SumModulus(e) => Id::MaterialYoung.check("inter_layer", e),
            Self::SumStiffness(k) => Id::InterLayerStiffness.check("inter_layer", k),
        }
    }

    /// Set the `stiffness` (N/m) of the inter-layer springs of `lattice`.
    pub(crate) fn apply(self, spec: &LatticeSpec, lattice: &Lattice, stiffness: &mut [f64]) {
        let column = |modulus: f64| {
            let (w, l) = spec.spacing();
            modulus * w * l / spec.gap
        };
        let inter = lattice.links.iter().zip(stiffness).filter(|(link, _)| link.class == SpringClass::Inter);
        let total = match self {
            Self::Planar => return,
            Self::Modulus(e) => return inter.for_each(|(_, k)| *k = column(e)),
            Self::SumModulus(e) => column(e),
            Self::SumStiffness(total) => total,
        };
        let sums = cosine_sums(lattice);
        inter.for_each(|(link, k)| *k = total / sums[&cell_of(link, lattice)]);
    }
}

/// Cell of an inter-layer spring: its node of the smaller (odd) layer, and the lower of the two
/// layers.
fn cell_of(link: &LatticeSpring, lattice: &Lattice) -> (u32, u32) {
    let is_small = lattice.layer_of[link.a as usize] % 2 == 1;
    (if is_small { link.a } else { link.b }, link.layer)
}

/// Σ cos θ over the springs of each cell at rest.
fn cosine_sums(lattice: &Lattice) -> BTreeMap<(u32, u32), f64> {
    let mut sums = BTreeMap::new();
    for link in lattice.links.iter().filter(|link| link.class == SpringClass::Inter) {
        let along = lattice.positions[link.b as usize] - lattice.positions[link.a as usize];
        *sums.entry(cell_of(link, lattice)).or_default() += along.y.abs() / along.length();
    }
    sums
}

/// Check the stiffness between the layers of a sheet. A lattice of one layer ignores the law.
pub(crate) fn check(s: &SheetSpec) -> Result<(), InputError> {
    Id::InterLayerStiffness.check_option("inter_layer_stiffness", s.inter_layer_stiffness)?;
    s.inter_layer.check()?;
    if s.file.is_some() || (s.inter_layer == InterLayerLaw::Planar && s.inter_layer_stiffness.is_none()) {
        return Ok(());
    }
    let field = if s.inter_layer_stiffness.is_some() { "inter_layer_stiffness" } else { "inter_layer" };
    let (is_single, own, law) = (s.grid.1 < 2, s.inter_layer_stiffness.is_some(), s.springs);
    let needs = format!("needs a lattice of two layers or more, but {} has {}", s.structure, s.grid.1);
    reject_if!(is_single && (own || s.structure == StructureKind::Shell), field, "{needs}");
    let needs = "needs springs: Uniform;";
    let other = !is_single && law != SpringLaw::Uniform;
    reject_if!(other, field, "{needs} {law:?} takes the springs between layers from the material");
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::structure::generate;

    fn stiffness(law: InterLayerLaw, structure: StructureKind, layers: u32) -> (LatticeSpec, Lattice, Vec<f64>) {
        let spec =
            LatticeSpec { structure, grid: (11, layers, 11), size: (0.025, 0.025), gap: 0.001, cross_over: false };
        let lattice = generate(&spec).expect("valid");
        let mut all = vec![0.185; lattice.links.len()];
        law.apply(&spec, &lattice, &mut all);
        (spec, lattice, all)
    }

    #[test]
    fn the_modulus_of_table_3_1_gives_its_springs() {
        // Thesis table 3.1 and 3.8b: K = 205e-3 N/m with h = 1 mm, w = l = 2.5 mm is 32.8 Pa across
        // the thickness.
        let (_, lattice, all) = stiffness(InterLayerLaw::Modulus(32.8), StructureKind::Slamm, 2);
        for (link, k) in lattice.links.iter().zip(&all) {
            let wanted = if link.class == SpringClass::Inter { 0.205 } else { 0.185 };
            assert!((k - wanted).abs() < 1e-12, "{link:?} {k}");
        }
    }

    #[test]
    fn inclined_springs_share_the_stiffness_of_their_node() {
        for (structure, layers) in [(StructureKind::Samm, 2), (StructureKind::Trimm, 3), (StructureKind::Provot3d, 4)] {
            let (spec, lattice, all) = stiffness(InterLayerLaw::SumModulus(185.0), structure, layers);
            let (w, l) = spec.spacing();
            let mut sums: BTreeMap<(u32, u32), f64> = BTreeMap::new();
            for (link, k) in lattice.links.iter().zip(&all).filter(|(l, _)| l.class == SpringClass::Inter) {
                let cosine = spec.gap / lattice.positions[link.a as usize].distance(lattice.positions[link.b as usize]);
                *sums.entry(cell_of(link, &lattice)).or_default() += k * cosine;
            }
            assert!(!sums.is_empty());
            for (cell, sum) in &sums {
                let wanted = 185.0 * w * l / spec.gap;
                assert!((sum / wanted - 1.0).abs() < 1e-12, "{structure} {cell:?}: {sum} {wanted}");
            }
        }
    }

    #[test]
    fn texts_name_the_laws_and_their_ranges() {
        assert_eq!("SumModulus(185)".parse(), Ok(InterLayerLaw::SumModulus(185.0)));
        for (text, part) in [("Stiff", "Modulus(Pa)"), ("Modulus(-1)", "Pa"), ("SumStiffness(0)", "N/m")] {
            let error = text.parse::<InterLayerLaw>().expect_err(text).to_string();
            assert!(error.contains(part), "{error}");
        }
    }
}
