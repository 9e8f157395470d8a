//! Contact detection of an island, stage by stage: placement of bodies, detection, and mapping of
//! contacts from colliders to bodies. Attachments and contacts between bodies are added as
//! contacts.

use glam::DVec3;

use crate::collision::collision_surface::Skin;
use crate::collision::constraint::{Contact, Side};
use crate::collision::narrow_phase::{BodyMotion, FindCounters, Finder, Pair, Problem, Scope, SheetMotion};
use crate::contact::Group;
use crate::contact::adhesion::on_bodies;
use crate::contact::detected::Found;
use crate::contact::gap::mass_point;
use crate::contact::outer_iteration::{Look, Margins};
use crate::contact::solver_body::{Mover, frame};
use crate::contact::step_bodies::Surroundings;
use crate::islands::implicit_step::Find;
use crate::math::RigidFrame;
use crate::math::Vectors;
use crate::profiler::{Phase, Watched};
use crate::rigid::settings::RigidSettings;
use crate::rigid::{BodyContact, BodyState, RigidView};
use crate::serialize::{Keeper, Taken, Taker};
use crate::sheet::Crossing;

const SETTINGS: RigidSettings = RigidSettings::DEFAULT;

/// Contact cache keys of attachments and of contacts between bodies; keys of sheet contacts are
/// smaller.
const GLUE: u64 = u64::MAX;
const BODIES: u64 = u64::MAX - 1;

/// State of detection between steps.
#[derive(Default)]
pub(crate) struct NearWork {
    finder: Finder,
    /// Parts and bodies of the surroundings in reach, ascending, and the island's body of each
    /// part.
    parts: Vec<u32>,
    bodies: Vec<u32>,
    of_part: Vec<u32>,
    sheet_motions: Vec<SheetMotion<'static>>,
    body_motions: Vec<BodyMotion<'static>>,
    /// Positions of the nodes of a lone sheet after the contact solution, m.
    moved: Vectors,
    /// Sheets of the island that interpenetrate.
    crossing: Vec<u32>,
}

impl NearWork {
    /// Counters of detection.
    pub fn counters(&self) -> FindCounters {
        self.finder.counters()
    }

    /// Serialise the state of detection for a snapshot.
    pub fn keep(&self, to: &mut Keeper) {
        self.finder.keep(to);
    }

    /// Whether the cache has data of sheet `index`.
    pub fn knows(&self, index: u32) -> bool {
        self.finder.knows(index)
    }

    /// Deserialise the state of detection; `skin` returns the collision surface of a sheet by
    /// index.
    pub fn taken<'s>(from: &mut Taker, skin: impl Fn(u32) -> Option<&'s Skin>) -> Taken<Self> {
        Ok(Self { finder: Finder::taken(from, skin)?, ..Self::default() })
    }

    /// Set the features that are detected from the next step on.
    pub fn limit(&mut self, scope: Scope) {
        self.finder.limit(scope);
    }

    /// Whether a sheet may have self-contact in this step.
    pub fn folds(&self) -> bool {
        self.finder.folds()
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
pub(crate) struct Near<'a> {
    pub view: Option<&'a RigidView<'a>>,
    pub surroundings: &'a Surroundings,
    pub body_contacts: &'a [BodyContact],
    pub gravity: DVec3,
    pub sheets_meet: bool,
    /// Index in the world of the first sheet of the slice.
    pub first: u32,
    pub work: &'a mut NearWork,
    pub watch: &'a Watched,
}

