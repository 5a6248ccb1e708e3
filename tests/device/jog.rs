//! The guarded jog: what it finds, and how far the joint goes at worst.
//!
//! The joint here is a small one of its own, with an integrator of its own: 27 deg/s^2 per V, 0.02
//! V s/deg, 0.40 V to start it and 0.38 V to keep it moving, 20 ms, counts of 0.00242 deg. The
//! simulator's joint, solved in closed form, is the second method for the sound one.

use files::hardware::STM32F405;
use simulator::device::client::Client;
use simulator::device::simulated::{SimulatedDevice, Wires};
use simulator::device::wire::SimulatedWire;
use stiction::link::StateCode;
use stiction::motion::jog::{JogBounds, JogEnd, JogFindings, JogRequest, Verdict};
use stiction::servo::{Boot, Input, State};
use stiction::{Fault, Limits, Parameters, Servo, parameters};

use crate::first_run::{Bench, follow};
use crate::fixture::{plans, srnf};

pub const COUNT: f64 = 0.00242;
pub const H: f64 = 0.02;
pub const KAPPA: f64 = 27.0;
pub const SLIP: f64 = 0.38;
const STICK: f64 = 0.40;

/// A joint, and what is wrong with it.
#[derive(Clone, Copy)]
pub struct Joint {
    pub position: f64,
    pub velocity: f64,
    /// The levels of its friction, V, and its viscous friction, V s/deg.
    friction: [f64; 2],
    viscous: f64,
    /// A load that pulls while the brake is open, which is while the output is on, V.
    pub load: f64,
    pub motor: f64,
    encoder: Encoder,
    counts: i32,
    counter: i32,
}

#[derive(Clone, Copy, PartialEq)]
pub enum Encoder {
    Sound,
    Reversed,
    Dead,
    OneChannel,
}

pub const SOUND: Joint = Joint {
    position: 0.0,
    velocity: 0.0,
    friction: [STICK, SLIP],
    viscous: 0.02,
    load: 0.0,
    motor: 1.0,
    encoder: Encoder::Sound,
    counts: 0,
    counter: 0,
};

impl Joint {
    /// Lets a tick pass, in steps of 20 us.
    pub fn pass(&mut self, effort: f64, is_on: bool) {
        let [stick, slip] = self.friction;
        let driven = if is_on { self.motor * effort + self.load } else { 0.0 };
        let dt = H / 1000.0;
        for _ in 0..1000 {
            let sign = if self.velocity == 0.0 { driven.signum() } else { self.velocity.signum() };
            if self.velocity == 0.0 && driven.abs() <= stick {
                continue;
            }
            let next =
                self.velocity + KAPPA * (driven - slip * sign - self.viscous * self.velocity) * dt;
            self.velocity = if next * sign < 0.0 && slip > 0.0 { 0.0 } else { next };
            self.position += self.velocity * dt;
        }
    }

    pub fn counter(&mut self) -> u32 {
        let counts = (self.position / COUNT).round() as i32;
        let edges = counts - std::mem::replace(&mut self.counts, counts);
        match self.encoder {
            Encoder::Sound => self.counter += edges,
            Encoder::Reversed => self.counter -= edges,
            Encoder::Dead => {}
            Encoder::OneChannel => self.counter ^= edges & 1,
        }
        self.counter as u32
    }
}

/// What a device is before anything is tuned: no gains, and friction that is known or not.
fn untuned(breakaway: f32) -> Parameters {
    let mut parameters = srnf(&[]);
    parameters.controller.compensator.clear();
    (parameters.controller.pd.kp, parameters.controller.pd.kd) = (0.0, 0.0);
    let (controller, device) = (&parameters.controller, &parameters.device);
    let limits = Limits::derived(controller, device, breakaway);
    let jog = JogBounds::derived(controller, device, breakaway);
    Parameters { limits, jog, ..parameters }
}

struct Run {
    state: State,
    found: Option<JogFindings>,
    /// The farthest that the joint was from its start, and where it was when the output went off,
    /// deg.
    farthest: f64,
    at_off: f64,
    ticks: u32,
}

