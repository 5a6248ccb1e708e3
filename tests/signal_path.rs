//! The parts that every law stands on: measured velocity, trajectories and the drive's two maps, each against a
//! second way of computing it, in `f64` or in integers.
//!
//! Runs on the host only, and is blind to the motion itself: positions come from a list, so nothing here says how
//! well a velocity measured so serves a loop or whether a joint can follow a trajectory; nor does it say what a
//! timer makes of a compare value, or that a microcontroller computes the same bits.

use std::iter::repeat_n;

use proptest::collection::vec;
use proptest::prelude::*;
use stiction::drive::{Drive, DriveConfig, Duty, PwmMode};
use stiction::position::Position;
use stiction::reference::{Corner, Reference, Setpoint, Step, Trajectory};
use stiction::velocity::{MAX_WINDOW, Velocity, VelocityState};
use stiction::{Error, Hardware};

/// The figures of the board.
const STM32F405: Hardware = Hardware { pwm_clock_hz: 168e6, supply_top: 4095 };

/// Joint angle of one count, deg.
const RESOLUTION: f32 = 0.00242;
/// Time between samples, s.
const SAMPLE_TIME: f32 = 0.02;
/// Beyond this many counts per tick an increment is clamped.
const MAX_INCREMENT: i32 = 1 << 21;
/// Half a unit in the last place of an `f32`, relative to it.
const HALF_ULP: f64 = 1.0 / 16_777_216.0;

fn config() -> ProptestConfig {
    ProptestConfig { failure_persistence: None, ..ProptestConfig::default() }
}

/// Slope of the regression line through equally spaced samples, by the textbook's two sums.
fn slope(samples: &[f64]) -> f64 {
    let n = samples.len() as f64;
    let mean_k = (n - 1.0) / 2.0;
    let mean_x = samples.iter().sum::<f64>() / n;
    let centred = || samples.iter().enumerate().map(|(k, x)| (k as f64 - mean_k, x - mean_x));
    let covariance: f64 = centred().map(|(k, x)| k * x).sum();
    let variance: f64 = centred().map(|(k, _)| k * k).sum();
    covariance / variance
}

proptest! {
    #![proptest_config(config())]

    #[test]
    fn velocity_is_the_slope_of_the_regression_line(
        window in 2..=MAX_WINDOW,
        resolution in 1e-4f32..1.0,
        sample_time in 1e-4f32..0.1,
        increments in vec(prop_oneof![Just(0), -3..=3, -3000..=3000, -MAX_INCREMENT..=MAX_INCREMENT], 1..40),
    ) {
        let velocity = Velocity::new(window as u32, resolution, sample_time);
        let mut state = VelocityState::default();
        let mut positions = vec![0.0; window];
        for increment in increments {
            positions.push(positions[positions.len() - 1] + f64::from(increment));
            let measured = f64::from(velocity.update(&mut state, increment));
            let slope = slope(&positions[positions.len() - window..]);
            let expected = slope * f64::from(resolution) / f64::from(sample_time);
            // Seven roundings at most, and what cancels in the regression itself.
            let tolerance = 7.0 * HALF_ULP * expected.abs() + 1e-6 * f64::from(resolution / sample_time);
            prop_assert!((measured - expected).abs() <= tolerance, "{measured}, not {expected}");
        }
    }
}

#[test]
fn velocity_forgets_a_movement_with_the_window_and_not_before() {
    for window in 2..=MAX_WINDOW {
        let velocity = Velocity::new(window as u32, RESOLUTION, SAMPLE_TIME);
        let mut state = VelocityState::default();
        velocity.update(&mut state, 1);
        for _ in 2..window {
            assert!(velocity.update(&mut state, 0) > 0.0, "{window}");
        }
        assert_eq!(velocity.update(&mut state, 0), 0.0, "{window}");
    }
}

