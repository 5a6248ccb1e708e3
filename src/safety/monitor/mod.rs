//! The monitors, which turn the bridge off in the tick in which they detect a fault.
//!
//! Each monitor is one module, whose doc states what it checks, how soon it trips and what it does
//! badly. [`Limits`] are the thresholds in a user's units; the monitors are made from them once, in
//! counts, codes and ticks, so that a tick compares integers. If several monitors trip in a tick,
//! the first one checked is reported: a jump of the encoder is a following error, too.
//!
//! Faults that are not detected in a tick (clock, watchdog, panic, overrun, break input) come from
//! the board, and [`Fault::NonFinite`] from the controller.

mod abrupt_stop;
mod encoder_jump;
mod encoder_probe;
mod following_error;
pub mod limits;
mod link_timeout;
mod net_travel;
mod oscillation;
mod overspeed;
mod play;
mod position_limits;
mod progress;
mod reversal;
mod stall;
mod stall_impulse;
mod standstill;
mod supply;
#[cfg(test)]
mod tests;
mod thermal;
#[cfg(feature = "two-encoders")]
mod twist;
mod wind_up;

pub use limits::Limits;
pub use standstill::Standstill;

use crate::control::controller::ControllerConfig;
use crate::control::device_config::DeviceConfig;
use crate::control::hardware::Hardware;
use crate::control::signal::Tick;
use crate::safety::fault::Fault;
use abrupt_stop::{AbruptStop, AbruptStopState};
use encoder_jump::EncoderJump;
use encoder_probe::{EncoderProbe, EncoderProbeState};
use following_error::{FollowingError, FollowingState};
use limits::Units;
use link_timeout::{LinkState, LinkTimeout};
use net_travel::{NetTravel, NetTravelState};
use oscillation::{Oscillation, OscillationState};
use overspeed::{Overspeed, OverspeedState};
use play::{Play, PlayState};
pub(crate) use position_limits::PositionLimits;
use progress::{Progress, ProgressState};
use reversal::{Reversal, ReversalState};
use stall::{Stall, StallState};
use stall_impulse::{StallImpulse, StallImpulseState};
use supply::{Supply, SupplyState};
use thermal::{Thermal, ThermalState};
#[cfg(feature = "two-encoders")]
use twist::{Twist, TwistState};
use wind_up::WindUp;

/// Time at standstill after which the joint is at rest, s.
const REST: f32 = 0.05;

/// All monitors of a joint, prepared for its loop.
#[derive(Clone, Debug)]
pub(crate) struct Monitors {
    units: Units,
    /// Angle of a count of the motor's own encoder, deg; without one, that of the joint's encoder.
    #[cfg(feature = "two-encoders")]
    driven_count: f32,
    #[cfg(feature = "two-encoders")]
    twist: Option<Twist>,
    rest: u32,
    is_friction_unknown: bool,
    jump: EncoderJump,
    overspeed: Overspeed,
    reversal: Reversal,
    following: FollowingError,
    stall: Stall,
    impulse: StallImpulse,
    net: NetTravel,
    play: Option<Play>,
    probe: EncoderProbe,
    abrupt: AbruptStop,
    progress: Progress,
    oscillation: Oscillation,
    position: PositionLimits,
    supply: Supply,
    thermal: Thermal,
    link: LinkTimeout,
    wind_up: WindUp,
}

/// The states of the monitors. The heat stays from one arming to the next, and so does the impulse
/// without a count.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct MonitorState {
    /// Code applied since the last tick.
    code: i32,
    overspeed: OverspeedState,
    reversal: ReversalState,
    #[cfg(feature = "two-encoders")]
    twist: TwistState,
    following: FollowingState,
    stall: StallState,
    impulse: StallImpulseState,
    net: NetTravelState,
    play: PlayState,
    probe: EncoderProbeState,
    abrupt: AbruptStopState,
    progress: ProgressState,
    oscillation: OscillationState,
    /// Range of positions since arming.
    range: PositionLimits,
    supply: SupplyState,
    thermal: ThermalState,
    /// Measured current, as the code at standstill that causes it; none without a sensor.
    measured: Option<f32>,
    /// Measured current, A; zero without a sensor.
    current: f32,
    link: LinkState,
    wound_up: u32,
    warning: bool,
}

