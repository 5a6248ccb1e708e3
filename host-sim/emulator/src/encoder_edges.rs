//! The encoder's two wires, edge by edge.
//!
//! ```text
//! counts   0  1  2  3  4
//! A       __/----\____/--      A rises first when the joint moves the way that counts up
//! B       _____/----\____
//! ```

use rigless::device::Level;
use rigless::soc::stm32f427::peripherals::gpio::Pin;
use rigless::soc::stm32f427::peripherals::tim::Channel;
use rigless::time::VirtualNanos;

use super::board::{EmulatedBoard, GpioPort};
use files::encoder::Wires;

/// TIM2, by its place in the emulator's table of general-purpose timers.
const TIM2: usize = 0;
/// Alternate function 1 of PA0 and PA1 is TIM2.
const TIM2_FUNCTION: u8 = 1;

/// Encoder with two wires, by the edges on them.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct EncoderEdges {
    /// Edges since power-on: those up minus those down.
    counts: i64,
    wires: Wires,
}

impl EncoderEdges {
    /// Returns the shown position of the disc, counts.
    pub const fn counts(&self) -> i64 {
        self.counts
    }

    /// Moves the disc by one count towards `target`, and drives the edge on the wires. Does nothing
    /// if the disc is there.
    pub fn step_towards(&mut self, target: i64, board: &mut EmulatedBoard, at: VirtualNanos) {
        let before = self.driven();
        self.counts += (target - self.counts).signum();
        let now = self.driven();
        for pin in [0, 1] {
            if before[pin] != now[pin] {
                drive(board, at, pin as u8, now[pin]);
            }
        }
    }

    /// Cuts, swaps or restores the wires.
    pub fn rewire(&mut self, wires: Wires, board: &mut EmulatedBoard, at: VirtualNanos) {
        self.wires = wires;
        self.show(board, at);
    }

    /// Drives the levels of the wires. Must be called once a tick: the emulated microcontroller
    /// loses the levels in a reset, and a pin whose wire is cut follows the resistor that the
    /// firmware has set.
    pub fn show(&self, board: &mut EmulatedBoard, at: VirtualNanos) {
        for (pin, level) in [0, 1].into_iter().zip(self.driven()) {
            drive(board, at, pin, level);
        }
    }

    /// Returns the levels of the wires at the pins A and B; `None` for a pin whose wire is cut.
    fn driven(&self) -> [Option<Level>; 2] {
        let [a, b] = levels(self.counts).map(Some);
        match self.wires {
            Wires::Sound => [a, b],
            Wires::Swapped => [b, a],
            Wires::OneCut => [None, b],
            Wires::Cut => [None, None],
        }
    }

    /// Returns whether the firmware has connected TIM2 to the pins of the encoder.
    pub fn connected(board: &mut EmulatedBoard) -> bool {
        [0, 1].into_iter().all(|pin| board.function(GpioPort::A, pin) == Some(TIM2_FUNCTION))
    }
}

/// Drives a pin, or releases it, so that it follows its resistor. The emulated port and timer do
/// not share their pins, so the level of the port is set at the timer as well.
fn drive(board: &mut EmulatedBoard, at: VirtualNanos, pin: u8, level: Option<Level>) {
    let (Some(channel), Some(place)) = (Channel::new(pin + 1), Pin::new(pin)) else { return };
    let level = board.mcu.drive_port(at, GpioPort::A as usize, |port, registers, context| {
        port.drive(place, level, registers, context);
        port.level(place, registers)
    });
    board.mcu.drive_timer(at, TIM2, |timer, registers, context| {
        timer.drive_input(channel, level, registers, context);
    });
}

const fn levels(counts: i64) -> [Level; 2] {
    match counts.rem_euclid(4) {
        0 => [Level::Low, Level::Low],
        1 => [Level::High, Level::Low],
        2 => [Level::High, Level::High],
        _ => [Level::Low, Level::High],
    }
}
