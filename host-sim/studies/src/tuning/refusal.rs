//! Reason why a tuning keeps the file's gains, with a remedy.
//!
//! A tuning is refused if no joint of the judgement succeeds at its load, before or after it. If
//! some succeed and no gains are better, the file's gains are kept. If the encoder's side succeeds
//! and the load does not, the reason is slack between them: no gain can correct an error that the
//! encoder cannot see.

use std::collections::BTreeMap;

use super::TuningFigures;
use crate::ensemble::CaseResult;
use files::data_sheet::UnseenSlack;
use files::error::rounded;
use files::goal::PositionGoal;

/// Evidence for or against a refusal.
#[derive(Clone, Copy, Debug)]
pub(super) struct Evidence<'a> {
    /// Name of the controller.
    pub controller: &'a str,
    /// Figures of the file's gains, and of the best ones of the judgement.
    pub figures: [&'a TuningFigures; 2],
    /// Rows of the best gains.
    pub rows: &'a [CaseResult],
    /// Whether the best gains are better than the file's.
    pub is_better: bool,
    /// Number of tried sets of gains.
    pub tried: usize,
    /// Goal by which a joint is judged.
    pub goal: &'a PositionGoal,
    /// Slack of the gear that the encoder cannot measure.
    pub slack: Option<UnseenSlack>,
}

impl Evidence<'_> {
    /// Returns the reason and a remedy, as one sentence without a full stop; `None` if better gains
    /// were found.
    pub fn refusal(&self) -> Option<String> {
        let Self { controller, figures: [before, after], tried, .. } = *self;
        if before.at_load.successes.max(after.at_load.successes) == 0 {
            return Some(self.without_a_success());
        }
        if self.is_better && after.at_load.successes < before.at_load.successes {
            return Some(format!(
                "the best of {tried} sets of gains of {controller} succeed on fewer joints at the \
                 load ({} of {}; {} with the file's gains); the file's gains stay; put an \
                 encoder on the load, or set [goal] tolerance_deg wider than the slack of the gear",
                after.at_load.successes, after.cases, before.at_load.successes
            ));
        }
        (!self.is_better).then(|| {
            format!(
                "none of {tried} sets of gains of {controller} is better than the file's on {} \
                 other runs, of which {} succeed with the file's gains; the file's gains stay; \
                 another goal, more joints or other gains to start from may find better ones",
                before.cases, before.at_load.successes
            )
        })
    }

    /// Returns the reason if no joint succeeds at its load.
    fn without_a_success(&self) -> String {
        let Self { controller, figures: [before, after], goal, slack, rows, .. } = *self;
        let tolerance = tolerance(goal);
        let at_encoder = before.at_encoder.successes.max(after.at_encoder.successes);
        if let Some(slack) = slack.filter(|_| at_encoder > 0) {
            let wider = rounded(slack.backlash_deg + slack.wind_up_deg);
            return format!(
                "no gains can rest the load {tolerance}: {}; put an encoder on the load, or set \
                 [goal] tolerance_deg to {wider} or more",
                unseen(&slack)
            );
        }
        if let Some((fault, trips)) = most_frequent_fault(rows).filter(|(_, n)| 2 * n > rows.len())
        {
            return format!(
                "no gains of {controller} succeed: a monitor trips in {trips} of {} runs \
                 ({fault}); check [limits] and the values of the joint in the file",
                rows.len()
            );
        }
        let rest = rounded(after.at_encoder.rest_counts);
        format!(
            "no gains of {controller} bring the joint to rest {tolerance} in time: in nine of ten \
             cases it stops up to {rest} counts off; take a law that compensates friction at rest, \
             such as robust or srnf, or set a larger [goal] tolerance_deg"
        )
    }
}

/// Returns the tolerance in words, such as "within 2 counts".
fn tolerance(goal: &PositionGoal) -> String {
    let alone = PositionGoal { tolerance_deg: goal.tolerance_deg, ..PositionGoal::default() };
    alone.describe().trim_end_matches(" until the end").into()
}

