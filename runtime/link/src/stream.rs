//! An output stream of the game: a service, its publisher, and shared memory that is reserved
//! before it is written.
//!
//! The system allocates shared memory at the first access, and kills the process if none is left. A
//! stream therefore checks the free memory when readers attach, touches the samples that they need,
//! and writes to no others.

use std::mem::MaybeUninit;

use iceoryx2::port::publisher::Publisher;
use iceoryx2::port::update_connections::UpdateConnections;
use iceoryx2::prelude::*;
use iceoryx2::service::builder::publish_subscribe::{PublishSubscribeOpenError, PublishSubscribeOpenOrCreateError};
use iceoryx2::service::port_factory::publish_subscribe::PortFactory as Factory;

use crate::link_place::{LinkPlace, free_shared_memory};
use crate::{Ipc, LinkError, MAXIMUM_CLIENTS};

/// Shared memory left free, bytes; far above the need of iceoryx2 for a new reader.
pub const FREE_MEMORY_MARGIN: u64 = 4 << 20;
/// Bytes of a word.
const WORD: usize = size_of::<u64>();
/// Maximum number of samples that a reader holds.
pub const MAXIMUM_BORROWED: usize = 2;
/// Maximum number of processes of a service: readers, the game, and some that are about to be
/// removed.
const MAXIMUM_NODES: usize = 2 * MAXIMUM_CLIENTS + 2;

/// A service of bytes in aligned words of eight.
pub type ByteService = Factory<Ipc, [u64], ()>;

/// Queue sizes of a stream.
#[derive(Clone, Copy, Debug)]
pub struct StreamQueue {
    /// Samples that a reader may lag behind before it misses some.
    pub buffer_size: usize,
    /// Samples for a reader that attaches later.
    pub history: usize,
}

/// Queue of frames and of fields.
pub const FRAMES: StreamQueue = StreamQueue { buffer_size: 4, history: 0 };
/// Queue of events.
pub const EVENTS: StreamQueue = StreamQueue { buffer_size: 64, history: 0 };
/// Queue of topology; only the newest sample is valid.
pub const TOPOLOGY: StreamQueue = StreamQueue { buffer_size: 1, history: 1 };

/// Opens the service of stream `what`, which a game has created.
pub fn open(node: &Node<Ipc>, place: &LinkPlace, what: &str) -> Result<ByteService, LinkError> {
    let name = place.service(what)?;
    node.service_builder(&name).publish_subscribe::<[u64]>().open().map_err(|e| not_opened(place, &e))
}

/// Opens or creates the service of stream `what`.
fn make(node: &Node<Ipc>, place: &LinkPlace, what: &str, queue: StreamQueue) -> Result<ByteService, LinkError> {
    let name = place.service(what)?;
    let builder = node.service_builder(&name).publish_subscribe::<[u64]>();
    let made = builder
        .max_publishers(1)
        .max_subscribers(MAXIMUM_CLIENTS)
        .max_nodes(MAXIMUM_NODES)
        .subscriber_max_buffer_size(queue.buffer_size)
        .subscriber_max_borrowed_samples(MAXIMUM_BORROWED)
        .history_size(queue.history)
        .enable_safe_overflow(true)
        .open_or_create();
    made.map_err(|e| match e {
        PublishSubscribeOpenOrCreateError::PublishSubscribeOpenError(e) => not_opened(place, &e),
        e => LinkError::Memory(format!("{name}: {e:?}")),
    })
}

fn not_opened(place: &LinkPlace, error: &PublishSubscribeOpenError) -> LinkError {
    match error {
        PublishSubscribeOpenError::DoesNotExist => LinkError::NoGame(place.name().into(), String::new()),
        PublishSubscribeOpenError::InsufficientPermissions => {
            LinkError::Refused(format!("{}: not allowed; a link is for its own user", place.root().display()))
        }
        PublishSubscribeOpenError::ExceedsMaxNumberOfNodes => LinkError::Full("be attached to a game"),
        e => LinkError::Unlike(format!("{e:?}")),
    }
}

/// The game's end of a stream.
pub struct Stream {
    service: ByteService,
    publisher: Option<Publisher<Ipc, [u64], ()>>,
    /// Samples per reader, and further samples: the history, one being written, and one spare.
    each: usize,
    own: usize,
    /// Maximum size of a sample, bytes.
    capacity: usize,
    /// Number of readers at the last call, and number of readers with reserved memory.
    readers: usize,
    ready_for: usize,
    /// Samples written.
    pub written: u64,
    /// Samples not written for lack of memory.
    pub dropped: u64,
    /// Bytes written.
    pub bytes: u64,
}

impl Stream {
    /// Stream `what` for samples of up to `capacity` bytes.
    pub fn new(
        node: &Node<Ipc>,
        place: &LinkPlace,
        what: &str,
        queue: StreamQueue,
        capacity: usize,
    ) -> Result<Self, LinkError> {
        let mut stream = Self {
            service: make(node, place, what, queue)?,
            publisher: None,
            each: queue.buffer_size + MAXIMUM_BORROWED,
            own: queue.history + 2,
            capacity: 0,
            readers: 0,
            ready_for: 0,
            written: 0,
            dropped: 0,
            bytes: 0,
        };
        stream.resize(place, capacity)?;
        Ok(stream)
    }

