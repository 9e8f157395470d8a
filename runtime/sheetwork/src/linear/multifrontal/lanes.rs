//! Vector operations of the factorisation for each instruction set.
//!
//! A value of [`Avx512`] or [`Avx2`] is a proof that the processor has the instructions, so its
//! methods do not test again. They are inlined into [`Lanes::run`], which is compiled for the
//! instructions.
//!
//! AVX-512 and AVX2 round a product and a sum once (fused multiply-add); portable code rounds
//! twice. The results of the three differ in the last bits; each gives equal bits on every machine
//! that supports it.

/// Work to run with the instructions of a vector type.
pub trait VectorKernel<const G: usize> {
    /// Result of the work.
    type Output;

    /// Runs the work. Implementations, and all vector code that they call, must be
    /// `#[inline(always)]`.
    fn run<L: Lanes<G>>(self, lanes: L) -> Self::Output;
}

/// Vectors of `G` numbers.
pub trait Lanes<const G: usize>: Copy {
    /// A vector.
    type Vector: Copy;

    /// Height of a tile of the product kernel in vectors, 1 to 3: the largest that fits into the
    /// registers.
    const TALL: usize;

    /// Runs a job compiled for these instructions.
    fn run<J: VectorKernel<G>>(self, job: J) -> J::Output;

    /// `x` in every lane.
    fn splat(self, x: f64) -> Self::Vector;

    /// Loads from memory.
    fn load(self, from: &[f64; G]) -> Self::Vector;

    /// Stores to memory.
    fn store(self, v: Self::Vector, to: &mut [f64; G]);

    /// a + b.
    fn add(self, a: Self::Vector, b: Self::Vector) -> Self::Vector;

    /// a - b.
    fn sub(self, a: Self::Vector, b: Self::Vector) -> Self::Vector;

    /// a b.
    fn mul(self, a: Self::Vector, b: Self::Vector) -> Self::Vector;

    /// a b + c.
    fn mul_add(self, a: Self::Vector, b: Self::Vector, c: Self::Vector) -> Self::Vector;

    /// c - a b.
    fn sub_mul(self, a: Self::Vector, b: Self::Vector, c: Self::Vector) -> Self::Vector;

    /// Adds `from` to `to`, both of one length.
    #[inline(always)]
    fn add_to(self, to: &mut [f64], from: &[f64]) {
        let (to, to_rest) = to.as_chunks_mut::<G>();
        let (from, from_rest) = from.as_chunks::<G>();
        for (t, f) in to.iter_mut().zip(from) {
            self.store(self.add(self.load(t), self.load(f)), t);
        }
        self.add_rest(to_rest, from_rest);
    }

    /// Adds `from` to `to`, both shorter than a vector.
    #[inline(always)]
    fn add_rest(self, to: &mut [f64], from: &[f64]) {
        for (t, f) in to.iter_mut().zip(from) {
            *t += f;
        }
    }

    /// Zero in every lane.
    #[inline(always)]
    fn zero(self) -> Self::Vector {
        self.splat(0.0)
    }

    /// The lanes as an array.
    #[inline(always)]
    fn array(self, v: Self::Vector) -> [f64; G] {
        let mut lanes = [0.0; G];
        self.store(v, &mut lanes);
        lanes
    }
}

/// Four lanes of scalar arithmetic, for every processor.
#[derive(Clone, Copy, Debug)]
pub struct Portable;

impl Lanes<4> for Portable {
    type Vector = [f64; 4];

    const TALL: usize = 1;

    #[inline]
    fn run<J: VectorKernel<4>>(self, job: J) -> J::Output {
        job.run(self)
    }

    #[inline(always)]
    fn splat(self, x: f64) -> [f64; 4] {
        [x; 4]
    }

    #[inline(always)]
    fn load(self, from: &[f64; 4]) -> [f64; 4] {
        *from
    }

    #[inline(always)]
    fn store(self, v: [f64; 4], to: &mut [f64; 4]) {
        *to = v;
    }

    #[inline(always)]
    fn add(self, a: [f64; 4], b: [f64; 4]) -> [f64; 4] {
        [a[0] + b[0], a[1] + b[1], a[2] + b[2], a[3] + b[3]]
    }

    #[inline(always)]
    fn sub(self, a: [f64; 4], b: [f64; 4]) -> [f64; 4] {
        [a[0] - b[0], a[1] - b[1], a[2] - b[2], a[3] - b[3]]
    }

    #[inline(always)]
    fn mul(self, a: [f64; 4], b: [f64; 4]) -> [f64; 4] {
        [a[0] * b[0], a[1] * b[1], a[2] * b[2], a[3] * b[3]]
    }

    #[inline(always)]
    fn mul_add(self, a: [f64; 4], b: [f64; 4], c: [f64; 4]) -> [f64; 4] {
        self.add(self.mul(a, b), c)
    }

    #[inline(always)]
    fn sub_mul(self, a: [f64; 4], b: [f64; 4], c: [f64; 4]) -> [f64; 4] {
        self.sub(c, self.mul(a, b))
    }
}

#[cfg(target_arch = "x86_64")]
pub use x86::{Avx2, Avx512};

#[cfg(target_arch = "x86_64")]
mod x86 {
    use std::arch::x86_64::*;

