//! The effort at which a joint breaks away, from a ramp of the effort from rest.
//!
//! ```text
//! effort  ^            x confirmed: 3 counts in 20 ms, or 8 in one run
//!         |          / |
//!         |        o   v  reading: the effort at the first count of that run
//!         |      /
//!         +----+--------> ticks
//!        from
//! ```
//!
//! The first effort is held for a tenth of a second, in which counts are no motion: bristles and
//! shafts give way to it at once.
//!
//! A joint with pre-sliding shows counts before it breaks away, but slowly: a tenth of a second
//! without a count ends a run of counts, and the counts of that run were no motion.
//!
//! The reading is late. With `D = F_s - F_c` the joint moves by `x = (D t^2 / 2 + r t^3 / 6) / J`
//! after breaking away, so the first count comes after about `delta = sqrt(2 x J / D)`, with half a
//! count for `x`, and the reading is high by `r delta`. Readings at two rates correct this, as long
//! as `D` accelerates the joint: `F = u_2 - (u_1 - u_2) r_2 / (r_1 - r_2)`.
//!
//! The reading is the requested effort. The drive rounds it to the nearest code, and so applies the
//! first sufficient code from half a code before on: on average, that is right.
//!
//! Does badly: if `D` is zero, the reading is high by a power 2/3 of the rate, of which two rates
//! correct only a part. A joint that rests on a wound-up shaft breaks away early.

/// Travel within [`SHORT`] that confirms a motion, counts.
const CONFIRMED: u32 = 3;
/// The time for that travel, s.
const SHORT: f32 = 0.02;
/// Travel of one run of counts that confirms a motion, however slow it is, counts.
const FAR: u32 = 8;
/// Time without a count that ends a run, s.
const PAUSE: f32 = 0.1;

/// Travel to and fro, beyond twice the net travel, that is noise, counts.
const NOISE: u32 = 16;

/// A ramp of the effort that is prepared for its ticks.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Push {
    /// First effort, V, without its sign.
    pub from: f32,
    /// Rise of the effort in a tick, V.
    pub rung: f32,
    /// Whether the effort is negative.
    pub reverse: bool,
}

/// The state of a ramp to the breakaway from tick to tick.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Breakaway {
    elapsed: u32,
    /// Positions at the start of the ramp, at the start of the present run of counts, and now,
    /// counts.
    origin: i32,
    run: i32,
    counts: i32,
    /// Tick of the first and of the last count of the run.
    run_began: u32,
    last_count: u32,
    /// Sum of all travel without its sign, counts.
    path: u32,
    /// Position (counts) and tick at the start of the present interval of `SHORT`.
    short: i32,
    short_began: u32,
}

impl Breakaway {
    /// Returns the state of a ramp that begins with the joint at rest at `counts`.
    pub const fn begin(counts: i32) -> Self {
        Self {
            elapsed: 0,
            origin: counts,
            run: counts,
            counts,
            run_began: 0,
            last_count: 0,
            path: 0,
            short: counts,
            short_began: 0,
        }
    }

    /// Returns the travel since the start of the ramp, counts.
    pub const fn travel(&self) -> i32 {
        self.counts.wrapping_sub(self.origin)
    }

    /// Returns the travel by which the joint gave way before the run of counts that is its motion,
    /// counts: bristles, backlash or a shaft. A stiff joint gives way by one count at most, at the
    /// edge of a count.
    pub const fn gave_way(&self) -> u32 {
        self.run.wrapping_sub(self.origin).unsigned_abs()
    }

    /// Returns whether the counts go to and fro: the encoder picks up noise. A joint that gives way
    /// goes one way.
    pub const fn is_noisy(&self) -> bool {
        self.path > self.travel().unsigned_abs().saturating_mul(2).saturating_add(NOISE)
    }

    /// Runs one tick with the joint at `counts`; `tick` is its length (s). Returns the effort from
    /// now on (V), or the reading (V, without its sign) if the joint has broken away.
    pub fn update(&mut self, push: &Push, counts: i32, tick: f32) -> Result<f32, f32> {
        // Never shorter than two ticks, or a slow loop would see no motion between two of them.
        let ticks = |s: f32| (libm::roundf(s / tick) as u32).max(2);
        let (pause, short) = (ticks(PAUSE), ticks(SHORT));
        // The effort that has led to this position is that of the tick before.
        let size = |ticks: u32| push.from + ticks.saturating_sub(pause) as f32 * push.rung;
        let moved = counts.wrapping_sub(self.counts).unsigned_abs();
        self.path = self.path.saturating_add(moved);
        if self.elapsed <= pause {
            (self.run, self.counts, self.short) = (counts, counts, counts);
            (self.last_count, self.short_began) = (0, self.elapsed);
        }
        if counts != self.counts {
            if self.elapsed.saturating_sub(self.last_count) > pause || self.run_began == 0 {
                self.run = self.counts;
                self.run_began = self.elapsed.max(1);
            }
            self.counts = counts;
            self.last_count = self.elapsed;
        }
        if self.elapsed.saturating_sub(self.short_began) > short {
            (self.short, self.short_began) = (counts, self.elapsed);
        }
        let within = |from: i32| counts.wrapping_sub(from).unsigned_abs();
        if within(self.short) >= CONFIRMED || within(self.run) >= FAR {
            return Err(size(self.run_began.saturating_sub(1)));
        }
        let effort = size(self.elapsed);
        self.elapsed = self.elapsed.saturating_add(1);
        Ok(if push.reverse { -effort } else { effort })
    }

