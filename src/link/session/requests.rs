//! The execution of a session's requests on the machine, and their answers.

use super::super::CHUNK;
use super::super::reply::{Reply, RequestRefusal, StateCode, Status};
use super::super::request::Request;
use super::super::telemetry::Subscription;
use super::{Machine, Session};
use crate::control::brake_resistor::BrakeResistor;
use crate::control::controller::EffortMode;
use crate::control::drive::DriveConfig;
use crate::control::laws::Gains;
use crate::control::signal::{self, LawSignal, SIGNALS};
use crate::identification;
use crate::motion::home::HomeRequest;
use crate::motion::jog::JogRequest;
use crate::motion::winding::WindingRequest;
use crate::motion::{Course, Motion};
use crate::parameters::{Parameters, ROOM};
use crate::servo::{self, ControlLoop, Servo};

impl<const RING: usize> Session<RING> {
    /// Executes a request that is of the session, or that only reads.
    #[inline(never)]
    pub(super) fn act(
        &mut self,
        request: Request,
        machine: &mut impl Machine,
    ) -> Result<Reply, RequestRefusal> {
        match request {
            // These were dealt with before.
            Request::Hello { .. } | Request::Stop | Request::ReadIdentification => {}
            Request::Open { .. } => return Ok(Reply::Session(self.session)),
            Request::TakeOver => return Ok(self.end(machine)),
            Request::Status => return Ok(Reply::Status(self.status(machine))),
            Request::Fault { index } => {
                let nth = |servo: &mut Servo| servo.log().iter().nth(index.into()).copied();
                return machine
                    .servo(nth)
                    .map(|fault| Reply::Fault(fault.into()))
                    .ok_or(RequestRefusal::NoSuch);
            }
            Request::Clear => machine.servo(Servo::clear)?,
            Request::Arm => machine.servo(|servo| servo.arm_for_link(None))?,
            Request::Move(motion) => self.go(&motion, machine)?,
            Request::ReadParameters { offset } => return self.read(offset),
            Request::WriteParameters { offset, bytes } => {
                let offset = usize::from(offset);
                let piece = self
                    .incoming
                    .get_mut(offset..offset + bytes.len())
                    .ok_or(RequestRefusal::NoSuch)?;
                piece.copy_from_slice(&bytes);
            }
            Request::TakeParameters { length } => self.take_parameters(length, machine)?,
            Request::Save => self.save(machine)?,
            Request::Change { entries } => self.change(&entries, machine)?,
            Request::Signal { index } => {
                let signal = signal::describe(index.into(), self.law_signals())
                    .ok_or(RequestRefusal::NoSuch)?;
                return Ok(Reply::Signal(signal.into()));
            }
            Request::Subscribe { signals, every } => {
                let known = SIGNALS.len() + self.law_signals().len();
                self.subscription =
                    Subscription::new(signals, every, known).ok_or(RequestRefusal::NoSuch)?;
            }
            Request::Identify { rate, hold } => {
                let ramp = self
                    .parameters
                    .as_ref()
                    .ok_or(RequestRefusal::NoParameters)?
                    .ramp(rate, hold)?;
                machine.servo(|servo| servo.arm_for_link(Some(ramp)))?;
            }
            Request::ReadLevels => return Ok(Reply::Levels(machine.servo(|servo| servo.levels()))),
            Request::Jog(asked) => self.jog(&asked, machine)?,
            Request::SetBrownOut => {
                machine.servo(keep_off)?;
                machine.set_brown_out()?;
            }
            Request::IdentifyJoint(asked) => self.identify(&asked, machine)?,
            Request::ReadMap => {
                let map = |servo: &mut Servo| servo.identified().map(|found| found.map);
                return Ok(Reply::Map(machine.servo(map)));
            }
            Request::SetReference { position } => {
                machine.servo(|servo| servo.set_reference(position))?;
            }
            Request::Home(asked) => self.home(&asked, machine)?,
            Request::ReadHome => return Ok(Reply::Home(machine.servo(|servo| servo.homed()))),
            Request::MeasureWinding(asked) => self.measure_winding(&asked, machine)?,
            Request::ReadWinding => {
                return Ok(Reply::Winding(machine.servo(|servo| servo.winding())));
            }
            Request::ReadJog => return Ok(Reply::Jog(machine.servo(|servo| servo.jogged()))),
        }
        Ok(Reply::Done)
    }

