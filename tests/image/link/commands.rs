//! What is said is done, and what is garbled costs at most itself.

use emulator::board::FittedParts;
use emulator::fault_injection::Injection;
use stiction::Fault;
use stiction::link::{Reply, Request, RequestRefusal, StateCode, encode_request};

use super::{SESSION, Script, commanded, faulted, record};
use crate::fault_injection::MS;

#[test]
fn a_board_is_armed_and_stopped_by_commands_and_answers_within_a_millisecond() {
    let mut script = Script::new();
    let arm = script.say(250 * MS, Request::Arm);
    let armed = script.status(300 * MS..600 * MS);
    let stop = script.say(600 * MS, Request::Stop);
    let stopped = script.say(700 * MS, Request::Status);
    let says: Vec<u64> = script.says.iter().skip(1).map(|(at, _)| *at).collect();
    let talked = script.run(Some(&record(&commanded(|_| {}))), &[], 1_500 * MS);
    talked.assert_done(arm);
    talked.assert_done(stop);
    assert_eq!(
        (talked.status(armed).state, talked.status(stopped).state),
        (StateCode::Armed, StateCode::Stopped)
    );
    assert_eq!(talked.status(stopped).bad_frames, 0);
    let [[on, off]] = talked.observed.on_ns[..] else { panic!("{:?}", talked.observed.on_ns) };
    // Each takes effect in the next tick.
    assert!(
        (250 * MS..271 * MS).contains(&on) && (600 * MS..621 * MS).contains(&off),
        "{on} {off}"
    );
    // It has to come and go on the wire: 11 us for each of some 20 and 60 bytes.
    for ((at, number, _), said) in talked.replies.iter().zip(says) {
        assert!((said..said + MS).contains(at), "{number}: said at {said}, answered at {at}");
    }
}

#[test]
fn garbage_between_frames_costs_only_itself() {
    let mut script = Script::new();
    let mut numbers = vec![];
    let status = |number| encode_request(SESSION, number, Request::Status).unwrap().to_vec();
    for bit in 0..8 * status(1).len() {
        let at = 250 * MS + bit as u64 * 2 * MS;
        let mut broken = status(9999);
        broken[bit / 8] ^= 1 << (bit % 8);
        broken.push(0);
        script.garbage(at, &broken);
        numbers.push(script.say(at, Request::Status));
    }
    // More than any ring of the board holds, without an end.
    script.garbage(700 * MS, &[0x55; 3000]);
    script.garbage(750 * MS, &[0]);
    numbers.push(script.say(750 * MS, Request::Status));
    let talked = script.run(Some(&record(&commanded(|_| {}))), &[], 800 * MS);
    for number in &numbers {
        assert_eq!(talked.status(*number).state, StateCode::Stopped);
    }
    assert!(
        talked.status(numbers[numbers.len() - 1]).bad_frames > 50,
        "{:?}",
        talked.replies.last()
    );
    assert!(talked.observed.resets.is_empty());
}

#[test]
fn a_link_that_falls_silent_turns_the_bridge_off_with_its_code() {
    let mut script = Script::new();
    let arm = script.say(250 * MS, Request::Arm);
    let last = script.status(300 * MS..800 * MS);
    let after = script.say(1_500 * MS, Request::Status);
    let talked = script.run(Some(&record(&commanded(|_| {}))), &[], 1_600 * MS);
    talked.assert_done(arm);
    assert_eq!(talked.status(last).state, StateCode::Armed);
    // The last sign of life is at 700 ms; half a second in ticks of 20 ms, the one of the sign
    // included or not.
    let off = talked.observed.off_at_ns().unwrap();
    assert!((1_180 * MS..1_241 * MS).contains(&off), "{off}");
    let status = talked.status(after);
    assert_eq!(
        (status.state, status.fault.code),
        (faulted(Fault::LinkTimeout), Fault::LinkTimeout as u8)
    );
    assert!((0.5..0.54).contains(&status.fault.value), "{:?}", status.fault);
    assert!(talked.observed.says("faulted: link silent while armed"), "{:?}", talked.observed.log);
}

