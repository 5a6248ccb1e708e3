//! A board that is on, held between two instructions until somebody lets time pass.
//!
//! The emulator runs in a thread of its own and waits at every order's end for the next one, so that whoever holds the
//! board decides when time passes, and every run is the same to the instruction.

use std::sync::Arc;
use std::sync::mpsc::{Receiver, SyncSender, channel, sync_channel};
use std::thread::JoinHandle;

use rigless::emulator::{AccessKind, Driver, Error as HostError, Host, Settled, Start, Stop};
use rigless::session::{Reset, Session};
use rigless::soc::Width;
use rigless::time::VirtualNanos;
use stiction::Tick;

use super::bench::Mishap;
use super::board::{EmulatedBoard, Fitted};
use super::guard::Guard;
use super::image::FirmwareImage;
use super::in_the_loop::{TIM2_CNT, flash};
use super::last_tick;
use super::log::Log;
use super::rig::{Rig, Sample};
use super::spans::Spans;
use super::uart::Uart;
use crate::device::simulated::Wires;
use crate::error::Error;
use crate::experiment::RunPlan;

/// A board with power and a joint.
pub struct Powered {
    /// The far end of its command link.
    pub uart: Uart,
    /// None when it is over.
    orders: Option<SyncSender<Order>>,
    answers: Receiver<()>,
    thread: Option<JoinHandle<Result<Left, Error>>>,
}

/// What is left of a board without power.
#[derive(Debug)]
pub struct Left {
    /// The joint, and what has been seen.
    pub rig: Rig,
    /// When the part was reset, and by what.
    pub resets: Vec<Reset>,
}

enum Order {
    Act(Box<dyn for<'a> FnOnce(&mut Held<'a>) + Send>),
    Until(Until),
}

/// Until when time passes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Until {
    /// So many samples have been seen since power-on.
    Samples(u64),
    /// ns since power-on.
    Time(u64),
    /// The board has said something on its link, or this time has come, ns since power-on.
    Frame(u64),
}

/// The board between two instructions.
pub struct Held<'a> {
    /// The joint and what has been seen.
    pub rig: &'a mut Rig,
    session: &'a mut Session<EmulatedBoard>,
    host: &'a mut dyn Host,
    stop: Stop,
    image: &'a FirmwareImage,
}

impl Powered {
    /// Power comes up. `records` are the contents of the two parameter sectors; one without any is erased. The joint is
    /// that of the plan.
    ///
    /// # Errors
    /// If the image cannot be placed, or a value of the plan is not allowed.
    pub fn on(
        image: &Arc<FirmwareImage>,
        records: [Option<&[u8]>; 2],
        fitted: Fitted,
        plan: &RunPlan,
    ) -> Result<Self, Error> {
        let trouble = {
            let path = image.path.clone();
            move |why: String| Error::Emulator(format!("{}: {why}", path.display()))
        };
        let images = flash(image, records).map_err(&trouble)?;
        let rig = Rig::new(plan, Log::new(image.clone(), &plan.label, None))?;
        let (mut board, uart) = (Box::new(EmulatedBoard::new(fitted)?), Uart::default());
        board.connect(&uart);
        let (orders, taken) = sync_channel(0);
        let (answer, answers) = channel();
        let hands = Hands {
            rig,
            orders: taken,
            answer,
            until: None,
            resets: 0,
            guard: Guard::default(),
            image: image.clone(),
            uart: uart.clone(),
            failed: None,
        };
        let thread = std::thread::spawn(move || {
            let session =
                Session::new(board, 0, VirtualNanos(0)).map_err(|error| trouble(error.to_string()))?;
            let finished = rigless::emulator::run(session, &Start::new(&images), hands)
                .map_err(|error| trouble(error.to_string()))?;
            let resets = finished.session.resets().to_vec();
            match finished.driver {
                Hands { failed: Some(why), .. } => Err(trouble(why)),
                Hands { rig, .. } => Ok(Left { rig, resets }),
            }
        });
        Ok(Self { uart, orders: Some(orders), answers, thread: Some(thread) })
    }

