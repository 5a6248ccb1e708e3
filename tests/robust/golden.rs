//! The golden traces: 26 runs of 1000 ticks each, with every state of the law in every tick.
//!
//! The traces are what a prototype of the law gave in `f32`. A second version, written from the
//! equations in `f64`, was seen to agree with it in all states, and to within 2.7e-4 F_hi in the
//! effort. So the tolerance is 3e-4 F_hi of the effort, 1e-6 of the hold effort and of the gain,
//! and none of the state.
//!
//! Most traces are in rad and N m. The law's equations hold in any units that belong together; of
//! its constants one alone is in degrees, the cap of the profile's speed. So the law is given the
//! traces' figures as they are, and their cap as the speed.

use std::io::Read;
use stiction::control::motor_encoder::MotorEncoder;

use flate2::read::GzDecoder;
use stiction::control::laws::robust::{EncoderSide, RobustState};
use stiction::control::laws::{Law, LawInput, Loop, Robust, RobustGains};
use stiction::control::reference::Setpoint;
use stiction::units::position::Position;
use stiction::units::value::Table;

const TRACES: &[u8] = include_bytes!("golden.csv.gz");

/// Header of a trace: its comment line.
pub struct Header {
    pub name: String,
    values: Vec<(String, String)>,
}

/// A trace: the gains of the law, and its rows.
pub struct Trace {
    pub header: Header,
    rows: Vec<Row>,
}

/// A tick of a trace.
pub struct Row {
    counts: i32,
    reference: f64,
    velocity: f64,
    mode: u8,
    effort: f32,
    hold_effort: f32,
    gain: f32,
}

impl Header {
    fn parse(line: &str) -> Option<Self> {
        let (name, values) = line.rsplit_once(": ")?;
        let words: Vec<_> = values.split_whitespace().map(String::from).collect();
        let values = words.chunks_exact(2).map(|pair| (pair[0].clone(), pair[1].clone())).collect();
        Some(Self { name: name.into(), values })
    }

    fn word(&self, name: &str) -> &str {
        &self.values.iter().find(|(of, _)| of == name).unwrap().1
    }

    fn number(&self, name: &str) -> f64 {
        self.word(name).parse().unwrap()
    }

    /// Whether the trace's unit of angle is the radian.
    fn is_in_radians(&self) -> bool {
        !self.name.contains("thesis")
    }

    /// The gains of the prototype.
    pub fn gains(&self) -> RobustGains {
        let [viscous, limit] = ["B", "umax"].map(|name| self.number(name));
        let side = if self.word("side") == "load" { EncoderSide::Load } else { EncoderSide::Motor };
        RobustGains {
            inertia: self.number("J") as f32,
            viscous: viscous as f32,
            breakaway_low: self.number("Flo") as f32,
            breakaway_high: self.number("Fhi") as f32,
            encoder_side: side,
            jitter: self.number("nj") as f32,
            speed: if self.is_in_radians() {
                (0.15 * limit / viscous).min(3.0) as f32
            } else {
                0.0
            },
            // What came after the prototype: giving up, another observer in motion with the
            // encoder on the load, and friction that is learned up to a speed.
            attempts: 0,
            learned_to: f32::MAX,
            observer: if side == EncoderSide::Load {
                (0.7 / self.number("h") as f32).min(110.0)
            } else {
                0.0
            },
            ..RobustGains::EXAMPLE
        }
    }

    fn law(&self, gains: &RobustGains) -> Robust {
        let around = Loop {
            sample_time: self.number("h") as f32,
            resolution: self.number("q") as f32,
            full_scale: self.number("umax") as f32,
            lsb: self.number("uq") as f32,
            kp: 0.0,
            motor: MotorEncoder::NONE,
        };
        Robust::new(gains, &around)
    }
}

pub fn traces() -> Vec<Trace> {
    let mut text = String::new();
    GzDecoder::new(TRACES).read_to_string(&mut text).unwrap();
    let mut traces: Vec<Trace> = Vec::new();
    for line in text.lines() {
        if let Some(comment) = line.strip_prefix("# ") {
            if comment.contains(" side ") && comment.contains(" umax ") {
                traces.push(Trace { header: Header::parse(comment).unwrap(), rows: Vec::new() });
            }
        } else {
            let columns: Vec<f64> = line.split(',').map(|word| word.parse().unwrap()).collect();
            let [_, counts, reference, velocity, mode, effort, hold_effort, gain] =
                columns.try_into().unwrap();
            traces.last_mut().unwrap().rows.push(Row {
                counts: counts as i32,
                reference,
                velocity,
                mode: mode as u8,
                effort: effort as f32,
                hold_effort: hold_effort as f32,
                gain: gain as f32,
            });
        }
    }
    traces
}