    #[inline(never)]
    fn take_parameters(
        &mut self,
        length: u16,
        machine: &mut impl Machine,
    ) -> Result<(), RequestRefusal> {
        // An armed servo refuses at once: to decode and to prepare takes milliseconds, for which an
        // armed loop's log would have to wait.
        machine.servo(|servo| refuse_if_armed(servo))?;
        let record = self.incoming.get(..length.into()).ok_or(RequestRefusal::NoSuch)?;
        let (parameters, _) = Parameters::decode(record)?;
        self.install(parameters, machine)
    }

    #[inline(never)]
    fn change(&mut self, entries: &[u8], machine: &mut impl Machine) -> Result<(), RequestRefusal> {
        machine.servo(|servo| refuse_if_armed(servo))?;
        let before = self.parameters.as_ref().ok_or(RequestRefusal::NoParameters)?;
        let mut parameters = before.clone();
        parameters.change(entries, before)?;
        self.install(parameters, machine)
    }

    /// Installs all of the parameters or none: exactly the validated ones.
    #[inline(never)]
    fn install(
        &mut self,
        parameters: Parameters,
        machine: &mut impl Machine,
    ) -> Result<(), RequestRefusal> {
        self.prepare_and_install(&parameters, machine)?;
        self.unsaved |= self.parameters.as_ref() != Some(&parameters);
        let announced = self.law_signals();
        self.parameters = Some(parameters);
        if self.law_signals() != announced {
            // A place may belong to another signal now. The client has to read the signals and
            // subscribe anew.
            self.subscription = Subscription::NONE;
        }
        Ok(())
    }

    /// Prepares the control loop before the servo is locked, and installs it. What can still be
    /// refused is refused before anything is changed.
    #[inline(never)]
    fn prepare_and_install(
        &self,
        parameters: &Parameters,
        machine: &mut impl Machine,
    ) -> Result<(), RequestRefusal> {
        let mut control_loop = None;
        ControlLoop::prepare(&mut control_loop, parameters, &machine.hardware())?;
        machine.servo(keep_off)?;
        if self.parameters.as_ref().is_none_or(|before| timing(before) != timing(parameters)) {
            machine.reconfigure(parameters)?;
        }
        Ok(machine.servo(|servo| servo.install(&mut control_loop))?)
    }

    #[inline(never)]
    fn save(&mut self, machine: &mut impl Machine) -> Result<(), RequestRefusal> {
        let parameters = self.parameters.as_ref().ok_or(RequestRefusal::NoParameters)?;
        machine.servo(keep_off)?;
        // Parameters that are saved already cost no erase.
        if self.unsaved || self.is_damaged {
            let clock = machine.servo(|servo| servo.clock());
            self.save_budget.take(clock, parameters.controller.sample_time)?;
        }
        self.saves = machine.save(parameters)?;
        (self.unsaved, self.is_damaged) = (false, false);
        Ok(())
    }

    #[inline(never)]
    fn go(&self, motion: &Motion, machine: &mut impl Machine) -> Result<(), RequestRefusal> {
        let Parameters { controller, profile, .. } =
            self.parameters.as_ref().ok_or(RequestRefusal::NoParameters)?;
        if let Motion::Hold = motion {
            return Ok(machine.servo(Servo::hold)?);
        }
        match motion.course(controller, profile)? {
            Course::Follow(reference) => Ok(machine.servo(|servo| servo.follow(reference))?),
            Course::Profile(profile) => Ok(machine.servo(|servo| servo.go_to(profile))?),
            // A ramp begins with arming, by `Identify`.
            Course::Ramp(_) | Course::Jog(_) | Course::Identification(_) | Course::Winding(_) => {
                Err(RequestRefusal::NoSuch)
            }
        }
    }

    #[inline(never)]
    fn jog(&self, asked: &JogRequest, machine: &mut impl Machine) -> Result<(), RequestRefusal> {
        let jog = self.parameters.as_ref().ok_or(RequestRefusal::NoParameters)?.jog(asked)?;
        Ok(machine.servo(|servo| servo.jog(jog))?)
    }

    #[inline(never)]
    fn home(&self, asked: &HomeRequest, machine: &mut impl Machine) -> Result<(), RequestRefusal> {
        let home = self.parameters.as_ref().ok_or(RequestRefusal::NoParameters)?.home(asked)?;
        Ok(machine.servo(|servo| servo.home(home))?)
    }

    #[inline(never)]
    fn measure_winding(
        &self,
        asked: &WindingRequest,
        machine: &mut impl Machine,
    ) -> Result<(), RequestRefusal> {
        let parameters = self.parameters.as_ref().ok_or(RequestRefusal::NoParameters)?;
        let test = parameters.measure_winding(asked, &machine.hardware())?;
        Ok(machine.servo(|servo| servo.measure_winding(test))?)
    }

