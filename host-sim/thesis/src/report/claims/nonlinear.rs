//! Sections 3.3.6 to 3.3.8: feedforward, DNPF and SRNF.

use super::Criterion::{Above, Below, Between};
use super::chapter3::{
    TORQUE_PER_VOLT, chatter, cruise, overshoots, rest, steps, tracking, trajectories,
};
use super::{Claim, ratios};
use crate::report::evidence::ReportEvidence;
use simulator::metrics::RunMetrics;

/// Returns a metric of Table 18's tests, relative to Table 17's SRNF: 5 and 2.5 deg/s.
fn test(
    evidence: &ReportEvidence,
    test: u32,
    of: fn(&RunMetrics) -> Option<f64>,
) -> Option<Vec<f64>> {
    let plain = trajectories("srnf");
    let with = plain.each_ref().map(|label| format!("{label}/test-{test}"));
    let with = evidence.metrics("srnf-robustness", &with.each_ref().map(String::as_str), of);
    ratios(with, evidence.metrics("trajectory", &plain.each_ref().map(String::as_str), of))
}

/// Returns the mean error of SRNF under variable friction from one time to another, deg.
fn mean_error(evidence: &ReportEvidence, from_s: f64, to_s: f64) -> Option<f64> {
    let moments = evidence.moments("srnf-added-friction", "srnf/trajectory-2.5/added-variable")?;
    let errors: Vec<f64> = moments
        .iter()
        .filter(|m| m.time_s >= from_s && m.time_s < to_s)
        .map(|m| m.error_deg())
        .collect();
    Some(errors.iter().sum::<f64>() / errors.len() as f64)
}

/// Returns the smallest chatter of the thesis's other compensators, for each trajectory.
fn least_chatter_of_others(evidence: &ReportEvidence) -> Option<Vec<f64>> {
    let others = ["ri", "rvi", "roi", "feedforward", "dnpf"].map(|name| chatter(evidence, name));
    let others: Vec<Vec<f64>> = others.into_iter().collect::<Option<_>>()?;
    let least =
        |i: usize| others.iter().filter_map(|values| values.get(i).copied()).reduce(f64::min);
    (0..2).map(least).collect()
}