impl Near<'_> {
    /// Find the parts near the island's box (m), which no object leaves by more than `reach` (m),
    /// and create the movers.
    pub fn begin(&mut self, group: &mut Group, (low, high): (DVec3, DVec3), reach: f64) {
        let NearWork { parts, bodies, of_part, .. } = &mut *self.work;
        parts.clear();
        bodies.clear();
        of_part.clear();
        group.movers.clear();
        let (low, high) = (low - reach, high + reach);
        for (i, part) in self.surroundings.parts.iter().enumerate() {
            if part.low.cmple(high).all() && part.high.cmpge(low).all() {
                parts.push(i as u32);
                bodies.push(part.body);
            }
        }
        for member in group.members {
            for (_, index, _) in group.sheets[*member as usize].pins.glued() {
                bodies.push(index as u32);
            }
        }
        take_along(bodies, self.body_contacts, self.surroundings);
        for index in bodies.iter() {
            group.movers.push(Mover::new(self.surroundings.bodies[*index as usize].start));
        }
        group.lift = 0.0;
        for c in self.body_contacts.iter().filter(|c| c.distance < -SETTINGS.penetration_tolerance) {
            if [c.a, c.b].iter().any(|index| bodies.binary_search(&(*index as u32)).is_ok()) {
                group.lift = group.lift.max(recovered(c));
            }
        }
        group.leaning = leaning(bodies, self.body_contacts, self.surroundings);
        for part in parts.iter() {
            let body = self.surroundings.parts[*part as usize].body;
            of_part.push(bodies.binary_search(&body).unwrap_or(0) as u32);
        }
        self.ask(group, Look::First, Margins::NARROW, |finder, problem| finder.begin(problem, reach));
        let in_doubt = |i: &u32| group.sheets[*i as usize].crossing != Crossing::No;
        if self.sheets_meet && group.members.iter().any(in_doubt) {
            self.leave_out_crossing(group);
        }
    }

    /// Disable contact between interpenetrating sheets, among those not known to be apart.
    fn leave_out_crossing(&mut self, group: &mut Group) {
        let mut crossing = std::mem::take(&mut self.work.crossing);
        crossing.clear();
        let in_doubt = |local: u32| group.sheet(local).crossing != Crossing::No;
        if group.members.len() > 1 {
            self.ask(group, Look::First, Margins::NARROW, |finder, problem| {
                finder.leave_out_crossing(problem, in_doubt, &mut crossing);
            });
        }
        for (local, member) in group.members.iter().enumerate() {
            let sheet = &mut group.sheets[*member as usize];
            sheet.crossing = match sheet.crossing {
                _ if !crossing.contains(&(local as u32)) => Crossing::No,
                Crossing::Told => Crossing::Told,
                _ => Crossing::Seen,
            };
        }
        self.work.crossing = crossing;
    }

    /// Whether contact is impossible in this step.
    pub fn is_idle(&self, group: &Group) -> bool {
        self.work.finder.is_idle() && !group.members.iter().any(|member| group.sheets[*member as usize].is_glued())
    }

    /// Call `ask` with the finder and the problem of `look`.
    fn ask(&mut self, group: &Group, look: Look, margins: Margins, ask: impl FnOnce(&mut Finder, &Problem)) {
        let mut sheets: Vec<SheetMotion> = reused(std::mem::take(&mut self.work.sheet_motions));
        let mut bodies: Vec<BodyMotion> = reused(std::mem::take(&mut self.work.body_motions));
        let mut finder = std::mem::take(&mut self.work.finder);
        let mut moved = std::mem::take(&mut self.work.moved);
        if look == Look::Moved
            && let [only] = group.members
        {
            let (work, unit) = (&group.sheets[*only as usize].work, &group.contacts[*only as usize].unit);
            if moved.len() != work.stage.free.len() {
                moved = Vectors::zeros(work.stage.free.len());
            }
            moved.copy_from(&work.stage.free);
            if unit.is_touched() {
                moved.add_scaled(1.0, &unit.jump.dx);
            }
        }
        finder.use_threads(group.parallel);
        finder.look_for_crossings(look == Look::Crossed);
        for member in group.members {
            let sheet = &group.sheets[*member as usize];
            let Some(skin) = &group.contacts[*member as usize].surface else { continue };
            let stage = &sheet.work.stage;
            let begun = stage.free.len() == sheet.masses();
            let reached = matches!(look, Look::Again | Look::Reached);
            let base = if reached && begun { &stage.iterate } else { &sheet.x };
            let end = match look {
                Look::Reached | Look::Crossed => &stage.iterate,
                Look::Moved => &moved,
                _ if begun => &stage.free,
                _ => &sheet.x,
            };
            sheets.push(SheetMotion { id: self.first + member, skin, start: &sheet.x, base, end, awake: true });
        }
        let bodies_too = if look == Look::Crossed { 0 } else { self.work.parts.len() };
        for (part, body) in self.work.parts.iter().zip(&self.work.of_part).take(bodies_too) {
            let of = &self.surroundings.parts[*part as usize];
            let mover = &group.movers[*body as usize];
            let base = if matches!(look, Look::First | Look::Moved) { frame(&mover.start) } else { mover.end_frame() };
            let end = if matches!(look, Look::Reached | Look::Moved) { mover.end_frame() } else { frame(&mover.free) };
            bodies.push(BodyMotion {
                id: *part,
                features: &of.features,
                start: in_world(&frame(&mover.start), &of.frame),
                base: in_world(&base, &of.frame),
                end: in_world(&end, &of.frame),
                awake: true,
            });
        }
        let between = (look != Look::Reached && self.sheets_meet).then_some(margins.sheets);
        let coefficients = |pair| self.coefficients(group, pair);
        let problem =
            Problem { sheets: &sheets, bodies: &bodies, margin: margins.bodies, between, surfaces: &coefficients };
        self.watch.within(Phase::Detection, || ask(&mut finder, &problem));
        self.work.finder = finder;
        self.work.sheet_motions = reused(sheets);
        self.work.body_motions = reused(bodies);
        self.work.moved = moved;
    }

    fn coefficients(&self, group: &Group, pair: Pair) -> (f64, f64) {
        match pair {
            Pair::SheetBody(sheet, part) => {
                let sheet = group.sheet(sheet);
                let part = self.work.parts.get(part as usize).and_then(|p| self.surroundings.parts.get(*p as usize));
                let known = self.view.zip(part).and_then(|(view, part)| {
                    Some(view.coefficients(sheet.surface_coefficients(), part.handle, view.colliders.get(part.handle)?))
                });
                known.unwrap_or((sheet.friction, sheet.restitution))
            }
            Pair::Sheets(a, b) => {
                let (a, b) = (group.sheet(a), group.sheet(b));
                let mean = (0.5 * (a.friction + b.friction), 0.5 * (a.restitution + b.restitution));
                self.view.map_or(mean, |v| v.between(&a.material().name, &b.material().name, mean))
            }
        }
    }

    /// Contact point on the island's body `mover`, with index `index`, at the end of the stage: the
    /// same body point as at the start of the step, or, on a ball that rolls, the body point that
    /// has moved to the same place.
    fn point(&self, group: &Group, (mover, index): (u32, usize), at_start: DVec3, is_round: bool) -> Side {
        let turned = || {
            let there = self.surroundings.bodies[index].start.rotation() * at_start;
            group.movers[mover as usize].free.rotation().conjugate() * there
        };
        Side::Body { body: mover, local: if is_round { turned() } else { at_start } }
    }

    /// Add contacts between bodies, and attachments.
    fn join(&self, group: &Group, found: &mut Found) {
        let mover = |index: usize| self.work.bodies.binary_search(&(index as u32)).ok().map(|i| i as u32);
        for c in self.body_contacts {
            let (Some(a), Some(b)) = (mover(c.a), mover(c.b)) else { continue };
            found.contacts.push(Contact {
                a: self.point(group, (a, c.a), c.on_a, c.round[0]),
                b: self.point(group, (b, c.b), c.on_b, c.round[1]),
                normal: c.normal,
                offset: c.distance.min(0.0) + recovered(c),
                key: [BODIES - (c.key[0] & 0xffff_ffff), c.key[1] ^ c.key[0].rotate_left(17)],
                friction: c.friction,
                restitution: c.restitution,
            });
        }
        found.glue_from = found.contacts.len();
        for (local, member) in group.members.iter().enumerate() {
            for (mass, index, place) in group.sheets[*member as usize].pins.glued() {
                let Some(body) = mover(index) else { continue };
                found.contacts.push(Contact {
                    a: mass_point(local as u32, mass),
                    b: Side::Body { body, local: place },
                    normal: DVec3::Y,
                    offset: 0.0,
                    key: [GLUE, (u64::from(self.first + member) << 32 | u64::from(mass)) ^ (index as u64) << 48],
                    friction: 0.0,
                    restitution: 0.0,
                });
            }
        }
    }
}

