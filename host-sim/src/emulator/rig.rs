//! A board with the simulated joint on its pins, whose image may do whatever it does.
//!
//! Unlike [`in_the_loop`](super::in_the_loop), nothing here knows what the image should do: no core is replayed beside it,
//! and no fault, reset or silence ends anything. Time is that of [`Lockstep`](super::lockstep), as on the host:
//!
//! ```text
//! counter read       duty taken       last edge        counter read
//! |------ h/4 -------|---- edges -----|---- 0.1 h -----|
//! ```
//!
//! A sample without a tick (the part boots, hangs, or has lost its clock) passes as well, half a sample late, and the
//! joint gets what is on the bridge. Does badly: a bridge that goes off within a sample is off for the joint from the
//! next sample on.

use rigless::emulator::{Error as HostError, Host};
use rigless::time::VirtualNanos;
use stiction::drive::{Drive, DriveConfig};

use super::board::EmulatedBoard;
use super::bridge::{Bridge, code_of, nearest_code};
use super::encoder_edges::EncoderEdges;
use super::log::Log;
use super::spans::Spans;
use crate::device::joint::SimulatedJoint;
use crate::device::simulated::Wires;
use crate::error::Error;
use crate::experiment::RunPlan;
use crate::hardware::STM32F405;

/// The log's buffer holds 1 KiB: more than the firmware says in this time.
const DRAIN_EVERY_NS: u64 = 5_000_000;

/// What comes next.
#[derive(Clone, Copy, Debug)]
enum Next {
    /// The image reads the counter.
    Tick,
    /// Its duty is taken.
    Duty,
    /// An edge, and more of them at this interval.
    Edge { interval_ns: u64 },
}

/// A sample, as far as it can be seen from outside.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Sample {
    /// When it began, ns since power-on.
    pub at_ns: u64,
    /// Which control tick since the last reset began it, the first being 1; none: there was none.
    pub clock: Option<u32>,
    /// The bridge after it.
    pub bridge: Bridge,
    /// What the bridge stands for, as a code of the drive; zero if it is off.
    pub code: i16,
}

/// What is wired to the board.
#[derive(Debug)]
pub struct Rig {
    /// The joint.
    pub joint: SimulatedJoint,
    /// Friction on top of the machine's own, V: a hand on the joint, a hard stop.
    pub brake_v: f64,
    /// When the bridge was on.
    pub spans: Spans,
    /// What the firmware has said.
    pub log: Log,
    encoder: EncoderEdges,
    /// Counts that the disc shows beyond where the joint is.
    noise: i64,
    /// How the bridge is wired and what its duty stands for.
    config: DriveConfig,
    drive: Drive,
    next: Next,
    due: VirtualNanos,
    drain_at: VirtualNanos,
    sample_ns: u64,
    begun: VirtualNanos,
    /// The last first read of a tick.
    read: Option<VirtualNanos>,
    /// Control ticks since the last reset.
    clock: u32,
    has_ticked: bool,
    sample: Sample,
    samples: u64,
}

impl Rig {
    /// The joint of a plan, at rest.
    ///
    /// # Errors
    /// Names a value that is not allowed.
    pub fn new(plan: &RunPlan, log: Log) -> Result<Self, Error> {
        let joint = SimulatedJoint::new(plan)?;
        let config = plan.controller_config()?.drive;
        let drive = *plan.closed_loop()?.controller.drive();
        let sample_ns = nanoseconds(joint.sample_time_s());
        Ok(Self {
            joint,
            brake_v: 0.0,
            spans: Spans::default(),
            log,
            encoder: EncoderEdges::default(),
            noise: 0,
            config,
            drive,
            next: Next::Tick,
            due: VirtualNanos(sample_ns),
            drain_at: VirtualNanos(DRAIN_EVERY_NS),
            sample_ns,
            begun: VirtualNanos(0),
            read: None,
            clock: 0,
            has_ticked: false,
            sample: Sample::default(),
            samples: 0,
        })
    }

    /// The last sample whose duty has been taken.
    pub const fn sample(&self) -> Sample {
        self.sample
    }

    /// How many there were.
    pub const fn samples(&self) -> u64 {
        self.samples
    }

    /// The next instant at which [`act`](Self::act) has something to do.
    pub fn next(&self) -> VirtualNanos {
        self.due.min(self.drain_at)
    }

    /// Noise on the encoder's wires: so many edges more before the next tick.
    pub fn jump(&mut self, counts: i32, at: VirtualNanos) {
        self.noise += i64::from(counts);
        self.replan(at);
    }

    /// The joint is put somewhere, by hand.
    pub fn push(&mut self, position_deg: f64, velocity_deg_per_s: f64, at: VirtualNanos) {
        self.joint.push(position_deg, velocity_deg_per_s);
        self.replan(at);
    }

