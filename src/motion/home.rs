//! Homing: the joint goes slowly one way until it finds a place of known position.
//!
//! # To a hard stop
//!
//! The joint goes until it is blocked, goes back a little, and does so again. Two places that agree
//! are the stop.
//!
//! ```text
//! set point ---- a profile at the homing speed, one way, farther than the travel ---->
//! loop      ---- closed, with its own law; the effort is bounded by `effort` ---->
//! joint     ---- follows ----------------| blocked: no farther for `quiet` at that effort
//!                       <----------------| back, until half of `retreat` is counted
//!                       ---------------->| blocked again: at the same place, within `agrees`
//!                       <----------------| back, and into the range: the output goes off
//! ```
//!
//! The joint is blocked when, for `quiet` ticks in a row, the effort in the sense of the homing is
//! at its bound and no count is farther than those before. `quiet` is at least 0.2 s, the time of 8
//! counts at the homing speed, and the time `sqrt(2 q / (g (effort - F)))` in which the weakest
//! joint makes its first count: `q` is a count, `g` `limits.progress_gain_deg_per_s2_per_v`, `F`
//! `limits.breakaway_v`. Ticks of the soft start do not count, since it bounds the effort as well.
//! If the places do not agree, the second becomes the first of another pair.
//!
//! An encoder that dies on the way looks like a stop. It shows no counts on the way back, so that
//! the stall monitors or the time bound end the homing. An encoder that counts again later has lost
//! counts, so that the places do not agree. The monitor of an abrupt stop is off on the way to the
//! hard stop, which it would report.
//!
//! The effort lies between `F + 0.3 (S - F)` and `F + 0.9 (S - F)`, where `S` is `limits.stall_v`.
//! Below this range, the probe of the encoder would not see that the joint is held
//! ([`encoder_probe`](crate::safety::monitor)); above it, a hard stop would be a stall at once.
//!
//! A blocked joint, or one that sets out slowly under this small effort, falls behind the set
//! point. Once the effort is at its bound, the set point waits at three quarters of
//! `limits.following_error_deg`, so that a stiff loop does not trip.
//!
//! Guarantees: the effort is never more than `effort` and half a code. The homing ends when the
//! joint is `travel` away from its start, plus the travel of one tick, and at the latest after
//! `time` and the soft start; a joint that still moves then coasts. A reference is set only by two
//! places that agree, with counts on the way back from each. The range of positions is not
//! monitored, since the position is not known yet.
//!
//! Does badly: anything that holds the joint twice at the same place counts as a stop: a cable, a
//! place with more friction. Counts that are lost slowly on the last way back shift the position,
//! as in every later motion. The position is that of the loaded stop: a gear gives way by `effort`
//! over its stiffness, and an encoder on the motor counts its slack. If a load uses up a part of
//! `effort`, only the rest presses against the stop. A law that builds up its effort slowly ends in
//! a stall. If the supply is too low for the effort, the time bound ends the homing.
//!
//! # To a switch
//!
//! ```text
//! switch    ____________________|~~~~~~~~~~~~~~~~~
//! joint     -------------------------->|            at the homing speed, until it is at the switch
//!                    <-----------------|            back, until the switch has let go of it
//!                    ---------->|                   at a quarter of the speed
//!           <-------------------|                   back, and into the range
//! ```
//!
//! The place is the edge of the switch (`home/switch.rs`) on the second, slow way. It is the
//! reference if it agrees with the place before: within the tolerance of a stop and the travel of a
//! tick at the homing speed. A joint that is at the switch already goes back first, and then finds
//! two edges. A joint that is still at the switch at the end of its travel or time ends as such:
//! the contact or its wire has failed. A joint that is blocked on the way does not go on. The
//! monitor of an abrupt stop stays on.
//!
//! A hysteresis of the switch does not matter: both edges are on ways towards it.
//!
//! Does badly: the edge is known to the travel of a tick at a quarter of the speed, and as well as
//! the switch repeats. A switch that bounces for longer than its filter can shift it by the travel
//! of the bounces. A normally open contact with a cut wire never comes.
//!
//! # To the index
//!
//! The place is that of the first pass in the sense of the homing, or of the first one on the way
//! back from the edge of a switch. The joint has moved from its start, or back from the edge, by
//! more than 2 counts then.
//!
//! With two encoders, the index is that of the motor, and the place the position of the load at its
//! pass: the load's count of the last tick, and the travel of the motor since then. The load itself
//! has moved by more than 8 counts, so that the gear is pressed to one side. A pass after a missing
//! answer of an absolute encoder does not count. Does badly: the place repeats to the change of the
//! gear's wind-up, friction and load over stiffness.