    /// Lets so many samples pass, and returns the last one. Time stands still at the instant at which the joint has got
    /// what is on the bridge.
    ///
    /// # Errors
    /// If the image cannot go on.
    pub fn samples(&mut self, count: u32) -> Result<Sample, Error> {
        let so_far = self.act(|held| held.rig.samples())?;
        self.order(Order::Until(Until::Samples(so_far + u64::from(count))))?;
        self.act(|held| held.rig.sample())
    }

    /// Lets time pass, ns.
    ///
    /// # Errors
    /// If the image cannot go on.
    pub fn pass(&mut self, ns: u64) -> Result<(), Error> {
        let now = self.act(|held| held.now())?;
        self.order(Order::Until(Until::Time(now + ns)))
    }

    /// Lets time pass until the board has sent a frame on its link, ns at most.
    ///
    /// # Errors
    /// If the image cannot go on.
    pub fn listen(&mut self, at_most_ns: u64) -> Result<(), Error> {
        let now = self.act(|held| held.now())?;
        self.order(Order::Until(Until::Frame(now + at_most_ns)))
    }

    /// Does something to the board; no time passes.
    ///
    /// # Errors
    /// If the image cannot go on.
    pub fn act<T: Send + 'static>(
        &mut self,
        act: impl for<'a> FnOnce(&mut Held<'a>) -> T + Send + 'static,
    ) -> Result<T, Error> {
        let (done, result) = channel();
        // There is somebody who waits for it.
        self.order(Order::Act(Box::new(move |held| drop(done.send(act(held))))))?;
        result.recv().map_err(|_| gone())
    }

    /// Power goes.
    ///
    /// # Errors
    /// If something had gone wrong before.
    pub fn off(mut self) -> Result<Left, Error> {
        self.end()
    }

    fn order(&mut self, order: Order) -> Result<(), Error> {
        let sent = self.orders.as_ref().is_some_and(|orders| orders.send(order).is_ok());
        if sent && self.answers.recv().is_ok() {
            return Ok(());
        }
        Err(self.end().err().unwrap_or_else(gone))
    }

    fn end(&mut self) -> Result<Left, Error> {
        self.orders = None;
        match self.thread.take().map(JoinHandle::join) {
            Some(Ok(left)) => left,
            Some(Err(_)) | None => Err(gone()),
        }
    }
}

impl Drop for Powered {
    fn drop(&mut self) {
        let _ = self.end();
    }
}

impl std::fmt::Debug for Powered {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Powered").field("is_on", &self.orders.is_some()).finish_non_exhaustive()
    }
}

fn gone() -> Error {
    Error::Emulator("the emulated board has no power any more".into())
}

impl Held<'_> {
    /// Time since power-on, ns.
    pub const fn now(&self) -> u64 {
        self.stop.at.0
    }

    /// Instructions since power-on.
    pub const fn instructions(&self) -> u64 {
        self.stop.instruction_count
    }

    /// Registers and pins.
    pub fn board(&mut self) -> &mut EmulatedBoard {
        self.session.board_mut()
    }

    /// Lets something happen to the board.
    pub fn mishap(&mut self, mishap: Mishap) {
        mishap.happen(self.session, &self.stop, self.host);
        self.rig.spans.look(self.session.board_mut(), self.stop.at);
    }

    /// Something happens to the encoder's wires.
    pub fn rewire(&mut self, wires: Wires) {
        self.rig.rewire(wires, self.session.board_mut(), self.stop.at);
    }

    /// Noise on the encoder's wires: so many edges more before the next tick.
    pub fn jump(&mut self, counts: i32) {
        self.rig.jump(counts, self.stop.at);
    }

    /// The joint is put somewhere, by hand.
    pub fn push(&mut self, position_deg: f64, velocity_deg_per_s: f64) {
        self.rig.push(position_deg, velocity_deg_per_s, self.stop.at);
    }

    /// What the image computed in its last tick.
    ///
    /// # Errors
    /// If the emulator refuses to read its own memory.
    pub fn last_tick(&mut self) -> Result<Tick, Error> {
        last_tick::read(self.host, self.image.last_tick).map_err(refused)
    }

    /// Words of the RAM.
    ///
    /// # Errors
    /// If there is none.
    pub fn words(&mut self, address: u64, count: u64) -> Result<Vec<u32>, Error> {
        let word = |index| self.host.read(address + 4 * index, Width::W32).map(|word| word as u32);
        (0..count).map(word).collect::<Result<_, _>>().map_err(refused)
    }

    /// Changes a word of the RAM.
    ///
    /// # Errors
    /// If there is none.
    pub fn overwrite(&mut self, address: u64, word: u32) -> Result<(), Error> {
        self.host.write(address, Width::W32, word.into()).map_err(refused)
    }

    /// What has been seen of the bridge.
    pub const fn spans(&self) -> &Spans {
        &self.rig.spans
    }
}

