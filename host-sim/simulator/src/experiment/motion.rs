//! Makes the core's motion, and its course, from the task of a run.

use stiction::control::reference::{Corner, MAX_CORNERS};
use stiction::units::position::Position;
use stiction::units::value::Table as _;
use stiction::{Course, Motion, ProfileLimits, identification};

use super::plan::{MAX_RAMP_SAMPLES, MAX_SAMPLES, RunPlan};
use super::task::Task;
use crate::identification::RampTest;
use files::error::{Error, rounded, shown};
use files::machine::{MachineFile, SineTable, TrajectoryTable};

/// Largest position, counts: the difference of two positions is below 2^31.
const MAX_COUNTS: f64 = 1_073_741_823.0;

/// Periods of a sine in a run whose duration the file does not set.
const SINE_PERIODS: f64 = 3.0;

/// Time after the last count until a ramp ends, s.
const AFTER_A_RAMP_S: f64 = 1.0;

impl RunPlan {
    /// Returns the longest time of the run, s.
    pub fn longest_s(&self) -> f64 {
        let MachineFile { drive, identification, .. } = &*self.machine;
        match self.task {
            Task::Ramp(rate) => {
                let hold_s = identification.as_ref().map_or(0.0, |ramps| ramps.hold_s);
                // Up to the full scale, and down to its negative.
                3.0 * drive.full_scale_v() / rate + hold_s + AFTER_A_RAMP_S
            }
            Task::Step(_) | Task::Trajectory(_) | Task::Sine(_) => self.duration_s(),
        }
    }

    /// Returns a ramp of the effort with a rate, V/s.
    ///
    /// # Errors
    /// Returns an error about the rate or the hold time if the ramp would be too short or too long.
    pub fn ramp(&self, rate: f64) -> Result<RampTest, Error> {
        let MachineFile { sampling, drive, identification, run, .. } = &*self.machine;
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
        Ok(RampTest { core, rate, hold_s, sample_time_s: sampling.sample_time_s() })
    }

    /// Returns the motion for a device: in counts from the position at arming, in single precision.
    ///
    /// # Errors
    /// Returns an error with the key, the value found and the allowed values.
    pub fn motion(&self) -> Result<Motion, Error> {
        Ok(match &self.task {
            Task::Step(deg) => Motion::Step(self.target(*deg)?),
            Task::Trajectory(trajectory) => Motion::Trajectory {
                corners: self.corners(trajectory)?.into_iter().collect(),
                half_blend: trajectory.half_blend_s as f32,
            },
            Task::Sine(sine) => self.sine(sine)?,
            Task::Ramp(rate) => {
                let ramp = self.ramp(*rate)?;
                Motion::Ramp { rate: ramp.rate as f32, hold: ramp.hold_s as f32 }
            }
        })
    }

    /// Returns the core's course of the motion, for the loop of this run.
    ///
    /// # Errors
    /// Returns an error with the key, the value found and the allowed values.
    pub fn course(&self) -> Result<Course, Error> {
        let motion = self.motion()?;
        // A task is never a profiled move.
        let course = motion.course(&self.controller_config()?, &ProfileLimits::EXAMPLE);
        course.map_err(|error| self.explain(&error))
    }

    /// Returns the duration of a closed loop's run, s: that of the file, or a default for the kind
    /// of motion.
    pub fn duration_s(&self) -> f64 {
        let by_default = match &self.task {
            Task::Step(_) | Task::Ramp(_) => 10.0,
            Task::Trajectory(trajectory) => {
                trajectory.corner_times_s.last().copied().unwrap_or(0.0) + 3.0
            }
            Task::Sine(sine) => (SINE_PERIODS / sine.frequency_hz).max(10.0),
        };
        self.machine.run.duration_s.unwrap_or(by_default)
    }

    /// Returns the target of a step.
    fn target(&self, deg: f64) -> Result<Position, Error> {
        let position = self.position(&self.asked_by, deg)?;
        if deg == 0.0 {
            return Err(self.refuse(&self.asked_by, "0", "a step other than 0"));
        }
        Ok(position)
    }

