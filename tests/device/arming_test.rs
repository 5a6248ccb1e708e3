//! The test at arming: which fault each failure at rest is, how far the joint goes until then, and
//! that a sound joint passes and begins its motion where it stands.

use experiments::both_encoders::{STIFF, both_encoders};
use files::encoder::Wires;
use simulator::device::client::Client;
use simulator::device::parameters;
use simulator::device::simulated::{HoldingBrake, MotorWires, SimulatedDevice};
use simulator::device::wire::SimulatedWire;
use stiction::link::StateCode;
use stiction::servo::{BrakeCommand, Refusal, State};
use stiction::{Fault, Tick};

use crate::fixture::plans;

/// Travel of the test, deg: 16 counts of 0.022 deg, and a twist of 1.8 deg, are less.
const TRAVEL_DEG: f64 = 3.0;
const TEST: &str = "device.arming_test_deg=3.0";
const LAWS: [&str; 2] = ["robust", "srnf"];

/// A device at rest whose joint has two encoders and a test at arming.
fn device(law: &str, set: &[&str]) -> SimulatedDevice {
    let mut device =
        SimulatedDevice::new(&both_encoders(&[law], &[&[TEST], set].concat())[0]).unwrap();
    device.ticks(200);
    device
}

/// A device whose encoder is that of the thesis's motor, with a test at arming.
fn device_of_one(law: &str, set: &[&str]) -> SimulatedDevice {
    let controller = format!("loop.controller={law}");
    let own = [&*controller, TEST, "reference.steps_deg=[5.0]"];
    let plan = &plans("step-response", &[&own[..], set].concat())[0];
    let mut device = SimulatedDevice::new(plan).unwrap();
    device.ticks(50);
    device
}

/// Result of a test at arming.
#[derive(Debug)]
struct Tested {
    /// The fault and its value.
    fault: Option<(Fault, f32)>,
    /// Largest distance of the load from the place of arming, deg.
    load_deg: f64,
    time_s: f64,
}

/// Arms and runs the test until its end.
fn tested(device: &mut SimulatedDevice) -> Tested {
    tested_with_noise(device, 0)
}

/// The same while the first encoder counts to and fro by `noise`.
fn tested_with_noise(device: &mut SimulatedDevice, noise: i32) -> Tested {
    let from = device.position_deg();
    device.device.servo().arm_for_link(None).unwrap();
    assert!(device.device.servo().is_testing());
    let (mut load_deg, mut ticks) = (0.0_f64, 0);
    while device.device.servo().is_testing() {
        device.device.servo().heard();
        device.jump(if ticks % 2 == 0 { noise } else { -noise });
        device.tick();
        ticks += 1;
        load_deg = load_deg.max((device.position_deg() - from).abs());
    }
    let fault = device.device.servo().latched().map(|latched| (latched.fault, latched.value));
    assert_eq!(device.device.servo().has_failed_test(), fault.is_some());
    Tested { fault, load_deg, time_s: f64::from(ticks) * device.sample_time_s() }
}

/// The table of `src/motion/arming_test.rs`, each row with its bound: the travel of the test, and
/// what the load coasts, 4.1 N m on 0.437 kg m^2 from the speed of a jog of at most 20 deg/s.
#[test]
fn each_failed_encoder_at_rest_is_its_fault_before_the_loop_closes() {
    let coasts = 20.0_f64.powi(2) / (2.0 * (4.1 / 0.437_f64).to_degrees());
    for law in LAWS {
        for (wires, fault) in [
            ([Wires::Cut, Wires::Sound], Fault::EncodersDisagree),
            ([Wires::Sound, Wires::Cut], Fault::EncodersDisagree),
            ([Wires::Swapped, Wires::Sound], Fault::EncoderReversed),
            ([Wires::Sound, Wires::Swapped], Fault::EncoderReversed),
            ([Wires::Swapped, Wires::Swapped], Fault::EncoderReversed),
            ([Wires::Cut, Wires::Cut], Fault::Stall),
        ] {
            for set in [&[][..], &STIFF] {
                let mut device = device(law, set);
                [device.wires, device.load_wires] = wires;
                let found = tested(&mut device);
                println!("{law} {wires:?} {set:?}: {found:?}");
                assert_eq!(found.fault.unwrap().0, fault, "{law} {wires:?} {set:?}: {found:?}");
                if wires != [Wires::Cut, Wires::Cut] {
                    assert!(found.load_deg < TRAVEL_DEG + coasts, "{wires:?} {found:?}");
                }
                assert!(!device.tick().enable);
                assert!(device.device.servo().is_encoder_in_doubt());
            }
        }
    }
}

