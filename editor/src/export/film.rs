//! A run that is looked at moment by moment, beside the session it began in: whole steps of the engine, as a scene that plays takes them, and a picture
//! between two of them where a moment lies there. The session stays where it is.

use sheetwork::recording::Frame;
use sheetwork::{InputError, World};

use crate::playback::Playback;
use crate::session::Session;

/// Part of a step that is none: times are sums of steps.
const ROUNDING: f64 = 1e-6;

/// A run from the present moment of a session on.
pub struct Film {
    source: Source,
    /// Time of the session's present moment, s.
    start: f64,
}

enum Source {
    Run {
        world: World,
        /// The world one step ago.
        before: Frame,
        /// What is looked at where it lies between two steps.
        between: Option<World>,
    },
    Recording(Playback, World),
}

impl Film {
    /// The run of `session` from where it is.
    ///
    /// # Errors
    /// When its scene cannot be built any more: a file that it names has gone.
    pub fn of(session: &Session) -> Result<Self, InputError> {
        if let Some(recording) = session.playback() {
            let (recording, world) = (recording.clone(), World::new(session.scene())?);
            return Ok(Self { start: recording.at(), source: Source::Recording(recording, world) });
        }
        let world = session.world_again()?;
        let (start, before) = (world.time(), Frame::of(&world));
        Ok(Self { start, source: Source::Run { world, before, between: None } })
    }

    /// The world `after` s later than the session's; a moment that lies before one that was asked for already is not gone back to.
    ///
    /// # Errors
    /// When the scene cannot be built any more.
    pub fn at(&mut self, after: f64) -> Result<&World, InputError> {
        let time = self.start + after;
        match &mut self.source {
            Source::Recording(recording, world) => {
                recording.seek(time, world);
                Ok(world)
            }
            Source::Run { world, before, between } => {
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
                if between.is_none() {
                    *between = Some(World::new(world.scene())?);
                }
                let Some(shown) = between else { return Ok(world) };
                shown.restore(&world.snapshot())?;
                shown.show_between(before, 1.0 - late / whole)?;
                Ok(shown)
            }
        }
    }

    /// The world as far as the run has come.
    pub fn world(&self) -> &World {
        match &self.source {
            Source::Run { world, .. } | Source::Recording(_, world) => world,
        }
    }
}
