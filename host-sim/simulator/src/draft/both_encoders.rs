//! The example of a joint with an encoder on its motor and another one on its load, for tests and
//! measurements.

use super::{QUESTIONS, Question, Typical, text};
use files::error::Error;

/// Its answers beside those of the typical joint `harmonic`: 0.3 deg of slack behind 1000 N m/rad,
/// and 16 384 counts a turn on the load. The motor has 100 000 counts a turn of the joint.
const ANSWERS: [(&str, &str); 3] = [
    ("gear.backlash_deg", "0.3"),
    ("gear.stiffness_nm_per_rad", "1000"),
    ("load_encoder.counts_per_turn", "16384"),
];

/// Returns the file of the example, with gains by rule.
///
/// # Errors
/// Returns an error if an answer does not fit its question; a test writes the file.
pub fn both_encoders() -> Result<String, Error> {
    let mut answers = Typical::find("harmonic")?.answers()?;
    for (key, typed) in ANSWERS {
        let question = Question::place(key).map(|place| QUESTIONS[place]);
        let question = question.ok_or_else(|| Error::Input(format!("no question has {key}")))?;
        answers.put(key, question.read(typed).map_err(Error::Input)?, "");
    }
    text("both-encoders", &answers, None)
}
