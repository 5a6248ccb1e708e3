//! What a page may ask for: one JSON object a message.

use std::collections::BTreeMap;
use std::ops::RangeInclusive;

use serde::{Deserialize, Serialize};

use crate::machine::TrajectoryTable;
use crate::tuning::Goal;

/// The largest message of a page, bytes: a machine's file has less than half of it.
pub const LARGEST: usize = 64 * 1024;

/// A request of a page. Its number comes back with the answer.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(try_from = "Written")]
pub struct Request {
    /// The page's own number for it.
    pub id: u32,
    /// What is asked for.
    pub what: Ask,
}

/// The same as it is written: `do` says what, and the others are what that wants.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Written {
    #[serde(default)]
    id: u32,
    r#do: String,
    deg: Option<f64>,
    rate: Option<f32>,
    hold: Option<f32>,
    values: Option<BTreeMap<String, String>>,
    text: Option<String>,
    trapezoid: Option<[f64; 4]>,
    wish: Option<Wish>,
    laws: Option<Vec<String>>,
    goal: Option<Goal>,
    moves: Option<usize>,
    joint: Option<Source>,
    limits: Option<Vec<String>>,
    cases: Option<u64>,
    number: Option<u32>,
}

/// Whose joint is computed with.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Source {
    /// That of the file that the studio was started with.
    #[default]
    File,
    /// The one that was identified here.
    Found,
}

/// What is to be tuned, as `stiction tune` takes it.
#[derive(Clone, Debug, PartialEq)]
pub struct Tuning {
    /// Controllers of the file; none of them means all.
    pub laws: Vec<String>,
    /// Objective of the gains.
    pub goal: Goal,
    /// Whose joint it is.
    pub joint: Source,
    /// Upper limits of metrics, `FIGURE=MOST`.
    pub limits: Vec<String>,
    /// Joints; none means as many as the command takes.
    pub cases: Option<u64>,
}

/// The largest number of limits: twice as many as there are figures.
const LIMITS: usize = 10;

/// How many moves a self-test may have, as on the command line.
const MOVES: RangeInclusive<usize> = 2..=200;

/// How a set point goes somewhere, in the zero of the arming.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "WrittenWay", into = "WrittenWay")]
pub enum Way {
    /// Within the limits of `[profile]`, to so many deg.
    Move(f64),
    /// At once, to so many deg.
    Step(f64),
    /// Through corners.
    Trajectory(TrajectoryTable),
}

/// The same as it is written. (A tag within the object would not do: a crate of the tree lets
/// serde_json keep numbers as they are written, and serde does not see them as numbers then.)
#[derive(Clone, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct WrittenWay {
    how: String,
    #[serde(skip_serializing_if = "Option::is_none")]
    deg: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    trajectory: Option<TrajectoryTable>,
}

impl TryFrom<WrittenWay> for Way {
    type Error = String;

    fn try_from(written: WrittenWay) -> Result<Self, String> {
        match (written.how.as_str(), written.deg, written.trajectory) {
            ("move", Some(deg), None) => Ok(Self::Move(deg)),
            ("step", Some(deg), None) => Ok(Self::Step(deg)),
            ("trajectory", None, Some(trajectory)) => Ok(Self::Trajectory(trajectory)),
            (how, ..) => Err(format!("there is no way `{how}` with these values")),
        }
    }
}

impl From<Way> for WrittenWay {
    fn from(way: Way) -> Self {
        let (how, deg, trajectory) = match way {
            Way::Move(deg) => ("move", Some(deg), None),
            Way::Step(deg) => ("step", Some(deg), None),
            Way::Trajectory(trajectory) => ("trajectory", None, Some(trajectory)),
        };
        Self { how: how.into(), deg, trajectory }
    }
}

/// What a page wants to have predicted.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Wish {
    /// The move, from where the joint stands.
    pub way: Way,
    /// Where it stands, deg from where it was armed: it is added to what is predicted, and gravity
    /// is that of this place.
    #[serde(default)]
    pub from_deg: f64,
    /// The controllers; the cloud is that of the first one.
    pub laws: Vec<String>,
    /// What differs from the machine in use, by its path.
    #[serde(default)]
    pub values: BTreeMap<String, f64>,
    /// Joints of the cloud.
    #[serde(default)]
    pub cloud: u8,
    /// Whose joint it is.
    #[serde(default)]
    pub joint: Source,
}

/// The largest wish: so many laws, so many changed values, so many joints.
const LARGEST_WISH: [usize; 3] = [16, 128, 48];

impl Wish {
    fn is_small(&self) -> bool {
        let [laws, values, cloud] = LARGEST_WISH;
        let is_small = self.laws.len() <= laws && self.values.len() <= values;
        is_small && usize::from(self.cloud) <= cloud
    }
}

