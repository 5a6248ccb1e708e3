//! What the thread does when the page that commands asks for it.

use std::path::Path;
use std::time::Duration;

use serde_json::{Value, json};
use stiction::identification::Summary;
use stiction::motion::jog::{Asked, Verdict};
use stiction::{Parameters, identification};

use super::desk::{FoundJoint, Order};
use super::form;
use super::machine_in_use::{self, MachineInUse};
use super::request::{Ask, Way};
use super::wording::{of_a_page, without_bounds};
use super::worker::{Running, Worker};
use crate::device::client::Map;
use crate::device::identified::{Identified, doubts};
use crate::device::wire::Wire;
use crate::device::{into, jogged, machine_file, words};
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
    pub(super) fn obey(&mut self, order: &Order) -> Result<Value, Error> {
        let what = &order.what;
        // Whatever becomes of the answer, the motor may be driven then.
        let arms = matches!(
            what,
            Ask::Arm | Ask::Jog | Ask::Identify { .. } | Ask::IdentifyJoint | Ask::Selftest(_)
        );
        self.driven |= arms;
        self.armed_here |= arms;
        // The joint counts as at rest 50 ms after it was stopped.
        if arms && !self.client.status()?.at_rest {
            self.client.pass(Duration::from_millis(100))?;
        }
        let mut identification = identification::Asked::default();
        if *what == Ask::IdentifyJoint {
            let checked = self.client.check_identification(&identification);
            identification = checked.map_err(of_a_page)?;
        }
        // That took its time.
        self.is_expected(order)?;
        let said: &str = match what {
            // Others answer these; a stop passes every order.
            Ask::Alive | Ask::Command | Ask::Stop => "",
            Ask::Predict(_) | Ask::Compare(_) | Ask::Tune(_) | Ask::CancelTuning => "",
            Ask::PredictSelftest { range_deg, moves, joint } => {
                return self.predict_selftest(*range_deg, *moves, *joint);
            }
            Ask::CancelSelftest => {
                let said = "the prediction of the self-test is cancelled";
                if !self.cancel_prediction(said) {
                    let why = "selftest: none is being predicted";
                    return Err(Error::Refused(why.into()));
                }
                said
            }
            Ask::Selftest(number) => return self.begin_selftest(*number, order),
            Ask::Arm => {
                self.client.arm()?;
                "armed: the loop is closed, and here is zero"
            }
            Ask::Hold => {
                self.client.hold()?;
                "stops here, and is held"
            }
            Ask::Move(deg) => {
                self.check_target("move", *deg)?;
                self.client.move_to(*deg)?;
                self.tell_motion(&Way::Move(*deg));
                return Ok(format!("moves to {deg} deg").into());
            }
            Ask::Step(deg) => {
                self.check_target("step", *deg)?;
                self.client.step_to(*deg)?;
                self.tell_motion(&Way::Step(*deg));
                return Ok(format!("steps to {deg} deg").into());
            }
            Ask::Trajectory => {
                let first =
                    machine_in_use::first_trajectory(&Document::open(&self.about.machine)?)?;
                return self.follow(first);
            }
            Ask::Trapezoid(fields) => {
                let trajectory = machine_in_use::there_and_back(*fields)?;
                self.check_target("trajectory to", fields[0])?;
                return self.follow(trajectory);
            }
            Ask::IdentifyJoint => {
                self.client.identify_joint(identification)?;
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
        let file = Document::open(&self.about.machine)?;
        let in_use = MachineInUse::new(&self.client.parameters()?, &file)?;
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

    /// The machine's file with its units, if it has any; if it cannot be read, why. What was found
    /// in minutes is told all the same.
    fn of_file(&self) -> Result<(Option<Document>, Option<CoreUnits>), Error> {
        if !self.about.is_its_file {
            return Ok((None, None));
        }
        let document = Document::open(&self.about.machine)?;
        let units = document.mapping()?.map(|(_, mapping)| mapping.units);
        Ok((Some(document), units))
    }

    /// Tells all pages of an identification that has ended, and keeps the joint that was found as a
    /// machine's file: the one that `device identify --into` writes. If it is no joint for a file,
    /// the one that was found before stays, and is told again. Returns what was found in words.
    fn identified(&mut self, summary: Summary, map: Map) -> Result<Report, Error> {
        let ((document, units), without) = match self.of_file() {
            Ok(known) => (known, String::new()),
            Err(error) => ((None, None), format!("\nnot in SI units: {error}")),
        };
        let found = Identified { summary, map, parameters: self.client.parameters()?, units };
        let mut said = found.words() + &without;
        if said.contains(" --") {
            said += "\n(what begins with -- is an option of `stiction device identify`)";
        }
        // Without a file there are no other motions to be taken over.
        let nothing = || Document::parse("no file", "");
        let file = document.map_or_else(nothing, Ok).and_then(|of| self.file_of(&found, &of));
        let mut told = match &file {
            Ok(_) => json!({ "ok": true, "said": said, "doubts": doubts(&summary.doubts) }),
            Err(error) => {
                json!({ "ok": false, "said": said, "why": without_bounds(&error.to_string()) })
            }
        };
        let is_new = file.is_ok();
        if let Ok(joint) = file {
            self.shared.finds(joint);
        }
        if let Ok(FoundJoint { name, text, laws }) = self.shared.found() {
            told["file"] = name.into();
            told["toml"] = text.into();
            told["laws"] = laws.into();
        }
        self.shared.news.tell("identified", told);
        if is_new {
            self.drop_test_of_found();
        }
        let grade = match found.verdict() {
            "good" => Grade::Good,
            "no result" => Grade::Bad,
            _ => Grade::Doubtful,
        };
        Ok(Report { said, grade })
    }

    /// The file of a joint that was found.
    fn file_of(&self, found: &Identified, of: &Document) -> Result<FoundJoint, Error> {
        let own = self.about.is_its_file.then_some(self.about.machine.as_str());
        let name = Path::new(own.unwrap_or("joint")).with_extension("identified.toml");
        let name = name.file_name().map_or_else(String::new, |name| name.to_string_lossy().into());
        let warning = self.client.warning();
        let header = warning.map_or(String::new(), |warning| format!("# {warning}\n"));
        let text = header + &into::text(found, of)?;
        let laws = Document::parse(&name, &text)?.machine()?.sampling.extras.list().to_vec();
        Ok(FoundJoint { name, text, laws })
    }

    /// What a motion has found that has ended.
    pub(super) fn found(&mut self, running: Running) -> Result<Report, Error> {
        let nothing = |what: &str| Report::bad(format!("{what}: ended before anything was found"));
        Ok(match running {
            Running::Jog => match self.client.jogged()? {
                Some(found) => {
                    let said = jogged::words(&found, &self.client.parameters()?);
                    match found.verdict() {
                        Verdict::Agrees => Report { said, grade: Grade::Good },
                        _ => Report::bad(said),
                    }
                }
                None => nothing("jog"),
            },
            Running::Identification => match self.client.identified()? {
                Some((summary, map)) => self.identified(summary, map)?,
                None => nothing("identify"),
            },
            Running::Ramp(rate) => match self.client.levels()? {
                Some(levels) => Report { said: words::levels(&levels, rate), grade: Grade::Good },
                None => nothing("identify"),
            },
        })
    }
}

/// Result of a motion that has ended, in words.
pub(super) struct Report {
    pub said: String,
    pub grade: Grade,
}

impl Report {
    /// A result that is not usable.
    pub const fn bad(said: String) -> Self {
        Self { said, grade: Grade::Bad }
    }
}

/// Grade of a result, by which a page marks it. A doubtful result is usable, and has doubts.
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
