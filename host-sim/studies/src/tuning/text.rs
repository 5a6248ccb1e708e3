//! What tuning has found, as a new file, as a table and as JSON.

use serde_json::{Value, json};
use toml_edit::{DocumentMut, value};

use super::{Figures, Tuned};
use crate::error::{Error, rounded};
use crate::output::table;

/// Writes the gains into the text of a file, of which everything else stays, comments included.
///
/// # Errors
/// If the text is no TOML.
pub fn rewritten(text: &str, tuned: &[Tuned]) -> Result<String, Error> {
    let mut document: DocumentMut =
        text.parse().map_err(|error| Error::Input(format!("the file: {error}")))?;
    for Tuned { controller, gains, better, .. } in tuned {
        for gain in gains.iter().filter(|_| *better) {
            let item = &mut document["controller"][controller.as_str()][gain.key];
            let decor = item.as_value().map(|value| value.decor().clone());
            *item = value(gain.to);
            if let (Some(decor), Some(value)) = (decor, item.as_value_mut()) {
                *value.decor_mut() = decor;
            }
        }
    }
    Ok(document.to_string())
}

/// Renders what was found for people, within 80 columns.
pub fn render(tuned: &[Tuned]) -> String {
    let mut text = String::new();
    for one in tuned {
        let Tuned { controller, gains, better, before, after, tried, margins, worst } = one;
        let verdict =
            if *better { "tuned" } else { "nothing better was found: the file's gains stay" };
        text += &format!("{controller}: {verdict} ({} sets of gains)\n", tried.len());
        for gain in gains.iter().filter(|_| *better) {
            text += &format!("  {:28} {} -> {}\n", gain.key, rounded(gain.from), rounded(gain.to));
        }
        let mut figures = table::new(&[
            "",
            "success\n%",
            "settled\ns",
            "tracking\ncounts",
            "rest\ncounts",
            "chatter\nV/s",
            "held\nV",
        ]);
        let mut add = |name: &str, row: &Figures| {
            let success = 100.0 * row.successes as f64 / row.cases.max(1) as f64;
            figures.add_row([
                name.to_owned(),
                table::number(Some(success), 1),
                table::number(Some(row.settling_s), 3),
                table::number(row.tracking_counts.filter(|counts| counts.is_finite()), 2),
                table::number(Some(row.rest_counts), 2),
                table::number(Some(row.chatter_v_per_s), 2),
                table::number(Some(row.held_v), 3),
            ]);
        };
        add("before", before);
        if *better {
            add("after", after);
        }
        text += &format!("{}\n", figures.trim_fmt());
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
                .settled_s
                .map_or_else(|| "never settles".into(), |s| format!("settles in {} s", rounded(s)));
            let fault = row.faults().next().map(|name| format!(", {name}")).unwrap_or_default();
            text += &format!(
                "  worst joint: {settled}, rests {} counts off{fault}; delay {delay}\n",
                rounded(row.rest_counts)
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

/// What was found, as one JSON object.
pub fn object(file: &str, tuned: &[Tuned]) -> Value {
    let figures = |of: &Figures| {
        json!({
            "cases": of.cases,
            "successes": of.successes,
            "settling_s": of.settling_s,
            "tracking_counts": of.tracking_counts.filter(|counts| counts.is_finite()),
            "rest_counts": of.rest_counts,
            "chatter_v_per_s": of.chatter_v_per_s,
            "held_v": of.held_v,
        })
    };
    let one = |tuned: &Tuned| {
        let gains: serde_json::Map<String, Value> = tuned
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
                "fault": row.faults().next(),
            })
        });
        let body = json!({
            "better": tuned.better,
            "gains": gains,
            "before": figures(&tuned.before),
            "after": figures(&tuned.after),
            "tried": tuned.tried.len(),
            "gain_margins": tuned.margins,
            "worst": worst,
        });
        (tuned.controller.clone(), body)
    };
    let controllers: serde_json::Map<String, Value> = tuned.iter().map(one).collect();
    json!({"schema": 1, "file": file, "controllers": controllers})
}

#[cfg(test)]
mod tests {
    use super::super::Turned;
    use super::*;

    #[test]
    fn a_new_file_has_the_new_gains_and_keeps_the_rest() {
        let figures = Figures {
            cases: 1,
            successes: 1,
            settling_s: 1.0,
            tracking_counts: None,
            rest_counts: 1.0,
            chatter_v_per_s: 0.0,
            held_v: 0.0,
        };
        let tuned = Tuned {
            controller: "pd".into(),
            gains: vec![
                Turned { key: "kp_v_per_deg", from: 1.0, to: 2.5 },
                Turned { key: "bandwidth_rad_per_s", from: 50.0, to: 60.0 },
            ],
            better: true,
            before: figures,
            after: figures,
            tried: vec![figures],
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
        let kept = Tuned { better: false, ..tuned };
        assert_eq!(rewritten(text, &[kept]).unwrap(), text);
    }
}
