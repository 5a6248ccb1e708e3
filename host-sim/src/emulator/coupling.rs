//! How plant and part are coupled: in [lockstep](super::lockstep) or
//! [free-running](super::free_running). What both have in common is how a sample is seen from outside.
//!
//! ```text
//! counter read       duty taken                        counter read, or else a sample without a tick
//! |------ h/4 -------|---------------- 5 h/4 ----------|
//! ```
//!
//! A sample without a tick (the part boots, hangs, or has lost its clock) passes as well, half a
//! sample late.

use rigless::time::VirtualNanos;

use super::board::EmulatedBoard;
use super::bridge::Bridge;

/// A sample, as far as it can be seen from outside.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Sample {
    /// When it began, ns since power-on.
    pub at_ns: u64,
    /// Which control tick since the last reset began it, the first being 1; none: there was none.
    pub clock: Option<u32>,
    /// What the image has read from the encoder's counter.
    pub counter: u32,
    /// Where the encoder's disc was shown to be at that instant, in counts.
    pub shown: i64,
    /// The bridge after it.
    pub bridge: Bridge,
    /// What the bridge stands for, as a code of the drive; zero if it is off.
    pub code: i16,
}

/// The samples of an image.
#[derive(Clone, Copy, Debug)]
pub struct Sampling {
    /// The last sample. Its bridge is that of the one before until the duty is taken.
    pub sample: Sample,
    /// Samples whose duty has been taken.
    pub samples: u64,
    /// Time between two samples, ns: as planned until the part has set its timer.
    pub period_ns: u64,
    /// When the duty of this sample is taken.
    pub due: VirtualNanos,
    /// When the sample began.
    pub begun: VirtualNanos,
    /// The control tick has read the counter, and its duty has not been taken.
    pub is_open: bool,
    /// The image has ticked at least once since power-on.
    pub has_ticked: bool,
    /// The last first read of a tick.
    read: Option<VirtualNanos>,
    /// Control ticks since the last reset.
    clock: u32,
}

impl Sampling {
    /// Of an image that is about to start and should tick so often, ns.
    pub fn new(period_ns: u64) -> Self {
        Self {
            sample: Sample::default(),
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

    /// The image has read the counter; whether this begins a tick.
    pub fn read(&mut self, board: &mut EmulatedBoard, counter: u32, shown: i64, at: VirtualNanos) -> bool {
        let period_ns = board.tick_period_ns(at).unwrap_or(self.period_ns);
        // Several reads of one tick are one tick; the first is the latch.
        if self.read.is_some_and(|read| at.0 - read.0 < period_ns / 2) {
            return false;
        }
        self.period_ns = period_ns;
        self.read = Some(at);
        self.begun = at;
        self.clock += 1;
        self.has_ticked = true;
        self.sample = Sample { at_ns: at.0, clock: Some(self.clock), counter, shown, ..self.sample };
        self.is_open = true;
        self.due = VirtualNanos(at.0 + period_ns / 4);
        true
    }

    /// The duty of a sample is taken now.
    pub fn take(&mut self, bridge: Bridge, code: i16) {
        if !std::mem::take(&mut self.is_open) {
            self.begun = VirtualNanos(self.begun.0 + self.period_ns);
            self.sample = Sample { at_ns: self.begun.0, clock: None, ..self.sample };
        }
        self.sample = Sample { bridge, code, ..self.sample };
        self.samples += 1;
        self.due = VirtualNanos(self.begun.0 + 3 * self.period_ns / 2);
    }

    /// The part has been reset.
    pub const fn reset(&mut self) {
        self.clock = 0;
        self.read = None;
    }
}

/// A way to couple plant and part.
pub trait Coupling: Send + std::fmt::Debug + 'static {
    /// The samples so far.
    fn sampling(&self) -> &Sampling;

    /// The image has read the encoder's counter.
    fn counter_read(&mut self, board: &mut EmulatedBoard, counter: u32, at: VirtualNanos);

    /// The image has written the duty.
    fn duty_written(&mut self, _board: &mut EmulatedBoard, _at: VirtualNanos) {}

    /// The next instant at which [`act`](Self::act) has something to do.
    fn next(&self) -> VirtualNanos;

    /// That instant has come.
    fn act(&mut self, board: &mut EmulatedBoard, at: VirtualNanos);

    /// The part has been reset: it has forgotten what is on its pins.
    fn reset(&mut self, board: &mut EmulatedBoard, at: VirtualNanos);
}