pub(super) const CLAIMS: &[Claim] = &[
    Claim {
        source: "Section 3.3.6",
        says: "Feedforward eliminates slip friction errors while tracking.",
        quantity: "cruise error by PD's: 5 and 2.5 deg/s; closed form 0.229 and 0.140",
        measure: |e| ratios(cruise(e, "feedforward"), cruise(e, "pd")),
        holds: Below(0.25),
        remark: "All but viscous friction and the 0.01 V that v_slip is below Td.",
    },
    Claim {
        source: "Section 3.3.6",
        says: "Feedforward does not eliminate stick friction errors.",
        quantity: "error at rest (counts): 5, 2.5 and 1 deg step",
        measure: |e| rest(e, "feedforward"),
        holds: Between(2.0, 166.0),
        remark: "At rest it is PD.",
    },
    Claim {
        source: "Section 3.3.6",
        says: "Feedforward's control signal is smooth.",
        quantity: "total variation of the output by PD's: 5 and 2.5 deg/s",
        measure: |e| ratios(chatter(e, "feedforward"), chatter(e, "pd")),
        holds: Below(1.1),
        remark: "",
    },
    Claim {
        source: "Section 3.3.7",
        says: "DNPF leaves a steady-state error at the 5 deg step.",
        quantity: "error at rest (counts)",
        measure: |e| rest(e, "dnpf").map(|all| all.into_iter().take(1).collect()),
        holds: Above(2.0),
        remark: "On our joint theta_b = 0.40 V/Kp just overcomes Ts = 0.40 V: the D/A rounds it to \
            0.40016 V.",
    },
    Claim {
        source: "Section 3.3.7",
        says: "That error is from undercompensated stick friction.",
        quantity: "error at rest with theta_b = 0.375 deg (counts): 5 deg step",
        measure: |e| {
            Some(vec![e.run("dnpf-short", "dnpf/step-5.0")?.metrics.rest_error_counts?.abs()])
        },
        holds: Above(2.0),
        remark: "",
    },
    Claim {
        source: "Section 3.3.7",
        says: "DNPF eliminates the steady-state error at the 2.5 and 1 deg steps.",
        quantity: "error at rest (counts): 2.5 and 1 deg step",
        measure: |e| rest(e, "dnpf").map(|all| all.into_iter().skip(1).collect()),
        holds: Below(2.0),
        remark: "",
    },
    Claim {
        source: "Sections 3.3.7, 3.4.6",
        says: "DNPF bangs to and fro at the 2.5 deg step.",
        quantity: "total variation of the output (V/s)",
        measure: |e| {
            e.metrics("step-response", &["dnpf/step-2.5"], |m| m.control_total_variation_v_per_s)
        },
        holds: Above(10.0),
        remark: "",
    },
    Claim {
        source: "Section 3.3.7",
        says: "Given ample time, DNPF's oscillations stop.",
        quantity: "travel of the output in the last ten of 120 s (V/s): 5, 2.5 and 1 deg step",
        measure: |e| {
            let late = |label: &String| {
                let moments = e.moments("long", label)?;
                let late = &moments[moments.len().checked_sub(501)?..];
                Some(
                    late.windows(2)
                        .map(|pair| (pair[1].applied_v - pair[0].applied_v).abs())
                        .sum::<f64>()
                        / 10.0,
                )
            };
            steps("dnpf").iter().map(late).collect()
        },
        holds: Below(1.0),
        remark: "Section 3.4.6 speaks of a limit cycle.",
    },
    Claim {
        source: "Section 3.3.7",
        says: "DNPF is quite sensitive to epsilon, so to theta_b.",
        quantity: "error at rest with 0.375 deg by that with 0.39 deg: 5 and 1 deg step",
        measure: |e| {
            let rest = |name| {
                e.metrics(name, &["dnpf/step-5.0", "dnpf/step-1.0"], |m| {
                    Some(m.rest_error_counts?.abs())
                })
            };
            ratios(rest("dnpf-short"), rest("dnpf-enough"))
        },
        holds: Above(10.0),
        remark: "",
    },
    Claim {
        source: "Section 3.3.7",
        says: "DNPF's tracking errors are as large as PD's.",
        quantity: "cruise error by PD's: 5 and 2.5 deg/s",
        measure: |e| ratios(cruise(e, "dnpf"), cruise(e, "pd")),
        holds: Between(0.95, 1.05),
        remark: "",
    },
    Claim {
        source: "Section 3.3.7",
        says: "DNPF's control signal oscillates where a trajectory starts and stops.",
        quantity: "total variation of the output by PD's: 5 and 2.5 deg/s",
        measure: |e| ratios(chatter(e, "dnpf"), chatter(e, "pd")),
        holds: Above(2.0),
        remark: "",
    },
    Claim {
        source: "Section 3.3.7",
        says: "DNPF's impulsive torques are in the range of \u{b1}220 N m.",
        quantity: "n Kt Ka times the largest v_c (N m): 2.5 deg step",
        measure: |e| {
            let moments = e.moments("step-response", "dnpf/step-2.5")?;
            Some(vec![
                TORQUE_PER_VOLT
                    * moments.iter().map(|m| f64::from(m.tick.v_c).abs()).fold(0.0, f64::max),
            ])
        },
        holds: Between(200.0, 240.0),
        remark: "",
    },
    Claim {
        source: "Section 3.3.8",
        says: "SRNF's steady-state errors are significantly reduced.",
        quantity: "error at rest by PD's: 5, 2.5 and 1 deg step",
        measure: |e| ratios(rest(e, "srnf"), rest(e, "pd")),
        holds: Below(0.2),
        remark: "",
    },
    Claim {
        source: "Section 3.3.8",
        says: "SRNF is tuned for little overshoot at 2.5 deg.",
        quantity: "overshoot of the 2.5 deg step (deg); 1 % is 0.025",
        measure: |e| Some(vec![*overshoots(e, "srnf")?.get(1)?]),
        holds: Below(0.025),
        remark: "",
    },
    Claim {
        source: "Section 3.3.8",
        says: "SRNF eliminates most of the tracking error.",
        quantity: "rms error by PD's: 5 and 2.5 deg/s",
        measure: |e| ratios(tracking(e, "srnf"), tracking(e, "pd")),
        holds: Below(0.5),
        remark: "",
    },
    Claim {
        source: "Section 3.3.8",
        says: "SRNF's tracking error is larger at 5 than at 2.5 deg/s, by viscous friction.",
        quantity: "cruise error at 5 by that at 2.5 deg/s",
        measure: |e| {
            let errors = cruise(e, "srnf")?;
            Some(vec![errors.first()? / errors.last()?])
        },
        holds: Above(1.1),
        remark: "",
    },
    Claim {
        source: "Section 3.5",
        says: "SRNF has the least unwanted oscillation of the control signal of all compensators.",
        quantity: "total variation of the output by the smallest of the others: 5 and 2.5 deg/s",
        measure: |e| ratios(chatter(e, "srnf"), least_chatter_of_others(e)),
        holds: Below(1.0),
        remark: "Feedforward, which does not look at the error, is smoother.",
    },
    Claim {
        source: "Table 18, test 1",
        says: "A larger v_ms (0.5 V) reduces the tracking error.",
        quantity: "rms error by that of Table 17: 5 and 2.5 deg/s",
        measure: |e| test(e, 1, |m| m.rms_error_deg),
        holds: Below(1.0),
        remark: "",
    },
    Claim {
        source: "Table 18, test 1",
        says: "A larger v_ms risks oscillations of the control signal.",
        quantity: "total variation by that of Table 17: 5 and 2.5 deg/s",
        measure: |e| test(e, 1, |m| m.control_total_variation_v_per_s),
        holds: Above(1.0),
        remark: "",
    },
    Claim {
        source: "Table 18, test 2",
        says: "A smaller v_ms (0.2 V) produces large tracking errors.",
        quantity: "cruise error by that of Table 17: 5 and 2.5 deg/s",
        measure: |e| test(e, 2, |m| m.cruise_error_deg),
        holds: Above(2.0),
        remark: "",
    },
    Claim {
        source: "Table 18, test 3",
        says: "A larger alpha (300 per deg) makes the control signal oscillate.",
        quantity: "total variation by that of Table 17: 5 and 2.5 deg/s",
        measure: |e| test(e, 3, |m| m.control_total_variation_v_per_s),
        holds: Above(1.0),
        remark: "",
    },
    Claim {
        source: "Table 18, test 3",
        says: "With a larger alpha slip friction is still compensated.",
        quantity: "cruise error by that of Table 17: 5 and 2.5 deg/s",
        measure: |e| test(e, 3, |m| m.cruise_error_deg),
        holds: Below(1.05),
        remark: "",
    },
    Claim {
        source: "Table 18, test 4",
        says: "A smaller alpha (5 per deg) makes tanh less effective.",
        quantity: "rms error by that of Table 17: 5 and 2.5 deg/s",
        measure: |e| test(e, 4, |m| m.rms_error_deg),
        holds: Above(1.0),
        remark: "",
    },
    Claim {
        source: "Section 3.3.8.1",
        says: "Throughout these tests SRNF remains stable.",
        quantity: "unstable runs, of eight",
        measure: |e| {
            Some(vec![e.axis("srnf-robustness").iter().filter(|run| run.unstable).count() as f64])
        },
        holds: Below(1.0),
        remark: "",
    },
    Claim {
        source: "Section 3.3.8.2",
        says: "Friction above the level that SRNF is set for remains uncompensated.",
        quantity: "cruise error with 0.2 by that with 0.1 V added, and with 0.4 by that with 0.2 V",
        measure: |e| {
            let labels =
                ["0.1", "0.2", "0.4"].map(|added| format!("srnf/trajectory-2.5/added-{added}"));
            let labels = labels.each_ref().map(String::as_str);
            let errors = e.metrics("srnf-added-friction", &labels, |m| m.cruise_error_deg)?;
            Some(errors.windows(2).map(|pair| pair[1] / pair[0]).collect())
        },
        holds: Above(1.5),
        remark: "The thesis does not say how much friction its wedge added.",
    },
    Claim {
        source: "Section 3.3.8.2",
        says: "Nor does SRNF adapt when friction varies.",
        quantity: "mean error with the friction (4-5 and 9-10 s) by that without it (6-8 s)",
        measure: |e| {
            let off = mean_error(e, 6.0, 8.0)?;
            Some(vec![mean_error(e, 4.0, 5.0)? / off, mean_error(e, 9.0, 10.0)? / off])
        },
        holds: Above(2.0),
        remark: "",
    },
];
