//! The image in the loop: virtual time, and who has to act next in it.
//!
//! A tick is seen by its read of the encoder's counter. What happens between two ticks is the mode's own:
//! [`Lockstep`] or [`FreeRunning`].

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU32, Ordering};

use rigless::device::ResetCause;
use rigless::emulator::{AccessKind, Driver, Host, Settled, Start, Stop};
use rigless::image::Image;
use rigless::session::Session;
use rigless::time::VirtualNanos;
use stiction::Tick;

use super::board::{EmulatedBoard, Fitted};
use super::compare::Difference;
use super::encoder_edges::EncoderEdges;
use super::free_running::FreeRunning;
use super::guard::Guard;
use super::image::FirmwareImage;
use super::joint::Joint;
use super::last_tick;
use super::lockstep::Lockstep;
use super::log::{Listener, Log};
use super::probe::{Points, Probe};
use crate::error::Error;
use crate::solver::AxisSolver;

/// Where the parameter blob lies: sector 10 of the flash.
pub const PARAMETERS_AT: u64 = 0x080C_0000;
/// Read-only words that the maker has put there: unique identifier (12 bytes), and the flash's size in KiB.
pub(super) const FACTORY_AT: u64 = 0x1FFF_7A10;
pub(super) const TIM2_CNT: u64 = 0x4000_0024;
pub(super) const TIM1_CCR1: u64 = 0x4001_0034;
/// The log's buffer holds 1 KiB: more than the firmware says in this time.
const DRAIN_EVERY_NS: u64 = 5_000_000;

/// What a mode has to do next.
pub trait Mode<S>: Send {
    /// The image has read the encoder's counter.
    fn counter_read(&mut self, wired: &mut Wired<S>, counter: u32, at: VirtualNanos) -> Result<(), Stopped>;

    /// The image has written the duty.
    fn duty_written(&mut self, wired: &mut Wired<S>, board: &mut EmulatedBoard, at: VirtualNanos);

    /// The next instant at which [`due`](Self::due) has something to do.
    fn next(&self) -> VirtualNanos;

    /// That instant has come.
    fn due(&mut self, wired: &mut Wired<S>, part: &mut Part<'_>, at: VirtualNanos) -> Result<(), Stopped>;
}

/// The part while it stands still.
pub struct Part<'a> {
    /// Registers and pins.
    pub board: &'a mut EmulatedBoard,
    host: &'a mut dyn Host,
    image: &'a FirmwareImage,
}

impl Part<'_> {
    /// What the image computed in its last tick.
    ///
    /// # Errors
    /// If the emulator refuses to read its own memory.
    pub fn last_tick(&mut self) -> Result<Tick, Stopped> {
        let read = last_tick::read(self.host, self.image.last_tick);
        read.map_err(|error| Stopped::Misbehaves(error.to_string()))
    }
}

/// What is wired to the part in either mode.
#[derive(Debug)]
pub struct Wired<S> {
    /// The joint.
    pub joint: Joint<S>,
    /// Its encoder.
    pub encoder: EncoderEdges,
    /// From each read of the counter to the instant at which the duty of that tick takes effect, ns.
    pub latencies_ns: Vec<u64>,
}

/// Why a run ends before its last sample.
#[derive(Debug)]
pub enum Stopped {
    /// Image and core do not agree.
    Differs(Box<Difference>),
    /// The part does something that it should not, in words that follow "the image ... :".
    Misbehaves(String),
    /// The caller wants no more.
    Interrupted,
}

/// What to run, besides the joint.
pub struct Setup {
    /// What the run is called, in messages and beside its log.
    pub label: String,
    /// The program.
    pub image: Arc<FirmwareImage>,
    /// The parameter sector.
    pub parameters: Vec<u8>,
    /// What is soldered on.
    pub fitted: Fitted,
    /// Edges and PWM at their own times.
    pub free_running: bool,
    /// Gets each line of the log at once.
    pub listener: Option<Listener>,
    /// What to count.
    pub points: Option<Arc<Points>>,
    /// Counts ticks, for whoever shows progress.
    pub ticks: Arc<AtomicU32>,
    /// Ends the run when it is set.
    pub interrupt: Arc<AtomicBool>,
}

