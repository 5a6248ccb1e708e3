//! A family, or a machine's file, as reports need it.

use serde::{Deserialize, Serialize};

use super::family::Family;
use files::data_sheet::UnseenSlack;
use files::goal::PositionGoal;

/// A family, or a machine's file, as reports need it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Group {
    /// Name of the family or file.
    pub name: String,
    /// Unit of angles.
    pub unit: String,
    /// Unit of efforts.
    pub effort_unit: String,
    /// Time in which a joint has to settle, s.
    pub settles_within_s: f64,
    /// Whether this is a family, whose laws have their gains by rules; otherwise it is a machine's
    /// file.
    pub is_family: bool,
    /// Error below which a joint counts as close to its target, in the unit of angles; `None` if
    /// that is not judged.
    pub near: Option<f64>,
    /// Whether a wall stands before the target.
    pub has_wall: bool,
    /// Goal by which a joint is judged: the file's `[goal]`, or two counts.
    pub goal: PositionGoal,
    /// Slack of a machine's file that its encoder cannot see.
    pub unseen_slack: Option<UnseenSlack>,
}

impl From<Family> for Group {
    fn from(family: Family) -> Self {
        let units = family.units();
        Self {
            name: family.name().into(),
            unit: units.angle.into(),
            effort_unit: units.effort.into(),
            settles_within_s: family.settles_within_s(),
            is_family: true,
            near: family.near(),
            has_wall: family.has_wall(),
            goal: PositionGoal {
                settle_s: Some(family.settles_within_s()),
                ..PositionGoal::default()
            },
            unseen_slack: None,
        }
    }
}
