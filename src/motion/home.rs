//! Homing to a hard stop: the joint goes slowly one way until it is blocked, goes back a little,
//! and does so again. Two places that agree are the stop.
//!
//! ```text
//! set point ---- a profile at the homing speed, one way, farther than the travel ---->
//! loop      ---- closed, with its own law; the effort is bounded by `effort` ---->
//! joint     ---- follows ----------------| blocked: no farther for `quiet` at that effort
//!                       <----------------| back, until half of `retreat` is counted
//!                       ---------------->| blocked again: at the same place, within `agrees`
//!                       <----------------| back: the stop is found, and the output goes off
//! ```
//!
//! The joint is blocked when, for `quiet` ticks in a row, the effort in the sense of the homing is
//! at its bound and no count is farther than those before. `quiet` is at least 0.2 s, the time of 8
//! counts at the homing speed, and the time `sqrt(2 q / (g (effort - F)))` in which the weakest
//! joint makes its first count: `q` is a count, `g` `limits.progress_gain_deg_per_s2_per_v`, `F`
//! `limits.breakaway_v`. Ticks of the soft start do not count, since it bounds the effort as well.
//! If the places do not agree, the second is the first of another pair.
//!
//! An encoder that dies on the way looks like a stop. It shows no counts on the way back, so that
//! the monitors of a stall end the homing, or its time. One that counts again later has lost
//! counts, so that the places do not agree. The monitor of an abrupt stop is off on the way to the
//! stop, which is one.
//!
//! The effort lies between `F + 0.3 (S - F)` and `F + 0.9 (S - F)`, where `S` is `limits.stall_v`.
//! Below, the probe of the encoder would not see the joint held
//! ([`encoder_probe`](crate::safety::monitor)); above, a stop would be a stall at once.
//!
//! A blocked joint, or one that sets out slowly under so little effort, falls behind the set point.
//! At three quarters of `limits.following_error_deg` the set point waits, so that a stiff loop does
//! not trip.
//!
//! Guarantees: the effort is never more than `effort` and half a code. The homing ends when the
//! joint is `travel` away from its start, plus the travel of one tick, and after `time` and the
//! soft start; a joint that moves coasts. Only two places that agree, with counts away from each,
//! set a reference. The range of positions is off, since it is not known yet.
//!
//! Does badly: what holds the joint twice at the same place is a stop: a cable, a place with more
//! friction. Counts that are lost slowly on the last way back shift the position, as in every later
//! motion. The position is that of the loaded stop: a gear gives way by `effort` over its
//! stiffness, and an encoder on the motor counts its slack. A load that takes a part of `effort`
//! leaves the rest. A law that builds up its effort slowly ends as a stall. At a supply that cannot
//! give the effort, the time ends it.

use serde::{Deserialize, Serialize};

use crate::control::controller::ControllerConfig;
use crate::control::profile::{Profile, ProfileLimits};
use crate::control::signal::Tick;
use crate::motion::jog::JogBounds;
use crate::safety::monitor::Limits;
use crate::units::error::{HUGE, InvalidValue, above, between};
use crate::units::position::Position;
use crate::units::value::Key;

/// The numbers of the bounds, under which a refusal names them.
pub(crate) const EFFORT: Key = Key(0x060C);
pub(crate) const TRAVEL: Key = Key(0x060D);
pub(crate) const SPEED: Key = Key(0x060E);
pub(crate) const TIME: Key = Key(0x060F);

