//! Image and core side by side: every tick of both, compared bit for bit.
//!
//! The output of the image drives the plant. The core runs beside it to find the first tick with a
//! difference in any term. In lockstep the two are a [`Target`]. In free-running the
//! microcontroller determines the time, and the host follows.

use std::sync::Arc;
use std::sync::atomic::{AtomicU32, Ordering};

use rigless::device::ResetCause;
use rigless::session::Reset;
use stiction::Tick;
use stiction::control::drive::Duty;
use stiction::control::encoder::CounterBits;
use stiction::identification::RampFindings;

use super::board_under_test::{BoardUnderTest, PoweredOffBoard};
use super::compare::{Difference, same_bits};
use super::coupling::{ImageSample, PlantCoupling};
use super::free_running::FreeRunning;
use super::guard::Guard;
use super::image::FirmwareImage;
use super::lockstep::Lockstep;
use super::log::LogLine;
use super::plant_interface::{FreeDiscs, PowerStage, nanoseconds};
use super::setup::BoardSetup;
use dynamics::solver::AxisSolver;
use files::error::Error;
use simulator::closed_loop::ClosedLoop;
use simulator::counters::Counters;
use simulator::plant::{DelayLine, Discs};
use simulator::run::Recording;
use simulator::target::{BareLoop, Target};

/// Reason of an early end of a run.
#[derive(Debug)]
enum Stopped {
    /// A tick of the firmware's image differs from the same tick of the core on the host.
    Differs(Box<Difference>),
    /// The microcontroller misbehaves. The text ends a message that begins with "image ...:".
    Misbehaves(String),
    /// The emulated board cannot continue.
    Board(Error),
}

impl From<Error> for Stopped {
    fn from(error: Error) -> Self {
        Self::Board(error)
    }
}

fn misbehaves<T>(why: impl Into<String>) -> Result<T, Stopped> {
    Err(Stopped::Misbehaves(why.into()))
}

/// One sample of an image.
#[derive(Debug)]
struct Seen {
    sample: ImageSample,
    /// Last tick that the image has computed.
    image: Tick,
    /// First reset of the microcontroller since power-on.
    reset: Option<Reset>,
    now_ns: u64,
}

/// Advances a board by one sample, and returns it.
fn next_sample<C: PlantCoupling>(board: &mut BoardUnderTest<C>) -> Result<Seen, Error> {
    board.samples(1)?;
    board.act(|halted| {
        let (sample, reset) = (halted.harness.coupling.sampling().sample, halted.resets().first());
        let reset = reset.copied();
        Ok(Seen { sample, reset, image: halted.last_tick()?, now_ns: halted.now() })
    })?
}

/// Waits until a board drives its bridge, and returns the first sample in which it does. Calls
/// `on_first_tick` at the first tick.
fn armed<C: PlantCoupling>(
    board: &mut BoardUnderTest<C>,
    closed_loop: &ClosedLoop,
    mut on_first_tick: impl FnMut(&mut BoardUnderTest<C>) -> Result<(), Error>,
) -> Result<Seen, Stopped> {
    let mut has_ticked = false;
    loop {
        let seen = next_sample(board)?;
        not_reset(seen.reset)?;
        if !has_ticked && seen.sample.clock.is_some() {
            has_ticked = true;
            on_first_tick(board)?;
        }
        if seen.sample.bridge.is_on() && seen.sample.clock.is_some() {
            let (found, top) = (seen.sample.bridge.top, closed_loop.controller.drive().pwm_top());
            let unconnected = board
                .act(|halted| halted.harness.coupling.encoders().unconnected(halted.board()))?;
            if let Some(why) = unconnected {
                return misbehaves(why);
            }
            if found != top {
                return misbehaves(format!(
                    "its PWM counts up to {found}, but drive.pwm_hz needs {top}"
                ));
            }
            return Ok(seen);
        }
        if seen.now_ns >= Guard::boot_limit().0 {
            return misbehaves(Guard::not_armed());
        }
    }
}

fn not_reset(reset: Option<Reset>) -> Result<(), Stopped> {
    let Some(reset) = reset else { return Ok(()) };
    let by = match reset.cause {
        ResetCause::Core => "itself",
        ResetCause::Model(instance) => instance,
        ResetCause::Pin => "its reset pin",
        _ => "power",
    };
    let at_s = reset.at.0 as f64 * 1e-9;
    misbehaves(format!("the part was reset by {by} after {at_s:.6} s"))
}

