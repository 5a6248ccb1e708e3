//! Profiled moves of the thesis's joint under every law, with the thresholds and limits that are
//! derived, and what becomes of a move that is stopped, replaced or refused.

use simulator::device::moved::longest_s;
use simulator::device::simulated::SimulatedDevice;
use simulator::experiment::{Document, RunPlan, Task, builtins};
use stiction::Motion;
use stiction::control::reference::{Corner, Reference, Setpoint, Step, Trajectory};
use stiction::servo::{Output, Refusal, State};
use stiction::units::position::Position;

use crate::fixture::{parameters, plans};
use experiments::controllers;

/// A count of the thesis's encoder, deg, and its sample time, s.
const COUNT: f64 = 0.00242;
const TICK_S: f64 = 0.02;
/// The default soft start, half a second, ticks.
const SOFT_START: usize = 25;

fn plan(law: &str, set: &[&str]) -> RunPlan {
    let law = format!("loop.controller={law}");
    let own = [law.as_str(), "reference.steps_deg=[5.0]"];
    plans("step-response", &[&own, set].concat()).swap_remove(0)
}

/// A device around the joint of a plan, after the soft start of its arming.
fn armed(plan: &RunPlan) -> SimulatedDevice {
    let mut simulated = just_armed(plan);
    for _ in 0..SOFT_START {
        tick(&mut simulated);
    }
    simulated
}

/// The same before its first tick.
fn just_armed(plan: &RunPlan) -> SimulatedDevice {
    let mut simulated = SimulatedDevice::new(plan).unwrap();
    simulated.ticks(10);
    simulated.device.servo().arm_for_link(None).unwrap();
    simulated
}

fn counts(deg: f64) -> i32 {
    (deg / COUNT).round() as i32
}

fn go_to(simulated: &mut SimulatedDevice, plan: &RunPlan, counts: i32) -> Result<(), Refusal> {
    let parameters = parameters(plan);
    let motion = Motion::Profiled(Position::from_counts(counts));
    let course = motion.course(&parameters.controller, &parameters.profile).unwrap();
    let stiction::Course::Profile(profile) = course else { unreachable!("it is a profiled move") };
    simulated.device.servo().go_to(profile)
}

/// One tick with a sign of life of the link.
fn tick(simulated: &mut SimulatedDevice) -> Output {
    simulated.device.servo().heard();
    simulated.tick()
}

/// Runs for a time, and returns the set points; the loop stays closed.
fn run(simulated: &mut SimulatedDevice, time_s: f64, what: &str) -> Vec<Setpoint> {
    let ticks = 0..(time_s / TICK_S).ceil() as u32;
    ticks
        .map(|_| {
            let output = tick(simulated);
            let latched = simulated.device.servo().latched();
            assert_eq!(output.state, State::Armed, "{what}: {latched:?}");
            output.tick.setpoint()
        })
        .collect()
}

/// A step of 40 deg trips the following error or the overspeed under every law (`thesis.rs`).
#[test]
fn every_law_follows_a_profiled_move_of_any_size_with_the_derived_thresholds() {
    for law in controllers() {
        // What the driver lets through as it is, and half of it.
        for duty in ["drive.duty_max=1.0", "drive.duty_max=0.5"] {
            let plan = plan(law, &[duty]);
            let limits = parameters(&plan).profile;
            let mut simulated = armed(&plan);
            for deg in [0.1, -2.5, 40.0, -300.0, 300.0] {
                let what = format!("{law}, {duty}, {deg}");
                let from = simulated.position_deg();
                go_to(&mut simulated, &plan, counts(deg)).unwrap();
                let time_s = longest_s(&limits, deg - from) + 3.0;
                let setpoints = run(&mut simulated, time_s, &what);
                let end = Setpoint::at_rest(Position::from_counts(counts(deg)));
                assert_eq!(setpoints.last(), Some(&end), "{what}");
                // No law rests farther from its target than 0.4 V / Kp, under which PD sticks.
                let error = simulated.position_deg() - deg;
                assert!(error.abs() < 0.41, "{what}: {error}");
                let v = setpoints.iter().map(|setpoint| setpoint.velocity.abs());
                let fastest = v.fold(0.0, f32::max);
                assert!(fastest <= limits.velocity, "{what}: {fastest}");
                // A long move uses what it is allowed.
                assert!(deg.abs() < 100.0 || fastest > 0.95 * limits.velocity, "{what}");
            }
        }
    }
}