/// What a page asks for.
#[derive(Clone, Debug, PartialEq)]
pub enum Ask {
    /// Nothing: the page lives, and looks at what comes. It is not answered.
    Alive,
    /// The page wants to command.
    Command,
    /// Output off.
    Stop,
    /// Close the loop where the joint is.
    Arm,
    /// Stop the joint, with the loop closed.
    Hold,
    /// Move within the limits of `[profile]` to so many deg in the zero of the arming.
    Move(f64),
    /// Jump there.
    Step(f64),
    /// Push the joint a little each way.
    Jog,
    /// Follow the first trajectory of the machine's file.
    Trajectory,
    /// Go to a place and back with a trapezoid of the speed: way (deg), speed (deg/s), rest between
    /// there and back (s), half the time of a blend (s).
    Trapezoid([f64; 4]),
    /// Identify the joint by the device's bounded sequence of motions.
    IdentifyJoint,
    /// Find the friction by a ramp.
    Identify {
        /// How fast the effort rises, V/s.
        rate: f32,
        /// Time between the rise and the fall, s.
        hold: f32,
    },
    /// Clear the latched fault.
    Clear,
    /// Change parameters by their paths, as in `limits.stall_v`. Each value is written as it would
    /// be in a machine's file.
    Set(BTreeMap<String, String>),
    /// Take the parameters of a machine's file, whose text this is.
    Push(String),
    /// Take the parameters that were in use before the last change.
    Undo,
    /// Keep what is in use across a reset.
    Save,
    /// Say what a move would be like. It asks the device nothing, and is no word.
    Predict(Box<Wish>),
    /// Compare what is in use with a machine's file, whose text this is; empty: with the file that
    /// the studio was started with. It asks the device nothing.
    Compare(String),
    /// Predict a self-test of so many moves: within so many deg to either side, or else within the
    /// range that is derived.
    PredictSelftest {
        /// Range to either side, deg.
        range_deg: Option<f64>,
        /// Moves.
        moves: usize,
        /// Whose joint it is.
        joint: Source,
    },
    /// End the prediction of a self-test that is computed.
    CancelSelftest,
    /// Make the moves of the self-test that was predicted last, if its prediction has this number.
    Selftest(u32),
    /// Tune controllers for a goal. It asks the device nothing.
    Tune(Box<Tuning>),
    /// End the tuning that runs.
    CancelTuning,
}

impl TryFrom<Written> for Request {
    type Error = String;

    fn try_from(written: Written) -> Result<Self, String> {
        let Written { id, r#do: what, deg, rate, hold, values, text, .. } = written;
        let Written { trapezoid, wish, laws, goal, moves, joint, limits, cases, .. } = written;
        let number = written.number;
        let all = [
            deg.is_some(),
            rate.is_some(),
            hold.is_some(),
            values.is_some(),
            text.is_some(),
            trapezoid.is_some(),
            wish.is_some(),
            laws.is_some(),
            goal.is_some(),
            moves.is_some(),
            joint.is_some(),
            limits.is_some(),
            cases.is_some(),
            number.is_some(),
        ];
        let given = all.into_iter().filter(|given| *given).count();
        let also = |some: &[bool]| some.iter().filter(|some| **some).count();
        let whose = joint.unwrap_or_default();
        let (ask, wanted) = match what.as_str() {
            "alive" => (Some(Ask::Alive), 0),
            "command" => (Some(Ask::Command), 0),
            "stop" => (Some(Ask::Stop), 0),
            "arm" => (Some(Ask::Arm), 0),
            "hold" => (Some(Ask::Hold), 0),
            "jog" => (Some(Ask::Jog), 0),
            "clear" => (Some(Ask::Clear), 0),
            "undo" => (Some(Ask::Undo), 0),
            "save" => (Some(Ask::Save), 0),
            "move" => (deg.map(Ask::Move), 1),
            "step" => (deg.map(Ask::Step), 1),
            "set" => (values.map(Ask::Set), 1),
            "push" => (text.map(Ask::Push), 1),
            "compare" => (text.map(Ask::Compare), 1),
            "predict" => (wish.filter(Wish::is_small).map(|wish| Ask::Predict(wish.into())), 1),
            "selftest" => (number.map(Ask::Selftest), 1),
            "predict-selftest" => {
                let moves = moves.filter(|moves| MOVES.contains(moves));
                let ask = |moves| Ask::PredictSelftest { range_deg: deg, moves, joint: whose };
                (moves.map(ask), 1 + also(&[deg.is_some(), joint.is_some()]))
            }
            "cancel-selftest" => (Some(Ask::CancelSelftest), 0),
            "tune" => {
                let more = also(&[joint.is_some(), limits.is_some(), cases.is_some()]);
                let limits = limits.unwrap_or_default();
                let wanted = laws.zip(goal).filter(|_| limits.len() <= LIMITS);
                let tuning = wanted.map(|(laws, goal)| {
                    Ask::Tune(Tuning { laws, goal, joint: whose, limits, cases }.into())
                });
                (tuning, 2 + more)
            }
            "cancel-tuning" => (Some(Ask::CancelTuning), 0),
            "trajectory" if given == 0 => (Some(Ask::Trajectory), 0),
            "trajectory" => (trapezoid.map(Ask::Trapezoid), 1),
            "identify" if given == 0 => (Some(Ask::IdentifyJoint), 0),
            "identify" => (rate.zip(hold).map(|(rate, hold)| Ask::Identify { rate, hold }), 2),
            _ => return Err(format!("there is nothing to do that is called `{what}`")),
        };
        match ask {
            Some(what) if given == wanted => Ok(Self { id, what }),
            _ => Err(format!("`{what}` wants other values than those that are given")),
        }
    }
}

impl Ask {
    /// Whether any page may ask for it, and not only the one that commands.
    pub const fn is_for_all(&self) -> bool {
        matches!(self, Self::Stop | Self::Command) || self.is_apart()
    }

