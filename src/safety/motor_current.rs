//! The motor's current: its measurement, and the faults that it shows.
//!
//! ```text
//! i = +-(reading - offset) unit              offset: current_offset.rs
//! w = u - k_e v,  d = k_e |v| / 4            of the effort u since the tick; k_e may be off by d
//! e = (|w| + d) / R                          largest expected current
//! e_d = sgn(w) max(|w| - d - V_d, 0) / R     smallest one; V_d: lost to dead time and brushes
//!
//! open:      |E_d| > i_0, |I| < |E_d| / 4                no current (in a current loop 0.4 |E_d|)
//! reversed:  |E_d| > i_0, |I| > |E_d| / 4, I E_d < 0     the other way
//! shorted:   |I| > 2 E + i_0                             too much current
//! silent:    J* > i_0, J < J* / 4      in a current loop: no current, whatever its voltage does
//! ```
//!
//! The effort u is the bridge's voltage: under a current loop that of its last period, not the
//! target. I, E and E_d are i, e and e_d behind the same first-order lag of 20 ms, which a winding
//! with an inductance is small against. In a current loop, that one voltage stands for a tick only
//! while the current is the target, to a quarter of it and `i_0`, and was so a tick before; or once
//! it has not been the target for 20 ms: its voltage is at its limit then. Else e_d is no larger
//! than |i|.
//!
//! J is |i|, and J* the size of the current that the loop is to make, behind a lag of 5 ms and a
//! period of its bandwidth. That current is the target as far as the largest voltage u_m suffices,
//! and changes by no more than `u_m / L` in a second. Neither has a sign, since a law may change
//! that of its effort in every tick.
//!
//! In every tick of a time one of the first three conditions has to hold, or the last one: 20 ms
//! (silent: that lag), three ticks, or the ticks of the velocity window, whichever is longest. The
//! last tick names the fault. If no current is measured, and the encoder moves the way of the
//! effort without losing a tenth of its speed meanwhile, the sensor is dead, not the wire; in a
//! current loop if it gains speed, since the loop drives with its largest voltage then. `i_0` is a
//! fiftieth of the sensor's range. An offset or a noise that forbids arming is judged in
//! [`current_offset`](super::current_offset).
//!
//! Guarantees: with a sample time of up to 5 ms, a velocity window of up to four positions per 20
//! ms and an effort of twice `R i_0 + V_d`, an open wire is found within 0.1 s.
//! Does badly: one shunt in line with the motor does not distinguish an open wire from a bridge
//! that is not enabled or not supplied; a joint that coasts almost without friction looks as if its
//! sensor was dead, and in a current loop one that a load accelerates. An effort below `R i_0 +
//! V_d` shows none of these faults. A resistance that is off by more than a factor of two is
//! reported as a short or as an open wire, and so is a motor that crosses the slack before an
//! encoder on the load. A sensor that reads half of the current is no fault: the heat is then that
//! of 0.7 times the expected current, half of it.

use crate::control::current_sensor::{CurrentSensor, Driven};
use crate::safety::current_offset::{CurrentOffset, CurrentOffsetState};
use crate::safety::fault::Fault;
use crate::units::saturation::saturate;

/// Time constant of the lag, and time for which a condition has to hold, s.
const TIME: f32 = 0.02;

/// Time constant of the lag in a current loop, s, beside a period of its bandwidth.
const REGULATED: f32 = 0.005;

/// Smallest number of ticks for which a condition has to hold.
const FEWEST: u16 = 3;

/// Part of the sensor's range: the smallest expected current that is judged. The offset of an
/// amplifier drifts by less than that between two armings, and noise of a few readings is less.
const LEAST: f32 = 0.02;

/// Part of the back-EMF by which it may be off: tolerance of the torque constant and warm magnets.
const INDUCED: f32 = 0.25;

/// Part of the expected current below which none flows.
const NONE: f32 = 0.25;

/// The same in a current loop, where a sensor that reads too little has more current flow: the
/// current of 0.4 times the voltage, which a winding of 1.4 times the resistance has with 0.56 of
/// the supply.
const NONE_REGULATED: f32 = 0.4;

