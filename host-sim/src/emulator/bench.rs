//! A board on the bench, without a joint: power, a few mishaps, and what bridge and log do about them.

use std::sync::Arc;

use rigless::emulator::{AccessKind, Driver, Host, Settled, Start, Stop};
use rigless::session::{Reset, Session};
use rigless::soc::Width;
use rigless::time::VirtualNanos;

use super::board::{EmulatedBoard, Fitted};
use super::bridge::Bridge;
use super::image::FirmwareImage;
use super::in_the_loop::{TIM1_CCR1, TIM2_CNT, flash};
use super::log::{Log, LogLine};
use super::spans::Spans;
use super::uart::Uart;
use crate::error::Error;

/// How often something may happen, ns.
const LOOK_EVERY_NS: u64 = 50_000;
/// Looks between two drains of the log.
const LOOKS_PER_DRAIN: u64 = 40;

/// Something that happens to a board.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Mishap {
    /// The bridge's driver pulls the break input.
    Break,
    /// It lets go of it.
    BreakReleased,
    /// It pulls it for no longer than an instant, at the worst one: when the control task has just written the first duty
    /// and is about to turn the outputs on.
    BreakAtArming,
    /// The crystal stops.
    CrystalLost,
    /// The reset pin is pulled.
    Reset,
    /// The supply sags below the brown-out level and comes back at once: a reset with that level's flag, as on a part
    /// whose option bytes enable it. The emulator has no such level of its own. The RAM stays as it is.
    BrownOut,
    /// The timer of the control tick stops counting.
    TickStops,
    /// The control tick comes now, before its time, and the next one a whole period later.
    TickEarly,
    /// The processor stands still while timers and pins go on, as it does when it is locked up, or halted by a probe, or
    /// waits for the flash.
    CoreStalls,
    /// It goes on where it stood.
    CoreGoesOn,
    /// The next access to a register is answered by a bus error.
    BusError {
        /// Address of the register.
        address: u64,
    },
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

/// Somebody at the other end of the command link: is told the time (ns) and what the board has sent since it was last
/// asked, and says what is sent to the board.
pub type Partner = Box<dyn FnMut(u64, &[u8]) -> Vec<u8> + Send>;

/// What has been seen on the bench.
#[derive(Clone, Debug)]
pub struct Observed {
    /// Spans of time in which the bridge was on, ns since power-on, to the instruction.
    pub on_ns: Vec<[u64; 2]>,
    /// The bridge when it was last seen on.
    pub last: Bridge,
    /// The compare values that it was on with, each with the time at which it came, ns.
    pub compares: Vec<(u64, u16)>,
    /// When the encoder was read, ns since power-on: early in each control tick.
    pub ticks_ns: Vec<u64>,
    /// Everything that was logged.
    pub log: Vec<LogLine>,
    /// When the part was reset, and by what.
    pub resets: Vec<Reset>,
}

impl Observed {
    /// Whether the bridge was on at any time after `at_ns`.
    pub fn on_after(&self, at_ns: u64) -> bool {
        self.on_ns.iter().any(|[_, until]| *until > at_ns)
    }

    /// When the bridge was turned off for the last time; nothing if it was never on.
    pub fn off_at_ns(&self) -> Option<u64> {
        self.on_ns.last().map(|[_, until]| *until)
    }

    /// Whether a line of the log holds `text`.
    pub fn says(&self, text: &str) -> bool {
        self.log.iter().any(|line| line.text.contains(text))
    }
}

/// Powers a board until `until_ns`, and lets each mishap happen at its time (ns, in order). `records` are the contents of
/// the two parameter sectors, 10 and 11; one without any is erased.
///
/// # Errors
/// If the image cannot be placed.
pub fn observe(
    image: &Arc<FirmwareImage>,
    records: [Option<&[u8]>; 2],
    fitted: Fitted,
    mishaps: &[(u64, Mishap)],
    until_ns: u64,
) -> Result<Observed, Error> {
    converse(image, records, fitted, mishaps, until_ns, Box::new(|_, _| Vec::new()))
}

