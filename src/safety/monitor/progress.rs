//! Effort beyond any friction, and the encoder counts too little in its direction.
//!
//! ```text
//! v    += g |u| h                         while v < 0: a joint is braked, friction helps
//! v    += (g (|u| - F) - v / T) h         then; u: effort, F: stall_v
//! due  += v h                             g: progress_gain, T = 0.2 s
//! made += travel in the direction of u
//! path += travel without its sign
//! ```
//!
//! `v` and `due` are speed and travel of the weakest joint that the file allows: it has the gain
//! `g`, a mechanical time constant of 0.2 s, and the friction F. All sums start anew when the
//! effort falls to F or changes its sign, and after each judgement that a joint passes: `due`
//! exceeds 64 counts and the play, or `path` exceeds twice its limit. Trips in two cases:
//!
//! - `due` exceeds 64 counts and the play, and `made` is less than a quarter of what exceeds the
//!   play: the counts are too few.
//! - `path` exceeds 32 counts and twice the play, and `made` is less than half of it: the counts
//!   go to and fro.
//!
//! If the joint still moves against a new effort, `v` starts at one and a half times the joint's
//! speed against the effort, and is no more than that while the joint brakes. So braking is in none
//! of the sums.
//!
//! [`super::stall`] and [`super::stall_impulse`] accept counts in any direction as a sign of a
//! working encoder. An open line picks up noise, and its counts go to and fro. This monitor
//! requires counts in the direction of the effort, and as many as the effort causes. With an
//! encoder on either side of a gear, it uses that of the motor, which the gear holds within its
//! twist of the load: `play_deg` is then that twist. A gear that is wound up further throws its
//! motor back against any effort, so `path` is then judged beyond 32 counts and twice the larger of
//! `play_deg` and the largest twist since the sums began.
//!
//! Guarantees: under an effort above F, an encoder whose error stays within n counts is detected
//! before the weakest joint has moved the larger of 64 and 4 n counts, plus one tick, if it starts
//! at rest. If it breaks in motion, one judgement more may pass.
//!
//! Does badly: efforts up to F are not judged; [`super::net_travel`] judges their mean. An effort
//! that keeps changing its sign starts anew each time. Noise in the measured speed delays the
//! start. Three joints trip although their encoders work: one with less than a quarter of `g`; one
//! of four times `g`, as derived from its file, with a time constant below 12 ms; and one with the
//! encoder on the load behind more than 64 counts of play beyond `play_deg`.

use super::limits::{Limits, Units};

/// Travel that is due before it is judged, counts: four times the counts to and fro of an input
/// that picks up noise of 16 counts.
const LEAST: f32 = 64.0;

/// Path that is judged, counts: half of it is the noise of 16 counts.
const LEAST_PATH: i32 = 32;

/// Fewest ticks in a row with effort of one sign that are judged. A loop that swings at a quarter
/// of its sample rate changes the sign every two ticks. Its speed can then be measured neither by
/// regression nor by the travel.
const LEAST_TICKS: u32 = 4;

/// Part of the due travel that the joint has to make.
const SHARE: f32 = 0.25;

/// Mechanical time constant of the weakest joint, s: after it the due speed no longer rises.
const TIME: f32 = 0.2;

/// Multiple of its speed against the effort with which a joint starts: it is still braked when the
/// friction is at its least.
const AGAINST: f32 = 1.5;

/// Monitor that detects too few counts under an effort beyond any friction. It compares the travel
/// in the direction of the effort with the due travel: that of the weakest joint.
#[derive(Clone, Copy, Debug)]
pub(super) struct Progress {
    /// Effort up to which nothing is judged, F, codes.
    friction: i32,
    /// Acceleration of the weakest joint for each code, counts per tick and tick.
    gain: f32,
    /// Share of the due speed that is left after a tick.
    decay: f32,
    /// Counts per tick for each deg/s.
    per_speed: f32,
    /// Due travel that is judged, counts: [`LEAST`] beyond the play.
    due: f32,
    /// Path that is judged, counts.
    path: i32,
    /// Path that a twist of 1 deg explains, counts.
    #[cfg(feature = "two-encoders")]
    path_per_twist: f32,
}

