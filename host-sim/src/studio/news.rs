//! Messages to all pages: events as JSON texts, samples as binary frames.
//!
//! A frame has four numbers and then a row for each sample, all of 32 bits, little endian:
//!
//! ```text
//! generation, columns, rows, 0 | number, clock, value 1 ... value n | ...
//! ```
//!
//! `number` counts every sample that the device had to send, so a gap is the number of samples lost
//! on the way. `clock` counts ticks since power-on. The values are those of the signals that the
//! event `hello` of this generation lists, in its order; each is read by its form. The last event
//! of each kind is kept for pages that connect later.

use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, PoisonError};

use bytes::Bytes;
use serde_json::Value;
use stiction::link::Sample;
use tokio::sync::broadcast;

/// Largest number of messages that a page may lag behind: two seconds of frames.
const BEHIND: usize = 64;

/// Largest number of samples in a frame: a tenth of a second of the fastest loop.
const ROWS: usize = 1024;

/// A message for every page.
#[derive(Clone, Debug)]
pub enum StudioMessage {
    /// A JSON object with the key `event`.
    Event(Arc<str>),
    /// A frame of samples.
    Samples(Bytes),
}

/// Sender of messages to all pages. It never waits for a page.
#[derive(Clone, Debug)]
pub struct Broadcaster {
    ring: broadcast::Sender<StudioMessage>,
    kept: Arc<Mutex<BTreeMap<&'static str, Arc<str>>>>,
}

impl Default for Broadcaster {
    fn default() -> Self {
        Self { ring: broadcast::Sender::new(BEHIND), kept: Arc::default() }
    }
}

impl Broadcaster {
    /// Publishes an event, and keeps it for later pages. Adds `"event": kind`.
    pub fn publish(&self, kind: &'static str, mut event: Value) {
        if let Value::Object(map) = &mut event {
            map.insert("event".into(), kind.into());
        }
        let text: Arc<str> = event.to_string().into();
        let mut kept = self.kept.lock().unwrap_or_else(PoisonError::into_inner);
        kept.insert(kind, text.clone());
        // Without a page, sending fails.
        let _ = self.ring.send(StudioMessage::Event(text));
    }

    /// Drops a kept event. The pages receive no message about this.
    pub fn forget(&self, kind: &'static str) {
        self.kept.lock().unwrap_or_else(PoisonError::into_inner).remove(kind);
    }

    /// Sends a frame.
    fn send(&self, frame: Bytes) {
        let _ = self.ring.send(StudioMessage::Samples(frame));
    }

    /// Returns the kept events, and a receiver of later messages.
    pub fn listen(&self) -> (Vec<Arc<str>>, broadcast::Receiver<StudioMessage>) {
        // An event between the two is received twice, which does no harm.
        let receiver = self.ring.subscribe();
        let kept = self.kept.lock().unwrap_or_else(PoisonError::into_inner);
        (kept.values().cloned().collect(), receiver)
    }

    /// Returns the last event of each kind, for a page that has missed some.
    #[cfg(feature = "studio")]
    pub fn kept(&self) -> Vec<String> {
        let kept = self.kept.lock().unwrap_or_else(PoisonError::into_inner);
        kept.values().map(|event| event.as_ref().to_owned()).collect()
    }
}

/// Frame of samples that is being filled.
#[derive(Debug, Default)]
pub struct SampleFrame {
    /// Generation of the `hello` that names the columns.
    pub generation: u32,
    /// Places of the signals, in ascending order.
    pub places: Vec<usize>,
    rows: usize,
    bytes: Vec<u8>,
}

impl SampleFrame {
    /// Adds a sample, and sends the frame if it is full.
    pub fn push(&mut self, sample: &Sample, to: &Broadcaster) {
        let values = self.places.iter().map(|place| sample.value(*place).unwrap_or(0));
        for word in [sample.number, sample.clock].into_iter().chain(values) {
            self.bytes.extend_from_slice(&word.to_le_bytes());
        }
        self.rows += 1;
        if self.rows >= ROWS {
            self.flush(to);
        }
    }

    /// Sends the frame unless it is empty.
    pub fn flush(&mut self, to: &Broadcaster) {
        if self.rows == 0 {
            return;
        }
        let head = [self.generation, self.places.len() as u32, self.rows as u32, 0];
        let head = head.into_iter().flat_map(u32::to_le_bytes);
        to.send(head.chain(std::mem::take(&mut self.bytes)).collect());
        self.rows = 0;
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used, clippy::panic)]
mod tests {
    use super::*;

    fn sample(number: u32) -> Sample {
        let values = [1, 0, 0, 0, 254, 255, 255, 255].into_iter().collect();
        Sample { number, clock: 100 + number, signals: 1 << 2 | 1 << 5, values }
    }

    #[test]
    fn a_frame_has_number_clock_and_values_of_every_sample() {
        let broadcaster = Broadcaster::default();
        let (_, mut receiver) = broadcaster.listen();
        let mut frame = SampleFrame { generation: 3, places: vec![2, 5], ..SampleFrame::default() };
        frame.flush(&broadcaster);
        frame.push(&sample(8), &broadcaster);
        frame.push(&sample(9), &broadcaster);
        frame.flush(&broadcaster);
        let StudioMessage::Samples(bytes) = receiver.try_recv().unwrap() else { panic!() };
        let words: Vec<u32> = bytes.as_chunks().0.iter().map(|w| u32::from_le_bytes(*w)).collect();
        assert_eq!(words[..4], [3, 2, 2, 0]);
        assert_eq!(words[4..8], [8, 108, 1, -2i32 as u32]);
        assert_eq!(words[8..], [9, 109, 1, -2i32 as u32]);
        assert!(receiver.try_recv().is_err(), "an empty frame was sent");
    }

    #[test]
    fn a_reader_that_sleeps_loses_frames_and_does_not_delay_the_sender() {
        let broadcaster = Broadcaster::default();
        let (_, mut receiver) = broadcaster.listen();
        let mut frame = SampleFrame { generation: 1, places: vec![2], ..SampleFrame::default() };
        for number in 0..10 * BEHIND as u32 {
            frame.push(&sample(number), &broadcaster);
            frame.flush(&broadcaster);
        }
        let lost = receiver.try_recv();
        let Err(broadcast::error::TryRecvError::Lagged(lost)) = lost else { panic!("{lost:?}") };
        assert_eq!(lost, 9 * BEHIND as u64);
    }

    #[test]
    fn a_page_that_connects_later_receives_the_last_event_of_each_kind() {
        let broadcaster = Broadcaster::default();
        for state in ["stopped", "armed"] {
            broadcaster.publish("status", serde_json::json!({ "state": state }));
        }
        broadcaster.publish("gone", serde_json::json!({}));
        broadcaster.forget("gone");
        let (kept, _) = broadcaster.listen();
        assert_eq!(kept.len(), 1);
        assert!(kept[0].contains("armed") && kept[0].contains(r#""event":"status""#));
    }
}
