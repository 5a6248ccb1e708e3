//! What the studio does when the way to the device or to the page is bad: late orders, a device
//! that was out of reach, a network that is cut while the motor is driven.

use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

use host_sim::Error;
use host_sim::device::wire::{SimulatedWire, Wire};
use host_sim::ensemble::rules::TUNING_SEEDS;
use host_sim::experiment::Document;
use host_sim::studio::Server;
use host_sim::tuning::{Goal, Request, object, spreads};
use serde_json::{Value, json};
use stiction::link::{Deframer, decode_request};
use stiction::servo::State;
use tokio::net::{TcpListener, TcpStream};

use super::page::{
    Page, Visit, arm, device, run, studio, studio_around, studio_of, studio_of_file,
    studio_of_unknown,
};
use super::what_if::{self, wish};
use super::{LINK_TIMEOUT_S, SLACK_S, TICK_S, ticks_on_after};

/// What is done before a request reaches the device: it is told which one.
type Before = Box<dyn FnMut(&str, &mut SimulatedWire) + Send>;

/// A device that stays where it is, whoever opens the line to it.
#[derive(Clone)]
struct Line {
    device: Arc<Mutex<SimulatedWire>>,
    /// The next request waits for so long, ms.
    stalls_ms: Arc<AtomicU64>,
    /// Nothing gets through.
    is_cut: Arc<AtomicBool>,
    /// What the device was asked for.
    asked: Arc<Mutex<Vec<String>>>,
    deframer: Arc<Mutex<Deframer>>,
    before: Arc<Mutex<Option<Before>>>,
    /// Its time is not that on the wall.
    in_haste: bool,
}

impl Line {
    fn new(set: &[&str]) -> Self {
        Self {
            device: Arc::new(Mutex::new(SimulatedWire::new(device(set)))),
            stalls_ms: Arc::default(),
            is_cut: Arc::default(),
            asked: Arc::default(),
            deframer: Arc::default(),
            before: Arc::default(),
            in_haste: false,
        }
    }

    fn serve(&self) -> Server {
        let line = self.clone();
        studio_of(move || Ok(line.clone()))
    }

    fn names(&self) -> Vec<String> {
        self.asked.lock().unwrap().clone()
    }

    fn was_asked(&self, what: &str) -> bool {
        self.names().iter().any(|name| name.starts_with(what))
    }

    fn before(&self, what: impl FnMut(&str, &mut SimulatedWire) + Send + 'static) {
        *self.before.lock().unwrap() = Some(Box::new(what));
    }

    /// The next request of a kind waits for so long. Tells when it does.
    fn stalls(&self, kind: &'static str, time: Duration) -> Arc<AtomicBool> {
        let is_stalled = Arc::new(AtomicBool::new(false));
        let stalled = is_stalled.clone();
        self.before(move |name, _| {
            if name.starts_with(kind) && !stalled.swap(true, Ordering::SeqCst) {
                std::thread::sleep(time);
            }
        });
        is_stalled
    }
}

/// Waits, and gives no word meanwhile.
async fn until(flag: &AtomicBool) {
    for _ in 0..2000 {
        if flag.load(Ordering::SeqCst) {
            return;
        }
        tokio::time::sleep(Duration::from_millis(5)).await;
    }
    panic!("it does not come");
}

impl Wire for Line {
    fn send(&mut self, bytes: &[u8]) -> Result<(), Error> {
        if self.is_cut.load(Ordering::SeqCst) {
            return Ok(());
        }
        for byte in bytes {
            let mut deframer = self.deframer.lock().unwrap();
            let Some(message) = deframer.push(*byte) else { continue };
            let (_, request) = decode_request(message).unwrap();
            let name = format!("{:?}", request.unwrap());
            self.asked.lock().unwrap().push(name.clone());
            if let Some(before) = &mut *self.before.lock().unwrap() {
                before(&name, &mut self.device.lock().unwrap());
            }
        }
        let stalls = self.stalls_ms.swap(0, Ordering::SeqCst);
        std::thread::sleep(Duration::from_millis(stalls));
        self.device.lock().unwrap().send(bytes)
    }

    fn receive(&mut self, at_most: Duration) -> Result<Vec<u8>, Error> {
        if self.is_cut.load(Ordering::SeqCst) {
            std::thread::sleep(at_most);
            return Ok(vec![]);
        }
        self.device.lock().unwrap().receive(at_most)
    }

    fn name(&self) -> String {
        "the device of the test".into()
    }