mod switch;

use serde::{Deserialize, Serialize};

use crate::control::controller::ControllerConfig;
use crate::control::device_config::{DeviceConfig, HomeSwitch};
use crate::control::profile::{MoveLimits, Profile, ProfileLimits};
use crate::control::signal::Tick;
use crate::motion::jog::{JogBounds, TELLING};
use crate::safety::monitor::Limits;
use crate::units::error::{HUGE, InvalidValue, above, between};
use crate::units::position::Position;
use crate::units::value::{Key, Scalar as _, Table as _, key};
use switch::SwitchFilter;

/// Value numbers of the bounds, by which a refusal names them.
pub(crate) const EFFORT: Key = Key(0x060C);
pub(crate) const TRAVEL: Key = Key(0x060D);
pub(crate) const SPEED: Key = Key(0x060E);
pub(crate) const TIME: Key = Key(0x060F);
/// Key of the switch, without which a homing to it is refused.
const SWITCH: Key = key(DeviceConfig::ABOUT, "home_switch");
/// Key of the index, without which a homing to it is refused.
const INDEX: Key = key(DeviceConfig::ABOUT, "index_counts");

/// Default travel if there is no range of positions, deg: a turn.
const TURN_DEG: f32 = 360.0;
/// Default travel, in ranges of positions.
const OF_RANGE: f32 = 1.1;
/// The largest travel, deg: two turns.
const FARTHEST_DEG: f32 = 720.0;
/// Part of the default time for the travel, in times of the travel at the homing speed.
const OF_TRAVEL: f32 = 1.5;
/// Part of the default time for the ways back, in times of one way back at the homing speed.
const OF_RETREAT: f32 = 4.0;
/// Part of the default time for accelerations and the time at the stop, s.
const ADDED_S: f32 = 5.0;
/// The longest time, s.
const LONGEST_S: f32 = 1800.0;
/// Least time at the stop, s: friction stops a joint in less ([`super::jog`]).
const QUIET_S: f32 = 0.2;
/// Least time at the stop: the time of this number of counts at the homing speed.
const QUIET_COUNTS: f32 = 8.0;
/// Least way back and least travel, counts: half of the way back, which is judged, is twice the
/// noise of 16 counts that an open line picks up.
const RETREAT_COUNTS: f32 = 64.0;
/// The longest way back, deg: places that are farther from each other than a sixteenth of the way
/// back do not agree.
const RETREAT_DEG: f32 = 2.0;
/// The error at which the set point waits, as a share of the limit of the following error.
const WAITS: f32 = 0.75;
/// Places agree if they are no farther apart than the way back over this divisor, or than this
/// number of counts: twice what a joint at rest may show. Two places that are no stop are half of
/// the way back apart.
const AGREES: i32 = 16;
const AGREES_COUNTS: i32 = 8;
/// Bounds of the effort, as shares of the span from `breakaway_v` to `stall_v`. The probe of the
/// encoder assumes a held joint from a quarter of that span on.
const WEAKEST: f32 = 0.3;
const STRONGEST: f32 = 0.9;
/// Tolerated flicker, counts: twice that of an encoder on an edge, or with a wire cut.
const FLICKER: i32 = 2;
/// Largest reduction of an effort at its bound by rounding, codes.
const PUSHING: f32 = 1.5;
/// Factor on a quotient of decimals that should be whole, and can be a little above it.
const ROUNDING: f32 = 1.0 - 1e-5;
/// The speed of the second way to a switch, as a share of that of the homing.
const SLOW: f32 = 0.25;

/// The place that a homing looks for.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum HomeTarget {
    /// A hard stop that blocks the joint.
    #[default]
    Stop,
    /// The edge of a switch.
    Switch,
    /// The first pass of the encoder's index.
    Index,
    /// The first pass of the encoder's index on the way back from the edge of a switch.
    SwitchIndex,
}

impl HomeTarget {
    const fn has_switch(self) -> bool {
        matches!(self, Self::Switch | Self::SwitchIndex)
    }

    const fn has_index(self) -> bool {
        matches!(self, Self::Index | Self::SwitchIndex)
    }
}

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

