//! Curvatures of a plate as sums over masses: what a lattice of masses has to say to [`super::bending`].
//!
//! κ_a = Σ w x (+ Σ c t where an edge's slope is prescribed), a = uu, vv, 2uv; vectors, because x is. A group is where the
//! three are known together and stand for an area. Curvatures that nothing holds (across a free edge) are `relaxed`: they
//! take the value that costs least, which is the natural boundary condition.

/// Curvatures at one place.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct CurvatureGroup {
    /// Stencil of each component (uu, vv, 2uv): masses and weights, 1/m²; empty for one that is not known here.
    pub rows: [Vec<(u32, f64)>; 3],
    /// What a prescribed edge slope adds to each component: number of the direction and weight, 1/m.
    pub clamps: [Vec<(u32, f64)>; 3],
    /// Area the group stands for, the clamp's factor included, m².
    pub area: f64,
    /// Directions (uu, vv, 2uv) of curvature that are free to adjust.
    pub relaxed: Vec<[f64; 3]>,
    /// Masses a, b, c, d whose differences give the normal, (x_b - x_a) × (x_d - x_c).
    pub frame: [u32; 4],
}
