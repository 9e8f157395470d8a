//! `sheetwork haptic`: a force loop of a kilohertz between a device in the hand and a sheet of a
//! running game.
//!
//! Two loops run side by side. The force loop has the rate of the device and never waits for the
//! game: it reads the position p of the hand, computes the force of a spring and damper to the
//! grabbed point (a virtual coupling; Colgate, Stanley, Brown, IROS 1995),
//!
//!   f = k (x - p) - c p',
//!
//! and gives it to the device. The link loop sends p to the game and receives the point's position
//! x and the force in the game, as often as the game answers; between two answers x moves with its
//! last velocity, for at most 20 ms. A device is anything that implements [`Device`].

use std::io::Read;
use std::process::ExitCode;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

use clap::Args;
use glam::DVec3;
use serde_json::{Value, json};
use sheetwork::{InputError, check_range};
use sheetwork_link::{Client, Command, LinkError};

use crate::link::{GameSelection, MaterialPoint};
use sheetwork_rigs::output::OutputFlags;
use sheetwork_rigs::quantities::{length, parse_number, stiffness, time};

/// Longest extrapolation of the grabbed point, s.
const EXTRAPOLATION: f64 = 0.02;

/// Holds a material point of a running game's sheet with a device, in a force loop of 1 kHz.
#[derive(Args)]
#[command(allow_negative_numbers = true)]
pub struct HapticArguments {
    #[command(flatten)]
    target: GameSelection,
    #[command(flatten)]
    point: MaterialPoint,
    /// Device: `circle` moves by itself, once a second; or a file of a joystick (/dev/input/js0) or
    /// of a mouse (/dev/input/mice).
    #[arg(long, default_value = "circle")]
    device: String,
    /// Reach of the hand from the grabbed point, m.
    #[arg(long, default_value = "0.05", value_parser = length)]
    reach: f64,
    /// Duration, s.
    #[arg(long, default_value = "5", value_parser = time)]
    seconds: f64,
    /// Stiffness of the coupling between hand and sheet, N/m.
    #[arg(long, default_value = "100", value_parser = stiffness)]
    stiffness: f64,
    /// Damping of the coupling, N s/m.
    #[arg(long, default_value = "0.5", value_parser = parse_number)]
    damping: f64,
    /// Rate of the force loop, 1/s.
    #[arg(long, default_value = "1000", value_parser = parse_number)]
    rate: f64,
    #[command(flatten)]
    output: OutputFlags,
}

/// A device in the hand.
trait Device: Send {
    /// Position of the hand, each component within ±1 of the reach; `time` in s from the start.
    fn position(&mut self, time: f64) -> DVec3;

    /// Takes the force on the hand, N. Devices without motors ignore it.
    fn force(&mut self, _force: DVec3) {}
}

/// A hand that goes round in a vertical circle once a second.
struct Circle;

impl Device for Circle {
    fn position(&mut self, time: f64) -> DVec3 {
        let (sine, cosine) = (std::f64::consts::TAU * time).sin_cos();
        DVec3::new(0.5 * sine, 0.5 * (1.0 - cosine), 0.0)
    }
}

/// Reports of a device file, read by a thread of its own.
struct DeviceFile {
    position: Arc<Mutex<DVec3>>,
}

impl DeviceFile {
    /// Opens a joystick (reports of 8 bytes: time, value, type, number of the axis) or the mice
    /// (reports of 3 bytes: buttons, x, y).
    fn open(path: &str) -> Result<Self, InputError> {
        let file = std::fs::File::open(path).map_err(|e| InputError::io(std::path::Path::new(path), &e))?;
        let position = Arc::new(Mutex::new(DVec3::ZERO));
        let shared = Arc::clone(&position);
        let is_mouse = path.contains("mice") || path.contains("mouse");
        // The thread ends with the file or with the program.
        std::thread::spawn(move || if is_mouse { read_mouse(file, &shared) } else { read_joystick(file, &shared) });
        Ok(Self { position })
    }
}

