//! The profile of a move against its limits and its closed form, and the bounded acceleration of a
//! law against the same equation in `f64`.
//!
//! Positions, velocities and accelerations are taken from the set points, and the differences of
//! the positions are held against the limits as well: what a set point says of its velocity is what
//! its position does.

use proptest::prelude::*;
use stiction::control::pd::PdGains;
use stiction::control::profile::{BoundedAcceleration, LimitedReference, Profile, ProfileLimits};
use stiction::control::reference::Setpoint;
use stiction::parameters::DeviceConfig;
use stiction::parameters::names::NamedError;
use stiction::units::position::Position;
use stiction::units::value::Table;
use stiction::{ControllerConfig, Limits};

use super::{HALF_ULP, config};

/// What the limits may be exceeded by: they are computed in a handful of operations.
const ROUNDING: f64 = 1.0 + 8.0 * HALF_ULP;
/// What the jerk may be exceeded by: a length of the averages that is a power of two but for 1e-5
/// is taken as that power, since 0.02 s and 0.16 s are no binary numbers.
const ROUNDED_LENGTH: f64 = 1.0 + 1.1e-5;

/// The loop that a profile is made for, with limits that it can keep.
#[derive(Clone, Copy, Debug)]
struct Made {
    limits: ProfileLimits,
    sample_time: f32,
    resolution: f32,
}

impl Made {
    fn profile(&self, target: i32) -> Profile {
        self.to(Position::from_counts(target))
    }

    fn to(&self, target: Position) -> Profile {
        let Self { limits, sample_time, resolution } = self;
        match Profile::new(target, limits, *sample_time, *resolution) {
            Ok(profile) => profile,
            Err(error) => unreachable!("{error}"),
        }
    }

    /// Velocity, acceleration and jerk in counts and ticks.
    fn per_tick(&self) -> [f64; 3] {
        let (h, count) = (f64::from(self.sample_time), f64::from(self.resolution));
        let ProfileLimits { velocity, acceleration, jerk } = self.limits;
        [
            f64::from(velocity) / count * h,
            f64::from(acceleration) / count * h * h,
            f64::from(jerk) / count * h * h * h,
        ]
    }

    /// Length of the average, ticks: the first power of two that holds the jerk.
    fn span(&self) -> f64 {
        let [_, a, j] = self.per_tick();
        let span = 2.0 * a / j;
        (1..=8).map(|n| f64::from(1 << n)).find(|power| *power >= span * 0.9999).unwrap_or(256.0)
    }

    /// Ticks of the first stage's step.
    fn step(&self) -> f64 {
        (self.span() / 64.0).max(2.0)
    }

    /// Time of the trapezoid (or the triangle) over a number of counts, and of the averages, ticks.
    fn ticks(&self, counts: f64) -> f64 {
        let [v, a, _] = self.per_tick();
        // Whole units: a fifth of the limits at the most is not used.
        let used = if counts * a > v * v { counts / v + v / a } else { 2.0 * (counts / a).sqrt() };
        used + self.span()
    }
}

/// Random loops from 0.1 ms to 20 ms, with limits as they are derived of random gains.
fn made() -> impl Strategy<Value = Made> {
    let time = (-4.0f32..-1.7).prop_map(|exponent| 10f32.powf(exponent).min(0.02));
    let count = (-4.0f32..-0.5).prop_map(|exponent| 10f32.powf(exponent));
    let velocity = (0.0f32..2.0).prop_map(|exponent| 10f32.powf(exponent));
    // Times to reach the velocity and the acceleration, s.
    (time, count, velocity, 0.05f32..3.0, 0.001f32..0.1).prop_filter_map(
        "limits that the loop cannot keep",
        |(sample_time, resolution, velocity, reach, turn)| {
            let acceleration = velocity / reach;
            let limits = ProfileLimits { velocity, acceleration, jerk: 2.0 * acceleration / turn };
            let made = Made { limits, sample_time, resolution };
            let fits = Profile::new(Position::default(), &limits, sample_time, resolution).is_ok();
            fits.then_some(made)
        },
    )
}

