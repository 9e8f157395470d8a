//! The live link (feature `link`): other processes see the sheets in shared memory and turn their knobs.
//!
//! See [`sheetwork_link`] for what goes over it, and `docs/link.md` for the protocol, the tools and who may attach.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use bevy::prelude::*;
use sheetwork::{InputError, World as Sheets};
use sheetwork_link::Attached;
use sheetwork_link::Host;
use sheetwork_link::LinkError;
use sheetwork_link::place::LinkPlace;
use sheetwork_link::{Link, LinkStatistics};

use crate::core::{SheetClock, SheetWorld, SheetworkSet};

/// Serves the [`SheetWorld`] to other processes.
///
/// ```no_run
/// # use bevy::prelude::*;
/// # use bevy_sheetwork::prelude::*;
/// App::new().add_plugins((DefaultPlugins, SheetworkPlugins, SheetLinkPlugin::default())).run();
/// ```
///
/// Then `sheetwork watch`, `sheetwork set gravity "(0, -1.6, 0)"`, or `sheetwork.attach()` in Python. Commands are done, and the
/// sheets shown, after every tick of `FixedUpdate`; commands also once a frame. The game decides which scene it shows:
/// it refuses to load one. A reset puts the sheets back to where they came in, and what others have set to what the game had it at.
#[derive(Clone, Debug, Default)]
pub struct SheetLinkPlugin {
    /// Name of the link, 1 to 32 letters, digits, `-` or `_`; empty for SHEETWORK_LINK's, or "sheetwork".
    pub name: String,
    /// Folder of its files; the user's own if none. Must be this user's, with mode 0700.
    pub root: Option<PathBuf>,
}

/// The link of a game. Where it could not be opened the game goes on without, and this says why.
#[derive(Resource)]
pub struct SheetLink {
    link: Result<Link, LinkError>,
    /// What others have set, and the value that the game had it at.
    turned: Vec<(String, String)>,
}

impl SheetLink {
    /// Who is attached and what was written; the reason where there is no link.
    ///
    /// # Errors
    /// Why it could not be opened.
    pub fn statistics(&self) -> Result<LinkStatistics, LinkError> {
        self.link.as_ref().map(Link::statistics).map_err(Clone::clone)
    }

    /// Who is attached: process and name. Asks the system: not to be called in every frame.
    pub fn attached(&self) -> Vec<Attached> {
        self.link.as_ref().map(Link::attached).unwrap_or_default()
    }

    /// Name of the link; none where there is none.
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
        if let Err(error) = &link {
            warn!("no live link: {error}");
        }
        app.insert_resource(SheetLink { link, turned: Vec::new() });
        app.add_systems(FixedUpdate, exchange.after(SheetworkSet::Writeback).run_if(resource_exists::<SheetWorld>));
        app.add_systems(PreUpdate, answer.run_if(resource_exists::<SheetWorld>));
    }
}

/// A game as the link drives it.
struct Driven<'a> {
    world: &'a mut SheetWorld,
    clock: &'a mut SheetClock,
    turned: &'a mut Vec<(String, String)>,
}

impl Host for Driven<'_> {
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
        if !self.turned.iter().any(|(p, _)| p == path) {
            self.turned.push((path.to_owned(), old.clone()));
        }
        Ok(old)
    }

    fn reset(&mut self) -> Result<(), InputError> {
        // Warmth is no setting: it goes back with the sheets.
        let is_state = |path: &str| path.starts_with("sheets.") && path.ends_with(".temperature");
        let now = self.world.parameters().into_iter().filter(|p| !is_state(&p.path));
        let own = |path: &str| self.turned.iter().find(|(p, _)| p == path).map(|(_, old)| old.clone());
        let wanted: Vec<(String, String)> = now.map(|p| (own(&p.path).unwrap_or(p.value), p.path)).collect();
        self.world.reset()?;
        self.turned.clear();
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

impl<'a> Driven<'a> {
    /// Being looked at is no change; what is commanded changes what it changes.
    fn new(
        world: &'a mut ResMut<SheetWorld>,
        clock: &'a mut ResMut<SheetClock>,
        turned: &'a mut Vec<(String, String)>,
    ) -> Self {
        Self { world: world.bypass_change_detection(), clock: clock.bypass_change_detection(), turned }
    }
}

fn exchange(mut link: ResMut<SheetLink>, mut world: ResMut<SheetWorld>, mut clock: ResMut<SheetClock>) {
    let SheetLink { link: Ok(link), turned } = &mut *link else { return };
    let step_time = world.step_time().as_secs_f64();
    link.exchange(&mut Driven::new(&mut world, &mut clock, turned), step_time);
}

fn answer(mut link: ResMut<SheetLink>, mut world: ResMut<SheetWorld>, mut clock: ResMut<SheetClock>) {
    let SheetLink { link: Ok(link), turned } = &mut *link else { return };
    if link.is_commanded() {
        link.answer(&mut Driven::new(&mut world, &mut clock, turned));
    }
}
