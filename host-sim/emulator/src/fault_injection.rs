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
use super::plant_interface::FreeDisc;
use super::setup::{BoardSetup, Partner};
use super::spans::Spans;
use files::error::Error;

/// First address of the RAM, and bytes of the page below it.
const RAM: u64 = 0x2000_0000;
const PAGE: u64 = 0x1000;
/// Accesses below the RAM that are answered by a bus error: more than two exceptions save.
const BELOW_RAM: usize = 64;

/// The log is read more often than elsewhere: what a reset finds unread is lost.
const DRAIN_EVERY_NS: u64 = 2_000_000;
/// Time between two samples until the part has set its timer, ns.
const SAMPLE_NS: u64 = 20_000_000;

/// A fault of the hardware, or what ends one.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Injection {
    /// The bridge's driver pulls the break input.
    Break,
    /// It lets go of it.
    BreakReleased,
    /// It pulls it for no longer than an instant, at the worst one: when the control task has just
    /// written the first duty and is about to turn the outputs on.
    BreakAtArming,
    /// The crystal stops.
    CrystalLost,
    /// The reset pin is pulled.
    Reset,
    /// The supply sags below the brown-out level and comes back at once: a reset with that level's
    /// flag, as on a part whose option bytes enable it. The emulator has no such level of its own.
    /// The RAM stays as it is.
    BrownOut,
    /// The timer of the control tick stops counting.
    TickStops,
    /// The control tick comes now, before its time, and the next one a whole period later.
    TickEarly,
    /// The processor stands still while timers and pins go on, as it does when it is locked up, or
    /// halted by a probe, or waits for the flash.
    CoreStalls,
    /// It goes on where it stood.
    CoreGoesOn,
    /// The next access to a register is answered by a bus error.
    BusError {
        /// Address of the register.
        address: u64,
    },
    /// The next accesses to the page below the RAM are answered by bus errors, as on the part. The
    /// emulator drops them otherwise.
    NothingBelowRam,
    /// Bytes of the RAM change.
    Corrupts {
        /// The first of them.
        address: u64,
        /// How many.
        length: u64,
        /// What they are afterwards.
        to: u8,
    },
}

/// Observations of a board.
#[derive(Clone, Debug)]
pub struct BoardObservation {
    /// The bridge was on in these spans of time, ns since power-on, to the instruction.
    pub on_ns: Vec<[u64; 2]>,
    /// Its outputs or its enable pin, or both, were on until this time, ns since power-on.
    pub any_ns: u64,
    /// The bridge was in this state when it was last seen on.
    pub last: BridgeInputs,
    /// It was on with these compare values, each with the time at which it came, ns.
    pub compares: Vec<(u64, u16)>,
    /// Times at which the image read the encoder, ns since power-on: early in each control tick.
    pub ticks_ns: Vec<u64>,
    /// The firmware logged these lines.
    pub log: Vec<LogLine>,
    /// Resets of the microcontroller: time and cause of each.
    pub resets: Vec<Reset>,
}

impl BoardObservation {
    /// Says whether the bridge was on at any time after `at_ns`.
    pub fn on_after(&self, at_ns: u64) -> bool {
        self.on_ns.iter().any(|[_, until]| *until > at_ns)
    }

    /// Returns when the bridge was turned off for the last time; nothing if it was never on.
    pub fn off_at_ns(&self) -> Option<u64> {
        self.on_ns.last().map(|[_, until]| *until)
    }

    /// Says whether a line of the log holds `text`.
    pub fn says(&self, text: &str) -> bool {
        self.log.iter().any(|line| line.text.contains(text))
    }
}

/// Powers a board until `until_ns`, and injects each fault at its time (ns, in order). `records`
/// are the contents of the two parameter sectors, 10 and 11; one without any is erased.
///
/// # Errors
/// If the image cannot be placed.
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
/// If the image cannot be placed.
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
    // What hangs is looked at to its end.
    setup.is_guarded = false;
    let blocked = Lockstep::new(FreeDisc::default(), SAMPLE_NS);
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
                    // What is no RAM stays as it is, and a test of what should follow fails.
                    let _ = host.write(address, Width::W8, u64::from(to));
                }
            }
        }
        self.harness.spans.look(self.session.board_mut(), at);
    }
}
