//! An ensemble: untuned laws on random joints.
//!
//! ```text
//! family, seed, number -> draw.rs: a joint, its loop, the bounds of both ----+
//!                         (arm_draw.rs, arm_rig.rs, arm_case.rs: two joints) |
//!              bounds -> the rule book (simulator::rules): gains --+             |
//!                                                              v             v
//!   motions.rs -> rig.rs: servo with all monitors, joint -> samples -> measures.rs
//!                                                                          |
//!                                                                          v
//! case.rs: a CaseResult -> rows.rs (CSV, shards, resume) -> summary.rs, trips.rs -> table.rs,
//!                                                                       json.rs, figures.rs
//! follow.rs, follow_sine.rs: ramps and sines on the same joints -> follow_report.rs: rows and
//!                                                       tables of their own; follow_chart.rs
//! ```
//!
//! Every law sees the same joints. A row depends only on the seed, the family, the number of the
//! case and the law. So any part of an ensemble can run on any machine, and the summary of the rows
//! is the same.

mod arm_case;
mod arm_draw;
mod arm_rig;
mod assemble;
mod bridge;
mod case;
mod case_result;
mod condition;
#[cfg(test)]
mod condition_tests;
#[cfg(test)]
mod current_bars_tests;
mod distribution;
mod draw;
mod drawn_case;
mod electrics;
#[cfg(test)]
mod electrics_tests;
mod family;
#[cfg(test)]
mod family_tests;
mod figures;
mod follow;
mod follow_chart;
mod follow_report;
mod follow_sine;
mod group;
#[cfg(test)]
mod hostile_tests;
mod identified;
mod json;
mod machine_file;
mod markdown;
mod measures;
mod motions;
mod moves;
mod rig;
mod rows;
#[cfg(test)]
mod rows_tests;

#[cfg(test)]
mod failed_sensor;
#[cfg(test)]
mod failed_sensor_tests;
mod run;
mod selection;
#[cfg(test)]
mod sheet_tests;
#[cfg(test)]
mod sides_tests;
#[cfg(test)]
mod slow_bars_tests;
mod statistics;
mod summary;
mod table;
#[cfg(test)]
mod tests;
mod thesis_draw;
mod trips;
mod tune;
#[cfg(test)]
mod two_encoders_tests;

pub use bridge::Bridge;
pub use case::run_and_show;
pub use case_result::{CaseResult, JudgedMotion};
pub use condition::Condition;
pub use drawn_case::{Case, DrawOptions};
pub use family::{Family, FamilyUnits};
pub use figures::{charts, traces};
pub use follow::{
    FollowSummary, FollowedRamp, RampSummary, follow, follow_summaries, followed_families,
};
pub use follow_chart::{follow_charts, sine_charts};
pub use follow_report::{
    follow_csv, follow_json, follow_table, sine_json, sine_table, slowest_table,
};
pub use follow_sine::{FollowedSine, SineSummary, SinesSummary, follow_sines, sine_summaries};
pub use group::Group;
pub use identified::{
    IdentifiedCase, Rates, TrueJoint, UNEVEN, drawn, identified_names, identify, rates,
    rates_markdown, rates_table, rates_within,
};
pub use json::object;
pub use machine_file::{
    KeySpread, MachineEnsemble, MachineOptions, drawn_keys, goal_of_steps, written_spreads,
};
pub use markdown::markdown;
pub(crate) use measures::Reversals;
pub use measures::{BAND_COUNTS, CaseSample, HUNTING_REVERSALS, TrackingJudge, TrackingMeasures};
pub use motions::{Approach, Motions};
pub use rows::{
    EnsembleHeader, ResumeFile, Shard, merge, read as read_rows, render as render_rows,
    sort as sort_rows,
};
pub use run::{Ensemble, run};
pub use selection::{CASES_ALLOWED, RATE_HZ, allowed_rate, families, families_under};
pub use statistics::{SortedValues, wilson};
pub use summary::{LawSummary, MovesSummary, SideSummary, summaries};
pub use table::render;
pub use trips::{EndedMotion, FalseTrip};
pub use tune::{ConstantTrial, tune};