#[test]
fn a_profiled_move_of_forty_degrees_trips_nothing_in_any_experiment() {
    let mut moves = 0;
    // The experiments of the friction lab have no drive.
    let driven = builtins().iter().map(|builtin| builtin.name);
    for name in driven.filter(|name| !Document::open(name).unwrap().is_lab()) {
        for plan in plans(name, &[]) {
            // An unstable loop moves by itself, as high gain with a delay does (thesis, Appendix
            // A.2), and a ramp has none.
            let wild = ["literal-si", "delay-1"].iter().any(|slug| plan.label.contains(slug));
            if wild || matches!(plan.task, Task::Ramp(_)) {
                continue;
            }
            let limits = parameters(&plan).profile;
            let mut simulated = armed(&plan);
            for deg in [40.0, 0.0] {
                go_to(&mut simulated, &plan, counts(deg)).unwrap();
                let time_s = longest_s(&limits, 40.0) + 1.0;
                run(&mut simulated, time_s, &format!("{name} {}", plan.label));
                moves += 1;
            }
        }
    }
    assert!(moves > 50, "{moves}");
}

/// A move cannot start from a step whose first tick has not run.
#[test]
fn a_move_before_the_first_tick_begins_where_the_joint_is() {
    let plan = plan("srnf", &["reference.steps_deg=[5.0]", "device.soft_start_s=0"]);
    let mut simulated = SimulatedDevice::new(&plan).unwrap();
    simulated.ticks(10);
    simulated.device.servo().arm().unwrap();
    go_to(&mut simulated, &plan, 0).unwrap();
    let seen = run(&mut simulated, 1.0, "a move to zero");
    assert!(seen.iter().all(|setpoint| setpoint.position == Position::default()));
}

#[test]
fn a_hold_in_motion_slows_down_and_rests_on_the_first_count_that_the_limits_allow() {
    for after in [3, 20, 60, 100] {
        let plan = plan("srnf", &[]);
        let limits = parameters(&plan).profile;
        let (v, a) = (f64::from(limits.velocity), f64::from(limits.acceleration));
        let mut simulated = armed(&plan);
        go_to(&mut simulated, &plan, counts(-40.0)).unwrap();
        let before = *run(&mut simulated, f64::from(after) * TICK_S, "move").last().unwrap();
        simulated.device.servo().hold().unwrap();
        let setpoints = run(&mut simulated, v / a + 1.0, "hold");
        let end = setpoints.last().unwrap();
        assert_eq!((end.velocity, end.position.fraction), (0.0, 0.0), "{after}");
        // The way of v^2 / 2a, and what the averages of 0.08 s and a step of 0.04 s are behind. The
        // set point speeds up for that long before it slows down.
        let speed = f64::from(before.velocity.abs());
        let faster = (speed + 0.12 * a).min(v);
        let way = -f64::from(end.position.counts - before.position.counts) * COUNT;
        let most = faster * faster / (2.0 * a) + 0.12 * faster + 2.0 * COUNT;
        // One that slows down already does so a step earlier than a parabola.
        let least = speed * speed / (2.0 * a) - 0.04 * speed;
        assert!(way >= least && way <= most, "{after}: {way}, not {least} to {most}");
        // Another hold keeps the joint where it is by then, as without a profile.
        simulated.device.servo().hold().unwrap();
        let here = tick(&mut simulated).tick;
        assert!((here.reference_counts - here.counts).abs() <= 1, "{here:?}");
    }
}

