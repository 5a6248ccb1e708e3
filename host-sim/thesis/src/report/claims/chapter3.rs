//! Sections 3.2, 3.3.2 and 3.4, Appendix A.2 and the conclusions.

use super::Criterion::{Above, Below, Between};
use super::{Claim, magnitudes, ratios};
use crate::report::evidence::ReportEvidence;

/// n K_t K_a, torque per volt of the control signal, N m/V (Table 20).
pub(super) const TORQUE_PER_VOLT: f64 = 1800.0 * 0.10 * 3.0;

/// Labels of the steps of a controller.
pub(super) fn steps(controller: &str) -> [String; 3] {
    ["5.0", "2.5", "1.0"].map(|size| format!("{controller}/step-{size}"))
}

pub(super) fn trajectories(controller: &str) -> [String; 2] {
    ["5.0", "2.5"].map(|speed| format!("{controller}/trajectory-{speed}"))
}

/// Returns the magnitudes of the errors at rest after 10 s, counts.
pub(super) fn rest(evidence: &ReportEvidence, controller: &str) -> Option<Vec<f64>> {
    let labels = steps(controller);
    let labels = labels.each_ref().map(String::as_str);
    magnitudes(evidence.metrics("step-response", &labels, |m| m.rest_error_counts))
}

pub(super) fn overshoots(evidence: &ReportEvidence, controller: &str) -> Option<Vec<f64>> {
    let labels = steps(controller);
    evidence.metrics("step-response", &labels.each_ref().map(String::as_str), |m| m.overshoot_deg)
}

pub(super) fn cruise(evidence: &ReportEvidence, controller: &str) -> Option<Vec<f64>> {
    let labels = trajectories(controller);
    evidence.metrics("trajectory", &labels.each_ref().map(String::as_str), |m| m.cruise_error_deg)
}

pub(super) fn tracking(evidence: &ReportEvidence, controller: &str) -> Option<Vec<f64>> {
    let labels = trajectories(controller);
    evidence.metrics("trajectory", &labels.each_ref().map(String::as_str), |m| m.rms_error_deg)
}

pub(super) fn chatter(evidence: &ReportEvidence, controller: &str) -> Option<Vec<f64>> {
    let labels = trajectories(controller);
    let of = |labels: &[&str]| {
        evidence.metrics("trajectory", labels, |m| m.control_total_variation_v_per_s)
    };
    of(&labels.each_ref().map(String::as_str))
}

/// Controllers of Table 24.
const HIGH: [&str; 5] = ["pd", "ri", "roi", "dnpf", "srnf"];

fn high(
    evidence: &ReportEvidence,
    suffix: &str,
    of: fn(&simulator::metrics::RunMetrics) -> Option<f64>,
) -> Option<Vec<f64>> {
    let labels = HIGH.map(|name| format!("{name}/trajectory-5.0{suffix}"));
    evidence.metrics("high-gain", &labels.each_ref().map(String::as_str), of)
}

fn low(
    evidence: &ReportEvidence,
    of: fn(&simulator::metrics::RunMetrics) -> Option<f64>,
) -> Option<Vec<f64>> {
    let labels = HIGH.map(|name| format!("{name}/trajectory-5.0"));
    evidence.metrics("trajectory", &labels.each_ref().map(String::as_str), of)
}

