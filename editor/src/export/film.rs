//! A run that is looked at moment by moment, beside the session it began in: whole steps of the engine, as a scene that plays takes them, and a picture
//! between two of them where a moment lies there. The session stays where it is.

use sheetwork::world::recording::Frame;
use sheetwork::{InputError, World};

use crate::playback::Playback;
use crate::session::{ROUNDING, Session};

/// A run from the present moment of a session on.
pub struct Film {
    /// As far as the run has come.
    world: World,
    /// Time of the session's present moment, s.
    start: f64,
    source: Source,
}

/// Where it comes from.
enum Source {
    Run {
        /// The world one step ago.
        before: Frame,
        /// What is looked at where it lies between two steps.
        between: Option<Box<World>>,
    },
    Recording(Playback),
}

impl Film {
    /// The run of `session` from where it is.
    ///
    /// # Errors
    /// When its scene cannot be built any more: a file that it names has gone.
    pub fn of(session: &Session) -> Result<Self, InputError> {
        if let Some(recording) = session.playback() {
            let (recording, world) = (recording.clone(), World::new(session.scene())?);
            return Ok(Self { world, start: recording.at(), source: Source::Recording(recording) });
        }
        let world = session.world_again()?;
        let before = Frame::of(&world);
        Ok(Self { start: world.time(), world, source: Source::Run { before, between: None } })
    }

    /// The world `after` s later than the session's; a moment that lies before one that was asked for already is not gone back to.
    ///
    /// # Errors
    /// When the scene cannot be built any more.
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
            *before = Frame::of(world);
            world.step();
        }
        let late = world.time() - time;
        let whole = world.time() - before.time;
        // A sheet that has gone to another grid in the last step has no place between.
        if late <= ROUNDING * whole || world.can_show(before).is_err() {
            return Ok(world);
        }
        let shown = match between {
            Some(shown) => shown,
            None => between.insert(Box::new(World::new(world.scene())?)),
        };
        shown.restore(&world.snapshot())?;
        shown.show_between(before, 1.0 - late / whole)?;
        Ok(shown)
    }

    /// The world as far as the run has come.
    pub fn world(&self) -> &World {
        &self.world
    }
}
