//! From a machine's tables to the core's configuration and the models around it. Every value is checked here, once.

use heapless::Vec as FixedVec;
use stiction::compensator::{
    DiscontinuousNonlinearProportionalGains, FeedforwardGains, Gains, MAX_TERMS, RateVariableIntegralGains,
    ResetIntegralGains, ResetOffsetIntegralGains, SmoothRobustNonlinearGains,
};
use stiction::drive::{DriveConfig, PwmMode};
use stiction::encoder::{CounterBits, Direction, Encoder};
use stiction::pd::PdGains;
use stiction::position::Position;
use stiction::reference::{Corner, Reference, Step, Trajectory};
use stiction::{Controller, ControllerConfig};

use super::plan::{Motion, RunPlan};
use crate::closed_loop::{ClosedLoop, Delay};
use crate::encoder::EncoderModel;
use crate::error::Error;
use crate::friction::{AddedFriction, Coulomb};
use crate::identification::Ramp;
use crate::machine::{self, LawName, Machine};
use crate::mechanism::RobotAxis;

/// Clock of the STM32F405's TIM1, which makes the PWM: the host computes the same compare values as the board.
const PWM_TIMER_HZ: f32 = 168e6;

/// A run of more samples than this is a mistake: a simulated day at 1 kHz.
const MAX_SAMPLES: f64 = 86.4e6;

impl RunPlan {
    /// The joint.
    ///
    /// # Errors
    /// Names the key, what was found and what is allowed.
    pub fn axis(&self) -> Result<RobotAxis, Error> {
        let joint = &self.machine.joint;
        let friction = &joint.friction;
        self.above_zero("joint.gain_deg_per_s2_per_v", joint.gain_deg_per_s2_per_v)?;
        self.at_least_zero("joint.viscous_v_per_deg_per_s", joint.viscous_v_per_deg_per_s)?;
        self.at_least_zero("joint.friction.slip_v", friction.slip_v)?;
        self.above_zero("joint.friction.band_deg_per_s", friction.band_deg_per_s)?;
        self.check("joint.friction.stick_v", friction.stick_v, friction.stick_v >= friction.slip_v, || {
            format!("a number not below `slip_v` ({})", friction.slip_v)
        })?;
        let lowest = -friction.slip_v;
        self.check("joint.friction.added_v", friction.added_v, friction.added_v >= lowest, || {
            format!("a number not below {lowest}")
        })?;
        for [from, to] in friction.added_during_s.iter().flatten() {
            self.check("joint.friction.added_during_s", *to, to > from, || {
                format!("an end later than {from} s")
            })?;
        }
        Ok(RobotAxis {
            gain: joint.gain_deg_per_s2_per_v,
            viscous: joint.viscous_v_per_deg_per_s,
            friction: Coulomb { stick: friction.stick_v, slip: friction.slip_v },
            added: AddedFriction { amount: friction.added_v, during_s: friction.added_during_s.clone() },
        })
    }

    /// The encoder's disc.
    ///
    /// # Errors
    /// Names the key, what was found and what is allowed.
    pub fn encoder(&self) -> Result<EncoderModel, Error> {
        let encoder = &self.machine.encoder;
        self.above_zero("encoder.resolution_deg", encoder.resolution_deg)?;
        self.check("encoder.phase", encoder.phase, (-1.0..=1.0).contains(&encoder.phase), || {
            "a number from -1 to 1".into()
        })?;
        Ok(EncoderModel {
            resolution: encoder.resolution_deg,
            rounding: encoder.rounding,
            phase: encoder.phase,
            counter_bits: self.counter_bits()?,
            direction: direction(encoder.direction),
        })
    }

    /// The control core with this run's controller; with no controller, all gains are zero.
    ///
    /// # Errors
    /// Names the key, what was found and what is allowed.
    pub fn controller(&self) -> Result<Controller, Error> {
        let name = self.controller.as_deref().unwrap_or_default();
        Controller::new(&self.controller_config()?).map_err(|error| self.explain(&error, name))
    }

