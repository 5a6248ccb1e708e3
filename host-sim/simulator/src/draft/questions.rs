//! What has to be known of a joint, as questions; the answers are keys of a data sheet.

use toml::Value;

use crate::error::{Error, shown};

/// What an answer looks like.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// A number, in the unit that the key names.
    Number,
    /// A whole number.
    Whole,
    /// One of these words.
    Words(&'static [&'static str]),
}

/// A question.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Question {
    /// The key that the answer is written to.
    pub key: &'static str,
    /// What it is, with its unit.
    pub what: &'static str,
    /// What may be answered.
    pub kind: Kind,
    /// The way the motor is driven, if only then it has to be known.
    pub only: Option<&'static str>,
}

/// What has to be known of a joint, in the order in which a file has it.
pub const QUESTIONS: [Question; 16] = {
    const fn number(key: &'static str, what: &'static str) -> Question {
        Question { key, what, kind: Kind::Number, only: None }
    }
    [
        Question {
            key: "motor.driven_by",
            what: "what the drive sets: the motor's voltage or its current",
            kind: Kind::Words(&["voltage", "current"]),
            only: None,
        },
        Question {
            only: Some("voltage"),
            ..number("motor.resistance_ohm", "resistance of the winding, ohm")
        },
        Question {
            only: Some("current"),
            ..number("motor.amplifier_a_per_v", "current for each volt of the amplifier's input")
        },
        number("motor.kt_nm_per_a", "torque constant at the motor's shaft, N m/A"),
        number("motor.rotor_inertia_kg_m2", "inertia of the rotor at its shaft, kg m^2"),
        number("motor.current_limit_a", "largest current, A"),
        number("gear.ratio", "turns of the motor for a turn of the joint"),
        number("gear.efficiency", "efficiency of the gear, above 0 to 1"),
        number("load.inertia_kg_m2", "inertia of the load at the joint, kg m^2"),
        number("friction.stick_nm", "static friction at the joint, N m"),
        number("friction.slip_nm", "dynamic friction at the joint, N m"),
        number("friction.viscous_nm_s_per_rad", "viscous friction at the joint, N m s/rad"),
        Question {
            only: Some("voltage"),
            ..number("supply.voltage_v", "voltage of the supply, V")
        },
        Question {
            kind: Kind::Whole,
            ..number("encoder.lines", "lines of the encoder: a quarter of its counts in a turn")
        },
        Question {
            key: "encoder.at",
            what: "where the encoder sits: on the motor or on the load",
            kind: Kind::Words(&["motor", "load"]),
            only: None,
        },
        number("loop.sample_time_s", "time between samples, s"),
    ]
};

impl Question {
    /// The option of the command line that answers it.
    pub fn option(&self) -> String {
        let (_, name) = self.key.split_once('.').unwrap_or(("", self.key));
        format!("--{}", name.replace('_', "-"))
    }

    /// Reads an answer.
    ///
    /// # Errors
    /// Says what was found and what is allowed.
    pub fn read(&self, typed: &str) -> Result<Value, Error> {
        let typed = typed.trim();
        let refused = |allowed: &str| {
            Error::Input(format!("{} is {typed:?}; allowed is {allowed}", self.option()))
        };
        match self.kind {
            Kind::Number => match typed.parse::<f64>() {
                Ok(number) if number.is_finite() => Ok(Value::Float(number)),
                _ => Err(refused("a number")),
            },
            Kind::Whole => match typed.parse::<u32>() {
                Ok(whole) => Ok(Value::Integer(whole.into())),
                Err(_) => Err(refused("a whole number")),
            },
            Kind::Words(words) if words.contains(&typed) => Ok(Value::String(typed.into())),
            Kind::Words(words) => Err(refused(&words.join(" or "))),
        }
    }
}

/// An answer, and why it is that.
#[derive(Clone, Debug, PartialEq)]
pub struct Answer {
    /// The value of the key.
    pub value: Value,
    /// Where it comes from; empty if it is the user's own.
    pub source: &'static str,
}

/// The answers to the questions, in their order, as far as there are any.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Answers([Option<Answer>; QUESTIONS.len()]);

impl Answers {
    /// Answers a question, or answers it otherwise.
    pub fn put(&mut self, key: &str, value: Value, source: &'static str) {
        for (question, place) in QUESTIONS.iter().zip(&mut self.0) {
            if question.key == key {
                *place = Some(Answer { value: value.clone(), source });
            }
        }
    }

    /// The answer to a question.
    pub fn get(&self, key: &str) -> Option<&Answer> {
        let place = QUESTIONS.iter().position(|question| question.key == key)?;
        self.0.get(place)?.as_ref()
    }

    /// Whether a question has to be answered, as the motor is driven.
    pub fn asks(&self, question: &Question) -> bool {
        let driven_by = self.get("motor.driven_by").and_then(|answer| answer.value.as_str());
        question.only.is_none_or(|only| driven_by == Some(only))
    }

    /// The questions that are still open.
    pub fn open(&self) -> Vec<Question> {
        let all = QUESTIONS.iter().zip(&self.0);
        let open = all.filter(|(question, answer)| answer.is_none() && self.asks(question));
        open.map(|(question, _)| *question).collect()
    }

    /// The answers that are asked for, with their questions.
    pub fn given(&self) -> impl Iterator<Item = (&'static Question, &Answer)> {
        let all = QUESTIONS.iter().zip(&self.0);
        all.filter_map(|(question, answer)| Some((question, answer.as_ref()?)))
            .filter(|(question, _)| self.asks(question))
    }
}

/// A value as a person would type it.
pub fn typed(value: &Value) -> String {
    match value {
        Value::String(word) => word.clone(),
        Value::Float(number) => shown(*number),
        other => other.to_string(),
    }
}
