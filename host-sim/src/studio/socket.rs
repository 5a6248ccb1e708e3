//! Connection of a page: its requests, and the messages to it.

use std::sync::Arc;
use std::sync::mpsc::{SyncSender, TrySendError};
use std::time::Duration;

use axum::extract::ws::{Message, WebSocket};
use futures_util::stream::SplitStream;
use futures_util::{Sink, SinkExt, StreamExt};
use serde_json::json;
use tokio::sync::broadcast::error::RecvError;
use tokio::sync::{broadcast, mpsc};
use tokio::time::timeout;

use super::control::TAKEN;
use super::desk::{QueuedRequest, StudioState, answer};
use super::forecaster::PredictionQueue;
use super::news::{Broadcaster, StudioMessage};
use super::refusals::Refusals;
use super::request::{StudioAction, StudioRequest, TuningRequest};
use super::tuner::Tuner;
use files::error::Error;

/// Largest number of answers that wait for a page.
const ANSWERS: usize = 64;

/// Number of invalid messages after which the connection of a page ends.
const MISTAKES: u32 = 8;

/// Time within which a page must accept a message; otherwise its connection ends.
const TO_TAKE: Duration = Duration::from_secs(10);

/// Handles that a connection uses.
#[derive(Clone, Debug)]
pub struct StudioHandles {
    /// State shared with the thread of the device.
    pub shared: Arc<StudioState>,
    /// Queue of requests for that thread.
    pub orders: SyncSender<QueuedRequest>,
    /// Queue of predictions.
    pub wishes: Arc<PredictionQueue>,
    /// Tuner of the gains.
    pub tuner: Arc<Tuner>,
    /// Reports of refusals.
    pub refusals: Arc<Refusals>,
}

/// A connection of a page. When it ends, the page no longer commands.
struct Page {
    number: u64,
    desk: StudioHandles,
}

impl Drop for Page {
    fn drop(&mut self) {
        self.desk.shared.control.leave(self.number);
    }
}

/// Serves a page until it leaves.
pub async fn serve(socket: WebSocket, number: u64, desk: StudioHandles) {
    let page = Page { number, desk };
    let shared = page.desk.shared.clone();
    let (answers, answered) = mpsc::channel(ANSWERS);
    let (kept, news) = shared.news.listen();
    let mut first = vec![page.role(shared.control.ask(number, shared.now()))];
    first.extend(kept.iter().map(|event| event.as_ref().to_owned()));
    // Requests are read even from a page that reads slowly: its stop must not wait for a plot.
    let (into, from) = socket.split();
    tokio::select! {
        () = listen(from, &page, &answers) => {}
        () = send_messages(into, first, answered, news, &shared.news) => {}
    }
}

/// Reads requests of a page until it leaves or sends too many invalid messages.
async fn listen(mut from: SplitStream<WebSocket>, page: &Page, answers: &mpsc::Sender<String>) {
    let mut mistakes = 0;
    let refuse = |why: &str| page.desk.refusals.report(&format!("page {}: {why}", page.number));
    while let Some(message) = from.next().await {
        let message = match message {
            Ok(message) => message,
            Err(error) => {
                let why = error.to_string();
                // A reset connection is a page that has gone, and so is one that accepts no more
                // bytes. Other errors, such as a message that is too large, are reported.
                if !why.contains("Connection reset") && !why.contains("Broken pipe") {
                    refuse(&format!("the connection ends: {why}"));
                }
                return;
            }
        };
        let said = match message {
            Message::Text(text) => match page.take(&text) {
                PageInput::Request(order) => page.order(order, answers),
                PageInput::Prediction(StudioRequest { id, what }) => {
                    page.desk.wishes.put(page.number, id, what, answers.clone());
                    None
                }
                PageInput::Tuning(id, tuning) => {
                    let answers = answers.clone();
                    page.desk.tuner.start(*tuning, move |done| {
                        // If the page is gone or does not read, the answer is dropped.
                        let _ = answers.try_send(answer(id, &done));
                    });
                    None
                }
                PageInput::Answered(said) => Some(said),
                PageInput::KeepAlive => None,
                PageInput::Invalid(why) => {
                    mistakes += 1;
                    refuse(&format!("a message was refused: {why}"));
                    Some(answer(0, &Err(why)))
                }
            },
            Message::Ping(_) | Message::Pong(_) => None,
            // A page sends no binary messages.
            Message::Binary(_) => return refuse("the connection ends: a message was binary"),
            Message::Close(_) => return,
        };
        if mistakes > MISTAKES {
            return refuse("the connection ends: too many messages were no request");
        }
        // A full queue of answers means that the page does not read.
        if said.is_some_and(|said| answers.try_send(said).is_err()) {
            return;
        }
    }
}