/// Rejects a sample that deviates from the sample time by more than a hundredth plus 2 us, which
/// are for a delayed interrupt.
fn on_time(since_ns: u64, sample_ns: u64) -> Result<(), Stopped> {
    if since_ns.abs_diff(sample_ns) <= sample_ns / 100 + 2_000 {
        return Ok(());
    }
    let (found, asked) = (since_ns as f64 * 1e-6, sample_ns as f64 * 1e-6);
    misbehaves(format!("its sample time is {found} ms instead of {asked} ms"))
}

/// The core that runs beside an image.
#[derive(Debug)]
struct Beside<'a> {
    closed_loop: &'a ClosedLoop,
    core: BareLoop<'a>,
    /// Position at which the image was armed, in the host's counts; in the image's it is zero.
    start: i32,
    /// Ticks of the motion so far.
    ticks: usize,
    /// Start of the last tick, ns.
    at_ns: u64,
    /// Ticks of the motion so far, for a progress bar.
    progress: &'a AtomicU32,
}

impl<'a> Beside<'a> {
    /// Creates the core at the first tick of the motion, with the joint at rest at `start` counts.
    fn new(
        closed_loop: &'a ClosedLoop,
        first: &ImageSample,
        start: i32,
        progress: &'a AtomicU32,
    ) -> Self {
        let ClosedLoop { controller, course, .. } = closed_loop;
        let core = BareLoop::new(controller, course, counters(first).position, start);
        Self { closed_loop, core, start, ticks: 0, at_ns: first.at_ns, progress }
    }

    /// Returns the host's time of the next tick since the start of the motion, s.
    fn time_s(&self) -> f64 {
        self.ticks as f64 * self.closed_loop.sample_time_s
    }

    /// Rejects a sample without a tick, or at a wrong time.
    fn has_come(&mut self, seen: &Seen) -> Result<(), Stopped> {
        not_reset(seen.reset)?;
        let ticks = self.ticks;
        if seen.sample.clock.is_none() {
            return misbehaves(format!("its control tick has stopped after {ticks} ticks"));
        }
        if ticks > 0 {
            let since_ns = seen.sample.at_ns - self.at_ns;
            on_time(since_ns, nanoseconds(self.closed_loop.sample_time_s))?;
        }
        self.at_ns = seen.sample.at_ns;
        Ok(())
    }

    /// Compares a tick of the image with that of the core; `None` after the end of a ramp.
    fn compare(&mut self, seen: &Seen) -> Result<Option<Tick>, Stopped> {
        let (time_s, bridge) = (self.time_s(), &seen.sample.bridge);
        let (host, is_over) = self.core.follow(counters(&seen.sample));
        if bridge.is_on() == is_over {
            return misbehaves(if is_over {
                format!("its bridge is still on at {time_s} s, when its ramp is over")
            } else {
                format!("it has turned its bridge off at {time_s} s")
            });
        }
        // Positions are in the host's counts: exact, since they are whole counts that wrap. The
        // duty is that of the pins, and must be the computed one. The status is set by the servo,
        // which the bare loop does not have.
        let Duty { compare, reverse } = bridge.duty(self.closed_loop.controller.drive().mode());
        let image = Tick {
            counts: seen.image.counts.wrapping_add(self.start),
            reference_counts: seen.image.reference_counts.wrapping_add(self.start),
            compare,
            reverse,
            status: 0,
            current: 0.0,
            ..seen.image
        };
        if !same_bits(&host, &image) {
            let (index, host, image) = (self.ticks, Some(host), Some(image));
            return Err(Stopped::Differs(Box::new(Difference { index, host, image })));
        }
        self.ticks += 1;
        self.progress.store(self.ticks as u32, Ordering::Relaxed);
        Ok((!is_over).then_some(image))
    }
}

/// Image and core in lockstep with a plant that the host moves.
#[derive(Debug)]
struct SideBySide<'a> {
    board: &'a mut BoardUnderTest<Lockstep<FreeDiscs>>,
    beside: Beside<'a>,
    discs: Discs,
    /// First tick of the motion, until it has been compared.
    first: Option<Seen>,
    stopped: Result<(), Stopped>,
}