/// The motor turns within a gear whose halves no longer meet: 60 deg of slack that the file does
/// not have.
#[test]
fn a_broken_coupling_is_found_before_the_motor_has_gone_farther_than_the_travel() {
    for law in LAWS {
        let sound = parameters(&both_encoders(&[law], &[TEST])[0]).unwrap();
        let broken = &both_encoders(&[law], &["gear.backlash_deg=60"])[0];
        let boot = stiction::servo::Boot::at_zero();
        let mut device = SimulatedDevice::running(broken, &sound, boot).unwrap();
        device.ticks(200);
        let found = tested(&mut device);
        let (fault, twist_deg) = found.fault.unwrap();
        assert_eq!(fault, Fault::EncodersDisagree, "{found:?}");
        // The motor alone has shown the twist: the travel, and what it turns in a tick.
        assert!((TRAVEL_DEG..TRAVEL_DEG + 0.5).contains(&f64::from(twist_deg)), "{found:?}");
        assert!(found.load_deg < 1e-3, "{found:?}");
    }
}

#[test]
fn a_motor_that_does_not_turn_is_a_stall_with_one_encoder_and_with_two() {
    for law in LAWS {
        for mut device in [device(law, &[]), device_of_one(law, &[])] {
            device.motor_wires = MotorWires::Open;
            let found = tested(&mut device);
            let (fault, effort) = found.fault.unwrap();
            let bound = device.device.parameters().unwrap().jog.effort;
            assert_eq!(fault, Fault::Stall, "{law}: {found:?}");
            // The effort has reached its bound both ways.
            assert!((effort / bound - 1.0).abs() < 0.02, "{effort} of {bound}");
        }
    }
}

/// With one encoder, a dead one cannot be distinguished from a motor that does not turn.
#[test]
fn a_dead_or_reversed_only_encoder_is_found_at_rest() {
    for law in ["pd", "srnf", "robust"] {
        for (wires, fault) in [(Wires::Cut, Fault::Stall), (Wires::Swapped, Fault::EncoderReversed)]
        {
            let mut device = device_of_one(law, &[]);
            device.wires = wires;
            let found = tested(&mut device);
            assert_eq!(found.fault.map(|found| found.0), Some(fault), "{law} {wires:?}: {found:?}");
        }
    }
}

/// The gears of the families, from soft to stiff and with up to 1 deg of slack, at both ends of the
/// slack, and with an absolute encoder.
#[test]
fn sound_joints_pass_and_begin_where_they_stand() {
    for law in LAWS {
        for set in [
            &[][..],
            &STIFF,
            &["gear.backlash_deg=1.0", "device.arming_test_deg=6.0"],
            &["gear.backlash_deg=1.0", "gear.stiffness_nm_per_rad=300", "device.arming_test_deg=9"],
            &["gear.backlash_deg=0", "gear.stiffness_nm_per_rad=300", "device.arming_test_deg=6.0"],
            &[
                "load_encoder.counts_per_turn=1000000",
                "encoder.lines=25",
                "device.arming_test_deg=5.0",
            ],
            &["load_encoder.kind=as5047p", "load_encoder.zero_counts=100"],
            &["load.constant_nm=2.0"],
            &["load.constant_nm=-2.0"],
        ] {
            let mut device = device(law, set);
            let found = tested(&mut device);
            println!("{law} {set:?}: {found:?}");
            assert_eq!(found.fault, None, "{law} {set:?}: {found:?}");
            // Two rises of at most a second, and three times of rest.
            assert!(found.time_s < 3.0, "{law} {set:?}: {found:?}");
            let (state, counts) = (device.device.servo().state(), device.tick().tick.counts);
            assert_eq!(state, State::Armed);
            // The zero of the motion is where the joint stands.
            assert!(counts.abs() <= 1, "{law} {set:?}: {counts}");
            for _ in 0..500 {
                device.device.servo().heard();
                let tick = device.tick().tick;
                assert!(tick.counts.abs() <= 3, "{law} {set:?}: {}", tick.counts);
            }
            assert_eq!(device.device.servo().state(), State::Armed, "{law} {set:?}");
        }
    }
}

