//! The machine that the device drives, as a document: the device's parameters with the joint of a
//! machine's file.
//!
//! The device's parameters do not describe its joint, so the file provides the joint. The document
//! also has the other controllers of the file, with the file's gains. Variants of the file are
//! ignored; if it has only variants, the first one is used, as for a simulated device. Features of
//! a data sheet beyond the rigid joint stay as in the file: a load, gravity, backlash, a shaft,
//! bristles, the winding's lag. The four keys of the joint scale its inertia and its friction.
//! Limits: a dead time, the supply's limits and the encoder's noise are left out, as in a simulated
//! device. The angle of gravity counts from the position at arming, like the device's position.

use stiction::units::position::Position;
use stiction::{Motion, Parameters};
use toml::{Table, Value};

use super::request::RequestedMotion;
use files::data_sheet::{SheetFactors, UnseenSlack};
use files::error::Error;
use files::machine::{JointTable, TrajectoryTable};
use simulator::device::machine_file;
use simulator::experiment::{Document, Experiment, RunPlan, Task};

/// Returns the error of an operation whose joint is unknown. `so` names the consequence.
pub fn no_joint(so: &str) -> Error {
    Error::Input(format!(
        "the joint is not known, so {so}: the studio was started without a machine's file. \
         Identify the joint in the step Identify, or end the studio and start it with its file: \
         `stiction studio --port DEV FILE.toml`"
    ))
}

/// Document of the machine in use, with its controllers.
#[derive(Clone, Debug)]
pub struct MachineInUse {
    /// The device's parameters with the joint.
    pub document: Document,
    /// The controller in use.
    pub law: String,
    /// All controllers, the one in use first.
    pub laws: Vec<String>,
    /// The run of the file that provides the joint.
    lent: RunPlan,
    file: Document,
    parameters: Parameters,
}

impl MachineInUse {
    /// Combines the parameters of a device with the joint of a machine's file.
    ///
    /// # Errors
    /// Reports what is wrong with the file, or that no file can express the parameters.
    pub fn new(parameters: &Parameters, of: &Document) -> Result<Self, Error> {
        let machine = &of.origin.name;
        // As for a simulated device.
        let first = Experiment::plan(of, &[], &[])?.into_first();
        let nothing = || Error::Input(format!("{machine}: there is nothing to run"));
        let first = first.ok_or_else(nothing)?;
        let lent = &*first.machine;
        // A file cannot express a motion that only holds.
        let motion = Motion::Step(Position::from_counts(1));
        let asked = Parameters { motion, ..parameters.clone() };
        let bad = |error: &dyn std::fmt::Display| Error::Input(error.to_string());
        let text = machine_file::render(&asked, &lent.joint, machine)?;
        let mut table: Table = toml::from_str(&text).map_err(|error| bad(&error))?;
        let law = table.get("loop").and_then(|own| own.get("controller"));
        let law = law.and_then(Value::as_str).unwrap_or_default().to_owned();
        let of_file = Table::try_from(lent).map_err(|error| bad(&error))?;
        let mut laws = vec![law.clone()];
        if let (Some(Value::Table(all)), Some(Value::Table(others))) =
            (table.get_mut("controller"), of_file.get("controller"))
        {
            for (name, gains) in others.iter().filter(|(name, _)| **name != law) {
                all.insert(name.clone(), gains.clone());
                laws.push(name.clone());
            }
        }
        let delay = i64::from(lent.run.delay_samples);
        let run = Table::from_iter([("delay_samples".to_owned(), Value::Integer(delay))]);
        table.insert("run".into(), run.into());
        for lent in ["spread", "goal"] {
            if let Some(lines) = of_file.get(lent) {
                table.insert(lent.into(), lines.clone());
            }
        }
        let text = toml::to_string(&table).map_err(|error| bad(&error))?;
        let document = Document::parse("the machine in use", &text)?;
        let (file, parameters) = (of.clone(), parameters.clone());
        Ok(Self { document, law, laws, lent: first, file, parameters })
    }

    /// Returns the file if it is a data sheet.
    pub fn sheet(&self) -> Option<&Document> {
        self.file.get("motor").map(|_| &self.file)
    }

    /// Returns whether motor and load have an encoder each. The loop has that of the load.
    pub fn has_two_encoders(&self) -> bool {
        self.parameters.controller.motor.count().is_some()
    }

    /// Returns the slack of the joint's gear that its encoder cannot measure.
    ///
    /// # Errors
    /// Returns an error that names the invalid value.
    pub fn unseen_slack(&self) -> Result<Option<UnseenSlack>, Error> {
        self.lent.unseen_slack()
    }

    /// Returns the machine with keys of its file set to drawn values, `table.key=value` each.
    ///
    /// # Errors
    /// Returns an error that names a value that no joint can have.
    pub fn drawn(&self, keys: &[String]) -> Result<Self, Error> {
        let mut file = self.file.clone();
        file.draw(keys)?;
        Self::new(&self.parameters, &file)
    }

