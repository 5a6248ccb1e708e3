//! A powered board, halted between two instructions until a command advances the time.
//!
//! The emulator runs in its own thread and waits for a command after each command, so that the
//! caller decides when time passes, and every run is the same to the instruction. A command costs
//! some microseconds, and a sample of 20 ms some fifty milliseconds.

use std::sync::mpsc::{Receiver, SyncSender, channel, sync_channel};
use std::thread::JoinHandle;

use rigless::emulator::{Error as HostError, Host, Start, Stop};
use rigless::session::{Reset, Session};
use rigless::soc::Width;
use rigless::time::VirtualNanos;
use stiction::Tick;

use super::board::EmulatedBoard;
use super::coupling::{ImageSample, PlantCoupling};
use super::harness::Harness;
use super::last_tick;
use super::lockstep::Lockstep;
use super::plant_interface::{DrivenPlant, nanoseconds};
use super::setup::BoardSetup;
use super::uart::Uart;
use dynamics::joint::RunJoint;
use files::encoder::Wires;
use files::error::Error;
use simulator::experiment::RunPlan;
use simulator::plant::Plant;

/// The joint of a plan, in lockstep with a board.
pub type PlantInLockstep = Lockstep<DrivenPlant>;

impl Lockstep<DrivenPlant> {
    /// Couples the joint of a plan, at rest.
    ///
    /// # Errors
    /// Returns an error that names the invalid value.
    pub fn of(plan: &RunPlan) -> Result<Self, Error> {
        let plant = DrivenPlant::at_rest(plan)?;
        Ok(Self::new(plant, nanoseconds(plan.machine.sampling.sample_time_s())))
    }
}

/// Powered board that waits for commands.
pub struct BoardUnderTest<C = PlantInLockstep> {
    /// Far end of the board's command link.
    pub uart: Uart,
    /// Channel of the commands; `None` after power-off.
    orders: Option<SyncSender<BoardCommand<C>>>,
    answers: Receiver<()>,
    thread: Option<JoinHandle<Result<PoweredOffBoard<C>, Error>>>,
}

/// State of a board after power-off.
#[derive(Debug)]
pub struct PoweredOffBoard<C> {
    /// Harness, with the observations of the run and the plant on the pins.
    pub harness: Harness<C>,
    /// Resets of the microcontroller: time and cause of each.
    pub resets: Vec<Reset>,
    /// Instructions that the microcontroller ran from power-on to the end.
    pub instructions: u64,
}

/// Action on a halted board.
pub type BoardAction<C> = Box<dyn for<'a> FnOnce(&mut HaltedBoard<'a, C>) + Send>;

/// Command to a halted board.
pub enum BoardCommand<C> {
    /// Execute this action on the board; no time passes.
    Act(BoardAction<C>),
    /// Advance the time until this condition holds.
    Until(StopCondition),
}

/// Condition that ends a stretch of time.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum StopCondition {
    /// The number of samples since power-on.
    Samples(u64),
    /// ns since power-on.
    Time(u64),
    /// The board has sent a frame on its link, or this time is reached, ns since power-on.
    Frame(u64),
    /// The number of counted ticks is reached, or this time, ns since power-on.
    Counted {
        /// Ticks of the core.
        ticks: usize,
        /// ns since power-on.
        or_ns: u64,
    },
}

/// Board that is halted between two instructions.
pub struct HaltedBoard<'a, C = PlantInLockstep> {
    /// Harness, with the observations so far and the plant on the pins.
    pub harness: &'a mut Harness<C>,
    pub(super) session: &'a mut Session<EmulatedBoard>,
    pub(super) host: &'a mut dyn Host,
    pub(super) stop: Stop,
}

