//! A device with an encoder on its motor and one on its load: what a jog finds of each, which fault
//! a failed one is, how far the load goes until then, and what makes the servo trust both again.

use experiments::both_encoders::{STIFF, both_encoders};
use simulator::device::client::Client;
use simulator::device::simulated::{SimulatedDevice, Wires};
use simulator::device::wire::SimulatedWire;
use simulator::device::{jogged, parameters};
use stiction::motion::jog::{JogEnd, JogFindings, JogRequest, Verdict};
use stiction::servo::{Boot, Input, Refusal, State};
use stiction::{Fault, Parameters, Servo};

use crate::first_run;

/// Returns a device at rest whose joint has two encoders.
fn device(set: &[&str]) -> SimulatedDevice {
    let mut device = SimulatedDevice::new(&both_encoders(&["robust"], set)[0]).unwrap();
    device.ticks(200);
    device
}

fn jogged_with(wires: [Wires; 2], set: &[&str]) -> (JogFindings, f64) {
    let mut device = device(set);
    [device.wires, device.load_wires] = wires;
    let mut client = Client::connect(SimulatedWire::new(device)).unwrap();
    let found = first_run::jogged(&mut client).unwrap();
    (found, client.wire().simulated.position_deg().abs())
}

#[test]
fn a_jog_finds_which_of_two_encoders_is_reversed_or_dead() {
    use Verdict::{Agrees, Reversed, RunsOn, Still};
    for (wires, verdicts, what) in [
        ([Wires::Sound, Wires::Sound], [Agrees, Agrees], "both encoders count in the sense"),
        ([Wires::Swapped, Wires::Sound], [Agrees, Reversed], "the motor's encoder counts AGAINST"),
        ([Wires::Sound, Wires::Swapped], [Reversed, Agrees], "the load's encoder counts AGAINST"),
        ([Wires::Swapped, Wires::Swapped], [Reversed, Reversed], "both encoders count AGAINST"),
        ([Wires::Cut, Wires::Sound], [Agrees, Still], "motor's encoder does not follow"),
        ([Wires::Sound, Wires::Cut], [Still, RunsOn], "load's encoder does not follow"),
    ] {
        let (found, travel_deg) = jogged_with(wires, &[]);
        let verdict = [Some(found.verdict()), found.motor_verdict()];
        assert_eq!(verdict, verdicts.map(Some), "{wires:?}: {found:?}");
        let plan = &both_encoders(&["robust"], &[])[0];
        let words = jogged::words(&found, &parameters(plan).unwrap());
        assert!(words.contains(what), "{wires:?}: {words}");
        // Within the travel, and the twist of 1.8 deg that the motor may be ahead.
        assert!(travel_deg < 4.0, "{wires:?}: {travel_deg} deg");
        let ends = wires[1] == Wires::Cut;
        assert_eq!(found.ways[0].ended == JogEnd::Travel, ends, "{wires:?}: {found:?}");
    }
}

/// So stiff a gear is wound up by less than the jog's travel: a difference of both encoders that is
/// a fault in every other motion.
#[test]
fn a_jog_finds_a_dead_encoder_behind_a_stiff_gear_too() {
    use Verdict::{Agrees, RunsOn, Still};
    let motor = parameters(&both_encoders(&["robust"], &STIFF)[0]).unwrap().controller.motor;
    for (wires, verdicts) in [
        ([Wires::Sound, Wires::Sound], [Agrees, Agrees]),
        ([Wires::Cut, Wires::Sound], [Agrees, Still]),
        ([Wires::Sound, Wires::Cut], [Still, RunsOn]),
    ] {
        let (found, _) = jogged_with(wires, &STIFF);
        assert_eq!([Some(found.verdict()), found.motor_verdict()], verdicts.map(Some), "{wires:?}");
        let way = found.ways[0].motor_moved.unwrap_or(0) as f32 * motor.count;
        let is_far = wires[1] == Wires::Cut;
        assert_eq!(way > motor.swing, is_far, "{wires:?}: {way} deg of {}", motor.swing);
    }
}