    /// What the core is configured with, on the host as on a device.
    ///
    /// # Errors
    /// Names the key, what was found and what is allowed.
    pub fn controller_config(&self) -> Result<ControllerConfig, Error> {
        let machine = &self.machine;
        let name = self.controller.as_deref().unwrap_or_default();
        let none = machine::Controller::default();
        let table = machine.controller.get(name).unwrap_or(&none);
        Ok(ControllerConfig {
            sample_time: machine.sampling.sample_time_s as f32,
            encoder: Encoder {
                resolution: machine.encoder.resolution_deg as f32,
                counter_bits: self.counter_bits()?,
                direction: direction(machine.encoder.direction),
            },
            velocity_window: machine.sampling.velocity_window,
            pd: PdGains { kp: table.kp_v_per_deg as f32, kd: table.kd_v_per_deg_per_s as f32 },
            compensator: self.laws(name, table)?,
            drive: self.drive()?,
        })
    }

    /// The whole loop, ready to run.
    ///
    /// # Errors
    /// Names the key, what was found and what is allowed.
    pub fn closed_loop(&self) -> Result<ClosedLoop, Error> {
        let machine = &self.machine;
        let delay = match machine.run.delay_samples {
            0 => Delay::None,
            1 => Delay::OneSample,
            other => return Err(self.refuse("run.delay_samples", f64::from(other), "0 or 1")),
        };
        self.above_zero("run.step_s", machine.run.step_s)?;
        let controller = self.controller()?;
        Ok(ClosedLoop {
            reference: self.reference()?,
            controller,
            encoder: self.encoder()?,
            lsb_v: machine.drive.lsb_v,
            sample_time_s: machine.sampling.sample_time_s,
            delay,
            axis: self.axis()?,
        })
    }

    /// How many samples the run has after its first.
    ///
    /// # Errors
    /// Names the duration if it is not a positive number of at most 8.64e7 samples.
    pub fn samples(&self) -> Result<u32, Error> {
        let sample_time_s = self.machine.sampling.sample_time_s;
        let duration_s = self.duration_s();
        let samples = (duration_s / sample_time_s).round();
        self.check("run.duration_s", duration_s, (1.0..=MAX_SAMPLES).contains(&samples), || {
            format!("from one sample ({sample_time_s} s) to {} s", MAX_SAMPLES * sample_time_s)
        })?;
        Ok(samples as u32)
    }

    /// A ramp of the effort.
    ///
    /// # Errors
    /// Names the rate or the hold if the ramp would take no time or too long.
    pub fn ramp(&self, rate: f64) -> Result<Ramp, Error> {
        let Machine { sampling, drive, identification, .. } = &*self.machine;
        let hold_s = identification.as_ref().map_or(0.0, |ramps| ramps.hold_s);
        let longest_s = MAX_SAMPLES * sampling.sample_time_s;
        self.check("identification.hold_s", hold_s, (0.0..=longest_s).contains(&hold_s), || {
            format!("a number from 0 to {longest_s}")
        })?;
        // Up to the full scale and down to its negative.
        let slowest = 3.0 * drive.full_scale_v / longest_s;
        self.check("identification.ramp_rates_v_per_s", rate, rate >= slowest, || {
            format!("a number not below {slowest}")
        })?;
        Ok(Ramp {
            rate,
            hold_s,
            sample_time_s: sampling.sample_time_s,
            full_scale_v: drive.full_scale_v,
            lsb_v: drive.lsb_v,
        })
    }

    fn duration_s(&self) -> f64 {
        let by_default = match &self.motion {
            Motion::Step(_) | Motion::Ramp(_) => 10.0,
            Motion::Trajectory(trajectory) => trajectory.corner_times_s.last().copied().unwrap_or(0.0) + 3.0,
        };
        self.machine.run.duration_s.unwrap_or(by_default)
    }

    fn reference(&self) -> Result<Reference, Error> {
        let corners = self.corners()?;
        match &self.motion {
            Motion::Step(_) => Ok(Reference::Step(Step {
                from: Position::default(),
                to: corners.first().map_or(Position::default(), |corner| corner.position),
                at_tick: 0,
            })),
            Motion::Trajectory(trajectory) => {
                let sample_time = self.machine.sampling.sample_time_s as f32;
                let resolution = self.machine.encoder.resolution_deg as f32;
                Trajectory::new(&corners, trajectory.half_blend_s as f32, sample_time, resolution)
                    .map(Reference::Trajectory)
                    .map_err(|error| self.explain(&error, ""))
            }
            Motion::Ramp(_) => Ok(Reference::Step(Step::default())),
        }
    }

