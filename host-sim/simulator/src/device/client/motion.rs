//! Requests that arm, move and stop the joint.

use stiction::identification::{self, LEAST_TRAVEL_COUNTS, MapPoint, SPEEDS, Summary};
use stiction::link::{Reply, Request, RequestRefusal, StateCode};
use stiction::motion::home::{HomeFindings, HomeRequest};
use stiction::motion::jog::{JogFindings, JogRequest};
use stiction::motion::winding::{WindingFindings, WindingRequest};
use stiction::servo::FrictionLevels;
use stiction::units::position::Position;
use stiction::{Limits, Motion, Parameters};

use super::Client;
use crate::device::moved::longest_s;
use crate::device::wire::Wire;
use crate::device::words;
use files::error::{Error, rounded, shown};

/// Friction map: a row for each speed, the fastest first, with a point for each direction.
pub type Map = [[MapPoint; 2]; SPEEDS];

impl<W: Wire> Client<W> {
    /// Arms the device: the loop closes at the present position of the joint. From then on the
    /// pause between two requests of the client must be shorter than the device's link timeout.
    ///
    /// # Errors
    /// Returns why the device refuses.
    pub fn arm(&mut self) -> Result<(), Error> {
        self.done("arm", Request::Arm)
    }

    /// Arms the device as [`arm`](Self::arm) does, and waits for the end of a test at arming.
    ///
    /// # Errors
    /// Returns why the device refuses, or the fault that the test has found.
    pub fn arm_tested(&mut self) -> Result<(), Error> {
        self.arm()?;
        let status = self.pass_test()?;
        if status.has_failed_test {
            let (of, remedy) = (&status.fault, words::remedy(status.fault.code, words::CLEAR));
            return Err(Error::Device(format!(
                "arm: {}; {}; {remedy}",
                words::fault(of, status.sample_time),
                words::IN_THE_TEST
            )));
        }
        Ok(())
    }

    /// Brakes the joint, and waits until the output is off.
    ///
    /// # Errors
    /// Returns an error if the device does not answer.
    pub fn stop(&mut self) -> Result<(), Error> {
        self.done("stop", Request::Stop)?;
        self.wait_until_off()
    }

    /// Stops the joint; the loop stays closed. A profiled move slows down within its limits;
    /// without one, the joint holds its position.
    ///
    /// # Errors
    /// Returns why the device refuses.
    pub fn hold(&mut self) -> Result<(), Error> {
        self.done("move", Request::Move(Motion::Hold))
    }

    /// Steps the set point to a position (deg), counted from the zero that arming has set.
    ///
    /// # Errors
    /// Returns why the device refuses.
    pub fn step_to(&mut self, deg: f64) -> Result<(), Error> {
        let motion = self.step(deg)?;
        self.move_along(motion)
    }

    /// Moves to a position (deg), counted from the zero that arming has set, within the limits of
    /// the device's profile.
    ///
    /// # Errors
    /// Returns why the device refuses.
    pub fn move_to(&mut self, deg: f64) -> Result<(), Error> {
        let motion = self.profiled(deg)?;
        self.move_along(motion)
    }

    /// Returns a profiled move to a position (deg), in counts, for
    /// [`move_along`](Self::move_along).
    ///
    /// # Errors
    /// Returns an error if the position is out of range.
    pub fn profiled(&mut self, deg: f64) -> Result<Motion, Error> {
        self.counted(deg).map(Motion::Profiled)
    }

    /// Returns a step to a position (deg), in counts, for [`move_along`](Self::move_along).
    ///
    /// # Errors
    /// Returns an error if the position is out of range.
    pub fn step(&mut self, deg: f64) -> Result<Motion, Error> {
        self.counted(deg).map(Motion::Step)
    }

    /// Returns the longest time from arming until the set point of a profiled move over `deg` (deg)
    /// rests, s. It includes the reset pulse and the wake-up of the driver, the soft start, and the
    /// opening of a holding brake.
    ///
    /// # Errors
    /// Returns an error if the device has no parameters.
    pub fn longest_s(&mut self, deg: f64) -> Result<f64, Error> {
        let Parameters { profile, device, .. } = self.parameters()?;
        let of_driver = device.reset_pulse + device.wake_up;
        let waits = of_driver + device.soft_start + device.brake_open;
        Ok(longest_s(&profile, deg) + f64::from(waits))
    }

