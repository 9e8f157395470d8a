//! Reading what a game shows: frames, topology, events.
//!
//! A reader looks into shared memory whenever it wants to; the game does not know when. Waiting is looking again every 50 µs.

use std::sync::Arc;
use std::time::{Duration, Instant};

use iceoryx2::port::subscriber::{Subscriber, SubscriberCreateError};
use iceoryx2::prelude::*;
use iceoryx2::sample::Sample;
use serde_json::{Map, Value};

use crate::layout::{FrameHeader, FrameView};
use crate::place::LinkPlace;
use crate::stream::{ByteService, bytes_of, open};
use crate::topology::{Meshes, SheetMesh};
use crate::{Ipc, LinkError, clean_up};

/// How often one who waits looks.
pub(crate) const LOOK_EVERY: Duration = Duration::from_micros(50);
/// After so long without a sign of the game, what dead processes left is looked for.
const QUIET: Duration = Duration::from_secs(1);

/// A reader's end of a stream, with what it needs to live.
struct Reader {
    port: Subscriber<Ipc, [u64], ()>,
    _service: ByteService,
    node: Arc<Node<Ipc>>,
    place: LinkPlace,
}

impl Reader {
    fn new(node: &Arc<Node<Ipc>>, place: &LinkPlace, what: &'static str) -> Result<Self, LinkError> {
        let service = open(node, place, what)?;
        let port = service.subscriber_builder().create().map_err(|e| match e {
            SubscriberCreateError::ExceedsMaxSupportedSubscribers => LinkError::Full(match what {
                "frames" => "read a game's frames",
                "fields" => "read a game's fields",
                "events" => "hear a game's events",
                _ => "read a game's topology",
            }),
            e => LinkError::Memory(format!("nobody can read {what}: {e:?}")),
        })?;
        Ok(Self { port, _service: service, node: Arc::clone(node), place: place.clone() })
    }

    /// Removes what dead processes have left.
    fn clean_up(&self) {
        clean_up(&self.node, &self.place);
    }

    /// The next sample; none where there is none yet.
    fn receive(&self) -> Result<Option<Sample<Ipc, [u64], ()>>, LinkError> {
        self.port.receive().map_err(|e| LinkError::Memory(format!("a sample cannot be received: {e:?}")))
    }
}

/// Frames of a game, as they come.
pub struct Frames {
    port: Reader,
    last: Option<FrameHeader>,
    missed: u64,
    restarts: u64,
    faulty: u64,
    heard: Instant,
}

/// A frame, where the game wrote it. It holds one of the few places there are: look at it and let it go.
pub struct Frame {
    sample: Sample<Ipc, [u64], ()>,
    header: FrameHeader,
}

impl Frame {
    /// What is common to its sheets.
    pub fn header(&self) -> &FrameHeader {
        &self.header
    }

    /// The whole frame.
    ///
    /// # Errors
    /// When the game has gone mad since it was received, and writes to what it gave away.
    pub fn view(&self) -> Result<FrameView<'_>, LinkError> {
        FrameView::new(bytes_of(self.sample.payload())).map_err(LinkError::Unlike)
    }
}

impl Frames {
    pub(crate) fn new(node: &Arc<Node<Ipc>>, place: &LinkPlace, complete: bool) -> Result<Self, LinkError> {
        let port = Reader::new(node, place, if complete { "fields" } else { "frames" })?;
        Ok(Self { port, last: None, missed: 0, restarts: 0, faulty: 0, heard: Instant::now() })
    }

    /// The newest frame since the last call; none where there is none. Those between are passed over.
    ///
    /// # Errors
    /// When the newest cannot be read: it is of another layout, or damaged.
    pub fn latest(&mut self) -> Result<Option<Frame>, LinkError> {
        let mut newest = None;
        while let Some(frame) = self.next()? {
            newest = Some(frame);
        }
        Ok(newest)
    }

