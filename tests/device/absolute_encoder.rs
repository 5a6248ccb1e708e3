//! An absolute encoder on the load, beside the motor's: the reference at power-on, and what becomes
//! of a chip that does not answer.

use experiments::both_encoders::{STIFF, both_encoders};
use simulator::device::client::Client;
use simulator::device::homed::HomeResult;
use simulator::device::jog_offset::Offset;
use simulator::device::simulated::{SimulatedDevice, Wires};
use simulator::device::wire::SimulatedWire;
use simulator::device::{jogged, parameters};
use stiction::motion::home::{HomeEnd, HomeRequest, HomeTarget};
use stiction::motion::jog::JogFindings;
use stiction::servo::{Boot, Input, Refusal, State};
use stiction::{Fault, Servo};

use crate::first_run;

/// An AS5047P on the joint, which reads 16 000 at the joint's zero.
const CHIP: [&str; 2] = ["load_encoder.kind=as5047p", "load_encoder.zero_counts=16000"];
/// A range of half a turn.
const RANGE: [&str; 2] = ["limits.position_min_deg=-90", "limits.position_max_deg=90"];

/// Powers a device up with its joint at a position, deg.
fn powered_at(deg: f64, set: &[&str]) -> SimulatedDevice {
    let plan = &both_encoders(&["robust"], &[&CHIP, set].concat())[0];
    let parameters = parameters(plan).unwrap();
    let mut device = SimulatedDevice::running(plan, &parameters, Boot::default()).unwrap();
    device.push(deg, 0.0);
    device
}

/// Returns the position that the servo counts, deg.
fn counted_deg(device: &mut SimulatedDevice) -> f64 {
    f64::from(device.device.servo().position()) * 360.0 / 16384.0
}

#[test]
fn the_angle_gives_the_position_where_the_range_is_less_than_a_turn() {
    for direction in ["forward", "reverse"] {
        let direction = format!("load_encoder.direction={direction}");
        for deg in [-89.0, -10.0, 0.0, 30.0, 89.0] {
            let mut device = powered_at(deg, &[&RANGE[..], &[&direction]].concat());
            device.ticks(200);
            assert!(device.device.servo().is_referenced(), "{direction}, {deg} deg");
            // Half a count of rounding, and the twist that a push leaves in the gear: none.
            let off_deg = (counted_deg(&mut device) - deg).abs();
            assert!(off_deg <= 0.5 * 360.0 / 16384.0 + 1e-9, "{direction}, {deg}: {off_deg} deg");
            assert_eq!(device.device.servo().arm_for_link(None), Ok(()), "{deg} deg");
        }
    }
}

#[test]
fn the_number_of_turns_is_unknown_in_a_range_of_a_turn_and_outside_of_a_range() {
    let wide = ["limits.position_min_deg=-180", "limits.position_max_deg=181"];
    for (deg, set) in [(-179.5, wide), (100.0, RANGE)] {
        let mut device = powered_at(deg, &set);
        device.ticks(200);
        assert!(!device.device.servo().is_referenced(), "{deg} deg, {set:?}");
        let refused = device.device.servo().arm_for_link(None);
        assert_eq!(refused, Err(Refusal::NotReferenced), "{deg} deg, {set:?}");
    }
}

/// Five ticks of 1 ms. While the chip does not answer, nothing is armed; once it answers again, the
/// position is that of its angle, wherever the joint has been turned meanwhile.
#[test]
fn a_chip_that_does_not_answer_is_a_fault_and_the_angle_gives_the_position_again() {
    let mut device = powered_at(10.0, &RANGE);
    device.ticks(200);
    device.device.servo().arm_for_link(None).unwrap();
    device.ticks(10);
    assert_eq!(device.device.servo().state(), State::Armed);
    device.load_wires = Wires::Cut;
    device.ticks(4);
    assert_eq!(device.device.servo().state(), State::Armed);
    device.tick();
    let latched = device.device.servo().latched().unwrap();
    assert_eq!((latched.fault, latched.value), (Fault::EncoderSilent, 5.0));
    assert!(!device.device.servo().is_referenced());
    device.device.servo().clear().unwrap();
    device.ticks(200);
    let refused = Err(Refusal::WouldTrip(Fault::EncoderSilent));
    assert_eq!(device.device.servo().arm_for_link(None), refused);
    // Nor is the position known that a command would set.
    assert_eq!(device.device.servo().set_reference(0), Err(Refusal::Moving));
    device.push(-50.0, 0.0);
    device.ticks(10);
    device.load_wires = Wires::Sound;
    device.ticks(200);
    assert!(device.device.servo().is_referenced());
    assert!((counted_deg(&mut device) + 50.0).abs() < 0.02, "{}", counted_deg(&mut device));
    assert_eq!(device.device.servo().arm_for_link(None), Ok(()));
}