/// Part of its target by which the current of a loop may be off while its voltage is judged.
const SETTLED: f32 = 0.25;

/// Factor of the expected current beyond which there is a short.
const SHORT: f32 = 2.0;

/// Voltage that brushes may lose, V: those of graphite lose about 1 V a pair.
const BRUSHES: f32 = 1.0;

/// Part of the expected current that heats the winding at least: a winding that is 100 K hotter has
/// 1.4 times its resistance.
const HEATS: f32 = 0.7;

/// Part of its speed that a joint without a current has lost to its friction when the fault comes.
const COASTS: f32 = 0.9;

/// Travel the way of the effort that shows that the motor has a current, counts: four times what
/// noise adds to a standing joint.
const MOVES: i32 = 16;

/// A sensor of the motor's current, prepared for its ticks.
#[derive(Clone, Copy, Debug)]
pub struct MotorCurrent {
    /// Current of one reading, A, with the sign of the sensor's direction.
    unit: f32,
    /// The converter's largest reading.
    top: u16,
    /// Measurement of the offset.
    offset: CurrentOffset,
    /// Current that turns the bridge off, readings.
    trip: f32,
    /// Resistance of the winding, ohm.
    resistance: f32,
    /// Back-EMF of a speed of one deg/s, V.
    back_emf: f32,
    /// Largest voltage that is lost to dead time and brushes, V.
    lost: f32,
    /// Smallest current that is judged, A.
    least: f32,
    share: f32,
    /// Ticks in a row in which a condition has to hold.
    ticks: u16,
    regulated: Option<Regulated>,
}

/// What is known of a current loop.
#[derive(Clone, Copy, Debug)]
struct Regulated {
    /// Largest voltage, V, and the change of the current that it causes in a tick, A.
    most: f32,
    slope: f32,
    /// Share of a tick in the lag, and ticks in a row in which the condition has to hold.
    share: f32,
    ticks: u16,
}

/// Measured current and its history.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct MotorCurrentState {
    /// Current of the last tick, A.
    current: f32,
    offset: CurrentOffsetState,
    /// Lagged current, and lagged largest and smallest expected currents, A.
    lagged: f32,
    expected: f32,
    at_least: f32,
    /// Lagged size of the current, and of the one that a current loop is to make, A.
    size: f32,
    target: f32,
    /// Current that a loop can make of its targets, A.
    reached: f32,
    /// Ticks in a row in which the current of a loop is not its target.
    unsettled: u16,
    /// Ticks in a row in which a condition holds; and in which a current loop is silent.
    odd: u16,
    silent: u16,
    /// Travel the way of the effort meanwhile, counts.
    travel: i32,
    /// Speed at the first of these ticks, deg/s.
    speed: f32,
}

impl MotorCurrentState {
    /// Returns the current of the last tick, A.
    pub const fn current(&self) -> f32 {
        self.current
    }
}

impl MotorCurrent {
    /// Prepares a sensor. `top` is the largest reading of the converter, `back_emf` in V s/deg,
    /// `dead_time` the largest voltage that is lost by it (V), `sample_time` in s, and the number
    /// of positions over which the speed is measured. `most` is the largest voltage (V) of a
    /// current loop, if there is one. None without a sensor.
    pub fn of(
        sensor: &CurrentSensor,
        top: u16,
        [back_emf, dead_time, sample_time]: [f32; 3],
        velocity_window: u32,
        most: Option<f32>,
    ) -> Option<Self> {
        let in_ticks = |time: f32| libm::ceilf(time / sample_time) as u16;
        let fewest = FEWEST.max(velocity_window as u16);
        let lag = REGULATED + 1.0 / sensor.bandwidth;
        let regulated = most.map(|most| Regulated {
            most,
            slope: most * sample_time / sensor.inductance,
            share: sample_time / (sample_time + lag),
            ticks: in_ticks(lag).max(fewest),
        });
        let unit = sensor.unit(top);
        sensor.is_there().then(|| Self {
            unit,
            top,
            offset: CurrentOffset::of(top, sample_time),
            trip: sensor.trip / unit.abs(),
            resistance: sensor.resistance,
            back_emf,
            lost: dead_time + BRUSHES,
            least: LEAST * sensor.full_scale,
            share: sample_time / (sample_time + TIME),
            ticks: in_ticks(TIME).max(fewest),
            regulated,
        })
    }

