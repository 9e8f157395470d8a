//! Encoding of frames, in both versions of the file.
//!
//! Frame of version 2: the time (f64). Per sheet: a byte with the kinds of data, the positions of
//! the nodes (3 f32 each), the temperatures (u16 each: tenths of a kelvin, or 65535ths of the
//! remaining stiffness) and, where the open cells differ from those of the frame before, their
//! number (u32) and a bit for each. Then 7 f32 per body.

use std::sync::Arc;

use glam::{Quat, Vec3};

use crate::sheet::temperature::RecordedTemperature;
use crate::units::temperature::ZERO_CELSIUS;
use crate::world::recording::frame::{RecordedFrame, RecordingHeader};

/// Bits of a sheet's first byte: the kind of temperatures, and whether cells follow.
const WARMTH: u8 = 3;
const CELLS: u8 = 4;
/// Steps per kelvin.
const STEPS: f64 = 10.0;
/// Steps of the remaining stiffness.
const LEFT: f64 = 65535.0;

/// Checksum of 32 bits: FNV-1a over words of eight bytes.
pub fn checksum(bytes: &[u8]) -> u32 {
    let mix = |sum: u64, word: u64| (sum ^ word).wrapping_mul(0x0100_0000_01b3);
    let words = bytes.chunks(8).map(|chunk| {
        let mut word = [0; 8];
        word[..chunk.len()].copy_from_slice(chunk);
        u64::from_le_bytes(word)
    });
    // The upper bits are folded in, since the last words affect only these.
    let sum = words.fold(0xcbf2_9ce4_8422_2325, |sum, word| mix(mix(sum, word & 0xffff_ffff), word >> 32));
    (sum ^ (sum >> 32)) as u32
}

/// Append `frame` to `out`. `open` holds the open cells of the frame before and is updated.
pub fn encode(frame: &RecordedFrame, open: &mut Vec<Arc<[bool]>>, out: &mut Vec<u8>) {
    out.extend(frame.time.to_le_bytes());
    open.resize_with(frame.sheets.len(), || [].into());
    for (index, (places, open)) in frame.sheets.iter().zip(open).enumerate() {
        let (warmth, cells) = (frame.temperatures_of(index), frame.open_of(index));
        let changed = **open != *cells;
        let kind = match warmth {
            RecordedTemperature::Unknown => 0,
            RecordedTemperature::Mean(_) => 1,
            RecordedTemperature::Sides(_) => 2,
            RecordedTemperature::Stiffness(_) => 3,
        };
        out.push(kind | if changed { CELLS } else { 0 });
        places.iter().for_each(|p| p.to_array().iter().for_each(|c| out.extend(c.to_le_bytes())));
        let step = |value: &f32| match warmth {
            RecordedTemperature::Stiffness(_) => LEFT * f64::from(*value),
            _ => STEPS * (f64::from(*value) + ZERO_CELSIUS),
        };
        // The conversion saturates values out of range.
        warmth.values().iter().for_each(|v| out.extend((step(v).round() as u16).to_le_bytes()));
        if changed {
            *open = cells.into();
            out.extend((cells.len() as u32).to_le_bytes());
            let byte =
                |eight: &[bool]| eight.iter().enumerate().fold(0_u8, |byte, (bit, o)| byte | u8::from(*o) << bit);
            out.extend(cells.chunks(8).map(byte));
        }
    }
    for (position, rotation) in &frame.bodies {
        let floats = position.to_array().into_iter().chain(rotation.to_array());
        floats.for_each(|c| out.extend(c.to_le_bytes()));
    }
}

/// Reader of bytes from the front.
struct ByteReader<'a>(&'a [u8]);

