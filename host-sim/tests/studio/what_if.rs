//! What the studio predicts, and that a prediction moves nothing and keeps nothing alive.

use std::time::Duration;

use serde_json::{Value, json};

use super::clock::breath;
use super::page::{Page, Studio, Visit, arm, run, studio, studio_around, studio_without_a_file};
use super::{
    LINK_TIMEOUT_S, RESOLUTION, SLACK_S, TICK_S, armed_with_a_reader, is_on, ticks_on_after,
};

pub fn wish(way: &Value, laws: &[&str], values: &Value, cloud: u8) -> Value {
    let wish = json!({ "way": way, "laws": laws, "values": values, "cloud": cloud });
    json!({ "do": "predict", "wish": wish })
}

pub async fn predicted(page: &mut Page, part: &str, wish: Value) -> Value {
    page.send(&wish).await;
    let is_it = |event: &Value| {
        let is_part = event["part"] == part || event["part"] == "refused";
        event["event"] == "answer" || event["event"] == "predicted" && is_part
    };
    let event = page.until(is_it).await;
    assert_eq!(event["part"], part, "{event}");
    event["content"].clone()
}

pub fn numbers(curve: &Value, key: &str) -> Vec<f64> {
    let all = curve[key].as_array().unwrap_or_else(|| panic!("{curve}"));
    all.iter().map(|value| value.as_f64().unwrap()).collect()
}

/// Ticks of the set point and of the joint, deg, from the last one before the set point sets out.
fn from_the_begin(reference: &[f64], position: &[f64]) -> Vec<[f64; 2]> {
    let sets_out = reference.windows(2).position(|pair| pair[0] != pair[1]).unwrap();
    let pairs = reference.iter().zip(position).skip(sets_out);
    pairs.map(|(reference, position)| [*reference, *position]).collect()
}

#[test]
fn a_simulated_device_does_what_was_predicted_count_by_count() {
    foretold(|| studio(&[]), "srnf");
    // Its file has variants, and its law an observer.
    foretold(|| studio_around("untuned-joints", "robust", &[]), "robust");
}

/// The twin has the joint of the file as it stands, as the device has.
#[test]
fn a_variant_before_the_file_as_it_stands_is_no_joint_of_the_prediction() {
    let name = format!("stiction-studio-variant-{}.toml", std::process::id());
    let file = std::env::temp_dir().join(name);
    let text = std::fs::read_to_string("thesis/experiments/step-response.toml").unwrap();
    let (own, _) = text.split_once("[[variant]]").unwrap();
    // The variant sticks four times as much.
    let variants = "[[variant]]\nslug = \"sticky\"\n\
                    set = { \"joint.friction.stick_v\" = 1.6, \"joint.friction.slip_v\" = 1.5 }\n\
                    [[variant]]\nslug = \"\"\n";
    std::fs::write(&file, format!("{own}{variants}")).unwrap();
    let machine: &'static str = file.to_str().unwrap().to_owned().leak();
    foretold(|| studio_around(machine, "srnf", &[]), "srnf");
    run(async {
        let server = studio_around(machine, "srnf", &[]);
        let mut page = Visit::proper(&server).connect().await.unwrap();
        let knobs = page.event("what-if").await["knobs"].clone();
        let stick = knobs.as_array().unwrap().iter().find(|one| one["name"] == "stick_v").cloned();
        assert_eq!(stick.unwrap()["value"], 0.4);
    });
    std::fs::remove_file(&file).unwrap();
}

pub fn foretold(studio: impl FnOnce() -> Studio, law: &str) {
    run(async {
        let server = studio();
        let mut page = Page::open(&server).await;
        let way = json!({ "how": "move", "deg": 5.0 });
        let curves = predicted(&mut page, "laws", wish(&way, &[law], &json!({}), 0)).await;
        let foreseen = from_the_begin(
            &numbers(&curves[0], "reference_deg"),
            &numbers(&curves[0], "position_deg"),
        );
        page.done(arm()).await;
        // The twin waits out its soft start, too.
        page.watch(Duration::from_millis(1000)).await;
        page.done(json!({ "do": "move", "deg": 5.0 })).await;
        let event = page.motion().await;
        assert_eq!((&event["way"], &event["from_counts"]), (&way, &0.0.into()));
        page.watch(Duration::from_secs(4)).await;
        let on: Vec<bool> = page.signal("status").iter().map(is_on).collect();
        // The clock of the event is a tick shortly before the move.
        let lead = page.signal("reference_counts");
        let sets_out = lead.iter().zip(&on).position(|(to, on)| *on && *to != 0).unwrap();
        let since = i64::from(page.rows[sets_out].clock) - event["clock"].as_i64().unwrap();
        assert!((1..=(0.5 / TICK_S) as i64).contains(&since), "{since} ticks");
        let deg = |bits: Vec<u32>| -> Vec<f64> {
            let on_only = bits.iter().zip(&on).filter(|(_, on)| **on);
            on_only.map(|(bits, _)| f64::from(*bits as i32) * RESOLUTION).collect()
        };
        let measured =
            from_the_begin(&deg(page.signal("reference_counts")), &deg(page.signal("counts")));
        // The measured set point has whole counts here, and may set out a tick later for it.
        let lead = foreseen.iter().position(|[to, _]| *to >= RESOLUTION).unwrap() as i64
            - measured.iter().position(|[to, _]| *to >= RESOLUTION).unwrap() as i64;
        let ticks = measured.len().min(foreseen.len()) - lead.unsigned_abs() as usize;
        assert!(ticks as f64 > 3.0 / TICK_S, "{ticks}");
        for k in 0..ticks {
            let [there, here] =
                if lead > 0 { [k + lead as usize, k] } else { [k, k + -lead as usize] };
            let off = foreseen[there][1] - measured[here][1];
            assert!(off.abs() < 0.01 * RESOLUTION, "tick {k}: {off} deg");
        }
    });
}

