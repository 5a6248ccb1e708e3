//! Result of a jog, as text and as JSON.

use serde_json::{Map, Value, json};
use stiction::Parameters;
use stiction::control::encoder::Direction;
use stiction::motion::jog::{JogEnd, JogFindings, Verdict, Way};

use files::written::single;

/// Returns whether all encoders count in the sense of the effort, and two agree about the way.
pub fn is_right(found: &JogFindings, parameters: &Parameters) -> bool {
    found.agrees() && wrong_ratio(found, parameters).is_none()
}

/// Returns the verdict of a jog as half a sentence.
pub fn headline(found: &JogFindings, parameters: &Parameters) -> &'static str {
    if wrong_ratio(found, parameters).is_some() {
        return "both encoders count in the sense of the effort, but not by the same angle";
    }
    match (found.verdict(), found.motor_verdict()) {
        (verdict, None) => of_one(verdict),
        (Verdict::Agrees, Some(Verdict::Agrees)) => {
            "both encoders count in the sense of the effort, as they should"
        }
        (Verdict::Reversed, Some(Verdict::Reversed)) => {
            "both encoders count AGAINST the effort: a closed loop would run away"
        }
        (Verdict::Reversed, Some(Verdict::Agrees)) => {
            "the load's encoder counts AGAINST the effort: a closed loop would run away"
        }
        (Verdict::Agrees, Some(Verdict::Reversed)) => {
            "the motor's encoder counts AGAINST the effort: a closed loop would run away"
        }
        (
            Verdict::Still | Verdict::Noise,
            Some(Verdict::Agrees | Verdict::Reversed | Verdict::RunsOn),
        ) => "the motor turned, but the load's encoder does not follow it",
        (Verdict::Agrees | Verdict::Reversed, Some(_)) => {
            "the load moved, but the motor's encoder does not follow it"
        }
        (verdict, Some(_)) => of_one(verdict),
    }
}

/// Returns the verdict on one encoder as half a sentence.
const fn of_one(verdict: Verdict) -> &'static str {
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
const fn other(direction: Direction) -> &'static str {
    match direction {
        Direction::Forward => "reverse",
        Direction::Reverse => "forward",
    }
}

/// Returns the keys of a machine's file that set the directions of the encoders that a jog has
/// found reversed, with their values. `encoder` is that of the motor if there are two.
fn reversed(found: &JogFindings, parameters: &Parameters) -> Vec<(&'static str, &'static str)> {
    let position = other(parameters.controller.encoder.direction);
    let is_reversed = |verdict| verdict == Verdict::Reversed;
    match found.motor_verdict() {
        None if is_reversed(found.verdict()) => vec![("encoder.direction", position)],
        None => vec![],
        Some(of_motor) => {
            let motor = other(parameters.controller.motor.direction);
            let keys = [
                (is_reversed(of_motor), "encoder.direction", motor),
                (is_reversed(found.verdict()), "load_encoder.direction", position),
            ];
            keys.into_iter().filter(|key| key.0).map(|(_, key, set)| (key, set)).collect()
        }
    }
}

/// Returns what is wrong with the ratio of two encoders, if the jog shows that: both sides agree,
/// and the twist between them is larger than the gear allows.
fn wrong_ratio(found: &JogFindings, parameters: &Parameters) -> Option<String> {
    let (motor, count) = (parameters.controller.motor, parameters.controller.encoder.resolution);
    if !found.agrees() || motor.twist == 0.0 {
        return None;
    }
    found.ways.iter().find_map(|way| {
        let [load_deg, motor_deg] =
            [way.moved as f32 * count, way.motor_moved? as f32 * motor.count];
        let twist_deg = (motor_deg - load_deg).abs();
        (twist_deg > motor.twist).then(|| {
            format!(
                "the motor's encoder shows {motor_deg:+.3} deg of the joint and the load's \
                 {load_deg:+.3} deg: more apart than the {:.3} deg that the gear allows",
                motor.twist
            )
        })
    })
}

