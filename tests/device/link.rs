//! The link: what is said is done once, and what is garbled costs at most itself.

use std::time::Duration;

use host_sim::device::client::Client;
use host_sim::device::log::Log;
use host_sim::device::signals::Signals;
use host_sim::device::simulated::SimulatedDevice;
use host_sim::device::wire::{SimulatedWire, Wire};
use host_sim::experiment::Motion as Asked;
use host_sim::solver::ExactAxis;
use stiction::compensator::{
    FIRST_LAW, Gains, ResetIntegralGains, ResetOffsetIntegralGains, SmoothRobustNonlinearGains,
};
use stiction::link::{Deframer, Message, Numbered, PROTOCOL, Refused, Reply, Request, State, encode};
use stiction::parameters::DeviceConfig;
use stiction::pd::PdGains;
use stiction::position::Position;
use stiction::servo::{self, Boot, Levels};
use stiction::signal::{Form, SIGNALS, index};
use stiction::value::{Key, Table, key};
use stiction::{Fault, Limits, Motion};

use crate::fixture::{blank, plans, srnf, stored};

/// Every signal of a loop.
const ALL: u64 = (1 << SIGNALS.len()) - 1;

fn simulated() -> SimulatedDevice {
    let plan = &plans("step-response", &["loop.controller=srnf", "reference.steps_deg=[5.0]"])[0];
    let mut simulated = SimulatedDevice::new(plan).unwrap();
    simulated.ticks(10);
    simulated
}

fn client() -> Client<SimulatedWire> {
    Client::connect(SimulatedWire::new(simulated())).unwrap()
}

fn frame(number: u16, content: Request) -> Vec<u8> {
    encode(&Numbered { number, content }).unwrap().to_vec()
}

fn hello(number: u16, session: u32) -> Vec<u8> {
    frame(number, Request::Hello { protocol: PROTOCOL, session })
}

/// What a device answers to bytes.
fn say(simulated: &mut SimulatedDevice, bytes: &[u8]) -> Vec<(u16, Reply)> {
    simulated.device.receive(bytes);
    let (mut deframer, mut buffer, mut replies) = (Deframer::default(), [0; 4096], vec![]);
    let count = simulated.device.transmit(&mut buffer);
    for &byte in &buffer[..count] {
        if let Some(message) = deframer.push(byte)
            && let Message::Reply(Numbered { number, content }) = postcard::from_bytes(message).unwrap()
        {
            replies.push((number, content));
        }
    }
    assert_eq!(deframer.bad(), 0);
    replies
}

fn refused(number: u16, why: Refused) -> Vec<(u16, Reply)> {
    vec![(number, Reply::Refused(why))]
}

#[test]
fn a_client_arms_moves_and_stops_a_joint() {
    let mut client = client();
    assert_eq!(client.status().unwrap().state, State::Stopped);
    client.arm().unwrap();
    client.step_to(5.0).unwrap();
    let status = client.pass(Duration::from_secs(3)).unwrap();
    assert_eq!((status.state, status.at_rest, status.unsaved), (State::Armed, true, false));
    let error = client.wire().simulated.position_deg() - 5.0;
    assert!(error.abs() < 0.01, "{error}");
    client.stop().unwrap();
    assert_eq!(client.status().unwrap().state, State::Stopped);
    assert_eq!(client.faults().unwrap(), []);
}

#[test]
fn a_hold_stops_the_joint_where_it_is() {
    let mut client = client();
    client.arm().unwrap();
    client.step_to(10.0).unwrap();
    client.pass(Duration::from_millis(600)).unwrap();
    let at = client.wire().simulated.position_deg();
    client.hold().unwrap();
    client.pass(Duration::from_secs(3)).unwrap();
    let after = client.wire().simulated.position_deg();
    // It was on its way, and a joint that is stopped from 20 deg/s overshoots by less than 0.46 (20 / 5.2) = 1.8 deg;
    // then it comes back.
    assert!(at > 2.0 && at < 9.0, "{at}");
    // Where it was at the last tick, that is, up to 20 ms at 25 deg/s before.
    assert!((after - at).abs() < 0.5, "{at} {after}");
    assert_eq!(client.status().unwrap().state, State::Armed);
}