/// Jogs a joint, with a client that is there until a tick.
fn jog(parameters: &Parameters, mut joint: Joint, asked: JogRequest, silent_from: u32) -> Run {
    let mut servo = Servo::new(Ok(parameters), Boot::default(), &STM32F405);
    let mut farthest = 0.0f64;
    for _ in 0..10 {
        servo.tick(Input { counter: joint.counter(), supply: 2048, lines: 0, ..Input::default() });
    }
    servo.jog(parameters.jog(&asked).unwrap()).unwrap();
    let (mut ticks, mut at_off) = (0, None);
    for tick in 0..1500 {
        if tick < silent_from {
            servo.heard();
        }
        let output = servo.tick(Input {
            counter: joint.counter(),
            supply: 2048,
            lines: 0,
            ..Input::default()
        });
        if !output.enable && at_off.is_none() {
            (ticks, at_off) = (tick, Some(joint.position));
        }
        joint.pass(f64::from(output.tick.v_applied), output.enable);
        farthest = farthest.max(joint.position.abs());
    }
    let (state, found) = (servo.state(), servo.jogged());
    Run { state, found, farthest, at_off: at_off.unwrap(), ticks }
}

/// Where a joint is, and how fast, a time after a ramp of the effort has started it, in closed form
/// without viscous friction, which only slows it: deg, deg/s.
fn ramped(rate: f64, t: f64) -> (f64, f64) {
    // The effort is held for a tick and rounded to a code; this is never below it.
    let excess = STICK - SLIP + 0.5 * 0.00488;
    let v = KAPPA * (excess * t + rate * t * t / 2.0);
    (KAPPA * (excess * t * t / 2.0 + rate * t.powi(3) / 6.0), v)
}

/// How far friction lets it coast from there.
fn stopped((x, v): (f64, f64)) -> f64 {
    x + v * v / (2.0 * KAPPA * SLIP)
}

/// The farthest that a dead encoder lets a joint go, one way: pushed from breakaway to the bound of
/// the effort, and a tick.
fn dead(bounds: &JogBounds) -> f64 {
    let [effort, rate] = [bounds.effort, bounds.rate].map(f64::from);
    stopped(ramped(rate, (effort - STICK) / rate + H))
}

/// The farthest that a joint goes whose encoder counts: until 9 counts are past, of which 8 are
/// seen, and a tick.
fn counted(bounds: &JogBounds) -> f64 {
    let rate = f64::from(bounds.rate);
    let t = (0..100_000)
        .map(|i| f64::from(i) * 1e-5)
        .find(|t| ramped(rate, *t).0 > 9.0 * COUNT)
        .unwrap();
    stopped(ramped(rate, t + H))
}

#[test]
fn the_direction_is_found_and_the_joint_has_hardly_moved() {
    for breakaway in [0.4, 0.0] {
        let parameters = untuned(breakaway);
        // 1.5 times what starts it in a second, or a quarter of 5 V in half a second.
        let (effort, rise) = if breakaway > 0.0 { (0.6, 1.0) } else { (1.25, 0.5) };
        let bounds = parameters.jog;
        assert!((bounds.effort / effort - 1.0).abs() < 1e-6, "{bounds:?}");
        assert_eq!(bounds.rate, bounds.effort / rise);
        let most = counted(&parameters.jog);
        assert!(most < 0.2, "{most}");
        for (motor, encoder, verdict) in [
            (1.0, Encoder::Sound, Verdict::Agrees),
            (-1.0, Encoder::Sound, Verdict::Reversed),
            (1.0, Encoder::Reversed, Verdict::Reversed),
            (-1.0, Encoder::Reversed, Verdict::Agrees),
        ] {
            let run =
                jog(&parameters, Joint { motor, encoder, ..SOUND }, JogRequest::default(), 1500);
            let found = run.found.unwrap();
            assert_eq!((run.state, found.verdict()), (State::Stopped, verdict), "{found:?}");
            assert!(run.farthest > 8.0 * COUNT && run.farthest < most, "{} {most}", run.farthest);
            for way in found.ways {
                assert_eq!(way.ended, JogEnd::Moved);
                // It set out at 0.4 V, and was seen within the time of `counted`.
                assert!(way.effort > 0.4 && way.effort < effort, "{way:?}");
                assert!((8..20).contains(&way.moved.abs()), "{way:?}");
            }
        }
    }
}