#[test]
fn velocity_is_clamped_before_it_could_overflow() {
    for window in 2..=MAX_WINDOW {
        let velocity = Velocity::new(window as u32, RESOLUTION, SAMPLE_TIME);
        let steady = |increment: i32| {
            let mut state = VelocityState::default();
            repeat_n(increment, window)
                .map(|increment| velocity.update(&mut state, increment))
                .last()
                .unwrap()
        };
        let bound = f64::from(MAX_INCREMENT) * f64::from(RESOLUTION) / f64::from(SAMPLE_TIME);
        assert!((f64::from(steady(i32::MAX)) / bound - 1.0).abs() < 1e-6, "{window}: {}", steady(i32::MAX));
        assert_eq!(steady(i32::MIN), -steady(i32::MAX), "{window}");
        assert_eq!(steady(MAX_INCREMENT + 1), steady(MAX_INCREMENT), "{window}");
        assert_eq!(steady(-MAX_INCREMENT - 1), steady(-MAX_INCREMENT), "{window}");
        // Sixteen counts are more than a float of that size rounds away.
        assert!(steady(MAX_INCREMENT - 16) < steady(MAX_INCREMENT), "{window}");
    }
}

/// A trajectory in `f64`, counts and ticks: every corner adds a change of rate, spread evenly over its blend.
struct Profile {
    start: f64,
    changes: Vec<(f64, f64)>,
    half_blend: f64,
}

impl Profile {
    /// Positions are taken relative to the counts of `origin`.
    fn new(corners: &[Corner], half_blend: f64, origin: i32) -> Self {
        let place = |corner: &Corner| {
            f64::from(corner.position.counts.wrapping_sub(origin)) + f64::from(corner.position.fraction)
        };
        let mut rate = 0.0;
        let mut changes = Vec::new();
        for (i, corner) in corners.iter().enumerate() {
            let next = corners
                .get(i + 1)
                .map_or(0.0, |next| (place(next) - place(corner)) / f64::from(next.tick - corner.tick));
            changes.push((f64::from(corner.tick), next - rate));
            rate = next;
        }
        Self { start: place(&corners[0]), changes, half_blend }
    }

    fn velocity(&self, t: f64) -> f64 {
        let part = |since: f64| ((since + self.half_blend) / (2.0 * self.half_blend)).clamp(0.0, 1.0);
        self.changes.iter().map(|&(tick, change)| change * part(t - tick)).sum()
    }

    /// Position at every tick up to the last: the integral of the velocity by the trapezoidal rule, which makes no
    /// error here because the velocity bends at whole and half ticks only.
    fn positions(&self, last: u32) -> Vec<f64> {
        let mut position = self.start;
        let mut positions = vec![position];
        for half_tick in 0..2 * last {
            let t = 0.5 * f64::from(half_tick);
            position += 0.25 * (self.velocity(t) + self.velocity(t + 0.5));
            if half_tick % 2 == 1 {
                positions.push(position);
            }
        }
        positions
    }
}

fn far_from(origin: i32, position: Position) -> f64 {
    f64::from(position.counts.wrapping_sub(origin)) + f64::from(position.fraction)
}

fn degrees(deg: f64) -> Position {
    let counts = deg / f64::from(RESOLUTION);
    Position { counts: counts.floor() as i32, fraction: counts.fract() as f32 }
}

fn corners(corners: &[(u32, Position)]) -> Vec<Corner> {
    corners.iter().map(|&(tick, position)| Corner { tick, position }).collect()
}

/// 50 deg and back at 5 deg/s: corners at 1, 11, 13 and 23 s.
fn thesis() -> Vec<Corner> {
    corners(&[(50, degrees(0.0)), (550, degrees(50.0)), (650, degrees(50.0)), (1150, degrees(0.0))])
}

#[test]
fn thesis_profile_is_the_integral_of_its_velocity() {
    let trajectory = Trajectory::new(&thesis(), 0.25, SAMPLE_TIME, RESOLUTION).unwrap();
    let profile = Profile::new(&thesis(), 12.5, 0);
    let positions = profile.positions(1300);
    assert!((positions[1300]).abs() < 1e-6, "the integral itself is off: {}", positions[1300]);
    let to_deg_per_s = f64::from(RESOLUTION) / f64::from(SAMPLE_TIME);
    for (tick, &position) in (0..).zip(&positions) {
        let setpoint = trajectory.at(tick);
        let error = far_from(0, setpoint.position) - position;
        assert!(error.abs() < 1e-4, "{error} counts at tick {tick}");
        let velocity = profile.velocity(f64::from(tick)) * to_deg_per_s;
        assert!((f64::from(setpoint.velocity) - velocity).abs() < 1e-6, "{setpoint:?} at tick {tick}");
        // The blends begin and end half way between two ticks: 37.5, 62.5, ...
        let acceleration = match tick {
            38..=62 | 1138..=1162 => 10.0,
            538..=562 | 638..=662 => -10.0,
            _ => 0.0,
        };
        assert!((setpoint.acceleration - acceleration).abs() < 1e-5, "{setpoint:?} at tick {tick}");
    }
}

