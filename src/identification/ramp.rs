//! The identification of a joint's friction levels, from a ramp of the effort (thesis section 3.2).
//!
//! ```text
//! effort  ^            _____________
//!         |          /               \         rung n is the effort  n r h,
//!         |        /  moved     hold   \       at most the full scale
//!         |      /                       \ rests
//!         +----/---------------------------\----> ticks
//! ```
//!
//! The effort rises by `r h` a tick (rate `r`, sample time `h`) until the joint has moved. The
//! effort is then held, and falls at the same rate until the joint rests. The stick level is the
//! effort at the first count of the motion, the slip level the effort at the last count before
//! rest. No law runs meanwhile.
//!
//! Why this form: an effort is a whole number of rungs times one constant, so that a ramp of hours
//! is as exact as one of seconds; nothing is added up. A level is reported as its rung, too.
//!
//! Guarantees: the effort is never negative, so the joint is not driven backwards before it is seen
//! to rest. A ramp ends. It ends without any level at the full scale, and without a slip level when
//! a joint without friction coasts for twice the time from the full scale to zero.
//!
//! Does badly: both levels are late. The stick level is high by the rise of the effort until a
//! count is seen. The slip level is low by the lag of the joint's velocity, which can be corrected
//! only if its time constant is known. And nothing bounds the travel: a joint with little viscous
//! friction gathers speed for as long as the effort is held. If the encoder does not count, the
//! effort rises to the full scale before the ramp gives up; the servo's monitors end the ramp
//! sooner.

use crate::units::error::{InvalidValue, between};
use crate::units::value::Key;

/// Value number of a ramp's rate.
pub(crate) const RATE: Key = Key(0x0604);
/// Value number of a ramp's hold time.
pub(crate) const HOLD: Key = Key(0x0605);

/// Distance from its rest position at which a joint has moved, counts: one more than the flicker of
/// an encoder disc on an edge.
const MOVED: u32 = 2;

/// Time without a count after which a joint rests, s.
const QUIET: f32 = 1.0;

/// The length of the longest ramp, ticks: up to the full scale, and down for twice as long. It is
/// some three weeks at 20 ms.
pub const MAX_TICKS: f32 = 1e8;

/// Allowed rounding of a limit, as a fraction of it: a value that a host has accepted in double
/// precision must not be refused.
const ROUNDING: f32 = 1e-6;

/// A ramp up to the motion and down to rest, prepared for its ticks.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ramp {
    /// Effort of a rung, V.
    rung: f32,
    full_scale: f32,
    /// Number of the first rung at the full scale.
    top: u32,
    /// Length of the time at constant effort, ticks.
    hold: u32,
    /// Time without a count after which the joint rests, ticks.
    quiet: u32,
}

/// The rungs of the friction levels that a ramp has found so far.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct RampFindings {
    /// Rung of the first count of the motion; none: the joint did not move.
    pub stick: Option<u32>,
    /// Rung of the last count before rest; none: the joint did not rest.
    pub slip: Option<u32>,
    /// Time from the start of the fall to that last count, ticks.
    pub fall: u32,
}

/// The state of a ramp from tick to tick.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct RampState {
    phase: Phase,
    /// Time since the phase began, ticks.
    elapsed: u32,
    /// Rung of the present effort.
    rung: u32,
    /// Position in which the joint rested at the start, counts.
    start: i32,
    /// Present position of the joint, counts.
    counts: i32,
    /// Rung of the last count.
    counted_at: u32,
    findings: RampFindings,
}

/// The phases of a ramp, in their order.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
enum Phase {
    #[default]
    Rising,
    Holding,
    Falling,
    Over,
}

