//! The Pareto front: configurations for which no other is better in both cost and error.

use crate::bench::point::ParetoPoint;

/// Indices in `points` of valid points on the front, cheapest first.
pub fn front(points: &[&ParetoPoint]) -> Vec<usize> {
    let mut order: Vec<usize> = (0..points.len()).filter(|&i| points[i].is_valid()).collect();
    let key = |i: usize| (points[i].cpu_ms_per_simulated_s, points[i].error.unwrap_or(f64::INFINITY));
    // At equal cost the smaller error comes first, so that the others are removed below.
    order.sort_by(|&a, &b| {
        let ((cost_a, error_a), (cost_b, error_b)) = (key(a), key(b));
        cost_a.total_cmp(&cost_b).then(error_a.total_cmp(&error_b)).then(a.cmp(&b))
    });
    let mut best = f64::INFINITY;
    order.retain(|&i| {
        let better = key(i).1 < best;
        best = best.min(key(i).1);
        better
    });
    order
}

#[cfg(test)]
pub mod tests {
    use super::*;

    /// A point with this cost (ms) and this error.
    pub fn point(cost: f64, error: f64) -> ParetoPoint {
        ParetoPoint {
            case: "cantilever".into(),
            structure: "shell".into(),
            engine: "tr-bdf2".into(),
            grid: "21x21".into(),
            dt_s: 1.0 / 60.0,
            poisson: 0.0,
            cpu_ms_per_simulated_s: cost,
            error: Some(error),
            quantity: "drop_m".into(),
            measured: Some(1.0 + error),
            reference: Some(1.0),
            settled: Some(true),
            status: "ok".into(),
            peer: false,
        }
    }

    #[test]
    fn the_front_has_only_undominated_points() {
        let mut all = [
            point(10.0, 0.1),
            point(5.0, 0.2),
            point(20.0, 0.1),
            point(20.0, 0.01),
            point(4.0, 0.3),
            point(6.0, 0.25),
            point(1.0, 0.001),
        ];
        all[6].settled = Some(false);
        let points: Vec<&ParetoPoint> = all.iter().collect();
        assert_eq!(front(&points), [4, 1, 0, 3]);
    }
}