impl Trace {
    /// Runs the law along the trace, fed with its own effort, and calls `f` with each row and what
    /// the law gave there.
    pub fn replay(&self, gains: &RobustGains, mut f: impl FnMut(usize, &Row, f32, &RobustState)) {
        let law = self.header.law(gains);
        let count = self.header.number("q");
        let (mut state, mut applied) = (RobustState::default(), 0.0);
        for (tick, row) in self.rows.iter().enumerate() {
            let place = row.reference / count;
            let position = Position {
                counts: place.floor() as i32,
                fraction: ((place - place.floor()) as f32).min(1f32.next_down()),
            };
            let velocity = row.velocity as f32;
            let setpoint = Setpoint { position, velocity, acceleration: 0.0 };
            let input = LawInput { counts: row.counts, setpoint, applied, ..LawInput::default() };
            applied = law.update(&mut state, &input);
            f(tick, row, applied, &state);
        }
    }
}

#[test]
fn law_does_what_its_prototype_did_in_every_tick_of_every_trace() {
    let mut traces = traces();
    assert_eq!(traces.len(), 26);
    assert_eq!(traces.iter().map(|trace| trace.rows.len()).sum::<usize>(), 26_000);
    // Where the set point moves the law has changed since: robust/slow_traces.rs.
    traces.retain(|trace| trace.rows.iter().all(|row| row.velocity == 0.0));
    assert_eq!(traces.len(), 23);
    for trace in &traces {
        let name = &trace.header.name;
        let tolerance = 3e-4 * trace.header.number("Fhi") as f32;
        let mut worst = 0f32;
        trace.replay(&trace.header.gains(), |tick, row, effort, state| {
            assert_eq!(state.mode() as u8, row.mode, "{name}: state in tick {tick}");
            let off = (effort - row.effort).abs();
            worst = worst.max(off);
            assert!(off <= tolerance, "{name}: {effort}, not {} in tick {tick}", row.effort);
            let held = state.hold_effort();
            assert!((held - row.hold_effort).abs() <= 1e-6, "{name}: u_b {held} in tick {tick}");
            let gain = state.gain();
            assert!((gain - row.gain).abs() <= 1e-6, "{name}: g {gain} in tick {tick}");
        });
        println!("{name}: {:.1e} F_hi", worst / trace.header.number("Fhi") as f32);
    }
}

/// These change what the law does only where a joint has answered it: in the traces of a joint that
/// springs back, and of one that swings.
#[test]
fn stop_band_hold_step_and_least_gain_change_what_the_law_does() {
    let traces = traces();
    let changed = |name: &str, change: fn(&mut RobustGains)| {
        let trace = traces.iter().find(|trace| trace.header.name == name).unwrap();
        let (stated, mut gains) = (trace.header.gains(), trace.header.gains());
        change(&mut gains);
        let [before, after] = [stated, gains].map(|gains| {
            let mut efforts = Vec::new();
            trace.replay(&gains, |_, _, effort, _| efforts.push(effort));
            efforts
        });
        before != after
    };
    assert!(changed("LuGre, J configured / 3", |gains| gains.stop_band = 2.25));
    assert!(changed("LuGre, J configured / 3", |gains| gains.hold_step = 0.2));
    let swings = "flexible hard joint at 5 ms, [F] configured x 3";
    assert!(changed(swings, |gains| gains.least_gain = 0.3));
}

/// The main transitions, each seen in the modes of the traces, as often as they are.
#[test]
fn traces_pass_through_every_transition_between_modes() {
    let mut seen = std::collections::BTreeSet::new();
    for trace in traces() {
        let mut before = 0;
        trace.replay(&trace.header.gains(), |_, _, _, state| {
            let mode = state.mode() as u8;
            if mode != before {
                seen.insert((before, mode));
            }
            before = mode;
        });
    }
    let [moving, stuck, pulse, coast, hold] = [0, 1, 2, 3, 4];
    for transition in [
        (moving, stuck),
        (moving, pulse),
        (moving, coast),
        (stuck, pulse),
        (stuck, coast),
        (stuck, hold),
        (pulse, coast),
        (coast, stuck),
        // Lost, or a new motion.
        (stuck, moving),
        (pulse, moving),
        (coast, moving),
        (hold, moving),
        (hold, stuck),
    ] {
        assert!(seen.contains(&transition), "{transition:?} of {seen:?}");
    }
}
