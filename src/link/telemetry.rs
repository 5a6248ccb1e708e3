//! Terms of ticks, for those who have subscribed.

use heapless::Vec;

use super::sample::{Sample, Term};
use crate::servo::{Output, State};

/// What is sent, and how often.
#[derive(Clone, Copy, Debug, Default)]
pub struct Subscription {
    terms: u16,
    every: u16,
    /// Ticks until the next one.
    due: u16,
    number: u32,
}

impl Subscription {
    /// Nothing is sent.
    pub const NONE: Self = Self { terms: 0, every: 0, due: 0, number: 0 };

    /// `terms` of every so many ticks, from the next one on; none if a term is not known, or there are none.
    pub fn new(terms: u16, every: u16) -> Option<Self> {
        let known = Term::ALL.iter().fold(0, |bits, term| bits | term.bit());
        if every == 0 {
            return Some(Self::default());
        }
        (terms != 0 && terms & !known == 0).then_some(Self { terms, every, due: 0, number: 0 })
    }

    /// Takes a tick, and returns a sample if one is due.
    pub fn tick(&mut self, output: &Output) -> Option<Sample> {
        if self.every == 0 {
            return None;
        }
        if self.due > 0 {
            self.due -= 1;
            return None;
        }
        self.due = self.every - 1;
        let mut values = Vec::new();
        for term in Term::ALL.into_iter().filter(|term| self.terms & term.bit() != 0) {
            // Cannot fail: there is room for more terms than there are.
            let _ = values.extend_from_slice(&value(term, output));
        }
        let number = self.number;
        self.number = number.wrapping_add(1);
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