impl SideBySide<'_> {
    /// Turns the discs to the positions at which the counters have these readings, and waits for
    /// the next sample.
    fn turned_to(&mut self, Counters { position, motor }: Counters) -> Result<Seen, Stopped> {
        let ClosedLoop { encoder, motor_encoder, .. } = self.beside.closed_loop;
        let Discs { first, load, .. } = &mut self.discs;
        if let (Some(load), Some(motor)) = (load, motor) {
            *load += edges(position, *load, encoder.counter_bits);
            let bits = motor_encoder.map_or(CounterBits::ThirtyTwo, |motor| motor.counter_bits);
            *first += edges(motor, *first, bits);
        } else {
            *first += edges(position, *first, encoder.counter_bits);
        }
        turn(self.board, self.discs)?;
        Ok(next_sample(self.board)?)
    }

    fn step(&mut self, counters: Counters) -> Result<Option<Tick>, Stopped> {
        let seen = match self.first.take() {
            Some(first) => first,
            None => self.turned_to(counters)?,
        };
        self.beside.has_come(&seen)?;
        let (ImageSample { counter, shown, .. }, disc) = (seen.sample, self.discs.first);
        if self.beside.ticks > 0 {
            if shown != self.discs {
                return misbehaves("it has ticked before the encoder's edges were over");
            }
            if counter != disc as u32 {
                let (time_s, found) = (self.beside.time_s(), counter as i32);
                return misbehaves(format!(
                    "its encoder counter reads {found} at {time_s} s, and the disc is at {disc}: \
                     the edges come faster than its input filter passes them, or the wires are \
                     swapped"
                ));
            }
        }
        self.beside.compare(&seen)
    }
}

impl Target for SideBySide<'_> {
    fn tick(&mut self, counters: Counters) -> Option<Tick> {
        match self.step(counters) {
            Ok(tick) => tick,
            Err(stopped) => {
                self.stopped = Err(stopped);
                None
            }
        }
    }
}

/// Returns the readings of the counters in a sample. The counter of the load's encoder has those of
/// its wires: the image reads it at the same instant, and a wrong reading is a difference.
fn counters(sample: &ImageSample) -> Counters {
    let ImageSample { counter, shown: Discs { load, .. }, .. } = *sample;
    match load {
        Some(load) => Counters { position: load as u32, motor: Some(counter) },
        None => Counters::one(counter),
    }
}

/// Returns the edges from a disc to the position at which its counter reads `counter`.
fn edges(counter: u32, disc: i64, counter_bits: CounterBits) -> i64 {
    let edges = counter.wrapping_sub(disc as u32);
    match counter_bits {
        CounterBits::Sixteen => i64::from(edges as u16 as i16),
        CounterBits::ThirtyTwo => i64::from(edges as i32),
    }
}

/// Turns the discs of a halted board.
fn turn(board: &mut BoardUnderTest<Lockstep<FreeDiscs>>, discs: Discs) -> Result<(), Error> {
    board.act(move |halted| {
        let coupling = &mut halted.harness.coupling;
        coupling.plant = FreeDiscs(discs);
        coupling.replan(halted.stop.at);
    })
}

/// Results of a run in addition to its recording.
#[derive(Debug)]
pub(super) struct Ran<S> {
    /// Joint at the end of the run.
    pub solver: S,
    /// Friction levels found by a ramp.
    pub found: RampFindings,
    /// Log of the firmware.
    pub log: Vec<LogLine>,
    /// Latencies of a free-running run, ns: from each read of the counter until the duty of that
    /// tick takes effect.
    pub latencies_ns: Vec<u64>,
    /// Instructions from power-on to the end.
    pub instructions: u64,
}

/// Runs an image in lockstep with the plant of a recording, from power-on to the last sample, and
/// counts the ticks in `progress`.
///
/// # Errors
/// Returns an error if the image cannot be placed in the flash, hangs, turns its bridge off, or
/// differs from the core.
pub(super) fn in_lockstep<S: AxisSolver>(
    setup: BoardSetup,
    recording: &mut Recording<'_>,
    solver: S,
    progress: &AtomicU32,
) -> Result<Ran<S>, Error> {
    let around = recording.closed_loop.clone();
    let mut plant = around.plant(solver);
    let (explain, discs) = (Explanation::of(&setup), plant.discs());
    let at_zero = Discs {
        first: 0,
        load: discs.load.map(|load| if discs.is_absolute { load } else { 0 }),
        is_absolute: discs.is_absolute,
    };
    let coupling = Lockstep::new(FreeDiscs(at_zero), nanoseconds(around.sample_time_s));
    let mut board = BoardUnderTest::power_on(setup, coupling)?;
    let counts = plant.counts();
    let found = armed(&mut board, &around, |board| turn(board, discs)).and_then(|first| {
        let mut target = SideBySide {
            board: &mut board,
            beside: Beside::new(&around, &first.sample, counts, progress),
            discs,
            first: Some(first),
            stopped: Ok(()),
        };
        recording.step(&mut target, &mut plant);
        target.stopped.map(|()| target.beside.core.state.ramp().findings())
    });
    let (found, left) = explain.end(found, board)?;
    let PoweredOffBoard { harness, instructions, .. } = left;
    let log = harness.log.lines;
    Ok(Ran { solver: plant.solver, found, log, latencies_ns: Vec::new(), instructions })
}