#[test]
fn a_flood_of_requests_that_take_long_does_not_starve_the_watchdog() {
    let fast = record(&commanded(|parameters| parameters.controller.sample_time = 0.001));
    let take = || Request::TakeParameters { length: fast.len() as u16 };
    let mut script = Script::new();
    let taken = script.push(220 * MS, &fast);
    // As many as find room.
    let while_off = script.burst(300 * MS, (0..24).map(|_| take()));
    let arm = script.say(450 * MS, Request::Arm);
    // 40 ms of the wire, without a pause in which the log would have its turn: with the fastest
    // oscillator, the watchdog waits for 10. What finds no room is not answered.
    let armed = script.burst(500 * MS, (0..400).map(|_| take()));
    let last = script.status(600 * MS..700 * MS);
    let fitted = FittedParts { lsi_hz: 47_000, ..FittedParts::default() };
    let talked = script.run_on(fitted, Some(&fast), &[], 700 * MS);
    assert!(talked.observed.resets.is_empty(), "{:?}", talked.observed.resets);
    for number in [taken, arm].into_iter().chain(while_off) {
        talked.assert_done(number);
    }
    let answers: Vec<_> =
        talked.replies.iter().filter(|(_, number, _)| armed.contains(number)).collect();
    assert!(answers.len() > 24, "{}", answers.len());
    assert!(
        answers.iter().all(|(.., reply)| *reply == Reply::Refused(RequestRefusal::Armed)),
        "{answers:?}"
    );
    let status = talked.status(last);
    assert_eq!((status.state, status.faults), (StateCode::Armed, 0));
    assert!(talked.observed.on_after(690 * MS));
}

#[test]
fn the_break_input_can_be_cleared_and_trips_again() {
    let mut script = Script::new();
    let arm = script.say(250 * MS, Request::Arm);
    let early = script.say(350 * MS, Request::Clear);
    let pulled = script.say(390 * MS, Request::Status);
    let refused = script.say(395 * MS, Request::Arm);
    let clear = script.say(450 * MS, Request::Clear);
    let cleared = script.say(490 * MS, Request::Status);
    let again = script.say(500 * MS, Request::Arm);
    let armed = script.say(560 * MS, Request::Status);
    let second = script.say(650 * MS, Request::Status);
    let (break_, released) = (Injection::Break, Injection::BreakReleased);
    let injections =
        [(300 * MS, break_), (400 * MS, released), (600 * MS, break_), (610 * MS, released)];
    let talked = script.run(Some(&record(&commanded(|_| {}))), &injections, 700 * MS);
    let broken = faulted(Fault::BreakInput);
    talked.assert_done(arm);
    // While it is pulled, clearing it trips it again.
    talked.assert_done(early);
    assert_eq!(talked.status(pulled).state, broken);
    talked.assert_refused(refused, RequestRefusal::Faulted(Fault::BreakInput as u8));
    talked.assert_done(clear);
    assert_eq!(talked.status(cleared).state, StateCode::Stopped);
    talked.assert_done(again);
    assert_eq!(talked.status(armed).state, StateCode::Armed);
    assert_eq!(talked.status(second).state, broken);
    let [first, then] = talked.observed.on_ns[..] else { panic!("{:?}", talked.observed.on_ns) };
    assert!((300 * MS..301 * MS).contains(&first[1]), "{first:?}");
    assert!(then[0] > 500 * MS && (600 * MS..601 * MS).contains(&then[1]), "{then:?}");
}

#[test]
fn a_break_between_two_ticks_is_a_fault_though_a_request_comes_before_the_second() {
    // Ticks are some 1 ms after multiples of 20 ms, and the break is over before anybody asks.
    let mut script = Script::new();
    let arm = script.say(250 * MS, Request::Arm);
    let status = script.say(306 * MS, Request::Status);
    let refused = script.say(307 * MS, Request::Arm);
    let clear = script.say(350 * MS, Request::Clear);
    let again = script.say(360 * MS, Request::Arm);
    // All of it between two ticks: what was on, tripped, was cleared and armed anew is on.
    let cleared = script.say(406 * MS, Request::Clear);
    let anew = script.say(407 * MS, Request::Arm);
    let armed = script.status(450 * MS..500 * MS);
    let (break_, released, short) = (Injection::Break, Injection::BreakReleased, MS / 5);
    let injections = [305, 405].map(|at| [(at * MS, break_), (at * MS + short, released)]).concat();
    let talked = script.run(Some(&record(&commanded(|_| {}))), &injections, 500 * MS);
    talked.assert_done(arm);
    assert_eq!(talked.status(status).state, faulted(Fault::BreakInput));
    talked.assert_refused(refused, RequestRefusal::Faulted(Fault::BreakInput as u8));
    assert!(talked.observed.says(Fault::BreakInput.describe()), "{:?}", talked.observed.log);
    for number in [clear, again, cleared, anew] {
        talked.assert_done(number);
    }
    let status = talked.status(armed);
    assert_eq!((status.state, status.faults), (StateCode::Armed, 2));
    let [first, second, third] = talked.observed.on_ns[..] else {
        panic!("{:?}", talked.observed.on_ns)
    };
    assert!(first[1].abs_diff(305 * MS) < short && second[1].abs_diff(405 * MS) < short);
    assert!(second[0] > 360 * MS && third[0] > 407 * MS && talked.observed.on_after(480 * MS));
}
