//! The ring of the bytes received over the wire. Nothing here accesses a register, so that a test
//! on a host covers it.
//!
//! The DMA writes the ring round and round, and counts down the bytes that are left of a lap
//! (RM0090: NDTR).
//!
//! ```text
//! place of the next byte      = (LENGTH - left) mod LENGTH
//! bytes since the last look   = (place now - place then) mod LENGTH
//! ```
//!
//! This holds as long as fewer than [`LENGTH`] bytes come between two looks. For that, the DMA
//! interrupts at each half of a lap. The reader may be any number of bytes behind: bytes that the
//! writer overwrites before they are read are lost, and counted. Does badly: while the processor
//! stands still for longer than a lap takes (5.5 ms), nothing is read, and whole laps are not
//! counted. The bytes read then are a mixture, which the checksum of a frame detects.

/// Size of the ring, bytes: two of the longest frames, and 5.5 ms of the wire. It is a power of
/// two, so that the number of written bytes can wrap.
pub const LENGTH: usize = 512;

const MASK: u32 = LENGTH as u32 - 1;

const _: () = assert!(LENGTH.is_power_of_two());

/// The writer's end of the ring.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Writer {
    written: u32,
}

/// The reader's end of the ring.
#[derive(Clone, Copy, Debug, Default)]
pub struct Reader {
    read: u32,
    lost: u32,
}

impl Writer {
    /// Updates the place of the DMA, given the bytes that are left of the lap, and returns the
    /// number of bytes written since the start. The number wraps.
    #[inline]
    pub const fn look(&mut self, left: u16) -> u32 {
        let place = (LENGTH as u32).wrapping_sub(left as u32);
        let came = place.wrapping_sub(self.written) & MASK;
        self.written = self.written.wrapping_add(came);
        self.written
    }
}

impl Reader {
    /// Returns the place of the next byte in the ring, given the number of bytes written; none if
    /// all of them have been read. A reader that the writer has overtaken continues with the newer
    /// half of the ring: the older one is about to be overwritten.
    #[inline]
    pub const fn next(&mut self, written: u32) -> Option<usize> {
        let unread = written.wrapping_sub(self.read);
        if unread == 0 {
            return None;
        }
        if unread > LENGTH as u32 {
            let lost = unread - LENGTH as u32 / 2;
            self.read = self.read.wrapping_add(lost);
            self.lost = self.lost.saturating_add(lost);
        }
        let place = self.read & MASK;
        self.read = self.read.wrapping_add(1);
        Some(place as usize)
    }

    /// Returns whether there is something to read.
    #[inline]
    pub const fn is_behind(&self, written: u32) -> bool {
        written != self.read
    }

    /// Returns the number of bytes that were lost because the writer had overtaken the reader.
    pub const fn lost(&self) -> u32 {
        self.lost
    }
}
