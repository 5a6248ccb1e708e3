//! The control tick with the interrupts of the current loop that fall into it.
//!
//! ```text
//! t = tick + ceil(t / period) isr        the smallest fixed point: the tick begins with a period
//! share = tick / sample time + isr / period
//! ```
//!
//! Tick and interrupt are the longest ones of all laws with a current loop, both with the estimated
//! cycles of an entry and an exit. The deadline of a tick is half of the sample time. Link, log and
//! watchdog run below the tick and are left out of the share.

use emulator::board::CLOCK_HZ;
use emulator::tracer::Cycles;

use crate::measure::{CostMeasurement, LOOP_ROW};

/// Longest time of a tick with its preemptions, us, and largest share of the processor, %.
const LONGEST_US: f64 = 60.0;
const LARGEST_SHARE: f64 = 15.0;

/// The usual sample time, s, and the PWM beside it, Hz.
const USUAL: Rates = Rates { sample_s: 1e-3, pwm_hz: 22e3 };
/// The shortest sample time that a device accepts, s, with a PWM that is in step with it, and with
/// the fastest one whose current is converted.
const SHORTEST: [Rates; 2] =
    [Rates { sample_s: 1e-4, pwm_hz: 20e3 }, Rates { sample_s: 1e-4, pwm_hz: 100e3 }];

/// A sample time, s, and the frequency of the PWM, Hz.
#[derive(Clone, Copy, Debug)]
struct Rates {
    sample_s: f64,
    pwm_hz: f64,
}

/// The longest tick and the longest interrupt of the current loop.
#[derive(Clone, Copy, Debug)]
pub struct Nesting {
    tick: Cycles,
    period: Cycles,
}

/// Time of a tick with its preemptions, us; their number; and the share of the processor, %.
#[derive(Clone, Copy, Debug)]
struct Nested {
    time_us: f64,
    preemptions: u32,
    share: f64,
}

impl Nested {
    /// Returns the smallest fixed point for a tick and an interrupt (us). There is none if the
    /// interrupt alone fills its period: the time is then infinite.
    fn of([tick_us, period_us]: [f64; 2], rates: Rates) -> Self {
        let Rates { sample_s, pwm_hz } = rates;
        let every_us = 1e6 / pwm_hz;
        let share = 100.0 * (tick_us / (1e6 * sample_s) + period_us / every_us);
        if period_us >= every_us {
            return Self { time_us: f64::INFINITY, preemptions: 0, share };
        }
        let mut preemptions = 0;
        loop {
            let time_us = tick_us + f64::from(preemptions) * period_us;
            let within = (time_us / every_us).ceil() as u32;
            if within <= preemptions {
                return Self { time_us, preemptions, share };
            }
            preemptions = within;
        }
    }
}

impl Nesting {
    /// Returns the longest ticks and interrupts of an image; none if no current loop has run.
    pub fn of(measured: &CostMeasurement) -> Option<Self> {
        let period = most(measured.periods.iter().map(|period| period.cycles))?;
        let with_loop = measured.laws.iter().filter(|(name, _)| name.ends_with(LOOP_ROW));
        let ticks = with_loop.flat_map(|(_, ticks)| ticks);
        Some(Self { tick: most(ticks.map(|tick| tick.interrupt.cycles))?, period })
    }

    /// Returns hits and misses at these rates.
    fn at(self, rates: Rates) -> [Nested; 2] {
        [[self.tick.hits, self.period.hits], [self.tick.misses, self.period.misses]].map(|cycles| {
            let us = cycles.map(|cycles| f64::from(cycles) / CLOCK_HZ.get() as f64 * 1e6);
            Nested::of(us, rates)
        })
    }

    /// Returns the lines of the table.
    pub fn lines(self) -> Vec<String> {
        let mut lines = vec![format!(
            "{:34} {:>8} {:>8} {:>8}",
            "estimate, tick with current loop", "hits", "misses", "bar"
        )];
        let mut line = |head: String, values: [String; 2], bar: String| {
            let [hits, misses] = values;
            lines.push(format!("{head:34} {hits:>8} {misses:>8} {bar:>8}"));
        };
        for (rates, is_usual) in
            std::iter::once((USUAL, true)).chain(SHORTEST.map(|rates| (rates, false)))
        {
            let Rates { sample_s, pwm_hz } = rates;
            let nested = self.at(rates);
            let half_us = 0.5e6 * sample_s;
            let (longest, share) = match is_usual {
                true => (format!("{LONGEST_US:.0}"), format!("{LARGEST_SHARE:.0}")),
                false => (format!("{half_us:.0}"), String::new()),
            };
            let at = format!("{} ms, PWM {:.0} kHz:", 1e3 * sample_s, 1e-3 * pwm_hz);
            line(format!("{at} us"), nested.map(|of| format!("{:.2}", of.time_us)), longest);
            let counts = nested.map(|of| of.preemptions.to_string());
            line("  interrupts within it".into(), counts, String::new());
            line(
                "  share of the processor, %".into(),
                nested.map(|of| format!("{:.1}", of.share)),
                share,
            );
        }
        lines
    }

    /// Returns what is over its bar, with misses.
    pub fn over_bars(self) -> Vec<String> {
        let mut over = Vec::new();
        let [_, usual] = self.at(USUAL);
        if usual.time_us > LONGEST_US {
            over.push(format!(
                "a tick with a current loop {:.1} us, allowed {LONGEST_US}",
                usual.time_us
            ));
        }
        if usual.share > LARGEST_SHARE {
            over.push(format!(
                "share of the processor {:.1} %, allowed {LARGEST_SHARE}",
                usual.share
            ));
        }
        for rates in SHORTEST {
            let ([_, nested], half_us) = (self.at(rates), 0.5e6 * rates.sample_s);
            if nested.time_us > half_us {
                over.push(format!(
                    "a tick of {} s takes {:.1} us, allowed {half_us}",
                    rates.sample_s, nested.time_us
                ));
            }
        }
        over
    }
}

/// Returns the largest cycles; none of nothing.
fn most(all: impl Iterator<Item = Cycles>) -> Option<Cycles> {
    all.reduce(|a, b| Cycles { hits: a.hits.max(b.hits), misses: a.misses.max(b.misses) })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// 28 us hold one period of 45.45 us; 44.5 us and one interrupt of 2 us reach into the second;
    /// 90 us hold two, and with them a third.
    #[test]
    fn a_tick_takes_the_interrupts_that_begin_within_it_and_within_them() {
        let rates = Rates { sample_s: 1e-3, pwm_hz: 22e3 };
        for (tick, count) in [(28.0, 1), (43.4, 1), (44.5, 2), (86.8, 2), (87.5, 3)] {
            let nested = Nested::of([tick, 2.0], rates);
            assert_eq!(nested.preemptions, count, "{tick}");
            assert_eq!(nested.time_us, tick + 2.0 * f64::from(count));
        }
        // 2.8 % and 4.4 %.
        let share = Nested::of([28.0, 2.0], rates).share;
        assert!((share - 7.2).abs() < 1e-9, "{share}");
        assert_eq!(Nested::of([28.0, 46.0], rates).time_us, f64::INFINITY);
    }
}
