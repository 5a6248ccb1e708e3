//! Free-running: edges and PWM at their own times.
//!
//! The joint moves all the time, under the effort that is on the bridge at that instant. An edge comes when the joint
//! crosses it. A duty takes effect at the PWM's next turn, up or down, where the timer loads what has been written; the
//! ripple within a period is not simulated, only its mean.

use rigless::time::{NO_DEADLINE, VirtualNanos};

use super::board::{CLOCK_HZ, EmulatedBoard};
use super::bridge::{Bridge, code_of};
use super::in_the_loop::{Mode, Part, Stopped, Wired};
use super::lockstep::{on_time, take_duty};
use crate::closed_loop::hold;
use crate::solver::AxisSolver;

const TIM1_CR1: u64 = 0x4001_0000;
const TIM1_CNT: u64 = 0x4001_0024;
const TIM1_ARR: u64 = 0x4001_002C;
/// The timer counts down.
const DIR: u32 = 1 << 4;
/// An edge is looked for no further ahead than this, so that a joint that turns back within it loses no more than the
/// flicker of one count.
const HORIZON_NS: u64 = 500_000;
/// How exactly an edge is located.
const EDGE_NS: u64 = 5;

/// The loop with its own times.
#[derive(Debug)]
pub struct FreeRunning<S> {
    sample_ns: u64,
    /// The first tick of the motion.
    origin: Option<VirtualNanos>,
    /// Until when the joint has been moved.
    moved_to: VirtualNanos,
    applied_v: f64,
    /// The last tick: when, what it read, and where the joint was.
    tick: Option<(VirtualNanos, u32, S)>,
    duty_at: VirtualNanos,
    effect_at: VirtualNanos,
    edge_at: VirtualNanos,
    last_tick_by: VirtualNanos,
}

impl<S: AxisSolver + Clone> FreeRunning<S> {
    /// For a loop that samples every `sample_ns`.
    pub const fn new(sample_ns: u64) -> Self {
        Self {
            sample_ns,
            origin: None,
            moved_to: VirtualNanos(0),
            applied_v: 0.0,
            tick: None,
            duty_at: NO_DEADLINE,
            effect_at: NO_DEADLINE,
            edge_at: NO_DEADLINE,
            last_tick_by: NO_DEADLINE,
        }
    }

    /// Moves the joint to `at`. Before the motion begins it rests.
    fn move_to(&mut self, wired: &mut Wired<S>, at: VirtualNanos) {
        let Some(origin) = self.origin else {
            self.moved_to = at;
            return;
        };
        if at > self.moved_to {
            let from_s = seconds(self.moved_to.0.saturating_sub(origin.0));
            wired.joint.drive(self.applied_v, from_s, seconds(at.0 - self.moved_to.0));
            self.moved_to = at;
        }
    }

    /// When the joint crosses its next edge, or when to look again.
    fn look_ahead(&mut self, wired: &Wired<S>) {
        let Some(origin) = self.origin else { return };
        let now = wired.encoder.counts();
        let from_s = seconds(self.moved_to.0.saturating_sub(origin.0));
        let disc_after = |ns: u64| {
            let mut ahead = wired.joint.solver.clone();
            let axis = &wired.joint.closed_loop.axis;
            hold(&mut ahead, axis, self.applied_v, [from_s, seconds(ns)], &mut |_| {});
            wired.joint.disc_at(ahead.position())
        };
        let (mut before, mut after) = (0, HORIZON_NS);
        if disc_after(after) != now {
            while after - before > EDGE_NS {
                let middle = before.midpoint(after);
                if disc_after(middle) == now {
                    before = middle;
                } else {
                    after = middle;
                }
            }
        }
        self.edge_at = VirtualNanos(self.moved_to.0 + after);
    }
}

impl<S: AxisSolver + Clone + Send> Mode<S> for FreeRunning<S> {
    fn counter_read(&mut self, wired: &mut Wired<S>, counter: u32, at: VirtualNanos) -> Result<(), Stopped> {
        if let Some((last, ..)) = &self.tick {
            let since_ns = at.0 - last.0;
            if since_ns < self.sample_ns / 2 {
                return Ok(());
            }
            if wired.joint.has_begun() {
                on_time(since_ns, self.sample_ns)?;
            }
        }
        self.move_to(wired, at);
        self.tick = Some((at, counter, wired.joint.solver.clone()));
        self.duty_at = VirtualNanos(at.0 + self.sample_ns / 4);
        self.last_tick_by = VirtualNanos(at.0 + 3 * self.sample_ns / 2);
        Ok(())
    }

    fn duty_written(&mut self, wired: &mut Wired<S>, board: &mut EmulatedBoard, at: VirtualNanos) {
        let mut register = |address| board.peek(at, address).map(u64::from);
        let (Some(control), Some(count), Some(top)) =
            (register(TIM1_CR1), register(TIM1_CNT), register(TIM1_ARR))
        else {
            return;
        };
        let clocks = if control & u64::from(DIR) == 0 { top.saturating_sub(count) } else { count };
        self.effect_at = VirtualNanos(at.0 + (clocks * 1_000_000_000).div_ceil(CLOCK_HZ.get()));
        if let (Some((tick, ..)), Some(_)) = (&self.tick, self.origin) {
            wired.latencies_ns.push(self.effect_at.0 - tick.0);
        }
    }

    fn next(&self) -> VirtualNanos {
        self.duty_at.min(self.effect_at).min(self.edge_at).min(self.last_tick_by)
    }

    fn due(&mut self, wired: &mut Wired<S>, part: &mut Part<'_>, at: VirtualNanos) -> Result<(), Stopped> {
        self.move_to(wired, at);
        if self.effect_at <= at {
            self.effect_at = NO_DEADLINE;
            let bridge = Bridge::read(part.board);
            let drive = wired.joint.closed_loop.controller.drive();
            let code = code_of(bridge.duty(drive.mode()), drive, 0).filter(|_| bridge.is_on());
            let now_v = f64::from(code.unwrap_or(0)) * wired.joint.closed_loop.lsb_v;
            if now_v != 0.0 && self.origin.is_none() {
                // Until now the joint has had no reason to move: the motion's clock begins with the tick behind this.
                self.origin = self.tick.as_ref().map(|(tick, ..)| *tick);
            }
            self.applied_v = now_v;
        }
        if self.duty_at <= at {
            self.duty_at = NO_DEADLINE;
            if let Some((tick, counter, joint)) = self.tick.clone()
                && take_duty(wired, part, counter, Some(&joint))?.is_some()
            {
                self.origin.get_or_insert(tick);
            }
        }
        if self.last_tick_by <= at && wired.joint.has_begun() {
            let ticks = wired.joint.ticks();
            return Err(Stopped::Misbehaves(format!("its control tick has stopped after {ticks} ticks")));
        }
        if self.last_tick_by <= at {
            self.last_tick_by = NO_DEADLINE;
        }
        let disc = wired.joint.disc();
        if wired.encoder.counts() != disc {
            wired.encoder.step_towards(disc, part.board, at);
        }
        if wired.encoder.counts() == disc {
            self.look_ahead(wired);
        } else {
            self.edge_at = VirtualNanos(at.0 + HORIZON_NS / 100);
        }
        Ok(())
    }
}

fn seconds(ns: u64) -> f64 {
    ns as f64 * 1e-9
}