#[test]
fn without_a_hello_only_stop_is_obeyed() {
    let mut simulated = simulated();
    assert_eq!(say(&mut simulated, &frame(1, Request::Arm)), refused(1, Refused::SayHello));
    assert_eq!(say(&mut simulated, &frame(2, Request::Stop)), [(2, Reply::Done)]);
    let other = frame(3, Request::Hello { protocol: PROTOCOL + 1, session: 1 });
    let [(3, Reply::Hello(identity))] = &say(&mut simulated, &other)[..] else { panic!() };
    assert_eq!(identity.protocol, PROTOCOL);
    assert_eq!(say(&mut simulated, &frame(4, Request::Arm)), refused(4, Refused::SayHello));
}

#[test]
fn a_request_that_comes_twice_is_done_once() {
    let mut simulated = simulated();
    say(&mut simulated, &hello(1, 7));
    let arm = frame(2, Request::Arm);
    assert_eq!(say(&mut simulated, &arm), [(2, Reply::Done)]);
    simulated.device.servo().stop();
    // The same answer, but it is not armed again.
    assert_eq!(say(&mut simulated, &arm), [(2, Reply::Done)]);
    assert!(!simulated.tick().enable);
    // Nor does the hello, come twice, begin a new session in which old requests would count again.
    say(&mut simulated, &frame(3, Request::Status));
    say(&mut simulated, &hello(1, 7));
    assert_eq!(say(&mut simulated, &arm), refused(2, Refused::OutOfOrder));
}

#[test]
fn a_stop_is_obeyed_however_late_and_an_arm_that_it_overtook_is_not() {
    let mut simulated = simulated();
    say(&mut simulated, &hello(1, 7));
    say(&mut simulated, &frame(9, Request::Arm));
    assert!(simulated.tick().enable);
    assert_eq!(say(&mut simulated, &frame(2, Request::Stop)), [(2, Reply::Done)]);
    assert!(!simulated.tick().enable);
    assert_eq!(say(&mut simulated, &frame(11, Request::Stop)), [(11, Reply::Done)]);
    assert_eq!(say(&mut simulated, &frame(10, Request::Arm)), refused(10, Refused::OutOfOrder));
    assert!(!simulated.tick().enable);
}

#[test]
fn garbage_costs_at_most_the_frame_that_it_touches() {
    let status = |number| frame(number, Request::Status);
    let numbers = |simulated: &mut SimulatedDevice, bytes: &[u8]| {
        let replies = say(simulated, bytes);
        replies.into_iter().map(|(number, _)| number).collect::<Vec<_>>()
    };
    let mut simulated = simulated();
    say(&mut simulated, &hello(1, 7));
    let mut number = 1;
    // Every bit of a frame changed, every cut, and a frame of garbage that has no end: the next frame is whole.
    let length = status(2).len();
    for bit in 0..8 * length {
        let (mut broken, sound) = (status(number + 1), status(number + 2));
        let at = bit / 8;
        if at >= broken.len() {
            continue;
        }
        broken[at] ^= 1 << (bit % 8);
        number += 2;
        let heard = numbers(&mut simulated, &[broken, vec![0], sound].concat());
        assert_eq!(heard, [number], "bit {bit}");
    }
    for cut in 0..length - 1 {
        let heard =
            numbers(&mut simulated, &[&status(number + 1)[..cut], &[0], &status(number + 2)].concat());
        number += 2;
        assert_eq!(heard, [number], "cut {cut}");
    }
    let heard = numbers(&mut simulated, &[vec![0x55; 10_000], vec![0], status(number + 1)].concat());
    assert_eq!(heard, [number + 1]);
    // Whole, but nothing that is known.
    let strange = encode(&(number + 2, 200u8)).unwrap();
    assert_eq!(say(&mut simulated, &strange), refused(number + 2, Refused::Unknown));
}

