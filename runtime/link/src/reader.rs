//! Readers of a game's streams: frames, topology, events.
//!
//! A reader polls shared memory without the game's involvement. A wait polls every 50 µs.

use std::sync::Arc;
use std::time::{Duration, Instant};

use iceoryx2::port::subscriber::{Subscriber, SubscriberCreateError};
use iceoryx2::prelude::*;
use iceoryx2::sample::Sample;
use serde_json::{Map, Value};

use crate::layout::{FrameHeader, FrameView};
use crate::link_place::LinkPlace;
use crate::stream::{ByteService, bytes_of, open};
use crate::topology::{Meshes, SheetMesh};
use crate::{Ipc, LinkError, clean_up};

/// Poll interval of a wait.
pub(crate) const POLL_INTERVAL: Duration = Duration::from_micros(50);
/// Time without a sample after which a reader removes the remains of terminated processes.
const CLEAN_UP_DELAY: Duration = Duration::from_secs(1);

/// A subscription to a stream, with the objects that it depends on.
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

    /// Removes the remains of terminated processes.
    fn clean_up(&self) {
        clean_up(&self.node, &self.place);
    }

    /// The next sample; none if no sample has arrived.
    fn receive(&self) -> Result<Option<Sample<Ipc, [u64], ()>>, LinkError> {
        self.port.receive().map_err(|e| LinkError::Memory(format!("a sample cannot be received: {e:?}")))
    }
}

/// Subscription to frames.
pub struct Frames {
    port: Reader,
    last: Option<FrameHeader>,
    missed: u64,
    restarts: u64,
    faulty: u64,
    heard: Instant,
}

/// A frame in shared memory. It occupies one of few samples: read it and drop it.
pub struct Frame {
    sample: Sample<Ipc, [u64], ()>,
    header: FrameHeader,
}

impl Frame {
    /// Values common to its sheets.
    pub fn header(&self) -> &FrameHeader {
        &self.header
    }

    /// The whole frame.
    ///
    /// # Errors
    /// A sample that the game has corrupted after sending it.
    pub fn view(&self) -> Result<FrameView<'_>, LinkError> {
        FrameView::new(bytes_of(self.sample.payload())).map_err(LinkError::Unlike)
    }
}

impl Frames {
    pub(crate) fn new(node: &Arc<Node<Ipc>>, place: &LinkPlace, complete: bool) -> Result<Self, LinkError> {
        let port = Reader::new(node, place, if complete { "fields" } else { "frames" })?;
        Ok(Self { port, last: None, missed: 0, restarts: 0, faulty: 0, heard: Instant::now() })
    }

    /// The newest frame since the last call; none without a new frame. Older ones are skipped.
    ///
    /// # Errors
    /// A frame with another layout, or a damaged one.
    pub fn latest(&mut self) -> Result<Option<Frame>, LinkError> {
        let mut newest = None;
        while let Some(frame) = self.next()? {
            newest = Some(frame);
        }
        Ok(newest)
    }

    /// The next frame; none without a new frame.
    ///
    /// # Errors
    /// A frame with another layout, or a damaged one.
    #[allow(clippy::should_implement_trait)]
    pub fn next(&mut self) -> Result<Option<Frame>, LinkError> {
        let Some(sample) = self.port.receive()? else {
            if self.heard.elapsed() > CLEAN_UP_DELAY {
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

    /// Waits for the next frame.
    ///
    /// # Errors
    /// [`LinkError::Silent`] after `patience`, or an unreadable frame.
    pub fn wait(&mut self, patience: Duration) -> Result<Frame, LinkError> {
        let start = Instant::now();
        loop {
            if let Some(frame) = self.next()? {
                return Ok(frame);
            }
            if start.elapsed() > patience {
                return Err(LinkError::Silent);
            }
            std::thread::sleep(POLL_INTERVAL);
        }
    }

    /// Number of missed frames of the present epoch.
    pub fn missed(&self) -> u64 {
        self.missed
    }

    /// Number of changes of the epoch.
    pub fn restarts(&self) -> u64 {
        self.restarts
    }

    /// Number of unreadable samples.
    pub fn faulty(&self) -> u64 {
        self.faulty
    }
}

/// Subscription to the topology of a game's sheets.
pub struct Topology {
    port: Reader,
    now: Meshes,
}

impl Topology {
    pub(crate) fn new(node: &Arc<Node<Ipc>>, place: &LinkPlace) -> Result<Self, LinkError> {
        Ok(Self { port: Reader::new(node, place, "topology")?, now: Meshes::default() })
    }

    /// Receives the topology. Returns whether it belongs to the frame with `header` or is a later
    /// one of its epoch, in which triangles that have opened since the frame are missing. False for
    /// a moment after attaching.
    ///
    /// # Errors
    /// A sample with another layout, or a damaged one; the previous topology remains.
    pub fn follow(&mut self, header: &FrameHeader) -> Result<bool, LinkError> {
        while let Some(sample) = self.port.receive()? {
            self.now = Meshes::read(bytes_of(sample.payload())).map_err(LinkError::Unlike)?;
        }
        Ok(self.now.epoch == header.epoch && self.now.version >= header.topology)
    }

    /// Waits up to `patience` for the topology of the frame with `header`.
    ///
    /// # Errors
    /// [`LinkError::Silent`] after that time, or an unreadable sample.
    pub fn wait(&mut self, header: &FrameHeader, patience: Duration) -> Result<&[SheetMesh], LinkError> {
        let start = Instant::now();
        while !self.follow(header)? {
            if start.elapsed() > patience {
                self.port.clean_up();
                return Err(LinkError::Silent);
            }
            std::thread::sleep(POLL_INTERVAL);
        }
        Ok(&self.now.sheets)
    }

    /// Topology of all sheets, in the order of the frames; empty before the first sample.
    pub fn sheets(&self) -> &[SheetMesh] {
        &self.now.sheets
    }

    /// Topology of the sheet of that name.
    pub fn sheet(&self, name: &str) -> Option<&SheetMesh> {
        self.now.sheets.iter().find(|s| s.name == name)
    }

    /// Version of the topology in its epoch; 0 before the first sample.
    pub fn version(&self) -> u32 {
        self.now.version
    }
}

/// Subscription to events.
pub struct Events {
    port: Reader,
}

impl Events {
    pub(crate) fn new(node: &Arc<Node<Ipc>>, place: &LinkPlace) -> Result<Self, LinkError> {
        Ok(Self { port: Reader::new(node, place, "events")? })
    }

    /// The next event, a JSON object; none without a new event. Unreadable samples are skipped.
    ///
    /// # Errors
    /// Unreadable shared memory.
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
