//! A small game for the tests of the live link, stepped in the test's process or another.

use std::path::Path;

use sheetwork::scene::Scene;
use sheetwork::{InputError, World};
use sheetwork_link::Host;

/// A small sheet, clamped at one edge.
///
/// # Panics
/// An invalid scene.
pub fn strip() -> Scene {
    Scene::parse(
        r#"(name: "strip", dt: 0.004166666666666667, engine: "tr-bdf2", sheets: [(name: "strip", structure: "shell", grid: (9, 1, 5),
            size: (0.2, 0.1), material: "pet", damping_ratio: 0.2, pins: [(region: Left, clamp: true)])])"#,
    )
    .expect("valid")
}

/// A game that executes all commands.
pub struct TestGame {
    /// World of the game.
    pub world: World,
    /// Whether the simulation runs.
    pub playing: bool,
}

impl TestGame {
    /// A running game of `scene`.
    ///
    /// # Panics
    /// An invalid scene.
    pub fn new(scene: &Scene) -> Self {
        Self { world: World::new(scene).expect("valid"), playing: true }
    }
}

impl Host for TestGame {
    fn world(&self) -> &World {
        &self.world
    }

    fn world_mut(&mut self) -> &mut World {
        &mut self.world
    }

    fn playing(&self) -> bool {
        self.playing
    }

    fn play(&mut self, playing: bool) -> Result<(), InputError> {
        self.playing = playing;
        Ok(())
    }

    fn load(&mut self, file: &Path) -> Result<(), InputError> {
        self.world = World::new(&Scene::load(file)?)?;
        Ok(())
    }
}