    /// Where the motion leads: the corners of a trajectory, or the one position of a step.
    ///
    /// # Errors
    /// Names the key, what was found and what is allowed.
    pub fn corners(&self) -> Result<Vec<Corner>, Error> {
        let resolution = self.machine.encoder.resolution_deg;
        let position = |key: &str, deg: f64| {
            self.check(key, deg, (deg / resolution).abs() < f64::from(i32::MAX), || {
                format!("a number below {} in size, 2^31 counts", f64::from(i32::MAX) * resolution)
            })?;
            Ok::<_, Error>(counts(deg / resolution))
        };
        match &self.motion {
            Motion::Step(step) => {
                Ok(vec![Corner { tick: 0, position: position("reference.steps_deg", *step)? }])
            }
            Motion::Trajectory(trajectory) => {
                let (times, positions) = (&trajectory.corner_times_s, &trajectory.corner_positions_deg);
                self.check(
                    "reference.trajectories.corner_positions_deg",
                    positions.len() as f64,
                    positions.len() == times.len(),
                    || format!("as many entries as `corner_times_s` ({})", times.len()),
                )?;
                let corner = |(time_s, deg): (&f64, &f64)| {
                    self.at_least_zero("reference.trajectories.corner_times_s", *time_s)?;
                    Ok(Corner {
                        tick: (time_s / self.machine.sampling.sample_time_s).round() as u32,
                        position: position("reference.trajectories.corner_positions_deg", *deg)?,
                    })
                };
                times.iter().zip(positions).map(corner).collect()
            }
            Motion::Ramp(_) => Ok(vec![]),
        }
    }

    fn laws(&self, name: &str, table: &machine::Controller) -> Result<FixedVec<Gains, MAX_TERMS>, Error> {
        let laws = match &table.laws {
            Some(laws) => laws.clone(),
            None if name.is_empty() => vec![],
            None => vec![law_called(name).ok_or_else(|| {
                let why = "its name is not that of a law, so `laws` must list the laws that it adds to PD";
                Error::Input(format!("{}: `controller.{name}.laws` is missing; {why}", self.origin))
            })?],
        };
        if laws.contains(&LawName::Ri) && laws.contains(&LawName::Rvi) {
            let why = "both take `ki_v_per_deg_s`";
            return Err(Error::Input(format!(
                "{}: `controller.{name}.laws` has ri and rvi; {why}",
                self.origin
            )));
        }
        let mut gains = FixedVec::new();
        for law in laws {
            let one = self.gains(name, table, law)?;
            if let Some(one) = one
                && gains.push(one).is_err()
            {
                let why = format!("a controller adds at most {MAX_TERMS}");
                return Err(Error::Input(format!(
                    "{}: `controller.{name}.laws` is too long; {why}",
                    self.origin
                )));
            }
        }
        Ok(gains)
    }

    fn gains(&self, name: &str, table: &machine::Controller, law: LawName) -> Result<Option<Gains>, Error> {
        let need = |key: &str, value: Option<f64>| {
            value
                .map(|value| value as f32)
                .ok_or_else(|| Error::Input(format!("{}: `controller.{name}.{key}` is missing", self.origin)))
        };
        Ok(Some(match law {
            LawName::Pd => return Ok(None),
            LawName::Ri => Gains::ResetIntegral(ResetIntegralGains {
                ki: need("ki_v_per_deg_s", table.ki_v_per_deg_s)?,
                theta_ri: need("theta_ri_deg", table.theta_ri_deg)?,
            }),
            LawName::Rvi => Gains::RateVariableIntegral(RateVariableIntegralGains {
                ki: need("ki_v_per_deg_s", table.ki_v_per_deg_s)?,
                gamma: need("gamma_deg2_per_s2", table.gamma_deg2_per_s2)?,
            }),
            LawName::Roi => Gains::ResetOffsetIntegral(ResetOffsetIntegralGains {
                t_roi: need("t_roi_s", table.t_roi_s)?,
                v_roi: need("v_roi_deg_per_s", table.v_roi_deg_per_s)?,
            }),
            LawName::Feedforward => Gains::Feedforward(FeedforwardGains {
                v_slip: need("v_slip_v", table.v_slip_v)?,
                v_ff: need("v_ff_deg_per_s", table.v_ff_deg_per_s)?,
            }),
            LawName::Dnpf => {
                Gains::DiscontinuousNonlinearProportional(DiscontinuousNonlinearProportionalGains {
                    theta_b: need("theta_b_deg", table.theta_b_deg)?,
                })
            }
            LawName::Srnf => Gains::SmoothRobustNonlinear(SmoothRobustNonlinearGains {
                v_ms: need("v_ms_v", table.v_ms_v)?,
                alpha: need("alpha_per_deg", table.alpha_per_deg)?,
            }),
        }))
    }

