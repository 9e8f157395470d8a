//! Positions of a sheet in the frame of a body, and constraints between the two.

use glam::DVec3;

use crate::collision::bvh::{BoundingBox, SurfaceTree};
use crate::collision::collision_surface::{CollisionSurface, SurfaceEdge};
use crate::collision::constraint::{ContactConstraint, ContactSide, SheetPoint};
use crate::collision::narrow_phase::edge_edge::EdgeOrientation;
use crate::collision::narrow_phase::feature_keys::{FeatureKind, feature_key};
use crate::collision::narrow_phase::{BodyStageMotion, DetectionDistances, DetectionInput, SheetStageMotion};
use crate::collision::settings::DetectionSettings;
use crate::math::{RigidFrame, Vectors};

const SETTINGS: DetectionSettings = DetectionSettings::DEFAULT;

/// Positions of the nodes in the frame of the body at start, base and end, m.
#[derive(Default)]
pub(crate) struct BodyFramePositions {
    pub start: Vec<DVec3>,
    pub base: Vec<DVec3>,
    pub end: Vec<DVec3>,
    /// Bounding box of all positions.
    pub around: BoundingBox,
    /// Whether the base was accepted by the contact solver in an earlier outer iteration of the
    /// stage.
    pub has_accepted: bool,
}

impl BodyFramePositions {
    pub fn load(&mut self, sheet: &SheetStageMotion, body: &BodyStageMotion) {
        let seen = |to: &mut Vec<DVec3>, x: &Vectors, frame: &RigidFrame| {
            to.clear();
            let turn = frame.rotation.transpose();
            to.extend(x.iter().map(|p| turn * (p - frame.origin)));
        };
        seen(&mut self.start, sheet.start, &body.start);
        seen(&mut self.base, sheet.base, &body.base);
        seen(&mut self.end, sheet.end, &body.end);
        let all = self.start.iter().chain(&self.base).chain(&self.end);
        self.around = BoundingBox::from(crate::collision::narrow_phase::box_of(all.copied()));
        self.has_accepted = !std::ptr::eq(sheet.base, sheet.start);
    }

    /// Position of node `i` accepted by the contact solver; before that its position at the end, m.
    pub fn accepted(&self, i: usize) -> DVec3 {
        if self.has_accepted { self.base[i] } else { self.end[i] }
    }

    /// Positions of nodes at start, base and end, m.
    pub fn positions<const N: usize>(&self, masses: [u32; N]) -> [[DVec3; N]; 3] {
        [&self.start, &self.base, &self.end].map(|x| masses.map(|i| x[i as usize]))
    }
}

/// A sheet and one part of a collider.
pub(crate) struct SheetBodyPair<'a> {
    pub skin: &'a CollisionSurface,
    pub offset: f64,
    pub margin: f64,
    /// Half thickness of the sheet, m.
    pub half: f64,
    fall: f64,
    base: RigidFrame,
    end: RigidFrame,
    start: RigidFrame,
    sheet: (u32, u32),
    body: (u32, u32),
    first: u32,
    friction: f64,
    restitution: f64,
}