    /// Takes a reading with the bridge off, which counts for the offset if the joint is at rest.
    pub fn idle(&self, state: &mut MotorCurrentState, reading: u16, is_at_rest: bool) {
        let mut now = MotorCurrentState { offset: state.offset, ..MotorCurrentState::default() };
        self.offset.idle(&mut now.offset, reading, is_at_rest);
        *state = now;
    }

    /// Returns whether the offset is known: the mean of a few readings at rest.
    pub const fn is_calibrated(&self, state: &MotorCurrentState) -> bool {
        self.offset.is_known(&state.offset)
    }

    /// Returns whether the sensor is known to be faulty while no current flows, by its offset or
    /// its noise.
    pub fn is_off(&self, state: &MotorCurrentState) -> bool {
        self.offset.is_off(&state.offset)
    }

    /// Returns the mean reading without a current.
    pub const fn offset(&self, state: &MotorCurrentState) -> f32 {
        state.offset.mean()
    }

    /// Returns the current of a reading, A, with the sign of the sensor's direction.
    pub const fn unit(&self) -> f32 {
        self.unit
    }

    /// Returns the lowest and the highest reading that does not turn the bridge off. A reading at
    /// an end of the range is beyond them.
    pub fn window(&self, state: &MotorCurrentState) -> [u16; 2] {
        let low = (state.offset.mean() - self.trip).max(1.0);
        let high = (state.offset.mean() + self.trip).min(f32::from(self.top) - 1.0);
        [libm::ceilf(low) as u16, high as u16]
    }

    /// Returns the current of a reading, A.
    #[inline]
    pub fn current(&self, state: &MotorCurrentState, reading: u16) -> f32 {
        (f32::from(reading) - state.offset.mean()) * self.unit
    }

    /// Measures the current of a tick with the bridge on, and returns it, A.
    #[inline]
    pub fn measure(&self, state: &mut MotorCurrentState, reading: u16) -> f32 {
        state.current = self.current(state, reading);
        self.offset.drive(&mut state.offset);
        state.current
    }

    /// Returns the current that heats the winding, as the effort at standstill that causes it, V:
    /// the measured one, and no less than what the effort causes in a hot winding. So a sensor that
    /// reads too little leaves half of the heat, and not none of it.
    pub fn heat_volts(&self, state: &MotorCurrentState) -> f32 {
        state.current.abs().max(HEATS * state.at_least.abs()) * self.resistance
    }

    /// Returns the measured current, as the effort at standstill that causes it, V. In a short
    /// brake no effort is there that would set a least current.
    pub fn volts(&self, state: &MotorCurrentState) -> f32 {
        state.current * self.resistance
    }

