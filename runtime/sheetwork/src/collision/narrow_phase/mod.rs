//! Collision detection of a stage: contact constraints between features of sheets and bodies.
//!
//! A stage moves the nodes from `start`, where nothing overlaps, to `end`, the result of the
//! present iteration; `base` is the latest state that the contact solver has accepted. A constraint
//! is made for each pair of features that at `end` is nearer than contact offset plus margin, or
//! that has crossed during the motion. Its normal is that of the closest features at `base` if the
//! pair is close there, otherwise that at the time of impact. The normal of a resting contact
//! therefore depends neither on the depth of the free motion nor on the shortest way out. Pairs
//! with a body are computed in the frame of the body, in which its features are constant. Lengths
//! in m.
//!
//! Pairs: nodes on faces (`vertex_face`), sheet edges on sharp convex edges (`edge_edge`), convex
//! corners on triangles (`corner_triangle`), triangles on balls (`triangle_ball`), and nodes on
//! triangles and edges on edges of sheets (`triangle_pairs`). The broad phase compares bounding
//! boxes of sheets and bodies, then bounding volume hierarchies over triangles.

pub(crate) mod body_frame;
pub(crate) mod corner_triangle;
pub(crate) mod duplicates;
pub(crate) mod edge_edge;
pub(crate) mod feature_keys;
pub(crate) mod height_graph;
pub(crate) mod sheet_pairs;
#[cfg(test)]
mod tests;
pub(crate) mod triangle_ball;
pub(crate) mod triangle_pairs;
pub(crate) mod vertex_face;

use glam::DVec3;
use rapier3d::parry::partitioning::BvhWorkspace;

use crate::collision::bvh::{BoundingBox, FrameMotion, SurfaceTree};
use crate::collision::collision_surface::CollisionSurface;
use crate::collision::constraint::{ContactConstraint, ContactKey};
use crate::collision::features::{ColliderFeatures, ColliderPart};
use crate::collision::narrow_phase::body_frame::{BodyFramePositions, SheetBodyPair};
pub(crate) use crate::collision::narrow_phase::feature_keys::{
    attachment_key, feature_owner, is_ball_contact, is_node_surface_contact, layer_key, without_sheet,
};
use crate::collision::narrow_phase::height_graph::remains_height_graph;
use crate::collision::narrow_phase::sheet_pairs::{SheetPairDetector, box_margin, sheet_pair};
use crate::collision::settings::DetectionSettings;
use crate::math::{RigidFrame, Vectors};
use crate::serialize::{ReadResult, State, StateReader, StateWriter, state};

const SETTINGS: DetectionSettings = DetectionSettings::DEFAULT;

/// Motion of a sheet over a stage.
#[derive(Clone, Copy)]
pub struct SheetStageMotion<'a> {
    /// Identifier of the sheet, constant between steps; below 2²⁴.
    pub id: u32,
    /// Collision surface.
    pub skin: &'a CollisionSurface,
    /// Positions of the nodes at the start of the stage, m.
    pub start: &'a Vectors,
    /// Positions last accepted by the contact solver, m; `start` before that.
    pub base: &'a Vectors,
    /// Positions at the end of the stage without further contact forces, m.
    pub end: &'a Vectors,
    /// Whether the sheet is stepped. A sleeping sheet is tested only against moving ones.
    pub awake: bool,
}

/// Motion of a body's collider over a stage.
#[derive(Clone, Copy)]
pub struct BodyStageMotion<'a> {
    /// Identifier of the body, constant between steps; below 2²⁴.
    pub id: u32,
    /// Features of the collider.
    pub features: &'a ColliderFeatures,
    /// Frame at the start of the stage.
    pub start: RigidFrame,
    /// Frame last accepted by the contact solver.
    pub base: RigidFrame,
    /// Frame at the end of the stage.
    pub end: RigidFrame,
    /// Whether the body moves.
    pub awake: bool,
}

