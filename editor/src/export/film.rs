//! Run sampled at given moments, independent of its session: whole time steps, as during playback,
//! with interpolation between two steps. The session is unchanged.

use sheetwork::world::recording::RecordedFrame;
use sheetwork::{InputError, World};

use crate::playback::Playback;
use crate::session::{ROUNDING, Session};

/// Run from the present state of a session.
pub struct Film {
    /// World at the end of the last step.
    world: World,
    /// Time of the session's present state, s.
    start: f64,
    source: Source,
}

/// Source of the states.
enum Source {
    Run {
        /// State one step ago.
        before: RecordedFrame,
        /// World with an interpolated state.
        between: Option<Box<World>>,
    },
    Recording(Playback),
}

impl Film {
    /// Run of `session` from its present state.
    ///
    /// # Errors
    /// When its scene cannot be built: one of its files is missing.
    pub fn from_session(session: &Session) -> Result<Self, InputError> {
        if let Some(recording) = session.playback() {
            let (recording, world) = (recording.clone(), World::with_start_overlaps(session.scene())?);
            return Ok(Self { world, start: recording.at(), source: Source::Recording(recording) });
        }
        let world = session.world_again()?;
        let before = RecordedFrame::of(&world);
        Ok(Self { start: world.time(), world, source: Source::Run { before, between: None } })
    }

    /// World `after` s later than the session. Earlier moments than the last one are not restored.
    ///
    /// # Errors
    /// When the scene cannot be built.
    pub fn at(&mut self, after: f64) -> Result<&World, InputError> {
        let (time, world) = (self.start + after, &mut self.world);
        let (before, between) = match &mut self.source {
            Source::Recording(recording) => {
                recording.seek(time, world);
                return Ok(world);
            }
            Source::Run { before, between } => (before, between),
        };
        while world.time() + ROUNDING * world.dt() < time {
            *before = RecordedFrame::of(world);
            world.step();
        }
        let late = world.time() - time;
        let whole = world.time() - before.time;
        // After a change of grid in the last step there is no interpolation.
        if late <= ROUNDING * whole || world.can_show(before).is_err() {
            return Ok(world);
        }
        let shown = match between {
            Some(shown) => shown,
            None => between.insert(Box::new(World::with_start_overlaps(world.scene())?)),
        };
        shown.restore(&world.snapshot())?;
        shown.show_between(before, 1.0 - late / whole)?;
        Ok(shown)
    }

    /// World at the end of the last step.
    pub fn world(&self) -> &World {
        &self.world
    }
}
