//! Random numbers from a seed, equal on all machines (xorshift64*; Vigna, ACM Trans. Math. Softw.
//! 42(4), 2016).

use glam::DVec3;
use sheetwork::scene::Material;
use sheetwork::scene::material::LIBRARY;

/// Materials that are drawn. A material that is added to the library does not change the draws.
const DRAWN_MATERIALS: [&str; 11] = [
    "hips",
    "pvc",
    "pvc-plasticised",
    "packaging-pvc",
    "pet",
    "paper",
    "card",
    "playing-card",
    "steel-foil",
    "aluminium-foil",
    "rubber",
];

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

    /// A random material of the library, with its name.
    pub fn material(&mut self) -> (&'static str, Material) {
        let name = self.pick(&DRAWN_MATERIALS);
        let found = LIBRARY.iter().find(|row| row.0 == name);
        (name, found.map_or_else(Material::default, |row| row.2.clone()))
    }

    /// Random rotations about the three axes, degrees.
    pub fn turns(&mut self) -> DVec3 {
        DVec3::new(self.between(0.0, 360.0), self.between(0.0, 360.0), self.between(0.0, 360.0))
    }
}

/// Pseudo-random numbers (splitmix64), determined by seed and number.
pub struct SplitMix64(u64);

impl SplitMix64 {
    /// Sequence from this state.
    pub fn from_state(state: u64) -> Self {
        Self(state)
    }

    /// Sequence `number` of a seed; 0 and 0 start at state 0.
    pub fn new(seed: u64, number: u64) -> Self {
        Self(seed.wrapping_mul(0xd134_2543_de82_ef95) ^ number.wrapping_mul(0x9e37_79b9_7f4a_7c15))
    }

    /// Next 64 bits.
    pub fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    /// A number below `end`; 0 for an end of 0.
    pub fn below(&mut self, end: usize) -> usize {
        (self.bits() % end.max(1) as u64) as usize
    }

    /// True with probability 1/n.
    pub fn once_in(&mut self, n: usize) -> bool {
        self.below(n) == 0
    }

    /// Next number, uniform in `low` to `high`.
    pub fn within(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * (self.bits() >> 11) as f64 / (1_u64 << 53) as f64
    }

    /// Uniform in the logarithm.
    pub fn scale(&mut self, low: f64, high: f64) -> f64 {
        self.within(low.ln(), high.ln()).exp()
    }

    /// A vector with components of at most `reach`.
    pub fn place(&mut self, reach: f64) -> DVec3 {
        DVec3::new(self.within(-reach, reach), self.within(-reach, reach), self.within(-reach, reach))
    }

    /// A random element.
    pub fn pick<'a, T>(&mut self, of: &'a [T]) -> &'a T {
        &of[self.below(of.len())]
    }
}