proptest! {
    #![proptest_config(config())]

    /// A begin may be faster than the limit, as that of a trajectory is.
    #[test]
    fn no_set_point_is_beyond_all_targets_and_the_place_where_the_begin_comes_to_rest(
        made in made(),
        share in -3.0f32..3.0,
        targets in prop::collection::vec((-20_000i32..20_000, 1usize..400), 1..6),
    ) {
        let mut profile = made.profile(targets[0].0);
        let velocity = share * made.limits.velocity;
        profile.start_at(Position::default(), velocity);
        let stops_at = profile.stops_at();
        // v^2 / 2a; the averages reach it half of their length later, and a step is as long as k.
        let [_, a, _] = made.per_tick();
        let v = f64::from(velocity / made.resolution * made.sample_time);
        let way = v * v.abs() / (2.0 * a) + 0.5 * made.span() * v;
        // D and V are floored by a fifth at the most; a step more or less, and a whole count.
        let (less, more) = (way.abs() * 0.99, way.abs() * 1.26);
        let off = 2.0 * made.step() * v.abs() + 2.0;
        let found = f64::from(stops_at) * v.signum();
        // A begin beyond the limit is taken as far as the sums have room.
        let is_enough = share.abs() > 1.0 || found >= less - off;
        prop_assert!(is_enough && found <= more + off, "{found}, not {way} {off}");
        let mut stopped = profile.clone();
        stopped.stop();
        prop_assert_eq!(stopped.target(), Position::from_counts(stops_at));
        let (mut lowest, mut highest) = (stops_at.min(0), stops_at.max(0));
        for (target, ticks) in targets {
            profile.aim(Position::from_counts(target));
            (lowest, highest) = (lowest.min(target), highest.max(target));
            for _ in 0..ticks {
                let now = profile.update().position;
                prop_assert!(
                    now.counts >= lowest && (now.counts, now.fraction) <= (highest, 0.0),
                    "{now:?} is not within {lowest} to {highest}"
                );
                let stops_at = profile.stops_at();
                prop_assert!(stops_at >= lowest && stops_at <= highest, "{stops_at}");
            }
        }
    }
}

/// Runs targets (shares of the farthest) and stops, each for its number of ticks, and then to rest.
fn obeys(made: Made, orders: &[(u32, f64, bool)]) -> Result<(), TestCaseError> {
    let mut profile = made.profile(0);
    let mut judge = Judge::new(made, at(0));
    let mut last = 0;
    for &(ticks, share, is_stop) in orders {
        if is_stop {
            profile.stop();
        } else {
            profile.aim(Position::from_counts((share * share * share * farthest(made)) as i32));
        }
        last = profile.target().counts;
        for _ in 0..ticks {
            judge.see(profile.update())?;
        }
    }
    to_rest(&mut profile, &mut judge)?;
    prop_assert_eq!(profile.update(), at(last));
    Ok(())
}

/// The first stage is back at zero, and the set point turns: velocity and acceleration are zero in
/// the same tick, 6e-5 counts before it arrives.
#[test]
fn a_set_point_that_turns_still_moves() {
    let limits = ProfileLimits { velocity: 1.0, acceleration: 20.0, jerk: 989.0507 };
    let made = Made { limits, sample_time: 0.000_339_551_74, resolution: 0.004_728_544 };
    let orders = [(1, -0.136_460_739_680_476_26, false), (1, 0.0, false)];
    assert!(obeys(made, &orders).is_ok());
}

/// Holds every set point against the limits and the one before.
struct Judge {
    made: Made,
    before: Setpoint,
    /// Velocity and acceleration by differences, counts per tick.
    velocity: f64,
    acceleration: f64,
}

impl Judge {
    fn new(made: Made, begin: Setpoint) -> Self {
        Self { made, before: begin, velocity: 0.0, acceleration: 0.0 }
    }

