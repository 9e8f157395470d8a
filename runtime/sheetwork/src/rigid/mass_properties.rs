//! Mass, centre of mass and principal inertia of a body of uniform density, in f64.
//!
//! A box with edges a, b, c has the principal inertias m (b² + c²)/12 and cyclic, a ball of radius
//! r 2/5 m r² about any axis. A polyhedron is the sum of the tetrahedra that its triangles span
//! with a point o: the one with the corners o, p₁, p₂, p₃ has the volume V =
//! (p₁-o)·((p₂-o)×(p₃-o))/6 and, with s the sum of the three arms from o, the first moment V s/4
//! and the second moment ∫ x xᵀ dV = V/20 (Σ pᵢpᵢᵀ + s sᵀ) about o (Tonon, Explicit exact formulas
//! for the 3-D tetrahedron inertia tensor in terms of its vertex coordinates, J. Math. Stat. 1,
//! 2005). With C the second moment of the whole about its centre of mass, the inertia is ρ (tr C -
//! C). Jacobi rotations give its principal axes.

use glam::{DMat3, DQuat, DVec3};
use rapier3d::prelude::{LockedAxes, RigidBody};

use crate::rigid::settings::{RigidSettings, RotationSettings};
use crate::scene::{Polyhedron, Shape};

const SETTINGS: RotationSettings = RigidSettings::DEFAULT.rotation;

/// Mass, centre of mass and inertia of a body.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MassProperties {
    /// Mass, kg; infinite for a static or kinematic body.
    pub mass: f64,
    /// Centre of mass in the body frame, m.
    pub centre: DVec3,
    /// Inertias about the principal axes through the centre of mass, kg m²; infinite for a static
    /// or kinematic body.
    pub principal: DVec3,
    /// Rotation from the principal axes to the body frame.
    pub axes: DQuat,
}

impl MassProperties {
    /// Mass properties of a static or kinematic body, with the origin in place of the centre of
    /// mass.
    pub const fn immovable() -> Self {
        Self { mass: f64::INFINITY, centre: DVec3::ZERO, principal: DVec3::INFINITY, axes: DQuat::IDENTITY }
    }

    /// Mass properties of a dynamic body of a Rapier world. One that may not rotate about an axis
    /// is too heavy to rotate about any.
    pub(crate) fn from_rapier(body: &RigidBody) -> Self {
        let own = &body.mass_properties().local_mprops;
        let mass = f64::from(own.mass());
        let most = DVec3::splat(SETTINGS.locked_inertia * mass);
        let is_locked = body.locked_axes().intersects(LockedAxes::ROTATION_LOCKED);
        Self {
            mass,
            centre: own.local_com.as_dvec3(),
            principal: if is_locked { most } else { own.inv_principal_inertia.as_dvec3().recip().min(most) },
            axes: own.principal_inertia_local_frame.as_dquat().normalize(),
        }
    }

    /// Mass properties of a body of density 1 kg/m³ with this shape and its `polyhedra` (empty for
    /// balls and half spaces). `None` if the volume is zero or infinite.
    pub fn from_shape(shape: &Shape, polyhedra: &[Polyhedron]) -> Option<Self> {
        let centred = |mass: f64, principal| Self { mass, centre: DVec3::ZERO, principal, axes: DQuat::IDENTITY };
        let found = match shape {
            Shape::HalfSpace => return None,
            Shape::Ball(r) => {
                let mass = 4.0 / 3.0 * std::f64::consts::PI * r * r * r;
                centred(mass, DVec3::splat(0.4 * mass * r * r))
            }
            Shape::Box(size) => {
                let (mass, squares) = (size.x * size.y * size.z, *size * *size);
                centred(mass, (DVec3::splat(squares.element_sum()) - squares) * (mass / 12.0))
            }
            Shape::File(_) | Shape::Part(..) | Shape::Polyhedron(_) => Self::from_polyhedra(polyhedra)?,
        };
        (found.mass > 0.0 && found.principal.min_element() > 0.0).then_some(found)
    }

    /// Mass properties scaled to the mass `mass` (kg).
    pub fn with_mass(self, mass: f64) -> Self {
        Self { mass, principal: self.principal * (mass / self.mass), ..self }
    }

