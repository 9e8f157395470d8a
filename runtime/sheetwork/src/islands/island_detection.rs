//! What a group of sheets may touch, stage by stage: bodies are put where they are, detection is asked, and its rows are
//! brought from colliders to bodies. Glue and contacts of bodies with each other join them.

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
use crate::rigid::{BodyContact, BodyState, RigidView};
use crate::serialize::{Keeper, Taken, Taker};
use crate::sheet::{Crossing, Sheet};

/// Key of glue, and of contacts between bodies: detection's are below.
const GLUE: u64 = u64::MAX;
const BODIES: u64 = u64::MAX - 1;

/// Part of an overlap of two bodies that a step takes back, and overlap that is none, m.
const RECOVERED: f64 = 0.2;
const LET_BE: f64 = 1e-4;

/// Detection's memory from step to step.
#[derive(Default)]
pub(crate) struct NearWork {
    finder: Finder,
    /// Parts and bodies of the surroundings that are near, ascending, and the group's body of each part.
    parts: Vec<u32>,
    bodies: Vec<u32>,
    of_part: Vec<u32>,
    sheet_motions: Vec<SheetMotion<'static>>,
    body_motions: Vec<BodyMotion<'static>>,
    /// Where contact moves the masses of the group's sheet, m.
    moved: Vectors,
    /// Sheets of the group that go through one another.
    crossing: Vec<u32>,
}

impl NearWork {
    /// What detection has done.
    pub fn counters(&self) -> FindCounters {
        self.finder.counters()
    }

    /// Keeps detection's memory for a snapshot.
    pub fn keep(&self, to: &mut Keeper) {
        self.finder.keep(to);
    }

    /// Whether it remembers sheet number `index`.
    pub fn knows(&self, index: u32) -> bool {
        self.finder.knows(index)
    }

    /// What was kept; `skin` finds the surface of a sheet by its number.
    pub fn taken<'s>(from: &mut Taker, skin: impl Fn(u32) -> Option<&'s Skin>) -> Taken<Self> {
        Ok(Self { finder: Finder::taken(from, skin)?, ..Self::default() })
    }

    /// Looks for this from the next step on.
    pub fn limit(&mut self, scope: Scope) {
        self.finder.limit(scope);
    }

    /// Whether some sheet may meet itself in this step.
    pub fn folds(&self) -> bool {
        self.finder.folds()
    }

    /// Bodies of the group, by number in the surroundings.
    pub fn bodies(&self) -> &[u32] {
        &self.bodies
    }

    /// Of a contact's `part`, the number in the surroundings.
    pub fn part(&self, part: u32) -> Option<u32> {
        self.parts.get(part as usize).copied()
    }
}

/// Detection for one group over one step.
pub(crate) struct Near<'a> {
    pub view: Option<&'a RigidView<'a>>,
    pub surroundings: &'a Surroundings,
    pub body_contacts: &'a [BodyContact],
    pub gravity: DVec3,
    pub sheets_meet: bool,
    /// Number of the first sheet among the world's, for a group that is given alone.
    pub first: u32,
    pub work: &'a mut NearWork,
    pub watch: &'a Watched,
}

