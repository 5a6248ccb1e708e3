//! Why the servo refuses to move.
//!
//! `docs/faults.md` says of each what it means and what to check.

/// The number of faults that a servo remembers.
pub const HISTORY: usize = 8;

/// A latched fault: the output stays off until it is cleared or the part is reset, and the reset after it says why.
///
/// The number is what is kept in memory across a reset and what goes over the link; it never changes its meaning.
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
    /// The bridge pulled the break input: overcurrent, or what else its driver reports there.
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
    /// The encoder moved further in one tick than the joint can.
    EncoderJump = 13,
    /// Effort beyond any friction, and the encoder does not count: the joint is blocked, or a wire is cut.
    Stall = 14,
    /// The first move went against the effort: encoder or motor is wired the wrong way around.
    EncoderReversed = 15,
    /// The joint does not follow its set point.
    FollowingError = 16,
    /// Faster than the loop was made for.
    Overspeed = 17,
    /// Outside of the range of positions.
    PositionLimit = 18,
    /// The supply of the bridge is too low.
    SupplyLow = 19,
    /// The supply of the bridge is too high.
    SupplyHigh = 20,
    /// The motor has taken more effort than it can lose as heat.
    Overheat = 21,
    /// Armed by a link that has fallen silent.
    LinkTimeout = 22,
}

impl Fault {
    /// All of them.
    pub const ALL: [Self; 22] = [
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
        Self::EncoderJump,
        Self::Stall,
        Self::EncoderReversed,
        Self::FollowingError,
        Self::Overspeed,
        Self::PositionLimit,
        Self::SupplyLow,
        Self::SupplyHigh,
        Self::Overheat,
        Self::LinkTimeout,
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
            Self::EncoderJump => "encoder jump",
            Self::Stall => "stall: effort, but no count",
            Self::EncoderReversed => "encoder or motor reversed",
            Self::FollowingError => "following error",
            Self::Overspeed => "overspeed",
            Self::PositionLimit => "position limit",
            Self::SupplyLow => "supply low",
            Self::SupplyHigh => "supply high",
            Self::Overheat => "motor overheated (model)",
            Self::LinkTimeout => "link silent while armed",
        }
    }

    /// The unit of the value that tripped it; empty if there is no such value.
    pub const fn unit(self) -> &'static str {
        match self {
            Self::EncoderJump | Self::EncoderReversed | Self::FollowingError | Self::PositionLimit => "deg",
            Self::Overspeed => "deg/s",
            Self::Stall | Self::SupplyLow | Self::SupplyHigh | Self::Overheat => "V",
            Self::LinkTimeout => "s",
            _ => "",
        }
    }

    /// Whether a command can clear it. Without a crystal neither the tick nor the link keeps its time, and only a
    /// reset tries again; missing and bad parameters end with good ones.
    pub const fn is_clearable(self) -> bool {
        !matches!(self, Self::ClockAbsent | Self::ClockLost | Self::NoParameters | Self::BadParameters)
    }
}

/// A fault, when it was, and what tripped it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Latched {
    /// Which.
    pub fault: Fault,
    /// Ticks from power-on to the fault.
    pub tick: u32,
    /// What tripped it, in [`Fault::unit`]; zero if it has none.
    pub value: f32,
}

impl From<Fault> for Latched {
    fn from(fault: Fault) -> Self {
        Self { fault, tick: 0, value: 0.0 }
    }
}

/// The last faults.
#[derive(Clone, Copy, Debug, Default)]
pub struct FaultLog {
    /// A ring: the fault number `n` of all that there were is at `n` modulo its length.
    entries: [Option<Latched>; HISTORY],
    count: u32,
}

impl FaultLog {
    /// Adds one.
    pub fn push(&mut self, latched: Latched) {
        if let Some(entry) = self.entries.get_mut(self.count as usize % HISTORY) {
            *entry = Some(latched);
        }
        self.count = self.count.saturating_add(1);
    }

    /// Those that are remembered, the oldest first.
    pub fn iter(&self) -> impl Iterator<Item = &Latched> {
        let oldest = self.count as usize % HISTORY;
        (0..HISTORY).filter_map(move |i| self.entries.get((oldest + i) % HISTORY)?.as_ref())
    }

    /// How many there were, remembered or not.
    pub const fn count(&self) -> u32 {
        self.count
    }
}