/// What is left of a run.
#[derive(Debug)]
pub struct Ran<S> {
    /// The joint with all its moments.
    pub wired: Wired<S>,
    /// The firmware's log.
    pub log: Log,
    /// What was counted.
    pub probe: Option<Probe>,
    /// Instructions from power-on to the end.
    pub instructions: u64,
    /// Virtual time from power-on to the end, ns.
    pub virtual_ns: u64,
}

/// Runs an image from power-on to the last sample of the joint's motion.
///
/// # Errors
/// If the image cannot be placed, gets stuck, turns its bridge off, or does not do what the core does.
pub fn run<S>(setup: &Setup, joint: Joint<S>) -> Result<Ran<S>, Error>
where
    S: AxisSolver + Clone + Send + std::fmt::Debug + 'static,
{
    let trouble = |why: String| {
        Error::Emulator(format!("{}, image {}: {why}", setup.label, setup.image.path.display()))
    };
    let path = setup.image.path.as_path();
    let images = [
        Image::new(path, setup.image.elf.clone(), None),
        Image::new("parameters".as_ref(), setup.parameters.clone(), Some(PARAMETERS_AT)),
        Image::new("identity".as_ref(), factory_words(), Some(FACTORY_AT)),
    ];
    let images: Vec<Image> =
        images.into_iter().collect::<Result<_, _>>().map_err(|error| trouble(error.to_string()))?;
    let board = Box::new(EmulatedBoard::new(setup.fitted)?);
    let sample_ns = (joint.closed_loop.sample_time_s * 1e9).round() as u64;
    let mode: Box<dyn Mode<S>> = if setup.free_running {
        Box::new(FreeRunning::new(sample_ns))
    } else {
        Box::new(Lockstep::new(sample_ns))
    };
    let loop_ = Loop {
        wired: Wired { joint, encoder: EncoderEdges::default(), latencies_ns: Vec::new() },
        mode,
        log: Log::new(setup.image.clone(), &setup.label, setup.listener.clone()),
        guard: Guard::default(),
        probe: setup.points.clone().map(Probe::new),
        image: setup.image.clone(),
        ticks: setup.ticks.clone(),
        interrupt: setup.interrupt.clone(),
        // A probe has to be there before the first instruction.
        drain_at: VirtualNanos(if setup.points.is_some() { 0 } else { DRAIN_EVERY_NS }),
        stopped: None,
    };
    let session = Session::new(board, 0, loop_.drain_at).map_err(|error| trouble(error.to_string()))?;
    let mut start = Start::new(&images);
    start.interrupt = Some(&setup.interrupt);
    let finished =
        rigless::emulator::run(session, &start, loop_).map_err(|error| trouble(error.to_string()))?;
    let Loop { wired, log, probe, stopped, .. } = finished.driver;
    let stop = finished.stop.map(|stop| (stop.instruction_count, stop.at.0));
    let (instructions, virtual_ns) = stop.unwrap_or_default();
    match stopped {
        None if stop.is_some() => Ok(Ran { wired, log, probe, instructions, virtual_ns }),
        None | Some(Stopped::Interrupted) => Err(Error::Interrupted),
        Some(Stopped::Differs(difference)) => {
            // The one cause that is nobody's mistake in the code: an image of other sources of the same version.
            let commit = &setup.image.note.commit;
            Err(trouble(format!("the image is of commit {commit}; {}", difference.to_string().trim_end())))
        }
        Some(Stopped::Misbehaves(why)) => Err(trouble(format!("{why}; {}", log.tail()))),
    }
}

/// Identifier `stiction sim` and 1024 KiB.
pub(super) fn factory_words() -> Vec<u8> {
    let mut words = b"stiction sim".to_vec();
    words.resize(18, 0);
    words.extend(1024u16.to_le_bytes());
    words
}