/// The same with somebody at the other end of the command link, who is asked every 50 us.
///
/// # Errors
/// If the image cannot be placed.
pub fn converse(
    image: &Arc<FirmwareImage>,
    records: [Option<&[u8]>; 2],
    fitted: Fitted,
    mishaps: &[(u64, Mishap)],
    until_ns: u64,
    partner: Partner,
) -> Result<Observed, Error> {
    let trouble = |why: String| Error::Emulator(format!("{}: {why}", image.path.display()));
    let images = flash(image, records).map_err(&trouble)?;
    let bench = Bench {
        mishaps: mishaps.to_vec(),
        until_ns,
        breaks_at_arming: false,
        looks: 0,
        resets: 0,
        spans: Spans::default(),
        ticks_ns: Vec::new(),
        log: Log::new(image.clone(), "bench", None),
        uart: Uart::default(),
        partner,
    };
    let mut board = Box::new(EmulatedBoard::new(fitted)?);
    board.connect(&bench.uart);
    let session =
        Session::new(board, 0, VirtualNanos(LOOK_EVERY_NS)).map_err(|error| trouble(error.to_string()))?;
    let finished = rigless::emulator::run(session, &Start::new(&images), bench)
        .map_err(|error| trouble(error.to_string()))?;
    let resets = finished.session.resets().to_vec();
    let Bench { spans: Spans { on_ns, last, compares, .. }, ticks_ns, log, .. } = finished.driver;
    Ok(Observed { on_ns, last, compares, ticks_ns, log: log.lines, resets })
}

struct Bench {
    mishaps: Vec<(u64, Mishap)>,
    until_ns: u64,
    breaks_at_arming: bool,
    looks: u64,
    /// How many have been seen.
    resets: usize,
    spans: Spans,
    ticks_ns: Vec<u64>,
    log: Log,
    uart: Uart,
    partner: Partner,
}

impl Mishap {
    /// Lets it happen, at a stop; [`BreakAtArming`](Self::BreakAtArming) waits for its moment elsewhere.
    pub(super) fn happen(self, session: &mut Session<EmulatedBoard>, stop: &Stop, host: &mut dyn Host) {
        let at = stop.at;
        match self {
            Self::Break => session.board_mut().drive_break(at, true),
            Self::BreakAtArming => {}
            Self::BreakReleased => session.board_mut().drive_break(at, false),
            Self::CrystalLost => session.board_mut().lose_crystal(at),
            Self::Reset => session.reset_by_pin(at, stop.instruction_count, host),
            Self::BrownOut => {
                session.reset_by_pin(at, stop.instruction_count, host);
                session.board_mut().flag_brown_out();
            }
            Self::TickStops => session.board_mut().stop_tick(at),
            Self::TickEarly => session.board_mut().early_tick(at),
            Self::CoreStalls => host.hold(true),
            Self::CoreGoesOn => host.hold(false),
            Self::BusError { address } => session.fail_next(address, address + 4),
            Self::Corrupts { address, length, to } => {
                for address in address..address + length {
                    // What is no RAM stays as it is, and a test of what should follow fails.
                    let _ = host.write(address, Width::W8, u64::from(to));
                }
            }
        }
    }
}

impl Driver<EmulatedBoard> for Bench {
    fn on_settled(&mut self, session: &mut Session<EmulatedBoard>, host: &mut dyn Host, settled: Settled) {
        match settled {
            Settled::Access { access, .. } if access.kind == AccessKind::Write => {
                let (board, at) = (session.board_mut(), access.virtual_time);
                self.spans.look(board, at);
                let neutral = Bridge::read(board).top / 2;
                // The set-up writes the register, too, before its top.
                let ticks = !self.ticks_ns.is_empty();
                let drives = access.address == TIM1_CCR1 && access.value != u64::from(neutral);
                if self.breaks_at_arming && ticks && drives {
                    self.breaks_at_arming = false;
                    board.drive_break(at, true);
                    board.drive_break(at, false);
                }
            }
            Settled::Access { access, .. } if access.address == TIM2_CNT => {
                self.ticks_ns.push(access.virtual_time.0);
            }
            Settled::Stop(stop) => {
                session.board_mut().settle();
                self.spans.look(session.board_mut(), stop.at);
                if session.resets().len() > self.resets {
                    self.resets = session.resets().len();
                    session.board_mut().reconnect(stop.at);
                    // A reset ends a stall, whatever it came from.
                    host.hold(false);
                }
            }
            _ => {}
        }
    }

    fn on_stop(
        &mut self,
        session: &mut Session<EmulatedBoard>,
        stop: Stop,
        host: &mut dyn Host,
    ) -> Option<VirtualNanos> {
        let at = stop.at;
        while let Some((_, mishap)) = self.mishaps.first().copied().filter(|(due, _)| *due <= at.0) {
            self.mishaps.remove(0);
            self.breaks_at_arming |= mishap == Mishap::BreakAtArming;
            mishap.happen(session, &stop, host);
            self.spans.look(session.board_mut(), at);
        }
        self.uart.send(&(self.partner)(at.0, &self.uart.receive()));
        self.looks += 1;
        let over = at.0 >= self.until_ns;
        if over || self.looks.is_multiple_of(LOOKS_PER_DRAIN) {
            // A log that cannot be read is an empty one, and a test of it fails.
            let _ = self.log.drain(host, at);
        }
        (!over).then_some(VirtualNanos(at.0 + LOOK_EVERY_NS))
    }
}
