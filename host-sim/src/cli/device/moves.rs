//! `stiction device move`.

use std::path::PathBuf;
use std::time::Duration;

use serde_json::Value;
use stiction::link::StateCode;

use super::{arm, ended, kept, lost, off, then_off, time};
use crate::cli::outputs::check_standard_output;
use crate::cli::warn;
use files::data_sheet::UnseenSlack;
use files::error::Error;
use files::goal::PositionGoal;
use files::typed_number;
use simulator::device::client::Client;
use simulator::device::log::SampleLog;
use simulator::device::moved::MoveResult;
use simulator::device::signals::Signals;
use simulator::device::travel::Travel;
use simulator::device::wire::Wire;
use simulator::device::{json, words};
use simulator::experiment::Document;
use simulator::output::sides::sentence;
use simulator::output::{OutputFile, OverwriteGuard};

/// Least time for which the loop stays closed after a step, s, without `--for`.
const STEP_S: f64 = 5.0;
/// Least time for which a joint is watched after its set point rests, s: an integral needs a
/// second.
const SETTLES_S: f64 = 2.0;

/// Longest wait for the first sample of a joint that is armed already.
const FIRST_SAMPLE: Duration = Duration::from_millis(200);

#[derive(Debug, clap::Args)]
pub struct MoveArguments {
    /// Position from the zero that arming sets, deg
    #[arg(allow_hyphen_values = true, value_parser = typed_number::parse)]
    deg: f64,
    /// Step to the position at once, without the limits of [profile]
    #[arg(long)]
    step: bool,
    /// Time for which the loop stays closed, s; then the motor is turned off [default: the longest
    /// time of the move and 2 s; of a step 5 s]
    #[arg(long, value_name = "S", allow_hyphen_values = true, value_parser = typed_number::parse)]
    r#for: Option<f64>,
    /// Write a sample of every tick to this file; - for the standard output
    #[arg(long, value_name = "FILE.csv")]
    log: Option<PathBuf>,
    /// Write over a file that this command reads, or over a machine's file
    #[arg(long)]
    pub force: bool,
    /// Report the end of the move as JSON
    #[arg(long)]
    json: bool,
}

impl MoveArguments {
    /// Checks the path of the log's file, if there is one.
    pub fn output(&self, guard: &OverwriteGuard) -> Result<Option<OutputFile>, Error> {
        let log = self.log.as_ref().map(|path| guard.results("--log", path)).transpose()?;
        check_standard_output(self.json, log.as_ref())?;
        Ok(log)
    }
}

/// Text of the result, and an error if the move ended before its time.
pub struct MoveReport {
    pub text: String,
    pub ended: Result<(), Error>,
    /// Whether the text is printed alone, without a warning before it.
    pub alone: bool,
}

/// Criteria by which the end of a move is judged, from the machine's file.
#[derive(Clone, Copy, Debug, Default)]
pub struct MoveCriteria {
    goal: PositionGoal,
    slack: Option<UnseenSlack>,
}

impl MoveCriteria {
    /// Reads the criteria from a machine's file, and prints the doubts about its joint as warnings.
    ///
    /// # Errors
    /// Reports what is wrong with the file.
    pub fn by(machine: &str) -> Result<Self, Error> {
        let document = Document::open(machine)?;
        warn(&document.doubts()?);
        Ok(Self { goal: document.machine()?.goal, slack: document.unseen_slack()? })
    }
}