impl Ramp {
    /// Prepares a ramp of `rate` (V/s), held for `hold` (s) between rise and fall, for a loop of
    /// `sample_time` (s) whose output is at most `full_scale` (V).
    ///
    /// # Errors
    /// Returns an error that names `ramp_rates_v_per_s` unless the full scale is reached in one
    /// tick or more, and in a third of [`MAX_TICKS`] or less; or `hold_s` unless it is from 0 to
    /// [`MAX_TICKS`].
    // Once in the flash: it is called to check and to prepare.
    #[cfg_attr(target_os = "none", inline(never))]
    pub fn new(
        rate: f32,
        hold: f32,
        sample_time: f32,
        full_scale: f32,
    ) -> Result<Self, InvalidValue> {
        let longest = MAX_TICKS * sample_time;
        between(HOLD, hold, 0.0, longest * (1.0 + ROUNDING))?;
        let (slowest, fastest) = (3.0 * full_scale / longest, full_scale / sample_time);
        between(RATE, rate, slowest * (1.0 - ROUNDING), fastest * (1.0 + ROUNDING))?;
        let rung = rate * sample_time;
        Ok(Self {
            rung,
            full_scale,
            top: libm::ceilf(full_scale / rung) as u32,
            hold: libm::roundf(hold / sample_time) as u32,
            quiet: libm::roundf(QUIET / sample_time) as u32,
        })
    }

    /// Returns the effort of a rung, V.
    ///
    /// ```
    /// use stiction::identification::Ramp;
    /// let ramp = Ramp::new(0.25, 10.0, 0.5, 5.0).unwrap();
    /// assert_eq!([0, 1, 39, 40, 41].map(|rung| ramp.volts(rung)), [0.0, 0.125, 4.875, 5.0, 5.0]);
    /// ```
    pub const fn volts(&self, rung: u32) -> f32 {
        let v = rung as f32 * self.rung;
        if v < self.full_scale { v } else { self.full_scale }
    }

    /// Runs one tick with the joint at `counts`, and returns the effort from now on, V.
    pub fn update(&self, state: &mut RampState, counts: i32) -> f32 {
        state.elapsed = state.elapsed.saturating_add(1);
        let distance = counts.wrapping_sub(state.start).unsigned_abs();
        if counts != state.counts {
            state.count(counts, distance);
        }
        match state.phase {
            Phase::Rising if distance >= MOVED => {
                state.findings.stick = state.findings.stick.or(Some(state.rung));
                state.enter(Phase::Holding);
            }
            Phase::Rising if state.rung >= self.top => state.abandon(),
            Phase::Rising => state.rung += 1,
            Phase::Holding if state.elapsed < self.hold => {}
            Phase::Holding => state.enter(Phase::Falling),
            Phase::Falling if state.elapsed.wrapping_sub(state.findings.fall) > self.quiet => {
                state.findings.slip = Some(state.counted_at);
                state.end();
            }
            Phase::Falling if state.elapsed > self.longest_fall() => state.end(),
            Phase::Falling => state.rung = state.rung.saturating_sub(1),
            Phase::Over => {}
        }
        self.volts(state.rung)
    }

    const fn longest_fall(&self) -> u32 {
        self.top.saturating_mul(2).saturating_add(self.quiet)
    }
}

impl RampState {
    /// Returns the state of a ramp that begins with a joint at rest at `counts`.
    pub const fn start(counts: i32) -> Self {
        let findings = RampFindings { stick: None, slip: None, fall: 0 };
        Self {
            phase: Phase::Rising,
            elapsed: 0,
            rung: 0,
            start: counts,
            counts,
            counted_at: 0,
            findings,
        }
    }

    /// Returns whether the ramp has ended. Its effort is zero then.
    pub const fn is_over(&self) -> bool {
        matches!(self.phase, Phase::Over)
    }

    /// Returns the findings so far.
    pub const fn findings(&self) -> RampFindings {
        self.findings
    }

    /// Ends the ramp without a level, because the applied effort is not the requested one.
    pub fn abandon(&mut self) {
        self.findings = RampFindings::default();
        self.end();
    }

    const fn count(&mut self, counts: i32, distance: u32) {
        self.counts = counts;
        self.counted_at = self.rung;
        match self.phase {
            // A disc that was on an edge and is back has not moved.
            Phase::Rising if distance == 0 => self.findings.stick = None,
            Phase::Rising if distance == 1 => self.findings.stick = Some(self.rung),
            Phase::Falling => self.findings.fall = self.elapsed,
            _ => {}
        }
    }

    const fn enter(&mut self, phase: Phase) {
        self.phase = phase;
        self.elapsed = 0;
    }

    const fn end(&mut self) {
        self.enter(Phase::Over);
        self.rung = 0;
    }
}