/// Travel unless a client states another one, if there is no range of positions, deg: a turn.
const TURN_DEG: f32 = 360.0;
/// Travel unless a client states another one, in ranges of positions.
const OF_RANGE: f32 = 1.1;
/// The largest travel, deg: two turns.
const FARTHEST_DEG: f32 = 720.0;
/// Time unless a client states another one, in times of the travel at the homing speed.
const OF_TRAVEL: f32 = 1.5;
/// The same, in times of the way back.
const OF_RETREAT: f32 = 4.0;
/// What is added to both for accelerations and the time at the stop, s.
const ADDED_S: f32 = 5.0;
/// The longest time, s.
const LONGEST_S: f32 = 1800.0;
/// Time at the stop, s: friction stops a joint in less ([`super::jog`]).
const QUIET_S: f32 = 0.2;
/// Counts of the travel in that time at the homing speed.
const QUIET_COUNTS: f32 = 8.0;
/// Fewest counts of the way back, and of a travel: half of it, which is judged, is twice the noise
/// of 16 counts that an open line picks up.
const RETREAT_COUNTS: f32 = 64.0;
/// The longest way back, deg: places that are farther from each other than a sixteenth of it are
/// two.
const RETREAT_DEG: f32 = 2.0;
/// The error at which the set point waits, in limits of the following error.
const WAITS: f32 = 0.75;
/// Places agree within this part of the way back, of which half lies between two places that are
/// none, and within the counts that a joint at rest may show twice.
const AGREES: i32 = 16;
const AGREES_COUNTS: i32 = 8;
/// The effort's bounds, as parts of the way from `breakaway_v` to `stall_v`. The probe of the
/// encoder takes a joint for held from a quarter on.
const WEAKEST: f32 = 0.3;
const STRONGEST: f32 = 0.9;
/// What an encoder on an edge flickers by, and one with a wire cut, counts twice.
const FLICKER: i32 = 2;
/// What rounding may take off an effort at its bound, codes.
const PUSHING: f32 = 1.5;

/// The sense of a homing.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum Sense {
    /// Towards smaller positions.
    #[default]
    Minus,
    /// Towards larger positions.
    Plus,
}

impl Sense {
    const fn sign(self) -> i32 {
        match self {
            Self::Minus => -1,
            Self::Plus => 1,
        }
    }
}

/// What a client asks of a homing.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct HomeRequest {
    /// Sense in which the stop is.
    pub sense: Sense,
    /// Position of the joint at the stop, counts.
    pub at: i32,
    /// Largest effort, V. Otherwise it is that of `[jog]`, within the bounds of a homing's.
    pub effort: Option<f32>,
    /// Largest distance from where the joint was armed, deg. Otherwise it is 1.1 times the range of
    /// positions, or a turn without one.
    pub travel: Option<f32>,
    /// Speed, deg/s. Otherwise it is that of `[jog]`, and no more than that of `[profile]`.
    pub speed: Option<f32>,
    /// Longest time after the soft start, s. Otherwise it is 1.5 times that of the travel, four
    /// times that of the way back, and 5 s.
    pub time: Option<f32>,
}

/// What ended a homing.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum HomeEnd {
    /// It has not ended by itself yet.
    #[default]
    Not,
    /// The stop was found twice, and the joint has left it: it is referenced.
    Stop,
    /// The joint went as far as it may, and found no stop.
    Travel,
    /// The time was over.
    Time,
}

/// What a homing has found.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct HomeFindings {
    /// What ended it.
    pub ended: HomeEnd,
    /// Travel from its begin to the stop, or to its end without one, counts.
    pub moved: i32,
    /// Effort there, V.
    pub effort: f32,
    /// How often the joint was blocked.
    pub touches: u8,
}

/// A homing that is prepared for a loop.
#[derive(Clone, Debug, PartialEq)]
pub struct Home {
    /// The set point: a move that would go on beyond the travel.
    pub(crate) profile: Profile,
    /// What ends it.
    pub(crate) watch: HomeWatch,
}

/// The watch over a profile that looks for a stop, with its state.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct HomeWatch {
    sense: Sense,
    at: i32,
    /// Largest effort, V, and the effort from which on it is at that bound.
    effort: f32,
    pushing: f32,
    /// Largest distance, counts.
    travel: u32,
    /// Longest time after the soft start, ticks.
    ticks: u32,
    /// Time at the stop, ticks.
    quiet: u32,
    /// Way back from it, counts.
    retreat: i32,
    /// Ticks that are left of the soft start.
    wait: u32,
    elapsed: u32,
    /// How far the set point may be from the joint, counts.
    lead: u32,
    /// Whether it waits for the joint.
    waits: bool,
    /// Whether the joint is on its way back.
    is_back: bool,
    /// The farthest count in the sense of the homing since the joint last went the other way.
    farthest: i32,
    /// For how many ticks the effort has been at its bound without a count that is farther.
    held: u32,
    /// The place before the last one, counts.
    before: Option<i32>,
    found: HomeFindings,
}

