//! The golden traces of slow set points: 5500 ticks, with every state of the law in every tick.
//!
//! They are the results of a prototype in `f32`. Their set points are multiples of a tenth of a
//! count, so that many comparisons are between nearly equal numbers. So the supervisor gets exactly
//! the numbers of the prototype, and not positions in counts, which are rounded differently.

extern crate std;

use crate::control::motor_encoder::MotorEncoder;
use std::io::Read;
use std::string::String;
use std::vec::Vec;

use flate2::read::GzDecoder;

use super::super::Loop;
use super::RobustGains;
use super::supervisor::{Seen, Supervisor, SupervisorState};
use crate::units::value::Table;

const TRACES: &[u8] = include_bytes!("../../../../tests/robust/golden_slow.csv.gz");

/// Returns the figure after a name in the comment above a trace.
fn figure(comment: &str, name: &str) -> f64 {
    let words: Vec<&str> = comment.split_whitespace().collect();
    let at = words.iter().position(|word| *word == name).unwrap();
    words[at + 1].parse().unwrap()
}

/// Returns the law of a trace; angles are in the unit of the trace.
fn law(comment: &str) -> Supervisor {
    let [h, q, inertia, viscous, low, high, limit, lsb, jitter] =
        ["h", "q", "J", "B", "Flo", "Fhi", "umax", "uq", "nj"].map(|name| figure(comment, name));
    let is_in_radians = !comment.contains("thesis");
    let gains = RobustGains {
        inertia: inertia as f32,
        viscous: viscous as f32,
        breakaway_low: low as f32,
        breakaway_high: high as f32,
        jitter: jitter as f32,
        // The cap of the rule is in degrees.
        speed: if is_in_radians { (0.15 * limit / viscous).min(3.0) as f32 } else { 0.0 },
        // The prototype is as fast with jitter, and learns friction at any speed.
        tracking_observer: ((0.7 / h).min(110.0)).max((0.35 / h).min(300.0)) as f32,
        learned_to: f32::MAX,
        attempts: 0,
        ..RobustGains::EXAMPLE
    };
    let around = Loop {
        sample_time: h as f32,
        resolution: q as f32,
        full_scale: limit as f32,
        lsb: lsb as f32,
        kp: 0.0,
        motor: MotorEncoder::NONE,
    };
    Supervisor::new(&gains, &around)
}

#[test]
fn law_follows_slow_set_points_as_its_prototype_did_in_every_tick() {
    let mut text = String::new();
    GzDecoder::new(TRACES).read_to_string(&mut text).unwrap();
    let (mut name, mut law_of, mut count, mut highest) = ("", None, 0.0, 0.0);
    let (mut state, mut applied, mut origin) = (SupervisorState::default(), 0.0, 0.0);
    let (mut ticks, mut traces, mut inched, mut worst) = (0, 0, 0, 0.0f32);
    for line in text.lines() {
        if let Some(comment) = line.strip_prefix("# ") {
            let Some((of, _)) = comment.rsplit_once(": h ") else { continue };
            (name, count, highest) = (of, figure(comment, "q"), figure(comment, "Fhi") as f32);
            let made = law(comment);
            made.start(&mut state);
            (law_of, applied) = (Some(made), 0.0);
            traces += 1;
            continue;
        }
        let law = law_of.as_ref().unwrap();
        let columns: Vec<f64> = line.split(',').map(|word| word.parse().unwrap()).collect();
        let [tick, counts, reference, velocity, mode, inches, effort, held, gain] =
            columns.try_into().unwrap();
        if tick == 0.0 {
            origin = counts * count;
        }
        let seen = Seen {
            position: (counts * count - origin) as f32,
            reference: (reference - origin) as f32,
            velocity: velocity as f32,
            applied,
        };
        applied = law.update(&mut state, &seen);
        let at = (name, tick);
        assert_eq!((state.mode as u8, state.inching.active), (mode as u8, inches == 1.0), "{at:?}");
        let off = (applied - effort as f32).abs() / highest;
        // The tolerance of the other golden traces.
        assert!(off <= 3e-4, "{at:?}: {applied}, not {effort}");
        assert!((state.held.effort - held as f32).abs() <= 1e-6, "{at:?}: u_b");
        assert!((state.guarded.gain - gain as f32).abs() <= 1e-6, "{at:?}: g");
        worst = worst.max(off);
        ticks += 1;
        inched += u32::from(state.inching.active);
    }
    assert_eq!((traces, ticks), (8, 5500));
    assert!(inched > 2000, "{inched} ticks of {ticks} inch, effort to {worst} F_hi");
}
