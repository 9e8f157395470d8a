//! Contact detection of an island, stage by stage: placement of bodies, detection, and mapping of
//! contacts from colliders to bodies. Attachments and contacts between bodies are added as
//! contacts.

use glam::DVec3;

use crate::collision::collision_surface::CollisionSurface;
use crate::collision::constraint::{ContactConstraint, ContactSide};
use crate::collision::narrow_phase::{
    BodyStageMotion, CollisionDetector, ContactPair, DetectionCounters, DetectionInput, DetectionScope,
    SheetStageMotion, attachment_key,
};
use crate::contact::IslandView;
use crate::contact::adhesion::on_bodies;
use crate::contact::barrier::{BarrierAttachment, BarrierCollider};
use crate::contact::compression::resolve_compression;
use crate::contact::detected_contacts::DetectedContacts;
use crate::contact::gap::node_side;
use crate::contact::outer_iteration::{ContactMargins, DetectionMode};
use crate::contact::solver_body::{SolverBody, frame_of_body};
use crate::contact::step_bodies::StepBodies;
use crate::contact::workspace::ContactWorkspace;
use crate::islands::overlap_test::{OverlapTest, TestedColliders, TestedState, frame_in};
use crate::math::{RigidFrame, Vectors};
use crate::profiler::{Phase, Profiler};
use crate::rigid::settings::RigidSettings;
use crate::rigid::{BodyContact, BodyState, RigidView};
use crate::serialize::{ReadResult, StateReader, StateWriter};
use crate::sheet::{Interpenetration, Sheet, attachment, node_contact, stage};

const SETTINGS: RigidSettings = RigidSettings::DEFAULT;

/// Contact cache key of contacts between bodies, below that of attachments; keys of sheet contacts
/// are smaller.
const BODY_CONTACT_KEY: u64 = u64::MAX - 1;

/// State of detection between steps.
#[derive(Default)]
pub(crate) struct DetectionCache {
    pub finder: CollisionDetector,
    /// Parts and bodies of the surroundings in reach, ascending, and the island's body of each
    /// part.
    parts: Vec<u32>,
    bodies: Vec<u32>,
    of_part: Vec<u32>,
    sheet_motions: Vec<SheetStageMotion<'static>>,
    body_motions: Vec<BodyStageMotion<'static>>,
    /// Positions of the nodes of a lone sheet after the contact solution, m.
    moved: Vectors,
    /// Buffers of the test before a substep is accepted.
    overlap: OverlapTest,
    /// Sheets of the island that interpenetrate.
    crossing: Vec<u32>,
}

impl DetectionCache {
    /// Counters of detection.
    pub fn counters(&self) -> DetectionCounters {
        self.finder.counters()
    }

    /// Serialise the state of detection for a snapshot.
    pub fn serialise(&self, to: &mut StateWriter) {
        self.finder.serialise(to);
    }

    /// Deserialise the state of detection; `skin` returns the collision surface of a sheet by
    /// index.
    pub fn deserialise<'s>(
        from: &mut StateReader,
        skin: impl Fn(u32) -> Option<&'s CollisionSurface>,
    ) -> ReadResult<Self> {
        Ok(Self { finder: CollisionDetector::deserialise(from, skin)?, ..Self::default() })
    }

    /// Set the features that are detected from the next step on.
    pub fn limit(&mut self, scope: DetectionScope) {
        self.finder.set_scope(scope);
    }

    /// Whether a sheet may have self-contact in this step.
    pub fn has_self_contact(&self) -> bool {
        self.finder.has_folded_sheet()
    }

    /// Bodies of the island, by index in the surroundings.
    pub fn bodies(&self) -> &[u32] {
        &self.bodies
    }

    /// Index in the surroundings of a contact's `part`.
    pub fn part(&self, part: u32) -> Option<u32> {
        self.parts.get(part as usize).copied()
    }
}

