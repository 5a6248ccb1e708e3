//! Adaptive impulsive positioner: PD moves and brakes; pulses from rest remove the remaining error.
//!
//! A pulse of the effort `A` for the time `T` from rest moves an inertia `J` against the friction
//! `F` by the quadratic law of pulse width control (Yang and Tomizuka, "Adaptive pulse width
//! control for precise positioning under the influence of stiction and Coulomb friction", *ASME
//! Journal of Dynamic Systems, Measurement, and Control* 110(3), 1988). With `(A - F)/J` it gains
//! speed for `T`, and with `-F/J` it loses it again:
//!
//! ```text
//! d = A (A - F) T^2 / (2 J F)     so     A = [F + sqrt(F^2 + 8 J F d / T^2)] / 2
//! ```
//!
//! The time is a whole number `N` of samples, and the amplitude makes up for it, as in pulse
//! amplitude pulse width control (van de Wijdeven and Singh). A tick of the law:
//!
//! ```text
//! at rest (no count for 6 ticks; 3 above 10 ms), the set point too, and armed:
//!   d = k |theta_e|,  F = 2 F_lo F_hi/(F_lo + F_hi)
//!   N the smallest with A <= U, at most 40;  A = max(A, 1.05 F_lo), at most U
//!   v_PD + v_c = A sgn(theta_e)    for N ticks;   v_c = 0 otherwise
//! at rest after a pulse that began at theta_e = e and moved the joint m towards the target:
//!   m < 0.3 |e|: k -> 1.25 k       m > 1.2 |e|: k -> 0.8 k       k in [0.2, 5], one each way
//! armed: no more within 1.25 counts, again beyond 1.5 counts or with a new motion
//! ```
//!
//! Why this form: an integral has to creep up to an unknown breakaway, and then has too much; a
//! pulse is far above any breakaway, and how far it moves depends on the friction in motion, which
//! is known within a factor. Guarantees: with `A` well above the friction the error shrinks with
//! each pulse by about `(F_hi - F_lo)/(F_hi + F_lo)` for every friction in the range, although it
//! is unknown (van de Wouw and Leine, "Robust impulsive control of motion systems with uncertain
//! friction", *International Journal of Robust and Nonlinear Control* 22(4), 2012, have the proof
//! of a similar law). The effort of a pulse never exceeds `U`. The band with two edges keeps it
//! from firing forever where bristles yield and come back. Does badly: a load above the friction
//! drives the joint off again. On a flexible joint a pulse rings. It does nothing for tracking.

use crate::control::laws::{Law, LawInput, Loop};
use crate::units::error::HUGE;
use crate::units::value::table;

/// The number of ticks in the longest pulse.
const LONGEST: f32 = 40.0;

/// Errors at which the pulses stop and start again, counts.
const STOP: f32 = 1.25;
const REARM: f32 = 1.5;

table! {
    /// Gains of the impulsive positioner.
    #[derive(Clone, Copy, Debug, PartialEq)]
    pub struct ImpulsiveGains (law) "controller" {
        /// Inertia J, V/(deg/s^2).
        inertia: f32 = 0x3201 "pulse_inertia_v_per_deg_per_s2", Above(0.0, HUGE), Needed(0.037);
        /// Least friction F_lo, V.
        low: f32 = 0x3202 "pulse_friction_low_v", Above(0.0, HUGE), Needed(0.19);
        /// Largest friction F_hi, V. One below the least counts as the least.
        high: f32 = 0x3203 "pulse_friction_high_v", Above(0.0, HUGE), Needed(1.03);
        /// Largest effort of a pulse U, V. Zero turns the pulses off.
        largest: f32 = 0x3204 "pulse_effort_v", Between(0.0, HUGE), Needed(5.0);
    }
}

/// The impulsive positioner, prepared for its ticks.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Impulsive {
    /// F, V.
    friction: f32,
    /// 8 J F/h^2, V^2/deg.
    steepness: f32,
    /// Smallest and largest effort of a pulse, V.
    smallest: f32,
    largest: f32,
    /// Angle of a count, deg.
    resolution: f32,
    /// Ticks without a count after which the joint is at rest.
    rest: u32,
}

/// The state of the law.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ImpulsiveState {
    /// Ticks without a count since the last one, or since the last pulse.
    still: u32,
    /// Ticks that are left of the pulse.
    left: u32,
    /// Effort of the pulse, V, with its sign.
    effort: f32,
    /// Error from which the pulse began, deg; zero: no pulse has to be judged.
    from: f32,
    /// Factor k from the error to the distance that a pulse is planned for: forwards and backwards.
    reach: [f32; 2],
    /// Whether the error has been within the band, and not beyond its outer edge since.
    content: bool,
}

