//! Detection of a material point that passes through the core of a body between two observations.
//!
//! Between observations a point moves in straight lines from stage to stage of the step. The body
//! translates linearly and rotates uniformly by the angle of its angular velocity: a box struck at
//! its edge can turn by more than half a turn in a step, and a static point beside it then circles
//! the box in the box's frame. The true path between stages may deviate from the straight line, as
//! along a plate and then down beside its rim; the deviation is at most half of the line's length.
//! Lengths in m, in the frame of the body.

use std::f64::consts::TAU;

use glam::{DQuat, DVec3};

use crate::measure::contact_observer;
use sheetwork::World;
use sheetwork::collision::overlap::{BodyPose, OverlapSolid, faces};
use sheetwork::math::Vectors;
use sheetwork::sheet::{Sheet, stage_trace};

/// Maximum rotation of a body per linear piece of a path, rad.
const MAXIMUM_TURN: f64 = 0.1;

/// Positions of nodes and triangle centres, and frames of bodies, at the last observation.
pub(crate) struct CrossingDetector {
    solids: Vec<(usize, OverlapSolid)>,
    faces: Vec<[u32; 3]>,
    places: Vec<DVec3>,
    frames: Vec<Option<BodyPose>>,
    time: f64,
}

/// Fraction of the observation interval, and the position at that time.
type At = (f64, DVec3);

impl CrossingDetector {
    /// Starts detection and enables the record of stage positions in the first sheet.
    pub fn new(world: &mut World) -> Self {
        if let Some(sheet) = world.sheets_mut().first_mut() {
            stage_trace::record_stages(sheet);
        }
        let world = &*world;
        let bodies = world.rigid().map_or(&[][..], |r| r.bodies());
        let solids: Vec<_> =
            bodies.iter().enumerate().filter_map(|(i, b)| Some((i, OverlapSolid::from_shape(&b.shape)?))).collect();
        let faces = world.sheets().first().map(faces).unwrap_or_default();
        let mut paths = Self { solids, faces, places: Vec::new(), frames: Vec::new(), time: world.time() };
        let places = world.sheets().first().map_or_else(Vec::new, |sheet| paths.places(&sheet.state.x));
        (paths.places, paths.frames) = (places, paths.frames(world));
        paths
    }

    fn places(&self, x: &Vectors) -> Vec<DVec3> {
        let middle = |t: &[u32; 3]| t.iter().map(|i| x.get(*i as usize)).sum::<DVec3>() / 3.0;
        x.iter().chain(self.faces.iter().map(middle)).collect()
    }

    /// Positions of all points since the last observation, by fraction of the interval.
    fn since(&self, sheet: &Sheet, span: f64) -> Vec<(f64, Vec<DVec3>)> {
        let last = self.places(&sheet.state.x);
        let mut ways = vec![(0.0, self.places.clone())];
        // A sleeping sheet has no stages.
        if let Some(trace) = stage_trace::recorded_stages(sheet).filter(|_| last != self.places && span > 0.0) {
            ways.extend(trace.iter().map(|(time, x)| ((time / span).min(1.0), self.places(x))));
        }
        ways.push((1.0, last));
        ways
    }

    fn frames(&self, world: &World) -> Vec<Option<BodyPose>> {
        self.solids.iter().map(|(body, _)| contact_observer::frame(world, *body)).collect()
    }

    /// First point that has passed through a body since the last observation.
    pub fn crossing(&mut self, world: &World) -> Option<String> {
        let frames = self.frames(world);
        let span = world.time() - self.time;
        let ways = world.sheets().first().map_or_else(Vec::new, |sheet| self.since(sheet, span));
        let mut found = None;
        for (k, (body, solid)) in self.solids.iter().enumerate() {
            let (Some(start), Some(end)) = (&self.frames[k], &frames[k]) else { continue };
            let spin = world.rigid().and_then(|r| r.state(*body)).map_or(DVec3::ZERO, |state| state.spin());
            let turn = turned(start.rotation, end.rotation, spin * span);
            let mut pieces = ways.iter().zip(ways.iter().skip(1));
            let gone = |((t0, a), (t1, b)): (&(f64, Vec<DVec3>), &(f64, Vec<DVec3>))| {
                let goes = |place: &usize| passes(solid, (start, end, turn), ((*t0, a[*place]), (*t1, b[*place])));
                let place = (0..a.len()).find(goes)?;
                let (a, b) = (start.local(a[place]), end.local(b[place]));
                Some(format!("place {place} through body {body}, from {a:.4} to {b:.4} m"))
            };
            found = found.or_else(|| pieces.find_map(gone));
        }
        if let Some((_, places)) = ways.into_iter().next_back() {
            self.places = places;
        }
        (self.frames, self.time) = (frames, world.time());
        found
    }
}

