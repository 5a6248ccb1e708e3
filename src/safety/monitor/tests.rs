//! Tests of each monitor on both sides of its threshold. A count is 1 deg, a code 1 V and a tick 1
//! s, so that a threshold in counts, codes or ticks equals its value in the limits.

use super::*;
use crate::units::value::Table;

const UNITS: Units = Units { count: 1.0, code: 1.0, tick: 1.0, supply: 1.0 };

const HARDWARE: Hardware = Hardware {
    pwm_clock_hz: 168e6,
    supply_top: 4095,
    dead_time_max: 6e-6,
    sample_time: [1e-4, 0.02],
};

#[test]
fn a_jump_and_a_speed_trip_beyond_their_limits_in_both_directions() {
    let limits = Limits { encoder_jump: 10.0, overspeed: 5.0, ..Limits::OFF };
    let jump = EncoderJump::new(&limits, &UNITS);
    let speed = Overspeed::new(&limits, 5, 0.0, &UNITS);
    let speeds = |v: f32| speed.check(&mut OverspeedState::default(), v, 0).is_some();
    assert_eq!([10, -10, 11, -11].map(|travel| jump.check(travel, 1)), [false, false, true, true]);
    // The first answer after four missing ones has the travel of five ticks.
    assert_eq!([50, -50, 51, -51].map(|travel| jump.check(travel, 5)), [false, false, true, true]);
    let off = EncoderJump::new(&Limits::OFF, &UNITS);
    assert!(![1, 5].into_iter().any(|ticks| off.check(i32::MIN, ticks)));
    assert_eq!([5.0, -5.0, 5.1, -5.1].map(speeds), [false, false, true, true]);
}

/// The limit is 5 deg/s, and the mean is that of 20 ticks in two halves.
#[test]
fn a_swing_is_not_too_fast_and_a_joint_that_goes_one_way_is_within_one_and_a_half_times() {
    let limits = Limits { overspeed: 5.0, ..Limits::OFF };
    let monitor = Overspeed::new(&limits, 5, 20.0, &UNITS);
    let trips = |travel: fn(i32) -> i32| {
        let mut state = OverspeedState::default();
        (0..200).find_map(|k| Some((k, monitor.check(&mut state, 99.0, travel(k))?)))
    };
    // Four times as fast as the limit, to and fro, four ticks each way.
    assert_eq!(trips(|k| if k / 4 % 2 == 0 { 20 } else { -20 }), None);
    assert_eq!(trips(|_| 5), None);
    assert_eq!(trips(|_| -6), Some((19, -6.0)));
    // It sets out in the second tick of a piece: 9 and 10 of 20 ticks are 5.7 deg/s.
    assert_eq!(trips(|k| if k > 10 { 6 } else { 0 }).map(|(k, _)| k), Some(29));
    assert_eq!(trips(|k| if k > 10 { 60 } else { 0 }), Some((19, 27.0)));
    // A regression over as long a time needs no mean.
    let regressed = Overspeed::new(&limits, 21, 20.0, &UNITS);
    assert_eq!(regressed.check(&mut OverspeedState::default(), 5.1, 0), Some(5.1));
}

#[test]
fn a_joint_that_is_slowed_down_by_the_effort_has_no_wrong_wire() {
    let limits = Limits { reversal: 8.0, breakaway_effort: 4.0, ..Limits::OFF };
    let monitor = Reversal::new(&limits, &UNITS);
    let first = |moves: &[(i32, i32)]| {
        let mut state = ReversalState::default();
        moves.iter().find_map(|(code, travel)| monitor.check(&mut state, *code, *travel))
    };
    // A load drives it, until the effort is beyond the breakaway.
    let driven =
        |by: i32, then: &[(i32, i32)]| first(&[&[(by.signum() * -3, by); 2], then].concat());
    assert_eq!(driven(-9, &[(4, -9), (4, -8), (5, -7), (5, -9), (5, -5)]), None);
    assert_eq!(driven(9, &[(-4, 9), (-4, 8), (-5, 7), (-5, 9), (-5, 5)]), None);
    // A wrong wire makes it faster: by eight counts beyond the nine of each tick.
    assert_eq!(driven(-9, &[(4, -12), (4, -15)]), Some(-9));
    // What it is slowed down by proves nothing.
    assert_eq!(driven(-9, &[(4, -1), (4, -1), (4, -17)]), Some(-8));
    // Of two ticks the slower one counts. A glitch has one tick, and jitter goes to and fro: each
    // count counts then. Either way around.
    for (before, then) in [([-4, -9], -8), ([0, -700], -4), ([1, -1], -4)] {
        let moves = [(3, before[0]), (3, before[1]), (4, then), (4, then)];
        assert_eq!(first(&moves), Some(-8), "{moves:?}");
        assert_eq!(first(&moves.map(|(code, travel)| (-code, -travel))), Some(-8), "{moves:?}");
    }
}