    /// Resizes samples to `capacity` bytes; readers stay attached.
    pub fn resize(&mut self, place: &LinkPlace, capacity: usize) -> Result<(), LinkError> {
        use iceoryx2::port::publisher::PublisherCreateError::ExceedsMaxSupportedPublishers;
        if capacity <= self.capacity && self.publisher.is_some() {
            return Ok(());
        }
        self.publisher = None;
        let chunks = MAXIMUM_CLIENTS * self.each + self.own;
        let builder = self.service.publisher_builder().initial_max_slice_len(capacity.div_ceil(WORD));
        let made = builder
            .allocation_strategy(AllocationStrategy::Static)
            .backpressure_strategy(BackpressureStrategy::DiscardData)
            .override_sample_preallocation(move |_| chunks)
            .max_loaned_samples(chunks)
            .create();
        self.publisher = Some(made.map_err(|e| match e {
            ExceedsMaxSupportedPublishers => LinkError::Taken(place.name().into()),
            e => LinkError::Memory(format!("{e:?}")),
        })?);
        (self.capacity, self.ready_for) = (capacity, 0);
        Ok(())
    }

    /// Number of readers.
    #[inline]
    pub fn readers(&self) -> usize {
        self.service.dynamic_config().number_of_subscribers()
    }

    /// Writes a sample of `bytes` bytes, rounded up to eight, for the present readers, with `fill`.
    /// False without memory.
    pub fn write(&mut self, readers: usize, bytes: usize, fill: impl FnOnce(&mut [u8])) -> bool {
        let sent = self.reserve_for(readers) && self.send(bytes, fill);
        if sent {
            self.written += 1;
            self.bytes += bytes as u64;
        } else {
            self.dropped += 1;
        }
        sent
    }

    /// Sends the history to new readers without a new sample.
    pub fn send_history(&mut self, readers: usize) {
        if let (true, Some(publisher)) = (self.reserve_for(readers), &self.publisher) {
            // Readers that cannot be reached are retried at the next call.
            let _ = publisher.update_connections();
        }
    }

    /// Calls `each` with the process of every reader.
    pub fn list(&self, mut each: impl FnMut(u32)) {
        self.service.dynamic_config().list_subscribers(|reader| {
            if let Ok(process) = reader.node_id.pid::<Ipc>() {
                each(process.value() as u32);
            }
            CallbackProgression::Continue
        });
    }

    fn send(&self, bytes: usize, fill: impl FnOnce(&mut [u8])) -> bool {
        let Some(publisher) = &self.publisher else { return false };
        let Ok(mut sample) = publisher.loan_slice_uninit(bytes.div_ceil(WORD)) else { return false };
        fill(initialised(sample.payload_mut()));
        // SAFETY: the memory has been touched, and `fill` has written the part that readers
        // access.
        let sample = unsafe { sample.assume_init() };
        sample.send().is_ok()
    }

    /// Reserves memory for `readers` readers; false without enough memory.
    fn reserve_for(&mut self, readers: usize) -> bool {
        if readers == self.readers && readers <= self.ready_for {
            return true;
        }
        let chunks = readers.min(MAXIMUM_CLIENTS) * self.each + self.own;
        let needed = if readers > self.ready_for { chunks * (self.capacity + 256) } else { 0 };
        if free_shared_memory() < FREE_MEMORY_MARGIN + needed as u64 {
            return false;
        }
        if readers > self.ready_for {
            self.reserve_samples(chunks);
            self.ready_for = readers;
        }
        self.readers = readers;
        true
    }

    /// Loans `chunks` samples at once, writes to all of them and returns them. Free samples are
    /// reused last in, first out, so these are in use from then on.
    fn reserve_samples(&self, chunks: usize) {
        let Some(publisher) = &self.publisher else { return };
        let mut held = Vec::with_capacity(chunks);
        for _ in 0..chunks {
            let Ok(mut sample) = publisher.loan_slice_uninit(self.capacity.div_ceil(WORD)) else { break };
            initialised(sample.payload_mut()).fill(0);
            held.push(sample);
        }
    }
}

/// Words of shared memory as bytes.
fn initialised(words: &mut [MaybeUninit<u64>]) -> &mut [u8] {
    let bytes = size_of_val(words);
    // SAFETY: pages of shared memory are zero before the first write, so all bytes are initialised.
    unsafe { std::slice::from_raw_parts_mut(words.as_mut_ptr().cast(), bytes) }
}

/// Received words as bytes.
pub fn bytes_of(words: &[u64]) -> &[u8] {
    // SAFETY: a u64 is eight bytes, and a byte has alignment 1.
    unsafe { std::slice::from_raw_parts(words.as_ptr().cast(), size_of_val(words)) }
}