    fn real_time(&mut self) {
        if !self.in_haste {
            self.device.lock().unwrap().real_time();
        }
    }

    fn warning(&self) -> Option<&'static str> {
        None
    }
}

#[test]
fn an_order_that_has_waited_for_more_than_a_second_is_not_obeyed() {
    run(async {
        let line = Line::new(&[]);
        let server = line.serve();
        let mut page = Page::open(&server).await;
        // The device is busy for so long, and the order is given meanwhile.
        line.stalls_ms.store(1500, Ordering::SeqCst);
        tokio::time::sleep(Duration::from_millis(200)).await;
        let said = page.refused(arm()).await;
        assert!(said.contains("the device was busy"), "{said}");
        assert!(!line.names().iter().any(|name| name == "Arm"), "{:?}", line.names());
        // One that is as old as half of that is.
        line.stalls_ms.store(500, Ordering::SeqCst);
        tokio::time::sleep(Duration::from_millis(150)).await;
        page.done(arm()).await;
        page.done(json!({ "do": "stop" })).await;
    });
}

#[test]
fn an_order_of_a_page_that_is_gone_is_not_obeyed() {
    run(async {
        let line = Line::new(&[]);
        let server = line.serve();
        let mut page = Page::open(&server).await;
        let mut reader = Page::open(&server).await;
        reader.lives = false;
        line.stalls_ms.store(700, Ordering::SeqCst);
        tokio::time::sleep(Duration::from_millis(200)).await;
        page.send(&arm()).await;
        tokio::time::sleep(Duration::from_millis(50)).await;
        drop(page);
        reader.watch(Duration::from_millis(1500)).await;
        assert!(!line.names().iter().any(|name| name == "Arm"), "{:?}", line.names());
        assert_eq!(reader.event("status").await["state"], "stopped");
    });
}

#[test]
fn a_device_that_was_out_of_reach_while_armed_from_here_is_told_to_stop_first() {
    run(async {
        let line = Line::new(&["limits.link_timeout_s=30"]);
        let server = line.serve();
        let mut page = Page::open(&server).await;
        page.done(arm()).await;
        page.watch(Duration::from_millis(300)).await;
        line.is_cut.store(true, Ordering::SeqCst);
        let gone = page.event("gone").await;
        assert!(gone["said"].as_str().unwrap().contains("THE MOTOR MAY STILL BE DRIVEN"), "{gone}");
        let said = page.refused(json!({ "do": "move", "deg": 1.0 })).await;
        assert!(said.contains("does not answer"), "{said}");
        let before = line.names().len();
        line.is_cut.store(false, Ordering::SeqCst);
        page.event("back").await;
        let after = line.names().split_off(before);
        assert!(after[0].starts_with("Hello"), "a session begins with it: {after:?}");
        assert_eq!(after[1], "Stop", "{after:?}");
        let status = page.state("stopped").await;
        assert!(status["fault"].is_null(), "{status}");
    });
}

#[test]
fn a_self_test_that_has_lost_its_device_says_so_and_the_device_is_told_to_stop_first() {
    run(async {
        let line = Line::new(&[]);
        let server = line.serve();
        let mut page = Page::open(&server).await;
        let begin = predicted(&mut page, 2).await;
        page.done(begin.clone()).await;
        line.is_cut.store(true, Ordering::SeqCst);
        let told = page.until(|event| event["phase"] == "none").await;
        assert!(told["said"].as_str().unwrap().contains("did not answer"), "{told}");
        line.asked.lock().unwrap().clear();
        line.is_cut.store(false, Ordering::SeqCst);
        page.event("back").await;
        assert_eq!(line.names().get(1).map(String::as_str), Some("Stop"), "{:?}", line.names());
        // It does not go on by itself.
        assert!(page.refused(begin).await.contains("predict it first"));
        // A page that comes later has not heard that it was gone.
        let mut later = Visit::proper(&server).connect().await.unwrap();
        later.lives = false;
        let mut kinds: Vec<String> = vec![];
        while kinds.last().is_none_or(|kind| kind != "status") {
            kinds.push(later.next().await.unwrap()["event"].as_str().unwrap().to_owned());
        }
        assert!(!kinds.iter().any(|kind| kind == "back" || kind == "gone"), "{kinds:?}");
    });
}

/// Predicts a self-test, and returns the order to make its moves.
async fn predicted(page: &mut Page, moves: usize) -> Value {
    page.done(json!({ "do": "predict-selftest", "moves": moves })).await;
    let ready = page.until(|event| event["phase"] == "ready").await;
    json!({ "do": "selftest", "number": ready["number"] })
}