    fn counted(&mut self, deg: f64) -> Result<Position, Error> {
        position_of(deg, self.status()?.resolution.into())
    }

    /// Checks whether the target of a step or a profiled move is within the limits of travel of a
    /// stopped device, before it is armed. All other motions pass, and so do all moves in any other
    /// state of the device. Nothing is armed.
    ///
    /// # Errors
    /// Returns why the device would refuse, or that it does not answer.
    pub fn check_move(&mut self, motion: &Motion) -> Result<(), Error> {
        let (Motion::Step(to) | Motion::Profiled(to)) = motion else { return Ok(()) };
        let status = self.status()?;
        if status.state == StateCode::Stopped
            && leads_out(&self.parameters()?, status.position, *to)
        {
            return Err(self.out_of_range());
        }
        Ok(())
    }

    /// Starts a motion. Its positions count from the zero of the arming.
    ///
    /// # Errors
    /// Returns why the device refuses.
    pub fn move_along(&mut self, motion: Motion) -> Result<(), Error> {
        match self.talk(Request::Move(motion))? {
            Reply::Done => Ok(()),
            Reply::Refused(RequestRefusal::OutOfRange) => Err(self.out_of_range()),
            Reply::Refused(refused) => Err(self.refused("move", &refused)),
            _ => Err(self.unexpected()),
        }
    }

    /// Returns the error for a motion that leaves the limits of travel, with these limits if the
    /// device still answers.
    fn out_of_range(&mut self) -> Error {
        let error = self.refused("move", &RequestRefusal::OutOfRange);
        let Ok(Parameters { limits, .. }) = self.parameters() else { return error };
        let [min, max] = [limits.position_min, limits.position_max].map(files::written::single);
        let range = format!("{} to {} deg from the reference", shown(min), shown(max));
        Error::Refused(format!("{error}; the range is {range}"))
    }

    /// Arms and starts a ramp: the effort rises by `rate` (V/s) until the joint moves, is held for
    /// `hold` (s) and falls again. The ramp ends automatically; [`levels`](Self::levels) returns
    /// its result. Meanwhile the client must send a request within the device's link timeout.
    ///
    /// # Errors
    /// Returns why the device refuses.
    pub fn identify(&mut self, rate: f32, hold: f32) -> Result<(), Error> {
        self.done("identify", Request::Identify { rate, hold })
    }

    /// Arms and starts a jog, within the limits of the device and those of the request. The jog
    /// ends automatically; [`jogged`](Self::jogged) returns its result. Meanwhile the client must
    /// send a request within the device's link timeout.
    ///
    /// # Errors
    /// Returns why the device refuses.
    pub fn jog(&mut self, asked: JogRequest) -> Result<(), Error> {
        self.done("jog", Request::Jog(asked))
    }

    /// Arms and starts a homing, within the limits of the device and those of the request. The
    /// homing ends automatically; [`homed`](Self::homed) returns its result. Meanwhile the client
    /// must send a request within the device's link timeout.
    ///
    /// # Errors
    /// Returns why the device refuses.
    pub fn home(&mut self, asked: HomeRequest) -> Result<(), Error> {
        self.done("home", Request::Home(asked))
    }

    /// Returns the result of the last homing; `None` before its end or if it was interrupted.
    ///
    /// # Errors
    /// Returns an error if the device does not answer.
    pub fn homed(&mut self) -> Result<Option<HomeFindings>, Error> {
        match self.ask(Request::ReadHome)? {
            Reply::Home(found) => Ok(found),
            _ => Err(self.unexpected()),
        }
    }

    /// Arms and starts a measurement of the winding, which ends automatically;
    /// [`winding`](Self::winding) returns its result. Meanwhile the client must send a request
    /// within the device's link timeout.
    ///
    /// # Errors
    /// Returns why the device refuses.
    pub fn measure_winding(&mut self, asked: WindingRequest) -> Result<(), Error> {
        self.done("winding", Request::MeasureWinding(asked))
    }

