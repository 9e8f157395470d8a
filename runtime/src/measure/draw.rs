//! Numbers drawn from a seed, the same on every machine (xorshift64*; Vigna, ACM Trans. Math. Softw. 42(4), 2016).

use glam::DVec3;

/// A sequence of numbers.
pub(super) struct Draw(u64);

impl Draw {
    /// The sequence of draw number `index` of a seed.
    pub fn new(seed: u64, index: u64) -> Self {
        let mixed = (index + 1).wrapping_mul(0xd134_2543_de82_ef95) ^ seed.wrapping_mul(0xa076_1d64_78bd_642f);
        // A state of zero would stay there.
        let mut draw = Self((0x9e37_79b9_7f4a_7c15 ^ mixed).max(1));
        (0..8).for_each(|_| _ = draw.unit());
        draw
    }

    /// The next, 0 to 1.
    pub fn unit(&mut self) -> f64 {
        self.0 ^= self.0 >> 12;
        self.0 ^= self.0 << 25;
        self.0 ^= self.0 >> 27;
        (self.0.wrapping_mul(0x2545_f491_4f6c_dd1d) >> 11) as f64 / (1u64 << 53) as f64
    }

    /// The next, spread evenly between two.
    pub fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.unit()
    }

    /// The next, evenly spread over magnitudes.
    pub fn scale(&mut self, low: f64, high: f64) -> f64 {
        low * (high / low).powf(self.unit())
    }

    /// One of these.
    pub fn pick<T: Copy>(&mut self, from: &[T]) -> T {
        from[(self.unit() * from.len() as f64) as usize % from.len()]
    }

    /// Turns about the three axes, degrees.
    pub fn turns(&mut self) -> DVec3 {
        DVec3::new(self.between(0.0, 360.0), self.between(0.0, 360.0), self.between(0.0, 360.0))
    }
}
