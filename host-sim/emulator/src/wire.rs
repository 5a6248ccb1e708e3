//! The flash image on the emulated board, around the joint of a machine's file, at the other end of
//! its own USART.
//!
//! Time passes while the client waits, and at no other time, so that every session is the same to
//! the instruction. It is that of a [lockstep](super::lockstep): the joint does what it does around
//! a [simulated device](simulator::device::simulated), to the bit, if what is asked of both is
//! asked between the same two ticks. What is between is real: the wire's 11 us a byte, and the
//! instructions that the firmware takes to answer.

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::{Duration, Instant};

use stiction::control::device_config::PositionReference;
use stiction::link::RequestRefusal;
use stiction::parameters::ROOM;

use super::FirmwareImage;
use super::board_under_test::{BoardUnderTest, PlantInLockstep};
use super::runs::DEFAULT_IMAGE;
use super::setup::BoardSetup;
use files::error::Error;
use simulator::device::wire::{AWAY, Wire};
use simulator::experiment::{RunPlan, for_a_device};

/// Warning that precedes every output about an emulated device.
pub const EMULATED: &str = "EMULATED DEVICE: no motor moves or stops.";

/// By then a sound image has ticked, ns: a crystal that does not start is waited for for 50 ms, and
/// a tick is 20 ms at most.
const BOOT_NS: u64 = 200_000_000;

/// How far the board's time may fall behind that on the wall before it is let go on: an instant to
/// the eye.
const STEP: Duration = Duration::from_millis(5);

/// Wire to the far end of an emulated board's USART, for a client.
#[derive(Debug)]
pub struct EmulatedWire {
    /// The board has the joint of a plan on its pins.
    pub board: BoardUnderTest,
    now: Duration,
    /// The image has not been sent the zero at which its joint stands.
    needs_reference: bool,
    /// A moment on the wall, and the board's time at it, from which on the two keep pace.
    paced: Option<(Instant, Duration)>,
}

impl EmulatedWire {
    /// With the image at `path`, or else the one that `cargo xtask firmware` builds, and what the
    /// plan says in its flash, with nothing that starts by itself. Power is on, and the joint has
    /// been at rest for long enough to be armed.
    ///
    /// # Errors
    /// Says what the image is not, or names a value of the plan that is not allowed.
    pub fn new(path: Option<&Path>, plan: &RunPlan) -> Result<Self, Error> {
        let path = path.map_or_else(|| PathBuf::from(DEFAULT_IMAGE), Path::to_path_buf);
        Self::with(&Arc::new(FirmwareImage::open(&path)?), plan)
    }

    /// Does the same with an image that has been read.
    ///
    /// # Errors
    /// Names a value of the plan that is not allowed.
    pub fn with(image: &Arc<FirmwareImage>, plan: &RunPlan) -> Result<Self, Error> {
        let mut parameters = for_a_device(plan)?;
        parameters.device.autostart = false;
        let needs_reference = parameters.device.reference == PositionReference::Command;
        let mut room = [0; ROOM];
        let record = parameters.encode(1, &mut room).unwrap_or_default().to_vec();
        let setup = BoardSetup::new(&plan.label, image, record);
        let mut board = BoardUnderTest::power_on(setup, PlantInLockstep::of(plan)?)?;
        // The joint rests for 50 ms before it may be armed; and just after a tick there is the most
        // time until the next.
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

    /// Lets the board's time follow that on the wall, until it sends something.
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