/// A set point that would jump, or stop at once, changes its velocity by more than the limit.
#[test]
fn a_move_goes_on_smoothly_from_whatever_the_set_point_did() {
    let plan = plan("srnf", &[]);
    let limits = parameters(&plan).profile;
    let (sample_time, resolution) = (TICK_S as f32, COUNT as f32);
    let through: Vec<Corner> = [(25, 0), (425, 16_529)]
        .map(|(tick, counts)| Corner { tick, position: Position::from_counts(counts) })
        .into();
    let trajectory = Trajectory::new(&through, 0.25, sample_time, resolution).unwrap();
    let step = Step { to: Position { counts: 1033, fraction: 0.5 }, ..Step::default() };
    let befores: [(&str, Option<Reference>); 4] = [
        ("trajectory", Some(Reference::Trajectory(trajectory))),
        ("step", Some(Reference::Step(step))),
        ("arming", None),
        ("profile", None),
    ];
    for (what, reference) in befores {
        let mut simulated = armed(&plan);
        match (what, reference) {
            (_, Some(reference)) => simulated.device.servo().follow(reference).unwrap(),
            ("profile", _) => go_to(&mut simulated, &plan, 10_000).unwrap(),
            _ => {}
        }
        let before = *run(&mut simulated, 2.0, what).last().unwrap();
        go_to(&mut simulated, &plan, -5000).unwrap();
        let after = run(&mut simulated, 15.0, what);
        let mut last = before;
        for now in &after {
            let change = (now.velocity - last.velocity).abs() / sample_time;
            assert!(change <= limits.acceleration * 1.0001, "{what}: {change}");
            let travel = (f64::from(now.position.counts - last.position.counts)
                + f64::from(now.position.fraction - last.position.fraction))
                * COUNT;
            let reported = f64::from(now.velocity) * TICK_S;
            // The begin is on the grid of 2^-8 counts.
            assert!(
                (travel - reported).abs() < COUNT / 256.0 + 1e-6,
                "{what}: {travel} {reported}"
            );
            last = *now;
        }
        assert_eq!(last, Setpoint::at_rest(Position::from_counts(-5000)), "{what}");
    }
}

#[test]
fn what_cannot_be_done_is_refused_before_it_begins() {
    let range = ["limits.position_min_deg=-30", "limits.position_max_deg=30"];
    let [free, bounded] = [plan("srnf", &[]), plan("srnf", &range)];
    let mut simulated = SimulatedDevice::new(&free).unwrap();
    simulated.ticks(10);
    assert_eq!(go_to(&mut simulated, &free, 10), Err(Refusal::NotArmed));
    let mut simulated = armed(&bounded);
    for (deg, expected) in
        [(29.9, Ok(())), (30.1, Err(Refusal::OutOfRange)), (-30.1, Err(Refusal::OutOfRange))]
    {
        assert_eq!(go_to(&mut simulated, &bounded, counts(deg)), expected, "{deg}");
    }
    // The refused ones have changed nothing.
    let end = *run(&mut simulated, 6.0, "29.9").last().unwrap();
    assert_eq!(end, Setpoint::at_rest(Position::from_counts(counts(29.9))));
    let mut simulated = armed(&free);
    let far = 1 << 30;
    for (at, expected) in [
        (far, Err(Refusal::TooFar)),
        (-far, Err(Refusal::TooFar)),
        (i32::MIN, Err(Refusal::TooFar)),
        (far - 1, Ok(())),
        // It is on its way there.
        (-1, Ok(())),
    ] {
        assert_eq!(go_to(&mut simulated, &free, at), expected, "{at}");
    }
}