#[test]
fn a_dead_encoder_leads_as_far_as_the_ramp_pushes() {
    for (breakaway, within) in [(0.4, 0.25), (0.0, 2.0)] {
        let parameters = untuned(breakaway);
        let most = dead(&parameters.jog);
        assert!(most < within, "{most}");
        for (encoder, verdict) in
            [(Encoder::Dead, Verdict::Still), (Encoder::OneChannel, Verdict::Noise)]
        {
            let run = jog(&parameters, Joint { encoder, ..SOUND }, JogRequest::default(), 1500);
            let found = run.found.unwrap();
            assert_eq!((run.state, found.verdict()), (State::Stopped, verdict), "{found:?}");
            assert!(found.ways.iter().all(|way| way.ended == JogEnd::Effort), "{found:?}");
            // Without the viscous friction, and with every rounding upwards, it is a bit more.
            assert!((0.6 * most..most).contains(&run.farthest), "{} of {most}", run.farthest);
            let known = if breakaway > 0.0 { "yes" } else { "no" };
            let encoder = if verdict == Verdict::Still { "dead" } else { "one channel dead" };
            reliability!(
                "jog",
                encoder,
                known,
                travel_deg = format!("{:.2}", run.farthest),
                bound_deg = format!("{most:.2}")
            );
        }
    }
}

#[test]
fn jogs_with_a_dead_encoder_add_up_to_a_stall() {
    // A way is 0.2 V beyond breakaway at 0.6 V/s: 0.033 V s, and a jog 0.067 V s of 0.2 V s.
    let parameters = untuned(0.4);
    let mut servo = Servo::new(Ok(&parameters), Boot::default(), &STM32F405);
    for _ in 0..10 {
        servo.tick(Input::default());
    }
    let mut jogs = 0;
    let fault = loop {
        servo.jog(parameters.jog(&JogRequest::default()).unwrap()).unwrap();
        while servo.state() == State::Armed {
            servo.heard();
            servo.tick(Input::default());
        }
        if let State::Faulted(fault) = servo.state() {
            break fault;
        }
        jogs += 1;
        assert!(jogs < 20);
    };
    assert!(fault == Fault::Stall && (2..=3).contains(&jogs), "{fault:?} after {jogs}");
}

#[test]
fn a_blocked_joint_stays_where_it_is_and_the_jog_reports_no_motion() {
    let blocked = Joint { friction: [9.0, 9.0], ..SOUND };
    let run = jog(&untuned(0.4), blocked, JogRequest::default(), 1500);
    let found = run.found.unwrap();
    assert_eq!((found.verdict(), run.farthest), (Verdict::Still, 0.0));
    // 49 rungs of 0.012 V are 0.588 V, and the next one is the bound itself, to a rounding.
    assert!(found.ways.iter().all(|way| way.effort > 0.57 && way.effort <= 0.6), "{found:?}");
}

