//! Pulses of voltage at standstill that show the resistance and the inductance of the winding.
//!
//! ```text
//!  u  +U --+     +-----+     a half cycle has 32 groups of n periods of the PWM
//!          |     |     |     i_q = sum of +-i over the periods of group q, +-: sign of U
//!     -U   +-----+     +---  the first half cycle has half the length
//! ```
//!
//! The reading of a period is taken half a period after its voltage began to act, at the upper end
//! of the count. So group q covers the times from `(q n + 1/2) T` to `(q n + n - 1/2) T` after the
//! voltage has changed its sign. The offset of the sensor adds to every second half cycle and is
//! subtracted in the others.
//!
//! The mean voltage is zero, and the first half cycle is short: a joint without friction would
//! swing around its place, and would not drift. The first two cycles are not counted, in which the
//! current comes to its steady alternation.
//!
//! Does badly: it does not limit the current within a tick. In sign-magnitude, a bridge whose
//! direction changes at once has the new sign half a period earlier.

use crate::control::drive::{Drive, DriveConfig, Duty};

/// Number of groups of a half cycle: five bytes each, they fit in one message.
pub const GROUPS: usize = 32;

/// Largest number of the PWM's periods in a group: 32 groups are 0.1 s at 20 kHz, twenty time
/// constants of a winding of 5 ms.
pub const MOST_PERIODS: u8 = 64;

/// Largest number of counted cycles. 2000 cycles of 64 periods with readings of 4095 are
/// 5.2e8 in a sum, a quarter of what it holds.
pub const MOST_CYCLES: u16 = 2000;

/// Half cycles before the counted ones, the short one included.
const BEFORE: u32 = 5;

/// Sums of the readings over the half cycles, with the sign of the voltage, group by group.
pub type GroupSums = [i32; GROUPS];

/// Pulses, prepared for the periods of the PWM.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WindingPulses {
    drive: Drive,
    code: i16,
    /// Periods of a group.
    periods: u8,
    /// Half cycles, with those that are not counted.
    halves: u32,
}

/// The state of the pulses from period to period.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PulseState {
    /// Begun half cycles; zero before the first period.
    halves: u32,
    /// Place in the half cycle: group, and period of the group.
    group: u8,
    period: u8,
    sums: GroupSums,
}

impl PulseState {
    /// State before the first period.
    pub const NONE: Self = Self { halves: 0, group: 0, period: 0, sums: [0; GROUPS] };

    /// Begins anew. The first counted readings replace the sums, so that an interrupt does not
    /// write them all at once.
    #[inline]
    pub const fn restart(&mut self) {
        (self.halves, self.group, self.period) = (0, 0, 0);
    }
}

impl WindingPulses {
    /// Prepares `cycles` counted cycles of `volts` either way, with `periods` of the PWM in a
    /// group, for a drive that has been validated.
    pub fn new(volts: f32, periods: u8, cycles: u16, drive: Drive) -> Self {
        let halves = BEFORE + 2 * u32::from(cycles);
        Self { drive, code: drive.code(volts), periods, halves }
    }

    /// Returns the compare value of full duty.
    pub const fn top(&self) -> u16 {
        self.drive.pwm_top()
    }

    /// Returns the voltage of the pulses, V.
    pub fn volts(&self, drive: &DriveConfig) -> f32 {
        f32::from(self.code) * drive.lsb
    }

    /// Returns the PWM setting of a code.
    #[inline]
    pub fn duty(&self, code: i16) -> Duty {
        self.drive.duty_of(code.into())
    }

    /// Runs one period: takes the reading of the current, and returns the code that acts next.
    #[inline]
    pub fn step(&self, state: &mut PulseState, reading: u16) -> i16 {
        let PulseState { halves, group, period, .. } = *state;
        if halves > self.halves {
            return 0;
        }
        if halves == 0 {
            // The first reading is one without a voltage.
            (state.halves, state.group) = (1, GROUPS as u8 / 2);
            return self.code;
        }
        let is_negative = halves % 2 == 0;
        if halves > BEFORE
            && let Some(sum) = state.sums.get_mut(usize::from(group))
        {
            let before = if halves == BEFORE + 1 && period == 0 { 0 } else { *sum };
            *sum = before + if is_negative { -i32::from(reading) } else { i32::from(reading) };
        }
        state.period = period + 1;
        if state.period >= self.periods {
            (state.period, state.group) = (0, group + 1);
        }
        if usize::from(state.group) >= GROUPS {
            (state.halves, state.group) = (halves + 1, 0);
        }
        match state.halves {
            over if over > self.halves => 0,
            even if even % 2 == 0 => -self.code,
            _ => self.code,
        }
    }

