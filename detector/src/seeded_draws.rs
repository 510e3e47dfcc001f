//! Random numbers from a seed, the same on every machine.

/// A stream of random numbers: the generator `SplitMix64` of Steele, Lea and Flood 2014.
#[derive(Debug, Clone)]
pub struct SeededDraws(u64);

impl SeededDraws {
    /// The stream of `seed`.
    pub fn new(seed: u64) -> Self {
        Self(seed)
    }

    /// A number in 0 to 1, without 1.
    pub fn share(&mut self) -> f64 {
        const TO_SHARE: f64 = 1.0 / (1_u64 << 53) as f64;
        (self.next() >> 11) as f64 * TO_SHARE
    }

    /// A number below `n`, which fits in 32 bits.
    pub fn below(&mut self, n: usize) -> usize {
        (((self.next() >> 32) * n as u64) >> 32) as usize
    }

    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut mixed = self.0;
        mixed = (mixed ^ (mixed >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        mixed = (mixed ^ (mixed >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        mixed ^ (mixed >> 31)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_is_the_published_generator() {
        // The first numbers of seed 1234567 in the authors' code.
        let mut draws = SeededDraws::new(1_234_567);
        assert_eq!([draws.next(), draws.next()], [6_457_827_717_110_365_317, 3_203_168_211_198_807_973]);
    }

    #[test]
    fn shares_are_spread_from_0_to_1() {
        let mut draws = SeededDraws::new(1);
        let shares: Vec<f64> = (0..1000).map(|_| draws.share()).collect();
        let mean = shares.iter().sum::<f64>() / 1000.0;
        assert!(shares.iter().all(|it| (0.0..1.0).contains(it)) && (mean - 0.5).abs() < 0.05, "{mean}");
    }
}