    /// Plans a controller's step with keys set, `table.key=value` each.
    ///
    /// # Errors
    /// Returns an error that names an unknown key or an invalid value.
    pub fn plan(&self, law: &str, set: &[String]) -> Result<RunPlan, Error> {
        let mut document = self.document.clone();
        document.set(set)?;
        let mut runs = Experiment::plan(&document, &[law.to_owned()], &[])?.runs;
        // A plan without runs is an error above.
        let mut plan = runs.swap_remove(0);
        let times = times(&plan.machine.joint, &self.lent.machine.joint);
        plan.substitute = self.lent.beyond_an_axis(&times)?;
        Ok(plan)
    }

    /// Plans a controller's move from a position, deg from where the joint was armed. The position
    /// affects only gravity and friction that depends on the angle.
    ///
    /// # Errors
    /// Returns the errors of [`plan`](Self::plan).
    pub fn plan_from(&self, deg: f64, law: &str, set: &[String]) -> Result<RunPlan, Error> {
        let mut plan = self.plan(law, set)?;
        if let Some(beyond) = &mut plan.substitute {
            beyond.joint = beyond.joint.begun_at(deg.to_radians());
        }
        Ok(plan)
    }

    /// Converts a request into the device's motion: positions in counts from the zero of the
    /// arming.
    ///
    /// # Errors
    /// Returns an error that names an invalid position or time.
    pub fn motion(&self, way: &RequestedMotion) -> Result<Motion, Error> {
        let plan = self.plan(&self.law, &[])?;
        motion(&plan, way)
    }
}

/// Returns the ratios of the parameters of joint `is` to those of joint `of`. A parameter that is 0
/// in `of` has no slider, and its ratio is 1.
fn times(is: &JointTable, of: &JointTable) -> SheetFactors {
    let ratio = |over: f64, under: f64| if under == 0.0 { 1.0 } else { over / under };
    SheetFactors {
        // The gain is the inverse of the inertia.
        inertia: ratio(of.gain_deg_per_s2_per_v, is.gain_deg_per_s2_per_v),
        slip: ratio(is.friction.slip_v, of.friction.slip_v),
        stick: ratio(is.friction.stick_v, of.friction.stick_v),
        viscous: ratio(is.viscous_v_per_deg_per_s, of.viscous_v_per_deg_per_s),
    }
}

/// Converts a request into the motion of a plan.
///
/// # Errors
/// Returns the errors of [`MachineInUse::motion`].
pub fn motion(plan: &RunPlan, way: &RequestedMotion) -> Result<Motion, Error> {
    let (task, asked_by) = match way {
        // A step to the present position has no size.
        RequestedMotion::Move(deg) | RequestedMotion::Step(deg) if *deg == 0.0 => {
            let here = Position::from_counts(0);
            return Ok(if let RequestedMotion::Move(_) = way {
                Motion::Profiled(here)
            } else {
                Motion::Step(here)
            });
        }
        RequestedMotion::Move(deg) | RequestedMotion::Step(deg) => {
            (Task::Step(*deg), "the position")
        }
        RequestedMotion::Trajectory(trajectory) => {
            (Task::Trajectory(trajectory.clone()), "trajectory")
        }
    };
    let motion = RunPlan { task, asked_by: asked_by.into(), ..plan.clone() }.motion()?;
    Ok(match (way, motion) {
        (RequestedMotion::Move(_), Motion::Step(to)) => Motion::Profiled(to),
        (_, motion) => motion,
    })
}

/// Returns the first trajectory of a machine's file.
///
/// # Errors
/// Returns an error if the file has no trajectory.
pub fn first_trajectory(of: &Document) -> Result<TrajectoryTable, Error> {
    let mut all = of.machine()?.reference.trajectories;
    if all.is_empty() {
        return Err(Error::Input(format!(
            "{}: no trajectory in `reference.trajectories`; enter distance and speed",
            of.origin.name
        )));
    }
    Ok(all.swap_remove(0))
}

/// Returns a trajectory to a position and, after a rest there, back, with a trapezoidal speed each
/// way.
///
/// # Errors
/// Returns an error that names the invalid value and its range.
pub fn there_and_back(
    [deg, speed_deg_per_s, rest_s, half_blend_s]: [f64; 4],
) -> Result<TrajectoryTable, Error> {
    let refuse = |what: &str| Err(Error::Input(format!("trajectory: {what}")));
    if !(speed_deg_per_s > 0.0 && speed_deg_per_s.is_finite()) {
        return refuse("the speed must be a number above 0, deg/s");
    }
    if !(half_blend_s > 0.0 && half_blend_s.is_finite()) {
        return refuse("half a blend (half the rounding time at a corner) must be above 0 s");
    }
    if !(rest_s >= 0.0 && rest_s.is_finite() && deg.is_finite()) {
        return refuse("the way must be a number, and the rest a number from 0, s");
    }
    // Blends must not overlap.
    let way_s = (deg.abs() / speed_deg_per_s).max(2.0 * half_blend_s);
    let rest_s = rest_s.max(2.0 * half_blend_s);
    let first_s = half_blend_s;
    let ends = [first_s, first_s + way_s, first_s + way_s + rest_s, first_s + 2.0 * way_s + rest_s];
    Ok(TrajectoryTable {
        corner_times_s: ends.to_vec(),
        corner_positions_deg: vec![0.0, deg, deg, 0.0],
        half_blend_s,
    })
}
