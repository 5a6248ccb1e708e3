//! An encoder that dies in motion, at every moment of a move: how far the joint goes on.
//!
//! What the servo sees is bounded, and the bound is derived. What it cannot see is an encoder that
//! dies while the joint creeps, when the law is left with an effort between the two levels of
//! friction: too little to be a stall, and enough to keep the joint moving. Those moments are
//! counted and printed, window by window. Only a second encoder would see them.

use simulator::device::simulated::Wires;
use stiction::Fault;
use stiction::servo::State;

use crate::dead_encoder::{armed, step};
use experiments::controllers;

// Tables 20 and 21 of the thesis: kappa, deg/s^2 per V; b, V s/deg; T_d, V; a count, deg; a tick.
const GAIN: f64 = 27.0;
const VISCOUS: f64 = 0.02;
const SLIP: f64 = 0.38;
const COUNT: f64 = 0.00242;
const TICK_S: f64 = 0.02;

/// The largest code within 0.4 V, which start the joint.
const BREAKAWAY: i16 = 81;
const LSB: f64 = 0.00488;

/// Targets, deg, and the number of ticks on the way to each in which the encoder dies.
const TARGETS: [f64; 3] = [0.5, 5.0, 20.0];
const MOMENTS: u32 = 250;

/// Ticks of 20 ms in a minute.
const MINUTE: u32 = 3000;

/// What comes of an encoder that dies in one moment.
struct Death {
    /// The true speed at the cut, deg/s.
    speed: f64,
    /// Counts in the last tick that was read, and the least effort with them, codes, from the begin
    /// of that tick to the second one that is not.
    counts: f64,
    least: f64,
    /// Whether the tick before had counts the other way, or none: that of a turn is not judged.
    turns: bool,
    /// Ticks until the servo is no longer armed; a minute at most.
    ticks: u32,
    state: State,
    /// Ticks in which the effort was beyond the slip level, but within the breakaway.
    between: u32,
    travel: f64,
    goes_on: bool,
    effort_v: f64,
}

fn death(law: &str, target: f64, cut: u32, wires: Wires) -> Death {
    let mut device = armed(law);
    step(&mut device, target);
    let (mut codes, mut read) = (vec![0], [0.0; 3]);
    for _ in 0..cut {
        device.device.servo().heard();
        read = [read[1], read[2], device.position_deg()];
        codes.push(device.tick().tick.code);
    }
    device.wires = wires;
    let (from, speed) = (device.position_deg(), device.velocity_deg_per_s());
    let (mut ticks, mut between, mut state) = (0, 0, State::Armed);
    let mut still = 0;
    // A joint at rest whose effort has been the same for 5 s is let rest: an integral with an error
    // of a count takes half a second for a code.
    while ticks < MINUTE && state == State::Armed && still < 250 {
        device.device.servo().heard();
        let output = device.tick();
        (state, ticks) = (output.state, ticks + 1);
        let code = output.tick.code;
        let is_still = device.velocity_deg_per_s() == 0.0 && codes.last() == Some(&code);
        still = if is_still { still + 1 } else { 0 };
        codes.push(code);
        between += u32::from(f64::from(code.abs()) * LSB > SLIP && code.abs() <= BREAKAWAY);
    }
    let last = codes[codes.len() - 1];
    let travel = read[2] - read[1];
    let with = |code: &i16| f64::from(*code) * travel.signum();
    let near = codes[cut.saturating_sub(1) as usize..].iter().take(3);
    Death {
        speed,
        counts: travel.abs() / COUNT,
        turns: (read[1] - read[0]) * travel.signum() < 2.0 * COUNT,
        least: near.map(with).fold(f64::INFINITY, f64::min),
        ticks,
        state,
        between,
        travel: (device.position_deg() - from).abs(),
        goes_on: state == State::Armed && device.velocity_deg_per_s() != 0.0,
        effort_v: f64::from(last) * LSB,
    }
}

