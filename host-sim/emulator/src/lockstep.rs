//! Lockstep: the loop as the host models it.
//!
//! ```text
//! counter read       duty taken       last edge        counter read
//! |------ h/4 -------|---- edges -----|---- 0.1 h -----|
//! ```
//!
//! The duty of a tick is taken over a quarter of a sample later, and applies from the tick on. The
//! plant is then moved by a whole sample at once, and the edges to its new position are sent before
//! the next tick. The motor's current at the end of that sample is on its pin from there on, and is
//! converted once, at the next trigger of the timer: further conversions would read the same. A
//! supply with a capacitor is on its pin from there on as well; the next tick starts its
//! conversion.
//!
//! Under a current loop the plant is moved once a period of the PWM, at the upper end of its count:
//! by half a period, of which the current is converted, and by the other half at once. Edges to the
//! position at the lower end follow within the first part of that half. The duty is the one that
//! the interrupt of the period before has set.
//!
//! Limits: a bridge that turns off within a sample (or a period) is off for the joint from the next
//! one on.

use rigless::time::{NO_DEADLINE, VirtualNanos};

use super::board::EmulatedBoard;
use super::bridge::BridgeInputs;
use super::coupling::{PlantCoupling, Sampling};
use super::encoder_edges::Encoders;
use super::plant_interface::PlantInterface;
use files::encoder::Wires;
use simulator::plant::Discs;

/// Shortest time between two edges, ns: the filter of the firmware's inputs passes 95 ns.
const SHORTEST_NS: u64 = 100;

/// Lockstep coupling: the plant waits for the microcontroller, sample by sample.
#[derive(Debug)]
pub struct Lockstep<P> {
    /// Plant on the pins.
    pub plant: P,
    sampling: Sampling,
    encoders: Encoders,
    /// Counts that noise has added to the position of the first disc.
    noise: i64,
    edge_at: VirtualNanos,
    interval_ns: u64,
    /// Next conversion of the motor's current.
    convert_at: VirtualNanos,
}

impl<P: PlantInterface> Lockstep<P> {
    /// Couples a plant with a microcontroller whose planned sample time is `period_ns`.
    pub fn new(plant: P, period_ns: u64) -> Self {
        Self {
            encoders: Encoders::of(&plant.discs(), plant.index()),
            plant,
            sampling: Sampling::new(period_ns),
            noise: 0,
            edge_at: NO_DEADLINE,
            interval_ns: 0,
            convert_at: NO_DEADLINE,
        }
    }

    /// Puts noise on the wires of the first encoder: a number of edges before the next tick.
    pub fn jump(&mut self, counts: i32, at: VirtualNanos) {
        self.noise += i64::from(counts);
        self.encoders.add_noise(counts.into());
        self.replan(at);
    }

    /// Cuts, swaps or restores the wires of the first encoder.
    pub fn rewire(&mut self, wires: Wires, board: &mut EmulatedBoard, at: VirtualNanos) {
        self.encoders.rewire(wires, board, at);
    }

    /// Cuts, swaps or restores the wires of the load's encoder, if there are two.
    pub fn rewire_load(&mut self, wires: Wires, board: &mut EmulatedBoard, at: VirtualNanos) {
        self.encoders.rewire_load(wires, board, at);
    }

    /// Returns the positions of the discs, the first one with noise.
    fn discs(&self) -> Discs {
        let discs = self.plant.discs();
        Discs { first: discs.first + self.noise, ..discs }
    }

    /// Plans the edges from the shown positions of the discs to their present ones, up to 0.9 of
    /// the sample. Must be called when the plant has moved.
    pub fn replan(&mut self, now: VirtualNanos) {
        if self.sampling.is_open && !self.plant.is_regulated() {
            return;
        }
        let last = self.sampling.begun.0 + self.sampling.period_ns / 10 * 9;
        self.replan_until(now, last);
    }

    /// Plans the edges to the present positions of the discs, up to an instant, ns.
    fn replan_until(&mut self, now: VirtualNanos, last: u64) {
        let distance = self.encoders.distance(&self.discs());
        match last.saturating_sub(now.0).checked_div(distance) {
            None => self.edge_at = NO_DEADLINE,
            Some(interval_ns) => {
                self.interval_ns = interval_ns.max(SHORTEST_NS);
                self.edge_at = VirtualNanos(now.0 + self.interval_ns);
            }
        }
    }
}