/// A tenth of a second after power-on; four ticks without an answer later are none.
#[test]
fn a_chip_has_its_time_to_become_ready_and_may_miss_some_ticks() {
    let mut device = powered_at(10.0, &RANGE);
    device.load_wires = Wires::Cut;
    device.ticks(99);
    assert_eq!(device.device.servo().latched(), None);
    device.tick();
    assert_eq!(device.device.servo().latched().unwrap().fault, Fault::EncoderSilent);
    let mut device = powered_at(10.0, &RANGE);
    for _ in 0..50 {
        device.load_wires = Wires::Sound;
        device.ticks(3);
        device.load_wires = Wires::Cut;
        device.ticks(4);
    }
    assert_eq!(device.device.servo().latched(), None);
}

/// The reference is that of an encoder and its zero.
#[test]
fn another_zero_or_kind_ends_the_reference_and_the_angle_gives_it_anew() {
    let incremental = ["load_encoder.counts_per_turn=16384"];
    let of =
        |set: &[&str]| parameters(&both_encoders(&["robust"], &[set, &RANGE].concat())[0]).unwrap();
    // Quarter of a turn further.
    let moved = ["load_encoder.kind=as5047p", "load_encoder.zero_counts=11904"];
    let hardware = files::hardware::STM32F405;
    let mut servo = Servo::new(Ok(&of(&incremental)), Boot::at_zero(), &hardware);
    let mut input = Input { supply: 2048, ..Input::default() };
    let mut install = |servo: &mut Servo, set: &[&str], counter: u32| {
        let mut place = None;
        stiction::servo::ControlLoop::prepare(&mut place, &of(set), &hardware).unwrap();
        servo.install(&mut place).unwrap();
        input.load.counter = counter;
        let is_referenced = servo.is_referenced();
        (0..200).for_each(|_| {
            servo.tick(input);
        });
        (is_referenced, servo.is_referenced(), servo.position())
    };
    // The counter of the chip has nothing to do with that of the timer, and proves nothing.
    servo.tick(Input { supply: 2048, ..Input::default() });
    servo.fault(Fault::EncodersDisagree);
    servo.clear().unwrap();
    assert_eq!(install(&mut servo, &CHIP, 16_000), (false, false, 0));
    assert_eq!(servo.arm_for_link(None), Err(Refusal::EncoderInDoubt));
    let mut servo = Servo::new(Ok(&of(&incremental)), Boot::at_zero(), &hardware);
    assert_eq!(install(&mut servo, &CHIP, 16_000), (false, true, 0));
    assert_eq!(install(&mut servo, &moved, 16_000), (false, true, 4096));
    assert_eq!(install(&mut servo, &moved, 16_000), (true, true, 4096));
}

/// Half of the range of a reading that the load may pass unseen, by the motor's travel: a quarter
/// of it, in counts of 0.0036 deg.
#[test]
fn a_pause_in_which_the_load_may_have_turned_too_far_ends_the_reference() {
    let incremental = ["load_encoder.counts_per_turn=16384"];
    for (set, most_deg) in [(&CHIP[..], 90.0), (&incremental, 360.0)] {
        let wide = ["limits.position_min_deg=-720", "limits.position_max_deg=720"];
        let set = [set, &wide].concat();
        let parameters = parameters(&both_encoders(&["robust"], &set)[0]).unwrap();
        for (share, stays) in [(0.99, true), (1.01, false)] {
            for way in [1.0, -1.0] {
                let hardware = files::hardware::STM32F405;
                let mut servo = Servo::new(Ok(&parameters), Boot::at_zero(), &hardware);
                servo.tick(Input { supply: 2048, ..Input::default() });
                assert!(servo.is_referenced());
                servo.check_pause((way * share * most_deg / 0.0036) as i32);
                assert_eq!(servo.is_referenced(), stays, "{set:?}, {share}");
            }
        }
    }
}

