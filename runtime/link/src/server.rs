//! The game's end of a link.

use std::sync::Arc;
use std::sync::mpsc::{Sender, channel};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use iceoryx2::port::server::Server;
use iceoryx2::prelude::*;
use iceoryx2::service::port_factory::request_response::PortFactory as Factory;
use serde_json::{Value, json};

use crate::attached_process::AttachedProcess;
use crate::command::{Command, Host};
use crate::command_handler::{ANSWER_BYTES, CommandHandler, unstable_sheets};
use crate::link_place::{LinkPlace, free_shared_memory};
use crate::plan::{FramePlan, MINIMUM_SAMPLE_BYTES};
use crate::stream::{EVENTS, FRAMES, FREE_MEMORY_MARGIN, Stream, TOPOLOGY};
use crate::write::{FrameStamp, frame};
use crate::{Ipc, LinkError, MAXIMUM_CLIENTS, clean_up, monotonic_ns, node_at, topology};
use sheetwork::World;
use sheetwork::islands::event::Event;
use sheetwork::sheet::Status;

/// Interval between removals of the remains of terminated processes.
const HOUSEKEEPING: Duration = Duration::from_millis(500);
/// Time limit for the end of the housekeeping thread when a link is dropped.
const SHUTDOWN_TIMEOUT: Duration = Duration::from_secs(2);
/// Maximum number of commands in one exchange; more are spread over the steps.
const MAXIMUM_COMMANDS: usize = 64;
/// Interval between frames of a resting world, ns.
const IDLE_FRAME_INTERVAL_NS: u64 = 100_000_000;
/// Calls between two counts: of readers of events, which decide on buckling detection, and of
/// readers of frames while there are none.
const READER_COUNT_INTERVAL: u32 = 16;
/// Maximum size of an event, bytes.
const EVENT_BYTES: usize = 1024;
/// Maximum number of attempts to start while a predecessor is being removed.
const ATTEMPTS: usize = 20;

/// Service of commands and answers.
pub(crate) type Control = Factory<Ipc, [u8], (), [u8], ()>;

/// Statistics of a link since its start.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct LinkStatistics {
    /// Present number of readers of frames, fields, events and topology.
    pub readers: [usize; 4],
    /// Present number of processes that may send commands.
    pub clients: usize,
    /// Frames written, with positions only or complete.
    pub frames: u64,
    /// Frames not written for lack of readers.
    pub unread_frames: u64,
    /// Frames and events not written for lack of shared memory.
    pub dropped: u64,
    /// Events written.
    pub events: u64,
    /// Bytes written.
    pub bytes: u64,
    /// Executed commands.
    pub accepted: u64,
    /// Rejected commands.
    pub refused: u64,
}

/// The game's end of a link.
pub struct Link {
    place: LinkPlace,
    epoch: u64,
    plan: FramePlan,
    frames: Stream,
    fields: Stream,
    events: Stream,
    topology: Stream,
    control: Control,
    server: Server<Ipc, [u8], (), [u8], ()>,
    desk: CommandHandler,
    clients: usize,
    frame: u64,
    /// Steps and time of the last frame, and time of its writing, ns.
    steps: Option<(u64, f64)>,
    written_at: u64,
    /// Readers of frames, fields and topology at the last frame.
    readers: [usize; 3],
    /// Version of the present topology, and of the last one sent.
    version: u32,
    sent: u32,
    events_seen: u64,
    /// Whether the link has enabled buckling detection for a reader of events; calls since the last
    /// count of these readers.
    detects_buckling: bool,
    calls_since_count: u32,
    /// Calls since the last count of readers while there are none.
    calls_since_poll: u32,
    /// Unread frames, and accepted and rejected commands.
    counted: LinkStatistics,
    /// Ends the housekeeping when dropped.
    housekeeping: (Option<Sender<()>>, Option<JoinHandle<()>>),
    /// Last field, so that the ports are dropped before it.
    node: Arc<Node<Ipc>>,
}

