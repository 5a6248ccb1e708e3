//! A page for the tests: it speaks to the server as the real one does.

use std::collections::VecDeque;
use std::net::SocketAddr;
use std::ops::Deref;
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

use futures_util::{SinkExt, StreamExt};
use host_sim::studio::{Server, StudioOptions};
use serde_json::{Value, json};
use simulator::device::clock::Clock;
use simulator::device::simulated::SimulatedDevice;
use simulator::device::wire::{SimulatedWire, Wire};
use simulator::experiment::{Document, Experiment};
use tokio::net::TcpStream;
use tokio::time::timeout;
use tokio_tungstenite::WebSocketStream;
use tokio_tungstenite::tungstenite::{Error, Message};

use super::clock::{TestClock, breath};

/// Real time after which a test hangs. Nothing else depends on it.
pub const PATIENCE: Duration = Duration::from_secs(300);

/// A studio on a clock that goes on while its pages wait.
pub struct Studio {
    server: Server,
    pub clock: Arc<TestClock>,
}

impl Deref for Studio {
    type Target = Server;

    fn deref(&self) -> &Server {
        &self.server
    }
}

/// As in link.ts.
const WITHOUT_A_WORD: [&str; 9] =
    ["answer", "gone", "identified", "predicted", "role", "selftest", "tuned", "tuning", "what-if"];

/// The joint of a machine, with keys of its file set.
fn device_of(machine: &str, law: &str, set: &[&str]) -> SimulatedDevice {
    let mut document = Document::open(machine).unwrap();
    document.set(&set.iter().map(|text| (*text).to_owned()).collect::<Vec<_>>()).unwrap();
    let plan = Experiment::plan(&document, &[law.into()], &[]).unwrap().into_first().unwrap();
    SimulatedDevice::new(&plan).unwrap()
}

/// The thesis's joint, with keys of its file set.
pub fn device(set: &[&str]) -> SimulatedDevice {
    device_of("step-response", "srnf", set)
}

fn wanted(machine: &str, is_its_file: bool) -> StudioOptions {
    let listen = "127.0.0.1:0".parse().unwrap();
    StudioOptions { listen, machine: machine.into(), is_its_file, every_tick: true }
}

/// A studio around the device of a wire, with the file of its joint or without one.
pub fn studio_of<W: Wire>(
    clock: &Arc<TestClock>,
    machine: &str,
    is_its_file: bool,
    open: impl Fn() -> Result<W, files::Error> + Send + 'static,
) -> Studio {
    started(clock, wanted(machine, is_its_file), |_| {}, open)
}

/// The same, with the file of its joint, and with a wire that limits the rate of the samples.
pub fn studio_on_a_slow_wire<W: Wire>(
    clock: &Arc<TestClock>,
    machine: &str,
    open: impl Fn() -> Result<W, files::Error> + Send + 'static,
) -> Studio {
    let wanted = StudioOptions { every_tick: false, ..wanted(machine, true) };
    started(clock, wanted, |_| {}, open)
}

fn started<W: Wire>(
    clock: &Arc<TestClock>,
    wanted: StudioOptions,
    report: impl Fn(&str) + Send + Sync + 'static,
    open: impl Fn() -> Result<W, files::Error> + Send + 'static,
) -> Studio {
    let start = || Server::start_on(clock.clone(), wanted, report, open).unwrap();
    Studio { server: clock.freely(start), clock: clock.clone() }
}

/// A studio around the thesis's joint, without a file of it.
pub fn studio_without_a_file() -> Studio {
    let clock = Arc::<TestClock>::default();
    let of_wire = clock.clone();
    let open = move || Ok(SimulatedWire::on_clock(device(&[]), of_wire.clone()));
    studio_of(&clock, "step-response", false, open)
}

/// A studio around a simulated machine.
pub fn studio_around(machine: &'static str, law: &'static str, set: &[&str]) -> Studio {
    let set: Vec<String> = set.iter().map(|text| (*text).to_owned()).collect();
    let clock = Arc::<TestClock>::default();
    let of_wire = clock.clone();
    studio_of(&clock, machine, true, move || {
        let set: Vec<&str> = set.iter().map(String::as_str).collect();
        Ok(SimulatedWire::on_clock(device_of(machine, law, &set), of_wire.clone()))
    })
}

/// A studio around the thesis's joint.
pub fn studio(set: &[&str]) -> Studio {
    studio_around("step-response", "srnf", set)
}

/// A studio around the thesis's joint, and its reports of refusals.
pub fn studio_with_reports() -> (Studio, Arc<Mutex<Vec<String>>>) {
    let reports = Arc::<Mutex<Vec<String>>>::default();
    let all = reports.clone();
    let report = move |what: &str| all.lock().unwrap().push(what.to_owned());
    let clock = Arc::<TestClock>::default();
    let of_wire = clock.clone();
    let open = move || Ok(SimulatedWire::on_clock(device(&[]), of_wire.clone()));
    (started(&clock, wanted("step-response", true), report, open), reports)
}

/// Runs a test.
pub fn run(test: impl Future<Output = ()>) {
    let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build().unwrap();
    runtime.block_on(test);
}

