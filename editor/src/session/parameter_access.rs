//! The session as owner of parameters for the panels that the inspector shares.

use bevy_sheetwork::inspector::ParameterAccess;
use sheetwork::World;

use super::Session;

impl ParameterAccess for Session {
    fn world(&self) -> &World {
        Session::world(self)
    }

    fn set(&mut self, path: &str, value: &str) -> bool {
        Session::set(self, path, value)
    }

    fn set_default(&mut self, path: &str) -> bool {
        self.default_of(path).is_some_and(|value| self.set(path, &value))
    }

    fn fail(&mut self, text: String) {
        Session::fail(self, text);
    }

    fn step_s(&self) -> f64 {
        self.timing().step_s
    }

    fn speed(&self) -> f64 {
        Session::speed(self)
    }

    fn largest_step(&self) -> Option<f64> {
        self.largest_step
    }
}