    fn see(&mut self, now: Setpoint) -> Result<(), TestCaseError> {
        let [v, a, j] = self.made.per_tick();
        let (position, before) = (now.position, self.before.position);
        // Of a position and of a difference of two: a fraction has 24 bits.
        let seen = 2.0 / 16_777_216.0;
        let travel = f64::from(position.counts.wrapping_sub(before.counts))
            + (f64::from(position.fraction) - f64::from(before.fraction));
        let (change, turn) = (travel - self.velocity, travel - self.velocity - self.acceleration);
        prop_assert!((0.0..1.0).contains(&position.fraction), "{position:?}");
        prop_assert!(travel.abs() <= v * ROUNDING + seen, "velocity {travel} of {v}");
        prop_assert!(change.abs() <= a * ROUNDING + 2.0 * seen, "acceleration {change} of {a}");
        prop_assert!(turn.abs() <= j * ROUNDED_LENGTH + 4.0 * seen, "jerk {turn} of {j}");
        let (h, count) = (f64::from(self.made.sample_time), f64::from(self.made.resolution));
        let reported = f64::from(now.velocity) / count * h;
        prop_assert!(
            (reported - travel).abs() <= 2.0 * seen + 1e-6 * v,
            "{reported}, not {travel}"
        );
        let reported = f64::from(now.acceleration) / count * h * h;
        prop_assert!(
            (reported - change).abs() <= 4.0 * seen + 1e-6 * a,
            "{reported}, not {change}"
        );
        prop_assert!(reported.abs() <= a * ROUNDING, "acceleration {reported} of {a}");
        (self.before, self.velocity, self.acceleration) = (now, travel, change);
        Ok(())
    }
}

fn at(counts: i32) -> Setpoint {
    Setpoint::at_rest(Position::from_counts(counts))
}

/// Ticks within which a move of any length that is tried has ended.
const LONG: u32 = 4_000_000;

/// Runs a move to its rest; the ticks that it took.
fn to_rest(profile: &mut Profile, judge: &mut Judge) -> Result<u32, TestCaseError> {
    for tick in 1..LONG {
        judge.see(profile.update())?;
        if !profile.is_moving() {
            return Ok(tick);
        }
    }
    Err(TestCaseError::fail("it never rests"))
}

/// Most counts that a move of this loop makes within a hundred thousand ticks.
fn farthest(made: Made) -> f64 {
    let [v, a, _] = made.per_tick();
    (2e4 * v).min(2.5e9 * a).clamp(4.0, 5e8)
}