/// The file has a quarter of the load's counts, so the load seems to go four times as far as the
/// motor. A gear with slack hides that in a short jog.
#[test]
fn a_jog_finds_a_wrong_number_of_counts_behind_a_stiff_gear() {
    let of = |set: &[&str], counts: &str| {
        let plan = |counts: &str| both_encoders(&["robust"], &[set, &[counts]].concat()).remove(0);
        let configured = parameters(&plan(counts)).unwrap();
        let joint = plan("load_encoder.counts_per_turn=16384");
        let mut device = SimulatedDevice::running(&joint, &configured, Boot::at_zero()).unwrap();
        device.ticks(200);
        let mut client = Client::connect(SimulatedWire::new(device)).unwrap();
        let found = first_run::jogged(&mut client).unwrap();
        (jogged::is_right(&found, &configured), jogged::words(&found, &configured))
    };
    for (set, counts, is_right) in [
        (&STIFF[..], "load_encoder.counts_per_turn=16384", true),
        (&STIFF[..], "load_encoder.counts_per_turn=4096", false),
        (&[][..], "load_encoder.counts_per_turn=4096", true),
    ] {
        let (found, words) = of(set, counts);
        assert_eq!(found, is_right, "{words}");
        assert_eq!(words.contains("not by the same angle"), !is_right, "{words}");
    }
}

/// What became of a move on whose way an encoder failed.
struct Failed {
    fault: Fault,
    /// How far the load went from the failure until the motor was off, deg, and its speed then,
    /// deg/s.
    until_off: [f64; 2],
    /// How far it went on after that, deg.
    coasted: f64,
}

/// Moves the load by 20 deg, and fails the wires on the way.
fn fails_on_the_way(law: &str, [motor, load]: [Wires; 2]) -> Failed {
    let plan = &both_encoders(&[law], &["reference.steps_deg=[20.0]"])[0];
    let mut simulated = SimulatedDevice::new(plan).unwrap();
    simulated.ticks(200);
    let mut client = Client::connect(SimulatedWire::new(simulated)).unwrap();
    client.arm().unwrap();
    client.move_to(20.0).unwrap();
    let device = &mut client.wire().simulated;
    let mut tick = |wires: [Wires; 2]| {
        [device.wires, device.load_wires] = wires;
        device.device.servo().heard();
        let load_deg = device.position_deg() + device.load_ahead_deg();
        (device.tick().state, load_deg, device.velocity_deg_per_s())
    };
    let begin = (0..5000).map(|_| tick([Wires::Sound; 2]).1).find(|deg| *deg > 5.0).unwrap();
    let (fault, off_deg, speed) = (0..5000)
        .find_map(|_| match tick([motor, load]) {
            (State::Faulted(fault), deg, speed) => Some((fault, deg, speed)),
            _ => None,
        })
        .ok_or(format!("{law}: {motor:?} {load:?} is no fault"))
        .unwrap();
    let rests_deg = (0..5000).map(|_| tick([motor, load]).1).last().unwrap();
    Failed { fault, until_off: [off_deg - begin, speed], coasted: rests_deg - off_deg }
}

