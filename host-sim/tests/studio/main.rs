//! The server of `stiction studio`, used by a page and by other clients.
#![allow(missing_docs, clippy::unwrap_used, clippy::expect_used, clippy::panic)]

#[path = "../../../tests/axis_with_stops.rs"]
mod axis_with_stops;
mod clock;
mod cut_network;
mod gear;
#[path = "../joints_under_test/gearmotor.rs"]
mod gearmotor;
mod homing;
mod identification;
mod late_orders;
mod line;
mod lost_device;
mod owner;
mod page;
mod playground;
mod refusals;
mod selftest;
mod selftest_guards;
mod tune;
mod walk;
mod what_if;
mod what_if_of_a_sheet;

use std::time::{Duration, Instant};

use futures_util::{SinkExt, StreamExt};
use page::{Page, Row, Studio, Visit, arm, run, studio};
use serde_json::json;
use tokio::io::AsyncReadExt;
use tokio::net::TcpStream;
use tokio::time::timeout;
use tokio_tungstenite::tungstenite::{Error, Message};

/// deg a count, and s a tick, of the thesis's joint.
const RESOLUTION: f64 = 0.002_42;
const TICK_S: f64 = 0.02;

/// The default of `limits.link_timeout_s`, and of what a page may say last.
const LINK_TIMEOUT_S: f64 = 0.5;

/// Whether the output was on in the tick of a sample.
fn is_on(status: &u32) -> bool {
    status & 0xFF == 2
}

#[test]
fn the_samples_of_a_move_arrive_complete_and_end_at_the_target() {
    run(async {
        let server = studio(&[]);
        let mut page = Page::open(&server).await;
        assert_eq!(page.role["commands"], true);
        page.done(arm()).await;
        page.done(json!({ "do": "move", "deg": 5.0 })).await;
        page.watch(Duration::from_secs(4)).await;
        page.done(json!({ "do": "stop" })).await;
        page.state("stopped").await;
        let numbers: Vec<u32> = page.rows.iter().map(|row| row.number).collect();
        assert!(numbers.len() as f64 > 3.5 / TICK_S, "{}", numbers.len());
        assert!(numbers.windows(2).all(|pair| pair[1] == pair[0] + 1), "a gap");
        let clock = |row: &Row| row.clock;
        assert!(page.rows.windows(2).all(|pair| clock(&pair[1]) == clock(&pair[0]) + 1));
        let (counts, status) = (page.signal("counts"), page.signal("status"));
        let last = status.iter().rposition(is_on).unwrap();
        let error = f64::from(counts[last] as i32) - 5.0 / RESOLUTION;
        assert!(error.abs() <= 2.0, "{error} counts");
    });
}

/// Returns the number of ticks for which the output stayed on after `last`, the last tick that the
/// page in command received; measured by another page.
async fn ticks_on_after(reader: &mut Page, last: u32) -> i64 {
    reader.state("faulted").await;
    // The samples of the last ticks come with the next frame.
    reader.watch(Duration::from_millis(300)).await;
    let status = reader.signal("status");
    let on = status.iter().rposition(is_on).unwrap();
    assert!(on + 1 < status.len(), "it is on still");
    i64::from(reader.rows[on].clock) - i64::from(last)
}

/// Time of a frame, of a page's answer and of the thread, s.
const SLACK_S: f64 = 0.35;

async fn armed_with_a_reader(server: &Studio) -> (Page, Page) {
    let mut page = Page::open(server).await;
    let mut reader = Page::open(server).await;
    reader.lives = false;
    page.done(arm()).await;
    page.watch(Duration::from_millis(1500)).await;
    let on = page.signal("status").iter().filter(|status| is_on(status)).count();
    assert!(on as f64 > 1.2 / TICK_S, "it stays on while the page lives: {on} ticks");
    (page, reader)
}

#[test]
fn when_the_page_that_commands_is_closed_the_link_timeout_turns_the_output_off() {
    run(async {
        let server = studio(&[]);
        let (page, mut reader) = armed_with_a_reader(&server).await;
        let last = page.rows.last().unwrap().clock;
        drop(page);
        let on_s = ticks_on_after(&mut reader, last).await as f64 * TICK_S;
        assert!((LINK_TIMEOUT_S - 0.15..LINK_TIMEOUT_S + SLACK_S).contains(&on_s), "{on_s} s");
        let status = reader.state("faulted").await;
        assert_eq!(status["fault"]["code"], 22, "{status}");
    });
}

