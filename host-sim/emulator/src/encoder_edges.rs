//! The encoder's two wires, edge by edge.
//!
//! ```text
//! counts   0  1  2  3  4
//! A       __/----\____/--      A rises first when the joint moves the way that counts up
//! B       _____/----\____
//! ```

use rigless::device::Level;
use rigless::soc::stm32f427::peripherals::tim::Channel;
use rigless::time::VirtualNanos;

use super::board::{EmulatedBoard, GpioPort};
use files::encoder::Wires;

/// TIM2, by its place in the part's table of general-purpose timers.
const TIM2: usize = 0;
/// Alternate function 1 of PA0 and PA1 is TIM2.
const TIM2_FUNCTION: u8 = 1;

/// An encoder, as far as its wires show where it is.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct EncoderEdges {
    /// Edges since power-on, up less down.
    counts: i64,
    wires: Wires,
}

impl EncoderEdges {
    /// Where the disc is.
    pub const fn counts(&self) -> i64 {
        self.counts
    }

    /// Moves the disc by one count towards `target`, and shows the edge to the part. Nothing to do
    /// if it is there.
    pub fn step_towards(&mut self, target: i64, board: &mut EmulatedBoard, at: VirtualNanos) {
        let before = self.pins();
        self.counts += (target - self.counts).signum();
        let now = self.pins();
        for (number, before, now) in [(1, before.0, now.0), (2, before.1, now.1)] {
            if before != now {
                drive(board, at, number, now);
            }
        }
    }

    /// Lets something happen to the wires.
    pub fn rewire(&mut self, wires: Wires, board: &mut EmulatedBoard, at: VirtualNanos) {
        self.wires = wires;
        self.show(board, at);
    }

    /// Shows the wires as they are: to be called after a reset of the part, which forgets them.
    pub fn show(&self, board: &mut EmulatedBoard, at: VirtualNanos) {
        let (a, b) = self.pins();
        drive(board, at, 1, a);
        drive(board, at, 2, b);
    }

    /// What the part's two pins see. A wire that is cut leaves its pin to the pull-up.
    const fn pins(&self) -> (Level, Level) {
        let (a, b) = levels(self.counts);
        match self.wires {
            Wires::Sound => (a, b),
            Wires::Swapped => (b, a),
            Wires::OneCut => (Level::High, b),
            Wires::Cut => (Level::High, Level::High),
        }
    }

    /// Whether the firmware has connected TIM2 to the pins that the encoder is soldered to.
    pub fn connected(board: &mut EmulatedBoard) -> bool {
        [0, 1].into_iter().all(|pin| board.function(GpioPort::A, pin) == Some(TIM2_FUNCTION))
    }
}

fn drive(board: &mut EmulatedBoard, at: VirtualNanos, channel: u8, level: Level) {
    let Some(channel) = Channel::new(channel) else { return };
    board.mcu.drive_timer(at, TIM2, |timer, registers, context| {
        timer.drive_input(channel, level, registers, context);
    });
}

const fn levels(counts: i64) -> (Level, Level) {
    match counts.rem_euclid(4) {
        0 => (Level::Low, Level::Low),
        1 => (Level::High, Level::Low),
        2 => (Level::High, Level::High),
        _ => (Level::Low, Level::High),
    }
}
