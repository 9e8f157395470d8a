//! Nodes on triangles and edges on edges, of two sheets or of one.
//!
//! The normal of a node on a triangle is that of the triangle, on the side of the node. Beside the
//! border of a sheet, or over a ridge between two triangles, it is the direction between the
//! closest points. The normal of two edges is perpendicular to both. Edge pairs count only if both
//! edges stand out towards each other, as ridges and borders do; between flat surfaces the nodes
//! suffice, and two sheets that lie on each other need no constraint for each crossing of their
//! mesh lines. Neighbours within one sheet, nearer at rest than contact offset plus triangle size,
//! are excluded.

use glam::DVec3;

use crate::collision::bvh::{SurfaceTree, flanks};
use crate::collision::collision_surface::{NONE, SurfaceEdge, SurfaceTriangle};
use crate::collision::constraint::{ContactConstraint, ContactSide, SheetPoint};
use crate::collision::geometry::{
    barycentric_along, edges_meet, point_meets_triangle, point_triangle, segment_segment, triangles_intersect,
};
use crate::collision::narrow_phase::corner_triangle::{clamp_weights, interpolate};
use crate::collision::narrow_phase::edge_edge::{EdgeContact, EdgeOrientation, facing_parameters, on_edge};
use crate::collision::narrow_phase::feature_keys::{FeatureKind, feature_key};
use crate::collision::narrow_phase::{DetectionDistances, SheetStageMotion};
use crate::collision::settings::{DetectionSettings, EdgeEdgeSettings, SheetPairSettings};
use crate::math::Vectors;

const SETTINGS: SheetPairSettings = DetectionSettings::DEFAULT.sheet_pairs;
const DETECTION: DetectionSettings = DetectionSettings::DEFAULT;
const EDGE_EDGE: EdgeEdgeSettings = DetectionSettings::DEFAULT.edge_edge;

/// A sheet of a pair, with its index in the detection input.
#[derive(Clone, Copy)]
pub(crate) struct PairMember<'a> {
    pub index: u32,
    pub sheet: &'a SheetStageMotion<'a>,
    pub tree: &'a SurfaceTree,
}

impl PairMember<'_> {
    /// Positions of nodes at start, base and end, m.
    fn positions<const N: usize>(&self, masses: [u32; N]) -> [[DVec3; N]; 3] {
        [self.sheet.start, self.sheet.base, self.sheet.end].map(|x| masses.map(|i| x.get(i as usize)))
    }

    fn triangle(&self, t: u32) -> &SurfaceTriangle {
        &self.sheet.skin.triangles()[t as usize]
    }

    fn edge(&self, e: u32) -> &SurfaceEdge {
        &self.sheet.skin.edges()[e as usize]
    }

    fn edge_orientation(&self, edge: &SurfaceEdge) -> EdgeOrientation {
        let mut flanks = self.flanks(edge).map(DVec3::normalize_or_zero);
        let first = flanks.next().unwrap_or_default();
        let flanks = [first, flanks.next().unwrap_or(first)];
        EdgeOrientation { sides: self.tree.edge_normals(edge.triangles), flanks, is_border: edge.is_border() }
    }

    /// Orientation of an edge at the fraction `time` of the stage, for edges that turn within it.
    fn edge_orientation_at(&self, edge: &SurfaceEdge, time: f64) -> EdgeOrientation {
        let place = |i: u32| self.sheet.start.get(i as usize).lerp(self.sheet.end.get(i as usize), time);
        let [from, to] = edge.nodes.map(place);
        let along = (to - from).normalize_or(DVec3::X);
        let each = edge.triangles.map(|t| (t != NONE).then(|| self.triangle(t).nodes.map(place)));
        let only = each[0].or(each[1]).unwrap_or([from; 3]);
        let each = each.map(|corners| corners.unwrap_or(only));
        EdgeOrientation {
            sides: each.map(|corners| unit_normal(corners).unwrap_or_default()),
            flanks: each.map(|[a, b, c]| ((a + b + c) / 3.0 - from).reject_from_normalized(along).normalize_or_zero()),
            is_border: edge.is_border(),
        }
    }

    /// Height (m) by which edge `e` stands out against the direction `n`; infinite at the border.
    fn ridge_height(&self, e: u32, n: DVec3) -> f64 {
        if self.edge(e).is_border() { f64::INFINITY } else { self.tree.ridge(e).dot(n) }
    }

    /// Whether edge `e` stands out by less than `slack` (m) to either side.
    fn is_flat(&self, e: u32, slack: f64) -> bool {
        !self.edge(e).is_border() && self.tree.ridge(e).length_squared() < slack * slack
    }

    /// Position, at the base and at the end, of the end node of an edge that is nearer to parameter
    /// `k`, m.
    fn nearest_end(&self, edge: &SurfaceEdge, k: f64) -> [DVec3; 2] {
        let mass = edge.nodes[usize::from(k > 0.5)] as usize;
        [self.sheet.base, self.sheet.end].map(|x| x.get(mass))
    }

    /// Whether a point lies beyond the border `edge` of the sheet, at the base or at the end.
    fn ends_before(&self, edge: &SurfaceEdge, place: [DVec3; 2]) -> bool {
        let Some(triangle) = edge.triangles.into_iter().find(|t| *t != NONE).filter(|_| edge.is_border()) else {
            return false;
        };
        let middle =
            |x: &Vectors| self.triangle(triangle).nodes.iter().map(|i| x.get(*i as usize)).sum::<DVec3>() / 3.0;
        [self.sheet.base, self.sheet.end].into_iter().zip(place).any(|(x, place)| {
            let [from, to] = edge.nodes.map(|i| x.get(i as usize));
            let inward = (middle(x) - from).reject_from_normalized((to - from).normalize_or(DVec3::X));
            inward.dot(place - from) < 0.0
        })
    }

    /// Whether the surface at `edge` touches a node at `place` with a normal close to `normal`.
    fn meets_along(&self, edge: &SurfaceEdge, place: [DVec3; 2], normal: DVec3) -> bool {
        let is_along = |side: &DVec3| side.dot(normal).abs() > SETTINGS.same_direction_cosine;
        !self.ends_before(edge, place) && self.tree.edge_normals(edge.triangles).iter().any(is_along)
    }

    /// Vectors from an edge to the centroids of its triangles, perpendicular to the edge, m.
    fn flanks(&self, edge: &SurfaceEdge) -> impl Iterator<Item = DVec3> {
        flanks(self.sheet, edge)
    }
}

