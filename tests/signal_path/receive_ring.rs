//! The ring of the wire's bytes, held against a queue without an end: the file is the firmware's
//! own.

use std::collections::VecDeque;

use proptest::prelude::*;

use super::config;

#[path = "../../src/board/receive_ring.rs"]
mod of_the_board;

use of_the_board::{LENGTH, Reader, Writer};

/// A DMA that writes a ring round and round, and counts down.
struct Dma {
    ring: [u8; LENGTH],
    left: u16,
}

impl Dma {
    fn new() -> Self {
        Self { ring: [0; LENGTH], left: LENGTH as u16 }
    }

    fn write(&mut self, byte: u8) {
        self.ring[LENGTH - usize::from(self.left)] = byte;
        // RM0090: in circular mode the count is what it was at first as soon as it is zero.
        self.left = if self.left == 1 { LENGTH as u16 } else { self.left - 1 };
    }
}

proptest! {
    #![proptest_config(config())]

    /// Bursts (bytes), each followed by a look, and how much is read of them.
    #[test]
    fn what_is_read_is_what_was_written_wherever_the_end_of_the_ring_is(
        bursts in prop::collection::vec((0..LENGTH, 0..LENGTH), 1..40), first in any::<u8>()
    ) {
        let (mut dma, mut writer, mut reader) = (Dma::new(), Writer::default(), Reader::default());
        let (mut expected, mut byte, mut written) = (VecDeque::new(), first, 0);
        for (came, wanted) in bursts {
            // No more than there is room for, so that nothing is lost.
            for _ in 0..came.min(LENGTH - expected.len()) {
                dma.write(byte);
                expected.push_back(byte);
                byte = byte.wrapping_mul(5).wrapping_add(1);
            }
            written = writer.look(dma.left);
            prop_assert_eq!(reader.is_behind(written), !expected.is_empty());
            for _ in 0..wanted {
                let read = reader.next(written).map(|place| dma.ring[place]);
                prop_assert_eq!(read, expected.pop_front());
                if read.is_none() {
                    break;
                }
            }
        }
        while let Some(place) = reader.next(written) {
            prop_assert_eq!(Some(dma.ring[place]), expected.pop_front());
        }
        prop_assert!(expected.is_empty() && reader.lost() == 0);
    }

    /// A writer that goes around the reader: whatever it reads was written last at its place, and
    /// what was not read was counted.
    #[test]
    fn a_reader_that_is_overtaken_goes_on_with_newer_bytes_and_counts_the_others(
        halves in prop::collection::vec(1..=LENGTH / 2, 1..12), start in 0..LENGTH
    ) {
        let (mut dma, mut writer, mut reader) = (Dma::new(), Writer::default(), Reader::default());
        for i in 0..start {
            dma.write(i as u8);
        }
        let mut written = writer.look(dma.left);
        while reader.next(written).is_some() {}
        let mut all = vec![];
        for half in halves {
            for _ in 0..half {
                let byte = (all.len() * 7 % 251) as u8;
                dma.write(byte);
                all.push(byte);
            }
            // Each half of a lap interrupts.
            written = writer.look(dma.left);
        }
        let mut read = vec![];
        while let Some(place) = reader.next(written) {
            read.push(dma.ring[place]);
        }
        prop_assert_eq!(read.len() + reader.lost() as usize, all.len());
        prop_assert!(all.ends_with(&read));
        if all.len() <= LENGTH {
            prop_assert_eq!(reader.lost(), 0);
        } else {
            prop_assert_eq!(read.len(), LENGTH / 2);
        }
    }
}

#[test]
fn the_numbers_wrap_and_nothing_is_lost() {
    let (mut dma, mut writer, mut reader) = (Dma::new(), Writer::default(), Reader::default());
    // 2^32 bytes are 13 hours of the wire. 2^32 is a multiple of the ring's length, so that places
    // go on: a thousand laps stand for all, and the number is brought to its end by hand.
    let mut number = 0u32;
    for i in 0..1000 * LENGTH as u32 + 17 {
        dma.write(i as u8);
        let written = writer.look(dma.left);
        number = number.wrapping_add(1);
        assert_eq!(written, number);
        assert_eq!(reader.next(written).map(|place| dma.ring[place]), Some(i as u8));
        assert_eq!(reader.next(written), None);
    }
    let mut late = Reader::default();
    let end = u32::MAX - 3;
    // It has read none of them: the newer half is what it goes on with, up to the end.
    assert_eq!(late.next(end), Some(((end - LENGTH as u32 / 2) % LENGTH as u32) as usize));
    while late.next(end).is_some() {}
    let after = end.wrapping_add(10);
    assert_eq!((0..20).filter(|_| late.next(after).is_some()).count(), 10);
    assert_eq!(late.lost(), end - LENGTH as u32 / 2);
}