    #[inline(never)]
    fn identify(
        &self,
        asked: &identification::IdentificationRequest,
        machine: &mut impl Machine,
    ) -> Result<(), RequestRefusal> {
        let settings =
            self.parameters.as_ref().ok_or(RequestRefusal::NoParameters)?.identify(asked)?;
        Ok(machine.servo(|servo| servo.identify(&settings))?)
    }

    #[inline(never)]
    fn read(&self, offset: u16) -> Result<Reply, RequestRefusal> {
        let parameters = self.parameters.as_ref().ok_or(RequestRefusal::NoParameters)?;
        let mut room = [0; ROOM];
        // Cannot fail: every record fits.
        let record = parameters.encode(0, &mut room).ok_or(RequestRefusal::NotWhole)?;
        let rest = record.get(offset.into()..).ok_or(RequestRefusal::NoSuch)?;
        let bytes = rest.iter().copied().take(CHUNK).collect();
        Ok(Reply::Parameters { length: record.len() as u16, offset, bytes })
    }

    /// Returns the signals that the law in use publishes of itself.
    fn law_signals(&self) -> &'static [LawSignal] {
        let laws = self.parameters.iter().flat_map(|parameters| &parameters.controller.compensator);
        laws.map(Gains::signals).find(|signals| !signals.is_empty()).unwrap_or_default()
    }

    #[inline(never)]
    fn status(&self, machine: &mut impl Machine) -> Status {
        let controller = self.parameters.as_ref().map(|parameters| &parameters.controller);
        let (bad_frames, dropped) = (self.deframer.bad(), self.outbox.dropped());
        let (unsaved, is_damaged, saves) = (self.unsaved, self.is_damaged, self.saves);
        let Self { has_brown_out, crystal_not_measured, wire, .. } = *self;
        machine.servo(|servo| Status {
            state: StateCode::from(servo.state()),
            fault: servo.latched().map(Into::into).unwrap_or_default(),
            faults: servo.log().count(),
            clock: servo.clock(),
            sample_time: controller.map_or(0.0, |controller| controller.sample_time),
            position: servo.position(),
            resolution: controller.map_or(0.0, |controller| controller.encoder.resolution),
            at_rest: servo.is_at_rest(),
            wound_up: servo.is_wound_up(),
            thermal_effort: servo.thermal_effort(),
            motor_temperature: servo.motor_temperature(),
            unsaved,
            is_damaged,
            saves,
            bad_frames,
            dropped,
            has_brown_out,
            wire,
            crystal_not_measured,
            gave_up: servo.has_given_up(),
            is_encoder_in_doubt: servo.is_encoder_in_doubt(),
            oscillates: servo.is_oscillating(),
            is_referenced: servo.is_referenced(),
            is_testing: servo.is_testing(),
            has_failed_test: servo.has_failed_test(),
            load_angle: load_angle(servo),
            index_passes: servo.index_passes().0,
            index_deviation: servo.index_passes().1,
        })
    }
}

/// Returns the reading of an absolute encoder on the load, counts within its turn.
const fn load_angle(servo: &Servo) -> Option<u16> {
    #[cfg(feature = "two-encoders")]
    return servo.load_angle();
    #[cfg(not(feature = "two-encoders"))]
    {
        let _ = servo;
        None
    }
}

fn refuse_if_armed(servo: &Servo) -> Result<(), servo::Refusal> {
    match servo.state() {
        servo::State::Armed => Err(servo::Refusal::Armed),
        _ => Ok(()),
    }
}

/// Turns autostart off, for an action of more than a tick with the output off: the servo must not
/// arm automatically meanwhile. An armed servo refuses.
fn keep_off(servo: &mut Servo) -> Result<(), servo::Refusal> {
    refuse_if_armed(servo)?;
    servo.stop();
    Ok(())
}

/// Returns the settings of bridge, timers, converter and watchdog: sample time, dead time,
/// blanking, PWM, what an effort is, whether there is a sensor of the current, and the brake
/// resistor with the scale of the supply.
const fn timing(
    parameters: &Parameters,
) -> ([f32; 4], &DriveConfig, EffortMode, bool, &BrakeResistor) {
    let Parameters { controller, device, current, brake_resistor, .. } = parameters;
    let full_scale = device.supply_full_scale;
    let times = [controller.sample_time, device.dead_time, device.fault_blanking, full_scale];
    (times, &controller.drive, controller.effort, current.is_there(), brake_resistor)
}
