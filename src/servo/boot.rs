//! The start of a servo, from its parameters and the state of the microcontroller after the reset.

use super::referenced::Referenced;
use super::{ControlLoop, Follower, Servo, State, WakeUp};
use crate::control::hardware::Hardware;
use crate::motion::Course;
use crate::parameters::{DecodeError, Parameters};
use crate::safety::encoder_index::IndexState;
use crate::safety::encoder_proof::EncoderProofs;
use crate::safety::fault::{Fault, FaultLog, LatchedFault};
use crate::safety::motor_temperature::MotorTemperatureState;
use crate::safety::open_line::OpenLineState;

/// State in which the microcontroller came out of its last reset.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Boot {
    /// Fault with which the microcontroller starts, if any. Its time is that of the run in which it
    /// happened.
    pub fault: Option<LatchedFault>,
    /// Whether the encoder was [in doubt](crate::safety::encoder_proof) before the reset.
    pub is_encoder_in_doubt: bool,
    /// Whether a slot of the parameters is damaged. The parameters may then not be those saved
    /// last, so the servo does not arm automatically.
    pub is_damaged: bool,
    /// Whether the reset may have been a dip of the supply that cannot be distinguished from
    /// power-on. Nothing arms automatically then, unless the parameters allow it
    /// (`autostart_after_dip`).
    pub may_be_dip: bool,
    /// Whether the joint is known to be at zero, as on a simulated device.
    pub is_at_zero: bool,
    /// Heat of the motor before the reset, as the steady effort that would cause it, V.
    pub thermal_effort: f32,
}

impl Boot {
    /// Returns the boot of a simulated device: power-on, with the joint at zero.
    pub fn at_zero() -> Self {
        Self { is_at_zero: true, ..Self::default() }
    }
}

impl Servo {
    /// Makes a servo from its parameters, or from the reason why there are none.
    pub fn new(
        parameters: Result<&Parameters, DecodeError>,
        boot: Boot,
        hardware: &Hardware,
    ) -> Self {
        let mut servo = Self::blank();
        servo.boot(parameters, boot, hardware);
        servo
    }

    /// Returns a servo without parameters. [`boot`](Self::boot) sets them.
    pub fn blank() -> Self {
        Self {
            control_loop: None,
            countdown: None,
            state: State::Boot,
            clock: 0,
            follower: Follower::default(),
            wake_up: WakeUp::default(),
            encoder_proof: EncoderProofs::default(),
            open_line: OpenLineState::default(),
            #[cfg(feature = "two-encoders")]
            load_line: OpenLineState::default(),
            index: IndexState::default(),
            velocity: 0.0,
            transition: None,
            pending: Course::default(),
            is_contact_open: false,
            is_stop_behind: false,
            motor_temperature: MotorTemperatureState::default(),
            referenced: Referenced::default(),
            origin: 0,
            latched: None,
            log: FaultLog::default(),
            has_failed_test: false,
        }
    }

    /// Boots a blank servo in place, with the same result as [`new`](Self::new).
    pub fn boot(
        &mut self,
        parameters: Result<&Parameters, DecodeError>,
        boot: Boot,
        hardware: &Hardware,
    ) {
        let prepared = parameters.and_then(|parameters| {
            ControlLoop::prepare(&mut self.control_loop, parameters, hardware)
                .map_err(DecodeError::Value)
        });
        let autostart = self.control_loop.as_ref().and_then(|control_loop| control_loop.autostart);
        let after_dip = parameters.is_ok_and(|parameters| parameters.device.autostart_after_dip);
        let is_sure =
            !boot.is_damaged && !boot.is_encoder_in_doubt && (!boot.may_be_dip || after_dip);
        if boot.is_encoder_in_doubt {
            self.encoder_proof = EncoderProofs::IN_DOUBT;
        }
        if let Some(control_loop) = &mut self.control_loop {
            control_loop.watch = control_loop.monitors.warm(boot.thermal_effort);
        }
        if boot.is_at_zero {
            self.referenced = Referenced::Set;
        }
        self.countdown = autostart.filter(|_| is_sure);
        let refused = match prepared {
            Ok(()) => None,
            Err(DecodeError::Blank) => Some(Fault::NoParameters),
            Err(_) => Some(Fault::BadParameters),
        };
        if let Some(latched) = boot.fault.or(refused.map(LatchedFault::from)) {
            self.latch(latched);
        }
    }
}