    /// Checks a tick with the bridge on. The value of the fault is the current, A.
    pub fn check(&self, state: &mut MotorCurrentState, driven: &Driven) -> Option<(Fault, f32)> {
        let induced = self.back_emf * driven.speed;
        let (drives, doubt) = (driven.effort - induced, INDUCED * induced.abs());
        let mut at_least = (drives.abs() - doubt - self.lost).max(0.0).copysign(drives);
        if self.regulated.is_some() {
            let off = (driven.target - state.current * self.resistance).abs();
            let is_settled = off <= SETTLED * driven.target.abs() + self.least * self.resistance;
            let unsettled = if is_settled { 0 } else { state.unsettled.saturating_add(1) };
            let was_settled = core::mem::replace(&mut state.unsettled, unsettled) == 0;
            // A voltage that does not reach the target for longer is that of all periods.
            if unsettled < self.ticks && !(is_settled && was_settled) {
                (at_least, _) = saturate(at_least, state.current.abs() * self.resistance);
            }
        }
        let lag = |before: f32, now: f32| before + (now - before) * self.share;
        state.lagged = lag(state.lagged, state.current);
        state.expected = lag(state.expected, (drives.abs() + doubt) / self.resistance);
        state.at_least = lag(state.at_least, at_least / self.resistance);
        let MotorCurrentState { lagged, expected, at_least, .. } = *state;
        let is_driven = at_least.abs() > self.least;
        let none = if self.regulated.is_some() { NONE_REGULATED } else { NONE };
        let is_none = lagged.abs() < none * at_least.abs();
        let is_short = lagged.abs() > SHORT * expected + self.least;
        let is_reversed = is_driven && !is_none && lagged * at_least < 0.0;
        let (is_silent, ticks) = match &self.regulated {
            Some(of) => (self.is_silent(of, state, driven), of.ticks),
            None => (false, self.ticks),
        };
        let is_odd = is_short || is_reversed || (is_driven && is_none);
        if !(is_odd || is_silent) {
            (state.odd, state.silent, state.travel) = (0, 0, 0);
            return None;
        }
        if state.odd.max(state.silent) == 0 {
            state.speed = driven.speed;
        }
        state.odd = if is_odd { state.odd.saturating_add(1) } else { 0 };
        state.silent = if is_silent { state.silent.saturating_add(1) } else { 0 };
        // An effort that changes its sign has no way.
        let towards = if is_silent { state.speed } else { driven.effort };
        let way = if towards < 0.0 { -1 } else { 1 };
        state.travel = state.travel.saturating_add(driven.travel.saturating_mul(way));
        if state.odd < self.ticks && state.silent < ticks {
            return None;
        }
        // The largest voltage, which a loop puts out without a reading, speeds the joint up.
        let kept = if self.regulated.is_some() { 1.0 } else { COASTS };
        let fault = if is_reversed {
            Fault::CurrentSensor
        } else if is_short {
            Fault::MotorShorted
        } else if state.travel >= MOVES && driven.speed.abs() > kept * state.speed.abs() {
            Fault::CurrentSensor
        } else {
            Fault::MotorOpen
        };
        Some((fault, lagged))
    }

