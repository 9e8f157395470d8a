//! Collision detection of a stage: contact constraints between features of sheets and bodies.
//!
//! A stage moves the nodes from `start`, where nothing overlaps, to `end`, where they would be now;
//! `base` is the latest state that the contact solver has accepted. A constraint is made for each
//! pair of features that at `end` is nearer than contact offset plus margin, or that has crossed
//! during the motion. Its normal is that of the closest features at `base` if the pair is close
//! there, otherwise that at the time of impact. The normal of a resting contact therefore depends
//! neither on the depth of the free motion nor on the shortest way out. Pairs with a body are
//! computed in the frame of the body, in which its features are constant. Lengths in m.
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

use crate::collision::bvh::{Cuboid, Drift, SkinTree};
use crate::collision::collision_surface::Skin;
use crate::collision::constraint::{Contact, Key};
use crate::collision::features::{Features, Solid};
use crate::collision::narrow_phase::body_frame::{Local, Meeting};
pub(crate) use crate::collision::narrow_phase::feature_keys::{is_of_ball, is_of_surface, thing};
use crate::collision::narrow_phase::height_graph::stays_graph;
use crate::collision::narrow_phase::sheet_pairs::{Between, couple, half_room};
use crate::collision::settings::DetectionSettings;
use crate::math::RigidFrame;
use crate::math::Vectors;
use crate::serialize::{Keeper, Taken, Taker};

const SETTINGS: DetectionSettings = DetectionSettings::DEFAULT;

/// Motion of a sheet over a stage.
#[derive(Clone, Copy)]
pub struct SheetMotion<'a> {
    /// Identifier of the sheet, constant between steps; below 2²⁴.
    pub id: u32,
    /// Collision surface.
    pub skin: &'a Skin,
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
pub struct BodyMotion<'a> {
    /// Identifier of the body, constant between steps; below 2²⁴.
    pub id: u32,
    /// Features of the collider.
    pub features: &'a Features,
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
pub enum Pair {
    /// A sheet and a body.
    SheetBody(u32, u32),
    /// Two sheets, or a sheet and itself.
    Sheets(u32, u32),
}

/// Input of collision detection.
#[derive(Clone, Copy)]
pub struct Problem<'a> {
    /// Sheets.
    pub sheets: &'a [SheetMotion<'a>],
    /// Bodies.
    pub bodies: &'a [BodyMotion<'a>],
    /// Margin (m, 1e-6 to 1e-2): a pair nearer than its contact offset plus this gets a constraint.
    pub margin: f64,
    /// Margin (m) of sheet-sheet and self-contact; `None` disables their detection.
    pub between: Option<f64>,
    /// Friction and restitution coefficient of a pair.
    pub surfaces: &'a dyn Fn(Pair) -> (f64, f64),
}

/// Kinds of pairs that are detected.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Scope {
    /// Nodes on faces. Without them only edges and corners of bodies are tested.
    pub faces: bool,
    /// Self-contact of lattices with several layers.
    pub stacks: bool,
}

impl Default for Scope {
    fn default() -> Self {
        Self { faces: true, stacks: true }
    }
}

/// Counts of detection work since construction.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize)]
pub struct FindCounters {
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

/// Collision detector. Its buffers are reused, so that a repeated call does not allocate.
#[derive(Default)]
pub struct Finder {
    /// Candidate pairs of a sheet and a body in this step.
    near: Vec<(u32, u32)>,
    between: Between,
    /// Whether the work is divided among the threads of the current pool.
    parallel: bool,
    /// Whether interpenetration is tested, and whether the last stage created one.
    crosses: bool,
    cut: bool,
    /// Surface trees, one for each sheet.
    trees: Vec<SkinTree>,
    local: Local,
    nearest: triangle_ball::Nearest,
    workspace: BvhWorkspace,
    order: Vec<(Key, u32)>,
    raw: Vec<Contact>,
    keep: Vec<bool>,
    counters: FindCounters,
    scope: Scope,
}

impl Finder {
    /// Counts since construction.
    pub fn counters(&self) -> FindCounters {
        self.counters
    }

    /// Serialise the state that carries over between steps.
    pub(crate) fn keep(&self, to: &mut Keeper) {
        to.flag(self.scope.faces);
        to.flag(self.scope.stacks);
        let c = &self.counters;
        for count in [c.boxes, c.mass_body_tests, c.edge_tests, c.vertex_tests, c.self_tests, c.sheet_sheet_tests] {
            to.count(count);
        }
        to.count(self.trees.len() as u64);
        self.trees.iter().for_each(|tree| tree.keep(to));
    }

    /// Deserialise the state; `skin` returns the collision surface of a sheet by its identifier.
    pub(crate) fn taken<'s>(from: &mut Taker, skin: impl Fn(u32) -> Option<&'s Skin>) -> Taken<Self> {
        let scope = Scope { faces: from.flag()?, stacks: from.flag()? };
        let mut finder = Self { scope, ..Self::default() };
        let c = &mut finder.counters;
        let counts = [&mut c.boxes, &mut c.mass_body_tests, &mut c.edge_tests, &mut c.vertex_tests];
        for count in counts.into_iter().chain([&mut c.self_tests, &mut c.sheet_sheet_tests]) {
            *count = from.count()?;
        }
        for _ in 0..from.length(2)? {
            finder.trees.push(SkinTree::taken(from, &skin)?);
        }
        Ok(finder)
    }

