//! Execution of the requests of the page that commands.

use std::path::Path;
use std::time::Duration;

use serde_json::{Value, json};
use stiction::identification::{Outcome, Summary};
use stiction::motion::home::{HomeRequest, HomeTarget};
use stiction::motion::jog::JogRequest;
use stiction::{Parameters, identification};

use super::desk::{QueuedRequest, UnsavedJoint};
use super::form;
use super::machine_in_use::{self, MachineInUse};
use super::request::{RequestedMotion, StudioAction};
use super::worker::{RunningMotion, Worker};
use dynamics::joint::CoreUnits;
use files::error::Error;
use files::machine::TrajectoryTable;
use simulator::device::client::Map;
use simulator::device::homed::HomeResult;
use simulator::device::identified::{IdentifiedJoint, doubts};
use simulator::device::wire::Wire;
use simulator::device::{into, jogged, machine_file, words};
use simulator::experiment::Document;
use studies::device_gear::{self, DeviceGear, PrecedingSequence};

/// Remark on the bounds of an identification, which a page cannot set.
const BOUNDS: &str = ". The bounds are the device's: the effort is that of limits.breakaway_v, the \
                      speed that of profile.velocity_deg_per_s";

/// Largest number of parameter changes that can be undone.
const UNDONE: usize = 32;