impl Near<'_> {
    /// Finds which parts are near the box (m) of the group, which nothing in it leaves by more than `reach`; makes the movers.
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
        for c in self.body_contacts.iter().filter(|c| c.distance < -LET_BE) {
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

    /// Leaves out contact between sheets that go through one another, of those of which it is not known that they do not.
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

    /// Whether nothing can touch in this step.
    pub fn is_idle(&self, group: &Group) -> bool {
        self.work.finder.is_idle() && !group.members.iter().any(|member| group.sheets[*member as usize].is_glued())
    }

    /// Calls `ask` with detection and its problem for what `look` says.
    fn ask(&mut self, group: &Group, look: Look, margins: Margins, ask: impl FnOnce(&mut Finder, &Problem)) {
        let mut sheets: Vec<SheetMotion> = reused(std::mem::take(&mut self.work.sheet_motions));
        let mut bodies: Vec<BodyMotion> = reused(std::mem::take(&mut self.work.body_motions));
        let mut finder = std::mem::take(&mut self.work.finder);
        let mut moved = std::mem::take(&mut self.work.moved);
        if look == Look::Moved
            && let [only] = group.members
        {
            let work = &group.sheets[*only as usize].work;
            if moved.len() != work.stage.free.len() {
                moved = Vectors::zeros(work.stage.free.len());
            }
            moved.copy_from(&work.stage.free);
            if work.unit.is_touched() {
                moved.add_scaled(1.0, &work.unit.jump.dx);
            }
        }
        finder.use_threads(group.parallel);
        finder.look_for_crossings(look == Look::Crossed);
        for member in group.members {
            let sheet = &group.sheets[*member as usize];
            let Some(skin) = &sheet.work.skin else { continue };
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
                    Some(view.coefficients(sheet, part.handle, view.colliders.get(part.handle)?))
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

    /// The point of the group's body `mover` with which body `index` touches another at the end of the stage, given the point of the start of
    /// the step: that very point, or of a ball, which rolls over it, the one that has come to where it was.
    fn point(&self, group: &Group, (mover, index): (u32, usize), at_start: DVec3, is_round: bool) -> Side {
        let turned = || {
            let there = self.surroundings.bodies[index].start.rotation() * at_start;
            group.movers[mover as usize].free.rotation().conjugate() * there
        };
        Side::Body { body: mover, local: if is_round { turned() } else { at_start } }
    }

    /// Adds contacts of bodies with each other, and glue.
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

/// How much of an overlap of two bodies a step takes back, m. A body that comes down fast is deep in what it hits before Rapier knows of it; what
/// Rapier itself lets overlap is let be.
fn recovered(contact: &BodyContact) -> f64 {
    RECOVERED * (-contact.distance - LET_BE).max(0.0)
}

/// Takes what touches `bodies` along with them, and what touches that: who pushes a body pushes on what it leans against. What does not give
/// way passes nothing on. Leaves them ascending.
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

/// How many of `bodies` that give way touch another that does.
fn leaning(bodies: &[u32], contacts: &[BodyContact], surroundings: &Surroundings) -> usize {
    let gives = |index: usize| surroundings.bodies[index].start.gives();
    let leans = |index: usize| contacts.iter().any(|c| (c.a == index || c.b == index) && gives(c.a) && gives(c.b));
    bodies.iter().filter(|index| leans(**index as usize)).count()
}

/// Weight θ with which gravity and bonds move bodies in a stage of `span` s, Δx = v h + θ a h²: that of the sheets' implicit engine, or a body
/// that a sheet carries would press on it with another force when its place is solved for than when its velocity is. In the short
/// steps of explicit ones a sheet is not stiff, and the two come to the same.
fn drift(group: &Group, span: f64) -> f64 {
    let lead = group.members.first().map(|i| &group.sheets[*i as usize]);
    lead.filter(|sheet| !sheet.is_explicit()).map_or(0.5, |sheet| sheet.drift(span))
}

/// A body that a force (N) at `at` (m) has pulled for `span` s, moved with weight `drift`.
fn pulled(free: &BodyState, force: DVec3, at: DVec3, (span, drift): (f64, f64)) -> BodyState {
    let turn = free.inverse_inertia() * (at - free.centre()).cross(force);
    let moved = free.displaced(force * (drift * span * span * free.inverse_mass()), turn * (drift * span * span));
    moved.kicked(force * span, at)
}

/// The frame `inner` of the axes of `outer`, in the world.
fn in_world(outer: &RigidFrame, inner: &RigidFrame) -> RigidFrame {
    RigidFrame { origin: outer.world(inner.origin), rotation: outer.rotation * inner.rotation }
}

/// An empty list in the memory of another whose elements had another lifetime.
fn reused<A, B>(mut list: Vec<A>) -> Vec<B> {
    list.clear();
    list.into_iter().filter_map(|_| None).collect()
}

/// Makes sure the sheet has its contact surface.
pub(crate) fn skin(sheet: &mut Sheet) {
    if sheet.work.skin.is_none() {
        sheet.work.skin = Some(Box::new(Skin::of(sheet)));
    }
}
