//! Summary of the rows of each family and law.

use std::collections::BTreeMap;

use super::case_result::CaseResult;
use super::group::Group;
use super::measures::HUNTING_REVERSALS;
use super::motions::Approach;
use super::rows::EnsembleHeader;
use super::statistics::{SortedValues, wilson};
use super::trips::{self, FalseTrip};

/// Number of worst cases that are named.
const WORST: usize = 5;

/// Classes of the jump of a load behind a shaft: name and lowest jump, counts.
const JUMPS: [(&str, f64); 5] =
    [("0-4", 0.0), ("4-16", 4.0), ("16-64", 16.0), ("64-256", 64.0), ("256-", 256.0)];

/// Results of a law at one side of the gear.
#[derive(Clone, Debug, PartialEq)]
pub struct SideSummary {
    /// Number of cases that met the goal there, without a fault in the step.
    pub success: usize,
    /// Wilson's 95 % interval of their share.
    pub success_ci: [f64; 2],
    /// Settling times, s.
    pub settled_s: SortedValues,
    /// Rest errors, counts.
    pub rest_counts: SortedValues,
}

/// Results of a law on a family. Every quantile is over all cases; if a case never settles, its
/// time is infinite.
#[derive(Clone, Debug, PartialEq)]
pub struct LawSummary {
    /// Name of the law.
    pub law: String,
    /// Number of cases.
    pub cases: usize,
    /// Results at the encoder's side.
    pub at_encoder: SideSummary,
    /// Results at the load.
    pub at_load: SideSummary,
    /// Number of cases that settled in time and stayed, without a fault: for a family at the
    /// encoder, for a machine's file at the side of the joint's own position.
    pub success: usize,
    /// Wilson's 95 % interval of their share.
    pub success_ci: [f64; 2],
    /// Settling times, s.
    pub settling_s: SortedValues,
    /// Settling times into the wider band, s; empty if the family has none.
    pub near_s: SortedValues,
    /// Times at which the law gave up before a wall, s; empty without a wall.
    pub gave_up_s: SortedValues,
    /// Largest efforts after giving up, in the family's unit.
    pub effort_after: SortedValues,
    /// Rest errors, counts.
    pub rest_counts: SortedValues,
    /// Rest errors of a load that the encoder does not see, counts; empty if there is none.
    pub load_rest_counts: SortedValues,
    /// Number of cases that hunt.
    pub hunting_cases: usize,
    /// Distances between the extremes of the hunting cases, counts.
    pub hunting_counts: SortedValues,
    /// Periods of the hunting cases, s.
    pub hunting_period_s: SortedValues,
    /// Tracking errors, in the family's unit; infinite if a fault ended the motion, and empty if
    /// there was no trajectory.
    pub tracking_rms: SortedValues,
    /// Number of stops in motion of each case.
    pub sticks_in_motion: SortedValues,
    /// Mean total variation of the effort at rest, per second.
    pub variation_rest_per_s: f64,
    /// The same in motion.
    pub variation_motion_per_s: f64,
    /// Root mean square of the effort at rest, in the family's unit.
    pub held_effort: SortedValues,
    /// Number of cases in which a monitor tripped.
    pub false_trips: usize,
    /// Number of motions that each fault ended: steps, trajectories and rows of moves.
    pub faults: BTreeMap<String, usize>,
    /// Each of these faults, in the order of the cases.
    pub trips: Vec<FalseTrip>,
    /// Cases and successes by the jump of the load; empty if no case has a jump.
    pub by_jump: Vec<(&'static str, usize, usize)>,
    /// Results of the row of moves, if there was one.
    pub moves: Option<MovesSummary>,
    /// Numbers of the worst cases, the worst first.
    pub worst: Vec<u64>,
}

/// Results of moves in a row, over all cases. Pairs are of the first tenth and of the last.
#[derive(Clone, Debug, PartialEq)]
pub struct MovesSummary {
    /// Number of moves of a case.
    pub moves: u32,
    /// Number of moves in one tenth, over all cases.
    pub judged: u64,
    /// Number of missed moves in the first and in the last tenth.
    pub missed: [u64; 2],
    /// Number of missed moves in the whole rows.
    pub missed_of_all: u64,
    /// Tracking errors, in the family's unit.
    pub tracking_rms: [SortedValues; 2],
}

/// Summarises the rows of each family and law, in the order of the header.
pub fn summaries(header: &EnsembleHeader, rows: &[CaseResult]) -> Vec<(Group, Vec<LawSummary>)> {
    let of = |group: &Group, law: &String| -> Vec<&CaseResult> {
        rows.iter().filter(|row| row.family == group.name && row.law == *law).collect()
    };
    let families = header.families.iter().map(|group| {
        let laws = header.laws.iter().map(|law| (law, of(group, law)));
        let seen = laws.filter(|(_, rows)| !rows.is_empty());
        (
            group.clone(),
            seen.map(|(law, rows)| LawSummary::of(group, law, header.motion, &rows)).collect(),
        )
    });
    families.collect()
}

impl SideSummary {
    /// Summarises one side of the gear; `of` returns success, settling time (s) and rest error
    /// (counts) of a row.
    fn of(rows: &[&CaseResult], of: impl Fn(&CaseResult) -> (bool, Option<f64>, f64)) -> Self {
        let of: Vec<_> = rows.iter().map(|row| of(row)).collect();
        let success = of.iter().filter(|(is_success, ..)| *is_success).count();
        let settled_s = of.iter().map(|(_, settled_s, _)| settled_s.unwrap_or(f64::INFINITY));
        Self {
            success,
            success_ci: wilson(success, rows.len()),
            settled_s: SortedValues::new(settled_s),
            rest_counts: SortedValues::new(of.iter().map(|(.., rest_counts)| *rest_counts)),
        }
    }
}

impl LawSummary {
    /// Returns whether the results at the load differ from those at the encoder.
    pub fn is_two_sided(&self) -> bool {
        self.at_encoder != self.at_load
    }