/// The difference of two positions of 32 bits changes its sign beyond 2^31 counts, and the joint
/// would go the other way.
#[test]
fn a_step_whose_way_has_no_sign_in_32_bits_is_refused() {
    let free = plan("srnf", &["limits.following_error_deg=off"]);
    let mut simulated = armed(&free);
    go_to(&mut simulated, &free, -413).unwrap();
    run(&mut simulated, 3.0, "-1");
    let far = 1 << 30;
    for (at, expected) in [
        (i32::MAX, Err(Refusal::TooFar)),
        (i32::MIN, Err(Refusal::TooFar)),
        (far, Err(Refusal::TooFar)),
        (far - 1000, Ok(())),
    ] {
        let to = Position::from_counts(at);
        let step = Step { from: Position::default(), to, at_tick: 0 };
        let servo = simulated.device.servo();
        assert_eq!(servo.follow(Reference::Step(step)), expected, "{at}");
    }
    let from = simulated.position_deg();
    simulated.ticks(10);
    assert!(simulated.position_deg() > from, "{} deg", simulated.position_deg());
}

/// The limits of a profile are those of the whole output: with a part of it, the joint would trail
/// until the following error ends the move.
#[test]
fn a_move_right_after_arming_waits_for_the_soft_start_and_then_works() {
    for (soft_start, wake_up, waits) in
        [("0", "0", 0), ("0.5", "0", 25), ("4", "0", 200), ("10", "0", 500), ("4", "0.1", 205)]
    {
        for law in ["pd", "srnf"] {
            let what = format!("{law}, {soft_start} s, {wake_up} s");
            let plan = plan(
                law,
                &[
                    &format!("device.soft_start_s={soft_start}"),
                    &format!("device.wake_up_s={wake_up}"),
                ],
            );
            let limits = parameters(&plan).profile;
            let mut simulated = just_armed(&plan);
            go_to(&mut simulated, &plan, counts(40.0)).unwrap();
            let still = run(&mut simulated, f64::from(waits) * TICK_S, &what);
            let rest = Setpoint::default();
            assert!(still.iter().all(|setpoint| *setpoint == rest), "{what}");
            let moved = run(&mut simulated, longest_s(&limits, 40.0) + 1.0, &what);
            // It sets out with the first tick of the whole output.
            assert!(moved[0].position.ahead_of(0) > 0.0, "{what}");
            assert_eq!(moved.last(), Some(&Setpoint::at_rest(Position::from_counts(counts(40.0)))));
        }
    }
    // Another target while it waits does not begin the wait anew, and a hold stays.
    let plan = plan("srnf", &["device.soft_start_s=2"]);
    let mut simulated = just_armed(&plan);
    go_to(&mut simulated, &plan, counts(40.0)).unwrap();
    run(&mut simulated, 1.0, "the first half");
    go_to(&mut simulated, &plan, counts(-40.0)).unwrap();
    let still = run(&mut simulated, 1.0, "the second half");
    assert!(still.iter().all(|setpoint| *setpoint == Setpoint::default()));
    assert!(run(&mut simulated, 0.02, "the begin")[0].velocity < 0.0);
    let mut simulated = just_armed(&plan);
    go_to(&mut simulated, &plan, counts(40.0)).unwrap();
    run(&mut simulated, 1.0, "the first half");
    simulated.device.servo().hold().unwrap();
    let still = run(&mut simulated, 3.0, "a hold");
    assert!(still.iter().all(|setpoint| *setpoint == Setpoint::default()));
}