#[test]
fn parameters_come_over_the_link_as_a_whole_or_not_at_all() {
    let plan = &plans("step-response", &["loop.controller=srnf", "reference.steps_deg=[5.0]"])[0];
    let simulated = SimulatedDevice::with(plan, blank(), Boot::default()).unwrap();
    let mut client = Client::connect(SimulatedWire::new(simulated)).unwrap();
    // Without any: the fault is shown, and arming refused.
    let message = client.arm().unwrap_err().to_string();
    assert!(message.contains("no parameters") && message.contains("docs/faults.md"), "{message}");
    assert!(client.clear().is_err());

    let good = srnf(&[]);
    client.set_parameters(&good).unwrap();
    let status = client.pass(Duration::from_millis(200)).unwrap();
    assert_eq!((status.state, status.unsaved), (State::Stopped, true));
    assert_eq!(client.parameters().unwrap(), good);

    // One bad value: refused with its key, and everything is as it was.
    let mut bad = srnf(&["controller.srnf.kp_v_per_deg=2"]);
    bad.limits.thermal_time = -1.0;
    let message = client.set_parameters(&bad).unwrap_err().to_string();
    assert!(message.contains("`thermal_s` is -1; allowed is a number from 0.1 to 100"), "{message}");
    assert_eq!(client.parameters().unwrap(), good);

    // A frequency that its timer cannot make.
    let mut slow = srnf(&[]);
    slow.controller.drive.pwm_hz = 1000.0;
    let message = client.set_parameters(&slow).unwrap_err().to_string();
    assert!(message.contains("`pwm_hz` is 1000; allowed is a number from 1300 to 5250000"), "{message}");
    assert_eq!(client.parameters().unwrap(), good);

    // While armed nothing is taken or saved.
    client.arm().unwrap();
    assert!(client.set_parameters(&good).unwrap_err().to_string().contains("`stop` first"));
    assert!(client.save().unwrap_err().to_string().contains("`stop` first"));
    client.stop().unwrap();
    client.save().unwrap();
    assert!(!client.status().unwrap().unsaved);
}

/// A record that another board could run: it is decoded, and refused where the timer is known.
#[test]
fn a_device_whose_flash_asks_for_a_frequency_that_its_timer_cannot_make_is_faulted() {
    let plan = &plans("step-response", &["loop.controller=srnf"])[0];
    let mut slow = srnf(&[]);
    slow.controller.drive.pwm_hz = 1000.0;
    let mut simulated = SimulatedDevice::with(plan, stored(&slow), Boot::default()).unwrap();
    let output = simulated.ticks(50);
    assert_eq!(output.state, servo::State::Faulted(Fault::BadParameters));
    assert!(!output.enable && simulated.device.servo().arm().is_err());
}

#[test]
fn parameters_last_until_the_reset_unless_they_are_saved() {
    let plan = &plans("step-response", &["loop.controller=srnf", "reference.steps_deg=[5.0]"])[0];
    let (first, second) = (srnf(&[]), srnf(&["controller.srnf.v_ms_v=0.3"]));
    for save in [false, true] {
        let mut store = blank();
        store.save(&first).unwrap();
        let simulated = SimulatedDevice::with(plan, store, Boot::default()).unwrap();
        let mut client = Client::connect(SimulatedWire::new(simulated)).unwrap();
        client.set_parameters(&second).unwrap();
        if save {
            client.save().unwrap();
        }
        assert_eq!(client.parameters().unwrap(), second);
        let store = client.end().simulated.device.end();
        let simulated = SimulatedDevice::with(plan, store, Boot::default()).unwrap();
        let found = simulated.device.parameters().unwrap();
        assert_eq!(found, if save { &second } else { &first });
    }
}

fn gains(v_ms: f32, alpha: f32) -> Gains {
    Gains::SmoothRobustNonlinear(SmoothRobustNonlinearGains { v_ms, alpha })
}

const RI: Gains = Gains::ResetIntegral(ResetIntegralGains { ki: 3.0, theta_ri: 0.25 });
const ROI: Gains = Gains::ResetOffsetIntegral(ResetOffsetIntegralGains { t_roi: 0.2, v_roi: 1.5 });

/// Which law is in a place of the sum; zero is none.
fn law(place: u16, law: Option<Gains>) -> (Key, u32) {
    (Key(FIRST_LAW.0 + place), law.map_or(0, |law| law.id().into()))
}

fn number(key: Key, value: f32) -> (Key, u32) {
    (key, value.to_bits())
}

const KP: Key = key(PdGains::ABOUT, "kp");
const KI: Key = key(ResetIntegralGains::ABOUT, "ki");
const THETA_RI: Key = key(ResetIntegralGains::ABOUT, "theta_ri");

