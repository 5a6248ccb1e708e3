//! Result of a homing, as text and as JSON.

use serde_json::{Value, json};
use stiction::Parameters;
use stiction::link::Status;
use stiction::motion::home::{HomeEnd, HomeFindings, HomeTarget};

use files::written::single;

/// Result of a homing, and the state of the joint after it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HomeResult {
    /// Findings of the device.
    pub found: HomeFindings,
    /// Place that the homing looked for.
    pub to: HomeTarget,
    /// Angle of a count, deg.
    pub resolution: f32,
    /// Position of the joint after the homing, deg; from the reference if there is one.
    pub position_deg: f64,
    /// Whether the device counts the joint as referenced now.
    pub is_referenced: bool,
    /// Largest twist of a healthy gear at rest, deg, if the index is that of a motor with its own
    /// encoder; 0: the file has none.
    pub twist_deg: Option<f32>,
}

impl HomeResult {
    /// Returns the result of a homing to a place with these findings, after which the device has
    /// this status and these parameters.
    pub fn new(
        found: HomeFindings,
        to: HomeTarget,
        status: &Status,
        parameters: &Parameters,
    ) -> Self {
        let resolution = status.resolution;
        let position_deg = f64::from(status.position) * f64::from(resolution);
        let motor = &parameters.controller.motor;
        let is_of_motor = found.ended == HomeEnd::Index && motor.count().is_some();
        let twist_deg = is_of_motor.then_some(motor.twist);
        let is_referenced = status.is_referenced;
        Self { found, to, resolution, position_deg, is_referenced, twist_deg }
    }

    /// Returns whether the place was found and the joint is referenced.
    pub const fn is_found(&self) -> bool {
        self.found.ended.is_found() && self.is_referenced
    }

    /// Returns what ended the homing as half a sentence.
    pub fn headline(&self) -> String {
        let place = name(self.to);
        let reference = match (self.found.ended, self.is_referenced) {
            (end, true) if end.is_found() => ", and the joint is referenced",
            (end, false) if end.is_found() => ", but a fault has ended the reference since",
            (_, true) => "; the joint is referenced by its encoder's angle",
            (_, false) => "; the joint is not referenced",
        };
        let what = match self.found.ended {
            HomeEnd::Index => "the index was found".into(),
            HomeEnd::Stop | HomeEnd::Switch => format!("the {place} was found twice"),
            HomeEnd::Travel => format!("no {place} within the travel"),
            HomeEnd::Time | HomeEnd::Not => format!("no {place} within the time"),
            HomeEnd::SwitchStuck => "the switch did not let go of the joint".into(),
            HomeEnd::Blocked => {
                format!("the joint was blocked before the {place}, or its encoder does not count")
            }
        };
        what + reference
    }
}

/// Returns the name of a place.
const fn name(to: HomeTarget) -> &'static str {
    match to {
        HomeTarget::Stop => "stop",
        HomeTarget::Switch => "switch",
        HomeTarget::Index => "index",
        HomeTarget::SwitchIndex => "switch with an index",
    }
}

/// Returns the next steps after a homing to a place, one per line.
const fn advice(ended: HomeEnd, to: HomeTarget) -> &'static [&'static str] {
    match (ended, to) {
        (HomeEnd::Stop, _) => &["the joint has gone back from its stop a little"],
        (HomeEnd::Switch, _) => &["the joint has gone back from its switch a little"],
        (HomeEnd::Index, _) => &["the joint has gone back from its index a little"],
        (HomeEnd::Travel, HomeTarget::Stop) => &[
            "is the stop in the other sense, or farther? Allow it more travel then. A stop that",
            "gives way under the effort needs less of it.",
        ],
        (HomeEnd::Travel, HomeTarget::Index) => &[
            "is the travel less than a turn of the encoder? Otherwise no edge came from PA2:",
            "measure it while you turn the encoder by hand.",
        ],
        (HomeEnd::Travel, HomeTarget::Switch | HomeTarget::SwitchIndex) => &[
            "is the switch in the other sense, or farther? Allow it more travel then. A normally",
            "open contact with a cut wire never comes: press it by hand and measure PA7.",
        ],
        (HomeEnd::Time | HomeEnd::Not, HomeTarget::Stop) => &[
            "the joint was too slow, was held with less than the largest effort, was blocked at",
            "other places each time, or did not come back. A heavy joint needs more effort, a long",
            "way more time.",
        ],
        (HomeEnd::Time | HomeEnd::Not, _) => &[
            "the joint was too slow, was held with less than the largest effort, or came to a",
            "switch at another place each time. A heavy joint needs more effort, a long way more",
            "time.",
        ],
        (HomeEnd::SwitchStuck, _) => &[
            "a normally closed contact with a cut wire reads as that, and so does the wrong",
            "`device.home_switch`. Press the switch by hand and measure PA7: with a normally",
            "closed contact it is high at the switch.",
        ],
        (HomeEnd::Blocked, _) => &[
            "clear the way, or use more effort. If the joint has moved, its encoder is dead: jog",
            "it before anything else.",
        ],
    }
}

impl HomeResult {
    fn moved_deg(&self) -> f64 {
        f64::from(self.found.moved) * f64::from(self.resolution)
    }

    /// Returns the result as text, with the next steps.
    pub fn words(&self) -> String {
        let HomeFindings { ended, moved, effort, touches, from_switch } = self.found;
        let deg = self.moved_deg();
        let came = match self.to {
            HomeTarget::Stop => "blocked",
            HomeTarget::Switch | HomeTarget::SwitchIndex => "at the switch",
            HomeTarget::Index => "at the index",
        };
        let mut lines = vec![
            format!("home       {}", self.headline()),
            format!("moved      {deg:+.4} deg ({moved:+} counts), there with {effort:+.3} V"),
            format!("position   {:+.4} deg; {came} {touches} times", self.position_deg),
        ];
        if from_switch != 0 {
            lines.push(format!("index      {from_switch:+} counts from the edge of the switch"));
        }
        if let Some(twist_deg) = self.twist_deg {
            let most = if twist_deg > 0.0 {
                format!(" of {twist_deg:.2} deg at most")
            } else {
                String::new()
            };
            lines.push(
                "gear       the index is the motor's: the load's position there repeats to".into(),
            );
            lines.push(format!(
                "           the change of the gear's twist{most}. Home in one sense"
            ));
        }
        lines.extend(advice(ended, self.to).iter().map(|line| format!("           {line}")));
        lines.join("\n") + "\n"
    }

    /// Returns the JSON object for scripts.
    pub fn json(&self, warning: Option<&str>) -> Value {
        let HomeFindings { ended, moved, effort, touches, from_switch } = self.found;
        let ended_by = match ended {
            HomeEnd::Not => "not-ended",
            HomeEnd::Stop => "stop",
            HomeEnd::Travel => "travel",
            HomeEnd::Time => "time",
            HomeEnd::Switch => "switch",
            HomeEnd::SwitchStuck => "switch-stuck",
            HomeEnd::Blocked => "blocked",
            HomeEnd::Index => "index",
        };
        json!({
            "schema": 1,
            "warning": warning,
            "ended_by": ended_by,
            "referenced": self.is_referenced,
            "touches": touches,
            "moved_counts": moved,
            "moved_deg": self.moved_deg(),
            "effort_v": single(effort),
            "from_switch_counts": from_switch,
            "position_deg": self.position_deg,
        })
    }
}
