//! Live link (feature `link`): other processes read the sheets in shared memory and set parameters.
//!
//! See [`sheetwork_link`] for the data and `docs/link.md` for the protocol, the tools and access
//! rights.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use bevy::prelude::*;
use sheetwork::{InputError, World as Sheets};
use sheetwork_link::link_place::LinkPlace;
use sheetwork_link::{AttachedProcess, Host, Link, LinkError, LinkStatistics};

use crate::core::{SheetClock, SheetWorld, SheetworkSet};

/// Plugin that serves the [`SheetWorld`] to other processes.
///
/// ```no_run
/// # use bevy::prelude::*;
/// # use bevy_sheetwork::prelude::*;
/// App::new().add_plugins((DefaultPlugins, SheetworkPlugins, SheetLinkPlugin::default())).run();
/// ```
///
/// Clients are `sheetwork watch`, `sheetwork set gravity "(0, -1.6, 0)"`, and `sheetwork.attach()`
/// in Python. Commands are executed after every tick of `FixedUpdate` and once a frame; the state
/// is published after every tick. A request to load a scene is rejected: the game chooses its
/// scene. A reset returns the sheets to their initial state and the parameters set by clients to
/// the game's values.
#[derive(Clone, Debug, Default)]
pub struct SheetLinkPlugin {
    /// Name of the link: 1 to 32 letters, digits, `-` or `_`. Empty for the value of
    /// SHEETWORK_LINK, or "sheetwork".
    pub name: String,
    /// Folder of the link's files; `None` for the user's own. Must belong to this user, with mode
    /// 0700.
    pub root: Option<PathBuf>,
}

/// Link of a game. If it cannot be opened the game runs without it, and this resource holds the
/// reason.
#[derive(Resource)]
pub struct SheetLink {
    link: Result<Link, LinkError>,
    /// Parameters set by clients, and their values in the game.
    client_values: Vec<(String, String)>,
}

impl SheetLink {
    /// Clients and amount of data.
    ///
    /// # Errors
    /// The reason why the link could not be opened.
    pub fn statistics(&self) -> Result<LinkStatistics, LinkError> {
        self.link.as_ref().map(Link::statistics).map_err(Clone::clone)
    }

    /// Attached clients: process and name. Queries the operating system; avoid it in every frame.
    pub fn attached(&self) -> Vec<AttachedProcess> {
        self.link.as_ref().map(Link::attached).unwrap_or_default()
    }

    /// Name of the link; `None` without one.
    pub fn name(&self) -> Option<&str> {
        self.link.as_ref().ok().map(|l| l.place().name())
    }
}

impl Plugin for SheetLinkPlugin {
    fn build(&self, app: &mut App) {
        let world = app.world().get_resource::<SheetWorld>();
        let link = match world {
            Some(world) => {
                let place = match &self.root {
                    Some(root) => LinkPlace::within(root, &self.name),
                    None => LinkPlace::new(&self.name),
                };
                place.and_then(|place| Link::new(&place, world))
            }
            None => Err(LinkError::Refused("SheetLinkPlugin comes after SheetworkCorePlugin".into())),
        };
        match &link {
            Err(error @ LinkError::Taken(_)) => warn!("no live link: {error} or SheetLinkPlugin::name"),
            Err(error) => warn!("no live link: {error}"),
            Ok(_) => {}
        }
        app.insert_resource(SheetLink { link, client_values: Vec::new() });
        app.add_systems(FixedUpdate, exchange.after(SheetworkSet::Writeback).run_if(resource_exists::<SheetWorld>));
        app.add_systems(PreUpdate, answer.run_if(resource_exists::<SheetWorld>));
    }
}

/// A game as host of the link.
struct GameHost<'a> {
    world: &'a mut SheetWorld,
    clock: &'a mut SheetClock,
    client_values: &'a mut Vec<(String, String)>,
}

impl Host for GameHost<'_> {
    fn world(&self) -> &Sheets {
        self.world
    }

    fn world_mut(&mut self) -> &mut Sheets {
        self.world
    }

    fn playing(&self) -> bool {
        !self.clock.paused
    }

    fn play(&mut self, playing: bool) -> Result<(), InputError> {
        self.clock.paused = !playing;
        Ok(())
    }

    fn set(&mut self, path: &str, value: &str) -> Result<String, InputError> {
        let old = self.world.set(path, value)?;
        if !self.client_values.iter().any(|(p, _)| p == path) {
            self.client_values.push((path.to_owned(), old.clone()));
        }
        Ok(old)
    }

    fn reset(&mut self) -> Result<(), InputError> {
        // A temperature is state, not a setting: the reset restores it with the sheets.
        let is_state = |path: &str| path.starts_with("sheets.") && path.ends_with(".temperature");
        let now = self.world.parameters().into_iter().filter(|p| !is_state(&p.path));
        let own = |path: &str| self.client_values.iter().find(|(p, _)| p == path).map(|(_, old)| old.clone());
        let wanted: Vec<(String, String)> = now.map(|p| (own(&p.path).unwrap_or(p.value), p.path)).collect();
        self.world.reset()?;
        self.client_values.clear();
        let begun: BTreeMap<String, String> = self.world.parameters().into_iter().map(|p| (p.path, p.value)).collect();
        for (value, path) in wanted.iter().filter(|(value, path)| begun.get(path).is_some_and(|b| b != value)) {
            self.world.set(path, value)?;
        }
        Ok(())
    }

    fn load(&mut self, _file: &Path) -> Result<(), InputError> {
        Err(InputError::new("load", "this game decides itself which scene it shows"))
    }
}

impl<'a> GameHost<'a> {
    /// Reading the world is not a change; commands mark what they change.
    fn new(
        world: &'a mut ResMut<SheetWorld>,
        clock: &'a mut ResMut<SheetClock>,
        client_values: &'a mut Vec<(String, String)>,
    ) -> Self {
        Self { world: world.bypass_change_detection(), clock: clock.bypass_change_detection(), client_values }
    }
}

fn exchange(mut link: ResMut<SheetLink>, mut world: ResMut<SheetWorld>, mut clock: ResMut<SheetClock>) {
    let SheetLink { link: Ok(link), client_values } = &mut *link else { return };
    let step_time = world.step_time().as_secs_f64();
    link.exchange(&mut GameHost::new(&mut world, &mut clock, client_values), step_time);
}

fn answer(mut link: ResMut<SheetLink>, mut world: ResMut<SheetWorld>, mut clock: ResMut<SheetClock>) {
    let SheetLink { link: Ok(link), client_values } = &mut *link else { return };
    if link.is_commanded() {
        link.answer(&mut GameHost::new(&mut world, &mut clock, client_values));
    }
}
