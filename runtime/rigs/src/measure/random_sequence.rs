//! Random numbers from a seed, equal on all machines (xorshift64*; Vigna, ACM Trans. Math. Softw.
//! 42(4), 2016).

use glam::DVec3;

/// A pseudo-random sequence.
pub(crate) struct RandomSequence(u64);

impl RandomSequence {
    /// The sequence of draw `index` of a seed.
    pub fn new(seed: u64, index: u64) -> Self {
        let mixed = (index + 1).wrapping_mul(0xd134_2543_de82_ef95) ^ seed.wrapping_mul(0xa076_1d64_78bd_642f);
        // Zero is a fixed point of the generator.
        let mut draw = Self((0x9e37_79b9_7f4a_7c15 ^ mixed).max(1));
        (0..8).for_each(|_| _ = draw.unit());
        draw
    }

    /// Next number, uniform in 0 to 1.
    pub fn unit(&mut self) -> f64 {
        self.0 ^= self.0 >> 12;
        self.0 ^= self.0 << 25;
        self.0 ^= self.0 >> 27;
        (self.0.wrapping_mul(0x2545_f491_4f6c_dd1d) >> 11) as f64 / (1u64 << 53) as f64
    }

    /// Next number, uniform in `low` to `high`.
    pub fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.unit()
    }

    /// Next number, uniform in the logarithm, in `low` to `high`.
    pub fn scale(&mut self, low: f64, high: f64) -> f64 {
        low * (high / low).powf(self.unit())
    }

    /// A random element.
    pub fn pick<T: Copy>(&mut self, from: &[T]) -> T {
        from[(self.unit() * from.len() as f64) as usize % from.len()]
    }

    /// Random rotations about the three axes, degrees.
    pub fn turns(&mut self) -> DVec3 {
        DVec3::new(self.between(0.0, 360.0), self.between(0.0, 360.0), self.between(0.0, 360.0))
    }
}