    /// Whether a surface tree exists for the sheet `id`.
    pub fn knows(&self, id: u32) -> bool {
        self.trees.iter().any(|tree| tree.of() == id)
    }

    /// Set the kinds of pairs that are detected from the next step on.
    pub fn limit(&mut self, scope: Scope) {
        self.scope = scope;
    }

    /// Enable or disable threads of the current pool. The result is independent of them.
    pub fn use_threads(&mut self, parallel: bool) {
        self.parallel = parallel;
    }

    /// Enable or disable the detection of crossings: of edges of two sheets that are flat at the
    /// base and stand out at the end, since a sheet that bends within the stage may pass between
    /// the nodes of another; and of interpenetration of two sheets regardless of their constraints.
    pub fn look_for_crossings(&mut self, crosses: bool) {
        self.crosses = crosses;
    }

    /// Whether two sheets interpenetrate at the end and did not at the start. False unless the
    /// detection of crossings is enabled.
    pub fn has_cut(&self) -> bool {
        self.cut
    }

    /// Run the broad phase of a step in which no point moves farther than `reach` (m) from its
    /// position at the start.
    pub fn begin(&mut self, problem: &Problem, reach: f64) {
        let count = problem.sheets.len();
        self.near.clear();
        self.between.near.clear();
        self.trees.truncate(count);
        for (i, sheet) in problem.sheets.iter().enumerate() {
            match self.trees.get_mut(i) {
                Some(tree) if tree.is_of(sheet.id, sheet.skin) => {}
                Some(tree) => *tree = SkinTree::new(sheet.id, sheet.skin),
                None => self.trees.push(SkinTree::new(sheet.id, sheet.skin)),
            }
            if let Some(tree) = self.trees.get_mut(i).filter(|_| sheet.awake) {
                tree.look_whether_flat(sheet.skin, sheet.start);
            }
        }
        for (s, sheet) in problem.sheets.iter().enumerate() {
            let around = Cuboid::of(sheet.start).grown(reach + sheet.skin.offset() + problem.margin);
            for (b, body) in problem.bodies.iter().enumerate() {
                if !sheet.awake && !body.awake {
                    continue;
                }
                self.counters.boxes += 1;
                let way = if body.awake { reach } else { 0.0 };
                let faces = self.scope.faces;
                let has = |solid: &Solid| faces || !matches!(solid, Solid::HalfSpace { .. });
                let hit = |solid: &Solid| has(solid) && around.meets(&Cuboid::of_solid(solid, &body.start).grown(way));
                if body.features.solids().iter().any(|(_, solid)| hit(solid)) {
                    self.near.push((s as u32, b as u32));
                }
            }
            for (t, other) in problem.sheets.iter().enumerate().skip(s + 1).filter(|(_, o)| o.awake || sheet.awake) {
                self.counters.boxes += 1;
                let way = reach + other.skin.offset();
                if around.meets(&Cuboid::of(other.start).grown(way)) {
                    self.between.near.push((s as u32, t as u32));
                }
            }
        }
    }

    /// Exclude, for this step, pairs of sheets that interpenetrate at its start and of which at
    /// least one satisfies `is_in_doubt` (by index). Their indices are appended to `crossing`.
    pub fn leave_out_crossing(
        &mut self,
        problem: &Problem,
        is_in_doubt: impl Fn(u32) -> bool,
        crossing: &mut Vec<u32>,
    ) {
        self.trees.iter_mut().for_each(SkinTree::forget);
        self.between.leave_out_crossing(problem, &mut self.trees, is_in_doubt, crossing);
    }

    /// Whether the broad phase has found no pair and no sheet folded enough for self-contact.
    pub fn is_idle(&self) -> bool {
        self.near.is_empty() && self.between.near.is_empty() && !self.folds()
    }

    /// Indices of the bodies that may touch a sheet in this step; an index may repeat.
    pub fn near_bodies(&self) -> impl Iterator<Item = u32> {
        self.near.iter().map(|(_, body)| *body)
    }

    /// Whether some sheet is folded enough for self-contact in this step.
    pub fn folds(&self) -> bool {
        !self.trees.iter().all(|t| t.looks_flat() || self.passes_over(t))
    }

    /// Whether self-contact of this sheet is not detected.
    fn passes_over(&self, tree: &SkinTree) -> bool {
        tree.stack && !self.scope.stacks
    }

    /// Detect the contacts of a stage and write them to `out`. Their order depends on the input
    /// alone.
    pub fn find(&mut self, problem: &Problem, out: &mut Vec<Contact>) {
        self.raw.clear();
        self.cut = false;
        self.trees.iter_mut().for_each(SkinTree::forget);
        self.against_bodies(problem);
        self.against_sheets(problem);
        self.against_themselves(problem);
        self.collect(out);
        if !self.between.near.is_empty() {
            duplicates::prune(problem, out, &mut self.keep);
        }
    }

