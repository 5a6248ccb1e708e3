//! The control loop of a joint: controller, course and monitors, prepared once from the parameters,
//! with their states.

#[cfg(feature = "two-encoders")]
use super::absolute_load::AbsoluteLoad;
use super::current_path::CurrentPath;
use super::holding_brake::BrakeTimes;
use super::stopping::Brakes;
use super::wake_up::DriverTimes;
use super::{Input, Refusal, control};
use crate::control::controller::{Controller, ControllerConfig, Reading};
use crate::control::device_config::PositionReference;
use crate::control::encoder::Encoder;
use crate::control::hardware::Hardware;
use crate::control::profile::Profile;
use crate::control::reference::{Reference, Setpoint};
use crate::control::signal::Tick;
#[cfg(feature = "two-encoders")]
use crate::load_encoder::AbsoluteEncoder;
use crate::motion::arming_test::ArmingTest;
use crate::motion::home::HomeWatch;
use crate::motion::{Course, CourseState};
use crate::parameters::Parameters;
use crate::safety::encoder_index::IndexCheck;
use crate::safety::fault::Fault;
use crate::safety::monitor::{MonitorState, Monitors, PositionLimits, Seen};
use crate::safety::motor_temperature::MotorTemperature;
use crate::safety::open_line::OpenLineTest;
use crate::units::error::InvalidValue;
use crate::units::position::Position;

/// The control loop of a joint, made from parameters by [`ControlLoop::prepare`].
#[derive(Clone, Debug)]
pub struct ControlLoop {
    pub(super) controller: Controller,
    /// The present course: the motion of the parameters, until a link requests another one. There
    /// is memory for only one course.
    pub(super) course: Course,
    /// Whether a link has replaced the motion of the parameters.
    pub(super) replaced: bool,
    pub(super) state: CourseState,
    /// The watch that ends a homing; none if the course is no homing.
    pub(super) home: Option<HomeWatch>,
    /// The position in which the loop was armed, counts since power-on.
    pub(super) zero: i32,
    pub(super) monitors: Monitors,
    pub(super) open_line: OpenLineTest,
    /// The test of the load's encoder, if there are two; `open_line` is then that of the motor's.
    #[cfg(feature = "two-encoders")]
    pub(super) load_line: Option<OpenLineTest>,
    /// The load's encoder, if it is an absolute one.
    #[cfg(feature = "two-encoders")]
    pub(super) absolute: Option<AbsoluteLoad>,
    pub(super) watch: MonitorState,
    /// The sensor of the motor's current; none without one.
    pub(super) current: Option<CurrentPath>,
    /// The temperature sensor of the motor; none without one.
    pub(super) temperature: Option<MotorTemperature>,
    /// Ticks from the first one until the servo arms automatically; none without autostart.
    pub(super) autostart: Option<u32>,
    /// The event that makes the position known: a reset, or a command.
    pub(super) reference: PositionReference,
    pub(super) driver_times: DriverTimes,
    pub(super) brakes: Brakes,
    pub(super) holding_brake: BrakeTimes,
    /// Bit of the [lines](super::Input::lines) that the contact of the emergency stop sets; zero
    /// without such a contact.
    pub(super) contact: u8,
    /// The test at arming; none unless the parameters have one.
    pub(super) arming_test: Option<ArmingTest>,
    /// Check of the counts by the encoder's index; none without one.
    pub(super) index: Option<IndexCheck>,
}

impl ControlLoop {
    /// Validates the parameters and prepares everything that a tick needs, in `place`: a loop has
    /// the size of a kilobyte, and the stack of a board has no room for two.
    ///
    /// # Errors
    /// Returns an error that names the first invalid value, as [`Parameters::prepare`] does;
    /// `place` is then unchanged.
    pub fn prepare(
        place: &mut Option<Self>,
        parameters: &Parameters,
        hardware: &Hardware,
    ) -> Result<(), InvalidValue> {
        parameters.check_times(hardware)?;
        parameters.check()?;
        Self::begin_with(place, parameters, hardware)?;
        match place {
            Some(prepared) => {
                let Parameters { motion, controller, profile, .. } = parameters;
                motion.prepare(controller, profile, &mut prepared.course)
            }
            None => Ok(()),
        }
    }