#[test]
fn thesis_profile_passes_where_paul_says_and_rests_exactly() {
    let trajectory = Trajectory::new(&thesis(), 0.25, SAMPLE_TIME, RESOLUTION).unwrap();
    let degrees_at = |tick| far_from(0, trajectory.at(tick).position) * f64::from(RESOLUTION);
    // A corner is cut by a quarter of the half blend at the full change of rate: 5 deg/s * 0.25 s / 4.
    for (tick, expected) in
        [(50, 0.3125), (300, 25.0), (550, 49.6875), (650, 49.6875), (900, 25.0), (1150, 0.3125)]
    {
        assert!((degrees_at(tick) - expected).abs() < 1e-6, "{} at tick {tick}", degrees_at(tick));
    }
    for tick in 63..=537 {
        assert!((trajectory.at(tick).velocity - 5.0).abs() < 1e-6);
    }
    let [first, top, _, last] = thesis()[..] else { panic!("four corners") };
    for (ticks, place) in [(0..=37, first), (563..=637, top), (1163..=2000, last)] {
        for tick in ticks {
            assert_eq!(trajectory.at(tick), Setpoint::at_rest(place.position), "tick {tick}");
        }
    }
    for moving in [38, 562, 638, 1162] {
        assert_ne!(trajectory.at(moving).velocity, 0.0, "tick {moving}");
    }
    // No jump of position or velocity: what one tick adds is bounded by the acceleration of the blends.
    for tick in 1..1300 {
        let [before, here, after] = [tick - 1, tick, tick + 1].map(|tick| trajectory.at(tick));
        let bend = degrees_at(tick + 1) - 2.0 * degrees_at(tick) + degrees_at(tick - 1);
        assert!(bend.abs() < 10.0 * 0.02 * 0.02 + 1e-6, "{bend} deg at tick {tick}");
        assert!((here.velocity - before.velocity).abs() < 10.0 * 0.02 + 1e-5, "tick {tick}");
        assert!((after.velocity - here.velocity).abs() < 10.0 * 0.02 + 1e-5, "tick {tick}");
    }
}

proptest! {
    #![proptest_config(config())]

    #[test]
    fn trajectory_is_the_integral_of_its_velocity_wherever_it_lies(
        half_blend in (1u32..=60).prop_map(|n| 0.5 * f64::from(n)),
        gaps_and_positions in vec((1u32..150, -200_000..=200_000i32, 0u32..1 << 24), 1..=6),
        sample_time in prop_oneof![Just(0.02), Just(0.001), Just(0.000_05)],
        origin in prop_oneof![any::<i32>(), Just(2_000_000_000), Just(i32::MAX), Just(i32::MIN)],
    ) {
        let mut tick = 0;
        let at = |origin: i32| move |(tick, counts, fraction): &(u32, i32, u32)| Corner {
            tick: *tick,
            position: Position {
                counts: counts.wrapping_add(origin),
                fraction: *fraction as f32 / 16_777_216.0,
            },
        };
        let places: Vec<_> = gaps_and_positions
            .into_iter()
            .map(|(gap, counts, fraction)| {
                tick += gap + (2.0 * half_blend) as u32;
                (tick, counts, fraction)
            })
            .collect();
        let corners: Vec<_> = places.iter().map(at(0)).collect();
        let new = |corners: &[Corner]| {
            let half_blend_s = (half_blend * sample_time) as f32;
            Trajectory::new(corners, half_blend_s, sample_time as f32, RESOLUTION).unwrap()
        };
        let trajectory = new(&corners);
        let shifted = new(&places.iter().map(at(origin)).collect::<Vec<_>>());
        let profile = Profile::new(&corners, half_blend, 0);
        let last = tick + half_blend as u32 + 5;

        // `f32` holds the displacement within a blend, no more than three times its half length at the fastest
        // rate; a line is a whole number of 2^-32 counts each tick.
        let (_, fastest) = profile.changes.iter().fold((0.0, 0.0), |(rate, fastest), (_, change)| {
            (rate + change, f64::max(fastest, f64::abs(rate + change)))
        });
        let to_deg_per_s = f64::from(RESOLUTION) / sample_time;
        let velocity_tolerance = 16.0 * HALF_ULP * (fastest + 1.0);
        let tolerance = velocity_tolerance * half_blend + 16.0 * HALF_ULP + f64::from(last) / 4_294_967_296.0;
        for (tick, position) in (0..).zip(profile.positions(last)) {
            let setpoint = trajectory.at(tick);
            let error = far_from(0, setpoint.position) - position;
            prop_assert!(error.abs() <= tolerance, "{error} counts at tick {tick}, not {tolerance}");
            let velocity = profile.velocity(f64::from(tick)) * to_deg_per_s;
            let error = f64::from(setpoint.velocity) - velocity;
            prop_assert!(error.abs() <= velocity_tolerance * to_deg_per_s, "{error} deg/s at tick {tick}");
            prop_assert!((0.0..1.0).contains(&setpoint.position.fraction));

            let mut moved_back = shifted.at(tick);
            moved_back.position.counts = moved_back.position.counts.wrapping_sub(origin);
            prop_assert_eq!(moved_back, setpoint, "tick {}", tick);
        }
        let end = corners[corners.len() - 1].position;
        prop_assert_eq!(trajectory.at(last), Setpoint::at_rest(end));
        prop_assert_eq!(trajectory.at(0), Setpoint::at_rest(corners[0].position));
    }
}

