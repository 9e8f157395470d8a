//! Serialisation of state to bytes ([`StateWriter`]) and from bytes ([`StateReader`]), for
//! snapshots.
//!
//! Little endian; numbers keep all bits. Each type whose state carries over between steps has a
//! function that writes it and one that reads it in the same order. The bytes come from a file with
//! a valid checksum and from a world of the same structure; counts and indices are checked
//! nevertheless, and invalid ones are a [`CorruptState`].

use glam::{DQuat, DVec3};

use crate::math::Vectors;

/// Error of deserialisation: the bytes end early or contain an invalid value.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct CorruptState;

/// Result of deserialisation.
pub type ReadResult<T = ()> = Result<T, CorruptState>;

/// State of known size, written and read in one order. A list has no count: its reader knows it.
pub(crate) trait State: Sized {
    /// Write the state.
    fn serialise(&self, to: &mut StateWriter);

    /// Read the state in place.
    fn deserialise(&mut self, from: &mut StateReader) -> ReadResult;

    /// Write several states.
    fn serialise_all(values: &[Self], to: &mut StateWriter) {
        values.iter().for_each(|value| value.serialise(to));
    }

    /// Read several states in place.
    fn deserialise_all(values: &mut [Self], from: &mut StateReader) -> ReadResult {
        values.iter_mut().try_for_each(|value| value.deserialise(from))
    }
}

/// Implement [`State`] by the functions of [`StateWriter`] and [`StateReader`] of one name, and
/// those for several states where there are any.
macro_rules! state_of_values {
    ($($type:ty: $write:ident, $read:ident $(, $all:ident)?;)+) => {$(
        impl State for $type {
            fn serialise(&self, to: &mut StateWriter) {
                to.$write((*self).into());
            }

            fn deserialise(&mut self, from: &mut StateReader) -> ReadResult {
                *self = from.$read()?;
                Ok(())
            }
            $(
                fn serialise_all(values: &[Self], to: &mut StateWriter) {
                    to.$all(values);
                }

                fn deserialise_all(values: &mut [Self], from: &mut StateReader) -> ReadResult {
                    from.$all(values)
                }
            )?
        }
    )+};
}

state_of_values! {
    bool: flag, flag;
    u32: count, count_u32;
    u64: count, count;
    f32: single, single, singles;
    f64: number, number, numbers;
    DVec3: vector, vector;
    DQuat: rotation, rotation;
}

/// Implement [`State`] for a type by its fields, in the order of the bytes: all fields of a struct,
/// or the paths of some of them. `then` names a method that updates derived data after reading.
macro_rules! state {
    ($name:ident { $($field:ident),+ $(; without $($skipped:ident),+)? }) => {
        impl crate::serialize::State for $name {
            fn serialise(&self, to: &mut crate::serialize::StateWriter) {
                // Every field is named: a new one that is not serialised does not compile.
                let Self { $($field,)+ $($($skipped: _,)+)? } = self;
                $(crate::serialize::State::serialise($field, to);)+
            }

            fn deserialise(&mut self, from: &mut crate::serialize::StateReader) -> crate::serialize::ReadResult {
                $(crate::serialize::State::deserialise(&mut self.$field, from)?;)+
                Ok(())
            }
        }
    };
    ($name:ident: $($field:ident$(.$part:tt)*),+ $(; then $update:ident)?) => {
        impl crate::serialize::State for $name {
            fn serialise(&self, to: &mut crate::serialize::StateWriter) {
                $(crate::serialize::State::serialise(&self.$field$(.$part)*, to);)+
            }

            fn deserialise(&mut self, from: &mut crate::serialize::StateReader) -> crate::serialize::ReadResult {
                $(crate::serialize::State::deserialise(&mut self.$field$(.$part)*, from)?;)+
                $(self.$update();)?
                Ok(())
            }
        }
    };
}

pub(crate) use state;

impl<T: State, const N: usize> State for [T; N] {
    fn serialise(&self, to: &mut StateWriter) {
        T::serialise_all(self, to);
    }

    fn deserialise(&mut self, from: &mut StateReader) -> ReadResult {
        T::deserialise_all(self, from)
    }
}

impl<T: State> State for Vec<T> {
    fn serialise(&self, to: &mut StateWriter) {
        T::serialise_all(self, to);
    }

    fn deserialise(&mut self, from: &mut StateReader) -> ReadResult {
        T::deserialise_all(self, from)
    }
}