impl Link {
    /// Serves `world` at `place`. Removes the remains of a terminated predecessor; its readers
    /// continue with this link.
    ///
    /// # Errors
    /// A link of that name served by another process, no shared memory, or a folder of another
    /// user.
    pub fn new(place: &LinkPlace, world: &World) -> Result<Self, LinkError> {
        let node = Arc::new(node_at(place, "sheetwork game")?);
        let mut attempt = 0;
        loop {
            match Self::on(place, world, &node) {
                Err(LinkError::Taken(_) | LinkError::Memory(_)) if attempt < ATTEMPTS => {
                    // A process that died a moment ago may still count as alive.
                    attempt += 1;
                    if place.remove_unfinished() {
                        node.blocking_cleanup_dead_nodes(Duration::from_millis(50));
                    }
                    std::thread::sleep(Duration::from_millis(25));
                }
                result => return result,
            }
        }
    }

    fn on(place: &LinkPlace, world: &World, node: &Arc<Node<Ipc>>) -> Result<Self, LinkError> {
        let plan = FramePlan::new(world);
        let room = |bytes: usize| bytes.max(MINIMUM_SAMPLE_BYTES);
        let frames = Stream::new(node, place, "frames", FRAMES, room(plan.bytes[0]))?;
        let fields = Stream::new(node, place, "fields", FRAMES, room(plan.bytes[1]))?;
        let events = Stream::new(node, place, "events", EVENTS, EVENT_BYTES)?;
        let topology = Stream::new(node, place, "topology", TOPOLOGY, room(topology::sample_capacity(&plan)))?;
        let control = control(node, place, true)?;
        let server = control.server_builder().initial_max_slice_len(ANSWER_BYTES);
        let server = server.allocation_strategy(AllocationStrategy::Static);
        let server = server.backpressure_strategy(BackpressureStrategy::DiscardData).create();
        let server = server.map_err(|_| LinkError::Taken(place.name().into()))?;
        Ok(Self {
            place: place.clone(),
            epoch: epoch(),
            plan,
            frames,
            fields,
            events,
            topology,
            control,
            server,
            desk: CommandHandler::default(),
            clients: 0,
            frame: 0,
            steps: None,
            written_at: 0,
            readers: [0; 3],
            version: 1,
            sent: 0,
            events_seen: world.event_count(),
            detects_buckling: false,
            calls_since_count: READER_COUNT_INTERVAL,
            calls_since_poll: 0,
            counted: LinkStatistics::default(),
            housekeeping: spawn_housekeeping(node, place),
            node: Arc::clone(node),
        })
    }

    /// Answers commands, then publishes the world if it has moved; to be called between two steps.
    /// `step_time` is the duration of the last step or tick, s. Never blocks.
    pub fn exchange(&mut self, host: &mut dyn Host, step_time: f64) {
        self.answer(host);
        self.publish(host.world(), step_time, host.playing());
    }

    /// Enables buckling detection while events have a reader, unless the game enables it.
    fn update_buckling_detection(&mut self, host: &mut dyn Host) {
        self.calls_since_count += 1;
        if self.calls_since_count < READER_COUNT_INTERVAL {
            return;
        }
        self.calls_since_count = 0;
        let heard = self.events.readers() > 0;
        if heard != self.detects_buckling && (self.detects_buckling || !host.world().detects_buckling()) {
            host.world_mut().set_buckling_detection(heard);
            self.detects_buckling = heard;
        }
    }

    /// Answers the commands received since the last call. May be called more often than once a
    /// step, for haptic clients.
    pub fn answer(&mut self, host: &mut dyn Host) {
        self.desk.grabs.expire(host.world_mut());
        self.update_buckling_detection(host);
        let clients = self.control.dynamic_config().number_of_clients();
        if clients == 0 && self.clients == 0 {
            return;
        }
        if clients != self.clients {
            if free_shared_memory() < FREE_MEMORY_MARGIN {
                return;
            }
            self.clients = clients;
        }
        for _ in 0..MAXIMUM_COMMANDS {
            let Ok(Some(request)) = self.server.receive() else { break };
            let result = Command::from_bytes(request.payload())
                .map_err(|problem| sheetwork::InputError::new("", problem))
                .and_then(|command| {
                    let loads = matches!(command, Command::Load { .. });
                    let done = self.desk.execute(host, &command);
                    if loads && done.is_ok() {
                        self.invalidate_plan();
                    }
                    done
                });
            match &result {
                Ok(_) => self.counted.accepted += 1,
                Err(_) => self.counted.refused += 1,
            }
            let bytes = self.reply(host.world(), result);
            if free_shared_memory() < FREE_MEMORY_MARGIN {
                self.counted.refused += 1;
                continue;
            }
            if let Ok(sample) = request.loan_slice_uninit(bytes.len()) {
                // The client may have terminated.
                let _ = sample.write_from_slice(&bytes).send();
            }
        }
    }

