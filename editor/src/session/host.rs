//! The session as host of the live link.

use std::path::Path;

use sheetwork::{InputError, World};
use sheetwork_link::Host;

use super::Session;

impl Host for Session {
    fn world(&self) -> &World {
        Session::world(self)
    }

    fn world_mut(&mut self) -> &mut World {
        Session::world_mut(self)
    }

    fn playing(&self) -> bool {
        Session::playing(self)
    }

    fn play(&mut self, playing: bool) -> Result<(), InputError> {
        if playing {
            Session::play(self)
        } else {
            self.pause()
        }
        Ok(())
    }

    fn step(&mut self, steps: u32) -> Result<(), InputError> {
        (0..steps).for_each(|_| Session::step(self));
        Ok(())
    }

    fn set(&mut self, path: &str, value: &str) -> Result<String, InputError> {
        self.try_set(path, value)
    }

    fn reset(&mut self) -> Result<(), InputError> {
        if Session::reset(self) { Ok(()) } else { Err(InputError::new("reset", "a file of the scene cannot be read")) }
    }

    fn load(&mut self, file: &Path) -> Result<(), InputError> {
        // Opened twice, so that the answer holds the reason of an error.
        Session::open(file)?;
        if Session::load(self, file) { Ok(()) } else { Err(InputError::new("load", "cannot be opened")) }
    }
}
