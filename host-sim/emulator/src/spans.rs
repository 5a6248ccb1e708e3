//! Times at which the bridge was on, to the instruction: checked after every write to a register
//! and at every stop.

use rigless::time::VirtualNanos;

use super::board::EmulatedBoard;
use super::bridge::BridgeInputs;

/// Observations of the bridge.
#[derive(Clone, Debug, Default)]
pub struct Spans {
    /// Spans of time in which the bridge was on, ns since power-on.
    pub on_ns: Vec<[u64; 2]>,
    /// Last time at which the bridge's outputs or its enable pin were on, ns since power-on.
    pub any_ns: u64,
    /// State of the bridge when it was last seen on.
    pub last: BridgeInputs,
    /// Compare values with which the bridge was on, each with the time from which it was set, ns.
    pub compares: Vec<(u64, u16)>,
    was_on: bool,
    was_any: bool,
}

impl Spans {
    /// Reads the bridge, and records its state.
    pub fn look(&mut self, board: &mut EmulatedBoard, at: VirtualNanos) -> BridgeInputs {
        let bridge = BridgeInputs::read(board);
        let is_on = bridge.is_on();
        if is_on {
            self.last = bridge;
            if self.compares.last().is_none_or(|(_, compare)| *compare != bridge.compare) {
                self.compares.push((at.0, bridge.compare));
            }
        }
        match self.on_ns.last_mut() {
            Some([_, until]) if self.was_on => *until = at.0,
            _ if is_on => self.on_ns.push([at.0, at.0]),
            _ => {}
        }
        self.was_on = is_on;
        let is_any = bridge.outputs || bridge.enable;
        if is_any || self.was_any {
            self.any_ns = at.0;
        }
        self.was_any = is_any;
        bridge
    }

    /// Returns whether the bridge was on at any time after `at_ns`.
    pub fn on_after(&self, at_ns: u64) -> bool {
        self.on_ns.iter().any(|[_, until]| *until > at_ns)
    }
}