/// Contact detection of one island over one step.
pub(crate) struct IslandDetection<'a> {
    pub view: Option<&'a RigidView<'a>>,
    pub surroundings: &'a StepBodies,
    pub body_contacts: &'a [BodyContact],
    pub gravity: DVec3,
    pub sheets_meet: bool,
    /// Index in the world of each sheet of the island.
    pub ids: &'a [u32],
    pub work: &'a mut DetectionCache,
    pub profiler: &'a Profiler,
}

impl IslandDetection<'_> {
    /// Find the parts near the island's box (m), which no object leaves by more than `reach` (m),
    /// and create the solver bodies.
    pub fn begin(&mut self, island: &mut IslandView, (low, high): (DVec3, DVec3), reach: f64) {
        let DetectionCache { parts, bodies, of_part, .. } = &mut *self.work;
        parts.clear();
        bodies.clear();
        of_part.clear();
        island.solver_bodies.clear();
        let (low, high) = (low - reach, high + reach);
        for (i, part) in self.surroundings.colliders.iter().enumerate() {
            if part.low.cmple(high).all() && part.high.cmpge(low).all() {
                parts.push(i as u32);
                bodies.push(part.body);
            }
        }
        for sheet in island.sheets.iter() {
            for (_, index, _) in sheet.pins.dynamic_attachments() {
                bodies.push(index as u32);
            }
        }
        add_touching_bodies(bodies, self.body_contacts, self.surroundings);
        for index in bodies.iter() {
            island.solver_bodies.push(SolverBody::new(self.surroundings.bodies[*index as usize].start));
        }
        island.body_penetration = 0.0;
        for c in self.body_contacts.iter().filter(|c| c.distance < -SETTINGS.penetration_tolerance) {
            if [c.a, c.b].iter().any(|index| bodies.binary_search(&(*index as u32)).is_ok()) {
                island.body_penetration = island.body_penetration.max(depenetration_of(c));
            }
        }
        island.stacked_bodies = count_leaning_bodies(bodies, self.body_contacts, self.surroundings);
        for part in parts.iter() {
            let body = self.surroundings.colliders[*part as usize].body;
            of_part.push(bodies.binary_search(&body).unwrap_or(0) as u32);
        }
        self.run_detection(island, DetectionMode::FromStart, ContactMargins::resting(island), |finder, problem| {
            finder.run_broad_phase(problem, reach)
        });
        let in_doubt = |sheet: &Sheet| sheet.state.interpenetration != Interpenetration::None;
        if self.sheets_meet && island.sheets.iter().any(in_doubt) {
            self.exclude_crossing_sheets(island);
        }
    }

    /// Disable contact between interpenetrating sheets, among those not known to be apart.
    fn exclude_crossing_sheets(&mut self, island: &mut IslandView) {
        let mut crossing = std::mem::take(&mut self.work.crossing);
        crossing.clear();
        let in_doubt = |local: u32| island.sheet(local).state.interpenetration != Interpenetration::None;
        if island.sheets.len() > 1 {
            self.run_detection(island, DetectionMode::FromStart, ContactMargins::resting(island), |finder, problem| {
                finder.exclude_crossing_pairs(problem, in_doubt, &mut crossing);
            });
        }
        for (local, sheet) in island.sheets.iter_mut().enumerate() {
            sheet.state.interpenetration = match sheet.state.interpenetration {
                _ if !crossing.contains(&(local as u32)) => Interpenetration::None,
                Interpenetration::Reported => Interpenetration::Reported,
                _ => Interpenetration::Detected,
            };
        }
        self.work.crossing = crossing;
    }

    /// Whether contact is impossible in this step.
    pub fn is_idle(&self, island: &IslandView) -> bool {
        self.work.finder.is_idle() && !island.sheets.iter().any(attachment::has_dynamic_attachments)
    }

    /// Call `run_detection` with the finder and the problem of `look`.
    fn run_detection(
        &mut self,
        island: &IslandView,
        mode: DetectionMode,
        margins: ContactMargins,
        ask: impl FnOnce(&mut CollisionDetector, &DetectionInput),
    ) {
        let mut sheets: Vec<SheetStageMotion> = reuse_allocation(std::mem::take(&mut self.work.sheet_motions));
        let mut bodies: Vec<BodyStageMotion> = reuse_allocation(std::mem::take(&mut self.work.body_motions));
        let mut finder = std::mem::take(&mut self.work.finder);
        let mut moved = std::mem::take(&mut self.work.moved);
        if mode == DetectionMode::ContactMotion
            && let [sheet] = &*island.sheets
        {
            let (work, response) = (&sheet.work, &island.contacts[0].response);
            if moved.len() != work.stage.free_positions.len() {
                moved = Vectors::zeros(work.stage.free_positions.len());
            }
            moved.copy_from(&work.stage.free_positions);
            if response.is_touched() {
                moved.add_scaled(1.0, &response.jump.dx);
            }
        }
        finder.use_threads(island.parallel);
        finder.set_detect_crossings(mode == DetectionMode::SheetCrossing);
        for ((sheet, contact), id) in island.sheets.iter().zip(&*island.contacts).zip(self.ids) {
            let Some(skin) = &contact.surface else { continue };
            let context = &sheet.work.stage;
            let begun = context.free_positions.len() == sheet.node_count();
            let reached = matches!(mode, DetectionMode::FromIterate | DetectionMode::BodyPenetration);
            let base = if reached && begun { &context.iterate } else { &sheet.state.x };
            let end = match mode {
                DetectionMode::BodyPenetration | DetectionMode::SheetCrossing => &context.iterate,
                DetectionMode::ContactMotion => &moved,
                _ if begun => &context.free_positions,
                _ => &sheet.state.x,
            };
            sheets.push(SheetStageMotion { id: *id, skin, start: &sheet.state.x, base, end, awake: true });
        }
        let bodies_too = if mode == DetectionMode::SheetCrossing { 0 } else { self.work.parts.len() };
        for (part, body) in self.work.parts.iter().zip(&self.work.of_part).take(bodies_too) {
            let of = &self.surroundings.colliders[*part as usize];
            let solver_body = &island.solver_bodies[*body as usize];
            let base = if matches!(mode, DetectionMode::FromStart | DetectionMode::ContactMotion) {
                frame_of_body(&solver_body.start)
            } else {
                solver_body.end_frame()
            };
            let end = if matches!(mode, DetectionMode::BodyPenetration | DetectionMode::ContactMotion) {
                solver_body.end_frame()
            } else {
                frame_of_body(&solver_body.free)
            };
            bodies.push(BodyStageMotion {
                id: *part,
                features: &of.features,
                start: in_world(&frame_of_body(&solver_body.start), &of.frame),
                base: in_world(&base, &of.frame),
                end: in_world(&end, &of.frame),
                awake: true,
            });
        }
        let between = (mode != DetectionMode::BodyPenetration && self.sheets_meet).then_some(margins.sheets);
        let coefficients = |pair| self.coefficients(island, pair);
        let length = island.sheets.first().map_or(0.0, |sheet| sheet.work.stage.length);
        let problem = DetectionInput {
            sheets: &sheets,
            bodies: &bodies,
            margin: margins.bodies,
            fall: self.gravity.length() * length * length,
            between,
            surfaces: &coefficients,
        };
        self.profiler.measure(Phase::Detection, || ask(&mut finder, &problem));
        self.work.finder = finder;
        self.work.sheet_motions = reuse_allocation(sheets);
        self.work.body_motions = reuse_allocation(bodies);
        self.work.moved = moved;
    }

    fn coefficients(&self, island: &IslandView, pair: ContactPair) -> (f64, f64) {
        match pair {
            ContactPair::SheetBody(sheet, part) => {
                let sheet = island.sheet(sheet);
                let part =
                    self.work.parts.get(part as usize).and_then(|p| self.surroundings.colliders.get(*p as usize));
                let known = self.view.zip(part).and_then(|(view, part)| {
                    Some(view.coefficients(
                        node_contact::surface_coefficients(sheet),
                        part.handle,
                        view.colliders.get(part.handle)?,
                    ))
                });
                known.unwrap_or((sheet.parameters.friction, sheet.parameters.restitution))
            }
            ContactPair::Sheets(a, b) => {
                let (a, b) = (island.sheet(a), island.sheet(b));
                let mean = (
                    0.5 * (a.parameters.friction + b.parameters.friction),
                    0.5 * (a.parameters.restitution + b.parameters.restitution),
                );
                self.view.map_or(mean, |v| v.between(&a.material().name, &b.material().name, mean))
            }
        }
    }

    /// Colliders near the island, for the barrier method.
    pub fn barrier_colliders(&self) -> impl Iterator<Item = BarrierCollider<'_>> + Clone {
        let all = self.work.parts.iter().zip(&self.work.of_part).enumerate();
        all.map(|(part, (index, body))| {
            let of = &self.surroundings.colliders[*index as usize];
            BarrierCollider { part: part as u32, body: *body, features: &of.features, frame: &of.frame }
        })
    }

    /// Nodes attached to dynamic bodies, with body and point.
    pub fn barrier_attachments(&self, island: &IslandView) -> Vec<BarrierAttachment> {
        let mut all = Vec::new();
        for (sheet, of) in (0..).zip(island.sheets.iter()) {
            for (node, index, local) in of.pins.dynamic_attachments() {
                if let Ok(body) = self.work.bodies.binary_search(&(index as u32)) {
                    all.push(BarrierAttachment { sheet, node, body: body as u32, local });
                }
            }
        }
        all
    }

    /// Whether a sheet of the island is deeper than accepted in something, at the start or at the
    /// end of a substep.
    pub fn finds_overlap(&mut self, island: &IslandView, workspace: &ContactWorkspace, state: TestedState) -> bool {
        let mut test = std::mem::take(&mut self.work.overlap);
        let frames = |body| frame_in(state, island, workspace, body);
        let finds = {
            let colliders = TestedColliders { colliders: self.barrier_colliders(), frames: &frames };
            test.finds(island, &colliders, (state, self.sheets_meet))
        };
        self.work.overlap = test;
        finds
    }

    /// Friction coefficient of a pair; `None` where it has no contact.
    pub fn friction(&self, island: &IslandView, pair: ContactPair) -> Option<f64> {
        if let ContactPair::Sheets(a, b) = pair
            && a != b
        {
            let crosses = |s| island.sheet(s).state.interpenetration != Interpenetration::None;
            if !self.sheets_meet || crosses(a) && crosses(b) {
                return None;
            }
        }
        Some(self.coefficients(island, pair).0)
    }

    /// Contact point on the island's body `solver_body`, with index `index`, at the end of the
    /// stage: the same body point as at the start of the step, or, on a ball that rolls, the body
    /// point that has moved to the same place.
    fn point(
        &self,
        island: &IslandView,
        (solver_body, index): (u32, usize),
        at_start: DVec3,
        is_round: bool,
    ) -> ContactSide {
        let turned = || {
            let there = self.surroundings.bodies[index].start.rotation() * at_start;
            island.solver_bodies[solver_body as usize].free.rotation().conjugate() * there
        };
        ContactSide::Body { body: solver_body, local: if is_round { turned() } else { at_start } }
    }

    /// Add contacts between bodies, and attachments.
    fn add_attachments_and_body_contacts(&self, island: &IslandView, found: &mut DetectedContacts) {
        let solver_body = |index: usize| self.work.bodies.binary_search(&(index as u32)).ok().map(|i| i as u32);
        for c in self.body_contacts {
            let (Some(a), Some(b)) = (solver_body(c.a), solver_body(c.b)) else { continue };
            found.contacts.push(ContactConstraint {
                a: self.point(island, (a, c.a), c.on_a, c.round[0]),
                b: self.point(island, (b, c.b), c.on_b, c.round[1]),
                normal: c.normal,
                offset: c.distance.min(0.0) + depenetration_of(c),
                key: [BODY_CONTACT_KEY - (c.key[0] & 0xffff_ffff), c.key[1] ^ c.key[0].rotate_left(17)],
                friction: c.friction,
                restitution: c.restitution,
                bond: 0.0,
                compressed: None,
            });
        }
        found.first_attachment = found.contacts.len();
        for (local, (sheet, id)) in island.sheets.iter().zip(self.ids).enumerate() {
            for (mass, index, place) in sheet.pins.dynamic_attachments() {
                let Some(body) = solver_body(index) else { continue };
                found.contacts.push(ContactConstraint {
                    a: node_side(local as u32, mass),
                    b: ContactSide::Body { body, local: place },
                    normal: DVec3::Y,
                    offset: 0.0,
                    key: attachment_key(*id, mass, index),
                    friction: 0.0,
                    restitution: 0.0,
                    bond: 0.0,
                    compressed: None,
                });
            }
        }
    }

    /// Move the bodies of `island` to the start of a stage from `from` to `to` (s after the start
    /// of the whole step), and set their motion without contact with sheets.
    pub fn begin_stage(&mut self, island: &mut IslandView, from: f64, to: f64) {
        let (span, weight) = (to - from, gravity_weight(island, to - from));
        for (solver_body, index) in island.solver_bodies.iter_mut().zip(&self.work.bodies) {
            let over = &self.surroundings.bodies[*index as usize];
            if solver_body.start.is_dynamic() {
                let mut free = solver_body.start.free_flight(span, self.gravity);
                if weight > 0.5 {
                    free = free.displaced(self.gravity * ((weight - 0.5) * span * span), DVec3::ZERO);
                }
                on_bodies(island.sheets, |body, force, at| {
                    if body == *index {
                        free = apply_force(&free, force, solver_body.start.world_point(at), (span, weight));
                    }
                });
                solver_body.begin(free);
            } else {
                solver_body.start = over.start.free_flight(from, DVec3::ZERO);
                solver_body.begin(over.start.free_flight(to, DVec3::ZERO));
            }
        }
    }

    /// Write to `found` the contacts of `mode` that are closer than `margins`, from the motions in
    /// the sheets of `island`.
    pub fn detect_contacts(
        &mut self,
        island: &IslandView,
        mode: DetectionMode,
        margins: ContactMargins,
        found: &mut DetectedContacts,
    ) {
        let mut contacts = std::mem::take(&mut found.contacts);
        self.run_detection(island, mode, margins, |finder, problem| finder.detect_contacts(problem, &mut contacts));
        found.sheets_intersect = self.work.finder.has_interpenetration();
        if !self.sheets_meet {
            contacts.retain(|c| !matches!((c.a, c.b), (ContactSide::Sheet { .. }, ContactSide::Sheet { .. })));
        }
        found.contacts = contacts;
        found.colliders.clear();
        for contact in &mut found.contacts {
            let mut part_of = u32::MAX;
            for side in [&mut contact.a, &mut contact.b] {
                if let ContactSide::Body { body, local } = side {
                    part_of = *body;
                    let part =
                        self.work.parts.get(*body as usize).and_then(|p| self.surroundings.colliders.get(*p as usize));
                    if let Some(part) = part {
                        *local = part.frame.world(*local);
                    }
                    *body = self.work.of_part.get(*body as usize).copied().unwrap_or(0);
                }
            }
            found.colliders.push(part_of);
        }
        resolve_compression(island, &mut found.contacts);
        if island.sheets.iter().any(|sheet| !sheet.pins.is_empty()) {
            found.remove_immovable(island);
            let body_of = |index: usize| self.work.bodies.binary_search(&(index as u32)).ok();
            found.remove_attached(|sheet, mass, body| {
                let mut glued = island.sheet(sheet).pins.dynamic_attachments();
                glued.any(|(m, index, _)| m == mass && body_of(index) == Some(body as usize))
            });
        }
        self.add_attachments_and_body_contacts(island, found);
    }

    /// Largest spin of the dynamic bodies with corners that may meet a sheet in this step, rad/s.
    pub fn max_body_spin(&self, island: &IslandView) -> f64 {
        let spin = |part: u32| {
            let of = self.surroundings.colliders.get(self.work.part(part)? as usize)?;
            let solver_body = island.solver_bodies.get(*self.work.of_part.get(part as usize)? as usize)?;
            (solver_body.is_dynamic() && of.features.has_corners()).then(|| solver_body.start.spin().length())
        };
        self.work.finder.near_bodies().filter_map(spin).fold(0.0, f64::max)
    }

    /// Set the bodies to their state at the end of the stage.
    pub fn end_stage(&mut self, island: &mut IslandView) {
        island.solver_bodies.iter_mut().for_each(|solver_body| solver_body.start = solver_body.end());
    }
}

