//! Section 2.3, each model under the three inputs, and Appendix A.1.

use super::Claim;
use super::Criterion::{Above, Below, Between};
use super::friction::{apart, levels, peaks, rows, times};
use dynamics::solver::EventKind;

pub(super) const CLAIMS: &[Claim] = &[
    Claim {
        source: "Section 2.3.1.1, Fig. 15",
        says: "Under the square wave the banded block \"rests\" with a velocity near D_v.",
        quantity: "speed at 8 s by D_v",
        measure: |e| {
            Some(vec![e.lab("square/banded")?.metrics.final_velocity.first()?.abs() / 0.001])
        },
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
        says: "The block's largest velocity under the triangle wave is slightly larger than 0.1 \
            m/s.",
        quantity: "largest speed (m/s)",
        measure: |e| Some(vec![*e.lab("triangle/karnopp")?.metrics.max_speed.first()?]),
        holds: Between(0.1, 0.15),
        remark: "",
    },
    Claim {
        source: "Section 2.3.2.1, Fig. 18",
        says: "The Reset Integrator's block sticks just after 1.5 s.",
        quantity: "first stick (s)",
        measure: |e| {
            times(e.lab("square/ri")?, 0, &[EventKind::Stick]).first().map(|time_s| vec![*time_s])
        },
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
        says: "On sticking the friction starts with a spike and oscillates about zero before it \
            settles.",
        quantity: "smallest friction within 0.1 s of the first stick, by F_s",
        measure: |e| {
            let result = e.lab("square/ri")?;
            let stop_s = *times(result, 0, &[EventKind::Stick]).first()?;
            let least = rows(result, stop_s, stop_s + 0.1)
                .iter()
                .map(|row| row.friction[0])
                .reduce(f64::min)?;
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
            let most = rows(result, break_s - 0.1, break_s)
                .iter()
                .map(|row| row.friction[0])
                .reduce(f64::max)?;
            Some(vec![most / levels(result, "stick").first()?])
        },
        holds: Between(0.99, 1.01),
        remark: "",
    },
    Claim {
        source: "Section 2.3.1.1, Fig. 15",
        says: "On leaving the band the block's acceleration jumps up.",
        quantity: "acceleration after by that before the first break: square wave, triangle wave",
        measure: |e| {
            let jump = |name| {
                let result = e.lab(name)?;
                let break_s = *times(result, 0, &[EventKind::Break]).first()?;
                let before =
                    rows(result, 0.0, break_s).iter().rev().find(|row| row.stuck == [true])?;
                let after =
                    rows(result, break_s, f64::INFINITY).iter().find(|row| row.stuck == [false])?;
                // The ratio shows a jump only for a block that is pushed forward before.
                let before = Some(before.acceleration[0]).filter(|a| *a > 0.0)?;
                Some(after.acceleration[0] / before)
            };
            Some(vec![jump("square/banded")?, jump("triangle/banded")?])
        },
        holds: Above(1.0),
        remark: "From F_s to F_d: closed form (1 - 0.6) / (1 - 0.8) = 2 under the square wave.",
    },
    Claim {
        source: "Section 2.3.1.1",
        says: "A smaller D_v makes the block rest less long, and creep less while it does.",
        quantity: "with D_v = 0.0001 m/s by that with 0.001: time within the band, speed at 8 s \
            (steps of 10 \u{b5}s)",
        measure: |e| {
            let rest = |name| {
                let result = e.lab(name)?;
                let pairs = result.rows.windows(2).filter(|pair| pair[0].stuck == [true]);
                let rest_s: f64 = pairs.map(|pair| pair[1].time_s - pair[0].time_s).sum();
                Some((rest_s, result.metrics.final_velocity.first()?.abs()))
            };
            let ((narrow_s, slow), (wide_s, fast)) =
                (rest("square/narrow")?, rest("square/banded")?);
            Some(vec![narrow_s / wide_s, slow / fast])
        },
        holds: Below(1.0),
        remark: "",
    },
    Claim {
        source: "Section 2.3.2.2, Fig. 19",
        says: "Under the triangle wave the Reset Integrator's friction follows the force \
            accurately until it breaks away.",
        quantity: "largest difference of friction and force before the first break, by F_s",
        measure: |e| {
            let result = e.lab("triangle/ri")?;
            let break_s = *times(result, 0, &[EventKind::Break]).first()?;
            let held = rows(result, 0.0, break_s).iter().filter(|row| row.stuck == [true]);
            let missing =
                held.map(|row| (row.friction[0] - row.input[0]).abs()).fold(0.0, f64::max);
            Some(vec![missing / levels(result, "stick").first()?])
        },
        holds: Below(0.01),
        remark: "",
    },
    Claim {
        source: "Section 2.3.2.2, Fig. 19",
        says: "Its transition from slip to stick is less smooth than that from stick to slip.",
        quantity: "largest jump of the friction within 20 ms of the first stick, by that of the \
            first break",
        measure: |e| {
            let result = e.lab("triangle/ri")?;
            let range = |kind| {
                let at_s = *times(result, 0, &[kind]).first()?;
                let near = rows(result, at_s - 0.02, at_s + 0.02).iter().map(|row| row.friction[0]);
                let (least, most) = near.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), f| {
                    (f64::min(a, f), f64::max(b, f))
                });
                Some(most - least)
            };
            Some(vec![range(EventKind::Stick)? / range(EventKind::Break)?])
        },
        holds: Above(1.0),
        remark: "",
    },
    Claim {
        source: "Section 2.3.2.2, Fig. 19",
        says: "At the second break the position variable is at its other end.",
        quantity: "p at the second break, by p at the first",
        measure: |e| {
            let result = e.lab("triangle/ri")?;
            let breaks = times(result, 0, &[EventKind::Break]);
            let p = |at_s: &f64| Some(rows(result, *at_s, f64::INFINITY).first()?.deflection[0]);
            Some(vec![p(breaks.get(1)?)? / p(breaks.first()?)?])
        },
        holds: Between(-1.001, -0.999),
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