#[test]
fn laws_stand_side_by_side_and_a_changed_joint_is_another_one() {
    run(async {
        let server = studio(&[]);
        let mut page = Page::open(&server).await;
        let way = json!({ "how": "step", "deg": 5.0 });
        let values = json!({});
        let curves = predicted(&mut page, "laws", wish(&way, &["srnf", "pd"], &values, 0)).await;
        // Section 3.3.2: PD rests up to 0.4 deg off; SRNF within 6 counts.
        let rest = |place: usize| curves[place]["rest_counts"].as_f64().unwrap();
        assert!(rest(0) <= 6.0 && rest(1) > 6.0 && rest(1) < 166.0, "{} {}", rest(0), rest(1));
        assert_eq!((&curves[0]["law"], &curves[1]["law"]), (&"srnf".into(), &"pd".into()));
        // A tenth of the friction leaves PD a tenth of the error.
        let less = json!({ "joint.friction.stick_v": 0.04, "joint.friction.slip_v": 0.038 });
        let slippery = predicted(&mut page, "laws", wish(&way, &["pd"], &less, 0)).await;
        assert!(slippery[0]["rest_counts"].as_f64().unwrap() < 17.0, "{slippery}");
        // Twice the gain of the loop halves the band in which friction holds it.
        let stiff = json!({ "controller.pd.kp_v_per_deg": 2.0, "inertia": 2.0 });
        let stiff = predicted(&mut page, "laws", wish(&way, &["pd"], &stiff, 0)).await;
        assert!(stiff[0]["rest_counts"].as_f64().unwrap() < 84.0, "{stiff}");
        // What no joint and no law can have is refused by name, and the other law goes on.
        for (path, goes_on) in
            [("joint.friction.slip_v", false), ("controller.pd.kp_v_per_deg", true)]
        {
            let wrong = json!({ path: if goes_on { -1.0 } else { 0.5 } });
            let laws = predicted(&mut page, "laws", wish(&way, &["pd", "srnf"], &wrong, 0)).await;
            let name = path.rsplit('.').next().unwrap();
            assert!(laws[0]["refused"].as_str().unwrap().contains(name), "{laws}");
            assert_eq!(laws[1]["refused"].is_null(), goes_on, "{laws}");
            assert_eq!(laws[1]["position_deg"].is_array(), goes_on, "{laws}");
        }
        let far = json!({ "how": "move", "deg": 1e300 });
        let refused = predicted(&mut page, "refused", wish(&far, &["pd"], &values, 0)).await;
        assert!(refused.as_str().unwrap().contains("2^30"), "{refused}");
    });
}

#[test]
fn the_cloud_has_its_worst_joint_picked_out() {
    run(async {
        let server = studio(&[]);
        let mut page = Page::open(&server).await;
        let way = json!({ "how": "move", "deg": 2.5 });
        let cloud = predicted(&mut page, "cloud", wish(&way, &["pd"], &json!({}), 12)).await;
        let curves = cloud["curves"].as_array().unwrap();
        assert_eq!(curves.len(), 12);
        let rest: Vec<f64> =
            curves.iter().map(|one| one["rest_counts"].as_f64().unwrap()).collect();
        let place = cloud["worst"]["place"].as_u64().unwrap() as usize;
        // PD settles on none of them, so the largest error is the worst.
        assert!(cloud["settled"].as_u64().unwrap() < 12);
        let is_never = |one: &Value| one["settled_s"].is_null();
        let worst = (0..12).filter(|k| is_never(&curves[*k])).map(|k| rest[k]);
        assert_eq!(worst.fold(0.0, f64::max), rest[place]);
        let joint = cloud["worst"]["joint"].as_array().unwrap();
        assert!(joint.iter().any(|key| key.as_str().unwrap().starts_with("joint.friction.")));
    });
}