    /// Returns the breakaway level (V) from readings (V) at a fast and at a slow rate (V/s): the
    /// line through both, at the rate zero.
    pub fn at_rest([fast, slow]: [f32; 2], [fast_rate, slow_rate]: [f32; 2]) -> f32 {
        slow - (fast - slow) * slow_rate / (fast_rate - slow_rate)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A joint that rests up to `stick` (V) and then moves by `x = (D t^2/2 + r t^3/6)/J`, with
    /// counts from `phase` on, and pre-sliding of `bristle` counts up to there.
    struct Truth {
        stick: f64,
        drop: f64,
        inertia: f64,
        bristle: f64,
        phase: f64,
    }

    impl Truth {
        fn reading(&self, push: &Push, tick: f64) -> f64 {
            let (rung, from) = (f64::from(push.rung), f64::from(push.from));
            let rate = rung / tick;
            let held = (0.1 / tick).round().max(2.0) * tick;
            let broke = held + (self.stick - from) / rate;
            let at = |t: f64| {
                let s = t - broke;
                let effort = from + rate * (t.min(broke) - held).max(0.0);
                let before = self.bristle * (effort / self.stick).powi(2);
                let after = if s > 0.0 {
                    (self.drop * s * s / 2.0 + rate * s.powi(3) / 6.0) / self.inertia
                } else {
                    0.0
                };
                (self.phase + before + after).floor() as i32
            };
            let mut state = Breakaway::begin(at(0.0));
            for k in 0..100_000 {
                if let Err(reading) = state.update(push, at(f64::from(k) * tick), tick as f32) {
                    return f64::from(reading);
                }
            }
            panic!("it never broke away");
        }
    }

    fn push(rate: f64, tick: f64) -> Push {
        Push { from: 0.2, rung: (rate * tick) as f32, reverse: false }
    }

    #[test]
    fn readings_are_late_by_the_closed_form_and_two_rates_give_it_back() {
        for tick in [1e-3, 1e-4, 2e-2] {
            for phase in [0.1, 0.5, 0.9] {
                // In counts: 0.4 V, 0.02 V of drop, 27 deg/s^2 per V and 0.00242 deg.
                let inertia = 0.00242 / 27.0;
                let truth = Truth { stick: 0.4, drop: 0.02, inertia, bristle: 0.0, phase };
                let [fast, slow] = [0.08, 0.024].map(|rate| truth.reading(&push(rate, tick), tick));
                let late = (2.0 * (1.0 - phase) * inertia / 0.02).sqrt();
                for (reading, rate) in [(fast, 0.08), (slow, 0.024)] {
                    let high = reading - 0.4;
                    // The jerk shortens it; and a tick more or less.
                    let bounds = (0.6 * late - tick) * rate..=(late + 1.5 * tick) * rate;
                    assert!(bounds.contains(&high), "{high} {late} {rate} {tick}");
                }
                let pair = [fast as f32, slow as f32];
                let found = f64::from(Breakaway::at_rest(pair, [0.08, 0.024]));
                assert!((found / 0.4 - 1.0).abs() < 0.006, "{found} {phase} {tick}");
            }
        }
    }

    #[test]
    fn counts_of_the_presliding_are_no_motion() {
        // Ten counts on the way; the last run begins where it breaks away.
        let inertia = 0.0036 / 2022.0;
        let truth = Truth { stick: 0.5, drop: 0.1, inertia, bristle: 10.0, phase: 0.3 };
        let found = truth.reading(&push(0.03, 1e-3), 1e-3);
        assert!((0.49..=0.51).contains(&found), "{found}");
        // One count and back is a disc on an edge.
        let mut state = Breakaway::begin(0);
        let flicker = (0..5000).all(|k| state.update(&push(0.03, 1e-3), k / 3 % 2, 1e-3).is_ok());
        assert!(flicker);
    }

    #[test]
    fn a_negative_push_gives_negative_efforts_and_a_reading_without_sign() {
        let push = Push { reverse: true, ..push(0.1, 1e-3) };
        let mut state = Breakaway::begin(7);
        // Held for 0.1 s, in which it gives way by 4 counts.
        for k in 0..=100 {
            let held = state.update(&push, 7 - k / 25, 1e-3).unwrap();
            assert!((held + 0.2).abs() < 1e-6);
        }
        let next = state.update(&push, 3, 1e-3).unwrap();
        assert!((next + 0.2001).abs() < 1e-6);
        let reading = state.update(&push, -13, 1e-3).unwrap_err();
        assert!((reading - 0.2001).abs() < 1e-6, "{reading}");
        assert_eq!(state.travel(), -20);
        // Of which the four were no motion.
        assert_eq!(state.gave_way(), 4);
    }
}
