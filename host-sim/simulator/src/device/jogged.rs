//! Result of a jog, as text and as JSON.

use serde_json::{Value, json};
use stiction::Parameters;
use stiction::control::encoder::Direction;
use stiction::motion::jog::{JogEnd, JogFindings, Verdict, Way};

use files::written::single;

/// Returns the verdict of a jog as half a sentence.
pub const fn headline(verdict: Verdict) -> &'static str {
    match verdict {
        Verdict::Agrees => "the encoder counts in the sense of the effort, as it should",
        Verdict::Reversed => "the encoder counts AGAINST the effort: a closed loop would run away",
        Verdict::Pulled => "the joint moved the same way under both efforts: a load moves it",
        Verdict::RunsOn => "the joint moved on without effort after the first push",
        Verdict::Still => "nothing moved, as far as the encoder shows",
        Verdict::Noise => "the encoder counts to and fro, but does not follow a motion",
    }
}

/// Returns the direction that a reversed encoder must be set to.
const fn other(parameters: &Parameters) -> &'static str {
    match parameters.controller.encoder.direction {
        Direction::Forward => "reverse",
        Direction::Reverse => "forward",
    }
}

/// Returns the next steps, one per line.
fn advice(verdict: Verdict, found: &JogFindings, parameters: &Parameters) -> Vec<String> {
    let bound = found.ways.iter().map(|way| way.effort).fold(0.0, f32::max);
    let lines: &[&str] = match verdict {
        Verdict::Agrees => &[
            "next: `identify` the friction. The direction of the first motion is positive.",
            "To reverse it: power off, swap the motor's two wires, change `encoder.direction`,",
            "and jog again.",
        ],
        Verdict::Reversed => {
            return vec![
                "do not arm it like this. In the machine's file, in [encoder], set".into(),
                format!("    direction = \"{}\"", other(parameters)),
                "send it with `params push FILE.toml`, and jog again. The direction of the".into(),
                "first motion is positive. (To make it negative, swap the motor's two wires".into(),
                "instead, with the power off.)".into(),
            ];
        }
        Verdict::Pulled => &[
            "take the load off the joint (gravity, a spring, a hand), and jog again: do not",
            "trust a direction that was found under this load.",
        ],
        Verdict::RunsOn => &[
            "nothing holds the joint without effort: little friction, or a load. Take the load",
            "off, or brake the joint lightly with the hand, and jog again.",
        ],
        Verdict::Still => {
            return vec![
                format!("the effort rose to {bound:.3} V. Check, in this order: bridge power;"),
                "the enable wire (PB0); motor wires; brake; supply and wires of the encoder".into(),
                "(turn the joint by hand: the position in `status` must follow). If all are".into(),
                "sound, the joint needs more effort or more time: raise `jog.effort_v` in the"
                    .into(),
                "machine's file by a half, push it, and jog again; or jog with half the".into(),
                "rate of the effort.".into(),
            ];
        }
        Verdict::Noise => &[
            "the joint may have moved. Check the encoder's wires: A or B is cut or shorted, or",
            "runs beside the motor's wires. Turn the joint by hand: the position in `status`",
            "must follow, both ways. Then jog again.",
        ],
    };
    lines.iter().map(|line| (*line).to_owned()).collect()
}

/// Returns the result of a jog as text, with the next steps.
pub fn words(found: &JogFindings, parameters: &Parameters) -> String {
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
        JogEnd::Not => return "not tried".into(),
        _ if way.effort == 0.0 => {
            return format!(
                "not tried: the joint reached {} before it was at rest",
                words_of(way.ended)
            );
        }
        JogEnd::Moved => "enough for a verdict",
        JogEnd::Effort => "effort limit reached",
        JogEnd::Travel => "travel limit reached",
        JogEnd::Speed => "speed limit reached",
        JogEnd::Time => "time limit reached",
    };
    format!("up to {:.3} V: {:+} counts ({deg:+.4} deg), {why}", way.effort, way.moved)
}

const fn words_of(ended: JogEnd) -> &'static str {
    match ended {
        JogEnd::Travel => "its travel limit",
        JogEnd::Speed => "its speed limit",
        JogEnd::Time => "its time limit",
        JogEnd::Not | JogEnd::Moved | JogEnd::Effort => "the end",
    }
}

/// Returns the JSON object for scripts.
pub fn json(found: &JogFindings, parameters: &Parameters, warning: Option<&str>) -> Value {
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
            JogEnd::Not => "not-tried",
            JogEnd::Moved => "moved",
            JogEnd::Effort => "effort",
            JogEnd::Travel => "travel",
            JogEnd::Speed => "speed",
            JogEnd::Time => "time",
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