#[test]
fn a_page_that_hangs_or_is_cut_off_keeps_nothing_alive() {
    run(async {
        let server = studio(&[]);
        let (mut page, mut reader) = armed_with_a_reader(&server).await;
        let last = page.rows.last().unwrap().clock;
        // Its connection stays open, and it says nothing.
        page.lives = false;
        let on_s = ticks_on_after(&mut reader, last).await as f64 * TICK_S;
        assert!((LINK_TIMEOUT_S - 0.15..LINK_TIMEOUT_S + SLACK_S).contains(&on_s), "{on_s} s");
    });
}

#[test]
fn without_a_link_timeout_the_studio_stops_the_motor_itself() {
    run(async {
        let server = studio(&["limits.link_timeout_s=\"off\""]);
        let (page, mut reader) = armed_with_a_reader(&server).await;
        drop(page);
        let status = reader.state("stopped").await;
        assert!(status["fault"].is_null(), "{status}");
    });
}

#[test]
fn one_page_commands_and_every_page_may_stop() {
    run(async {
        let server = studio(&[]);
        let mut page = Page::open(&server).await;
        let mut other = Page::open(&server).await;
        assert_eq!(other.role["commands"], false);
        assert!(other.role["why"].as_str().unwrap().contains("another page commands"));
        for what in [arm(), json!({ "do": "move", "deg": 1.0 }), json!({ "do": "save" })] {
            assert!(other.refused(what).await.contains("another page commands"));
        }
        page.done(arm()).await;
        // Its connection has two readers now; the first one keeps the device alive.
        let (stopped, ()) = tokio::join!(
            other.done(json!({ "do": "stop" })),
            page.watch(Duration::from_millis(600)),
        );
        assert!(stopped.contains("the motor is off"));
        other.state("stopped").await;
        // The command is free as soon as the first page has gone.
        drop(page);
        let mut commands = false;
        for _ in 0..50 {
            other.send(&json!({ "do": "command" })).await;
            commands |= other.event("role").await["commands"] == true;
        }
        assert!(commands);
        other.done(arm()).await;
    });
}

#[test]
fn what_the_device_refuses_is_refused_with_its_reason() {
    run(async {
        let server = studio(&["limits.position_max_deg=50", "limits.position_min_deg=-50"]);
        let mut page = Page::open(&server).await;
        let go = |deg: f64| json!({ "do": "move", "deg": deg });
        assert!(page.refused(go(1.0)).await.contains("`arm` first"));
        assert!(page.refused(json!({ "do": "undo" })).await.contains("nothing was changed"));
        let set = |value: &str| json!({ "do": "set", "values": { "limits.stall_s": value } });
        assert!(page.refused(set("-1")).await.contains("limits.stall_s"));
        assert!(page.done(set("0.75")).await.contains("limits.stall_s: "));
        let form = page.form(1).await;
        let rows = form["rows"].as_array().unwrap();
        let row = rows.iter().find(|row| row["path"] == "limits.stall_s").unwrap();
        assert_eq!(row["value"], "0.75");
        assert_ne!(row["saved"], row["value"]);
        page.done(arm()).await;
        assert!(page.refused(set("0.5")).await.contains("`stop` first"));
        // The joint was armed where it stood at power-on.
        let said = page.refused(go(70.0)).await;
        assert!(said.contains("limits.position_min_deg") && said.contains(" to 50"), "{said}");
        page.done(json!({ "do": "stop" })).await;
        page.done(json!({ "do": "undo" })).await;
        page.form(0).await;
        assert!(page.done(set("0.75")).await.contains("-> 0.75"));
        page.done(json!({ "do": "save" })).await;
    });
}

#[test]
fn without_limits_of_travel_a_target_beyond_one_turn_is_refused() {
    run(async {
        let server = studio(&[]);
        let mut page = Page::open(&server).await;
        page.done(arm()).await;
        for how in ["move", "step"] {
            let said = page.refused(json!({ "do": how, "deg": 99999 })).await;
            assert!(said.contains("it must be -360 to 360 deg"), "{said}");
        }
        let there_and_back = json!({ "do": "trajectory", "trapezoid": [-99999, 5, 1, 0.25] });
        let said = page.refused(there_and_back).await;
        assert!(said.contains("trajectory to -99999: "), "{said}");
        assert!(said.contains("it must be -360 to 360 deg"), "{said}");
        assert_eq!(page.event("status").await["targets_deg"], json!([-360.0, 360.0]));
    });
}