impl Device for DeviceFile {
    fn position(&mut self, _time: f64) -> DVec3 {
        *self.position.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

fn read_joystick(mut file: impl Read, position: &Mutex<DVec3>) {
    let mut report = [0_u8; 8];
    while file.read_exact(&mut report).is_ok() {
        let [_, _, _, _, low, high, kind, axis] = report;
        // Type 2 is an axis; 0x80 marks the state at the start. Axes: x to the right, y towards the
        // user, and the throttle or second stick.
        if kind & 0x7f == 2 && axis < 3 {
            let value = f64::from(i16::from_le_bytes([low, high])) / 32767.0;
            let mut place = position.lock().unwrap_or_else(PoisonError::into_inner);
            place[[0, 2, 1][axis as usize]] = if axis == 2 { -value } else { value };
        }
    }
}

fn read_mouse(mut file: impl Read, position: &Mutex<DVec3>) {
    let mut report = [0_u8; 3];
    while file.read_exact(&mut report).is_ok() {
        let [buttons, x, y] = report;
        // Five hundred counts are the reach. With the right button the hand moves in depth.
        let moved = DVec3::new(f64::from(x as i8), f64::from(y as i8), 0.0) / 500.0;
        let moved = if buttons & 2 == 0 { moved } else { DVec3::new(moved.x, 0.0, -moved.y) };
        let mut place = position.lock().unwrap_or_else(PoisonError::into_inner);
        *place = (*place + moved).clamp(DVec3::NEG_ONE, DVec3::ONE);
    }
}

/// State that both loops read and write.
#[derive(Clone, Copy, Default)]
struct Shared {
    /// Position of the hand, m.
    hand: DVec3,
    /// Position of the grabbed point (m), its velocity (m/s), and the time of the answer (s).
    point: DVec3,
    velocity: DVec3,
    answered: f64,
    /// Force of the game on the hand, N.
    force: DVec3,
    done: bool,
}

/// Times and forces of a run.
#[derive(Default)]
struct Measured {
    /// Periods of the force loop, s.
    periods: Vec<f64>,
    /// Round trips of the link loop, s.
    trips: Vec<f64>,
    /// Largest force on the hand, N.
    largest: f64,
    /// Largest difference of the force on the hand from that of the last answer, N.
    difference: f64,
}

impl HapticArguments {
    pub fn execute(self) -> Result<ExitCode, InputError> {
        check_range("--rate", self.rate, 1.0, 1e4, "1/s")?;
        check_range("--seconds", self.seconds, 0.1, 1e5, "s")?;
        check_range("--reach", self.reach, 1e-6, 100.0, "m")?;
        check_range("--damping", self.damping, 0.0, 1e6, "N s/m")?;
        let mut device: Box<dyn Device> = match self.device.as_str() {
            "circle" => Box::new(Circle),
            path => Box::new(DeviceFile::open(path)?),
        };
        let client = self.target.attach()?;
        let (grab, begin) = self.point.grab(&client, self.stiffness)?;
        let begin = DVec3::from(begin);
        let shared = Mutex::new(Shared { hand: begin, point: begin, ..Shared::default() });
        let start = Instant::now();
        let mut measured = Measured::default();
        std::thread::scope(|scope| {
            let forces = scope.spawn(|| self.force_loop(&mut *device, begin, start, &shared));
            measured.trips = link_loop(&client, grab, start, &shared)?;
            let felt = forces.join().map_err(|_| LinkError::Unlike("the force loop ended".into()))?;
            measured = Measured { trips: std::mem::take(&mut measured.trips), ..felt };
            Ok::<(), LinkError>(())
        })?;
        client.send(&Command::Release { grab })?;
        let result = measured.summary(start.elapsed().as_secs_f64());
        self.output.print(|| &result, || text(&result))?;
        Ok(ExitCode::SUCCESS)
    }

    /// Reads the device and gives it the force, at the rate of the device.
    fn force_loop(&self, device: &mut dyn Device, begin: DVec3, start: Instant, shared: &Mutex<Shared>) -> Measured {
        let mut measured = Measured::default();
        let (mut last, mut before) = (0.0, begin);
        for tick in 1_u64.. {
            let due = Duration::from_secs_f64(tick as f64 / self.rate);
            std::thread::sleep(due.saturating_sub(start.elapsed()));
            let now = start.elapsed().as_secs_f64();
            let hand = begin + self.reach * device.position(now).clamp(DVec3::NEG_ONE, DVec3::ONE);
            let state = {
                let mut shared = lock(shared);
                shared.hand = hand;
                shared.done |= now >= self.seconds;
                *shared
            };
            let ahead = (now - state.answered).clamp(0.0, EXTRAPOLATION);
            let point = state.point + state.velocity * ahead;
            let force = self.stiffness * (point - hand) - self.damping * (hand - before) / (now - last).max(1e-6);
            device.force(force);
            measured.largest = measured.largest.max(force.length());
            if state.answered > 0.0 {
                measured.difference = measured.difference.max((force - state.force).length());
            }
            measured.periods.push(now - last);
            (last, before) = (now, hand);
            if state.done {
                break;
            }
        }
        measured
    }
}

fn lock(shared: &Mutex<Shared>) -> std::sync::MutexGuard<'_, Shared> {
    shared.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Sends the hand to the game and receives the point, as often as the game answers. Returns the
/// times of the round trips, s.
fn link_loop(client: &Client, grab: u64, start: Instant, shared: &Mutex<Shared>) -> Result<Vec<f64>, LinkError> {
    let mut trips = Vec::new();
    let mut last: Option<(f64, DVec3)> = None;
    loop {
        let Shared { hand, done, .. } = *lock(shared);
        if done {
            return Ok(trips);
        }
        let sent = start.elapsed().as_secs_f64();
        let answer = client.pull(grab, hand.to_array());
        let felt = match answer {
            Ok(felt) => felt,
            Err(error) => {
                lock(shared).done = true;
                return Err(error);
            }
        };
        let now = start.elapsed().as_secs_f64();
        trips.push(now - sent);
        let point = DVec3::from(felt.position);
        let mut state = lock(shared);
        // The velocity is that over simulated time, which stands while the game is paused.
        if let Some((time, before)) = last.filter(|(time, _)| felt.time > *time) {
            state.velocity = (point - before) / (felt.time - time);
        }
        (state.point, state.force, state.answered) = (point, DVec3::from(felt.force), now);
        drop(state);
        if last.is_none_or(|(time, _)| felt.time > time) {
            last = Some((felt.time, point));
        }
    }
}

impl Measured {
    fn summary(mut self, elapsed: f64) -> Value {
        let count = self.periods.len();
        for list in [&mut self.periods, &mut self.trips] {
            list.sort_by(f64::total_cmp);
        }
        let at = |list: &[f64], part: f64| {
            let index = ((list.len() as f64 * part) as usize).min(list.len().saturating_sub(1));
            list.get(index).map(|t| 1e3 * t)
        };
        json!({
            "force_loop_hz": count as f64 / elapsed,
            "period_median_ms": at(&self.periods, 0.5),
            "period_p99_ms": at(&self.periods, 0.99),
            "link_loop_hz": self.trips.len() as f64 / elapsed,
            "round_trip_median_ms": at(&self.trips, 0.5),
            "round_trip_p99_ms": at(&self.trips, 0.99),
            "largest_force_n": self.largest,
            "largest_difference_n": self.difference,
        })
    }
}

fn text(result: &Value) -> String {
    let part = |key: &str| result[key].as_f64().unwrap_or(f64::NAN);
    format!(
        "force loop {:.0} times a second, a period {:.2} ms in the median and within {:.2} ms in 99 of 100\n\
         link loop {:.0} times a second, a round trip {:.2} ms in the median and within {:.2} ms in 99 of 100\n\
         at most {:.3} N on the hand, and {:.3} N from the force in the game",
        part("force_loop_hz"),
        part("period_median_ms"),
        part("period_p99_ms"),
        part("link_loop_hz"),
        part("round_trip_median_ms"),
        part("round_trip_p99_ms"),
        part("largest_force_n"),
        part("largest_difference_n")
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn reports_of_a_joystick_and_of_a_mouse_move_the_hand() {
        let position = Mutex::new(DVec3::ZERO);
        // Axis 0 to the right by half, a button, axis 1 towards the user, axis 2 up.
        let reports = [
            [0, 0, 0, 0, 0xff, 0x3f, 2, 0],
            [0, 0, 0, 0, 1, 0, 1, 0],
            [0, 0, 0, 0, 0xff, 0x7f, 0x82, 1],
            [0, 0, 0, 0, 0x01, 0x80, 2, 2],
        ];
        read_joystick(&reports.concat()[..], &position);
        let place = *lock_position(&position);
        assert!((place - DVec3::new(0.5, 1.0, 1.0)).abs().max_element() < 1e-3, "{place}");
        let mouse = Mutex::new(DVec3::ZERO);
        read_mouse(&[8, 50, 0xce, 10, 0, 25][..], &mouse);
        let place = *lock_position(&mouse);
        assert!((place - DVec3::new(0.1, -0.1, -0.05)).abs().max_element() < 1e-12, "{place}");
    }

    fn lock_position(position: &Mutex<DVec3>) -> std::sync::MutexGuard<'_, DVec3> {
        position.lock().unwrap_or_else(PoisonError::into_inner)
    }
}