#[test]
fn travel_against_the_effort_trips_and_a_joint_that_still_coasts_does_not() {
    let limits = Limits { reversal: 8.0, breakaway_effort: 4.0, ..Limits::OFF };
    let monitor = Reversal::new(&limits, &UNITS);
    let first = |moves: &[(i32, i32)]| {
        let mut state = ReversalState::default();
        moves.iter().find_map(|(code, travel)| monitor.check(&mut state, *code, *travel))
    };
    assert_eq!(first(&[(4, -4), (4, -3)]), None);
    assert_eq!(first(&[(4, -4), (4, -4)]), Some(-8));
    assert_eq!(first(&[(-4, 4), (-4, 4)]), Some(-8));
    // Less than the breakaway proves nothing, and eight counts with the effort prove the wiring.
    assert_eq!(first(&[(3, -9), (3, -9)]), None);
    assert_eq!(first(&[(4, 8), (4, -20)]), None);
    // The effort turns, the joint goes on until it has stopped.
    assert_eq!(first(&[(4, 3), (-4, 9), (-4, 9)]), None);
    // What it went with the effort is set off against what it goes back against it.
    assert_eq!(first(&[(4, 3), (-4, 9), (-4, 0), (-4, 10)]), None);
    assert_eq!(first(&[(4, 3), (-4, 9), (-4, 0), (-4, 11)]), Some(-11));
    // That of two pushes is not added up, and proves nothing.
    assert_eq!(first(&[(4, 5), (3, 0), (4, 5), (-4, 0), (-4, 12)]), None);
    assert_eq!(first(&[(4, 5), (3, 0), (4, 5), (-4, 0), (-4, 13)]), Some(-13));
}

/// The travel of a joint of the family with declared noise in its first move, to the tick where it
/// tripped once: pushed by seven counts, braked for ten ticks.
#[test]
fn noise_of_a_count_in_a_short_move_that_is_braked_looks_like_no_wrong_wire() {
    let pushed = [-1, 1, -2, 1, 0, 1, 1, 0, 1, -1, 2, 1, 2, -1, 2].map(|travel| (4, travel));
    let between = [(-3, 2)];
    let braked = [0, 0, 1, 0, 3, 1, -1, 1, 1, 1, -1, 2].map(|travel| (-4, travel));
    let limits = Limits { reversal: 8.0, breakaway_effort: 4.0, ..Limits::OFF };
    let monitor = Reversal::new(&limits, &UNITS);
    let first = |moves: &[&[(i32, i32)]], sign: i32| {
        let mut state = ReversalState::default();
        let moves = moves.concat();
        let trip = |(code, by): &(i32, i32)| monitor.check(&mut state, sign * code, sign * by);
        moves.iter().find_map(trip)
    };
    for sign in [1, -1] {
        assert_eq!(first(&[&pushed, &between, &braked], sign), None);
        // The braking alone goes eight counts against the effort. So it does after a push against
        // the effort, which is forgotten below the breakaway effort.
        assert_eq!(first(&[&braked], sign), Some(-8));
        assert_eq!(first(&[&[(4, -7)], &between, &braked], sign), Some(-8));
    }
}