    /// Summarises the rows of one family and law.
    fn of(group: &Group, law: &str, approach: Approach, rows: &[&CaseResult]) -> Self {
        let is_success = |row: &CaseResult| row.is_success(group.settles_within_s);
        let all = |of: fn(&CaseResult) -> f64| SortedValues::new(rows.iter().map(|row| of(row)));
        let mean = |of: fn(&CaseResult) -> f64| {
            rows.iter().map(|row| of(row)).sum::<f64>() / rows.len().max(1) as f64
        };
        let hunting: Vec<&&CaseResult> =
            rows.iter().filter(|row| row.reversals >= HUNTING_REVERSALS).collect();
        let success = rows.iter().filter(|row| is_success(row)).count();
        let mut faults = BTreeMap::new();
        for fault in rows.iter().flat_map(|row| row.faults()) {
            *faults.entry(fault.to_owned()).or_default() += 1;
        }
        let late = |of: fn(&CaseResult) -> Option<f64>, is_asked: bool| {
            let rows = rows.iter().filter(|_| is_asked);
            SortedValues::new(rows.map(|row| of(row).unwrap_or(f64::INFINITY)))
        };
        let has_trajectory =
            rows.iter().any(|row| row.tracking_rms.is_some() || row.tracking_fault.is_some());
        Self {
            law: law.into(),
            cases: rows.len(),
            at_encoder: SideSummary::of(rows, |row| {
                (row.success_at_encoder, row.settled_at_encoder_s, row.rest_at_encoder_counts)
            }),
            at_load: SideSummary::of(rows, |row| {
                (row.success_at_load, row.settled_at_load_s, row.rest_at_load_counts)
            }),
            success,
            success_ci: wilson(success, rows.len()),
            settling_s: all(|row| row.settled_s.unwrap_or(f64::INFINITY)),
            near_s: late(|row| row.near_s, group.near.is_some()),
            gave_up_s: late(|row| row.gave_up_s, group.has_wall),
            effort_after: SortedValues::new(rows.iter().filter_map(|row| row.effort_after)),
            rest_counts: all(|row| row.rest_counts),
            load_rest_counts: SortedValues::new(rows.iter().filter_map(|row| row.load_rest_counts)),
            hunting_cases: hunting.len(),
            hunting_counts: SortedValues::new(hunting.iter().map(|row| row.swing_counts)),
            hunting_period_s: SortedValues::new(hunting.iter().filter_map(|row| row.period_s)),
            tracking_rms: late(|row| row.tracking_rms, has_trajectory),
            sticks_in_motion: all(|row| f64::from(row.sticks_in_motion)),
            variation_rest_per_s: mean(|row| row.variation_rest_per_s),
            variation_motion_per_s: mean(|row| row.variation_motion_per_s),
            held_effort: all(|row| row.held_effort),
            false_trips: rows.iter().filter(|row| row.faults().next().is_some()).count(),
            faults,
            trips: rows.iter().flat_map(|row| trips::of(row, approach)).collect(),
            by_jump: by_jump(rows, is_success),
            moves: MovesSummary::of(rows),
            worst: worst(rows, is_success),
        }
    }
}

impl MovesSummary {
    fn of(rows: &[&CaseResult]) -> Option<Self> {
        let moves = rows.first()?.moves;
        let rms = |of: fn(&CaseResult) -> Option<f64>| {
            SortedValues::new(rows.iter().filter_map(|row| of(row)))
        };
        let sum = |of: fn(&CaseResult) -> u32| rows.iter().map(|row| u64::from(of(row))).sum();
        (moves > 0).then(|| Self {
            moves,
            judged: sum(|row| row.judged_moves),
            missed: [sum(|row| row.missed_first), sum(|row| row.missed_last)],
            missed_of_all: sum(|row| row.missed),
            tracking_rms: [rms(|row| row.moves_rms_first), rms(|row| row.moves_rms_last)],
        })
    }
}

fn by_jump(
    rows: &[&CaseResult],
    is_success: impl Fn(&CaseResult) -> bool,
) -> Vec<(&'static str, usize, usize)> {
    if rows.iter().all(|row| row.jump_counts.is_none()) {
        return Vec::new();
    }
    let class = |jump: f64| JUMPS.iter().rposition(|(_, from)| jump >= *from);
    let of = |place: usize| {
        rows.iter().filter(move |row| row.jump_counts.and_then(class) == Some(place))
    };
    let count = |(place, (name, _)): (usize, &(&'static str, f64))| {
        (*name, of(place).count(), of(place).filter(|row| is_success(row)).count())
    };
    JUMPS.iter().enumerate().map(count).collect()
}

/// Returns the numbers of the worst cases: failures before successes, then the longer settling
/// (never is the longest), then the larger rest error.
fn worst(rows: &[&CaseResult], is_success: impl Fn(&CaseResult) -> bool) -> Vec<u64> {
    let mut ranked: Vec<(&CaseResult, bool)> =
        rows.iter().map(|row| (*row, is_success(row))).collect();
    let settled = |row: &CaseResult| row.settled_s.unwrap_or(f64::INFINITY);
    ranked.sort_by(|(a, a_succeeds), (b, b_succeeds)| {
        a_succeeds
            .cmp(b_succeeds)
            .then(settled(b).total_cmp(&settled(a)))
            .then(b.rest_counts.total_cmp(&a.rest_counts))
            .then(a.case.cmp(&b.case))
    });
    ranked.iter().take(WORST).map(|(row, _)| row.case).collect()
}
