//! Questions about a joint. The answers are keys of a machine's file.

use toml::Value;

use super::range;
use files::error::shown;
use files::typed_number;

/// Form of an answer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum AnswerKind {
    /// One line of text.
    Text,
    /// A number, in the unit of the question.
    Number,
    /// A number that is not below zero, or a range of such numbers.
    Range,
    /// A `Range`, or this word.
    RangeOr(&'static str),
    /// A range that includes zero and extends to both sides of it, or this word.
    Around(&'static str),
    /// A whole number.
    Whole,
    /// A whole number, or this word.
    WholeOr(&'static str),
    /// One of these words.
    Words(&'static [&'static str]),
}

/// Joints to which a question applies.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum OnlyFor {
    /// The drive sets the motor's voltage.
    Voltage,
    /// The drive sets the motor's current.
    Current,
    /// The load is unbalanced.
    Unbalanced,
    /// The encoder is on the motor, and the gear has slack or a stiffness.
    BehindAGear,
}

/// Question about one quantity of a joint.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Question {
    /// Key of the answer. A travel is written as two keys of `[limits]`.
    pub key: &'static str,
    /// Quantity, with its unit. It is also the comment of the key in the file.
    pub what: &'static str,
    /// Hint for the user; empty if there is none.
    pub help: &'static str,
    /// Form of the answer.
    pub kind: AnswerKind,
    /// Joints that have this quantity; `None`: all joints.
    pub only: Option<OnlyFor>,
    /// Default answer; `None`: the question must be answered.
    pub otherwise: Option<&'static str>,
}

/// Number of questions.
const COUNT: usize = 23;

/// The questions. Motor and gear come first, so that a friction or a load that the motor cannot
/// move is refused when it is typed.
pub const QUESTIONS: [Question; COUNT] = {
    const fn number(key: &'static str, what: &'static str) -> Question {
        Question { key, what, help: "", kind: AnswerKind::Number, only: None, otherwise: None }
    }
    [
        Question {
            kind: AnswerKind::Text,
            help: "the heading of tables and figures",
            otherwise: Some("A joint of my own"),
            ..number("title", "title of the joint")
        },
        Question {
            kind: AnswerKind::Words(&["voltage", "current"]),
            help: "a bridge sets the voltage, a servo amplifier the current",
            ..number("motor.driven_by", "what the drive sets: the motor's voltage or its current")
        },
        Question {
            only: Some(OnlyFor::Voltage),
            ..number("supply.voltage_v", "voltage of the supply, V")
        },
        Question {
            only: Some(OnlyFor::Voltage),
            help: "the voltage divided by the current at stall",
            ..number("motor.resistance_ohm", "resistance of the winding, ohm")
        },
        Question {
            only: Some(OnlyFor::Current),
            ..number(
                "motor.amplifier_a_per_v",
                "current for each volt of the amplifier's input, A/V",
            )
        },
        Question {
            help: "9.549 divided by the speed constant in 1/min per V",
            ..number("motor.kt_nm_per_a", "torque constant at the motor's shaft, N m/A")
        },
        number("motor.rotor_inertia_kg_m2", "inertia of the rotor at its shaft, kg m^2"),
        number("motor.current_limit_a", "largest current, A"),
        number("gear.ratio", "turns of the motor for a turn of the joint"),
        number("gear.efficiency", "efficiency of the gear, above 0 to 1"),
        Question {
            kind: AnswerKind::Range,
            help: "a number, or a range such as 0.01..0.03 if you are not sure",
            ..number("load.inertia_kg_m2", "inertia of the load at the joint, kg m^2")
        },
        Question {
            kind: AnswerKind::Range,
            help: "the joint's play with the motor held; 0.1 to 1 deg for a planetary gear",
            otherwise: Some("0"),
            ..number("gear.backlash_deg", "backlash at the joint, deg; 0 for none")
        },
        Question {
            kind: AnswerKind::RangeOr("rigid"),
            help: "rigid, or the torque that winds the gear up by one radian",
            otherwise: Some("rigid"),
            ..number("gear.stiffness_nm_per_rad", "torsional stiffness at the joint, N m/rad")
        },
        Question {
            kind: AnswerKind::Range,
            help: "mass x 9.81 x distance of the center of mass from the axis; 0 if balanced",
            otherwise: Some("0"),
            ..number("load.unbalance_nm", "largest torque of gravity on the load, N m")
        },
        Question {
            only: Some(OnlyFor::Unbalanced),
            help: "0 is where the joint is at power-on; -90 or 90 is horizontal there",
            otherwise: Some("-90"),
            ..number("load.hangs_at_deg", "position at which the load hangs down, deg")
        },
        Question {
            kind: AnswerKind::Range,
            help: "the torque that starts the joint; a range such as 0.15..0.4, or one number",
            ..number("friction.stick_nm", "static friction at the joint, N m")
        },
        Question {
            kind: AnswerKind::Range,
            help: "the torque that keeps it moving slowly; often 0.5 to 0.9 of the static one",
            ..number("friction.slip_nm", "dynamic friction at the joint, N m")
        },
        Question {
            kind: AnswerKind::Range,
            help: "without the motor's back-EMF; 0 if it is not known",
            ..number("friction.viscous_nm_s_per_rad", "viscous friction at the joint, N m s/rad")
        },
        Question {
            kind: AnswerKind::Whole,
            help: "an encoder of 2048 counts in a turn has 512 lines",
            ..number("encoder.lines", "lines of the encoder: a quarter of its counts in a turn")
        },
        Question {
            kind: AnswerKind::Words(&["motor", "load"]),
            help: "an encoder on the motor cannot see the backlash",
            ..number("encoder.at", "where the encoder sits: on the motor or on the load")
        },
        Question {
            kind: AnswerKind::WholeOr("none"),
            only: Some(OnlyFor::BehindAGear),
            help: "an AS5047 on the joint's shaft has 16384; none for the motor's encoder alone",
            otherwise: Some("none"),
            ..number(
                "load_encoder.counts_per_turn",
                "counts a turn of a second encoder, on the load",
            )
        },
        Question {
            kind: AnswerKind::Around("none"),
            help: "0 is where the joint is at power-on: -30..90, or none for no limits",
            otherwise: Some("none"),
            ..number("limits.travel_deg", "travel, lowest to highest position, deg")
        },
        Question {
            help: "a board runs 0.0001 to 0.02 s",
            ..number("loop.sample_time_s", "time between samples, s")
        },
    ]
};

