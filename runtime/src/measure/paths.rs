//! Whether a place of a sheet has passed through the core of a body between two looks at them.
//!
//! In the time between, the place goes straight on from where it was, and the body moves straight on and turns evenly, by the angle that its
//! spin says: a box that is struck at its edge may turn by more than half a turn in a step, and what stands still beside it goes around
//! it, as it sees that. The real way is anything that goes on in every direction, as along a plate and then down beside its rim: such a way
//! is never further from the straight one than half of that. Lengths in m, in the frame of the body.

use std::f64::consts::TAU;

use glam::{DQuat, DVec3};

use super::overlap::{Frame, Solid, faces};
use super::watch;
use crate::World;
use crate::sheet::Sheet;

/// Turn of a body that one straight piece of a way may stand for, rad.
const TURN: f64 = 0.1;

/// Where masses and middles of triangles were after the last look, and the bodies.
pub(crate) struct Paths {
    solids: Vec<(usize, Solid)>,
    faces: Vec<[u32; 3]>,
    places: Vec<DVec3>,
    frames: Vec<Option<Frame>>,
    time: f64,
}

impl Paths {
    pub fn new(world: &World) -> Self {
        let bodies = world.rigid().map_or(&[][..], |r| r.bodies());
        let solids: Vec<_> = bodies.iter().enumerate().filter_map(|(i, b)| Some((i, Solid::of(&b.shape)?))).collect();
        let faces = world.sheets().first().map(faces).unwrap_or_default();
        let mut paths = Self { solids, faces, places: Vec::new(), frames: Vec::new(), time: world.time() };
        (paths.places, paths.frames) = (paths.places(world), paths.frames(world));
        paths
    }

    fn places(&self, world: &World) -> Vec<DVec3> {
        let Some(sheet) = world.sheets().first() else { return Vec::new() };
        let middle = |sheet: &Sheet, t: &[u32; 3]| t.iter().map(|i| sheet.x.get(*i as usize)).sum::<DVec3>() / 3.0;
        sheet.x.iter().chain(self.faces.iter().map(|t| middle(sheet, t))).collect()
    }

    fn frames(&self, world: &World) -> Vec<Option<Frame>> {
        self.solids.iter().map(|(body, _)| watch::frame(world, *body)).collect()
    }

    /// The first place that has gone through a body since the last look.
    pub fn crossing(&mut self, world: &World) -> Option<String> {
        let (places, frames) = (self.places(world), self.frames(world));
        let span = world.time() - self.time;
        let mut found = None;
        for (k, (body, solid)) in self.solids.iter().enumerate() {
            let (Some(start), Some(end)) = (&self.frames[k], &frames[k]) else { continue };
            let spin = world.rigid().and_then(|r| r.state(*body)).map_or(DVec3::ZERO, |state| state.spin());
            let turn = turned(start.rotation, end.rotation, spin * span);
            let mut ways = self.places.iter().zip(&places).enumerate();
            let gone = ways.find(|(_, (a, b))| passes(solid, (start, end, turn), (**a, **b)));
            if let Some((place, (a, b))) = gone.filter(|_| found.is_none()) {
                let (a, b) = (start.local(*a), end.local(*b));
                found = Some(format!("place {place} through body {body}, from {a:.4} to {b:.4} m"));
            }
        }
        (self.places, self.frames, self.time) = (places, frames, world.time());
        found
    }
}

/// The turn that leads from one orientation to another, as axis times angle, rad: of those that differ by whole turns the one nearest to
/// `about`.
fn turned(from: DQuat, to: DQuat, about: DVec3) -> DVec3 {
    let least = (to * from.inverse()).to_scaled_axis();
    // What does not turn by itself turns about what it is told to.
    let axis = least.try_normalize().or(about.try_normalize()).unwrap_or(DVec3::X);
    least + axis * (TAU * ((about - least).dot(axis) / TAU).round())
}

/// Whether a place that goes from `a` to `b` in the world passes through the core of a body that goes from one frame to another by `turn`.
fn passes(solid: &Solid, (start, end, turn): (&Frame, &Frame, DVec3), (a, b): (DVec3, DVec3)) -> bool {
    let (a, b) = (a - start.position, b - end.position);
    let pieces = (turn.length() / TURN).ceil().clamp(1.0, 200.0);
    let bend = 0.5 * a.distance(b);
    let seen = |part: f64| (DQuat::from_scaled_axis(turn * part) * start.rotation).inverse() * a.lerp(b, part);
    (0..pieces as u32).any(|k| solid.crossed(seen(f64::from(k) / pieces), seen(f64::from(k + 1) / pieces), bend))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::Polyhedron;

    #[test]
    fn what_stands_beside_a_box_that_turns_has_not_gone_through_it() {
        let solid = Solid::of(&crate::scene::Shape::Box(DVec3::splat(0.1))).expect("a solid");
        let frame = |angle: f64| Frame { position: DVec3::ZERO, rotation: DQuat::from_rotation_y(angle) };
        let beside = DVec3::new(0.2, 0.0, 0.0);
        for angle in [0.5, 3.0, 4.0, 9.0] {
            let (start, end) = (frame(0.3), frame(0.3 + angle));
            let turn = turned(start.rotation, end.rotation, DVec3::Y * (angle + 0.2));
            assert!((turn - DVec3::Y * angle).length() < 1e-9, "{turn} {angle}");
            assert!(!passes(&solid, (&start, &end, turn), (beside, beside)), "{angle}");
            assert!(passes(&solid, (&start, &end, turn), (beside, -beside)), "{angle}");
        }
    }

    #[test]
    fn what_goes_straight_through_a_wedge_has() {
        let solid = Solid::of(&crate::scene::Shape::Polyhedron(Polyhedron::wedge(0.1, 0.1, 0.2))).expect("a solid");
        let frame = Frame { position: DVec3::new(1.0, 0.0, 0.0), rotation: DQuat::IDENTITY };
        let way = |x: f64, y: f64| (DVec3::new(1.0 - x, y, 0.0), DVec3::new(1.0 + x, y, 0.0));
        assert!(passes(&solid, (&frame, &frame, DVec3::ZERO), way(0.06, 0.03)));
        assert!(!passes(&solid, (&frame, &frame, DVec3::ZERO), way(0.06, 0.2)));
    }
}