#[test]
fn values_are_changed_by_their_numbers_while_stopped_and_the_others_stay() {
    let mut client = client();
    let before = client.parameters().unwrap();
    let soft_start = key(DeviceConfig::ABOUT, "soft_start");
    client.change(&[number(KP, 2.0), number(soft_start, 0.25)]).unwrap();
    let mut expected = before;
    (expected.controller.pd.kp, expected.device.soft_start) = (2.0, 0.25);
    assert_eq!(client.parameters().unwrap(), expected);
    let status = client.status().unwrap();
    assert_eq!((status.state, status.unsaved), (State::Stopped, true));

    // The loop runs with it: 1.5 deg under 2 V/deg.
    client.change(&[law(0, None)]).unwrap();
    client.pass(Duration::from_millis(200)).unwrap();
    client.arm().unwrap();
    assert!(client.change(&[number(KP, 1.0)]).unwrap_err().to_string().contains("`stop` first"));
    client.step_to(1.5).unwrap();
    let output = client.wire().simulated.tick();
    assert!((output.tick.v_pd - 3.0).abs() < 1e-5, "{}", output.tick.v_pd);
}

#[test]
fn a_change_with_a_value_that_is_not_allowed_changes_nothing() {
    let mut client = client();
    let before = client.parameters().unwrap();
    let thermal = key(Limits::ABOUT, "thermal_time");
    for (entries, said) in [
        (vec![number(KP, f32::NAN)], "`kp_v_per_deg` is NaN; allowed is a number from 0 to 1000000"),
        (
            vec![number(KP, 2.0), number(thermal, -1.0)],
            "`thermal_s` is -1; allowed is a number from 0.1 to 100",
        ),
        (
            vec![number(thermal, 0.0), number(KP, 2.0)],
            "`thermal_s` is 0; allowed is a number from 0.1 to 100",
        ),
        (vec![number(KP, 2.0), (Key(0x087F), 0)], "does not know `value 0x087f`"),
        // A gain of a law that is not there.
        (vec![number(KP, 2.0), number(KI, 1.0)], "does not know `ki_v_per_deg_s`"),
        (vec![number(KP, 2.0), law(1, Some(gains(0.4, 100.0)))], "is 6; allowed is"),
    ] {
        let message = client.change(&entries).unwrap_err().to_string();
        assert!(message.contains(said), "{said}: {message}");
        assert_eq!(client.parameters().unwrap(), before, "{said}");
    }
    assert!(!client.status().unwrap().unsaved);
}

#[test]
fn a_law_is_replaced_by_its_number_with_all_of_its_gains() {
    let mut client = client();
    let laws = |client: &mut Client<SimulatedWire>| {
        let parameters = client.parameters().unwrap();
        parameters.controller.compensator.iter().copied().collect::<Vec<_>>()
    };
    assert_eq!(laws(&mut client), [gains(0.4, 100.0)]);
    let message = client.change(&[law(0, Some(RI)), number(KI, 3.0)]).unwrap_err().to_string();
    assert!(message.contains("`theta_ri_deg` is missing"), "{message}");
    assert_eq!(laws(&mut client), [gains(0.4, 100.0)]);
    client.change(&[law(0, Some(RI)), number(KI, 3.0), number(THETA_RI, 0.25)]).unwrap();
    assert_eq!(laws(&mut client), [RI]);
    // One gain alone, and none of the others.
    client.change(&[number(THETA_RI, 0.5)]).unwrap();
    let wider = Gains::ResetIntegral(ResetIntegralGains { ki: 3.0, theta_ri: 0.5 });
    assert_eq!(laws(&mut client), [wider]);
    client.change(&[law(0, None)]).unwrap();
    assert_eq!(laws(&mut client), []);
}

#[test]
fn a_law_of_a_sum_keeps_its_gains_in_another_place_and_its_place_when_another_law_is_replaced() {
    let mut client = client();
    let laws = |client: &mut Client<SimulatedWire>| {
        let parameters = client.parameters().unwrap();
        parameters.controller.compensator.iter().copied().collect::<Vec<_>>()
    };
    let srnf = gains(0.3, 50.0);
    let mut three = client.parameters().unwrap();
    three.controller.compensator = [srnf, RI, ROI].into_iter().collect();
    client.set_parameters(&three).unwrap();
    client.change(&[law(0, Some(ROI)), law(1, Some(srnf)), law(2, Some(RI))]).unwrap();
    assert_eq!(laws(&mut client), [ROI, srnf, RI]);
    client.change(&[law(1, Some(RI)), law(2, None)]).unwrap();
    assert_eq!(laws(&mut client), [ROI, RI]);
    let [v_ms, alpha] = ["v_ms", "alpha"].map(|field| key(SmoothRobustNonlinearGains::ABOUT, field));
    client.change(&[law(0, Some(srnf)), number(v_ms, 0.3), number(alpha, 50.0)]).unwrap();
    assert_eq!(laws(&mut client), [srnf, RI]);
}