impl<C: PlantCoupling> BoardUnderTest<C> {
    /// Turns the power on.
    ///
    /// # Errors
    /// Returns an error if the image cannot be placed in the flash.
    pub fn power_on(setup: BoardSetup, coupling: C) -> Result<Self, Error> {
        let trouble = {
            let (label, path) = (setup.label.clone(), setup.image.path.clone());
            move |why: String| Error::Emulator(format!("{label}, image {}: {why}", path.display()))
        };
        let images = setup.flash().map_err(&trouble)?;
        let (mut board, uart) = (Box::new(EmulatedBoard::new(setup.fitted)?), Uart::default());
        board.connect(&uart);
        let (orders, taken) = sync_channel(0);
        let (answer, answers) = channel();
        let interrupt = setup.interrupt.clone();
        let harness = Harness::new(setup, coupling, uart.clone(), (taken, answer));
        let thread = std::thread::spawn(move || {
            let session = Session::new(board, 0, VirtualNanos(0))
                .map_err(|error| trouble(error.to_string()))?;
            let mut start = Start::new(&images);
            start.interrupt = Some(&interrupt);
            let finished = rigless::emulator::run(session, &start, harness)
                .map_err(|error| trouble(error.to_string()))?;
            let (resets, harness) = (finished.session.resets().to_vec(), finished.driver);
            match (finished.stop, &harness.failed) {
                (_, Some(why)) => Err(trouble(format!("{why}; {}", harness.log.tail()))),
                (None, None) => Err(Error::Interrupted),
                (Some(stop), None) => {
                    Ok(PoweredOffBoard { harness, resets, instructions: stop.instruction_count })
                }
            }
        });
        Ok(Self { uart, orders: Some(orders), answers, thread: Some(thread) })
    }

    /// Advances the time by a number of samples, and returns the last one. The board halts at the
    /// instant at which the plant has received the state of the bridge.
    ///
    /// # Errors
    /// Returns an error if the image cannot continue.
    pub fn samples(&mut self, count: u32) -> Result<ImageSample, Error> {
        let so_far = self.act(|halted| halted.harness.coupling.sampling().samples)?;
        self.until(StopCondition::Samples(so_far + u64::from(count)))?;
        self.act(|halted| halted.harness.coupling.sampling().sample)
    }

    /// Advances the time, ns.
    ///
    /// # Errors
    /// Returns an error if the image cannot continue.
    pub fn pass(&mut self, ns: u64) -> Result<(), Error> {
        let now = self.act(|halted| halted.now())?;
        self.until(StopCondition::Time(now + ns))
    }

    /// Advances the time until the board has sent a frame on its link, by at most `at_most_ns`.
    ///
    /// # Errors
    /// Returns an error if the image cannot continue.
    pub fn listen(&mut self, at_most_ns: u64) -> Result<(), Error> {
        let now = self.act(|halted| halted.now())?;
        self.until(StopCondition::Frame(now + at_most_ns))
    }

    /// Advances the time until a condition holds.
    ///
    /// # Errors
    /// Returns an error if the image cannot continue.
    pub fn until(&mut self, until: StopCondition) -> Result<(), Error> {
        self.order(BoardCommand::Until(until))
    }

    /// Executes an action on the board; no time passes.
    ///
    /// # Errors
    /// Returns an error if the image cannot continue.
    pub fn act<T: Send + 'static>(
        &mut self,
        act: impl for<'a> FnOnce(&mut HaltedBoard<'a, C>) -> T + Send + 'static,
    ) -> Result<T, Error> {
        let (done, result) = channel();
        // The caller waits for it below.
        self.order(BoardCommand::Act(Box::new(move |halted| drop(done.send(act(halted))))))?;
        result.recv().map_err(|_| gone())
    }

    /// Turns the power off.
    ///
    /// # Errors
    /// Returns an error if the run had failed before.
    pub fn off(mut self) -> Result<PoweredOffBoard<C>, Error> {
        self.end()
    }

    fn order(&mut self, order: BoardCommand<C>) -> Result<(), Error> {
        let sent = self.orders.as_ref().is_some_and(|orders| orders.send(order).is_ok());
        if sent && self.answers.recv().is_ok() {
            return Ok(());
        }
        Err(self.end().err().unwrap_or_else(gone))
    }
}