impl<'a> SheetBodyPair<'a> {
    /// Pair of a sheet and a part of a body, with their indices in the detection input, the number
    /// of the part's first feature, and the coefficients of friction and restitution.
    pub fn new(
        problem: &DetectionInput,
        (s, sheet): (u32, &SheetStageMotion<'a>),
        (b, body): (u32, &BodyStageMotion),
        first: u32,
        (friction, restitution): (f64, f64),
    ) -> Self {
        Self {
            skin: sheet.skin,
            offset: sheet.skin.contact_offset(),
            margin: problem.margin,
            half: sheet.skin.half_thickness(),
            fall: problem.fall,
            start: body.start,
            base: body.base,
            end: body.end,
            sheet: (s, sheet.id),
            body: (b, body.id),
            first,
            friction,
            restitution,
        }
    }

    /// Distances of detection for a solid of this least width, m.
    pub fn limits(&self, thinness: f64) -> DetectionDistances {
        let deep = (SETTINGS.maximum_initial_overlap * self.half).min(0.4 * (thinness + 2.0 * self.offset));
        DetectionDistances {
            offset: self.offset,
            margin: self.margin,
            max_start_penetration: deep,
            half: self.half,
            fall: self.fall,
        }
    }

    /// Direction in the frame of the body at the base, from world axes.
    pub fn at_base(&self, direction: DVec3) -> DVec3 {
        self.base.local_direction(direction)
    }

    /// Direction in the frame of the body at the end, from world axes.
    pub fn at_end(&self, direction: DVec3) -> DVec3 {
        self.end.local_direction(direction)
    }

    /// Rotate positions in the frame of the body at start, base and end into world axes, as seen by
    /// an observer that translates with the body but does not rotate.
    pub fn in_world_axes<const N: usize>(&self, [start, base, end]: [[DVec3; N]; 3]) -> [[DVec3; N]; 3] {
        [(start, &self.start), (base, &self.base), (end, &self.end)].map(|(x, frame)| x.map(|p| frame.direction(p)))
    }

    /// Orientation of an edge of the sheet at the base, in the frame of the body.
    pub fn orientation_at_base(
        &self,
        edge: &SurfaceEdge,
        tree: &SurfaceTree,
        local: &BodyFramePositions,
    ) -> EdgeOrientation {
        let sides = tree.edge_normals(edge.triangles).map(|n| self.at_base(n));
        self.edge_orientation(edge, sides, &local.base)
    }

    /// Orientation of an edge of the sheet at the start, in the frame of the body.
    pub fn orientation_at_start(&self, edge: &SurfaceEdge, local: &BodyFramePositions) -> EdgeOrientation {
        let normal = |[p, q, r]: [DVec3; 3]| (q - p).cross(r - p).normalize_or_zero();
        self.edge_orientation(edge, self.triangles_at(edge, &local.start).map(normal), &local.start)
    }

    fn edge_orientation(&self, edge: &SurfaceEdge, sides: [DVec3; 2], x: &[DVec3]) -> EdgeOrientation {
        let [a, b] = edge.nodes.map(|i| x[i as usize]);
        let along = (b - a).normalize_or(DVec3::X);
        let flank = |corners: [DVec3; 3]| {
            let middle = corners.into_iter().sum::<DVec3>() / 3.0;
            (middle - a).reject_from_normalized(along).normalize_or_zero()
        };
        EdgeOrientation { sides, flanks: self.triangles_at(edge, x).map(flank), is_border: edge.is_border() }
    }

    /// Corners of the two triangles at an edge; at the border those of the only one, twice.
    fn triangles_at(&self, edge: &SurfaceEdge, x: &[DVec3]) -> [[DVec3; 3]; 2] {
        let [first, second] = edge.triangles;
        let both = [first, if edge.is_border() { first } else { second }];
        both.map(|t| self.skin.triangles()[t as usize].nodes.map(|i| x[i as usize]))
    }

    /// World box swept by the box from `low` to `high` of the frame of the body.
    pub fn swept(&self, low: DVec3, high: DVec3) -> BoundingBox {
        let own = BoundingBox::from((low, high));
        own.placed(&self.start).joined(&own.placed(&self.end))
    }

    /// Key of feature `index` of the sheet.
    pub fn sheet_feature(&self, kind: FeatureKind, index: u32) -> u64 {
        feature_key(kind, self.sheet.1, index)
    }

    /// Constraint of a point of the sheet (with kind and index of its feature) with the point
    /// `local` of a feature of the body, along `normal`, both in the frame of the body.
    pub fn constraint(
        &self,
        (point, kind, index): (SheetPoint, FeatureKind, u32),
        (local, body_kind, body_index): (DVec3, FeatureKind, u32),
        normal: DVec3,
    ) -> ContactConstraint {
        ContactConstraint {
            a: ContactSide::Sheet { sheet: self.sheet.0, point },
            b: ContactSide::Body { body: self.body.0, local },
            normal: self.end.direction(normal),
            offset: self.offset,
            key: [self.sheet_feature(kind, index), feature_key(body_kind, self.body.1, self.first + body_index)],
            friction: self.friction,
            restitution: self.restitution,
            bond: 0.0,
            compressed: None,
        }
    }
}
