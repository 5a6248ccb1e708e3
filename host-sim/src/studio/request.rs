//! What a page may ask for: one JSON object a message.

use std::collections::BTreeMap;

use serde::Deserialize;

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
}

impl TryFrom<Written> for Request {
    type Error = String;

    fn try_from(written: Written) -> Result<Self, String> {
        let Written { id, r#do: what, deg, rate, hold, values, text } = written;
        let all = [deg.is_some(), rate.is_some(), hold.is_some(), values.is_some(), text.is_some()];
        let given = all.into_iter().filter(|given| *given).count();
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
        matches!(self, Self::Stop | Self::Command)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_request_is_taken_whole_or_not_at_all() {
        let read = |text: &str| serde_json::from_str::<Request>(text).ok();
        let whole = Request { id: 7, what: Ask::Move(-2.5) };
        assert_eq!(read(r#"{"id":7,"do":"move","deg":-2.5}"#), Some(whole));
        assert_eq!(read(r#"{"do":"stop"}"#), Some(Request { id: 0, what: Ask::Stop }));
        for wrong in [
            r#"{"id":7,"do":"move"}"#,
            r#"{"id":7,"do":"arm","deg":1}"#,
            r#"{"id":7,"do":"arm","now":1}"#,
            r#"{"do":"identify","rate":0.1}"#,
            r#"{"id":7,"do":"move","deg":"5"}"#,
            r#"{"id":7,"do":"move","deg":NaN}"#,
            r#"{"id":7,"do":"fly"}"#,
            r#"{"id":-1,"do":"arm"}"#,
            r#"[{"do":"arm"}]"#,
            "",
        ] {
            assert_eq!(read(wrong), None, "{wrong}");
        }
    }
}
