//! Ranks controllers by their places in the columns of the benchmark.
//!
//! A controller is disqualified if one of its runs is unstable, if it moves the joint in none of
//! them, or if a step never settles: a task that is not done cannot be weighed against one that is.
//! The others are ranked in each column, the best first. Equal values share the mean of their
//! places, so a value that many controllers reach counts little. The rank is the order of the
//! weighted means of the places. A column without values is not included in the mean.

use serde::Serialize;

use super::Score;
use files::error::{Error, suggestion};

/// A column of the benchmark: its name in `--weights`, and its value in a row.
pub struct Column {
    /// The name in `--weights`.
    pub name: &'static str,
    of: fn(&Score) -> Option<f64>,
}

/// Ranked columns; less is better in each of them.
pub const COLUMNS: [Column; 7] = [
    Column { name: "rest", of: rest_counts },
    Column { name: "overshoot", of: |score| score.overshoot_deg },
    Column { name: "settling", of: settling_s },
    Column { name: "tracking", of: |score| score.tracking_rms_deg },
    Column { name: "chatter", of: |score| score.chatter_v_per_s },
    Column { name: "hunting", of: |score| score.hunting_counts },
    Column { name: "sticks", of: |score| score.sticks_in_motion },
];

fn rest_counts(score: &Score) -> Option<f64> {
    if score.is_ranked_at_encoder {
        score.sides.rest_at_encoder_counts
    } else {
        score.rest_error_counts
    }
}

fn settling_s(score: &Score) -> Option<f64> {
    if score.is_ranked_at_encoder {
        score.settling_time_at_encoder_s
    } else {
        score.settling_time_s
    }
}

/// The reason why a controller is not ranked.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Disqualification {
    /// A run is unstable or diverged.
    Unstable,
    /// The joint did not move by a count in any run.
    NeverMoves,
    /// A step did not meet the file's goal at the encoder. If the file has no goal: a step did not
    /// stay within 0.05 deg, at the encoder if the encoder cannot see slack.
    NeverSettles,
}

impl Disqualification {
    /// Returns the reason in words.
    pub const fn describe(self) -> &'static str {
        match self {
            Self::Unstable => "is unstable",
            Self::NeverMoves => "never moves the joint",
            Self::NeverSettles => "never settles",
        }
    }
}

/// Weights of the columns in the mean of the places, in the order of [`COLUMNS`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Weights([f64; COLUMNS.len()]);

impl Default for Weights {
    /// Every column has the same weight.
    fn default() -> Self {
        Self([1.0; COLUMNS.len()])
    }
}

impl Weights {
    /// Parses `COLUMN=WEIGHT` pairs. A column without a pair has the weight 1.
    ///
    /// # Errors
    /// Returns an error that names the malformed pair, the unknown column or the invalid weight, or
    /// an error if all weights are zero.
    pub fn read(pairs: &[String]) -> Result<Self, Error> {
        let mut weights = Self::default();
        for pair in pairs {
            let refuse = |why: String| Error::Input(format!("--weights {pair}: {why}"));
            let (name, weight) = pair
                .split_once('=')
                .ok_or_else(|| refuse("write COLUMN=WEIGHT, as in settling=2".into()))?;
            let place = COLUMNS.iter().position(|column| column.name == name).ok_or_else(|| {
                let near = suggestion(name, COLUMNS.iter().map(|column| column.name));
                refuse(format!("there is no column `{name}`{near}"))
            })?;
            weights.0[place] =
                weight.parse().ok().filter(|weight| (0.0..=1e6).contains(weight)).ok_or_else(
                    || refuse(format!("`{weight}` is no weight; must be a number from 0 to 1e6")),
                )?;
        }
        if weights.0.iter().all(|weight| *weight == 0.0) {
            return Err(Error::Input("--weights: all of them are 0, so nothing is ranked".into()));
        }
        Ok(weights)
    }

    /// Returns each column's name with its weight.
    pub fn iter(&self) -> impl Iterator<Item = (&'static str, f64)> {
        COLUMNS.iter().map(|column| column.name).zip(self.0)
    }
}

/// Sets the weighted mean of the places of each row that is not disqualified, and sorts the rows by
/// it. Disqualified rows are last, in the order of their rest errors.
pub fn rank(scores: &mut [Score], weights: &Weights) {
    let qualified: Vec<Score> =
        scores.iter().filter(|score| score.disqualified.is_none()).cloned().collect();
    for score in scores.iter_mut().filter(|score| score.disqualified.is_none()) {
        let (mut sum, mut weight_of_all) = (0.0, 0.0);
        for (column, weight) in COLUMNS.iter().zip(weights.0) {
            let Some(place) = place(score, &qualified, column.of) else { continue };
            sum += weight * place;
            weight_of_all += weight;
        }
        score.mean_place = (weight_of_all > 0.0).then(|| sum / weight_of_all);
    }
    let key = |score: &Score| {
        let mean = score.mean_place.unwrap_or(f64::INFINITY);
        (score.disqualified.is_some(), mean, score.rest_error_counts.unwrap_or(f64::INFINITY))
    };
    scores.sort_by(|a, b| {
        let (a, b) = (key(a), key(b));
        a.0.cmp(&b.0).then(a.1.total_cmp(&b.1)).then(a.2.total_cmp(&b.2))
    });
}