/// A move that holds is no move to zero.
#[test]
fn a_move_that_holds_stays_where_the_joint_is_however_often_it_is_said() {
    let mut client = client();
    client.arm().unwrap();
    client.step_to(5.0).unwrap();
    client.pass(Duration::from_secs(3)).unwrap();
    let at = client.wire().simulated.position_deg();
    assert!((at - 5.0).abs() < 0.03, "{at}");
    for _ in 0..3 {
        client.move_along(Motion::Hold).unwrap();
        let counts = client.status().unwrap().position;
        assert_eq!(client.wire().simulated.tick().tick.reference_counts, counts);
        client.pass(Duration::from_secs(2)).unwrap();
        let after = client.wire().simulated.position_deg();
        assert!((after - at).abs() < 0.03, "{at} {after}");
    }
}

/// One that the parameters have holds where the joint is armed, also far from where it was at power-on.
#[test]
fn a_motion_of_the_parameters_that_holds_stays_where_the_joint_is_armed() {
    let mut client = client();
    let parameters = stiction::Parameters { motion: Motion::Hold, ..client.parameters().unwrap() };
    client.set_parameters(&parameters).unwrap();
    client.wire().simulated.push(10.0, 0.0);
    client.pass(Duration::from_secs(1)).unwrap();
    let at = client.wire().simulated.position_deg();
    client.wire().simulated.device.servo().arm().unwrap();
    client.pass(Duration::from_secs(2)).unwrap();
    let after = client.wire().simulated.position_deg();
    assert!(at > 9.0 && (after - at).abs() < 1e-9, "{at} {after}");
    assert_eq!(client.status().unwrap().state, State::Armed);
}

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
    ] {
        let found = &signals[index(place)];
        assert_eq!((&*found.name, &*found.unit, found.form), (name, unit, form), "{place}");
    }
    // A name says its unit at its end, and none is there twice.
    for (i, signal) in signals.iter().enumerate() {
        let written = match &*signal.unit {
            "deg" => "_deg",
            "deg/s" => "_deg_per_s",
            "deg/s^2" => "_deg_per_s2",
            "V" => "_v",
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
        assert!(message.contains("there is no such thing"), "{message}");
    }
    client.subscribe(ALL, 1).unwrap();
}

/// Everything that it knows of the signals is what the device has announced.
#[test]
fn a_client_without_a_table_logs_what_is_applied_by_its_name() {
    let mut client = client();
    let mut log = Log::new(Signals::new(client.signals().unwrap()), &["compare".into()]).unwrap();
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
    // One of five ticks of 20 ms.
    assert!((9..=11).contains(&samples.len()), "{}", samples.len());
    assert_eq!(client.lost(), 0);
    for pair in samples.windows(2) {
        assert_eq!((pair[1].number, pair[1].clock), (pair[0].number + 1, pair[0].clock + 5));
    }
    let counts = |i: usize| samples[i].value(counts).unwrap() as i32;
    assert!(counts(samples.len() - 1) > counts(0) + 1000);
    assert_eq!(samples[2].value(index("error")), None);
    // Armed, and the bridge is on.
    assert_eq!(samples[2].value(status).unwrap() & 0x4_00FF, 0x4_0002);
}

#[test]
fn samples_that_nobody_takes_are_dropped_and_counted_and_answers_are_not() {
    let mut simulated = simulated();
    say(&mut simulated, &hello(1, 7));
    say(&mut simulated, &frame(2, Request::Subscribe { signals: ALL, every: 1 }));
    simulated.ticks(1000);
    let [(3, Reply::Status(status))] = &say(&mut simulated, &frame(3, Request::Status))[..] else { panic!() };
    assert!(status.dropped > 900 && status.dropped < 1000, "{}", status.dropped);
}

#[test]
fn a_move_says_where_and_not_how_far() {
    let mut client = client();
    client.arm().unwrap();
    for _ in 0..3 {
        client.move_along(Motion::Step(Position::from_counts(1000))).unwrap();
        client.pass(Duration::from_secs(2)).unwrap();
    }
    let position = client.status().unwrap().position;
    assert!((position - 1000).abs() < 5, "{position}");
}

/// Lets a ramp run to its end.
fn identified(client: &mut Client<SimulatedWire>) -> Option<Levels> {
    while client.pass(Duration::from_secs(1)).unwrap().state == State::Armed {}
    client.levels().unwrap()
}

