//! Far end of the board's USART: bytes to the image and back, each with its time on the wire.
//!
//! The model of the port fetches a byte whenever its receiver is free, and at every stop of the
//! emulator. A byte that is sent while the board is halted is on the wire at the next stop.

use std::collections::VecDeque;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use rigless::chip::Timeline;
use rigless::chip::uart::Peer;
use rigless::store;
use rigless::time::VirtualNanos;

/// USART1, by its place in the emulator's table of ports.
pub(super) const USART1: usize = 0;

/// Far end of a wire. Clones are the same wire.
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
    /// Sends bytes to the board, behind those that are still unsent.
    pub fn send(&self, bytes: &[u8]) {
        self.lines().to_board.extend(bytes);
    }

    /// Returns the number of bytes that have not been sent to the board yet.
    pub fn unsent(&self) -> usize {
        self.lines().to_board.len()
    }

    /// Returns whether the bytes that wait to be received contain the end of a frame.
    pub fn has_frame(&self) -> bool {
        self.lines().from_board.contains(&0)
    }

    /// Returns the bytes that the board has sent since the last call.
    pub fn receive(&self) -> Vec<u8> {
        self.lines().from_board.drain(..).collect()
    }

    fn lines(&self) -> MutexGuard<'_, Lines> {
        // The two queues are valid even if a thread has panicked while it held the lock.
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
