//! Coupling of plant and microcontroller: in [lockstep](super::lockstep) or
//! [free-running](super::free_running). Both detect a sample from outside in the same way.
//!
//! ```text
//! counter read       duty taken                   counter read, or else a sample without a tick
//! |------ h/4 -------|------------- 5 h/4 --------|
//! ```
//!
//! A sample without a tick (the microcontroller boots, hangs, or has lost its clock) passes as
//! well, half a sample late.

use rigless::time::VirtualNanos;

use super::board::EmulatedBoard;
use super::bridge::BridgeInputs;
use super::encoder_edges::Encoders;
use simulator::plant::Discs;

/// One passage of the control task, as seen from outside.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ImageSample {
    /// Start of the sample, ns since power-on.
    pub at_ns: u64,
    /// Number of its control tick since the last reset, from 1; `None` if it had no tick.
    pub clock: Option<u32>,
    /// Counter of the first encoder, as the image read it.
    pub counter: u32,
    /// Positions of the discs on the encoders' wires at that instant.
    pub shown: Discs,
    /// State of the bridge after the sample.
    pub bridge: BridgeInputs,
    /// Drive code of the bridge's state; zero if it is off.
    pub code: i16,
}

/// Sampling of an image: its last sample, and the time of the next one.
#[derive(Clone, Copy, Debug)]
pub struct Sampling {
    /// Last sample. Until its duty is taken over, its bridge is that of the sample before.
    pub sample: ImageSample,
    /// Number of samples whose duty has been applied.
    pub samples: u64,
    /// Time between two samples, ns: as planned until the microcontroller has set its timer.
    pub period_ns: u64,
    /// Time at which the duty of this sample is taken over.
    pub due: VirtualNanos,
    /// Start of the sample, ns since power-on.
    pub begun: VirtualNanos,
    /// Whether a control tick has read the counter, and its duty has not been taken over.
    pub is_open: bool,
    /// Whether the image has ticked at least once since power-on.
    pub has_ticked: bool,
    /// Time of the first read of the counter in the last tick.
    read: Option<VirtualNanos>,
    /// Control ticks since the last reset.
    clock: u32,
}

impl Sampling {
    /// Creates the sampling of an image that is about to start, with the planned sample time
    /// `period_ns`.
    pub fn new(period_ns: u64) -> Self {
        Self {
            sample: ImageSample::default(),
            samples: 0,
            period_ns,
            due: VirtualNanos(period_ns),
            begun: VirtualNanos(0),
            is_open: false,
            has_ticked: false,
            read: None,
            clock: 0,
        }
    }

    /// Records a read of the counter, and returns whether it starts a tick.
    pub fn read(
        &mut self,
        board: &mut EmulatedBoard,
        counter: u32,
        shown: Discs,
        at: VirtualNanos,
    ) -> bool {
        let period_ns = board.tick_period_ns(at).unwrap_or(self.period_ns);
        // Several reads within a tick count as one tick; the first one is the latch.
        if self.read.is_some_and(|read| at.0 - read.0 < period_ns / 2) {
            return false;
        }
        self.period_ns = period_ns;
        self.read = Some(at);
        self.begun = at;
        self.clock += 1;
        self.has_ticked = true;
        self.sample =
            ImageSample { at_ns: at.0, clock: Some(self.clock), counter, shown, ..self.sample };
        self.is_open = true;
        self.due = VirtualNanos(at.0 + period_ns / 4);
        true
    }

    /// Takes over the duty of a sample, and counts the sample.
    pub fn take(&mut self, bridge: BridgeInputs, code: i16) {
        if !std::mem::take(&mut self.is_open) {
            self.begun = VirtualNanos(self.begun.0 + self.period_ns);
            self.sample = ImageSample { at_ns: self.begun.0, clock: None, ..self.sample };
        }
        self.sample = ImageSample { bridge, code, ..self.sample };
        self.samples += 1;
        self.due = VirtualNanos(self.begun.0 + 3 * self.period_ns / 2);
    }

    /// Restarts the count of ticks after a reset of the microcontroller.
    pub const fn reset(&mut self) {
        self.clock = 0;
        self.read = None;
    }
}

/// Coupling that moves the plant as the microcontroller's time advances, and drives its encoder
/// pins.
pub trait PlantCoupling: Send + std::fmt::Debug + 'static {
    /// Returns the sampling so far.
    fn sampling(&self) -> &Sampling;

    /// Returns the encoders on the pins.
    fn encoders(&self) -> Encoders;

    /// Handles a read of the encoder's counter by the image.
    fn counter_read(&mut self, board: &mut EmulatedBoard, counter: u32, at: VirtualNanos);

    /// Handles a duty that the image has written.
    fn duty_written(&mut self, _board: &mut EmulatedBoard, _at: VirtualNanos) {}

    /// Returns the next instant at which [`act`](Self::act) has something to do.
    fn next(&self) -> VirtualNanos;

    /// Executes all that is due.
    fn act(&mut self, board: &mut EmulatedBoard, at: VirtualNanos);

    /// Drives the pins again after a reset, in which the emulated microcontroller loses their
    /// levels.
    fn reset(&mut self, board: &mut EmulatedBoard, at: VirtualNanos);
}
