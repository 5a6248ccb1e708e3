//! Result of a move: target, position reached, and time.

use std::fmt;

use serde_json::{Value, json};
use stiction::ProfileLimits;
use stiction::link::Sample;

use super::signals::Signals;
use crate::settling::Settling;
use files::data_sheet::UnseenSlack;
use files::goal::PositionGoal;

/// Signals that a move is judged by.
const SIGNALS: [&str; 3] = ["counts", "status", "reference_velocity_deg_per_s"];

/// Least time between two samples, s.
const LOOKED_AT_S: f64 = 0.01;

/// Result of a move. Positions count from the zero of the arming.
///
/// A device measures its encoder only. A simulated device reports its load as well, and the move is
/// judged on both sides of the gear.
#[derive(Clone, Debug, PartialEq)]
pub struct MoveResult {
    target_counts: i64,
    resolution_deg: f64,
    sample_time_s: f64,
    /// The tick of the first sample.
    begin: Option<u32>,
    /// The tick of the last sample with another position than before, and the position of the last
    /// one.
    moved_last: u32,
    counts: i64,
    /// Position of the load in the last sample, counts; `None` if the device does not report it.
    load_counts: Option<f64>,
    goal: PositionGoal,
    slack: Option<UnseenSlack>,
    /// Verdicts at the encoder and at the load, from the end of the set point's motion on.
    sides: [Settling; 2],
    rests_since_s: f64,
    is_ended: bool,
}

impl MoveResult {
    /// Creates the result of a move to a position (deg), before its first sample.
    pub fn to(deg: f64, resolution_deg: f64, sample_time_s: f64) -> Self {
        let goal = PositionGoal::default();
        Self {
            target_counts: (deg / resolution_deg).round() as i64,
            resolution_deg,
            sample_time_s,
            begin: None,
            moved_last: 0,
            counts: 0,
            load_counts: None,
            goal,
            slack: None,
            sides: [Settling::new(&goal, resolution_deg); 2],
            rests_since_s: 0.0,
            is_ended: false,
        }
    }

    /// Sets the goal by which the move is judged, and the slack of the gear that the encoder cannot
    /// see; `None`: there is no such slack.
    #[must_use]
    pub fn judged_by(self, goal: PositionGoal, slack: Option<UnseenSlack>) -> Self {
        let sides = [Settling::new(&goal, self.resolution_deg); 2];
        Self { goal, slack, sides, ..self }
    }

    /// Returns the signals that must be subscribed, as a mask, and the number of ticks between two
    /// samples.
    pub fn subscription(&self, signals: &Signals) -> (u64, u16) {
        let every = (LOOKED_AT_S / self.sample_time_s).clamp(1.0, 1000.0);
        (signals.mask(SIGNALS), every as u16)
    }

    /// Evaluates the next sample of an armed device. `load_ahead_deg` is the load's angle minus
    /// that of the encoder's side, if the device reports it.
    pub fn see(&mut self, signals: &Signals, sample: &Sample, load_ahead_deg: Option<f64>) {
        let counts = signals.number(sample, "counts") as i64;
        if self.begin.is_none() {
            (self.begin, self.moved_last) = (Some(sample.clock), sample.clock);
            self.counts = counts;
        }
        if counts != self.counts {
            (self.counts, self.moved_last) = (counts, sample.clock);
        }
        self.load_counts = load_ahead_deg.map(|deg| counts as f64 + deg / self.resolution_deg);
        let time_s = self.since_begin_s(sample.clock);
        if signals.number(sample, "reference_velocity_deg_per_s") != 0.0 {
            self.rests_since_s = time_s;
            self.sides.iter_mut().for_each(Settling::restart);
        }
        let target = self.target_counts as f64;
        let of_load = self.load_counts.unwrap_or(f64::NAN);
        for (side, position) in self.sides.iter_mut().zip([counts as f64, of_load]) {
            side.see(time_s, target - position);
        }
    }

    /// Marks the move as ended by a fault or a stop: it has not met its goal, wherever the joint
    /// is.
    pub const fn end(&mut self) {
        self.is_ended = true;
    }

    /// Returns position minus target, counts.
    pub const fn error_counts(&self) -> i64 {
        self.counts - self.target_counts
    }

    /// Returns the time from the start to the last count of the motion, s.
    pub fn time_s(&self) -> f64 {
        self.since_begin_s(self.moved_last)
    }