/// Four ticks without an answer, and an answer, over and over on the way of a move: each answer has
/// the travel of five ticks. The limit is the fastest tick of the same move with all answers.
#[test]
fn an_answer_after_missing_ones_has_the_travel_of_all_their_ticks() {
    let moved = |most_counts: Option<i32>, missing: u32| {
        let most = most_counts.map_or(1.0, |counts| f64::from(counts) * 360.0 / 16384.0);
        let jump = format!("limits.encoder_jump_deg={most}");
        let mut simulated = powered_at(0.0, &[&RANGE[..], &[&jump]].concat());
        simulated.ticks(200);
        let mut client = Client::connect(SimulatedWire::new(simulated)).unwrap();
        client.arm().unwrap();
        client.move_to(60.0).unwrap();
        let device = &mut client.wire().simulated;
        let (mut fastest, mut last) = (0, 0);
        for _ in 0..3000 {
            device.device.servo().heard();
            device.load_wires = Wires::Cut;
            (0..missing).for_each(|_| {
                device.tick();
            });
            device.load_wires = Wires::Sound;
            device.tick();
            let now = device.device.servo().position();
            fastest = fastest.max((now - std::mem::replace(&mut last, now)).abs());
        }
        (device.device.servo().latched().map(|latched| latched.fault), fastest)
    };
    let (fault, fastest) = moved(None, 0);
    assert_eq!(fault, None);
    assert!(fastest >= 2, "{fastest} counts in the fastest tick");
    assert_eq!(moved(Some(fastest), 0).0, None);
    assert_eq!(moved(Some(fastest - 1), 0).0, Some(Fault::EncoderJump));
    let (fault, of_five) = moved(Some(fastest), 4);
    assert_eq!(fault, None);
    assert!(of_five > fastest, "{of_five} counts in five ticks, {fastest} in the fastest");
}

/// The limit is a degree in a tick: 45 counts. A jump is one in spite of missing answers.
#[test]
fn a_jump_after_missing_answers_is_a_fault_beyond_the_limits_of_their_ticks() {
    for (missing, counts, expected) in [
        (0, 44, None),
        (0, 47, Some(Fault::EncoderJump)),
        (4, 215, None),
        (4, 235, Some(Fault::EncoderJump)),
    ] {
        let mut device = powered_at(0.0, &[&RANGE[..], &["limits.encoder_jump_deg=1"]].concat());
        device.ticks(200);
        device.device.servo().arm_for_link(None).unwrap();
        device.ticks(20);
        device.load_wires = Wires::Cut;
        (0..missing).for_each(|_| {
            device.tick();
        });
        device.load_wires = Wires::Sound;
        device.jump_load(counts);
        device.tick();
        let fault = device.device.servo().latched().map(|latched| latched.fault);
        assert_eq!(fault, expected, "{counts} counts after {missing} ticks");
    }
}

/// The unit of all positions would be another one than that of the chip's angles.
#[test]
fn a_resolution_that_is_not_the_chips_is_refused() {
    let chip = parameters(&both_encoders(&["robust"], &CHIP)[0]).unwrap();
    let mut place = None;
    let mut refusal = |resolution: f32| {
        let mut parameters = chip.clone();
        parameters.controller.encoder.resolution = resolution;
        let hardware = files::hardware::STM32F405;
        stiction::servo::ControlLoop::prepare(&mut place, &parameters, &hardware)
            .map_err(|error| stiction::parameters::names::NamedError(error).to_string())
    };
    assert_eq!(refusal(360.0 / 16384.0), Ok(()));
    for resolution in [360.0 / 16383.0, 360.0 / 16385.0, 0.01, 1.0] {
        assert_eq!(
            refusal(resolution),
            Err(format!(
                "`encoder.resolution_deg` is {resolution}; must be 0.021972656, because of \
                 `motor_encoder.load_kind`"
            ))
        );
    }
    // Another kind has any resolution.
    let incremental = ["load_encoder.counts_per_turn=16384"];
    let mut other = parameters(&both_encoders(&["robust"], &incremental)[0]).unwrap();
    other.controller.encoder.resolution = 0.01;
    let prepared = other.prepare(&files::hardware::STM32F405);
    assert!(prepared.is_ok(), "{prepared:?}");
}

/// The angle is there again as soon as the motor is off.
#[test]
fn a_homing_that_finds_no_stop_leaves_the_reference_to_the_angle() {
    let mut device = powered_at(10.0, &RANGE);
    device.ticks(200);
    let request = HomeRequest { travel: Some(5.0), ..HomeRequest::default() };
    let home = device.device.parameters().unwrap().home(&request).unwrap();
    device.device.servo().home(home).unwrap();
    assert!(!device.device.servo().is_referenced());
    let ended = (0..20_000).find(|_| {
        device.device.servo().heard();
        device.tick().state != State::Armed
    });
    assert!(ended.is_some());
    let found = device.device.servo().homed().unwrap();
    assert_eq!(found.ended, HomeEnd::Travel);
    device.ticks(200);
    assert!(device.device.servo().is_referenced());
    let off_deg = counted_deg(&mut device) - device.position_deg();
    for (is_referenced, words) in
        [(true, "referenced by its encoder's angle"), (false, "the joint is not referenced")]
    {
        let (to, resolution) = (HomeTarget::Stop, 0.02);
        let twist_deg = None;
        let result =
            HomeResult { found, to, resolution, position_deg: 0.0, is_referenced, twist_deg };
        assert!(result.words().contains(words), "{}", result.words());
        assert!(!result.is_found());
    }
    // The load is behind the motor by no more than the twist at rest.
    assert!(off_deg.abs() < 2.0, "{off_deg} deg");
}

