//! The telemetry: samples of the signals that a client has subscribed to.

use heapless::Vec;

use super::sample::{MAX_SIGNALS, Sample};
use crate::control::signal;
use crate::servo::Output;

/// A subscription: which signals are sent, and how often.
#[derive(Clone, Copy, Debug, Default)]
pub struct Subscription {
    signals: u64,
    every: u16,
    /// The tick of the next sample; none: the next tick.
    next: Option<u32>,
    number: u32,
}

impl Subscription {
    /// The subscription of a client that receives no samples.
    pub const NONE: Self = Self { signals: 0, every: 0, next: None, number: 0 };

    /// Returns a subscription to `signals` of every `every`-th tick, from the next one on; for 0,
    /// one without samples. Returns none if no signal is requested, or if one of them is not among
    /// the first `known`.
    pub fn new(signals: u64, every: u16, known: usize) -> Option<Self> {
        if every == 0 {
            return Some(Self::NONE);
        }
        let unknown = u64::MAX.checked_shl(known as u32).unwrap_or(0);
        (signals != 0 && signals & unknown == 0).then_some(Self {
            signals,
            every,
            next: None,
            number: 0,
        })
    }

    /// Returns the sample of a tick if one is due. Ticks may be missing; the sample's number also
    /// counts the samples that were due in them.
    pub fn sample(&mut self, output: &Output) -> Option<Sample> {
        let every = u32::from(self.every);
        let since = output.clock.wrapping_sub(self.next.unwrap_or(output.clock));
        // There is no subscription, or it is not time yet.
        let (due, is_due) = (since.checked_div(every)?, since.checked_rem(every)? == 0);
        if since > u32::MAX / 2 {
            return None;
        }
        // The number grows by the samples that were due before this tick.
        self.number = self.number.wrapping_add(if is_due { due } else { due + 1 });
        let number = self.number;
        let ahead = if is_due { every } else { every - since % every };
        self.next = Some(output.clock.wrapping_add(ahead));
        if !is_due {
            return None;
        }
        self.number = number.wrapping_add(1);
        let mut values = Vec::new();
        for place in (0..MAX_SIGNALS).filter(|place| self.signals >> place & 1 != 0) {
            let bits = signal::value(&output.tick, place).unwrap_or_default();
            // Cannot fail: there is room for every place.
            let _ = values.extend_from_slice(&bits.to_le_bytes());
        }
        Some(Sample { number, clock: output.clock, signals: self.signals, values })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::control::signal::Tick;
    use crate::servo::State;

    fn numbers(ticks: impl IntoIterator<Item = u32>) -> heapless::Vec<(u32, u32), 16> {
        let mut subscription = Subscription::new(1, 3, 1).unwrap();
        let sample = |clock| {
            let (state, tick) = (State::Stopped, Tick::default());
            let output =
                Output { enable: false, wakes: false, state, tick, clock, wound_up: false };
            subscription.sample(&output).map(|sample| (sample.number, sample.clock))
        };
        ticks.into_iter().filter_map(sample).collect()
    }

    #[test]
    fn every_third_tick_is_a_sample_across_the_end_of_the_clock() {
        let clocks = (0..10u32).map(|i| (u32::MAX - 4).wrapping_add(i));
        assert_eq!(numbers(clocks), [(0, u32::MAX - 4), (1, u32::MAX - 1), (2, 1), (3, 4)]);
    }

    #[test]
    fn samples_of_ticks_that_never_came_count() {
        // Due at 10, 13, 16, 19, 22: those at 13 and 16 never come, nor that at 22.
        assert_eq!(numbers([10, 11, 12, 17, 18, 19, 20, 23, 24, 25]), [(0, 10), (3, 19), (5, 25)]);
        // One that is due comes right after the gap.
        assert_eq!(numbers([10, 16, 17]), [(0, 10), (2, 16)]);
    }
}