    /// Returns the result of the last measurement of the winding; `None` before its end or if it
    /// was interrupted.
    ///
    /// # Errors
    /// Returns an error if the device does not answer.
    pub fn winding(&mut self) -> Result<Option<WindingFindings>, Error> {
        match self.ask(Request::ReadWinding)? {
            Reply::Winding(found) => Ok(found),
            _ => Err(self.unexpected()),
        }
    }

    /// Converts a position of the joint (deg) to counts, for a request that sets the reference.
    /// `what` is the command, for messages.
    ///
    /// # Errors
    /// Returns an error for a position that is not finite or 2^30 counts away or more.
    pub fn counts_of(&mut self, what: &str, deg: f64) -> Result<i32, Error> {
        let resolution = f64::from(self.status()?.resolution);
        if resolution <= 0.0 {
            return Err(self.refused(what, &RequestRefusal::NoParameters));
        }
        let counts = deg / resolution;
        if !counts.is_finite() || counts.abs() >= f64::from(1 << 30) {
            let furthest = shown(f64::from(1 << 30) * resolution);
            return Err(Error::Input(format!(
                "{what} --at {deg}: it must be a number within {furthest} deg, 2^30 counts"
            )));
        }
        Ok(counts.round() as i32)
    }

    /// Sets the present position of the joint (deg), from which its range counts. The output must
    /// be off and the joint at rest.
    ///
    /// # Errors
    /// Returns why the device refuses.
    pub fn set_reference(&mut self, deg: f64) -> Result<(), Error> {
        let position = self.counts_of("reference", deg)?;
        self.done("reference", Request::SetReference { position })
    }

    /// Returns the result of the last jog; `None` before its end or if it was interrupted.
    ///
    /// # Errors
    /// Returns an error if the device does not answer.
    pub fn jogged(&mut self) -> Result<Option<JogFindings>, Error> {
        match self.ask(Request::ReadJog)? {
            Reply::Jog(found) => Ok(found),
            _ => Err(self.unexpected()),
        }
    }

    /// Returns the request of an identification that fits between the limits of travel: if the
    /// request has no travel and the default is too long, the travel ends at the nearer limit.
    /// Nothing moves. [`identify_joint`](Self::identify_joint) does not check this: the check takes
    /// several exchanges, and the caller can do other checks before arming.
    ///
    /// # Errors
    /// Returns why the identification does not fit, the speed limit that the encoder needs, or that
    /// the device does not answer.
    pub fn check_identification(
        &mut self,
        asked: &identification::IdentificationRequest,
    ) -> Result<identification::IdentificationRequest, Error> {
        let parameters = self.parameters()?;
        let position = self.status()?.position;
        let fitted = fits(asked, &parameters, position).map_err(Error::Refused)?;
        let why = shows_too_little(&fitted, &parameters);
        why.map_or(Ok(fitted), |why| Err(Error::Refused(why)))
    }

    /// Arms and starts an identification, within the limits of the request and of the device. It
    /// ends automatically; [`identified`](Self::identified) returns its result. Meanwhile the
    /// client must send a request within the device's link timeout.
    ///
    /// # Errors
    /// Returns why the device refuses.
    pub fn identify_joint(
        &mut self,
        asked: identification::IdentificationRequest,
    ) -> Result<(), Error> {
        self.done("identify", Request::IdentifyJoint(asked))
    }

    /// Returns the result of the last identification; `None` before its end or if it was
    /// interrupted.
    ///
    /// # Errors
    /// Returns an error if the device does not answer.
    pub fn identified(&mut self) -> Result<Option<(Summary, Map)>, Error> {
        let Reply::Identification(summary) = self.ask(Request::ReadIdentification)? else {
            return Err(self.unexpected());
        };
        match self.ask(Request::ReadMap)? {
            Reply::Map(map) => Ok(summary.zip(map)),
            _ => Err(self.unexpected()),
        }
    }

    /// Returns the efforts (V) that the last ramp has measured; `None` before its end.
    ///
    /// # Errors
    /// Returns an error if the device does not answer.
    pub fn levels(&mut self) -> Result<Option<FrictionLevels>, Error> {
        match self.ask(Request::ReadLevels)? {
            Reply::Levels(levels) => Ok(levels),
            _ => Err(self.unexpected()),
        }
    }
}