pub(super) const AXIS: &[Claim] = &[
    Claim {
        source: "Section 3.2",
        says: "A slow ramp of the effort moves the axis at about 0.40 V.",
        quantity: "effort at break-away (V), ramps of 0.001 to 0.02 V/s",
        measure: |e| {
            e.axis("friction-identification").iter().map(|run| run.metrics.stick_v).collect()
        },
        holds: Between(0.395, 0.405),
        remark: "",
    },
    Claim {
        source: "Section 3.2",
        says: "A slow ramp down stops the moving axis at about 0.38 V.",
        quantity: "effort at standstill (V), the same ramps, without the axis's lag",
        measure: |e| {
            e.axis("friction-identification")
                .iter()
                .map(|run| run.metrics.slip_corrected_v)
                .collect()
        },
        holds: Between(0.375, 0.385),
        remark: "Uncorrected readings are low by up to 1.85 s of the ramp: the moving axis lags.",
    },
    Claim {
        source: "Section 3.2",
        says: "Stick friction is worth 216 N m.",
        quantity: "n Kt Ka times the slowest ramp's break-away effort (N m)",
        measure: |e| {
            Some(vec![
                TORQUE_PER_VOLT * e.axis("friction-identification").first()?.metrics.stick_v?,
            ])
        },
        holds: Between(213.0, 219.0),
        remark: "",
    },
    Claim {
        source: "Eq. 37, Table 20",
        says: "With the parameters in SI units, 27 rad/s\u{b2} per volt, the controllers of Table \
            17 position the axis.",
        quantity: "controllers, of seven, whose 5 deg step is unstable",
        measure: |e| {
            let runs =
                e.axis("step-response").iter().filter(|run| run.plan.variant == "literal-si");
            Some(vec![runs.filter(|run| run.unstable).count() as f64])
        },
        holds: Below(1.0),
        remark: "Everything else here reads it as 27 deg/s\u{b2} per volt: next row.",
    },
    Claim {
        source: "Eq. 37, Table 20",
        says: "With the inertia in N m per deg/s\u{b2}, 27 deg/s\u{b2} per volt, the controllers \
            do.",
        quantity: "unstable runs of the seven controllers, steps and trajectories",
        measure: |e| {
            let runs = e.axis("step-response").iter().chain(e.axis("trajectory"));
            Some(
                vec![runs.filter(|run| run.plan.variant.is_empty() && run.unstable).count() as f64],
            )
        },
        holds: Below(1.0),
        remark: "",
    },
    Claim {
        source: "Section 3.3.2",
        says: "PD ends each step in a nonzero equilibrium.",
        quantity: "error at rest (counts): 5, 2.5 and 1 deg step; Ts/Kp is 165",
        measure: |e| rest(e, "pd"),
        holds: Between(2.0, 166.0),
        remark: "",
    },
    Claim {
        source: "Section 3.3.2",
        says: "Steady-state errors result in the trajectory responses, too.",
        quantity: "error at the end (counts): 5 and 2.5 deg/s",
        measure: |e| {
            magnitudes(e.metrics("trajectory", &["pd/trajectory-5.0", "pd/trajectory-2.5"], |m| {
                m.rest_error_counts
            }))
        },
        holds: Between(2.0, 166.0),
        remark: "",
    },
    Claim {
        source: "Section 3.3.2",
        says: "PD's tracking error and control signal are slightly larger at 5 than at 2.5 deg/s, \
            by viscous friction.",
        quantity: "cruise error at 5 by that at 2.5 deg/s; closed form 1.116",
        measure: |e| {
            let errors = cruise(e, "pd")?;
            Some(vec![errors.first()? / errors.last()?])
        },
        holds: Between(1.05, 1.25),
        remark: "",
    },
    Claim {
        source: "Section 3.3.2",
        says: "Five times Kp and about twice Kd reduce the position error about four times.",
        quantity: "PD, 5 deg/s: rms error by that at high gain",
        measure: |e| {
            Some(vec![
                low(e, |m| m.rms_error_deg)?.first()?
                    / high(e, "", |m| m.rms_error_deg)?.first()?,
            ])
        },
        holds: Between(3.0, 5.0),
        remark: "",
    },
    Claim {
        source: "Section 3.3.2",
        says: "The control signal at high gain is quite oscillatory.",
        quantity: "PD, 5 deg/s: total variation of the output, high gain by Table 17's, without \
            and with a sample of delay",
        measure: |e| {
            let of = |values: Option<Vec<f64>>| values?.first().copied();
            let plain = of(low(e, |m| m.control_total_variation_v_per_s))?;
            let [none, one] =
                ["", "/delay-1"].map(|s| of(high(e, s, |m| m.control_total_variation_v_per_s)));
            Some(vec![none? / plain, one? / plain])
        },
        holds: Above(2.0),
        remark: "The thesis blames encoder noise; our encoder only rounds.",
    },
    Claim {
        source: "Section 3.4.1",
        says: "The simulated PD steps show the same: each rests elsewhere when stick-slip friction \
            is significant.",
        quantity: "difference of any two of the three signed errors at rest (counts)",
        measure: |e| {
            let labels = ["pd/step-5.0", "pd/step-2.5", "pd/step-1.0"];
            let errors = e.metrics("step-response", &labels, |m| m.rest_error_counts)?;
            let [a, b, c] = errors[..] else { return None };
            Some(vec![(a - b).abs(), (b - c).abs(), (c - a).abs()])
        },
        holds: Above(2.0),
        remark: "",
    },
];

