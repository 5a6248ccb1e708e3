//! The far end of the board's USART: bytes to the image and back, each taking its time on the wire.
//!
//! The model of the port asks for a byte whenever its receiver is free, and at every stop of the
//! emulator. A byte that is put here while the part stands still is on the wire at the next stop.

use std::collections::VecDeque;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use rigless::chip::Timeline;
use rigless::chip::uart::Peer;
use rigless::store;
use rigless::time::VirtualNanos;

/// USART1, by its place in the part's table of ports.
pub(super) const USART1: usize = 0;

/// A wire that is held at its far end. Clones are the same wire.
#[derive(Clone, Debug, Default)]
pub struct Uart {
    lines: Arc<Mutex<Lines>>,
}

#[derive(Debug, Default)]
struct Lines {
    to_board: VecDeque<u8>,
    from_board: VecDeque<u8>,
}

store!(Uart { values: [], parts: [], built: [lines] });

impl Uart {
    /// Puts bytes on the wire, behind those that are there.
    pub fn send(&self, bytes: &[u8]) {
        self.lines().to_board.extend(bytes);
    }

    /// Bytes that have not gone to the board yet.
    pub fn unsent(&self) -> usize {
        self.lines().to_board.len()
    }

    /// Whether there is the end of a frame in what the board has sent since it was last asked.
    pub fn has_frame(&self) -> bool {
        self.lines().from_board.contains(&0)
    }

    /// What the board has sent since this was last asked.
    pub fn receive(&self) -> Vec<u8> {
        self.lines().from_board.drain(..).collect()
    }

    fn lines(&self) -> MutexGuard<'_, Lines> {
        // Two queues of bytes are whole whatever has happened to the one that held them.
        self.lines.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Peer for Uart {
    fn receive(&mut self, word: u16, _: &mut Timeline<'_, '_>) {
        self.lines().from_board.push_back(word as u8);
    }

    fn transmit(&mut self, _: VirtualNanos) -> Option<u16> {
        self.lines().to_board.pop_front().map(u16::from)
    }
}