    /// Returns the sums of the readings once the pulses are over.
    #[inline]
    pub fn sums<'a>(&self, state: &'a PulseState) -> Option<&'a GroupSums> {
        (state.halves > self.halves).then_some(&state.sums)
    }
}

#[cfg(test)]
mod tests {
    extern crate std;
    use std::vec::Vec;

    use super::*;
    use crate::control::drive::PwmMode;
    use crate::control::hardware::Hardware;

    fn drive() -> Drive {
        let config = DriveConfig {
            full_scale: 24.0,
            lsb: 0.001,
            pwm_hz: 20e3,
            mode: PwmMode::LockedAntiphase,
            duty_max: 1.0,
        };
        let hardware = Hardware {
            pwm_clock_hz: 168e6,
            supply_top: 4095,
            dead_time_max: 6e-6,
            sample_time: [1e-4, 0.02],
        };
        Drive::new(&config, &hardware).unwrap()
    }

    /// The codes of all periods, and the sums, with `read` from the code of the period before.
    fn run(pulses: &WindingPulses, mut read: impl FnMut(i16) -> u16) -> (Vec<i16>, GroupSums) {
        let (mut state, mut code, mut codes) = (PulseState::NONE, 0, Vec::new());
        while pulses.sums(&state).is_none() {
            code = pulses.step(&mut state, read(code));
            codes.push(code);
            assert!(codes.len() < 1_000_000);
        }
        assert_eq!(pulses.step(&mut state, 4095), 0);
        (codes, *pulses.sums(&state).unwrap())
    }

    #[test]
    fn voltage_alternates_around_zero_and_the_double_sum_of_a_free_joint_ends_where_it_began() {
        let pulses = WindingPulses::new(1.5, 3, 4, drive());
        let (codes, _) = run(&pulses, |_| 2048);
        // 12.5 half cycles of 96 periods, and the zero at the end.
        assert_eq!(codes.len(), 25 * 48 + 1);
        assert!(codes[..1200].iter().all(|code| code.abs() == 1500));
        assert_eq!(codes.iter().filter(|code| **code == 0).count(), 1);
        // A joint without friction: its speed is the sum of the codes, its place the sum of that.
        let (mut speed, mut place, mut farthest) = (0i64, 0i64, 0i64);
        for code in codes.iter().map(|code| i64::from(code / 1500)) {
            place += speed;
            speed += code;
            farthest = farthest.max(place.abs());
        }
        // 48 half periods of the first half cycle: 48^2 / 2, twice, and no more after that.
        assert!(farthest <= 48 * 48 + 48, "{farthest}");
    }

    #[test]
    fn sums_are_those_of_the_counted_half_cycles_without_the_offset() {
        let pulses = WindingPulses::new(1.5, 2, 3, drive());
        // A winding without inductance: 7 readings with the sign of the last voltage.
        let (_, sums) = run(&pulses, |code| 2051u16.wrapping_add_signed(7 * code.signum()));
        // 6 half cycles of 2 periods.
        assert_eq!(sums, [7 * 12; GROUPS]);
        // The sums of a measurement before are none of this one.
        let mut state = PulseState { sums: [9; GROUPS], ..PulseState::NONE };
        state.restart();
        let mut code = 0i16;
        while pulses.sums(&state).is_none() {
            code = pulses.step(&mut state, 2051u16.wrapping_add_signed(7 * code.signum()));
        }
        assert_eq!(pulses.sums(&state), Some(&sums));
    }

    #[test]
    fn readings_of_a_group_are_those_after_its_place_in_the_half_cycle() {
        let pulses = WindingPulses::new(1.5, 2, 2, drive());
        let (mut before, mut since) = (0, 0);
        // The reading is the number of periods for which the voltage has had its sign.
        let (_, sums) = run(&pulses, |code| {
            since = if code == before { since + 1 } else { 0 };
            before = code;
            2000u16.wrapping_add_signed(code.signum() * since)
        });
        for (group, sum) in sums.iter().enumerate() {
            let places = 2 * group + (2 * group + 1);
            assert_eq!(*sum, 4 * places as i32, "{group}");
        }
    }

    #[test]
    fn the_largest_sum_fits() {
        let all = i64::from(MOST_CYCLES) * i64::from(MOST_PERIODS) * 4095;
        assert!(2 * all < i64::from(i32::MAX), "{all}");
    }
}
