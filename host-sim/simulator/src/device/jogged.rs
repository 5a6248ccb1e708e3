//! What a jog has found, for a person and for a script.

use serde_json::{Value, json};
use stiction::Parameters;
use stiction::control::encoder::Direction;
use stiction::motion::jog::{Ended, Found, Verdict, Way};

use crate::written::single;

/// Says in half a sentence what a jog has shown.
pub const fn headline(verdict: Verdict) -> &'static str {
    match verdict {
        Verdict::Agrees => "the encoder counts in the sense of the effort, as it should",
        Verdict::Reversed => "the encoder counts AGAINST the effort: a closed loop would run away",
        Verdict::Pulled => "the joint moved the same way under both efforts: a load moves it",
        Verdict::RunsOn => "the joint went on by itself after the first push",
        Verdict::Still => "nothing moved, as far as the encoder shows",
        Verdict::Noise => "the encoder counts to and fro, but does not follow a motion",
    }
}

/// The other direction, which a reversed encoder has to be set to.
const fn other(parameters: &Parameters) -> &'static str {
    match parameters.controller.encoder.direction {
        Direction::Forward => "reverse",
        Direction::Reverse => "forward",
    }
}

/// Says what to do now, a line each.
fn advice(verdict: Verdict, found: &Found, parameters: &Parameters) -> Vec<String> {
    let bound = found.ways.iter().map(|way| way.effort).fold(0.0, f32::max);
    let lines: &[&str] = match verdict {
        Verdict::Agrees => &[
            "next: `identify` the friction. The way that the joint went first is positive.",
            "If you want it the other way: power off, swap the motor's two wires, turn",
            "`encoder.direction` around, and jog again.",
        ],
        Verdict::Reversed => {
            return vec![
                "do not arm it like this. In the machine's file, in [encoder], set".into(),
                format!("    direction = \"{}\"", other(parameters)),
                "send it with `params push FILE.toml`, and jog again. The way that the joint"
                    .into(),
                "went first is the positive one. (To swap the motor's two wires, with the".into(),
                "power off, does the same with the positive sense the other way around.)".into(),
            ];
        }
        Verdict::Pulled => &[
            "take the load off the joint (gravity, a spring, a hand), and jog again: a",
            "direction that is found under this load is not to be trusted.",
        ],
        Verdict::RunsOn => &[
            "nothing holds the joint without effort: little friction, or a load. Take the load",
            "off, or brake the joint lightly with the hand, and jog again.",
        ],
        Verdict::Still => {
            return vec![
                format!(
                    "the effort went up to {bound:.3} V. Look at, in this order: bridge power;"
                ),
                "the enable wire (PB0); motor wires; brake; supply and wires of the encoder".into(),
                "(turn the joint by hand: the position in `status` has to follow). If all is"
                    .into(),
                "sound, the joint needs more effort or more time: raise `jog.effort_v` in the"
                    .into(),
                "machine's file by a half, push it, and jog again; or jog with half the".into(),
                "`--rate`.".into(),
            ];
        }
        Verdict::Noise => &[
            "the joint may have moved. Look at the encoder's wires: one of A and B is cut or",
            "shorted, or lies beside the motor's. Turn the joint by hand: the position in",
            "`status` has to follow, both ways. Then jog again.",
        ],
    };
    lines.iter().map(|line| (*line).to_owned()).collect()
}

/// Writes what a jog has found, and what to do.
pub fn words(found: &Found, parameters: &Parameters) -> String {
    let verdict = found.verdict();
    let [first, second] = &found.ways;
    let resolution = parameters.controller.encoder.resolution;
    let mut lines = vec![
        format!("jog        {}", headline(verdict)),
        format!("effort +   {}", way(first, resolution)),
        format!("effort -   {}", way(second, resolution)),
    ];
    lines.extend(
        advice(verdict, found, parameters).into_iter().map(|line| format!("           {line}")),
    );
    lines.join("\n") + "\n"
}

fn way(way: &Way, resolution: f32) -> String {
    let deg = f64::from(way.moved) * f64::from(resolution);
    let why = match way.ended {
        Ended::Not => return "not tried".into(),
        _ if way.effort == 0.0 => {
            return format!(
                "not tried: the joint came to {} before it rested",
                words_of(way.ended)
            );
        }
        Ended::Moved => "enough to tell",
        Ended::Effort => "no more effort is allowed",
        Ended::Travel => "as far as it may go",
        Ended::Speed => "as fast as it may go",
        Ended::Time => "the time was over",
    };
    format!("up to {:.3} V: {:+} counts ({deg:+.4} deg), {why}", way.effort, way.moved)
}

const fn words_of(ended: Ended) -> &'static str {
    match ended {
        Ended::Travel => "its travel bound",
        Ended::Speed => "its speed bound",
        Ended::Time => "the end of its time",
        Ended::Not | Ended::Moved | Ended::Effort => "the end",
    }
}

/// Makes the object for a script.
pub fn json(found: &Found, parameters: &Parameters, warning: Option<&str>) -> Value {
    let verdict = found.verdict();
    let name = match verdict {
        Verdict::Agrees => "agrees",
        Verdict::Reversed => "reversed",
        Verdict::Pulled => "pulled",
        Verdict::RunsOn => "runs-on",
        Verdict::Still => "still",
        Verdict::Noise => "noise",
    };
    let resolution = parameters.controller.encoder.resolution;
    let ways = found.ways.iter().map(|way| {
        let ended = match way.ended {
            Ended::Not => "not-tried",
            Ended::Moved => "moved",
            Ended::Effort => "effort",
            Ended::Travel => "travel",
            Ended::Speed => "speed",
            Ended::Time => "time",
        };
        json!({
            "effort_v": single(way.effort),
            "moved_counts": way.moved,
            "moved_deg": f64::from(way.moved) * f64::from(resolution),
            "counted": way.counted,
            "ended_by": ended,
        })
    });
    let set =
        (verdict == Verdict::Reversed).then(|| json!({ "encoder.direction": other(parameters) }));
    json!({
        "schema": 1,
        "warning": warning,
        "verdict": name,
        "set": set,
        "positive": ways.clone().next(),
        "negative": ways.clone().nth(1),
    })
}
