//! Wire from a client to the flash image on an emulated board, which controls the joint of a
//! machine's file.
//!
//! Time passes only while the client waits, so that every session is the same to the instruction.
//! Board and joint run in [lockstep](super::lockstep). The joint moves as with a
//! [simulated device](simulator::device::simulated), to the bit, if both devices receive their
//! requests between the same two ticks. The link is real: a byte takes 11 us on the USART's wire,
//! and the firmware needs instructions to answer.

use std::path::Path;
use std::sync::Arc;
use std::time::{Duration, Instant};

use stiction::control::device_config::PositionReference;
use stiction::link::RequestRefusal;
use stiction::parameters::ROOM;

use super::FirmwareImage;
use super::board_under_test::{BoardUnderTest, PlantInLockstep};
use super::setup::BoardSetup;
use files::error::Error;
use simulator::device::wire::{AWAY, Wire};
use simulator::experiment::{RunPlan, for_a_device};

/// Warning that precedes every output about an emulated device.
pub const EMULATED: &str = "EMULATED DEVICE: no motor moves or stops.";

/// Time by which an intact image has ticked, ns: it waits up to 50 ms for a crystal that does not
/// start, and a tick is 20 ms at most.
const BOOT_NS: u64 = 200_000_000;

/// Time by which the board can fall behind the wall clock before it is advanced: too short to be
/// seen.
const STEP: Duration = Duration::from_millis(5);

/// Wire to the far end of an emulated board's USART, for a client.
#[derive(Debug)]
pub struct EmulatedWire {
    /// Board with the joint of a plan on its pins.
    pub board: BoardUnderTest,
    now: Duration,
    /// Whether the image still needs the command that its joint is at zero.
    needs_reference: bool,
    /// Instant of the wall clock and the board's time at it, from which on both keep pace.
    paced: Option<(Instant, Duration)>,
}

impl EmulatedWire {
    /// Powers a board with the image at `path`, or else with the one that `cargo xtask firmware`
    /// builds for the encoders of the plan, and with the parameters of the plan in its flash,
    /// without automatic start. When it returns, the joint has been at rest for long enough to be
    /// armed.
    ///
    /// # Errors
    /// Returns why the file is not a valid image, or names an invalid value of the plan.
    pub fn new(path: Option<&Path>, plan: &RunPlan) -> Result<Self, Error> {
        Self::with(&Arc::new(FirmwareImage::for_plan(path, plan)?), plan)
    }

    /// As [`new`](Self::new), with an image that has been read.
    ///
    /// # Errors
    /// Returns an error that names an invalid value of the plan, or if the image does not read all
    /// encoders of the plan.
    pub fn with(image: &Arc<FirmwareImage>, plan: &RunPlan) -> Result<Self, Error> {
        image.fits(plan)?;
        let mut parameters = for_a_device(plan)?;
        parameters.device.autostart = false;
        let needs_reference = parameters.device.reference == PositionReference::Command;
        let mut room = [0; ROOM];
        let record = parameters.encode(1, &mut room).unwrap_or_default().to_vec();
        let setup = BoardSetup::new(&plan.label, image, record);
        let mut board = BoardUnderTest::power_on(setup, PlantInLockstep::of(plan)?)?;
        // The joint must rest for 50 ms before it can be armed. Just after a tick, the time until
        // the next one is longest.
        let ticks = (0.1 / plan.machine.sampling.sample_time_s()).ceil() as u32;
        while board.samples(1)?.clock.is_none() {
            let now = board.act(|halted| halted.now())?;
            if now > BOOT_NS {
                let log = board.act(|halted| halted.harness.log.tail())?;
                return Err(Error::Emulator(format!(
                    "{}: the control loop does not run; {log}",
                    image.path.display()
                )));
            }
        }
        board.samples(ticks)?;
        Ok(Self { board, now: Duration::ZERO, needs_reference, paced: None })
    }

    fn listen(&mut self, at_most: Duration) -> Result<(), Error> {
        let ns = u64::try_from(at_most.as_nanos()).unwrap_or(u64::MAX);
        self.board.listen(ns)?;
        self.now = Duration::from_nanos(self.board.act(|halted| halted.now())?);
        Ok(())
    }

    /// Advances the board's time to the wall clock, or until the board sends a frame.
    fn keep_pace(&mut self, (begin, at): (Instant, Duration)) -> Result<(), Error> {
        let lag = (begin.elapsed() + at).saturating_sub(self.now);
        if lag > AWAY {
            self.paced = Some((Instant::now(), self.now));
            return Ok(());
        }
        self.listen(lag)
    }
}

impl Wire for EmulatedWire {
    fn send(&mut self, bytes: &[u8]) -> Result<(), Error> {
        self.board.uart.send(bytes);
        Ok(())
    }

    fn receive(&mut self, at_most: Duration) -> Result<Vec<u8>, Error> {
        let Some(_) = self.paced else {
            self.listen(at_most)?;
            return Ok(self.board.uart.receive());
        };
        let begin = Instant::now();
        while let Some(paced) = self.paced {
            self.keep_pace(paced)?;
            let bytes = self.board.uart.receive();
            let left = at_most.saturating_sub(begin.elapsed());
            if !bytes.is_empty() || left.is_zero() {
                return Ok(bytes);
            }
            std::thread::sleep(left.min(STEP));
        }
        Ok(Vec::new())
    }

    fn real_time(&mut self) {
        self.paced = Some((Instant::now(), self.now));
    }

    fn now(&self) -> Duration {
        self.now
    }

    fn name(&self) -> String {
        "the emulated device".into()
    }

    fn excuse(&self, refused: &RequestRefusal) -> &'static str {
        match refused {
            RequestRefusal::Flash => " (the emulator models no contents of the flash)",
            _ => "",
        }
    }

    fn stands_at_zero(&mut self) -> bool {
        std::mem::take(&mut self.needs_reference)
    }

    fn warning(&self) -> Option<&'static str> {
        Some(EMULATED)
    }
}
