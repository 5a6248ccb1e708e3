//! What all pages are told: events as JSON texts, samples as binary frames.
//!
//! A frame is four numbers and then a row for each sample, all of 32 bits, little endian:
//!
//! ```text
//! generation, columns, rows, 0 | number, clock, value 1 ... value n | ...
//! ```
//!
//! `number` counts every sample that was due on the device, so a gap says how many were lost on the
//! way, wherever that was. `clock` counts ticks since power-on. The values are those of the signals
//! that the event `hello` of this generation names, in its order; each is read by its form. The
//! last event of each kind is kept, for a page that comes later.

use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, PoisonError};

use bytes::Bytes;
use serde_json::Value;
use stiction::link::Sample;
use tokio::sync::broadcast;

/// How many messages a page may fall behind: two seconds of frames.
const BEHIND: usize = 64;

/// The largest number of samples of a frame: a tenth of a second of the fastest loop.
const ROWS: usize = 1024;

/// A message for every page.
#[derive(Clone, Debug)]
pub enum News {
    /// A JSON object with the key `event`.
    Event(Arc<str>),
    /// A frame of samples.
    Samples(Bytes),
}

/// Hands news to all pages, and never waits for one.
#[derive(Clone, Debug)]
pub struct Newsroom {
    ring: broadcast::Sender<News>,
    kept: Arc<Mutex<BTreeMap<&'static str, Arc<str>>>>,
}

impl Default for Newsroom {
    fn default() -> Self {
        Self { ring: broadcast::Sender::new(BEHIND), kept: Arc::default() }
    }
}

impl Newsroom {
    /// Tells an event, and keeps it for pages that come later. `"event": kind` is added to it.
    pub fn tell(&self, kind: &'static str, mut event: Value) {
        if let Value::Object(map) = &mut event {
            map.insert("event".into(), kind.into());
        }
        let text: Arc<str> = event.to_string().into();
        let mut kept = self.kept.lock().unwrap_or_else(PoisonError::into_inner);
        kept.insert(kind, text.clone());
        // Nobody listens: then nobody has to be told.
        let _ = self.ring.send(News::Event(text));
    }

    /// Forgets an event that is over, and says so to nobody.
    pub fn forget(&self, kind: &'static str) {
        self.kept.lock().unwrap_or_else(PoisonError::into_inner).remove(kind);
    }

    /// Sends a frame.
    fn send(&self, frame: Bytes) {
        let _ = self.ring.send(News::Samples(frame));
    }

    /// What was told so far, and what will be told.
    pub fn listen(&self) -> (Vec<Arc<str>>, broadcast::Receiver<News>) {
        // An event that comes between the two would be told twice, and does no harm.
        let receiver = self.ring.subscribe();
        let kept = self.kept.lock().unwrap_or_else(PoisonError::into_inner);
        (kept.values().cloned().collect(), receiver)
    }

    /// The last event of each kind, for a page that has missed some.
    #[cfg(feature = "studio")]
    pub fn kept(&self) -> Vec<String> {
        let kept = self.kept.lock().unwrap_or_else(PoisonError::into_inner);
        kept.values().map(|event| event.as_ref().to_owned()).collect()
    }
}

/// Samples on their way into a frame.
#[derive(Debug, Default)]
pub struct Frame {
    /// Which `hello` names the columns.
    pub generation: u32,
    /// The places of the signals, in ascending order.
    pub places: Vec<usize>,
    rows: usize,
    bytes: Vec<u8>,
}

impl Frame {
    /// Adds a sample, and sends the frame if it is full.
    pub fn push(&mut self, sample: &Sample, to: &Newsroom) {
        let values = self.places.iter().map(|place| sample.value(*place).unwrap_or(0));
        for word in [sample.number, sample.clock].into_iter().chain(values) {
            self.bytes.extend_from_slice(&word.to_le_bytes());
        }
        self.rows += 1;
        if self.rows >= ROWS {
            self.flush(to);
        }
    }

    /// Sends what there is, if there is anything.
    pub fn flush(&mut self, to: &Newsroom) {
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
        let newsroom = Newsroom::default();
        let (_, mut receiver) = newsroom.listen();
        let mut frame = Frame { generation: 3, places: vec![2, 5], ..Frame::default() };
        frame.flush(&newsroom);
        frame.push(&sample(8), &newsroom);
        frame.push(&sample(9), &newsroom);
        frame.flush(&newsroom);
        let News::Samples(bytes) = receiver.try_recv().unwrap() else { panic!() };
        let words: Vec<u32> = bytes.as_chunks().0.iter().map(|w| u32::from_le_bytes(*w)).collect();
        assert_eq!(words[..4], [3, 2, 2, 0]);
        assert_eq!(words[4..8], [8, 108, 1, -2i32 as u32]);
        assert_eq!(words[8..], [9, 109, 1, -2i32 as u32]);
        assert!(receiver.try_recv().is_err(), "an empty frame was sent");
    }

    #[test]
    fn a_reader_that_sleeps_loses_frames_and_delays_nobody() {
        let newsroom = Newsroom::default();
        let (_, mut receiver) = newsroom.listen();
        let mut frame = Frame { generation: 1, places: vec![2], ..Frame::default() };
        for number in 0..10 * BEHIND as u32 {
            frame.push(&sample(number), &newsroom);
            frame.flush(&newsroom);
        }
        let lost = receiver.try_recv();
        let Err(broadcast::error::TryRecvError::Lagged(lost)) = lost else { panic!("{lost:?}") };
        assert_eq!(lost, 9 * BEHIND as u64);
    }

    #[test]
    fn a_page_that_comes_later_is_told_the_last_event_of_each_kind() {
        let newsroom = Newsroom::default();
        for state in ["stopped", "armed"] {
            newsroom.tell("status", serde_json::json!({ "state": state }));
        }
        newsroom.tell("gone", serde_json::json!({}));
        newsroom.forget("gone");
        let (kept, _) = newsroom.listen();
        assert_eq!(kept.len(), 1);
        assert!(kept[0].contains("armed") && kept[0].contains(r#""event":"status""#));
    }
}