fn unseen(slack: &UnseenSlack) -> String {
    if slack.backlash_deg == 0.0 {
        return format!(
            "the encoder cannot see the wind-up of the gear, up to {} deg at rest",
            rounded(slack.wind_up_deg)
        );
    }
    format!("the encoder cannot see {:.0} counts of backlash", slack.backlash_counts)
}

/// Returns the fault that ended most runs, with the number of these runs.
fn most_frequent_fault(rows: &[CaseResult]) -> Option<(&str, usize)> {
    let mut counts: BTreeMap<&str, usize> = BTreeMap::new();
    for fault in rows.iter().filter_map(|row| row.faults().next()) {
        *counts.entry(fault).or_default() += 1;
    }
    counts.into_iter().max_by_key(|(_, count)| *count)
}

#[cfg(test)]
mod tests {
    use super::super::figures::SideFigures;
    use super::*;

    const SLACK: UnseenSlack =
        UnseenSlack { backlash_deg: 0.6, backlash_counts: 170.67, wind_up_deg: 0.15 };

    fn figures(at_encoder: usize, at_load: usize) -> TuningFigures {
        let side = |successes, rest_counts| SideFigures {
            successes,
            settling_s: 1.0,
            tracking_counts: None,
            rest_counts,
        };
        TuningFigures {
            cases: 48,
            at_encoder: side(at_encoder, 30.0),
            at_load: side(at_load, 105.0),
            chatter_v_per_s: 0.0,
            held_v: 0.0,
        }
    }

    fn said(
        before: [usize; 2],
        after: [usize; 2],
        is_better: bool,
        slack: Option<UnseenSlack>,
        rows: &[CaseResult],
    ) -> Option<String> {
        let [before, after] = [before, after].map(|[encoder, load]| figures(encoder, load));
        let goal = PositionGoal::default();
        let figures = [&before, &after];
        let controller = "robust";
        Evidence { controller, figures, rows, is_better, tried: 41, goal: &goal, slack }.refusal()
    }

    #[test]
    fn slack_is_the_reason_where_the_encoder_succeeds_and_the_load_never() {
        assert_eq!(
            said([40, 0], [48, 0], true, Some(SLACK), &[]).unwrap(),
            "no gains can rest the load within 2 counts: the encoder cannot see 171 counts of \
             backlash; put an encoder on the load, or set [goal] tolerance_deg to 0.75 or more"
        );
        // One load that succeeds is enough for a tuning.
        assert_eq!(said([40, 0], [48, 1], true, Some(SLACK), &[]), None);
        // Better at the encoder, and fewer at the load.
        let lost = said([40, 10], [48, 9], true, Some(SLACK), &[]).unwrap();
        assert!(lost.contains("fewer joints at the load (9 of"), "{lost}");
    }

    #[test]
    fn a_law_that_never_succeeds_is_refused_with_what_it_is_off_or_what_trips() {
        let off = said([0, 0], [0, 0], true, None, &[]).unwrap();
        assert!(off.contains("up to 30 counts off") && off.contains("robust or srnf"), "{off}");
        // Slack is no reason if not even the encoder's side succeeds.
        let off = said([0, 0], [0, 0], true, Some(SLACK), &[]).unwrap();
        assert!(off.contains("up to 30 counts off"), "{off}");
        let stall = CaseResult { step_fault: Some("stall".into()), ..CaseResult::default() };
        let rows = [stall.clone(), stall, CaseResult::default()];
        let trips = said([0, 0], [0, 0], false, None, &rows).unwrap();
        assert!(trips.contains("trips in 2 of 3 runs (stall)"), "{trips}");
    }

    #[test]
    fn what_is_no_better_is_refused_and_what_is_better_is_not() {
        let same = said([30, 30], [30, 30], false, None, &[]).unwrap();
        assert!(same.contains("none of 41 sets") && same.contains("30 succeed"), "{same}");
        assert_eq!(said([30, 30], [31, 31], true, None, &[]), None);
        assert_eq!(said([0, 0], [1, 1], true, None, &[]), None);
    }
}