    fn reply(&self, world: &World, result: Result<serde_json::Map<String, Value>, sheetwork::InputError>) -> Vec<u8> {
        let mut answer =
            json!({ "ok": result.is_ok(), "epoch": self.epoch, "steps": world.steps(), "time": world.time() });
        let stopped = unstable_sheets(world);
        if !stopped.is_empty() {
            answer["stopped"] = stopped.into();
        }
        match result {
            Ok(body) => body.into_iter().for_each(|(key, value)| answer[key] = value),
            Err(error) => answer["error"] = error.to_string().into(),
        }
        let bytes = serde_json::to_vec(&answer).unwrap_or_default();
        if bytes.len() <= ANSWER_BYTES {
            return bytes;
        }
        // An error or a name of excessive length.
        let text: String = answer["error"].as_str().unwrap_or("the answer is too long").chars().take(2000).collect();
        let short = json!({ "ok": answer["ok"], "epoch": self.epoch, "error": text });
        serde_json::to_vec(&short).unwrap_or_default()
    }

    /// Publishes the world to the readers if it has moved since the last call; a resting world ten
    /// times a second. `step_time` is the duration of the last step or tick, s.
    pub fn publish(&mut self, world: &World, step_time: f64, playing: bool) {
        if world.event_count() != self.events_seen {
            self.publish_events(world);
        }
        let now = (world.steps(), world.time());
        let readers = self.count_readers();
        let before = std::mem::replace(&mut self.readers, readers);
        if readers == [0; 3] {
            self.counted.unread_frames += u64::from(self.steps != Some(now));
            self.steps = Some(now);
            return;
        }
        let newcomer = readers.iter().zip(before).any(|(now, before)| *now > before);
        if self.steps == Some(now) && !newcomer && !self.idle_is_due() {
            return;
        }
        self.steps = Some(now);
        if !self.update_plan(world) {
            return;
        }
        let [frames, fields, topology] = readers;
        if fields > 0 || topology > 0 {
            self.plan.update_topology(world);
        }
        if topology > 0 {
            self.publish_topology(world, topology);
        }
        let written_at = monotonic_ns();
        self.written_at = written_at;
        let (epoch, topology) = (self.epoch, self.version);
        let moment = FrameStamp { epoch, frame: self.frame, topology, step_time, written_at, playing };
        self.frame += 1;
        let plan = &self.plan;
        if frames > 0 {
            self.frames.write(frames, plan.bytes[0], |out| frame(plan, world, &moment, false, out));
        }
        if fields > 0 {
            self.fields.write(fields, plan.bytes[1], |out| frame(plan, world, &moment, true, out));
        }
    }

    /// Readers of frames, fields and topology. Readers attach as commanding clients first. Without
    /// such clients and without readers at the last call, readers are counted at intervals only,
    /// because after a step each count misses the CPU cache.
    fn count_readers(&mut self) -> [usize; 3] {
        self.calls_since_poll = (self.calls_since_poll + 1) % READER_COUNT_INTERVAL;
        if self.readers == [0; 3] && self.calls_since_poll != 0 && !self.is_commanded() {
            return [0; 3];
        }
        [self.frames.readers(), self.fields.readers(), self.topology.readers()]
    }

    /// Sends a changed topology to all readers, and an unchanged one to new readers.
    fn publish_topology(&mut self, world: &World, readers: usize) {
        if self.sent == self.version {
            self.topology.send_history(readers);
            return;
        }
        let (plan, which) = (&self.plan, (self.epoch, self.version));
        let write = |out: &mut [u8]| topology::write(plan, world, which, out);
        if self.topology.write(readers, topology::bytes(plan), write) {
            self.sent = self.version;
        }
    }

