//! Sections 2.2 and 2.4.

use super::Criterion::{Above, Below, Between};
use super::friction::{
    accelerations_at_rest, after_stops, apart, changes_of_side, excess, held_at_stops, miss, peaks,
    reversals_at_rest, rows, swings, times, work,
};
use super::{Claim, precision};
use crate::report::evidence::ReportEvidence;
use dynamics::solver::EventKind;

/// Returns the position at which the block on the spring rests after each slip, m.
fn plateaus(evidence: &ReportEvidence, name: &str) -> Option<Vec<f64>> {
    let result = evidence.lab(name)?;
    let at = |stop_s: &f64| Some(rows(result, *stop_s, f64::INFINITY).first()?.position[0]);
    times(result, 0, &[EventKind::Stick]).iter().map(at).collect()
}

fn largest(values: Vec<f64>) -> Vec<f64> {
    values.into_iter().reduce(f64::max).into_iter().collect()
}

/// Returns the ratios of the largest speeds of two runs.
fn speeds(evidence: &ReportEvidence, of: &str, by: &str) -> Option<Vec<f64>> {
    let (of, by) = (evidence.lab(of)?, evidence.lab(by)?);
    Some(of.metrics.max_speed.iter().zip(&by.metrics.max_speed).map(|(a, b)| a / b).collect())
}

