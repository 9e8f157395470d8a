//! Adhesion: what has touched while hot is held on by a force, and lets go when pulled harder or when cold.
//!
//! Solvers know nothing of it. After a step every closed contact of a mass of a sticky sheet that is warm enough, or that stuck
//! before and is not too cold, is a bond; in the next step the two sides are pulled together with a constant force along the contact's
//! normal, as if it were one of the scene's own. The contact then bears p + f, which is 0 or more for a load that pulls by up to f, and
//! friction goes up to μ (p + f). A bond that is pulled harder opens, is no closed contact after the step, and is gone.
//!
//! f is at most σ A, with σ the material's strength (Pa) and A the area of the sheet that falls to the mass (half of that between two
//! sheets, whose masses meet each other's triangles, where they all do); a mass shares it between the features that are on the same side of the
//! sheet. Edges and corners that no mass touches hold nothing. As f takes the free motion
//! of the masses far into what they stick to, no more is used of σ A than there may be need for: what accelerates the mass by
//! `RESERVE`, or twice what the bond bore in the last step, across and along, whichever is more. So a load has to grow faster than twofold
//! in a step, from 200 m/s², to part what σ would hold.

use glam::DVec3;

use super::row::{Contact, SheetPoint, Side};
use super::stage::Scratch;
use super::surroundings::Surroundings;
use crate::heat::REFERENCE;
use crate::kept::{Cut, Keeper, Taken, Taker};
use crate::scene::Tack;
use crate::sheet::{Sheet, Vectors};

/// Acceleration that a bond can bear without a warning, m/s²: of the mass, and of a body that hangs on it.
const RESERVE: f64 = 200.0;
const RESERVE_OF_BODY: f64 = 20.0;
/// How much more than in the last step a bond can bear.
const GROWTH: f64 = 2.0;

/// What holds a sheet on to other things.
#[derive(Clone, Debug, Default)]
pub(crate) struct Stuck {
    /// Force on each mass, N, and that of the step before.
    pull: Vectors,
    was_pull: Vectors,
    /// Force (N) on bodies that give way, at a place in their own frame (m); bodies by number in the surroundings.
    on_bodies: Vec<(u32, DVec3, DVec3)>,
    /// Whether each mass sticks to something.
    held: Vec<bool>,
    was_held: Vec<bool>,
    /// Where the first contact of each mass is from it, and how many there are on that side and on the other.
    towards: Vec<DVec3>,
    count: Vec<[u32; 2]>,
    /// The scene's own forces, while the others are with them.
    applied: Vectors,
    /// How many masses stick.
    bonds: usize,
}

impl Stuck {
    /// Keeps it for a snapshot.
    pub fn keep(&self, to: &mut Keeper) {
        to.vector_list(&self.pull);
        to.vector_list(&self.was_pull);
        to.count(self.on_bodies.len() as u64);
        for (body, force, at) in &self.on_bodies {
            to.count(u64::from(*body));
            to.vector(*force);
            to.vector(*at);
        }
        to.flags(&self.held);
        to.flags(&self.was_held);
        to.count(self.bonds as u64);
    }

    /// What was kept, of a sheet of `masses` masses.
    pub fn taken(from: &mut Taker, masses: usize) -> Taken<Self> {
        let mut stuck = Self::default();
        from.vector_list(&mut stuck.pull, masses)?;
        from.vector_list(&mut stuck.was_pull, masses)?;
        for _ in 0..from.length(49)? {
            stuck.on_bodies.push((from.small()?, from.vector()?, from.vector()?));
        }
        from.flags(&mut stuck.held)?;
        from.flags(&mut stuck.was_held)?;
        stuck.bonds = from.length(0)?;
        if [stuck.pull.len(), stuck.was_pull.len(), stuck.held.len(), stuck.was_held.len()] != [masses; 4] {
            return Err(Cut);
        }
        (stuck.count, stuck.towards) = (vec![[0; 2]; masses], vec![DVec3::ZERO; masses]);
        stuck.applied = Vectors::zeros(masses);
        Ok(stuck)
    }

    fn begin(&mut self, masses: usize) {
        if self.held.len() != masses {
            *self = Self { pull: Vectors::zeros(masses), held: vec![false; masses], ..Self::default() };
            (self.was_held, self.count) = (vec![false; masses], vec![[0; 2]; masses]);
            self.towards = vec![DVec3::ZERO; masses];
            (self.applied, self.was_pull) = (Vectors::zeros(masses), Vectors::zeros(masses));
        }
        std::mem::swap(&mut self.held, &mut self.was_held);
        std::mem::swap(&mut self.pull, &mut self.was_pull);
        self.held.fill(false);
        self.count.fill([0; 2]);
        self.pull.clear();
        self.on_bodies.clear();
        self.bonds = 0;
    }

