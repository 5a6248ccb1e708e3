//! The first motions of a joint whose motor is wired the wrong way around, with gains that say
//! little: kp a tenth of the thesis's and no kd. A hand moves the joint, and the motor helps it.
//!
//! The joint is the small one of `jog.rs`, with an integrator of its own.

use stiction::parameters::DeviceConfig;
use stiction::servo::{Boot, Input, State};
use stiction::{Fault, Limits, Motion, Parameters, Servo};

use crate::fixture::srnf;
use crate::jog::{COUNT, H, Joint, KAPPA, SLIP, SOUND};
use files::hardware::STM32F405;

const KP: f64 = 0.1;
const LSB: f64 = 0.00488;
/// The effort of the hand, V: a fifth beyond what starts the joint.
const HAND: f64 = 0.5;

/// The largest speed of a joint that hand and reversed motor have moved so far from rest, deg/s:
/// without viscous friction, from what they have done on the way.
fn fastest(deg: f64) -> f64 {
    (2.0 * KAPPA * ((HAND - SLIP) * deg + KP * deg * deg / 2.0)).sqrt()
}

fn weak() -> Parameters {
    let mut parameters = srnf(&[]);
    parameters.controller.compensator.clear();
    (parameters.controller.pd.kp, parameters.controller.pd.kd) = (KP as f32, 0.0);
    parameters.device = DeviceConfig { soft_start: 5.0, ..parameters.device };
    let limits = Limits::derived(&parameters.controller, &parameters.device, 0.4);
    Parameters { limits, motion: Motion::Hold, ..parameters }
}

/// Closes the loop, pushes the joint by hand up to a position after the soft start, and lets it go;
/// returns the state, and where the joint is and how fast, at the end or when the output goes off.
fn pushed(motor: f64, until: f64) -> (State, f64, f64) {
    let mut servo = Servo::new(Ok(&weak()), Boot::default(), &STM32F405);
    let mut joint: Joint = SOUND;
    joint.motor = motor;
    for _ in 0..10 {
        servo.tick(Input { counter: joint.counter(), supply: 2048, lines: 0, ..Input::default() });
    }
    servo.arm().unwrap();
    for tick in 0..1500 {
        let output = servo.tick(Input {
            counter: joint.counter(),
            supply: 2048,
            lines: 0,
            ..Input::default()
        });
        if !output.enable {
            break;
        }
        let is_pushed = tick > 300 && joint.position < until;
        joint.load = if is_pushed { HAND } else { 0.0 };
        joint.pass(f64::from(output.tick.v_applied), true);
    }
    (servo.state(), joint.position, joint.velocity)
}

#[test]
fn a_reversed_motor_without_kd_is_seen_as_soon_as_its_effort_could_move_the_joint() {
    // The effort is beyond any friction from here on, rounded to a code.
    let from = (0.4 / LSB - 0.5).floor() * LSB / KP;
    // The joint moves already, so it has to gain eight counts over the way that it had made in a
    // tick, and one for the rounding of each tick. Hand and motor leave it so much acceleration.
    let least = KAPPA * (HAND + KP * from - SLIP - 0.02 * fastest(from + 2.0));
    let gained = |ticks: &u32| {
        let time = H * f64::from(*ticks);
        0.5 * least * time * time > f64::from(8 + ticks) * COUNT
    };
    // That, and the tick in which the effort gets there, and the one that is under way.
    let ticks = (1..50).find(gained).unwrap() + 2;
    let (state, at, speed) = pushed(-1.0, from + 2.0);
    assert_eq!(state, State::Faulted(Fault::EncoderReversed), "at {at} deg");
    let most = from + H * f64::from(ticks) * fastest(from + 2.0);
    assert!(most < from + 2.0, "the hand is there until then: {most} deg");
    assert!((from..most).contains(&at) && speed < fastest(at), "{at} of {most} deg, {speed} deg/s");
}

#[test]
fn an_effort_within_the_friction_moves_nothing_whichever_way_the_motor_is_wired() {
    for motor in [-1.0, 1.0] {
        let (state, at, speed) = pushed(motor, 1.0);
        // Let go at 1 deg, with what its own friction leaves of 0.2 V at 2 deg.
        let coasts = fastest(1.0).powi(2) / (2.0 * KAPPA * (SLIP - 2.0 * KP));
        assert_eq!((state, speed), (State::Armed, 0.0), "{motor}: at {at} deg");
        assert!((1.0..1.0 + H * fastest(1.1) + coasts).contains(&at), "{motor}: {at}");
    }
    // A sound motor holds against a hand of 0.5 V where it leaves it no more than slip: 1.2 deg,
    // and it trips nothing.
    let (state, at, speed) = pushed(1.0, 5.0);
    assert_eq!((state, speed), (State::Armed, 0.0), "at {at} deg");
    // From there it swings on by what it had gained, at most as far again.
    let balance = (HAND - SLIP) / KP;
    assert!((balance..2.0 * balance + H * fastest(1.0)).contains(&at), "{at} of {balance} deg");
}

/// The limits that the gains say nothing of are wide, but none is off.
#[test]
fn gains_that_say_little_turn_no_limit_off() {
    let Limits { overspeed, encoder_jump, following_error, reversal, .. } = weak().limits;
    for limit in [overspeed, encoder_jump, following_error, reversal] {
        assert!(limit > 0.0, "{:?}", weak().limits);
    }
}
