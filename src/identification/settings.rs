//! The bounds of an identification, and the values derived from them.

use serde::{Deserialize, Serialize};

use super::follower::Follower;
use crate::control::controller::ControllerConfig;
use crate::control::profile::ProfileLimits;
use crate::safety::monitor::Limits;
use crate::safety::open_loop::Bounds;
use crate::units::error::{HUGE, InvalidValue, above, between};
use crate::units::value::Key;

/// Value numbers of the bounds, by which a refusal names them.
pub(crate) const EFFORT: Key = Key(0x0606);
pub(crate) const TRAVEL: Key = Key(0x0607);
pub(crate) const SPEED: Key = Key(0x0608);
pub(crate) const TIME: Key = Key(0x0609);

/// Default travel in each sense, deg.
const TRAVEL_DEG: f32 = 45.0;
/// The largest travel, deg: two turns.
const FARTHEST_DEG: f32 = 720.0;
/// The least travel bound, counts: a window at the slowest speed needs it.
pub const LEAST_TRAVEL_COUNTS: f32 = 500.0;
/// Default time, and the longest one, s.
const TIME_S: f32 = 300.0;
const LONGEST_S: f32 = 1800.0;
/// Default effort, in breakaway efforts (`limits.breakaway_v`).
const EFFORT_SHARE: f32 = 4.0;
/// Time for which a joint at rest stays within two counts, s.
const QUIET_S: f32 = 0.2;
/// Length of a window in time constants of the follower.
const WINDOW: f32 = 4.0;
/// Windows in the longest leg.
const DWELL: f32 = 10.0;
/// Shares of the travel bound and of the speed bound that the motion uses: the rest is for
/// overshoot.
const USED: f32 = 0.85;
const USED_SPEED: f32 = 0.7;
/// Least number of windows between the start and the end of the travel at the fastest speed.
const FEWEST: f32 = 5.0;

/// Bounds that a client requests for an identification; none: the default.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct IdentificationRequest {
    /// Largest effort, V. Default: four times `limits.breakaway_v`, and no more than drive and
    /// `duty_max` allow; half of that maximum if `limits.breakaway_v` is zero.
    pub effort: Option<f32>,
    /// Largest distance from where the joint was armed, deg. Default: 45 deg, or 500 counts if that
    /// is more.
    pub travel: Option<f32>,
    /// Largest speed, deg/s. Default: the velocity of `[profile]`.
    pub speed: Option<f32>,
    /// Longest time, s. Default: 300 s.
    pub time: Option<f32>,
}

/// An identification that is prepared for a loop.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct IdentificationPlan {
    pub(super) bounds: Bounds,
    /// Time of a tick, s, and angle of a count, deg.
    pub(super) tick: f32,
    pub(super) count: f32,
    /// Time for which a joint at rest stays within two counts, ticks.
    pub(super) quiet: u32,
    /// Length of a window, ticks.
    pub(super) window: u32,
    /// The fastest speed of the map, deg/s, and the slowest that the encoder shows.
    pub(super) fast: f32,
    pub(super) slow: f32,
}

impl IdentificationPlan {
    /// Prepares an identification within the bounds that a client requests.
    ///
    /// # Errors
    /// Returns an error that names the invalid bound: an effort beyond what the drive allows, a
    /// speed of more than `[profile]`, a travel of less than 500 counts or of more than two turns,
    /// a time of more than half an hour.
    pub fn new(
        asked: &IdentificationRequest,
        controller: &ControllerConfig,
        limits: &Limits,
        profile: &ProfileLimits,
    ) -> Result<Self, InvalidValue> {
        let (tick, count) = (controller.sample_time, controller.encoder.resolution);
        let largest = controller.drive.full_scale * controller.drive.duty_max;
        let usual = match limits.breakaway_effort {
            known if known > 0.0 => (EFFORT_SHARE * known).min(largest),
            _ => 0.5 * largest,
        };
        let least = LEAST_TRAVEL_COUNTS * count;
        let effort = asked.effort.unwrap_or(usual);
        let travel = asked.travel.unwrap_or(TRAVEL_DEG.max(least));
        let speed = asked.speed.unwrap_or(profile.velocity);
        let time = asked.time.unwrap_or(TIME_S);
        above(EFFORT, effort, 0.0, largest)?;
        between(TRAVEL, travel, least, FARTHEST_DEG.max(least))?;
        above(SPEED, speed, 0.0, profile.velocity.min(HUGE))?;
        above(TIME, time, 0.0, LONGEST_S)?;
        // The conversions saturate.
        let ticks = |s: f32| (libm::roundf(s / tick) as u32).max(2);
        let bandwidth = Follower::bandwidth(tick);
        let window = WINDOW / bandwidth;
        let fast = (USED_SPEED * speed).min(USED * travel / (FEWEST * window));
        Ok(Self {
            bounds: Bounds {
                effort,
                travel: (travel / count) as u32,
                speed: speed * tick / count,
                ticks: ticks(time),
            },
            tick,
            count,
            quiet: ticks(QUIET_S),
            window: ticks(window),
            fast,
            // The filter of the follower has a rounding of some 2 w counts a second.
            slow: 3.0 * bandwidth * count,
        })
    }

    /// Returns the largest distance from where the joint was armed, counts.
    pub const fn travel(&self) -> u32 {
        self.bounds.travel
    }

    /// Returns the least speed bound at which the encoder shows the swings, deg/s, if the bound of
    /// the plan is less; none otherwise. Without swings nothing shows the inertia. Their mean speed
    /// is half of the fastest speed.
    ///
    /// A travel of 500 counts, the least that is allowed, has room for three times that speed.
    ///
    /// ```
    /// use stiction::identification::IdentificationRequest;
    /// use stiction::units::value::Table as _;
    /// use stiction::{ControllerConfig, Limits, ProfileLimits, identification::IdentificationPlan};
    /// let controller = ControllerConfig::EXAMPLE; // 0.0024 deg, 20 ms, 5 rad/s
    /// let of = |speed| {
    ///     let asked =
    ///         IdentificationRequest { speed: Some(speed), ..IdentificationRequest::default() };
    ///     let (limits, profile) = (Limits::EXAMPLE, ProfileLimits::EXAMPLE);
    ///     IdentificationPlan::new(&asked, &controller, &limits, &profile).unwrap().least_speed()
    /// };
    /// // 2 * 3 * 5 rad/s * 0.00242 deg / 0.7
    /// let least = of(0.05).unwrap();
    /// assert!((least - 0.1037).abs() < 1e-3, "{least}");
    /// assert_eq!(of(0.11), None);
    /// ```
    pub fn least_speed(&self) -> Option<f32> {
        let shows = 2.0 * self.slow;
        (self.fast < shows).then_some(shows / USED_SPEED)
    }

    /// Returns the longest time, s.
    pub const fn time(&self) -> f32 {
        self.bounds.ticks as f32 * self.tick
    }

    /// Returns the part of the travel that the motion uses, deg.
    pub(super) const fn room(&self) -> f32 {
        USED * self.bounds.travel as f32 * self.count
    }

    /// Returns the time of a window, s.
    pub(super) const fn window_time(&self) -> f32 {
        self.window as f32 * self.tick
    }

    /// Returns the longest way of a leg at a speed, deg.
    pub(super) const fn way(&self, speed: f32) -> f32 {
        DWELL * self.window_time() * speed
    }

    /// Returns the number of ticks in a time (s), rounded.
    pub(super) fn ticks(&self, time: f32) -> u32 {
        libm::roundf(time / self.tick) as u32
    }
}
