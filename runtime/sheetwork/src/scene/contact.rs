//! Specification of friction and restitution: defaults, and coefficients of material pairs.
//!
//! Two touching surfaces have the mean of their coefficients, unless the scene has a pair for their
//! materials, whose coefficients then apply.

use serde::{Deserialize, Serialize};

/// Contact offset of a surface without thickness, m. It exceeds the resolution of `f32` at the
/// scale of a body.
pub const MINIMUM_CONTACT_OFFSET: f64 = 1e-5;

/// Least step budget of a scene, node-iterations: some iterations of the smallest sheets.
pub const MINIMUM_STEP_BUDGET: u64 = 1000;

/// Half thickness to which tolerances of a surface without thickness refer, m.
pub const NOMINAL_HALF_THICKNESS: f64 = 2.5e-4;

/// Default contact coefficients of bodies and sheets.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct ContactDefaults {
    /// Coulomb friction coefficient, 0 to 10.
    pub friction: f64,
    /// Coefficient of restitution, 0 to 1.
    pub restitution: f64,
    /// Coefficients of material pairs, which replace all others.
    pub pairs: Vec<PairSpec>,
    /// Whether contact between sheets and self-contact are enabled.
    pub sheets: bool,
    /// Work of one step of implicit integrators, in node-iterations (about 0.2 µs each), above
    /// which the barrier method solves contact; above twice of it in few iterations: motion may
    /// then lag, which the step reports. [`MINIMUM_STEP_BUDGET`] or more; `None` for 4 million an
    /// island, 400,000 for one sheet on static and kinematic bodies.
    pub step_budget: Option<u64>,
}

impl Default for ContactDefaults {
    fn default() -> Self {
        Self { friction: 0.3, restitution: 0.1, pairs: Vec::new(), sheets: true, step_budget: None }
    }
}

/// Contact coefficients of two materials, in either order.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PairSpec {
    /// Names of the two materials: of the library, of a sheet's material file (without `.ron`) or
    /// its `name`, or the `material` of a body.
    pub between: (String, String),
    /// Coulomb friction coefficient, 0 to 10; `None` for that of the two surfaces.
    pub friction: Option<f64>,
    /// Coefficient of restitution, 0 to 1; `None` for that of the two surfaces.
    pub restitution: Option<f64>,
}

impl PairSpec {
    /// Whether the pair is of these two materials.
    pub(crate) fn joins(&self, a: &str, b: &str) -> bool {
        let (first, second) = (self.between.0.as_str(), self.between.1.as_str());
        (first == a && second == b) || (first == b && second == a)
    }
}

impl ContactDefaults {
    /// (friction, restitution) of two touching surfaces: those of the pair of their materials
    /// (empty name: none), where there is one, and otherwise `combined`.
    pub fn between(&self, materials: (&str, &str), combined: (f64, f64)) -> (f64, f64) {
        let pair = self.pairs.iter().find(|p| p.joins(materials.0, materials.1));
        pair.map_or(combined, |p| (p.friction.unwrap_or(combined.0), p.restitution.unwrap_or(combined.1)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_material_pair_overrides_surface_coefficients_in_either_order() {
        let pair = PairSpec { between: ("card".into(), "felt".into()), friction: Some(0.7), restitution: None };
        let contact = ContactDefaults { pairs: vec![pair], ..ContactDefaults::default() };
        assert_eq!(contact.between(("felt", "card"), (0.3, 0.1)), (0.7, 0.1));
        assert_eq!(contact.between(("card", "felt"), (0.3, 0.1)), (0.7, 0.1));
        assert_eq!(contact.between(("card", "card"), (0.3, 0.1)), (0.3, 0.1));
        assert_eq!(contact.between(("", ""), (0.3, 0.1)), (0.3, 0.1));
    }
}
