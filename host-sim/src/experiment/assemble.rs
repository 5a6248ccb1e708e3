//! From a machine's tables to the core's configuration and the models around it. Every value is checked here, once.

use heapless::Vec as FixedVec;
use stiction::compensator::{Gains, MAX_TERMS};
use stiction::drive::DriveConfig;
use stiction::encoder::Encoder;
use stiction::pd::PdGains;
use stiction::position::Position;
use stiction::reference::{Corner, MAX_CORNERS, Reference, Step, Trajectory};
use stiction::value::{About, Table};
use stiction::velocity::MAX_WINDOW;
use stiction::{Controller, ControllerConfig, Course, identification};
use toml::Value;

use super::plan::{MAX_RAMP_SAMPLES, MAX_SAMPLES, Motion, RunPlan};
use crate::closed_loop::{ClosedLoop, Delay};
use crate::encoder::EncoderModel;
use crate::error::{Error, rounded, shown};
use crate::friction::{AddedFriction, Coulomb};
use crate::hardware::STM32F405;
use crate::identification::Ramp;
use crate::machine::{self, LawName, Laws, Machine, PD};
use crate::mechanism::RobotAxis;
use crate::written::{AllGains, Written};

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
        let written = &self.machine.encoder;
        let core = written.core(Encoder::EXAMPLE);
        let phase = written.extras.phase;
        self.above_zero("encoder.resolution_deg", written.resolution_deg())?;
        self.check("encoder.phase", phase, (-1.0..=1.0).contains(&phase), || "a number from -1 to 1".into())?;
        Ok(EncoderModel {
            resolution: written.resolution_deg(),
            rounding: written.extras.rounding,
            phase,
            counter_bits: core.counter_bits,
            direction: core.direction,
        })
    }

    /// The control core with this run's controller; with no controller, all gains are zero.
    ///
    /// # Errors
    /// Names the key, what was found and what is allowed.
    pub fn controller(&self) -> Result<Controller, Error> {
        let name = self.controller.as_deref().unwrap_or_default();
        let config = self.controller_config()?;
        let controller = Controller::new(&config, &STM32F405).map_err(|error| self.explain(&error))?;
        // Also those that none of the laws takes.
        for (key, _) in self.machine.controller.get(name).iter().flat_map(|table| table.iter()) {
            if let Some(gain) = self.machine.controller.get(name).and_then(|table| table.number(key)) {
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
        let none = Written::default();
        let table = machine.controller.get(name).unwrap_or(&none);
        // It may be negative, or too large for the core's type.
        let window = machine.sampling.velocity_window();
        if !(2..=MAX_WINDOW as i64).contains(&window) {
            let allowed = format!("a whole number from 2 to {MAX_WINDOW}");
            return Err(self.refuse("loop.velocity_window", &window.to_string(), &allowed));
        }
        let mut pd = PdGains { kp: 0.0, kd: 0.0 };
        table.apply(PdGains::ABOUT, &mut pd);
        let config = ControllerConfig {
            encoder: machine.encoder.core(Encoder::EXAMPLE),
            drive: machine.drive.core(DriveConfig::EXAMPLE),
            pd,
            compensator: self.laws(name, table)?,
            ..ControllerConfig::EXAMPLE
        };
        Ok(machine.sampling.core(config))
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
            course: self.course()?,
            controller,
            encoder: self.encoder()?,
            lsb_v: machine.drive.lsb_v(),
            sample_time_s: machine.sampling.sample_time_s(),
            delay,
            axis: self.axis()?,
        })
    }

    /// How many samples the run has after its first.
    ///
    /// # Errors
    /// Names the duration if it is not a positive number of at most ten million samples.
    pub fn samples(&self) -> Result<u32, Error> {
        let sample_time_s = self.machine.sampling.sample_time_s();
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
                3.0 * drive.full_scale_v() / rate + hold_s + AFTER_A_RAMP_S
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
        let longest_s = MAX_RAMP_SAMPLES * sampling.sample_time_s();
        self.check("identification.hold_s", hold_s, (0.0..=longest_s).contains(&hold_s), || {
            format!("a number from 0 to {}", rounded(longest_s))
        })?;
        let slowest = 3.0 * drive.full_scale_v() / longest_s;
        let fastest = drive.full_scale_v() / sampling.sample_time_s();
        self.check(&self.asked_by, rate, (slowest..=fastest).contains(&rate), || {
            format!("a number from {} to {}", rounded(slowest), rounded(fastest))
        })?;
        let core = identification::Ramp::new(
            rate as f32,
            hold_s as f32,
            sampling.sample_time_s() as f32,
            drive.full_scale_v() as f32,
        );
        let core = core.map_err(|error| self.explain(&error))?;
        Ok(Ramp { core, rate, hold_s, sample_time_s: sampling.sample_time_s() })
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
                    (sampling.sample_time_s() as f32, encoder.resolution_deg() as f32);
                Trajectory::new(&corners, trajectory.half_blend_s as f32, sample_time, resolution)
                    .map(Reference::Trajectory)
                    .map_err(|error| self.explain(&error))
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
        let resolution = self.machine.encoder.resolution_deg();
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
        let (shortest_s, latest_s) = (0.5 * sampling.sample_time_s(), MAX_SAMPLES * sampling.sample_time_s());
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
                tick: (time_s / sampling.sample_time_s()).round() as u32,
                position: self.position(&format!("{positions_key}[{i}]"), *deg)?,
            });
        }
        if positions.windows(2).all(|pair| pair[0] == pair[1]) {
            let found = format!("{} throughout", shown(positions[0]));
            return Err(self.refuse(&positions_key, &found, "a motion from one position to another"));
        }
        Ok(corners)
    }

    /// The laws of this run's controller; none for a ramp. What is wrong with them has been told before.
    pub(crate) fn laws_in_use(&self) -> Vec<Gains> {
        self.controller_config().map_or(vec![], |config| config.compensator.iter().copied().collect())
    }

    fn laws(&self, name: &str, table: &Written<AllGains, Laws>) -> Result<FixedVec<Gains, MAX_TERMS>, Error> {
        let key = format!("controller.{name}.laws");
        let origin = self.origin.of(&key);
        let laws = match &table.extras.laws {
            Some(laws) => laws.clone(),
            None if name.is_empty() => vec![],
            None => vec![LawName::find(name).ok_or_else(|| {
                let why =
                    "a controller with a name of its own lists the laws that it adds to PD, as in [\"srnf\"]";
                Error::Input(format!("{origin}: `{key}` is missing: {why}"))
            })?],
        };
        let twice = laws.iter().enumerate().find(|(i, law)| laws[..*i].contains(law));
        if let Some((i, _)) = twice {
            return Err(Error::Input(format!("{origin}: `{key}[{i}]` names a law for the second time")));
        }
        if let Some((one, other, shared)) = sharing(&laws) {
            let why = format!("only one of them is allowed, since both take `{shared}`");
            return Err(Error::Input(format!("{origin}: `{key}` has {one} and {other}; {why}")));
        }
        if let Some(law) =
            laws.iter().find(|law| law.0.is_some_and(|law| law.replaces_pd()) && laws.len() > 1)
        {
            let why = "it takes the place of PD, and stands alone";
            return Err(Error::Input(format!("{origin}: `{key}` has {} and another law; {why}", law.name())));
        }
        let mut gains = FixedVec::new();
        for law in laws.iter().filter_map(|law| law.0) {
            if gains.push(self.gains(name, table, law)?).is_err() {
                let why = format!("allowed are {MAX_TERMS}, not counting {PD}");
                return Err(Error::Input(format!("{origin}: `{key}` has too many entries; {why}")));
            }
        }
        Ok(gains)
    }

    /// The law with the gains of a table, each of which has to be there.
    fn gains(&self, name: &str, table: &Written<AllGains, Laws>, mut law: Gains) -> Result<Gains, Error> {
        let about = about_law(&law);
        if let Some(gone) = about.iter().find(|about| table.number(about.name).is_none()) {
            let key = format!("controller.{name}.{}", gone.name);
            let (origin, law) = (self.origin.of(&format!("controller.{name}.laws")), law.name());
            return Err(Error::Input(format!("{origin}: `{key}` is missing; the law {law} needs it")));
        }
        table.apply(about, &mut law);
        Ok(law)
    }

    /// An error of the core with the value as it was written. The value's declaration says in which table it is.
    pub(crate) fn explain(&self, error: &stiction::Error) -> Error {
        let Some(about) = error.key.about() else { return Error::Input(error.to_string()) };
        let controller = self.controller.as_deref().unwrap_or_default();
        let path = match (about.table, about.name) {
            ("controller", key) => format!("controller.{controller}.{key}"),
            ("reference", _) => self.asked_by.clone(),
            ("reference.trajectories", key) => format!("{}.{key}", self.asked_by),
            ("identification", "ramp_rates_v_per_s") => self.asked_by.clone(),
            (table, key) => format!("{table}.{key}"),
        };
        let written = match (about.name, &self.motion) {
            ("ramp_rates_v_per_s", Motion::Ramp(rate)) => Some(*rate),
            _ => self.value_at(&path.split('.').collect::<Vec<_>>()).and_then(|value| value.as_float()),
        };
        let mut found = shown(error.found.into());
        if let Some(written) = written {
            let vanishes = error.found == 0.0 && written != 0.0;
            found = shown(written) + if vanishes { ", which is 0 in single precision" } else { "" };
        }
        self.refuse(&path, &found, &error.allowed.to_string())
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

/// The declarations of a law's gains.
pub(crate) fn about_law(law: &Gains) -> &'static [About] {
    let place = Gains::EXAMPLES.iter().position(|example| example.id() == law.id());
    place.and_then(|place| Gains::ABOUT.get(place)).copied().unwrap_or_default()
}

/// Two laws of a list that take the same key of a table, and that key.
fn sharing(laws: &[LawName]) -> Option<(&'static str, &'static str, &'static str)> {
    let all: Vec<Gains> = laws.iter().filter_map(|law| law.0).collect();
    all.iter().enumerate().find_map(|(i, one)| {
        all.iter().skip(i + 1).find_map(|other| {
            let shares = |about: &&About| about_law(other).iter().any(|b| b.name == about.name);
            let shared = about_law(one).iter().find(shares)?;
            Some((one.name(), other.name(), shared.name))
        })
    })
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