/// A pair that may touch, by indices of the detection input.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ContactPair {
    /// A sheet and a body.
    SheetBody(u32, u32),
    /// Two sheets, or a sheet and itself.
    Sheets(u32, u32),
}

/// Input of collision detection.
#[derive(Clone, Copy)]
pub struct DetectionInput<'a> {
    /// Sheets.
    pub sheets: &'a [SheetStageMotion<'a>],
    /// Bodies.
    pub bodies: &'a [BodyStageMotion<'a>],
    /// Margin (m, 1e-6 to 1e-2): a pair nearer than its contact offset plus this gets a constraint.
    pub margin: f64,
    /// Displacement of a resting node in the free motion of the stage, m: g times the square of its
    /// length.
    pub fall: f64,
    /// Margin (m) of sheet-sheet and self-contact; `None` disables their detection.
    pub between: Option<f64>,
    /// Friction and restitution coefficient of a pair.
    pub surfaces: &'a dyn Fn(ContactPair) -> (f64, f64),
}

/// Kinds of pairs that are detected.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct DetectionScope {
    /// Nodes on faces. Without them only edges and corners of bodies are tested.
    pub faces: bool,
    /// Self-contact of lattices with several layers.
    pub stacks: bool,
}

impl Default for DetectionScope {
    fn default() -> Self {
        Self { faces: true, stacks: true }
    }
}

/// Counts of detection work since construction.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize)]
pub struct DetectionCounters {
    /// Comparisons of bounding boxes of whole sheets and bodies.
    pub boxes: u64,
    /// Tests of a node against a body.
    pub mass_body_tests: u64,
    /// Tests of a sheet edge against a body edge.
    pub edge_tests: u64,
    /// Tests of a sheet triangle against a body corner or a ball.
    pub vertex_tests: u64,
    /// Tests of two triangles of one sheet.
    pub self_tests: u64,
    /// Tests of two triangles of two sheets.
    pub sheet_sheet_tests: u64,
}

state!(DetectionCounters { boxes, mass_body_tests, edge_tests, vertex_tests, self_tests, sheet_sheet_tests });

/// Collision detector. Its buffers are reused, so that a repeated call does not allocate.
#[derive(Default)]
pub struct CollisionDetector {
    /// Candidate pairs of a sheet and a body in this step.
    candidate_pairs: Vec<(u32, u32)>,
    between: SheetPairDetector,
    /// Whether the work is divided among the threads of the current pool.
    parallel: bool,
    /// Whether interpenetration is tested, and whether the last stage created one.
    detect_crossings: bool,
    interpenetrates: bool,
    /// Surface trees, one for each sheet.
    trees: Vec<SurfaceTree>,
    local: BodyFramePositions,
    nearest: triangle_ball::BallWorkspace,
    workspace: BvhWorkspace,
    order: Vec<(ContactKey, u32)>,
    detected: Vec<ContactConstraint>,
    retained: Vec<bool>,
    counters: DetectionCounters,
    scope: DetectionScope,
}

impl CollisionDetector {
    /// Counts since construction.
    pub fn counters(&self) -> DetectionCounters {
        self.counters
    }

    /// Serialise the state that carries over between steps.
    pub(crate) fn serialise(&self, to: &mut StateWriter) {
        to.flag(self.scope.faces);
        to.flag(self.scope.stacks);
        self.counters.serialise(to);
        to.count(self.trees.len() as u64);
        self.trees.iter().for_each(|tree| tree.serialise(to));
    }