    /// Counts a contact of mass `i` that is on its side `towards`.
    fn has_contact(&mut self, i: u32, towards: DVec3) {
        let i = i as usize;
        if self.count[i] == [0; 2] {
            self.towards[i] = towards;
        }
        self.count[i][usize::from(self.towards[i].dot(towards) < 0.0)] += 1;
    }

    /// How many contacts mass `i` has on its side `towards`.
    fn contacts(&self, i: u32, towards: DVec3) -> u32 {
        let i = i as usize;
        self.count[i][usize::from(self.count[i] != [0; 2] && self.towards[i].dot(towards) < 0.0)]
    }
}

impl Sheet {
    /// How many masses of it stick to something.
    pub fn bonds(&self) -> usize {
        self.work.stuck.as_ref().map_or(0, |s| s.bonds)
    }

    /// Adds to its forces those of what it sticks to.
    pub(crate) fn hold_on(&mut self) {
        if let Some(stuck) = &mut self.work.stuck {
            stuck.applied.copy_from(&self.applied);
            self.applied.add_scaled(1.0, &stuck.pull);
        }
    }

    /// Takes them off again.
    pub(crate) fn hold_no_more(&mut self) {
        if let Some(stuck) = &self.work.stuck {
            self.applied.copy_from(&stuck.applied);
        }
    }

    /// Lets go of everything.
    pub(crate) fn unstick(&mut self) {
        let masses = self.masses();
        if let Some(stuck) = &mut self.work.stuck {
            stuck.begin(masses);
        }
    }

    /// Temperature of mass `i`, °C.
    fn celsius(&self, i: u32) -> f64 {
        let of_mass = self.temperatures().and_then(|t| t.get(i as usize).copied());
        of_mass.or_else(|| self.temperature()).unwrap_or(REFERENCE)
    }

    /// Strength of what sticks at a point of it, Pa, if it is warm enough there; `stuck` says that it did before.
    fn strength(&self, point: &SheetPoint, stuck: bool) -> f64 {
        let Some(Tack { strength, above, lets_go_below }) = self.tack() else { return 0.0 };
        let celsius: f64 = point.terms().map(|(i, w)| w * self.celsius(i)).sum();
        let holds = stuck && lets_go_below.is_none_or(|limit| celsius >= limit);
        if celsius >= above || holds { strength } else { 0.0 }
    }
}

/// The forces on the bodies that give way of some sheets: calls `push` with the body's number, force (N) and place in its frame (m).
pub(crate) fn on_bodies(sheets: &[Sheet], members: &[u32], mut push: impl FnMut(u32, DVec3, DVec3)) {
    for stuck in members.iter().filter_map(|i| sheets[*i as usize].work.stuck.as_ref()) {
        stuck.on_bodies.iter().for_each(|(body, force, at)| push(*body, *force, *at));
    }
}

/// Finds what sticks after a step of `members`; `body_of` is the number in the surroundings of a contact's body.
pub(crate) fn stick(sheets: &mut [Sheet], members: &[u32], scratch: &Scratch, around: &Surroundings, bodies: &[u32]) {
    let is_sticky = |i: &u32| sheets[*i as usize].tack().is_some();
    if !members.iter().any(is_sticky) {
        return;
    }
    for i in members.iter().map(|i| *i as usize) {
        let masses = sheets[i].masses();
        sheets[i].work.stuck.get_or_insert_default().begin(masses);
    }
    scratch.closed(|contact, _| {
        if let Some((sheet, mass, _)) = of_mass(contact)
            && let Some(stuck) = &mut sheets[members[sheet as usize] as usize].work.stuck
        {
            stuck.has_contact(mass, towards(contact));
        }
    });
    let hanging = |body: u32| {
        let mut rows = 0.0;
        scratch.closed(|c, _| rows += if other_body(c) == Some(body) { 1.0 } else { 0.0 });
        rows
    };
    let mut last = (u32::MAX, 0.0);
    scratch.closed(|contact, _| {
        let Some((sheet, mass, point)) = of_mass(contact) else { return };
        let own = &sheets[members[sheet as usize] as usize];
        let Some(stuck) = &own.work.stuck else { return };
        let was = stuck.was_held[mass as usize];
        let (mut strength, mut share) = (own.strength(&point, was), 1.0);
        if let Some((other, place)) = other_sheet(contact) {
            let other = &sheets[members[other as usize] as usize];
            strength = strength.max(other.strength(&place, was));
            // Masses there that have no contacts of their own are told of by this one.
            let silent = |i: u32| other.work.stuck.as_ref().is_some_and(|s| s.contacts(i, -towards(contact)) == 0);
            share = 0.5 * (1.0 + place.terms().filter(|(i, _)| silent(*i)).map(|(_, w)| w).sum::<f64>());
        }
        if strength <= 0.0 {
            return;
        }
        let mut need = RESERVE * own.mass(mass as usize);
        let body = other_body(contact).and_then(|b| Some((b, around.bodies.get(*bodies.get(b as usize)? as usize)?)));
        if let Some((body, over)) = body.filter(|(_, over)| over.start.gives()) {
            if last.0 != body {
                last = (body, hanging(body));
            }
            need += RESERVE_OF_BODY * over.start.mass() / f64::max(last.1, 1.0);
        }
        let parts = f64::from(stuck.contacts(mass, towards(contact)).max(1));
        let before = stuck.was_pull.get(mass as usize).length() / parts;
        need = (need / parts).max(GROWTH * borne(scratch, contact, before));
        let most = strength * share * own.area_of(mass) / parts;
        pull(sheets, members, contact, need.min(most), bodies, around);
        if let Some(stuck) = &mut sheets[members[sheet as usize] as usize].work.stuck {
            stuck.bonds += usize::from(!std::mem::replace(&mut stuck.held[mass as usize], true));
        }
    });
}

