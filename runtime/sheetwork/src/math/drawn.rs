//! Random tests draw the same cases in each run: a failure is of the change, not of chance.
//! `PROPTEST_RNG_SEED=7 cargo test -p sheetwork --lib` draws others.

use proptest::test_runner::{Config, RngSeed};

/// Configuration with a number of cases, from the seed of the environment or a fixed one.
pub(crate) fn drawn_cases(cases: u32) -> Config {
    let config = Config::with_cases(cases);
    let rng_seed = if config.rng_seed == RngSeed::Random { RngSeed::Fixed(1) } else { config.rng_seed };
    Config { rng_seed, ..config }
}
