//! Result of a homing, as text and as JSON.

use serde_json::{Value, json};
use stiction::link::Status;
use stiction::motion::home::{HomeEnd, HomeFindings};

use files::written::single;

/// Result of a homing, and the state of the joint after it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HomeResult {
    /// Findings of the device.
    pub found: HomeFindings,
    /// Angle of a count, deg.
    pub resolution: f32,
    /// Position of the joint after the homing, deg; from the reference if there is one.
    pub position_deg: f64,
    /// Whether the device counts the joint as referenced now.
    pub is_referenced: bool,
}

impl HomeResult {
    /// Returns the result of a homing with these findings, after which the device has this status.
    pub fn new(found: HomeFindings, status: &Status) -> Self {
        let resolution = status.resolution;
        let position_deg = f64::from(status.position) * f64::from(resolution);
        Self { found, resolution, position_deg, is_referenced: status.is_referenced }
    }

    /// Returns whether the stop was found and the joint is referenced.
    pub fn is_found(&self) -> bool {
        self.found.ended == HomeEnd::Stop && self.is_referenced
    }

    /// Returns what ended the homing as half a sentence.
    pub const fn headline(&self) -> &'static str {
        match self.found.ended {
            HomeEnd::Stop if self.is_referenced => {
                "the stop was found twice, and the joint is referenced"
            }
            HomeEnd::Stop => "the stop was found, but a fault has ended the reference since",
            HomeEnd::Travel if self.is_referenced => {
                "no stop within the travel; the joint is referenced by its encoder's angle"
            }
            HomeEnd::Travel => "no stop within the travel; the joint is not referenced",
            HomeEnd::Time | HomeEnd::Not if self.is_referenced => {
                "no stop within the time; the joint is referenced by its encoder's angle"
            }
            HomeEnd::Time | HomeEnd::Not => "no stop within the time; the joint is not referenced",
        }
    }
}

/// Returns the next steps, one per line.
const fn advice(ended: HomeEnd) -> &'static [&'static str] {
    match ended {
        HomeEnd::Stop => &["the joint has gone back from its stop a little"],
        HomeEnd::Travel => &[
            "is the stop in the other sense, or farther? Allow it more travel then. A stop that",
            "gives way under the effort needs less of it.",
        ],
        HomeEnd::Time | HomeEnd::Not => &[
            "the joint was too slow, was held with less than the largest effort, was blocked at",
            "other places each time, or did not come back. A heavy joint needs more effort, a long",
            "way more time.",
        ],
    }
}

impl HomeResult {
    fn moved_deg(&self) -> f64 {
        f64::from(self.found.moved) * f64::from(self.resolution)
    }

    /// Returns the result as text, with the next steps.
    pub fn words(&self) -> String {
        let HomeFindings { ended, moved, effort, touches } = self.found;
        let deg = self.moved_deg();
        let mut lines = vec![
            format!("home       {}", self.headline()),
            format!("moved      {deg:+.4} deg ({moved:+} counts), there with {effort:+.3} V"),
            format!("position   {:+.4} deg; blocked {touches} times", self.position_deg),
        ];
        lines.extend(advice(ended).iter().map(|line| format!("           {line}")));
        lines.join("\n") + "\n"
    }

    /// Returns the JSON object for scripts.
    pub fn json(&self, warning: Option<&str>) -> Value {
        let HomeFindings { ended, moved, effort, touches } = self.found;
        let ended_by = match ended {
            HomeEnd::Not => "not-ended",
            HomeEnd::Stop => "stop",
            HomeEnd::Travel => "travel",
            HomeEnd::Time => "time",
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
            "position_deg": self.position_deg,
        })
    }
}