    use super::{Lanes, VectorKernel};

    /// Proof of AVX-512F: eight lanes, fused multiply-add.
    #[derive(Clone, Copy, Debug)]
    pub struct Avx512(());

    /// Proof of AVX2 and FMA: four lanes, fused multiply-add.
    #[derive(Clone, Copy, Debug)]
    pub struct Avx2(());

    impl Avx512 {
        /// Returns the proof if this processor has the instructions.
        pub fn detect() -> Option<Self> {
            (is_x86_feature_detected!("avx512f") && Avx2::detect().is_some()).then_some(Self(()))
        }
    }

    impl Avx2 {
        /// Returns the proof if this processor has the instructions.
        pub fn detect() -> Option<Self> {
            (is_x86_feature_detected!("avx2") && is_x86_feature_detected!("fma")).then_some(Self(()))
        }
    }

    /// Implements [`Lanes`] with intrinsics: each method is the instruction that it names.
    macro_rules! lanes {
        ($proof:ty, $g:literal, $vector:ty, $tall:literal, $features:literal, $splat:ident, $load:ident, $store:ident, $add:ident,
         $sub:ident, $mul:ident, $mul_add:ident, $sub_mul:ident, {$($own:item)*}) => {
            impl Lanes<$g> for $proof {
                type Vector = $vector;

                const TALL: usize = $tall;

                #[inline]
                fn run<J: VectorKernel<$g>>(self, job: J) -> J::Output {
                    #[target_feature(enable = $features)]
                    fn compiled<J: VectorKernel<$g>>(lanes: $proof, job: J) -> J::Output {
                        job.run(lanes)
                    }
                    // SAFETY: `self` exists only if the processor has these features.
                    unsafe { compiled(self, job) }
                }

                #[inline(always)]
                fn splat(self, x: f64) -> $vector {
                    // SAFETY: `self` exists only if the processor has the instruction.
                    unsafe { $splat(x) }
                }

                #[inline(always)]
                fn load(self, from: &[f64; $g]) -> $vector {
                    // SAFETY: `self` exists only if the processor has the instruction, and the
                    // reference is to as many numbers as are read; the instruction needs no
                    // alignment.
                    unsafe { $load(from.as_ptr()) }
                }

                #[inline(always)]
                fn store(self, v: $vector, to: &mut [f64; $g]) {
                    // SAFETY: `self` exists only if the processor has the instruction, and the
                    // reference is to as many numbers as are written; the instruction needs no
                    // alignment.
                    unsafe { $store(to.as_mut_ptr(), v) }
                }

                #[inline(always)]
                fn add(self, a: $vector, b: $vector) -> $vector {
                    // SAFETY: `self` exists only if the processor has the instruction.
                    unsafe { $add(a, b) }
                }

                #[inline(always)]
                fn sub(self, a: $vector, b: $vector) -> $vector {
                    // SAFETY: `self` exists only if the processor has the instruction.
                    unsafe { $sub(a, b) }
                }

                #[inline(always)]
                fn mul(self, a: $vector, b: $vector) -> $vector {
                    // SAFETY: `self` exists only if the processor has the instruction.
                    unsafe { $mul(a, b) }
                }

                #[inline(always)]
                fn mul_add(self, a: $vector, b: $vector, c: $vector) -> $vector {
                    // SAFETY: `self` exists only if the processor has the instruction.
                    unsafe { $mul_add(a, b, c) }
                }

                #[inline(always)]
                fn sub_mul(self, a: $vector, b: $vector, c: $vector) -> $vector {
                    // SAFETY: `self` exists only if the processor has the instruction.
                    unsafe { $sub_mul(a, b, c) }
                }

                $($own)*
            }
        };
    }

    lanes!(
        Avx512,
        8,
        __m512d,
        3,
        "avx512f,avx2,fma",
        _mm512_set1_pd,
        _mm512_loadu_pd,
        _mm512_storeu_pd,
        _mm512_add_pd,
        _mm512_sub_pd,
        _mm512_mul_pd,
        _mm512_fmadd_pd,
        _mm512_fnmadd_pd,
        {
            #[inline(always)]
            fn add_rest(self, to: &mut [f64], from: &[f64]) {
                let len = to.len().min(from.len()).min(8);
                let mask = ((1u16 << len) - 1) as u8;
                // SAFETY: `self` exists only if the processor has the instructions; the mask
                // excludes all lanes that are not in both slices, and excluded lanes are neither
                // read nor written.
                unsafe {
                    let sum = _mm512_add_pd(
                        _mm512_maskz_loadu_pd(mask, to.as_ptr()),
                        _mm512_maskz_loadu_pd(mask, from.as_ptr()),
                    );
                    _mm512_mask_storeu_pd(to.as_mut_ptr(), mask, sum);
                }
            }
        }
    );
    lanes!(
        Avx2,
        4,
        __m256d,
        2,
        "avx2,fma",
        _mm256_set1_pd,
        _mm256_loadu_pd,
        _mm256_storeu_pd,
        _mm256_add_pd,
        _mm256_sub_pd,
        _mm256_mul_pd,
        _mm256_fmadd_pd,
        _mm256_fnmadd_pd,
        {}
    );
}