/// A day at a third of a count each tick. A product in `f32` would be off by a sixteenth of a count.
#[test]
fn line_of_a_day_keeps_its_place_to_a_thousandth_of_a_count() {
    let day = 24 * 3600 * 50;
    let corners =
        corners(&[(50, Position::from_counts(0)), (50 + day, Position::from_counts(day as i32 / 3))]);
    let trajectory = Trajectory::new(&corners, 0.25, SAMPLE_TIME, RESOLUTION).unwrap();
    for k in (1000..day - 1000).step_by(997) {
        let error = far_from(0, trajectory.at(50 + k).position) - f64::from(k) / 3.0;
        assert!(error.abs() <= f64::from(k) / 4_294_967_296.0 + HALF_ULP, "{error} counts after {k} ticks");
    }
}

#[test]
fn every_parameter_of_a_reference_changes_it() {
    let positions = |reference: &Reference| (0..1300).map(|tick| reference.at(tick)).collect::<Vec<_>>();
    let trajectory = |change: &dyn Fn(&mut Vec<Corner>, &mut [f32; 3])| {
        let mut corners = thesis();
        let mut numbers = [0.25, SAMPLE_TIME, RESOLUTION];
        change(&mut corners, &mut numbers);
        let [half_blend_s, sample_time, resolution] = numbers;
        positions(&Reference::Trajectory(
            Trajectory::new(&corners, half_blend_s, sample_time, resolution).unwrap(),
        ))
    };
    let base = trajectory(&|_, _| {});
    for i in 0..4 {
        assert_ne!(trajectory(&|corners, _| corners[i].tick += 1), base, "time of corner {i}");
        assert_ne!(trajectory(&|corners, _| corners[i].position.counts += 1), base, "counts of corner {i}");
        assert_ne!(
            trajectory(&|corners, _| corners[i].position.fraction += 0.25),
            base,
            "fraction of corner {i}"
        );
    }
    assert_ne!(trajectory(&|corners, _| corners.truncate(3)), base, "number of corners");
    for (i, name) in ["half blend", "sample time", "resolution"].iter().enumerate() {
        assert_ne!(trajectory(&|_, numbers| numbers[i] *= 1.05), base, "{name}");
    }

    let step = Step { from: Position::from_counts(3), to: Position::from_counts(2066), at_tick: 50 };
    let at = positions(&Reference::Step(step));
    let [from, to] = [3, 2066].map(|counts| Setpoint::at_rest(Position::from_counts(counts)));
    assert_eq!((at[0], at[49], at[50], at[1299]), (from, from, to, to));
}