    /// Prepares everything but the motion. As a separate function, it frees its stack before the
    /// motion is prepared.
    #[inline(never)]
    fn begin_with(
        place: &mut Option<Self>,
        parameters: &Parameters,
        hardware: &Hardware,
    ) -> Result<(), InvalidValue> {
        let Parameters { device, limits, controller: config, .. } = parameters;
        let mut controller = Controller::new(config, hardware)?;
        parameters.on_device(&mut controller, hardware);
        let current = CurrentPath::of(parameters, *controller.drive(), hardware);
        *place = Some(Self {
            controller,
            course: Course::default(),
            replaced: false,
            state: CourseState::default(),
            home: None,
            zero: 0,
            monitors: Monitors::new(limits, config, device, hardware),
            open_line: OpenLineTest::new(first_encoder(config).output, config.sample_time),
            #[cfg(feature = "two-encoders")]
            load_line: config
                .motor
                .count()
                .map(|_| OpenLineTest::new(config.encoder.output, config.sample_time)),
            #[cfg(feature = "two-encoders")]
            absolute: AbsoluteLoad::of(config),
            watch: MonitorState::default(),
            current,
            temperature: MotorTemperature::of(
                parameters.motor_ntc,
                config.sample_time,
                hardware.supply_top,
            ),
            autostart: device.autostart.then(|| parameters.in_ticks(device.autostart_delay)),
            reference: device.reference,
            driver_times: DriverTimes::of(parameters),
            brakes: Brakes {
                time: device.stop_time,
                acceleration: parameters.profile.acceleration,
                tick: config.sample_time,
                count: config.encoder.resolution,
            },
            holding_brake: BrakeTimes::of(parameters),
            contact: if device.emergency_stop { Input::CONTACT } else { 0 },
            arming_test: parameters.arming_test(),
            index: IndexCheck::of(device.index_counts, device.index_width),
        });
        Ok(())
    }

    /// Begins the loop's course at `position` (counts since power-on), which becomes zero. If
    /// `by_link`, the silence of the link is watched. `origin` is the zero of the range, counts
    /// since power-on; none: there is no range.
    pub(super) fn arm(&mut self, position: i32, by_link: bool, origin: Option<i32>) {
        self.begin_at(position);
        if let Some(path) = &mut self.current {
            path.arm();
        }
        let range = self.monitors.range(origin);
        self.watch = self.monitors.armed(&self.watch, by_link, range);
    }

    /// Restarts the monitors after a test at arming, in which some are off.
    pub(super) fn watch_anew(&mut self) {
        let (by_link, range) = (self.watch.is_watched(), self.watch.range());
        self.watch = self.monitors.armed(&self.watch, by_link, range);
        self.watch.expect_stop(self.home.as_ref().is_some_and(HomeWatch::expects_stop));
    }

    /// Begins the loop's course at `position` (counts since power-on), which becomes zero.
    pub(super) fn begin_at(&mut self, position: i32) {
        self.zero = position;
        let most = self.home.as_ref().map_or(f32::INFINITY, HomeWatch::effort);
        self.controller.bound_effort(most);
        self.state = CourseState::start(&self.controller, 0);
        let wait = self.state.soft_start_left(&self.controller);
        self.course.restart(wait);
        if let Some(home) = &mut self.home {
            home.restart(wait);
        }
    }

    /// Resets the state of law and course. If the course has ended, its state stays, with the
    /// findings of a ramp or a jog. The monitors begin anew at the next arming.
    pub(super) fn rest(&mut self) {
        if !self.is_over() {
            self.state.forget();
        }
        self.watch.rest();
    }

    /// Replaces the course: by one that a link requests, or by the braking of a controlled stop.
    pub(super) fn begin(&mut self, course: Course) {
        self.course = course;
        self.home = None;
        self.goes_on();
    }