    /// Whether a resting world is due for another frame.
    fn idle_is_due(&self) -> bool {
        monotonic_ns().saturating_sub(self.written_at) > IDLE_FRAME_INTERVAL_NS
    }

    /// Invalidates the plan after a replacement of the sheets by similar ones.
    pub fn invalidate_plan(&mut self) {
        self.plan = FramePlan::default();
    }

    /// Updates the plan to the world; false without memory for it.
    fn update_plan(&mut self, world: &World) -> bool {
        if self.plan.fits(world) {
            self.version += u32::from(self.plan.has_changed_cells(world));
            return true;
        }
        let plan = FramePlan::new(world);
        let room = free_shared_memory() >= FREE_MEMORY_MARGIN;
        let place = &self.place;
        let resized = room
            && self.frames.resize(place, plan.bytes[0]).is_ok()
            && self.fields.resize(place, plan.bytes[1]).is_ok()
            && self.topology.resize(place, topology::sample_capacity(&plan)).is_ok();
        if resized {
            self.plan = plan;
            self.version += 1;
        } else {
            self.frames.dropped += 1;
        }
        resized
    }

    /// Sends the events since the last call.
    fn publish_events(&mut self, world: &World) {
        // A reset or a restored snapshot has fewer events.
        let events = world.events_since(self.events_seen);
        self.events_seen = world.event_count();
        let first = self.events_seen as usize - events.len();
        let readers = self.events.readers();
        if readers == 0 {
            return;
        }
        for (index, event) in (first..).zip(events) {
            let bytes = event_bytes(self.epoch, index, event, world);
            self.events.write(readers, bytes.len(), |out| {
                // Spaces fill the last word.
                out.fill(b' ');
                out[..bytes.len()].copy_from_slice(&bytes);
            });
        }
    }

    /// Sleeps for `duration`; false after SIGINT or SIGTERM. After the first call these signals do
    /// not end the process, so that a serving program can clean up.
    pub fn sleep(&self, duration: Duration) -> bool {
        self.node.wait(duration).is_ok()
    }

    /// Whether a client may send commands. Haptic clients need answers more often than once a step.
    pub fn is_commanded(&self) -> bool {
        self.control.dynamic_config().number_of_clients() > 0
    }

    /// Place of the link.
    pub fn place(&self) -> &LinkPlace {
        &self.place
    }

    /// Number of this run, unique among runs.
    pub fn epoch(&self) -> u64 {
        self.epoch
    }

    /// Attached processes. Reads their names from the system; too slow for every step.
    pub fn attached(&self) -> Vec<AttachedProcess> {
        let mut list = Vec::new();
        self.control.dynamic_config().list_clients(|client| {
            if let Ok(process) = client.node_id.pid::<Ipc>() {
                AttachedProcess::count(&mut list, process.value() as u32, true);
            }
            CallbackProgression::Continue
        });
        for stream in [&self.frames, &self.fields, &self.topology, &self.events] {
            stream.list(|process| AttachedProcess::count(&mut list, process, false));
        }
        list
    }

    /// Statistics since the start.
    pub fn statistics(&self) -> LinkStatistics {
        LinkStatistics {
            readers: [self.frames.readers(), self.fields.readers(), self.events.readers(), self.topology.readers()],
            clients: self.control.dynamic_config().number_of_clients(),
            frames: self.frames.written + self.fields.written,
            dropped: self.frames.dropped + self.fields.dropped + self.events.dropped + self.topology.dropped,
            events: self.events.written,
            bytes: self.frames.bytes + self.fields.bytes + self.events.bytes + self.topology.bytes,
            ..self.counted
        }
    }
}

impl Drop for Link {
    fn drop(&mut self) {
        self.housekeeping.0 = None;
        let Some(thread) = self.housekeeping.1.take() else { return };
        // Bounded wait: the thread may be blocked by an object that another process has not
        // finished.
        let start = Instant::now();
        while !thread.is_finished() && start.elapsed() < SHUTDOWN_TIMEOUT {
            std::thread::sleep(Duration::from_millis(1));
        }
        if thread.is_finished() {
            let _ = thread.join();
        }
    }
}