#[test]
fn a_stall_wants_effort_of_one_sign_and_no_motion_both_for_its_time() {
    let limits = Limits { stall_effort: 8.0, stall_time: 3.0, ..Limits::OFF };
    let monitor = Stall::new(&limits, &UNITS);
    let trips = |ticks: &[(i32, u32)]| {
        let mut state = StallState::default();
        ticks.iter().map(|(code, still)| monitor.check(&mut state, *code, *still)).last().unwrap()
    };
    assert!(trips(&[(8, 9), (8, 9), (8, 9)]) && trips(&[(-8, 9), (-9, 9), (-8, 9)]));
    assert!(!trips(&[(8, 9), (8, 9)]) && !trips(&[(7, 9), (7, 9), (7, 9)]));
    assert!(!trips(&[(8, 9), (8, 9), (-8, 9)]) && !trips(&[(8, 0), (8, 1), (8, 2)]));
    assert!(!trips(&[(8, 9), (8, 9), (7, 9), (8, 9)]));
}

#[test]
fn an_impulse_grows_by_the_excess_and_only_counts_clear_it() {
    let limits =
        Limits { breakaway_effort: 16.0, stall_effort: 32.0, stall_impulse: 40.0, ..Limits::OFF };
    let monitor = StallImpulse::new(&limits, &UNITS);
    let trips_after = |code: i32, positions: &[i32]| {
        let (mut state, mut before) = (StallImpulseState::default(), 0);
        (1..100).find(|tick| {
            let position = positions[tick % positions.len()];
            let travel = position - core::mem::replace(&mut before, position);
            monitor.check(&mut state, code, position, travel)
        })
    };
    // An eighth of the breakaway at least: 40 in steps of 2, 10, 16 and 36.
    assert_eq!(trips_after(16, &[0]), None);
    assert_eq!(trips_after(17, &[0]), Some(21));
    assert_eq!([26, 32, -52].map(|code| trips_after(code, &[0])), [Some(5), Some(3), Some(2)]);
    // Four times the breakaway at most: 400 in steps of 60 and 64.
    let slower = StallImpulse::new(&Limits { stall_impulse: 400.0, ..limits }, &UNITS);
    let sums = |code: i32| {
        let mut state = StallImpulseState::default();
        (1..100).find(|_| slower.check(&mut state, code, 0, 0))
    };
    assert_eq!([76, 80, -9999].map(sums), [Some(7); 3]);
    assert_eq!([73, 9999].map(sums), [Some(8), Some(7)]);
    // One wire flickers by a count, two counts are a joint that moves.
    assert_eq!(trips_after(26, &[0, 1]), Some(5));
    assert_eq!(trips_after(26, &[0, 2]), None);
    // A joint that hunts counts with an effort whose sign has turned.
    let mut state = StallImpulseState::default();
    let hunts =
        |k: i32| (if k % 2 == 0 { 26 } else { -26 }, k % 2, if k % 2 == 0 { -1 } else { 1 });
    let mut against = StallImpulseState::default();
    let [mut lives, mut dead] = [true, false];
    for (code, position, travel) in (0..100).map(hunts) {
        lives &= !monitor.check(&mut state, code, position, travel);
        dead |= monitor.check(&mut against, code, 0, 0);
    }
    assert!(lives && dead);
    // With twice the breakaway it would leave the two counts: a pulse and its brake on a dead wire.
    let mut state = StallImpulseState::default();
    let pulses = |k: i32| ([32, -26][k as usize % 2], k % 2, [-1, 1][k as usize % 2]);
    let trips = (1..100).find(|k| {
        let (code, position, travel) = pulses(*k - 1);
        monitor.check(&mut state, code, position, travel)
    });
    // 16 and 10 by turns.
    assert_eq!(trips, Some(3));
}

