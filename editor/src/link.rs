//! The editor's live link: other processes watch the session and turn its knobs.

use std::path::Path;
use std::time::Instant;

use sheetwork::{InputError, World};
use sheetwork_link::Attached;
use sheetwork_link::Host;
use sheetwork_link::LinkError;
use sheetwork_link::place::LinkPlace;
use sheetwork_link::{Link, LinkStatistics};

use crate::session::Session;

/// A link that can be switched on and off.
#[derive(Default)]
pub struct LiveLink {
    link: Option<Link>,
    problem: Option<String>,
    now: LinkStatistics,
    /// When the rates were last taken, and frames and bytes then.
    since: Option<(Instant, u64, u64)>,
    /// Frames and bytes a second.
    rates: (f64, f64),
    /// Who is attached, as it was when the rates were taken.
    who: Vec<Attached>,
}

/// How often rates and names are taken, s.
const TAKEN_EVERY: f64 = 0.5;

impl LiveLink {
    /// Whether it is on.
    pub fn is_on(&self) -> bool {
        self.link.is_some()
    }

    /// Whether any process is attached.
    pub fn is_attached(&self) -> bool {
        self.now.clients > 0 || self.now.readers.iter().any(|n| *n > 0)
    }

    /// Its state in a line.
    pub fn status(&self) -> String {
        let Some(link) = &self.link else { return self.problem.clone().unwrap_or_else(|| "off".to_owned()) };
        let name = link.place().name();
        if !self.is_attached() {
            return format!("\"{name}\": nobody is attached");
        }
        let (rate, bytes) = self.rates;
        let who = match self.who.as_slice() {
            // Not asked yet.
            [] => "somebody".to_owned(),
            all => all.iter().map(Attached::to_string).collect::<Vec<_>>().join(", "),
        };
        format!("\"{name}\": {who}; {rate:.0} frames/s, {:.1} kB/s", 1e-3 * bytes)
    }

    /// Who is attached, as it was half a second ago at most.
    pub fn attached(&self) -> &[Attached] {
        &self.who
    }

    /// Opens it under the usual name, or closes it. A second editor gets a name with its process's number.
    pub(crate) fn switch(&mut self, on: bool, world: &World) {
        *self = Self::default();
        if !on {
            return;
        }
        let usual = LinkPlace::new("").and_then(|place| Link::new(&place, world));
        let opened = match usual {
            Err(LinkError::Taken(_)) => {
                LinkPlace::new(&format!("sheetwork-{}", std::process::id())).and_then(|place| Link::new(&place, world))
            }
            result => result,
        };
        self.take(opened);
    }

    /// Opens it at a place.
    pub(crate) fn open(&mut self, place: &LinkPlace, world: &World) {
        *self = Self::default();
        self.take(Link::new(place, world));
    }

    fn take(&mut self, opened: Result<Link, LinkError>) {
        match opened {
            Ok(link) => self.link = Some(link),
            Err(error) => self.problem = Some(error.to_string()),
        }
    }

    /// Tells it that the sheets are others.
    pub(crate) fn look_again(&mut self) {
        if let Some(link) = &mut self.link {
            link.look_again();
        }
    }

    pub(crate) fn exchange(&mut self, session: &mut Session) {
        let Some(link) = &mut self.link else { return };
        let step_time = session.timing().step_s;
        link.exchange(session, step_time);
        let before = std::mem::replace(&mut self.now, link.statistics());
        let (frames, bytes) = (self.now.frames, self.now.bytes);
        let (at, frames_then, bytes_then) = *self.since.get_or_insert_with(|| (Instant::now(), frames, bytes));
        let elapsed = at.elapsed().as_secs_f64();
        let changed = (before.clients, before.readers) != (self.now.clients, self.now.readers);
        if changed || elapsed > TAKEN_EVERY {
            self.who = link.attached();
        }
        if elapsed > TAKEN_EVERY {
            self.rates = ((frames - frames_then) as f64 / elapsed, (bytes - bytes_then) as f64 / elapsed);
            self.since = Some((Instant::now(), frames, bytes));
        }
    }
}

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
        // Refused before it is opened, so that the answer says why.
        Session::open(file)?;
        if Session::load(self, file) { Ok(()) } else { Err(InputError::new("load", "cannot be opened")) }
    }
}