impl State for Vectors {
    fn serialise(&self, to: &mut StateWriter) {
        self.axes().into_iter().for_each(|axis| to.numbers(axis));
    }

    fn deserialise(&mut self, from: &mut StateReader) -> ReadResult {
        self.axes_mut().into_iter().try_for_each(|axis| from.numbers(axis))
    }
}

/// Implement [`State`] for tuples.
macro_rules! state_of_tuple {
    ($($part:ident $index:tt),+) => {
        impl<$($part: State),+> State for ($($part,)+) {
            fn serialise(&self, to: &mut StateWriter) {
                $(self.$index.serialise(to);)+
            }

            fn deserialise(&mut self, from: &mut StateReader) -> ReadResult {
                $(self.$index.deserialise(from)?;)+
                Ok(())
            }
        }
    };
}

state_of_tuple!(A 0, B 1);
state_of_tuple!(A 0, B 1, C 2);

impl<T: State + Default> State for Option<T> {
    fn serialise(&self, to: &mut StateWriter) {
        to.option(self.as_ref(), T::serialise);
    }

    fn deserialise(&mut self, from: &mut StateReader) -> ReadResult {
        *self = if from.flag()? { Some(from.read()?) } else { None };
        Ok(())
    }
}

/// Writer of state.
#[derive(Default)]
pub struct StateWriter {
    pub bytes: Vec<u8>,
}

impl StateWriter {
    pub fn byte(&mut self, value: u8) {
        self.bytes.push(value);
    }

    pub fn flag(&mut self, value: bool) {
        self.bytes.push(u8::from(value));
    }

    /// Write an unsigned integer in LEB128, with fewer bytes for smaller values.
    pub fn count(&mut self, value: u64) {
        let mut rest = value;
        while rest >= 0x80 {
            self.bytes.push(rest as u8 | 0x80);
            rest >>= 7;
        }
        self.bytes.push(rest as u8);
    }

    pub fn number(&mut self, value: f64) {
        self.bytes.extend_from_slice(&value.to_le_bytes());
    }

    pub fn single(&mut self, value: f32) {
        self.bytes.extend_from_slice(&value.to_le_bytes());
    }

    pub fn vector(&mut self, value: DVec3) {
        value.to_array().serialise(self);
    }

    pub fn rotation(&mut self, value: DQuat) {
        value.to_array().serialise(self);
    }

    /// Write whether there is a value, then the value by `write`.
    pub fn option<T>(&mut self, value: Option<T>, write: impl FnOnce(T, &mut Self)) {
        self.flag(value.is_some());
        if let Some(value) = value {
            write(value, self);
        }
    }

    pub fn text(&mut self, value: &str) {
        self.blob(value.as_bytes());
    }

    /// Write the number of bytes, then the bytes.
    pub fn blob(&mut self, bytes: &[u8]) {
        self.count(bytes.len() as u64);
        self.bytes.extend_from_slice(bytes);
    }

    /// Write numbers without their count, which the reader knows.
    pub fn numbers(&mut self, values: &[f64]) {
        let from = self.bytes.len();
        self.bytes.resize(from + 8 * values.len(), 0);
        for (to, value) in self.bytes[from..].chunks_exact_mut(8).zip(values) {
            to.copy_from_slice(&value.to_le_bytes());
        }
    }

    /// Write single-precision numbers without their count.
    pub fn singles(&mut self, values: &[f32]) {
        let from = self.bytes.len();
        self.bytes.resize(from + 4 * values.len(), 0);
        for (to, value) in self.bytes[from..].chunks_exact_mut(4).zip(values) {
            to.copy_from_slice(&value.to_le_bytes());
        }
    }

    /// Write numbers of which many may be zero: one bit for each number states whether it follows.
    pub fn sparse(&mut self, values: &[f64]) {
        for eight in values.chunks(8) {
            let at = self.bytes.len();
            self.bytes.push(0);
            let mut there = 0;
            for (bit, value) in eight.iter().enumerate().filter(|(_, v)| v.to_bits() != 0) {
                there |= 1 << bit;
                self.bytes.extend_from_slice(&value.to_le_bytes());
            }
            self.bytes[at] = there;
        }
    }

    /// Write the count of states, then the states.
    pub(crate) fn states<T: State>(&mut self, values: &[T]) {
        self.count(values.len() as u64);
        T::serialise_all(values, self);
    }

    /// Write the count of vectors, then the vectors.
    pub fn vector_list(&mut self, values: &Vectors) {
        self.count(values.len() as u64);
        values.serialise(self);
    }