/// Readings of the encoder in a tick, armed or not.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Seen {
    /// Travel since the last tick, counts.
    pub travel: i32,
    /// Position since power-on, counts.
    pub position: i32,
    /// Ticks without motion.
    pub standstill: u32,
    /// Readings of the motor's encoder, if the joint's encoder is on the load and the motor has
    /// another one.
    #[cfg(feature = "two-encoders")]
    pub motor: Option<SeenMotor>,
    /// Ticks before this one in which the load's encoder gave no valid answer: `travel` is also
    /// theirs.
    #[cfg(feature = "two-encoders")]
    pub missed: u32,
}

/// Readings of the motor's encoder in a tick.
#[cfg(feature = "two-encoders")]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct SeenMotor {
    /// Travel since the last tick, counts.
    pub travel: i32,
    /// Position since power-on, counts.
    pub position: i32,
    /// Ticks without motion.
    pub standstill: u32,
}

impl Seen {
    /// Returns whether load and motor have an encoder each.
    #[inline]
    pub const fn has_both_sides(&self) -> bool {
        #[cfg(feature = "two-encoders")]
        return self.motor.is_some();
        #[cfg(not(feature = "two-encoders"))]
        false
    }

    /// Returns the number of ticks in which the joint has made its travel.
    #[inline]
    pub const fn ticks(&self) -> u32 {
        #[cfg(feature = "two-encoders")]
        return self.missed.saturating_add(1);
        #[cfg(not(feature = "two-encoders"))]
        1
    }

    /// Returns the readings of the side on which the effort acts: those of the motor, if it has its
    /// own encoder.
    #[inline]
    pub const fn driven(&self) -> Self {
        #[cfg(feature = "two-encoders")]
        if let Some(SeenMotor { travel, position, standstill }) = self.motor {
            return Self { travel, position, standstill, motor: None, missed: 0 };
        }
        *self
    }
}

/// A fault and the value that tripped it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Trip {
    pub fault: Fault,
    pub value: f32,
}

impl Monitors {
    /// Makes the monitors of a loop from validated parameters.
    pub fn new(
        limits: &Limits,
        controller: &ControllerConfig,
        device: &DeviceConfig,
        hardware: &Hardware,
    ) -> Self {
        let units = Units {
            count: controller.encoder.resolution,
            code: controller.drive.lsb,
            tick: controller.sample_time,
            supply: device.supply_full_scale / f32::from(hardware.supply_top),
        };
        let driven = Units { count: controller.motor.count().unwrap_or(units.count), ..units };
        Self {
            units,
            #[cfg(feature = "two-encoders")]
            driven_count: driven.count,
            #[cfg(feature = "two-encoders")]
            twist: Twist::new(&controller.motor, limits, &units),
            rest: Units::whole(REST, units.tick),
            is_friction_unknown: limits.is_friction_unknown(),
            jump: EncoderJump::new(limits, &units),
            overspeed: Overspeed::new(
                limits,
                controller.velocity_window,
                Limits::swing_time(controller),
                &driven,
            ),
            reversal: Reversal::new(limits, &driven),
            following: FollowingError::new(limits, Limits::saturating_error(controller), &units),
            stall: Stall::new(limits, &driven),
            impulse: StallImpulse::new(limits, &driven),
            net: NetTravel::new(limits, &driven),
            // A motor with its own encoder counts while it crosses the play.
            play: Play::new(limits, &driven).filter(|_| controller.motor.count().is_none()),
            probe: EncoderProbe::new(limits, &units),
            abrupt: AbruptStop::new(limits, &driven),
            progress: Progress::new(limits, &driven),
            oscillation: Oscillation::new(limits, &units),
            position: PositionLimits::new(limits, &units),
            supply: Supply::new(limits, &units),
            thermal: Thermal::new(limits, &units),
            link: LinkTimeout::new(limits, &units),
            wind_up: WindUp::new(limits, &units),
        }
    }