/// The counts in a tick that cannot be none two ticks later, as the drive knows it: twice the
/// joint's gain, twice the breakaway effort, and the least effort with the motion (codes).
fn seen_at_once(least: f64) -> f64 {
    let lost = 2.0 * GAIN * TICK_S * TICK_S / COUNT * (0.8 - least * LSB);
    2.5 * lost.max(0.0) + 2.0
}

#[test]
fn an_encoder_that_dies_in_motion_is_seen_but_for_windows_in_which_the_joint_creeps() {
    let (mut at_once, mut windows) = (0, 0);
    for law in controllers() {
        let (mut furthest, mut blind, mut moments, mut longest) = (0.0f64, 0, 0, 0);
        for wires in [Wires::Cut, Wires::OneCut] {
            for target in TARGETS {
                let mut window: Option<(u32, u32, Death)> = None;
                let mut print = |window: &mut Option<(u32, u32, Death)>| {
                    let Some((first, last, worst)) = window.take() else { return };
                    windows += 1;
                    reliability!(
                        "blind",
                        law,
                        wires = if wires == Wires::Cut { "both" } else { "one" },
                        target,
                        from_s = format!("{:.2}", f64::from(first) * TICK_S),
                        moments = last - first + 1,
                        speed = format!("{:.2}", worst.speed.abs()),
                        effort_v = format!("{:.3}", worst.effort_v.abs()),
                        travel = format!("{:.0}", worst.travel)
                    );
                };
                for cut in 0..MOMENTS {
                    let name = format!("{law}, {target} deg, {wires:?} after {cut} ticks");
                    let death = death(law, target, cut, wires);
                    moments += 1;
                    if death.goes_on {
                        // It is let creep: with no more speed than an abrupt stop, and an effort
                        // that keeps a moving joint moving and starts none.
                        let effort = death.effort_v.abs();
                        assert!(
                            effort > SLIP && effort <= f64::from(BREAKAWAY) * LSB,
                            "{name}: {effort} V"
                        );
                        let counts = death.counts;
                        assert!(counts < seen_at_once(death.least) + 1.0, "{name}: {counts}");
                        blind += 1;
                        match &mut window {
                            Some((_, last, worst)) if *last + 1 == cut => {
                                *last = cut;
                                if death.travel > worst.travel {
                                    *worst = death;
                                }
                            }
                            _ => {
                                print(&mut window);
                                window = Some((cut, cut, death));
                            }
                        }
                        continue;
                    }
                    furthest = furthest.max(death.travel);
                    if death.state != State::Armed {
                        assert_eq!(death.state, State::Faulted(Fault::Stall), "{name}");
                        longest = longest.max(death.ticks);
                    }
                    // The axis is linear while it moves, so its travel is what the effort beyond
                    // the slip level and the speed that it has lost add up to. Beyond the breakaway
                    // that is the impulse of 0.2 V s, and 0.02 V more for 4 s at most; within it,
                    // 0.02 V. Effort of the other sign has the same bounds.
                    let within = 0.02 * f64::from(death.between + 1) * TICK_S;
                    let bound = (0.2 + 0.02 * 4.0 + within + death.speed.abs() / GAIN) / VISCOUS;
                    assert!(death.travel < bound, "{name}: {} of {bound} deg", death.travel);
                    // Counts in a tick, less one for their rounding, that cannot be none two ticks
                    // later.
                    if !death.turns && death.counts - 1.0 > seen_at_once(death.least) {
                        assert!(death.ticks <= 2, "{name}: {} ticks", death.ticks);
                        at_once += 1;
                    }
                }
                print(&mut window);
            }
        }
        reliability!(
            "dying",
            law,
            moments,
            furthest = format!("{furthest:.1}"),
            longest_s = format!("{:.1}", f64::from(longest) * TICK_S),
            blind
        );
        // Windows of a few hundredths of a second, where the law's effort passes the friction.
        assert!(blind < moments / 100, "{law}: {blind} of {moments}");
    }
    assert!(at_once > 400, "{at_once}");
    reliability!("blind-windows", windows, at_once);
}