    /// The next frame; none where there is none yet.
    ///
    /// # Errors
    /// When it cannot be read: it is of another layout, or damaged.
    #[allow(clippy::should_implement_trait)]
    pub fn next(&mut self) -> Result<Option<Frame>, LinkError> {
        let Some(sample) = self.port.receive()? else {
            if self.heard.elapsed() > QUIET {
                self.heard = Instant::now();
                self.port.clean_up();
            }
            return Ok(None);
        };
        self.heard = Instant::now();
        let header = match FrameView::new(bytes_of(sample.payload())) {
            Ok(view) => *view.header(),
            Err(problem) => {
                self.faulty += 1;
                return Err(LinkError::Unlike(problem));
            }
        };
        if let Some(last) = &self.last {
            if last.epoch == header.epoch {
                self.missed += header.frame.saturating_sub(last.frame + 1);
            } else {
                self.restarts += 1;
            }
        }
        self.last = Some(header);
        Ok(Some(Frame { sample, header }))
    }

    /// The next frame, waited for.
    ///
    /// # Errors
    /// [`LinkError::Silent`] after `patience`; or it cannot be read.
    pub fn wait(&mut self, patience: Duration) -> Result<Frame, LinkError> {
        let start = Instant::now();
        loop {
            if let Some(frame) = self.next()? {
                return Ok(frame);
            }
            if start.elapsed() > patience {
                return Err(LinkError::Silent);
            }
            std::thread::sleep(LOOK_EVERY);
        }
    }

    /// Frames of the present epoch that went by unread.
    pub fn missed(&self) -> u64 {
        self.missed
    }

    /// Times the game was another than before.
    pub fn restarts(&self) -> u64 {
        self.restarts
    }

    /// Samples that could not be read.
    pub fn faulty(&self) -> u64 {
        self.faulty
    }
}

/// Which masses of a game's sheets make triangles, as that changes.
pub struct Topology {
    port: Reader,
    now: Meshes,
}

impl Topology {
    pub(crate) fn new(node: &Arc<Node<Ipc>>, place: &LinkPlace) -> Result<Self, LinkError> {
        Ok(Self { port: Reader::new(node, place, "topology")?, now: Meshes::default() })
    }

    /// Takes up what has come, and says whether that is the topology of the frame with `header`, or a later one of its epoch: triangles
    /// that have opened since the frame are then missing already. False for a moment after attaching.
    ///
    /// # Errors
    /// When it cannot be read: it is of another layout, or damaged. What there was before stays.
    pub fn follow(&mut self, header: &FrameHeader) -> Result<bool, LinkError> {
        while let Some(sample) = self.port.receive()? {
            self.now = Meshes::read(bytes_of(sample.payload())).map_err(LinkError::Unlike)?;
        }
        Ok(self.now.epoch == header.epoch && self.now.version >= header.topology)
    }

    /// Waits up to `patience` for the topology of the frame with `header`.
    ///
    /// # Errors
    /// [`LinkError::Silent`] after that time; or it cannot be read.
    pub fn wait(&mut self, header: &FrameHeader, patience: Duration) -> Result<&[SheetMesh], LinkError> {
        let start = Instant::now();
        while !self.follow(header)? {
            if start.elapsed() > patience {
                self.port.clean_up();
                return Err(LinkError::Silent);
            }
            std::thread::sleep(LOOK_EVERY);
        }
        Ok(&self.now.sheets)
    }

    /// The topology of all sheets, in the order that frames have them, as far as it has come.
    pub fn sheets(&self) -> &[SheetMesh] {
        &self.now.sheets
    }

    /// The topology of the sheet of that name.
    pub fn sheet(&self, name: &str) -> Option<&SheetMesh> {
        self.now.sheets.iter().find(|s| s.name == name)
    }

    /// Which topology of its epoch it is; 0 before any came.
    pub fn version(&self) -> u32 {
        self.now.version
    }
}

/// Events of a game, as they come.
pub struct Events {
    port: Reader,
}

impl Events {
    pub(crate) fn new(node: &Arc<Node<Ipc>>, place: &LinkPlace) -> Result<Self, LinkError> {
        Ok(Self { port: Reader::new(node, place, "events")? })
    }

    /// The next event, a JSON object; none where there is none yet. What cannot be read is passed over.
    ///
    /// # Errors
    /// When shared memory cannot be read.
    #[allow(clippy::should_implement_trait)]
    pub fn next(&mut self) -> Result<Option<Map<String, Value>>, LinkError> {
        loop {
            let Some(sample) = self.port.receive()? else { return Ok(None) };
            if let Ok(event) = serde_json::from_slice(bytes_of(sample.payload())) {
                return Ok(Some(event));
            }
        }
    }
}
