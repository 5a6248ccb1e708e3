//! Result of a tuning, as a new file, as a table and as JSON.

use serde_json::{Map, Value, json};
use toml_edit::DocumentMut;

use super::{SideFigures, TuningFigures, TuningResult};
use files::error::{Error, rounded};
use files::file_text::put_number;
use simulator::output::grid;

/// Returns the text of a file with the new gains. Everything else stays, comments included.
///
/// # Errors
/// Returns an error if the text is not TOML.
pub fn rewritten(text: &str, tuned: &[TuningResult]) -> Result<String, Error> {
    let mut document: DocumentMut =
        text.parse().map_err(|error| Error::Input(format!("the file: {error}")))?;
    for TuningResult { controller, gains, better, .. } in tuned {
        for gain in gains.iter().filter(|_| *better) {
            put_number(&mut document, &["controller", controller], gain.key, gain.to);
        }
    }
    Ok(document.to_string())
}

/// Returns the results as text within 80 columns.
pub fn render(tuned: &[TuningResult]) -> String {
    let mut text = String::new();
    for one in tuned {
        let TuningResult {
            controller, gains, better, before, after, tried, margins, worst, ..
        } = one;
        let verdict = match &one.refusal {
            None => format!("tuned ({} sets of gains)", tried.len()),
            Some(why) => {
                let what =
                    if one.is_refused() { "no gains were found" } else { "the file's gains stay" };
                format!("{what} ({} sets of gains)\n{}", tried.len(), wrapped(why))
            }
        };
        text += &format!("{controller}: {verdict}\n");
        for gain in gains.iter().filter(|_| *better) {
            text += &format!("  {:28} {} -> {}\n", gain.key, rounded(gain.from), rounded(gain.to));
        }
        text += &format!("{}\n", figures(before, better.then_some(after)));
        let [least, most] = margins;
        if least < most {
            text += &format!(
                "  with a sample of delay it succeeds from {} to {} times the joint's gain\n",
                rounded(*least),
                rounded(*most)
            );
        }
        if let Some((drawn, delay, row)) = worst {
            let settled = row
                .settled_at_encoder_s
                .map_or_else(|| "never settles".into(), |s| format!("settles in {} s", rounded(s)));
            let fault = row.faults().next().map(|name| format!(", {name}")).unwrap_or_default();
            let at_load = if row.rest_at_load_counts == row.rest_at_encoder_counts {
                String::new()
            } else {
                let counts = rounded(row.rest_at_load_counts);
                format!(" at the encoder, {counts} at the load")
            };
            text += &format!(
                "  worst joint: {settled}, rests {} counts off{at_load}{fault}; delay {delay}\n",
                rounded(row.rest_at_encoder_counts)
            );
            for key in drawn {
                let (key, value) = key.split_once('=').unwrap_or((key, ""));
                let value = value.parse().map_or_else(|_| value.into(), rounded);
                text += &format!("    {key} = {value}\n");
            }
        }
        text.push('\n');
    }
    text
}

/// Wraps a sentence into lines of up to 80 columns, two spaces in.
fn wrapped(sentence: &str) -> String {
    let mut lines = vec![String::from(" ")];
    for word in sentence.split_whitespace() {
        match lines.last_mut() {
            Some(line) if line.chars().count() + 1 + word.chars().count() <= 80 => {
                *line += " ";
                *line += word;
            }
            _ => lines.push(format!("  {word}")),
        }
    }
    lines.join("\n")
}

/// Returns a table of the figures before and after, with both sides of the gear if they differ.
fn figures(before: &TuningFigures, after: Option<&TuningFigures>) -> String {
    let mut table = grid::new(&[
        "",
        "success\n%",
        "settled\ns",
        "tracking\ncounts",
        "rest\ncounts",
        "chatter\nV/s",
        "held\nV",
    ]);
    let is_two_sided = before.is_two_sided() || after.is_some_and(TuningFigures::is_two_sided);
    let mut add = |name: String, of: &TuningFigures, side: &SideFigures| {
        let success = 100.0 * side.successes as f64 / of.cases.max(1) as f64;
        table.add_row([
            name,
            grid::number(Some(success), 1),
            grid::number(Some(side.settling_s), 3),
            grid::number(side.tracking_counts.filter(|counts| counts.is_finite()), 2),
            grid::number(Some(side.rest_counts), 2),
            grid::number(Some(of.chatter_v_per_s), 2),
            grid::number(Some(of.held_v), 3),
        ]);
    };
    for (name, of) in [("before", Some(before)), ("after", after)] {
        let Some(of) = of else { continue };
        if is_two_sided {
            add(format!("{name}, at the encoder"), of, &of.at_encoder);
            add(format!("{name}, at the load"), of, &of.at_load);
        } else {
            add(name.into(), of, &of.at_encoder);
        }
    }
    table.trim_fmt()
}

