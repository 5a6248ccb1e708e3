//! Terms of ticks, for those who have subscribed.

use heapless::Vec;

use super::sample::{Sample, Term};
use crate::servo::{Output, State};

/// What is sent, and how often.
#[derive(Clone, Copy, Debug, Default)]
pub struct Subscription {
    terms: u16,
    every: u16,
    /// The tick of the next sample; none: the next one that comes.
    next: Option<u32>,
    number: u32,
}

impl Subscription {
    /// Nothing is sent.
    pub const NONE: Self = Self { terms: 0, every: 0, next: None, number: 0 };

    /// `terms` of every so many ticks, from the next one on; none if a term is not known, or there are none.
    pub fn new(terms: u16, every: u16) -> Option<Self> {
        let known = Term::ALL.iter().fold(0, |bits, term| bits | term.bit());
        if every == 0 {
            return Some(Self::NONE);
        }
        (terms != 0 && terms & !known == 0).then_some(Self { terms, every, next: None, number: 0 })
    }

    /// Takes a tick, and returns a sample if one is due. Ticks may be missing; samples that were due in them count, too.
    pub fn tick(&mut self, output: &Output) -> Option<Sample> {
        let every = u32::from(self.every);
        let since = output.clock.wrapping_sub(self.next.unwrap_or(output.clock));
        // Nobody has subscribed, or it is not time yet.
        let (due, is_due) = (since.checked_div(every)?, since.checked_rem(every)? == 0);
        if since > u32::MAX / 2 {
            return None;
        }
        // Those that were due before this tick.
        self.number = self.number.wrapping_add(if is_due { due } else { due + 1 });
        let number = self.number;
        let ahead = if is_due { every } else { every - since % every };
        self.next = Some(output.clock.wrapping_add(ahead));
        if !is_due {
            return None;
        }
        self.number = number.wrapping_add(1);
        let mut values = Vec::new();
        for term in Term::ALL.into_iter().filter(|term| self.terms & term.bit() != 0) {
            // Cannot fail: there is room for more terms than there are.
            let _ = values.extend_from_slice(&value(term, output));
        }
        Some(Sample { number, clock: output.clock, terms: self.terms, values })
    }
}

fn value(term: Term, output: &Output) -> [u8; 4] {
    let tick = &output.tick;
    let (setpoint, duty) = (&tick.setpoint, output.duty);
    match term {
        Term::SetpointCounts => setpoint.position.counts.to_le_bytes(),
        Term::SetpointFraction => setpoint.position.fraction.to_le_bytes(),
        Term::SetpointVelocity => setpoint.velocity.to_le_bytes(),
        Term::Counts => tick.counts.to_le_bytes(),
        Term::Error => tick.error.to_le_bytes(),
        Term::Velocity => tick.velocity.to_le_bytes(),
        Term::Pd => tick.v_pd.to_le_bytes(),
        Term::Compensator => tick.v_c.to_le_bytes(),
        Term::Output => tick.v.to_le_bytes(),
        Term::Code => i32::from(tick.code).to_le_bytes(),
        Term::Duty => {
            let compare = i32::from(duty.compare);
            (if duty.reverse { -compare } else { compare }).to_le_bytes()
        }
        Term::Flags => flags(output).to_le_bytes(),
    }
}

fn flags(output: &Output) -> u32 {
    let (state, fault) = match output.state {
        State::Boot => (0, 0),
        State::Stopped => (1, 0),
        State::Armed => (2, 0),
        State::Faulted(fault) => (3, fault as u32),
    };
    let bit = |set: bool, place: u32| u32::from(set) << place;
    state | fault << 8 | bit(output.tick.saturated, 16) | bit(output.wound_up, 17) | bit(output.enable, 18)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::controller::Tick;
    use crate::drive::Duty;

    fn numbers(ticks: impl IntoIterator<Item = u32>) -> heapless::Vec<(u32, u32), 16> {
        let mut subscription = Subscription::new(Term::Counts.bit(), 3).unwrap();
        let sample = |clock| {
            let (duty, state, tick) = (Duty::default(), State::Stopped, Tick::default());
            let output = Output { enable: false, duty, state, tick, clock, wound_up: false };
            subscription.tick(&output).map(|sample| (sample.number, sample.clock))
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