/// Penetration of two bodies that a step removes, m. A fast body can penetrate deeply before Rapier
/// detects it; the penetration that Rapier itself allows is left.
fn depenetration_of(contact: &BodyContact) -> f64 {
    SETTINGS.penetration_recovery * (-contact.distance - SETTINGS.penetration_tolerance).max(0.0)
}

/// Add the bodies that touch `bodies`, transitively through dynamic bodies, which pass forces on.
/// Leaves the list ascending.
fn add_touching_bodies(bodies: &mut Vec<u32>, contacts: &[BodyContact], surroundings: &StepBodies) {
    bodies.sort_unstable();
    bodies.dedup();
    let mut grown = true;
    while std::mem::take(&mut grown) {
        for c in contacts {
            for (from, to) in [(c.a, c.b), (c.b, c.a)] {
                if surroundings.bodies[from].start.is_dynamic()
                    && bodies.binary_search(&(from as u32)).is_ok()
                    && let Err(at) = bodies.binary_search(&(to as u32))
                {
                    bodies.insert(at, to as u32);
                    grown = true;
                }
            }
        }
    }
}

/// Number of dynamic bodies in `bodies` that touch another dynamic body.
fn count_leaning_bodies(bodies: &[u32], contacts: &[BodyContact], surroundings: &StepBodies) -> usize {
    let gives = |index: usize| surroundings.bodies[index].start.is_dynamic();
    let leans = |index: usize| contacts.iter().any(|c| (c.a == index || c.b == index) && gives(c.a) && gives(c.b));
    bodies.iter().filter(|index| leans(**index as usize)).count()
}