impl Home {
    /// Prepares a homing within the bounds that a client asks for.
    ///
    /// # Errors
    /// Names the bound that is not allowed: an effort near `limits.breakaway_v` or
    /// `limits.stall_v`, or beyond the drive; a speed of more than `[profile]`; a travel of less
    /// than 64 counts or of more than two turns; a time of more than half an hour.
    pub fn new(
        asked: &HomeRequest,
        controller: &ControllerConfig,
        limits: &Limits,
        profile: &ProfileLimits,
        jog: &JogBounds,
    ) -> Result<Self, InvalidValue> {
        let (tick, count) = (controller.sample_time, controller.encoder.resolution);
        let friction = limits.breakaway_effort;
        let let_through = controller.drive.full_scale * controller.drive.duty_max;
        let (weakest, strongest) = match limits.stall_effort {
            stall if stall > 0.0 => {
                let span = stall - friction;
                (friction + WEAKEST * span, (friction + STRONGEST * span).min(let_through))
            }
            _ => (friction, let_through),
        };
        let range = limits.position_max - limits.position_min;
        let least = RETREAT_COUNTS * count;
        let farthest = FARTHEST_DEG.max(least);
        let usual = if range > 0.0 { OF_RANGE * range } else { TURN_DEG };
        let effort = asked.effort.unwrap_or(jog.effort.max(weakest).min(strongest));
        let travel = asked.travel.unwrap_or(usual.max(least).min(farthest));
        let speed = asked.speed.unwrap_or(jog.speed.min(profile.velocity));
        between(EFFORT, effort, weakest, strongest)?;
        above(EFFORT, effort, 0.0, strongest)?;
        between(TRAVEL, travel, least, farthest)?;
        above(SPEED, speed, 0.0, profile.velocity.min(HUGE))?;
        // The conversions saturate. The target of the profile is twice as far as the travel, and
        // has to be nearer than 2^30 counts.
        let counts = |deg: f32| (deg / count).min(((1 << 29) - 64) as f32) as i32;
        let travel = counts(travel);
        let retreat = counts(jog.travel.min(RETREAT_DEG).max(least)).min(travel);
        let lead = if limits.following_error > 0.0 {
            counts(WAITS * limits.following_error).unsigned_abs()
        } else {
            u32::MAX
        };
        let way = travel as f32 * OF_TRAVEL + retreat as f32 * OF_RETREAT;
        let time = asked.time.unwrap_or((way * count / speed + ADDED_S).min(LONGEST_S));
        above(TIME, time, 0.0, LONGEST_S)?;
        let ticks = |s: f32| (libm::roundf(s / tick) as u32).max(2);
        let gain = limits.progress_gain * (effort - friction);
        let first = if gain > 0.0 { libm::sqrtf(2.0 * count / gain) } else { 0.0 };
        let target = Position::from_counts(asked.sense.sign() * 2 * travel);
        let slow = ProfileLimits { velocity: speed, ..*profile }.nearest(tick, count);
        let profile = Profile::new(target, &slow, tick, count)?;
        let watch = HomeWatch {
            sense: asked.sense,
            at: asked.at,
            effort,
            pushing: effort - PUSHING * controller.drive.lsb,
            travel: travel.unsigned_abs(),
            ticks: ticks(time),
            quiet: ticks(QUIET_S.max(QUIET_COUNTS * count / speed).max(first)),
            retreat,
            wait: 0,
            elapsed: 0,
            lead,
            waits: false,
            is_back: false,
            farthest: 0,
            held: 0,
            before: None,
            found: HomeFindings::default(),
        };
        Ok(Self { profile, watch })
    }
}

impl HomeWatch {
    /// Returns the largest effort, V.
    pub(crate) const fn effort(&self) -> f32 {
        self.effort
    }

    /// Returns whether the joint is on its way back from a place that has blocked it.
    pub(crate) const fn is_back(&self) -> bool {
        self.is_back
    }

    /// Returns the position of the joint at the stop, counts.
    pub(crate) const fn at(&self) -> i32 {
        self.at
    }

    /// Returns the position in which the homing ends at the earliest, counts.
    pub(crate) const fn leaves_at(&self) -> i32 {
        self.at.wrapping_sub(self.sense.sign() * (self.retreat / 2))
    }