/// The largest twist of a healthy gear in motion bounds the difference of both encoders since the
/// arming, when it was no more than that of a gear at rest; and so the travel from the failure on,
/// since the other side stands still or goes the other way. After that the friction brakes the
/// joint: 4.1 N m on 0.437 kg m^2, by energy; the twist of the gear adds to that what it had at the
/// most.
#[test]
fn a_failed_encoder_of_either_side_turns_the_motor_off_on_the_way() {
    let motor = parameters(&both_encoders(&["pd"], &[])[0]).unwrap().controller.motor;
    let deceleration = (4.1 / 0.437_f64).to_degrees();
    for (wires, what) in [
        ([Wires::Cut, Wires::Sound], "motor's cut"),
        ([Wires::OneCut, Wires::Sound], "a line of the motor's cut"),
        ([Wires::Swapped, Wires::Sound], "motor's swapped"),
        ([Wires::Sound, Wires::Cut], "load's cut"),
        ([Wires::Sound, Wires::OneCut], "a line of the load's cut"),
        ([Wires::Sound, Wires::Swapped], "load's swapped"),
    ] {
        for law in ["robust", "srnf", "both", "pd"] {
            let Failed { fault, until_off: [travel, speed], coasted } =
                fails_on_the_way(law, wires);
            let name = format!("{law}, {what}: {}", fault.describe());
            // For the table in tests/evidence/two-encoders.md.
            println!("{name}, load {:.1} deg", travel + coasted);
            let most = f64::from(motor.swing + motor.twist);
            assert!(travel.abs() < most, "{name}, {travel} deg of {most}");
            let most = speed * speed / (2.0 * deceleration) + f64::from(motor.twist);
            assert!(coasted.abs() < most, "{name}, {coasted} deg of {most}");
        }
    }
}

/// After a fault that may come from an encoder, both need a proof.
#[test]
fn a_hand_proves_the_encoders_that_count_and_a_jog_those_that_agree() {
    for (wires, is_proved) in [
        ([Wires::Sound, Wires::Sound], true),
        ([Wires::Cut, Wires::Sound], false),
        ([Wires::Sound, Wires::Cut], false),
    ] {
        for by_hand in [true, false] {
            let mut device = device(&STIFF);
            device.device.servo().fault(Fault::EncodersDisagree);
            device.ticks(200);
            device.device.servo().clear().unwrap();
            [device.wires, device.load_wires] = wires;
            device.ticks(200);
            assert_eq!(device.device.servo().arm_for_link(None), Err(Refusal::EncoderInDoubt));
            if by_hand {
                device.push(device.position_deg() + 1.0, 0.0);
                device.ticks(200);
            } else {
                let jog = device.device.parameters().unwrap().jog(&JogRequest::default()).unwrap();
                device.device.servo().jog(jog).unwrap();
                while device.tick().state == State::Armed {
                    device.device.servo().heard();
                }
                device.ticks(200);
            }
            let doubt = device.device.servo().is_encoder_in_doubt();
            assert_eq!(!doubt, is_proved, "{wires:?}, by hand: {by_hand}");
        }
    }
}

/// With one encoder the position is that of the first counter, with two that of the load's: the
/// difference of two counters is no travel.
#[test]
fn parameters_with_another_encoder_move_no_position() {
    let two = &both_encoders(&["robust"], &[])[0];
    let one = &both_encoders(&["robust"], &["loop.position=motor"])[0];
    let hardware = files::hardware::STM32F405;
    let [two, one] = [two, one].map(|plan| parameters(plan).unwrap());
    let mut servo = Servo::new(Ok(&one), Boot::at_zero(), &hardware);
    let mut input = Input { counter: 70_000, supply: 2048, ..Input::default() };
    input.load.counter = 4_000_000_000;
    for parameters in [&one, &two, &one, &two] {
        let mut place = None;
        let prepared = stiction::servo::ControlLoop::prepare(&mut place, parameters, &hardware);
        prepared.unwrap();
        servo.install(&mut place).unwrap();
        for _ in 0..200 {
            servo.tick(input);
        }
        assert_eq!((servo.position(), servo.is_at_rest()), (0, true));
        assert_eq!(servo.state(), State::Stopped);
    }
    // The position is that of another encoder: it is no longer known to be the true one.
    assert!(!servo.is_referenced());
}