    /// Returns whether the joint is at rest.
    pub const fn is_at_rest(&self, seen: &Seen) -> bool {
        seen.standstill >= self.rest && seen.driven().standstill >= self.rest
    }

    /// Returns the range of a joint whose zero is at `zero` (counts since power-on). Without a
    /// known zero there is no range.
    pub fn range(&self, zero: Option<i32>) -> PositionLimits {
        zero.map_or(PositionLimits::NONE, |zero| self.position.with_zero(zero))
    }

    /// Returns the ends of the range of positions, counts from the zero of the joint. Without a
    /// range these are the ends of all numbers.
    #[cfg(feature = "two-encoders")]
    pub const fn range_counts(&self) -> [i32; 2] {
        self.position.ends()
    }

    /// Returns whether there is a range of positions.
    pub fn has_range(&self) -> bool {
        self.position != PositionLimits::NONE
    }

    /// Returns the fault that would trip at once after arming.
    pub fn forbids_arming(
        &self,
        state: &MonitorState,
        range: PositionLimits,
        seen: &Seen,
        supply: u16,
    ) -> Option<Fault> {
        if range.check(seen.position) {
            return Some(Fault::PositionLimit);
        }
        if self.thermal.is_hot(&state.thermal) {
            return Some(Fault::Overheat);
        }
        self.supply.is_out(supply)
    }

    /// Returns whether a reading of the supply is outside its limits.
    pub const fn is_supply_out(&self, supply: u16) -> bool {
        self.supply.is_out(supply).is_some()
    }

    /// Returns whether the friction is unknown, so that only an open loop may be armed.
    pub const fn is_friction_unknown(&self) -> bool {
        self.is_friction_unknown
    }

    /// Returns the smallest drive code that the tick must apply at a position (counts since
    /// power-on): that of a running probe of the encoder, otherwise zero.
    pub const fn probe_code(&self, state: &MonitorState, position: i32) -> i32 {
        self.probe.effort(&state.probe, position)
    }

    /// Returns whether a set point at this distance from the joint (counts) is a jump.
    pub const fn is_jump(&self, distance: i32) -> bool {
        self.following.is_jump(distance)
    }

    /// Stores the measured current of a tick, A, and the effort at standstill that causes it, V.
    pub fn measure(&self, state: &mut MonitorState, current: f32, volts: f32) {
        (state.current, state.measured) = (current, Some(volts / self.units.code));
    }

    /// Returns the state at arming.
    pub fn armed(
        &self,
        before: &MonitorState,
        by_link: bool,
        range: PositionLimits,
    ) -> MonitorState {
        let MonitorState { thermal, impulse, net, probe, .. } = *before;
        MonitorState {
            thermal,
            impulse,
            net,
            probe: probe.armed(),
            range,
            link: LinkState::watch(by_link),
            ..MonitorState::default()
        }
    }

    /// Returns the state after a change of parameters, in the new units: the winding stays warm.
    /// `before` and `monitors` are those of the old parameters.
    pub fn taken_over(&self, before: &MonitorState, monitors: &Self) -> MonitorState {
        let ratio = monitors.units.code / self.units.code;
        let thermal = before.thermal.scaled(ratio);
        let ratio = ratio * monitors.units.tick / self.units.tick;
        let (impulse, probe) = (before.impulse.scaled(ratio), before.probe.scaled(ratio));
        MonitorState { thermal, impulse, probe, ..MonitorState::default() }
    }

    /// Returns the state of a motor that a steady effort (V) has warmed.
    pub fn warm(&self, effort: f32) -> MonitorState {
        let thermal = ThermalState::of_effort(effort / self.units.code);
        MonitorState { thermal, ..MonitorState::default() }
    }

    /// Raises the heat of the winding to a part of the largest one, if it is less.
    pub fn warm_at_least(&self, state: &mut MonitorState, part: f32) {
        self.thermal.warm_at_least(&mut state.thermal, part);
    }

    /// Updates the state in a tick without output.
    pub fn idle(&self, state: &mut MonitorState, seen: &Seen) {
        self.thermal.cool(&mut state.thermal);
        let driven = seen.driven();
        self.impulse.see(&mut state.impulse, driven.position);
        self.probe.see(&mut state.probe, seen.position);
        state.net = NetTravelState::at(driven.position);
        state.code = 0;
        state.warning = false;
    }