/// The second method is the simulator's: the same joint under the core's ramp, without a servo, monitors or a link.
#[test]
fn a_ramp_over_the_link_finds_the_levels_of_the_experiment() {
    for plan in plans("friction-identification", &[]) {
        let Asked::Ramp(rate) = plan.motion else { panic!() };
        let (ramp, around) = (plan.ramp(rate).unwrap(), plan.closed_loop().unwrap());
        let mut solver = ExactAxis::at_rest(&around.axis, around.sample_time_s);
        let expected = ramp.run(&mut solver, &around, |_| {}, |_| {});

        let mut client = client();
        assert_eq!(client.levels().unwrap(), None);
        client.identify(ramp.rate as f32, ramp.hold_s as f32).unwrap();
        let found = identified(&mut client).unwrap();
        let status = client.status().unwrap();
        assert_eq!((status.state, status.faults, status.at_rest), (State::Stopped, 0, true));
        // Levels are whole rungs: the same ones, and their volts to single precision.
        let rung_v = rate * around.sample_time_s;
        for (found, expected) in [(found.stick, expected.stick_v), (found.slip, expected.slip_v)] {
            let (found, expected) = (f64::from(found.unwrap()), expected.unwrap());
            assert_eq!((found / rung_v).round(), (expected / rung_v).round(), "{rate}: {found} {expected}");
            assert!((found - expected).abs() < 1e-6 * expected, "{rate}: {found} {expected}");
        }
        // Stick is late by what the effort rises until a count is seen, slip by the joint's lag of 1.85 s; half an LSB.
        let (stick, slip) = (f64::from(found.stick.unwrap()), f64::from(found.slip.unwrap()));
        assert!(stick > 0.40 - 0.0025 && stick < 0.40 + 0.0025 + 0.6 * rate, "{rate}: {stick}");
        assert!(slip < 0.38 + 0.0025 && slip > 0.38 - 0.0025 - 2.5 * rate, "{rate}: {slip}");
    }
}

#[test]
fn a_ramp_begins_like_arming_and_obeys_nothing_but_a_stop() {
    let said = |error: host_sim::Error| error.to_string();
    let mut client = client();
    // Faster than the output's limit may rise after arming: 5 V in 0.5 s.
    let message = said(client.identify(10.1, 1.0).unwrap_err());
    assert!(message.contains("`ramp_rates_v_per_s` is 10.1; allowed is a number from 0 to 10"), "{message}");
    assert!(said(client.identify(0.02, -1.0).unwrap_err()).contains("`hold_s` is -1"));

    // From stopped, at rest and without a fault only.
    client.arm().unwrap();
    assert!(said(client.identify(0.02, 1.0).unwrap_err()).contains("`stop` first"));
    client.stop().unwrap();
    client.wire().simulated.push(0.0, 20.0);
    client.wire().simulated.ticks(5);
    assert!(said(client.identify(0.02, 1.0).unwrap_err()).contains("at rest"));
    client.pass(Duration::from_secs(10)).unwrap();
    client.wire().simulated.device.servo().fault(Fault::Overrun);
    assert!(said(client.identify(0.02, 1.0).unwrap_err()).contains("fault 5"));
    client.clear().unwrap();

    // On the way no move is taken, and the ramp goes on.
    client.identify(0.1, 1.0).unwrap();
    client.pass(Duration::from_secs(1)).unwrap();
    assert!(said(client.step_to(1.0).unwrap_err()).contains("`stop` first"));
    assert!(said(client.hold().unwrap_err()).contains("`stop` first"));
    assert_eq!((client.levels().unwrap(), client.status().unwrap().state), (None, State::Armed));
    let found = identified(&mut client).unwrap();
    assert!(found.stick.is_some() && found.slip.is_some(), "{found:?}");

    // One that is stopped has found nothing; nor has the one before it.
    client.identify(0.1, 1.0).unwrap();
    client.pass(Duration::from_secs(1)).unwrap();
    client.stop().unwrap();
    assert!(!client.wire().simulated.tick().enable);
    assert_eq!(client.levels().unwrap(), None);

    // Nobody is there: the output goes off after 0.5 s, as for any arming by a link.
    client.identify(0.1, 1.0).unwrap();
    client.wire().simulated.ticks(24);
    assert!(client.wire().simulated.tick().enable);
    assert!(!client.wire().simulated.ticks(2).enable);
    assert_eq!(client.status().unwrap().fault.code, Fault::LinkTimeout as u8);
}