proptest! {
    #![proptest_config(config())]

    #[test]
    fn a_move_from_rest_keeps_its_limits_lands_never_overshoots_and_takes_the_closed_form(
        made in made(), share in -1.0f64..1.0,
    ) {
        let target = (share * share * share * farthest(made)) as i32;
        let mut profile = made.profile(target);
        let mut judge = Judge::new(made, at(0));
        let mut ticks = 0;
        for tick in 1..LONG {
            let now = profile.update();
            judge.see(now)?;
            let left = f64::from(target.wrapping_sub(now.position.counts))
                - f64::from(now.position.fraction);
            prop_assert!(left * f64::from(target.signum()) >= 0.0, "{left} beyond {target}");
            ticks = tick;
            if !profile.is_moving() {
                break;
            }
        }
        for _ in 0..100 {
            prop_assert_eq!(profile.update(), at(target));
        }
        // A step's end, begin, landing and average are a step of the first stage each; and whole
        // units are a fifth below the limits at the worst.
        let most = made.ticks(f64::from(target).abs()) * 5.0 / 4.0 + 5.0 * made.step() + 2.0;
        prop_assert!(f64::from(ticks) <= most, "{ticks} ticks, more than {most}");
    }

    #[test]
    fn a_move_is_the_same_in_both_directions(made in made(), share in 0.0f64..1.0) {
        let target = (share * share * share * farthest(made)) as i32;
        let [mut there, mut back] = [target, -target].map(|target| made.profile(target));
        for _ in 0..2000 {
            let (one, other) = (there.update(), back.update());
            let sum = f64::from(one.position.counts.wrapping_add(other.position.counts))
                + f64::from(one.position.fraction) + f64::from(other.position.fraction);
            // Each fraction is cut off, not rounded.
            prop_assert!(sum.abs() <= 2.0 / 16_777_216.0, "{one:?} {other:?}");
            prop_assert!((one.velocity + other.velocity).abs() <= 1e-6 * made.limits.velocity);
        }
    }

    /// Targets anywhere, at any tick, and stops between them.
    #[test]
    fn other_targets_and_stops_in_motion_keep_the_limits_and_the_last_one_is_reached(
        made in made(),
        orders in proptest::collection::vec((1u32..400, -1.0f64..1.0, any::<bool>()), 1..12),
    ) {
        obeys(made, &orders)?;
    }

    /// A stop takes v/a and the averages, and ends on a count within the closed form's way.
    #[test]
    fn a_stop_ends_within_its_braking_time(made in made(), ticks in 1u32..3000) {
        let mut profile = made.profile(i32::MAX / 4);
        let mut judge = Judge::new(made, at(0));
        for _ in 0..ticks {
            judge.see(profile.update())?;
        }
        profile.stop();
        let took = to_rest(&mut profile, &mut judge)?;
        let [v, a, _] = made.per_tick();
        let most = v / a * 5.0 / 4.0 + made.span() + 5.0 * made.step() + 2.0
            // The last count may be a whole one away, at the speed of a landing.
            + 2.0 * (1.0 / a).sqrt();
        prop_assert!(f64::from(took) <= most, "{took} ticks, more than {most}");
        let at = profile.update().position;
        prop_assert!(at.fraction == 0.0 && at.counts >= 0, "{at:?}");
    }

    /// A profile that begins in motion goes on from there, and slows down if it is too fast.
    #[test]
    fn it_begins_where_the_set_point_is_and_as_fast_as_it_is(
        made in made(), share in -1.0f32..1.0, fraction in 0.0f32..1.0, counts in any::<i32>(),
    ) {
        let [v, ..] = made.per_tick();
        let speed = share * made.limits.velocity;
        let begin = Position { counts, fraction: fraction.min(0.999_999) };
        let mut profile = made.profile(counts);
        profile.start_at(begin, speed);
        // The begin is rounded to the grid, once: no finer than 2^-8 counts, and to 2^-22 of v.
        let first = profile.update();
        let travel = f64::from(first.position.counts.wrapping_sub(begin.counts))
            + f64::from(first.position.fraction) - f64::from(begin.fraction);
        let [_, a, j] = made.per_tick();
        let off = (travel - f64::from(share) * v).abs();
        let most = (j * ROUNDED_LENGTH).min(a * ROUNDING);
        prop_assert!(off <= most + 1.0 / 128.0 + v / 1e5, "{off}");
        // From here on by differences: what a set point says of its velocity is rounded.
        let travel = |from: Setpoint, to: Setpoint| {
            f64::from(to.position.counts.wrapping_sub(from.position.counts))
                + (f64::from(to.position.fraction) - f64::from(from.position.fraction))
        };
        let (second, third) = (profile.update(), profile.update());
        let mut judge = Judge::new(made, third);
        judge.velocity = travel(second, third);
        judge.acceleration = judge.velocity - travel(first, second);
        to_rest(&mut profile, &mut judge)?;
        prop_assert_eq!(profile.update(), at(counts));
    }

    /// `f32` against `f64`, from the equation as it is printed.
    #[test]
    fn bounded_acceleration_is_its_equation(
        velocity in 0.5f32..50.0, reach in 0.1f32..2.0, h in 1e-3f32..2e-2,
        begin in -20.0f32..20.0, speed in -5.0f32..5.0,
    ) {
        let acceleration = velocity / reach;
        let limits = BoundedAcceleration::new(velocity, acceleration, h);
        let mut state = LimitedReference { position: begin, ..LimitedReference::default() };
        for tick in 0..500 {
            // It stands, and moves.
            let (reference, of) = if tick < 250 { (3.0, 0.0) } else {
                (3.0 + speed * h * (tick - 250) as f32, speed)
            };
            let before = state;
            limits.update(&mut state, reference, of);
            let (p, dp, ddp, is_edge) = second(&before, reference, of, velocity, acceleration, h);
            if is_edge {
                continue;
            }
            // The distance is a difference of numbers up to 25 + 3 + 5 * 5: 2^-18 each, and the
            // root's slope is a/(D/2).
            let (far, fast) = (64.0 * HALF_ULP * 8.0, 64.0 * HALF_ULP * 8.0 * 2.0 / f64::from(h));
            prop_assert!((f64::from(state.position) - p).abs() <= far + f64::from(h) * fast);
            prop_assert!((f64::from(state.velocity) - dp).abs() <= fast);
            prop_assert!((f64::from(state.acceleration) - ddp).abs() <= 2.0 * fast / f64::from(h));
        }
    }
}

