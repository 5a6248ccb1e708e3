//! Sections 2.2 to 2.4 and Appendix A.1.

use super::Claim;
use super::Criterion::{Above, Below, Between};
use super::friction::{
    accelerations_at_rest, after_stops, apart, changes_of_side, excess, held_at_stops, levels, miss, peaks,
    rows, times, work,
};
use crate::report::evidence::Evidence;
use crate::solver::EventKind;

/// Where the block on the spring comes to rest after each slip, m.
fn plateaus(evidence: &Evidence, name: &str) -> Option<Vec<f64>> {
    let result = evidence.lab(name)?;
    let at = |stop_s: &f64| Some(rows(result, *stop_s, f64::INFINITY).first()?.position[0]);
    times(result, 0, &[EventKind::Stick]).iter().map(at).collect()
}

fn largest(values: Vec<f64>) -> Vec<f64> {
    values.into_iter().reduce(f64::max).into_iter().collect()
}

/// Largest speeds of one run by those of another.
fn speeds(evidence: &Evidence, of: &str, by: &str) -> Option<Vec<f64>> {
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
            (karnopp.len() == ri.len()).then(|| largest(pairs.map(|(k, r)| (k - r).abs() / step).collect()))
        },
        holds: Below(0.05),
        remark: "",
    },
    Claim {
        source: "Section 2.2.1.1",
        says: "In double precision the Reset Integrator's friction peaks are uniform each time the block sticks.",
        quantity: "largest by smallest peak within 20 ms of the six sticks",
        measure: |e| {
            let peaks = after_stops(e, "spring/ri", 0.02)?;
            let least = peaks.iter().copied().reduce(f64::min)?;
            Some(largest(peaks).into_iter().map(|most| most / least).collect())
        },
        holds: Between(1.0, 1.001),
        remark: "The uneven peaks of single precision are not simulated.",
    },
    Claim {
        source: "Section 2.2.1.1",
        says: "More damping beta raises the Reset Integrator's peaks, less lowers them.",
        quantity: "largest friction with beta = 60 by that with 30, and with 30 by that with 15 N s/m",
        measure: |e| {
            let peak = |name| Some(*e.lab(name)?.metrics.peak_friction.first()?);
            let middle = peak("spring/ri")?;
            Some(vec![peak("spring/ri-damped-more")? / middle, middle / peak("spring/ri-damped-less")?])
        },
        holds: Above(1.01),
        remark: "At a stop p-dot is zero and the friction K_r (1 + a) p_o = F_s: beta does not enter.",
    },
    Claim {
        source: "Section 2.4",
        says: "Karnopp's friction stays within the given F_s.",
        quantity: "largest friction less F_s (N, N m): spring, two blocks, pendulum, two links",
        measure: |e| {
            let names = ["spring/karnopp", "blocks/karnopp", "pendulum/karnopp", "arm/karnopp"];
            names.into_iter().map(|name| excess(e, name)).collect::<Option<Vec<_>>>().map(|all| all.concat())
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
        source: "Section 2.2.2.1, Fig. 9a",
        says: "With Karnopp's model the pendulum's static friction exceeds the dynamic one at its first two stops only.",
        quantity: "stops that ask for more than T_d to be held: from the first on, and in all",
        measure: |e| {
            let held = held_at_stops(e, "pendulum/karnopp")?;
            let first_two = held.iter().take_while(|held| **held > 1.0).count();
            let all = held.iter().filter(|held| **held > 1.0).count();
            Some(vec![first_two as f64, all as f64])
        },
        holds: Between(2.0, 2.0),
        remark: "It takes gravity, which eq. 15 leaves out.",
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
        source: "Section 2.2.2.2",
        says: "Accelerations of the previous step (eqs. 22-25) are more accurate than none.",
        quantity: "miss of the final angles from the exact ones, by that of eqs. 18-21 at the same D_v",
        measure: |e| {
            let miss = |name| miss(e, name, "arm/karnopp");
            Some(vec![miss("arm/previous-step")? / miss("arm/wide-neglected")?])
        },
        holds: Below(1.0),
        remark: "As printed they keep up the joint's own last acceleration instead of cancelling it.",
    },
    Claim {
        source: "Section 2.2.2.2, Fig. 14",
        says: "With eqs. 22-25 the stick frictions switch back and forth.",
        quantity: "changes of sign, of at least T_d either way, among the samples with both joints within D_v: joints 1 and 2",
        measure: |e| changes_of_side(e, "arm/previous-step", "slip"),
        holds: Above(10.0),
        remark: "",
    },
    Claim {
        source: "Section 2.2.2.2, Fig. 14",
        says: "With eqs. 22-25 the stick frictions switch between their maximum values.",
        quantity: "changes of sign, of at least T_s either way, among the samples with both joints within D_v",
        measure: |e| changes_of_side(e, "arm/previous-step", "stick"),
        holds: Above(10.0),
        remark: "A joint that comes into its band keeps its acceleration up, and so the friction it had: near T_d, not T_s.",
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
        says: "One block on a spring: the Reset Integrator takes about twice as long (printed: 2.25).",
        quantity: "its derivative evaluations by those of banded Karnopp: eps = 2e-4, 1.6e-4, 1.8e-4, 2.2e-4, 2.4e-4",
        measure: |e| work(e, "spring/ri-work", "spring/banded-work"),
        holds: Between(1.5, 3.0),
        remark: "",
    },
    Claim {
        source: "Table 6",
        says: "Two blocks: the Reset Integrator is the faster one (printed: 0.86).",
        quantity: "its derivative evaluations by those of banded Karnopp: eps = 2e-4, 1.6e-4, 1.8e-4, 2.2e-4, 2.4e-4",
        measure: |e| work(e, "blocks/ri-work", "blocks/banded-work"),
        holds: Below(1.0),
        remark: "It depends on the details of the step control, of which the thesis tells only eps.",
    },
    Claim {
        source: "Table 9",
        says: "Pendulum: the Reset Integrator is slower (printed: 2.75).",
        quantity: "its derivative evaluations by those of banded Karnopp: eps = 2e-4, 1.6e-4, 1.8e-4, 2.2e-4, 2.4e-4",
        measure: |e| work(e, "pendulum/ri-work", "pendulum/banded-work"),
        holds: Above(1.0),
        remark: "",
    },
    Claim {
        source: "Table 12",
        says: "Two links: the Reset Integrator is slower (printed: 3.15).",
        quantity: "its derivative evaluations by those of banded Karnopp with eqs. 18-21, at the same eps",
        measure: |e| work(e, "arm/ri-work", "arm/banded-work"),
        holds: Above(1.0),
        remark: "With eqs. 18-21 an arm may chatter about its band's edge, and then costs a hundred times as much.",
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
        source: "Section 2.3.1.1, Fig. 15",
        says: "Under the square wave the banded block \"rests\" with a velocity near D_v.",
        quantity: "speed at 8 s by D_v",
        measure: |e| Some(vec![e.lab("square/banded")?.metrics.final_velocity.first()?.abs() / 0.001]),
        holds: Between(0.9, 1.0),
        remark: "The exact block rests.",
    },
    Claim {
        source: "Section 2.3.1.2, Fig. 16",
        says: "Under the triangle wave it keeps D_v until the force exceeds F_s just before 3 s.",
        quantity: "second break-away (s); closed form 2.8",
        measure: |e| Some(vec![*times(e.lab("triangle/banded")?, 0, &[EventKind::Break]).get(1)?]),
        holds: Between(2.7, 3.0),
        remark: "",
    },
    Claim {
        source: "Section 2.3.1.2",
        says: "The block's largest velocity under the triangle wave is slightly larger than 0.1 m/s.",
        quantity: "largest speed (m/s)",
        measure: |e| Some(vec![*e.lab("triangle/karnopp")?.metrics.max_speed.first()?]),
        holds: Between(0.1, 0.15),
        remark: "",
    },
    Claim {
        source: "Section 2.3.2.1, Fig. 18",
        says: "The Reset Integrator's block sticks just after 1.5 s.",
        quantity: "first stick (s)",
        measure: |e| times(e.lab("square/ri")?, 0, &[EventKind::Stick]).first().map(|time_s| vec![*time_s]),
        holds: Between(1.5, 1.8),
        remark: "",
    },
    Claim {
        source: "Section 2.3.2.1, Fig. 18",
        says: "A sudden force raises the Reset Integrator's friction above F_s.",
        quantity: "largest friction by F_s",
        measure: |e| peaks(e, "square/ri"),
        holds: Above(1.05),
        remark: "",
    },
    Claim {
        source: "Section 2.3.2.1, Fig. 18",
        says: "On sticking the friction starts with a spike and oscillates about zero before it settles.",
        quantity: "smallest friction within 0.1 s of the first stick, by F_s",
        measure: |e| {
            let result = e.lab("square/ri")?;
            let stop_s = *times(result, 0, &[EventKind::Stick]).first()?;
            let least =
                rows(result, stop_s, stop_s + 0.1).iter().map(|row| row.friction[0]).reduce(f64::min)?;
            Some(vec![least / levels(result, "stick").first()?])
        },
        holds: Below(-0.01),
        remark: "",
    },
    Claim {
        source: "Section 2.3.2.3, Fig. 20",
        says: "On the spring the Reset Integrator breaks away smoothly at F_s.",
        quantity: "largest friction in the 0.1 s before the first break, by F_s",
        measure: |e| {
            let result = e.lab("revisited/ri")?;
            let break_s = *times(result, 0, &[EventKind::Break]).first()?;
            let most =
                rows(result, break_s - 0.1, break_s).iter().map(|row| row.friction[0]).reduce(f64::max)?;
            Some(vec![most / levels(result, "stick").first()?])
        },
        holds: Between(0.99, 1.01),
        remark: "",
    },
    Claim {
        source: "Appendix A.1, Figs. 61-62",
        says: "On two independent blocks the models' displacements are quite similar.",
        quantity: "largest difference by the largest excursion: blocks 1 and 2",
        measure: |e| apart(e, "independent/karnopp", "independent/ri"),
        holds: Below(0.05),
        remark: "",
    },
];