/// Returns the figures as JSON. Keys that name no side have the values at the load.
fn figures_object(of: &TuningFigures) -> Value {
    let mut object = Map::new();
    let mut put = |key: String, value: Value| object.insert(key, value);
    let share = |successes: usize| successes as f64 / of.cases.max(1) as f64;
    let finite = |counts: Option<f64>| json!(counts.filter(|counts| counts.is_finite()));
    let load = &of.at_load;
    put("cases".into(), json!(of.cases));
    put("successes".into(), json!(load.successes));
    put("settling_s".into(), json!(load.settling_s));
    put("tracking_counts".into(), finite(load.tracking_counts));
    put("rest_counts".into(), json!(load.rest_counts));
    put("chatter_v_per_s".into(), json!(of.chatter_v_per_s));
    put("held_v".into(), json!(of.held_v));
    for (name, side) in [("encoder", &of.at_encoder), ("load", load)] {
        put(format!("success_at_{name}"), json!(share(side.successes)));
        put(format!("successes_at_{name}"), json!(side.successes));
        put(format!("settled_at_{name}_s"), json!(side.settling_s));
        put(format!("tracking_at_{name}_counts"), finite(side.tracking_counts));
        put(format!("rest_at_{name}_counts"), json!(side.rest_counts));
    }
    Value::Object(object)
}

/// Returns the results as one JSON object.
pub fn object(file: &str, tuned: &[TuningResult]) -> Value {
    let one = |tuned: &TuningResult| {
        let gains: Map<String, Value> = tuned
            .gains
            .iter()
            .map(|gain| (gain.key.to_owned(), json!({"from": gain.from, "to": gain.to})))
            .collect();
        let worst = tuned.worst.as_ref().map(|(drawn, delay, row)| {
            json!({
                "drawn": drawn,
                "delay_samples": delay,
                "settled_s": row.settled_s,
                "rest_counts": row.rest_counts,
                "settled_at_encoder_s": row.settled_at_encoder_s,
                "settled_at_load_s": row.settled_at_load_s,
                "rest_at_encoder_counts": row.rest_at_encoder_counts,
                "rest_at_load_counts": row.rest_at_load_counts,
                "fault": row.faults().next(),
            })
        });
        let body = json!({
            "outcome": outcome(std::slice::from_ref(tuned)),
            "reason": tuned.refusal,
            "better": tuned.better,
            "gains": gains,
            "before": figures_object(&tuned.before),
            "after": figures_object(&tuned.after),
            "tried": tuned.tried.len(),
            "gain_margins": tuned.margins,
            "worst": worst,
        });
        (tuned.controller.clone(), body)
    };
    let controllers: Map<String, Value> = tuned.iter().map(one).collect();
    json!({
        "schema": 1,
        "file": file,
        "outcome": outcome(tuned),
        "reason": reason(tuned),
        "controllers": controllers,
    })
}

/// Returns the best outcome among some controllers: `tuned`, `kept` or `refused`.
fn outcome(tuned: &[TuningResult]) -> &'static str {
    if tuned.iter().any(|one| one.better) {
        "tuned"
    } else if is_refused(tuned) {
        "refused"
    } else {
        "kept"
    }
}

/// Returns whether no joint succeeds under any controller, with the file's gains or with others.
pub fn is_refused(tuned: &[TuningResult]) -> bool {
    tuned.iter().all(TuningResult::is_refused)
}

/// Returns the reasons why the file's gains stay for all controllers; `None` if better gains were
/// found for one.
pub fn reason(tuned: &[TuningResult]) -> Option<String> {
    let all: Option<Vec<String>> = tuned
        .iter()
        .map(|one| Some(format!("{}: {}", one.controller, one.refusal.as_ref()?)))
        .collect();
    all.filter(|all| !all.is_empty()).map(|all| all.join("; "))
}

