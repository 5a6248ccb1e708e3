//! Answers to the questions, and assumptions in place of missing ones.

use toml::Value;

use super::questions::{AnswerKind, OnlyFor, QUESTIONS, Question};
use super::range;

/// An answer, and where it comes from.
#[derive(Clone, Debug, PartialEq)]
pub struct Answer {
    /// Value: a number, two ends of a range, or a word.
    pub value: Value,
    /// Source; empty if it is the user's own.
    pub source: &'static str,
}

/// Answers to the questions, in their order.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Answers([Option<Answer>; QUESTIONS.len()]);

/// Source of an assumed stiffness.
const OF_BACKLASH: &str = "assumed: winds up by the backlash at stall";

/// Source of an assumed position at which the load hangs.
const HORIZONTAL: &str = "assumed: horizontal at power-on, the worst place";

impl Answers {
    /// Sets the answer to a question.
    pub fn put(&mut self, key: &str, value: Value, source: &'static str) {
        if let Some(place) = Question::place(key) {
            self.0[place] = Some(Answer { value, source });
        }
    }

    /// Removes the answer to a question.
    pub fn remove(&mut self, key: &str) {
        if let Some(place) = Question::place(key) {
            self.0[place] = None;
        }
    }

    /// Returns the answer to a question.
    pub fn get(&self, key: &str) -> Option<&Answer> {
        self.0.get(Question::place(key)?)?.as_ref()
    }

    /// Returns these answers, and those of `other` where they are missing.
    #[must_use]
    pub fn or(&self, other: &Self) -> Self {
        let mut all = self.clone();
        for (one, other) in all.0.iter_mut().zip(&other.0) {
            if one.is_none() {
                one.clone_from(other);
            }
        }
        all
    }

    /// Returns both ends of a number or a range.
    pub fn range(&self, key: &str) -> Option<[f64; 2]> {
        match &self.get(key)?.value {
            Value::Array(ends) => Some([ends.first()?.as_float()?, ends.get(1)?.as_float()?]),
            value => value.as_float().map(|number| [number; 2]),
        }
    }

    /// Returns both ends of a range; `None` for a single number.
    pub fn only_range(&self, key: &str) -> Option<[f64; 2]> {
        self.get(key)?.value.as_array()?;
        self.range(key)
    }

    /// Returns a number, or the nominal of a range.
    pub fn number(&self, key: &str) -> Option<f64> {
        self.range(key).map(range::nominal)
    }

    /// Returns whether a joint with these answers has the quantity of a question.
    pub fn asks(&self, question: &Question) -> bool {
        let driven_by = self.get("motor.driven_by").and_then(|answer| answer.value.as_str());
        match question.only {
            None => true,
            Some(OnlyFor::Voltage) => driven_by == Some("voltage"),
            Some(OnlyFor::Current) => driven_by == Some("current"),
            Some(OnlyFor::Unbalanced) => {
                self.range("load.unbalance_nm").is_some_and(|[_, high]| high > 0.0)
            }
            Some(OnlyFor::BehindAGear) => {
                let at = self.get("encoder.at").and_then(|answer| answer.value.as_str());
                let is_elastic = ["gear.stiffness_nm_per_rad", "gear.backlash_deg"]
                    .iter()
                    .any(|key| self.range(key).is_some_and(|[_, high]| high > 0.0));
                at == Some("motor") && is_elastic
            }
        }
    }

    /// Returns the questions that must be answered and are not.
    pub fn open(&self) -> Vec<Question> {
        let is_open = |question: &&Question| {
            question.otherwise.is_none() && self.asks(question) && self.get(question.key).is_none()
        };
        QUESTIONS.iter().filter(is_open).copied().collect()
    }

    /// Returns the answers with their questions, without those that do not apply to the joint or
    /// state an absence, such as no backlash.
    pub fn given(&self) -> impl Iterator<Item = (&'static Question, &Answer)> {
        let all = QUESTIONS.iter().zip(&self.0);
        all.filter_map(|(question, answer)| Some((question, answer.as_ref()?)))
            .filter(|(question, answer)| self.asks(question) && !is_nothing(question, answer))
    }

