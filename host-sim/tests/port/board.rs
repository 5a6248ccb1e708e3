//! The far end of the pseudoterminal: a board, or something that should not be there.

use std::io::{Read, Write};
use std::path::PathBuf;
use std::process::{Command, Output};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU32, Ordering};
use std::thread::JoinHandle;
use std::time::Duration;

use serialport::{SerialPort, TTYPort};
use simulator::device::simulated::SimulatedDevice;
use simulator::experiment::{Document, Experiment};
use stiction::link::{
    Deframer, DeviceKind, Identity, Message, NumberedMessage, PROTOCOL, Reply, encode,
};
use stiction::servo::State;

use crate::program::{self, SPAWNING, pseudoterminal};

#[derive(Clone, PartialEq, Eq)]
pub enum Manner {
    /// It answers as a board should.
    Sound,
    /// The cable is pulled after this number of armed ticks.
    PulledWhileArmed(u32),
    /// It speaks a later version of the protocol.
    Later,
    /// It has another firmware, which talks to people.
    Banner,
    /// It sends noise, as another baud rate would.
    Garbage,
    /// It says nothing.
    Silent,
    /// Another client arms it as soon as a file of this name exists. It then makes a file `armed`
    /// beside that.
    ArmedBy(PathBuf),
}

pub struct Board {
    pub path: String,
    /// Samples that the board has sent, and ticks in which it was armed.
    progress: Arc<AtomicU32>,
    done: Arc<AtomicBool>,
    thread: Option<JoinHandle<()>>,
    /// This end is kept open, so that the other one does not hang up between two programs.
    _slave: TTYPort,
}

impl Board {
    pub fn new(manner: Manner) -> Self {
        let (master, slave) = pseudoterminal(&SPAWNING.lock().unwrap());
        let path = slave.name().unwrap();
        let done = Arc::new(AtomicBool::new(false));
        let progress = Arc::new(AtomicU32::new(0));
        let (ends, made) = (done.clone(), progress.clone());
        let thread = Some(std::thread::spawn(move || run(manner, master, &ends, &made)));
        Self { path, progress, done, thread, _slave: slave }
    }

    /// Starts a command, presses Ctrl-C once it has made so much progress, and returns what became
    /// of it.
    pub fn interrupted_after(&self, progress: u32, arguments: &[&str]) -> Output {
        self.progress.store(0, Ordering::Relaxed);
        let child = program::start(&[&["--port", &self.path], arguments].concat());
        while self.progress.load(Ordering::Relaxed) < progress {
            std::thread::sleep(Duration::from_millis(1));
        }
        let kill = Command::new("kill").args(["-INT", &child.id().to_string()]).status();
        assert!(kill.unwrap().success());
        child.wait_with_output().unwrap()
    }

    pub fn device(&self, arguments: &[&str]) -> Output {
        program::device(&[&["--port", &self.path], arguments].concat())
    }
}

impl Drop for Board {
    fn drop(&mut self) {
        self.done.store(true, Ordering::Relaxed);
        self.thread.take().map(JoinHandle::join).unwrap().unwrap();
    }
}

/// Makes a device that has as much time as it needs on a busy machine. It ticks at every turn of
/// the loop, and its client may be silent for long.
fn simulated() -> SimulatedDevice {
    let mut document = Document::open("step-response").unwrap();
    document.set(&["limits.link_timeout_s=60".into()]).unwrap();
    let plan = Experiment::plan(&document, &["srnf".into()], &[]).unwrap().runs.remove(0);
    let mut simulated = SimulatedDevice::new(&plan).unwrap();
    simulated.ticks(10);
    simulated
}

fn run(manner: Manner, mut master: TTYPort, done: &AtomicBool, progress: &AtomicU32) {
    master.set_timeout(Duration::from_millis(1)).unwrap();
    let (mut simulated, mut armed) = (simulated(), 0);
    let mut deframer = Deframer::default();
    let (mut bytes, mut turn) = ([0; 512], 0u32);
    while !done.load(Ordering::Relaxed) {
        let count = master.read(&mut bytes).unwrap_or(0);
        turn = turn.wrapping_add(1);
        if let Manner::ArmedBy(file) = &manner
            && file.exists()
            && simulated.device.servo().arm_for_link(None).is_ok()
        {
            std::fs::rename(file, file.with_file_name("armed")).unwrap();
        }
        let said: Vec<u8> = match manner {
            Manner::Sound | Manner::PulledWhileArmed(_) | Manner::ArmedBy(_) => {
                simulated.device.receive(&bytes[..count]);
                let is_armed = u32::from(simulated.tick().state == State::Armed);
                armed += is_armed;
                progress.fetch_add(is_armed, Ordering::Relaxed);
                if matches!(manner, Manner::PulledWhileArmed(ticks) if armed > ticks) {
                    return;
                }
                let count = simulated.device.transmit(&mut bytes);
                bytes[..count].to_vec()
            }
            Manner::Later if count > 0 => {
                let identity = Identity {
                    protocol: PROTOCOL + 1,
                    kind: DeviceKind::Board,
                    version: "9.8.7".try_into().unwrap(),
                };
                let reply = NumberedMessage { number: 1, content: Reply::Hello(identity) };
                encode(&Message::Reply(reply)).unwrap().to_vec()
            }
            Manner::Banner if turn.is_multiple_of(20) => b"ok T:21.3 /0.0\r\n".to_vec(),
            Manner::Garbage if turn.is_multiple_of(5) => {
                (0..40).map(|i| (turn.wrapping_mul(2_654_435_761) >> (i % 24)) as u8).collect()
            }
            _ => continue,
        };
        for byte in &said {
            let message = deframer.push(*byte).map(postcard::from_bytes::<Message>);
            let is_sample = matches!(message, Some(Ok(Message::Sample(_))));
            progress.fetch_add(u32::from(is_sample), Ordering::Relaxed);
        }
        let _ = master.write_all(&said);
    }
}
