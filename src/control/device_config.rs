//! `[device]` of a machine's file: values that only a device has and a simulated loop does not
//! need.

use crate::units::error::HUGE;
use crate::units::value::{Table, choice, table};

choice! {
    /// What makes the position of a joint known, on which the range of positions rests.
    pub enum PositionReference {
        /// The joint stands at zero whenever the device starts.
        PowerOn = 0 "power-on",
        /// A command says where the joint stands.
        Command = 1 "command",
    }
}

choice! {
    /// Contact of a homing switch between PA7 and ground.
    pub enum HomeSwitch {
        /// There is no switch.
        None = 0 "none",
        /// The contact opens where the joint is at the switch. An open wire reads as that.
        NormallyClosed = 1 "normally-closed",
        /// The contact closes where the joint is at the switch. An open wire is not detected.
        NormallyOpen = 2 "normally-open",
    }
}

table! {
    /// The configuration that only a device has. By default the device neither starts nor scales
    /// anything by itself.
    #[derive(Clone, Copy, Debug, PartialEq)]
    pub struct DeviceConfig (device) "device" {
        /// Arm without a command, `autostart_delay_s` after power-on. After an unrequested reset
        /// nothing arms, nor after one that may be a dip of the supply (`autostart_after_dip`).
        autostart: bool = 0x0801 "autostart", Any, Default(false);
        /// Time from the first tick to arming by itself, s.
        autostart_delay: f32 = 0x0802 "autostart_delay_s", Between(0.0, 60.0), Default(1.0);
        /// Time in which the output's limit rises from zero to the full scale after arming, s; 0 is
        /// at once. The product of its ticks and the codes fits 32 bits up to 10 s at 10 kHz.
        soft_start: f32 = 0x0803 "soft_start_s", Between(0.0, 10.0), Default(0.5);
        /// Time between the switching of complementary outputs in locked antiphase, s. The other
        /// modes have none from the board: in sign-magnitude it is that of the bridge's driver, for
        /// which the faults of the current allow. The board's timer sets the longest one: 6e-6 at
        /// 168 MHz.
        dead_time: f32 = 0x0804 "dead_time_s", Between(0.0, 1e-3), Default(1e-6);
        /// Supply for which the gains were found, V: the output is scaled by its ratio to the
        /// measured supply. 0 leaves the output alone. Up to `supply_full_scale_v`.
        nominal_supply: f32 =
            0x0805 "nominal_supply_v", Between(0.0, device.supply_full_scale), Default(0.0);
        /// Supply at the full scale of the converter, V; 0: the supply is not measured.
        supply_full_scale: f32 = 0x0806 "supply_full_scale_v", Between(0.0, 100.0), Default(0.0);
        /// Time from the enable pin's rise to the first duty, s: what the bridge's driver takes to
        /// wake up. The loop does not run meanwhile.
        wake_up: f32 = 0x0807 "wake_up_s", Between(0.0, 1.0), Default(0.0);
        /// Time from the enable pin's rise for which the break input is ignored, s: for a driver
        /// that holds its fault output low while it sleeps and wakes up. If not 0, the input is
        /// also ignored while the output is off. Up to `wake_up_s`, so that no duty goes without
        /// the break input.
        fault_blanking: f32 =
            0x0808 "fault_blanking_s", Between(0.0, device.wake_up), Default(0.0);
        /// Time for which the enable pin is low at least before it rises again, s: the pulse by
        /// which the bridge's driver forgets a latched fault.
        reset_pulse: f32 = 0x0809 "reset_pulse_s", Between(0.0, 1.0), Default(0.0);
        /// Autostart also where power-on cannot be distinguished from a dip of the supply: on a
        /// microcontroller whose brown-out reset is off, the factory's setting.
        autostart_after_dip: bool = 0x080A "autostart_after_dip", Any, Default(false);
        /// Longest time of a stop, s: the loop brakes the joint, then the output is off. So does a
        /// link that falls silent. 0: the output is off at once, and the joint coasts.
        stop_time: f32 = 0x080B "stop_s", Between(0.0, 10.0), Default(1.0);
        /// What makes the position known on which `position_min_deg` and `position_max_deg` rest.
        /// `command`: after a reset, and after a stall, a jump or a reversal, only a jog and a
        /// homing move a joint with a range, until `device home` finds a stop or `device reference`
        /// sets where it stands. `power-on`: it stands at zero after each reset. Another
        /// `[encoder]` and a homing that finds no stop end either.
        reference: PositionReference =
            0x080C "reference", Any, Default(PositionReference::PowerOn);
        /// Whether the bridge's high-side drivers are bootstrapped: their capacitors charge only
        /// while the low side conducts. `duty_max` has to leave 2 us of that in each period then,
        /// beside the dead times.
        bootstrapped: bool = 0x080D "bootstrapped", Any, Default(false);
        /// Whether the contact of an emergency stop is connected to PA6. The bridge is off while
        /// the contact or its wire is open, and the device reports fault 32. The contact has to act
        /// in hardware, too (docs/reference/wiring.md).
        emergency_stop: bool = 0x080E "emergency_stop", Any, Default(false);
        /// Time in which a holding brake opens, s. After arming, the loop holds the joint until the
        /// soft start is over; then the brake opens, and the motion starts after this time. 0 here
        /// and in `brake_close_s`: there is no brake.
        brake_open: f32 = 0x080F "brake_open_s", Between(0.0, 2.0), Default(0.0);
        /// Time in which a holding brake closes, s: the loop holds the joint for this time at the
        /// end of a stop, then the output is off. A fault closes the brake and turns the output off
        /// at once.
        brake_close: f32 = 0x0810 "brake_close_s", Between(0.0, 2.0), Default(0.0);
        /// Time of the short brake after a fault, s: the bridge stays on at zero volts, so that the
        /// back-EMF brakes the joint, and is off then. docs/reference/faults.md has the faults. 0:
        /// the bridge is off at once, and the joint coasts. Not with an analog amplifier.
        short_brake: f32 = 0x0811 "short_brake_s", Between(0.0, 10.0), Default(0.0);
        /// Largest travel of the motor in a test after arming, deg of the joint: a slow effort
        /// pushes the joint until each encoder has counted, and back, before the loop closes. Dead
        /// and reversed encoders and a broken coupling are faults then. At least 16 counts, and
        /// `motor_encoder.twist_deg` with two encoders; the bounds of `[jog]` hold, too. Off: the
        /// loop closes at once.
        arming_test: f32 = 0x0816 "arming_test_deg", OrOff(0.0, HUGE), Default(0.0);
        /// Contact of a homing switch between PA7 and ground. `normally-closed`: it opens at the
        /// switch, as does a cut wire, so that a homing does not end at a false place.
        /// `normally-open`: a cut wire reads as a switch that never comes.
        home_switch: HomeSwitch = 0x0812 "home_switch", Any, Default(HomeSwitch::None);
        /// Time for which the level of the homing switch has to be the same to count, s, rounded up
        /// to ticks: one at least. Its edge is where that time began.
        home_switch_filter: f32 =
            0x0813 "home_switch_filter_s", Between(0.0, 0.1), Default(0.002);
        /// Counts between two passes of the encoder's index (Z) on PA2: four times its lines,
        /// however many turns of it a turn of the joint has. At each pass the counts are checked.
        /// Of two encoders, it is the motor's. 0: there is no index.
        index_counts: u32 = 0x0814 "index_counts", Between(0.0, 16_777_216.0), Default(0);
        /// Width of the index, counts: up to an eighth of `index_counts`. Passes in the two senses
        /// differ by it.
        index_width: u32 = 0x0815 "index_width_counts", Between(0.0, 65_536.0), Default(4);
    }
}

impl DeviceConfig {
    /// Configuration without autostart and without scaling by the supply. It has half a second of
    /// soft start and one microsecond of dead time.
    pub const CAUTIOUS: Self = Self::EXAMPLE;
}