/// Noise of a count to and fro hides neither a sound encoder nor a dead one.
#[test]
fn noise_of_a_count_is_neither_a_motion_nor_a_fault() {
    for law in LAWS {
        for wires in [Wires::Sound, Wires::Cut] {
            for (mut device, fault) in [
                (device(law, &[]), Fault::EncodersDisagree),
                (device_of_one(law, &[]), Fault::Stall),
            ] {
                device.wires = wires;
                let found = tested_with_noise(&mut device, 1);
                let expected = (wires == Wires::Cut).then_some(fault);
                assert_eq!(found.fault.map(|fault| fault.0), expected, "{law} {wires:?} {found:?}");
            }
        }
    }
}

/// The monitors that are off in the test are on after it: a wire of the load's encoder that is
/// swapped then, or cut, is a fault of the first move.
#[test]
fn after_its_test_a_failed_encoder_is_a_fault_of_the_move() {
    for load in [Wires::Swapped, Wires::Cut] {
        let device = device("srnf", &STIFF);
        let mut client = Client::connect(SimulatedWire::new(device)).unwrap();
        client.arm_tested().unwrap();
        client.wire().simulated.load_wires = load;
        client.move_to(5.0).unwrap();
        let status = client.pass(std::time::Duration::from_secs(2)).unwrap();
        assert_eq!(status.fault.code, Fault::EncodersDisagree as u8, "{load:?}");
        assert!(!status.has_failed_test);
    }
}

/// Near the upper end of its range, the joint is pushed the other way first, and back.
#[test]
fn the_first_way_leads_away_from_a_limit_of_the_range() {
    for (range, sign) in [(["-90", "2"], -1), (["-2", "90"], 1), (["-90", "90"], 1)] {
        let [min, max] = range;
        let set =
            [format!("limits.position_min_deg={min}"), format!("limits.position_max_deg={max}")];
        let mut device = device("srnf", &[&*set[0], &*set[1]]);
        device.device.servo().set_reference(0).unwrap();
        device.device.servo().arm_for_link(None).unwrap();
        let mut first = 0.0;
        while first == 0.0 {
            device.device.servo().heard();
            first = device.tick().tick.v_applied;
        }
        assert_eq!(first.signum() as i32, sign, "{range:?}");
    }
}

#[test]
fn the_test_accepts_only_a_stop_and_a_silent_link_ends_it() {
    let mut device = device("robust", &[]);
    // After a stop, the motion of the parameters waits for the next test.
    for _ in 0..2 {
        device.device.servo().arm().unwrap();
        assert!(device.device.servo().is_testing());
        device.device.servo().stop();
        device.ticks(200);
    }
    let servo = device.device.servo();
    servo.arm_for_link(None).unwrap();
    assert_eq!(servo.hold(), Err(Refusal::Testing));
    assert_eq!(servo.arm_for_link(None), Err(Refusal::Testing));
    servo.come_to_rest();
    assert_eq!((servo.state(), servo.is_testing()), (State::Stopped, false));
    device.ticks(200);
    device.device.servo().arm_for_link(None).unwrap();
    while device.tick().state == State::Armed {}
    let latched = device.device.servo().latched().unwrap();
    assert_eq!(latched.fault, Fault::LinkTimeout);
    assert!(device.device.servo().has_failed_test());
    // What was stopped does not begin by itself, and the next arming has its test again.
    device.device.servo().clear().unwrap();
    assert!(!device.device.servo().has_failed_test());
    device.ticks(200);
    assert_eq!(tested(&mut device).fault, None);
}

