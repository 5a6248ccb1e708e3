//! Requests of a page: one JSON object a message.

use std::collections::BTreeMap;
use std::ops::RangeInclusive;

use serde::{Deserialize, Serialize};
use stiction::motion::home::{HomeTarget, Sense};

use files::machine::TrajectoryTable;
use studies::tuning::TuningGoal;

/// Size of the largest message of a page, bytes: a machine's file needs less than half.
pub const LARGEST: usize = 64 * 1024;

/// A request of a page. The answer has the same number.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(try_from = "RequestFields")]
pub struct StudioRequest {
    /// The page's own number of the request.
    pub id: u32,
    /// Requested action.
    pub what: StudioAction,
}

/// JSON form of a request: `do` names the action, and the other fields are its values.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct RequestFields {
    #[serde(default)]
    id: u32,
    r#do: String,
    deg: Option<f64>,
    rate: Option<f32>,
    hold: Option<f32>,
    values: Option<BTreeMap<String, String>>,
    text: Option<String>,
    trapezoid: Option<[f64; 4]>,
    wish: Option<PredictionRequest>,
    laws: Option<Vec<String>>,
    goal: Option<TuningGoal>,
    moves: Option<usize>,
    joint: Option<JointSource>,
    limits: Option<Vec<String>>,
    cases: Option<u64>,
    number: Option<u32>,
    home: Option<HomingBounds>,
}

/// Joint of a prediction, a tuning or a self-test.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum JointSource {
    /// The joint of the file that the studio was started with.
    #[default]
    File,
    /// The joint that was identified in this session.
    Found,
}

/// Place of known position, and bounds of the homing to it, as of `stiction device home`. The
/// device has a default for each bound that is absent.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct HomingBounds {
    /// Kind of the place; absent: a hard stop.
    #[serde(default, deserialize_with = "place")]
    pub to: HomeTarget,
    /// Sense in which the place is.
    #[serde(deserialize_with = "sense")]
    pub towards: Sense,
    /// Position of the joint at the place, deg.
    pub at_deg: f64,
    /// Largest effort, V.
    pub effort_v: Option<f32>,
    /// Largest distance from the present position, deg.
    pub travel_deg: Option<f32>,
}

/// Reads the sense of a homing by its name on the command line.
fn sense<'de, D: serde::Deserializer<'de>>(from: D) -> Result<Sense, D::Error> {
    match String::deserialize(from)?.as_str() {
        "minus" => Ok(Sense::Minus),
        "plus" => Ok(Sense::Plus),
        other => Err(serde::de::Error::unknown_variant(other, &["minus", "plus"])),
    }
}

/// Reads the place of a homing by its name on the command line.
fn place<'de, D: serde::Deserializer<'de>>(from: D) -> Result<HomeTarget, D::Error> {
    match String::deserialize(from)?.as_str() {
        "stop" => Ok(HomeTarget::Stop),
        "switch" => Ok(HomeTarget::Switch),
        "index" => Ok(HomeTarget::Index),
        "switch-index" => Ok(HomeTarget::SwitchIndex),
        other => {
            let places = &["stop", "switch", "index", "switch-index"];
            Err(serde::de::Error::unknown_variant(other, places))
        }
    }
}

/// Options of a tuning, as of `stiction tune`.
#[derive(Clone, Debug, PartialEq)]
pub struct TuningRequest {
    /// Controllers of the file; empty selects all.
    pub laws: Vec<String>,
    /// Objective of the gains.
    pub goal: TuningGoal,
    /// Source of the joint.
    pub joint: JointSource,
    /// Upper limits of metrics, `FIGURE=MOST`.
    pub limits: Vec<String>,
    /// Number of joints; `None` selects the command's default.
    pub cases: Option<u64>,
}

/// Largest number of upper limits in a tuning: twice the number of metrics.
const LIMITS: usize = 10;

/// Allowed number of moves of a self-test, as on the command line.
const MOVES: RangeInclusive<usize> = 2..=200;

/// Motion of the set point, from the zero of the arming.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "MotionFields", into = "MotionFields")]
pub enum RequestedMotion {
    /// To a position within the limits of `[profile]`, deg.
    Move(f64),
    /// To a position at once, deg.
    Step(f64),
    /// Along a trajectory.
    Trajectory(TrajectoryTable),
}

/// JSON form of a motion. (A tagged enum does not work: a dependency lets serde_json keep numbers
/// as text, which serde then does not accept as numbers.)
#[derive(Clone, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct MotionFields {
    how: String,
    #[serde(skip_serializing_if = "Option::is_none")]
    deg: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    trajectory: Option<TrajectoryTable>,
}

impl TryFrom<MotionFields> for RequestedMotion {
    type Error = String;

    fn try_from(written: MotionFields) -> Result<Self, String> {
        match (written.how.as_str(), written.deg, written.trajectory) {
            ("move", Some(deg), None) => Ok(Self::Move(deg)),
            ("step", Some(deg), None) => Ok(Self::Step(deg)),
            ("trajectory", None, Some(trajectory)) => Ok(Self::Trajectory(trajectory)),
            (how, ..) => Err(format!("there is no motion `{how}` with these values")),
        }
    }
}