/// Travel and speed end what no friction stops.
#[test]
fn a_joint_without_friction_ends_at_its_bounds() {
    let parameters = untuned(0.4);
    let free = Joint { friction: [0.0; 2], viscous: 0.0, ..SOUND };
    // After the first push it coasts: 2 deg, and what it travels in the tick that sees it.
    let run = jog(&parameters, free, JogRequest::default(), 1500);
    let found = run.found.unwrap();
    assert_eq!(found.verdict(), Verdict::RunsOn);
    assert_eq!(found.ways.map(|way| way.ended), [JogEnd::Moved, JogEnd::Travel]);
    assert!((2.0..2.0 + 1.0 * H).contains(&run.at_off), "{}", run.at_off);
    // A third of that, if it is asked for.
    let asked = JogRequest { travel: Some(0.7), ..JogRequest::default() };
    let run = jog(&parameters, free, asked, 1500);
    assert!((0.7..0.7 + 1.0 * H).contains(&run.at_off), "{}", run.at_off);

    // A load falls as soon as the brake opens, with 27 deg/s^2. The speed's bound of 4
    // deg/s shows when 8 counts are travelled beyond it.
    let load = -1.0;
    let run = jog(&parameters, Joint { load, ..free }, JogRequest::default(), 1500);
    let found = run.found.unwrap();
    assert_eq!(found.verdict(), Verdict::RunsOn, "{found:?}");
    assert_eq!(found.ways[1].ended, JogEnd::Speed);
    let most = 4.0 + (16.0 * COUNT * KAPPA).sqrt() + KAPPA * H;
    let bounds = [4.0 * 4.0 / (2.0 * KAPPA), most * most / (2.0 * KAPPA) + most * H];
    assert!((bounds[0]..bounds[1]).contains(&-run.at_off), "{} {bounds:?}", run.at_off);
    // A load within the friction does not deceive: from rest the joint goes where it is pushed.
    for load in [-0.2, 0.2] {
        let run = jog(&parameters, Joint { load, ..SOUND }, JogRequest::default(), 1500);
        assert_eq!(run.found.unwrap().verdict(), Verdict::Agrees, "{load}");
    }
}

#[test]
fn silence_a_stop_and_time_end_a_jog() {
    // Half a second of silence, which begins at the last tick that hears a client.
    let parameters = untuned(0.4);
    let stuck = Joint { friction: [9.0, 9.0], ..SOUND };
    let slow = JogRequest { rate: Some(0.1), ..JogRequest::default() };
    let run = jog(&parameters, stuck, slow, 10);
    assert_eq!((run.state, run.found), (State::Faulted(Fault::LinkTimeout), None));
    assert_eq!(run.ticks, 9 + 25);
    // 10 s, or what is asked for.
    for (time, ticks) in [(None, 500), (Some(1.0), 50)] {
        let asked = JogRequest { rate: Some(0.01), time, ..JogRequest::default() };
        let run = jog(&parameters, stuck, asked, 1500);
        let found = run.found.unwrap();
        assert_eq!((run.ticks, found.ways[0].ended), (ticks, JogEnd::Time));
        assert_eq!((found.verdict(), found.ways[1].ended), (Verdict::Still, JogEnd::Not));
    }
}

/// A client asks for less, and never for more.
#[test]
fn a_client_gets_less_but_never_more_than_the_machine_allows() {
    let parameters = untuned(0.4);
    let asked =
        |effort, rate, travel, speed, time| JogRequest { effort, rate, travel, speed, time };
    let own = parameters.jog;
    let all =
        asked(Some(own.effort), Some(own.rate), Some(own.travel), Some(own.speed), Some(own.time));
    assert_eq!(parameters.jog(&all), parameters.jog(&JogRequest::default()));
    let more = |own: f32| Some(own * 1.01);
    for (refused, name) in [
        (asked(more(own.effort), None, None, None, None), "effort_v"),
        (asked(None, more(own.rate), None, None, None), "rate_v_per_s"),
        (asked(None, None, more(own.travel), None, None), "travel_deg"),
        (asked(None, None, None, more(own.speed), None), "speed_deg_per_s"),
        (asked(None, None, None, None, more(own.time)), "time_s"),
        (asked(Some(0.0), None, None, None, None), "effort_v"),
        (asked(Some(f32::NAN), None, None, None, None), "effort_v"),
        // Seven counts show no direction.
        (asked(None, None, Some(7.0 * 0.00242), None, None), "travel_deg"),
    ] {
        let error = parameters.jog(&refused).unwrap_err();
        assert_eq!(parameters::about(error.key).unwrap().name, name);
    }
    // An effort that does not start the joint moves nothing.
    let run = jog(&parameters, SOUND, asked(Some(0.39), None, None, None, None), 1500);
    assert_eq!((run.found.unwrap().verdict(), run.farthest), (Verdict::Still, 0.0));
}