    /// Returns these answers with the assumptions on a joint with backlash or unbalance. Backlash
    /// can only be simulated in a gear with a stiffness: by assumption, the gear winds up by the
    /// backlash at the motor's stall torque. An unbalanced load is assumed to be horizontal at
    /// power-on.
    #[must_use]
    pub fn with_assumptions(&self) -> Self {
        let mut all = self.clone();
        if self.get("gear.stiffness_nm_per_rad").is_none()
            && let Some(stiffness) = self.stiffness()
        {
            all.put("gear.stiffness_nm_per_rad", Value::Float(stiffness), OF_BACKLASH);
        }
        let hangs_at = "load.hangs_at_deg";
        let is_unbalanced = self.range("load.unbalance_nm").is_some_and(|[_, high]| high > 0.0);
        if self.get(hangs_at).is_none() && is_unbalanced {
            all.put(hangs_at, Value::Float(-90.0), HORIZONTAL);
        }
        all
    }

    /// Returns the assumed stiffness of a gear with backlash, N m/rad, with two digits.
    fn stiffness(&self) -> Option<f64> {
        let [_, backlash] = self.range("gear.backlash_deg").filter(|[_, high]| *high > 0.0)?;
        let stiffness = self.stall_nm()? / backlash.to_radians();
        format!("{stiffness:.1e}").parse().ok()
    }

    /// Returns the motor's largest torque at the joint at standstill, N m.
    pub fn stall_nm(&self) -> Option<f64> {
        let limit = self.number("motor.current_limit_a")?;
        let current = match self.number("motor.resistance_ohm") {
            Some(ohm) if self.asks_voltage() => (self.number("supply.voltage_v")? / ohm).min(limit),
            _ => limit,
        };
        let [ratio, efficiency] = ["gear.ratio", "gear.efficiency"].map(|key| self.number(key));
        Some(ratio? * efficiency? * self.number("motor.kt_nm_per_a")? * current)
    }

    fn asks_voltage(&self) -> bool {
        self.get("motor.driven_by").and_then(|answer| answer.value.as_str()) == Some("voltage")
    }
}

/// Returns whether an answer states the absence of its quantity: no backlash, a rigid gear.
fn is_nothing(question: &Question, answer: &Answer) -> bool {
    match (question.kind, &answer.value) {
        (
            AnswerKind::RangeOr(word) | AnswerKind::Around(word) | AnswerKind::WholeOr(word),
            Value::String(answer),
        ) => answer == word,
        (AnswerKind::Range, Value::Float(number)) => question.otherwise.is_some() && *number == 0.0,
        _ => false,
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;
    use crate::draft::Typical;

    fn put(answers: &mut Answers, key: &str, typed: &str) {
        let question = QUESTIONS[Question::place(key).unwrap()];
        answers.put(key, question.read(typed).unwrap(), "");
    }

    #[test]
    fn the_stiffness_of_a_gear_with_backlash_is_that_of_its_stall_torque() {
        let mut answers = Typical::find("gimbal").unwrap().answers().unwrap();
        assert!(answers.with_assumptions().get("gear.stiffness_nm_per_rad").is_none());
        put(&mut answers, "gear.backlash_deg", "0.2..0.6");
        // 50 x 0.68 x 0.011 N m/A x 2 A = 0.748 N m over 0.6 deg: 71.4 N m/rad.
        let all = answers.with_assumptions();
        let stiffness = all.number("gear.stiffness_nm_per_rad").unwrap();
        assert!((stiffness - 71.0).abs() < 1e-9, "{stiffness}");
        put(&mut answers, "gear.stiffness_nm_per_rad", "200");
        let own = answers.with_assumptions().number("gear.stiffness_nm_per_rad").unwrap();
        assert!((own - 200.0).abs() < 1e-9);
    }

    #[test]
    fn where_a_load_hangs_is_asked_of_an_unbalanced_one_alone() {
        let mut answers = Typical::find("gimbal").unwrap().answers().unwrap();
        let question = QUESTIONS[Question::place("load.hangs_at_deg").unwrap()];
        assert!(!answers.asks(&question));
        put(&mut answers, "load.unbalance_nm", "0");
        assert!(!answers.asks(&question));
        put(&mut answers, "load.unbalance_nm", "0..0.05");
        assert!(answers.asks(&question) && answers.open().is_empty());
        assert_eq!(answers.with_assumptions().number("load.hangs_at_deg"), Some(-90.0));
    }
}
