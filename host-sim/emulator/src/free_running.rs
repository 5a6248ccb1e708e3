//! Free-running: edges and PWM at their own times.
//!
//! The plant moves all the time, under the effort that is on the bridge at that instant. An edge
//! comes when the joint crosses it. A duty takes effect at the next turning point of the PWM, up or
//! down, where the timer loads the written value. Only the mean of a PWM period is simulated, not
//! its ripple.
//!
//! No [`Target`](simulator::target::Target) is stepped, since it ticks once a sample: here the
//! microcontroller needs the plant at every edge and at every turning point of the PWM, and
//! determines the times of its ticks.

use rigless::time::{NO_DEADLINE, VirtualNanos};

use super::board::{CLOCK_HZ, EmulatedBoard};
use super::bridge::BridgeInputs;
use super::coupling::{PlantCoupling, Sampling};
use super::encoder_edges::Encoders;
use super::plant_interface::PowerStage;
use dynamics::solver::{AxisSolver, Event};
use simulator::plant::Plant;

const TIM1_CR1: u64 = 0x4001_0000;
const TIM1_CNT: u64 = 0x4001_0024;
const TIM1_ARR: u64 = 0x4001_002C;
/// The timer counts down.
const DIR: u32 = 1 << 4;
/// Longest time ahead for which an edge is searched, ns. A joint that reverses within it loses at
/// most the flicker of one count.
const HORIZON_NS: u64 = 500_000;
/// Accuracy of the time of an edge, ns.
const EDGE_NS: u64 = 5;

/// Free-running coupling: the plant moves whenever the microcontroller's time advances.
#[derive(Debug)]
pub struct FreeRunning<S> {
    /// Plant that the bridge drives.
    pub plant: Plant<S>,
    /// State of the joint when the image last read the counter.
    pub at_tick: S,
    /// Breaks, sticks and reversals of the joint so far.
    pub events: Vec<Event>,
    /// Latencies, ns: from each read of the counter until the duty of that tick takes effect.
    pub latencies_ns: Vec<u64>,
    stage: PowerStage,
    sampling: Sampling,
    encoders: Encoders,
    /// The first tick of the motion.
    origin: Option<VirtualNanos>,
    /// Time up to which the joint has been moved.
    moved_to: VirtualNanos,
    applied_v: f64,
    effect_at: VirtualNanos,
    edge_at: VirtualNanos,
}

impl<S: AxisSolver + Clone> FreeRunning<S> {
    /// Couples a plant with a microcontroller whose planned sample time is `period_ns`.
    pub fn new(plant: Plant<S>, stage: PowerStage, period_ns: u64) -> Self {
        Self {
            at_tick: plant.solver.clone(),
            encoders: Encoders::of(&plant.discs(), None),
            plant,
            events: Vec::new(),
            latencies_ns: Vec::new(),
            stage,
            sampling: Sampling::new(period_ns),
            origin: None,
            moved_to: VirtualNanos(0),
            applied_v: 0.0,
            effect_at: NO_DEADLINE,
            edge_at: NO_DEADLINE,
        }
    }

    /// Moves the joint up to the time `at`. Before the motion starts, the joint rests.
    fn move_to(&mut self, at: VirtualNanos) {
        let Some(origin) = self.origin else {
            self.moved_to = at;
            return;
        };
        if at > self.moved_to {
            let from_s = seconds(self.moved_to.0.saturating_sub(origin.0));
            let span_s = [from_s, seconds(at.0 - self.moved_to.0)];
            let events = &mut self.events;
            self.plant.hold_from(self.applied_v, span_s, &mut |event| events.push(event));
            self.moved_to = at;
        }
    }

    /// Sets the time at which the joint crosses its next edge, or at which to search again.
    fn look_ahead(&mut self) {
        let Some(origin) = self.origin else { return };
        let now = self.encoders.shown();
        let from_s = seconds(self.moved_to.0.saturating_sub(origin.0));
        let discs_after = |ns| self.plant.discs_after(self.applied_v, [from_s, seconds(ns)]);
        let (mut before, mut after) = (0, HORIZON_NS);
        if discs_after(after) != now {
            while after - before > EDGE_NS {
                let middle = before.midpoint(after);
                if discs_after(middle) == now {
                    before = middle;
                } else {
                    after = middle;
                }
            }
        }
        self.edge_at = VirtualNanos(self.moved_to.0 + after);
    }
}

impl<S> PlantCoupling for FreeRunning<S>
where
    S: AxisSolver + Clone + Send + std::fmt::Debug + 'static,
{
    fn sampling(&self) -> &Sampling {
        &self.sampling
    }

    fn encoders(&self) -> Encoders {
        self.encoders
    }

    fn counter_read(&mut self, board: &mut EmulatedBoard, counter: u32, at: VirtualNanos) {
        if self.sampling.read(board, counter, self.encoders.shown(), at) {
            self.move_to(at);
            self.at_tick = self.plant.solver.clone();
        }
    }

    fn duty_written(&mut self, board: &mut EmulatedBoard, at: VirtualNanos) {
        let mut register = |address| board.peek(at, address).map(u64::from);
        let (Some(control), Some(count), Some(top)) =
            (register(TIM1_CR1), register(TIM1_CNT), register(TIM1_ARR))
        else {
            return;
        };
        let clocks = if control & u64::from(DIR) == 0 { top.saturating_sub(count) } else { count };
        self.effect_at = VirtualNanos(at.0 + (clocks * 1_000_000_000).div_ceil(CLOCK_HZ.get()));
        if self.origin.is_some() {
            self.latencies_ns.push(self.effect_at.0 - self.sampling.begun.0);
        }
    }

    fn next(&self) -> VirtualNanos {
        self.sampling.due.min(self.effect_at).min(self.edge_at)
    }

    fn act(&mut self, board: &mut EmulatedBoard, at: VirtualNanos) {
        self.move_to(at);
        if self.effect_at <= at {
            self.effect_at = NO_DEADLINE;
            let code = self.stage.code(&BridgeInputs::read(board), 0);
            self.applied_v = self.plant.volts(code);
            if self.applied_v != 0.0 && self.sampling.has_ticked {
                // Until now nothing has driven the joint: the clock of the motion starts with the
                // tick of this duty.
                self.origin.get_or_insert(self.sampling.begun);
            }
        }
        if self.sampling.due <= at {
            let bridge = BridgeInputs::read(board);
            if self.sampling.is_open && bridge.is_on() {
                self.origin.get_or_insert(self.sampling.begun);
            }
            self.sampling.take(bridge, self.stage.code(&bridge, 0));
            self.encoders.show(board, at);
        }
        let discs = self.plant.discs();
        if self.encoders.shown() != discs {
            self.encoders.step_towards(&discs, board, at);
        }
        if self.encoders.shown() == discs {
            self.look_ahead();
        } else {
            self.edge_at = VirtualNanos(at.0 + HORIZON_NS / 100);
        }
    }

    fn reset(&mut self, board: &mut EmulatedBoard, at: VirtualNanos) {
        self.encoders.show(board, at);
        self.sampling.reset();
    }
}

fn seconds(ns: u64) -> f64 {
    ns as f64 * 1e-9
}