    fn since_begin_s(&self, clock: u32) -> f64 {
        let ticks = self.begin.map_or(0, |begin| clock.wrapping_sub(begin));
        f64::from(ticks) * self.sample_time_s
    }

    /// Returns whether the encoder's side has met the goal.
    pub fn success_at_encoder(&self) -> bool {
        let [encoder, _] = self.sides;
        !self.is_ended && encoder.is_success(self.rests_since_s)
    }

    /// Returns whether the load has met the goal; `None` if the device does not report its load.
    pub fn success_at_load(&self) -> Option<bool> {
        let [_, load] = self.sides;
        self.load_counts.map(|_| !self.is_ended && load.is_success(self.rests_since_s))
    }

    /// Returns the JSON object for scripts.
    pub fn json(&self, at_rest: bool, warning: Option<&str>) -> Value {
        let deg = |counts: i64| counts as f64 * self.resolution_deg;
        let settled = self.sides.map(|side| {
            side.settled_s().map(|settled_s| (settled_s - self.rests_since_s).max(0.0))
        });
        let target = self.target_counts as f64;
        json!({
            "schema": 1,
            "warning": warning,
            "target_counts": self.target_counts,
            "target_deg": deg(self.target_counts),
            "reached_counts": self.counts,
            "reached_deg": deg(self.counts),
            "error_counts": self.error_counts(),
            "time_s": self.time_s(),
            "at_rest": at_rest,
            "goal": self.goal.in_both_units(self.resolution_deg),
            "unseen_slack": self.slack,
            "rest_at_encoder_counts": target - self.counts as f64,
            "rest_at_load_counts": self.load_counts.map(|counts| target - counts),
            "settled_at_encoder_s": settled[0],
            "settled_at_load_s": settled[1],
            "success_at_encoder": self.success_at_encoder(),
            "success_at_load": self.success_at_load(),
        })
    }
}

/// Prints target, position and time, one per line. If the gear has slack that the encoder cannot
/// measure, the position is marked as the encoder's, and the position of the load follows if the
/// device reports it. The verdict follows if there is such slack or the file has a goal.
impl fmt::Display for MoveResult {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let deg = |counts: f64| counts * self.resolution_deg;
        let (target, counts, error) = (self.target_counts, self.counts, self.error_counts());
        let off = match error {
            0 => "on target".into(),
            1 | -1 => format!("{error:+} count off"),
            _ => format!("{error:+} counts off"),
        };
        let side = if self.slack.is_some() { " at the encoder" } else { "" };
        writeln!(f, "target     {:.4} deg ({target} counts)", deg(target as f64))?;
        writeln!(f, "reached    {:.4} deg ({counts} counts), {off}{side}", deg(counts as f64))?;
        if let (Some(_), Some(load)) = (self.slack, self.load_counts) {
            let off = load - target as f64;
            writeln!(f, "           {:.4} deg, {off:+.1} counts off at the load", deg(load))?;
        }
        writeln!(f, "time       {:.2} s until the last count of the motion", self.time_s())?;
        if self.slack.is_none() && self.goal.is_default() {
            return Ok(());
        }
        let word = |success: bool| if success { "met" } else { "missed" };
        let at_encoder = word(self.success_at_encoder());
        let verdict = match (self.slack, self.success_at_load()) {
            (None, _) => at_encoder.to_owned(),
            (Some(_), None) => format!("{at_encoder} at the encoder; unknown at the load"),
            (Some(_), Some(at_load)) => {
                format!("{at_encoder} at the encoder, {} at the load", word(at_load))
            }
        };
        writeln!(f, "goal       {verdict}\n           ({})", self.goal.describe())
    }
}

/// Returns the longest time that a profiled move over `deg` takes until its set point rests, s: the
/// time of its trapezoid or triangle, plus that of its averages, up to twice the time 2 a/j that
/// the jerk requires. A quarter is added to the first for limits that are rounded to whole units.
pub fn longest_s(limits: &ProfileLimits, deg: f64) -> f64 {
    let [v, a, j] = [limits.velocity, limits.acceleration, limits.jerk].map(f64::from);
    let way = deg.abs();
    let used = if way * a > v * v { way / v + v / a } else { 2.0 * (way / a).sqrt() };
    5.0 / 4.0 * used + 4.0 * a / j
}

#[cfg(test)]
mod tests {
    use super::*;
    use stiction::control::signal::index;

