//! Samples of the ticks, which hold up nothing.

use stiction::control::signal::{SIGNALS, index};
use stiction::link::{Request, RequestRefusal, StateCode};
use stiction::{Parameters, ProfileLimits};

use super::{Script, commanded, record};
use crate::fault_injection::MS;

/// Those of every loop.
const EVERY_SIGNAL: u64 = (1 << SIGNALS.len()) - 1;

/// Those of a joint with one encoder: 19, which is what the wire carries in each tick of 1 ms.
const OF_ONE_ENCODER: u64 = EVERY_SIGNAL & !(1 << index("motor_counts"));

#[test]
fn samples_are_of_the_ticks_that_were_asked_for_and_hold_up_nothing() {
    let fast = commanded(|parameters| parameters.controller.sample_time = 0.001);
    let mut script = Script::new();
    let arm = script.say(250 * MS, Request::Arm);
    let subscribe = script.say(300 * MS, Request::Subscribe { signals: OF_ONE_ENCODER, every: 1 });
    let last = script.status(350 * MS..600 * MS);
    let end = script.say(600 * MS, Request::Subscribe { signals: 0, every: 0 });
    let talked = script.run(Some(&record(&fast)), &[], 650 * MS);
    for number in [arm, subscribe, end] {
        talked.assert_done(number);
    }
    let samples = &talked.samples;
    assert!((295..=302).contains(&samples.len()), "{}", samples.len());
    for pair in samples.windows(2) {
        assert_eq!((pair[1].number, pair[1].clock), (pair[0].number + 1, pair[0].clock + 1));
    }
    // The joint is blocked: the loop holds zero, and says so.
    let status = samples[10].value(index("status")).unwrap();
    assert_eq!(status & 0xFF | status & 1 << 18, 2 | 1 << 18);
    assert_eq!(samples[10].value(index("counts")), Some(0));
    assert_eq!(talked.status(last).dropped, 0);
    let ticks: Vec<u64> =
        talked.observed.ticks_ns.iter().copied().filter(|at| *at > 300 * MS).collect();
    let late = ticks.windows(2).map(|pair| (pair[1] - pair[0]).abs_diff(MS)).max().unwrap();
    assert!(late < 1_000, "{late} ns");
}

#[test]
fn at_ten_kilohertz_the_loop_goes_on_whatever_the_link_is_asked() {
    // More than the wire carries: 93 bytes of each tick of 0.1 ms, of which 9 find room. And 0.1 ms
    // is what a record takes to be validated many times over.
    let fastest = commanded(|parameters| {
        parameters.controller.sample_time = 0.0001;
        // What was derived for another sample time may be more than 256 ticks can keep.
        let Parameters { controller, limits, profile, .. } = parameters;
        *profile = ProfileLimits::derived(controller, limits.overspeed, 0.0);
    });
    let mut script = Script::new();
    let subscribe = script.say(210 * MS, Request::Subscribe { signals: EVERY_SIGNAL, every: 1 });
    let taken = script.push(220 * MS, &record(&fastest));
    let arm = script.say(350 * MS, Request::Arm);
    let refused = script.push(360 * MS, &record(&fastest));
    let last = script.status(400 * MS..700 * MS);
    let talked = script.run(Some(&record(&fastest)), &[], 750 * MS);
    for number in [subscribe, taken, arm] {
        talked.assert_done(number);
    }
    talked.assert_refused(refused, RequestRefusal::Armed);
    let status = talked.status(last);
    assert_eq!((status.state, status.faults, status.sample_time), (StateCode::Armed, 0, 0.0001));
    assert!(status.dropped > 1_000, "{status:?}");
    assert!(talked.observed.resets.is_empty() && talked.observed.on_after(740 * MS));
    // Every sample that was due has a number, those that found no room among them.
    let samples: Vec<_> = talked.samples.iter().filter(|sample| sample.clock > 3_600).collect();
    assert!(samples.len() > 100, "{}", samples.len());
    for pair in samples.windows(2) {
        assert_eq!(pair[1].number - pair[0].number, pair[1].clock - pair[0].clock);
    }
}