#[test]
fn the_cloud_is_drawn_from_the_spread_of_the_file_around_the_joint_that_is_turned() {
    let name = format!("stiction-studio-spread-{}.toml", std::process::id());
    let file = std::env::temp_dir().join(name);
    let text = std::fs::read_to_string("thesis/experiments/step-response.toml").unwrap();
    let spread = "\n[spread]\n\"joint.friction.stick_v\" = [0.39, 0.41]\n";
    std::fs::write(&file, text + spread).unwrap();
    let machine: &'static str = file.to_str().unwrap().to_owned().leak();
    run(async {
        let server = studio_around(machine, "srnf", &[]);
        let mut page = Page::open(&server).await;
        let way = json!({ "how": "move", "deg": 1.0 });
        for (values, low, high) in
            [(json!({}), 0.39, 0.41), (json!({ "joint.friction.stick_v": 0.8 }), 0.78, 0.82)]
        {
            let cloud = predicted(&mut page, "cloud", wish(&way, &["pd"], &values, 6)).await;
            assert_eq!(cloud["is_written"], true, "{cloud}");
            let joint = cloud["worst"]["joint"].as_array().unwrap();
            let keys: Vec<_> = joint.iter().filter_map(|key| key.as_str()).collect();
            let [stick] = keys[..1] else { panic!("{keys:?}") };
            let drawn = stick.strip_prefix("joint.friction.stick_v=").unwrap();
            let drawn: f64 = drawn.parse().unwrap();
            assert!((low..=high).contains(&drawn), "{drawn}");
            // Nothing else is drawn but the delay.
            assert_eq!(keys.len(), 2, "{keys:?}");
        }
    });
    std::fs::remove_file(&file).unwrap();
    run(async {
        let server = studio(&[]);
        let mut page = Page::open(&server).await;
        let way = json!({ "how": "move", "deg": 1.0 });
        let cloud = predicted(&mut page, "cloud", wish(&way, &["pd"], &json!({}), 2)).await;
        assert_eq!(cloud["is_written"], false, "{cloud}");
    });
}

#[test]
fn for_a_device_without_a_file_nothing_is_predicted_and_the_reason_is_reported() {
    run(async {
        let server = studio_without_a_file();
        let mut page = Page::open(&server).await;
        let way = json!({ "how": "move", "deg": 1.0 });
        let refused = predicted(&mut page, "refused", wish(&way, &["pd"], &json!({}), 0)).await;
        assert!(refused.as_str().unwrap().contains("without a machine's file"), "{refused}");
        let said = page.refused(json!({ "do": "compare", "text": "" })).await;
        assert!(said.contains("without a machine's file"), "{said}");
        // It is driven all the same.
        page.done(arm()).await;
        page.done(json!({ "do": "stop" })).await;
        // A page that connects later receives it, too.
        let mut other = Visit::proper(&server).connect().await.unwrap();
        let event = other.event("what-if").await;
        assert!(event["machine"].is_null() && event["laws"] == json!([]), "{event}");
        assert!(event["why"].as_str().unwrap().contains("without a machine's file"), "{event}");
    });
    run(async {
        let server = studio(&[]);
        let mut page = Visit::proper(&server).connect().await.unwrap();
        assert_eq!(page.event("what-if").await["machine"], "step-response");
    });
}

#[test]
fn a_reader_is_predicted_to_and_a_prediction_keeps_nothing_alive() {
    run(async {
        let server = studio(&[]);
        let (mut page, mut reader) = armed_with_a_reader(&server).await;
        let last = page.rows.last().unwrap().clock;
        let way = json!({ "how": "move", "deg": 1.0 });
        let ask = wish(&way, &["pd"], &json!({}), 0);
        let event = predicted(&mut reader, "laws", ask.clone()).await;
        assert!(event[0]["settled_s"].is_null() || event[0]["settled_s"].is_f64());
        // The page that commands hangs, but for its slider.
        page.lives = false;
        let slides = async {
            loop {
                page.send(&ask).await;
                breath().await;
            }
        };
        tokio::select! {
            () = slides => {}
            on = ticks_on_after(&mut reader, last) => {
                let on_s = on as f64 * TICK_S;
                // The reader was predicted to first, and the page gave words meanwhile.
                assert!(on_s < LINK_TIMEOUT_S + SLACK_S + 0.5, "{on_s} s");
            }
        }
        assert_eq!(reader.state("faulted").await["fault"]["code"], 22);
    });
}

#[test]
fn what_is_in_use_is_compared_with_a_file() {
    run(async {
        let server = studio(&[]);
        let mut page = Page::open(&server).await;
        let mut reader = Page::open(&server).await;
        page.done(json!({ "do": "set", "values": { "limits.stall_s": "0.75" } })).await;
        let text = page.form(1).await["file"].as_str().unwrap().to_owned();
        let changed = text.replace("stall_s = 0.75", "stall_s = 0.5");
        assert_ne!(text, changed);
        for (text, lines) in [(text, 0), (changed, 1)] {
            let answer = reader.ask(json!({ "do": "compare", "text": text })).await;
            assert_eq!(answer["said"]["changes"].as_array().unwrap().len(), lines, "{answer}");
        }
        let said = reader.refused(json!({ "do": "compare", "text": "[joint" })).await;
        assert!(said.contains("line 1"), "{said}");
        let own = reader.ask(json!({ "do": "compare", "text": "" })).await;
        assert_eq!(own["said"]["name"], "step-response");
        assert_eq!(own["said"]["values"]["encoder.resolution_deg"], "0.00242");
    });
}
