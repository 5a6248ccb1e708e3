//! The golden traces: eight runs of 12,200 ticks together, with the state of the law in every tick.
//!
//! They are the results of a prototype in `f32`. As in `robust/slow_traces.rs`, the supervisor gets
//! exactly the numbers of the prototype, in rad and N m.

extern crate std;

use std::io::Read;
use std::string::String;
use std::vec::Vec;

use flate2::read::GzDecoder;

use super::super::Loop;
use super::RobustDualGains;
use super::supervisor::{Mode, Seen, Supervisor, SupervisorState};
use crate::control::motor_encoder::MotorEncoder;
use crate::units::value::Table;

const TRACES: &[u8] = include_bytes!("../../../../tests/robust/golden_dual.csv.gz");

/// A trace: the parameters of the law, and the rows.
struct Trace {
    name: String,
    given: Vec<(String, f64)>,
    rows: Vec<[f64; 9]>,
}

impl Trace {
    fn figure(&self, name: &str) -> f64 {
        self.given.iter().find(|(of, _)| of == name).unwrap().1
    }

    fn law(&self) -> Supervisor {
        let [viscous, limit, jitter] = ["B", "umax", "nj"].map(|name| self.figure(name) as f32);
        let gains = RobustDualGains {
            inertia: self.figure("J") as f32,
            viscous,
            breakaway_low: self.figure("Flo") as f32,
            breakaway_high: self.figure("Fhi") as f32,
            jitter,
            motor_jitter: jitter,
            stiffness: self.figure("K") as f32,
            attempts: 0,
            // The cap of the rule is in degrees.
            speed: (0.15 * limit / viscous).min(3.0),
            ..RobustDualGains::EXAMPLE
        };
        let around = Loop {
            sample_time: self.figure("h") as f32,
            resolution: self.figure("q") as f32,
            full_scale: limit,
            lsb: self.figure("uq") as f32,
            kp: 0.0,
            motor: MotorEncoder { count: self.figure("qm") as f32, ..MotorEncoder::NONE },
        };
        Supervisor::new(&gains, &around)
    }
}

fn traces() -> Vec<Trace> {
    let mut text = String::new();
    GzDecoder::new(TRACES).read_to_string(&mut text).unwrap();
    let mut traces: Vec<Trace> = Vec::new();
    for line in text.lines() {
        if let Some(comment) = line.strip_prefix("# ") {
            if let Some((name, given)) = comment.split_once(": h ") {
                let words: Vec<&str> = given.split_whitespace().collect();
                let mut given: Vec<_> = words[1..]
                    .chunks_exact(2)
                    .map(|pair| (pair[0].into(), pair[1].parse().unwrap()))
                    .collect();
                given.push(("h".into(), words[0].parse().unwrap()));
                traces.push(Trace { name: name.into(), given, rows: Vec::new() });
            }
        } else {
            let row: Vec<f64> = line.split(',').map(|word| word.parse().unwrap()).collect();
            traces.last_mut().unwrap().rows.push(row.try_into().unwrap());
        }
    }
    traces
}

/// Returns the number of a state in the traces.
const fn number(mode: Mode) -> u8 {
    match mode {
        Mode::Bump => 5,
        other => other as u8,
    }
}

#[test]
fn law_does_what_its_prototype_did_in_every_tick_of_every_trace() {
    let traces = traces();
    assert_eq!(traces.len(), 8);
    assert_eq!(traces.iter().map(|trace| trace.rows.len()).sum::<usize>(), 12_200);
    for trace in &traces {
        let law = trace.law();
        let [count, motor_count] = ["q", "qm"].map(|name| trace.figure(name));
        let (mut state, mut applied) = (SupervisorState::default(), 0.0);
        law.start(&mut state);
        let [_, first_motor, first_load, ..] = trace.rows[0];
        let (mut worst, mut worst_levels) = (0f32, 0f32);
        for row in &trace.rows {
            let [tick, motor, load, reference, mode, effort, backwards, forwards, neutral] = *row;
            let origin = first_load * count;
            let seen = Seen {
                motor: (motor * motor_count - first_motor * motor_count) as f32,
                load: (load * count - origin) as f32,
                reference: (reference - origin) as f32,
                velocity: 0.0,
                applied,
            };
            applied = law.update(&mut state, &seen);
            let at = (&trace.name, tick);
            assert_eq!(number(state.mode), mode as u8, "{at:?}: {applied}, {effort}");
            let off = (applied - effort as f32).abs();
            worst = worst.max(off);
            let levels = state.levels.breakaway;
            for (found, wanted) in
                [(levels[0], backwards), (levels[1], forwards), (state.levels.neutral, neutral)]
            {
                worst_levels = worst_levels.max((found - wanted as f32).abs() / count as f32);
            }
            // 6e-5 N m of 60 and 1.6e-4 counts were seen.
            assert!(off <= 2e-4, "{at:?}: {applied}, not {effort}");
            assert!(worst_levels <= 1e-2, "{at:?}: levels off by {worst_levels} counts");
        }
        std::println!("{}: effort {worst:.1e}, levels {worst_levels:.1e} counts", trace.name);
    }
}
