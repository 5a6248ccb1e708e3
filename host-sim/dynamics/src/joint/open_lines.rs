//! An encoder with open lines that pick up noise, and the decoder behind them.
//!
//! The level of one open line is random at each edge of the other, and once in each reading. With
//! both open, the counter is at a random place within a few counts of its start. Limits: lines that
//! are open for a part of the time, and edges that are too fast for a decoder, are not simulated.

use super::random::SplitMix64;

/// Which lines of an encoder are open.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum OpenLines {
    /// One of A and B.
    One,
    /// Both: the counter is within this number of counts of its start.
    Both(u16),
}

/// Quadrature decoder whose lines are open from its start on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct OpenLineDecoder {
    open: OpenLines,
    random: SplitMix64,
    /// True position, counts.
    disc: i64,
    /// Level of the open line.
    level: bool,
    counts: i64,
}

impl OpenLineDecoder {
    /// Creates a decoder at zero with the disc at zero.
    pub const fn new(open: OpenLines, seed: u64) -> Self {
        Self { open, random: SplitMix64::new(seed), disc: 0, level: false, counts: 0 }
    }

    /// Moves the disc to a position (counts), and returns the change of the decoder's counts.
    pub const fn move_to(&mut self, disc: i64) -> i64 {
        let before = self.counts;
        match self.open {
            OpenLines::Both(most) => {
                self.counts = self.random.below(2 * most as u32 + 1) as i64 - most as i64;
            }
            OpenLines::One => {
                while self.disc != disc {
                    let next = self.disc + (disc - self.disc).signum();
                    let [old, new] = [Self::sound(self.disc), Self::sound(next)];
                    if old != new {
                        self.flicker(old);
                        self.counts += if new == self.level { -1 } else { 1 };
                    }
                    self.disc = next;
                }
                self.flicker(Self::sound(disc));
            }
        }
        self.counts - before
    }

    /// Returns the level of the intact line at a position (counts).
    const fn sound(disc: i64) -> bool {
        (disc + 1).rem_euclid(4) >= 2
    }

    /// Sets the open line to a random level. `sound` is the level of the intact line.
    const fn flicker(&mut self, sound: bool) {
        let level = self.random.below(2) == 1;
        if level != self.level {
            self.counts += if level == sound { 1 } else { -1 };
            self.level = level;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A level that is random at each edge makes as many counts forth as back: n edges are a random
    /// walk, whose mean square is at most a few times n.
    #[test]
    fn one_open_line_counts_at_random_whichever_way_the_disc_turns() {
        for (seed, to) in [(1, 40_000), (2, -40_000)] {
            let mut decoder = OpenLineDecoder::new(OpenLines::One, seed);
            let made = decoder.move_to(to);
            // 20 000 edges of the sound line; five times the square root of twice as many.
            assert!(made != 0 && made.abs() < 1000, "{made} counts of {to}");
        }
        // At rest it flickers within a count.
        let mut decoder = OpenLineDecoder::new(OpenLines::One, 3);
        let places: Vec<i64> = (0..100)
            .scan(0, |at, _| {
                *at += decoder.move_to(0);
                Some(*at)
            })
            .collect();
        let [least, most] = [places.iter().min(), places.iter().max()].map(|at| *at.unwrap());
        assert_eq!(most - least, 1, "{places:?}");
    }

    #[test]
    fn both_open_lines_show_nothing_of_the_disc() {
        let mut decoder = OpenLineDecoder::new(OpenLines::Both(4), 1);
        let mut at = 0;
        let mut seen = [0u32; 9];
        for disc in 0..9000 {
            at += decoder.move_to(100 * disc);
            seen[usize::try_from(at + 4).unwrap()] += 1;
        }
        // Five standard deviations of a binomial count of 1/9 in 9000: 5 * 29.8.
        assert!(seen.iter().all(|count| count.abs_diff(1000) < 149), "{seen:?}");
    }
}