impl Find for Near<'_> {
    fn begin_stage(&mut self, group: &mut Group, from: f64, to: f64) {
        let (span, weight) = (to - from, drift(group, to - from));
        for (mover, index) in group.movers.iter_mut().zip(&self.work.bodies) {
            let over = &self.surroundings.bodies[*index as usize];
            if mover.start.gives() {
                let mut free = mover.start.fly(span, self.gravity);
                if weight > 0.5 {
                    free = free.displaced(self.gravity * ((weight - 0.5) * span * span), DVec3::ZERO);
                }
                on_bodies(group.sheets, group.members, |body, force, at| {
                    if body == *index {
                        free = pulled(&free, force, mover.start.place(at), (span, weight));
                    }
                });
                mover.begin(free);
            } else {
                mover.start = over.start.fly(from, DVec3::ZERO);
                mover.begin(over.start.fly(to, DVec3::ZERO));
            }
        }
    }

    fn find(&mut self, group: &Group, look: Look, margins: Margins, found: &mut Found) {
        let mut contacts = std::mem::take(&mut found.contacts);
        self.ask(group, look, margins, |finder, problem| finder.find(problem, &mut contacts));
        found.cut = self.work.finder.has_cut();
        if !self.sheets_meet {
            contacts.retain(|c| !matches!((c.a, c.b), (Side::Sheet { .. }, Side::Sheet { .. })));
        }
        found.contacts = contacts;
        found.parts.clear();
        for contact in &mut found.contacts {
            let mut part_of = u32::MAX;
            for side in [&mut contact.a, &mut contact.b] {
                if let Side::Body { body, local } = side {
                    part_of = *body;
                    let part =
                        self.work.parts.get(*body as usize).and_then(|p| self.surroundings.parts.get(*p as usize));
                    if let Some(part) = part {
                        *local = part.frame.world(*local);
                    }
                    *body = self.work.of_part.get(*body as usize).copied().unwrap_or(0);
                }
            }
            found.parts.push(part_of);
        }
        if group.members.iter().any(|i| !group.sheets[*i as usize].pins.is_empty()) {
            found.leave_out_jammed(group);
            let body_of = |index: usize| self.work.bodies.binary_search(&(index as u32)).ok();
            found.leave_out_glued(|sheet, mass, body| {
                let mut glued = group.sheet(sheet).pins.glued();
                glued.any(|(m, index, _)| m == mass && body_of(index) == Some(body as usize))
            });
        }
        self.join(group, found);
    }

    fn spin(&self, group: &Group) -> f64 {
        let spin = |part: u32| {
            let of = self.surroundings.parts.get(self.work.part(part)? as usize)?;
            let mover = group.movers.get(*self.work.of_part.get(part as usize)? as usize)?;
            (mover.gives() && of.features.has_corners()).then(|| mover.start.spin().length())
        };
        self.work.finder.near_bodies().filter_map(spin).fold(0.0, f64::max)
    }

    fn end_stage(&mut self, group: &mut Group) {
        group.movers.iter_mut().for_each(|mover| mover.start = mover.end());
    }
}