/// Runs an image in free-running, otherwise as [`in_lockstep`].
///
/// # Errors
/// As [`in_lockstep`].
pub(super) fn in_free_running<S>(
    setup: BoardSetup,
    recording: &mut Recording<'_>,
    (solver, stage): (S, PowerStage),
    progress: &AtomicU32,
) -> Result<Ran<S>, Error>
where
    S: AxisSolver + Clone + Send + std::fmt::Debug + 'static,
{
    let around = recording.closed_loop.clone();
    let plant = around.plant(solver);
    let (explain, counts) = (Explanation::of(&setup), plant.counts());
    let coupling = FreeRunning::new(plant, stage, nanoseconds(around.sample_time_s));
    let mut board = BoardUnderTest::power_on(setup, coupling)?;
    let found = armed(&mut board, &around, |_| Ok(())).and_then(|first| {
        let mut beside = Beside::new(&around, &first.sample, counts, progress);
        follow(&mut board, &mut beside, recording, first)?;
        Ok(beside.core.state.ramp().findings())
    });
    let (found, PoweredOffBoard { harness, instructions, .. }) = explain.end(found, board)?;
    let FreeRunning { plant, events, latencies_ns, .. } = harness.coupling;
    recording.events = events;
    let log = harness.log.lines;
    Ok(Ran { solver: plant.solver, found, log, latencies_ns, instructions })
}

/// Records every tick of the motion.
fn follow<S>(
    board: &mut BoardUnderTest<FreeRunning<S>>,
    beside: &mut Beside<'_>,
    recording: &mut Recording<'_>,
    mut seen: Seen,
) -> Result<(), Stopped>
where
    S: AxisSolver + Clone + Send + std::fmt::Debug + 'static,
{
    let around = beside.closed_loop;
    let mut delay = DelayLine::new(around.delay);
    loop {
        beside.has_come(&seen)?;
        let time_s = beside.time_s();
        let joint = board.act(|halted| halted.harness.coupling.at_tick.clone())?;
        if !(joint.position().is_finite() && joint.velocity().is_finite()) {
            recording.diverged_at_s = Some(time_s);
            return Ok(());
        }
        let Some(tick) = beside.compare(&seen)? else { return Ok(()) };
        let applied_v = f64::from(delay.put(tick.code)) * around.lsb_v;
        recording.trace.push(&around.moment(time_s, tick, applied_v, &joint));
        if beside.ticks > recording.samples as usize {
            return Ok(());
        }
        seen = next_sample(board)?;
    }
}

/// Run and image, for error messages.
struct Explanation {
    label: String,
    image: Arc<FirmwareImage>,
}

impl Explanation {
    fn of(setup: &BoardSetup) -> Self {
        Self { label: setup.label.clone(), image: setup.image.clone() }
    }

    /// Turns the power off. If the run ended too early, returns an error with the reason.
    fn end<T, C: PlantCoupling>(
        &self,
        ran: Result<T, Stopped>,
        board: BoardUnderTest<C>,
    ) -> Result<(T, PoweredOffBoard<C>), Error> {
        let why = match ran {
            Ok(found) => return Ok((found, board.off()?)),
            Err(Stopped::Board(error)) => return Err(error),
            // One cause is no mistake in the code: an image built from other sources of the same
            // version.
            Err(Stopped::Differs(difference)) => {
                let commit = &self.image.note.commit;
                format!("the image is of commit {commit}; {}", difference.to_string().trim_end())
            }
            Err(Stopped::Misbehaves(why)) => {
                format!("{why}; {}", board.off()?.harness.log.tail())
            }
        };
        let Self { label, image } = self;
        Err(Error::Emulator(format!("{label}, image {}: {why}", image.path.display())))
    }
}
