//! Effort that may move the joint and shows no count: the encoder has to prove itself.
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
//! a joint may rest for ever, and an encoder that is dead shows the same. The probe raises the
//! effort beyond B_h in its own direction, so it never lets a load go. An effort under which the
//! joint rested while its encoder was alive needs no second proof at that place, 64 counts to each
//! side.
//!
//! No probe begins while the error is at most `probe_error_deg`, or while the loop is open. A law
//! whose effort turns ends the probe; what was silent stays.
//!
//! Guarantees: where B_l is the lowest breakaway effort of the joint or less, no effort drives a
//! joint with a silent encoder for longer than the times above, in all.
//!
//! Does badly: each probe moves a joint that rests by a few counts towards where its effort pushes.
//! A joint that is blocked fails the probe. Within `probe_error_deg` a silent encoder stays unseen:
//! gains that ask for more than B_l there drive the joint without an end. So does noise of two
//! counts, which is a proof.

use super::limits::{Limits, Units};

/// Time for which the lowest breakaway effort may be exceeded by itself, s: that of the impulse of
/// a stall.
const IMPULSE_TIME: f32 = 0.5;

/// Longest time without a count, s.
const LONGEST: f32 = 2.0;

/// Time in which the effort of a probe rises, s: slow enough that a joint that breaks away on the
/// way shows its counts before it is fast.
const RISE: f32 = 0.4;

/// Counts in the direction of the effort that are a proof.
const PROOF: i32 = 2;

/// Shortest and longest time that a probe is held, s. A transmission winds up for a tenth of a
/// second.
const HELD: [f32; 2] = [0.1, 1.0];

/// Longest time for which a probe takes up play, s.
const LONGEST_PLAY: f32 = 10.0;

/// Distance from the place of a proof up to which it counts, counts.
const NEAR: u32 = 64;

/// The probe of the encoder and its limits, in codes and ticks.
#[derive(Clone, Copy, Debug)]
pub(super) struct EncoderProbe {
    lowest: u32,
    /// The largest excess over it that is added.
    most: u32,
    /// The effort of a probe, and what it rises by in a tick.
    full: i32,
    step: i32,
    /// The effort from which a probe counts as held: rounding and a supply that sags take some.
    held_from: u32,
    held: u32,
    /// Codes times ticks.
    impulse: u32,
    longest: u32,
    /// Counts.
    error: u32,
}

/// The effort without counts so far, and the probe.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct EncoderProbeState {
    /// Codes times ticks, and ticks.
    silent: u32,
    ticks: u32,
    /// Where the encoder last showed that it lives, counts.
    anchor: i32,
    /// The least code of the next tick, with its sign; zero: no probe runs.
    probe: i32,
    /// The code with which the probe began, and the ticks for which it has been held.
    begun: i32,
    held: u32,
    /// The code under which the joint rests at a place, with its sign; zero: none is known.
    rested: i32,
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

    /// Takes the position (counts), armed or not. Returns whether it shows that the encoder lives.
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

    /// Takes the code that is about to be applied, the position (counts) and the error (counts;
    /// zero if the loop is open). Returns whether a probe has ended without a proof.
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

    /// Goes on with a probe.
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

    /// Returns the state that arming begins with: no probe runs, and what was silent stays.
    pub const fn armed(self) -> Self {
        Self { probe: 0, begun: 0, held: 0, rested: 0, ..self }
    }

    /// Returns the same effort where it has `ratio` times as many codes and ticks.
    pub fn scaled(self, ratio: f32) -> Self {
        Self { silent: (self.silent as f32 * ratio) as u32, ..self.armed() }
    }
}