#[test]
fn a_self_test_that_is_not_expected_any_more_while_it_is_prepared_never_arms() {
    run(async {
        let line = Line::new(&[]);
        let server = line.serve();
        let mut page = Page::open(&server).await;
        let mut begin = predicted(&mut page, 2).await;
        begin["id"] = 70.into();
        let answer = |event: &Value| event["event"] == "answer" && event["id"] == 70;
        // A stop comes while the parameters are read that the prediction has to fit.
        let stalled = line.stalls("ReadParameters", Duration::from_millis(400));
        page.send(&begin).await;
        until(&stalled).await;
        page.send(&json!({ "id": 71, "do": "stop" })).await;
        let said = page.until(answer).await;
        assert!(said["said"].as_str().unwrap().contains("a stop came first"), "{said}");
        page.until(|event| event["event"] == "answer" && event["id"] == 71).await;
        assert!(!line.was_asked("Arm"), "{:?}", line.names());
        // It takes so long that nobody expects it.
        line.stalls("ReadParameters", Duration::from_millis(1100));
        page.send(&begin).await;
        let said = page.until(answer).await;
        assert!(said["said"].as_str().unwrap().contains("the device was busy"), "{said}");
        assert!(!line.was_asked("Arm"), "{:?}", line.names());
        // As long as the first one, but nobody stops it.
        line.stalls("ReadParameters", Duration::from_millis(400));
        page.send(&begin).await;
        assert_eq!(page.until(answer).await["ok"], true);
        assert!(line.was_asked("Arm"));
        page.done(json!({ "do": "stop" })).await;
        // The page that has given it is gone.
        line.asked.lock().unwrap().clear();
        let stalled = line.stalls("ReadParameters", Duration::from_millis(600));
        let mut reader = Page::open(&server).await;
        reader.lives = false;
        page.send(&begin).await;
        until(&stalled).await;
        drop(page);
        reader.watch(Duration::from_millis(1500)).await;
        assert!(line.was_asked("ReadParameters") && !line.was_asked("Arm"), "{:?}", line.names());
    });
}

/// A self-test whose device answers late when it is asked for the status with which the first move
/// is due. Returns when it is.
async fn due(line: &Line, page: &mut Page) {
    // The soft start, and 2 s.
    const WAITS_S: f64 = 2.2;
    let begin = predicted(page, 2).await;
    let (is_due, mut armed) = (Arc::new(AtomicBool::new(false)), None::<Instant>);
    let due = is_due.clone();
    line.before(move |name, _| {
        if name == "Arm" {
            armed = Some(Instant::now());
        }
        let is_late = armed.is_some_and(|at| at.elapsed().as_secs_f64() > WAITS_S - 0.1);
        if name == "Status" && is_late && !due.swap(true, Ordering::SeqCst) {
            // Less than what a simulated device catches up with, and more than a word is worth.
            std::thread::sleep(Duration::from_millis(190));
        }
    });
    page.done(begin).await;
    // It gives a word for all that comes, and none from then on.
    while !is_due.load(Ordering::SeqCst) {
        let _ = tokio::time::timeout(Duration::from_millis(5), page.next()).await;
    }
}

#[test]
fn no_move_of_a_self_test_begins_on_an_old_word_or_after_a_stop() {
    const SET: [&str; 2] = ["device.soft_start_s=0.2", "limits.link_timeout_s=5"];
    run(async {
        let line = Line::new(&SET);
        let server = line.serve();
        let mut page = Page::open(&server).await;
        due(&line, &mut page).await;
        page.send(&json!({ "do": "stop" })).await;
        let done = page.until(|event| event["phase"] == "done").await;
        assert_eq!(done["result"]["ended_by"], "a stop", "{done}");
        assert!(!line.was_asked("Move"), "{:?}", line.names());
    });
    run(async {
        let line = Line::new(&SET);
        let server = line.serve();
        let mut page = Page::open(&server).await;
        due(&line, &mut page).await;
        // The page hangs: it has given its last word before the status was asked for.
        tokio::time::sleep(Duration::from_millis(600)).await;
        assert!(!line.was_asked("Move"), "{:?}", line.names());
        // With its next words the move begins.
        page.until(|event| event["phase"] == "moving" && event["to_deg"].is_f64()).await;
        assert!(line.was_asked("Move"));
        page.done(json!({ "do": "stop" })).await;
    });
}

