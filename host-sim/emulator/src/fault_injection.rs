//! Fault injection: injects faults into a board with the unmodified image, and records bridge and
//! log.
//!
//! [`observe`] and [`converse`] have a board with a blocked joint. A board with a joint that moves
//! has its faults injected by its caller.

use std::sync::Arc;

use rigless::session::Reset;
use rigless::soc::Width;

use super::board::FittedParts;
use super::board_under_test::{BoardUnderTest, HaltedBoard, PoweredOffBoard, StopCondition};
use super::bridge::BridgeInputs;
use super::harness::Harness;
use super::image::FirmwareImage;
use super::lockstep::Lockstep;
use super::log::LogLine;
use super::plant_interface::FreeDiscs;
use super::setup::{BoardSetup, Partner};
use super::spans::Spans;
use files::error::Error;

/// First address of the RAM, and bytes of the page below it.
const RAM: u64 = 0x2000_0000;
const PAGE: u64 = 0x1000;
/// Number of accesses below the RAM that a bus error answers: more than two exceptions need.
const BELOW_RAM: usize = 64;

/// Interval at which the log is read, ns. It is shorter than elsewhere, since a reset loses the
/// unread log.
const DRAIN_EVERY_NS: u64 = 2_000_000;
/// Time between two samples until the microcontroller has set its timer, ns.
const SAMPLE_NS: u64 = 20_000_000;

/// Fault of the hardware, or the end of a fault.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Injection {
    /// The bridge's driver pulls the break input.
    Break,
    /// The bridge's driver releases the break input.
    BreakReleased,
    /// The bridge's driver pulls the break input only for an instant, at the worst time: when the
    /// control task has just written the first duty and is about to turn the outputs on.
    BreakAtArming,
    /// The contact of the emergency stop opens, or its wire is cut.
    ContactOpens,
    /// The contact of the emergency stop is closed.
    ContactCloses,
    /// The crystal stops.
    CrystalLost,
    /// The reset pin is pulled.
    Reset,
    /// The supply sags below the brown-out level and comes back at once: a reset with that level's
    /// flag, as on a microcontroller whose option bytes enable it. The emulator itself has no such
    /// level. The RAM stays as it is.
    BrownOut,
    /// The timer of the control tick stops counting.
    TickStops,
    /// The control tick comes now, before its time, and the next one a whole period later.
    TickEarly,
    /// The processor stops while timers and pins continue, as it does when it is locked up, or
    /// halted by a probe, or waits for the flash.
    CoreStalls,
    /// The processor continues where it has stopped.
    CoreGoesOn,
    /// The next access to a register is answered by a bus error.
    BusError {
        /// Address of the register.
        address: u64,
    },
    /// The next accesses to the page below the RAM are answered by bus errors, as on the
    /// microcontroller. Without this injection, the emulator ignores them.
    NothingBelowRam,
    /// Bytes of the RAM change.
    Corrupts {
        /// Address of the first byte.
        address: u64,
        /// Number of bytes.
        length: u64,
        /// New value of each byte.
        to: u8,
    },
}

/// Observations of a board.
#[derive(Clone, Debug)]
pub struct BoardObservation {
    /// Spans of time in which the bridge was on, ns since power-on, exact to the instruction.
    pub on_ns: Vec<[u64; 2]>,
    /// Last time at which the bridge's outputs or its enable pin were on, ns since power-on.
    pub any_ns: u64,
    /// State of the bridge when it was last seen on.
    pub last: BridgeInputs,
    /// Compare values with which the bridge was on, each with the time from which it was set, ns.
    pub compares: Vec<(u64, u16)>,
    /// Times at which the image read the encoder, ns since power-on: early in each control tick.
    pub ticks_ns: Vec<u64>,
    /// Log of the firmware.
    pub log: Vec<LogLine>,
    /// Resets of the microcontroller: time and cause of each.
    pub resets: Vec<Reset>,
}

impl BoardObservation {
    /// Returns whether the bridge was on at any time after `at_ns`.
    pub fn on_after(&self, at_ns: u64) -> bool {
        self.on_ns.iter().any(|[_, until]| *until > at_ns)
    }

    /// Returns the time at which the bridge was last turned off, ns; `None` if it was never on.
    pub fn off_at_ns(&self) -> Option<u64> {
        self.on_ns.last().map(|[_, until]| *until)
    }