/// A ramp against a block gives up by the impulse without a count, long before the full scale.
#[test]
fn a_ramp_against_a_block_stalls() {
    let mut client = client();
    client.wire().simulated.brake_v = 100.0;
    client.identify(0.1, 1.0).unwrap();
    assert_eq!(identified(&mut client), None);
    let fault = client.status().unwrap().fault;
    assert_eq!(fault.code, Fault::Stall as u8);
    // 0.1 V/s beyond the breakaway effort of 0.4 V, and 0.2 V s to be had: 0.05 V for the first half of a second, and
    // e^2/2r - 0.05^2/2r after it. That is 0.194 V, within 2 % for codes of 4.88 mV.
    assert!((0.590..0.598).contains(&fault.value), "{}", fault.value);
}

/// Answers wait in a ring of 2 KiB. Those that a wire does not take in time are lost; the request is done all the same,
/// and the client that says it again gets its answer.
#[test]
fn an_answer_that_found_no_room_comes_when_the_request_is_repeated() {
    let mut simulated = simulated();
    say(&mut simulated, &hello(1, 7));
    // 14 answers of some 140 bytes each fill the ring; then, one that counts.
    for number in 2..40 {
        simulated.device.receive(&frame(number, Request::ReadParameters { offset: 0 }));
    }
    simulated.device.receive(&frame(40, Request::Arm));
    assert!(simulated.tick().enable, "done, though nobody will hear of it");
    let mut sink = [0; 4096];
    let waited = simulated.device.transmit(&mut sink);
    assert!((1800..=2048).contains(&waited), "{waited}");
    simulated.device.servo().stop();
    // The same number: the answer, and nothing done a second time.
    assert_eq!(say(&mut simulated, &frame(40, Request::Arm)), [(40, Reply::Done)]);
    assert!(!simulated.tick().enable);
    let [(41, Reply::Status(status))] = &say(&mut simulated, &frame(41, Request::Status))[..] else {
        panic!()
    };
    assert!((20..30).contains(&status.dropped), "{}", status.dropped);
}

/// A wire that loses the first answer to every request.
struct Lossy {
    wire: SimulatedWire,
    said: Vec<u8>,
    lost: u32,
}

impl Wire for Lossy {
    fn send(&mut self, bytes: &[u8]) -> Result<(), host_sim::Error> {
        self.wire.send(bytes)?;
        if self.said != bytes {
            self.said = bytes.to_vec();
            self.lost += u32::from(!self.wire.receive(Duration::ZERO)?.is_empty());
        }
        Ok(())
    }

    fn receive(&mut self, at_most: Duration) -> Result<Vec<u8>, host_sim::Error> {
        self.wire.receive(at_most)
    }

    fn name(&self) -> String {
        "a lossy wire".into()
    }

    fn warning(&self) -> Option<&'static str> {
        None
    }
}

#[test]
fn a_client_repeats_itself_until_it_is_answered_and_nothing_is_done_twice() {
    let wire = Lossy { wire: SimulatedWire::new(simulated()), said: vec![], lost: 0 };
    let mut client = Client::connect(wire).unwrap();
    client.arm().unwrap();
    client.step_to(2.5).unwrap();
    client.pass(Duration::from_secs(3)).unwrap();
    let position = client.wire().wire.simulated.position_deg();
    assert!((position - 2.5).abs() < 0.03, "{position}");
    client.set_parameters(&srnf(&[])).unwrap_err();
    client.stop().unwrap();
    client.set_parameters(&srnf(&[])).unwrap();
    assert_eq!(client.status().unwrap().bad_frames, 0);
    let lost = client.wire().lost;
    assert!(lost > 20, "{lost}");
}

/// A wire of 921 600 baud: ten bits a byte, so many bytes in the time of a tick.
struct Metered {
    simulated: SimulatedDevice,
    bytes_per_tick: f64,
    room: f64,
}

impl Wire for Metered {
    fn send(&mut self, bytes: &[u8]) -> Result<(), host_sim::Error> {
        self.simulated.device.receive(bytes);
        Ok(())
    }