impl<C> BoardUnderTest<C> {
    fn end(&mut self) -> Result<PoweredOffBoard<C>, Error> {
        self.orders = None;
        match self.thread.take().map(JoinHandle::join) {
            Some(Ok(left)) => left,
            Some(Err(_)) | None => Err(gone()),
        }
    }
}

impl<C> Drop for BoardUnderTest<C> {
    fn drop(&mut self) {
        let _ = self.end();
    }
}

impl<C> std::fmt::Debug for BoardUnderTest<C> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let is_on = self.orders.is_some();
        f.debug_struct("BoardUnderTest").field("is_on", &is_on).finish_non_exhaustive()
    }
}

fn gone() -> Error {
    Error::Emulator("the emulated board is powered off".into())
}

impl<C> HaltedBoard<'_, C> {
    /// Returns the time since power-on, ns.
    pub const fn now(&self) -> u64 {
        self.stop.at.0
    }

    /// Returns the board, for access to registers and pins.
    pub fn board(&mut self) -> &mut EmulatedBoard {
        self.session.board_mut()
    }

    /// Returns the resets of the microcontroller: time and cause of each.
    pub fn resets(&self) -> &[Reset] {
        self.session.resets()
    }

    /// Reads a register of a peripheral; `None` if the peripheral has no clock.
    pub fn register(&mut self, address: u64) -> Option<u32> {
        let at = self.stop.at;
        self.board().peek(at, address)
    }

    /// Writes a register of a peripheral, as a debugger does.
    pub fn set_register(&mut self, address: u64, value: u32) {
        let at = self.stop.at;
        self.board().poke(at, address, value);
    }

    /// Reads the last tick that the image has computed.
    ///
    /// # Errors
    /// Returns an error if the emulator refuses to read its own memory.
    pub fn last_tick(&mut self) -> Result<Tick, Error> {
        last_tick::read(self.host, self.harness.image.last_tick).map_err(refused)
    }

    /// Reads words of the RAM.
    ///
    /// # Errors
    /// Returns an error if there is no RAM at the address.
    pub fn words(&mut self, address: u64, count: u64) -> Result<Vec<u32>, Error> {
        let word = |index| self.host.read(address + 4 * index, Width::W32).map(|word| word as u32);
        (0..count).map(word).collect::<Result<_, _>>().map_err(refused)
    }

    /// Changes a word of the RAM.
    ///
    /// # Errors
    /// Returns an error if there is no RAM at the address.
    pub fn overwrite(&mut self, address: u64, word: u32) -> Result<(), Error> {
        self.host.write(address, Width::W32, word.into()).map_err(refused)
    }
}

impl HaltedBoard<'_> {
    /// Returns the joint.
    pub const fn plant(&mut self) -> &mut Plant<RunJoint> {
        &mut self.harness.coupling.plant.plant
    }

    /// Cuts, swaps or restores the wires of the load's encoder, if there are two.
    pub fn rewire_load(&mut self, wires: Wires) {
        self.harness.coupling.rewire_load(wires, self.session.board_mut(), self.stop.at);
    }

    /// Cuts, swaps or restores the wires of the encoder: of two, that of the motor.
    pub fn rewire(&mut self, wires: Wires) {
        self.harness.coupling.rewire(wires, self.session.board_mut(), self.stop.at);
    }

    /// Puts noise on the encoder's wires: a number of edges before the next tick.
    pub fn jump(&mut self, counts: i32) {
        self.harness.coupling.jump(counts, self.stop.at);
    }

    /// Sets position (deg) and velocity (deg/s) of the joint, as if it was moved by hand.
    pub fn push(&mut self, position_deg: f64, velocity_deg_per_s: f64) {
        self.plant().push(position_deg, velocity_deg_per_s);
        self.harness.coupling.replan(self.stop.at);
    }
}

fn refused(error: HostError) -> Error {
    Error::Emulator(error.to_string())
}