    fn sample(clock: u32, counts: i32) -> Sample {
        Sample {
            number: 0,
            clock,
            signals: 1 << index("counts"),
            values: counts.to_le_bytes().into_iter().collect(),
        }
    }

    #[test]
    fn a_move_reports_its_end_position_and_time() {
        let mut moved = MoveResult::to(-2.5, 0.01, 0.02);
        let signals = Signals::of_core();
        // 20 counts a sample, every 5 ticks, from -10 to -249, at rest then.
        for i in 0..40 {
            let counts = (-10 - 20 * i as i32).max(-249);
            moved.see(&signals, &sample(1000 + 5 * i, counts), None);
        }
        // The twelfth sample after the first is the last one with another position: 60 ticks.
        let text = moved.to_string();
        let lines: Vec<&str> = text.lines().collect();
        assert_eq!(lines[0], "target     -2.5000 deg (-250 counts)");
        assert_eq!(lines[1], "reached    -2.4900 deg (-249 counts), +1 count off");
        assert_eq!(lines[2], "time       1.20 s until the last count of the motion");
        let json = moved.json(true, None);
        assert_eq!((&json["error_counts"], &json["time_s"]), (&1.into(), &(60.0 * 0.02).into()));
    }

    /// The load stays 30 counts behind the encoder, which arrives after 0.5 s.
    #[test]
    fn a_move_is_judged_at_the_encoder_and_where_it_is_known_at_the_load() {
        let slack = UnseenSlack { backlash_deg: 0.6, backlash_counts: 60.0, wind_up_deg: 0.01 };
        let signals = Signals::of_core();
        let moved = |goal: PositionGoal, ahead: Option<f64>| {
            let mut moved = MoveResult::to(1.0, 0.01, 0.01).judged_by(goal, Some(slack));
            for i in 0..100 {
                moved.see(&signals, &sample(7 + i, (2 * i as i32).min(100)), ahead);
            }
            moved
        };
        let (goal, behind) = (PositionGoal::default(), Some(-0.3));
        let known = moved(goal, behind);
        assert_eq!((known.success_at_encoder(), known.success_at_load()), (true, Some(false)));
        let json = known.json(true, None);
        assert_eq!(json["rest_at_encoder_counts"], 0.0);
        let at_load = json["rest_at_load_counts"].as_f64().unwrap();
        assert!((at_load - 30.0).abs() < 1e-9, "{json}");
        // Within 2 counts from 98 on.
        let settled_s = json["settled_at_encoder_s"].as_f64().unwrap();
        assert!((settled_s - 0.49).abs() < 1e-9 && json["settled_at_load_s"].is_null(), "{json}");
        let text = known.to_string();
        assert!(text.contains("on target at the encoder\n"), "{text}");
        assert!(text.contains("-30.0 counts off at the load\n"), "{text}");
        assert!(text.contains("met at the encoder, missed at the load\n"), "{text}");
        // A board does not report its load.
        let unknown = moved(goal, None);
        assert_eq!((unknown.success_at_encoder(), unknown.success_at_load()), (true, None));
        assert!(unknown.to_string().contains("met at the encoder; unknown at the load"));
        assert!(unknown.json(true, None)["rest_at_load_counts"].is_null());
        // The file's goal decides: a tolerance that the load keeps, and a time that none does.
        let wide = PositionGoal { tolerance_deg: Some(0.301), ..goal };
        assert_eq!(moved(wide, behind).success_at_load(), Some(true));
        let soon = PositionGoal { settle_s: Some(0.48), ..goal };
        assert!(!moved(soon, behind).success_at_encoder());
        let mut ended = moved(wide, behind);
        ended.end();
        assert_eq!((ended.success_at_encoder(), ended.success_at_load()), (false, Some(false)));
    }

    #[test]
    fn the_longest_time_is_that_of_trapezoid_and_triangle() {
        let limits = ProfileLimits { velocity: 10.0, acceleration: 20.0, jerk: 400.0 };
        // 40 deg: 4 s and 0.5 s; 1.25 deg: twice 0.25 s; and twice 2 a/j.
        for (deg, used) in [(40.0, 4.5), (-40.0, 4.5), (1.25, 0.5)] {
            assert!((longest_s(&limits, deg) - (5.0 / 4.0 * used + 0.2)).abs() < 1e-9);
        }
    }
}
