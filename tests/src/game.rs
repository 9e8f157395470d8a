//! What tests of the live link share: a game small enough to be stepped in their own process or another.

use std::path::Path;

use sheetwork::scene::Scene;
use sheetwork::{InputError, World};
use sheetwork_link::Host;

/// A small sheet, clamped at one edge.
///
/// # Panics
/// When the scene in here is not valid.
pub fn strip() -> Scene {
    Scene::parse(
        r#"(name: "strip", dt: 0.004166666666666667, engine: "tr-bdf2", sheets: [(name: "strip", structure: "shell", grid: (9, 1, 5),
            size: (0.2, 0.1), material: "pet", damping_ratio: 0.2, pins: [(region: Left, clamp: true)])])"#,
    )
    .expect("valid")
}

/// A game that does what it is told.
pub struct Game {
    /// Its world.
    pub world: World,
    /// Whether time passes.
    pub playing: bool,
}

impl Game {
    /// One that plays `scene`.
    ///
    /// # Panics
    /// When the scene cannot be built: a test must fail then.
    pub fn new(scene: &Scene) -> Self {
        Self { world: World::new(scene).expect("valid"), playing: true }
    }
}

impl Host for Game {
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