fn client(wires: Wires) -> Client<SimulatedWire> {
    let set = [
        "loop.controller=pd",
        "controller.pd.kp_v_per_deg=0",
        "controller.pd.kd_v_per_deg_per_s=0",
        "reference.steps_deg=[5.0]",
    ];
    let mut simulated = SimulatedDevice::new(&plans("step-response", &set)[0]).unwrap();
    simulated.ticks(10);
    simulated.wires = wires;
    Client::connect(SimulatedWire::new(simulated)).unwrap()
}

fn jogged(client: &mut Client<SimulatedWire>) -> Option<JogFindings> {
    client.jog(JogRequest::default()).unwrap();
    while client.pass(std::time::Duration::from_secs(1)).unwrap().state == StateCode::Armed {}
    client.jogged().unwrap()
}

#[test]
fn over_the_link_the_simulators_joint_shows_the_same() {
    for (wires, encoder) in [
        (Wires::Sound, Encoder::Sound),
        (Wires::Swapped, Encoder::Reversed),
        (Wires::Cut, Encoder::Dead),
    ] {
        let mut client = client(wires);
        assert_eq!(client.jogged().unwrap(), None);
        let found = jogged(&mut client).unwrap();
        let small = jog(&untuned(0.4), Joint { encoder, ..SOUND }, JogRequest::default(), 1500);
        assert_eq!(found.verdict(), small.found.unwrap().verdict());
        for (found, small) in found.ways.iter().zip(small.found.unwrap().ways) {
            assert_eq!(found.ended, small.ended);
            // Within a rung, and what a rung makes of the counts.
            assert!((found.effort - small.effort).abs() < 0.025, "{found:?} {small:?}");
            assert!((found.moved - small.moved).abs() <= 4, "{found:?} {small:?}");
        }
        let truth = client.wire().simulated.position_deg().abs();
        assert!(truth < counted(&untuned(0.4).jog), "{truth}");
        assert_eq!(client.status().unwrap().faults, 0);
    }
}

#[test]
fn a_jog_obeys_a_stop_and_nothing_else_and_leaves_nothing_behind() {
    let mut client = client(Wires::Sound);
    client.arm().unwrap();
    assert!(client.jog(JogRequest::default()).unwrap_err().to_string().contains("`stop` first"));
    client.stop().unwrap();
    client.pass(std::time::Duration::from_millis(100)).unwrap();
    client.wire().simulated.brake_v = 9.0;
    client.jog(JogRequest { rate: Some(0.05), ..JogRequest::default() }).unwrap();
    client.pass(std::time::Duration::from_secs(1)).unwrap();
    assert!(client.step_to(1.0).unwrap_err().to_string().contains("`stop` first"));
    assert!(client.wire().simulated.tick().enable);
    client.stop().unwrap();
    assert!(!client.wire().simulated.tick().enable);
    assert_eq!(client.jogged().unwrap(), None);
    // The next one begins anew.
    client.wire().simulated.brake_v = 0.0;
    client.pass(std::time::Duration::from_millis(100)).unwrap();
    assert_eq!(jogged(&mut client).unwrap().verdict(), Verdict::Agrees);
    // The monitor of the direction is on again after it: a reversed encoder trips when the joint is
    // armed.
    client.wire().simulated.wires = Wires::Swapped;
    let values = [(
        stiction::units::value::key(
            <stiction::control::pd::PdGains as stiction::units::value::Table>::ABOUT,
            "kp",
        ),
        1f32.to_bits(),
    )];
    client.change(&values).unwrap();
    client.pass(std::time::Duration::from_millis(100)).unwrap();
    client.arm().unwrap();
    client.step_to(5.0).unwrap();
    let status = client.pass_armed(std::time::Duration::from_secs(2)).unwrap();
    assert_eq!(status.fault.code, Fault::EncoderReversed as u8);
}

impl Bench for SimulatedWire {
    const KEEPS: bool = true;

    fn truth_deg(&mut self) -> f64 {
        self.simulated.position_deg()
    }
}

/// The guide of docs/reference/wiring.md, from an untuned board to its first move.
#[test]
fn the_first_run_can_be_followed_on_the_simulated_device() {
    for is_reversed in [false, true] {
        let mut client = client(if is_reversed { Wires::Swapped } else { Wires::Sound });
        follow(&mut client, &srnf(&[]), is_reversed);
    }
}
