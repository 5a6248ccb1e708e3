//! The faults, which are the reasons why the servo refuses to move.
//!
//! `docs/reference/faults.md` explains each fault and what to check.

use crate::safety::monitor::limits::Limits;
use crate::units::value::{Key, Table, key};

/// Number of faults in the log of a servo.
pub const HISTORY: usize = 8;

/// Declares the faults: `number Name "a few words", "its section in docs/reference/faults.md",
/// "value that trips it" "its unit", "seen within", what ends it, reaction "its reason", [limits]`.
macro_rules! faults {
    ($($(#[doc = $text:literal])+ $code:literal $Fault:ident $words:literal, $section:literal,
        $value:literal $unit:literal, $within:literal, $end:ident,
        $reaction:ident $why:literal, [$($limit:ident),*];)+) => {
        /// A reason why the output is off. Once latched, a fault keeps the output off until the
        /// fault is cleared or the microcontroller is reset. After the reset, the device reports
        /// the fault.
        ///
        /// The fault's number is kept in memory across a reset and sent over the link. Its meaning
        /// never changes.
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        #[repr(u8)]
        pub enum Fault {
            $($(#[doc = $text])+ $Fault = $code,)+
        }

        impl Fault {
            /// All faults, in the order of their numbers.
            pub const ALL: &'static [Self] = &[$(Self::$Fault),+];

            /// Returns a short description for a log.
            pub const fn describe(self) -> &'static str {
                match self {
                    $(Self::$Fault => $words,)+
                }
            }

            /// Returns the unit of the value that tripped the fault; empty if there is no such
            /// value.
            pub const fn unit(self) -> &'static str {
                match self {
                    $(Self::$Fault => $unit,)+
                }
            }

            /// Returns how the fault ends.
            const fn end(self) -> End {
                match self {
                    $(Self::$Fault => End::$end,)+
                }
            }

            /// Returns the reaction of an armed servo to the fault.
            pub const fn reaction(self) -> Reaction {
                match self {
                    $(Self::$Fault => Reaction::$reaction,)+
                }
            }

            /// Returns the reason for the [reaction](Self::reaction), for hosts.
            pub const fn reason(self) -> &'static str {
                match self {
                    $(Self::$Fault => $why,)+
                }
            }

            /// Returns the meaning of the fault, for hosts: the doc of its declaration.
            pub const fn text(self) -> &'static str {
                match self {
                    $(Self::$Fault => concat!($($text),+),)+
                }
            }

            /// Returns the name of the value that trips the fault, for hosts; empty if there is
            /// none.
            pub const fn value(self) -> &'static str {
                match self {
                    $(Self::$Fault => $value,)+
                }
            }

            /// Returns the fault's section in docs/reference/faults.md, for hosts.
            pub const fn section(self) -> &'static str {
                match self {
                    $(Self::$Fault => $section,)+
                }
            }

            /// Returns the time within which the fault is detected, as a text for hosts.
            pub const fn seen_within(self) -> &'static str {
                match self {
                    $(Self::$Fault => $within,)+
                }
            }

            /// Returns the keys of the fault's thresholds, for hosts.
            pub const fn limits(self) -> &'static [Key] {
                match self {
                    $(Self::$Fault => const { &[$(key(Limits::ABOUT, stringify!($limit))),*] },)+
                }
            }
        }
    };
}

/// The way in which a fault ends.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum End {
    /// The fault stays until a command clears it.
    Clear,
    /// The fault stays until the device has valid parameters.
    Parameters,
    /// A reset ends the fault: without a crystal neither the tick nor the link keeps its time, and
    /// only a reset tries again.
    Reset,
}

/// Reaction of an armed servo to a fault.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Reaction {
    /// The output is off at once, and the joint coasts.
    Off,
    /// The output is at zero volts for `short_brake_s`, and then off.
    ShortBrake,
    /// The loop brakes the joint for `stop_s` at most, and then the output is off. Without a
    /// controlled stop, the same as a short brake.
    Stop,
}