/// Rotation vector (rad) between two orientations. Among those that differ by whole turns, the
/// nearest to `about`.
fn turned(from: DQuat, to: DQuat, about: DVec3) -> DVec3 {
    let least = (to * from.inverse()).to_scaled_axis();
    // Without a relative rotation the axis is that of `about`.
    let axis = least.try_normalize().or(about.try_normalize()).unwrap_or(DVec3::X);
    least + axis * (TAU * ((about - least).dot(axis) / TAU).round())
}

/// Whether a point that moves from `a` to `b` in the world passes through the core of a body that
/// moves between two frames and rotates by `turn` over the whole interval.
fn passes(solid: &OverlapSolid, (start, end, turn): (&BodyPose, &BodyPose, DVec3), (a, b): (At, At)) -> bool {
    let (time, length) = (a.0, b.0 - a.0);
    let seen = |part: f64| {
        let all = time + length * part;
        let from = a.1.lerp(b.1, part) - start.position.lerp(end.position, all);
        (DQuat::from_scaled_axis(turn * all) * start.rotation).inverse() * from
    };
    let moved = |at: At| at.1 - start.position.lerp(end.position, at.0);
    let bend = 0.5 * moved(a).distance(moved(b));
    let pieces = (turn.length() * length / MAXIMUM_TURN).ceil().clamp(1.0, 200.0);
    (0..pieces as u32).any(|k| solid.crossed(seen(f64::from(k) / pieces), seen(f64::from(k + 1) / pieces), bend))
}

#[cfg(test)]
mod tests {
    use super::*;
    use sheetwork::scene::Polyhedron;

    #[test]
    fn a_static_point_beside_a_turning_box_does_not_pass_through_it() {
        let solid = OverlapSolid::from_shape(&sheetwork::scene::Shape::Box(DVec3::splat(0.1))).expect("a solid");
        let frame = |angle: f64| BodyPose { position: DVec3::ZERO, rotation: DQuat::from_rotation_y(angle) };
        let beside = DVec3::new(0.2, 0.0, 0.0);
        for angle in [0.5, 3.0, 4.0, 9.0] {
            let (start, end) = (frame(0.3), frame(0.3 + angle));
            let turn = turned(start.rotation, end.rotation, DVec3::Y * (angle + 0.2));
            assert!((turn - DVec3::Y * angle).length() < 1e-9, "{turn} {angle}");
            assert!(!passes(&solid, (&start, &end, turn), ((0.0, beside), (1.0, beside))), "{angle}");
            assert!(passes(&solid, (&start, &end, turn), ((0.0, beside), (1.0, -beside))), "{angle}");
        }
    }

    #[test]
    fn a_point_that_crosses_a_wedge_passes_through_it() {
        let solid = OverlapSolid::from_shape(&sheetwork::scene::Shape::Polyhedron(Polyhedron::wedge(0.1, 0.1, 0.2)))
            .expect("a solid");
        let frame = BodyPose { position: DVec3::new(1.0, 0.0, 0.0), rotation: DQuat::IDENTITY };
        let way = |x: f64, y: f64| ((0.0, DVec3::new(1.0 - x, y, 0.0)), (1.0, DVec3::new(1.0 + x, y, 0.0)));
        assert!(passes(&solid, (&frame, &frame, DVec3::ZERO), way(0.06, 0.03)));
        assert!(!passes(&solid, (&frame, &frame, DVec3::ZERO), way(0.06, 0.2)));
    }

    #[test]
    fn a_point_that_circles_a_needle_in_stages_does_not_pass_through_it() {
        let solid =
            OverlapSolid::from_shape(&sheetwork::scene::Shape::Box(DVec3::new(0.01, 0.2, 0.01))).expect("a solid");
        let frame = BodyPose { position: DVec3::ZERO, rotation: DQuat::IDENTITY };
        let round = |part: f64| (part, DQuat::from_rotation_y(3.0 * part) * DVec3::X * 0.02);
        let gone = |from: f64, to: f64| passes(&solid, (&frame, &frame, DVec3::ZERO), (round(from), round(to)));
        assert!(gone(0.0, 1.0));
        assert!(!(0..10).any(|k| gone(0.1 * f64::from(k), 0.1 * f64::from(k + 1))));
    }
}