/// Returns the verdicts of a jog with `--at` on a joint at 30 deg whose file has these keys beside
/// those of the joint: on direction, ratio and offset. The last value is whether the JSON object
/// has the offset among the keys to set.
fn jogged_at(set: &[&str], stated_deg: f64) -> ([bool; 3], Offset, bool) {
    let plan =
        |set: &[&str]| both_encoders(&["robust"], &[&CHIP, &STIFF, &RANGE, set].concat()).remove(0);
    let configured = parameters(&plan(set)).unwrap();
    let mut device = SimulatedDevice::running(&plan(&[]), &configured, Boot::default()).unwrap();
    device.push(30.0, 0.0);
    device.ticks(200);
    let mut client = Client::connect(SimulatedWire::new(device)).unwrap();
    let angle = client.status().unwrap().load_angle;
    let found = first_run::jogged(&mut client).unwrap();
    let offset = Offset::check(Some(stated_deg), angle.unwrap(), &found, &configured);
    let mut object = jogged::json(&found, &configured, None);
    let is_wrong_ratio = !object["wrong_ratio"].is_null();
    offset.add_to(&mut object);
    let is_written = !object["set"]["load_encoder.zero_counts"].is_null();
    ([found.agrees(), !is_wrong_ratio, offset.wrong().is_none()], offset, is_written)
}

/// Each of direction, ratio and offset wrong in the file, alone and together. Whatever else is
/// wrong, the offset to write is the 16 000 of the joint, within the rounding of the reading and of
/// the stated position, and what a stiff gear is wound up by a push.
#[test]
fn a_jog_at_a_stated_position_finds_which_of_direction_ratio_and_offset_is_wrong() {
    let direction = "load_encoder.direction=reverse";
    // Eight times as many counts a turn of the motor as it has.
    let ratio = "encoder.lines=4000";
    // A quarter of a turn, 4096 counts.
    let offset = "load_encoder.zero_counts=11904";
    for (set, right) in [
        (&[][..], [true, true, true]),
        (&[direction], [false, true, true]),
        (&[ratio], [true, false, true]),
        (&[offset], [true, true, false]),
        (&[direction, offset], [false, true, false]),
        (&[ratio, offset], [true, false, false]),
    ] {
        let (verdicts, found, is_written) = jogged_at(set, 30.0);
        assert_eq!(verdicts, right, "{set:?}: {found:?}");
        let Offset::Checked(checked) = found else { panic!("{set:?}: {found:?}") };
        assert!(checked.zero_counts.abs_diff(16_000) <= 2, "{set:?}: {checked:?}");
        let expected_deg = if right[2] { 0.0 } else { 90.0 };
        assert!((checked.error_deg.abs() - expected_deg).abs() < 0.05, "{set:?}: {checked:?}");
        assert_eq!(is_written, !right[2], "{set:?}");
        assert_eq!(found.words().contains("WRONG"), !right[2], "{}", found.words());
    }
    // A person who is wrong by 5 deg finds an offset that is: 5 deg are 227.6 counts.
    let (verdicts, Offset::Checked(checked), _) = jogged_at(&[], 25.0) else { panic!() };
    assert_eq!(verdicts, [true, true, false]);
    assert!((checked.error_deg - 5.0).abs() < 0.05, "{checked:?}");
    assert!((i64::from(checked.zero_counts) - 16_000 - 228).abs() <= 2, "{checked:?}");
}

/// An incremental encoder has no offset, and without a stated position none is checked.
#[test]
fn an_offset_that_was_not_checked_is_reported_as_such() {
    let plan = |set: &[&str]| parameters(&both_encoders(&["robust"], set)[0]).unwrap();
    let found = JogFindings::default();
    assert_eq!(Offset::check(Some(0.0), 7, &found, &plan(&[])), Offset::None);
    assert_eq!(Offset::None.words(), "");
    let unstated = Offset::check(None, 7, &found, &plan(&CHIP));
    assert!(unstated.words().contains("not checked: `--at DEG`"), "{}", unstated.words());
    // Nothing has moved: the direction, and so the offset, is unknown.
    assert_eq!(Offset::check(Some(0.0), 7, &found, &plan(&CHIP)), Offset::Unknown);
}
