//! Sections 3.3.3 to 3.3.5: the three integrals.

use super::Criterion::{Above, Below, Between};
use super::chapter3::{chatter, cruise, overshoots, rest, steps, tracking};
use super::{Claim, magnitudes, ratios};
use crate::report::evidence::ReportEvidence;

/// Returns the hunting in the second of two minutes, peak to peak, counts; zero if there is none.
pub(super) fn hunting(evidence: &ReportEvidence, name: &str, controller: &str) -> Option<Vec<f64>> {
    let of = |label: &String| {
        let run = evidence.run(name, label)?;
        let resolution_deg = run.plan.machine.encoder.resolution_deg();
        Some(run.metrics.hunting_peak_to_peak_deg.unwrap_or(0.0) / resolution_deg)
    };
    steps(controller).iter().map(of).collect()
}

/// Returns the largest error in the second of two minutes, counts.
fn worst_late(evidence: &ReportEvidence, controller: &str) -> Option<Vec<f64>> {
    let of = |label: &String| {
        let resolution_deg = evidence.run("long", label)?.plan.machine.encoder.resolution_deg();
        let late = evidence.moments("long", label)?.iter().filter(|m| m.time_s >= 60.0);
        Some(late.map(|m| m.error_deg().abs() / resolution_deg).fold(0.0, f64::max))
    };
    steps(controller).iter().map(of).collect()
}

/// Returns the times between the steps of v_c once the joint of the 1 deg step is stuck, s.
fn times_between_offsets(evidence: &ReportEvidence) -> Option<Vec<f64>> {
    let moments = evidence.moments("step-response", "roi/step-1.0")?;
    let slow = moments.iter().rposition(|m| m.velocity_deg_per_s.abs() > 2.0).unwrap_or(0) + 10;
    let settled = moments.get(slow..200)?;
    let changes = settled.windows(2).filter(|pair| pair[1].tick.v_c != pair[0].tick.v_c);
    let times: Vec<f64> = changes.map(|pair| pair[1].time_s).collect();
    let between = times.windows(2).map(|pair| pair[1] - pair[0]);
    let (least, most) =
        between.fold((f64::INFINITY, 0.0), |(a, b), t| (f64::min(a, t), f64::max(b, t)));
    (times.len() > 5).then_some(vec![least, most])
}