/// Homing that a client requests.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct HomeRequest {
    /// Sense of the motion towards the place.
    pub sense: Sense,
    /// Position of the joint at the place, counts.
    pub at: i32,
    /// Largest effort, V. Default: that of `[jog]`, limited to the range for a homing.
    pub effort: Option<f32>,
    /// Largest distance from where the joint was armed, deg. Default: 1.1 times the range of
    /// positions, or a turn without one.
    pub travel: Option<f32>,
    /// Speed, deg/s. Default: that of `[jog]`, and no more than that of `[profile]`.
    pub speed: Option<f32>,
    /// Longest time after the soft start, s. Default: the sum of 1.5 times that of the travel, four
    /// times that of the way back, and 5 s. To a switch, 16 times that of the way back.
    pub time: Option<f32>,
    /// The place to look for.
    pub to: HomeTarget,
}

/// What ended a homing.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum HomeEnd {
    /// The homing has not ended at a place or a bound.
    #[default]
    Not,
    /// The stop was found twice, and the joint has left it: the joint is referenced.
    Stop,
    /// The joint exceeded the travel bound, and found no stop.
    Travel,
    /// The time ran out.
    Time,
    /// The edge of the switch was found twice, and the joint has left it: the joint is referenced.
    Switch,
    /// The joint was still at the switch at the end of the travel or of the time.
    SwitchStuck,
    /// The joint was blocked on its way, or its encoder does not count.
    Blocked,
    /// The index was found, and the joint has left it: the joint is referenced.
    Index,
}

impl HomeEnd {
    /// Returns whether the homing has found its place.
    pub const fn is_found(self) -> bool {
        matches!(self, Self::Stop | Self::Switch | Self::Index)
    }
}

/// Findings of a homing.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct HomeFindings {
    /// What ended it.
    pub ended: HomeEnd,
    /// Travel from the start of the homing to the place, or to the last position on the way there,
    /// counts.
    pub moved: i32,
    /// Effort in that position, V.
    pub effort: f32,
    /// Number of times that the joint was blocked, or came to the switch.
    pub touches: u8,
    /// Way from the edge of the switch to the index, counts; 0 without both.
    pub from_switch: i32,
}

/// A homing that is prepared for a loop.
#[derive(Clone, Debug, PartialEq)]
pub struct Home {
    /// The set point: a move that would go on beyond the travel.
    pub(crate) profile: Profile,
    /// The watch that ends the homing.
    pub(crate) watch: HomeWatch,
}

/// The watch that looks for a place while a profile runs, with its state.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct HomeWatch {
    sense: Sense,
    at: i32,
    /// Largest effort, V, and the effort from which on the effort counts as at that bound, V.
    effort: f32,
    pushing: f32,
    /// Largest distance, counts.
    travel: u32,
    /// Longest time after the soft start, ticks.
    ticks: u32,
    /// Time for which a blocked joint is held, ticks.
    quiet: u32,
    /// Way back from the place, counts.
    retreat: i32,
    /// Way back from the place at whose end the homing is over, counts.
    leave: i32,
    /// Ticks of the soft start that were left at the start of the homing.
    wait: u32,
    elapsed: u32,
    /// Largest lead of the set point over a joint that gets the largest effort, counts.
    lead: i32,
    /// Whether the set point waits for the joint.
    waits: bool,
    /// Whether the last tick had the largest effort the way that the joint is to go.
    at_bound: bool,
    /// Whether the joint is on its way back.
    is_back: bool,
    /// Whether the last two places agree: the joint is on its way into the range.
    agrees: bool,
    /// The farthest count in the sense of the homing since the joint last went the other way.
    farthest: i32,
    /// Number of ticks for which the effort has been at its bound without a farther count.
    held: u32,
    /// Previous place, counts; none: no place yet.
    before: Option<i32>,
    /// Largest distance of two places that agree, counts.
    agreement: i32,
    to: HomeTarget,
    /// Pass of the index since the last tick.
    pass: Option<IndexPass>,
    /// First pass of the index behind the last edge of the switch.
    behind: Option<IndexPass>,
    /// Place of the index once it has been found, counts of its encoder since power-on.
    index: Option<i32>,
    /// Distance from start or edge beyond which a pass counts, counts.
    shows: i32,
    /// The switch that the homing looks for; none: a stop or an index.
    switch: Option<SwitchFilter>,
    /// Limits of the set point on the second way to a switch.
    slow: MoveLimits,
    found: HomeFindings,
}

