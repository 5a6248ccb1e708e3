//! Disturbance observer: it estimates the effort that the joint's model lacks, and applies it.
//!
//! An [extended state observer](super::robust::extended_state_observer) of the joint `J theta_a'' =
//! u - F sgn(theta_d') - B theta_a' + d`, `u` being the applied effort, estimates `d`:
//!
//! ```text
//! v_c = -d    estimated, in every tick in which the joint moves or should move
//! d  -> d                      at rest within the band, |theta_e| <= theta_o: kept
//! d  -> d - R h sgn(theta_e)   at rest beyond the band: a ramp towards the target
//! ```
//!
//! At rest is a joint that has not moved by a count for three ticks while its set point rests. `F`
//! is the slip friction that a feedforward in the same sum already applies in the direction of the
//! set point; the rest, which the observer estimates, then does not change with the direction.
//!
//! Why this form: feedforward and SRNF rest and track by the friction that is configured. The
//! observer finds the rest, including a load. On a joint that sticks, it would be a fast integral
//! of the other laws' effort, which hunts; hence it is stopped there, and a slow ramp breaks the
//! joint away. The ramp exceeds the friction by `R` times the time in which the breakaway is
//! detected.
//!
//! Guarantees: |v_c| never exceeds the full scale; at rest in the band the effort is constant, and
//! only the slope of the other laws acts. A friction or a load that is constant while the joint
//! slides leaves no error of velocity. Does badly: it lands where static friction allows, and with
//! one far above the dynamic friction the attempts scatter by more than the band. It holds an
//! effort at rest, up to the slip friction. An error of the inertia appears as a disturbance, which
//! is late: a joint of half of `J` rings with a sample of delay, unless the PD loop is slow.

use super::robust::extended_state_observer::{ExtendedStateObserver, ObserverState};
use super::{Law, LawInput, Loop};
use crate::units::error::HUGE;
use crate::units::saturation::bounded;
use crate::units::value::table;

/// The number of ticks without a count after which the joint is at rest.
const REST: u32 = 3;

table! {
    /// Gains of the disturbance observer.
    #[derive(Clone, Copy, Debug, PartialEq)]
    pub struct DisturbanceObserverGains (law) "controller" {
        /// Bandwidth of the estimate w, rad/s.
        bandwidth: f32 = 0x1801 "observer_bandwidth_rad_per_s", Above(0.0, HUGE), Needed(40.0);
        /// Inertia of the joint J, V/(deg/s^2).
        inertia: f32 = 0x1802 "observer_inertia_v_per_deg_per_s2", Above(0.0, HUGE), Needed(0.037);
        /// Viscous friction of the joint B, V/(deg/s).
        viscous: f32 = 0x1803 "observer_viscous_v_per_deg_per_s", Between(0.0, HUGE), Needed(0.02);
        /// Slip friction that another law already gives F, V.
        slip: f32 = 0x1804 "observer_slip_v", Between(0.0, HUGE), Needed(0.33);
        /// Error at rest within which the estimate is kept theta_o, deg.
        band: f32 = 0x1805 "observer_band_deg", Between(0.0, HUGE), Needed(0.003);
        /// Rate at which the effort rises at rest beyond the band R, V/s.
        ramp: f32 = 0x1806 "observer_ramp_v_per_s", Between(0.0, HUGE), Needed(0.2);
        /// Largest estimate, V. Zero turns the observer off.
        largest: f32 = 0x1807 "observer_largest_v", Between(0.0, HUGE), Needed(1.5);
    }
}

/// The disturbance observer, prepared for one sample time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DisturbanceObserver {
    observer: ExtendedStateObserver,
    resolution: f32,
    slip: f32,
    band: f32,
    /// R h/J, deg/s^2.
    ramp: f32,
    inertia: f32,
    largest: f32,
}

/// The state of the observer.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct DisturbanceObserverState {
    /// The estimates; the position is relative to the joint's present one, so that no precision is
    /// lost far from the origin.
    estimate: ObserverState,
    /// Ticks without a count.
    still: u32,
}

impl Law for DisturbanceObserver {
    type Gains = DisturbanceObserverGains;
    type State = DisturbanceObserverState;

    fn new(gains: &DisturbanceObserverGains, around: &Loop) -> Self {
        let DisturbanceObserverGains { bandwidth, inertia, viscous, slip, band, ramp, largest } =
            *gains;
        let h = around.sample_time;
        let largest = largest.min(around.full_scale);
        Self {
            observer: ExtendedStateObserver::new(h, [inertia, viscous], bandwidth, largest),
            resolution: around.resolution,
            slip,
            band,
            ramp: ramp * h / inertia,
            inertia,
            largest,
        }
    }

    /// Returns the law's v_c for one tick, V.
    ///
    /// ```
    /// use stiction::control::laws::disturbance_observer::DisturbanceObserverState;
    /// use stiction::control::laws::{DisturbanceObserver, DisturbanceObserverGains};
    /// use stiction::control::laws::{Law, LawInput, Loop};
    /// let gains = DisturbanceObserverGains {
    ///     bandwidth: 40.0,
    ///     inertia: 0.5,
    ///     viscous: 0.0,
    ///     slip: 0.0,
    ///     band: 0.5,
    ///     ramp: 12.5,
    ///     largest: 2.0,
    /// };
    /// let law = DisturbanceObserver::new(&gains, &Loop::EXAMPLE);
    /// let mut state = DisturbanceObserverState::default();
    /// let rest = |error| LawInput { error, ..LawInput::default() };
    /// // At rest beyond the band it rises by 0.25 V a tick; within the band it stays.
    /// let v_c = [0.75, 0.75, 0.75, 0.75, 0.25, 0.25].map(|e| law.update(&mut state, &rest(e)));
    /// assert_eq!(v_c, [0.0, 0.0, 0.25, 0.5, 0.5, 0.5]);
    /// ```
    fn update(&self, state: &mut DisturbanceObserverState, input: &LawInput) -> f32 {
        let LawInput { error, setpoint, travel, applied, .. } = *input;
        let DisturbanceObserverState { estimate, still } = state;
        *still = if travel == 0 { still.saturating_add(1) } else { 0 };
        if *still >= REST && setpoint.velocity == 0.0 {
            (estimate.position, estimate.velocity) = (0.0, 0.0);
            if error.abs() > self.band {
                estimate.disturbance -= self.ramp.copysign(error);
            }
        } else {
            let slip = if setpoint.velocity > 0.0 {
                self.slip
            } else if setpoint.velocity < 0.0 {
                -self.slip
            } else {
                0.0
            };
            estimate.position -= travel as f32 * self.resolution;
            self.observer.update(estimate, applied - slip, 0.0);
        }
        let v_c = bounded(-self.inertia * estimate.disturbance, self.largest);
        // The ramp stops at the limit.
        if v_c.abs() == self.largest {
            estimate.disturbance = -v_c / self.inertia;
        }
        v_c
    }
}