#[test]
fn counts_that_stop_at_once_trip_and_those_that_friction_can_stop_do_not() {
    // 2.5 g T^2 is 5 counts per code: no count after more than 5 (8 - u) + 2 two ticks ago.
    let limits = Limits { stop_gain: 2.0, stall_effort: 8.0, ..Limits::OFF };
    let monitor = AbruptStop::new(&limits, &UNITS);
    let trips = |ticks: &[(i32, i32)]| {
        let both = [1, -1].map(|sign| {
            let mut state = AbruptStopState::default();
            let mut check =
                |(code, travel): &(i32, i32)| monitor.check(&mut state, sign * code, sign * travel);
            // It comes up to speed before.
            check(&(0, 9));
            ticks.iter().map(check).fold(false, |any, trip| any | trip)
        });
        assert_eq!(both[0], both[1]);
        both[0]
    };
    assert!(!trips(&[(0, 42), (0, 20), (0, 0)]) && trips(&[(0, 43), (0, 20), (0, 0)]));
    // A count is a flicker, two are a joint that moves.
    assert!(trips(&[(0, 43), (0, 20), (0, 1)]) && !trips(&[(0, 43), (0, 20), (0, 2)]));
    // Effort with the motion leaves less friction; effort against it, in any of the ticks, brakes.
    assert!(!trips(&[(4, 22), (4, 9), (4, 0)]) && trips(&[(4, 23), (4, 9), (4, 0)]));
    for braked in [[-4, 0, 0], [0, -4, 0], [0, 0, -4]] {
        let with = |first| [(braked[0], first), (braked[1], 20), (braked[2], 0)];
        assert!(!trips(&with(62)) && trips(&with(63)), "{braked:?}");
    }
}

#[test]
fn a_position_trips_beyond_either_end_of_its_range() {
    let limits = Limits { position_min: -10.0, position_max: 20.0, ..Limits::OFF };
    let monitor = PositionLimits::new(&limits, &UNITS);
    let found = [-11, -10, 20, 21].map(|position| monitor.check(position));
    assert_eq!(found, [true, false, false, true]);
    // The zero of the range is elsewhere; no range is none anywhere.
    let shifted = monitor.with_zero(-100);
    let found = [-111, -110, -80, -79].map(|position| shifted.check(position));
    assert_eq!((found, shifted.counted(-111)), ([true, false, false, true], -11));
    let none = PositionLimits::NONE.with_zero(i32::MAX);
    assert_eq!([i32::MIN, 0, i32::MAX].map(|position| none.check(position)), [false; 3]);
}

#[test]
fn a_supply_trips_at_the_third_reading_out_of_its_range() {
    let limits = Limits { supply_min: 10.0, supply_max: 20.0, ..Limits::OFF };
    let monitor = Supply::new(&limits, &UNITS);
    let last = |readings: &[u16]| {
        let mut state = SupplyState::default();
        readings.iter().map(|reading| monitor.check(&mut state, *reading)).last().flatten()
    };
    assert_eq!(last(&[9, 9]), None);
    assert_eq!(last(&[9, 9, 9]), Some(Fault::SupplyLow));
    assert_eq!(last(&[21, 21, 21]), Some(Fault::SupplyHigh));
    assert_eq!(last(&[9, 9, 10, 9]), None);
    assert_eq!(last(&[10, 20, 10]), None);
}

#[test]
fn heat_rises_and_falls_by_its_time_constant_and_forbids_arming() {
    // From cold, 10 V against 5 V: tau ln(1 / (1 - 1/4)) = 28.8 of a hundred ticks.
    let limits = Limits { continuous_effort: 5.0, thermal_time: 100.0, ..Limits::OFF };
    let monitor = Thermal::new(&limits, &UNITS);
    let mut state = ThermalState::default();
    let trips = (1..1000).find(|_| monitor.check(&mut state, 10, 0.0)).unwrap();
    assert!((28..=30).contains(&trips), "{trips}");
    assert!(monitor.is_hot(&state));
    // A joint that is shaken to and fro, at rest or not, heats as much.
    let mut shaken = ThermalState::default();
    let code = |k: i32| if k % 2 == 0 { 10 } else { -10 };
    assert_eq!((1..1000).find(|k| monitor.check(&mut shaken, code(*k), 99.0)), Some(trips));
    (0..10).for_each(|_| monitor.cool(&mut state));
    assert!(!monitor.is_hot(&state));
    assert!((1..10_000).all(|_| !monitor.check(&mut state, -5, 0.0)));
}