#[test]
fn a_move_of_a_self_test_that_is_refused_ends_it_with_that_reason_and_keeps_the_moves() {
    run(async {
        let line = Line::new(&[]);
        let server = line.serve();
        let mut page = Page::open(&server).await;
        let begin = predicted(&mut page, 3).await;
        let mut moves = 0;
        // Something else turns the output off just before the second move.
        line.before(move |name, wire| {
            moves += u32::from(name.starts_with("Move"));
            if moves == 2 {
                wire.simulated.device.servo().stop();
            }
        });
        page.done(begin).await;
        let done = page.until(|event| event["phase"] == "done").await;
        assert_eq!((&done["ok"], &done["result"]["checks"]), (&json!(false), &json!([])));
        let by = done["result"]["ended_by"].as_str().unwrap();
        assert!(by.contains("refuses"), "{by}");
        assert!(done["said"].as_str().unwrap().contains(by), "{done}");
        assert_eq!(done["result"]["moves"].as_array().unwrap().len(), 1, "{done}");
    });
}

#[test]
fn a_stop_is_answered_however_many_orders_wait() {
    run(async {
        let line = Line::new(&[]);
        let server = line.serve();
        let mut page = Page::open(&server).await;
        line.stalls_ms.store(900, Ordering::SeqCst);
        tokio::time::sleep(Duration::from_millis(200)).await;
        for id in 100..140 {
            page.send(&json!({ "id": id, "do": "arm" })).await;
        }
        page.send(&json!({ "id": 99, "do": "stop" })).await;
        let (mut full, mut overtaken) = (0, 0);
        let stopped = loop {
            let event = page.event("answer").await;
            let said = event["said"].as_str().unwrap();
            full += u32::from(said.contains("too many requests wait"));
            overtaken += u32::from(said.contains("a stop came first"));
            if event["id"] == 99 {
                break event;
            }
        };
        assert_eq!((&stopped["ok"], full, overtaken), (&json!(true), 8, 32), "{stopped}");
        assert!(stopped["said"].as_str().unwrap().contains("the motor is off"), "{stopped}");
        assert!(!line.was_asked("Arm"), "{:?}", line.names());
    });
}

#[test]
fn a_device_that_was_not_armed_from_here_is_left_alone_when_it_is_back() {
    run(async {
        let line = Line::new(&[]);
        let server = line.serve();
        let mut page = Page::open(&server).await;
        line.is_cut.store(true, Ordering::SeqCst);
        page.event("gone").await;
        let before = line.names().len();
        line.is_cut.store(false, Ordering::SeqCst);
        page.event("back").await;
        let after = line.names().split_off(before);
        assert!(!after.contains(&"Stop".to_owned()), "{after:?}");
    });
}

#[test]
fn a_stop_that_did_not_reach_the_device_is_said_once_it_is_back() {
    run(async {
        let line = Line::new(&[]);
        let server = line.serve();
        let mut page = Page::open(&server).await;
        line.is_cut.store(true, Ordering::SeqCst);
        let said = page.refused(json!({ "do": "stop" })).await;
        assert!(said.contains("not answer"), "{said}");
        let before = line.names().len();
        line.is_cut.store(false, Ordering::SeqCst);
        page.event("back").await;
        page.watch(Duration::from_millis(300)).await;
        let after = line.names().split_off(before);
        assert!(after.contains(&"Stop".to_owned()), "{after:?}");
    });
}

#[test]
fn a_device_that_is_gone_is_tried_again_and_a_stop_is_answered_however_many_orders_come() {
    run(async {
        let line = Line::new(&[]);
        let server = line.serve();
        let mut page = Page::open(&server).await;
        line.is_cut.store(true, Ordering::SeqCst);
        page.event("gone").await;
        // Five times a second, and the time between two tries is one.
        for id in 200..215 {
            if id == 202 {
                page.send(&json!({ "id": 299, "do": "stop" })).await;
            }
            if id == 207 {
                line.is_cut.store(false, Ordering::SeqCst);
            }
            page.send(&json!({ "id": id, "do": "clear" })).await;
            tokio::time::sleep(Duration::from_millis(200)).await;
        }
        let (mut stop, mut last) = (None, None);
        while stop.is_none() || last.is_none() {
            let answer = page.event("answer").await;
            match answer["id"].as_u64() {
                Some(299) => stop = Some(answer["said"].clone()),
                Some(214) => last = Some(answer["said"].clone()),
                _ => {}
            }
        }
        let (stop, last) = (stop.unwrap(), last.unwrap());
        assert!(stop.as_str().unwrap().contains("does not answer"), "{stop}");
        assert!(!last.as_str().unwrap().contains("does not answer"), "{last}");
    });
}