impl<'a> ByteReader<'a> {
    fn take(&mut self, n: usize) -> Option<&'a [u8]> {
        let (first, rest) = self.0.split_at_checked(n)?;
        self.0 = rest;
        Some(first)
    }

    fn array<const N: usize>(&mut self) -> Option<[u8; N]> {
        self.take(N)?.try_into().ok()
    }

    fn floats<const N: usize>(&mut self, n: usize) -> Option<impl Iterator<Item = [f32; N]>> {
        let all = self.take(n.checked_mul(4 * N)?)?;
        let float = |b: &[u8], k: usize| f32::from_le_bytes([b[4 * k], b[4 * k + 1], b[4 * k + 2], b[4 * k + 3]]);
        Some(all.chunks_exact(4 * N).map(move |row| std::array::from_fn(|k| float(row, k))))
    }

    fn places(&mut self, n: usize) -> Option<Vec<Vec3>> {
        Some(self.floats::<3>(n)?.map(Vec3::from_array).collect())
    }

    fn bodies(&mut self, n: usize) -> Option<Vec<(Vec3, Quat)>> {
        let body = |[x, y, z, a, b, c, d]: [f32; 7]| (Vec3::new(x, y, z), Quat::from_xyzw(a, b, c, d));
        Some(self.floats::<7>(n)?.map(body).collect())
    }

    fn warmth(&mut self, kind: u8, masses: usize) -> Option<RecordedTemperature> {
        let of: fn(Vec<f32>) -> RecordedTemperature = match kind {
            0 => return Some(RecordedTemperature::Unknown),
            1 => RecordedTemperature::Mean,
            2 => RecordedTemperature::Sides,
            _ => RecordedTemperature::Stiffness,
        };
        let all = self.take(of(Vec::new()).count(masses).checked_mul(2)?)?;
        let value = |step: f64| if kind == 3 { step / LEFT } else { step / STEPS - ZERO_CELSIUS };
        Some(of(all.chunks_exact(2).map(|b| value(f64::from(u16::from_le_bytes([b[0], b[1]]))) as f32).collect()))
    }

    fn cells(&mut self) -> Option<Arc<[bool]>> {
        let n = u32::from_le_bytes(self.array()?) as usize;
        let bits = self.take(n.div_ceil(8))?;
        Some((0..n).map(|i| bits[i / 8] >> (i % 8) & 1 == 1).collect())
    }
}

/// Decode the frame in `bytes`, of version 2. `open` holds the open cells of the frame before and
/// is updated. `None` when the bytes are no such frame.
pub fn decode(header: &RecordingHeader, bytes: &[u8], open: &mut Vec<Arc<[bool]>>) -> Option<RecordedFrame> {
    let mut bytes = ByteReader(bytes);
    let mut frame = RecordedFrame { time: f64::from_le_bytes(bytes.array()?), ..RecordedFrame::default() };
    open.resize_with(header.masses.len(), || [].into());
    for (masses, open) in header.masses.iter().zip(open.iter_mut()) {
        let [what] = bytes.array()?;
        frame.sheets.push(bytes.places(*masses)?);
        frame.temperatures.push(bytes.warmth(what & WARMTH, *masses)?);
        if what & CELLS != 0 {
            *open = bytes.cells()?;
        }
        frame.open.push(Arc::clone(open));
    }
    frame.bodies = bytes.bodies(header.bodies)?;
    bytes.0.is_empty().then_some(frame)
}

/// Length of a frame of version 1, bytes; saturates for a damaged header.
pub fn first_version_bytes(header: &RecordingHeader) -> usize {
    let masses = header.masses.iter().fold(0_usize, |sum, n| sum.saturating_add(*n));
    masses.saturating_mul(12).saturating_add(header.bodies.saturating_mul(28)).saturating_add(8)
}

/// Decode the frame in `bytes`, of version 1: time, positions, bodies.
pub fn decode_first_version(header: &RecordingHeader, bytes: &[u8]) -> Option<RecordedFrame> {
    let mut bytes = ByteReader(bytes);
    let time = f64::from_le_bytes(bytes.array()?);
    let sheets = header.masses.iter().map(|masses| bytes.places(*masses)).collect::<Option<_>>()?;
    Some(RecordedFrame { time, sheets, bodies: bytes.bodies(header.bodies)?, ..RecordedFrame::default() })
}
