//! The trait of a law: its inputs in a tick, the loop around it, and the signals it publishes.

use crate::control::motor_encoder::MotorEncoder;
use crate::control::reference::Setpoint;
use crate::control::signal::{LawSignal, MAX_LAW_SIGNALS};
use crate::units::value::Table;

/// Input of a law in one tick.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct LawInput {
    /// Position theta_a, counts.
    pub counts: i32,
    /// Position of the motor, counts of its own encoder; `counts` is then the position of the load.
    #[cfg(feature = "two-encoders")]
    pub motor_counts: i32,
    /// Travel since the last tick, counts.
    pub travel: i32,
    /// Set point theta_d and its derivatives.
    pub setpoint: Setpoint,
    /// Error theta_e = theta_d - theta_a, deg.
    pub error: f32,
    /// Measured velocity theta_a', deg/s.
    pub velocity: f32,
    /// Velocity error theta_d' - theta_a', deg/s.
    pub velocity_error: f32,
    /// Output of the PD loop, V; zero if the law replaces it.
    pub v_pd: f32,
    /// Effort that the joint had since the last tick, V: after saturation, scaling and soft start.
    pub applied: f32,
    /// Whether that effort was less than requested.
    pub saturated: bool,
}

/// Properties of the loop around the laws, for which they are prepared.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Loop {
    /// Time between samples h, s.
    pub sample_time: f32,
    /// Angle of a count, deg.
    pub resolution: f32,
    /// Largest output, V: no integral grows beyond it.
    pub full_scale: f32,
    /// Effort of one code of the drive, V.
    pub lsb: f32,
    /// Proportional gain of the PD loop, V/deg.
    pub kp: f32,
    /// The encoder of the motor, if there is another one on the load.
    pub motor: MotorEncoder,
}

impl Loop {
    /// The loop of the thesis: 20 ms, 0.00242 deg, 5 V in steps of 0.00488 V, Kp = 1 V/deg.
    pub const EXAMPLE: Self = Self {
        sample_time: 0.02,
        resolution: 0.00242,
        full_scale: 5.0,
        lsb: 0.00488,
        kp: 1.0,
        motor: MotorEncoder::NONE,
    };
}

/// A control law, prepared from its gains for a loop.
pub trait Law: Sized {
    /// The law's gains, which a user sets.
    type Gains: Table + Copy;
    /// The law's state from tick to tick; its default is that of a joint at rest.
    type State: Copy + Default;

    /// Whether the law's output replaces that of PD; otherwise both outputs are added.
    const REPLACES_PD: bool = false;
    /// Whether the law is in the image of a device. The other laws exist on a host alone, for
    /// comparison.
    const ON_THE_DEVICE: bool = true;
    /// The signals that the law publishes beside its output: at most [`MAX_LAW_SIGNALS`].
    const SIGNALS: &'static [LawSignal] = &[];

    /// Prepares the law for a loop. The gains have been validated.
    fn new(gains: &Self::Gains, around: &Loop) -> Self;

    /// Returns the law's v_c for one tick, V.
    fn update(&self, state: &mut Self::State, input: &LawInput) -> f32;

    /// Returns the values of [`SIGNALS`](Self::SIGNALS) after an update.
    fn signals(&self, _: &Self::State) -> [f32; MAX_LAW_SIGNALS] {
        [0.0; MAX_LAW_SIGNALS]
    }

    /// Returns whether the law has ended its attempts to reach the set point.
    fn has_given_up(_: &Self::State) -> bool {
        false
    }

    /// Called at the start of each motion, even if its target is the present set point. A law that
    /// has given up tries again.
    fn begin_motion(_: &mut Self::State) {}

    /// Returns the law's own default of `overspeed_deg_per_s`; none: the default by PD's gains.
    fn overspeed(_: &Self::Gains, _: &Loop) -> Option<f32> {
        None
    }

    /// Returns the time for which the joint can swing to and fro before the law ends the swings, s;
    /// none if the law does not end swings. The overspeed monitor checks the mean speed over this
    /// time.
    fn swing_time(_: &Self::Gains, _: &Loop) -> Option<f32> {
        None
    }

    /// Returns the law's own default of `following_error_deg`; none: the default by PD's gains.
    fn following_error(_: &Self::Gains, _: &Loop) -> Option<f32> {
        None
    }

    /// Returns the error at which the law requests the full scale, deg; none: that of PD's gains.
    fn saturating_error(_: &Self::Gains, _: &Loop) -> Option<f32> {
        None
    }
}