#[test]
fn a_jog_reports_its_result() {
    run(async {
        let server = studio(&[]);
        let mut page = Page::open(&server).await;
        page.done(json!({ "do": "jog" })).await;
        let found = page.event("found").await;
        assert!(found["said"].as_str().unwrap().contains("the encoder counts in the sense"));
    });
}

/// The status of HTTP that a visit ends with.
async fn turned_away(visit: Visit<'_>) -> u16 {
    match visit.connect().await {
        Err(Error::Http(response)) => response.status().as_u16(),
        Err(other) => panic!("{other}"),
        Ok(_) => panic!("it was let in"),
    }
}

#[test]
fn a_connection_without_the_token_from_another_origin_or_by_another_name_is_refused() {
    run(async {
        let server = studio(&[]);
        let proper = || Visit::proper(&server);
        let wrong = "0".repeat(32);
        let part = &server.token().text()[..31];
        for token in ["", part, &wrong] {
            assert_eq!(turned_away(Visit { token, ..proper() }).await, 403, "{token}");
        }
        for origin in [None, Some("http://evil.example".into()), Some("null".into())] {
            assert_eq!(turned_away(Visit { origin, ..proper() }).await, 403);
        }
        let host = format!("evil.example:{}", server.address().port());
        let origin = Some(format!("http://{host}"));
        assert_eq!(turned_away(Visit { origin, host, ..proper() }).await, 403);
        let mut page = Page::open(&server).await;
        assert_eq!(page.role["commands"], true, "none of them has got so far");
        assert_eq!(page.event("status").await["state"], "stopped");
    });
}

#[test]
fn invalid_messages_are_refused_and_end_the_connection_if_they_go_on() {
    run(async {
        let server = studio(&[]);
        let mut page = Page::open(&server).await;
        for wrong in ["", "{", "[]", r#"{"do":"arm","now":1}"#, r#"{"do":"move","deg":1e999}"#] {
            page.socket.send(Message::Text(wrong.into())).await.unwrap();
            let said = page.event("answer").await;
            assert_eq!(said["ok"], false, "{wrong}");
        }
        // Not even a number that is one, but no place.
        page.done(arm()).await;
        assert!(
            page.refused(json!({ "do": "move", "deg": 1e300 })).await.contains("-360 to 360 deg")
        );
        page.done(json!({ "do": "stop" })).await;
        for _ in 0..10 {
            let _ = page.socket.send(Message::Text("?".into())).await;
        }
        while page.next().await.is_some() {}
        // It was the page that commanded.
        assert_eq!(Page::open(&server).await.role["commands"], true);
    });
}

