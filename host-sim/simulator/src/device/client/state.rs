//! State and faults of the device, and waits with a keep-alive.

use std::sync::atomic::Ordering;
use std::time::Duration;

use stiction::link::{FaultReport, Reply, Request, RequestRefusal, StateCode, Status};

use super::Client;
use super::exchange::PATIENCE;
use crate::device::wire::Wire;
use files::error::Error;

/// Longest time between two requests of a waiting client: a fifth of the default link timeout.
const SIGN_OF_LIFE: Duration = Duration::from_millis(100);

/// Time between two status requests during a stop.
const STOP_POLL: Duration = Duration::from_millis(20);

/// More than the longest `device.stop_s` and `device.brake_close_s`.
const LONGEST_STOP: Duration = Duration::from_secs(20);

/// More than the longest time of a jog, whose bounds a test at arming has.
const LONGEST_TEST: Duration = Duration::from_secs(80);

impl<W: Wire> Client<W> {
    /// Reads the state of the device.
    ///
    /// # Errors
    /// Returns an error if the device does not answer.
    pub fn status(&mut self) -> Result<Status, Error> {
        match self.ask(Request::Status)? {
            Reply::Status(status) => Ok(status),
            _ => Err(self.unexpected()),
        }
    }

    /// Reads the faults that the device has stored, the oldest first.
    ///
    /// # Errors
    /// Returns an error if the device does not answer.
    pub fn faults(&mut self) -> Result<Vec<FaultReport>, Error> {
        let mut faults = Vec::new();
        for index in 0..stiction::safety::fault::HISTORY as u8 {
            match self.talk(Request::Fault { index })? {
                Reply::Fault(fault) => faults.push(fault),
                Reply::Refused(RequestRefusal::NoSuch) => break,
                Reply::Refused(refused) => return Err(self.refused("faults", &refused)),
                _ => return Err(self.unexpected()),
            }
        }
        Ok(faults)
    }

    /// Clears the latched fault.
    ///
    /// # Errors
    /// Returns why the fault cannot be cleared.
    pub fn clear(&mut self) -> Result<(), Error> {
        self.done("faults --clear", Request::Clear)
    }

    /// Waits for a time on the device's clock, keeps the link alive, and stores the samples that
    /// arrive.
    ///
    /// # Errors
    /// Returns an error if the device does not answer, or if Ctrl-C ended the wait
    /// ([`end_on`](Self::end_on)).
    pub fn pass(&mut self, time: Duration) -> Result<Status, Error> {
        self.pass_while(time, |_| true)
    }

    /// Waits as [`pass`](Self::pass) does, but only while the device is armed.
    ///
    /// # Errors
    /// Returns an error if the device does not answer.
    pub fn pass_armed(&mut self, time: Duration) -> Result<Status, Error> {
        self.pass_while(time, |status| status.state == StateCode::Armed)
    }

    /// Waits until the joint is at rest, for a second at most.
    ///
    /// # Errors
    /// Returns an error if the device does not answer.
    pub fn wait_at_rest(&mut self) -> Result<Status, Error> {
        self.pass_while(Duration::from_secs(1), |status| !status.at_rest)
    }

    /// Waits for the end of a test at arming.
    pub(super) fn pass_test(&mut self) -> Result<Status, Error> {
        self.pass_while(LONGEST_TEST, |status| status.is_testing)
    }

    /// Waits until the output is off. Ctrl-C does not end this wait, since it can be the cause of
    /// the stop.
    pub(super) fn wait_until_off(&mut self) -> Result<(), Error> {
        let started = self.wire.now();
        while self.status()?.state == StateCode::Armed {
            if self.wire.now() - started > LONGEST_STOP {
                return Err(Error::Device(
                    "stop: the output is still on; turn the supply off (docs/reference/link.md)"
                        .into(),
                ));
            }
            let bytes = self.wire.receive(STOP_POLL)?;
            self.take(&bytes);
        }
        Ok(())
    }

    fn pass_while(
        &mut self,
        time: Duration,
        go_on: impl Fn(&Status) -> bool,
    ) -> Result<Status, Error> {
        let mut status = self.status()?;
        let device_s = |status: &Status| f64::from(status.clock) * f64::from(status.sample_time);
        let (begin, started) = (device_s(&status), self.wire.now());
        loop {
            let on_the_wire = self.wire.now() - started;
            // The device's clock counts, since a simulated device has its own. The wire's clock
            // counts for a device without parameters, and limits the wait for one that has stopped.
            let passed = if status.sample_time > 0.0 && on_the_wire < 2 * time + PATIENCE {
                device_s(&status) - begin
            } else {
                on_the_wire.as_secs_f64()
            };
            let left = time.as_secs_f64() - passed;
            if left <= 0.0 || !go_on(&status) {
                return Ok(status);
            }
            if self.interrupt.as_ref().is_some_and(|interrupt| interrupt.load(Ordering::Relaxed)) {
                return Err(Error::CtrlC("ended by Ctrl-C".into()));
            }
            let bytes =
                self.wire.receive(SIGN_OF_LIFE.min(Duration::from_secs_f64(left.max(0.001))))?;
            self.take(&bytes);
            status = self.status()?;
        }
    }
}