    /// Replaces the course by a profile that begins at the position and velocity of the set point.
    /// A set point at rest waits for the end of the soft start. If a profile already runs, only its
    /// target changes.
    ///
    /// # Errors
    /// Refuses if the set point is too fast to come to rest within the range of positions.
    pub(super) fn begin_profile(&mut self, mut profile: Profile) -> Result<(), Refusal> {
        if let Course::Profile(running) = &mut self.course {
            // It can always stop within the range: its start and each of its targets were checked
            // against the range.
            running.aim(profile.target());
            self.goes_on();
            return Ok(());
        }
        let Setpoint { position, velocity, .. } = self.setpoint();
        profile.start_at(position, velocity);
        if self.is_out_of_range(Position::from_counts(profile.stops_at())) {
            return Err(Refusal::TooFast);
        }
        profile.wait(self.state.soft_start_left(&self.controller));
        self.begin(Course::Profile(profile));
        Ok(())
    }

    /// Brings a moving profile to rest. Returns whether there was one.
    pub(super) fn stops_profile(&mut self) -> bool {
        match &mut self.course {
            Course::Profile(running) if running.is_moving() => {
                running.stop();
                self.goes_on();
                true
            }
            _ => false,
        }
    }

    /// Starts a new motion in the running loop. From now on the silence of the link is watched.
    fn goes_on(&mut self) {
        self.replaced = true;
        self.watch.listen();
        self.state.begin_motion();
    }

    /// Returns the set point of the last tick.
    // This function has its own copy of the reference's code. Code shared with the tick would no
    // longer be inlined into the tick.
    #[inline(never)]
    pub(super) fn setpoint(&self) -> Setpoint {
        match &self.course {
            // Before its first tick, a step has not been commanded yet.
            Course::Follow(_) if self.state.next_tick() == 0 => {
                Setpoint::at_rest(Position::from_counts(self.state.counts()))
            }
            Course::Follow(reference) => reference.at(self.state.next_tick().saturating_sub(1)),
            Course::Profile(profile) => profile.setpoint(),
            Course::Ramp(_) | Course::Jog(_) | Course::Identification(_) | Course::Winding(_) => {
                Setpoint::at_rest(Position::from_counts(self.state.counts()))
            }
        }
    }

    /// Returns whether a position, counted from the zero of this arming, is outside the range.
    pub(super) const fn is_out_of_range(&self, position: Position) -> bool {
        self.watch.range().check(self.zero.wrapping_add(position.counts))
    }

    /// Returns whether a trajectory or a sine begins so far from `counts`, a position from the zero
    /// of arming, that its first tick would be a jump.
    pub(super) fn begins_far_from(&self, course: &Course, counts: i32) -> bool {
        let first = match course {
            // It rests there before its first blend.
            Course::Follow(Reference::Trajectory(trajectory)) => {
                trajectory.corners().next().unwrap_or_default().position
            }
            Course::Follow(Reference::Sine(sine)) => sine.turns()[0],
            _ => return false,
        };
        self.monitors.is_jump(first.counts.wrapping_sub(counts))
    }

    /// Runs one tick with the readings of the encoders.
    #[inline]
    pub(super) fn tick(&mut self, seen: &Seen, supply: u16) -> Tick {
        let counts = seen.position.wrapping_sub(self.zero);
        if self.watch.probes() {
            self.state.push(self.monitors.probe_code(&self.watch, seen.position));
        }
        let reading = Reading::measured(counts, supply);
        #[cfg(feature = "two-encoders")]
        let reading = match &seen.motor {
            Some(motor) => Reading { motor_counts: motor.position, ..reading },
            None => reading,
        };
        let mut tick = control(&mut self.course, &self.controller, &mut self.state, reading);
        tick.current = self.watch.current();
        if tick.saturated {
            self.state.capped(&mut self.course);
        }
        tick
    }

    /// Measures the motor's current, for the limit of the effort and for the heat, and checks it.
    /// `speed` is that of the joint in the last tick, deg/s. Returns the fault and the current, A.
    // Out of line: a tick without a sensor does not pay for it.
    #[inline(never)]
    pub(super) fn measure(
        &mut self,
        seen: &Seen,
        reading: u16,
        speed: f32,
    ) -> Option<(Fault, f32)> {
        let path = self.current.as_mut()?;
        let target = self.state.controller().applied();
        let driven = path.driven(target, speed, seen.driven().travel);
        let found = path.measure(reading, &driven);
        self.monitors.measure(&mut self.watch, path.current(), path.heat_volts());
        if let Course::Winding(test) = &mut self.course {
            // The voltage is that of the pulses, through a winding that is not known yet.
            if path.is_beyond_limit() {
                test.exceed();
            }
            return None;
        }
        match found {
            Ok(bounds) => {
                if let Some(bounds) = bounds {
                    self.controller.bound(bounds);
                }
                None
            }
            Err(trip) => Some(trip),
        }
    }