/// Arms the device if it is not armed, moves, and turns the output off.
///
/// # Errors
/// Reports why the move was not made, and the state of the drive.
pub fn go<W: Wire>(
    arguments: &MoveArguments,
    client: &mut Client<W>,
    log: Option<&OutputFile>,
    judged: &MoveCriteria,
) -> Result<MoveReport, Error> {
    let MoveArguments { deg, step, r#for, json, .. } = arguments;
    let given = r#for.map(|seconds| time("--for", seconds)).transpose()?;
    // Arming drives the motor, so a target out of range is refused before.
    Travel::new(&client.parameters()?).check("move", *deg)?;
    let motion = if *step { client.step(*deg)? } else { client.profiled(*deg)? };
    client.check_move(&motion).map_err(|error| match error {
        Error::Refused(why) => Error::Device(format!("{why}; the motor is off")),
        other => other,
    })?;
    let signals = Signals::new(client.signals()?);
    let mut samples = SampleLog::new(signals.clone(), &[])?;
    let before = client.status()?;
    let mut moved = MoveResult::to(*deg, before.resolution.into(), before.sample_time.into())
        .judged_by(judged.goal, judged.slack);
    let (status, interrupted) = then_off(client, |client| {
        let was_armed = client.status()?.state == StateCode::Armed;
        if !was_armed {
            arm(client)?;
        }
        let (mask, every) =
            if log.is_some() { (samples.mask(), 1) } else { moved.subscription(&signals) };
        client.subscribe(mask, every)?;
        let time = match given {
            Some(time) => time,
            None if *step => Duration::from_secs_f64(judged.goal.watched_s(STEP_S).min(86_400.0)),
            None => {
                // A joint that was armed before can be anywhere.
                let first = if was_armed { client.sample(FIRST_SAMPLE)? } else { None };
                let from = first.map_or(0.0, |sample| signals.number(&sample, "counts"));
                let way = deg - from * f64::from(before.resolution);
                let watched_s = client.longest_s(way)? + judged.goal.watched_s(SETTLES_S);
                Duration::from_secs_f64(watched_s.min(86_400.0))
            }
        };
        client.move_along(motion)?;
        let (status, interrupted) = kept(client, |client| client.pass_armed(time))?;
        // The log ends before the output goes off: a tick without the loop has neither zero nor
        // position.
        while let Some(sample) = client.kept() {
            if signals.is_armed(&sample) {
                moved.see(&signals, &sample, client.load_ahead_deg(sample.clock));
            }
            if log.is_some() {
                samples.push(sample);
            }
        }
        Ok((status, interrupted))
    })?;
    if let Some(file) = log {
        file.write(&samples.render(status.sample_time, status.resolution)?)?;
    }
    if status.state != StateCode::Armed {
        moved.end();
    }
    let text = if *json {
        let mut object = moved.json(status.at_rest, client.warning());
        object["state"] = words::state(status.state).into();
        object["fault"] = json::latched(&status);
        object["ended_by"] = match (&interrupted, status.state) {
            (Err(_), _) => "ctrl-c".into(),
            (Ok(()), StateCode::Armed) => Value::Null,
            (Ok(()), _) if status.fault.code != 0 => "fault".into(),
            (Ok(()), _) => "stop".into(),
        };
        format!("{object:#}\n")
    } else {
        let rest =
            if status.at_rest { "" } else { "the joint still moved when the time was over\n" };
        let slack = judged.slack.as_ref().map_or_else(String::new, sentence);
        words::status(&status) + &moved.to_string() + &slack + rest + off(&status) + &lost(client)
    };
    let ended = interrupted
        .map_err(|why| Error::CtrlC(format!("move: {why}; the motor is off")))
        .and_then(|()| ended("move", &status));
    Ok(MoveReport { text, ended, alone: *json })
}

#[cfg(test)]
mod tests {
    use super::*;
    use simulator::device::simulated::SimulatedDevice;
    use simulator::device::wire::SimulatedWire;
    use simulator::experiment::{Document, Experiment};

    /// A wire that records whether the motor was driven.
    struct DriveWatchingWire {
        wire: SimulatedWire,
        was_driven: bool,
    }

    impl Wire for DriveWatchingWire {
        fn send(&mut self, bytes: &[u8]) -> Result<(), Error> {
            self.wire.send(bytes)?;
            self.was_driven |= self.wire.simulated.tick().enable;
            Ok(())
        }

        fn receive(&mut self, at_most: Duration) -> Result<Vec<u8>, Error> {
            self.wire.receive(at_most)
        }

        fn name(&self) -> String {
            self.wire.name()
        }

        fn warning(&self) -> Option<&'static str> {
            self.wire.warning()
        }
    }

    /// Returns a client of a device with travel from -10 to 20 deg, whose joint was pushed to a
    /// position.
    fn client(pushed_deg: f64) -> Client<DriveWatchingWire> {
        let joint = simulator::experiment::find("step-response").unwrap().toml;
        let limits = "[limits]\nposition_min_deg = -10.0\nposition_max_deg = 20.0\n";
        let document = Document::parse("joint.toml", &format!("{joint}\n{limits}")).unwrap();
        let plan = Experiment::plan(&document, &["srnf".into()], &[]).unwrap().runs.remove(0);
        let mut simulated = SimulatedDevice::new(&plan).unwrap();
        simulated.tick();
        simulated.push(pushed_deg, 0.0);
        let wire = DriveWatchingWire { wire: SimulatedWire::new(simulated), was_driven: false };
        Client::connect(wire).unwrap()
    }

    fn arguments(deg: f64, step: bool) -> MoveArguments {
        MoveArguments { deg, step, r#for: Some(0.1), log: None, force: false, json: false }
    }

    #[test]
    fn a_target_out_of_the_range_is_refused_and_nothing_was_armed() {
        for (pushed, deg, step) in [(0.0, 400.0, false), (0.0, -10.1, true), (15.0, 5.1, false)] {
            let mut client = client(pushed);
            let refused = go(&arguments(deg, step), &mut client, None, &MoveCriteria::default());
            let error = refused.err().unwrap().to_string();
            assert!(error.starts_with("move: the simulated device refuses: "), "{error}");
            assert!(
                error.contains("leaves the range `limits.position_min_deg`")
                    && error.ends_with("; the motor is off"),
                "{error}"
            );
            assert!(!client.wire().was_driven, "{pushed}, {deg}");
            // Without the check before, the device reports the same, but drives the motor for it.
            arm(&mut client).unwrap();
            let motion = client.profiled(deg).unwrap();
            let reported = client.move_along(motion).unwrap_err().to_string();
            assert_eq!(error, format!("{reported}; the motor is off"));
            assert!(client.wire().was_driven);
        }
    }

    /// Both refuse the same targets around the ends of the range, to the count, at any position of
    /// the joint.
    #[test]
    fn the_look_before_arming_refuses_what_the_armed_device_refuses() {
        for pushed in [0.0, 3.0, -7.7] {
            for end in [-10.0, 20.0] {
                for count in -2i32..=2 {
                    let mut client = client(pushed);
                    let status = client.status().unwrap();
                    let resolution = f64::from(status.resolution);
                    let here = f64::from(status.position) * resolution;
                    let deg = end - here + f64::from(count) * resolution;
                    let motion = client.profiled(deg).unwrap();
                    let before = client.check_move(&motion);
                    arm(&mut client).unwrap();
                    let after = client.move_along(motion);
                    assert_eq!(before.is_err(), after.is_err(), "{pushed} {end} {count}");
                    // The ends of the range and the target are rounded, each by less than a count.
                    if count.abs() == 2 {
                        let is_out = f64::from(count) * end > 0.0;
                        assert_eq!(before.is_err(), is_out, "{pushed} {end} {count}");
                    }
                }
            }
        }
    }

    #[test]
    fn without_limits_of_travel_a_far_target_is_refused_with_the_range() {
        let document = Document::open("step-response").unwrap();
        let plan = Experiment::plan(&document, &["srnf".into()], &[]).unwrap().runs.remove(0);
        for deg in [361.0, 1e9] {
            let simulated = SimulatedDevice::new(&plan).unwrap();
            let wire = DriveWatchingWire { wire: SimulatedWire::new(simulated), was_driven: false };
            let mut client = Client::connect(wire).unwrap();
            let refused = go(&arguments(deg, false), &mut client, None, &MoveCriteria::default());
            let error = refused.err().unwrap().to_string();
            assert!(error.contains("it must be -360 to 360 deg"), "{error}");
            assert!(!client.wire().was_driven);
        }
    }

    #[test]
    fn a_target_within_the_range_is_moved_to() {
        let mut client = client(15.0);
        let said = go(&arguments(4.9, false), &mut client, None, &MoveCriteria::default()).unwrap();
        assert!(said.ended.is_ok() && client.wire().was_driven, "{}", said.text);
    }
}