#[test]
fn effort_that_the_back_emf_takes_heats_nothing_and_braking_heats_with_both() {
    let limits =
        Limits { continuous_effort: 5.0, thermal_time: 100.0, back_emf: 2.0, ..Limits::OFF };
    let monitor = Thermal::new(&limits, &UNITS);
    let trips = |code: i32, velocity: f32| {
        let mut state = ThermalState::default();
        (1..10_000).find(|_| monitor.check(&mut state, code, velocity))
    };
    // 10 V at 3 deg/s are 4 V of current, and at -3 deg/s 16 V: ln(1 / (1 - (5 / 16)^2)) 100 s.
    assert_eq!([trips(10, 3.0), trips(-10, -3.0)], [None, None]);
    assert_eq!([trips(10, -3.0), trips(-10, 3.0)], [Some(11), Some(11)]);
    assert_eq!(ThermalState::of_effort(3.0).effort(), 3.0);
}

#[test]
fn silence_trips_after_its_time_only_if_it_is_watched_and_a_word_ends_it() {
    let limits = Limits { link_timeout: 3.0, ..Limits::OFF };
    let monitor = LinkTimeout::new(&limits, &UNITS);
    let mut state = LinkState::watch(true);
    assert_eq!([(); 4].map(|()| monitor.check(&mut state)), [None, None, None, Some(4)]);
    state.heard();
    assert_eq!([(); 3].map(|()| monitor.check(&mut state)), [None; 3]);
    let mut alone = LinkState::watch(false);
    assert!((0..100).all(|_| monitor.check(&mut alone).is_none()));
}

#[test]
fn wind_up_wants_effort_of_the_law_and_no_motion_both_for_its_time() {
    let limits = Limits { wind_up_effort: 4.0, wind_up_time: 3.0, ..Limits::OFF };
    let monitor = WindUp::new(&limits, &UNITS);
    let warns = |ticks: &[(f32, u32)]| {
        let mut state = 0;
        ticks.iter().map(|(v_c, still)| monitor.check(&mut state, *v_c, *still)).last().unwrap()
    };
    assert!(warns(&[(4.0, 9); 3]) && warns(&[(-4.0, 9); 3]));
    assert!(!warns(&[(4.0, 9); 2]) && !warns(&[(3.9, 9); 9]) && !warns(&[(4.0, 2); 9]));
}

#[test]
fn a_joint_is_at_rest_within_two_counts_for_its_time() {
    let mut standstill = Standstill::default();
    let ticks = [0, 1, 2, -2, 3, 3, 4, 5].map(|position| standstill.update(position));
    assert_eq!(ticks, [1, 2, 3, 4, 0, 1, 2, 3]);
}

#[test]
fn heat_and_impulse_outlast_arming_and_a_motor_that_is_off_cools() {
    let (controller, device) = (ControllerConfig::EXAMPLE, DeviceConfig::EXAMPLE);
    let limits = Limits { continuous_effort: 1.0, thermal_time: 1.0, ..Limits::OFF };
    let monitors = Monitors::new(&limits, &controller, &device, &HARDWARE);
    let tick = Tick { v_applied: 5.0, ..Tick::default() };
    let (mut state, seen) = (MonitorState::default(), Seen::default());
    let trips = (0..100).find_map(|_| monitors.check(&mut state, &seen, &tick, 0));
    assert_eq!(trips.map(|trip| trip.fault), Some(Fault::Overheat));
    let none = PositionLimits::NONE;
    let armed = monitors.armed(&state, false, none);
    assert_eq!(monitors.forbids_arming(&armed, none, &seen, 0), Some(Fault::Overheat));
    // So does a motor that was as warm before a reset.
    let warm = |effort| monitors.forbids_arming(&monitors.warm(effort), none, &seen, 0);
    assert_eq!([0.99, 1.01].map(warm), [None, Some(Fault::Overheat)]);
    (0..500).for_each(|_| monitors.idle(&mut state, &seen));
    assert_eq!(monitors.forbids_arming(&state, none, &seen, 0), None);
    // 50 ms of 20 ms are three ticks.
    let at_rest = [2, 3].map(|standstill| monitors.is_at_rest(&Seen { standstill, ..seen }));
    assert_eq!(at_rest, [false, true]);
}

