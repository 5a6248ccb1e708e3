//! Requests that arm, move and stop the joint.

use stiction::identification::{self, MapPoint, SPEEDS, Summary};
use stiction::jog::{Asked, Found};
use stiction::link::{Reply, Request};
use stiction::position::Position;
use stiction::servo::Levels;
use stiction::{Motion, Parameters};

use super::Client;
use crate::device::moved::longest_s;
use crate::device::wire::Wire;
use crate::error::Error;

/// The map of the friction: each speed in both senses, the fastest first.
pub type Map = [[MapPoint; 2]; SPEEDS];

impl<W: Wire> Client<W> {
    /// Closes the loop where the joint is. From now on the device has to hear from the client
    /// within its link timeout.
    ///
    /// # Errors
    /// Says why the device refuses.
    pub fn arm(&mut self) -> Result<(), Error> {
        self.done("arm", Request::Arm)
    }

    /// Turns the output off.
    ///
    /// # Errors
    /// Says that the device does not answer.
    pub fn stop(&mut self) -> Result<(), Error> {
        self.done("stop", Request::Stop)
    }

    /// Stops the joint; the loop stays closed. A profiled move slows down within its limits, and
    /// any other joint stays where it is.
    ///
    /// # Errors
    /// Says why the device refuses.
    pub fn hold(&mut self) -> Result<(), Error> {
        self.done("move", Request::Move(Motion::Hold))
    }

    /// Steps to a position (deg), counted from the zero that arming has set.
    ///
    /// # Errors
    /// Says why the device refuses.
    pub fn step_to(&mut self, deg: f64) -> Result<(), Error> {
        let motion = self.step(deg)?;
        self.move_along(motion)
    }

    /// Moves to a position (deg), counted from the zero that arming has set, within the limits of
    /// the device's profile.
    ///
    /// # Errors
    /// Says why the device refuses.
    pub fn move_to(&mut self, deg: f64) -> Result<(), Error> {
        let motion = self.profiled(deg)?;
        self.move_along(motion)
    }

    /// Turns a profiled move to a position (deg) into counts, for
    /// [`move_along`](Self::move_along).
    ///
    /// # Errors
    /// Says that there is no such position.
    pub fn profiled(&mut self, deg: f64) -> Result<Motion, Error> {
        self.counted(deg).map(Motion::Profiled)
    }

    /// Turns a step to a position (deg) into counts, for [`move_along`](Self::move_along).
    ///
    /// # Errors
    /// Says that there is no such position.
    pub fn step(&mut self, deg: f64) -> Result<Motion, Error> {
        self.counted(deg).map(Motion::Step)
    }

    /// Asks for the longest time that a profiled move over so many degrees takes until its set
    /// point rests, s: if the device has just been armed, its driver wakes up before it, and it
    /// waits for the soft start.
    ///
    /// # Errors
    /// Says that the device has no parameters.
    pub fn longest_s(&mut self, deg: f64) -> Result<f64, Error> {
        let Parameters { profile, device, .. } = self.parameters()?;
        let waits = [device.reset_pulse, device.wake_up, device.soft_start].map(f64::from);
        Ok(longest_s(&profile, deg) + waits.iter().sum::<f64>())
    }

    fn counted(&mut self, deg: f64) -> Result<Position, Error> {
        position_of(deg, self.status()?.resolution.into())
    }

    /// Begins a motion, whose positions are counted from the zero that arming has set.
    ///
    /// # Errors
    /// Says why the device refuses.
    pub fn move_along(&mut self, motion: Motion) -> Result<(), Error> {
        self.done("move", Request::Move(motion))
    }

    /// Arms and begins a ramp of the effort, which rises by `rate` (V/s) until the joint moves, is
    /// held for `hold` (s) and falls again. The ramp ends by itself, and [`levels`](Self::levels)
    /// says what it has found. Meanwhile the device has to hear from the client within its link
    /// timeout.
    ///
    /// # Errors
    /// Says why the device refuses.
    pub fn identify(&mut self, rate: f32, hold: f32) -> Result<(), Error> {
        self.done("identify", Request::Identify { rate, hold })
    }

    /// Arms and begins a jog, within the bounds of the device and those that are asked for. The jog
    /// ends by itself, and [`jogged`](Self::jogged) says what it has found. Meanwhile the device
    /// has to hear from the client within its link timeout.
    ///
    /// # Errors
    /// Says why the device refuses.
    pub fn jog(&mut self, asked: Asked) -> Result<(), Error> {
        self.done("jog", Request::Jog(asked))
    }

    /// What the last jog has found; none before it is over, and none if something else ended it.
    ///
    /// # Errors
    /// Says that the device does not answer.
    pub fn jogged(&mut self) -> Result<Option<Found>, Error> {
        match self.ask(Request::ReadJog)? {
            Reply::Jog(found) => Ok(found),
            _ => Err(self.unexpected()),
        }
    }

    /// Arms and begins an identification, within the bounds that are asked for and the device's. It
    /// ends by itself, and [`identified`](Self::identified) says what it has found. Meanwhile the
    /// device has to hear from the client within its link timeout.
    ///
    /// # Errors
    /// Says why the device refuses.
    pub fn identify_joint(&mut self, asked: identification::Asked) -> Result<(), Error> {
        self.done("identify", Request::IdentifyJoint(asked))
    }

    /// What the last identification has found; none before it is over, and none if something else
    /// ended it.
    ///
    /// # Errors
    /// Says that the device does not answer.
    pub fn identified(&mut self) -> Result<Option<(Summary, Map)>, Error> {
        let Reply::Identification(summary) = self.ask(Request::ReadIdentification)? else {
            return Err(self.unexpected());
        };
        match self.ask(Request::ReadMap)? {
            Reply::Map(map) => Ok(summary.zip(map)),
            _ => Err(self.unexpected()),
        }
    }

    /// The efforts (V) that the last ramp has found; none before the ramp is over.
    ///
    /// # Errors
    /// Says that the device does not answer.
    pub fn levels(&mut self) -> Result<Option<Levels>, Error> {
        match self.ask(Request::ReadLevels)? {
            Reply::Levels(levels) => Ok(levels),
            _ => Err(self.unexpected()),
        }
    }
}

/// Turns an angle (deg) into the counts of an encoder, of which one is so many deg.
///
/// # Errors
/// Says that there is no such position.
pub fn position_of(deg: f64, resolution_deg: f64) -> Result<Position, Error> {
    let counts = deg / resolution_deg;
    // 2^30 counts, as for steps of a machine's file.
    if !counts.is_finite() || counts.abs() > f64::from(1 << 30) {
        return Err(Error::Input(format!("move {deg}: allowed is a position within 2^30 counts")));
    }
    Ok(crate::experiment::position(counts))
}