impl From<RequestedMotion> for MotionFields {
    fn from(way: RequestedMotion) -> Self {
        let (how, deg, trajectory) = match way {
            RequestedMotion::Move(deg) => ("move", Some(deg), None),
            RequestedMotion::Step(deg) => ("step", Some(deg), None),
            RequestedMotion::Trajectory(trajectory) => ("trajectory", None, Some(trajectory)),
        };
        Self { how: how.into(), deg, trajectory }
    }
}

/// Request of a prediction.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PredictionRequest {
    /// The move, from the present position.
    pub way: RequestedMotion,
    /// Present position, deg from where the joint was armed. It shifts the predicted curves, and
    /// gravity depends on it.
    #[serde(default)]
    pub from_deg: f64,
    /// The controllers; the cloud is computed for the first one.
    pub laws: Vec<String>,
    /// Values that differ from the machine in use, by their paths.
    #[serde(default)]
    pub values: BTreeMap<String, f64>,
    /// Number of joints of the cloud.
    #[serde(default)]
    pub cloud: u8,
    /// The joint.
    #[serde(default)]
    pub joint: JointSource,
}

/// Largest numbers of laws, changed values and joints in a prediction.
const LARGEST_WISH: [usize; 3] = [16, 128, 48];

impl PredictionRequest {
    fn is_small(&self) -> bool {
        let [laws, values, cloud] = LARGEST_WISH;
        let is_small = self.laws.len() <= laws && self.values.len() <= values;
        is_small && usize::from(self.cloud) <= cloud
    }
}

/// Action that a page requests.
#[derive(Clone, Debug, PartialEq)]
pub enum StudioAction {
    /// Keep-alive of the page. It has no answer.
    Alive,
    /// Request of the command over the device.
    Command,
    /// Turn the output off.
    Stop,
    /// Close the loop at the present position.
    Arm,
    /// Stop the joint, with the loop closed.
    Hold,
    /// Move within the limits of `[profile]` to a position from the zero of the arming, deg.
    Move(f64),
    /// Step to a position, deg.
    Step(f64),
    /// Push the joint a little each way.
    Jog,
    /// Find a hard stop, and set the joint's position there.
    Home(HomingBounds),
    /// Follow the first trajectory of the machine's file.
    Trajectory,
    /// Go to a position and back with a trapezoid of the speed: distance (deg), speed (deg/s), rest
    /// between the two (s), half the time of a blend (s).
    Trapezoid([f64; 4]),
    /// Identify the joint by the device's bounded sequence of motions.
    IdentifyJoint,
    /// Identify the friction by a ramp.
    Identify {
        /// Rate of the effort, V/s.
        rate: f32,
        /// Time between the rise and the fall, s.
        hold: f32,
    },
    /// Clear the latched fault.
    Clear,
    /// Stop the motor that another client has driven, and end that client's session.
    TakeOver,
    /// Set the position at which the joint stands, deg.
    Reference(f64),
    /// Change parameters by their paths, as in `limits.stall_v`. Each value is written as in a
    /// machine's file.
    Set(BTreeMap<String, String>),
    /// Use the parameters of a machine's file, given as text.
    Push(String),
    /// Restore the parameters before the last change.
    Undo,
    /// Save the parameters in use for the next reset.
    Save,
    /// Predict a move. Sends nothing to the device, and is no keep-alive.
    Predict(Box<PredictionRequest>),
    /// Compare the parameters in use with a machine's file, given as text; if it is empty, with the
    /// file that the studio was started with. Sends nothing to the device.
    Compare(String),
    /// Predict a self-test.
    PredictSelftest {
        /// Range to either side, deg; `None` derives it.
        range_deg: Option<f64>,
        /// Number of moves.
        moves: usize,
        /// The joint.
        joint: JointSource,
    },
    /// Cancel the prediction of a self-test.
    CancelSelftest,
    /// Make the moves of the self-test that was predicted last. Its prediction must have this
    /// number.
    Selftest(u32),
    /// Tune controllers for a goal. Sends nothing to the device.
    Tune(Box<TuningRequest>),
    /// Cancel the running tuning.
    CancelTuning,
}

impl TryFrom<RequestFields> for StudioRequest {
    type Error = String;