    /// Returns whether a current loop makes no current, although its voltage suffices.
    fn is_silent(&self, of: &Regulated, state: &mut MotorCurrentState, driven: &Driven) -> bool {
        let induced = self.back_emf * driven.speed;
        let against = if driven.target < 0.0 { -induced } else { induced };
        let room = of.most * driven.supply - against - INDUCED * induced.abs() - self.lost;
        let (target, _) = saturate(driven.target, room.max(0.0));
        let change = target / self.resistance - state.reached;
        let (change, _) = saturate(change, of.slope * driven.supply);
        state.reached += change;
        state.size += (state.current.abs() - state.size) * of.share;
        state.target += (state.reached.abs() - state.target) * of.share;
        state.target > self.least && state.size < NONE * state.target
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::control::encoder::Direction;

    /// +-10 A in 4095 readings; 2 ohm, 0.05 V s/deg, 0.5 V of dead time, 1 ms. So i_0 is 0.2 A.
    fn sensor(direction: Direction) -> MotorCurrent {
        let sensor = CurrentSensor { direction, ..CurrentSensor::derived(10.0, [2.0, 0.0]) };
        MotorCurrent::of(&sensor, 4095, [0.05, 0.5, 0.001], 5, None).unwrap()
    }

    /// The same sensor in a current loop of 12 V.
    fn regulated() -> MotorCurrent {
        let sensor = CurrentSensor::derived(10.0, [2.0, 0.001]);
        MotorCurrent::of(&sensor, 4095, [0.05, 0.5, 0.001], 5, Some(12.0)).unwrap()
    }

    fn at_rest(sensor: &MotorCurrent, reading: u16) -> MotorCurrentState {
        let mut state = MotorCurrentState::default();
        (0..50).for_each(|_| sensor.idle(&mut state, reading, true));
        state
    }

    /// Returns the fault and the number of its tick, of a current (A) for each tick.
    fn trips(
        sensor: &MotorCurrent,
        driven: Driven,
        current: impl Fn(u32) -> f32,
    ) -> Option<(Fault, u32)> {
        let mut state = at_rest(sensor, 2100);
        (0..2000).find_map(|tick| {
            let reading = 2100.0 + current(tick) / sensor.unit;
            sensor.measure(&mut state, reading.round() as u16);
            sensor.check(&mut state, &driven).map(|(fault, _)| (fault, tick))
        })
    }

    const STANDS: Driven = Driven { effort: 4.0, target: 4.0, speed: 0.0, supply: 1.0, travel: 0 };

    /// The lag of 6 ms falls to a quarter in 6 ms ln 4 = 8.3 ms, and then for 6 ms.
    #[test]
    fn a_current_loop_without_a_current_is_found_in_16_ms_though_its_effort_changes_its_sign() {
        let sensor = regulated();
        for (period, speed) in [(0, 0.0), (1, 0.0), (1, 20.0), (3, 20.0), (0, -20.0)] {
            let mut state = at_rest(&sensor, 2100);
            let found = (0..200u32).find_map(|tick| {
                let is_back = period > 0 && (tick / period) % 2 == 1;
                let target = if is_back { -4.0 } else { 4.0 };
                let dies = tick >= 100;
                let current = if dies { 0.0 } else { target / 2.0 };
                sensor.measure(&mut state, (2100.0 + current / sensor.unit).round() as u16);
                // Its voltage drives against the error, five times as far.
                let effort = if dies { 5.0 * target } else { target + 0.05 * speed };
                let travel = speed as i32;
                sensor
                    .check(&mut state, &Driven { effort, target, speed, supply: 1.0, travel })
                    .map(|_| tick)
            });
            let ticks = found.unwrap() - 100;
            assert!((8..=16).contains(&ticks), "{period}, {speed}: {ticks}");
        }
    }

    /// A current that swings about zero is one, and has none on average: after some ticks of that,
    /// the loop has none for two ticks less than a silent one. The lag takes another one until it
    /// shows the current.
    #[test]
    fn ticks_of_another_condition_are_none_of_a_silent_loop() {
        let sensor = regulated();
        let silent = sensor.regulated.unwrap().ticks;
        let mut state = at_rest(&sensor, 2100);
        let driven = Driven { effort: 4.0, target: 4.0, speed: 0.0, supply: 1.0, travel: 0 };
        let tick = |state: &mut _, current: f32| {
            sensor.measure(state, (2100.0 + current / sensor.unit).round() as u16);
            sensor.check(state, &driven)
        };
        let mut current = 1.0;
        while state.odd < 4 {
            assert_eq!(tick(&mut state, current), None);
            current = -current;
        }
        assert_eq!(state.silent, 0);
        while state.silent < silent - 2 {
            assert_eq!(tick(&mut state, 0.0), None, "{state:?}");
        }
        assert!(state.odd > silent, "{state:?}");
        let found = (0..200).find_map(|_| tick(&mut state, 2.0));
        assert_eq!(found, None);
    }

    /// At 200 deg/s 10 V are induced, which may be 12.5 V, and 1.5 V are lost to dead time and
    /// brushes: of 12 V none is left for a current.
    #[test]
    fn a_current_that_the_voltage_cannot_make_is_no_fault() {
        let sensor = regulated();
        for sign in [1.0, -1.0f32] {
            let driven = |speed| Driven {
                effort: sign * 12.0,
                target: sign * 8.0,
                speed: sign * speed,
                supply: 1.0,
                travel: 0,
            };
            assert_eq!(trips(&sensor, driven(200.0), |_| 0.0), None);
            let found = trips(&sensor, driven(-200.0), |_| 0.0);
            assert_eq!(found.map(|(fault, _)| fault), Some(Fault::MotorOpen));
        }
    }

    /// L/R = 5 ms and 12 V: 1.2 A a tick. In the tick of a pulse of 4 A the loop puts out 12 V, and
    /// in the next one it has ended the current of 1.2 A.
    #[test]
    fn pulses_that_a_slow_winding_cannot_follow_are_no_fault_and_an_open_wire_is_one() {
        let sensor = CurrentSensor::derived(10.0, [2.0, 0.01]);
        let sensor = MotorCurrent::of(&sensor, 4095, [0.05, 0.5, 0.001], 5, Some(12.0)).unwrap();
        for (every, is_alternating) in [(2, false), (2, true), (4, false), (1, true)] {
            let mut state = at_rest(&sensor, 2100);
            let found = (0..4000u32).find_map(|tick| {
                let is_back = is_alternating && (tick / every) % 2 == 1;
                let sign = if is_back { -1.0 } else { 1.0 };
                let target = if tick % every == 0 { sign * 8.0 } else { 0.0 };
                let follows = tick < 2000;
                let current = if follows { 1.2 / 8.0 * target } else { 0.0 };
                sensor.measure(&mut state, (2100.0 + current / sensor.unit).round() as u16);
                let effort = 1.5 * target;
                let driven = Driven { effort, target, speed: 0.0, supply: 1.0, travel: 0 };
                sensor.check(&mut state, &driven).map(|(fault, _)| (fault, tick))
            });
            let (fault, tick) = found.unwrap();
            let is_found = fault == Fault::MotorOpen && (2005..2040).contains(&tick);
            assert!(is_found, "{every}, {is_alternating}: {fault:?} in tick {tick}");
        }
    }

    /// A blocked joint, 8 V commanded. The sensor reads a third of the current, so the loop puts
    /// out its 12 V, and 6 A flow.
    #[test]
    fn a_sensor_that_reads_a_third_is_found_though_the_loop_does_not_reach_its_target() {
        let sensor = regulated();
        let driven = Driven { effort: 12.0, target: 8.0, speed: 0.0, supply: 1.0, travel: 0 };
        let (fault, tick) = trips(&sensor, driven, |_| 2.0).unwrap();
        assert!(fault == Fault::MotorOpen && tick < 100, "{fault:?} {tick}");
        // With the whole current, the voltage is 8 V.
        let driven = Driven { effort: 8.0, ..driven };
        assert_eq!(trips(&sensor, driven, |_| 4.0), None);
    }

    #[test]
    fn a_reading_is_a_current_by_the_offset_at_rest_and_the_direction() {
        for (direction, sign) in [(Direction::Forward, 1.0), (Direction::Reverse, -1.0)] {
            let sensor = sensor(direction);
            let mut state = at_rest(&sensor, 2100);
            for (reading, expected) in [(2100, 0.0), (2304, 0.9963), (1690, -2.0024)] {
                let found = sensor.measure(&mut state, reading);
                assert!((found - sign * expected).abs() < 1e-3, "{reading}: {found} A");
                assert!((sensor.heat_volts(&state) - 2.0 * found.abs()).abs() < 1e-6);
            }
            // 9 A are 1842.75 readings.
            assert_eq!(sensor.window(&state), [258, 3942]);
        }
    }

    /// The lagged expectation, 1.75 A (1 - exp(-t / 20 ms)), exceeds 0.2 A after 2.4 ms, and the
    /// condition holds for 20 ticks from there.
    #[test]
    fn an_open_wire_is_found_in_23_ms_and_a_dead_sensor_by_the_motion() {
        let sensor = sensor(Direction::Forward);
        for sign in [1.0, -1.0f32] {
            let stands = Driven { effort: sign * 4.0, ..STANDS };
            let (fault, tick) = trips(&sensor, stands, |_| 0.0).unwrap();
            assert!(fault == Fault::MotorOpen && (20..=25).contains(&tick), "{fault:?} {tick}");
            let moves = Driven { speed: sign, travel: sign as i32, ..stands };
            let (fault, _) = trips(&sensor, moves, |_| 0.0).unwrap();
            assert_eq!(fault, Fault::CurrentSensor);
            // A motor that a load drives against its effort has no current either.
            let driven = Driven { travel: -sign as i32, ..stands };
            assert_eq!(trips(&sensor, driven, |_| 0.0).unwrap().0, Fault::MotorOpen);
        }
        // Less than 0.2 A + 0.5 V / 2 ohm proves nothing.
        for effort in [0.4, 0.7, 0.89] {
            assert_eq!(trips(&sensor, Driven { effort, ..STANDS }, |_| 0.0), None, "{effort} V");
        }
    }

    #[test]
    fn a_current_the_other_way_is_a_sensor_and_one_beyond_twice_the_expected_is_a_short() {
        let sensor = sensor(Direction::Forward);
        for (effort, current, expected) in [
            (4.0, -2.0, Some(Fault::CurrentSensor)),
            (-4.0, 2.0, Some(Fault::CurrentSensor)),
            (4.0, 5.0, Some(Fault::MotorShorted)),
            (0.0, 0.25, Some(Fault::MotorShorted)),
            (4.0, 4.1, None),
            (0.0, 0.17, None),
            (4.0, 0.5, None),
        ] {
            let found = trips(&sensor, Driven { effort, ..STANDS }, |_| current);
            assert_eq!(found.map(|(fault, _)| fault), expected, "{effort} V, {current} A");
        }
    }

    /// An effort of 4 V to and fro every 5 ms to 50 ms, through windings with L / R up to 5 ms.
    #[test]
    fn the_lag_of_a_winding_is_no_fault_at_any_period_of_the_effort() {
        let sensor = sensor(Direction::Forward);
        for time_constant in [0.0, 0.001, 0.005f32] {
            for period in [1, 2, 5, 10, 20, 50] {
                let mut state = at_rest(&sensor, 2048);
                let (mut current, decay) = (0.0, (-0.001 / time_constant).exp());
                for tick in 0..1000 {
                    let effort = if tick / period % 2 == 0 { 4.0 } else { -4.0 };
                    current = effort / 2.0 + (current - effort / 2.0) * decay;
                    sensor.measure(&mut state, (2048.0 + current / sensor.unit).round() as u16);
                    let driven = Driven { effort, ..STANDS };
                    let found = sensor.check(&mut state, &driven);
                    assert_eq!(found, None, "{time_constant} s, {period} ms, {tick}");
                }
            }
        }
    }

    /// 100 deg/s induce 5 V, or 20 % more or less. The effort of 6 V causes from 0 A to 1 A.
    #[test]
    fn a_back_emf_that_is_off_by_a_fifth_is_no_fault_at_speed() {
        let sensor = sensor(Direction::Forward);
        let fast = Driven { effort: 6.0, target: 6.0, speed: 100.0, supply: 1.0, travel: 10 };
        for current in [0.0, 0.25, 0.5, 1.0] {
            assert_eq!(trips(&sensor, fast, |_| current), None, "{current} A");
        }
        // At 9 V it is 1.5 A at least, less the dead time.
        let driven = Driven { effort: 9.0, ..fast };
        assert_eq!(trips(&sensor, driven, |_| 0.0).unwrap().0, Fault::CurrentSensor);
        assert_eq!(trips(&sensor, driven, |_| 1.5), None);
    }

    /// The effort is to and fro around the back-EMF: no current is expected, but for the fifth by
    /// which the back-EMF is off, 0.5 A.
    #[test]
    fn a_back_emf_that_is_off_is_no_short_where_the_effort_is_about_as_large() {
        let sensor = sensor(Direction::Forward);
        let mut state = at_rest(&sensor, 2048);
        for tick in 0..1000 {
            let effort = if tick % 2 == 0 { 5.1 } else { 4.9 };
            sensor.measure(&mut state, (2048.0 + 0.5 / sensor.unit) as u16);
            let driven = Driven { effort, target: effort, speed: 100.0, supply: 1.0, travel: 10 };
            assert_eq!(sensor.check(&mut state, &driven), None, "{tick}");
        }
    }

    /// A sensor with a third of its gain: 4 V cause 1.75 A at least, and 0.6 A are measured.
    #[test]
    fn a_sensor_that_reads_too_little_heats_the_winding_by_half_of_the_effort() {
        let sensor = sensor(Direction::Forward);
        let mut state = at_rest(&sensor, 2048);
        for _ in 0..500 {
            sensor.measure(&mut state, (2048.0 + 0.6 / sensor.unit) as u16);
            assert_eq!(sensor.check(&mut state, &STANDS), None);
        }
        let heats = sensor.heat_volts(&state);
        assert!((heats - 0.5 * 1.75 * 2.0).abs() < 1e-3, "{heats} V");
    }
}