impl<P: PlantInterface> Lockstep<P> {
    /// Shows the temperature of the motor to its sensor's pin.
    fn show_temperature(&self, board: &mut EmulatedBoard) {
        if let Some(pin_mv) = self.plant.temperature_mv() {
            board.temperature(pin_mv);
        }
    }

    /// Moves a regulated plant by a period of the PWM, and converts its current.
    fn period(&mut self, board: &mut EmulatedBoard, at: VirtualNanos) {
        let next = board.next_trigger(at).unwrap_or(NO_DEADLINE);
        self.convert_at = next;
        // Before the first tick the plant rests, and its time does not count.
        if self.sampling.has_ticked {
            let bridge = BridgeInputs::read(board);
            self.plant.hold_half(&bridge);
            if let Some(pin_mv) = self.plant.current_mv() {
                board.current(pin_mv);
            }
            self.plant.hold_half(&bridge);
            board.drive_switch(at, self.plant.is_switch_open(at.0 as f64 * 1e-9));
            self.encoders.show(board, at);
            let period_ns = next.0.saturating_sub(at.0);
            self.replan_until(at, at.0 + period_ns / 10 * 4);
        }
        board.trigger_current(at);
    }
}

impl<P: PlantInterface> PlantCoupling for Lockstep<P> {
    fn sampling(&self) -> &Sampling {
        &self.sampling
    }

    fn encoders(&self) -> Encoders {
        self.encoders
    }

    fn counter_read(&mut self, board: &mut EmulatedBoard, counter: u32, at: VirtualNanos) {
        let begins = self.sampling.read(board, counter, self.encoders.shown(), at);
        if begins && !self.plant.is_regulated() {
            self.edge_at = NO_DEADLINE;
        }
    }

    fn next(&self) -> VirtualNanos {
        self.sampling.due.min(self.edge_at).min(self.convert_at)
    }

    fn act(&mut self, board: &mut EmulatedBoard, at: VirtualNanos) {
        let is_regulated = self.plant.is_regulated();
        if self.convert_at <= at && is_regulated {
            self.period(board, at);
        } else if self.convert_at <= at {
            self.convert_at = NO_DEADLINE;
            board.trigger_current(at);
        }
        if self.sampling.due <= at && is_regulated {
            let bridge = BridgeInputs::read(board);
            let code = self.plant.code(&bridge);
            self.sampling.take(bridge, code);
            self.show_temperature(board);
            if self.convert_at == NO_DEADLINE {
                self.convert_at = board.next_trigger(at).unwrap_or(NO_DEADLINE);
            }
        } else if self.sampling.due <= at {
            let bridge = BridgeInputs::read(board);
            let Sampling { has_ticked, period_ns, .. } = self.sampling;
            // Before the first tick the plant rests, and its time does not count.
            let code = if has_ticked { self.plant.hold(&bridge, period_ns) } else { 0 };
            self.sampling.take(bridge, code);
            if let Some(pin_mv) = self.plant.supply_mv() {
                board.supply(pin_mv);
            }
            self.show_temperature(board);
            if let Some(pin_mv) = self.plant.current_mv() {
                board.current(pin_mv);
                self.convert_at = board.next_trigger(at).unwrap_or(NO_DEADLINE);
            }
            board.drive_switch(at, self.plant.is_switch_open(at.0 as f64 * 1e-9));
            self.encoders.show(board, at);
            self.replan(at);
        } else if self.edge_at <= at {
            self.encoders.step_towards(&self.discs(), board, at);
            self.edge_at = if self.encoders.shown() == self.discs() {
                NO_DEADLINE
            } else {
                VirtualNanos(at.0 + self.interval_ns)
            };
        }
    }

    fn reset(&mut self, board: &mut EmulatedBoard, at: VirtualNanos) {
        board.drive_switch(at, self.plant.is_switch_open(at.0 as f64 * 1e-9));
        self.encoders.show(board, at);
        self.sampling.reset();
    }
}
