//! The wires of the encoders, edge by edge.
//!
//! ```text
//! counts   0  1  2  3  4
//! A       __/----\____/--      A rises first when the joint moves the way that counts up
//! B       _____/----\____
//! ```
//!
//! The first encoder is on TIM2, that of a load beside it on TIM4. The index of the first one is on
//! TIM2's third channel. Its line follows the edge of A or B: the timer has counted it by then.

use rigless::device::Level;
use rigless::soc::stm32f427::peripherals::gpio::Pin;
use rigless::soc::stm32f427::peripherals::tim::Channel;
use rigless::time::VirtualNanos;

use super::as5047p::As5047p;
use super::board::{EmulatedBoard, GpioPort};
use files::encoder::Wires;
use simulator::home_sensors::IndexModel;
use simulator::plant::Discs;

/// The pins of an encoder, and the timer that counts its edges.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct EncoderInput {
    port: GpioPort,
    /// Number of the pin of line A; that of line B is the next one.
    first_pin: u8,
    /// The timer, by its place in the emulator's table of general-purpose timers.
    timer: usize,
    /// The alternate function of the pins that connects them to the timer.
    function: u8,
}

/// TIM2 on PA0 and PA1.
const FIRST: EncoderInput = EncoderInput { port: GpioPort::A, first_pin: 0, timer: 0, function: 1 };
/// Line of the first encoder's index: PA2, and channel 3 of TIM2.
const INDEX_LINE: u8 = 2;
/// TIM4 on PB6 and PB7.
const LOAD: EncoderInput = EncoderInput { port: GpioPort::B, first_pin: 6, timer: 2, function: 2 };

/// The encoders of a joint, by the edges on their wires.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Encoders {
    first: EncoderEdges,
    index: Option<IndexModel>,
    /// Turns of the first disc by noise on its wires, counts, which the index does not see.
    noise: i64,
    load: Option<LoadDisc>,
}

/// The encoder on the load.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum LoadDisc {
    /// Two lines.
    Edges(EncoderEdges),
    /// The chip on SPI, whose magnet is at a count.
    Chip(i64),
}

impl LoadDisc {
    const fn counts(&self) -> i64 {
        match self {
            Self::Edges(edges) => edges.counts,
            Self::Chip(counts) => *counts,
        }
    }
}

impl Encoders {
    /// Returns encoders at zero, as many as there are discs.
    pub fn of(discs: &Discs, index: Option<IndexModel>) -> Self {
        Self {
            index,
            noise: 0,
            first: EncoderEdges::at_zero(FIRST),
            load: discs.load.map(|counts| {
                if discs.is_absolute {
                    LoadDisc::Chip(counts)
                } else {
                    LoadDisc::Edges(EncoderEdges::at_zero(LOAD))
                }
            }),
        }
    }

    /// Returns the shown positions of the discs.
    pub fn shown(&self) -> Discs {
        let is_absolute = matches!(self.load, Some(LoadDisc::Chip(_)));
        Discs { first: self.first.counts, load: self.load.map(|load| load.counts()), is_absolute }
    }

    /// Returns the number of edges to `target` of the disc that has the longest way.
    pub fn distance(&self, target: &Discs) -> u64 {
        let load = self.load.zip(target.load).map_or(0, |(load, at)| match load {
            LoadDisc::Edges(edges) => edges.counts.abs_diff(at),
            // A magnet turns at once.
            LoadDisc::Chip(counts) => u64::from(counts != at),
        });
        self.first.counts.abs_diff(target.first).max(load)
    }

    /// Moves each disc by one count towards `target`, and drives the edges on the wires. A disc
    /// that is there stays.
    pub fn step_towards(&mut self, target: &Discs, board: &mut EmulatedBoard, at: VirtualNanos) {
        self.first.step_towards(target.first, board, at);
        self.show_index(board, at);
        if let (Some(load), Some(disc)) = (&mut self.load, target.load) {
            match load {
                LoadDisc::Edges(edges) => edges.step_towards(disc, board, at),
                LoadDisc::Chip(counts) => {
                    *counts = disc;
                    As5047p::turn(&mut board.mcu, disc);
                }
            }
        }
    }

    /// Cuts, swaps or restores the wires of the first encoder.
    pub fn rewire(&mut self, wires: Wires, board: &mut EmulatedBoard, at: VirtualNanos) {
        self.first.rewire(wires, board, at);
    }

