//! Random numbers for the noise and the open lines of an encoder.

/// SplitMix64 (Steele, Lea and Flood, OOPSLA 2014), which is the same on every machine.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct SplitMix64 {
    state: u64,
}

impl SplitMix64 {
    /// Starts the stream of a seed.
    pub const fn new(seed: u64) -> Self {
        Self { state: seed }
    }

    /// Returns the next 32 bits.
    #[inline]
    pub const fn next(&mut self) -> u32 {
        self.state = self.state.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut word = self.state;
        word = (word ^ (word >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        word = (word ^ (word >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        word ^= word >> 31;
        (word >> 32) as u32
    }

    /// Returns the next number below `end`, with a bias of `end` / 2^32.
    #[inline]
    pub const fn below(&mut self, end: u32) -> u32 {
        ((self.next() as u64 * end as u64) >> 32) as u32
    }
}