#[test]
fn displaced_position_keeps_its_fraction_below_one() {
    let zero = Position::default();
    let almost_one = 1f32.next_down();
    // The first three end nearer to a whole count than an `f32` below one can tell.
    for (from, displacement, to) in [
        (zero, -1e-9, zero),
        (zero, -f32::from_bits(1), zero),
        (Position { counts: i32::MAX, fraction: almost_one }, 4e-8, Position::from_counts(i32::MIN)),
        (zero, -HALF_ULP as f32, Position { counts: -1, fraction: almost_one }),
        (Position { counts: i32::MAX, fraction: 0.75 }, 0.25, Position::from_counts(i32::MIN)),
        (Position { counts: i32::MIN, fraction: 0.25 }, -0.5, Position { counts: i32::MAX, fraction: 0.75 }),
    ] {
        assert_eq!(from.displaced(displacement), to, "{from:?} by {displacement}");
    }
}

/// A timer of which 65 534 is the top at 100 Hz, exactly: the longest period that is allowed.
const TIMER: Hardware = Hardware { pwm_clock_hz: 4.0 * 32_767.0 * 100.0, supply_top: 4095 };

/// A drive whose timer has this top.
fn drive(full_scale: f32, lsb: f32, mode: PwmMode, top: u16) -> Result<Drive, Error> {
    let pwm_hz = TIMER.pwm_clock_hz / (2.0 * f32::from(top));
    let drive = Drive::new(&DriveConfig { full_scale, lsb, mode, pwm_hz, duty_max: 1.0 }, &TIMER)?;
    assert_eq!(drive.pwm_top(), top);
    Ok(drive)
}

#[test]
fn pwm_top_is_the_even_one_nearest_to_the_frequency() {
    for hz in [1300.0, 1301.0, 9_999.0, 20e3, 22e3, 100e3, 1e6, 5.25e6f32] {
        let exact = 168e6 / (2.0 * f64::from(hz));
        let top = STM32F405.pwm_top(hz).unwrap();
        // The next even ones are two away.
        let off = (f64::from(top) - exact).abs();
        assert!(top.is_multiple_of(2) && off <= 1.0 + 1e-6 * exact, "{hz} Hz: {top}, {exact}");
    }
    assert_eq!([1300.0, 22e3, 5.25e6].map(|hz| STM32F405.pwm_top(hz)), [Ok(64_616), Ok(3818), Ok(16)]);
    assert_eq!(TIMER.pwm_top(100.0), Ok(65_534));
    for (hardware, hz) in [(STM32F405, 1299.0), (STM32F405, 5.26e6), (TIMER, 99.9), (TIMER, f32::NAN)] {
        let error = hardware.pwm_top(hz).unwrap_err();
        assert_eq!(error.key.to_string(), "pwm_hz", "{hz} Hz");
    }
}

#[test]
fn code_rounds_an_exact_half_away_from_zero() {
    // With an LSB of 2^-8 V every half is a float, and so is its neighbour.
    let drive = drive(5.0, 1.0 / 256.0, PwmMode::LockedAntiphase, 3818).unwrap();
    assert_eq!(drive.max_code(), 1280);
    for k in 0..1280i16 {
        let half = (f32::from(k) + 0.5) / 256.0;
        assert_eq!((drive.code(half), drive.code(-half)), (k + 1, -k - 1), "{half} V");
        let below = half.next_down();
        assert_eq!((drive.code(below), drive.code(-below)), (k, -k), "{below} V");
    }
    for beyond in [1280.5 / 256.0, 1281.0 / 256.0, 1e9, f32::MAX, f32::INFINITY] {
        assert_eq!((drive.code(beyond), drive.code(-beyond)), (1280, -1280), "{beyond} V");
    }
    assert_eq!(drive.code(f32::NAN), 0);
}

