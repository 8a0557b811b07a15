//! Normal noise by sample number: the same number gives the same value, in whatever order samples are read.
//!
//! Reference: J. K. Salmon et al., "Parallel random numbers: as easy as 1, 2, 3", SC'11, DOI 10.1145/2063384.2063405
//! (counter-based generators; here ChaCha with 8 rounds). It does not do: coloured noise.

use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

/// 32-bit words of the generator reserved per sample; the ziggurat rarely needs more than two.
const WORDS: u128 = 16;

/// Standard normal numbers of a seed.
///
/// ```
/// let noise = piezoid_numerics::noise::Noise::new(7);
/// assert_eq!(noise.at(3), piezoid_numerics::noise::Noise::new(7).at(3));
/// assert_ne!(noise.at(3), noise.at(4));
/// ```
#[derive(Debug, Clone)]
pub struct Noise(ChaCha8Rng);

impl Noise {
    /// The numbers of `seed`.
    pub fn new(seed: u64) -> Self {
        Noise(ChaCha8Rng::seed_from_u64(seed))
    }

    /// Number `n`.
    pub fn at(&self, n: u64) -> f64 {
        let mut generator = self.0.clone();
        generator.set_word_pos(WORDS * u128::from(n));
        StandardNormal.sample(&mut generator)
    }
}
