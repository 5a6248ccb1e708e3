//! Why the servo refuses to move.

/// A latched fault: the output stays off until the next reset, and the reset after it says why.
///
/// The number is what is kept in memory across a reset; it never changes its meaning.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub enum Fault {
    /// The parameter sectors are empty.
    NoParameters = 1,
    /// The parameter sectors hold something that was refused.
    BadParameters = 2,
    /// The crystal did not start: neither tick nor baud rate are what they say.
    ClockAbsent = 3,
    /// The crystal stopped.
    ClockLost = 4,
    /// The control task came too late or took too long.
    Overrun = 5,
    /// The bridge pulled the break input.
    BreakInput = 6,
    /// The watchdog reset the part: the control task had stopped running.
    Watchdog = 7,
    /// The supply sagged.
    BrownOut = 8,
    /// The part was reset while the servo was armed.
    ResetWhileArmed = 9,
    /// The program stopped itself.
    Panic = 10,
    /// The processor stopped the program.
    HardFault = 11,
    /// A term of the control law was not a finite number.
    NonFinite = 12,
}

impl Fault {
    /// All of them.
    pub const ALL: [Self; 12] = [
        Self::NoParameters,
        Self::BadParameters,
        Self::ClockAbsent,
        Self::ClockLost,
        Self::Overrun,
        Self::BreakInput,
        Self::Watchdog,
        Self::BrownOut,
        Self::ResetWhileArmed,
        Self::Panic,
        Self::HardFault,
        Self::NonFinite,
    ];

    /// The fault of a number.
    ///
    /// ```
    /// use stiction::Fault;
    /// assert!(Fault::ALL.iter().all(|fault| Fault::from_code(*fault as u8) == Some(*fault)));
    /// assert_eq!(Fault::from_code(0), None);
    /// ```
    pub fn from_code(code: u8) -> Option<Self> {
        Self::ALL.into_iter().find(|fault| *fault as u8 == code)
    }

    /// A few words for a log.
    pub const fn describe(self) -> &'static str {
        match self {
            Self::NoParameters => "no parameters",
            Self::BadParameters => "bad parameters",
            Self::ClockAbsent => "crystal absent",
            Self::ClockLost => "crystal lost",
            Self::Overrun => "control overrun",
            Self::BreakInput => "break input",
            Self::Watchdog => "watchdog reset",
            Self::BrownOut => "brown-out",
            Self::ResetWhileArmed => "reset while armed",
            Self::Panic => "panic",
            Self::HardFault => "hard fault",
            Self::NonFinite => "value not finite",
        }
    }
}
