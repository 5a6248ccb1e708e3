//! Check of the answers so far: the data sheet that they make, with neutral values in place of the
//! answers that are still missing.
//!
//! The neutral values cause no refusal: no friction, no load, a motor of 1 N m/A. So a refusal is
//! due to the newest answer if the earlier ones have passed. Each end of a range is checked as a
//! joint of its own, with a dynamic friction that is never above the static one.

use toml::{Table, Value};

use super::answers::Answers;
use super::questions::{QUESTIONS, Question};
use super::range;
use files::data_sheet::{DataSheet, Mapping, SheetTables, WrittenDrive};
use files::error::rounded;

/// Function that picks the value of a joint from a range.
type Pick = fn([f64; 2]) -> f64;

/// Joints that are checked: the nominal one, and both ends of the ranges.
const PICKS: [Pick; 3] = [range::nominal, |[low, _]| low, |[_, high]| high];

/// Checks the answers to the questions up to the one at `place`.
///
/// # Errors
/// Returns one sentence with what was found and what is allowed.
pub fn check(answers: &Answers, place: usize) -> Result<(), String> {
    let is_reached = |key: &str| Question::place(key).is_some_and(|at| at <= place);
    // The tables of a data sheet differ by the drive.
    if !is_reached("motor.driven_by") || answers.get("motor.driven_by").is_none() {
        return Ok(());
    }
    let [slip, stick] = ["friction.slip_nm", "friction.stick_nm"].map(|key| answers.number(key));
    if is_reached("friction.slip_nm")
        && let (Some(slip), Some(stick)) = (slip, stick)
        && slip > stick
    {
        return Err(format!(
            "the dynamic friction ({} N m) must not be above the static friction ({} N m)",
            rounded(slip),
            rounded(stick)
        ));
    }
    PICKS.iter().try_for_each(|pick| {
        let sheet = sheet(answers, place, *pick)?;
        sheet.can_be_simulated().map_err(|why| why.sentence)?;
        match Mapping::of(&sheet, WrittenDrive::default()) {
            Some(mapping) => can_move(&sheet, &mapping),
            None => Ok(()),
        }
    })
}

/// Refuses a friction or a gravity that the motor cannot overcome.
fn can_move(sheet: &DataSheet, mapping: &Mapping) -> Result<(), String> {
    sheet.can_move(mapping).map_err(|why| why.sentence)?;
    let (unbalance, stall) = (sheet.load.unbalance_nm, mapping.stall());
    if unbalance < stall {
        return Ok(());
    }
    Err(format!(
        "gravity ({} N m) must be below the motor's stall torque at the joint ({} N m): \
         reduce the unbalance, or choose a stronger motor or gear",
        rounded(unbalance),
        rounded(stall)
    ))
}

/// Makes the data sheet of the answers so far.
fn sheet(answers: &Answers, place: usize, pick: Pick) -> Result<DataSheet, String> {
    let mut tables = Table::new();
    for (at, question) in QUESTIONS.iter().enumerate() {
        let Some((table, key)) = question.key.split_once('.') else { continue };
        if table == "limits" || table == "loop" || !answers.asks(question) {
            continue;
        }
        let number = answers.range(question.key).map(|ends| Value::Float(pick(ends)));
        let answer = || answers.get(question.key).map(|answer| answer.value.clone());
        let value = match (at <= place, neutral(question.key)) {
            // A word such as `rigid` leaves the key out.
            (true, _) if question.otherwise.is_some() && number.is_none() => {
                answer().filter(Value::is_integer)
            }
            (true, neutral) => number.or_else(answer).or(neutral),
            (false, neutral) => neutral,
        };
        let Some(value) = value else { continue };
        if let Value::Table(table) =
            tables.entry(table).or_insert_with(|| Value::Table(Table::new()))
        {
            table.insert(key.into(), value);
        }
    }
    // Until its stiffness is answered, the gear has a neutral one: backlash needs a stiffness.
    let waits = Question::place("gear.stiffness_nm_per_rad").is_some_and(|at| at > place);
    if let Some(Value::Table(gear)) = tables.get_mut("gear").filter(|_| waits) {
        gear.insert("stiffness_nm_per_rad".into(), Value::Float(1.0));
    }
    if let Some(Value::Table(friction)) = tables.get_mut("friction") {
        let of = |key: &str| friction.get(key).and_then(Value::as_float);
        if let (Some(slip), Some(stick)) = (of("slip_nm"), of("stick_nm")) {
            friction.insert("slip_nm".into(), Value::Float(slip.min(stick)));
        }
    }
    if answers.get("motor.driven_by").is_some_and(|by| by.value.as_str() == Some("current")) {
        tables.remove("supply");
    }
    let tables: SheetTables =
        tables.try_into().map_err(|why: toml::de::Error| why.message().to_owned())?;
    let sheet = tables.sheet().map_err(|why| why.sentence)?;
    sheet.ok_or_else(|| "the motor is missing".into())
}