    /// Something happens to the encoder's wires.
    pub fn rewire(&mut self, wires: Wires, board: &mut EmulatedBoard, at: VirtualNanos) {
        self.encoder.rewire(wires, board, at);
    }

    /// The part has been reset: it has forgotten what is on its pins.
    pub fn reset(&mut self, board: &mut EmulatedBoard, at: VirtualNanos) {
        board.reconnect(at);
        self.encoder.show(board, at);
        self.clock = 0;
        self.read = None;
    }

    /// The image has read the encoder's counter.
    pub fn counter_read(&mut self, board: &mut EmulatedBoard, at: VirtualNanos) {
        let period_ns = board.tick_period_ns(at).unwrap_or(self.sample_ns);
        // Several reads of one tick are one tick; the first is the latch.
        if self.read.is_some_and(|read| at.0 - read.0 < period_ns / 2) {
            return;
        }
        self.sample_ns = period_ns;
        self.read = Some(at);
        self.begun = at;
        self.clock += 1;
        self.has_ticked = true;
        self.sample = Sample { at_ns: at.0, clock: Some(self.clock), ..self.sample };
        self.next = Next::Duty;
        self.due = VirtualNanos(at.0 + self.sample_ns / 4);
    }

    /// Everything that is due at `at`.
    ///
    /// # Errors
    /// If the emulator refuses to read its own memory.
    pub fn act(
        &mut self,
        board: &mut EmulatedBoard,
        host: &mut dyn Host,
        at: VirtualNanos,
    ) -> Result<(), HostError> {
        if self.drain_at <= at {
            self.drain_at = VirtualNanos(at.0 + DRAIN_EVERY_NS);
            self.log.drain(host, at)?;
        }
        if self.due > at {
            return Ok(());
        }
        match self.next {
            Next::Tick => {
                self.begun = VirtualNanos(self.begun.0 + self.sample_ns);
                self.sample = Sample { at_ns: self.begun.0, clock: None, ..self.sample };
                self.take_duty(board, at);
            }
            Next::Duty => self.take_duty(board, at),
            Next::Edge { interval_ns } => {
                self.encoder.step_towards(self.disc(), board, at);
                if self.encoder.counts() == self.disc() {
                    self.await_tick();
                } else {
                    self.due = VirtualNanos(at.0.max(self.due.0) + interval_ns.max(1));
                }
            }
        }
        Ok(())
    }

    /// The joint gets what is on the bridge for a sample.
    fn take_duty(&mut self, board: &mut EmulatedBoard, at: VirtualNanos) {
        let bridge = self.spans.look(board, at);
        let code = if bridge.is_on() { self.code(&bridge) } else { 0 };
        self.sample = Sample { bridge, code, ..self.sample };
        self.samples += 1;
        // Before the first tick it rests, and its time does not count.
        if self.has_ticked {
            let usual_s = self.joint.sample_time_s();
            let sample_s =
                if self.sample_ns == nanoseconds(usual_s) { usual_s } else { self.sample_ns as f64 * 1e-9 };
            self.joint.hold(code, bridge.is_on(), self.brake_v, sample_s);
        }
        self.replan(at);
    }

    /// The code of a duty; that of the nearest duty if it is of another program than that of the machine.
    fn code(&mut self, bridge: &Bridge) -> i16 {
        if bridge.top != self.drive.pwm_top() {
            let pwm_hz = STM32F405.pwm_clock_hz / (2.0 * f32::from(bridge.top));
            let config = DriveConfig { pwm_hz, ..self.config };
            if let Ok(drive) = Drive::new(&config, &STM32F405) {
                (self.config, self.drive) = (config, drive);
            }
        }
        let duty = bridge.duty(self.drive.mode());
        code_of(duty, &self.drive, self.sample.code).unwrap_or_else(|| nearest_code(duty, &self.drive))
    }

    /// What the disc shows, in counts.
    fn disc(&self) -> i64 {
        self.joint.disc() + self.noise
    }

    fn await_tick(&mut self) {
        self.next = Next::Tick;
        self.due = VirtualNanos(self.begun.0 + 3 * self.sample_ns / 2);
    }

    /// The edges from where the disc is shown to be to where it is, up to 0.9 of the sample.
    fn replan(&mut self, now: VirtualNanos) {
        if let Next::Duty = self.next
            && self.due > now
        {
            return;
        }
        let distance = self.encoder.counts().abs_diff(self.disc());
        if distance == 0 {
            return self.await_tick();
        }
        let last = self.begun.0 + self.sample_ns / 10 * 9;
        let interval_ns = (last.saturating_sub(now.0) / distance).max(SHORTEST_NS);
        self.next = Next::Edge { interval_ns };
        self.due = VirtualNanos(now.0 + interval_ns);
    }
}

/// Between two edges: the filter of the firmware's inputs passes 95 ns.
const SHORTEST_NS: u64 = 200;

fn nanoseconds(seconds: f64) -> u64 {
    (seconds * 1e9).round() as u64
}