    fn against_bodies(&mut self, problem: &Problem) {
        for k in 0..self.near.len() {
            let (s, b) = self.near[k];
            let (Some(sheet), Some(body)) = (problem.sheets.get(s as usize), problem.bodies.get(b as usize)) else {
                continue;
            };
            let Scope { faces, .. } = self.scope;
            let Some(tree) = self.trees.get_mut(s as usize) else { continue };
            self.local.load(sheet, body);
            let coefficients = (problem.surfaces)(Pair::SheetBody(s, b));
            for (first, solid) in body.features.solids() {
                let meeting = Meeting::new(problem, (s, sheet), (b, body), *first, coefficients);
                self.counters.boxes += 1;
                let around = self.local.around.grown(meeting.offset + meeting.margin);
                if !around.meets(&Cuboid::from(solid.bounds())) {
                    continue;
                }
                match solid {
                    Solid::HalfSpace { .. } if !faces => {}
                    Solid::Mesh(mesh) if !faces && !mesh.is_sharp_in(around.low, around.high) => {}
                    Solid::HalfSpace { normal } => {
                        vertex_face::half_space(&meeting, &self.local, *normal, &mut self.raw);
                        self.counters.mass_body_tests += self.local.end.len() as u64;
                    }
                    Solid::Ball { centre, radius } => {
                        tree.refresh(sheet, &Drift::default(), sheet.skin.offset() + problem.margin);
                        let ball = (*centre, *radius);
                        self.counters.vertex_tests +=
                            triangle_ball::ball(&meeting, &self.local, tree, ball, &mut self.nearest, &mut self.raw);
                    }
                    Solid::Mesh(mesh) => {
                        tree.refresh(sheet, &Drift::default(), sheet.skin.offset() + problem.margin);
                        if faces {
                            self.counters.mass_body_tests +=
                                vertex_face::mesh(&meeting, &self.local, tree, mesh, &mut self.raw);
                        }
                        self.counters.edge_tests += edge_edge::edges(&meeting, &self.local, tree, mesh, &mut self.raw);
                        self.counters.vertex_tests +=
                            corner_triangle::corners(&meeting, &self.local, tree, mesh, &mut self.raw);
                    }
                }
            }
        }
    }

    fn against_sheets(&mut self, problem: &Problem) {
        let Some(margin) = problem.between.filter(|_| !self.between.near.is_empty()) else { return };
        let seen = self.between.find(problem, margin, &mut self.trees, (self.parallel, self.crosses), &mut self.raw);
        self.counters.boxes += seen.boxes;
        self.counters.sheet_sheet_tests += seen.tests;
        self.cut = seen.cut;
    }

    fn against_themselves(&mut self, problem: &Problem) {
        let Some(margin) = problem.between else { return };
        for (s, sheet) in problem.sheets.iter().enumerate().filter(|(_, sheet)| sheet.awake) {
            let passes_over = self.trees.get(s).is_some_and(|tree| self.passes_over(tree));
            let folded =
                |tree: &&mut SkinTree| !passes_over && !tree.stays_flat(sheet) && !stays_graph(sheet, tree.height());
            let Some(tree) = self.trees.get_mut(s).filter(folded) else { continue };
            tree.refresh(sheet, &Drift::of(std::iter::once(sheet)), half_room(sheet, margin));
            tree.refresh_ridges(sheet, false);
            let coefficients = (problem.surfaces)(Pair::Sheets(s as u32, s as u32));
            let pair = (s as u32, s as u32);
            let Some(couple) = couple(problem.sheets, &self.trees, pair, margin, coefficients) else { continue };
            let (rows, tests) = (&mut self.raw, &mut self.counters.self_tests);
            couple.a.tree.own_pairs(&mut self.workspace, |p, q| {
                *tests += 1;
                couple.triangles(p, q, rows);
            });
        }
    }

    /// Sort the constraints by key and remove those with equal keys.
    fn collect(&mut self, out: &mut Vec<Contact>) {
        out.clear();
        self.order.clear();
        self.order.extend(self.raw.iter().enumerate().map(|(i, c)| (c.key, i as u32)));
        self.order.sort_unstable();
        self.order.dedup_by_key(|(key, _)| *key);
        out.extend(self.order.iter().map(|(_, i)| self.raw[*i as usize]));
    }
}

/// Distances that decide about a pair of features, m.
#[derive(Clone, Copy)]
pub(crate) struct Limits {
    /// Contact offset of the pair.
    offset: f64,
    /// Distance beyond the contact offset up to which a constraint is made.
    margin: f64,
    /// Overlap at the start above which the pair is rejected.
    deep: f64,
}

impl Limits {
    /// Distance up to which the closest features at the base determine the contact.
    fn near(&self) -> f64 {
        3.0 * self.offset + SETTINGS.closest_feature_distance
    }
}

/// Lower and upper corner of the bounding box of some points.
fn box_of(points: impl IntoIterator<Item = DVec3>) -> (DVec3, DVec3) {
    points.into_iter().fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(low, high), p| (low.min(p), high.max(p)))
}