/// The load is 6 times as strong as the friction of the thesis's joint; the brake holds it. Once it
/// is open, the joint falls by the travel, and by `v t + a t^2 / 2` in the time of the brake: 0.2 s
/// at the 27 deg/s^2 of a volt.
#[test]
fn a_load_that_falls_when_the_brake_opens_is_a_fault_within_the_travel() {
    for load_v in [-2.4, 2.4] {
        falls(load_v);
    }
}

/// The first push is positive: a load falls against it or with it.
fn falls(load_v: f64) {
    let times = ["device.soft_start_s=0.5", "device.brake_open_s=0.1", "device.brake_close_s=0.2"];
    let mut device = device_of_one("robust", &times);
    device.holding_brake = Some(HoldingBrake::closed(20.0, [0.1, 0.2]));
    device.load_v = load_v;
    device.ticks(20);
    device.device.servo().arm_for_link(None).unwrap();
    let mut speed = 0.0;
    while device.device.servo().state() == State::Armed {
        device.device.servo().heard();
        speed = device.velocity_deg_per_s();
        let output = device.tick();
        assert!(output.tick.status & Tick::HELD == 0 || output.brake() == BrakeCommand::Closed);
    }
    let fault = device.device.servo().latched().unwrap().fault;
    let expected = if load_v < 0.0 {
        [Fault::EncoderReversed, Fault::Stall]
    } else {
        [Fault::FollowingError; 2]
    };
    assert!(expected.contains(&fault), "{load_v} V: {fault:?}");
    device.ticks(100);
    let fallen = device.position_deg().abs();
    let acceleration = 27.0 * 2.4;
    let most = TRAVEL_DEG + (speed.abs() + acceleration * 0.02) * 0.22 + acceleration * 0.22 * 0.11;
    println!("{fault:?}: {fallen} deg of {most}, {speed} deg/s");
    assert!(fallen < most, "{fallen} deg of {most}");
}

#[test]
fn a_client_waits_for_the_test_and_reads_its_fault_in_words() {
    let client = |wires: [Wires; 2]| {
        let mut device = device("robust", &[]);
        [device.wires, device.load_wires] = wires;
        Client::connect(SimulatedWire::new(device)).unwrap()
    };
    let mut sound = client([Wires::Sound, Wires::Sound]);
    sound.arm().unwrap();
    assert!(sound.status().unwrap().is_testing);
    let why = sound.hold().unwrap_err().to_string();
    assert!(why.contains("the test at arming runs"), "{why}");
    sound.stop().unwrap();
    sound.pass(std::time::Duration::from_millis(200)).unwrap();
    sound.arm_tested().unwrap();
    let status = sound.status().unwrap();
    assert_eq!((status.state, status.is_testing), (StateCode::Armed, false));
    sound.move_to(1.0).unwrap();
    let why = client([Wires::Sound, Wires::Cut]).arm_tested().unwrap_err().to_string();
    assert!(why.contains("fault 26") && why.contains("during the test at arming"), "{why}");
}

/// The least travel is 16 counts of 0.022 deg, and the twist of the gear.
#[test]
fn a_travel_that_shows_no_encoder_is_refused() {
    let of = |travel: f32| {
        let mut parameters = parameters(&both_encoders(&["robust"], &[])[0]).unwrap();
        parameters.device.arming_test = travel;
        let least =
            16.0 * parameters.controller.encoder.resolution + parameters.controller.motor.twist;
        (parameters.check(), least)
    };
    let (is_off, least) = of(0.0);
    assert_eq!(is_off, Ok(()));
    assert!(of(0.999 * least).0.is_err() && of(1.001 * least).0.is_ok());
}
