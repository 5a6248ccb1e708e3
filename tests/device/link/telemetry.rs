//! Signals: what a device announces, what it samples, and what of it arrives.

use std::time::Duration;

use simulator::device::log::SampleLog;
use simulator::device::signals::Signals;
use stiction::control::signal::{Form, SIGNALS, index};
use stiction::link::{Reply, Request};

use super::{ALL, client, frame, hello, say, simulated};

#[test]
fn a_device_announces_its_signals_with_names_and_units() {
    let mut client = client();
    let signals = client.signals().unwrap();
    assert_eq!(signals.len(), SIGNALS.len());
    for (place, name, unit, form) in [
        ("tick", "tick", "", Form::Bits),
        ("counts", "counts", "counts", Form::Whole),
        ("error", "error_deg", "deg", Form::Number),
        ("reference_velocity", "reference_velocity_deg_per_s", "deg/s", Form::Number),
        ("v", "v_v", "V", Form::Number),
        ("v_applied", "v_applied_v", "V", Form::Number),
        ("code", "code", "", Form::Whole),
        ("saturated", "saturated", "", Form::Bits),
        ("current", "current_a", "A", Form::Number),
        ("motor_counts", "motor_counts", "counts", Form::Whole),
    ] {
        let found = &signals[index(place)];
        assert_eq!((&*found.name, &*found.unit, found.form), (name, unit, form), "{place}");
    }
    // A name ends with its unit, and no name is there twice.
    for (i, signal) in signals.iter().enumerate() {
        let written = match &*signal.unit {
            "deg" => "_deg",
            "deg/s" => "_deg_per_s",
            "deg/s^2" => "_deg_per_s2",
            "V" => "_v",
            "A" => "_a",
            "counts" => "counts",
            "" => "",
            other => panic!("{other}: say here how it is written in a name"),
        };
        assert!(signal.name.ends_with(written), "{signal:?}");
        assert!(signals[..i].iter().all(|other| other.name != signal.name), "{signal:?}");
    }
}

#[test]
fn a_signal_that_is_not_there_is_not_sent() {
    let mut client = client();
    for unknown in [1 << SIGNALS.len(), 1 << 63, ALL | 1 << SIGNALS.len(), 0] {
        let message = client.subscribe(unknown, 1).unwrap_err().to_string();
        assert!(message.contains("it has no such signal"), "{message}");
    }
    client.subscribe(ALL, 1).unwrap();
}

/// The client knows of the signals only what the device has announced.
#[test]
fn a_client_without_a_table_logs_what_is_applied_by_its_name() {
    let mut client = client();
    let mut log =
        SampleLog::new(Signals::new(client.signals().unwrap()), &["compare".into()]).unwrap();
    client.arm().unwrap();
    client.subscribe(log.mask(), 1).unwrap();
    client.step_to(5.0).unwrap();
    client.pass(Duration::from_secs(3)).unwrap();
    let status = client.status().unwrap();
    while let Some(sample) = client.kept() {
        log.push(sample);
    }
    let csv = log.render(status.sample_time, status.resolution).unwrap();
    let csv = String::from_utf8(csv).unwrap();
    let mut lines = csv.lines().map(|line| line.split(',').collect::<Vec<_>>());
    let header = lines.next().unwrap();
    assert_eq!(header[10..], ["v_applied_v", "compare"]);
    let column = |name: &str| header.iter().position(|found| *found == name).unwrap();
    let [v, applied, code, compare] = ["v_v", "v_applied_v", "code", "compare"].map(column);
    let (mut soft, mut all) = (0, 0);
    for (tick, row) in lines.enumerate() {
        let number = |column: usize| row[column].parse::<f32>().unwrap();
        let (v, applied, code) = (number(v), number(applied), number(code));
        assert_eq!(applied, code * 0.00488, "tick {tick}");
        // The step of 5 deg asks for more than 5 V at first, and the soft start lasts for 25 ticks.
        if applied.abs() < v.abs() - 0.00488 {
            assert!(tick < 25, "tick {tick}: {applied} of {v}");
            soft += 1;
        } else if tick > 25 {
            assert!((applied - v).abs() <= 0.5001 * 0.00488, "tick {tick}: {applied} of {v}");
        }
        assert_eq!(number(compare), 1909.0 + (code * 1909.0 / 1024.0).abs().round().copysign(code));
        all += 1;
    }
    assert!(soft > 3 && all > 140, "{soft} of {all}");
}

#[test]
fn samples_are_numbered_and_have_the_signals_that_were_asked_for() {
    let mut client = client();
    client.arm().unwrap();
    let [counts, code, status] = ["counts", "code", "status"].map(index);
    client.subscribe(1 << counts | 1 << code | 1 << status, 5).unwrap();
    client.step_to(5.0).unwrap();
    client.pass(Duration::from_secs(1)).unwrap();
    let samples: Vec<_> = std::iter::from_fn(|| client.sample(Duration::ZERO).unwrap()).collect();
    // A sample comes every five ticks of 20 ms.
    assert!((9..=11).contains(&samples.len()), "{}", samples.len());
    assert_eq!(client.lost(), 0);
    for pair in samples.windows(2) {
        assert_eq!((pair[1].number, pair[1].clock), (pair[0].number + 1, pair[0].clock + 5));
    }
    let counts = |i: usize| samples[i].value(counts).unwrap() as i32;
    assert!(counts(samples.len() - 1) > counts(0) + 1000);
    assert_eq!(samples[2].value(index("error")), None);
    // The device is armed, and the bridge is on.
    assert_eq!(samples[2].value(status).unwrap() & 0x4_00FF, 0x4_0002);
}

#[test]
fn samples_that_nobody_takes_are_dropped_and_counted_and_answers_are_not() {
    let mut simulated = simulated();
    say(&mut simulated, &hello(1, 7));
    say(&mut simulated, &frame(2, Request::Subscribe { signals: ALL, every: 1 }));
    simulated.ticks(1000);
    let [(3, Reply::Status(status))] = &say(&mut simulated, &frame(3, Request::Status))[..] else {
        panic!()
    };
    assert!(status.dropped > 900 && status.dropped < 1000, "{}", status.dropped);
}

#[test]
fn samples_of_an_earlier_subscription_are_neither_kept_nor_missed_by_the_next_one() {
    let mut client = client();
    let (signals, so_much) = (1 << index("counts"), Duration::from_millis(200));
    client.subscribe(signals, 1).unwrap();
    client.pass(so_much).unwrap();
    // These samples are on their way when the next subscription is asked for.
    client.wire().simulated.ticks(5);
    client.subscribe(signals, 1).unwrap();
    client.pass(so_much).unwrap();
    let numbers: Vec<u32> =
        std::iter::from_fn(|| client.kept()).map(|sample| sample.number).collect();
    assert_eq!(client.lost(), 0);
    assert!(
        numbers.len() >= 10 && numbers.iter().copied().eq(0..numbers.len() as u32),
        "{numbers:?}"
    );
}
