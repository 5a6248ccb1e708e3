//! The command link on the image's own USART: what is said is done, and what is garbled costs at most itself.
//!
//! The joint of the bench is blocked: what is looked at are the answers, and the bridge.

use std::sync::{Arc, Mutex};

use host_sim::emulator::bench::{Mishap, Observed, converse};
use host_sim::emulator::board::Fitted;
use stiction::link::{
    CHUNK, Deframer, Message, Numbered, PROTOCOL, Refused, Reply, Request, Sample, StateCode, Status, encode,
};
use stiction::parameters::ROOM;
use stiction::signal::{SIGNALS, index};
use stiction::{Fault, Parameters};

use crate::bench::{MS, firmware, parameters};

/// By then a board has ticked long enough to be armed at 20 ms.
const READY: u64 = 200 * MS;

/// What the bench's board is told, but that it waits for commands; watched for silence alone.
fn commanded(change: impl Fn(&mut Parameters)) -> Parameters {
    let (mut parameters, _) = Parameters::decode(&parameters()).unwrap();
    parameters.device.autostart = false;
    parameters.limits.link_timeout = 0.5;
    change(&mut parameters);
    parameters
}

fn record(parameters: &Parameters) -> Vec<u8> {
    parameters.encode(1, &mut [0; ROOM]).unwrap().to_vec()
}

/// What a client says, each at its time (ns), numbered in this order from 1 on: the first is a hello.
struct Script {
    says: Vec<(u64, Vec<u8>)>,
    number: u16,
}

impl Script {
    fn new() -> Self {
        let mut script = Self { says: vec![], number: 0 };
        script.garbage(READY, &[0]);
        script.say(READY, Request::Hello { protocol: PROTOCOL, session: 7 });
        script
    }

    /// Returns the number that the answer will have.
    fn say(&mut self, at: u64, request: Request) -> u16 {
        self.number += 1;
        let frame = encode(&Numbered { number: self.number, content: request }).unwrap().to_vec();
        self.says.push((at, frame));
        self.number
    }

    fn garbage(&mut self, at: u64, bytes: &[u8]) {
        self.says.push((at, bytes.to_vec()));
    }

    /// A status now and then, so that the link does not fall silent.
    fn status(&mut self, at: std::ops::Range<u64>) -> u16 {
        at.step_by(100 * MS as usize).map(|at| self.say(at, Request::Status)).last().unwrap()
    }

    /// A record in pieces; the number of the answer to its taking.
    fn push(&mut self, at: u64, record: &[u8]) -> u16 {
        for (i, piece) in record.chunks(CHUNK).enumerate() {
            let (offset, bytes) = ((i * CHUNK) as u16, piece.iter().copied().collect());
            self.say(at + i as u64 * 4 * MS, Request::WriteParameters { offset, bytes });
        }
        self.say(at + 20 * MS, Request::TakeParameters { length: record.len() as u16 })
    }

    /// All at once.
    fn burst(&mut self, at: u64, requests: impl IntoIterator<Item = Request>) -> Vec<u16> {
        requests.into_iter().map(|request| self.say(at, request)).collect()
    }

    fn run(self, records: Option<&[u8]>, mishaps: &[(u64, Mishap)], until: u64) -> Talked {
        self.run_on(Fitted::default(), records, mishaps, until)
    }