struct Loop<S> {
    wired: Wired<S>,
    mode: Box<dyn Mode<S>>,
    log: Log,
    guard: Guard,
    probe: Option<Probe>,
    image: Arc<FirmwareImage>,
    ticks: Arc<AtomicU32>,
    interrupt: Arc<AtomicBool>,
    drain_at: VirtualNanos,
    stopped: Option<Stopped>,
}

impl<S: AxisSolver + Send> Loop<S> {
    fn next(&self) -> VirtualNanos {
        if self.stopped.is_some() { VirtualNanos(0) } else { self.drain_at.min(self.mode.next()) }
    }

    /// Everything that is due at `at`, in order.
    fn act(
        &mut self,
        session: &mut Session<EmulatedBoard>,
        host: &mut dyn Host,
        at: VirtualNanos,
    ) -> Result<(), Stopped> {
        if at.0 == 0
            && let Some(probe) = &self.probe
        {
            probe.attach(host).map_err(|error| Stopped::Misbehaves(error.to_string()))?;
        }
        if self.drain_at <= at {
            self.drain_at = VirtualNanos(at.0 + DRAIN_EVERY_NS);
            self.log.drain(host, at).map_err(|error| Stopped::Misbehaves(error.to_string()))?;
            if self.interrupt.load(Ordering::Relaxed) {
                return Err(Stopped::Interrupted);
            }
            if let Some(why) = self.guard.polling(&self.image) {
                return Err(Stopped::Misbehaves(why));
            }
        }
        if let Some(reset) = session.resets().first() {
            let by = match reset.cause {
                ResetCause::Core => "itself",
                ResetCause::Model(instance) => instance,
                ResetCause::Pin => "its reset pin",
                _ => "power",
            };
            let at_s = reset.at.0 as f64 * 1e-9;
            return Err(Stopped::Misbehaves(format!("the part was reset by {by} after {at_s:.6} s")));
        }
        if self.mode.next() <= at {
            let mut part = Part { board: session.board_mut(), host, image: &self.image };
            self.mode.due(&mut self.wired, &mut part, at)?;
            self.ticks.store(self.wired.joint.ticks() as u32, Ordering::Relaxed);
        }
        if !self.wired.joint.has_begun() && at >= Guard::boot_limit() {
            return Err(Stopped::Misbehaves(Guard::not_armed()));
        }
        Ok(())
    }
}

impl<S: AxisSolver + Send> Driver<EmulatedBoard> for Loop<S> {
    fn on_settled(&mut self, session: &mut Session<EmulatedBoard>, _host: &mut dyn Host, settled: Settled) {
        if let (Settled::Hit(hit), Some(probe)) = (&settled, &mut self.probe) {
            probe.hit(hit);
            return;
        }
        let Settled::Access { access, value } = settled else {
            session.board_mut().settle();
            return;
        };
        self.guard.see(&access);
        let (at, wired) = (access.virtual_time, &mut self.wired);
        match (access.kind, access.address) {
            (AccessKind::Read, TIM2_CNT) => {
                if let Err(stopped) = self.mode.counter_read(wired, value as u32, at) {
                    self.stopped.get_or_insert(stopped);
                }
            }
            (AccessKind::Write, TIM1_CCR1) => self.mode.duty_written(wired, session.board_mut(), at),
            _ => return,
        }
        session.run_until(self.next());
    }

    fn on_stop(
        &mut self,
        session: &mut Session<EmulatedBoard>,
        stop: Stop,
        host: &mut dyn Host,
    ) -> Option<VirtualNanos> {
        if self.stopped.is_none()
            && let Err(stopped) = self.act(session, host, stop.at)
        {
            self.stopped = Some(stopped);
        }
        if self.stopped.is_some() || self.wired.joint.has_ended() {
            // The last words are often the ones that matter, and there is nobody to tell if they cannot be read.
            let _ = self.log.drain(host, stop.at);
            if let Some(probe) = &mut self.probe
                && let Err(error) = probe.detach(host)
            {
                self.stopped.get_or_insert(Stopped::Misbehaves(error.to_string()));
            }
            return None;
        }
        Some(self.next())
    }
}