    /// Mass properties of a body with the centre of mass at its origin and the inertia `inertia`
    /// (kg m²). A vanishing principal inertia, as of nodes on a line, is replaced by a minimal one.
    pub fn from_inertia(mass: f64, inertia: DMat3) -> Self {
        let (principal, axes) = principal_axes(inertia);
        let least = f64::EPSILON * principal.max_element().max(f64::MIN_POSITIVE / f64::EPSILON);
        Self { mass, centre: DVec3::ZERO, principal: principal.max(DVec3::splat(least)), axes }
    }

    fn from_polyhedra(polyhedra: &[Polyhedron]) -> Option<Self> {
        // The reference point is a vertex of the body: a distant origin would cause cancellation.
        let from = polyhedra.iter().find_map(|p| p.vertices.first().copied())?;
        let (mut volume, mut first, mut second) = (0.0, DVec3::ZERO, DMat3::ZERO);
        for polyhedron in polyhedra {
            for face in 0..polyhedron.faces.len() {
                let corners = polyhedron.corners(face);
                for pair in corners.windows(2).skip(1) {
                    let arms = [corners[0] - from, pair[0] - from, pair[1] - from];
                    let part = arms[0].dot(arms[1].cross(arms[2])) / 6.0;
                    let sum = arms[0] + arms[1] + arms[2];
                    volume += part;
                    first += sum * (part / 4.0);
                    let squares = arms.iter().fold(outer(sum), |all, p| all + outer(*p));
                    second += squares * (part / 20.0);
                }
            }
        }
        let arm = first / volume;
        let about_centre = second - outer(arm) * volume;
        let trace = about_centre.x_axis.x + about_centre.y_axis.y + about_centre.z_axis.z;
        let (principal, axes) = principal_axes(DMat3::from_diagonal(DVec3::splat(trace)) - about_centre);
        volume.is_finite().then_some(Self { mass: volume, centre: from + arm, principal, axes })
    }
}

fn outer(p: DVec3) -> DMat3 {
    DMat3::from_cols(p * p.x, p * p.y, p * p.z)
}

/// Eigenvalues of a symmetric matrix, and the rotation from its eigenvectors to the given axes.
fn principal_axes(mut a: DMat3) -> (DVec3, DQuat) {
    let mut axes = DMat3::IDENTITY;
    for _ in 0..SETTINGS.maximum_jacobi_sweeps {
        for (p, q) in [(0, 1), (0, 2), (1, 2)] {
            let beside = a.col(q)[p];
            if beside.abs() <= f64::EPSILON * 0.01 * (a.col(p)[p].abs() + a.col(q)[q].abs()) {
                continue;
            }
            // The smaller of the two angles that eliminate the entry.
            let theta = 0.5 * (a.col(q)[q] - a.col(p)[p]) / beside;
            let tangent = theta.signum() / (theta.abs() + (theta * theta + 1.0).sqrt());
            let cosine = 1.0 / (tangent * tangent + 1.0).sqrt();
            let turn = plane_rotation(p, q, cosine, tangent * cosine);
            a = turn.transpose() * a * turn;
            axes *= turn;
        }
    }
    (DVec3::new(a.x_axis.x, a.y_axis.y, a.z_axis.z), DQuat::from_mat3(&axes).normalize())
}