/// The set point of a trajectory may be faster than a profile brakes. A target within the range is
/// not enough then.
#[test]
fn a_move_out_of_a_fast_trajectory_brakes_within_the_range_or_is_refused() {
    for direction in [1.0, -1.0] {
        // 15 deg/s, which 10 deg/s^2 bring to rest within 11.25 deg, and the averages' 0.64 s (T of
        // 0.4 s or more is 32 ticks) lead on by half of that time: 4.8 deg and a step.
        let range = if direction > 0.0 {
            ["limits.position_min_deg=-1", "limits.position_max_deg=61"]
        } else {
            ["limits.position_min_deg=-61", "limits.position_max_deg=1"]
        };
        let slow = ["profile.acceleration_deg_per_s2=10", "profile.jerk_deg_per_s3=50"];
        let plan = plan("srnf", &[range, slow].concat());
        let (sample_time, resolution) = (TICK_S as f32, COUNT as f32);
        let through: Vec<Corner> = [(25, 0.0), (225, 60.0 * direction)]
            .map(|(tick, deg)| Corner { tick, position: Position::from_counts(counts(deg)) })
            .into();
        let trajectory = Trajectory::new(&through, 0.25, sample_time, resolution).unwrap();
        let (mut accepted, mut refused) = (0.0f64, f64::MAX);
        for tick_of_it in (50..220).step_by(5) {
            let what = format!("{direction}, {tick_of_it}");
            let mut simulated = armed(&plan);
            simulated.device.servo().follow(Reference::Trajectory(trajectory.clone())).unwrap();
            let time_s = f64::from(tick_of_it) * TICK_S;
            let at = *run(&mut simulated, time_s, &what).last().unwrap();
            let deg = f64::from(at.position.ahead_of(0)) * COUNT * direction;
            let outcome = go_to(&mut simulated, &plan, counts(5.0 * direction));
            let after = run(&mut simulated, 15.0, &what);
            let farthest = after
                .iter()
                .map(|setpoint| f64::from(setpoint.position.ahead_of(0)) * COUNT * direction)
                .fold(0.0, f64::max);
            assert!(farthest <= 61.0 + 1e-6, "{what}: {farthest}");
            let end = after.last().unwrap().position.counts;
            match outcome {
                Ok(()) => {
                    accepted = accepted.max(deg);
                    assert_eq!(end, counts(5.0 * direction), "{what}");
                }
                // The trajectory goes on.
                Err(refusal) => {
                    refused = refused.min(deg);
                    assert_eq!(
                        (refusal, end),
                        (Refusal::TooFast, counts(60.0 * direction)),
                        "{what}"
                    );
                }
            }
        }
        // The way to rest by the closed form, within a step of the first stage (0.04 s) and of the
        // ticks that were tried (0.1 s).
        let way = 15.0 * 15.0 / 20.0 + 0.5 * 0.64 * 15.0;
        let last = 61.0 - way;
        assert!(accepted > last - 2.5 && accepted < last + 0.7, "{accepted}, not {last}");
        assert!(refused > accepted && refused < accepted + 1.6, "{refused} {accepted}");
    }
}

/// A profile of the parameters begins anew with each arming.
#[test]
fn a_profiled_motion_of_the_parameters_begins_with_each_arming() {
    let plan = plan("srnf", &[]);
    let mut parameters = parameters(&plan);
    parameters.motion = Motion::Profiled(Position::from_counts(2000));
    parameters.device.soft_start = 1.0;
    let mut simulated = SimulatedDevice::new(&plan).unwrap();
    let mut room = [0; stiction::parameters::ROOM];
    let record = parameters.encode(1, &mut room).unwrap();
    assert_eq!(stiction::Parameters::decode(record).unwrap().0, parameters);
    let mut control_loop = None;
    let hardware = files::hardware::STM32F405;
    stiction::servo::ControlLoop::prepare(&mut control_loop, &parameters, &hardware).unwrap();
    simulated.device.servo().install(&mut control_loop).unwrap();
    let mut runs = Vec::new();
    for _ in 0..2 {
        simulated.ticks(60);
        simulated.device.servo().arm().unwrap();
        runs.push(run(&mut simulated, 4.0, "arming"));
        simulated.device.servo().stop();
    }
    assert_eq!(runs[0].last(), Some(&Setpoint::at_rest(Position::from_counts(2000))));
    assert_eq!(runs[0], runs[1]);
    // Half a second longer than the default soft start, of which it waits for all.
    let waits = runs[0].iter().take_while(|setpoint| **setpoint == Setpoint::default()).count();
    assert_eq!(waits, 50);
}
