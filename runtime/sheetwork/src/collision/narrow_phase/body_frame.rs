//! A sheet seen from a body, and how a row against that body is written down.

use glam::DVec3;

use crate::collision::bvh::{Cuboid, SkinTree};
use crate::collision::collision_surface::{Skin, SkinEdge};
use crate::collision::constraint::{Contact, SheetPoint, Side};
use crate::collision::narrow_phase::edge_edge::Facing;
use crate::collision::narrow_phase::feature_keys::{Kind, name};
use crate::collision::narrow_phase::{BodyMotion, DEEP, Limits, Problem, SheetMotion};
use crate::math::RigidFrame;
use crate::math::Vectors;

/// Places of the masses in the body's frame at the three times, m.
#[derive(Default)]
pub(crate) struct Local {
    pub start: Vec<DVec3>,
    pub base: Vec<DVec3>,
    pub end: Vec<DVec3>,
    /// Box around all of them.
    pub around: Cuboid,
    /// Whether the base is where contact has put the sheet in an earlier round of the stage.
    pub placed: bool,
}

impl Local {
    pub fn load(&mut self, sheet: &SheetMotion, body: &BodyMotion) {
        let seen = |to: &mut Vec<DVec3>, x: &Vectors, frame: &RigidFrame| {
            to.clear();
            let turn = frame.rotation.transpose();
            to.extend(x.iter().map(|p| turn * (p - frame.origin)));
        };
        seen(&mut self.start, sheet.start, &body.start);
        seen(&mut self.base, sheet.base, &body.base);
        seen(&mut self.end, sheet.end, &body.end);
        let all = self.start.iter().chain(&self.base).chain(&self.end);
        self.around = Cuboid::from(crate::collision::narrow_phase::box_of(all.copied()));
        self.placed = !std::ptr::eq(sheet.base, sheet.start);
    }

    /// Where contact has put mass `i` in an earlier round; where it would be now before that.
    pub fn put(&self, i: usize) -> DVec3 {
        if self.placed { self.base[i] } else { self.end[i] }
    }

    /// The places of some masses at the three times.
    pub fn of<const N: usize>(&self, masses: [u32; N]) -> [[DVec3; N]; 3] {
        [&self.start, &self.base, &self.end].map(|x| masses.map(|i| x[i as usize]))
    }
}

/// A sheet and a piece of a body.
pub(crate) struct Meeting<'a> {
    pub skin: &'a Skin,
    pub offset: f64,
    pub margin: f64,
    base: RigidFrame,
    end: RigidFrame,
    start: RigidFrame,
    sheet: (u32, u32),
    body: (u32, u32),
    first: u32,
    friction: f64,
    restitution: f64,
}

impl<'a> Meeting<'a> {
    /// Sheet and body with their places in the problem, the number of the piece's first feature, and the coefficients of
    /// friction and restitution.
    pub fn new(
        problem: &Problem,
        (s, sheet): (u32, &SheetMotion<'a>),
        (b, body): (u32, &BodyMotion),
        first: u32,
        (friction, restitution): (f64, f64),
    ) -> Self {
        Self {
            skin: sheet.skin,
            offset: sheet.skin.offset(),
            margin: problem.margin,
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

    /// What counts as close for a solid of this least width, m.
    pub fn limits(&self, thinness: f64) -> Limits {
        let deep = DEEP.min(0.4 * (thinness + 2.0 * self.offset));
        Limits { offset: self.offset, margin: self.margin, deep }
    }

    /// A direction of the world, at the base, in the body's frame.
    pub fn at_base(&self, direction: DVec3) -> DVec3 {
        self.base.local_direction(direction)
    }

    /// A direction of the world in the body's frame at the end.
    pub fn at_end(&self, direction: DVec3) -> DVec3 {
        self.end.local_direction(direction)
    }

    /// What is seen in the body's frame at the three times, in the world's axes: as from a point of the body that goes along with it
    /// and does not turn.
    pub fn in_axes_of_the_world<const N: usize>(&self, [start, base, end]: [[DVec3; N]; 3]) -> [[DVec3; N]; 3] {
        [(start, &self.start), (base, &self.base), (end, &self.end)].map(|(x, frame)| x.map(|p| frame.direction(p)))
    }

    /// From which directions an edge of the sheet can be touched at the base, in the body's frame.
    pub fn side_of(&self, edge: &SkinEdge, tree: &SkinTree, local: &Local) -> Facing {
        let sides = tree.edge_normals(edge.triangles).map(|n| self.at_base(n));
        self.facing(edge, sides, &local.base)
    }

    /// The same at the start.
    pub fn side_before(&self, edge: &SkinEdge, local: &Local) -> Facing {
        let normal = |[p, q, r]: [DVec3; 3]| (q - p).cross(r - p).normalize_or_zero();
        self.facing(edge, self.triangles_at(edge, &local.start).map(normal), &local.start)
    }

    fn facing(&self, edge: &SkinEdge, sides: [DVec3; 2], x: &[DVec3]) -> Facing {
        let [a, b] = edge.masses.map(|i| x[i as usize]);
        let along = (b - a).normalize_or(DVec3::X);
        let flank = |corners: [DVec3; 3]| {
            let middle = corners.into_iter().sum::<DVec3>() / 3.0;
            (middle - a).reject_from_normalized(along).normalize_or_zero()
        };
        Facing { sides, flanks: self.triangles_at(edge, x).map(flank), is_border: edge.is_border() }
    }

    /// The corners of the two triangles at an edge; at the border of the one there is, twice.
    fn triangles_at(&self, edge: &SkinEdge, x: &[DVec3]) -> [[DVec3; 3]; 2] {
        let [first, second] = edge.triangles;
        let both = [first, if edge.is_border() { first } else { second }];
        both.map(|t| self.skin.triangles()[t as usize].masses.map(|i| x[i as usize]))
    }

    /// Box in the world that points of the body's frame within the box from `low` to `high` sweep.
    pub fn swept(&self, low: DVec3, high: DVec3) -> Cuboid {
        let own = Cuboid::from((low, high));
        own.placed(&self.start).joined(&own.placed(&self.end))
    }

    /// The name of feature number `index` of the sheet.
    pub fn sheet_feature(&self, kind: Kind, index: u32) -> u64 {
        name(kind, self.sheet.1, index)
    }

    /// The row of a point of the sheet (named by kind and number) against the point `local` of the body's feature, along the
    /// normal `normal` of the body's frame.
    pub fn row(
        &self,
        (point, kind, index): (SheetPoint, Kind, u32),
        (local, body_kind, body_index): (DVec3, Kind, u32),
        normal: DVec3,
    ) -> Contact {
        Contact {
            a: Side::Sheet { sheet: self.sheet.0, point },
            b: Side::Body { body: self.body.0, local },
            normal: self.end.direction(normal),
            offset: self.offset,
            key: [self.sheet_feature(kind, index), name(body_kind, self.body.1, self.first + body_index)],
            friction: self.friction,
            restitution: self.restitution,
        }
    }
}
