//! Parameters that come over the link.

use emulator::fault_injection::Injection;
use stiction::Fault;
use stiction::link::{Reply, Request, RequestRefusal, StateCode};
use stiction::parameters::names::ValuePath;

use super::{Script, commanded, faulted, record};
use crate::fault_injection::MS;

#[test]
fn without_valid_parameters_arming_is_refused_until_some_come_over_the_link() {
    let mut damaged = record(&commanded(|_| {}));
    damaged[40] ^= 1;
    for (found, fault) in [(None, Fault::NoParameters), (Some(&damaged[..]), Fault::BadParameters)]
    {
        let mut script = Script::new();
        let refused = script.say(220 * MS, Request::Arm);
        let uncleared = script.say(230 * MS, Request::Clear);
        let mut bad = commanded(|_| {});
        bad.limits.thermal_time = -1.0;
        let bad = script.push(250 * MS, &record(&bad));
        let still = script.say(290 * MS, Request::Status);
        let good = script.push(300 * MS, &record(&commanded(|_| {})));
        let ready = script.say(450 * MS, Request::Status);
        let arm = script.say(460 * MS, Request::Arm);
        let armed = script.say(500 * MS, Request::Status);
        let talked = script.run(found, &[], 600 * MS);
        talked.assert_refused(refused, RequestRefusal::Faulted(fault as u8));
        talked.assert_refused(uncleared, RequestRefusal::NotClearable(fault as u8));
        let Reply::Refused(RequestRefusal::Value { key, found, .. }) = talked.reply(bad) else {
            panic!("{:?}", talked.reply(bad));
        };
        assert_eq!((ValuePath(*key).to_string().as_str(), *found), ("limits.thermal_s", -1.0));
        assert_eq!(
            (talked.status(still).state, talked.status(still).sample_time),
            (faulted(fault), 0.0)
        );
        talked.assert_done(good);
        let status = talked.status(ready);
        assert_eq!(
            (status.state, status.unsaved, status.sample_time),
            (StateCode::Stopped, true, 0.02)
        );
        talked.assert_done(arm);
        assert_eq!(talked.status(armed).state, StateCode::Armed);
        assert!(talked.observed.on_after(460 * MS) && talked.observed.on_ns[0][0] > 460 * MS);
    }
}

#[test]
fn other_parameters_set_sample_time_pwm_and_watchdog_anew() {
    let other = commanded(|parameters| {
        parameters.controller.sample_time = 0.001;
        parameters.controller.drive.pwm_hz = 21e3;
    });
    let mut script = Script::new();
    let taken = script.push(250 * MS, &record(&other));
    let arm = script.say(400 * MS, Request::Arm);
    let armed = script.say(450 * MS, Request::Status);
    let injections = [(500 * MS, Injection::TickStops)];
    let talked = script.run(Some(&record(&commanded(|_| {}))), &injections, 600 * MS);
    talked.assert_done(taken);
    talked.assert_done(arm);
    assert_eq!(
        (talked.status(armed).state, talked.status(armed).sample_time),
        (StateCode::Armed, 0.001)
    );
    let observed = &talked.observed;
    assert_eq!(observed.last.top, 4000);
    let late = |from: u64, until: u64, sample: u64| {
        let ticks: Vec<u64> =
            observed.ticks_ns.iter().copied().filter(|at| (from..until).contains(at)).collect();
        ticks.windows(2).map(|pair| (pair[1] - pair[0]).abs_diff(sample)).max().unwrap()
    };
    // Whatever is below the control task holds it up for a microsecond at most.
    let (before, after) = (late(100 * MS, 250 * MS, 20 * MS), late(300 * MS, 500 * MS, MS));
    assert!(before < 1_000 && after < 1_000, "{before} and {after} ns");
    // Three ticks would be too short, so it is 10 ms of the fastest oscillator: 14.7 of this one.
    let [reset] = observed.resets[..] else { panic!("{:?}", observed.resets) };
    let timeout = 10 * MS * 47 / 32;
    assert!((500 * MS + timeout - MS..500 * MS + timeout + MS).contains(&reset.at.0), "{reset:?}");
}