/// Rotation in the plane of the axes `p` and `q` that maps e_p to c e_p - s e_q.
fn plane_rotation(p: usize, q: usize, cosine: f64, sine: f64) -> DMat3 {
    let mut turn = DMat3::IDENTITY;
    turn.col_mut(p)[p] = cosine;
    turn.col_mut(p)[q] = -sine;
    turn.col_mut(q)[p] = sine;
    turn.col_mut(q)[q] = cosine;
    turn
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::Placement;

    fn close(a: DVec3, b: DVec3, tolerance: f64) -> bool {
        (a - b).abs().max_element() <= tolerance * b.abs().max_element()
    }

    fn sorted(v: DVec3) -> DVec3 {
        let mut all = v.to_array();
        all.sort_by(f64::total_cmp);
        all.into()
    }

    #[test]
    fn a_box_as_a_polyhedron_turned_and_far_away_has_the_inertia_of_a_box() {
        let size = DVec3::new(0.063, 0.088, 0.002);
        let wanted = MassProperties::from_shape(&Shape::Box(size), &[]).expect("a body").with_mass(0.7);
        let place = Placement { position: DVec3::new(30.0, -20.0, 50.0), rotation: DVec3::new(31.0, 47.0, -12.0) };
        let mut turned = Polyhedron::cuboid(size);
        turned.vertices.iter_mut().for_each(|p| *p = place.apply(*p));
        let shape = Shape::Polyhedron(turned.clone());
        let found = MassProperties::from_shape(&shape, &[turned]).expect("a body").with_mass(0.7);
        assert!(close(found.centre, place.position, 1e-12));
        assert!(close(sorted(found.principal), sorted(wanted.principal), 1e-9), "{found:?} {wanted:?}");
        // Inertia tensor in the body frame, independent of the order and signs of the principal
        // axes.
        let tensor = |m: &MassProperties, turn: DQuat| {
            let axes = DMat3::from_quat(turn * m.axes);
            axes * DMat3::from_diagonal(m.principal) * axes.transpose()
        };
        let (a, b) = (tensor(&found, DQuat::IDENTITY), tensor(&wanted, place.quaternion()));
        for axis in 0..3 {
            assert!((a.col(axis) - b.col(axis)).length() < 1e-9 * wanted.principal.max_element());
        }
    }

    #[test]
    fn a_corner_tetrahedron_has_its_closed_form() {
        // Corners 0, a x, a y, a z: V = a³/6, centre a/4. About the corner ∫ x² dV = a⁵/60 and ∫ x
        // y dV = a⁵/120, hence about the centre V a² (1/10 - 1/16) = 3/80 V a² and V a² (1/20 -
        // 1/16) = -1/80 V a². The inertia V a²/80, with 6 on and 1 beside the diagonal, has the
        // eigenvalues 5, 5 and 8.
        let a = 0.3;
        let corners = [DVec3::ZERO, DVec3::X * a, DVec3::Y * a, DVec3::Z * a];
        let body = Polyhedron {
            vertices: corners.to_vec(),
            faces: vec![vec![0, 2, 1], vec![0, 1, 3], vec![0, 3, 2], vec![1, 2, 3]],
        };
        let found = MassProperties::from_shape(&Shape::Polyhedron(body.clone()), &[body]).expect("a body");
        let volume = a * a * a / 6.0;
        assert!((found.mass - volume).abs() < 1e-15 * volume.max(1.0));
        assert!(close(found.centre, DVec3::splat(a / 4.0), 1e-13));
        let unit = volume * a * a / 80.0;
        assert!(close(sorted(found.principal), DVec3::new(5.0, 5.0, 8.0) * unit, 1e-12), "{found:?}");
    }

    #[test]
    fn a_fine_dome_approaches_the_half_ball() {
        // Half ball of radius r: V = 2/3 π r³, centre 3/8 r above its base, inertia about the
        // centre 83/320 m r² across and 2/5 m r² along the axis.
        let dome = Polyhedron::hemisphere(1.0, 48, 192);
        let found = MassProperties::from_shape(&Shape::Polyhedron(dome.clone()), &[dome]).expect("a body");
        let volume = 2.0 / 3.0 * std::f64::consts::PI;
        assert!((found.mass / volume - 1.0).abs() < 2e-3);
        assert!((found.centre.y - 0.375).abs() < 1e-3, "{found:?}");
        let wanted = DVec3::new(83.0 / 320.0, 83.0 / 320.0, 0.4) * found.mass;
        assert!(close(sorted(found.principal), wanted, 3e-3), "{found:?} {wanted}");
    }

    #[test]
    fn shapes_without_finite_volume_have_no_mass_properties() {
        assert!(MassProperties::from_shape(&Shape::HalfSpace, &[]).is_none());
        let flat = Polyhedron { vertices: vec![DVec3::ZERO, DVec3::X, DVec3::Y], faces: vec![vec![0, 1, 2]] };
        assert!(MassProperties::from_shape(&Shape::Polyhedron(flat.clone()), &[flat]).is_none());
    }
}