impl Default for ImpulsiveState {
    fn default() -> Self {
        Self { still: 0, left: 0, effort: 0.0, from: 0.0, reach: [1.0; 2], content: false }
    }
}

/// A pulse: its effort (V) and its length (ticks).
#[derive(Clone, Copy, Debug, PartialEq)]
struct Pulse {
    effort: f32,
    ticks: u32,
}

impl Impulsive {
    /// Returns the shortest pulse that moves the joint by a distance (deg).
    fn pulse(&self, distance: f32) -> Pulse {
        let needed = self.steepness * distance;
        // A <= U is 8 J F d/(N h)^2 <= 4 U (U - F).
        let room = 4.0 * self.largest * (self.largest - self.friction);
        // A rounding does not make it a tick longer.
        let least = libm::sqrtf(needed / room) - 1e-4;
        let shortest = if room > 0.0 { libm::ceilf(least) } else { LONGEST };
        // One after the other, so that NaN becomes one tick.
        let at_least_one = shortest.max(1.0);
        let ticks = at_least_one.min(LONGEST);
        let under_root = self.friction * self.friction + needed / (ticks * ticks);
        let effort = 0.5 * (self.friction + libm::sqrtf(under_root));
        Pulse { effort: effort.max(self.smallest).min(self.largest), ticks: ticks as u32 }
    }

    /// Adapts the reach to the travel after the last pulse, if there was one.
    fn judge(state: &mut ImpulsiveState, error: f32) {
        if state.from == 0.0 {
            return;
        }
        let [forwards, backwards] = &mut state.reach;
        let reach = if state.from > 0.0 { forwards } else { backwards };
        let share = (state.from - error) / state.from;
        if share < 0.3 {
            *reach = (*reach * 1.25).min(5.0);
        } else if share > 1.2 {
            *reach = (*reach * 0.8).max(0.2);
        }
        state.from = 0.0;
    }
}

impl Law for Impulsive {
    type Gains = ImpulsiveGains;
    type State = ImpulsiveState;

    const ON_THE_DEVICE: bool = false;

    fn new(gains: &ImpulsiveGains, around: &Loop) -> Self {
        let ImpulsiveGains { inertia, low, high, largest } = *gains;
        let high = high.max(low);
        // In this form no product of two large frictions overflows.
        let friction = 2.0 * low / (low / high + 1.0);
        let h = around.sample_time;
        Self {
            friction,
            steepness: 8.0 * inertia * friction / (h * h),
            smallest: 1.05 * low,
            largest: largest.min(around.full_scale),
            resolution: around.resolution,
            rest: if h > 0.01 { 3 } else { 6 },
        }
    }

    /// Returns the law's v_c for one tick, V.
    ///
    /// ```
    /// use stiction::control::laws::rival::impulsive::ImpulsiveState;
    /// use stiction::control::laws::{Impulsive, ImpulsiveGains, Law, LawInput, Loop};
    /// let gains = ImpulsiveGains { inertia: 0.0004, low: 1.0, high: 1.0, largest: 2.0 };
    /// let law = Impulsive::new(&gains, &Loop::EXAMPLE);
    /// let mut state = ImpulsiveState::default();
    /// // 2 V for 20 ms against 1 V move 4e-4 V/(deg/s^2) by 2 (2 - 1) 0.02^2/(2 * 0.0004) = 1 deg.
    /// let input = LawInput { error: 1.0, v_pd: 0.25, ..LawInput::default() };
    /// let v_c = [(); 4].map(|()| law.update(&mut state, &input));
    /// assert_eq!(v_c, [0.0, 0.0, 1.75, 0.0]);
    /// ```
    fn update(&self, state: &mut ImpulsiveState, input: &LawInput) -> f32 {
        let LawInput { error, v_pd, setpoint, .. } = *input;
        state.still = if input.travel == 0 { state.still.saturating_add(1) } else { 0 };
        if setpoint.velocity != 0.0 {
            (state.left, state.from, state.content) = (0, 0.0, false);
            return 0.0;
        }
        if state.left == 0 {
            if state.still < self.rest {
                return 0.0;
            }
            Self::judge(state, error);
            let counts = error.abs() / self.resolution;
            if counts <= STOP {
                state.content = true;
            } else if counts > REARM {
                state.content = false;
            }
            if state.content || self.largest == 0.0 {
                return 0.0;
            }
            let reach = if error > 0.0 { state.reach[0] } else { state.reach[1] };
            let pulse = self.pulse(reach * error.abs());
            state.effort = pulse.effort.copysign(error);
            (state.left, state.from) = (pulse.ticks, error);
        }
        state.left -= 1;
        state.still = 0;
        state.effort - v_pd
    }
}