/// Sums of the travel due and of the travel made.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct ProgressState {
    /// Sign of the effort; zero if the effort was within the friction.
    sign: i32,
    ticks: u32,
    /// Due speed, v, counts per tick.
    speed: f32,
    /// Due travel, counts.
    due: f32,
    /// Travel in the direction of the effort, counts.
    made: i32,
    /// Travel without its sign, counts.
    path: i32,
    /// Largest twist between two encoders since the sums began, without its sign, deg.
    #[cfg(feature = "two-encoders")]
    twist: f32,
}

impl Progress {
    pub fn new(limits: &Limits, units: &Units) -> Self {
        let per_speed = units.tick / units.count;
        // Disabled together with the stall monitor.
        let is_on = limits.progress_gain > 0.0 && limits.stall_effort > 0.0;
        Self {
            friction: if is_on { (limits.stall_effort / units.code) as i32 } else { i32::MAX },
            gain: limits.progress_gain * units.code * units.tick * per_speed,
            decay: (1.0 - units.tick / TIME).max(0.0),
            per_speed,
            due: LEAST + limits.play / units.count,
            path: LEAST_PATH.saturating_add((2.0 * limits.play / units.count) as i32),
            #[cfg(feature = "two-encoders")]
            path_per_twist: 2.0 / units.count,
        }
    }

    /// Updates the sums with the code that was applied in the last tick, the travel in it (counts),
    /// the measured speed (deg/s), and the twist of the gear (deg; zero with one encoder). Returns
    /// whether the monitor trips.
    #[inline]
    pub fn check(
        &self,
        state: &mut ProgressState,
        code: i32,
        travel: i32,
        velocity: f32,
        #[cfg_attr(not(feature = "two-encoders"), expect(unused_variables))] twist: f32,
    ) -> bool {
        // Neither a code nor the travel of a tick has the size of 2^31.
        let size = code.wrapping_abs();
        let excess = size.wrapping_sub(self.friction);
        if excess <= 0 {
            state.sign = 0;
            return false;
        }
        let sign = code.signum();
        if sign != state.sign {
            *state = ProgressState { sign, speed: f32::MIN, ..ProgressState::default() };
        }
        #[cfg(feature = "two-encoders")]
        {
            state.twist = state.twist.max(twist.abs());
        }
        let made = if sign < 0 { travel.wrapping_neg() } else { travel };
        if state.speed < 0.0 {
            // The regression is late; the travel of a tick is coarse. The joint goes no faster
            // against the effort than it is seen to go.
            let with = (velocity * self.per_speed * sign as f32).min(made as f32);
            state.speed = state.speed.max(AGAINST * with.min(0.0));
        }
        state.ticks += 1;
        if state.speed < 0.0 {
            // Friction helps the effort to brake.
            state.speed += size as f32 * self.gain;
            return false;
        }
        state.speed = state.speed * self.decay + excess as f32 * self.gain;
        state.due += state.speed;
        state.made = state.made.saturating_add(made);
        state.path = state.path.saturating_add(travel.wrapping_abs());
        let is_due = state.due > self.due || state.path > self.path;
        is_due && state.ticks >= LEAST_TICKS && self.judge(state)
    }

    /// Returns the limit of the path, counts: that of the twist, if it is larger.
    #[cfg(feature = "two-encoders")]
    fn path_of(&self, state: &ProgressState) -> i32 {
        let of_twist = (self.path_per_twist * state.twist) as i32;
        self.path.max(LEAST_PATH.saturating_add(of_twist))
    }

    /// Returns the limit of the path, counts.
    #[cfg(not(feature = "two-encoders"))]
    const fn path_of(&self, _: &ProgressState) -> i32 {
        self.path
    }

    /// Judges the travel made, and returns whether the monitor trips. The sums restart after a
    /// joint has passed, so that earlier travel is no credit for an encoder that breaks now.
    #[cold]
    #[inline(never)]
    fn judge(&self, state: &mut ProgressState) -> bool {
        let is_due = state.due > self.due;
        let too_few = is_due && (state.made as f32) < SHARE * (state.due - self.due + LEAST);
        let path = self.path_of(state);
        let to_and_fro = state.path > path && state.made < state.path >> 1;
        let trips = too_few || to_and_fro;
        if !trips && (is_due || state.path >> 1 > path) {
            (state.ticks, state.due, state.made, state.path) = (0, 0.0, 0, 0);
            #[cfg(feature = "two-encoders")]
            {
                state.twist = 0.0;
            }
        }
        trips
    }
}
