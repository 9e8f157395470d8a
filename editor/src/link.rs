//! Live link of the editor: other processes observe the session and set parameters.

use std::time::Instant;

use sheetwork::World;
use sheetwork_link::link_place::LinkPlace;
use sheetwork_link::{AttachedProcess, Host, Link, LinkError, LinkStatistics};

/// Link that can be switched on and off.
#[derive(Default)]
pub struct LiveLink {
    link: Option<Link>,
    problem: Option<String>,
    now: LinkStatistics,
    /// Time of the last measurement of the rates, and frames and bytes at that time.
    since: Option<(Instant, u64, u64)>,
    /// Frames and bytes per second.
    rates: (f64, f64),
    /// Clients at the last measurement.
    who: Vec<AttachedProcess>,
}

/// Interval between measurements of rates and clients, s.
const MEASUREMENT_INTERVAL: f64 = 0.5;

impl LiveLink {
    /// Whether the link is open.
    pub fn is_on(&self) -> bool {
        self.link.is_some()
    }

    /// Whether any process is attached.
    pub fn is_attached(&self) -> bool {
        self.now.clients > 0 || self.now.readers.iter().any(|n| *n > 0)
    }

    /// Status in one line.
    pub fn status(&self) -> String {
        let Some(link) = &self.link else { return self.problem.clone().unwrap_or_else(|| "off".to_owned()) };
        let name = link.place().name();
        if !self.is_attached() {
            return format!("\"{name}\": no process is attached");
        }
        let (rate, bytes) = self.rates;
        let who = match self.who.as_slice() {
            // No measurement yet.
            [] => "attached".to_owned(),
            all => all.iter().map(AttachedProcess::to_string).collect::<Vec<_>>().join(", "),
        };
        format!("\"{name}\": {who}; {rate:.0} frames/s, {:.1} kB/s", 1e-3 * bytes)
    }

    /// Attached clients, at most half a second old.
    pub fn attached(&self) -> &[AttachedProcess] {
        &self.who
    }

    /// Open the link under its default name, or close it. A second editor appends its process id to
    /// the name.
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

    /// Open the link at a place.
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

    /// Publish the sheets again after a change of their number or grids.
    pub(crate) fn look_again(&mut self) {
        if let Some(link) = &mut self.link {
            link.invalidate_plan();
        }
    }

    /// Answer the requests of other processes and publish the world of `host`, whose steps take
    /// `step_s` s.
    pub(crate) fn exchange(&mut self, host: &mut dyn Host, step_s: f64) {
        let Some(link) = &mut self.link else { return };
        link.exchange(host, step_s);
        let before = std::mem::replace(&mut self.now, link.statistics());
        let (frames, bytes) = (self.now.frames, self.now.bytes);
        let (at, frames_then, bytes_then) = *self.since.get_or_insert_with(|| (Instant::now(), frames, bytes));
        let elapsed = at.elapsed().as_secs_f64();
        let changed = (before.clients, before.readers) != (self.now.clients, self.now.readers);
        if changed || elapsed > MEASUREMENT_INTERVAL {
            self.who = link.attached();
        }
        if elapsed > MEASUREMENT_INTERVAL {
            self.rates = ((frames - frames_then) as f64 / elapsed, (bytes - bytes_then) as f64 / elapsed);
            self.since = Some((Instant::now(), frames, bytes));
        }
    }
}