/// Returns the next steps after a jog of a joint with two encoders that differ, one per line; none
/// if the verdict is that on the load alone.
fn advice_on_two(found: &JogFindings, parameters: &Parameters) -> Option<Vec<String>> {
    let of_motor = found.motor_verdict()?;
    let lines: &[&str] = match (found.verdict(), of_motor) {
        (Verdict::Agrees | Verdict::Reversed, Verdict::Agrees | Verdict::Reversed) => {
            let keys = reversed(found, parameters);
            if keys.is_empty() {
                let why = wrong_ratio(found, parameters)?;
                return Some(vec![
                    why + ".",
                    "Check `gear.ratio`, `encoder.lines` and `load_encoder.counts_per_turn`, and"
                        .into(),
                    "the slack and stiffness of the gear, send them, and jog again.".into(),
                ]);
            }
            let mut lines = vec!["do not arm it like this. In the machine's file, set".to_owned()];
            lines.extend(keys.iter().map(|(key, value)| format!("    {key} = \"{value}\"")));
            lines.extend([
                "send it with `params push FILE.toml`, and jog again.".into(),
                "(If both are reversed, swapping the motor's two wires does the same.)".into(),
            ]);
            return Some(lines);
        }
        (
            Verdict::Still | Verdict::Noise,
            Verdict::Agrees | Verdict::Reversed | Verdict::RunsOn,
        ) => &[
            "do not arm it like this. Check supply and wires of the load's encoder (PB6 and",
            "PB7), what couples it to the joint, and the gear: turn the load by hand, and the",
            "position in `status` must follow. Then jog again.",
        ],
        (Verdict::Agrees | Verdict::Reversed, _) => &[
            "do not arm it like this. Check supply and wires of the motor's encoder (PA0 and",
            "PA1), and what couples it to the motor. Then jog again.",
        ],
        _ => return None,
    };
    Some(lines.iter().map(|line| (*line).to_owned()).collect())
}

/// Returns the next steps, one per line.
fn advice(verdict: Verdict, found: &JogFindings, parameters: &Parameters) -> Vec<String> {
    if let Some(lines) = advice_on_two(found, parameters) {
        return lines;
    }
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
                format!("    direction = \"{}\"", other(parameters.controller.encoder.direction)),
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
    let counts = [parameters.controller.encoder.resolution, parameters.controller.motor.count];
    let mut lines = vec![
        format!("jog        {}", headline(found, parameters)),
        format!("effort +   {}", way(first, counts)),
        format!("effort -   {}", way(second, counts)),
    ];
    lines.extend(
        advice(verdict, found, parameters).into_iter().map(|line| format!("           {line}")),
    );
    lines.join("\n") + "\n"
}

/// Returns one way as text, with the angles of a count of both encoders, deg.
fn way(way: &Way, counts: [f32; 2]) -> String {
    let deg = f64::from(way.moved) * f64::from(counts[0]);
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
    let mut motor = String::new();
    if let Some(moved) = way.motor_moved {
        let deg = f64::from(moved) * f64::from(counts[1]);
        motor = format!("\n           motor {moved:+} counts ({deg:+.4} deg)");
    }
    format!("up to {:.3} V: {:+} counts ({deg:+.4} deg), {why}{motor}", way.effort, way.moved)
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
    let name = |verdict| match verdict {
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
            "motor_moved_counts": way.motor_moved,
            "ended_by": ended,
        })
    });
    let keys = reversed(found, parameters);
    let set: Option<Map<String, Value>> = (!keys.is_empty())
        .then(|| keys.into_iter().map(|(key, value)| (key.to_owned(), value.into())).collect());
    json!({
        "schema": 1,
        "warning": warning,
        "verdict": name(found.verdict()),
        "motor_verdict": found.motor_verdict().map(name),
        "wrong_ratio": wrong_ratio(found, parameters),
        "set": set,
        "positive": ways.clone().next(),
        "negative": ways.clone().nth(1),
    })
}
