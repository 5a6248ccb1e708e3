//! `[goal]`: tolerance and times that decide whether a joint has reached its target.

use schemars::JsonSchema;
use serde::de::{Error, Unexpected};
use serde::{Deserialize, Deserializer, Serialize};

use crate::error::shown;

/// Default tolerance, counts of the encoder.
pub const TOLERANCE_COUNTS: f64 = 2.0;

/// `[goal]`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct PositionGoal {
    // One line of the schema.
    #[doc = "Largest error at which the joint counts as being at its target, deg. Left out: two \
             counts of the encoder."]
    #[serde(deserialize_with = "above_zero", skip_serializing_if = "Option::is_none")]
    #[schemars(extend("x-bounds" = "above 0", "exclusiveMinimum" = 0))]
    pub tolerance_deg: Option<f64>,
    // One line of the schema.
    #[doc = "Longest time from the end of the set point's motion until the joint is within the \
             tolerance and stays there, s; a step ends at its start. Left out: the rest of the run \
             or of the move."]
    #[serde(deserialize_with = "above_zero", skip_serializing_if = "Option::is_none")]
    #[schemars(extend("x-bounds" = "above 0", "exclusiveMinimum" = 0))]
    pub settle_s: Option<f64>,
    // One line of the schema.
    #[doc = "Time that the joint has to stay within the tolerance, s. Left out: until the end of \
             the run or of the move."]
    #[serde(deserialize_with = "above_zero", skip_serializing_if = "Option::is_none")]
    #[schemars(extend("x-bounds" = "above 0", "exclusiveMinimum" = 0))]
    pub hold_s: Option<f64>,
}

impl PositionGoal {
    /// Returns the tolerance in counts of an encoder with the resolution `count_deg` (deg).
    /// Without `tolerance_deg` it is exactly [`TOLERANCE_COUNTS`].
    pub fn tolerance_counts(&self, count_deg: f64) -> f64 {
        self.tolerance_deg.map_or(TOLERANCE_COUNTS, |tolerance_deg| tolerance_deg / count_deg)
    }

    /// Returns the goal with its tolerance in both units; one count of the encoder is `count_deg`,
    /// deg.
    pub fn in_both_units(&self, count_deg: f64) -> GoalInBothUnits {
        let tolerance_counts = self.tolerance_counts(count_deg);
        GoalInBothUnits {
            tolerance_deg: self.tolerance_deg.unwrap_or(tolerance_counts * count_deg),
            tolerance_counts,
            settle_s: self.settle_s,
            hold_s: self.hold_s,
        }
    }

    /// Returns the time for which a joint must be watched after the end of the set point's motion,
    /// s: `least_s`, or longer if the goal has a longer settling time or a hold time.
    pub fn watched_s(&self, least_s: f64) -> f64 {
        self.settle_s.unwrap_or(0.0).max(least_s) + self.hold_s.unwrap_or(0.0)
    }

    /// Returns the goal in words, such as "within 2 counts until the end".
    pub fn describe(&self) -> String {
        let tolerance = match self.tolerance_deg {
            Some(tolerance_deg) => format!("within {} deg", shown(tolerance_deg)),
            None => format!("within {TOLERANCE_COUNTS} counts"),
        };
        let settle = self
            .settle_s
            .map_or_else(String::new, |settle_s| format!(" after at most {} s", shown(settle_s)));
        let hold = self
            .hold_s
            .map_or_else(|| "until the end".into(), |hold_s| format!("for {} s", shown(hold_s)));
        format!("{tolerance}{settle} {hold}")
    }

    /// Returns whether no key of the table is set.
    pub fn is_default(&self) -> bool {
        *self == Self::default()
    }
}

/// `goal` in JSON: the goal by which a motion was judged.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct GoalInBothUnits {
    /// Largest error at the target, deg.
    pub tolerance_deg: f64,
    /// Largest error at the target, counts of the encoder.
    pub tolerance_counts: f64,
    /// Longest time until the error stays within the tolerance, s; `None`: no limit.
    pub settle_s: Option<f64>,
    /// Time for which the error must stay within the tolerance, s; `None`: until the end.
    pub hold_s: Option<f64>,
}

/// Reads a number above zero.
fn above_zero<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Option<f64>, D::Error> {
    const ALLOWED: &str = "a finite number above 0";
    let found = f64::deserialize(deserializer)?;
    if found > 0.0 && found.is_finite() {
        return Ok(Some(found));
    }
    // The message shows the value of the file.
    Err(D::Error::invalid_value(Unexpected::Other("that"), &ALLOWED))
}
