//! A save stops the ticks while the flash is erased, and nothing is driven meanwhile.

use emulator::board::FittedParts;
use emulator::fault_injection::Injection;
use stiction::link::{CHUNK, Request, RequestRefusal, StateCode};

use super::{Script, commanded, record};
use crate::fault_injection::MS;

#[test]
fn a_save_that_the_flash_does_not_keep_is_refused_and_harms_nothing() {
    // The emulated flash says that it has erased and written, and is as it was before. The slowest
    // oscillator and the fastest: with the watchdog of the loop, 60 ms, none of them would live
    // through an erase.
    for lsi_hz in [17_000, 47_000] {
        let other = commanded(|parameters| parameters.limits.link_timeout = 0.6);
        let mut script = Script::new();
        let taken = script.push(250 * MS, &record(&other));
        let save = script.say(300 * MS, Request::Save);
        let after = script.say(3_000 * MS, Request::Status);
        let arm = script.say(3_100 * MS, Request::Arm);
        let armed = script.say(3_200 * MS, Request::Status);
        let injections = [(3_300 * MS, Injection::TickStops)];
        let fitted = FittedParts { lsi_hz, ..FittedParts::default() };
        let talked =
            script.run_on(fitted, Some(&record(&commanded(|_| {}))), &injections, 3_600 * MS);
        talked.assert_done(taken);
        talked.assert_refused(save, RequestRefusal::Flash);
        let status = talked.status(after);
        assert_eq!(
            (status.state, status.fault.code, status.unsaved),
            (StateCode::Stopped, 0, true)
        );
        talked.assert_done(arm);
        assert_eq!(talked.status(armed).state, StateCode::Armed);
        // The ticks stood still for the erase, for as long as it takes, and nothing was driven.
        let observed = &talked.observed;
        let gaps: Vec<u64> = observed.ticks_ns.windows(2).map(|pair| pair[1] - pair[0]).collect();
        let longest = gaps.iter().copied().max().unwrap();
        // Data sheet, 128 KiB at 32 bits of parallelism: 1 s typically, 2 s at most.
        assert!((1_000 * MS..2_050 * MS).contains(&longest), "{longest}");
        assert!(observed.on_ns[0][0] > 3_100 * MS, "{:?}", observed.on_ns);
        // Afterwards the watchdog is the loop's again.
        let [reset] = observed.resets[..] else { panic!("{lsi_hz}: {:?}", observed.resets) };
        let timeout = 60 * MS * 47_000 / lsi_hz;
        let allowed = 3_300 * MS + timeout - 20 * MS..3_300 * MS + timeout + MS;
        assert!(allowed.contains(&reset.at.0), "{lsi_hz}: {reset:?}");
    }
}

#[test]
fn nothing_is_driven_while_a_stop_and_a_save_come_within_one_tick() {
    let other = commanded(|parameters| parameters.limits.link_timeout = 0.6);
    let mut script = Script::new();
    script.push(220 * MS, &record(&other));
    let arm = script.say(350 * MS, Request::Arm);
    // Ticks are at multiples of 20 ms after the start, some 1 ms after power-on.
    let stop = script.say(406 * MS, Request::Stop);
    let save = script.say(407 * MS, Request::Save);
    let talked = script.run(Some(&record(&commanded(|_| {}))), &[], 1_000 * MS);
    talked.assert_done(arm);
    talked.assert_done(stop);
    let [[_, off]] = talked.observed.on_ns[..] else { panic!("{:?}", talked.observed.on_ns) };
    assert!((406 * MS..409 * MS).contains(&off), "off at {off}");
    assert!(
        talked.replies.iter().all(|(_, number, _)| *number != save),
        "the erase is not over yet"
    );
}

#[test]
fn saves_and_other_parameters_in_one_burst_are_done_one_after_the_other() {
    let fast = commanded(|parameters| parameters.controller.sample_time = 0.001);
    let slow = record(&commanded(|parameters| parameters.limits.link_timeout = 0.6));
    let mut script = Script::new();
    // The flash keeps nothing, so each save of parameters that it did not have before erases anew.
    script.push(
        220 * MS,
        &record(&commanded(|parameters| {
            parameters.controller.sample_time = 0.001;
            parameters.limits.link_timeout = 0.6;
        })),
    );
    for (i, piece) in slow.chunks(CHUNK).enumerate() {
        let (offset, bytes) = ((i * CHUNK) as u16, piece.iter().copied().collect());
        script.say((260 + i as u64 * 4) * MS, Request::WriteParameters { offset, bytes });
    }
    let take = Request::TakeParameters { length: slow.len() as u16 };
    let requests = [Request::Save, take, Request::Save, Request::Save];
    let [first, taken, second, third] = script.burst(300 * MS, requests)[..] else { panic!() };
    let after = script.say(7_000 * MS, Request::Status);
    let talked = script.run(Some(&record(&fast)), &[], 7_100 * MS);
    for save in [first, second, third] {
        talked.assert_refused(save, RequestRefusal::Flash);
    }
    talked.assert_done(taken);
    let status = talked.status(after);
    assert_eq!((status.state, status.sample_time), (StateCode::Stopped, 0.02));
    assert!(talked.observed.resets.is_empty(), "{:?}", talked.observed.resets);
    // Each was attempted, which takes a second.
    let at = |number| {
        talked.replies.iter().find(|(_, of, _)| *of == number).map(|(at, ..)| *at).unwrap()
    };
    assert!(at(second) - at(taken) > 1_000 * MS && at(third) - at(second) > 1_000 * MS);
}

#[test]
fn the_joint_has_to_rest_anew_after_a_save_before_it_is_armed() {
    let mut script = Script::new();
    script.push(220 * MS, &record(&commanded(|parameters| parameters.limits.link_timeout = 0.6)));
    let [save, arm] = script.burst(400 * MS, [Request::Save, Request::Arm])[..] else { panic!() };
    let later = script.say(2_700 * MS, Request::Arm);
    let talked = script.run(Some(&record(&commanded(|_| {}))), &[], 2_800 * MS);
    talked.assert_refused(save, RequestRefusal::Flash);
    // It was attempted: the ticks stood still for the erase.
    assert!(talked.observed.ticks_ns.windows(2).any(|pair| pair[1] - pair[0] > 1_000 * MS));
    talked.assert_refused(arm, RequestRefusal::Moving);
    talked.assert_done(later);
}

#[test]
fn a_brown_out_reset_that_was_turned_on_is_there_after_the_next_reset() {
    let mut script = Script::new();
    let before = script.say(250 * MS, Request::Status);
    let set = script.say(300 * MS, Request::SetBrownOut);
    let after = script.say(400 * MS, Request::Status);
    // A reset begins a session anew, and its numbers.
    script.hello(700 * MS, 8);
    let later = script.say(750 * MS, Request::Status);
    let injections = [(500 * MS, Injection::Reset)];
    let talked = script.run(Some(&record(&commanded(|_| {}))), &injections, 800 * MS);
    talked.assert_done(set);
    let [before, after, later] = [before, after, later].map(|number| talked.status(number));
    assert_eq!(
        (before.has_brown_out, after.has_brown_out, later.has_brown_out),
        (false, false, true)
    );
    assert_eq!((after.state, after.faults, later.faults), (StateCode::Stopped, 0, 0));
    assert!(talked.observed.says("brown-out reset is off"), "{:?}", talked.observed.log);
    assert!(talked.observed.says("brown-out reset: level 3"), "{:?}", talked.observed.log);
    // The one reset is the button's: the watchdog waited meanwhile.
    assert_eq!(talked.observed.resets.len(), 1, "{:?}", talked.observed.resets);
}