/// A count is 1 deg. A gear that is wound up by 20 deg throws its motor back by 4 counts a tick
/// and unwinds. Only the path is judged: beyond 32 counts, or beyond 32 and twice the first twist.
#[cfg(feature = "two-encoders")]
#[test]
fn motor_that_its_wound_up_gear_throws_back_is_no_stall() {
    let limits = Limits { stall_effort: 4.0, progress_gain: 0.1, ..Limits::OFF };
    let trips = |wound_up: f32| {
        let monitor = Progress::new(&limits, &UNITS);
        let mut state = ProgressState::default();
        let twist = |tick: i32| wound_up * (1.0 - 0.1 * tick as f32).max(0.0);
        (1..100).find(|tick| monitor.check(&mut state, 14, -4, 0.0, twist(tick - 1)))
    };
    let [relaxed, wound_up] = [0.0, -20.0].map(|twist| trips(twist).unwrap());
    // 40 counts are ten ticks of 4.
    assert_eq!(wound_up - relaxed, 10);
}

/// The friction is 4 V and the weakest joint makes a deg/s for a volt beyond it: its time constant
/// is within a tick of 1 s.
#[test]
fn too_little_travel_and_travel_to_and_fro_trip_and_braking_does_not() {
    let limits = Limits { stall_effort: 4.0, progress_gain: 1.0, ..Limits::OFF };
    let trips_with = |limits: &Limits, code: i32, velocity: f32, travel: fn(i32) -> i32| {
        let monitor = Progress::new(limits, &UNITS);
        let mut state = ProgressState::default();
        let sign = code.signum();
        (1..1000).find(|k| {
            let (travel, velocity) = (sign * travel(*k), sign as f32 * velocity);
            monitor.check(&mut state, code, travel, velocity, 0.0)
        })
    };
    let trips = |code: i32, velocity: f32, travel: fn(i32) -> i32| {
        let [up, down] = [code, -code].map(|code| trips_with(&limits, code, velocity, travel));
        assert_eq!(up, down);
        up
    };
    // 14 V: ten counts a tick are due, so the first 64 of them after seven ticks.
    assert_eq!(trips(14, 0.0, |_| 3), None);
    assert_eq!(trips(14, 0.0, |_| 2), Some(7));
    // It may still move against a new effort: a tick is for braking, and four make 32 counts.
    assert_eq!(trips(14, 0.0, |_| -9), Some(5));
    // Within the friction nothing is due.
    assert_eq!(trips(4, 0.0, |_| 0), None);
    // 5 V: one count a tick is due. Seven of 11 counts go with the effort, or two of 16.
    assert_eq!(trips(5, 0.0, |k| if k % 2 == 1 { 9 } else { -2 }), None);
    assert_eq!(trips(5, 0.0, |k| if k % 2 == 1 { 9 } else { -7 }), Some(5));
    // A joint at -40 deg/s has three ticks of 20 V to brake, half as many again as it needs.
    let braked = |k| if k < 3 { -60 + 20 * k } else { 20 };
    assert_eq!(trips(20, -40.0, braked), None);
    assert_eq!(trips(20, -40.0, |_| -40), Some(4));
    for off in [Limits { stall_effort: 0.0, ..limits }, Limits { progress_gain: 0.0, ..limits }] {
        assert_eq!(trips_with(&off, 14, 0.0, |_| -9), None);
    }
}