/// One tick of the equation, and whether it is so near the edge of landing that rounding decides.
fn second(
    before: &LimitedReference,
    r: f32,
    dr: f32,
    v: f32,
    a: f32,
    h: f32,
) -> (f64, f64, f64, bool) {
    let [p, dp, r, dr, v, a, h] = [before.position, before.velocity, r, dr, v, a, h].map(f64::from);
    let (d, step) = (r - p - h * dr, a * h);
    let (near, slow) = (d.abs() / (1.01 * step * h), (dp - dr).abs() / (1.01 * step));
    let is_edge = (near - 1.0).abs() < 1e-2 || (slow - 1.0).abs() < 1e-3;
    if near <= 1.0 && slow <= 1.0 {
        return (r, dr, if dr == 0.0 { 0.0 } else { (dr - dp) / h }, is_edge);
    }
    let t = d.signum() * ((2.0 * a * d.abs() + step * step / 4.0).sqrt() - step / 2.0) + dr;
    let change = (t.clamp(-v, v) - dp).clamp(-step, step);
    (p + h * (dp + change), dp + change, change / h, is_edge)
}

/// The units are at their best where rounding would show first: slow, and a thousand turns away.
#[test]
fn it_lands_a_thousand_turns_away_at_any_sample_time() {
    for sample_time in [1e-4, 1e-3, 0.02] {
        let limits = ProfileLimits { velocity: 1e3, acceleration: 4e3, jerk: 5e5 };
        let made = Made { limits, sample_time, resolution: 0.0036 };
        // 1000 turns of 100 000 counts.
        let mut profile = made.profile(-100_000_000);
        let ticks = (1..LONG).find(|_| {
            profile.update();
            !profile.is_moving()
        });
        assert_eq!(profile.update(), at(-100_000_000));
        // 360 s at 1000 deg/s, and 0.25 s to reach it; a fraction of a unit in a speed of 2^20 and
        // more is not used. The average takes 0.08 s, and up to twice that.
        let expected = 360.25 / sample_time;
        let off = ticks.unwrap() as f32 - expected;
        assert!((0.0..0.6 / sample_time).contains(&off), "{off} ticks of {expected}");
    }
}

fn derived(kp: f32, kd: f32, duty_max: f32, sample_time: f32, resolution: f32) -> Made {
    let mut controller = ControllerConfig { sample_time, ..ControllerConfig::EXAMPLE };
    controller.pd = PdGains { kp, kd };
    controller.drive.duty_max = duty_max;
    controller.encoder.resolution = resolution;
    let limits = Limits::derived(&controller, &DeviceConfig::CAUTIOUS, 0.0);
    let limits = ProfileLimits::derived(&controller, limits.overspeed, 0.0);
    Made { limits, sample_time, resolution }
}