    /// Returns whether the offset of the motor's current is known, or there is no sensor.
    pub(super) fn knows_offset(&self) -> bool {
        self.current.as_ref().is_none_or(CurrentPath::is_calibrated)
    }

    /// Updates a homing with the last tick, and returns whether the course has ended.
    #[inline]
    pub(super) fn ends(&mut self, tick: &Tick, lines: u8) -> bool {
        // Not by `is_over` for all: the longest ticks are those of the first two.
        match &mut self.course {
            Course::Follow(_) => false,
            Course::Profile(_) => self.home.is_some() && self.homing_ends(tick, lines),
            course => self.state.is_over(course),
        }
    }

    /// Returns the absolute encoder on the load, with its zero.
    #[cfg(feature = "two-encoders")]
    pub(super) fn angle(&self) -> Option<AbsoluteEncoder> {
        self.absolute.map(|absolute| absolute.encoder)
    }

    /// Returns whether the angle of an absolute encoder is to give the position of the joint: only
    /// a joint with a range needs it.
    pub(super) fn has_angle(&self) -> bool {
        #[cfg(feature = "two-encoders")]
        return self.absolute.is_some() && self.monitors.has_range();
        #[cfg(not(feature = "two-encoders"))]
        false
    }

    /// Returns whether the course has ended. A ramp, a jog and a homing end; a reference does not.
    pub(super) const fn is_over(&self) -> bool {
        match &self.home {
            Some(home) => home.is_over(),
            None => self.state.is_over(&self.course),
        }
    }

    /// Returns whether the course ends automatically and accepts only a stop until then.
    pub(super) const fn ends_by_itself(&self) -> bool {
        self.course.is_open() || self.home.is_some()
    }
}

/// Returns the encoder whose counter is [`Input::counter`](super::Input::counter): of two, that of
/// the motor.
fn first_encoder(config: &ControllerConfig) -> Encoder {
    #[cfg(feature = "two-encoders")]
    if config.motor.count().is_some() {
        return config.motor.encoder();
    }
    config.encoder
}

/// Returns whether any target position of a course satisfies a condition.
fn any_target(course: &Course, condition: impl Fn(Position) -> bool) -> bool {
    match course {
        Course::Follow(Reference::Step(step)) => condition(step.to),
        Course::Follow(Reference::Trajectory(trajectory)) => {
            trajectory.corners().any(|corner| condition(corner.position))
        }
        Course::Follow(Reference::Sine(sine)) => sine.turns().into_iter().any(condition),
        Course::Profile(profile) => condition(profile.target()),
        // It begins where the joint is, and only the servo starts it.
        Course::Follow(Reference::Braking(_)) => false,
        Course::Ramp(_) | Course::Jog(_) | Course::Identification(_) | Course::Winding(_) => false,
    }
}

/// Returns whether a course with its zero at `zero` (counts since power-on) has a target outside a
/// range.
pub(super) fn leads_out(course: &Course, zero: i32, range: PositionLimits) -> bool {
    any_target(course, |position| range.check(zero.wrapping_add(position.counts)))
}

/// Returns whether a course has a target so far from `counts` that a 32-bit difference of positions
/// could overflow on the way.
pub(super) fn leads_too_far(course: &Course, counts: i32) -> bool {
    any_target(course, |position| is_too_far(position, counts))
}

/// Returns whether a position is 2^30 counts or more from `counts`. Differences of positions are
/// signed 32-bit numbers, and the joint may overshoot its target.
pub(super) fn is_too_far(position: Position, counts: i32) -> bool {
    position.counts.checked_sub(counts).is_none_or(|way| way.unsigned_abs() >= 1 << 30)
}