pub(super) const CONCLUSIONS: &[Claim] = &[
    Claim {
        source: "Appendix A.2",
        says: "High gains reduce the errors.",
        quantity: "5 deg/s, rms error by that of Table 17: PD, RI, ROI, DNPF, SRNF",
        measure: |e| ratios(high(e, "", |m| m.rms_error_deg), low(e, |m| m.rms_error_deg)),
        holds: Below(0.5),
        remark: "",
    },
    Claim {
        source: "Appendix A.2",
        says: "High gains increase the oscillations of the control signal.",
        quantity: "5 deg/s, total variation by that of Table 17: PD, RI, ROI, DNPF, SRNF",
        measure: |e| {
            let of = |m: &simulator::metrics::RunMetrics| m.control_total_variation_v_per_s;
            ratios(high(e, "", of), low(e, of))
        },
        holds: Above(1.0),
        remark: "Without a sample of computation delay.",
    },
    Claim {
        source: "Appendix A.2",
        says: "At high gain the oscillations are visible in the displacement: they are violent.",
        quantity: "5 deg/s at high gain, total variation of the output (V/s): PD, RI, ROI, DNPF, \
            SRNF",
        measure: |e| high(e, "", |m| m.control_total_variation_v_per_s),
        holds: Above(10.0),
        remark: "Without a sample of computation delay.",
    },
    Claim {
        source: "Appendix A.2",
        says: "At high gain and with one sample of computation delay they are violent.",
        quantity: "5 deg/s at high gain and 20 ms of delay (V/s): PD, RI, ROI, DNPF, SRNF",
        measure: |e| high(e, "/delay-1", |m| m.control_total_variation_v_per_s),
        holds: Above(10.0),
        remark: "The thesis does not say how long its computer took.",
    },
    Claim {
        source: "Section 4.1",
        says: "SRNF displays the most potential.",
        quantity: "its place in the control benchmark of the README, of seven",
        measure: |e| {
            Some(vec![1.0 + e.scores.iter().position(|score| score.controller == "srnf")? as f64])
        },
        holds: Below(1.5),
        remark: "Mean place over rest, overshoot, settling, tracking, chatter, hunting and sticks.",
    },
    Claim {
        source: "Section 4.1",
        says: "RVI, ROI, feedforward and SRNF are better than RI and DNPF.",
        quantity: "places of RVI, ROI, feedforward and SRNF less the better one of RI and DNPF",
        measure: |e| {
            let place = |name: &str| e.scores.iter().position(|score| score.controller == name);
            let best = place("ri")?.min(place("dnpf")?) as f64;
            ["rvi", "roi", "feedforward", "srnf"]
                .into_iter()
                .map(|name| Some(place(name)? as f64 - best))
                .collect()
        },
        holds: Below(0.0),
        remark: "Feedforward never settles in a step, so it ranks behind all that do.",
    },
];