    /// Cuts, swaps or restores the wires of the load's encoder, if there are two. A chip on a bus
    /// has one that is cut or not.
    pub fn rewire_load(&mut self, wires: Wires, board: &mut EmulatedBoard, at: VirtualNanos) {
        match &mut self.load {
            Some(LoadDisc::Edges(edges)) => edges.rewire(wires, board, at),
            Some(LoadDisc::Chip(_)) => As5047p::silence(&mut board.mcu, wires != Wires::Sound),
            None => {}
        }
    }

    /// Drives the levels of the wires. Must be called once a tick: the emulated microcontroller
    /// loses the levels in a reset, and a pin whose wire is cut follows the resistor that the
    /// firmware has set.
    pub fn show(&self, board: &mut EmulatedBoard, at: VirtualNanos) {
        self.first.show(board, at);
        self.show_index(board, at);
        match &self.load {
            Some(LoadDisc::Edges(edges)) => edges.show(board, at),
            Some(LoadDisc::Chip(counts)) => As5047p::turn(&mut board.mcu, *counts),
            None => {}
        }
    }

    /// Adds edges by noise on the wires of the first encoder, which are no motion of its disc.
    pub const fn add_noise(&mut self, counts: i64) {
        self.noise += counts;
    }

    /// Drives the line of the index.
    fn show_index(&self, board: &mut EmulatedBoard, at: VirtualNanos) {
        let Some(index) = &self.index else { return };
        let is_high = index.is_high(self.first.counts - self.noise);
        FIRST.drive(board, at, INDEX_LINE, Some(if is_high { Level::High } else { Level::Low }));
    }

    /// Returns what is wrong with the pins of an encoder, if the firmware has not connected them to
    /// its timer.
    pub fn unconnected(&self, board: &mut EmulatedBoard) -> Option<&'static str> {
        if !self.first.is_connected(board) {
            return Some("PA0 and PA1, where the encoder is, are not connected to TIM2");
        }
        if let Some(LoadDisc::Edges(load)) = self.load
            && !load.is_connected(board)
        {
            return Some("PB6 and PB7, where the load's encoder is, are not connected to TIM4");
        }
        None
    }
}

/// Encoder with two wires, by the edges on them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct EncoderEdges {
    input: EncoderInput,
    /// Edges since power-on: those up minus those down.
    counts: i64,
    wires: Wires,
}

impl EncoderEdges {
    fn at_zero(input: EncoderInput) -> Self {
        Self { input, counts: 0, wires: Wires::Sound }
    }

    fn step_towards(&mut self, target: i64, board: &mut EmulatedBoard, at: VirtualNanos) {
        let before = self.driven();
        self.counts += (target - self.counts).signum();
        let now = self.driven();
        for line in [0, 1] {
            if before[line] != now[line] {
                self.input.drive(board, at, line as u8, now[line]);
            }
        }
    }

    fn rewire(&mut self, wires: Wires, board: &mut EmulatedBoard, at: VirtualNanos) {
        self.wires = wires;
        self.show(board, at);
    }

    fn show(&self, board: &mut EmulatedBoard, at: VirtualNanos) {
        for (line, level) in [0, 1].into_iter().zip(self.driven()) {
            self.input.drive(board, at, line, level);
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

    fn is_connected(&self, board: &mut EmulatedBoard) -> bool {
        let EncoderInput { port, first_pin, function, .. } = self.input;
        [0, 1].into_iter().all(|line| board.function(port, first_pin + line) == Some(function))
    }
}

impl EncoderInput {
    /// Drives the pin of a line, or releases it, so that it follows its resistor. The emulated port
    /// and timer do not share their pins, so the level of the port is set at the timer as well.
    fn drive(&self, board: &mut EmulatedBoard, at: VirtualNanos, line: u8, level: Option<Level>) {
        let (Some(channel), Some(place)) =
            (Channel::new(line + 1), Pin::new(self.first_pin + line))
        else {
            return;
        };
        let level = board.mcu.drive_port(at, self.port as usize, |port, registers, context| {
            port.drive(place, level, registers, context);
            port.level(place, registers)
        });
        board.mcu.drive_timer(at, self.timer, |timer, registers, context| {
            timer.drive_input(channel, level, registers, context);
        });
    }
}

const fn levels(counts: i64) -> [Level; 2] {
    match counts.rem_euclid(4) {
        0 => [Level::Low, Level::Low],
        1 => [Level::High, Level::Low],
        2 => [Level::High, Level::High],
        _ => [Level::Low, Level::High],
    }
}