    /// Deserialise the state; `skin` returns the collision surface of a sheet by its identifier.
    pub(crate) fn deserialise<'s>(
        from: &mut StateReader,
        skin: impl Fn(u32) -> Option<&'s CollisionSurface>,
    ) -> ReadResult<Self> {
        let scope = DetectionScope { faces: from.flag()?, stacks: from.flag()? };
        let mut finder = Self { scope, counters: from.read()?, ..Self::default() };
        for _ in 0..from.length(2)? {
            finder.trees.push(SurfaceTree::deserialise(from, &skin)?);
        }
        Ok(finder)
    }

    /// Whether a surface tree exists for the sheet `id`.
    pub fn has_sheet(&self, id: u32) -> bool {
        self.trees.iter().any(|tree| tree.id == id)
    }

    /// Remove the sheet `id`: higher identifiers become lower by one.
    pub fn remove_sheet(&mut self, id: u32) {
        self.trees.retain(|tree| tree.id != id);
        self.trees.iter_mut().for_each(|tree| tree.id -= u32::from(tree.id > id));
    }

    /// Set the kinds of pairs that are detected from the next step on.
    pub fn set_scope(&mut self, scope: DetectionScope) {
        self.scope = scope;
    }

    /// Enable or disable threads of the current pool. The result is independent of them.
    pub fn use_threads(&mut self, parallel: bool) {
        self.parallel = parallel;
    }

    /// Enable or disable the detection of crossings: of edges of two sheets that are flat at the
    /// base and stand out at the end, since a sheet that bends within the stage may pass between
    /// the nodes of another; and of interpenetration of two sheets regardless of their constraints.
    pub fn set_detect_crossings(&mut self, crosses: bool) {
        self.detect_crossings = crosses;
    }

    /// Whether two sheets interpenetrate at the end and did not at the start. False unless the
    /// detection of crossings is enabled.
    pub fn has_interpenetration(&self) -> bool {
        self.interpenetrates
    }

    /// Run the broad phase of a step in which no point moves farther than `reach` (m) from its
    /// position at the start.
    pub fn run_broad_phase(&mut self, problem: &DetectionInput, reach: f64) {
        let count = problem.sheets.len();
        self.candidate_pairs.clear();
        self.between.candidate_pairs.clear();
        self.trees.truncate(count);
        for (i, sheet) in problem.sheets.iter().enumerate() {
            match self.trees.get_mut(i) {
                Some(tree) if tree.is_of(sheet.id, sheet.skin) => {}
                Some(tree) => *tree = SurfaceTree::new(sheet.id, sheet.skin),
                None => self.trees.push(SurfaceTree::new(sheet.id, sheet.skin)),
            }
            if let Some(tree) = self.trees.get_mut(i).filter(|_| sheet.awake) {
                tree.look_whether_flat(sheet.skin, sheet.start);
            }
        }
        for (s, sheet) in problem.sheets.iter().enumerate() {
            let around =
                BoundingBox::from_positions(sheet.start).grown(reach + sheet.skin.contact_offset() + problem.margin);
            for (b, body) in problem.bodies.iter().enumerate() {
                if !sheet.awake && !body.awake {
                    continue;
                }
                self.counters.boxes += 1;
                let way = if body.awake { reach } else { 0.0 };
                let faces = self.scope.faces;
                let has = |solid: &ColliderPart| faces || !matches!(solid, ColliderPart::HalfSpace { .. });
                let hit = |solid: &ColliderPart| {
                    has(solid) && around.overlaps(&BoundingBox::from_part(solid, &body.start).grown(way))
                };
                if body.features.solids().iter().any(|(_, solid)| hit(solid)) {
                    self.candidate_pairs.push((s as u32, b as u32));
                }
            }
            for (t, other) in problem.sheets.iter().enumerate().skip(s + 1).filter(|(_, o)| o.awake || sheet.awake) {
                self.counters.boxes += 1;
                let way = reach + other.skin.contact_offset();
                if around.overlaps(&BoundingBox::from_positions(other.start).grown(way)) {
                    self.between.candidate_pairs.push((s as u32, t as u32));
                }
            }
        }
    }

    /// Exclude, for this step, pairs of sheets that interpenetrate at its start and of which at
    /// least one satisfies `is_in_doubt` (by index). Their indices are appended to `crossing`.
    pub fn exclude_crossing_pairs(
        &mut self,
        problem: &DetectionInput,
        is_in_doubt: impl Fn(u32) -> bool,
        crossing: &mut Vec<u32>,
    ) {
        self.trees.iter_mut().for_each(SurfaceTree::forget);
        self.between.exclude_crossing_pairs(problem, &mut self.trees, is_in_doubt, crossing);
    }

    /// Whether the broad phase has found no pair and no sheet folded enough for self-contact.
    pub fn is_idle(&self) -> bool {
        self.candidate_pairs.is_empty() && self.between.candidate_pairs.is_empty() && !self.has_folded_sheet()
    }

    /// Indices of the bodies that may touch a sheet in this step; an index may repeat.
    pub fn near_bodies(&self) -> impl Iterator<Item = u32> {
        self.candidate_pairs.iter().map(|(_, body)| *body)
    }

    /// Whether some sheet is folded enough for self-contact in this step.
    pub fn has_folded_sheet(&self) -> bool {
        !self.trees.iter().all(|t| t.looks_flat() || self.skips_self_contact(t))
    }

    /// Whether self-contact of this sheet is not detected.
    fn skips_self_contact(&self, tree: &SurfaceTree) -> bool {
        tree.is_multilayer && !self.scope.stacks
    }

    /// Detect the contacts of a stage and write them to `out`. Their order depends on the input
    /// alone.
    pub fn detect_contacts(&mut self, problem: &DetectionInput, out: &mut Vec<ContactConstraint>) {
        self.detected.clear();
        self.interpenetrates = false;
        self.trees.iter_mut().for_each(SurfaceTree::forget);
        self.detect_sheet_body(problem);
        self.detect_sheet_sheet(problem);
        self.detect_self_contact(problem);
        self.sort_constraints(out);
        if !self.between.candidate_pairs.is_empty() {
            duplicates::prune(problem, out, &mut self.retained);
        }
    }

    fn detect_sheet_body(&mut self, problem: &DetectionInput) {
        for k in 0..self.candidate_pairs.len() {
            let (s, b) = self.candidate_pairs[k];
            let (Some(sheet), Some(body)) = (problem.sheets.get(s as usize), problem.bodies.get(b as usize)) else {
                continue;
            };
            let DetectionScope { faces, .. } = self.scope;
            let Some(tree) = self.trees.get_mut(s as usize) else { continue };
            self.local.load(sheet, body);
            let coefficients = (problem.surfaces)(ContactPair::SheetBody(s, b));
            for (first, solid) in body.features.solids() {
                let meeting = SheetBodyPair::new(problem, (s, sheet), (b, body), *first, coefficients);
                self.counters.boxes += 1;
                let around = self.local.around.grown(meeting.offset + meeting.margin);
                if !around.overlaps(&BoundingBox::from(solid.bounds())) {
                    continue;
                }
                match solid {
                    ColliderPart::HalfSpace { .. } if !faces => {}
                    ColliderPart::Mesh(mesh) if !faces && !mesh.has_sharp_feature_in(around.low, around.high) => {}
                    ColliderPart::HalfSpace { normal } => {
                        vertex_face::half_space(&meeting, &self.local, *normal, &mut self.detected);
                        self.counters.mass_body_tests += self.local.end.len() as u64;
                    }
                    ColliderPart::Ball { centre, radius } => {
                        tree.refresh(sheet, &FrameMotion::default(), sheet.skin.contact_offset() + problem.margin);
                        let ball = (*centre, *radius);
                        self.counters.vertex_tests += triangle_ball::ball(
                            &meeting,
                            &self.local,
                            tree,
                            ball,
                            &mut self.nearest,
                            &mut self.detected,
                        );
                    }
                    ColliderPart::Mesh(mesh) => {
                        tree.refresh(sheet, &FrameMotion::default(), sheet.skin.contact_offset() + problem.margin);
                        if faces {
                            self.counters.mass_body_tests +=
                                vertex_face::mesh(&meeting, &self.local, tree, mesh, &mut self.detected);
                        }
                        self.counters.edge_tests +=
                            edge_edge::edges(&meeting, &self.local, tree, mesh, &mut self.detected);
                        self.counters.vertex_tests +=
                            corner_triangle::corners(&meeting, &self.local, tree, mesh, &mut self.detected);
                    }
                }
            }
        }
    }

    fn detect_sheet_sheet(&mut self, problem: &DetectionInput) {
        let Some(margin) = problem.between.filter(|_| !self.between.candidate_pairs.is_empty()) else { return };
        let seen = self.between.detect_contacts(
            problem,
            margin,
            &mut self.trees,
            (self.parallel, self.detect_crossings),
            &mut self.detected,
        );
        self.counters.boxes += seen.boxes;
        self.counters.sheet_sheet_tests += seen.tests;
        self.interpenetrates = seen.interpenetrates;
    }

    fn detect_self_contact(&mut self, problem: &DetectionInput) {
        let Some(margin) = problem.between else { return };
        for (s, sheet) in problem.sheets.iter().enumerate().filter(|(_, sheet)| sheet.awake) {
            let passes_over = self.trees.get(s).is_some_and(|tree| self.skips_self_contact(tree));
            let folded = |tree: &&mut SurfaceTree| {
                !passes_over && !tree.stays_flat(sheet) && !remains_height_graph(sheet, tree.height())
            };
            let Some(tree) = self.trees.get_mut(s).filter(folded) else { continue };
            tree.refresh(sheet, &FrameMotion::mean_of(std::iter::once(sheet)), box_margin(sheet, margin));
            tree.refresh_ridges(sheet, false);
            let coefficients = (problem.surfaces)(ContactPair::Sheets(s as u32, s as u32));
            let pair = (s as u32, s as u32);
            let Some(couple) = sheet_pair(problem.sheets, &self.trees, pair, margin, coefficients) else { continue };
            let (constraints, tests) = (&mut self.detected, &mut self.counters.self_tests);
            couple.a.tree.own_pairs(&mut self.workspace, |p, q| {
                *tests += 1;
                couple.detect_triangle_pair(p, q, constraints);
            });
        }
    }

    /// Sort the constraints by key and remove those with equal keys.
    fn sort_constraints(&mut self, out: &mut Vec<ContactConstraint>) {
        out.clear();
        self.order.clear();
        self.order.extend(self.detected.iter().enumerate().map(|(i, c)| (c.key, i as u32)));
        self.order.sort_unstable();
        self.order.dedup_by_key(|(key, _)| *key);
        out.extend(self.order.iter().map(|(_, i)| self.detected[*i as usize]));
    }
}

/// Distances that decide about a pair of features, m.
#[derive(Clone, Copy)]
pub(crate) struct DetectionDistances {
    /// Contact offset of the pair.
    offset: f64,
    /// Distance beyond the contact offset up to which a constraint is made.
    margin: f64,
    /// Overlap at the start above which the pair is rejected.
    max_start_penetration: f64,
    /// Half thickness of the thinner sheet, m, to which tolerances refer.
    half: f64,
    /// Displacement of a resting node in the free motion of the stage, m.
    fall: f64,
}

impl DetectionDistances {
    /// Distance up to which the closest features at the base determine the contact.
    fn base_distance(&self) -> f64 {
        3.0 * self.offset + SETTINGS.closest_feature_distance * self.half
    }

    /// Depth below its plane at which a node may pass a rim, m.
    fn rim_passing_depth(&self) -> f64 {
        SETTINGS.vertex_face.rim_passing_depth * self.half + self.fall
    }
}

/// Lower and upper corner of the bounding box of some points.
fn box_of(points: impl IntoIterator<Item = DVec3>) -> (DVec3, DVec3) {
    points.into_iter().fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(low, high), p| (low.min(p), high.max(p)))
}