fn refused(error: HostError) -> Error {
    Error::Emulator(error.to_string())
}

/// The one end of the thread: it does what it is told.
struct Hands {
    rig: Rig,
    orders: Receiver<Order>,
    answer: std::sync::mpsc::Sender<()>,
    until: Option<Until>,
    /// How many have been seen.
    resets: usize,
    guard: Guard,
    image: Arc<FirmwareImage>,
    uart: Uart,
    failed: Option<String>,
}

impl Hands {
    fn is_there(&self, at: VirtualNanos) -> bool {
        match self.until {
            None => true,
            Some(Until::Samples(samples)) => self.rig.samples() >= samples,
            Some(Until::Time(ns)) => at.0 >= ns,
            Some(Until::Frame(ns)) => at.0 >= ns || self.uart.has_frame(),
        }
    }

    fn next(&self) -> VirtualNanos {
        let next = self.rig.next();
        match self.until {
            Some(Until::Time(ns) | Until::Frame(ns)) => next.min(VirtualNanos(ns)),
            _ => next,
        }
    }

    /// Does what it is told until that is to let time pass; false if there is nobody any more.
    fn obey(&mut self, session: &mut Session<EmulatedBoard>, stop: &Stop, host: &mut dyn Host) -> bool {
        while self.is_there(stop.at) {
            if self.until.take().is_some() && self.answer.send(()).is_err() {
                return false;
            }
            match self.orders.recv() {
                Ok(Order::Until(until)) => self.until = Some(until),
                Ok(Order::Act(act)) => {
                    let (rig, image) = (&mut self.rig, &*self.image);
                    act(&mut Held { rig, session, host, stop: *stop, image });
                    if self.answer.send(()).is_err() {
                        return false;
                    }
                }
                Err(_) => return false,
            }
        }
        true
    }
}

impl Driver<EmulatedBoard> for Hands {
    fn on_settled(&mut self, session: &mut Session<EmulatedBoard>, host: &mut dyn Host, settled: Settled) {
        match settled {
            Settled::Access { access, .. } => {
                self.guard.see(&access);
                match access.kind {
                    AccessKind::Write => {
                        self.rig.spans.look(session.board_mut(), access.virtual_time);
                    }
                    _ if access.address == TIM2_CNT => {
                        self.rig.counter_read(session.board_mut(), access.virtual_time);
                        session.run_until(self.next());
                    }
                    _ => {}
                }
            }
            Settled::Stop(stop) => {
                let board = session.board_mut();
                board.settle();
                self.rig.spans.look(board, stop.at);
                if session.resets().len() > self.resets {
                    self.resets = session.resets().len();
                    self.rig.reset(session.board_mut(), stop.at);
                    // A reset ends a stall, whatever it came from.
                    host.hold(false);
                }
                if let Some(Until::Frame(_)) = self.until
                    && self.is_there(stop.at)
                {
                    session.run_until(stop.at);
                }
            }
            _ => {}
        }
    }

    fn on_stop(
        &mut self,
        session: &mut Session<EmulatedBoard>,
        stop: Stop,
        host: &mut dyn Host,
    ) -> Option<VirtualNanos> {
        if let Err(error) = self.rig.act(session.board_mut(), host, stop.at) {
            self.failed = Some(error.to_string());
        } else if let Some(why) = self.guard.polling(&self.image) {
            self.failed = Some(format!("{why}; {}", self.rig.log.tail()));
        }
        if self.failed.is_some() || !self.obey(session, &stop, host) {
            // The last words are often the ones that matter, and there is nobody to tell if they cannot be read.
            let _ = self.rig.log.drain(host, stop.at);
            return None;
        }
        Some(self.next())
    }
}
