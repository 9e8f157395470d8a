//! Eight numbers, vectors or matrices processed together: kernels of regular grids work on eight
//! cells at a time.
//!
//! Every operation is a loop over the lanes in order, which the compiler vectorises to the width
//! for which the kernel is compiled. Operations are neither contracted nor reordered, so that the
//! result is bit for bit independent of that width.

use std::ops::{Add, Mul, Neg, Sub};

/// Index of a 3x3 block that the tangent matrix does not have: blocks of fixed nodes are dropped.
pub const NO_BLOCK: u32 = u32::MAX;

use crate::math::Vectors;

/// Number of lanes of a [`Pack`].
pub const LANES: usize = 8;

/// Eight numbers.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Pack(pub [f64; LANES]);

impl Pack {
    /// Pack with `value` in all lanes.
    #[inline(always)]
    pub fn splat(value: f64) -> Self {
        Self([value; LANES])
    }

    /// First `LANES` numbers of `from`; zero beyond its end.
    #[inline(always)]
    pub fn load(from: &[f64]) -> Self {
        match from.first_chunk::<LANES>() {
            Some(all) => Self(*all),
            None => {
                let mut lanes = [0.0; LANES];
                lanes[..from.len()].copy_from_slice(from);
                Self(lanes)
            }
        }
    }

    /// Each lane, or zero where it is negative or NaN.
    #[inline(always)]
    pub fn positive_part(self) -> Self {
        let mut lanes = self.0;
        for x in &mut lanes {
            *x = if *x > 0.0 { *x } else { 0.0 };
        }
        Self(lanes)
    }

    /// Sum of the first `count` lanes.
    #[inline(always)]
    pub fn sum(self, count: usize) -> f64 {
        self.0[..count].iter().sum()
    }
}

/// Implement an operator lane by lane.
macro_rules! lanewise {
    ($trait:ident, $method:ident, $assign:tt) => {
        impl $trait for Pack {
            type Output = Self;
            #[inline(always)]
            fn $method(mut self, other: Self) -> Self {
                for l in 0..LANES {
                    self.0[l] $assign other.0[l];
                }
                self
            }
        }
    };
}

lanewise!(Add, add, +=);
lanewise!(Sub, sub, -=);
lanewise!(Mul, mul, *=);

impl Mul<f64> for Pack {
    type Output = Self;
    #[inline(always)]
    fn mul(mut self, scale: f64) -> Self {
        for l in 0..LANES {
            self.0[l] *= scale;
        }
        self
    }
}

impl Neg for Pack {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        self * -1.0
    }
}

/// Eight vectors.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Pack3 {
    /// First coordinates.
    pub x: Pack,
    /// Second coordinates.
    pub y: Pack,
    /// Third coordinates.
    pub z: Pack,
}

impl Pack3 {
    /// Vectors of `from` from index `at` on; zero beyond its end.
    #[inline(always)]
    pub fn load(from: &Vectors, at: usize) -> Self {
        Self { x: Pack::load(&from.x[at..]), y: Pack::load(&from.y[at..]), z: Pack::load(&from.z[at..]) }
    }

    /// Add the first `count` vectors to those of `to` from index `at` on.
    #[inline(always)]
    pub fn add_to(self, to: &mut Vectors, at: usize, count: usize) {
        for (to, from) in to.axes_mut().into_iter().zip([self.x, self.y, self.z]) {
            for (to, from) in to[at..at + count].iter_mut().zip(from.0) {
                *to += from;
            }
        }
    }

    /// Scalar product in each lane.
    #[inline(always)]
    pub fn dot(self, other: Self) -> Pack {
        self.x * other.x + self.y * other.y + self.z * other.z
    }

    /// Each vector times its lane of `s`.
    #[inline(always)]
    pub fn scaled(self, s: Pack) -> Self {
        Self { x: self.x * s, y: self.y * s, z: self.z * s }
    }
}

impl Add for Pack3 {
    type Output = Self;
    #[inline(always)]
    fn add(self, o: Self) -> Self {
        Self { x: self.x + o.x, y: self.y + o.y, z: self.z + o.z }
    }
}

impl Sub for Pack3 {
    type Output = Self;
    #[inline(always)]
    fn sub(self, o: Self) -> Self {
        Self { x: self.x - o.x, y: self.y - o.y, z: self.z - o.z }
    }
}

impl Mul<f64> for Pack3 {
    type Output = Self;
    #[inline(always)]
    fn mul(self, s: f64) -> Self {
        Self { x: self.x * s, y: self.y * s, z: self.z * s }
    }
}

/// Eight 3x3 matrices, by rows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pack9(pub [Pack; 9]);

impl Pack9 {
    /// Outer product (scale a) bᵀ.
    #[inline(always)]
    pub fn outer(a: Pack3, b: Pack3, scale: Pack) -> Self {
        let a = a.scaled(scale);
        Self([
            a.x * b.x,
            a.x * b.y,
            a.x * b.z, //
            a.y * b.x,
            a.y * b.y,
            a.y * b.z, //
            a.z * b.x,
            a.z * b.y,
            a.z * b.z,
        ])
    }

    /// Sum self + s I.
    #[inline(always)]
    pub fn plus_identity(mut self, s: Pack) -> Self {
        for i in [0, 4, 8] {
            self.0[i] = self.0[i] + s;
        }
        self
    }

    /// Transposed matrices.
    #[inline(always)]
    pub fn transposed(self) -> Self {
        let m = self.0;
        Self([m[0], m[3], m[6], m[1], m[4], m[7], m[2], m[5], m[8]])
    }

    /// Add lane l to block `slots[l]` of `values`, for the first `count` lanes.
    #[inline(always)]
    pub fn scatter(&self, slots: &[u32; LANES], count: usize, values: &mut [f64]) {
        for (l, slot) in slots.iter().enumerate().take(count) {
            if *slot != NO_BLOCK {
                let at = *slot as usize * 9;
                for (to, from) in values[at..at + 9].iter_mut().zip(&self.0) {
                    *to += from.0[l];
                }
            }
        }
    }
}

impl Add for Pack9 {
    type Output = Self;
    #[inline(always)]
    fn add(mut self, o: Self) -> Self {
        for i in 0..9 {
            self.0[i] = self.0[i] + o.0[i];
        }
        self
    }
}

impl Sub for Pack9 {
    type Output = Self;
    #[inline(always)]
    fn sub(mut self, o: Self) -> Self {
        for i in 0..9 {
            self.0[i] = self.0[i] - o.0[i];
        }
        self
    }
}