    /// Adds the heat of a tick of the short brake, after [`idle`](Self::idle): that of the measured
    /// current, as the effort at standstill that causes it, V. Without a sensor, `None`: that of
    /// the back-EMF at the speed of the travel.
    pub fn brake(&self, state: &mut MonitorState, seen: &Seen, measured: Option<f32>) {
        #[cfg(feature = "two-encoders")]
        let count = self.driven_count;
        #[cfg(not(feature = "two-encoders"))]
        let count = self.units.count;
        let current = match measured {
            Some(volts) => volts / self.units.code,
            None => {
                let time = self.units.tick * seen.ticks() as f32;
                self.thermal.induced(seen.driven().travel as f32 * count / time)
            }
        };
        self.thermal.heat(&mut state.thermal, current);
    }

    /// Checks a tick of the driver's wake-up, without output. Trips on a condition that forbids
    /// arming, or on a silent link.
    pub fn waking(&self, state: &mut MonitorState, seen: &Seen, supply: u16) -> Option<Trip> {
        self.idle(state, seen);
        if let Some(fault) = self.forbids_arming(state, state.range, seen, supply) {
            return Some(Trip { fault, value: 0.0 });
        }
        let ticks = self.link.check(&mut state.link)?;
        Some(Trip { fault: Fault::LinkTimeout, value: ticks as f32 * self.units.tick })
    }

    /// Checks a tick with output. `tick` has the effort that is about to be applied.
    #[inline]
    pub fn check(
        &self,
        state: &mut MonitorState,
        seen: &Seen,
        tick: &Tick,
        supply: u16,
    ) -> Option<Trip> {
        // In codes at the nominal supply: scaling the duty by the supply does not change the
        // effort.
        let code = self.units.codes(tick.v_applied);
        let before = core::mem::replace(&mut state.code, code);
        let deg = |counts: i32| counts as f32 * self.units.count;
        let trip = |fault, value| Some(Trip { fault, value });
        let driven = &seen.driven();
        if self.jump.check(seen.travel, seen.ticks()) {
            return trip(Fault::EncoderJump, deg(seen.travel));
        }
        if let Some(speed) =
            self.overspeed.check(&mut state.overspeed, tick.velocity, driven.travel)
        {
            return trip(Fault::Overspeed, speed);
        }
        if let Some(travel) = self.reversal.check(&mut state.reversal, before, driven.travel) {
            #[cfg(feature = "two-encoders")]
            let deg = |counts: i32| counts as f32 * self.driven_count;
            return trip(Fault::EncoderReversed, deg(travel));
        }
        #[cfg(feature = "two-encoders")]
        if let Some(twist) = &self.twist
            && let Some(deg) = twist.check(&mut state.twist, seen, before)
        {
            return trip(Fault::EncodersDisagree, deg);
        }
        let (setpoint, speed) = (tick.reference_counts, tick.reference_velocity);
        if let Some(error) =
            self.following.check(&mut state.following, setpoint, speed, tick.counts)
        {
            return trip(Fault::FollowingError, deg(error));
        }
        let (is_taken_up, stops) = match &self.play {
            // Its gear stops a motor abruptly, and both sides are seen.
            None if seen.has_both_sides() => (true, false),
            None => (true, self.abrupt.check(&mut state.abrupt, before, driven.travel)),
            // The halves of a joint collide in its play: they stop abruptly.
            Some(play) => (play.is_taken_up(&mut state.play, code, driven.position), false),
        };
        let stalls = if is_taken_up {
            self.stall.check(&mut state.stall, code, driven.standstill)
                | self.impulse.check(&mut state.impulse, code, driven.position, driven.travel)
        } else {
            state.stall = StallState::default();
            self.impulse.see(&mut state.impulse, driven.position);
            false
        };
        let stalls = stalls | self.net.check(&mut state.net, code, driven.position);
        #[cfg(feature = "two-encoders")]
        let twist = state.twist.twist;
        #[cfg(not(feature = "two-encoders"))]
        let twist = 0.0;
        let (travel, speed) = (driven.travel, tick.velocity);
        let stalls =
            stalls | self.progress.check(&mut state.progress, before, travel, speed, twist);
        let error = setpoint.wrapping_sub(tick.counts);
        let stalls = stalls | self.probe.check(&mut state.probe, code, seen.position, error);
        if stalls || stops {
            return trip(Fault::Stall, tick.v_applied);
        }
        if let Some(ticks) =
            self.oscillation.check(&mut state.oscillation, seen.position, setpoint, before)
        {
            return trip(Fault::Oscillation, ticks as f32 * self.units.tick);
        }
        if state.range.check(seen.position) {
            return trip(Fault::PositionLimit, deg(state.range.counted(seen.position)));
        }
        if let Some(fault) = self.supply.check(&mut state.supply, supply) {
            return trip(fault, f32::from(supply) * self.units.supply);
        }
        let is_hot = match state.measured {
            None => self.thermal.check(&mut state.thermal, code, tick.velocity),
            Some(measured) => self.thermal.check_measured(&mut state.thermal, measured),
        };
        if is_hot {
            return trip(Fault::Overheat, state.thermal.effort() * self.units.code);
        }
        if let Some(ticks) = self.link.check(&mut state.link) {
            return trip(Fault::LinkTimeout, ticks as f32 * self.units.tick);
        }
        state.warning = self.wind_up.check(&mut state.wound_up, tick.v_c, driven.standstill);
        None
    }
}

