//! Trajectories are held against the integral of their velocity.

use proptest::collection::vec;
use proptest::prelude::*;
use stiction::control::reference::{Corner, Setpoint, Trajectory};
use stiction::units::position::Position;

use super::{HALF_ULP, RESOLUTION, SAMPLE_TIME, config};

/// A trajectory in `f64`, counts and ticks: every corner adds a change of rate, spread evenly over
/// its blend.
struct Profile {
    start: f64,
    changes: Vec<(f64, f64)>,
    half_blend: f64,
}

impl Profile {
    /// Positions are taken relative to the counts of `origin`.
    fn new(corners: &[Corner], half_blend: f64, origin: i32) -> Self {
        let place = |corner: &Corner| {
            f64::from(corner.position.counts.wrapping_sub(origin))
                + f64::from(corner.position.fraction)
        };
        let mut rate = 0.0;
        let mut changes = Vec::new();
        for (i, corner) in corners.iter().enumerate() {
            let next = corners.get(i + 1).map_or(0.0, |next| {
                (place(next) - place(corner)) / f64::from(next.tick - corner.tick)
            });
            changes.push((f64::from(corner.tick), next - rate));
            rate = next;
        }
        Self { start: place(&corners[0]), changes, half_blend }
    }

    fn velocity(&self, t: f64) -> f64 {
        let part =
            |since: f64| ((since + self.half_blend) / (2.0 * self.half_blend)).clamp(0.0, 1.0);
        self.changes.iter().map(|&(tick, change)| change * part(t - tick)).sum()
    }

    /// Position at every tick up to the last: the integral of the velocity by the trapezoidal rule,
    /// which makes no error here because the velocity bends at whole and half ticks only.
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

/// The thesis's corners, 50 deg and back at 5 deg/s, at 1, 11, 13 and 23 s.
pub fn thesis() -> Vec<Corner> {
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
        assert!(
            (f64::from(setpoint.velocity) - velocity).abs() < 1e-6,
            "{setpoint:?} at tick {tick}"
        );
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
    // A corner is cut by a quarter of the half blend at the full change of rate: 5 deg/s * 0.25 s /
    // 4.
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
    // Neither position nor velocity jumps: the acceleration of the blends bounds what one tick
    // adds.
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

        // `f32` holds the displacement within a blend, no more than three times its half length at
        // the fastest rate; a line is a whole number of 2^-32 counts each tick.
        let (_, fastest) = profile.changes.iter().fold((0.0, 0.0), |(rate, fastest), (_, change)| {
            (rate + change, f64::max(fastest, f64::abs(rate + change)))
        });
        let to_deg_per_s = f64::from(RESOLUTION) / sample_time;
        let velocity_tolerance = 16.0 * HALF_ULP * (fastest + 1.0);
        let tolerance =
            velocity_tolerance * half_blend + 16.0 * HALF_ULP + f64::from(last) / 4_294_967_296.0;
        for (tick, position) in (0..).zip(profile.positions(last)) {
            let setpoint = trajectory.at(tick);
            let error = far_from(0, setpoint.position) - position;
            let off = error.abs();
            prop_assert!(off <= tolerance, "{off} counts at tick {tick}, not {tolerance}");
            let velocity = profile.velocity(f64::from(tick)) * to_deg_per_s;
            let error = f64::from(setpoint.velocity) - velocity;
            let tolerance = velocity_tolerance * to_deg_per_s;
            prop_assert!(error.abs() <= tolerance, "{error} deg/s at tick {tick}");
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

/// The line lasts a day at a third of a count each tick. A product in `f32` would be off by a
/// sixteenth of a count.
#[test]
fn line_of_a_day_keeps_its_place_to_a_thousandth_of_a_count() {
    let day = 24 * 3600 * 50;
    let corners = corners(&[
        (50, Position::from_counts(0)),
        (50 + day, Position::from_counts(day as i32 / 3)),
    ]);
    let trajectory = Trajectory::new(&corners, 0.25, SAMPLE_TIME, RESOLUTION).unwrap();
    for k in (1000..day - 1000).step_by(997) {
        let error = far_from(0, trajectory.at(50 + k).position) - f64::from(k) / 3.0;
        assert!(
            error.abs() <= f64::from(k) / 4_294_967_296.0 + HALF_ULP,
            "{error} counts after {k} ticks"
        );
    }
}

/// Ticks count on for years after a motion: it must not begin anew when a signed tick count would
/// wrap.
#[test]
fn finished_motion_stays_finished_to_the_last_tick() {
    let corners = [(50, 0), (550, 20_661)]
        .map(|(tick, counts)| Corner { tick, position: Position::from_counts(counts) });
    let trajectory = Trajectory::new(&corners, 0.25, 0.02, 0.00242).unwrap();
    for tick in [563, 1 << 31, (1 << 31) + 563, u32::MAX] {
        let setpoint = trajectory.at(tick);
        assert_eq!(
            (setpoint.position, setpoint.velocity),
            (Position::from_counts(20_661), 0.0),
            "{tick}"
        );
    }
}

/// 0.3 s / 0.02 s is 15.000001 in `f32`, and ticks beyond 2^24 are not all there.
#[test]
fn corners_may_touch_exactly_however_late_they_are() {
    let taken = |ticks: &[u32], half_blend_s| {
        let corners: Vec<_> = ticks
            .iter()
            .map(|&tick| Corner { tick, position: Position::from_counts(tick as i32) })
            .collect();
        Trajectory::new(&corners, half_blend_s, 0.02, 0.00242).is_ok()
    };
    assert!(taken(&[15, 45], 0.3) && !taken(&[14, 45], 0.3) && !taken(&[15, 44], 0.3));
    assert!(taken(&[16_777_216, 16_777_241], 0.25) && !taken(&[16_777_216, 16_777_240], 0.25));
}
