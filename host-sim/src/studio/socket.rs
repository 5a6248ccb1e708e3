//! The connection of one page: what it asks for, and what it is told.

use std::sync::Arc;
use std::sync::atomic::Ordering;
use std::sync::mpsc::{SyncSender, TrySendError};
use std::time::{Duration, Instant};

use axum::extract::ws::{Message, WebSocket};
use futures_util::stream::{SplitSink, SplitStream};
use futures_util::{SinkExt, StreamExt};
use serde_json::json;
use tokio::sync::broadcast::error::RecvError;
use tokio::sync::{broadcast, mpsc};
use tokio::time::timeout;

use super::control::TAKEN;
use super::desk::{Order, Shared, answer};
use super::forecaster::Wishes;
use super::news::News;
use super::refusals::refusal;
use super::request::{Ask, Request};
use super::tuner::Tuner;
use crate::error::Error;

/// How many answers may wait for a page.
const ANSWERS: usize = 64;

/// After so many messages that are no request a page is not listened to any more.
const MISTAKES: u32 = 8;

/// Time that a page has to take a message. One that takes nothing for so long is let go.
const TO_TAKE: Duration = Duration::from_secs(10);

/// What a connection works with.
#[derive(Clone, Debug)]
pub struct Desk {
    /// Shared with the thread that talks to the device.
    pub shared: Arc<Shared>,
    /// Takes orders for that thread.
    pub orders: SyncSender<Order>,
    /// Takes wishes for the thread that predicts.
    pub wishes: Arc<Wishes>,
    /// Tunes.
    pub tuner: Arc<Tuner>,
}

/// A connection, which gives the command back when it ends, however that is.
struct Page {
    number: u64,
    desk: Desk,
}

impl Drop for Page {
    fn drop(&mut self) {
        self.desk.shared.control.leave(self.number);
    }
}

/// Serves a page until it leaves.
pub async fn serve(socket: WebSocket, number: u64, desk: Desk) {
    let page = Page { number, desk };
    let shared = page.desk.shared.clone();
    let (answers, answered) = mpsc::channel(ANSWERS);
    let (kept, news) = shared.news.listen();
    let mut first = vec![page.role(shared.control.ask(number))];
    first.extend(kept.iter().map(|event| event.as_ref().to_owned()));
    // What a page asks for is taken however slowly it reads: its stop does not wait for a plot.
    let (into, from) = socket.split();
    tokio::select! {
        () = listen(from, &page, &answers) => {}
        () = tell(into, first, answered, news) => {}
    }
}

/// Takes what a page asks for, until it leaves or makes too many mistakes.
async fn listen(mut from: SplitStream<WebSocket>, page: &Page, answers: &mpsc::Sender<String>) {
    let mut mistakes = 0;
    let refuse = |why: &str| refusal(&format!("page {}: {why}", page.number));
    while let Some(message) = from.next().await {
        let message = match message {
            Ok(message) => message,
            Err(error) => {
                let why = error.to_string();
                // A page that is gone without a word is not refused. A message that is too large
                // is.
                if !why.contains("Connection reset") {
                    refuse(&format!("the connection ends: {why}"));
                }
                return;
            }
        };
        let said = match message {
            Message::Text(text) => match page.take(&text) {
                Taken::Order(order) => page.order(order, answers),
                Taken::Wish(Request { id, what }) => {
                    page.desk.wishes.put(page.number, id, what, answers.clone());
                    None
                }
                Taken::Said(said) => Some(said),
                Taken::Nothing => None,
                Taken::Mistake(why) => {
                    mistakes += 1;
                    refuse(&format!("a message was refused: {why}"));
                    Some(answer(0, &Err(why)))
                }
            },
            Message::Ping(_) | Message::Pong(_) => None,
            // A page sends none.
            Message::Binary(_) => return refuse("the connection ends: a message was binary"),
            Message::Close(_) => return,
        };
        if mistakes > MISTAKES {
            return refuse("the connection ends: too many messages were no request");
        }
        // A page that has so many answers to read does not read.
        if said.is_some_and(|said| answers.try_send(said).is_err()) {
            return;
        }
    }
}