/// Request of a connection to the server.
pub struct Visit<'a> {
    pub address: SocketAddr,
    pub token: &'a str,
    pub clock: &'a Arc<TestClock>,
    pub origin: Option<String>,
    pub host: String,
}

impl<'a> Visit<'a> {
    /// As the page does.
    pub fn proper(server: &'a Studio) -> Self {
        let host = server.address().to_string();
        let origin = Some(format!("http://{host}"));
        let (address, token) = (server.address(), server.token().text());
        Self { address, token, clock: &server.clock, origin, host }
    }

    pub async fn connect(self) -> Result<Page, Error> {
        let stream = TcpStream::connect(self.address).await.unwrap();
        let mut request = axum::http::Request::builder()
            .uri(format!("ws://{}/link?token={}", self.host, self.token))
            .header("host", &self.host)
            .header("connection", "Upgrade")
            .header("upgrade", "websocket")
            .header("sec-websocket-version", "13")
            .header("sec-websocket-key", "dGhlIHNhbXBsZSBub25jZQ==");
        if let Some(origin) = &self.origin {
            request = request.header("origin", origin);
        }
        let connected = tokio_tungstenite::client_async(request.body(()).unwrap(), stream).await?;
        let (socket, rows) = (connected.0, Vec::new());
        let (role, form, motion) = (Value::Null, Value::Null, Value::Null);
        Ok(Page {
            socket,
            clock: self.clock.clone(),
            lives: true,
            rows,
            columns: vec![],
            role,
            form,
            motion,
            number: 0,
            pings: 0,
            arrived: VecDeque::new(),
        })
    }
}

/// A sample: its number, its tick, and the bits of its values.
#[derive(Clone, Debug, PartialEq)]
pub struct Row {
    pub number: u32,
    pub clock: u32,
    pub values: Vec<u32>,
}

/// A connected page.
pub struct Page {
    pub socket: WebSocketStream<TcpStream>,
    pub clock: Arc<TestClock>,
    /// Whether it gives a word for what comes.
    pub lives: bool,
    /// The samples that have come.
    pub rows: Vec<Row>,
    pub columns: Vec<String>,
    pub role: Value,
    /// The last form of the parameters.
    form: Value,
    /// The last move. Its event may come before the answer to the request.
    motion: Value,
    number: u32,
    pings: u32,
    /// Messages that came while it hung.
    arrived: VecDeque<Message>,
}

/// What a page gets next.
enum Coming {
    Message(Message),
    /// The connection has ended.
    End,
    /// Nothing, before the time was over.
    Nothing,
}

impl Page {
    pub async fn open(server: &Studio) -> Self {
        let mut page = Visit::proper(server).connect().await.unwrap();
        page.role = page.event("role").await;
        page.event("status").await;
        page
    }

    pub async fn send(&mut self, what: &Value) {
        self.socket.send(Message::Text(what.to_string().into())).await.unwrap();
    }

    /// Pings the server, and returns the first message that comes before its answer, which it sends
    /// when it has handled all that the page has sent.
    async fn ping(&mut self) -> Coming {
        self.pings += 1;
        let own = self.pings.to_le_bytes();
        // The connection may have ended, and what has come before that is read still.
        let _ = self.socket.send(Message::Ping(own.to_vec().into())).await;
        loop {
            match timeout(PATIENCE, self.socket.next()).await.expect("nothing comes") {
                Some(Ok(Message::Pong(answer))) if answer[..] == own => return Coming::Nothing,
                Some(Ok(Message::Pong(_))) => {}
                Some(Ok(Message::Close(_)) | Err(_)) | None => return Coming::End,
                Some(Ok(message)) => return Coming::Message(message),
            }
        }
    }

    /// The next message. The clock goes on when the server has nothing more to send.
    async fn message(&mut self, end: Option<Duration>) -> Coming {
        if let Some(message) = self.arrived.pop_front() {
            return Coming::Message(message);
        }
        let begin = Instant::now();
        loop {
            let is_idle = self.clock.is_idle();
            match self.ping().await {
                Coming::Nothing => {}
                coming => return coming,
            }
            if end.is_some_and(|end| self.clock.now() >= end) {
                return Coming::Nothing;
            }
            assert!(begin.elapsed() < PATIENCE, "nothing comes");
            if is_idle {
                self.clock.step();
            }
            breath().await;
        }
    }

    /// Waits until the server has handled all that was sent, and keeps what comes.
    pub async fn settle(&mut self) {
        // An answer may come before what was to be sent in the same moment.
        for _ in 0..2 {
            while let Coming::Message(message) = self.ping().await {
                self.arrived.push_back(message);
            }
        }
    }

    /// Neither reads nor sends anything for a time.
    pub async fn hang(&mut self, time: Duration) {
        self.settle().await;
        self.clock.pass(time).await;
    }

    /// The events that have come.
    pub async fn come(&mut self) -> Vec<Value> {
        self.settle().await;
        let mut events = vec![];
        for _ in 0..self.arrived.len() {
            if let Some(event) = self.arrived.pop_front().and_then(|message| self.take(&message)) {
                events.push(event);
            }
        }
        events
    }