    /// Whether nothing is asked of the device: other threads answer, and the request is no word
    /// that would keep a link alive.
    pub const fn is_apart(&self) -> bool {
        matches!(self, Self::Predict(_) | Self::Compare(_) | Self::Tune(_) | Self::CancelTuning)
    }
}

#[cfg(test)]
#[allow(clippy::panic)]
mod tests {
    use super::*;

    #[test]
    fn a_request_is_taken_whole_or_not_at_all() {
        let read = |text: &str| serde_json::from_str::<Request>(text).ok();
        let whole = Request { id: 7, what: Ask::Move(-2.5) };
        assert_eq!(read(r#"{"id":7,"do":"move","deg":-2.5}"#), Some(whole));
        assert_eq!(read(r#"{"do":"stop"}"#), Some(Request { id: 0, what: Ask::Stop }));
        let wished = r#"{"do":"predict","wish":{"laws":["pd"],"way":{"how":"step","deg":1}}}"#;
        let Some(Request { what: Ask::Predict(wish), .. }) = read(wished) else { panic!() };
        assert_eq!((&wish.way, wish.cloud), (&Way::Step(1.0), 0));
        assert_eq!(read(r#"{"do":"trajectory"}"#).map(|all| all.what), Some(Ask::Trajectory));
        let tuned = r#"{"do":"tune","laws":["pd"],"goal":"settle","joint":"found","cases":3}"#;
        let Some(Request { what: Ask::Tune(tuning), .. }) = read(tuned) else { panic!() };
        assert_eq!((tuning.joint, tuning.cases), (Source::Found, Some(3)));
        let tested = r#"{"do":"predict-selftest","moves":2,"joint":"found"}"#;
        let of = Ask::PredictSelftest { range_deg: None, moves: 2, joint: Source::Found };
        assert_eq!(read(tested).map(|all| all.what), Some(of));
        let made = read(r#"{"do":"selftest","number":2}"#).map(|all| all.what);
        assert_eq!(made, Some(Ask::Selftest(2)));
        for wrong in [
            r#"{"id":7,"do":"move"}"#,
            r#"{"id":7,"do":"arm","deg":1}"#,
            r#"{"id":7,"do":"arm","now":1}"#,
            r#"{"do":"identify","rate":0.1}"#,
            r#"{"id":7,"do":"move","deg":"5"}"#,
            r#"{"id":7,"do":"move","deg":NaN}"#,
            r#"{"id":7,"do":"fly"}"#,
            r#"{"id":-1,"do":"arm"}"#,
            r#"{"do":"trajectory","trapezoid":[1,2,3]}"#,
            r#"{"do":"trajectory","deg":1}"#,
            r#"{"do":"predict"}"#,
            r#"{"do":"tune","goal":"settle"}"#,
            r#"{"do":"predict-selftest","deg":2}"#,
            r#"{"do":"predict-selftest","moves":1}"#,
            r#"{"do":"tune","laws":[],"goal":"win"}"#,
            r#"{"do":"tune","laws":[],"goal":"settle","joint":"mine"}"#,
            r#"{"do":"tune","laws":[],"goal":"settle","cases":-1}"#,
            r#"{"do":"tune","laws":[],"goal":"settle","cases":8,"moves":2}"#,
            r#"{"do":"cancel-selftest","moves":2}"#,
            r#"{"do":"selftest"}"#,
            r#"{"do":"selftest","number":-1}"#,
            r#"{"do":"arm","number":1}"#,
            r#"{"do":"predict","wish":{"laws":["pd"]}}"#,
            r#"{"do":"predict","wish":{"laws":["pd"],"way":{"how":"fly","deg":1}}}"#,
            r#"{"do":"predict","wish":{"laws":["pd"],"cloud":49,"way":{"how":"move","deg":1}}}"#,
            r#"[{"do":"arm"}]"#,
            "",
        ] {
            assert_eq!(read(wrong), None, "{wrong}");
        }
    }
}