/// What a bond bore in the step, N, where it was pulled with `force`: across, and along as friction needs of it.
fn borne(scratch: &Scratch, contact: &Contact, force: f64) -> f64 {
    let contact_force = scratch.force_of(&contact.key).unwrap_or(DVec3::ZERO);
    let across = contact_force.dot(contact.normal).abs();
    let along = contact_force.reject_from_normalized(contact.normal).length();
    let friction = if contact.friction > 0.0 { along / contact.friction } else { 0.0 };
    (force - across).max(0.0) + friction
}

/// Pulls the two sides of a contact together with `force` (N).
fn pull(sheets: &mut [Sheet], members: &[u32], contact: &Contact, force: f64, bodies: &[u32], around: &Surroundings) {
    let Some((owner, ..)) = of_mass(contact) else { return };
    for (side, sign) in [(&contact.a, -force), (&contact.b, force)] {
        let push = contact.normal * sign;
        match side {
            Side::Sheet { sheet, point } => {
                let Some(stuck) = &mut sheets[members[*sheet as usize] as usize].work.stuck else { continue };
                for (i, w) in point.terms() {
                    stuck.pull.set(i as usize, stuck.pull.get(i as usize) + push * w);
                }
            }
            Side::Body { body, local } => {
                let Some(index) = bodies.get(*body as usize) else { continue };
                let gives = around.bodies.get(*index as usize).is_some_and(|b| b.start.gives());
                if let Some(stuck) = sheets[members[owner as usize] as usize].work.stuck.as_mut().filter(|_| gives) {
                    stuck.on_bodies.push((*index, push, *local));
                }
            }
        }
    }
}

/// Sheet, mass and point of a contact of one mass with a body or a triangle; none of any other.
fn of_mass(contact: &Contact) -> Option<(u32, u32, SheetPoint)> {
    let single = |side: &Side| match side {
        Side::Sheet { sheet, point } if point.weights[0] == 1.0 => Some((*sheet, point.masses[0], *point)),
        _ => None,
    };
    single(&contact.a).or_else(|| single(&contact.b))
}

/// Where what its mass touches is from it, for a contact of one.
fn towards(contact: &Contact) -> DVec3 {
    let of_a = matches!(contact.a, Side::Sheet { point, .. } if point.weights[0] == 1.0);
    if of_a { -contact.normal } else { contact.normal }
}

/// The other sheet of a contact of two, and where.
fn other_sheet(contact: &Contact) -> Option<(u32, SheetPoint)> {
    let (sheet, mass, own) = of_mass(contact)?;
    [contact.a, contact.b].into_iter().find_map(|side| match side {
        Side::Sheet { sheet: other, point } if (other, point) != (sheet, own) => {
            Some((other, point)).filter(|_| other != sheet || point.masses[0] != mass)
        }
        _ => None,
    })
}

/// The body of a contact with one, by number in the group.
fn other_body(contact: &Contact) -> Option<u32> {
    [contact.a, contact.b].into_iter().find_map(|side| match side {
        Side::Body { body, .. } => Some(body),
        Side::Sheet { .. } => None,
    })
}
