//! The connection of one page: what it asks for, and what it is told.

use std::sync::Arc;
use std::sync::mpsc::{SyncSender, TrySendError};
use std::time::{Duration, Instant};

use axum::extract::ws::{Message, WebSocket};
use futures_util::stream::SplitStream;
use futures_util::{Sink, SinkExt, StreamExt};
use serde_json::json;
use tokio::sync::broadcast::error::RecvError;
use tokio::sync::{broadcast, mpsc};
use tokio::time::timeout;

use super::control::TAKEN;
use super::desk::{Order, Shared, answer};
use super::forecaster::Wishes;
use super::news::{News, Newsroom};
use super::refusals::Refusals;
use super::request::{Ask, Request, Tuning};
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
    /// Tells what is refused.
    pub refusals: Arc<Refusals>,
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
        () = tell(into, first, answered, news, &shared.news) => {}
    }
}

/// Takes what a page asks for, until it leaves or makes too many mistakes.
async fn listen(mut from: SplitStream<WebSocket>, page: &Page, answers: &mpsc::Sender<String>) {
    let mut mistakes = 0;
    let refuse = |why: &str| page.desk.refusals.tell(&format!("page {}: {why}", page.number));
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
                Taken::Tuning(id, tuning) => {
                    let answers = answers.clone();
                    page.desk.tuner.start(*tuning, move |done| {
                        // A page that is gone, or does not read, needs no answer.
                        let _ = answers.try_send(answer(id, &done));
                    });
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

/// Tells a page what there is, until it does not take it. A page that was too slow is told anew all
/// that stands: what was left out may have been an event that is told once.
async fn tell(
    mut into: impl Sink<Message> + Unpin,
    first: Vec<String>,
    mut answered: mpsc::Receiver<String>,
    mut news: broadcast::Receiver<News>,
    newsroom: &Newsroom,
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
                        first = newsroom.kept().into_iter();
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
    /// Something to be tuned.
    Tuning(u32, Box<Tuning>),
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
            let id = request.id;
            return match request.what {
                Ask::Tune(tuning) => Taken::Tuning(id, tuning),
                Ask::CancelTuning => Taken::Said(answer(id, &self.desk.tuner.cancel())),
                _ => Taken::Wish(request),
            };
        }
        let commands = shared.control.word(self.number);
        if commands {
            shared.gives_word();
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
        let (page, given, answer_to) = (self.number, Instant::now(), answers.clone());
        let order = Order { page, given, id, what, answer: answer_to };
        if order.what == Ask::Stop {
            self.desk.shared.stops(order);
            return None;
        }
        match self.desk.orders.try_send(order) {
            Ok(()) => None,
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

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use std::convert::Infallible;
    use std::sync::Mutex;

    use futures_util::sink::unfold;
    use serde_json::Value;

    use super::*;

    /// What a page is told that has read nothing while so many events were told behind the one that
    /// is told once.
    fn told_behind(events: u32) -> Vec<Value> {
        let newsroom = Newsroom::default();
        let (_, news) = newsroom.listen();
        newsroom.tell("tuned", json!({ "said": "better gains were found" }));
        (0..events).for_each(|clock| newsroom.tell("status", json!({ "clock": clock })));
        let told = Mutex::new(vec![]);
        let into = unfold((), |(), message: Message| {
            let Message::Text(text) = message else { unreachable!() };
            told.lock().unwrap().push(serde_json::from_str(&text).unwrap());
            async { Ok::<_, Infallible>(()) }
        });
        let (_answer, answered) = mpsc::channel(1);
        let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build().unwrap();
        runtime.block_on(async {
            let tells = tell(Box::pin(into), vec![], answered, news, &newsroom);
            // It waits for more as soon as all was told.
            let _ = timeout(Duration::from_millis(50), tells).await;
        });
        told.into_inner().unwrap()
    }

    #[test]
    fn a_page_that_was_too_slow_is_told_again_what_was_told_once() {
        let kinds = |told: &[Value]| -> Vec<String> {
            told.iter().map(|event| event["event"].as_str().unwrap().to_owned()).collect()
        };
        let fast = kinds(&told_behind(10));
        assert_eq!((fast[0].as_str(), fast.len()), ("tuned", 11), "{fast:?}");
        let all = told_behind(200);
        let slow = kinds(&all);
        assert_eq!(slow[..3], ["skipped", "status", "tuned"], "{slow:?}");
        assert_eq!(slow.iter().filter(|kind| *kind == "tuned").count(), 1);
        // What it is told in the end is what stands.
        assert_eq!((&all[1]["clock"], &all.last().unwrap()["clock"]), (&json!(199), &json!(199)));
    }
}