impl<W: Wire> Worker<'_, W> {
    /// Executes a request, and returns a sentence on what was done.
    ///
    /// # Errors
    /// Returns why the device refuses, or that it does not answer.
    pub(super) fn execute(&mut self, order: &QueuedRequest) -> Result<Value, Error> {
        let what = &order.what;
        // The motor may be driven even if the answer is lost.
        let arms = matches!(
            what,
            StudioAction::Arm
                | StudioAction::Jog
                | StudioAction::Home(_)
                | StudioAction::Identify { .. }
                | StudioAction::IdentifyJoint
                | StudioAction::Selftest(_)
        );
        self.driven |= arms;
        self.armed_here |= arms;
        // The joint counts as at rest 50 ms after it was stopped.
        if arms && !self.client.status()?.at_rest {
            self.client.pass(Duration::from_millis(100))?;
        }
        let bounds = identification::IdentificationRequest::default();
        let mut sequence = PrecedingSequence { bounds, begin: 0 };
        if *what == StudioAction::IdentifyJoint {
            sequence.bounds = self.client.check_identification(&bounds)?;
            sequence.begin = self.client.status()?.position;
        }
        // The requests above took time.
        self.is_expected(order)?;
        let said: &str = match what {
            // Other code answers these; a stop overtakes every request.
            StudioAction::Alive | StudioAction::Command | StudioAction::Stop => "",
            StudioAction::Predict(_)
            | StudioAction::Compare(_)
            | StudioAction::Tune(_)
            | StudioAction::CancelTuning => "",
            StudioAction::PredictSelftest { range_deg, moves, joint } => {
                return self.predict_selftest(*range_deg, *moves, *joint);
            }
            StudioAction::CancelSelftest => {
                let said = "the prediction of the self-test is cancelled";
                if !self.cancel_prediction(said) {
                    let why = "selftest: none is being predicted";
                    return Err(Error::Refused(why.into()));
                }
                said
            }
            StudioAction::Selftest(number) => return self.begin_selftest(*number, order),
            StudioAction::Arm => {
                self.client.arm()?;
                "armed: the motor is driven, and this position is 0 deg"
            }
            StudioAction::Hold => {
                self.client.hold()?;
                "stops here, and is held"
            }
            StudioAction::Move(deg) => {
                self.check_target("move", *deg)?;
                self.client.move_to(*deg)?;
                self.publish_motion(&RequestedMotion::Move(*deg));
                return Ok(format!("moves to {deg} deg").into());
            }
            StudioAction::Step(deg) => {
                self.check_target("step", *deg)?;
                self.client.step_to(*deg)?;
                self.publish_motion(&RequestedMotion::Step(*deg));
                return Ok(format!("steps to {deg} deg").into());
            }
            StudioAction::Trajectory => {
                let first =
                    machine_in_use::first_trajectory(&Document::open(&self.about.machine)?)?;
                return self.follow(first);
            }
            StudioAction::Trapezoid(fields) => {
                let trajectory = machine_in_use::there_and_back(*fields)?;
                self.check_target("trajectory to", fields[0])?;
                return self.follow(trajectory);
            }
            StudioAction::IdentifyJoint => {
                self.client.identify_joint(sequence.bounds)?;
                self.running = Some(RunningMotion::Identification(sequence, order.page));
                let in_use = self.shared.in_use();
                if in_use.is_some_and(|all| all.controller.motor.count().is_some()) {
                    "a sequence of motions starts, without a loop, and ends automatically; moves \
                     with the loop closed follow, and measure the gear"
                } else {
                    "a sequence of motions starts, without a loop, and ends automatically"
                }
            }
            StudioAction::Jog => {
                self.client.jog(JogRequest::default())?;
                self.running = Some(RunningMotion::Jog);
                "jogs: a little each way, without a loop"
            }
            StudioAction::Home(bounds) => {
                let at = self.client.counts_of("home", bounds.at_deg)?;
                let (effort, travel) = (bounds.effort_v, bounds.travel_deg);
                let asked = HomeRequest {
                    to: bounds.to,
                    sense: bounds.towards,
                    at,
                    effort,
                    travel,
                    ..HomeRequest::default()
                };
                self.client.home(asked)?;
                self.running = Some(RunningMotion::Homing(bounds.to));
                match bounds.to {
                    HomeTarget::Stop => {
                        "goes to its hard stop, twice; the joint is not referenced until both \
                         places agree"
                    }
                    HomeTarget::Switch | HomeTarget::SwitchIndex => {
                        "goes to its switch, twice; the joint is not referenced until both places \
                         agree"
                    }
                    HomeTarget::Index => {
                        "goes to its encoder's index; the joint is not referenced until it has come"
                    }
                }
            }
            StudioAction::Identify { rate, hold } => {
                self.client.identify(*rate, *hold)?;
                self.running = Some(RunningMotion::Ramp(*rate));
                "the effort rises until the joint moves"
            }
            StudioAction::Clear => {
                self.client.clear()?;
                "cleared"
            }
            StudioAction::TakeOver => {
                self.client.take_over()?;
                // With the samples, which a guest does not receive.
                self.publish_device()?;
                "taken over: the motor is off, and the other client's session is over"
            }
            StudioAction::Reference(deg) => {
                self.client.set_reference(*deg)?;
                return Ok(format!("the joint stands at {deg} deg").into());
            }
            StudioAction::Set(values) => {
                let before = self.client.parameters()?;
                let text = form::file(&before, &self.about.machine, None)?;
                let after = form::changed(&text, values)?;
                return self.take(before, &after);
            }
            StudioAction::Push(text) => {
                let after = machine_file::read("push", text)?;
                let before = self.client.parameters()?;
                return self.take(before, &after);
            }
            StudioAction::Undo => {
                let nothing = || Error::Input("undo: nothing was changed in this session".into());
                let last = self.before.last().ok_or_else(nothing)?.clone();
                let now = self.client.parameters()?;
                self.client.set_parameters(&last)?;
                self.before.pop();
                self.publish_device()?;
                return said_changes(&now, &last);
            }
            StudioAction::Save => {
                self.client.save()?;
                self.saved = Some(self.client.parameters()?);
                self.publish_device()?;
                "saved: a reset brings them back"
            }
        };
        Ok(said.into())
    }

    /// Follows a trajectory, whose positions count from the zero of the arming.
    fn follow(&mut self, trajectory: TrajectoryTable) -> Result<Value, Error> {
        let way = RequestedMotion::Trajectory(trajectory);
        let file = Document::open(&self.about.machine)?;
        let in_use = MachineInUse::new(&self.client.parameters()?, &file)?;
        self.client.move_along(in_use.motion(&way)?)?;
        self.publish_motion(&way);
        Ok("follows the trajectory".into())
    }

    /// Sends changed parameters to the device, which uses all of them or none. Returns the changes
    /// in words.
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
        self.publish_device()?;
        Ok(said)
    }

    /// Returns the machine's file, and the units that the file defines. Both are `None` if the
    /// device has no file. After an error the caller can still report the identified joint.
    pub(super) fn of_file(&self) -> Result<(Option<Document>, Option<CoreUnits>), Error> {
        if !self.about.is_its_file {
            return Ok((None, None));
        }
        let document = Document::open(&self.about.machine)?;
        let units = document.mapping()?.map(|(_, mapping)| mapping.units);
        Ok((Some(document), units))
    }

    /// Publishes the end of an identification, keeps the identified joint as a machine's file like
    /// that of `device identify --into`, and returns the result in words. If the result cannot be
    /// written as a file, the previous joint is kept, and published again.
    pub(super) fn identified(
        &mut self,
        summary: Summary,
        map: Map,
        parameters: Parameters,
        gear: Option<Result<DeviceGear, String>>,
    ) -> MotionReport {
        let ((document, units), without) = match self.of_file() {
            Ok(known) => (known, String::new()),
            Err(error) => ((None, None), format!("\nnot in SI units: {error}")),
        };
        let measured = gear.as_ref().and_then(|gear| gear.as_ref().ok()?.measured());
        let found = IdentifiedJoint { summary, map, parameters, units, gear: measured };
        let of_gear = gear.as_ref().map_or_else(String::new, device_gear::words_of);
        let said = found.words() + &of_gear + &without;
        // Without a file there are no other motions to copy.
        let nothing = || Document::parse("no file", "");
        let file = document.map_or_else(nothing, Ok).and_then(|of| self.file_of(&found, &of));
        let mut event = match &file {
            Ok(_) => json!({ "ok": true, "said": said, "doubts": doubts(&summary.doubts) }),
            Err(error) => {
                let at_bounds = matches!(
                    summary.outcome,
                    Outcome::Still | Outcome::Travel | Outcome::Speed | Outcome::Time
                );
                let bounds = if at_bounds || summary.doubts.few_rows { BOUNDS } else { "" };
                json!({ "ok": false, "said": said, "why": format!("{error}{bounds}") })
            }
        };
        event["gear"] = gear.iter().flatten().next().map(DeviceGear::json).into();
        event["gear_refused"] = gear.as_ref().and_then(|gear| gear.as_ref().err().cloned()).into();
        let is_new = file.is_ok();
        if let Ok(joint) = file {
            self.shared.set_found(joint);
        }
        if let Ok(UnsavedJoint { name, text, laws }) = self.shared.found() {
            event["file"] = name.into();
            event["toml"] = text.into();
            event["laws"] = laws.into();
        }
        self.shared.news.publish("identified", event);
        if is_new {
            self.drop_test_of_found();
        }
        let grade = match found.verdict() {
            "good" if !is_gear_doubtful(gear.as_ref()) => Grade::Good,
            "no result" => Grade::Bad,
            _ => Grade::Doubtful,
        };
        MotionReport { said, grade }
    }

    /// Makes the file of an identified joint.
    fn file_of(&self, found: &IdentifiedJoint, of: &Document) -> Result<UnsavedJoint, Error> {
        let own = self.about.is_its_file.then_some(self.about.machine.as_str());
        let name = Path::new(own.unwrap_or("joint")).with_extension("identified.toml");
        let name = name.file_name().map_or_else(String::new, |name| name.to_string_lossy().into());
        let warning = self.client.warning();
        let header = warning.map_or(String::new(), |warning| format!("# {warning}\n"));
        let text = header + &into::text(found, of)?;
        let laws = Document::parse(&name, &text)?.machine()?.sampling.extras.list().to_vec();
        Ok(UnsavedJoint { name, text, laws })
    }

    /// Returns the result of a motion that has ended, or `None` if moves for the gear follow.
    pub(super) fn found(&mut self, running: RunningMotion) -> Result<Option<MotionReport>, Error> {
        let nothing = |what: &str| MotionReport::bad(format!("{what}: ended without a result"));
        let report = match running {
            RunningMotion::Jog => match self.client.jogged()? {
                Some(found) => {
                    let parameters = self.client.parameters()?;
                    let said = jogged::words(&found, &parameters);
                    if jogged::is_right(&found, &parameters) {
                        MotionReport { said, grade: Grade::Good }
                    } else {
                        MotionReport::bad(said)
                    }
                }
                None => nothing("jog"),
            },
            RunningMotion::Homing(to) => match self.client.homed()? {
                Some(found) => {
                    let status = self.client.status()?;
                    let parameters = self.client.parameters()?;
                    let result = HomeResult::new(found, to, &status, &parameters);
                    let said = result.words();
                    if result.is_found() {
                        MotionReport { said, grade: Grade::Good }
                    } else {
                        MotionReport::bad(said)
                    }
                }
                None => nothing("home"),
            },
            RunningMotion::Identification(sequence, page) => match self.client.identified()? {
                Some((summary, map)) => {
                    return self.sequence_ended(summary, map, &sequence, page);
                }
                None => nothing("identify"),
            },
            RunningMotion::Ramp(rate) => match self.client.levels()? {
                Some(levels) => {
                    MotionReport { said: words::levels(&levels, rate), grade: Grade::Good }
                }
                None => nothing("identify"),
            },
        };
        Ok(Some(report))
    }
}

/// Returns whether a measured gear has doubts or was not identified.
fn is_gear_doubtful(gear: Option<&Result<DeviceGear, String>>) -> bool {
    gear.is_some_and(|gear| gear.as_ref().map_or(true, |gear| !gear.doubts.is_empty()))
}

/// Result of a motion that has ended, in words, with its grade.
pub(super) struct MotionReport {
    pub said: String,
    pub grade: Grade,
}

impl MotionReport {
    /// Returns a result that is not usable.
    pub const fn bad(said: String) -> Self {
        Self { said, grade: Grade::Bad }
    }
}

/// Grade of a result, for the page's mark. A doubtful result is usable, and has doubts.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "lowercase")]
pub(super) enum Grade {
    Good,
    Doubtful,
    Bad,
}

fn said_changes(before: &Parameters, after: &Parameters) -> Result<Value, Error> {
    let changes = machine_file::changes(before, after)?;
    Ok(if changes.is_empty() { "nothing is different".into() } else { changes.join("\n").into() })
}