/// Returns the place of a row in a column; `None` if no row has a value there. Equal values share
/// the mean of their places. A row without a value is worse than all rows with one.
fn place(score: &Score, all: &[Score], of: fn(&Score) -> Option<f64>) -> Option<f64> {
    all.iter().any(|other| of(other).is_some()).then(|| {
        let value = |score: &Score| of(score).unwrap_or(f64::INFINITY);
        let better = all.iter().filter(|other| value(other) < value(score)).count();
        let equal = all.iter().filter(|other| value(other) == value(score)).count();
        better as f64 + 0.5 * (equal + 1) as f64
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use simulator::both_sides::BothSides;

    fn score(controller: &str, values: [Option<f64>; 7]) -> Score {
        let [rest, overshoot, settling, tracking, chatter, hunting, sticks] = values;
        Score {
            controller: controller.into(),
            rest_error_counts: rest,
            overshoot_deg: overshoot,
            settling_time_s: settling,
            tracking_rms_deg: tracking,
            chatter_v_per_s: chatter,
            hunting_counts: hunting,
            sticks_in_motion: sticks,
            sides: BothSides::default(),
            settling_time_at_encoder_s: None,
            is_ranked_at_encoder: false,
            unstable: false,
            disqualified: None,
            mean_place: None,
        }
    }

    fn ranked(mut scores: Vec<Score>, weights: &[&str]) -> Vec<(String, Option<f64>)> {
        let weights: Vec<String> = weights.iter().map(|pair| (*pair).into()).collect();
        rank(&mut scores, &Weights::read(&weights).unwrap());
        scores.into_iter().map(|score| (score.controller, score.mean_place)).collect()
    }

    #[test]
    fn equal_values_share_their_places_and_columns_without_values_do_not_count() {
        let scores = || {
            vec![
                score("c", [Some(3.0), Some(1.0), Some(1.0), None, Some(3.0), Some(0.0), None]),
                score("b", [Some(2.0), Some(1.0), Some(3.0), None, Some(2.0), Some(0.0), None]),
                score("a", [Some(1.0), Some(2.0), Some(2.0), None, Some(1.0), Some(0.0), None]),
            ]
        };
        // a: 1 3 2 1 2; b: 2 1.5 3 2 2; c: 3 1.5 1 3 2, in five columns.
        let expected = [("a", 9.0 / 5.0), ("b", 10.5 / 5.0), ("c", 10.5 / 5.0)];
        assert_eq!(ranked(scores(), &[]), expected.map(|(name, mean)| (name.into(), Some(mean))));
        // Settling alone.
        let alone = ["rest=0", "overshoot=0", "chatter=0", "hunting=0", "tracking=0", "sticks=0"];
        let expected = [("c", 1.0), ("a", 2.0), ("b", 3.0)];
        assert_eq!(
            ranked(scores(), &alone),
            expected.map(|(name, mean)| (name.into(), Some(mean)))
        );
    }

    /// No law corrects slack that its encoder cannot see.
    #[test]
    fn rest_and_settling_are_ranked_at_the_encoder_where_it_cannot_see_slack() {
        let joint = |name: &str, at_load: f64, at_encoder: f64| Score {
            sides: BothSides { rest_at_encoder_counts: Some(at_encoder), ..BothSides::default() },
            settling_time_at_encoder_s: Some(at_encoder),
            is_ranked_at_encoder: true,
            ..score(name, [Some(at_load), None, None, None, None, None, None])
        };
        let scores = || vec![joint("chance", 1.0, 2.0), joint("precise", 9.0, 0.1)];
        let expected = [("precise", Some(1.0)), ("chance", Some(2.0))];
        assert_eq!(ranked(scores(), &[]), expected.map(|(name, mean)| (name.into(), mean)));
        let rigid = scores().into_iter().map(|one| Score { is_ranked_at_encoder: false, ..one });
        let expected = [("chance", Some(1.0)), ("precise", Some(2.0))];
        let found = ranked(rigid.collect(), &[]);
        assert_eq!(found, expected.map(|(name, mean)| (name.into(), mean)));
    }

    #[test]
    fn what_is_disqualified_takes_nobody_s_place_and_stands_last() {
        let out = |name: &str, why, rest| Score {
            disqualified: Some(why),
            ..score(name, [Some(rest), Some(0.0), None, Some(0.0), Some(0.0), Some(0.0), None])
        };
        let scores = vec![
            out("stuck", Disqualification::NeverMoves, 900.0),
            out("short", Disqualification::NeverSettles, 400.0),
            score("good", [Some(9.0); 7]),
        ];
        let expected = [("good", Some(1.0)), ("short", None), ("stuck", None)];
        assert_eq!(ranked(scores, &[]), expected.map(|(name, mean)| (name.into(), mean)));
    }

    #[test]
    fn weights_that_say_nothing_are_refused_by_name() {
        for (pair, said) in [
            ("settling", "write COLUMN=WEIGHT"),
            ("setling=2", "did you mean `settling`"),
            ("rest=-1", "must be a number from 0 to 1e6"),
            ("rest=NaN", "must be a number from 0 to 1e6"),
        ] {
            let error = Weights::read(&[pair.into()]).unwrap_err().to_string();
            assert!(error.contains("--weights") && error.contains(said), "{error}");
        }
        let none: Vec<String> = COLUMNS.iter().map(|column| format!("{}=0", column.name)).collect();
        assert!(Weights::read(&none).unwrap_err().to_string().contains("all of them are 0"));
    }
}