#[cfg(test)]
mod tests {
    use super::super::TunedGain;
    use super::*;

    #[test]
    fn a_long_reason_is_wrapped_and_loses_no_word() {
        let long = "one two three four five ".repeat(12);
        let text = wrapped(&long);
        assert!(text.lines().count() > 3 && text.lines().all(|line| line.len() <= 80), "{text}");
        assert!(text.lines().all(|line| line.starts_with("  ")), "{text}");
        assert!(text.split_whitespace().eq(long.split_whitespace()));
    }

    #[test]
    fn a_new_file_has_the_new_gains_and_keeps_the_rest() {
        let side =
            SideFigures { successes: 1, settling_s: 1.0, tracking_counts: None, rest_counts: 1.0 };
        let (at_encoder, at_load) = (side, SideFigures { rest_counts: 80.0, ..side });
        let figures =
            TuningFigures { cases: 1, at_encoder, at_load, chatter_v_per_s: 0.0, held_v: 0.0 };
        let tuned = TuningResult {
            controller: "pd".into(),
            gains: vec![
                TunedGain { key: "kp_v_per_deg", from: 1.0, to: 2.5 },
                TunedGain { key: "bandwidth_rad_per_s", from: 50.0, to: 60.0 },
            ],
            better: true,
            refusal: None,
            before: figures,
            after: figures,
            tried: vec![figures],
            kept: 0,
            margins: [1.0, 1.0],
            worst: None,
        };
        let text = "a = 1 # one\n\n[controller.pd]\nkp_v_per_deg = 1.0   # Table 17\n";
        let whole = rewritten(text, std::slice::from_ref(&tuned)).unwrap();
        assert_eq!(
            whole,
            "a = 1 # one\n\n[controller.pd]\nkp_v_per_deg = 2.5   # Table 17\n\
             bandwidth_rad_per_s = 60.0\n"
        );
        let whole = render(std::slice::from_ref(&tuned));
        assert!(whole.contains("after, at the encoder") && whole.contains("80.00"), "{whole}");
        assert!(whole.lines().all(|line| line.len() <= 80), "{whole}");
        let found = object("a.toml", std::slice::from_ref(&tuned));
        assert_eq!((&found["outcome"], &found["reason"]), (&json!("tuned"), &Value::Null));
        let refusal = Some("no gains can rest it".to_owned());
        let kept = TuningResult { better: false, refusal, ..tuned.clone() };
        assert_eq!(rewritten(text, std::slice::from_ref(&kept)).unwrap(), text);
        let whole = render(std::slice::from_ref(&kept));
        assert!(whole.contains("the file's gains stay") && whole.contains("rest it"), "{whole}");
        assert!(!whole.contains("after") && !whole.contains("->"), "{whole}");
        let found = object("a.toml", std::slice::from_ref(&kept));
        assert_eq!(found["outcome"], "kept");
        assert_eq!(found["reason"], "pd: no gains can rest it");
        let of = &found["controllers"]["pd"];
        assert_eq!(
            (&of["outcome"], &of["reason"]),
            (&json!("kept"), &json!("no gains can rest it"))
        );
        // Without a success before and after, nothing is kept either.
        let mut refused = kept.clone();
        refused.before.at_load.successes = 0;
        assert!(render(std::slice::from_ref(&refused)).contains("no gains were found"));
        assert_eq!(object("a.toml", std::slice::from_ref(&refused))["outcome"], "refused");
        assert_eq!(object("a.toml", &[kept.clone(), refused])["outcome"], "kept");
        assert_eq!(of["before"]["rest_at_encoder_counts"], 1.0);
        assert_eq!(
            (&of["before"]["rest_at_load_counts"], &of["before"]["rest_counts"]),
            (&json!(80.0), &json!(80.0))
        );
        // One of two is found: the file is written with it.
        let found = object("a.toml", &[kept, TuningResult { controller: "srnf".into(), ..tuned }]);
        assert_eq!((&found["outcome"], &found["reason"]), (&json!("tuned"), &Value::Null));
    }
}
