//! Lockstep: the loop as the host models it.
//!
//! ```text
//! counter read       duty taken       last edge        counter read
//! |------ h/4 -------|---- edges -----|---- 0.1 h -----|
//! ```
//!
//! The duty that a tick has put out is taken a quarter of a sample later and holds from the tick on. The joint is then
//! moved by a whole sample at once, and the edges that lead to its new position are shown before the next tick.

use rigless::time::NO_DEADLINE;
use rigless::time::VirtualNanos;

use super::board::EmulatedBoard;
use super::bridge::Bridge;
use super::encoder_edges::EncoderEdges;
use super::in_the_loop::{Mode, Part, Stopped, Wired};
use crate::solver::AxisSolver;

/// What comes next.
#[derive(Clone, Copy, Debug)]
enum Next {
    /// The image reads the counter.
    Tick,
    /// Its duty is taken.
    Duty { counter: u32 },
    /// An edge, and more of them at this interval.
    Edge { interval_ns: u64 },
}

/// The loop in lockstep.
#[derive(Debug)]
pub struct Lockstep {
    sample_ns: u64,
    next: Next,
    at: VirtualNanos,
    /// The last tick.
    tick: Option<VirtualNanos>,
}

impl Lockstep {
    /// For a loop that samples every `sample_ns`.
    pub const fn new(sample_ns: u64) -> Self {
        Self { sample_ns, next: Next::Tick, at: NO_DEADLINE, tick: None }
    }

    /// Waits for the next tick, but not much longer than a sample.
    fn await_tick(&mut self, from: VirtualNanos) {
        self.next = Next::Tick;
        self.at = VirtualNanos(from.0 + 3 * self.sample_ns / 2);
    }

    /// The edges from where the disc is shown to be to where it is, up to 0.9 of the sample.
    fn plan_edges(&mut self, distance: u64, now: VirtualNanos, tick: VirtualNanos) {
        if distance == 0 {
            self.await_tick(tick);
            return;
        }
        let last = tick.0 + self.sample_ns / 10 * 9;
        let interval_ns = last.saturating_sub(now.0) / distance;
        self.next = Next::Edge { interval_ns };
        self.at = VirtualNanos(now.0 + interval_ns.max(1));
    }
}

impl<S: AxisSolver + Clone> Mode<S> for Lockstep {
    fn counter_read(&mut self, wired: &mut Wired<S>, counter: u32, at: VirtualNanos) -> Result<(), Stopped> {
        if let Some(last) = self.tick {
            let since_ns = at.0 - last.0;
            // Several reads of one tick are one tick; the first is the latch.
            if since_ns < self.sample_ns / 2 {
                return Ok(());
            }
            if wired.joint.has_begun() {
                on_time(since_ns, self.sample_ns)?;
                if let Next::Edge { .. } = self.next {
                    return Err(Stopped::Misbehaves(
                        "it has ticked before the encoder's edges were over".into(),
                    ));
                }
                let disc = wired.joint.disc();
                if counter != disc as u32 {
                    let time_s = wired.joint.time_s();
                    let found = counter as i32;
                    return Err(Stopped::Misbehaves(format!(
                        "its encoder counter reads {found} at {time_s} s, and the disc is at {disc}: the edges come \
                         faster than its input filter passes them, or the wires are swapped"
                    )));
                }
            }
        }
        self.tick = Some(at);
        self.next = Next::Duty { counter };
        self.at = VirtualNanos(at.0 + self.sample_ns / 4);
        Ok(())
    }

    fn duty_written(&mut self, _: &mut Wired<S>, _: &mut EmulatedBoard, _: VirtualNanos) {}

    fn next(&self) -> VirtualNanos {
        self.at
    }

    fn due(&mut self, wired: &mut Wired<S>, part: &mut Part<'_>, at: VirtualNanos) -> Result<(), Stopped> {
        let tick = self.tick.unwrap_or(at);
        match self.next {
            Next::Tick if wired.joint.has_begun() => Err(Stopped::Misbehaves(format!(
                "its control tick has stopped after {} ticks",
                wired.joint.ticks()
            ))),
            Next::Tick => {
                self.at = NO_DEADLINE;
                Ok(())
            }
            Next::Duty { counter } => {
                if let Some(code) = take_duty(wired, part, counter, None)? {
                    let v = f64::from(code) * wired.joint.closed_loop.lsb_v;
                    if !wired.joint.has_ended() {
                        let from_s = (wired.joint.ticks() - 1) as f64 * wired.joint.closed_loop.sample_time_s;
                        wired.joint.drive(v, from_s, wired.joint.closed_loop.sample_time_s);
                    }
                }
                self.plan_edges(wired.encoder.counts().abs_diff(wired.joint.disc()), at, tick);
                Ok(())
            }
            Next::Edge { interval_ns } => {
                let disc = wired.joint.disc();
                wired.encoder.step_towards(disc, part.board, at);
                if wired.encoder.counts() == disc {
                    self.await_tick(tick);
                } else {
                    self.at = VirtualNanos(at.0.max(self.at.0) + interval_ns.max(1));
                }
                Ok(())
            }
        }
    }
}

/// Lets the joint have the duty of a tick, once the bridge is on. `at_tick` is the joint when the counter was read, if it
/// has moved since. No duty: the motion has not begun, or it is over.
pub fn take_duty<S: AxisSolver + Clone>(
    wired: &mut Wired<S>,
    part: &mut Part<'_>,
    counter: u32,
    at_tick: Option<&S>,
) -> Result<Option<i16>, Stopped> {
    let (joint, bridge) = (&mut wired.joint, Bridge::read(part.board));
    let (time_s, ends) = (joint.time_s(), joint.ends_with(counter));
    match (bridge.is_on(), joint.has_begun()) {
        (false, false) => return Ok(None),
        (false, true) if !ends => {
            return Err(Stopped::Misbehaves(format!("it has turned its bridge off at {time_s} s")));
        }
        (true, _) if ends => {
            let why = format!("its bridge is still on at {time_s} s, when its ramp is over");
            return Err(Stopped::Misbehaves(why));
        }
        _ => {}
    }
    if !joint.has_begun() {
        let top = joint.closed_loop.controller.drive().pwm_top();
        if !EncoderEdges::connected(part.board) {
            let why = "PA0 and PA1, where the encoder is, are not connected to TIM2";
            return Err(Stopped::Misbehaves(why.into()));
        }
        if bridge.top != top {
            let why = format!("its PWM turns around at {}, not at {top} as drive.pwm_hz asks", bridge.top);
            return Err(Stopped::Misbehaves(why));
        }
    }
    let at_tick = at_tick.cloned().unwrap_or_else(|| joint.solver.clone());
    joint.tick(counter, &bridge, part.last_tick()?, &at_tick).map_err(Stopped::Differs)
}

/// Refuses a sample that is more than a hundredth (and 2 us, for an interrupt that is held up) off.
pub fn on_time(since_ns: u64, sample_ns: u64) -> Result<(), Stopped> {
    if since_ns.abs_diff(sample_ns) <= sample_ns / 100 + 2_000 {
        return Ok(());
    }
    let (found, asked) = (since_ns as f64 * 1e-6, sample_ns as f64 * 1e-6);
    Err(Stopped::Misbehaves(format!("it ticks after {found} ms instead of {asked} ms")))
}
