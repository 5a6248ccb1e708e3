//! Signals of the device, and the samples of subscribed signals.

use std::collections::VecDeque;
use std::time::Duration;

use stiction::link::{Reply, Request, RequestRefusal, Sample, SignalDescription};

use super::Client;
use crate::device::wire::Wire;
use files::error::Error;

/// Received samples of a subscription.
#[derive(Debug, Default)]
pub(super) struct Subscription {
    samples: VecDeque<Sample>,
    /// Number of the next sample if none is lost.
    expected: Option<u32>,
    /// Whether a new subscription was requested and not yet answered.
    asked: bool,
    lost: u64,
}

impl Subscription {
    /// Clears the samples if the answer is that to a subscription: earlier samples belong to the
    /// previous subscription, which numbers them differently.
    pub(super) fn answered(&mut self) {
        if std::mem::take(&mut self.asked) {
            self.expected = None;
            self.samples.clear();
        }
    }

    /// Stores a sample, and counts the missing ones before it.
    pub(super) fn push(&mut self, sample: Sample) {
        let expected = self.expected.unwrap_or(sample.number);
        self.lost += u64::from(sample.number.wrapping_sub(expected));
        self.expected = Some(sample.number.wrapping_add(1));
        self.samples.push_back(sample);
    }
}

impl<W: Wire> Client<W> {
    /// Reads the signals that the device announces, in the order of their places.
    ///
    /// # Errors
    /// Returns an error if the device does not answer.
    pub fn signals(&mut self) -> Result<Vec<SignalDescription>, Error> {
        let mut all = Vec::new();
        for index in 0..=u8::MAX {
            match self.talk(Request::Signal { index })? {
                Reply::Signal(signal) => all.push(signal),
                Reply::Refused(RequestRefusal::NoSuch) => break,
                Reply::Refused(refused) => return Err(self.refused("log", &refused)),
                _ => return Err(self.unexpected()),
            }
        }
        Ok(all)
    }

    /// Subscribes to the signals of a mask (the sum of 1 << place), in every `every`-th tick; 0
    /// ends the subscription.
    ///
    /// # Errors
    /// Returns an error if the device does not answer or has no such signal.
    pub fn subscribe(&mut self, signals: u64, every: u16) -> Result<(), Error> {
        self.subscription.asked = true;
        self.done("log", Request::Subscribe { signals, every })
    }

    /// Returns the next sample; waits for it up to `at_most`.
    ///
    /// # Errors
    /// Returns an error if the wire is gone.
    pub fn sample(&mut self, at_most: Duration) -> Result<Option<Sample>, Error> {
        if self.subscription.samples.is_empty() {
            let bytes = self.wire.receive(at_most)?;
            self.take(&bytes);
        }
        Ok(self.kept())
    }

    /// Returns the next sample that has already arrived.
    pub fn kept(&mut self) -> Option<Sample> {
        self.subscription.samples.pop_front()
    }

    /// Returns the number of lost samples, by the gaps in the numbers of those received.
    pub const fn lost(&self) -> u64 {
        self.subscription.lost
    }
}