faults! {
    /// The parameter sectors are empty.
    1 NoParameters "no parameters", "1 No parameters",
        "" "", "at boot", Parameters,
        Off "the output is off at boot", [];
    /// The parameter sectors hold something that was refused.
    2 BadParameters "bad parameters", "2 Bad parameters",
        "" "", "at boot", Parameters,
        Off "the output is off at boot", [];
    /// The crystal did not start: tick and baud rate have the error of the internal oscillator.
    3 ClockAbsent "crystal absent", "3, 4 Crystal",
        "" "", "at boot", Reset,
        Off "the output is off at boot", [];
    /// The crystal stopped.
    4 ClockLost "crystal lost", "3, 4 Crystal",
        "" "", "at once", Reset,
        Off "the program starts again", [];
    /// The control task came too late or took too long.
    5 Overrun "control overrun", "5 Control overrun",
        "" "", "the tick after", Clear,
        Off "ticks that are late do not end a brake in time", [];
    /// The bridge pulled the break input: overcurrent, or what else its driver reports there.
    6 BreakInput "break input", "6 Break input",
        "" "", "at once, in hardware", Clear,
        Off "the hardware has turned the bridge off, which may be broken", [];
    /// The watchdog reset the part: the control task had stopped running.
    7 Watchdog "watchdog reset", "7 Watchdog reset",
        "" "", "when the watchdog of the board runs out", Clear,
        Off "the reset has turned the output off", [];
    /// The supply sagged.
    8 BrownOut "brown-out", "8, 9 Resets",
        "" "", "at boot", Clear,
        Off "the reset has turned the output off", [];
    /// The part was reset while the servo was armed.
    9 ResetWhileArmed "reset while armed", "8, 9 Resets",
        "" "", "at boot", Clear,
        Off "the reset has turned the output off", [];
    /// The program stopped itself.
    10 Panic "panic", "10, 11 Panic and hard fault",
        "" "", "at once", Clear,
        Off "no program runs that would end a brake", [];
    /// The processor stopped the program.
    11 HardFault "hard fault", "10, 11 Panic and hard fault",
        "" "", "at once", Clear,
        Off "no program runs that would end a brake", [];
    /// A term of the control law was not a finite number.
    12 NonFinite "value not finite", "12 Value not finite",
        "" "", "its tick", Clear,
        ShortBrake "zero volts need no law", [];
    /// The encoder moved further in one tick than the joint can.
    13 EncoderJump "encoder jump", "13 Encoder jump",
        "travel" "deg", "its tick", Clear,
        ShortBrake "zero volts need no encoder", [encoder_jump];
    /// Effort beyond any friction, and the encoder does not count: the joint is blocked, or a wire
    /// is cut.
    14 Stall "stall: effort, but no count", "14 Stall",
        "effort" "V",
        "`stall_s` beyond `stall_v`, or too little travel there; 0.125 to 4 s beyond \
         `breakaway_v`, 5 s and more without net travel; up to 3.4 s beyond `breakaway_min_v`; \
         20 to 60 ms in motion",
        Clear,
        ShortBrake "zero volts need no encoder",
        [stall_effort, stall_time, breakaway_effort, stall_impulse, stop_gain, progress_gain,
            breakaway_min, probe_error, play];
    /// The first move went against the effort: encoder or motor is wired the wrong way around.
    15 EncoderReversed "encoder or motor reversed", "15 Encoder or motor reversed",
        "travel" "deg", "`reversal_deg` of travel", Clear,
        ShortBrake "zero volts need no encoder", [reversal];
    /// The joint does not follow its set point.
    16 FollowingError "following error", "16 Following error",
        "error" "deg", "its tick", Clear,
        ShortBrake "the loop has lost the joint, the bridge is sound", [following_error];
    /// Faster than the loop was made for.
    17 Overspeed "overspeed", "17 Overspeed",
        "speed" "deg/s", "`velocity_window` ticks; under `robust` up to 0.15 s", Clear,
        ShortBrake "the faster the joint, the stronger the brake", [overspeed];
    /// Outside of the range of positions.
    18 PositionLimit "position limit", "18 Position limit",
        "position" "deg", "its tick", Clear,
        ShortBrake "a shorter way to the stop", [position_min, position_max];
    /// The supply of the bridge is too low.
    19 SupplyLow "supply low", "19, 20 Supply",
        "supply" "V", "3 ticks", Clear,
        Off "a driver without supply does not hold its low sides on", [supply_min];
    /// The supply of the bridge is too high.
    20 SupplyHigh "supply high", "19, 20 Supply",
        "supply" "V", "3 ticks", Clear,
        Off "a bridge above its voltage must not switch", [supply_max];
    /// The motor has taken more effort than it can lose as heat.
    21 Overheat "motor overheated (model)", "21 Motor overheated",
        "steady effort of that heat" "V", "a model, not a measurement", Clear,
        ShortBrake "the energy of the joint heats the winding little",
        [continuous_effort, thermal_time];
    /// Armed by a link that has fallen silent.
    22 LinkTimeout "link silent while armed", "22 Link silent",
        "silence" "s", "`link_timeout_s`", Clear,
        Stop "loop and encoder are sound", [link_timeout];
    /// The crystal has none of the frequencies that the part runs from, so it runs without it.
    23 ClockWrong "crystal of another frequency", "23 Crystal of another frequency",
        "frequency" "MHz", "at boot", Reset,
        Off "the output is off at boot", [];
    /// The joint swings to and fro around a set point that rests.
    24 Oscillation "oscillation", "24 Oscillation",
        "time of the swings" "s", "`oscillation_s`", Clear,
        ShortBrake "zero volts swing with no loop", [oscillation_time];
    /// A line of the encoder is open: at rest it followed the resistors of the input.
    25 EncoderOpen "open line of the encoder", "25 Open line of the encoder",
        "open lines" "(1: A, 2: B, 3: both)",
        "42 ms at rest, or 33 ticks; then every second", Clear,
        ShortBrake "zero volts need no encoder", [];
    /// The encoders of motor and load are further apart than the gear allows, and one is silent.
    26 EncodersDisagree "encoders disagree", "26 Encoders disagree",
        "twist of the gear" "deg",
        "5 ticks beyond the gear's twist, with one silent for 20 ms or both in opposite motion",
        Clear,
        ShortBrake "zero volts need no encoder", [];
    /// The absolute encoder on the load has sent no valid answer.
    27 EncoderSilent "encoder does not answer", "27 Encoder does not answer",
        "time without an answer" "ticks", "5 ticks; 0.1 s after power-on", Clear,
        ShortBrake "zero volts need no encoder", [];
    /// The motor's current was beyond `current_sensor.trip_a`.
    28 OverCurrent "over-current", "28 Over-current",
        "current" "A", "a period of the PWM", Clear,
        Off "the bridge must not conduct", [];
    /// The sensor of the motor's current is dead or reversed, or its offset is off.
    29 CurrentSensor "current sensor", "29 Current sensor",
        "current" "A", "20 to 100 ms under effort; longer with a sample time above 5 ms", Clear,
        Off "the current of the brake would not be seen", [];
    /// No current flows under effort: a wire of the motor is open, or the bridge does not drive.
    30 MotorOpen "no motor current", "30 No motor current",
        "current" "A", "20 to 100 ms under effort; longer with a sample time above 5 ms", Clear,
        Off "an open winding brakes nothing, and a loose wire may arc", [];
    /// More current flows than the resistance of the winding allows.
    31 MotorShorted "too much motor current", "31 Too much motor current",
        "current" "A", "20 to 100 ms; longer with a sample time above 5 ms", Clear,
        Off "a shorted winding heats", [];
    /// The contact of the emergency stop, or its wire, is open.
    32 EmergencyStop "emergency stop", "32 Emergency stop",
        "" "", "at once, in hardware", Clear,
        Off "the contact is to end all power", [];
    /// The counts between two passes of the encoder's index are not those of whole turns, or the
    /// index did not come: counts were lost or added.
    33 IndexDeviation "counts and index differ", "33 Counts and index differ",
        "deviation" "counts", "the next pass of the index, or a turn of the encoder without one",
        Clear,
        ShortBrake "zero volts need no encoder", [];
    /// The measured temperature of the motor is beyond `motor_ntc.limit_c`.
    34 MotorHot "motor too hot", "34 Motor too hot",
        "temperature" "deg C", "0.2 s", Clear,
        ShortBrake "the energy of the joint heats the winding little", [];
    /// The temperature sensor of the motor is open or shorted.
    35 MotorSensor "motor's temperature sensor", "35 Temperature sensor",
        "reading" "steps of the converter", "0.4 s", Clear,
        ShortBrake "the bridge is sound", [];
}