impl Question {
    /// Returns the index of a key among the questions.
    pub fn place(key: &str) -> Option<usize> {
        QUESTIONS.iter().position(|question| question.key == key)
    }

    /// Returns the option of the command line that answers the question.
    pub fn option(&self) -> String {
        let (_, name) = self.key.split_once('.').unwrap_or(("", self.key));
        format!("--{}", name.replace('_', "-"))
    }

    /// Parses an answer. [`check`](super::trial::check) compares it with the other answers.
    ///
    /// # Errors
    /// Returns one sentence with what was typed and what to type instead.
    pub fn read(&self, typed: &str) -> Result<Value, String> {
        let typed = typed.trim();
        match self.kind {
            AnswerKind::Text if typed.is_empty() => Err("nothing was typed; type a title".into()),
            AnswerKind::Text => Ok(Value::String(typed.into())),
            AnswerKind::Number => typed_number::parse(typed).map(Value::Float),
            AnswerKind::Whole => {
                whole(typed).ok_or(format!("`{typed}` is not a whole number; type one such as 512"))
            }
            AnswerKind::Words(words) if words.contains(&typed) => Ok(Value::String(typed.into())),
            AnswerKind::Words(words) => Err(format!("`{typed}` must be {}", words.join(" or "))),
            AnswerKind::RangeOr(word) | AnswerKind::Around(word) | AnswerKind::WholeOr(word)
                if typed == word =>
            {
                Ok(Value::String(word.into()))
            }
            AnswerKind::Range | AnswerKind::RangeOr(_) => not_negative(range::read(typed)?),
            AnswerKind::Around(word) => around_zero(typed, word),
            AnswerKind::WholeOr(word) => whole(typed).ok_or(format!(
                "`{typed}` is not a whole number; type one such as 16384, or {word}"
            )),
        }
    }
}

fn whole(typed: &str) -> Option<Value> {
    typed.parse::<u32>().ok().map(|whole| Value::Integer(whole.into()))
}

fn not_negative([low, high]: [f64; 2]) -> Result<Value, String> {
    if low < 0.0 {
        return Err(format!("{} is below zero; type a number from 0", shown(low)));
    }
    Ok(of_range([low, high]))
}

/// Reads a range of travel. It must contain 0, where the joint is at power-on; `word` is what the
/// user can type instead.
fn around_zero(typed: &str, word: &str) -> Result<Value, String> {
    if !typed.contains("..") {
        return Err(format!("`{typed}` is not a range; type one such as -30..90, or {word}"));
    }
    let [low, high] = range::read(typed)?;
    if low < 0.0 && high > 0.0 {
        return Ok(of_range([low, high]));
    }
    Err(format!(
        "`{typed}` must extend to both sides of 0, which is where the joint is at power-on; type a \
         range such as -5..90"
    ))
}

fn of_range([low, high]: [f64; 2]) -> Value {
    if low.to_bits() == high.to_bits() {
        return Value::Float(low);
    }
    Value::Array(vec![Value::Float(low), Value::Float(high)])
}

/// Formats a value as a user would type it.
pub fn typed(value: &Value) -> String {
    match value {
        Value::String(word) => word.clone(),
        Value::Float(number) => shown(*number),
        Value::Array(ends) => ends.iter().map(typed).collect::<Vec<_>>().join(".."),
        other => other.to_string(),
    }
}
