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
use stiction::reference::{Corner, MAX_CORNERS, Reference, Step, Trajectory};
use stiction::velocity::MAX_WINDOW;
use stiction::{Controller, ControllerConfig, Course, identification};
use toml::Value;

use super::plan::{MAX_RAMP_SAMPLES, MAX_SAMPLES, Motion, RunPlan};
use crate::closed_loop::{ClosedLoop, Delay};
use crate::encoder::EncoderModel;
use crate::error::{Error, rounded, shown};
use crate::friction::{AddedFriction, Coulomb};
use crate::identification::Ramp;
use crate::limits::LimitsTable;
use crate::machine::{self, LawName, Machine};
use crate::mechanism::RobotAxis;

/// Clock of the STM32F405's TIM1, which makes the PWM: the host computes the same compare values as the board.
const PWM_TIMER_HZ: f32 = 168e6;

/// Two positions that are this far apart still differ by less than 2^31 counts.
const MAX_COUNTS: f64 = 1_073_741_823.0;

/// So long after the last count a ramp is over.
const AFTER_A_RAMP_S: f64 = 1.0;

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
            format!("a number not below `slip_v` ({})", shown(friction.slip_v))
        })?;
        let lowest = -friction.slip_v;
        self.check("joint.friction.added_v", friction.added_v, friction.added_v >= lowest, || {
            format!("a number not below {} (minus `slip_v`)", shown(lowest))
        })?;
        for (i, [from, to]) in friction.added_during_s.iter().flatten().enumerate() {
            if !(from.is_finite() && to.is_finite() && from < to) {
                let found = format!("[{}, {}]", shown(*from), shown(*to));
                let key = format!("joint.friction.added_during_s[{i}]");
                return Err(self.refuse(&key, &found, "a begin and a later end, both finite"));
            }
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
        let controller =
            Controller::new(&self.controller_config()?).map_err(|error| self.explain(&error, name))?;
        // Also those that none of the laws takes.
        for (key, gain) in self.value_at(&["controller", name]).iter().flat_map(Value::as_table).flatten() {
            if let Some(gain) = gain.as_float() {
                self.at_least_zero(&format!("controller.{name}.{key}"), gain)?;
            }
        }
        Ok(controller)
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
        let window = machine.sampling.velocity_window;
        if !(2..=MAX_WINDOW).contains(&window) {
            let allowed = format!("a whole number from 2 to {MAX_WINDOW}");
            return Err(self.refuse("loop.velocity_window", &window.to_string(), &allowed));
        }
        Ok(ControllerConfig {
            sample_time: machine.sampling.sample_time_s as f32,
            encoder: Encoder {
                resolution: machine.encoder.resolution_deg as f32,
                counter_bits: self.counter_bits()?,
                direction: direction(machine.encoder.direction),
            },
            velocity_window: window,
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
            other => return Err(self.refuse("run.delay_samples", &other.to_string(), "0 or 1")),
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
    /// Names the duration if it is not a positive number of at most ten million samples.
    pub fn samples(&self) -> Result<u32, Error> {
        let sample_time_s = self.machine.sampling.sample_time_s;
        let duration_s = self.duration_s();
        let samples = (duration_s / sample_time_s).round();
        self.check("run.duration_s", duration_s, (1.0..=MAX_SAMPLES).contains(&samples), || {
            let longest_s = rounded(MAX_SAMPLES * sample_time_s);
            format!("a number from {} (one sample) to {longest_s}", shown(sample_time_s))
        })?;
        Ok(samples as u32)
    }

    /// The longest that the run can take, s.
    pub fn longest_s(&self) -> f64 {
        let Machine { drive, identification, .. } = &*self.machine;
        match self.motion {
            Motion::Ramp(rate) => {
                let hold_s = identification.as_ref().map_or(0.0, |ramps| ramps.hold_s);
                // Up to the full scale, and down to its negative.
                3.0 * drive.full_scale_v / rate + hold_s + AFTER_A_RAMP_S
            }
            Motion::Step(_) | Motion::Trajectory(_) => self.duration_s(),
        }
    }

    /// A ramp of the effort.
    ///
    /// # Errors
    /// Names the rate or the hold if the ramp would take no time or too long.
    pub fn ramp(&self, rate: f64) -> Result<Ramp, Error> {
        let Machine { sampling, drive, identification, run, .. } = &*self.machine;
        if let Some(duration_s) = run.duration_s {
            self.above_zero("run.duration_s", duration_s)?;
        }
        let hold_s = identification.as_ref().map_or(0.0, |ramps| ramps.hold_s);
        let longest_s = MAX_RAMP_SAMPLES * sampling.sample_time_s;
        self.check("identification.hold_s", hold_s, (0.0..=longest_s).contains(&hold_s), || {
            format!("a number from 0 to {}", rounded(longest_s))
        })?;
        let slowest = 3.0 * drive.full_scale_v / longest_s;
        let fastest = drive.full_scale_v / sampling.sample_time_s;
        self.check(&self.asked_by, rate, (slowest..=fastest).contains(&rate), || {
            format!("a number from {} to {}", rounded(slowest), rounded(fastest))
        })?;
        let core = identification::Ramp::new(
            rate as f32,
            hold_s as f32,
            sampling.sample_time_s as f32,
            drive.full_scale_v as f32,
        );
        let core = core.map_err(|error| self.explain(&error, ""))?;
        Ok(Ramp { core, rate, hold_s, sample_time_s: sampling.sample_time_s })
    }

    /// What the core runs.
    ///
    /// # Errors
    /// Names the key, what was found and what is allowed.
    pub fn course(&self) -> Result<Course, Error> {
        match self.motion {
            Motion::Ramp(rate) => Ok(Course::Ramp(self.ramp(rate)?.core)),
            Motion::Step(_) | Motion::Trajectory(_) => self.reference().map(Course::Follow),
        }
    }

    /// How long a step or a trajectory is run: as the file says, or else by its kind.
    pub fn duration_s(&self) -> f64 {
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
                let Machine { sampling, encoder, .. } = &*self.machine;
                let (sample_time, resolution) =
                    (sampling.sample_time_s as f32, encoder.resolution_deg as f32);
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
        match &self.motion {
            Motion::Step(step) => {
                let position = self.position(&self.asked_by, *step)?;
                if *step == 0.0 {
                    return Err(self.refuse(&self.asked_by, "0", "a step other than 0"));
                }
                Ok(vec![Corner { tick: 0, position }])
            }
            Motion::Trajectory(trajectory) => self.trajectory_corners(trajectory),
            Motion::Ramp(_) => Ok(vec![]),
        }
    }

    fn position(&self, key: &str, deg: f64) -> Result<Position, Error> {
        let resolution = self.machine.encoder.resolution_deg;
        self.check(key, deg, (deg / resolution).abs() <= MAX_COUNTS, || {
            let furthest = rounded(MAX_COUNTS * resolution);
            format!("a number from -{furthest} to {furthest}, 2^30 counts")
        })?;
        Ok(counts(deg / resolution))
    }

    fn trajectory_corners(&self, trajectory: &machine::Trajectory) -> Result<Vec<Corner>, Error> {
        let sampling = &self.machine.sampling;
        let (times, positions) = (&trajectory.corner_times_s, &trajectory.corner_positions_deg);
        let half_blend_s = trajectory.half_blend_s;
        let key = |key: &str| format!("{}.{key}", self.asked_by);
        let (times_key, positions_key) = (key("corner_times_s"), key("corner_positions_deg"));
        let entries = |key: &str, found: usize, allowed: String| {
            let origin = self.origin.of(key);
            Err(Error::Input(format!("{origin}: `{key}` has {found} entries; allowed are {allowed}")))
        };
        if !(2..=MAX_CORNERS).contains(&times.len()) {
            return entries(&times_key, times.len(), format!("2 to {MAX_CORNERS}"));
        }
        if positions.len() != times.len() {
            let allowed = format!("as many as in `corner_times_s` ({})", times.len());
            return entries(&positions_key, positions.len(), allowed);
        }
        let (shortest_s, latest_s) = (0.5 * sampling.sample_time_s, MAX_SAMPLES * sampling.sample_time_s);
        self.check(
            &key("half_blend_s"),
            half_blend_s,
            (shortest_s..=latest_s).contains(&half_blend_s),
            || format!("a number from {} (half a sample) to {}", shown(shortest_s), rounded(latest_s)),
        )?;
        let mut corners = Vec::new();
        let mut before_s = -half_blend_s;
        for (i, (time_s, deg)) in times.iter().zip(positions).enumerate() {
            let earliest_s = before_s + 2.0 * half_blend_s;
            // Sums of decimals differ in the last digit from the decimal that was written.
            let in_order = (earliest_s * (1.0 - 1e-9)..=latest_s).contains(time_s);
            self.check(&format!("{times_key}[{i}]"), *time_s, in_order, || {
                let why = if i == 0 { "half a blend" } else { "two half blends after the corner before" };
                format!("a number from {} ({why}) to {}", rounded(earliest_s), rounded(latest_s))
            })?;
            before_s = *time_s;
            corners.push(Corner {
                tick: (time_s / sampling.sample_time_s).round() as u32,
                position: self.position(&format!("{positions_key}[{i}]"), *deg)?,
            });
        }
        if positions.windows(2).all(|pair| pair[0] == pair[1]) {
            let found = format!("{} throughout", shown(positions[0]));
            return Err(self.refuse(&positions_key, &found, "a motion from one position to another"));
        }
        Ok(corners)
    }

    fn laws(&self, name: &str, table: &machine::Controller) -> Result<FixedVec<Gains, MAX_TERMS>, Error> {
        let key = format!("controller.{name}.laws");
        let origin = self.origin.of(&key);
        let laws = match &table.laws {
            Some(laws) => laws.clone(),
            None if name.is_empty() => vec![],
            None => vec![law_called(name).ok_or_else(|| {
                let why =
                    "a controller with a name of its own lists the laws that it adds to PD, as in [\"srnf\"]";
                Error::Input(format!("{origin}: `{key}` is missing: {why}"))
            })?],
        };
        let twice = laws.iter().enumerate().find(|(i, law)| laws[..*i].contains(law));
        if let Some((i, _)) = twice {
            return Err(Error::Input(format!("{origin}: `{key}[{i}]` names a law for the second time")));
        }
        if laws.contains(&LawName::Ri) && laws.contains(&LawName::Rvi) {
            let why = "only one of them is allowed, since both take `ki_v_per_deg_s`";
            return Err(Error::Input(format!("{origin}: `{key}` has ri and rvi; {why}")));
        }
        let mut gains = FixedVec::new();
        for law in laws {
            let one = self.gains(name, table, law)?;
            if let Some(one) = one
                && gains.push(one).is_err()
            {
                let why = format!("allowed are {MAX_TERMS}, not counting pd");
                return Err(Error::Input(format!("{origin}: `{key}` has too many entries; {why}")));
            }
        }
        Ok(gains)
    }

    fn gains(&self, name: &str, table: &machine::Controller, law: LawName) -> Result<Option<Gains>, Error> {
        let need = |key: &str, value: Option<f64>| {
            value.map(|value| value as f32).ok_or_else(|| {
                let key = format!("controller.{name}.{key}");
                let origin = self.origin.of(&format!("controller.{name}.laws"));
                let law = format!("{law:?}").to_lowercase();
                Error::Input(format!("{origin}: `{key}` is missing; the law {law} needs it"))
            })
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
            other => Err(self.refuse("encoder.counter_bits", &other.to_string(), "16 or 32")),
        }
    }

    /// An error of the core with the table in front of its key, and the value as it was written.
    pub(crate) fn explain(&self, error: &stiction::Error, controller: &str) -> Error {
        let tables = match error.key {
            "sample_time_s" | "velocity_window" => vec!["loop"],
            "resolution_deg" => vec!["encoder"],
            "full_scale_v" | "lsb_v" | "pwm_top" => vec!["drive"],
            "corner_times_s" | "half_blend_s" => vec![self.asked_by.as_str()],
            "autostart_delay_s"
            | "soft_start_s"
            | "dead_time_s"
            | "nominal_supply_v"
            | "supply_full_scale_v" => {
                vec!["device"]
            }
            "hold_s" => vec!["identification"],
            key if LimitsTable::KEYS.contains(&key) => vec!["limits"],
            _ => vec!["controller", controller],
        };
        let mut path = [&tables[..], &[error.key]].concat();
        let mut written = self.value_at(&path).and_then(|value| value.as_float());
        if let ("ramp_rates_v_per_s", Motion::Ramp(rate)) = (error.key, &self.motion) {
            (path, written) = (vec![self.asked_by.as_str()], Some(*rate));
        }
        let mut found = shown(error.found.into());
        if let Some(written) = written {
            let vanishes = error.found == 0.0 && written != 0.0;
            found = shown(written) + if vanishes { ", which is 0 in single precision" } else { "" };
        }
        let text = error.to_string();
        let allowed = text.split_once("; allowed is ").map_or(&*text, |(_, allowed)| allowed);
        self.refuse(&path.join("."), &found, allowed)
    }

    /// A value of the machine by its key.
    fn value_at(&self, path: &[&str]) -> Option<Value> {
        let machine = Value::try_from(&*self.machine).ok()?;
        path.iter().try_fold(machine, |value, key| value.get(key).cloned())
    }

    fn above_zero(&self, key: &str, found: f64) -> Result<(), Error> {
        self.check(key, found, found > 0.0, || "a number above 0".into())
    }

    fn at_least_zero(&self, key: &str, found: f64) -> Result<(), Error> {
        self.check(key, found, found >= 0.0, || "a number not below 0".into())
    }

    fn check(&self, key: &str, found: f64, allowed: bool, what: impl Fn() -> String) -> Result<(), Error> {
        if allowed && found.is_finite() { Ok(()) } else { Err(self.refuse(key, &shown(found), &what())) }
    }

    fn refuse(&self, key: &str, found: &str, allowed: &str) -> Error {
        // A person may take infinity for a number.
        let finite = if found.ends_with("inf") {
            allowed.replacen("a number", "a finite number", 1)
        } else {
            allowed.into()
        };
        Error::Input(format!("{}: `{key}` is {found}; allowed is {finite}", self.origin.of(key)))
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
pub fn position(counts: f64) -> Position {
    self::counts(counts)
}

fn counts(counts: f64) -> Position {
    let whole = counts.floor();
    let fraction = (counts - whole) as f32;
    if fraction < 1.0 {
        Position { counts: whole as i32, fraction }
    } else {
        Position::from_counts(whole as i32 + 1)
    }
}