/// A proof belongs to a counter. With other parameters, the same counter measures another side.
#[test]
fn parameters_with_another_encoder_prove_none() {
    let two = parameters(&both_encoders(&["robust"], &[])[0]).unwrap();
    let one = parameters(&both_encoders(&["robust"], &["loop.position=motor"])[0]).unwrap();
    let hardware = files::hardware::STM32F405;
    for sequence in [[&two, &one, &one], [&one, &two, &two], [&two, &one, &two]] {
        let mut servo = Servo::new(Ok(sequence[0]), Boot::at_zero(), &hardware);
        let mut input = Input { supply: 2048, ..Input::default() };
        let ticks = |servo: &mut Servo, input: &Input| {
            for _ in 0..200 {
                servo.tick(*input);
            }
        };
        ticks(&mut servo, &input);
        servo.fault(Fault::Stall);
        servo.clear().unwrap();
        ticks(&mut servo, &input);
        // A hand at the load: the motor's encoder, the first counter, is dead.
        input.load.counter = 100;
        ticks(&mut servo, &input);
        for parameters in &sequence[1..] {
            let mut place = None;
            stiction::servo::ControlLoop::prepare(&mut place, parameters, &hardware).unwrap();
            servo.install(&mut place).unwrap();
            ticks(&mut servo, &input);
        }
        assert_eq!(servo.arm_for_link(None), Err(Refusal::EncoderInDoubt));
        // After the change, the load alone is not enough either.
        input.load.counter = 200;
        ticks(&mut servo, &input);
        assert_eq!(servo.arm_for_link(None), Err(Refusal::EncoderInDoubt));
    }
}

/// The record of the flash keeps the motor's encoder, and one without it has a joint with one.
#[test]
fn the_flash_keeps_both_encoders() {
    for set in [&[][..], &["encoder.direction=reverse", "load_encoder.output=push-pull"][..]] {
        let written = parameters(&both_encoders(&["robust"], set)[0]).unwrap();
        assert!(written.controller.motor.count().is_some());
        let mut room = [0; stiction::parameters::ROOM];
        let record = written.encode(7, &mut room).unwrap();
        assert_eq!(Parameters::decode(record), Ok((written, 7)));
    }
}

/// Each encoder has a test of its own: 1 and 2 are the motor's lines, 4 and 8 those of the load.
#[test]
fn an_open_line_of_either_encoder_is_found_at_rest() {
    let set = ["encoder.output=push-pull", "load_encoder.output=push-pull"];
    for (wires, open) in [
        ([Wires::Cut, Wires::Sound], 3.0),
        ([Wires::OneCut, Wires::Sound], 1.0),
        ([Wires::Sound, Wires::Cut], 12.0),
        ([Wires::Sound, Wires::OneCut], 4.0),
    ] {
        let mut device = device(&set);
        assert_eq!(device.device.servo().latched(), None);
        [device.wires, device.load_wires] = wires;
        // A test begins after each second of rest.
        device.ticks(1500);
        let latched = device.device.servo().latched().unwrap();
        assert_eq!((latched.fault, latched.value), (Fault::EncoderOpen, open), "{wires:?}");
    }
}

/// The set point rests at 5 deg, so the load does, within two counts, and the motor within the
/// slack of 0.15 deg to either side and the wind-up by the stick friction, 4.9 N m behind 1000
/// N m/rad.
#[test]
fn a_tick_has_the_position_of_the_motor_and_zero_with_one_encoder() {
    let moved = |set: &[&str]| {
        let mut client = Client::connect(SimulatedWire::new(device(set))).unwrap();
        client.arm().unwrap();
        client.move_to(5.0).unwrap();
        client.pass(std::time::Duration::from_secs(4)).unwrap();
        let wire = client.wire();
        let tick = wire.simulated.tick().tick;
        (tick.counts, tick.motor_counts)
    };
    let (load, motor) = moved(&[]);
    let [load_deg, motor_deg] = [f64::from(load) * 360.0 / 16384.0, f64::from(motor) * 0.0036];
    assert!((load_deg - 5.0).abs() < 0.05, "{load_deg}");
    let twist_deg = (motor_deg - load_deg).abs();
    assert!(twist_deg < 0.15 + (4.9f64 / 1000.0).to_degrees() + 0.03, "{twist_deg} deg");
    // The motor alone: its counts are those of the joint.
    let (joint, motor) = moved(&["loop.position=motor"]);
    assert!((f64::from(joint) * 0.0036 - 5.0).abs() < 0.05, "{joint}");
    assert_eq!(motor, 0);
}