pub(super) const CLAIMS: &[Claim] = &[
    Claim {
        source: "Section 2.2.1.1, Fig. 5a",
        says: "Both models climb the same staircase.",
        quantity: "largest difference of the six heights, by a step's height (1.2146 mm)",
        measure: |e| {
            let (karnopp, ri) = (plateaus(e, "spring/karnopp")?, plateaus(e, "spring/ri")?);
            let step = *karnopp.first()?;
            let pairs = karnopp.iter().zip(&ri);
            (karnopp.len() == ri.len())
                .then(|| largest(pairs.map(|(k, r)| (k - r).abs() / step).collect()))
        },
        holds: Below(0.05),
        remark: "",
    },
    Claim {
        source: "Section 2.2.1.1",
        says: "In double precision the Reset Integrator's friction peaks are uniform each time the \
            block sticks.",
        quantity: "largest by smallest peak within 20 ms of the six sticks",
        measure: |e| {
            let peaks = after_stops(e, "spring/ri", 0.02)?;
            let least = peaks.iter().copied().reduce(f64::min)?;
            Some(largest(peaks).into_iter().map(|most| most / least).collect())
        },
        holds: Between(1.0, 1.001),
        remark: "",
    },
    Claim {
        source: "Section 2.2.1.1",
        says: "In single precision they are not.",
        quantity: "largest by smallest of the six peaks, Runge-Kutta steps of 0.1 ms in single \
            precision",
        measure: |_| Some(vec![precision::unevenness()[0]]),
        holds: Above(1.001),
        remark: "The same program in double precision is within 1e-5 of even.",
    },
    Claim {
        source: "Section 2.2.1.1",
        says: "The oscillations at rest dissipate quickly.",
        quantity: "time from each stop until the friction stays within 5 % of F_s of the spring's \
            force, by the stay at rest",
        measure: |e| Some(largest(swings(e, "spring/ri")?)),
        holds: Below(0.2),
        remark: "",
    },
    Claim {
        source: "Section 2.2.1.1",
        says: "Less damping beta dissipates them more slowly.",
        quantity: "that time with beta = 15 by that with 30, and with 30 by that with 60 N s/m",
        measure: |e| {
            let swing = |name| swings(e, name)?.first().copied();
            let middle = swing("spring/ri")?;
            Some(vec![
                swing("spring/ri-damped-less")? / middle,
                middle / swing("spring/ri-damped-more")?,
            ])
        },
        holds: Above(1.0),
        remark: "",
    },
    Claim {
        source: "Section 2.2.1.1",
        says: "More damping beta raises the Reset Integrator's peaks, less lowers them.",
        quantity: "largest friction with beta = 60 by that with 30, and with 30 by that with 15 N \
            s/m",
        measure: |e| {
            let peak = |name| Some(*e.lab(name)?.metrics.peak_friction.first()?);
            let middle = peak("spring/ri")?;
            Some(vec![
                peak("spring/ri-damped-more")? / middle,
                middle / peak("spring/ri-damped-less")?,
            ])
        },
        holds: Above(1.01),
        remark: "At a stop p-dot is zero and the friction K_r (1 + a) p_o = F_s: beta does not \
            enter.",
    },
    Claim {
        source: "Section 2.4",
        says: "Karnopp's friction stays within the given F_s.",
        quantity: "largest friction less F_s (N, N m): spring, two blocks, pendulum, two links",
        measure: |e| {
            let names = ["spring/karnopp", "blocks/karnopp", "pendulum/karnopp", "arm/karnopp"];
            names
                .into_iter()
                .map(|name| excess(e, name))
                .collect::<Option<Vec<_>>>()
                .map(|all| all.concat())
        },
        holds: Below(1e-9),
        remark: "",
    },
    Claim {
        source: "Section 2.2.1.2, Fig. 7b",
        says: "On two blocks the Reset Integrator's stick friction is above the given F_s.",
        quantity: "largest friction by F_s: block 1, block 2",
        measure: |e| peaks(e, "blocks/ri"),
        holds: Above(1.05),
        remark: "",
    },
    Claim {
        source: "Section 2.2.1.2",
        says: "Karnopp's computing time on two blocks is that on one (printed: 0.44 s both).",
        quantity: "derivative evaluations by those on one block: eps = 2e-4, 1.6e-4, 1.8e-4, \
            2.2e-4, 2.4e-4",
        measure: |e| work(e, "blocks/banded-work", "spring/banded-work"),
        holds: Between(0.9, 1.1),
        remark: "For a tenth of the simulated time: 0.5 s, not 5 s.",
    },
    Claim {
        source: "Section 2.2.1.2",
        says: "On two blocks the Reset Integrator oscillates less at rest than on one.",
        quantity: "reversals of the bristles at rest, by those on one block",
        measure: |e| {
            Some(vec![reversals_at_rest(e, "blocks/ri")? / reversals_at_rest(e, "spring/ri")?])
        },
        holds: Below(1.0),
        remark: "",
    },
    Claim {
        source: "Section 2.2.2.1, Fig. 9a",
        says: "With Karnopp's model the pendulum's static friction exceeds the dynamic one at its \
            first two stops only.",
        quantity: "stops held with more than T_d: from the first on, and in all",
        measure: |e| {
            let held = held_at_stops(e, "pendulum/karnopp")?;
            let first_two = held.iter().take_while(|held| **held > 1.0).count();
            let all = held.iter().filter(|held| **held > 1.0).count();
            Some(vec![first_two as f64, all as f64])
        },
        holds: Between(2.0, 2.0),
        remark: "This takes gravity, which eq. 15 leaves out.",
    },
    Claim {
        source: "Section 2.2.2.1, Fig. 9b",
        says: "With the Reset Integrator it does so at every stop.",
        quantity: "largest friction within 20 ms of each stop, by T_d",
        measure: |e| after_stops(e, "pendulum/ri", 0.02),
        holds: Above(1.0),
        remark: "",
    },
    Claim {
        source: "Section 2.2.2.1",
        says: "The pendulum's velocities are similar for both models.",
        quantity: "largest speed of the Reset Integrator by Karnopp's",
        measure: |e| speeds(e, "pendulum/ri", "pendulum/karnopp"),
        holds: Between(0.99, 1.01),
        remark: "",
    },
    Claim {
        source: "Section 2.2.2.2, Figs. 11-12",
        says: "The two links' velocities are similar for both models.",
        quantity: "largest speed of the Reset Integrator by Karnopp's: links 1 and 2",
        measure: |e| speeds(e, "arm/ri", "arm/karnopp"),
        holds: Between(0.99, 1.01),
        remark: "",
    },
    Claim {
        source: "Section 2.2.2.2",
        says: "On two links, too, the Reset Integrator's stick friction peaks above T_s.",
        quantity: "largest friction by T_s: joints 1 and 2",
        measure: |e| peaks(e, "arm/ri"),
        holds: Above(1.05),
        remark: "",
    },
    Claim {
        source: "Section 2.2.2.2, Fig. 13",
        says: "With the coupling neglected (eqs. 18-21) the joints accelerate while both stick.",
        quantity: "largest acceleration while both are within D_v (rad/s\u{b2}): joints 1 and 2",
        measure: |e| accelerations_at_rest(e, "arm/banded-work"),
        holds: Above(0.01),
        remark: "With both decided at once, and exact, it is zero by construction.",
    },
    Claim {
        source: "Section 2.2.2.2, Fig. 13",
        says: "They do so at about 1.25 s and at about 2.5 s.",
        quantity: "largest acceleration while both are within D_v, within 0.1 s of 1.25 s and of \
            2.5 s (rad/s\u{b2})",
        measure: |e| {
            let result = e.lab("arm/banded-work")?;
            let kick = |at_s: f64| {
                let resting = rows(result, at_s - 0.1, at_s + 0.1)
                    .iter()
                    .filter(|row| row.stuck == [true, true]);
                resting
                    .flat_map(|row| &row.acceleration)
                    .fold(0.0, |most: f64, a| most.max(a.abs()))
            };
            Some(vec![kick(1.25), kick(2.5)])
        },
        holds: Above(0.01),
        remark: "",
    },
    Claim {
        source: "Section 2.2.2.2",
        says: "Accelerations of the previous step (eqs. 22-25) are more accurate than none.",
        quantity: "miss of the final angles from the exact ones, by that of eqs. 18-21 at the same \
            D_v",
        measure: |e| {
            let miss = |name| miss(e, name, "arm/karnopp");
            Some(vec![miss("arm/previous-step")? / miss("arm/wide-neglected")?])
        },
        holds: Below(1.0),
        remark: "As printed they keep up the joint's own last acceleration instead of cancelling \
            it.",
    },
    Claim {
        source: "Section 2.2.2.2, Fig. 14",
        says: "With eqs. 22-25 the result changes slightly.",
        quantity: "largest difference of the angles from those with eqs. 18-21, by the largest \
            excursion: links 1 and 2",
        measure: |e| apart(e, "arm/wide-neglected", "arm/previous-step"),
        holds: Between(0.001, 0.1),
        remark: "",
    },
    Claim {
        source: "Section 2.2.2.2, Fig. 14",
        says: "With eqs. 22-25 the stick frictions switch back and forth.",
        quantity: "changes of sign, of at least T_d either way, among the samples with both joints \
            within D_v: joints 1 and 2",
        measure: |e| changes_of_side(e, "arm/previous-step", "slip"),
        holds: Above(10.0),
        remark: "",
    },
    Claim {
        source: "Section 2.2.2.2, Fig. 14",
        says: "With eqs. 22-25 the stick frictions switch between their maximum values.",
        quantity: "changes of sign, of at least T_s either way, among the samples with both joints \
            within D_v",
        measure: |e| changes_of_side(e, "arm/previous-step", "stick"),
        holds: Above(10.0),
        remark: "A joint that comes into its band keeps its acceleration up, and so the friction \
            it had: near T_d, not T_s.",
    },
    Claim {
        source: "Section 2.2.2.2, Fig. 14",
        says: "With eqs. 22-25 the computation takes very much longer.",
        quantity: "derivative evaluations by those of eqs. 18-21 at the same D_v",
        measure: |e| work(e, "arm/previous-step", "arm/wide-neglected"),
        holds: Above(10.0),
        remark: "The thesis's 70 minutes were of an NCD workstation.",
    },
    Claim {
        source: "Table 3",
        says: "One block on a spring: the Reset Integrator takes about twice as long (printed: \
            2.25).",
        quantity: "its derivative evaluations by those of banded Karnopp: eps = 2e-4, 1.6e-4, \
            1.8e-4, 2.2e-4, 2.4e-4",
        measure: |e| work(e, "spring/ri-work", "spring/banded-work"),
        holds: Between(1.5, 3.0),
        remark: "",
    },
    Claim {
        source: "Table 6",
        says: "Two blocks: the Reset Integrator is the faster one (printed: 0.86).",
        quantity: "its derivative evaluations by those of banded Karnopp: eps = 2e-4, 1.6e-4, \
            1.8e-4, 2.2e-4, 2.4e-4",
        measure: |e| work(e, "blocks/ri-work", "blocks/banded-work"),
        holds: Below(1.0),
        remark: "It depends on the details of the step control; the thesis gives only eps.",
    },
    Claim {
        source: "Table 9",
        says: "Pendulum: the Reset Integrator is slower (printed: 2.75).",
        quantity: "its derivative evaluations by those of banded Karnopp: eps = 2e-4, 1.6e-4, \
            1.8e-4, 2.2e-4, 2.4e-4",
        measure: |e| work(e, "pendulum/ri-work", "pendulum/banded-work"),
        holds: Above(1.0),
        remark: "",
    },
    Claim {
        source: "Table 12",
        says: "Two links: the Reset Integrator is slower (printed: 3.15).",
        quantity: "its derivative evaluations by those of banded Karnopp with eqs. 18-21, at the \
            same eps",
        measure: |e| work(e, "arm/ri-work", "arm/banded-work"),
        holds: Above(1.0),
        remark: "If a step that fails may shrink to any part of itself at once, eqs. 18-21 chatter \
            about the band's edge at most of these eps, and then cost a hundred times as much.",
    },
    Claim {
        source: "Table 12",
        says: "Two links, both joints decided at once: the Reset Integrator is slower.",
        quantity: "its derivative evaluations by those of banded Karnopp, at the same eps",
        measure: |e| work(e, "arm/ri-work", "arm/at-once-work"),
        holds: Above(1.0),
        remark: "",
    },
    Claim {
        source: "Section 2.4",
        says: "The Reset Integrator can be as much as three times slower for the manipulators.",
        quantity: "its derivative evaluations by those of banded Karnopp, the most of five eps: \
            pendulum, two links (eqs. 18-21)",
        measure: |e| {
            let most = |of, by| Some(largest(work(e, of, by)?));
            Some(
                [
                    most("pendulum/ri-work", "pendulum/banded-work")?,
                    most("arm/ri-work", "arm/banded-work")?,
                ]
                .concat(),
            )
        },
        holds: Between(2.0, 4.0),
        remark: "",
    },
];
