//! Effort that may move the joint but shows no count: a probe tests whether the encoder works.
//!
//! ```text
//! silent += (|effort| - B_l) h       while |effort| > B_l and no count comes; up to B_h - B_l
//! probe     begins when silent exceeds B_l 0.5 s, or after 2 s
//!           |effort| rises to at least P = B_h + (F - B_h) / 2 within 0.4 s and stays there
//! proof     two counts in the direction of the effort: the probe ends, and the law goes on
//! stall     no proof within T at P
//! T         = sqrt(2 (2 counts) / (g (F - B_h) / 4)), from 0.1 s to 1 s, and the same for the play
//! ```
//!
//! B_l is `breakaway_min_v`, B_h `breakaway_v`, F `stall_v`, g `progress_gain`. Between B_l and B_h
//! a joint may rest forever, and a dead encoder looks the same. The probe raises the effort beyond
//! B_h in the direction of the effort, so it never drops a load. If a probe has shown that the
//! joint rests under an effort while the encoder works, that effort needs no second probe within 64
//! counts of the place.
//!
//! No probe begins while the error is at most `probe_error_deg`, or while the loop is open. If the
//! effort of the law changes its sign, the probe ends; the sum `silent` stays.
//!
//! Guarantees: if B_l is at most the lowest breakaway effort of the joint, no effort drives a joint
//! with a silent encoder for longer than the times above in total.
//!
//! Does badly: each probe moves a resting joint by a few counts in the direction of its effort. A
//! blocked joint fails the probe. Within `probe_error_deg` a silent encoder is not detected: gains
//! that require more than B_l there drive the joint without an end. Noise of two counts passes as a
//! proof, with the same result.

use super::limits::{Limits, Units};

/// Time without a count at twice the lowest breakaway effort after which a probe begins, s: that of
/// the impulse of a stall.
const IMPULSE_TIME: f32 = 0.5;

/// Longest time without a count before a probe begins, s.
const LONGEST: f32 = 2.0;

/// Time in which the effort of a probe rises, s: slow enough that a joint that breaks away on the
/// way shows its counts before it is fast.
const RISE: f32 = 0.4;

/// Counts in the direction of the effort that are a proof.
const PROOF: i32 = 2;

/// Shortest and longest time for which a probe is held, s. A transmission takes a tenth of a second
/// to wind up.
const HELD: [f32; 2] = [0.1, 1.0];

/// Longest time for which a probe takes up play, s.
const LONGEST_PLAY: f32 = 10.0;

/// Distance from the place of a proof within which the proof is valid, counts.
const NEAR: u32 = 64;

/// The probe of the encoder and its limits, in codes and ticks.
#[derive(Clone, Copy, Debug)]
pub(super) struct EncoderProbe {
    lowest: u32,
    /// Largest excess over `lowest` that a tick adds to the sum, codes.
    most: u32,
    /// Full effort of a probe, codes.
    full: i32,
    /// Rise of the effort of a probe in a tick, codes.
    step: i32,
    /// Effort beyond which a probe counts as held, codes. It is less than that of the probe, since
    /// rounding and a sagging supply reduce the effort.
    held_from: u32,
    held: u32,
    /// Largest sum without a probe, codes times ticks.
    impulse: u32,
    longest: u32,
    /// Error up to which no probe begins, counts.
    error: u32,
}

/// Sum of the effort without counts, and the running probe.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct EncoderProbeState {
    /// Sum of the effort without counts, codes times ticks.
    silent: u32,
    /// Ticks that have added to the sum.
    ticks: u32,
    /// Position from which the counts of a proof are measured, counts.
    anchor: i32,
    /// Least code of the next tick, with its sign; zero if no probe runs.
    probe: i32,
    /// Code with which the probe began.
    begun: i32,
    /// Ticks for which the probe has been held.
    held: u32,
    /// Code under which the joint rested before the last proof, with its sign; zero if unknown.
    rested: i32,
    /// Position of that proof, counts.
    place: i32,
}