    fn try_from(written: RequestFields) -> Result<Self, String> {
        let RequestFields { id, r#do: what, deg, rate, hold, values, text, .. } = written;
        let RequestFields { trapezoid, wish, laws, goal, moves, joint, limits, cases, .. } =
            written;
        let (number, home) = (written.number, written.home);
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
            home.is_some(),
        ];
        let given = all.into_iter().filter(|given| *given).count();
        let also = |some: &[bool]| some.iter().filter(|some| **some).count();
        let whose = joint.unwrap_or_default();
        let (ask, wanted) = match what.as_str() {
            "alive" => (Some(StudioAction::Alive), 0),
            "command" => (Some(StudioAction::Command), 0),
            "stop" => (Some(StudioAction::Stop), 0),
            "arm" => (Some(StudioAction::Arm), 0),
            "hold" => (Some(StudioAction::Hold), 0),
            "jog" => (Some(StudioAction::Jog), 0),
            "clear" => (Some(StudioAction::Clear), 0),
            "take-over" => (Some(StudioAction::TakeOver), 0),
            "undo" => (Some(StudioAction::Undo), 0),
            "save" => (Some(StudioAction::Save), 0),
            "move" => (deg.map(StudioAction::Move), 1),
            "step" => (deg.map(StudioAction::Step), 1),
            "home" => (home.map(StudioAction::Home), 1),
            "reference" => (deg.map(StudioAction::Reference), 1),
            "set" => (values.map(StudioAction::Set), 1),
            "push" => (text.map(StudioAction::Push), 1),
            "compare" => (text.map(StudioAction::Compare), 1),
            "predict" => (
                wish.filter(PredictionRequest::is_small)
                    .map(|wish| StudioAction::Predict(wish.into())),
                1,
            ),
            "selftest" => (number.map(StudioAction::Selftest), 1),
            "predict-selftest" => {
                let moves = moves.filter(|moves| MOVES.contains(moves));
                let ask =
                    |moves| StudioAction::PredictSelftest { range_deg: deg, moves, joint: whose };
                (moves.map(ask), 1 + also(&[deg.is_some(), joint.is_some()]))
            }
            "cancel-selftest" => (Some(StudioAction::CancelSelftest), 0),
            "tune" => {
                let more = also(&[joint.is_some(), limits.is_some(), cases.is_some()]);
                let limits = limits.unwrap_or_default();
                let wanted = laws.zip(goal).filter(|_| limits.len() <= LIMITS);
                let tuning = wanted.map(|(laws, goal)| {
                    StudioAction::Tune(
                        TuningRequest { laws, goal, joint: whose, limits, cases }.into(),
                    )
                });
                (tuning, 2 + more)
            }
            "cancel-tuning" => (Some(StudioAction::CancelTuning), 0),
            "trajectory" if given == 0 => (Some(StudioAction::Trajectory), 0),
            "trajectory" => (trapezoid.map(StudioAction::Trapezoid), 1),
            "identify" if given == 0 => (Some(StudioAction::IdentifyJoint), 0),
            "identify" => {
                (rate.zip(hold).map(|(rate, hold)| StudioAction::Identify { rate, hold }), 2)
            }
            _ => return Err(format!("there is no action `{what}`")),
        };
        match ask {
            Some(what) if given == wanted => Ok(Self { id, what }),
            _ => Err(format!("`{what}` needs other values than those that are given")),
        }
    }
}

impl StudioAction {
    /// Returns whether every page may request the action, not only the page that commands.
    pub const fn is_for_all(&self) -> bool {
        matches!(self, Self::Stop | Self::Command) || self.is_apart()
    }

    /// Returns whether the action sends nothing to the device. Such an action is answered outside
    /// the device's thread, and is no keep-alive.
    pub const fn is_apart(&self) -> bool {
        matches!(self, Self::Predict(_) | Self::Compare(_) | Self::Tune(_) | Self::CancelTuning)
    }
}

#[cfg(test)]
#[allow(clippy::panic)]
mod tests {
    use super::*;

    #[test]
    fn a_request_is_read_whole_or_not_at_all() {
        let read = |text: &str| serde_json::from_str::<StudioRequest>(text).ok();
        let whole = StudioRequest { id: 7, what: StudioAction::Move(-2.5) };
        assert_eq!(read(r#"{"id":7,"do":"move","deg":-2.5}"#), Some(whole));
        assert_eq!(
            read(r#"{"do":"stop"}"#),
            Some(StudioRequest { id: 0, what: StudioAction::Stop })
        );
        let wished = r#"{"do":"predict","wish":{"laws":["pd"],"way":{"how":"step","deg":1}}}"#;
        let Some(StudioRequest { what: StudioAction::Predict(wish), .. }) = read(wished) else {
            panic!()
        };
        assert_eq!((&wish.way, wish.cloud), (&RequestedMotion::Step(1.0), 0));
        assert_eq!(
            read(r#"{"do":"trajectory"}"#).map(|all| all.what),
            Some(StudioAction::Trajectory)
        );
        let tuned = r#"{"do":"tune","laws":["pd"],"goal":"settle","joint":"found","cases":3}"#;
        let Some(StudioRequest { what: StudioAction::Tune(tuning), .. }) = read(tuned) else {
            panic!()
        };
        assert_eq!((tuning.joint, tuning.cases), (JointSource::Found, Some(3)));
        let tested = r#"{"do":"predict-selftest","moves":2,"joint":"found"}"#;
        let of =
            StudioAction::PredictSelftest { range_deg: None, moves: 2, joint: JointSource::Found };
        assert_eq!(read(tested).map(|all| all.what), Some(of));
        let made = read(r#"{"do":"selftest","number":2}"#).map(|all| all.what);
        assert_eq!(made, Some(StudioAction::Selftest(2)));
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