impl Fault {
    /// Returns the fault with this number, if there is one.
    ///
    /// ```
    /// use stiction::Fault;
    /// assert!(Fault::ALL.iter().all(|fault| Fault::from_code(*fault as u8) == Some(*fault)));
    /// assert_eq!(Fault::from_code(0), None);
    /// ```
    pub fn from_code(code: u8) -> Option<Self> {
        Self::ALL.iter().copied().find(|fault| *fault as u8 == code)
    }

    /// Returns whether a command can clear the fault. Missing and bad parameters end once the
    /// device has valid ones.
    pub const fn is_clearable(self) -> bool {
        matches!(self.end(), End::Clear)
    }

    /// Returns whether the fault may come from the encoder, so that its counts are in doubt.
    pub const fn doubts_encoder(self) -> bool {
        matches!(
            self,
            Self::EncoderJump
                | Self::Stall
                | Self::EncoderReversed
                | Self::EncoderOpen
                | Self::EncodersDisagree
        )
    }

    /// Returns whether valid parameters end the fault.
    pub const fn ends_with_parameters(self) -> bool {
        matches!(self.end(), End::Parameters)
    }
}

/// A fault that is latched, with its time and the value that tripped it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LatchedFault {
    /// The fault.
    pub fault: Fault,
    /// Ticks from power-on to the fault.
    pub tick: u32,
    /// Value that tripped the fault, in [`Fault::unit`]; zero if the fault has none.
    pub value: f32,
}

impl From<Fault> for LatchedFault {
    fn from(fault: Fault) -> Self {
        Self { fault, tick: 0, value: 0.0 }
    }
}

/// The log of the last faults.
#[derive(Clone, Copy, Debug, Default)]
pub struct FaultLog {
    /// The last faults, in a ring: fault number `n`, counted from zero, is at `n` modulo the
    /// length.
    entries: [Option<LatchedFault>; HISTORY],
    count: u32,
}

impl FaultLog {
    /// Adds a fault, in the place of the oldest one if the log is full.
    pub fn push(&mut self, latched: LatchedFault) {
        if let Some(entry) = self.entries.get_mut(self.count as usize % HISTORY) {
            *entry = Some(latched);
        }
        self.count = self.count.saturating_add(1);
    }

    /// Returns the faults in the log, the oldest first.
    pub fn iter(&self) -> impl Iterator<Item = &LatchedFault> {
        let oldest = self.count as usize % HISTORY;
        (0..HISTORY).filter_map(move |i| self.entries.get((oldest + i) % HISTORY)?.as_ref())
    }

    /// Returns the number of faults so far, including those no longer in the log.
    pub const fn count(&self) -> u32 {
        self.count
    }
}