    fn receive(&mut self, at_most: Duration) -> Result<Vec<u8>, host_sim::Error> {
        let ticks = (at_most.as_secs_f64() / self.simulated.sample_time_s()).ceil() as u32;
        let mut taken = vec![];
        for _ in 0..ticks {
            self.simulated.tick();
            // What the line could have carried while there was nothing to send is gone.
            self.room = self.room.fract() + self.bytes_per_tick;
            let mut buffer = vec![0; self.room as usize];
            let count = self.simulated.device.transmit(&mut buffer);
            self.room -= count as f64;
            taken.extend(&buffer[..count]);
        }
        Ok(taken)
    }

    fn name(&self) -> String {
        "a wire of 921 600 baud".into()
    }

    fn warning(&self) -> Option<&'static str> {
        None
    }
}

#[test]
fn the_wire_carries_every_signal_of_every_tick_at_1_khz_and_what_it_does_not_at_5_khz_is_counted() {
    let every = |sample_time: f64| {
        let sampled = format!("loop.sample_time_s={sample_time}");
        let set = [&*sampled, "loop.controller=pd", "reference.steps_deg=[5.0]"];
        let mut simulated = SimulatedDevice::new(&plans("step-response", &set)[0]).unwrap();
        simulated.ticks(1000);
        let wire = Metered { simulated, bytes_per_tick: 92_160.0 * sample_time, room: 0.0 };
        let mut client = Client::connect(wire).unwrap();
        client.subscribe(ALL, 1).unwrap();
        client.pass(Duration::from_secs(10)).unwrap();
        let samples: Vec<_> = std::iter::from_fn(|| client.sample(Duration::ZERO).unwrap()).collect();
        // Every gap is one that was counted.
        let span = u64::from(samples[samples.len() - 1].number) + 1;
        assert_eq!(span, samples.len() as u64 + client.lost());
        (samples.len() as f64, client.lost() as f64, f64::from(client.status().unwrap().dropped))
    };
    let (samples, lost, dropped) = every(1e-3);
    reliability!("baud", khz = 1, samples, lost);
    assert!(samples > 9_900.0 && lost == 0.0 && dropped == 0.0, "{samples} {lost}");
    // A sample of 72 bytes of values takes 86 to 89 on the wire: 1036 to 1072 go through in a second, less the answers.
    let (samples, lost, dropped) = every(2e-4);
    reliability!("baud", khz = 5, samples, lost);
    assert!((10_200.0..10_720.0).contains(&samples), "{samples}");
    assert!((samples + lost - 50_000.0).abs() < 500.0 && dropped >= lost, "{samples} {lost} {dropped}");
}

#[test]
fn samples_of_an_earlier_subscription_are_neither_kept_nor_missed_by_the_next_one() {
    let mut client = client();
    let (signals, so_much) = (1 << index("counts"), Duration::from_millis(200));
    client.subscribe(signals, 1).unwrap();
    client.pass(so_much).unwrap();
    // On their way when the next one is asked for.
    client.wire().simulated.ticks(5);
    client.subscribe(signals, 1).unwrap();
    client.pass(so_much).unwrap();
    let numbers: Vec<u32> = std::iter::from_fn(|| client.kept()).map(|sample| sample.number).collect();
    assert_eq!(client.lost(), 0);
    assert!(numbers.len() >= 10 && numbers.iter().copied().eq(0..numbers.len() as u32), "{numbers:?}");
}

#[test]
fn a_device_without_parameters_is_waited_for_as_long_as_was_asked() {
    struct Clock(SimulatedWire, Duration);
    impl Wire for Clock {
        fn send(&mut self, bytes: &[u8]) -> Result<(), host_sim::Error> {
            self.0.send(bytes)
        }
        fn receive(&mut self, at_most: Duration) -> Result<Vec<u8>, host_sim::Error> {
            self.1 += at_most;
            self.0.receive(at_most)
        }
        fn now(&self) -> Duration {
            self.1
        }
        fn name(&self) -> String {
            self.0.name()
        }
        fn warning(&self) -> Option<&'static str> {
            None
        }
    }
    let plan = &plans("step-response", &["loop.controller=srnf"])[0];
    let simulated = SimulatedDevice::with(plan, blank(), Boot::default()).unwrap();
    let mut client = Client::connect(Clock(SimulatedWire::new(simulated), Duration::ZERO)).unwrap();
    let begin = client.wire().now();
    client.pass(Duration::from_secs(10)).unwrap();
    let took = (client.wire().now() - begin).as_secs_f64();
    // Asking for its status takes some, too.
    assert!((10.0..11.0).contains(&took), "{took}");
}
