//! Detection: which features of sheets and bodies may touch in a stage, as rows of a contact problem.
//!
//! A stage takes the masses from `start`, where nothing overlaps, to `end`, where they would be now; `base` is the latest
//! state that contact has accepted. A row is made for each pair of features that at `end` is nearer than the offset and the
//! margin, or that has passed through on the way. Its normal is that of the closest features at `base` where the pair is
//! close there, and else that of the pair when it meets: so the normal of a resting contact does not depend on how deep the
//! free motion goes, nor on which way out would be shortest. Against a body everything is worked out in the body's frame, in
//! which the body stands still and its features are constants.
//!
//! Pairs: masses on faces (`faces`), sheet edges on sharp convex edges (`edges`), convex corners on triangles (`corners`),
//! triangles on balls (`ball`), and points on triangles and edges on edges of sheets (`surfaces`). Boxes of sheets and
//! bodies, then trees of boxes of triangles, decide what is looked at.

mod ball;
mod between;
mod corners;
mod edges;
mod faces;
mod graph;
mod keys;
mod local;
mod prune;
mod surfaces;
mod tree;

use glam::DVec3;
use rapier3d::parry::partitioning::BvhWorkspace;

use self::between::{Between, couple, half_room};
use self::graph::stays_graph;
pub(super) use self::keys::{is_of_ball, is_of_surface, thing};
use self::local::{Local, Meeting};
use self::tree::{Cuboid, Drift, SkinTree};
use super::features::{Features, Solid};
use super::frame::RigidFrame;
use super::row::{Contact, Key};
use super::skin::Skin;
use crate::kept::{Keeper, Taken, Taker};
use crate::sheet::Vectors;

/// A sheet over a stage.
#[derive(Clone, Copy)]
pub struct SheetMotion<'a> {
    /// Names it from step to step; below 2²⁴.
    pub id: u32,
    /// Its surface.
    pub skin: &'a Skin,
    /// Where its masses are at the start of the stage, m.
    pub start: &'a Vectors,
    /// Where contact has accepted them last, m; `start` before that.
    pub base: &'a Vectors,
    /// Where they would be now, m.
    pub end: &'a Vectors,
    /// Whether it moves; sheets that sleep are met by what moves only.
    pub awake: bool,
}

/// A body's collider over a stage.
#[derive(Clone, Copy)]
pub struct BodyMotion<'a> {
    /// Names it from step to step; below 2²⁴.
    pub id: u32,
    /// What it is made of.
    pub features: &'a Features,
    /// Where it is at the start of the stage.
    pub start: RigidFrame,
    /// Where contact has accepted it last.
    pub base: RigidFrame,
    /// Where it would be now.
    pub end: RigidFrame,
    /// Whether it moves.
    pub awake: bool,
}

/// Two things that may touch, by their place in the problem.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Pair {
    /// A sheet and a body.
    SheetBody(u32, u32),
    /// Two sheets, or a sheet and itself.
    Sheets(u32, u32),
}

/// What detection looks at.
#[derive(Clone, Copy)]
pub struct Problem<'a> {
    /// The sheets.
    pub sheets: &'a [SheetMotion<'a>],
    /// The bodies.
    pub bodies: &'a [BodyMotion<'a>],
    /// Pairs nearer than this beyond their offset get a row, m; 1e-6 to 1e-2.
    pub margin: f64,
    /// The same of two sheets, or of one with itself; `None` where those are not looked for.
    pub between: Option<f64>,
    /// Friction and restitution coefficient of a pair.
    pub surfaces: &'a dyn Fn(Pair) -> (f64, f64),
}

/// What is looked for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Scope {
    /// Masses against faces; where something else does that, edges and corners alone are left.
    pub faces: bool,
    /// Sheets of several layers against themselves.
    pub stacks: bool,
}

impl Default for Scope {
    fn default() -> Self {
        Self { faces: true, stacks: true }
    }
}

/// What detection has done since it was made.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize)]
pub struct FindCounters {
    /// Pairs of boxes of whole sheets and bodies compared.
    pub boxes: u64,
    /// Masses looked at against a body.
    pub mass_body_tests: u64,
    /// Sheet edges looked at against a body's edge.
    pub edge_tests: u64,
    /// Sheet triangles looked at against a body's corner or a ball.
    pub vertex_tests: u64,
    /// Pairs of triangles of one sheet looked at.
    pub self_tests: u64,
    /// Pairs of triangles of two sheets looked at.
    pub sheet_sheet_tests: u64,
}

/// Finds contacts; keeps what it needs so that a warm call allocates nothing.
#[derive(Default)]
pub struct Finder {
    /// Sheets and bodies that may meet in this step.
    near: Vec<(u32, u32)>,
    between: Between,
    /// Whether threads of the pool it is called in may help.
    parallel: bool,
    /// Whether what has crossed is looked for, and whether two sheets were found that go through one another.
    crosses: bool,
    cut: bool,
    /// Of each sheet of the problem.
    trees: Vec<SkinTree>,
    local: Local,
    nearest: ball::Nearest,
    workspace: BvhWorkspace,
    order: Vec<(Key, u32)>,
    raw: Vec<Contact>,
    keep: Vec<bool>,
    counters: FindCounters,
    scope: Scope,
}

/// Features further than this from each other at the base are not contacts there, m, beyond three offsets.
const NEAR: f64 = 5e-4;

/// A pair that overlaps more than this at the start of a stage, m, is none: it lies on two sides of something thin.
const DEEP: f64 = 2e-4;

