//! What comes over the wire while the processor does something else is not lost, and what is lost
//! is reported.

use emulator::board::FittedParts;
use emulator::fault_injection::Injection;
use stiction::link::{Request, Status, WireErrors, encode_request};

use super::{SESSION, Script, Talked, commanded, record};
use crate::fault_injection::MS;

/// Bytes of the board's ring.
const RING: usize = 512;
/// A byte on the wire, ns: ten bits of 91 clocks of 84 MHz.
const BYTE: u64 = 10_833;

/// The processor stands still for so long (ns), from 250 ms on. The next tick is due some ms later.
fn stalls(ns: u64) -> [(u64, Injection); 2] {
    [(250 * MS, Injection::CoreStalls), (250 * MS + ns, Injection::CoreGoesOn)]
}

fn clean(status: Status) -> bool {
    (status.bad_frames, status.wire) == (0, WireErrors::default())
}

fn answered(talked: &Talked, number: u16) -> bool {
    talked.replies.iter().any(|(_, of, _)| *of == number)
}

#[test]
fn a_frame_that_comes_while_the_processor_stands_still_is_not_lost() {
    // A line of the log holds the port's interrupt up for a microsecond or two, a tick for eight,
    // and a byte takes eleven. This is a hundred bytes' time.
    for long in [0, MS / 10, MS / 2, MS] {
        let mut script = Script::new();
        let during = [50, 150].map(|us| script.say(250 * MS + us * 1_000, Request::Status));
        let after = script.say(260 * MS, Request::Status);
        let talked = script.run(Some(&record(&commanded(|_| {}))), &stalls(long), 280 * MS);
        for number in during {
            talked.status(number);
        }
        assert!(clean(talked.status(after)), "{long} ns: {:?}", talked.status(after));
    }
}

#[test]
fn a_burst_of_frames_back_to_back_is_answered_whole_and_in_order() {
    let mut script = Script::new();
    let mut numbers = script.burst(250 * MS, (0..30).map(|_| Request::Status));
    let last = script.say(300 * MS, Request::Status);
    numbers.push(last);
    let bytes: usize = script.bytes();
    assert!((RING / 2..RING).contains(&bytes), "{bytes} bytes are more than a half of the ring");
    let talked = script.run(Some(&record(&commanded(|_| {}))), &[], 350 * MS);
    assert!(clean(talked.status(last)), "{:?}", talked.status(last));
    // What the ring of answers has no room for is dropped, and that is counted; the order stays.
    let answers: Vec<u16> = talked.replies.iter().map(|(_, number, _)| *number).collect();
    let missing = numbers.iter().filter(|number| !answers.contains(number)).count();
    assert_eq!(missing as u32, talked.status(last).dropped);
    assert!(answers.is_sorted() && answers.len() > 10, "{answers:?}");
}

#[test]
fn frames_of_every_place_in_the_ring_are_whole() {
    // Frames of 14 and of 25 to 36 bytes: over some laps, the end of the ring is within many.
    let mut script = Script::new();
    let mut numbers = vec![];
    for i in 0..120u64 {
        let at = 250 * MS + i * 2 * MS;
        let bytes = (0..12 + i % 12).map(|byte| byte as u8).collect();
        script.say(at, Request::WriteParameters { offset: 0, bytes });
        numbers.push(script.say(at + MS, Request::Status));
    }
    let bytes: usize = script.bytes();
    assert!(bytes > 6 * RING, "{bytes}");
    let talked = script.run(Some(&record(&commanded(|_| {}))), &[], 500 * MS);
    for number in &numbers {
        assert!(clean(talked.status(*number)), "{:?}", talked.status(*number));
    }
}

#[test]
fn what_is_more_than_the_ring_holds_costs_frames_and_nothing_after_them() {
    // Frames of 14 and 15 bytes: in 16 ms, two laps of the ring and most of a third.
    let mut script = Script::new();
    let during = script.burst(250 * MS, (0..100).map(|_| Request::Status));
    let after: Vec<u16> =
        (0..5).map(|i| script.say(290 * MS + i * 2 * MS, Request::Status)).collect();
    let bytes: usize = script.bytes();
    assert!(bytes as u64 * BYTE < 18 * MS && bytes > 2 * RING, "{bytes}");
    let talked = script.run(Some(&record(&commanded(|_| {}))), &stalls(18 * MS), 320 * MS);
    assert!(talked.observed.resets.is_empty(), "{:?}", talked.observed.resets);
    let lost = during.iter().filter(|number| !answered(&talked, **number)).count();
    assert!(lost > during.len() / 2, "{lost} of {}", during.len());
    // At most one frame is cut in two by what was written over it.
    let [first, .., last] = after[..] else { panic!() };
    assert_eq!(talked.status(first).bad_frames, talked.status(last).bad_frames);
    assert!(talked.status(last).bad_frames <= 2, "{:?}", talked.status(last));
}

#[test]
fn noise_on_the_wire_costs_frames_and_is_reported() {
    // A byte of a hundred: of frames of 14 bytes, one in eight is not whole.
    let fitted = FittedParts { noisy_bytes: 10_000, ..FittedParts::default() };
    let mut script = Script::new();
    let numbers: Vec<u16> =
        (0..200).map(|i| script.say(250 * MS + i * MS, Request::Status)).collect();
    let length = encode_request(SESSION, numbers[199], Request::Status).unwrap().len() as f64;
    let talked = script.run_on(fitted, Some(&record(&commanded(|_| {}))), &[], 460 * MS);
    let answers = numbers.iter().filter(|number| answered(&talked, **number)).count();
    let expected = 200.0 * 0.99f64.powf(length);
    // Three standard deviations of a binomial distribution, and the two frames that share a zero.
    let deviation = 3.0 * (expected * (1.0 - expected / 200.0)).sqrt();
    assert!((answers as f64 - expected).abs() < deviation + 4.0, "{answers}, not {expected}");
    let last = *numbers.iter().rev().find(|number| answered(&talked, **number)).unwrap();
    let Status { bad_frames, wire: WireErrors { noise, lost }, .. } = talked.status(last);
    assert!(bad_frames > 0 && lost == 0, "{bad_frames} {lost}");
    // Several in one frame count once, and one may hit a byte between two frames.
    assert!(noise > 0 && noise <= bad_frames + 10, "noise {noise}, bad frames {bad_frames}");
}
