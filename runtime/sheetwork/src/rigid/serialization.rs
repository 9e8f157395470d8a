//! Serialisation of the rigid world: the f64 states, and Rapier's sets if any body can move.
//!
//! Rapier carries more than poses between steps: warm-start impulses, pairs, the order of its
//! islands. All its sets are serialised by their own implementation. A world of static bodies omits
//! them, since it equals the world as built from its scene.

use rapier3d::prelude::PhysicsWorld;

use crate::rigid::step::Motion;
use crate::rigid::{BodyState, Kind, RigidWorld};
use crate::scene::Scene;
use crate::serialize::{Cut, Keeper, Taken, Taker};

impl RigidWorld {
    /// Serialise the rigid world.
    pub(crate) fn keep(&self, to: &mut Keeper) {
        to.count(self.motions.len() as u64);
        self.motions.iter().for_each(|motion| keep_motion(motion, to));
        [self.moving, self.moves()].into_iter().for_each(|f| to.flag(f));
        if self.moves() {
            // An error of serialisation leaves an empty byte sequence, which deserialisation
            // rejects.
            let sets = postcard::to_extend(&self.inner, Vec::new()).unwrap_or_default();
            to.blob(&sets);
        }
    }

    /// Deserialise the rigid world in place; `scene` is the one from which it was built.
    pub(crate) fn take(&mut self, from: &mut Taker, scene: &Scene) -> Taken {
        if from.count()? != self.motions.len() as u64 {
            return Err(Cut);
        }
        let motions = (0..self.motions.len()).map(|_| take_motion(from)).collect::<Taken<Vec<Motion>>>()?;
        let (moving, has_sets) = (from.flag()?, from.flag()?);
        if has_sets {
            let inner: PhysicsWorld = postcard::from_bytes(from.blob()?).map_err(|_| Cut)?;
            let known = |b: &crate::rigid::Body| {
                inner.bodies.get(b.handle).is_some() && b.colliders.iter().all(|c| inner.colliders.get(*c).is_some())
            };
            let counts = (inner.bodies.len(), inner.colliders.len());
            if counts != (self.inner.bodies.len(), self.inner.colliders.len()) || !self.bodies.iter().all(known) {
                return Err(Cut);
            }
            self.inner = inner;
        } else if self.moves() {
            let sleep = self.sleep;
            *self = Self::build(scene).map_err(|_| Cut)?;
            self.sleep = sleep;
            if motions.len() != self.motions.len() {
                return Err(Cut);
            }
        }
        for (index, (motion, body)) in motions.iter().zip(&mut self.bodies).enumerate() {
            // A body moved by a program has no path.
            if motion.kind == Kind::Path && body.path.is_empty() {
                body.path = scene.bodies.get(index).map(|b| b.path.clone()).unwrap_or_default();
            } else if matches!(motion.kind, Kind::Sent(_)) {
                body.path.clear();
            }
        }
        (self.motions, self.moving) = (motions, moving);
        self.contacts.clear();
        Ok(())
    }

    /// Whether any body is kinematic or dynamic, so that Rapier's sets differ from those as built.
    fn moves(&self) -> bool {
        self.moving || self.motions.iter().any(|m| m.kind != Kind::Standing)
    }
}

fn keep_motion(motion: &Motion, to: &mut Keeper) {
    let kind = match &motion.kind {
        Kind::Standing => 0,
        Kind::Path => 1,
        Kind::Sent(None) => 2,
        Kind::Sent(Some(_)) => 3,
        Kind::Free => 4,
    };
    to.byte(kind);
    if let Kind::Sent(Some((place, rotation))) = motion.kind {
        to.vector(place);
        to.rotation(rotation);
    }
    motion.start.keep(to);
    motion.end.keep(to);
    [motion.asleep, motion.claimed, motion.pushed].into_iter().for_each(|f| to.flag(f));
    to.numbers(&[motion.quiet, motion.extent]);
}

fn take_motion(from: &mut Taker) -> Taken<Motion> {
    let kind = match from.byte()? {
        0 => Kind::Standing,
        1 => Kind::Path,
        2 => Kind::Sent(None),
        3 => Kind::Sent(Some((from.vector()?, from.rotation()?))),
        4 => Kind::Free,
        _ => return Err(Cut),
    };
    let (start, end) = (BodyState::taken(from)?, BodyState::taken(from)?);
    let (asleep, claimed, pushed) = (from.flag()?, from.flag()?, from.flag()?);
    Ok(Motion { kind, start, from: start, end, asleep, quiet: from.number()?, claimed, pushed, extent: from.number()? })
}
