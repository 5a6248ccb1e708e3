//! What the connections and the threads behind them share: orders with their answers, who commands,
//! the news, and what the device runs.

use std::sync::atomic::{AtomicBool, AtomicU32, AtomicU64};
use std::sync::{Mutex, PoisonError};
use std::time::Instant;

use serde_json::{Value, json};
use stiction::Parameters;

use super::control::Control;
use super::news::Newsroom;
use super::request::Ask;
use crate::error::Error;

/// What the thread and the connections share.
#[derive(Debug, Default)]
pub struct Shared {
    /// Who commands.
    pub control: Control,
    /// What all pages are told.
    pub news: Newsroom,
    /// How many words the page that commands has given.
    pub words: AtomicU64,
    /// Somebody wants the output off: this passes every order that waits.
    pub stop: AtomicBool,
    /// The number of the last `hello`.
    pub(super) generation: AtomicU32,
    /// What the device runs, as far as is known: for those who compute with it and ask nothing of
    /// the device.
    in_use: Mutex<Option<Parameters>>,
}

impl Shared {
    /// Says what the device runs.
    pub fn runs(&self, parameters: Option<Parameters>) {
        *self.in_use.lock().unwrap_or_else(PoisonError::into_inner) = parameters;
    }

    /// Returns what the device runs, as far as is known.
    pub fn in_use(&self) -> Option<Parameters> {
        self.in_use.lock().unwrap_or_else(PoisonError::into_inner).clone()
    }
}

/// An order of a page, and where its answer goes.
#[derive(Debug)]
pub struct Order {
    /// The page that gives it.
    pub page: u64,
    /// When it was given.
    pub given: Instant,
    /// The page's number for it.
    pub id: u32,
    /// What is asked for.
    pub what: Ask,
    /// Takes the answer.
    pub answer: tokio::sync::mpsc::Sender<String>,
}

impl Order {
    /// Answers. A page that is gone, or does not read, needs none.
    pub fn answered(&self, done: &Result<Value, Error>) {
        let _ = self.answer.try_send(answer(self.id, done));
    }
}

/// The answer to a request, for the page.
pub fn answer(id: u32, done: &Result<Value, Error>) -> String {
    let said = match done {
        Ok(said) => json!({ "event": "answer", "id": id, "ok": true, "said": said }),
        Err(error) => {
            json!({ "event": "answer", "id": id, "ok": false, "said": error.to_string() })
        }
    };
    said.to_string()
}
