//! A page for the tests: it speaks to the server as the real one does.

use std::net::SocketAddr;
use std::sync::{Arc, Mutex};
use std::time::Duration;

use futures_util::{SinkExt, StreamExt};
use host_sim::studio::{Server, StudioOptions};
use serde_json::{Value, json};
use simulator::device::simulated::SimulatedDevice;
use simulator::device::wire::{SimulatedWire, Wire};
use simulator::experiment::{Document, Experiment};
use tokio::net::TcpStream;
use tokio::time::{Instant, timeout};
use tokio_tungstenite::WebSocketStream;
use tokio_tungstenite::tungstenite::{Error, Message};

/// Nothing takes longer, on a machine that has other things to do as well.
pub const PATIENCE: Duration = Duration::from_secs(20);

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

/// A studio around what stands behind a wire, whose joint is that of a machine.
fn serve<W: Wire>(
    machine: &str,
    is_its_file: bool,
    open: impl Fn() -> Result<W, files::Error> + Send + 'static,
) -> Server {
    Server::start(wanted(machine, is_its_file), open).unwrap()
}

fn wanted(machine: &str, is_its_file: bool) -> StudioOptions {
    let listen = "127.0.0.1:0".parse().unwrap();
    StudioOptions { listen, machine: machine.into(), is_its_file, every_tick: true }
}

/// A studio around what stands behind a wire.
pub fn studio_of<W: Wire>(open: impl Fn() -> Result<W, files::Error> + Send + 'static) -> Server {
    serve("step-response", true, open)
}

/// A studio around what stands behind a wire, with a machine's file.
pub fn studio_of_file<W: Wire>(
    machine: &str,
    open: impl Fn() -> Result<W, files::Error> + Send + 'static,
) -> Server {
    serve(machine, true, open)
}

/// A studio around the device of a wire, without a file of its joint.
pub fn studio_of_unknown<W: Wire>(
    open: impl Fn() -> Result<W, files::Error> + Send + 'static,
) -> Server {
    serve("step-response", false, open)
}

/// A studio around the thesis's joint, without a file of it.
pub fn studio_without_a_file() -> Server {
    studio_of_unknown(|| Ok(SimulatedWire::new(device(&[]))))
}

/// A studio around a simulated machine.
pub fn studio_around(machine: &'static str, law: &'static str, set: &[&str]) -> Server {
    let set: Vec<String> = set.iter().map(|text| (*text).to_owned()).collect();
    serve(machine, true, move || {
        let set: Vec<&str> = set.iter().map(String::as_str).collect();
        Ok(SimulatedWire::new(device_of(machine, law, &set)))
    })
}

/// A studio around the thesis's joint.
pub fn studio(set: &[&str]) -> Server {
    studio_around("step-response", "srnf", set)
}

/// A studio around the thesis's joint, and its reports of refusals.
pub fn studio_with_reports() -> (Server, Arc<Mutex<Vec<String>>>) {
    let reports = Arc::<Mutex<Vec<String>>>::default();
    let all = reports.clone();
    let report = move |what: &str| all.lock().unwrap().push(what.to_owned());
    let open = || Ok(SimulatedWire::new(device(&[])));
    (Server::start_with_reporter(wanted("step-response", true), report, open).unwrap(), reports)
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
    pub origin: Option<String>,
    pub host: String,
}

impl<'a> Visit<'a> {
    /// As the page does.
    pub fn proper(server: &'a Server) -> Self {
        let host = server.address().to_string();
        let origin = Some(format!("http://{host}"));
        Self { address: server.address(), token: server.token().text(), origin, host }
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
        Ok(Page { socket, lives: true, rows, columns: vec![], role, form, motion, number: 0 })
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
}

impl Page {
    pub async fn open(server: &Server) -> Self {
        let mut page = Visit::proper(server).connect().await.unwrap();
        page.role = page.event("role").await;
        page.event("status").await;
        page
    }

    pub async fn send(&mut self, what: &Value) {
        self.socket.send(Message::Text(what.to_string().into())).await.unwrap();
    }

    /// The next event; samples are kept on the way. None if the connection has ended.
    pub async fn next(&mut self) -> Option<Value> {
        loop {
            let message = timeout(PATIENCE, self.socket.next()).await.expect("nothing comes")?;
            let message = message.ok()?;
            let event = match &message {
                Message::Text(text) => serde_json::from_str(text).unwrap(),
                _ => Value::Null,
            };
            // A word for what comes of the device, as the page gives it.
            let is_news =
                event["event"].as_str().is_none_or(|kind| !WITHOUT_A_WORD.contains(&kind));
            if self.lives && is_news {
                // The connection may end meanwhile.
                let _ = self.socket.send(Message::Text(r#"{"do":"alive"}"#.into())).await;
            }
            match message {
                Message::Text(_) => {
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
                    return Some(event);
                }
                Message::Binary(frame) => self.frame(&frame),
                Message::Close(_) => return None,
                _ => {}
            }
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
        let end = Instant::now() + time;
        while Instant::now() < end {
            self.next().await;
        }
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
