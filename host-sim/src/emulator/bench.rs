//! A board on the bench, without a joint: power, a few mishaps, and what bridge and log do about them.

use std::sync::Arc;

use rigless::emulator::{Driver, Host, Settled, Start, Stop};
use rigless::image::Image;
use rigless::session::{Reset, Session};
use rigless::time::VirtualNanos;

use super::board::{EmulatedBoard, Fitted};
use super::bridge::Bridge;
use super::image::FirmwareImage;
use super::in_the_loop::{PARAMETERS_AT, factory_words};
use super::log::{Log, LogLine};
use crate::error::Error;

/// How often the bridge is looked at, ns.
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
    /// The crystal stops.
    CrystalLost,
    /// The reset pin is pulled.
    Reset,
}

/// What has been seen on the bench.
#[derive(Clone, Debug)]
pub struct Observed {
    /// Spans of time in which the bridge was on, ns since power-on, to 50 us.
    pub on_ns: Vec<[u64; 2]>,
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

    /// Whether a line of the log holds `text`.
    pub fn says(&self, text: &str) -> bool {
        self.log.iter().any(|line| line.text.contains(text))
    }
}

/// Powers a board until `until_ns`, and lets each mishap happen at its time (ns, in order). Without `parameters` the
/// sector is erased.
///
/// # Errors
/// If the image cannot be placed.
pub fn observe(
    image: &Arc<FirmwareImage>,
    parameters: Option<&[u8]>,
    fitted: Fitted,
    mishaps: &[(u64, Mishap)],
    until_ns: u64,
) -> Result<Observed, Error> {
    let trouble = |why: String| Error::Emulator(format!("{}: {why}", image.path.display()));
    let mut images = vec![Image::new(&image.path, image.elf.clone(), None)];
    images.push(Image::new("identity".as_ref(), factory_words(), Some(super::in_the_loop::FACTORY_AT)));
    if let Some(parameters) = parameters {
        images.push(Image::new("parameters".as_ref(), parameters.to_vec(), Some(PARAMETERS_AT)));
    }
    let images: Vec<Image> =
        images.into_iter().collect::<Result<_, _>>().map_err(|error| trouble(error.to_string()))?;
    let bench = Bench {
        mishaps: mishaps.to_vec(),
        until_ns,
        looks: 0,
        on_ns: Vec::new(),
        was_on: false,
        log: Log::new(image.clone(), "bench", None),
    };
    let board = Box::new(EmulatedBoard::new(fitted)?);
    let session =
        Session::new(board, 0, VirtualNanos(LOOK_EVERY_NS)).map_err(|error| trouble(error.to_string()))?;
    let finished = rigless::emulator::run(session, &Start::new(&images), bench)
        .map_err(|error| trouble(error.to_string()))?;
    let resets = finished.session.resets().to_vec();
    Ok(Observed { on_ns: finished.driver.on_ns, log: finished.driver.log.lines, resets })
}

struct Bench {
    mishaps: Vec<(u64, Mishap)>,
    until_ns: u64,
    looks: u64,
    on_ns: Vec<[u64; 2]>,
    was_on: bool,
    log: Log,
}

impl Driver<EmulatedBoard> for Bench {
    fn on_settled(&mut self, session: &mut Session<EmulatedBoard>, _: &mut dyn Host, settled: Settled) {
        if let Settled::Stop(_) = settled {
            session.board_mut().settle();
        }
    }

    fn on_stop(
        &mut self,
        session: &mut Session<EmulatedBoard>,
        stop: Stop,
        host: &mut dyn Host,
    ) -> Option<VirtualNanos> {
        let at = stop.at;
        let is_on = Bridge::read(session.board_mut()).is_on();
        match self.on_ns.last_mut() {
            Some([_, until]) if is_on && self.was_on => *until = at.0,
            _ if is_on => self.on_ns.push([at.0, at.0]),
            _ => {}
        }
        self.was_on = is_on;
        while let Some((_, mishap)) = self.mishaps.first().copied().filter(|(due, _)| *due <= at.0) {
            self.mishaps.remove(0);
            let board = session.board_mut();
            match mishap {
                Mishap::Break => board.drive_break(at, true),
                Mishap::BreakReleased => board.drive_break(at, false),
                Mishap::CrystalLost => board.lose_crystal(at),
                Mishap::Reset => session.reset_by_pin(at, stop.instruction_count, host),
            }
        }
        self.looks += 1;
        let over = at.0 >= self.until_ns;
        if over || self.looks.is_multiple_of(LOOKS_PER_DRAIN) {
            // A log that cannot be read is an empty one, and a test of it fails.
            let _ = self.log.drain(host, at);
        }
        (!over).then_some(VirtualNanos(at.0 + LOOK_EVERY_NS))
    }
}