#[test]
fn what_waits_is_not_obeyed_after_a_stop() {
    run(async {
        let line = Line::new(&[]);
        let server = line.serve();
        let mut page = Page::open(&server).await;
        let mut reader = Page::open(&server).await;
        reader.lives = false;
        line.stalls_ms.store(600, Ordering::SeqCst);
        tokio::time::sleep(Duration::from_millis(200)).await;
        page.send(&json!({ "id": 77, "do": "arm" })).await;
        tokio::time::sleep(Duration::from_millis(50)).await;
        reader.done(json!({ "do": "stop" })).await;
        let answer = page.until(|event| event["id"] == 77).await;
        assert!(answer["said"].as_str().unwrap().contains("a stop came first"), "{answer}");
        assert!(!line.names().iter().any(|name| name == "Arm"), "{:?}", line.names());
    });
}

#[test]
fn what_something_else_has_turned_on_is_not_kept_alive_by_the_studio() {
    run(async {
        let line = Line::new(&[]);
        let server = line.serve();
        let mut page = Page::open(&server).await;
        page.lives = false;
        page.watch(Duration::from_millis(400)).await;
        line.device.lock().unwrap().simulated.device.servo().arm().unwrap();
        page.state("armed").await;
        // It was asked once when a sample said so. (To watch would wait for an event.)
        tokio::time::sleep(Duration::from_millis(200)).await;
        let before = line.names().len();
        tokio::time::sleep(Duration::from_millis(1200)).await;
        let asked = line.names().split_off(before);
        assert!(asked.is_empty(), "{asked:?}");
        // It is asked again after 1 s and two link timeouts.
        tokio::time::sleep(Duration::from_millis(1100)).await;
        let asked = line.names().split_off(before);
        assert_eq!(asked, ["Status"]);
        page.done(json!({ "do": "stop" })).await;
    });
}

#[test]
fn a_studio_that_ends_leaves_the_motor_to_the_link_timeout() {
    run(async {
        let line = Line::new(&[]);
        let server = line.serve();
        let mut page = Page::open(&server).await;
        page.done(arm()).await;
        page.watch(Duration::from_millis(500)).await;
        drop(server);
        let is_armed = || {
            let mut device = line.device.lock().unwrap();
            // The device goes on.
            device.receive(Duration::from_millis(20)).unwrap();
            device.simulated.device.servo().state() == State::Armed
        };
        assert!(is_armed());
        let ends = Instant::now() + Duration::from_secs(3);
        while is_armed() && Instant::now() < ends {}
        let latched = line.device.lock().unwrap().simulated.device.servo().latched().unwrap();
        assert_eq!(latched.fault as u8, 22);
    });
}

#[test]
fn the_seventeenth_page_is_turned_away() {
    run(async {
        let server = studio(&[]);
        let mut pages = Vec::new();
        for _ in 0..16 {
            pages.push(Visit::proper(&server).connect().await.unwrap());
        }
        assert!(Visit::proper(&server).connect().await.is_err());
        pages.pop();
        // Its place is free once the server has seen that it is gone.
        tokio::time::sleep(Duration::from_millis(500)).await;
        assert!(Visit::proper(&server).connect().await.is_ok());
    });
}

/// A network between a page and the server, which can be cut: nothing gets through then, and no end
/// of the connection is seen.
async fn network(server: &Server, is_cut: Arc<AtomicBool>) -> std::net::SocketAddr {
    let listener = TcpListener::bind("127.0.0.1:0").await.unwrap();
    let (address, to) = (listener.local_addr().unwrap(), server.address());
    tokio::spawn(async move {
        let (near, _) = listener.accept().await.unwrap();
        let far = TcpStream::connect(to).await.unwrap();
        let ((mut from_near, mut to_near), (mut from_far, mut to_far)) =
            (near.into_split(), far.into_split());
        let cut = is_cut.clone();
        tokio::spawn(async move { carry(&mut from_far, &mut to_near, &cut).await });
        carry(&mut from_near, &mut to_far, &is_cut).await;
    });
    address
}

async fn carry(
    from: &mut tokio::net::tcp::OwnedReadHalf,
    to: &mut tokio::net::tcp::OwnedWriteHalf,
    is_cut: &AtomicBool,
) {
    use tokio::io::{AsyncReadExt, AsyncWriteExt};
    let mut buffer = [0; 4096];
    loop {
        let count = from.read(&mut buffer).await.unwrap_or(0);
        if count == 0 {
            return;
        }
        while is_cut.load(Ordering::SeqCst) {
            tokio::time::sleep(Duration::from_millis(20)).await;
        }
        if to.write_all(&buffer[..count]).await.is_err() {
            return;
        }
    }
}

