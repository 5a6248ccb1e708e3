//! Rest, settling and success at the encoder and at the load, side by side.

use super::grid::{self, number};
use crate::both_sides::BothSides;
use files::data_sheet::UnseenSlack;
use files::goal::PositionGoal;
use files::lines::wrapped;

/// Column of the rest error of one side.
pub const REST: &str = "rest\ncounts";

/// Column of the settling time of one side.
pub const SETTLED: &str = "settled\ns";

/// Columns that are shown for the end of a motion.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ShownSides {
    /// The encoder sees the load, and the file has no goal: other tables show rest and settling.
    Nothing,
    /// The encoder sees the load: one column for settling by the file's goal, and one for success.
    OneSide,
    /// The encoder cannot see slack: columns for both sides of the gear.
    BothSides,
}

impl ShownSides {
    /// Returns the columns for a joint with this slack and goal.
    pub fn of(slack: Option<&UnseenSlack>, goal: &PositionGoal) -> Self {
        match slack {
            Some(_) => Self::BothSides,
            None if goal.is_default() => Self::Nothing,
            None => Self::OneSide,
        }
    }

    /// Returns the columns of other tables that [`table`](Self::table) replaces.
    pub const fn replaces(self) -> &'static [&'static str] {
        match self {
            Self::Nothing => &[],
            Self::OneSide => &[SETTLED],
            Self::BothSides => &[REST, SETTLED],
        }
    }

    /// Returns the table of named motions; `what` heads the column of their names. It is empty if
    /// nothing is shown.
    pub fn table<'a>(
        self,
        what: &str,
        rows: impl Iterator<Item = (String, &'a BothSides)>,
    ) -> String {
        let mut header = vec![what];
        header.extend(match self {
            Self::Nothing => return String::new(),
            Self::OneSide => &["goal\nafter\ns", "goal"][..],
            Self::BothSides => &[
                "rest at\nencoder\ncounts",
                "rest at\nload\ncounts",
                "settled at\nencoder\ns",
                "settled at\nload\ns",
                "goal\nmet at",
            ],
        });
        let mut table = grid::new(&header);
        for (name, sides) in rows {
            let settled = [
                (sides.settled_at_encoder_s, sides.success_at_encoder),
                (sides.settled_at_load_s, sides.success_at_load),
            ];
            let [encoder_s, load_s] = settled.map(|(settled_s, success)| match settled_s {
                None if success.is_some() => "never".into(),
                settled_s => number(settled_s, 2),
            });
            let rest = [sides.rest_at_encoder_counts, sides.rest_at_load_counts];
            let [encoder_rest, load_rest] = rest.map(|counts| number(counts, 1));
            table.add_row(match self {
                Self::BothSides => {
                    vec![name, encoder_rest, load_rest, encoder_s, load_s, met_at(sides).into()]
                }
                _ => vec![name, load_s, in_a_word(sides.success_at_load).into()],
            });
        }
        table.trim_fmt() + "\n"
    }
}

/// Returns the cell for a success: `met`, `missed`, or a dash.
const fn in_a_word(success: Option<bool>) -> &'static str {
    match success {
        Some(true) => "met",
        Some(false) => "missed",
        None => "-",
    }
}

/// Returns the cell for the sides that met the goal.
const fn met_at(sides: &BothSides) -> &'static str {
    match (sides.success_at_encoder, sides.success_at_load) {
        (Some(true), Some(true)) => "both",
        (Some(true), _) => "encoder",
        (_, Some(true)) => "load",
        (Some(false), Some(false)) => "neither",
        _ => "-",
    }
}

/// Returns the legend of [`ShownSides::table`] in lines of 80 columns: the goal in words, and the
/// slack that the encoder cannot see.
pub fn legend(slack: Option<&UnseenSlack>, goal: &PositionGoal) -> String {
    let after = "Times count from the end of the set point's motion.";
    let text = wrapped(&format!("Goal: {}. {after}", goal.describe()), 0);
    text + &slack.map_or_else(String::new, sentence)
}

/// Returns the sentence on the slack that the encoder cannot see, in lines of 80 columns.
pub fn sentence(slack: &UnseenSlack) -> String {
    wrapped(&format!("Note: {slack}."), 0)
}

#[cfg(test)]
mod tests {
    use super::*;

    const SLACK: UnseenSlack =
        UnseenSlack { backlash_deg: 0.6, backlash_counts: 170.7, wind_up_deg: 0.1 };

    fn sides() -> BothSides {
        BothSides {
            rest_at_encoder_counts: Some(0.2),
            rest_at_load_counts: Some(-104.9),
            settled_at_encoder_s: Some(0.31),
            settled_at_load_s: None,
            success_at_encoder: Some(true),
            success_at_load: Some(false),
        }
    }

    #[test]
    fn both_sides_stand_side_by_side_only_where_the_encoder_cannot_see_slack() {
        let goal = PositionGoal::default();
        let named = "twenty-letters-at-mo/step-5.0".to_owned();
        let rows = || std::iter::once((named.clone(), sides()));
        let drawn = |shown: ShownSides| {
            let rows: Vec<_> = rows().collect();
            shown.table("step", rows.iter().map(|(name, sides)| (name.clone(), sides)))
        };
        let both = drawn(ShownSides::of(Some(&SLACK), &goal));
        let last = both.lines().last().unwrap();
        let cells: Vec<&str> = last.split_whitespace().skip(1).collect();
        assert_eq!(cells, ["0.2", "-104.9", "0.31", "never", "encoder"], "{both}");
        assert!(both.lines().all(|line| line.chars().count() <= 80), "{both}");
        assert_eq!(drawn(ShownSides::of(None, &goal)), "");
        let own = PositionGoal { tolerance_deg: Some(0.1), ..goal };
        let one = drawn(ShownSides::of(None, &own));
        assert!(one.lines().last().unwrap().ends_with("missed"), "{one}");
        assert!(!one.contains("encoder"), "{one}");
    }

    #[test]
    fn the_legend_has_the_goal_and_the_slack_once() {
        let text = legend(Some(&SLACK), &PositionGoal::default());
        assert!(text.lines().all(|line| line.chars().count() <= 80), "{text}");
        let text = text.split_whitespace().collect::<Vec<_>>().join(" ");
        assert!(text.starts_with("Goal: within 2 counts until the end."), "{text}");
        assert_eq!(text.matches("cannot see 171 counts of backlash").count(), 1);
        assert!(!legend(None, &PositionGoal::default()).contains("cannot see"));
    }
}
