//! Curvature of a surface by a least-squares quadric.

use glam::DVec3;
use nalgebra::{SMatrix, SVector};

use crate::world::query::SurfaceCurvature;
use crate::world::query::settings::QuerySettings;
use crate::world::query::surface::QuerySurface;

/// Number of coefficients of the fit.
const TERMS: usize = 6;
const SETTINGS: QuerySettings = QuerySettings::DEFAULT;

/// Height over a plane with the slopes z_x, z_y and the second derivatives z_xx, z_xy, z_yy (1/m).
struct Quadric {
    slopes: [f64; 2],
    second: [f64; 3],
}

/// Curvature at `place` (m) in the triangle `nodes`.
pub(super) fn fit(surface: &QuerySurface, nodes: [u32; 3], place: DVec3) -> Option<SurfaceCurvature> {
    let (around, normal) = neighbourhood(surface, nodes);
    let frame_of = |normal: DVec3| {
        let normal = normal.try_normalize()?;
        let (across, beside) = normal.any_orthonormal_pair();
        Some([across, beside, normal])
    };
    let frame = frame_of(normal)?;
    let [p, q] = fit_over(&around, place, frame)?.slopes;
    // Once more over the tangent plane of the first fit.
    let frame = frame_of(frame[2] - frame[0] * p - frame[1] * q)?;
    principal(&fit_over(&around, place, frame)?, frame)
}

/// Height of the nodes over the plane through `place` (m) normal to the last axis of `frame`.
fn fit_over(around: &[DVec3], place: DVec3, [across, beside, normal]: [DVec3; 3]) -> Option<Quadric> {
    // Lengths relative to the extent of the neighbourhood, for the condition of the equations.
    let squared = around.iter().map(|p| p.distance_squared(place)).fold(0.0, f64::max);
    let scale = squared.sqrt();
    if !(scale.is_finite() && scale > 0.0) {
        return None;
    }
    let mut matrix = SMatrix::<f64, TERMS, TERMS>::zeros();
    let mut load = SVector::<f64, TERMS>::zeros();
    for p in around {
        let from = (*p - place) / scale;
        let (x, y, z) = (from.dot(across), from.dot(beside), from.dot(normal));
        let row = SVector::<f64, TERMS>::from([1.0, x, y, 0.5 * x * x, x * y, 0.5 * y * y]);
        matrix += row * row.transpose();
        load += row * z;
    }
    let factor = matrix.cholesky()?;
    let pivots = factor.l_dirty().diagonal().map(|d| d * d);
    if pivots.min() < SETTINGS.least_pivot_ratio * pivots.max() {
        return None;
    }
    let solution = factor.solve(&load);
    let second = [solution[3], solution[4], solution[5]].map(|second| second / scale);
    Some(Quadric { slopes: [solution[1], solution[2]], second })
}

/// Positions of the nodes within the rings of triangles, and the sum of the area vectors of
/// these triangles.
fn neighbourhood(surface: &QuerySurface, nodes: [u32; 3]) -> (Vec<DVec3>, DVec3) {
    let triangles = surface.triangles();
    let count = triangles.iter().flatten().max().map_or(0, |i| *i as usize + 1);
    let mut is_near = vec![false; count];
    nodes.iter().for_each(|i| is_near[*i as usize] = true);
    let mut normal = DVec3::ZERO;
    for _ in 0..SETTINGS.curvature_rings {
        let touches = |t: &&[u32; 3]| t.iter().any(|i| is_near[*i as usize]);
        let ring: Vec<[u32; 3]> = triangles.iter().filter(touches).copied().collect();
        ring.iter().flatten().for_each(|i| is_near[*i as usize] = true);
        normal = ring.iter().map(|t| surface.corners(*t)).map(|[a, b, c]| (b - a).cross(c - a)).sum();
    }
    let near = is_near.iter().zip(0_u32..).filter(|(near, _)| **near);
    (near.map(|(_, i)| surface.position(i)).collect(), normal)
}

/// Principal curvatures: eigenvalues of the shape operator I⁻¹ II of the two fundamental forms.
fn principal(quadric: &Quadric, [across, beside, normal]: [DVec3; 3]) -> Option<SurfaceCurvature> {
    let ([p, q], [r, s, t]) = (quadric.slopes, quadric.second);
    let squared = 1.0 + p * p + q * q;
    let root = squared.sqrt();
    // Orthonormal tangents: the first along x, the second across it.
    let first = across + normal * p;
    let second = beside + normal * q;
    let length = (1.0 + p * p).sqrt();
    let along = first / length;
    let aside = (second - along * second.dot(along)).try_normalize()?;
    // Components of II in these tangents: first = (length, 0), second = (shear, height).
    let (shear, height) = (second.dot(along), second.dot(aside));
    let a = r / root / (length * length);
    let b = (s / root / length - a * shear) / height;
    let c = (t / root - 2.0 * b * shear * height - a * shear * shear) / (height * height);
    let (mean, half) = (0.5 * (a + c), 0.5 * (a - c));
    let reach = half.hypot(b);
    let angle = 0.5 * b.atan2(half);
    let (sin, cos) = angle.sin_cos();
    let directions = [along * cos + aside * sin, aside * cos - along * sin];
    let gaussian = a * c - b * b;
    let all = SurfaceCurvature { principal: [mean + reach, mean - reach], directions, mean, gaussian };
    (all.mean.is_finite() && all.gaussian.is_finite()).then_some(all)
}
