//! Masses that do not move freely: held where they are, led along a path or by a body, or held in some directions only.
//!
//! Masses glued to a body that stands or is led go where it takes them: to x + q l at the end of a step, with the body's place
//! x and rotation q then and their place l in its frame. Those glued to one that moves freely stay free themselves: body and
//! sheet pull at one another there, which is for the solver of contact to work out.

use glam::DVec3;

use crate::math::Vectors;
use crate::rigid::BodyState;
use crate::scene::{PathKey, path_at};
use crate::serialize::{Keeper, Taken, Taker};

/// The pins of a sheet.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Pins {
    groups: Vec<Group>,
    glue: Vec<Glue>,
    rails: Vec<Rail>,
    /// Masses that are gone, which nothing is glued to; empty where none is.
    gone: Vec<bool>,
}

#[derive(Clone, Debug, PartialEq)]
struct Group {
    masses: Vec<u32>,
    start: Vec<DVec3>,
    path: Vec<PathKey>,
    /// When they are let go, s.
    until: Option<f64>,
}

/// Masses glued to a body.
#[derive(Clone, Debug, PartialEq)]
struct Glue {
    name: String,
    /// Each mass, where it was at the start (m), and where it is in the body's frame (m) once that is known.
    masses: Vec<(u32, DVec3, DVec3)>,
    body: Option<Hold>,
}

/// The body that holds glued masses.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Hold {
    index: usize,
    /// Whether the masses are led by it; otherwise they are free, and it is for a solver to hold them.
    leads: bool,
    /// At the start and at the end of the world's step, and when that starts and how long it is, s.
    from: BodyState,
    to: BodyState,
    time: f64,
    dt: f64,
}

impl Hold {
    /// The body at time `t`, s: at the end of the step exactly where it is then.
    fn at(&self, t: f64) -> BodyState {
        let done = t - self.time;
        if done >= self.dt * (1.0 - 1e-12) { self.to } else { self.from.fly(done, DVec3::ZERO) }
    }
}

/// A mass held along some of the world's axes.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Rail {
    mass: u32,
    held: [bool; 3],
    start: DVec3,
}

impl Pins {
    /// Pins `masses`, now at `start` (m), led along `path` (empty: held), up to the time `until` (s) if there is one.
    pub fn add(&mut self, masses: Vec<u32>, start: Vec<DVec3>, path: Vec<PathKey>, until: Option<f64>) {
        self.groups.push(Group { masses, start, path, until });
    }

    /// Keeps for a snapshot what may be let go.
    pub(crate) fn keep(&self, to: &mut Keeper) {
        to.count(self.groups.len() as u64);
        for group in &self.groups {
            to.count(group.masses.len() as u64);
            for (mass, start) in group.masses.iter().zip(&group.start) {
                to.count(u64::from(*mass));
                to.vector(*start);
            }
            to.optional(group.until);
            to.count(group.path.len() as u64);
            for key in &group.path {
                to.number(key.time);
                to.vector(key.offset);
                to.vector(key.rotation);
            }
        }
    }

    /// Takes it back, of a sheet of `masses` masses; whether other masses are held then.
    pub(crate) fn take(&mut self, from: &mut Taker, masses: usize) -> Taken<bool> {
        let mut groups = Vec::new();
        for _ in 0..from.length(3)? {
            let mut group = Group { masses: Vec::new(), start: Vec::new(), path: Vec::new(), until: None };
            for _ in 0..from.length(25)? {
                group.masses.push(from.index(masses)?);
                group.start.push(from.vector()?);
            }
            group.until = from.optional()?;
            for _ in 0..from.length(56)? {
                group.path.push(PathKey { time: from.number()?, offset: from.vector()?, rotation: from.vector()? });
            }
            groups.push(group);
        }
        let changed = groups != self.groups;
        self.groups = groups;
        Ok(changed)
    }

    /// Whether something is to be let go at time `t`, s.
    pub fn ends(&self, t: f64) -> bool {
        self.groups.iter().any(|g| g.until.is_some_and(|until| until <= t))
    }

    /// Lets go what is not held beyond time `t`, s; the masses that were.
    pub(crate) fn release(&mut self, t: f64) -> Vec<u32> {
        let over = |g: &Group| g.until.is_some_and(|until| until <= t);
        let freed = self.groups.iter().filter(|g| over(g)).flat_map(|g| g.masses.iter().copied()).collect();
        self.groups.retain(|g| !over(g));
        freed
    }

    /// Holds `mass`, now at `start` (m), along the axes (x, y, z) that `held` names.
    pub fn add_rail(&mut self, mass: u32, start: DVec3, held: [bool; 3]) {
        self.rails.push(Rail { mass, held, start });
    }

    /// Glues `masses`, each now at a place (m), to the body called `name`.
    pub fn add_glue(&mut self, masses: impl Iterator<Item = (u32, DVec3)>, name: &str) {
        let masses = masses.map(|(mass, place)| (mass, place, DVec3::ZERO)).collect();
        self.glue.push(Glue { name: name.to_owned(), masses, body: None });
    }