proptest! {
    #![proptest_config(config())]

    #[test]
    fn code_is_nearest_odd_and_monotone(
        full_scale in 0.1f32..100.0,
        codes in 1.0f32..32_767.0,
        shares in (-1.5f32..1.5, -1.5f32..1.5),
        bits in any::<(u32, u32)>(),
    ) {
        let lsb = full_scale / codes;
        let drive = drive(full_scale, lsb, PwmMode::LockedAntiphase, 3818).unwrap();
        let max = f64::from(drive.max_code());
        let volts = (shares.0 * full_scale, shares.1 * full_scale);
        let exact = (f64::from(volts.0) / f64::from(lsb)).clamp(-max, max);
        let code = f64::from(drive.code(volts.0));
        // The reciprocal and the product are each rounded to half a unit in the last place.
        let off = (code - exact).abs();
        prop_assert!(off <= 0.5 + 2.1 * HALF_ULP * exact.abs(), "{volts:?}: {exact}, not {code}");

        for (a, b) in [volts, (f32::from_bits(bits.0), f32::from_bits(bits.1))] {
            for x in [a, b] {
                prop_assert_eq!(drive.code(-x), -drive.code(x), "{} V", x);
                prop_assert!(x.is_nan() || drive.code(x.next_up()) >= drive.code(x), "{x} V");
            }
            if a <= b {
                prop_assert!(drive.code(a) <= drive.code(b), "{a} V and {b} V");
            }
        }
    }

    #[test]
    fn code_of_a_power_of_two_is_the_rounded_quotient_itself(exponent in 2i32..14, share in -1.5f32..1.5) {
        let lsb = 0.5f32.powi(exponent);
        let drive = drive(1.0, lsb, PwmMode::LockedAntiphase, 3818).unwrap();
        // Rounded to a tenth of a code, so that many are exact halves.
        let v = (share * 10.0 / lsb).round() / 10.0 * lsb;
        for v in [v, share] {
            let expected = (v / lsb).round().clamp(-1.0 / lsb, 1.0 / lsb);
            prop_assert_eq!(f32::from(drive.code(v)), expected, "{} V", v);
        }
    }
}

#[test]
fn duty_is_the_rounded_share_of_the_top_for_every_code() {
    /// Numerator over denominator (both positive), rounded half up.
    fn rounded(numerator: i64, denominator: i64) -> i64 {
        (2 * numerator + denominator).div_euclid(2 * denominator)
    }
    for (codes, top) in [
        (1, 16),
        (1, 65_534),
        (3, 16),
        (1024, 3818),
        (1024, 2048),
        (1000, 1000),
        (32_767, 65_534),
        (32_767, 16),
    ] {
        let of = |mode| drive(f32::from(codes), 1.0, mode, top).unwrap();
        let (antiphase, magnitude) = (of(PwmMode::LockedAntiphase), of(PwmMode::SignMagnitude));
        assert_eq!((antiphase.max_code(), magnitude.max_code()), (codes, codes));
        for code in i16::MIN..=i16::MAX {
            let size = i64::from(code).abs().min(i64::from(codes));
            let (top, codes) = (i64::from(top), i64::from(codes));

            let Duty { compare, reverse } = antiphase.duty(code);
            let swing = i64::from(code.signum()) * rounded(size * top, 2 * codes);
            assert_eq!(
                (i64::from(compare), reverse),
                (top / 2 + swing, false),
                "{code} of {codes}, top {top}"
            );

            let Duty { compare, reverse } = magnitude.duty(code);
            assert_eq!(
                (i64::from(compare), reverse),
                (rounded(size * top, codes), code < 0),
                "{code} of {codes}, top {top}"
            );
        }
        assert_eq!([-codes, codes].map(|code| antiphase.duty(code).compare), [0, top]);
    }
}

/// Ticks count on for years after a motion: it must not begin anew when a signed tick count would wrap.
#[test]
fn finished_motion_stays_finished_to_the_last_tick() {
    let corners = [(50, 0), (550, 20_661)]
        .map(|(tick, counts)| Corner { tick, position: Position::from_counts(counts) });
    let trajectory = Trajectory::new(&corners, 0.25, 0.02, 0.00242).unwrap();
    for tick in [563, 1 << 31, (1 << 31) + 563, u32::MAX] {
        let setpoint = trajectory.at(tick);
        assert_eq!((setpoint.position, setpoint.velocity), (Position::from_counts(20_661), 0.0), "{tick}");
    }
}

/// 0.3 s / 0.02 s is 15.000001 in `f32`, and ticks beyond 2^24 are not all there.
#[test]
fn corners_may_touch_exactly_however_late_they_are() {
    let taken = |ticks: &[u32], half_blend_s| {
        let corners: Vec<_> =
            ticks.iter().map(|&tick| Corner { tick, position: Position::from_counts(tick as i32) }).collect();
        Trajectory::new(&corners, half_blend_s, 0.02, 0.00242).is_ok()
    };
    assert!(taken(&[15, 45], 0.3) && !taken(&[14, 45], 0.3) && !taken(&[15, 44], 0.3));
    assert!(taken(&[16_777_216, 16_777_241], 0.25) && !taken(&[16_777_216, 16_777_240], 0.25));
}