/// Penetration of two bodies that a step removes, m. A fast body can penetrate deeply before Rapier
/// detects it; the penetration that Rapier itself allows is left.
fn recovered(contact: &BodyContact) -> f64 {
    SETTINGS.penetration_recovery * (-contact.distance - SETTINGS.penetration_tolerance).max(0.0)
}

/// Add the bodies that touch `bodies`, transitively through dynamic bodies, which pass forces on.
/// Leaves the list ascending.
fn take_along(bodies: &mut Vec<u32>, contacts: &[BodyContact], surroundings: &Surroundings) {
    bodies.sort_unstable();
    bodies.dedup();
    let mut grown = true;
    while std::mem::take(&mut grown) {
        for c in contacts {
            for (from, to) in [(c.a, c.b), (c.b, c.a)] {
                if surroundings.bodies[from].start.gives()
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
fn leaning(bodies: &[u32], contacts: &[BodyContact], surroundings: &Surroundings) -> usize {
    let gives = |index: usize| surroundings.bodies[index].start.gives();
    let leans = |index: usize| contacts.iter().any(|c| (c.a == index || c.b == index) && gives(c.a) && gives(c.b));
    bodies.iter().filter(|index| leans(**index as usize)).count()
}

/// Weight θ of gravity and bond forces in a stage of `span` (s), Δx = v h + θ a h². The value is
/// that of the sheets' implicit integrator: with another, a body on a sheet would exert different
/// forces in the position solve and in the velocity solve. In the short steps of explicit
/// integrators the difference is negligible.
fn drift(group: &Group, span: f64) -> f64 {
    let lead = group.members.first().map(|i| &group.sheets[*i as usize]);
    lead.filter(|sheet| !sheet.is_explicit()).map_or(0.5, |sheet| sheet.drift(span))
}

/// State of a body after a force (N) at `at` (m) over `span` (s), with displacement weight `drift`.
fn pulled(free: &BodyState, force: DVec3, at: DVec3, (span, drift): (f64, f64)) -> BodyState {
    let turn = free.inverse_inertia() * (at - free.centre()).cross(force);
    let moved = free.displaced(force * (drift * span * span * free.inverse_mass()), turn * (drift * span * span));
    moved.kicked(force * span, at)
}

/// Frame `inner`, given in the axes of `outer`, in the world.
fn in_world(outer: &RigidFrame, inner: &RigidFrame) -> RigidFrame {
    RigidFrame { origin: outer.world(inner.origin), rotation: outer.rotation * inner.rotation }
}

/// Empty list that reuses the allocation of a list of another lifetime.
fn reused<A, B>(mut list: Vec<A>) -> Vec<B> {
    list.clear();
    list.into_iter().filter_map(|_| None).collect()
}
