//! Traces of what the law does beyond its prototype, which is off in the golden traces: the slower
//! observer with the encoder on the load, friction that a slow loop learns at low speeds only, the
//! load rule, and giving up.
//!
//! No second version stands behind these. They are what the law gave when they were written, so
//! they show an unintended change, not a mistake; the closed loops beside them
//! judge what the joint does. `STICTION_TRACES=write cargo test -p stiction --test robust` writes
//! them anew.

use std::fmt::Write;
use std::fs;
use std::path::Path;

use stiction::control::laws::RobustGains;
use stiction::control::laws::robust::{EncoderSide, RobustState};
use stiction::units::value::Table;

use super::golden::traces;
use super::joint::{ClosedLoop, Joint, configured};

/// Ticks between two rows; a tick in which the mode changes has a row of its own.
const EVERY: usize = 20;

/// What the law gives along a trace.
#[derive(Default)]
struct Written {
    text: String,
    ticks: usize,
    mode: u8,
}

impl Written {
    fn see(&mut self, effort: f32, state: &RobustState) {
        let mode = state.mode() as u8;
        if mode != self.mode || self.ticks.is_multiple_of(EVERY) {
            let (tick, held, gain) = (self.ticks, state.hold_effort(), state.gain());
            writeln!(self.text, "{tick},{mode},{effort},{held},{gain}").unwrap();
        }
        (self.ticks, self.mode) = (self.ticks + 1, mode);
    }
}

/// The counts and references of the golden traces, and the law as its rules make it today: in those
/// in which it then does something else.
fn along_golden_traces(all: &mut String) -> usize {
    let mut others = 0;
    for trace in traces() {
        let of = |gains: &RobustGains| {
            let mut written = Written::default();
            trace.replay(gains, |_, _, effort, state| written.see(effort, state));
            written.text
        };
        let prototype = trace.header.gains();
        let attempts = RobustGains::EXAMPLE.attempts;
        let today = RobustGains { attempts, observer: 0.0, learned_to: 0.0, ..prototype };
        let text = of(&today);
        if text != of(&prototype) {
            others += 1;
            writeln!(all, "# {}\n{text}", trace.header.name).unwrap();
        }
    }
    others
}

fn in_closed_loops(all: &mut String) {
    let held = RobustGains { load: 36.0, ..configured() };
    let on_load = RobustGains { encoder_side: EncoderSide::Load, ..configured() };
    let loaded = Joint { load: 10.0, ..Joint::new(4.0, 3.0) };
    let walled = Joint { wall: 4.982, ..Joint::new(4.0, 2.5) };
    let cases = [
        ("a load of 2.5 times the static friction, configured, which then grows", loaded, held),
        ("a wall five counts before the target", walled, configured()),
        ("the encoder on the load of a stiff joint", Joint::new(4.0, 2.5), on_load),
    ];
    for (name, joint, gains) in cases {
        let mut run = ClosedLoop::new(joint, &gains);
        let mut written = Written::default();
        run.run(5.0, 2.0, |run| written.see(run.applied, &run.state));
        run.joint.load *= 1.8;
        run.run(3.0, 2.0, |run| written.see(run.applied, &run.state));
        writeln!(all, "# {name}\n{}", written.text).unwrap();
    }
}

#[test]
fn what_is_beyond_the_prototype_is_as_it_was_written_down() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/robust/beyond.csv");
    let mut all = String::from("# tick, mode, effort, hold effort, gain of the guard\n\n");
    let others = along_golden_traces(&mut all);
    in_closed_loops(&mut all);
    // With the encoder on the load, and in slow loops.
    assert!(others >= 8, "{others} of the golden traces are passed through otherwise");
    for mode in ["GIVE_UP 5", "HOLD 4", "COAST 3", "PULSE 2", "STUCK 1"] {
        let number = mode.split(' ').next_back().unwrap();
        let is_seen = all.lines().any(|line| line.split(',').nth(1) == Some(number));
        assert!(is_seen, "{mode} is not seen");
    }
    if std::env::var("STICTION_TRACES").is_ok_and(|how| how == "write") {
        fs::write(&path, &all).unwrap();
    }
    let kept = fs::read_to_string(&path).unwrap_or_default();
    let changed = kept.lines().zip(all.lines()).find(|(kept, now)| kept != now);
    assert_eq!(changed, None, "as it was, and as it is; renew it with STICTION_TRACES=write");
    assert_eq!(kept.lines().count(), all.lines().count());
}