impl EncoderProbe {
    pub fn new(limits: &Limits, units: &Units) -> Self {
        let Limits { breakaway_min, breakaway_effort, stall_effort, progress_gain, .. } = *limits;
        // Towards zero, as in the impulse of the stall.
        let code = |effort: f32| (effort / units.code) as u32;
        let is_on = stall_effort > 0.0 && breakaway_min > 0.0 && breakaway_min < breakaway_effort;
        let beyond = (stall_effort - breakaway_effort).max(0.0);
        let way = 2.0 * PROOF as f32 * units.count;
        let within = |way: f32| libm::sqrtf(way / (progress_gain * 0.25 * beyond));
        let play =
            if limits.play > 0.0 { within(2.0 * limits.play).min(LONGEST_PLAY) } else { 0.0 };
        let time = within(way).clamp(HELD[0], HELD[1]) + play;
        let full = code(breakaway_effort + 0.5 * beyond).min(i16::MAX as u32) as i32;
        Self {
            lowest: if is_on { code(breakaway_min) } else { u32::MAX },
            most: code(breakaway_effort - breakaway_min).max(1),
            full,
            step: (full as u32 / Units::whole(RISE, units.tick)).max(1) as i32,
            held_from: code(breakaway_effort + 0.25 * beyond).saturating_sub(1),
            held: Units::whole(time, units.tick),
            impulse: Units::threshold(breakaway_min * IMPULSE_TIME, units.code * units.tick),
            longest: Units::whole(LONGEST, units.tick),
            error: (limits.probe_error / units.count) as u32,
        }
    }

    /// Updates the state with the position (counts), armed or not. Returns whether the position
    /// shows that the encoder works.
    #[inline]
    pub const fn see(&self, state: &mut EncoderProbeState, position: i32) -> bool {
        if position.wrapping_sub(state.anchor).unsigned_abs() < PROOF.unsigned_abs() {
            return false;
        }
        (state.silent, state.ticks, state.anchor) = (0, 0, position);
        if position.wrapping_sub(state.place).unsigned_abs() > NEAR {
            state.rested = 0;
        }
        true
    }

    /// Updates the state with the code that is about to be applied, the position (counts) and the
    /// error (counts; zero if the loop is open). Returns whether a probe has ended without a proof.
    #[inline]
    pub fn check(
        &self,
        state: &mut EncoderProbeState,
        code: i32,
        position: i32,
        error: i32,
    ) -> bool {
        if state.probe != 0 {
            return self.go_on(state, code, position);
        }
        let size = code.unsigned_abs();
        if self.see(state, position) || size <= self.lowest || error.unsigned_abs() <= self.error {
            return false;
        }
        let has_rested = state.rested.signum() == code.signum();
        let known = if has_rested { state.rested.unsigned_abs() } else { 0 };
        let excess = size.saturating_sub(known.max(self.lowest)).min(self.most);
        state.silent = state.silent.saturating_add(excess);
        state.ticks = state.ticks.saturating_add(u32::from(excess > 0));
        if state.silent > self.impulse || state.ticks > self.longest {
            (state.probe, state.begun, state.held) = (code, code, 0);
            state.anchor = position;
        }
        false
    }

    /// Runs a tick of a probe. Returns whether the probe has ended without a proof.
    #[cold]
    #[inline(never)]
    fn go_on(&self, state: &mut EncoderProbeState, code: i32, position: i32) -> bool {
        let (sign, made) = (state.probe.signum(), state.made(position));
        if made >= PROOF {
            let rested = state.begun;
            *state = EncoderProbeState {
                anchor: position,
                rested,
                place: position,
                ..EncoderProbeState::default()
            };
            return false;
        }
        if made < 0 {
            // A load moves the joint the other way: the counts that prove begin here.
            state.anchor = position;
        }
        if code.wrapping_mul(sign) < 0 {
            state.probe = 0;
            return false;
        }
        let size = (state.probe.wrapping_mul(sign)).saturating_add(self.step).min(self.full);
        state.probe = size.wrapping_mul(sign);
        if size == self.full && code.unsigned_abs() > self.held_from {
            state.held += 1;
        }
        if state.held <= self.held {
            return false;
        }
        *state = EncoderProbeState { anchor: position, ..EncoderProbeState::default() };
        true
    }

    /// Returns the least effort of a tick that begins at a position (counts), codes; zero if that
    /// position proves the encoder.
    pub const fn effort(&self, state: &EncoderProbeState, position: i32) -> i32 {
        if state.made(position) >= PROOF { 0 } else { state.probe }
    }
}

impl EncoderProbeState {
    /// Returns whether a probe runs.
    #[inline]
    pub const fn runs(&self) -> bool {
        self.probe != 0
    }

    /// Returns the travel in the direction of the probe since it began, counts.
    const fn made(&self, position: i32) -> i32 {
        position.wrapping_sub(self.anchor).wrapping_mul(self.probe.signum())
    }

    /// Returns the state at arming: no probe runs, and the sum without counts stays.
    pub const fn armed(self) -> Self {
        Self { probe: 0, begun: 0, held: 0, rested: 0, ..self }
    }

    /// Returns the state in other units, in which the same sum has `ratio` times as many codes
    /// times ticks. No probe runs.
    pub fn scaled(self, ratio: f32) -> Self {
        Self { silent: (self.silent as f32 * ratio) as u32, ..self.armed() }
    }
}