    /// Returns whether a line of the log contains `text`.
    pub fn says(&self, text: &str) -> bool {
        self.log.iter().any(|line| line.text.contains(text))
    }
}

/// Powers a board until `until_ns`, and injects each fault at its time (ns, in order). `records`
/// are the contents of the two parameter sectors, 10 and 11; one without any is erased.
///
/// # Errors
/// Returns an error if the image cannot be placed in the flash.
pub fn observe(
    image: &Arc<FirmwareImage>,
    records: [Option<&[u8]>; 2],
    fitted: FittedParts,
    faults: &[(u64, Injection)],
    until_ns: u64,
) -> Result<BoardObservation, Error> {
    observed(image, records, fitted, faults, until_ns, None)
}

/// Observes a board as [`observe`] does, with a partner at the other end of the command link, which
/// is called every 50 us.
///
/// # Errors
/// Returns an error if the image cannot be placed in the flash.
pub fn converse(
    image: &Arc<FirmwareImage>,
    records: [Option<&[u8]>; 2],
    fitted: FittedParts,
    faults: &[(u64, Injection)],
    until_ns: u64,
    partner: Partner,
) -> Result<BoardObservation, Error> {
    observed(image, records, fitted, faults, until_ns, Some(partner))
}

fn observed(
    image: &Arc<FirmwareImage>,
    records: [Option<&[u8]>; 2],
    fitted: FittedParts,
    faults: &[(u64, Injection)],
    until_ns: u64,
    partner: Option<Partner>,
) -> Result<BoardObservation, Error> {
    let mut setup = BoardSetup::new("fault injection", image, Vec::new());
    setup.records = records.map(|record| record.map(<[u8]>::to_vec));
    (setup.fitted, setup.partner, setup.drain_every_ns) = (fitted, partner, DRAIN_EVERY_NS);
    // A firmware that hangs is observed to the end.
    setup.is_guarded = false;
    let blocked = Lockstep::new(FreeDiscs::default(), SAMPLE_NS);
    let mut board = BoardUnderTest::power_on(setup, blocked)?;
    for (at, fault) in faults.iter().copied().filter(|(at, _)| *at <= until_ns) {
        board.until(StopCondition::Time(at))?;
        board.act(move |halted| halted.inject(fault))?;
    }
    board.until(StopCondition::Time(until_ns))?;
    let PoweredOffBoard { harness, resets, .. } = board.off()?;
    let Harness { spans, ticks_ns, log, .. } = harness;
    let Spans { on_ns, any_ns, last, compares, .. } = spans;
    Ok(BoardObservation { on_ns, any_ns, last, compares, ticks_ns, log: log.lines, resets })
}

impl<C> HaltedBoard<'_, C> {
    /// Injects a fault.
    pub fn inject(&mut self, fault: Injection) {
        let (at, instructions) = (self.stop.at, self.stop.instruction_count);
        let Self { session, host, .. } = self;
        match fault {
            Injection::Break => session.board_mut().drive_break(at, true),
            Injection::BreakAtArming => self.harness.breaks_at_arming = true,
            Injection::BreakReleased => session.board_mut().drive_break(at, false),
            Injection::ContactOpens => session.board_mut().drive_contact(at, true),
            Injection::ContactCloses => session.board_mut().drive_contact(at, false),
            Injection::CrystalLost => session.board_mut().lose_crystal(at),
            Injection::Reset => session.reset_by_pin(at, instructions, *host),
            Injection::BrownOut => {
                session.reset_by_pin(at, instructions, *host);
                session.board_mut().flag_brown_out();
            }
            Injection::TickStops => session.board_mut().stop_tick(at),
            Injection::TickEarly => session.board_mut().early_tick(at),
            Injection::CoreStalls => host.hold(true),
            Injection::CoreGoesOn => host.hold(false),
            Injection::BusError { address } => session.fail_next(address, address + 4),
            Injection::NothingBelowRam => {
                (0..BELOW_RAM).for_each(|_| session.fail_next(RAM - PAGE, RAM));
            }
            Injection::Corrupts { address, length, to } => {
                for address in address..address + length {
                    // Outside the RAM nothing changes, and a test of the consequence fails.
                    let _ = host.write(address, Width::W8, u64::from(to));
                }
            }
        }
        self.harness.spans.look(self.session.board_mut(), at);
    }
}