#[test]
fn a_network_that_is_cut_while_armed_turns_the_output_off_within_the_link_timeout() {
    run(async {
        let server = studio(&[]);
        let is_cut = Arc::new(AtomicBool::new(false));
        let address = network(&server, is_cut.clone()).await;
        let mut page = Visit { address, ..Visit::proper(&server) }.connect().await.unwrap();
        page.role = page.event("role").await;
        page.event("status").await;
        let mut reader = Page::open(&server).await;
        reader.lives = false;
        page.done(arm()).await;
        page.watch(Duration::from_millis(1000)).await;
        let last = page.rows.last().unwrap().clock;
        is_cut.store(true, Ordering::SeqCst);
        let on_s = ticks_on_after(&mut reader, last).await as f64 * TICK_S;
        assert!((LINK_TIMEOUT_S - 0.15..LINK_TIMEOUT_S + SLACK_S).contains(&on_s), "{on_s} s");
        assert_eq!(reader.state("faulted").await["fault"]["code"], 22);
    });
}

#[test]
fn a_trajectory_is_followed_and_what_cannot_be_followed_is_refused() {
    run(async {
        let server = studio(&[]);
        let mut page = Page::open(&server).await;
        let go = |fields: [f64; 4]| json!({ "do": "trajectory", "trapezoid": fields });
        assert!(page.refused(go([2.0, 4.0, 0.2, 0.1])).await.contains("`arm` first"));
        page.done(arm()).await;
        assert!(page.refused(json!({ "do": "trajectory" })).await.contains("has no trajectory"));
        assert!(page.refused(go([2.0, 0.0, 0.2, 0.1])).await.contains("the speed"));
        assert!(page.refused(go([1e300, 4.0, 0.2, 0.1])).await.contains("trajectory"));
        page.done(go([2.0, 4.0, 0.2, 0.1])).await;
        let told = page.motion().await;
        assert_eq!(told["way"]["how"], "trajectory");
        // 0.1 s, 0.5 s there, 0.2 s, 0.5 s back, 0.1 s.
        page.watch(Duration::from_millis(2500)).await;
        page.done(json!({ "do": "stop" })).await;
        let lead = page.signal("reference_counts").into_iter().map(|bits| bits as i32);
        let most = f64::from(lead.max().unwrap()) * super::RESOLUTION;
        assert!((most - 2.0).abs() < 0.01, "{most} deg");
        let (counts, status) = (page.signal("counts"), page.signal("status"));
        let last = status.iter().rposition(super::is_on).unwrap();
        assert!((counts[last] as i32).abs() <= 12, "{} counts", counts[last] as i32);
        page.state("stopped").await;
        // Where the joint is far from zero, the device refuses to begin at zero.
        page.done(arm()).await;
        page.done(json!({ "do": "move", "deg": 15.0 })).await;
        page.watch(Duration::from_millis(5000)).await;
        let said = page.refused(go([2.0, 4.0, 0.2, 0.1])).await;
        assert!(said.contains("begins too far from the joint"), "{said}");
        page.done(json!({ "do": "stop" })).await;
    });
}

#[test]
fn the_joint_is_identified_by_the_device_s_own_sequence() {
    run(async {
        let server = studio(&[]);
        let mut page = Page::open(&server).await;
        let said = page.done(json!({ "do": "identify" })).await;
        assert!(said.contains("ends by itself"), "{said}");
        page.state("armed").await;
        page.watch(Duration::from_secs(3)).await;
        let pushed = page.signal("v_applied_v").into_iter().map(f32::from_bits);
        assert!(pushed.fold(0.0, |most: f32, volt| most.max(volt.abs())) > 0.01, "it pushes");
        // It takes minutes; a stop ends it, and then nothing was found: nothing is told.
        page.done(json!({ "do": "stop" })).await;
        let mut found = false;
        let begin = Instant::now();
        while begin.elapsed() < Duration::from_secs(1) {
            let event = page.next().await.unwrap();
            found |= event["event"] == "found";
            if event["event"] == "status" {
                assert_eq!(event["state"], "stopped", "{event}");
            }
        }
        assert!(!found);
    });
}

