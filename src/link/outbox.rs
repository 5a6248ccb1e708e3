//! The outbox of a session: bytes of frames that wait for the wire.

use heapless::Deque;

use super::frame::{Frame, MAX_FRAME};

/// Bytes of an outbox that are reserved for answers: two of the longest frames.
pub(super) const FOR_ANSWERS: usize = 2 * MAX_FRAME;

/// A ring of bytes that wait for the wire.
#[derive(Debug)]
pub(super) struct Outbox<const RING: usize> {
    waiting: Deque<u8, RING>,
    dropped: u32,
}

impl<const RING: usize> Outbox<RING> {
    /// Makes an empty outbox.
    pub const fn new() -> Self {
        const { assert!(RING > FOR_ANSWERS, "no sample would ever find room") }
        Self { waiting: Deque::new(), dropped: 0 }
    }

    /// Queues a frame if that leaves room for `leave` bytes; otherwise drops and counts it.
    #[inline(never)]
    pub fn put(&mut self, frame: Option<&Frame>, leave: usize) {
        let room = self.waiting.capacity() - self.waiting.len();
        match frame.filter(|frame| frame.len() + leave <= room) {
            // Cannot fail: there is room.
            Some(frame) => frame.iter().for_each(|&byte| {
                let _ = self.waiting.push_back(byte);
            }),
            None => self.dropped = self.dropped.saturating_add(1),
        }
    }

    /// Moves waiting bytes to `bytes`, for the wire, and returns their number.
    pub fn take(&mut self, bytes: &mut [u8]) -> usize {
        let mut count = 0;
        for (to, from) in bytes.iter_mut().zip(core::iter::from_fn(|| self.waiting.pop_front())) {
            *to = from;
            count += 1;
        }
        count
    }

    /// Returns the number of frames that found no room.
    pub const fn dropped(&self) -> u32 {
        self.dropped
    }
}