/// The breakaway is 4 V, and a period of 5 s has a hundred ticks.
#[test]
fn more_than_the_breakaway_on_average_trips_after_a_period_without_net_travel() {
    let limits = Limits { stall_effort: 8.0, breakaway_effort: 4.0, ..Limits::OFF };
    let units = Units { tick: 0.05, ..UNITS };
    let trips_with = |limits: &Limits, code: fn(i32) -> i32, position: fn(i32) -> i32| {
        let monitor = NetTravel::new(limits, &units);
        let [up, down] = [1, -1].map(|sign| {
            let from = 1_000_000;
            let mut state = NetTravelState::at(from);
            (1..150)
                .find(|k| monitor.check(&mut state, sign * code(*k), from + sign * position(*k)))
        });
        assert_eq!(up, down);
        up
    };
    let trips = |code, position| trips_with(&limits, code, position);
    let to_and_fro = |k: i32| [0, 16, -7, 40][k as usize % 4];
    assert_eq!(trips(|_| 5, to_and_fro), Some(100));
    assert_eq!(trips(|_| 4, to_and_fro), None);
    // Only the mean counts.
    assert_eq!(trips(|k| if k % 2 == 0 { 20 } else { -11 }, to_and_fro), Some(100));
    assert_eq!(trips(|k| if k % 2 == 0 { 20 } else { -12 }, to_and_fro), None);
    // Eight counts in a period are four between the means of its halves.
    assert_eq!(trips(|_| 5, |k| k / 12), None);
    assert_eq!(trips(|_| 5, |k| k / 13), Some(100));
    // A joint that is braked goes against its effort.
    assert_eq!(trips(|_| 5, |k| -60 * (k / 51)), Some(100));
    assert_eq!(trips(|_| 5, |k| -65 * (k / 51)), None);
    for off in [Limits { stall_effort: 0.0, ..limits }, Limits { breakaway_effort: 0.0, ..limits }]
    {
        assert_eq!(trips_with(&off, |_| 5, to_and_fro), None);
    }
}

/// A joint of 1 deg/s^2 for a volt and 4 V of friction: 14 V add 10 counts per tick in each tick.
#[test]
fn an_effort_crosses_the_play_before_it_counts_and_the_other_way_it_crosses_all_of_it() {
    let limits = Limits { play: 45.0, progress_gain: 0.25, breakaway_effort: 4.0, ..Limits::OFF };
    let play = Play::new(&limits, &UNITS).unwrap();
    let crosses = |state: &mut PlayState, code: i32, position: i32| {
        (1..100).find(|_| play.is_taken_up(state, code, position))
    };
    for sign in [1, -1] {
        let mut state = PlayState::default();
        // 10 + 20 + 30 counts exceed 45, and 10 + ... + 40 those from end to end.
        assert_eq!(crosses(&mut state, 14 * sign, 0), Some(3));
        assert_eq!(crosses(&mut state, 14 * sign, 0), Some(1));
        assert_eq!(crosses(&mut state, -14 * sign, 0), Some(4));
        // The friction holds it, and two counts begin anew.
        assert_eq!(crosses(&mut PlayState::default(), 4 * sign, 0), None);
        assert_eq!(crosses(&mut state, -14 * sign, 1), Some(1));
        assert_eq!(crosses(&mut state, -14 * sign, 2), Some(3));
    }
    for off in [Limits { play: 0.0, ..limits }, Limits { progress_gain: 0.0, ..limits }] {
        assert!(Play::new(&off, &UNITS).is_none());
    }
}

#[test]
fn effort_is_a_stall_only_when_the_play_is_taken_up_and_abrupt_stops_are_none_with_play() {
    let (controller, device) = (ControllerConfig::EXAMPLE, DeviceConfig::EXAMPLE);
    let derived = Limits::derived(&controller, &device, 0.4);
    let ticks = |play: f32| {
        let limits = Limits { play, progress_gain: 27.0 / 4.0, ..derived };
        let monitors = Monitors::new(&limits, &controller, &device, &HARDWARE);
        let mut state = MonitorState::default();
        let tick = Tick { v_applied: 1.0, ..Tick::default() };
        let trips = (1..1000u32).find(|&standstill| {
            let seen = Seen { standstill, ..Seen::default() };
            let trip = monitors.check(&mut state, &seen, &tick, 0);
            assert!(trip.is_none_or(|trip| trip.fault == Fault::Stall), "{trip:?}");
            trip.is_some()
        });
        trips.unwrap()
    };
    // 0.2 s; then sqrt(2 p / (27 (1 - 0.4))) s of crossing more, and a tick for each rounding.
    assert_eq!(ticks(0.0), 10);
    let crossing = (2.0f32 / (27.0 * 0.6)).sqrt() / 0.02;
    let found = ticks(1.0) as f32;
    assert!((found - 10.0 - crossing).abs() < 2.0, "{found} ticks, {crossing} of them to cross");
}