/// Weight θ of gravity and bond forces in a stage of `span` (s), Δx = v h + θ a h². The value is
/// that of the sheets' implicit integrator: with another, a body on a sheet would exert different
/// forces in the position solve and in the velocity solve. In the short steps of explicit
/// integrators the difference is negligible.
fn gravity_weight(island: &IslandView, span: f64) -> f64 {
    let lead = island.sheets.first();
    lead.filter(|sheet| !node_contact::is_explicit(sheet)).map_or(0.5, |sheet| stage::drift(sheet, span))
}

/// State of a body after a force (N) at `at` (m) over `span` (s), with displacement weight `drift`.
fn apply_force(free: &BodyState, force: DVec3, at: DVec3, (span, drift): (f64, f64)) -> BodyState {
    let turn = free.inverse_inertia() * (at - free.centre()).cross(force);
    let moved = free.displaced(force * (drift * span * span * free.inverse_mass()), turn * (drift * span * span));
    moved.with_impulse_at(force * span, at)
}

/// Frame `inner`, given in the axes of `outer`, in the world.
pub(super) fn in_world(outer: &RigidFrame, inner: &RigidFrame) -> RigidFrame {
    RigidFrame { origin: outer.world(inner.origin), rotation: outer.rotation * inner.rotation }
}

/// Empty list that reuses the allocation of a list of another lifetime.
fn reuse_allocation<A, B>(mut list: Vec<A>) -> Vec<B> {
    list.clear();
    list.into_iter().filter_map(|_| None).collect()
}