/// A pass of the index.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct IndexPass {
    /// Position of the joint, counts.
    pub position: i32,
    /// Way of the joint that is known without the motor, counts: of two encoders, that of the load
    /// in the last tick.
    pub way: i32,
    /// Place of the index, counts of its encoder since power-on.
    pub place: i32,
}

impl Home {
    /// Prepares a homing within the bounds that a client requests.
    ///
    /// # Errors
    /// Returns an error that names the invalid bound: an effort near `limits.breakaway_v` or
    /// `limits.stall_v`, or beyond the drive; a speed of more than `[profile]`; a travel of less
    /// than 64 counts or of more than two turns; a time of more than half an hour. For a homing to
    /// a switch, `device.home_switch` is invalid if there is none.
    pub fn new(
        asked: &HomeRequest,
        controller: &ControllerConfig,
        limits: &Limits,
        profile_limits: &ProfileLimits,
        jog: &JogBounds,
        device: &DeviceConfig,
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
        let speed = asked.speed.unwrap_or(jog.speed.min(profile_limits.velocity));
        between(EFFORT, effort, weakest, strongest)?;
        above(EFFORT, effort, 0.0, strongest)?;
        between(TRAVEL, travel, least, farthest)?;
        above(SPEED, speed, 0.0, profile_limits.velocity.min(HUGE))?;
        // The conversions saturate. The target of the profile is twice as far as the travel, and
        // has to be nearer than 2^30 counts.
        let counts = |deg: f32| (deg / count).min(((1 << 29) - 64) as f32) as i32;
        let travel = counts(travel);
        let retreat = counts(jog.travel.min(RETREAT_DEG).max(least)).min(travel);
        let lead = if limits.following_error > 0.0 {
            // The set point goes on for two ticks before it is held.
            counts((WAITS * limits.following_error - 2.0 * speed * tick).max(0.0))
        } else {
            i32::MAX
        };
        let (sign, end) = match asked.sense {
            Sense::Plus => (1, limits.position_max),
            Sense::Minus => (-1, limits.position_min),
        };
        let outside = if range > 0.0 {
            asked.at.saturating_sub(counts(end)).saturating_mul(sign).max(0)
        } else {
            0
        };
        let leave = outside.saturating_add(retreat / 2).min(travel);
        let ticks = |s: f32| (libm::roundf(s / tick) as u32).max(2);
        let filter = libm::ceilf(device.home_switch_filter / tick * ROUNDING) as u32;
        let (switch, slowest) = if asked.to.has_switch() {
            let kind = device.home_switch;
            let last = HomeSwitch::NormallyOpen.number();
            between(SWITCH, kind.number(), HomeSwitch::NormallyClosed.number(), last)?;
            (SwitchFilter::of(kind, filter), SLOW * speed)
        } else {
            (None, speed)
        };
        let to_index = if asked.to.has_index() {
            above(INDEX, device.index_counts as f32, 0.0, HUGE)?;
            let of_index = controller.motor.count().unwrap_or(count);
            device.index_counts as f32 * of_index / count
        } else {
            0.0
        };
        // From the first edge on, a homing to a switch is slow.
        let slower = speed / slowest;
        let back = retreat as f32 * OF_RETREAT + leave as f32;
        let way = (travel as f32 + to_index * slower) * OF_TRAVEL + back * slower;
        let time = asked.time.unwrap_or((way * count / speed + ADDED_S).min(LONGEST_S));
        above(TIME, time, 0.0, LONGEST_S)?;
        let gain = limits.progress_gain * (effort - friction);
        let first = if gain > 0.0 { libm::sqrtf(2.0 * count / gain) } else { 0.0 };
        let target = Position::from_counts(asked.sense.sign() * 2 * travel);
        let of_speed =
            |velocity| ProfileLimits { velocity, ..*profile_limits }.nearest(tick, count);
        let profile = Profile::new(target, &of_speed(speed), tick, count)?;
        // An edge is known to the travel of a tick.
        let blurred = if switch.is_some() { counts(speed * tick) } else { 0 };
        let agreement = (retreat / AGREES).max(AGREES_COUNTS).saturating_add(blurred);
        // A load at rest may show less beside a motor that takes up the slack.
        let has_two = controller.motor.count().is_some();
        let shows = if has_two { TELLING as i32 } else { FLICKER };
        let watch = HomeWatch {
            sense: asked.sense,
            at: asked.at,
            effort,
            pushing: effort - PUSHING * controller.drive.lsb,
            travel: travel.unsigned_abs(),
            ticks: ticks(time),
            quiet: ticks(QUIET_S.max(QUIET_COUNTS * count / slowest).max(first)),
            retreat,
            leave,
            wait: 0,
            elapsed: 0,
            lead,
            waits: false,
            at_bound: false,
            is_back: false,
            agrees: false,
            farthest: 0,
            held: 0,
            before: None,
            agreement,
            to: asked.to,
            pass: None,
            behind: None,
            index: None,
            shows,
            switch,
            slow: Profile::limits(&of_speed(slowest), tick, count)?,
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

    /// Returns whether the joint is to come to a hard stop.
    pub(crate) const fn expects_stop(&self) -> bool {
        matches!(self.to, HomeTarget::Stop)
    }

    /// Takes a pass of the index for the next tick.
    pub(crate) const fn pass_index(&mut self, pass: IndexPass) {
        self.pass = Some(pass);
    }

    /// Returns the place of the index if the homing has found it, counts of its encoder since
    /// power-on.
    pub(crate) const fn index(&self) -> Option<i32> {
        self.index
    }

    /// Returns the position of the joint at the place, counts.
    pub(crate) const fn at(&self) -> i32 {
        self.at
    }

    /// Returns the position in which the homing ends at the earliest, counts.
    pub(crate) const fn leaves_at(&self) -> i32 {
        self.at.wrapping_sub(self.sense.sign() * self.leave)
    }

    /// Restarts the watch, with the joint at rest at zero and `wait` ticks of the soft start left.
    pub(crate) fn restart(&mut self, wait: u32) {
        (self.wait, self.elapsed) = (wait, 0);
        (self.is_back, self.farthest, self.held, self.before) = (false, 0, 0, None);
        (self.waits, self.at_bound, self.agrees) = (false, false, false);
        (self.pass, self.behind, self.index) = (None, None, None);
        self.found = HomeFindings::default();
        if let Some(switch) = &mut self.switch {
            switch.restart();
        }
    }

    /// Evaluates a tick with the level of the switch's input at its start, turns the profile's set
    /// point at the place and after the way back, and returns whether the homing has ended.
    #[inline(never)]
    pub(crate) fn ends(&mut self, tick: &Tick, is_high: bool, profile: &mut Profile) -> bool {
        self.elapsed = self.elapsed.saturating_add(1);
        let driven = self.elapsed.saturating_sub(self.wait);
        self.wait_for(tick, driven > 0, profile);
        let edge = self.switch.as_mut().and_then(|switch| switch.update(is_high, tick.counts));
        let pass = self.pass.take().filter(|_| self.to.has_index());
        let ahead = |pass: &IndexPass| self.sense.sign() * pass.way > self.shows;
        if self.is_back {
            self.go_back(tick.counts, pass, profile);
        } else if let (HomeTarget::Index, Some(pass)) = (self.to, pass.filter(ahead)) {
            (self.found.moved, self.found.effort) = (pass.position, tick.v_applied);
            (self.agrees, self.index) = (true, Some(pass.place));
            self.turn(profile);
        } else if let Some(edge) = edge {
            (self.found.moved, self.found.effort) = (edge, tick.v_applied);
            self.turn(profile);
        } else {
            self.approach(tick, driven > 0, profile);
        }
        if self.is_over() {
            return true;
        }
        let is_stuck = self.is_back && self.switch.is_some_and(|switch| switch.is_at());
        if tick.counts.unsigned_abs() > self.travel {
            self.found.ended = if is_stuck { HomeEnd::SwitchStuck } else { HomeEnd::Travel };
        } else if driven >= self.ticks {
            self.found.ended = if is_stuck { HomeEnd::SwitchStuck } else { HomeEnd::Time };
        }
        self.is_over()
    }

    /// Turns at a place.
    fn turn(&mut self, profile: &mut Profile) {
        (self.is_back, self.waits, self.behind) = (true, false, None);
        self.found.touches = self.found.touches.saturating_add(1);
        profile.aim(self.target());
    }

    /// Evaluates a tick on the way to the place.
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
        if self.held >= self.quiet && !self.expects_stop() {
            self.found.ended = HomeEnd::Blocked;
        } else if self.held >= self.quiet {
            profile.start_at(Position::from_counts(tick.counts), 0.0);
            self.turn(profile);
        }
    }

    /// Holds the set point if it is too far ahead of a joint that gets the largest effort. With
    /// less, the law needs more of an error to drive the joint on.
    fn wait_for(&mut self, tick: &Tick, is_driven: bool, profile: &mut Profile) {
        let way = if self.is_back { -self.sense.sign() } else { self.sense.sign() };
        let ahead = tick.setpoint().position.counts.wrapping_sub(tick.counts).wrapping_mul(way);
        let at_bound = is_driven && tick.v_applied * way as f32 >= self.pushing;
        // From the second tick on, so that rounding does not take the effort off its bound again.
        let waits = at_bound && self.at_bound && ahead > self.lead;
        self.at_bound = at_bound;
        if waits && !self.waits {
            // The set point stops at once: braking within the limits of a move would carry it
            // farther.
            let here = profile.setpoint().position;
            profile.start_at(here, 0.0);
            profile.aim(here);
        } else if !waits && self.waits {
            profile.aim(self.target());
        }
        self.waits = waits;
    }

    /// Returns the target of the set point: beyond the place, or back from the last one.
    const fn target(&self) -> Position {
        let sign = self.sense.sign();
        let counts = match (self.is_back, self.agrees) {
            (false, _) => sign * 2 * self.travel as i32,
            // Until the switch has let go of the joint.
            (true, false) if self.switch.is_some() => -sign * 2 * self.travel as i32,
            (true, false) => self.found.moved - sign * self.retreat,
            (true, true) if self.seeks_index() => -sign * 2 * self.travel as i32,
            // Beyond the place at which the homing ends, as before.
            (true, true) => self.found.moved - sign * (self.leave + self.retreat / 2),
        };
        Position::from_counts(counts)
    }

    /// Evaluates a tick on the way back from a place. After half of the way, the place is compared
    /// with the previous one. If both agree, the joint goes on until it is within the range.
    fn go_back(&mut self, counts: i32, pass: Option<IndexPass>, profile: &mut Profile) {
        let sign = self.sense.sign();
        // The first pass behind the edge, whether the edges are known to agree by then or not:
        // which turn of the encoder it is must not depend on how far the joint has gone back.
        let behind = |pass: &IndexPass| sign * (self.found.moved - pass.way) > self.shows;
        if let Some(pass) = pass.filter(behind) {
            self.behind.get_or_insert(pass);
        }
        if let (true, true, Some(pass)) = (self.agrees, self.seeks_index(), self.behind) {
            self.found.from_switch = pass.position - self.found.moved;
            (self.found.moved, self.index) = (pass.position, Some(pass.place));
            profile.aim(self.target());
        }
        let place = self.found.moved;
        let back = sign * (place - counts);
        let is_at = self.switch.is_some_and(|switch| switch.may_be_at());
        if back < -self.agreement && self.expects_stop() {
            // The obstacle that held the joint has given way.
            (self.is_back, self.agrees, self.before) = (false, false, None);
        } else if back >= self.retreat / 2 && !is_at && !self.agrees {
            match self.before.replace(place) {
                Some(before) if before.abs_diff(place) <= self.agreement.unsigned_abs() => {
                    self.agrees = true;
                    profile.aim(self.target());
                }
                _ => self.is_back = false,
            }
        }
        if !self.is_back {
            (self.farthest, self.held) = (self.sense.sign() * counts, 0);
            self.waits = false;
            if self.switch.is_some() {
                profile.rest_with(&self.slow, Position::from_counts(counts));
            }
            profile.aim(self.target());
        } else if self.agrees && back >= self.leave && !self.seeks_index() {
            self.found.ended = match self.to {
                HomeTarget::Stop => HomeEnd::Stop,
                HomeTarget::Switch => HomeEnd::Switch,
                HomeTarget::Index | HomeTarget::SwitchIndex => HomeEnd::Index,
            };
        }
    }

    /// Returns whether the index is still to be found.
    const fn seeks_index(&self) -> bool {
        self.to.has_index() && self.index.is_none()
    }

    /// Returns whether the homing has ended at its place or a bound.
    pub(crate) const fn is_over(&self) -> bool {
        !matches!(self.found.ended, HomeEnd::Not)
    }

    /// Returns the findings so far.
    pub(crate) const fn found(&self) -> &HomeFindings {
        &self.found
    }
}
