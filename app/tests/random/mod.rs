//! Random numbers that a printed seed gives again.
#![allow(dead_code, unreachable_pub)]

/// SplitMix64 (Steele, Lea and Flood 2014).
pub struct Random(u64);

impl Random {
    /// Numbers from the seed in `BOZZETTO_SEED`, else from `usual`. The seed is printed, so a failure can be had again.
    pub fn seeded(usual: u64) -> Self {
        let chosen = std::env::var("BOZZETTO_SEED").ok().and_then(|text| text.parse().ok());
        let seed = chosen.unwrap_or(usual);
        println!("BOZZETTO_SEED={seed}");
        Self(seed)
    }

    /// The next 64 bits.
    pub fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    /// A whole number from 0 to `bound − 1`.
    pub fn below(&mut self, bound: usize) -> usize {
        (self.bits() % bound as u64) as usize
    }

    /// A number from −1 to 1.
    pub fn signed(&mut self) -> f64 {
        (self.bits() >> 11) as f64 / (1u64 << 52) as f64 - 1.0
    }

    /// A point of the cube from −1 to 1.
    pub fn point(&mut self) -> [f64; 3] {
        [self.signed(), self.signed(), self.signed()]
    }

    /// Puts a list into a random order.
    pub fn shuffle<T>(&mut self, list: &mut [T]) {
        for last in (1..list.len()).rev() {
            list.swap(last, self.below(last + 1));
        }
    }
}
