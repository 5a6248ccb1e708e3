//! What the thread does when the page that commands asks for it.

use std::time::Duration;

use serde_json::Value;
use stiction::jog::Asked;
use stiction::{Parameters, identification};

use super::form;
use super::machine_in_use::{self, MachineInUse};
use super::request::{Ask, Way};
use super::worker::{Running, Worker};
use crate::device::identified::Identified;
use crate::device::wire::Wire;
use crate::device::{jogged, machine_file, words};
use crate::error::Error;
use crate::experiment::Document;
use crate::joint::CoreUnits;
use crate::machine::Trajectory;

/// How many changes of the parameters can be undone.
const UNDONE: usize = 32;

impl<W: Wire> Worker<'_, W> {
    /// Does what this page asks for, and says what was done.
    ///
    /// # Errors
    /// Says why the device refuses, or that it does not answer.
    pub(super) fn obey(&mut self, page: u64, what: &Ask) -> Result<Value, Error> {
        // Whatever becomes of the answer, the motor may be driven then.
        let arms = matches!(
            what,
            Ask::Arm | Ask::Jog | Ask::Identify { .. } | Ask::IdentifyJoint | Ask::Selftest
        );
        self.driven |= arms;
        self.armed_here |= arms;
        // The joint counts as at rest 50 ms after it was stopped.
        if arms && !self.client.status()?.at_rest {
            self.client.pass(Duration::from_millis(100))?;
        }
        let said: &str = match what {
            // Others answer these.
            Ask::Alive | Ask::Command => "",
            Ask::Predict(_) | Ask::Compare(_) | Ask::Tune(..) | Ask::CancelTuning => "",
            Ask::PredictSelftest { range_deg, moves } => {
                return self.predict_selftest(*range_deg, *moves);
            }
            Ask::Selftest => return self.begin_selftest(page),
            Ask::Stop => {
                self.client.stop()?;
                "stopped: the motor is off"
            }
            Ask::Arm => {
                self.client.arm()?;
                "armed: the loop is closed, and here is zero"
            }
            Ask::Hold => {
                self.client.hold()?;
                "stops here, and is held"
            }
            Ask::Move(deg) => {
                self.client.move_to(*deg)?;
                self.tell_motion(&Way::Move(*deg));
                return Ok(format!("moves to {deg} deg").into());
            }
            Ask::Step(deg) => {
                self.client.step_to(*deg)?;
                self.tell_motion(&Way::Step(*deg));
                return Ok(format!("steps to {deg} deg").into());
            }
            Ask::Trajectory => {
                let first = machine_in_use::first_trajectory(&self.about.machine)?;
                return self.follow(first);
            }
            Ask::Trapezoid(fields) => {
                return self.follow(machine_in_use::there_and_back(*fields)?);
            }
            Ask::IdentifyJoint => {
                self.client.identify_joint(identification::Asked::default())?;
                self.running = Some(Running::Identification);
                "a sequence of motions begins, without a loop, and ends by itself"
            }
            Ask::Jog => {
                self.client.jog(Asked::default())?;
                self.running = Some(Running::Jog);
                "jogs: a little each way, without a loop"
            }
            Ask::Identify { rate, hold } => {
                self.client.identify(*rate, *hold)?;
                self.running = Some(Running::Ramp(*rate));
                "the effort rises until the joint moves"
            }
            Ask::Clear => {
                self.client.clear()?;
                "cleared"
            }
            Ask::Set(values) => {
                let before = self.client.parameters()?;
                let text = form::file(&before, &self.about.machine, None)?;
                let after = form::changed(&text, values)?;
                return self.take(before, &after);
            }
            Ask::Push(text) => {
                let after = machine_file::read("push", text)?;
                let before = self.client.parameters()?;
                return self.take(before, &after);
            }
            Ask::Undo => {
                let nothing = || Error::Input("undo: nothing was changed in this session".into());
                let last = self.before.last().ok_or_else(nothing)?.clone();
                let now = self.client.parameters()?;
                self.client.set_parameters(&last)?;
                self.before.pop();
                self.introduce()?;
                return said_changes(&now, &last);
            }
            Ask::Save => {
                self.client.save()?;
                self.saved = Some(self.client.parameters()?);
                self.introduce()?;
                "saved: a reset brings them back"
            }
        };
        Ok(said.into())
    }

    /// Follows a trajectory, whose positions are those of the zero of the arming.
    fn follow(&mut self, trajectory: Trajectory) -> Result<Value, Error> {
        let way = Way::Trajectory(trajectory);
        let in_use = MachineInUse::new(&self.client.parameters()?, &self.about.machine)?;
        self.client.move_along(in_use.motion(&way)?)?;
        self.tell_motion(&way);
        Ok("follows the trajectory".into())
    }

    /// Lets the device take other parameters, all of them or none.
    fn take(&mut self, before: Parameters, after: &Parameters) -> Result<Value, Error> {
        let said = said_changes(&before, after)?;
        if before == *after {
            return Ok(said);
        }
        self.client.set_parameters(after)?;
        self.before.push(before);
        if self.before.len() > UNDONE {
            self.before.remove(0);
        }
        self.introduce()?;
        Ok(said)
    }

    /// The units of the machine's file, if it has any; if it cannot be read, why. What was found
    /// in minutes is told all the same.
    fn units(&self) -> (Option<CoreUnits>, String) {
        if !self.about.is_its_file {
            return (None, String::new());
        }
        match Document::open(&self.about.machine).and_then(|file| file.mapping()) {
            Ok(mapping) => (mapping.map(|(_, mapping)| mapping.units), String::new()),
            Err(error) => (None, format!("\nnot in SI units: {error}")),
        }
    }

    /// What a motion has found that has ended.
    pub(super) fn found(&mut self, running: Running) -> Result<String, Error> {
        let nothing = "ended before anything was found";
        Ok(match running {
            Running::Jog => match self.client.jogged()? {
                Some(found) => jogged::words(&found, &self.client.parameters()?),
                None => format!("jog: {nothing}"),
            },
            Running::Identification => match self.client.identified()? {
                Some((summary, map)) => {
                    let (units, without) = self.units();
                    let parameters = self.client.parameters()?;
                    Identified { summary, map, parameters, units }.words() + &without
                }
                None => format!("identify: {nothing}"),
            },
            Running::Ramp(rate) => match self.client.levels()? {
                Some(levels) => words::levels(&levels, rate),
                None => format!("identify: {nothing}"),
            },
        })
    }
}

fn said_changes(before: &Parameters, after: &Parameters) -> Result<Value, Error> {
    let changes = machine_file::changes(before, after)?;
    Ok(if changes.is_empty() { "nothing is different".into() } else { changes.join("\n").into() })
}