/// Converts an angle (deg) to counts of an encoder with the given resolution (deg).
///
/// # Errors
/// Returns an error if the position is out of range.
pub fn position_of(deg: f64, resolution_deg: f64) -> Result<Position, Error> {
    let counts = deg / resolution_deg;
    // 2^30 counts, as for steps of a machine's file.
    if !counts.is_finite() || counts.abs() > f64::from(1 << 30) {
        return Err(Error::Input(format!("move {deg}: the position must be within 2^30 counts")));
    }
    Ok(crate::experiment::position(counts))
}

/// Returns whether a target is outside the limits of travel of a device that is armed at `zero`,
/// counts from the reference. False if the joint itself is outside: the device then refuses to arm.
fn leads_out(parameters: &Parameters, zero: i32, to: Position) -> bool {
    let Limits { position_min, position_max, .. } = parameters.limits;
    if position_min == 0.0 && position_max == 0.0 {
        return false;
    }
    let resolution = parameters.controller.encoder.resolution;
    let counts = |deg: f32| (deg / resolution).round() as i32;
    let range = counts(position_min)..=counts(position_max);
    range.contains(&zero) && !range.contains(&zero.wrapping_add(to.counts))
}

/// Returns the request of an identification that fits between the limits of travel around a joint
/// at `position`, counts from the reference; a default travel is shortened if necessary. The device
/// checks all other bounds, and a joint that is outside its limits.
///
/// # Errors
/// Returns the distance to the nearer limit, and the travel that is allowed or needed.
fn fits(
    asked: &identification::IdentificationRequest,
    parameters: &Parameters,
    position: i32,
) -> Result<identification::IdentificationRequest, String> {
    let Limits { position_min, position_max, .. } = parameters.limits;
    let Ok(settings) = parameters.identify(asked) else { return Ok(*asked) };
    if position_min == 0.0 && position_max == 0.0 {
        return Ok(*asked);
    }
    let resolution = parameters.controller.encoder.resolution;
    // Counts as the device rounds them.
    let counts = |deg: f32| i64::from((deg / resolution).round() as i32);
    let here = i64::from(position);
    let room = (counts(position_max) - here).min(here - counts(position_min));
    if room < 0 || i64::from(settings.travel()) <= room {
        return Ok(*asked);
    }
    let room_deg = room as f32 * resolution;
    let shorter = identification::IdentificationRequest { travel: Some(room_deg), ..*asked };
    let is_possible = parameters.identify(&shorter).is_ok();
    if is_possible && asked.travel.is_none() {
        return Ok(shorter);
    }
    let deg = |deg: f32| rounded(deg.into());
    let stands = format!(
        "identify: the joint is only {} deg from a position limit \
         (`limits.position_min_deg`, `limits.position_max_deg`)",
        deg(room_deg)
    );
    Err(if is_possible {
        let at_most = 0.01 * (100.0 * room_deg).floor();
        format!("{stands}; use a travel of {} deg or less. Nothing has moved", deg(at_most))
    } else {
        format!(
            "{stands}, and the identification needs {} deg in each direction ({} counts of this \
             encoder): move the joint away from the limit, or set wider limits. Nothing has moved",
            deg(LEAST_TRAVEL_COUNTS * resolution),
            shown(LEAST_TRAVEL_COUNTS.into())
        )
    })
}

/// Returns an error message if the encoder does not resolve the swings at the speed limit: minutes
/// of motion would not identify the inertia. Returns `None` for a request that the device refuses
/// itself.
fn shows_too_little(
    asked: &identification::IdentificationRequest,
    parameters: &Parameters,
) -> Option<String> {
    let least = parameters.identify(asked).ok()?.least_speed()?;
    let most = parameters.profile.velocity;
    let how = if least <= most {
        format!("use a speed of {} deg/s or more", enough(least).min(most))
    } else {
        format!(
            "raise profile.velocity_deg_per_s from {most} to {} or more, with an acceleration and \
             a jerk to match",
            enough(least)
        )
    };
    Some(format!(
        "identify: at the speed limit of {} deg/s the encoder is too coarse to identify the \
         inertia; {how}. Nothing has moved",
        asked.speed.unwrap_or(most)
    ))
}