impl MonitorState {
    /// Returns whether a probe of the encoder runs.
    #[inline]
    pub const fn probes(&self) -> bool {
        self.probe.runs()
    }

    /// Returns the measured current of the last tick, A; zero without a sensor.
    #[inline]
    pub const fn current(&self) -> f32 {
        self.current
    }

    /// Returns the range of positions since arming.
    pub const fn range(&self) -> PositionLimits {
        self.range
    }

    /// Ends the warning and the watch over the link, when the output goes off. The rest of the
    /// state stays until [`Monitors::armed`], since the tick that latches a fault is the longest of
    /// all.
    pub const fn rest(&mut self) {
        self.warning = false;
        self.link = LinkState::watch(false);
    }

    /// Starts the watch over the link: its silence is a fault from now on.
    pub const fn listen(&mut self) {
        self.link = LinkState::watch(true);
    }

    /// Ends the watch over the link: its silence is no longer a fault.
    pub const fn ignore_link(&mut self) {
        self.link = LinkState::watch(false);
    }

    /// Turns the monitor of a reversal off, because the direction of the encoder is not known yet:
    /// a jog finds it.
    pub const fn suppose_direction(&mut self) {
        self.reversal.suppose();
    }

    /// Turns the monitors off that rely on the direction of an encoder or on the ratio of two: a
    /// jog finds both.
    pub const fn suppose_wiring(&mut self) {
        self.suppose_direction();
        #[cfg(feature = "two-encoders")]
        self.twist.suppose();
    }

    /// Turns the monitor of an abrupt stop off if a homing expects a stop, else on.
    pub fn expect_stop(&mut self, is_expected: bool) {
        self.abrupt = AbruptStopState::default();
        if is_expected {
            self.abrupt.expect();
        }
    }

    /// Returns whether the silence of a link is watched.
    pub const fn is_watched(&self) -> bool {
        self.link.is_watched()
    }

    /// Restarts the time of the link's silence, after a sign of life.
    pub const fn heard(&mut self) {
        self.link.heard();
    }

    /// Returns whether the compensator holds effort at standstill.
    pub const fn warning(&self) -> bool {
        self.warning
    }

    /// Returns whether the joint swings to and fro.
    pub const fn oscillates(&self, monitors: &Monitors) -> bool {
        monitors.oscillation.is_reported(&self.oscillation)
    }

    /// Returns the heat of the motor, as the steady effort that would cause it, V.
    pub fn effort(&self, monitors: &Monitors) -> f32 {
        self.thermal.effort() * monitors.units.code
    }
}