/// Opens or creates the service of commands.
pub(crate) fn control(node: &Node<Ipc>, place: &LinkPlace, create: bool) -> Result<Control, LinkError> {
    use iceoryx2::service::builder::request_response::RequestResponseOpenError as OpenError;
    let name = place.service("control")?;
    let builder = node.service_builder(&name).request_response::<[u8], [u8]>();
    if create {
        let builder = builder
            .max_servers(1)
            .max_clients(MAXIMUM_CLIENTS)
            .max_nodes(2 * MAXIMUM_CLIENTS + 2)
            .max_active_requests_per_client(4)
            .max_response_buffer_size(1)
            .enable_safe_overflow_for_requests(true)
            .enable_safe_overflow_for_responses(true);
        return builder.open_or_create().map_err(|e| LinkError::Memory(format!("{name}: {e:?}")));
    }
    builder.open().map_err(|e| match e {
        OpenError::DoesNotExist => LinkError::NoGame(place.name().into(), String::new()),
        OpenError::ExceedsMaxNumberOfNodes => LinkError::Full("be attached to a game"),
        OpenError::InsufficientPermissions => {
            LinkError::Refused(format!("{}: not allowed; a link is for its own user", place.root().display()))
        }
        e => LinkError::Unlike(format!("{e:?}")),
    })
}

/// A unique number of this run, from start time and process.
fn epoch() -> u64 {
    let now = std::time::SystemTime::now().duration_since(std::time::UNIX_EPOCH).unwrap_or_default();
    // 53 bits, exact in every language: seconds, and a hash of process and nanoseconds.
    let mixed = u64::from(std::process::id()).wrapping_mul(0x9e37_79b9) ^ u64::from(now.subsec_nanos());
    ((now.as_secs() & 0xffff_ffff) << 20) | (mixed & 0xf_ffff)
}

/// Starts a thread that removes the remains of terminated processes, so that no step has to.
fn spawn_housekeeping(node: &Arc<Node<Ipc>>, place: &LinkPlace) -> (Option<Sender<()>>, Option<JoinHandle<()>>) {
    let (end, ended) = channel::<()>();
    let (node, place) = (Arc::clone(node), place.clone());
    let work = move || {
        use std::sync::mpsc::RecvTimeoutError::Timeout;
        while ended.recv_timeout(HOUSEKEEPING) == Err(Timeout) {
            clean_up(&node, &place);
        }
        // Final removal.
        clean_up(&node, &place);
    };
    // Without the thread a terminated reader is counted until the next start.
    let thread = std::thread::Builder::new().name("sheetwork link".into()).spawn(work).ok();
    (Some(end), thread)
}

/// Serialises an event with its number, the sheet's energy (J) and a place (m): of the nodes in
/// contact, of the fastest node, or of the centre of mass.
fn event_bytes(epoch: u64, index: usize, event: &Event, world: &World) -> Vec<u8> {
    let mut object = serde_json::to_value(event).unwrap_or_default();
    object["epoch"] = epoch.into();
    object["number"] = index.into();
    if let Some(sheet) = world.sheet(&event.sheet) {
        let touching: Vec<usize> =
            (0..sheet.node_count()).filter(|i| sheet.touching().get(*i) == Some(&true)).collect();
        let place = match sheet.state.status {
            Status::Unstable { place, .. } => place,
            _ if touching.is_empty() => sheet.centre_of_mass(),
            _ => touching.iter().map(|i| sheet.state.x.get(*i)).sum::<glam::DVec3>() / touching.len() as f64,
        };
        if event.place_m.is_none() {
            object["place_m"] = json!(place.to_array());
        }
        if event.energy_j.is_none() {
            object["energy_j"] = json!(sheet.energy(world.gravity()).total);
        }
    }
    let mut bytes = serde_json::to_vec(&object).unwrap_or_default();
    if bytes.len() > EVENT_BYTES {
        let short = json!({ "epoch": epoch, "number": index, "time_s": event.time_s, "kind": event.kind });
        bytes = serde_json::to_vec(&short).unwrap_or_default();
    }
    bytes
}
