//! Signals of the device, and the samples of those that the client has subscribed to.

use std::collections::VecDeque;
use std::time::Duration;

use stiction::link::{Announced, Refused, Reply, Request, Sample};

use super::Client;
use crate::device::wire::Wire;
use crate::error::Error;

/// The samples of a subscription, as they come.
#[derive(Debug, Default)]
pub(super) struct Subscription {
    samples: VecDeque<Sample>,
    /// Number that the next sample has if none is lost.
    expected: Option<u32>,
    /// Another subscription was asked for, and its answer has not come yet.
    asked: bool,
    lost: u64,
}

impl Subscription {
    /// Begins anew if this is the answer to a subscription: samples that came before it belong to
    /// the last one, which counts from another number.
    pub(super) fn answered(&mut self) {
        if std::mem::take(&mut self.asked) {
            self.expected = None;
            self.samples.clear();
        }
    }

    /// Keeps a sample, and counts those that are missing before it.
    pub(super) fn push(&mut self, sample: Sample) {
        let expected = self.expected.unwrap_or(sample.number);
        self.lost += u64::from(sample.number.wrapping_sub(expected));
        self.expected = Some(sample.number.wrapping_add(1));
        self.samples.push_back(sample);
    }
}

impl<W: Wire> Client<W> {
    /// Asks for the signals that the device announces, in the order of their places.
    ///
    /// # Errors
    /// Says that the device does not answer.
    pub fn signals(&mut self) -> Result<Vec<Announced>, Error> {
        let mut all = Vec::new();
        for index in 0..=u8::MAX {
            match self.talk(Request::Signal { index })? {
                Reply::Signal(signal) => all.push(signal),
                Reply::Refused(Refused::NoSuch) => break,
                Reply::Refused(refused) => return Err(self.refused("log", &refused)),
                _ => return Err(self.unexpected()),
            }
        }
        Ok(all)
    }

    /// Subscribes to signals, given as a sum of 1 << place, of every `every`-th tick; 0 ends it.
    ///
    /// # Errors
    /// Says that the device does not answer, or that it has no such signal.
    pub fn subscribe(&mut self, signals: u64, every: u16) -> Result<(), Error> {
        self.subscription.asked = true;
        self.done("log", Request::Subscribe { signals, every })
    }

    /// Returns the next sample, and waits for it as long as `at_most`.
    ///
    /// # Errors
    /// Says that the wire is gone.
    pub fn sample(&mut self, at_most: Duration) -> Result<Option<Sample>, Error> {
        if self.subscription.samples.is_empty() {
            let bytes = self.wire.receive(at_most)?;
            self.take(&bytes);
        }
        Ok(self.kept())
    }

    /// Returns the next sample of those that have come already.
    pub fn kept(&mut self) -> Option<Sample> {
        self.subscription.samples.pop_front()
    }

    /// How many samples did not arrive, as far as later ones have shown.
    pub const fn lost(&self) -> u64 {
        self.subscription.lost
    }
}