    /// Returns the motion of a sine that starts at the zero of the run.
    fn sine(&self, sine: &SineTable) -> Result<Motion, Error> {
        let SineTable { amplitude_deg, frequency_hz } = *sine;
        let key = |key: &str| format!("{}.{key}", self.asked_by);
        if amplitude_deg == 0.0 {
            return Err(self.refuse(&key("amplitude_deg"), "0", "an amplitude other than 0"));
        }
        // The far turn, two amplitudes away, must be a valid position, too.
        let most = 0.5 * MAX_COUNTS * self.machine.count_deg();
        self.check(&key("amplitude_deg"), amplitude_deg, amplitude_deg.abs() <= most, || {
            let most = rounded(most);
            format!("a number from -{most} to {most} deg, which is 2^29 counts")
        })?;
        let sample_time_s = self.machine.sampling.sample_time_s();
        let (slowest, fastest) = (1.0 / (MAX_SAMPLES * sample_time_s), 0.25 / sample_time_s);
        let is_allowed = (slowest..=fastest).contains(&frequency_hz);
        self.check(&key("frequency_hz"), frequency_hz, is_allowed, || {
            let fastest = rounded(fastest);
            format!("a number from {} to {fastest} (a quarter of the sample rate)", shown(slowest))
        })?;
        let amplitude = (amplitude_deg / self.machine.count_deg()) as f32;
        let frequency = frequency_hz as f32;
        Ok(Motion::Sine { from: Position::default(), amplitude, frequency })
    }

    fn position(&self, key: &str, deg: f64) -> Result<Position, Error> {
        let resolution = self.machine.count_deg();
        self.check(key, deg, (deg / resolution).abs() <= MAX_COUNTS, || {
            let furthest = rounded(MAX_COUNTS * resolution);
            format!("a number from -{furthest} to {furthest} deg, which is 2^30 counts")
        })?;
        Ok(position(deg / resolution))
    }

    fn corners(&self, trajectory: &TrajectoryTable) -> Result<Vec<Corner>, Error> {
        let sampling = &self.machine.sampling;
        let (times, positions) = (&trajectory.corner_times_s, &trajectory.corner_positions_deg);
        let half_blend_s = trajectory.half_blend_s;
        let key = |key: &str| format!("{}.{key}", self.asked_by);
        let (times_key, positions_key) = (key("corner_times_s"), key("corner_positions_deg"));
        let entries = |key: &str, found: usize, allowed: String| {
            let origin = self.origin.of(key);
            Err(Error::Input(format!("{origin}: `{key}` has {found} entries; must have {allowed}")))
        };
        if !(2..=MAX_CORNERS).contains(&times.len()) {
            return entries(&times_key, times.len(), format!("2 to {MAX_CORNERS}"));
        }
        if positions.len() != times.len() {
            let allowed = format!("as many as in `corner_times_s` ({})", times.len());
            return entries(&positions_key, positions.len(), allowed);
        }
        let (shortest_s, latest_s) =
            (0.5 * sampling.sample_time_s(), MAX_SAMPLES * sampling.sample_time_s());
        self.check(
            &key("half_blend_s"),
            half_blend_s,
            (shortest_s..=latest_s).contains(&half_blend_s),
            || {
                format!(
                    "a number from {} (half a sample) to {}",
                    shown(shortest_s),
                    rounded(latest_s)
                )
            },
        )?;
        let mut corners = Vec::new();
        let mut before_s = -half_blend_s;
        for (i, (time_s, deg)) in times.iter().zip(positions).enumerate() {
            let earliest_s = before_s + 2.0 * half_blend_s;
            // Sums of decimals can differ from the written decimal in the last digit.
            let in_order = (earliest_s * (1.0 - 1e-9)..=latest_s).contains(time_s);
            self.check(&format!("{times_key}[{i}]"), *time_s, in_order, || {
                let why =
                    if i == 0 { "`half_blend_s`" } else { "previous corner + 2 `half_blend_s`" };
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
            return Err(self.refuse(
                &positions_key,
                &found,
                "a motion from one position to another",
            ));
        }
        Ok(corners)
    }
}

/// Splits a number of counts into whole counts and a fraction below one.
pub fn position(counts: f64) -> Position {
    let whole = counts.floor();
    let fraction = (counts - whole) as f32;
    if fraction < 1.0 {
        Position { counts: whole as i32, fraction }
    } else {
        Position::from_counts(whole as i32 + 1)
    }
}