    /// Finds the bodies that masses are glued to, by name: index and state. Masses glued to one that moves freely stay free;
    /// the others are given back, to be held. The name of the first body that is not there is the error.
    pub(crate) fn bind(&mut self, find: impl Fn(&str) -> Option<(usize, BodyState)>) -> Result<Vec<u32>, String> {
        let mut led = Vec::new();
        for glue in self.glue.iter_mut().filter(|g| g.body.is_none()) {
            let Some((index, state)) = find(&glue.name) else { return Err(glue.name.clone()) };
            glue.masses.iter_mut().for_each(|(_, place, local)| *local = state.local(*place));
            let leads = !state.gives();
            if leads {
                led.extend(glue.masses.iter().map(|m| m.0));
            }
            glue.body = Some(Hold { index, leads, from: state, to: state, time: 0.0, dt: 0.0 });
        }
        Ok(led)
    }

    /// Tells of the bodies' step from `time` on, `dt` long (s): `find` gives the states of a body at its start and end.
    pub(crate) fn follow(&mut self, time: f64, dt: f64, find: impl Fn(usize) -> Option<(BodyState, BodyState)>) {
        for hold in self.glue.iter_mut().filter_map(|g| g.body.as_mut()) {
            if let Some((from, to)) = find(hold.index) {
                *hold = Hold { from, to, time, dt, ..*hold };
            }
        }
    }

    /// Lets go of what is glued to body `index`, which is no more, and counts the bodies after it anew; the masses that it led.
    pub(crate) fn unglue(&mut self, index: usize) -> Vec<u32> {
        let on_it = |g: &Glue| g.body.is_some_and(|h| h.index == index);
        let led = |g: &&Glue| on_it(g) && g.body.is_some_and(|h| h.leads);
        let freed = self.glue.iter().filter(led).flat_map(|g| g.masses.iter().map(|m| m.0)).collect();
        self.glue.retain(|g| !on_it(g));
        for hold in self.glue.iter_mut().filter_map(|g| g.body.as_mut()).filter(|h| h.index > index) {
            hold.index -= 1;
        }
        freed
    }