    fn run_on(self, fitted: Fitted, first: Option<&[u8]>, mishaps: &[(u64, Mishap)], until: u64) -> Talked {
        let heard = Arc::new(Mutex::new((Deframer::default(), vec![])));
        let (mut says, into) = (self.says.into_iter().peekable(), heard.clone());
        let partner = move |at: u64, bytes: &[u8]| {
            let (deframer, messages) = &mut *into.lock().unwrap();
            for &byte in bytes {
                if let Some(message) = deframer.push(byte) {
                    messages.push((at, postcard::from_bytes::<Message>(message).unwrap()));
                }
            }
            let due = std::iter::from_fn(|| says.next_if(|(due, _)| *due <= at));
            due.flat_map(|(_, bytes)| bytes).collect()
        };
        let board = firmware();
        let observed = converse(&board, [first, None], fitted, mishaps, until, Box::new(partner)).unwrap();
        let (deframer, messages) = &*heard.lock().unwrap();
        assert_eq!(deframer.bad(), 0);
        let mut talked = Talked { observed, replies: vec![], samples: vec![] };
        for (at, message) in messages {
            match message.clone() {
                Message::Reply(Numbered { number, content }) => talked.replies.push((*at, number, content)),
                Message::Sample(sample) => talked.samples.push(sample),
            }
        }
        talked
    }
}

struct Talked {
    observed: Observed,
    replies: Vec<(u64, u16, Reply)>,
    samples: Vec<Sample>,
}

impl Talked {
    /// The only answer to a request.
    #[track_caller]
    fn reply(&self, number: u16) -> &Reply {
        let mut replies = self.replies.iter().filter(|(_, of, _)| *of == number);
        match (replies.next(), replies.next()) {
            (Some((.., reply)), None) => reply,
            _ => panic!("{number}: {:?}, log {:?}", self.replies, self.observed.log),
        }
    }

    #[track_caller]
    fn status(&self, number: u16) -> Status {
        let Reply::Status(status) = self.reply(number) else {
            panic!("{:?}, log {:?}, {:?}", self.reply(number), self.observed.log, self.observed.resets)
        };
        *status
    }

    #[track_caller]
    fn assert_done(&self, number: u16) {
        assert_eq!(*self.reply(number), Reply::Done, "{:?}", self.observed.log);
    }

    #[track_caller]
    fn assert_refused(&self, number: u16, why: Refused) {
        assert_eq!(*self.reply(number), Reply::Refused(why));
    }
}

const fn faulted(fault: Fault) -> StateCode {
    StateCode::Faulted(fault as u8)
}

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
    assert!((250 * MS..271 * MS).contains(&on) && (600 * MS..621 * MS).contains(&off), "{on} {off}");
    // It has to come and go on the wire: 11 us for each of some 20 and 60 bytes.
    for ((at, number, _), said) in talked.replies.iter().zip(says) {
        assert!((said..said + MS).contains(at), "{number}: said at {said}, answered at {at}");
    }
}

#[test]
fn garbage_between_frames_costs_only_itself() {
    let mut script = Script::new();
    let mut numbers = vec![];
    let status = |number| encode(&Numbered { number, content: Request::Status }).unwrap().to_vec();
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
    assert!(talked.status(numbers[numbers.len() - 1]).bad_frames > 50, "{:?}", talked.replies.last());
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
    // The last sign of life is at 700 ms; half a second in ticks of 20 ms, the one of the sign included or not.
    let off = talked.observed.off_at_ns().unwrap();
    assert!((1_180 * MS..1_241 * MS).contains(&off), "{off}");
    let status = talked.status(after);
    assert_eq!((status.state, status.fault.code), (faulted(Fault::LinkTimeout), Fault::LinkTimeout as u8));
    assert!((0.5..0.54).contains(&status.fault.value), "{:?}", status.fault);
    assert!(talked.observed.says("faulted: link silent while armed"), "{:?}", talked.observed.log);
}