impl Finder {
    /// What has been done so far.
    pub fn counters(&self) -> FindCounters {
        self.counters
    }

    /// Keeps for a snapshot what a step takes over from those before it.
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

    /// What was kept; `skin` finds the surface of a sheet by its number.
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

    /// Whether it remembers the sheet of that number.
    pub fn knows(&self, id: u32) -> bool {
        self.trees.iter().any(|tree| tree.of() == id)
    }

    /// Looks for this from the next step on.
    pub fn limit(&mut self, scope: Scope) {
        self.scope = scope;
    }

    /// Lets threads of the pool it is called in help, or not; what is found does not depend on it.
    pub fn use_threads(&mut self, parallel: bool) {
        self.parallel = parallel;
    }

    /// Looks also for what has crossed, or not: for edges of two sheets that are flat at the base and stand out at the end, as what bends in the
    /// stage may go through what it lies on between its masses; and for sheets that go through one another, whatever rows say.
    pub fn look_for_crossings(&mut self, crosses: bool) {
        self.crosses = crosses;
    }

    /// Whether two sheets go through one another at the end that did not at the start, where that was looked for.
    pub fn has_cut(&self) -> bool {
        self.cut
    }

    /// Begins a step in which nothing moves further than `reach` (m) from where it is at the start: finds which sheets and
    /// bodies can meet at all.
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

    /// Leaves out for this step what two sheets may do to one another that go through each other at its start, as far as `is_in_doubt` asks
    /// for one of them, by its place in the problem; their places are written to `crossing`.
    pub fn leave_out_crossing(
        &mut self,
        problem: &Problem,
        is_in_doubt: impl Fn(u32) -> bool,
        crossing: &mut Vec<u32>,
    ) {
        self.trees.iter_mut().for_each(SkinTree::forget);
        self.between.leave_out_crossing(problem, &mut self.trees, is_in_doubt, crossing);
    }

    /// Whether nothing can meet in this step: no pair is near, and no sheet is folded enough to meet itself.
    pub fn is_idle(&self) -> bool {
        self.near.is_empty() && self.between.near.is_empty() && !self.folds()
    }

    /// Bodies that may meet a sheet in this step, by their place in the problem of its beginning; one may come up several times.
    pub fn near_bodies(&self) -> impl Iterator<Item = u32> {
        self.near.iter().map(|(_, body)| *body)
    }

    /// Whether some sheet is folded enough to meet itself in this step.
    pub fn folds(&self) -> bool {
        !self.trees.iter().all(|t| t.looks_flat() || self.passes_over(t))
    }

    /// Whether what may become of a sheet alone is not looked for.
    fn passes_over(&self, tree: &SkinTree) -> bool {
        tree.stack && !self.scope.stacks
    }

    /// Finds the contacts of a stage, in an order that depends on the problem alone, and puts them into `out`.
    pub fn find(&mut self, problem: &Problem, out: &mut Vec<Contact>) {
        self.raw.clear();
        self.cut = false;
        self.trees.iter_mut().for_each(SkinTree::forget);
        self.against_bodies(problem);
        self.against_sheets(problem);
        self.against_themselves(problem);
        self.collect(out);
        if !self.between.near.is_empty() {
            prune::prune(problem, out, &mut self.keep);
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
                        faces::half_space(&meeting, &self.local, *normal, &mut self.raw);
                        self.counters.mass_body_tests += self.local.end.len() as u64;
                    }
                    Solid::Ball { centre, radius } => {
                        tree.refresh(sheet, &Drift::default(), sheet.skin.offset() + problem.margin);
                        let ball = (*centre, *radius);
                        self.counters.vertex_tests +=
                            ball::ball(&meeting, &self.local, tree, ball, &mut self.nearest, &mut self.raw);
                    }
                    Solid::Mesh(mesh) => {
                        tree.refresh(sheet, &Drift::default(), sheet.skin.offset() + problem.margin);
                        if faces {
                            self.counters.mass_body_tests +=
                                faces::mesh(&meeting, &self.local, tree, mesh, &mut self.raw);
                        }
                        self.counters.edge_tests += edges::edges(&meeting, &self.local, tree, mesh, &mut self.raw);
                        self.counters.vertex_tests +=
                            corners::corners(&meeting, &self.local, tree, mesh, &mut self.raw);
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

    /// Sorts the rows by their names and keeps one of each.
    fn collect(&mut self, out: &mut Vec<Contact>) {
        out.clear();
        self.order.clear();
        self.order.extend(self.raw.iter().enumerate().map(|(i, c)| (c.key, i as u32)));
        self.order.sort_unstable();
        self.order.dedup_by_key(|(key, _)| *key);
        out.extend(self.order.iter().map(|(_, i)| self.raw[*i as usize]));
    }
}

/// How close a pair of features must be, m.
#[derive(Clone, Copy)]
struct Limits {
    /// Distance at which they touch.
    offset: f64,
    /// Beyond that, up to where they get a row.
    margin: f64,
    /// Overlap at the start beyond which the pair is none.
    deep: f64,
}

impl Limits {
    /// Distance up to which the closest features at the base decide.
    fn near(&self) -> f64 {
        3.0 * self.offset + NEAR
    }
}

/// Smallest and largest of some points.
fn box_of(points: impl IntoIterator<Item = DVec3>) -> (DVec3, DVec3) {
    points.into_iter().fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(low, high), p| (low.min(p), high.max(p)))
}

#[cfg(test)]
mod tests;