#[test]
fn an_identification_begins_only_if_it_is_expected_once_it_was_checked_and_can_find_something() {
    run(async {
        let line = Line::new(&[]);
        let server = line.serve();
        let mut page = Page::open(&server).await;
        let identify = json!({ "do": "identify" });
        line.stalls("ReadParameters", Duration::from_millis(1100));
        let said = page.refused(identify.clone()).await;
        assert!(said.contains("the device was busy"), "{said}");
        assert!(!line.was_asked("IdentifyJoint"), "{:?}", line.names());
        // As long as half of that, and it is expected still.
        line.stalls("ReadParameters", Duration::from_millis(400));
        page.done(identify).await;
        assert!(line.was_asked("IdentifyJoint"), "{:?}", line.names());
        page.done(json!({ "do": "stop" })).await;
    });
    run(async {
        // Too slow for the thesis's encoder, which shows the swings from 0.104 deg/s on.
        let line = Line::new(&["profile.velocity_deg_per_s=0.05"]);
        let server = line.serve();
        let mut page = Page::open(&server).await;
        let said = page.refused(json!({ "do": "identify" })).await;
        assert!(said.contains("set profile.velocity_deg_per_s"), "{said}");
        assert!(said.contains("Nothing has moved") && !said.contains("--"), "{said}");
        // That is a refusal, and the device is there.
        assert_eq!(page.event("status").await["state"], "stopped");
        assert!(!line.was_asked("IdentifyJoint"), "{:?}", line.names());
    });
}

#[test]
fn what_was_identified_is_told_although_the_machine_s_file_is_gone() {
    let name = format!("stiction-studio-gone-{}.toml", std::process::id());
    let file = std::env::temp_dir().join(name);
    let text = std::fs::read_to_string("experiments/step-response.toml").unwrap();
    std::fs::write(&file, text).unwrap();
    run(async {
        // Its time passes as fast as it can be computed, so minutes take seconds.
        let line = Line { in_haste: true, ..Line::new(&["limits.link_timeout_s=\"off\""]) };
        let opened = line.clone();
        let server = studio_of_file(file.to_str().unwrap(), move || Ok(opened.clone()));
        let mut page = Page::open(&server).await;
        page.done(json!({ "do": "identify" })).await;
        std::fs::remove_file(&file).unwrap();
        let found = loop {
            let event = page.next().await.unwrap();
            assert_ne!(event["event"], "gone", "{event}");
            if event["event"] == "found" {
                break event["said"].as_str().unwrap().to_owned();
            }
        };
        assert!(found.contains("breakaway +") && found.contains("inertia"), "{found}");
        assert!(found.contains("not in SI units"), "{found}");
    });
}

/// The sliders of the joint that was found: the effort that starts it, V.
async fn found_stick(page: &mut Page, file: &Value) -> f64 {
    let told = page.until(|event| event["event"] == "what-if" && !event["found"].is_null()).await;
    assert_eq!((&told["found"]["machine"], &told["found"]["why"]), (file, &Value::Null));
    assert!(told["why"].as_str().unwrap().contains("without a machine's file"), "{told}");
    let knobs = told["found"]["knobs"].as_array().unwrap();
    knobs.iter().find(|knob| knob["name"] == "stick_v").unwrap()["value"].as_f64().unwrap()
}