    /// Write the count of flags, then the flags, eight per byte.
    pub fn flags(&mut self, values: &[bool]) {
        self.count(values.len() as u64);
        for eight in values.chunks(8) {
            self.bytes.push(eight.iter().enumerate().fold(0, |sum, (bit, value)| sum | u8::from(*value) << bit));
        }
    }
}

/// Reader of state.
pub struct StateReader<'a> {
    rest: &'a [u8],
}

impl<'a> StateReader<'a> {
    pub fn new(bytes: &'a [u8]) -> Self {
        Self { rest: bytes }
    }

    /// Whether all bytes have been read.
    pub fn is_empty(&self) -> bool {
        self.rest.is_empty()
    }

    fn take_bytes(&mut self, count: usize) -> ReadResult<&'a [u8]> {
        let (some, rest) = self.rest.split_at_checked(count).ok_or(CorruptState)?;
        self.rest = rest;
        Ok(some)
    }

    pub fn byte(&mut self) -> ReadResult<u8> {
        Ok(self.take_bytes(1)?[0])
    }

    pub fn flag(&mut self) -> ReadResult<bool> {
        match self.byte()? {
            0 => Ok(false),
            1 => Ok(true),
            _ => Err(CorruptState),
        }
    }

    pub fn count(&mut self) -> ReadResult<u64> {
        let (mut value, mut shift) = (0, 0);
        loop {
            let byte = self.byte()?;
            if shift > 63 || (shift == 63 && byte > 1) {
                return Err(CorruptState);
            }
            value |= u64::from(byte & 0x7f) << shift;
            if byte & 0x80 == 0 {
                return Ok(value);
            }
            shift += 7;
        }
    }

    /// Read a count of elements that take at least `least` bytes each; an error if the remaining
    /// bytes do not suffice.
    pub fn length(&mut self, least: usize) -> ReadResult<usize> {
        let count = usize::try_from(self.count()?).map_err(|_| CorruptState)?;
        if count.checked_mul(least).is_some_and(|bytes| bytes <= self.rest.len()) {
            Ok(count)
        } else {
            Err(CorruptState)
        }
    }

    /// Read an index below `end`.
    pub fn index(&mut self, end: usize) -> ReadResult<u32> {
        let index = self.count()?;
        if index < end as u64 { u32::try_from(index).map_err(|_| CorruptState) } else { Err(CorruptState) }
    }

    /// Read four bytes, little endian.
    pub fn checksum(&mut self) -> ReadResult<u32> {
        let bytes = self.take_bytes(4)?.first_chunk().ok_or(CorruptState)?;
        Ok(u32::from_le_bytes(*bytes))
    }

    /// Read an unsigned integer below 2³².
    pub fn count_u32(&mut self) -> ReadResult<u32> {
        u32::try_from(self.count()?).map_err(|_| CorruptState)
    }

    pub fn number(&mut self) -> ReadResult<f64> {
        let bytes = self.take_bytes(8)?.first_chunk().ok_or(CorruptState)?;
        Ok(f64::from_le_bytes(*bytes))
    }

    pub fn single(&mut self) -> ReadResult<f32> {
        let bytes = self.take_bytes(4)?.first_chunk().ok_or(CorruptState)?;
        Ok(f32::from_le_bytes(*bytes))
    }

    pub fn vector(&mut self) -> ReadResult<DVec3> {
        self.read().map(DVec3::from_array)
    }

    pub fn rotation(&mut self) -> ReadResult<DQuat> {
        self.read().map(DQuat::from_array)
    }

    /// Read a state.
    pub(crate) fn read<T: State + Default>(&mut self) -> ReadResult<T> {
        let mut value = T::default();
        value.deserialise(self)?;
        Ok(value)
    }

    /// Read a count of states that take at least `least` bytes each, then the states.
    pub(crate) fn states<T: State + Default>(&mut self, least: usize) -> ReadResult<Vec<T>> {
        (0..self.length(least)?).map(|_| self.read()).collect()
    }

    pub fn text(&mut self) -> ReadResult<&'a str> {
        std::str::from_utf8(self.blob()?).map_err(|_| CorruptState)
    }

    pub fn blob(&mut self) -> ReadResult<&'a [u8]> {
        let count = self.length(1)?;
        self.take_bytes(count)
    }

    pub fn numbers(&mut self, to: &mut [f64]) -> ReadResult {
        let bytes = self.take_bytes(8 * to.len())?;
        for (to, from) in to.iter_mut().zip(bytes.chunks_exact(8)) {
            *to = f64::from_le_bytes(*from.first_chunk().ok_or(CorruptState)?);
        }
        Ok(())
    }

    pub fn singles(&mut self, to: &mut [f32]) -> ReadResult {
        let bytes = self.take_bytes(4 * to.len())?;
        for (to, from) in to.iter_mut().zip(bytes.chunks_exact(4)) {
            *to = f32::from_le_bytes(*from.first_chunk().ok_or(CorruptState)?);
        }
        Ok(())
    }

    pub fn sparse_array<const N: usize>(&mut self) -> ReadResult<[f64; N]> {
        let mut values = [0.0; N];
        self.sparse(&mut values)?;
        Ok(values)
    }

    pub fn sparse(&mut self, to: &mut [f64]) -> ReadResult {
        for eight in to.chunks_mut(8) {
            let there = self.byte()?;
            for (bit, value) in eight.iter_mut().enumerate() {
                *value = if there >> bit & 1 == 1 { self.number()? } else { 0.0 };
            }
        }
        Ok(())
    }

    /// Read vectors, either none or one per node.
    pub fn vector_list(&mut self, to: &mut Vectors, masses: usize) -> ReadResult {
        let count = self.length(24)?;
        if count != 0 && count != masses {
            return Err(CorruptState);
        }
        if to.len() != count {
            *to = Vectors::zeros(count);
        }
        to.deserialise(self)
    }

    pub fn flags(&mut self, to: &mut Vec<bool>) -> ReadResult {
        let count = usize::try_from(self.count()?).map_err(|_| CorruptState)?;
        let bytes = self.take_bytes(count.div_ceil(8))?;
        to.clear();
        to.extend((0..count).map(|i| bytes[i / 8] >> (i % 8) & 1 == 1));
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn written_state_reads_back_bit_for_bit() {
        let mut keeper = StateWriter::default();
        for value in [0, 1, 127, 128, 300, u64::from(u32::MAX), u64::MAX] {
            keeper.count(value);
        }
        let numbers = [0.0, -0.0, f64::NAN, f64::INFINITY, 1e-310, 3.0, 0.0, 0.0, 7.5];
        keeper.sparse(&numbers);
        keeper.states(&numbers);
        keeper.singles(&[1.5, -0.0]);
        keeper.flags(&[true, false, true, true, false, false, false, false, true]);
        keeper.text("αβ");
        [None, Some(2.0)].serialise(&mut keeper);
        let mut taker = StateReader::new(&keeper.bytes);
        for value in [0, 1, 127, 128, 300, u64::from(u32::MAX), u64::MAX] {
            assert_eq!(taker.count(), Ok(value));
        }
        let bits = |values: &[f64]| values.iter().map(|v| v.to_bits()).collect::<Vec<_>>();
        let mut sparse = [9.0; 9];
        taker.sparse(&mut sparse).expect("there");
        assert_eq!(bits(&sparse), bits(&numbers));
        assert_eq!(taker.states(8).map(|l| bits(&l)), Ok(bits(&numbers)));
        let mut singles = [0.0; 2];
        taker.singles(&mut singles).expect("there");
        assert_eq!(singles.map(f32::to_bits), [1.5_f32, -0.0].map(f32::to_bits));
        let mut flags = Vec::new();
        taker.flags(&mut flags).expect("there");
        assert_eq!(flags, [true, false, true, true, false, false, false, false, true]);
        assert_eq!(taker.text(), Ok("αβ"));
        assert_eq!(taker.read(), Ok([None, Some(2.0)]));
        assert!(taker.is_empty());
    }

    #[test]
    fn corrupt_bytes_are_refused() {
        assert_eq!(StateReader::new(&[0xff; 11]).count(), Err(CorruptState));
        assert_eq!(StateReader::new(&[0x80]).count(), Err(CorruptState));
        assert_eq!(StateReader::new(&[2]).flag(), Err(CorruptState));
        assert_eq!(StateReader::new(&[9, 1, 2]).blob(), Err(CorruptState));
        assert_eq!(StateReader::new(&[1, 0xff]).text(), Err(CorruptState));
        // A count larger than memory.
        assert_eq!(StateReader::new(&[0xff, 0xff, 0xff, 0xff, 0x7f]).states::<f64>(8), Err(CorruptState));
        assert_eq!(StateReader::new(&[5]).index(5), Err(CorruptState));
        assert_eq!(StateReader::new(&[0xff, 0xff, 0xff, 0xff, 0x7f]).flags(&mut Vec::new()), Err(CorruptState));
    }
}
