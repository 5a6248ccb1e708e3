//! What has become of a move: where it was to lead, where the joint is, and when it was there.

use std::fmt;

use serde_json::{Value, json};
use stiction::ProfileLimits;
use stiction::link::Sample;

use super::signals::Signals;

/// The signals that tell how a move ends.
const SIGNALS: [&str; 2] = ["counts", "status"];

/// Least time between two of the samples that are looked at, s.
const LOOKED_AT_S: f64 = 0.01;

/// The end of a move. Positions count from the zero of the arming.
#[derive(Clone, Debug, PartialEq)]
pub struct Moved {
    target_counts: i64,
    resolution_deg: f64,
    sample_time_s: f64,
    /// The tick of the first sample.
    begin: Option<u32>,
    /// The tick of the last sample with another position than before, and the position of the last
    /// one.
    moved_last: u32,
    counts: i64,
}

impl Moved {
    /// Begins to look at a move to a position, deg.
    pub fn to(deg: f64, resolution_deg: f64, sample_time_s: f64) -> Self {
        Self {
            target_counts: (deg / resolution_deg).round() as i64,
            resolution_deg,
            sample_time_s,
            begin: None,
            moved_last: 0,
            counts: 0,
        }
    }

    /// What has to be subscribed, unless more is.
    pub fn subscription(&self, signals: &Signals) -> (u64, u16) {
        let every = (LOOKED_AT_S / self.sample_time_s).clamp(1.0, 1000.0);
        (signals.mask(SIGNALS), every as u16)
    }

    /// Takes a sample of an armed device, in their order.
    pub fn see(&mut self, signals: &Signals, sample: &Sample) {
        let counts = signals.number(sample, "counts") as i64;
        if self.begin.is_none() {
            (self.begin, self.moved_last) = (Some(sample.clock), sample.clock);
            self.counts = counts;
        }
        if counts != self.counts {
            (self.counts, self.moved_last) = (counts, sample.clock);
        }
    }

    /// Where the joint is ahead of its target, counts.
    pub const fn error_counts(&self) -> i64 {
        self.counts - self.target_counts
    }

    /// From the begin to the last count of the motion, s.
    pub fn time_s(&self) -> f64 {
        let ticks = self.begin.map_or(0, |begin| self.moved_last.wrapping_sub(begin));
        f64::from(ticks) * self.sample_time_s
    }

    /// The same for programs.
    pub fn json(&self, at_rest: bool, warning: Option<&str>) -> Value {
        let deg = |counts: i64| counts as f64 * self.resolution_deg;
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
        })
    }
}

/// A line each for target, position and time.
impl fmt::Display for Moved {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let deg = |counts: i64| counts as f64 * self.resolution_deg;
        let (target, counts, error) = (self.target_counts, self.counts, self.error_counts());
        let off = match error {
            0 => "on target".into(),
            1 | -1 => format!("{error:+} count off"),
            _ => format!("{error:+} counts off"),
        };
        writeln!(f, "target     {:.4} deg ({target} counts)", deg(target))?;
        writeln!(f, "reached    {:.4} deg ({counts} counts), {off}", deg(counts))?;
        writeln!(f, "time       {:.2} s until the last count of the motion", self.time_s())
    }
}

/// The longest time that a profiled move over so many degrees takes until its set point rests, s:
/// that of its trapezoid or triangle, and its averages, which are up to twice as long as the jerk
/// needs. A fifth is for limits that are rounded to whole units.
pub fn longest_s(limits: &ProfileLimits, deg: f64) -> f64 {
    let [v, a, j] = [limits.velocity, limits.acceleration, limits.jerk].map(f64::from);
    let way = deg.abs();
    let used = if way * a > v * v { way / v + v / a } else { 2.0 * (way / a).sqrt() };
    5.0 / 4.0 * used + 4.0 * a / j
}

#[cfg(test)]
mod tests {
    use super::*;
    use stiction::signal::index;

    fn sample(clock: u32, counts: i32) -> Sample {
        Sample {
            number: 0,
            clock,
            signals: 1 << index("counts"),
            values: counts.to_le_bytes().into_iter().collect(),
        }
    }

    #[test]
    fn a_move_tells_where_it_ended_and_when() {
        let mut moved = Moved::to(-2.5, 0.01, 0.02);
        let signals = Signals::of_core();
        // 20 counts a sample, every 5 ticks, from -10 to -249, at rest then.
        for i in 0..40 {
            moved.see(&signals, &sample(1000 + 5 * i, (-10 - 20 * i as i32).max(-249)));
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

    #[test]
    fn the_longest_time_is_that_of_trapezoid_and_triangle() {
        let limits = ProfileLimits { velocity: 10.0, acceleration: 20.0, jerk: 400.0 };
        // 40 deg: 4 s and 0.5 s; 1.25 deg: twice 0.25 s; and twice 2 a/j.
        for (deg, used) in [(40.0, 4.5), (-40.0, 4.5), (1.25, 0.5)] {
            assert!((longest_s(&limits, deg) - (5.0 / 4.0 * used + 0.2)).abs() < 1e-9);
        }
    }
}