    fn drive(&self) -> Result<DriveConfig, Error> {
        let drive = &self.machine.drive;
        // Below this the even top no longer fits 16 bits; above, fewer than 16 duties are left.
        let (lowest, highest) = (1300.0, 5.25e6);
        self.check("drive.pwm_hz", drive.pwm_hz, (lowest..=highest).contains(&drive.pwm_hz), || {
            format!("a number from {lowest} to {highest}")
        })?;
        Ok(DriveConfig {
            full_scale: drive.full_scale_v as f32,
            lsb: drive.lsb_v as f32,
            mode: match drive.mode {
                machine::PwmMode::LockedAntiphase => PwmMode::LockedAntiphase,
                machine::PwmMode::SignMagnitude => PwmMode::SignMagnitude,
            },
            pwm_top: DriveConfig::centre_aligned_top(PWM_TIMER_HZ, drive.pwm_hz as f32),
        })
    }

    fn counter_bits(&self) -> Result<CounterBits, Error> {
        match self.machine.encoder.counter_bits {
            16 => Ok(CounterBits::Sixteen),
            32 => Ok(CounterBits::ThirtyTwo),
            other => Err(self.refuse("encoder.counter_bits", f64::from(other), "16 or 32")),
        }
    }

    /// An error of the core with the table in front of its key.
    pub(crate) fn explain(&self, error: &stiction::Error, controller: &str) -> Error {
        let table = match error.key {
            "sample_time_s" | "velocity_window" => "loop.".into(),
            "resolution_deg" => "encoder.".into(),
            "full_scale_v" | "lsb_v" | "pwm_top" => "drive.".into(),
            "corner_times_s" | "half_blend_s" => "reference.trajectories.".into(),
            "autostart_delay_s"
            | "soft_start_s"
            | "dead_time_s"
            | "nominal_supply_v"
            | "supply_full_scale_v" => "device.".into(),
            _ => format!("controller.{controller}."),
        };
        let text = error.to_string();
        let text = text.strip_prefix('`').unwrap_or(&text);
        Error::Input(format!("{}: `{table}{text}", self.origin))
    }

    fn above_zero(&self, key: &str, found: f64) -> Result<(), Error> {
        self.check(key, found, found > 0.0, || "a number above 0".into())
    }

    fn at_least_zero(&self, key: &str, found: f64) -> Result<(), Error> {
        self.check(key, found, found >= 0.0, || "a number not below 0".into())
    }

    fn check(&self, key: &str, found: f64, allowed: bool, what: impl Fn() -> String) -> Result<(), Error> {
        if allowed && found.is_finite() { Ok(()) } else { Err(self.refuse(key, found, &what())) }
    }

    fn refuse(&self, key: &str, found: f64, allowed: &str) -> Error {
        Error::Input(format!("{}: `{key}` is {found}; allowed is {allowed}", self.origin))
    }
}

const fn direction(direction: machine::Direction) -> Direction {
    match direction {
        machine::Direction::Forward => Direction::Forward,
        machine::Direction::Reverse => Direction::Reverse,
    }
}

/// The law that has a controller's name.
fn law_called(name: &str) -> Option<LawName> {
    use serde::Deserialize;
    use serde::de::IntoDeserializer;
    let name: serde::de::value::StrDeserializer<'_, serde::de::value::Error> = name.into_deserializer();
    LawName::deserialize(name).ok()
}

/// A number of counts as whole counts and a fraction below one.
fn counts(counts: f64) -> Position {
    let whole = counts.floor();
    let fraction = (counts - whole) as f32;
    if fraction < 1.0 {
        Position { counts: whole as i32, fraction }
    } else {
        Position::from_counts(whole as i32 + 1)
    }
}