/// Two sheets, or one sheet twice.
pub(crate) struct SheetPair<'a> {
    pub a: PairMember<'a>,
    pub b: PairMember<'a>,
    pub limits: DetectionDistances,
    /// Friction and restitution coefficient.
    pub coefficients: (f64, f64),
}

impl SheetPair<'_> {
    fn is_self(&self) -> bool {
        self.a.index == self.b.index
    }

    /// Add the constraints of two triangles, one of each sheet, for the features that each owns.
    pub fn detect_triangle_pair(&self, ta: u32, tb: u32, constraints: &mut Vec<ContactConstraint>) {
        let (p, q) = (self.a.triangle(ta), self.b.triangle(tb));
        let shared = if self.is_self() { p.nodes.iter().filter(|i| q.nodes.contains(i)).count() } else { 0 };
        if shared >= 2 {
            return;
        }
        self.detect_node_triangle((&self.a, p), (&self.b, tb, q), constraints);
        self.detect_node_triangle((&self.b, q), (&self.a, ta, p), constraints);
        let flat = SETTINGS.flat_ridge_height * self.limits.offset;
        for i in (0..3).filter(|i| p.owns_edge[*i] && !self.a.is_flat(p.edges[*i], flat)) {
            for j in (0..3).filter(|j| q.owns_edge[*j] && !self.b.is_flat(q.edges[*j], flat)) {
                let swap = self.is_self() && p.edges[i] > q.edges[j];
                let (e, f) = if swap { (q.edges[j], p.edges[i]) } else { (p.edges[i], q.edges[j]) };
                self.detect_edge_edge(e, f, p.size.max(q.size), constraints);
            }
        }
    }

    /// Whether two triangles, one of each sheet, intersect with the nodes at the positions `x`.
    pub fn triangles_intersect(
        &self,
        ta: u32,
        tb: u32,
        x: impl for<'x> Fn(&SheetStageMotion<'x>) -> &'x Vectors,
    ) -> bool {
        let corners = |party: &PairMember, t: u32| party.triangle(t).nodes.map(|i| x(party.sheet).get(i as usize));
        triangles_intersect(corners(&self.a, ta), corners(&self.b, tb))
    }

    /// Whether two triangles intersect at the start with the first sheet translated by `by` (m).
    pub fn triangles_intersect_when_moved(&self, ta: u32, tb: u32, by: DVec3) -> bool {
        let corners = |party: &PairMember, t: u32| party.triangle(t).nodes.map(|i| party.sheet.start.get(i as usize));
        triangles_intersect(corners(&self.a, ta).map(|x| x + by), corners(&self.b, tb))
    }

    /// Whether features with these nodes are neighbours in one sheet; `size` is that of its
    /// triangles, m.
    fn are_neighbours(&self, p: &[u32], q: &[u32], size: f64) -> bool {
        self.is_self() && self.a.sheet.skin.is_rest_distance_below(p, q, self.limits.offset + size)
    }

    /// Whether features with these nodes belong to one region of one sheet, which can bend but not
    /// touch itself.
    fn is_same_region(&self, p: &[u32], q: &[u32], size: f64) -> bool {
        let reach = SETTINGS.neighbour_factor * (self.limits.offset + size);
        self.is_self() && self.a.sheet.skin.is_rest_distance_below(p, q, reach)
    }

    fn detect_node_triangle(
        &self,
        (of, p): (&PairMember, &SurfaceTriangle),
        (on, t, q): (&PairMember, u32, &SurfaceTriangle),
        constraints: &mut Vec<ContactConstraint>,
    ) {
        for mass in (0..3).filter(|k| p.owns_node[*k]).map(|k| p.nodes[k]) {
            let close = of.tree.node_box(mass).overlaps(on.tree.triangle_box(t));
            if !close || self.are_neighbours(&[mass], &q.nodes, q.size) {
                continue;
            }
            let Some((normal, weights)) = self.node_triangle_contact((of, mass), on, q) else { continue };
            let (kind, feature) = match weights.map(|w| w == 0.0) {
                [true, true, _] => (FeatureKind::Node, q.nodes[2]),
                [true, _, true] => (FeatureKind::Node, q.nodes[1]),
                [_, true, true] => (FeatureKind::Node, q.nodes[0]),
                [true, _, _] => (FeatureKind::SheetEdge, q.edges[1]),
                [_, true, _] => (FeatureKind::SheetEdge, q.edges[2]),
                [_, _, true] => (FeatureKind::SheetEdge, q.edges[0]),
                _ => (FeatureKind::Triangle, t),
            };
            let under = SheetPoint { nodes: q.nodes, weights };
            constraints.push(self.constraint(
                (of, SheetPoint::node(mass), FeatureKind::Node, mass),
                (on, under, kind, feature),
                normal,
            ));
        }
    }

    fn constraint(
        &self,
        (a, p, kind_a, index_a): (&PairMember, SheetPoint, FeatureKind, u32),
        (b, q, kind_b, index_b): (&PairMember, SheetPoint, FeatureKind, u32),
        normal: DVec3,
    ) -> ContactConstraint {
        ContactConstraint {
            a: ContactSide::Sheet { sheet: a.index, point: p },
            b: ContactSide::Sheet { sheet: b.index, point: q },
            normal,
            offset: self.half_thickness_along((a, kind_a, index_a), normal)
                + self.half_thickness_along((b, kind_b, index_b), normal),
            key: [feature_key(kind_a, a.sheet.id, index_a), feature_key(kind_b, b.sheet.id, index_b)],
            friction: self.coefficients.0,
            restitution: self.coefficients.1,
            bond: 0.0,
            compressed: None,
        }
    }

    /// Half thickness (m) of a sheet along `normal` at a feature of its mid-surface. Within one
    /// sheet it ends flat at the border: the two sides of a cut lie side by side without a gap, and
    /// a round border would hold them apart by one thickness.
    fn half_thickness_along(&self, (party, kind, index): (&PairMember, FeatureKind, u32), normal: DVec3) -> f64 {
        let half = 0.5 * self.limits.offset;
        let across = match kind {
            _ if !self.is_self() => return half,
            FeatureKind::SheetEdge if party.edge(index).is_border() => {
                party.tree.edge_normal(party.edge(index).triangles)
            }
            FeatureKind::Node if party.sheet.skin.on_border(index) => party.tree.node_normal(index as usize),
            _ => return half,
        };
        half * normal.dot(across).abs()
    }

    /// Whether features that are `gap` (m) apart at the base cannot come near by the end.
    fn out_of_reach(&self, gap: f64) -> bool {
        let reach = self.limits.offset + self.limits.margin;
        gap - reach > self.a.tree.travel + self.b.tree.travel
    }

    /// Normal and barycentric weights of the contact of a node with a triangle.
    fn node_triangle_contact(
        &self,
        (of, mass): (&PairMember, u32),
        on: &PairMember,
        q: &SurfaceTriangle,
    ) -> Option<(DVec3, [f64; 3])> {
        let base = of.sheet.base.get(mass as usize);
        let b = q.nodes.map(|i| on.sheet.base.get(i as usize));
        let w = point_triangle(base, b);
        let gap = base - interpolate(b, w);
        if self.out_of_reach(gap.length()) {
            return None;
        }
        let [[start], _, [end]] = of.positions([mass]);
        let [s, _, e] = on.positions(q.nodes);
        let afar = || self.node_contact_from_motion((start, end), (s, e));
        if gap.length() > self.limits.base_distance() {
            return afar();
        }
        let near = self.node_contact_from_base((of, mass), (base, gap, w), (on, q, b), (start, end), (s, e));
        near.or_else(|| {
            if self.may_pass_within_stage(|| self.is_same_region(&[mass], &q.nodes, q.size)) { afar() } else { None }
        })
    }

    /// Whether features that are near at the base may pass each other within the stage. Features of
    /// the same region do not, and constraints between them would resist bending.
    fn may_pass_within_stage(&self, kin: impl Fn() -> bool) -> bool {
        self.a.tree.travel + self.b.tree.travel > SETTINGS.fast_motion * self.limits.offset && !kin()
    }

    /// Contact of a node that is near a triangle at the base: the node is at `base`, `gap` from the
    /// point with the weights `w` of the triangle `b`.
    fn node_contact_from_base(
        &self,
        (of, mass): (&PairMember, u32),
        (base, gap, w): (DVec3, DVec3, [f64; 3]),
        (on, q, b): (&PairMember, &SurfaceTriangle, [DVec3; 3]),
        (start, end): (DVec3, DVec3),
        (s, e): ([DVec3; 3], [DVec3; 3]),
    ) -> Option<(DVec3, [f64; 3])> {
        let reach = self.limits.offset + self.limits.margin;
        let plane = unit_normal(b)?;
        if barycentric_along(base, plane, b).and_then(clamp_weights).is_some() {
            let mut height = gap.dot(plane);
            if height.abs() < SETTINGS.undetermined_side_height * self.limits.offset {
                // A pair within the tolerance takes its side from the start of the stage.
                height = (start - s[0]).dot(unit_normal(s)?);
            }
            // A pair that is coincident at the start as well has no defined side, such as two
            // sheets created in the same place.
            if height.abs() < SETTINGS.undetermined_side_height * self.limits.offset {
                return None;
            }
            let normal = if height >= 0.0 { plane } else { -plane };
            let w = clamp_weights(barycentric_along(end, normal, e)?)?;
            return (normal.dot(end - interpolate(e, w)) <= reach).then_some((normal, w));
        }
        // Beside the triangle the pair counts only at a border or a ridge.
        if gap.length() < 0.1 * self.limits.offset || !self.is_edge_feature(on, q, w, gap) {
            return None;
        }
        let mut direction = gap.normalize_or_zero();
        // A node inside a sheet is touched along the normal of its surface: an oblique constraint
        // would stop a sheet that slides over it.
        if !of.sheet.skin.on_border(mass) {
            let across = of.tree.node_normal(mass as usize);
            let cosine = direction.dot(across);
            if cosine.abs() < SETTINGS.same_direction_cosine {
                return None;
            }
            direction = across * cosine.signum();
        }
        let w_end = point_triangle(end, e);
        let last = (end - interpolate(e, w_end)).normalize_or_zero();
        let w = if last.dot(direction) > 0.8 { w_end } else { w };
        (direction.dot(end - interpolate(e, w)) <= reach).then_some((direction, w))
    }

    /// Whether the closest point (weights `w`) of triangle `q` lies on a border or a ridge, from
    /// which the sheet leads away from a point at `gap`.
    fn is_edge_feature(&self, on: &PairMember, q: &SurfaceTriangle, w: [f64; 3], gap: DVec3) -> bool {
        let side = match w.map(|x| x == 0.0) {
            [true, false, false] => 1,
            [false, true, false] => 2,
            [false, false, true] => 0,
            _ => {
                let corner = (0..3).find(|i| w[*i] != 0.0).unwrap_or(0);
                return on.sheet.skin.on_border(q.nodes[corner]) && {
                    // Both sides at the corner must fall away. A border beyond one of them belongs
                    // to another triangle.
                    let corner_edges = [q.edges[corner], q.edges[(corner + 2) % 3]];
                    corner_edges.iter().all(|e| {
                        let edge = on.edge(*e);
                        edge.is_border() || on.flanks(edge).all(|f| f.dot(gap) <= 1e-3 * f.length() * gap.length())
                    })
                };
            }
        };
        let edge = on.edge(q.edges[side]);
        edge.is_border() || on.flanks(edge).all(|f| f.dot(gap) <= 1e-3 * f.length() * gap.length())
    }

    fn node_contact_from_motion(
        &self,
        (start, end): (DVec3, DVec3),
        (s, e): ([DVec3; 3], [DVec3; 3]),
    ) -> Option<(DVec3, [f64; 3])> {
        let four = |p: DVec3, [a, b, c]: [DVec3; 3]| [p, a, b, c];
        let reach = self.limits.offset + self.limits.margin;
        if let Some(hit) =
            point_meets_triangle(four(start, s), four(end, e), DETECTION.impact_distance_tolerance * self.limits.half)
        {
            let there = [0, 1, 2].map(|i: usize| s[i].lerp(e[i], hit.time));
            let plane = unit_normal(there)?;
            let approach = (end - start) - (interpolate(e, hit.weights) - interpolate(s, hit.weights));
            let normal = if approach.dot(plane) <= 0.0 { plane } else { -plane };
            let w = barycentric_along(end, normal, e).and_then(clamp_weights).unwrap_or(hit.weights);
            return (normal.dot(end - interpolate(e, w)) <= reach).then_some((normal, w));
        }
        let (before, plane) = (unit_normal(s)?, unit_normal(e)?);
        let w = clamp_weights(barycentric_along(end, plane, e)?)?;
        let (height, was) = (plane.dot(end - interpolate(e, w)), before.dot(start - s[0]));
        // A node on the other side of the plane has come around the triangle or through a
        // neighbour; this pair gives no contact.
        (height.abs() <= reach && height * was > 0.0).then(|| (if was > 0.0 { plane } else { -plane }, w))
    }

    fn detect_edge_edge(&self, number_a: u32, number_b: u32, size: f64, constraints: &mut Vec<ContactConstraint>) {
        let (edge_a, edge_b) = (self.a.edge(number_a), self.b.edge(number_b));
        let around = |party: &PairMember, [i, j]: [u32; 2]| party.tree.node_box(i).joined(party.tree.node_box(j));
        let close = around(&self.a, edge_a.nodes).overlaps(&around(&self.b, edge_b.nodes));
        if !close || self.are_neighbours(&edge_a.nodes, &edge_b.nodes, size) {
            return;
        }
        let Some(found) = self.edge_contact((number_a, edge_a), (number_b, edge_b), size) else { return };
        let near_end = |x: f64| !(SETTINGS.end_fraction..=1.0 - SETTINGS.end_fraction).contains(&x);
        // Near its end an edge is represented by its node, whose own constraint acts along the
        // normal of the other sheet, unless the node lies beside that sheet.
        if near_end(found.s) && self.b.meets_along(edge_b, self.a.nearest_end(edge_a, found.s), found.normal)
            || near_end(found.t) && self.a.meets_along(edge_a, self.b.nearest_end(edge_b, found.t), found.normal)
        {
            return;
        }
        let (p, kind_a, index_a) = on_edge(edge_a.nodes, found.s, number_a);
        let (q, kind_b, index_b) = on_edge(edge_b.nodes, found.t, number_b);
        constraints.push(self.constraint((&self.a, p, kind_a, index_a), (&self.b, q, kind_b, index_b), found.normal));
    }

    /// Contact of two edges of triangles of this `size`, m.
    fn edge_contact(&self, one: (u32, &SurfaceEdge), other: (u32, &SurfaceEdge), size: f64) -> Option<EdgeContact> {
        let ([_, b, _], [_, c, _]) = (self.a.positions(one.1.nodes), self.b.positions(other.1.nodes));
        let (k, l) = segment_segment(b, c);
        let gap = b[0].lerp(b[1], k) - c[0].lerp(c[1], l);
        if self.out_of_reach(gap.length()) {
            return None;
        }
        let afar = || self.edge_contact_from_motion(one, other);
        if gap.length() > self.limits.base_distance() {
            return afar();
        }
        let near = self.edge_contact_from_base(one, other, gap, (k, l));
        let kin = || self.is_same_region(&one.1.nodes, &other.1.nodes, size);
        near.or_else(|| if self.may_pass_within_stage(kin) { afar() } else { None })
    }

    /// Contact of two edges that are near at the base, `gap` (m) apart at the parameters `k` and
    /// `l`.
    fn edge_contact_from_base(
        &self,
        one: (u32, &SurfaceEdge),
        other: (u32, &SurfaceEdge),
        gap: DVec3,
        (k, l): (f64, f64),
    ) -> Option<EdgeContact> {
        let ([s, b, _], [u, c, _]) = (self.a.positions(one.1.nodes), self.b.positions(other.1.nodes));
        let before = s[0].lerp(s[1], k) - u[0].lerp(u[1], l);
        let facing = || [self.a.edge_orientation(one.1), self.b.edge_orientation(other.1)];
        let beside = |normal: DVec3| {
            gap.reject_from_normalized(normal).length()
                > 0.5 * gap.length() + DETECTION.rounding_distance * self.limits.half
        };
        let normal = self.normal((one.1, b[1] - b[0]), (other.1, c[1] - c[0]));
        let usual = normal.filter(|normal| !beside(*normal)).and_then(|normal| {
            let side = if normal.dot(gap).abs() > DETECTION.rounding_distance * self.limits.half {
                normal.dot(gap)
            } else {
                normal.dot(before)
            };
            self.edge_contact_at_end(one, other, (if side >= 0.0 { normal } else { -normal }, facing), None)
        });
        usual.or_else(|| {
            let normal =
                self.nearly_parallel_normal((one.1, b[1] - b[0]), (other.1, c[1] - c[0]), [gap, before], facing)?;
            self.edge_contact_at_end(one, other, (normal, facing), Some((k, l)))
        })
    }

    /// Contact of two edges along this normal, provided that both stand out along it, admit it by
    /// their orientation and are near at the end. The parameters are those of the points above each
    /// other at the end, otherwise `met`.
    fn edge_contact_at_end(
        &self,
        (number_a, edge_a): (u32, &SurfaceEdge),
        (number_b, edge_b): (u32, &SurfaceEdge),
        (normal, facing): (DVec3, impl Fn() -> [EdgeOrientation; 2]),
        met: Option<(f64, f64)>,
    ) -> Option<EdgeContact> {
        let ([s, _, e], [u, _, f]) = (self.a.positions(edge_a.nodes), self.b.positions(edge_b.nodes));
        let out = self.a.ridge_height(number_a, normal).min(self.b.ridge_height(number_b, -normal));
        if out < SETTINGS.flat_ridge_height * self.limits.offset {
            return None;
        }
        let (k, l) = facing_parameters(e, f, normal).or(met)?;
        let gap = normal.dot(e[0].lerp(e[1], k) - f[0].lerp(f[1], l));
        let before = normal.dot(s[0].lerp(s[1], k) - u[0].lerp(u[1], l));
        let reach = self.limits.offset + self.limits.margin;
        let faces = || {
            let [one, other] = facing();
            one.admits(normal) && other.admits(-normal)
        };
        (gap <= reach && before >= -self.limits.max_start_penetration && faces()).then_some(EdgeContact {
            normal,
            s: k,
            t: l,
        })
    }

    /// Contact of two edges that are far apart at the base: at the time of impact, or at the end if
    /// they approach without crossing.
    fn edge_contact_from_motion(&self, one: (u32, &SurfaceEdge), other: (u32, &SurfaceEdge)) -> Option<EdgeContact> {
        let ((_, edge_a), (_, edge_b)) = (one, other);
        let ([s, _, e], [u, _, f]) = (self.a.positions(edge_a.nodes), self.b.positions(edge_b.nodes));
        if let Some(hit) = edges_meet(
            [s[0], s[1], u[0], u[1]],
            [e[0], e[1], f[0], f[1]],
            DETECTION.impact_distance_tolerance * self.limits.half,
        ) {
            let there = |x: [DVec3; 2], y: [DVec3; 2]| x[1].lerp(y[1], hit.time) - x[0].lerp(y[0], hit.time);
            let (along_a, along_b) = (there(s, e), there(u, f));
            let moved = |x: [DVec3; 2], y: [DVec3; 2], w: f64| y[0].lerp(y[1], w) - x[0].lerp(x[1], w);
            let approach = moved(s, e, hit.s) - moved(u, f, hit.t);
            let met = (!self.is_self()).then_some((hit.s, hit.t));
            let facing =
                || [self.a.edge_orientation_at(edge_a, hit.time), self.b.edge_orientation_at(edge_b, hit.time)];
            let usual = self.normal((edge_a, along_a), (edge_b, along_b)).and_then(|normal| {
                let normal = if approach.dot(normal) <= 0.0 { normal } else { -normal };
                self.edge_contact_at_end(one, other, (normal, facing), met)
            });
            return usual.or_else(|| {
                let normal = self.nearly_parallel_normal((edge_a, along_a), (edge_b, along_b), [-approach], facing)?;
                self.edge_contact_at_end(one, other, (normal, facing), met)
            });
        }
        let (k, l) = segment_segment(e, f);
        let gap = e[0].lerp(e[1], k) - f[0].lerp(f[1], l);
        if gap.length() > self.limits.offset + self.limits.margin {
            return None;
        }
        let normal = self.normal((edge_a, e[1] - e[0]), (edge_b, f[1] - f[0]))?;
        let side = normal.dot(gap);
        let before = normal.dot(s[0].lerp(s[1], k) - u[0].lerp(u[1], l));
        if side * before <= 0.0 {
            return None;
        }
        let facing = || [self.a.edge_orientation_at(edge_a, 1.0), self.b.edge_orientation_at(edge_b, 1.0)];
        self.edge_contact_at_end(one, other, (if side > 0.0 { normal } else { -normal }, facing), None)
    }

    /// Normal of two nearly parallel borders or ridges along `u` and `v` whose surface normals do
    /// not determine it: the first of `gaps` that is long enough, otherwise, for two borders, the
    /// direction out of both sheets.
    fn nearly_parallel_normal<const N: usize>(
        &self,
        (edge_a, u): (&SurfaceEdge, DVec3),
        (edge_b, v): (&SurfaceEdge, DVec3),
        gaps: [DVec3; N],
        facing: impl Fn() -> [EdgeOrientation; 2],
    ) -> Option<DVec3> {
        let (u, v) = (u.normalize_or_zero(), v.normalize_or_zero());
        let is_askew = (EDGE_EDGE.parallel_sine..EDGE_EDGE.nearly_parallel_sine).contains(&u.cross(v).length());
        if self.is_self() || !is_askew {
            return None;
        }
        let both_end = edge_a.is_border() && edge_b.is_border();
        let least = SETTINGS.undetermined_side_height * self.limits.offset;
        let apart = gaps.into_iter().map(|gap| gap.reject_from_normalized(u)).find(|gap| gap.length() > least);
        // Sheets that lie over each other have node constraints there; an oblique edge constraint
        // would contradict them.
        let lies_over = |gap: &DVec3| {
            let [one, other] = facing();
            one.sides[0].dot(other.sides[0]).abs() > SETTINGS.same_direction_cosine
                && gap.dot(one.sides[0]).abs() > SETTINGS.lying_over_height * self.limits.offset
        };
        if apart.as_ref().is_some_and(lies_over) {
            return None;
        }
        let outward = || {
            let [one, other] = facing();
            (one.flanks[0] - other.flanks[0]).reject_from_normalized(u)
        };
        apart.or_else(|| both_end.then(outward))?.try_normalize()
    }

    /// Normal of two edges along `u` and `v`, of either sign; `None` for parallel edges.
    fn normal(&self, (edge_a, u): (&SurfaceEdge, DVec3), (edge_b, v): (&SurfaceEdge, DVec3)) -> Option<DVec3> {
        let across = u.normalize_or_zero().cross(v.normalize_or_zero());
        let sine = across.length();
        if sine >= EDGE_EDGE.nearly_parallel_sine {
            return Some(across / sine);
        }
        if sine < EDGE_EDGE.parallel_sine {
            return None;
        }
        let (m, n) = (self.a.tree.edge_normal(edge_a.triangles), self.b.tree.edge_normal(edge_b.triangles));
        let mean = if m.dot(n) < 0.0 { m - n } else { m + n };
        mean.reject_from_normalized(u.normalize_or_zero()).try_normalize()
    }
}

fn unit_normal([a, b, c]: [DVec3; 3]) -> Option<DVec3> {
    (b - a).cross(c - a).try_normalize()
}