    /// The next event; samples are kept on the way. None if the connection has ended.
    pub async fn next(&mut self) -> Option<Value> {
        loop {
            match self.message(None).await {
                Coming::Message(message) => {
                    if let Some(event) = self.heard(&message).await {
                        return Some(event);
                    }
                }
                Coming::End => return None,
                Coming::Nothing => {}
            }
        }
    }

    /// The next event before a time of the clock.
    pub async fn next_before(&mut self, end: Duration) -> Option<Value> {
        loop {
            match self.message(Some(end)).await {
                Coming::Message(message) => {
                    if let Some(event) = self.heard(&message).await {
                        return Some(event);
                    }
                }
                Coming::End => panic!("the connection has ended"),
                Coming::Nothing => return None,
            }
        }
    }

    /// Takes a message, and gives a word for it.
    async fn heard(&mut self, message: &Message) -> Option<Value> {
        let event = self.take(message);
        let is_news = match (&event, message) {
            (Some(event), _) => !WITHOUT_A_WORD.contains(&event["event"].as_str().unwrap()),
            (None, message) => message.is_binary(),
        };
        if self.lives && is_news {
            // The connection may end meanwhile.
            let _ = self.socket.send(Message::Text(r#"{"do":"alive"}"#.into())).await;
        }
        event
    }

    /// Takes a message, and returns the event that it is.
    fn take(&mut self, message: &Message) -> Option<Value> {
        match message {
            Message::Text(text) => {
                let event: Value = serde_json::from_str(text).unwrap();
                if event["event"] == "hello" {
                    let names = event["signals"].as_array().unwrap();
                    let name = |signal: &Value| signal["name"].as_str().unwrap().to_owned();
                    self.columns = names.iter().map(name).collect();
                    self.rows.clear();
                }
                if event["event"] == "parameters" {
                    self.form = event.clone();
                }
                if event["event"] == "motion" {
                    self.motion = event.clone();
                }
                Some(event)
            }
            Message::Binary(frame) => {
                self.frame(frame);
                None
            }
            _ => None,
        }
    }

    fn frame(&mut self, frame: &[u8]) {
        let words: Vec<u32> = frame.as_chunks().0.iter().map(|w| u32::from_le_bytes(*w)).collect();
        let [_, columns, rows, _] = words[..4] else { unreachable!() };
        assert_eq!(words.len() as u32, 4 + rows * (2 + columns));
        assert_eq!(columns as usize, self.columns.len());
        self.rows.extend(words[4..].chunks(2 + columns as usize).map(|row| Row {
            number: row[0],
            clock: row[1],
            values: row[2..].to_vec(),
        }));
    }

    /// Waits for an event of a kind.
    pub async fn event(&mut self, kind: &str) -> Value {
        self.until(|event| event["event"] == kind).await
    }

    /// Waits for an event.
    pub async fn until(&mut self, wanted: impl Fn(&Value) -> bool) -> Value {
        let begin = Instant::now();
        loop {
            let event = self.next().await.expect("the connection has ended");
            if wanted(&event) {
                return event;
            }
            assert!(begin.elapsed() < PATIENCE, "it does not come; the last one is {event}");
        }
    }

    /// Asks for something, and returns the answer.
    pub async fn ask(&mut self, mut what: Value) -> Value {
        self.number += 1;
        let number = self.number;
        what["id"] = number.into();
        self.send(&what).await;
        self.until(|event| event["event"] == "answer" && event["id"] == number).await
    }

    /// Asks for something that is done.
    pub async fn done(&mut self, what: Value) -> String {
        let answer = self.ask(what.clone()).await;
        assert_eq!(answer["ok"], true, "{what}: {answer}");
        answer["said"].as_str().unwrap().to_owned()
    }

    /// Asks for something that is refused, and returns why.
    pub async fn refused(&mut self, what: Value) -> String {
        let answer = self.ask(what.clone()).await;
        assert_eq!(answer["ok"], false, "{what}: {answer}");
        answer["said"].as_str().unwrap().to_owned()
    }

    /// Waits until the device is in a state.
    pub async fn state(&mut self, state: &str) -> Value {
        self.until(|event| event["event"] == "status" && event["state"] == state).await
    }

    /// Returns the form of the parameters after a number of changes that can be undone.
    pub async fn form(&mut self, changes: u64) -> Value {
        while self.form["undo"] != changes {
            self.event("parameters").await;
        }
        self.form.clone()
    }

    /// Waits for the event of a move, and returns the last one.
    pub async fn motion(&mut self) -> Value {
        while self.motion.is_null() {
            self.next().await;
        }
        self.motion.clone()
    }

    /// Looks and gives words for so long.
    pub async fn watch(&mut self, time: Duration) {
        let end = self.clock.now() + time;
        while self.next_before(end).await.is_some() {}
    }

    /// A signal of all samples that have come.
    pub fn signal(&self, name: &str) -> Vec<u32> {
        let column = self.columns.iter().position(|known| known == name).unwrap();
        self.rows.iter().map(|row| row.values[column]).collect()
    }
}

pub fn arm() -> Value {
    json!({ "do": "arm" })
}