    /// Restarts the watch, with the joint at rest at zero and `wait` ticks of the soft start left.
    pub(crate) fn restart(&mut self, wait: u32) {
        (self.wait, self.elapsed) = (wait, 0);
        (self.is_back, self.farthest, self.held, self.before) = (false, 0, 0, None);
        self.waits = false;
        self.found = HomeFindings::default();
    }

    /// Takes what the tick has made of the profile's set point, which turns at the stop and back.
    /// Returns whether the homing has ended.
    #[inline(never)]
    pub(crate) fn ends(&mut self, tick: &Tick, profile: &mut Profile) -> bool {
        self.elapsed = self.elapsed.saturating_add(1);
        let driven = self.elapsed.saturating_sub(self.wait);
        self.wait_for(tick, profile);
        if self.is_back {
            self.go_back(tick.counts, profile);
        } else {
            self.approach(tick, driven > 0, profile);
        }
        if self.is_over() {
            return true;
        }
        if tick.counts.unsigned_abs() > self.travel {
            self.found.ended = HomeEnd::Travel;
        } else if driven >= self.ticks {
            self.found.ended = HomeEnd::Time;
        }
        self.is_over()
    }

    /// Takes a tick on the way to the stop.
    fn approach(&mut self, tick: &Tick, is_driven: bool, profile: &mut Profile) {
        // The place of the arming is zero.
        (self.found.moved, self.found.effort) = (tick.counts, tick.v_applied);
        let ahead = self.sense.sign() * tick.counts;
        let is_pushing = is_driven && tick.v_applied * self.sense.sign() as f32 >= self.pushing;
        if !is_pushing || ahead > self.farthest || ahead < self.farthest - FLICKER {
            (self.farthest, self.held) = (ahead, 0);
            return;
        }
        self.held = self.held.saturating_add(1);
        if self.held >= self.quiet {
            (self.is_back, self.waits) = (true, false);
            self.found.touches = self.found.touches.saturating_add(1);
            profile.start_at(Position::from_counts(tick.counts), 0.0);
            profile.aim(self.target());
        }
    }

    /// Holds the set point if it is too far from the joint.
    fn wait_for(&mut self, tick: &Tick, profile: &mut Profile) {
        let is_far = tick.setpoint().position.counts.abs_diff(tick.counts) > self.lead;
        if is_far && !self.waits {
            // Not braked within the limits of a move, which would lead it on.
            let here = profile.setpoint().position;
            profile.start_at(here, 0.0);
            profile.aim(here);
        } else if !is_far && self.waits {
            profile.aim(self.target());
        }
        self.waits = is_far;
    }

    /// Returns where the set point goes: beyond the stop, or back from the last place.
    const fn target(&self) -> Position {
        let counts = if self.is_back {
            self.found.moved - self.sense.sign() * self.retreat
        } else {
            self.sense.sign() * 2 * self.travel as i32
        };
        Position::from_counts(counts)
    }

    /// Takes a tick on the way back from a place. With half of it counted, the place is compared
    /// with the one before.
    fn go_back(&mut self, counts: i32, profile: &mut Profile) {
        let place = self.found.moved;
        let back = self.sense.sign() * (place - counts);
        let agrees = (self.retreat / AGREES).max(AGREES_COUNTS);
        if back < -agrees {
            // What held it has given way.
            (self.is_back, self.before) = (false, None);
        } else if back >= self.retreat / 2 {
            match self.before.replace(place) {
                Some(before) if before.abs_diff(place) <= agrees.unsigned_abs() => {
                    self.found.ended = HomeEnd::Stop;
                }
                _ => self.is_back = false,
            }
        }
        if !self.is_back {
            (self.farthest, self.held) = (self.sense.sign() * counts, 0);
            self.waits = false;
            profile.aim(self.target());
        }
    }

    /// Returns whether the homing has ended by itself.
    pub(crate) const fn is_over(&self) -> bool {
        !matches!(self.found.ended, HomeEnd::Not)
    }

    /// Returns what the homing has found so far.
    pub(crate) const fn found(&self) -> &HomeFindings {
        &self.found
    }
}
