//! Serialisation of state to bytes ([`Keeper`]) and from bytes ([`Taker`]), for snapshots.
//!
//! Little endian; numbers keep all bits. Each type whose state carries over between steps has a
//! function that writes it and one that reads it in the same order. The bytes come from a file with
//! a valid checksum and from a world of the same structure; counts and indices are checked
//! nevertheless, and invalid ones are a [`Cut`].

use glam::{DQuat, DVec3};

use crate::math::Vectors;

/// Error of deserialisation: the bytes end early or contain an invalid value.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Cut;

/// Result of deserialisation.
pub type Taken<T = ()> = Result<T, Cut>;

/// Writer of state.
#[derive(Default)]
pub struct Keeper {
    pub bytes: Vec<u8>,
}

impl Keeper {
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

    pub fn vector(&mut self, value: DVec3) {
        value.to_array().into_iter().for_each(|v| self.number(v));
    }

    pub fn rotation(&mut self, value: DQuat) {
        value.to_array().into_iter().for_each(|v| self.number(v));
    }

    pub fn optional(&mut self, value: Option<f64>) {
        self.flag(value.is_some());
        value.into_iter().for_each(|v| self.number(v));
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

    /// Write the count of numbers, then the numbers.
    pub fn list(&mut self, values: &[f64]) {
        self.count(values.len() as u64);
        self.numbers(values);
    }

    pub fn vectors(&mut self, values: &Vectors) {
        values.axes().into_iter().for_each(|axis| self.numbers(axis));
    }

    /// Write the count of vectors, then the vectors.
    pub fn vector_list(&mut self, values: &Vectors) {
        self.count(values.len() as u64);
        self.vectors(values);
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
pub struct Taker<'a> {
    rest: &'a [u8],
}

impl<'a> Taker<'a> {
    pub fn new(bytes: &'a [u8]) -> Self {
        Self { rest: bytes }
    }

    /// Whether all bytes have been read.
    pub fn is_empty(&self) -> bool {
        self.rest.is_empty()
    }

    fn some(&mut self, count: usize) -> Taken<&'a [u8]> {
        let (some, rest) = self.rest.split_at_checked(count).ok_or(Cut)?;
        self.rest = rest;
        Ok(some)
    }

    pub fn byte(&mut self) -> Taken<u8> {
        Ok(self.some(1)?[0])
    }

    pub fn flag(&mut self) -> Taken<bool> {
        match self.byte()? {
            0 => Ok(false),
            1 => Ok(true),
            _ => Err(Cut),
        }
    }

    pub fn count(&mut self) -> Taken<u64> {
        let (mut value, mut shift) = (0, 0);
        loop {
            let byte = self.byte()?;
            if shift > 63 || (shift == 63 && byte > 1) {
                return Err(Cut);
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
    pub fn length(&mut self, least: usize) -> Taken<usize> {
        let count = usize::try_from(self.count()?).map_err(|_| Cut)?;
        if count.checked_mul(least).is_some_and(|bytes| bytes <= self.rest.len()) { Ok(count) } else { Err(Cut) }
    }

    /// Read an index below `end`.
    pub fn index(&mut self, end: usize) -> Taken<u32> {
        let index = self.count()?;
        if index < end as u64 { u32::try_from(index).map_err(|_| Cut) } else { Err(Cut) }
    }

    /// Read four bytes, little endian.
    pub fn sum(&mut self) -> Taken<u32> {
        let bytes = self.some(4)?.first_chunk().ok_or(Cut)?;
        Ok(u32::from_le_bytes(*bytes))
    }

    /// Read an unsigned integer below 2³².
    pub fn small(&mut self) -> Taken<u32> {
        u32::try_from(self.count()?).map_err(|_| Cut)
    }

    pub fn number(&mut self) -> Taken<f64> {
        let bytes = self.some(8)?.first_chunk().ok_or(Cut)?;
        Ok(f64::from_le_bytes(*bytes))
    }

    pub fn vector(&mut self) -> Taken<DVec3> {
        Ok(DVec3::new(self.number()?, self.number()?, self.number()?))
    }

    pub fn rotation(&mut self) -> Taken<DQuat> {
        Ok(DQuat::from_xyzw(self.number()?, self.number()?, self.number()?, self.number()?))
    }

    pub fn optional(&mut self) -> Taken<Option<f64>> {
        if self.flag()? { self.number().map(Some) } else { Ok(None) }
    }

    pub fn text(&mut self) -> Taken<&'a str> {
        std::str::from_utf8(self.blob()?).map_err(|_| Cut)
    }

    pub fn blob(&mut self) -> Taken<&'a [u8]> {
        let count = self.length(1)?;
        self.some(count)
    }

    pub fn numbers(&mut self, to: &mut [f64]) -> Taken {
        let bytes = self.some(8 * to.len())?;
        for (to, from) in to.iter_mut().zip(bytes.chunks_exact(8)) {
            *to = f64::from_le_bytes(*from.first_chunk().ok_or(Cut)?);
        }
        Ok(())
    }

    pub fn singles(&mut self, to: &mut [f32]) -> Taken {
        let bytes = self.some(4 * to.len())?;
        for (to, from) in to.iter_mut().zip(bytes.chunks_exact(4)) {
            *to = f32::from_le_bytes(*from.first_chunk().ok_or(Cut)?);
        }
        Ok(())
    }

    pub fn sparse(&mut self, to: &mut [f64]) -> Taken {
        for eight in to.chunks_mut(8) {
            let there = self.byte()?;
            for (bit, value) in eight.iter_mut().enumerate() {
                *value = if there >> bit & 1 == 1 { self.number()? } else { 0.0 };
            }
        }
        Ok(())
    }

    pub fn list(&mut self) -> Taken<Vec<f64>> {
        let mut values = vec![0.0; self.length(8)?];
        self.numbers(&mut values)?;
        Ok(values)
    }

    /// Read a list into a slice of the same length.
    pub fn same_list(&mut self, to: &mut [f64]) -> Taken {
        if self.count()? != to.len() as u64 {
            return Err(Cut);
        }
        self.numbers(to)
    }

    pub fn vectors(&mut self, to: &mut Vectors) -> Taken {
        to.axes_mut().into_iter().try_for_each(|axis| self.numbers(axis))
    }

    /// Read vectors, either none or one per node.
    pub fn vector_list(&mut self, to: &mut Vectors, masses: usize) -> Taken {
        let count = self.length(24)?;
        if count != 0 && count != masses {
            return Err(Cut);
        }
        if to.len() != count {
            *to = Vectors::zeros(count);
        }
        self.vectors(to)
    }

    pub fn flags(&mut self, to: &mut Vec<bool>) -> Taken {
        let count = usize::try_from(self.count()?).map_err(|_| Cut)?;
        let bytes = self.some(count.div_ceil(8))?;
        to.clear();
        to.extend((0..count).map(|i| bytes[i / 8] >> (i % 8) & 1 == 1));
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_kept_is_taken() {
        let mut keeper = Keeper::default();
        for value in [0, 1, 127, 128, 300, u64::from(u32::MAX), u64::MAX] {
            keeper.count(value);
        }
        let numbers = [0.0, -0.0, f64::NAN, f64::INFINITY, 1e-310, 3.0, 0.0, 0.0, 7.5];
        keeper.sparse(&numbers);
        keeper.list(&numbers);
        keeper.singles(&[1.5, -0.0]);
        keeper.flags(&[true, false, true, true, false, false, false, false, true]);
        keeper.text("αβ");
        keeper.optional(None);
        keeper.optional(Some(2.0));
        let mut taker = Taker::new(&keeper.bytes);
        for value in [0, 1, 127, 128, 300, u64::from(u32::MAX), u64::MAX] {
            assert_eq!(taker.count(), Ok(value));
        }
        let bits = |values: &[f64]| values.iter().map(|v| v.to_bits()).collect::<Vec<_>>();
        let mut sparse = [9.0; 9];
        taker.sparse(&mut sparse).expect("there");
        assert_eq!(bits(&sparse), bits(&numbers));
        assert_eq!(taker.list().map(|l| bits(&l)), Ok(bits(&numbers)));
        let mut singles = [0.0; 2];
        taker.singles(&mut singles).expect("there");
        assert_eq!(singles.map(f32::to_bits), [1.5_f32, -0.0].map(f32::to_bits));
        let mut flags = Vec::new();
        taker.flags(&mut flags).expect("there");
        assert_eq!(flags, [true, false, true, true, false, false, false, false, true]);
        assert_eq!(taker.text(), Ok("αβ"));
        assert_eq!((taker.optional(), taker.optional()), (Ok(None), Ok(Some(2.0))));
        assert!(taker.is_empty());
    }

    #[test]
    fn what_cannot_be_is_refused() {
        assert_eq!(Taker::new(&[0xff; 11]).count(), Err(Cut));
        assert_eq!(Taker::new(&[0x80]).count(), Err(Cut));
        assert_eq!(Taker::new(&[2]).flag(), Err(Cut));
        assert_eq!(Taker::new(&[9, 1, 2]).blob(), Err(Cut));
        assert_eq!(Taker::new(&[1, 0xff]).text(), Err(Cut));
        // A count larger than memory.
        assert_eq!(Taker::new(&[0xff, 0xff, 0xff, 0xff, 0x7f]).list(), Err(Cut));
        assert_eq!(Taker::new(&[5]).index(5), Err(Cut));
        assert_eq!(Taker::new(&[0xff, 0xff, 0xff, 0xff, 0x7f]).flags(&mut Vec::new()), Err(Cut));
    }
}