/// Returns the neutral value of a missing answer; `None`: the key is left out.
fn neutral(key: &str) -> Option<Value> {
    match key {
        "motor.driven_by" => Some(Value::String("voltage".into())),
        "encoder.at" => Some(Value::String("motor".into())),
        "encoder.lines" => Some(Value::Integer(1)),
        "friction.stick_nm" | "friction.slip_nm" => Some(Value::Float(0.0)),
        "supply.voltage_v"
        | "motor.resistance_ohm"
        | "motor.amplifier_a_per_v"
        | "motor.kt_nm_per_a"
        | "motor.rotor_inertia_kg_m2"
        | "gear.ratio"
        | "gear.efficiency"
        | "load.inertia_kg_m2" => Some(Value::Float(1.0)),
        _ => None,
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;
    use crate::draft::Typical;

    /// Answers one question of the gimbal otherwise, and checks up to it.
    fn refused(key: &str, typed: &str) -> Option<String> {
        let mut answers = Typical::find("gimbal").unwrap().answers().unwrap();
        let place = Question::place(key).unwrap();
        answers.put(key, QUESTIONS[place].read(typed).unwrap(), "");
        check(&answers, place).err()
    }

    #[test]
    fn an_answer_is_refused_at_its_own_question_with_the_reason() {
        // The stall torque is 50 x 0.68 x 0.011 N m/A x 2 A = 0.748 N m.
        for (key, typed, said) in [
            ("supply.voltage_v", "0", "above 0"),
            ("motor.resistance_ohm", "-1", "above 0"),
            ("motor.kt_nm_per_a", "0", "above 0"),
            ("motor.rotor_inertia_kg_m2", "-1", "not below 0"),
            ("motor.current_limit_a", "0", "above 0"),
            ("gear.ratio", "0", "above 0"),
            ("gear.efficiency", "1.2", "above 0, up to 1"),
            ("gear.efficiency", "0", "above 0, up to 1"),
            ("load.unbalance_nm", "0.1..0.8", "stall torque at the joint (0.748 N m)"),
            ("friction.stick_nm", "0.75", "stall torque at the joint is 0.748 N m"),
            ("friction.stick_nm", "0.1..0.8", "stall torque at the joint is 0.748 N m"),
            ("friction.slip_nm", "0.09", "must not be above the static friction (0.08 N m)"),
            ("encoder.lines", "0", "above 0"),
        ] {
            let why = refused(key, typed).unwrap_or_default();
            assert!(why.contains(said), "{key} = {typed}: {why:?}");
        }
        for (key, typed) in [
            ("gear.efficiency", "1"),
            ("gear.backlash_deg", "0.2..0.6"),
            ("gear.stiffness_nm_per_rad", "200"),
            ("load.unbalance_nm", "0..0.74"),
            ("friction.stick_nm", "0.05..0.74"),
            // The upper end is above the static friction, which lowers it in a joint.
            ("friction.slip_nm", "0.04..0.1"),
            ("limits.travel_deg", "-30..90"),
            ("loop.sample_time_s", "0.001"),
        ] {
            assert_eq!(refused(key, typed), None, "{key} = {typed}");
        }
    }

    #[test]
    fn backlash_in_a_rigid_gear_is_refused_at_the_question_of_the_stiffness() {
        let mut answers = Typical::find("gimbal").unwrap().answers().unwrap();
        let mut put = |key: &str, typed: &str| {
            let place = Question::place(key).unwrap();
            answers.put(key, QUESTIONS[place].read(typed).unwrap(), "");
            check(&answers, place)
        };
        assert_eq!(put("gear.backlash_deg", "0.5"), Ok(()));
        let why = put("gear.stiffness_nm_per_rad", "rigid").unwrap_err();
        assert!(why.contains("needs its stiffness"), "{why}");
        assert_eq!(put("gear.stiffness_nm_per_rad", "100..300"), Ok(()));
    }
}