    /// Masses that are glued to bodies and yet free, for a solver to hold there: mass, index of the body, place in its frame
    /// (m).
    pub fn glued(&self) -> impl Iterator<Item = (u32, usize, DVec3)> + '_ {
        let free = self.glue.iter().filter_map(|g| g.body.filter(|h| !h.leads).map(|h| (g, h.index)));
        let all = free.flat_map(|(g, index)| g.masses.iter().map(move |(mass, _, local)| (*mass, index, *local)));
        all.filter(|(mass, ..)| !self.gone.get(*mass as usize).is_some_and(|gone| *gone))
    }

    /// Lets go of the glue of the masses that are `gone`, and of no others.
    pub(crate) fn set_gone(&mut self, gone: &[bool]) {
        self.gone.clear();
        self.gone.extend_from_slice(gone);
    }

    /// Free glued masses, each with the state of its body at the end of the step.
    pub(crate) fn glued_states(&self) -> impl Iterator<Item = (u32, &BodyState)> + '_ {
        let free = self.glue.iter().filter_map(|g| g.body.as_ref().filter(|h| !h.leads).map(|h| (g, &h.to)));
        free.flat_map(|(g, state)| g.masses.iter().map(move |m| (m.0, state)))
    }

    /// Glued masses that their bodies lead: the body's motion, the mass, and its place in the body's frame (m).
    fn led(&self) -> impl Iterator<Item = (&Hold, u32, DVec3)> + '_ {
        let led = self.glue.iter().filter_map(|g| g.body.as_ref().filter(|h| h.leads).map(|h| (g, h)));
        led.flat_map(|(g, h)| g.masses.iter().map(move |(mass, _, local)| (h, *mass, *local)))
    }

    /// Whether nothing is pinned.
    pub fn is_empty(&self) -> bool {
        self.groups.is_empty() && self.rails.is_empty() && self.glue.is_empty()
    }

    /// Whether it holds the sheet by anything but glue on bodies that give way.
    pub(crate) fn holds(&self) -> bool {
        !self.rails.is_empty() || self.masses().next().is_some()
    }

    /// Whether it glues any mass to a body that gives way.
    pub(crate) fn glues(&self) -> bool {
        self.glued().next().is_some()
    }

    /// All masses that are pinned in every direction, those led by bodies included.
    pub fn masses(&self) -> impl Iterator<Item = u32> + '_ {
        self.groups.iter().flat_map(|g| g.masses.iter().copied()).chain(self.led().map(|(_, mass, _)| mass))
    }

    /// Masses held along some axes only, and along which.
    pub fn rails(&self) -> impl Iterator<Item = (u32, [bool; 3])> + '_ {
        self.rails.iter().map(|r| (r.mass, r.held))
    }

    /// Along which axes mass `i` is free (1) or held (0) by a rail.
    pub(crate) fn free_axes(&self, i: u32) -> DVec3 {
        let free = |r: &Rail| DVec3::from_array(r.held.map(|held| if held { 0.0 } else { 1.0 }));
        self.rails.iter().filter(|r| r.mass == i).map(free).fold(DVec3::ONE, |a, b| a * b)
    }

    /// Whether any pin moves between the times `from` and `to`, s.
    pub fn moving(&self, from: f64, to: f64) -> bool {
        let led = self.glue.iter().filter_map(|g| g.body);
        self.groups.iter().any(|g| path_at(&g.path, from).0 != path_at(&g.path, to).0)
            || led
                .into_iter()
                .any(|h| h.from.moves() || (h.from.origin(), h.from.rotation()) != (h.to.origin(), h.to.rotation()))
    }

    /// Gives every pinned mass the constant velocity that takes it to its place at `t + dt`.
    pub(crate) fn lead(&self, t: f64, dt: f64, x: &Vectors, v: &mut Vectors) {
        for group in &self.groups {
            let offset = path_at(&group.path, t + dt).0;
            for (i, start) in group.masses.iter().zip(&group.start) {
                let i = *i as usize;
                v.set(i, (*start + offset - x.get(i)) / dt);
            }
        }
        for glue in &self.glue {
            let Some(hold) = glue.body.filter(|h| h.leads) else { continue };
            let there = hold.at(t + dt);
            for (mass, _, local) in &glue.masses {
                let i = *mass as usize;
                v.set(i, (there.place(*local) - x.get(i)) / dt);
            }
        }
        self.hold_rails(v);
    }

    /// Puts every pinned mass exactly where it belongs at `t`: what an engine rounds must not add up.
    pub(crate) fn place(&self, t: f64, x: &mut Vectors) {
        for group in &self.groups {
            let offset = path_at(&group.path, t).0;
            for (i, start) in group.masses.iter().zip(&group.start) {
                x.set(*i as usize, *start + offset);
            }
        }
        for (hold, mass, local) in self.led() {
            x.set(mass as usize, hold.at(t).place(local));
        }
        for rail in &self.rails {
            let i = rail.mass as usize;
            x.set(i, rail.replaced(x.get(i), rail.start));
        }
    }

    /// Takes it that at time `t` (s) masses are at `x`: a pin whose mass is further than `slack` (m) from where it would lead it began
    /// elsewhere. Puts all others exactly in place.
    pub(crate) fn anchor(&mut self, t: f64, x: &mut Vectors, slack: f64) {
        for group in &mut self.groups {
            let offset = path_at(&group.path, t).0;
            for (i, start) in group.masses.iter().zip(&mut group.start) {
                let there = x.get(*i as usize) - offset;
                if there.distance(*start) > slack {
                    *start = there;
                }
            }
        }
        for rail in &mut self.rails {
            let there = x.get(rail.mass as usize);
            if rail.replaced(there, rail.start).distance(there) > slack {
                rail.start = there;
            }
        }
        self.place(t, x);
    }

    /// Masses with where they began (m), pin by pin, and then those that are held along some axes.
    pub(crate) fn starts(&self) -> impl Iterator<Item = Vec<(u32, DVec3)>> + '_ {
        let groups = self.groups.iter().map(|g| g.masses.iter().copied().zip(g.start.iter().copied()).collect());
        groups.chain(std::iter::once(self.rails.iter().map(|r| (r.mass, r.start)).collect()))
    }

    /// Takes it that masses began further on: mass `i` of pin `k`, counted as [`Pins::starts`] does, by `by(k, i)`, m.
    pub(crate) fn shift_starts(&mut self, by: impl Fn(usize, u32) -> DVec3) {
        for (k, group) in self.groups.iter_mut().enumerate() {
            group.masses.iter().zip(&mut group.start).for_each(|(i, start)| *start += by(k, *i));
        }
        let last = self.groups.len();
        self.rails.iter_mut().for_each(|r| r.start += by(last, r.mass));
    }

    /// Sets the held components of velocities, accelerations or forces to zero.
    pub(crate) fn hold_rails(&self, a: &mut Vectors) {
        for rail in &self.rails {
            let i = rail.mass as usize;
            a.set(i, rail.replaced(a.get(i), DVec3::ZERO));
        }
    }

    /// Copies the held components of `x` to `to`.
    pub(crate) fn follow_rails(&self, x: &Vectors, to: &mut Vectors) {
        for rail in &self.rails {
            let i = rail.mass as usize;
            to.set(i, rail.replaced(to.get(i), x.get(i)));
        }
    }
}

impl Rail {
    /// `p` with the held components of `q`.
    fn replaced(&self, p: DVec3, q: DVec3) -> DVec3 {
        let pick = |axis: usize| if self.held[axis] { q[axis] } else { p[axis] };
        DVec3::new(pick(0), pick(1), pick(2))
    }
}