#[test]
fn the_joint_that_was_found_is_a_file_and_is_predicted_tuned_and_tested_with() {
    const GAIN: &str = "joint.gain_deg_per_s2_per_v";
    run(async {
        let line = Line { in_haste: true, ..Line::new(&["limits.link_timeout_s=\"off\""]) };
        let opened = line.clone();
        // Nobody has told its joint.
        let server = studio_of_unknown(move || Ok(opened.clone()));
        let mut page = Page::open(&server).await;
        let test = json!({ "do": "predict-selftest", "moves": 2, "joint": "found" });
        let tune = json!({ "do": "tune", "laws": [], "goal": "settle", "joint": "found",
                           "cases": 2 });
        for early in [&test, &tune] {
            assert!(page.refused(early.clone()).await.contains("identify it first"));
        }
        let mut early = wish(&json!({ "how": "step", "deg": 1.0 }), &["srnf"], &json!({}), 0);
        early["wish"]["joint"] = "found".into();
        page.send(&early).await;
        let refused = page.until(|event| event["part"] == "refused").await;
        assert!(refused["content"].as_str().unwrap().contains("identify it first"), "{refused}");
        page.done(json!({ "do": "identify" })).await;
        let found = page.event("identified").await;
        assert_eq!((&found["ok"], &found["file"]), (&json!(true), &json!("joint.identified.toml")));
        assert_eq!(found["laws"], json!(["srnf"]));
        let text = found["toml"].as_str().unwrap();
        assert!(text.starts_with("# SIMULATED DEVICE") && text.contains("[spread]"), "{text}");
        // It is the joint of the device, and no other one.
        let of = |document: &Document| document.get(GAIN).unwrap().as_float().unwrap();
        let is = of(&Document::parse("found", text).unwrap());
        let was = of(&Document::open("step-response").unwrap());
        assert!((is / was - 1.0).abs() < 0.05, "{is} of {was}");
        // A page that comes later is told it, too.
        let mut later = Visit::proper(&server).connect().await.unwrap();
        later.lives = false;
        assert_eq!(later.event("identified").await["toml"], found["toml"]);
        // What if: the predictions are those of a studio that has that file.
        let stick = found_stick(&mut page, &found["file"]).await;
        let in_file = Document::parse("found", text).unwrap();
        let in_file = in_file.get("joint.friction.stick_v").unwrap().as_float().unwrap();
        assert!((stick / in_file - 1.0).abs() < 1e-6, "{stick} of {in_file}");
        let wanted = wish(&json!({ "how": "move", "deg": 5.0 }), &["srnf"], &json!({}), 3);
        let mut of_found = wanted.clone();
        of_found["wish"]["joint"] = "found".into();
        let file = std::env::temp_dir().join(format!("stiction-found-{}.toml", std::process::id()));
        std::fs::write(&file, text).unwrap();
        let other = studio_around(file.to_str().unwrap().to_owned().leak(), "srnf", &[]);
        let mut of_file = Page::open(&other).await;
        for part in ["laws", "cloud"] {
            let by_found = what_if::predicted(&mut page, part, of_found.clone()).await;
            let by_file = what_if::predicted(&mut of_file, part, wanted.clone()).await;
            assert_eq!(by_found, by_file, "{part}");
        }
        std::fs::remove_file(&file).unwrap();
        page.send(&wanted).await;
        let refused = page.until(|event| event["part"] == "refused").await;
        assert!(refused["content"].as_str().unwrap().contains("in the step Identify"), "{refused}");
        // The gains are those that the command finds with that file.
        let said = page.done(tune).await;
        assert!(said.contains("joint.identified.toml"), "{said}");
        let tuned = page.event("tuned").await;
        assert_eq!((&tuned["machine"], &tuned["joint"]), (&found["file"], &json!("found")));
        let document = Document::parse("joint.identified.toml", text).unwrap();
        let same = Request {
            file: "joint.identified.toml".into(),
            goal: Goal::Settle,
            limits: vec![],
            spreads: spreads(&document).unwrap(),
            cases: 2,
            seed: *TUNING_SEEDS.start(),
            document,
        };
        let same = [same.tune("srnf", &|| ()).unwrap()];
        assert_eq!(tuned["result"], object("joint.identified.toml", &same));
        // The moves are judged by the joint that was found.
        page.done(test).await;
        let ready = page.until(|event| event["phase"] == "ready").await;
        assert_eq!(ready["machine"], found["file"]);
        assert_eq!(ready["joint"], "found");
        let begin = json!({ "do": "selftest", "number": ready["number"] });
        page.done(begin.clone()).await;
        let done = page.until(|event| event["phase"] == "done").await;
        assert_eq!((&done["ok"], &done["result"]["machine"]), (&json!(true), &found["file"]));
        // What it was predicted with is not the joint that is found next.
        page.done(json!({ "do": "identify" })).await;
        let next = page.event("identified").await;
        assert_eq!(next["ok"], true);
        let none = page.until(|event| event["phase"] == "none").await;
        assert!(none["said"].as_str().unwrap().contains("another joint was identified"), "{none}");
        assert!(page.refused(begin).await.contains("predict it first"));
        // It leaves its place faster than this, so the joint that was found before stays.
        let slow = json!({ "profile.velocity_deg_per_s": "0.12" });
        page.done(json!({ "do": "set", "values": slow })).await;
        page.done(json!({ "do": "identify" })).await;
        let still = page.event("identified").await;
        let why = still["why"].as_str().unwrap();
        assert!(
            why.starts_with("the joint came to the bound of its speed") && !why.contains("--"),
            "{why}"
        );
        assert_eq!(still["ok"], false);
        for key in ["file", "toml", "laws"] {
            assert_eq!(still[key], next[key], "{key}");
        }
    });
}