/// Sends messages to a page until the page no longer accepts them. A page that was too slow
/// receives the last event of each kind again, since an event among the lost messages may not be
/// published again.
async fn send_messages(
    mut into: impl Sink<Message> + Unpin,
    first: Vec<String>,
    mut answered: mpsc::Receiver<String>,
    mut news: broadcast::Receiver<StudioMessage>,
    broadcaster: &Broadcaster,
) {
    let mut first = first.into_iter();
    loop {
        let next = match first.next() {
            Some(text) => Message::Text(text.into()),
            None => tokio::select! {
                biased;
                Some(said) = answered.recv() => Message::Text(said.into()),
                message = news.recv() => match message {
                    Ok(StudioMessage::Event(text)) => Message::Text(text.as_ref().into()),
                    Ok(StudioMessage::Samples(frame)) => Message::Binary(frame),
                    Err(RecvError::Lagged(messages)) => {
                        let lost = json!({ "event": "skipped", "messages": messages });
                        first = broadcaster.kept().into_iter();
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

/// Result of a message from a page.
enum PageInput {
    /// An answer that is ready.
    Answered(String),
    /// A request for the thread of the device.
    Request(StudioRequest),
    /// A request for the thread of the predictions.
    Prediction(StudioRequest),
    /// A request for the tuner.
    Tuning(u32, Box<TuningRequest>),
    /// A keep-alive, which has no answer.
    KeepAlive,
    /// An invalid message, with the reason.
    Invalid(Error),
}

impl Page {
    fn role(&self, commands: bool) -> String {
        let why = if commands { "" } else { TAKEN };
        json!({ "event": "role", "commands": commands, "why": why }).to_string()
    }

    fn take(&self, text: &str) -> PageInput {
        let shared = &self.desk.shared;
        let request: StudioRequest = match serde_json::from_str(text) {
            Ok(request) => request,
            Err(error) => {
                return PageInput::Invalid(Error::Input(format!("this is no request: {error}")));
            }
        };
        if request.what == StudioAction::Command {
            return PageInput::Answered(self.role(shared.control.ask(self.number, shared.now())));
        }
        // A prediction is no keep-alive of the device.
        if request.what.is_apart() {
            let id = request.id;
            return match request.what {
                StudioAction::Tune(tuning) => PageInput::Tuning(id, tuning),
                StudioAction::CancelTuning => {
                    PageInput::Answered(answer(id, &self.desk.tuner.cancel()))
                }
                _ => PageInput::Prediction(request),
            };
        }
        let commands = shared.control.record_keep_alive(self.number, shared.now());
        if commands {
            shared.record_keep_alive();
        }
        match request.what {
            StudioAction::Alive => PageInput::KeepAlive,
            _ if commands || request.what.is_for_all() => PageInput::Request(request),
            _ => PageInput::Answered(answer(request.id, &Err(Error::Refused(TAKEN.into())))),
        }
    }

    /// Queues a request for the device. If it cannot be queued, returns its answer.
    fn order(&self, request: StudioRequest, answers: &mpsc::Sender<String>) -> Option<String> {
        let StudioRequest { id, what } = request;
        let (page, given, answer_to) = (self.number, self.desk.shared.now(), answers.clone());
        let order = QueuedRequest { page, given, id, what, answer: answer_to };
        if order.what == StudioAction::Stop {
            self.desk.shared.queue_stop(order);
            return None;
        }
        match self.desk.orders.try_send(order) {
            Ok(()) => None,
            Err(TrySendError::Full(_)) => {
                let why = "too many requests wait for the device; send it again";
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

    /// Returns the messages that a page receives if it reads none until an event `tuned` and then a
    /// number of events `status` are published.
    fn received_behind(events: u32) -> Vec<Value> {
        let broadcaster = Broadcaster::default();
        let (_, news) = broadcaster.listen();
        broadcaster.publish("tuned", json!({ "said": "better gains were found" }));
        (0..events).for_each(|clock| broadcaster.publish("status", json!({ "clock": clock })));
        let received = Mutex::new(vec![]);
        let into = unfold((), |(), message: Message| {
            let Message::Text(text) = message else { unreachable!() };
            received.lock().unwrap().push(serde_json::from_str(&text).unwrap());
            async { Ok::<_, Infallible>(()) }
        });
        let (_answer, answered) = mpsc::channel(1);
        let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build().unwrap();
        runtime.block_on(async {
            let sends = send_messages(Box::pin(into), vec![], answered, news, &broadcaster);
            // Once all is sent, the sender waits for more. An event needs at most one turn.
            let turns = async {
                for _ in 0..2 * events {
                    tokio::task::yield_now().await;
                }
            };
            tokio::select! { biased; () = sends => {}, () = turns => {} }
        });
        received.into_inner().unwrap()
    }

    #[test]
    fn a_page_that_was_too_slow_receives_an_event_again_that_was_published_once() {
        let kinds = |received: &[Value]| -> Vec<String> {
            received.iter().map(|event| event["event"].as_str().unwrap().to_owned()).collect()
        };
        let fast = kinds(&received_behind(10));
        assert_eq!((fast[0].as_str(), fast.len()), ("tuned", 11), "{fast:?}");
        let all = received_behind(200);
        let slow = kinds(&all);
        assert_eq!(slow[..3], ["skipped", "status", "tuned"], "{slow:?}");
        assert_eq!(slow.iter().filter(|kind| *kind == "tuned").count(), 1);
        // The last message is the present state.
        assert_eq!((&all[1]["clock"], &all.last().unwrap()["clock"]), (&json!(199), &json!(199)));
    }
}