#[test]
fn a_message_that_is_too_large_or_binary_ends_its_connection_and_nothing_else() {
    run(async {
        let server = studio(&[]);
        let large = format!(r#"{{"do":"push","text":"{}"}}"#, "x".repeat(65 * 1024));
        for message in [Message::Text(large.into()), Message::Binary(vec![1, 2, 3].into())] {
            let mut reader = Page::open(&server).await;
            let mut page = Page::open(&server).await;
            let _ = page.socket.send(message).await;
            while page.next().await.is_some() {}
            reader.event("status").await;
        }
    });
}

#[test]
fn a_thousand_connections_are_closed_and_the_page_goes_on() {
    run(async {
        let server = studio(&[]);
        let mut page = Page::open(&server).await;
        page.done(arm()).await;
        let mut idle = Vec::new();
        for i in 0..1000 {
            let connected = timeout(page::PATIENCE, TcpStream::connect(server.address())).await;
            idle.push(connected.unwrap().unwrap());
            if i % 20 == 0 {
                page.next().await;
            }
        }
        // The last one was closed at once, or is about to be.
        let closed = timeout(page::PATIENCE, idle.last_mut().unwrap().read(&mut [0; 8])).await;
        assert!(matches!(closed.unwrap(), Ok(0) | Err(_)));
        page.watch(Duration::from_millis(700)).await;
        assert_eq!(page.event("status").await["state"], "armed");
        page.done(json!({ "do": "stop" })).await;
        drop(idle);
        Page::open(&server).await;
    });
}

#[test]
fn a_page_that_does_not_read_delays_no_other_page() {
    run(async {
        let server = studio(&["loop.sample_time_s=0.001"]);
        // It takes nothing from its connection.
        let asleep = Visit::proper(&server).connect().await.unwrap();
        let mut page = Page::open(&server).await;
        page.watch(Duration::from_secs(2)).await;
        let numbers: Vec<u32> = page.rows.iter().map(|row| row.number).collect();
        assert!(numbers.windows(2).all(|pair| pair[1] == pair[0] + 1), "a gap");
        assert!(numbers.len() > 1500, "{}", numbers.len());
        drop(asleep);
    });
}

#[test]
fn the_page_may_load_nothing_but_what_the_server_sends() {
    run(async {
        let server = studio(&[]);
        let mut stream = TcpStream::connect(server.address()).await.unwrap();
        let host = server.address();
        let request = format!("GET / HTTP/1.1\r\nHost: {host}\r\nConnection: close\r\n\r\n");
        tokio::io::AsyncWriteExt::write_all(&mut stream, request.as_bytes()).await.unwrap();
        let mut answer = String::new();
        stream.read_to_string(&mut answer).await.unwrap();
        assert!(answer.starts_with("HTTP/1.1 200"), "{answer}");
        assert!(answer.contains("content-security-policy: default-src 'self'"), "{answer}");
        assert!(!answer.contains(server.token().text()), "the page holds no secret");
        let mut page = Page::open(&server).await;
        assert!(page.socket.next().await.is_some());
    });
}

#[test]
fn the_seventeenth_page_is_turned_away() {
    run(async {
        let server = studio(&[]);
        let mut pages = Vec::new();
        for _ in 0..16 {
            pages.push(Visit::proper(&server).connect().await.unwrap());
        }
        assert!(Visit::proper(&server).connect().await.is_err());
        pages.pop();
        // Its place is free once the server has seen that it is gone.
        let begin = Instant::now();
        while Visit::proper(&server).connect().await.is_err() {
            assert!(begin.elapsed() < page::PATIENCE, "its place is not free");
        }
    });
}

#[test]
fn a_trajectory_is_followed_and_what_cannot_be_followed_is_refused() {
    run(async {
        let server = studio(&[]);
        let mut page = Page::open(&server).await;
        let go = |fields: [f64; 4]| json!({ "do": "trajectory", "trapezoid": fields });
        assert!(page.refused(go([2.0, 4.0, 0.2, 0.1])).await.contains("`arm` first"));
        page.done(arm()).await;
        assert!(page.refused(json!({ "do": "trajectory" })).await.contains("no trajectory in"));
        assert!(page.refused(go([2.0, 0.0, 0.2, 0.1])).await.contains("the speed"));
        assert!(page.refused(go([1e300, 4.0, 0.2, 0.1])).await.contains("trajectory"));
        page.done(go([2.0, 4.0, 0.2, 0.1])).await;
        let motion = page.motion().await;
        assert_eq!(motion["way"]["how"], "trajectory");
        // 0.1 s, 0.5 s there, 0.2 s, 0.5 s back, 0.1 s.
        page.watch(Duration::from_millis(2500)).await;
        page.done(json!({ "do": "stop" })).await;
        let lead = page.signal("reference_counts").into_iter().map(|bits| bits as i32);
        let most = f64::from(lead.max().unwrap()) * RESOLUTION;
        assert!((most - 2.0).abs() < 0.01, "{most} deg");
        let (counts, status) = (page.signal("counts"), page.signal("status"));
        let last = status.iter().rposition(is_on).unwrap();
        assert!((counts[last] as i32).abs() <= 12, "{} counts", counts[last] as i32);
        page.state("stopped").await;
        // Where the joint is far from zero, the device refuses to begin at zero.
        page.done(arm()).await;
        page.done(json!({ "do": "move", "deg": 15.0 })).await;
        page.watch(Duration::from_millis(5000)).await;
        let said = page.refused(go([2.0, 4.0, 0.2, 0.1])).await;
        assert!(said.contains("start of the trajectory is too far from the joint"), "{said}");
        page.done(json!({ "do": "stop" })).await;
    });
}