pub(super) const INTEGRALS: &[Claim] = &[
    Claim {
        source: "Section 3.3.3",
        says: "RI reduces the steady-state errors of the steps.",
        quantity: "error at rest by PD's: 5, 2.5 and 1 deg step",
        measure: |e| ratios(rest(e, "ri"), rest(e, "pd")),
        holds: Below(0.5),
        remark: "",
    },
    Claim {
        source: "Section 3.3.3",
        says: "RI hunts around the set point: a limit cycle.",
        quantity: "peak to peak in the second minute (counts): 5, 2.5 and 1 deg step",
        measure: |e| hunting(e, "long", "ri"),
        holds: Above(2.0),
        remark: "",
    },
    Claim {
        source: "Section 3.3.3",
        says: "RI hunts because friction drops from stick to slip.",
        quantity: "peak to peak in the second minute with Ts = Td = 0.38 V (counts)",
        measure: |e| hunting(e, "ri-without-drop", "ri"),
        holds: Below(1.0),
        remark: "",
    },
    Claim {
        source: "Section 3.3.3",
        says: "The integral does not wind down fast enough once stick friction is overcome: it \
            overshoots the more, the larger the drop.",
        quantity: "peak to peak with Ts = 0.50 V by that with 0.40 V",
        measure: |e| ratios(hunting(e, "ri-larger-drop", "ri"), hunting(e, "long", "ri")),
        holds: Above(1.5),
        remark: "",
    },
    Claim {
        source: "Section 3.3.3",
        says: "RI tracks with low errors.",
        quantity: "rms error by PD's: 5 and 2.5 deg/s",
        measure: |e| ratios(tracking(e, "ri"), tracking(e, "pd")),
        holds: Below(0.5),
        remark: "",
    },
    Claim {
        source: "Section 3.3.3",
        says: "RI is too slow in eliminating stick friction.",
        quantity: "settling into 0.05 deg, by SRNF's: 5, 2.5 and 1 deg step",
        measure: |e| {
            let settling = |name: &str| {
                let labels = steps(name);
                e.metrics("step-response", &labels.each_ref().map(String::as_str), |m| {
                    m.settling_time_s
                })
            };
            ratios(settling("ri"), settling("srnf"))
        },
        holds: Above(2.0),
        remark: "",
    },
    Claim {
        source: "Section 3.3.3",
        says: "Too high an integral gain makes regulating oscillate.",
        quantity: "peak to peak in the second minute with Ki = 40 by that with 4 V/(deg s): 5, 2.5 \
            and 1 deg step",
        measure: |e| ratios(hunting(e, "ri-fast-step", "ri"), hunting(e, "long", "ri")),
        holds: Above(2.0),
        remark: "",
    },
    Claim {
        source: "Section 3.3.3",
        says: "Too high an integral gain makes tracking oscillate.",
        quantity: "Ki = 40: total variation of the output by that of Ki = 4: 5 and 2.5 deg/s",
        measure: |e| {
            let labels = ["ri/trajectory-5.0", "ri/trajectory-2.5"];
            ratios(
                e.metrics("ri-fast-trajectory", &labels, |m| m.control_total_variation_v_per_s),
                chatter(e, "ri"),
            )
        },
        holds: Above(2.0),
        remark: "",
    },
    Claim {
        source: "Section 3.3.4",
        says: "RVI is quite effective in eliminating steady-state errors.",
        quantity: "error at rest (counts): 5, 2.5 and 1 deg step",
        measure: |e| rest(e, "rvi"),
        holds: Below(5.0),
        remark: "",
    },
    Claim {
        source: "Section 3.3.4",
        says: "RVI's hunting due to stiction is eliminated.",
        quantity: "peak to peak in the second minute (counts): 5, 2.5 and 1 deg step",
        measure: |e| hunting(e, "long", "rvi"),
        holds: Below(2.0),
        remark: "Section 3.4.3 says itself that the integral's signal hunts around zero.",
    },
    Claim {
        source: "Section 3.3.4",
        says: "RVI adds no windup and no overshoot.",
        quantity: "overshoot by that of PD with the same Kd (feedforward's steps)",
        measure: |e| {
            ratios(overshoots(e, "rvi"), overshoots(e, "feedforward"))
                .map(|all| all.into_iter().take(1).collect())
        },
        holds: Below(1.05),
        remark: "Of the 5 deg step: from the others that PD stops short.",
    },
    Claim {
        source: "Section 3.3.4",
        says: "RVI fails to eliminate tracking errors.",
        quantity: "cruise error by PD's: 5 and 2.5 deg/s",
        measure: |e| ratios(cruise(e, "rvi"), cruise(e, "pd")),
        holds: Between(0.9, 1.1),
        remark: "",
    },
    Claim {
        source: "Section 3.3.5",
        says: "ROI's compensation steps at the interval T_roi = 140 ms.",
        quantity: "shortest and longest time between two steps of v_c (s)",
        measure: times_between_offsets,
        holds: Between(0.1399, 0.1401),
        remark: "",
    },
    Claim {
        source: "Section 3.3.5",
        says: "ROI eliminates the errors of stick friction better than RI.",
        quantity: "largest error in the second minute by RI's: 5, 2.5 and 1 deg step",
        measure: |e| ratios(worst_late(e, "roi"), worst_late(e, "ri")),
        holds: Below(1.0),
        remark: "",
    },
    Claim {
        source: "Section 3.3.5",
        says: "ROI eliminates the errors of slip friction better than RVI.",
        quantity: "rms error by RVI's: 5 and 2.5 deg/s",
        measure: |e| ratios(tracking(e, "roi"), tracking(e, "rvi")),
        holds: Below(0.5),
        remark: "",
    },
    Claim {
        source: "Section 3.3.5",
        says: "ROI tracks with smaller errors than RI.",
        quantity: "rms error by RI's: 5 and 2.5 deg/s",
        measure: |e| ratios(tracking(e, "roi"), tracking(e, "ri")),
        holds: Below(1.0),
        remark: "",
    },
    Claim {
        source: "Section 3.3.5",
        says: "ROI costs the steps nothing noticeable.",
        quantity: "overshoot of the 5 deg step by that of PD with the same Kd",
        measure: |e| {
            ratios(overshoots(e, "roi"), overshoots(e, "feedforward"))
                .map(|all| all.into_iter().take(1).collect())
        },
        holds: Below(1.05),
        remark: "",
    },
    Claim {
        source: "Section 4.1",
        says: "ROI does not hunt about zero error.",
        quantity: "peak to peak in the second minute (counts): 5, 2.5 and 1 deg step",
        measure: |e| hunting(e, "long", "roi"),
        holds: Below(2.0),
        remark: "Its periods are tens of seconds: the ten of Fig. 52 cannot show it.",
    },
    Claim {
        source: "Sections 3.3.3 to 3.3.5",
        says: "While cruising RI and ROI integrate the mean error away.",
        quantity: "mean cruise error (deg): RI at 5 and 2.5 deg/s, ROI at 5 and 2.5 deg/s",
        measure: |e| magnitudes(Some([cruise(e, "ri")?, cruise(e, "roi")?].concat())),
        holds: Below(0.01),
        remark: "",
    },
];
