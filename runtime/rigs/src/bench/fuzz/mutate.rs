//! Mutations of an input: of its bytes, its numbers and its fragments.

use crate::bench::fuzz::readers::FuzzedReader;
use crate::measure::random_sequence::SplitMix64;

/// Numbers at limits of formats and types.
const NUMBERS: &[&str] = &[
    "0",
    "-0",
    "1",
    "-1",
    "2",
    "1e-300",
    "1e300",
    "1e309",
    "-1e400",
    "NaN",
    "inf",
    "-inf",
    "0.5",
    "4294967295",
    "4294967296",
    "99999999999999999999",
    "2147483648",
    "1e-7",
    "65536",
    "255",
];
/// Integers at limits of types.
const WHOLE: &[u64] =
    &[0, 1, 2, 0x7f, 0x80, 0xff, 0xffff, 0x7fff_ffff, 0xffff_ffff, 0x7ff0_0000_0000_0000, u64::MAX, 1 << 40];
/// Maximum length of an input, bytes.
const MAXIMUM_INPUT_LENGTH: usize = 200_000;

/// A mutation of one of `seeds`.
pub fn mutate(seeds: &[Vec<u8>], reader: &FuzzedReader, dice: &mut SplitMix64) -> Vec<u8> {
    let mut bytes = seeds.get(dice.below(seeds.len())).cloned().unwrap_or_default();
    // Mostly a single change, because several can mask one another.
    for _ in 0..=[0, 0, 1, 3, 8][dice.below(5)] {
        if !reader.pieces.is_empty() {
            change_text(&mut bytes, seeds, reader.pieces, dice);
        } else {
            change_bytes(&mut bytes, seeds, dice);
        }
    }
    bytes.truncate(MAXIMUM_INPUT_LENGTH);
    if let Some(repair) = reader.repair.filter(|_| dice.below(4) != 0) {
        repair(&mut bytes);
    }
    bytes
}

fn change_text(bytes: &mut Vec<u8>, seeds: &[Vec<u8>], pieces: &[&str], dice: &mut SplitMix64) {
    let at = dice.below(bytes.len() + 1);
    match dice.below(8) {
        0 | 1 => replace_number(bytes, dice),
        2 => drop(bytes.splice(at..at, pieces.get(dice.below(pieces.len())).unwrap_or(&"").bytes())),
        3 => drop(bytes.drain(at..(at + dice.below(40)).min(bytes.len()))),
        4 => repeat(bytes, at, dice),
        5 => swap_line(bytes, seeds, dice),
        _ => change_bytes(bytes, seeds, dice),
    }
}

fn change_bytes(bytes: &mut Vec<u8>, seeds: &[Vec<u8>], dice: &mut SplitMix64) {
    let at = dice.below(bytes.len());
    match dice.below(9) {
        0 | 1 if !bytes.is_empty() => bytes[at] ^= 1 << dice.below(8),
        2 if !bytes.is_empty() => bytes[at] = dice.bits() as u8,
        3 => overwrite(bytes, at, &WHOLE[dice.below(WHOLE.len())].to_le_bytes()[..[1, 2, 4, 8][dice.below(4)]]),
        4 => bytes.truncate(at),
        5 => drop(bytes.drain(at..(at + dice.below(64)).min(bytes.len()))),
        6 => repeat(bytes, at, dice),
        7 => {
            // The head of one input and the tail of another.
            let other = seeds.get(dice.below(seeds.len())).map_or(&[][..], Vec::as_slice);
            bytes.truncate(at);
            bytes.extend_from_slice(&other[at.min(other.len())..]);
        }
        _ => overwrite(bytes, at, &f64::from_bits(dice.bits()).to_le_bytes()),
    }
}

fn overwrite(bytes: &mut [u8], at: usize, by: &[u8]) {
    bytes.iter_mut().skip(at).zip(by).for_each(|(to, from)| *to = *from);
}

fn repeat(bytes: &mut Vec<u8>, at: usize, dice: &mut SplitMix64) {
    let piece: Vec<u8> = bytes.iter().skip(at).take(1 + dice.below(60)).copied().collect();
    for _ in 0..=dice.below(3) {
        bytes.splice(at.min(bytes.len())..at.min(bytes.len()), piece.iter().copied());
    }
}

/// Replaces a number.
fn replace_number(bytes: &mut Vec<u8>, dice: &mut SplitMix64) {
    let digits: Vec<usize> = (0..bytes.len()).filter(|i| bytes[*i].is_ascii_digit()).collect();
    let Some(at) = digits.get(dice.below(digits.len())).copied() else { return };
    let part = |b: &u8| b.is_ascii_digit() || b".eE+-".contains(b);
    let start = bytes[..at].iter().rposition(|b| !part(b)).map_or(0, |i| i + 1);
    let end = bytes[at..].iter().position(|b| !part(b)).map_or(bytes.len(), |i| at + i);
    let small = dice.below(12).to_string();
    let number = if dice.below(3) == 0 { small.as_str() } else { NUMBERS[dice.below(NUMBERS.len())] };
    bytes.splice(start..end, number.bytes());
}

/// Replaces a line with one of another input.
fn swap_line(bytes: &mut Vec<u8>, seeds: &[Vec<u8>], dice: &mut SplitMix64) {
    let other = seeds.get(dice.below(seeds.len())).map_or(&[][..], Vec::as_slice);
    let lines: Vec<&[u8]> = other.split(|b| *b == b'\n').collect();
    let line = lines.get(dice.below(lines.len())).copied().unwrap_or_default();
    let at = dice.below(bytes.len());
    let start = bytes[..at].iter().rposition(|b| *b == b'\n').map_or(0, |i| i + 1);
    let end = bytes[at..].iter().position(|b| *b == b'\n').map_or(bytes.len(), |i| at + i);
    bytes.splice(start..end, line.iter().copied());
}