/// The sentences of the three values, in numbers.
#[test]
fn derived_limits_follow_from_the_loop() {
    // 5 V and Kp 1 V/deg: K = 0.64 / 0.15^2 = 28.4 deg/s^2 per V, and 2.5 * 5 / 0.15 deg/s.
    for duty_max in [1.0, 0.5] {
        let ProfileLimits { velocity, acceleration, jerk } =
            derived(1.0, 0.15, duty_max, 0.02, 0.00242).limits;
        let near = |found: f32, expected: f32| (found / expected - 1.0).abs() < 1e-5;
        assert!(near(velocity, duty_max * 41.666_67), "{velocity}");
        assert!(near(acceleration, duty_max * 35.555_56), "{acceleration}");
        // Within 0.075 s from nothing, and from one sign to the other.
        assert!(near(jerk, 2.0 * acceleration / 0.075), "{jerk}");
    }
    // Of no Kp, no Kd, or a Kd that looks ahead by less than a tick, nothing follows.
    for (kp, kd) in [(0.0, 0.15), (1.0, 0.0), (0.0, 0.0), (1.0, 0.019)] {
        let limits = derived(kp, kd, 1.0, 0.02, 0.00242).limits;
        assert_eq!(limits, ProfileLimits { velocity: 10.0, acceleration: 10.0, jerk: 200.0 });
    }
}

proptest! {
    #![proptest_config(config())]

    /// Whatever a loop is, a move has limits that the generator keeps.
    #[test]
    fn derived_limits_can_be_kept_in_any_loop(
        kp in 0.0f32..1e3, kd in 0.0f32..1e2, duty_max in 1e-3f32..1.0,
        time in -4.0f32..-1.7, count in -6.0f32..4.0,
    ) {
        for (kp, kd) in [(kp, kd), (0.0, kd), (kp, 0.0), (1e-6 * kp, kd), (kp, 1e-6 * kd)] {
            let made = derived(kp, kd, duty_max, 10f32.powf(time).min(0.02), 10f32.powf(count));
            let ProfileLimits { velocity, acceleration, jerk } = made.limits;
            prop_assert!(velocity > 0.0 && acceleration > 0.0 && jerk > 0.0, "{made:?}");
            let profile = Profile::new(
                Position::from_counts(1000), &made.limits, made.sample_time, made.resolution,
            );
            prop_assert!(profile.is_ok(), "{made:?}: {:?}", profile.err());
        }
    }
}

#[test]
fn limits_that_cannot_be_kept_are_refused_with_what_is_allowed() {
    let refused = |velocity, acceleration, jerk| {
        let limits = ProfileLimits { velocity, acceleration, jerk };
        let made = Profile::new(Position::default(), &limits, 0.02, 0.00242);
        made.map(|_| ()).map_err(|error| NamedError(error).to_string())
    };
    assert_eq!(refused(25.0, 35.0, 1000.0), Ok(()));
    for (limits, key, found, least) in [
        ((1e5, 35.0, 1000.0), "velocity_deg_per_s", "100000", ""),
        ((25.0, 1e7, 1e9), "acceleration_deg_per_s2", "10000000", ""),
        ((25.0, 1e-5, 1000.0), "acceleration_deg_per_s2", "0.00001", ""),
        ((25.0, 35.0, 0.1), "jerk_deg_per_s3", "0.1", "13.6"),
    ] {
        let (velocity, acceleration, jerk) = limits;
        let message = refused(velocity, acceleration, jerk).unwrap_err();
        let expected = format!("`profile.{key}` is {found}; must be a number from {least}");
        assert!(message.starts_with(&expected), "{message}");
    }
    for bad in [f32::NAN, f32::INFINITY] {
        assert!(refused(bad, 35.0, 1000.0).is_err() && refused(25.0, bad, 1000.0).is_err());
        assert!(refused(25.0, 35.0, f32::NAN).is_err());
    }
}