/// Tells a page what there is, until it does not take it.
async fn tell(
    mut into: SplitSink<WebSocket, Message>,
    first: Vec<String>,
    mut answered: mpsc::Receiver<String>,
    mut news: broadcast::Receiver<News>,
) {
    let mut first = first.into_iter();
    loop {
        let next = match first.next() {
            Some(text) => Message::Text(text.into()),
            None => tokio::select! {
                biased;
                Some(said) = answered.recv() => Message::Text(said.into()),
                told = news.recv() => match told {
                    Ok(News::Event(text)) => Message::Text(text.as_ref().into()),
                    Ok(News::Samples(frame)) => Message::Binary(frame),
                    Err(RecvError::Lagged(messages)) => {
                        let lost = json!({ "event": "skipped", "messages": messages });
                        Message::Text(lost.to_string().into())
                    }
                    Err(RecvError::Closed) => return,
                },
            },
        };
        if !matches!(timeout(TO_TAKE, into.send(next)).await, Ok(Ok(()))) {
            return;
        }
    }
}

/// What a message of a page comes to.
enum Taken {
    /// Something to be said at once.
    Said(String),
    /// Something for the thread that talks to the device.
    Order(Request),
    /// Something for the thread that predicts.
    Wish(Request),
    /// A word without an answer.
    Nothing,
    /// No request; this is why.
    Mistake(Error),
}

impl Page {
    fn role(&self, commands: bool) -> String {
        let why = if commands { "" } else { TAKEN };
        json!({ "event": "role", "commands": commands, "why": why }).to_string()
    }

    fn take(&self, text: &str) -> Taken {
        let shared = &self.desk.shared;
        let request: Request = match serde_json::from_str(text) {
            Ok(request) => request,
            Err(error) => {
                return Taken::Mistake(Error::Input(format!("this is no request: {error}")));
            }
        };
        if request.what == Ask::Command {
            return Taken::Said(self.role(shared.control.ask(self.number)));
        }
        // Not a word: what is predicted keeps nobody's link alive.
        if request.what.is_apart() {
            let Self { desk: Desk { tuner, .. }, .. } = self;
            return match &request.what {
                Ask::Tune(laws, goal) => Taken::Said(answer(request.id, &tuner.start(laws, *goal))),
                Ask::CancelTuning => Taken::Said(answer(request.id, &tuner.cancel())),
                _ => Taken::Wish(request),
            };
        }
        let commands = shared.control.word(self.number);
        if commands {
            shared.words.fetch_add(1, Ordering::Relaxed);
        }
        match request.what {
            Ask::Alive => Taken::Nothing,
            _ if commands || request.what.is_for_all() => Taken::Order(request),
            _ => Taken::Said(answer(request.id, &Err(Error::Refused(TAKEN.into())))),
        }
    }

    /// Gives an order. What has to be said at once is returned.
    fn order(&self, request: Request, answers: &mpsc::Sender<String>) -> Option<String> {
        let Request { id, what } = request;
        let is_stop = what == Ask::Stop;
        let (page, given, answer_to) = (self.number, Instant::now(), answers.clone());
        let sent = self.desk.orders.try_send(Order { page, given, id, what, answer: answer_to });
        // It passes what waits, and finds its own order behind it, which is answered.
        if is_stop {
            self.desk.shared.stop.store(true, Ordering::SeqCst);
        }
        match sent {
            Ok(()) => None,
            Err(TrySendError::Full(_)) if is_stop => None,
            Err(TrySendError::Full(_)) => {
                let why = "too many requests wait for the device; say it again";
                Some(answer(id, &Err(Error::Refused(why.into()))))
            }
            Err(TrySendError::Disconnected(_)) => {
                Some(answer(id, &Err(Error::Device("the studio ends".into()))))
            }
        }
    }
}