#[test]
fn without_valid_parameters_arming_is_refused_until_some_come_over_the_link() {
    let mut damaged = record(&commanded(|_| {}));
    damaged[40] ^= 1;
    for (found, fault) in [(None, Fault::NoParameters), (Some(&damaged[..]), Fault::BadParameters)] {
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
        talked.assert_refused(refused, Refused::Faulted(fault as u8));
        talked.assert_refused(uncleared, Refused::NotClearable(fault as u8));
        let Reply::Refused(Refused::Value { key, found, .. }) = talked.reply(bad) else {
            panic!("{:?}", talked.reply(bad));
        };
        assert_eq!((key.to_string().as_str(), *found), ("thermal_s", -1.0));
        assert_eq!((talked.status(still).state, talked.status(still).sample_time), (faulted(fault), 0.0));
        talked.assert_done(good);
        let status = talked.status(ready);
        assert_eq!((status.state, status.unsaved, status.sample_time), (StateCode::Stopped, true, 0.02));
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
    let mishaps = [(500 * MS, Mishap::TickStops)];
    let talked = script.run(Some(&record(&commanded(|_| {}))), &mishaps, 600 * MS);
    talked.assert_done(taken);
    talked.assert_done(arm);
    assert_eq!((talked.status(armed).state, talked.status(armed).sample_time), (StateCode::Armed, 0.001));
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

#[test]
fn a_save_that_the_flash_does_not_keep_is_refused_and_harms_nothing() {
    // The emulated flash says that it has erased and written, and is as it was before. The slowest oscillator and the
    // fastest: with the watchdog of the loop, 60 ms, none of them would live through an erase.
    for lsi_hz in [17_000, 47_000] {
        let other = commanded(|parameters| parameters.limits.link_timeout = 0.6);
        let mut script = Script::new();
        let taken = script.push(250 * MS, &record(&other));
        let save = script.say(300 * MS, Request::Save);
        let after = script.say(3_000 * MS, Request::Status);
        let arm = script.say(3_100 * MS, Request::Arm);
        let armed = script.say(3_200 * MS, Request::Status);
        let mishaps = [(3_300 * MS, Mishap::TickStops)];
        let fitted = Fitted { lsi_hz, ..Fitted::default() };
        let talked = script.run_on(fitted, Some(&record(&commanded(|_| {}))), &mishaps, 3_600 * MS);
        talked.assert_done(taken);
        talked.assert_refused(save, Refused::Flash);
        let status = talked.status(after);
        assert_eq!((status.state, status.fault.code, status.unsaved), (StateCode::Stopped, 0, true));
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
    assert!(talked.replies.iter().all(|(_, number, _)| *number != save), "the erase is not over yet");
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
        talked.assert_refused(save, Refused::Flash);
    }
    talked.assert_done(taken);
    let status = talked.status(after);
    assert_eq!((status.state, status.sample_time), (StateCode::Stopped, 0.02));
    assert!(talked.observed.resets.is_empty(), "{:?}", talked.observed.resets);
    // Each was attempted, which takes a second.
    let at = |number| talked.replies.iter().find(|(_, of, _)| *of == number).map(|(at, ..)| *at).unwrap();
    assert!(at(second) - at(taken) > 1_000 * MS && at(third) - at(second) > 1_000 * MS);
}

#[test]
fn the_joint_has_to_rest_anew_after_a_save_before_it_is_armed() {
    let mut script = Script::new();
    script.push(220 * MS, &record(&commanded(|parameters| parameters.limits.link_timeout = 0.6)));
    let [save, arm] = script.burst(400 * MS, [Request::Save, Request::Arm])[..] else { panic!() };
    let later = script.say(2_700 * MS, Request::Arm);
    let talked = script.run(Some(&record(&commanded(|_| {}))), &[], 2_800 * MS);
    talked.assert_refused(save, Refused::Flash);
    // It was attempted: the ticks stood still for the erase.
    assert!(talked.observed.ticks_ns.windows(2).any(|pair| pair[1] - pair[0] > 1_000 * MS));
    talked.assert_refused(arm, Refused::Moving);
    talked.assert_done(later);
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
    // 40 ms of the wire, without a pause in which the log would have its turn: with the fastest oscillator, the watchdog
    // waits for 10. What finds no room is not answered.
    let armed = script.burst(500 * MS, (0..400).map(|_| take()));
    let last = script.status(600 * MS..700 * MS);
    let fitted = Fitted { lsi_hz: 47_000, ..Fitted::default() };
    let talked = script.run_on(fitted, Some(&fast), &[], 700 * MS);
    assert!(talked.observed.resets.is_empty(), "{:?}", talked.observed.resets);
    for number in [taken, arm].into_iter().chain(while_off) {
        talked.assert_done(number);
    }
    let answers: Vec<_> = talked.replies.iter().filter(|(_, number, _)| armed.contains(number)).collect();
    assert!(answers.len() > 24, "{}", answers.len());
    assert!(answers.iter().all(|(.., reply)| *reply == Reply::Refused(Refused::Armed)), "{answers:?}");
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
    let (break_, released) = (Mishap::Break, Mishap::BreakReleased);
    let mishaps = [(300 * MS, break_), (400 * MS, released), (600 * MS, break_), (610 * MS, released)];
    let talked = script.run(Some(&record(&commanded(|_| {}))), &mishaps, 700 * MS);
    let broken = faulted(Fault::BreakInput);
    talked.assert_done(arm);
    // While it is pulled, clearing it trips it again.
    talked.assert_done(early);
    assert_eq!(talked.status(pulled).state, broken);
    talked.assert_refused(refused, Refused::Faulted(Fault::BreakInput as u8));
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
    let told = script.say(306 * MS, Request::Status);
    let refused = script.say(307 * MS, Request::Arm);
    let clear = script.say(350 * MS, Request::Clear);
    let again = script.say(360 * MS, Request::Arm);
    // All of it between two ticks: what was on, tripped, was cleared and armed anew is on.
    let cleared = script.say(406 * MS, Request::Clear);
    let anew = script.say(407 * MS, Request::Arm);
    let armed = script.status(450 * MS..500 * MS);
    let (break_, released, short) = (Mishap::Break, Mishap::BreakReleased, MS / 5);
    let mishaps = [305, 405].map(|at| [(at * MS, break_), (at * MS + short, released)]).concat();
    let talked = script.run(Some(&record(&commanded(|_| {}))), &mishaps, 500 * MS);
    talked.assert_done(arm);
    assert_eq!(talked.status(told).state, faulted(Fault::BreakInput));
    talked.assert_refused(refused, Refused::Faulted(Fault::BreakInput as u8));
    assert!(talked.observed.says(Fault::BreakInput.describe()), "{:?}", talked.observed.log);
    for number in [clear, again, cleared, anew] {
        talked.assert_done(number);
    }
    let status = talked.status(armed);
    assert_eq!((status.state, status.faults), (StateCode::Armed, 2));
    let [first, second, third] = talked.observed.on_ns[..] else { panic!("{:?}", talked.observed.on_ns) };
    assert!(first[1].abs_diff(305 * MS) < short && second[1].abs_diff(405 * MS) < short);
    assert!(second[0] > 360 * MS && third[0] > 407 * MS && talked.observed.on_after(480 * MS));
}

/// Those of every loop.
const EVERY_SIGNAL: u64 = (1 << SIGNALS.len()) - 1;

#[test]
fn samples_are_of_the_ticks_that_were_asked_for_and_hold_up_nothing() {
    let fast = commanded(|parameters| parameters.controller.sample_time = 0.001);
    let mut script = Script::new();
    let arm = script.say(250 * MS, Request::Arm);
    let subscribe = script.say(300 * MS, Request::Subscribe { signals: EVERY_SIGNAL, every: 1 });
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
    let ticks: Vec<u64> = talked.observed.ticks_ns.iter().copied().filter(|at| *at > 300 * MS).collect();
    let late = ticks.windows(2).map(|pair| (pair[1] - pair[0]).abs_diff(MS)).max().unwrap();
    assert!(late < 1_000, "{late} ns");
}

#[test]
fn at_ten_kilohertz_the_loop_goes_on_whatever_the_link_is_asked() {
    // More than the wire carries: 89 bytes of each tick of 0.1 ms, of which 9 find room. And 0.1 ms is what a record takes
    // to be validated many times over.
    let fastest = commanded(|parameters| parameters.controller.sample_time = 0.0001);
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
    talked.assert_refused(refused, Refused::Armed);
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