/// Returns a value 10 % above `least`, rounded up to two digits, so that the rounded value is not
/// below `least`.
fn enough(least: f32) -> f32 {
    let more = 1.1 * f64::from(least);
    let digit = 10f64.powf(more.log10().floor() - 1.0);
    // A value of two digits stays in spite of its rounding error.
    let up = (more / digit - 1e-6).ceil() * digit;
    format!("{up:.1e}").parse().unwrap_or(up as f32)
}

#[cfg(test)]
mod tests {
    use stiction::units::value::Table as _;
    use stiction::{ControllerConfig, ProfileLimits};

    use super::*;

    fn example() -> Parameters {
        Parameters {
            controller: ControllerConfig::EXAMPLE,
            motion: Motion::Hold,
            device: stiction::parameters::DeviceConfig::CAUTIOUS,
            limits: Limits::EXAMPLE,
            profile: ProfileLimits::EXAMPLE,
            jog: stiction::motion::jog::JogBounds::EXAMPLE,
            current: stiction::control::current_sensor::CurrentSensor::NONE,
            brake_resistor: stiction::control::brake_resistor::BrakeResistor::NONE,
            motor_ntc: stiction::control::motor_ntc::MotorNtc::NONE,
        }
    }

    /// The thesis's encoder has 0.00242 deg a count, so 500 counts are 1.21 deg.
    #[test]
    fn an_identification_fits_between_the_limits_of_travel_or_is_refused_with_the_room() {
        let limited = |position_min: f32, position_max: f32| {
            let limits = Limits { position_min, position_max, ..Limits::EXAMPLE };
            Parameters { limits, ..example() }
        };
        let resolution = ControllerConfig::EXAMPLE.encoder.resolution;
        let at = |deg: f32| (deg / resolution).round() as i32;
        let asked = |travel| identification::IdentificationRequest { travel, ..Default::default() };
        let fitted = |range: [f32; 2], here: f32, travel| {
            fits(&asked(travel), &limited(range[0], range[1]), at(here)).map(|fitted| fitted.travel)
        };
        assert_eq!(fitted([0.0, 0.0], 0.0, None), Ok(None));
        assert_eq!(fitted([-50.0, 90.0], 0.0, None), Ok(None));
        assert_eq!(fitted([-30.0, 90.0], 0.0, Some(29.0)), Ok(Some(29.0)));
        for (here, room) in [(0.0, 30.0), (-10.0, 20.0), (85.0, 5.0)] {
            let travel = fitted([-30.0, 90.0], here, None).unwrap().unwrap();
            assert!((travel - room).abs() < 2.0 * resolution, "{here}: {travel}");
            let refused = fitted([-30.0, 90.0], here, Some(44.0)).unwrap_err();
            assert!(refused.contains("or less. Nothing has moved"), "{refused}");
        }
        let refused = fitted([-30.0, 90.0], 89.0, None).unwrap_err();
        assert!(refused.contains("is only 0.9995 deg"), "{refused}");
        assert!(refused.contains("needs 1.21 deg"), "{refused}");
        assert!(refused.contains("500 counts") && !refused.contains("--"), "{refused}");
        // Out of its limits, which the device reports.
        assert_eq!(fitted([-30.0, 90.0], 95.0, None), Ok(None));
    }

    #[test]
    fn an_advised_speed_has_two_digits_and_a_margin_within_the_profile() {
        assert_eq!([0.1037, 19.286, 1.0, 90.0].map(enough), [0.12, 22.0, 1.1, 99.0]);
        // The thesis's encoder at 20 ms shows the swings from 0.1037 deg/s on.
        let said = |most: f32| {
            let profile = ProfileLimits { velocity: most, ..ProfileLimits::EXAMPLE };
            let parameters = Parameters { profile, ..example() };
            let asked =
                identification::IdentificationRequest { speed: Some(0.05), ..Default::default() };
            shows_too_little(&asked, &parameters).unwrap()
        };
        assert!(said(1.0).contains("use a speed of 0.12 deg/s or more"), "{}", said(1.0));
        assert!(said(0.11).contains("use a speed of 0.11 deg/s or more"), "{}", said(0.11));
        assert!(said(0.1).contains("from 0.1 to 0.12 or more"), "{}", said(0.1));
    }
}
