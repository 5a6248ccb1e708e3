//! The only harness of the emulated microcontroller: it acts at its accesses and at its stops.
//!
//! The harness detects a tick by its read of the encoder's counter. The coupling acts between two
//! ticks. The harness observes bridge, log, link, resets and counted instructions for every caller
//! ([`BoardUnderTest`](super::board_under_test::BoardUnderTest)).

use std::sync::Arc;
use std::sync::mpsc::{Receiver, Sender};

use rigless::emulator::{Access, AccessKind, Driver, Error as HostError, Host, Settled, Stop};
use rigless::session::Session;
use rigless::time::{NO_DEADLINE, VirtualNanos};

use super::board::{EmulatedBoard, TIM11_CCR1};
use super::board_under_test::{BoardCommand, HaltedBoard, StopCondition};
use super::bridge::BridgeInputs;
use super::coupling::PlantCoupling;
use super::guard::Guard;
use super::image::FirmwareImage;
use super::log::FirmwareLog;
use super::probe::Probe;
use super::setup::{BoardSetup, Partner};
use super::spans::Spans;
use super::uart::Uart;

const TIM2_CNT: u64 = 0x4000_0024;
const TIM1_CCR1: u64 = 0x4001_0034;
/// Interval at which a partner is called, ns.
const PARTNER_EVERY_NS: u64 = 50_000;

/// State of one emulated microcontroller as seen from outside.
pub struct Harness<C> {
    /// Coupling of the microcontroller with the plant on its pins.
    pub coupling: C,
    /// Spans of time in which the bridge was on.
    pub spans: Spans,
    /// Times at which the image read the encoder, ns since power-on: early in each control tick.
    pub ticks_ns: Vec<u64>,
    /// Log of the firmware so far.
    pub log: FirmwareLog,
    /// Counters of instructions, if the setup has points to count.
    pub probe: Option<Probe>,
    /// Program of the microcontroller.
    pub image: Arc<FirmwareImage>,
    /// Reason why the run cannot continue.
    pub failed: Option<String>,
    /// Whether to pull the break input low for an instant when the bridge is about to be driven.
    pub breaks_at_arming: bool,
    guard: Option<Guard>,
    uart: Uart,
    partner: Option<Partner>,
    partner_at: VirtualNanos,
    drain_at: VirtualNanos,
    drain_every_ns: u64,
    /// Number of resets so far.
    resets: usize,
    orders: Receiver<BoardCommand<C>>,
    answer: Sender<()>,
    until: Option<StopCondition>,
}

impl<C: PlantCoupling> Harness<C> {
    /// Creates the harness of a microcontroller that is about to start.
    pub fn new(
        setup: BoardSetup,
        coupling: C,
        uart: Uart,
        ends: (Receiver<BoardCommand<C>>, Sender<()>),
    ) -> Self {
        Self {
            coupling,
            spans: Spans::default(),
            ticks_ns: Vec::new(),
            log: FirmwareLog::new(setup.image.clone(), &setup.label, setup.listener),
            probe: setup.points.map(Probe::new),
            image: setup.image,
            failed: None,
            breaks_at_arming: false,
            guard: setup.is_guarded.then(Guard::default),
            uart,
            partner_at: if setup.partner.is_some() { VirtualNanos(0) } else { NO_DEADLINE },
            partner: setup.partner,
            drain_at: VirtualNanos(setup.drain_every_ns),
            drain_every_ns: setup.drain_every_ns,
            resets: 0,
            orders: ends.0,
            answer: ends.1,
            until: None,
        }
    }

    /// Returns the next instant at which the harness has to act.
    fn next(&self) -> VirtualNanos {
        let next = self.coupling.next().min(self.drain_at).min(self.partner_at);
        match self.until {
            Some(StopCondition::Time(ns) | StopCondition::Frame(ns)) => next.min(VirtualNanos(ns)),
            _ => next,
        }
    }

    /// Executes all that is due at a stop, except the next command.
    fn act(
        &mut self,
        board: &mut EmulatedBoard,
        host: &mut dyn Host,
        at: VirtualNanos,
    ) -> Result<(), HostError> {
        if at.0 == 0
            && let Some(probe) = &self.probe
        {
            probe.attach(host)?;
        }
        if let Some(partner) = &mut self.partner
            && self.partner_at <= at
        {
            self.partner_at = VirtualNanos(at.0 + PARTNER_EVERY_NS);
            self.uart.send(&partner(at.0, &self.uart.receive()));
        }
        if self.drain_at <= at {
            self.drain_at = VirtualNanos(at.0 + self.drain_every_ns);
            self.log.drain(host, at)?;
        }
        if self.coupling.next() <= at {
            self.coupling.act(board, at);
            self.spans.look(board, at);
        }
        Ok(())
    }

    /// Returns whether the command that advances the time is done.
    fn is_there(&self, at: VirtualNanos) -> bool {
        match self.until {
            None => true,
            Some(StopCondition::Samples(samples)) => self.coupling.sampling().samples >= samples,
            Some(StopCondition::Time(ns)) => at.0 >= ns,
            Some(StopCondition::Frame(ns)) => at.0 >= ns || self.uart.has_frame(),
            Some(StopCondition::Counted { ticks, or_ns }) => {
                at.0 >= or_ns || self.probe.as_ref().is_none_or(|probe| probe.ticks.len() >= ticks)
            }
        }
    }

    /// Executes commands until one advances the time. Returns false if the caller has ended.
    fn obey(
        &mut self,
        session: &mut Session<EmulatedBoard>,
        stop: &Stop,
        host: &mut dyn Host,
    ) -> bool {
        while self.is_there(stop.at) {
            if self.until.take().is_some() && self.answer.send(()).is_err() {
                return false;
            }
            match self.orders.recv() {
                Ok(BoardCommand::Until(until)) => self.until = Some(until),
                Ok(BoardCommand::Act(act)) => {
                    act(&mut HaltedBoard { harness: self, session, host, stop: *stop });
                    if self.answer.send(()).is_err() {
                        return false;
                    }
                }
                Err(_) => return false,
            }
        }
        true
    }

    fn accessed(&mut self, session: &mut Session<EmulatedBoard>, access: &Access, value: u64) {
        if let Some(guard) = &mut self.guard {
            guard.see(access);
        }
        let (board, at) = (session.board_mut(), access.virtual_time);
        match (access.kind, access.address) {
            (AccessKind::Write, address) => {
                self.spans.look(board, at);
                if address != TIM1_CCR1 {
                    return;
                }
                // The set-up writes the register, too, before its top.
                let drives = access.value != u64::from(BridgeInputs::read(board).top / 2);
                if self.breaks_at_arming && drives && !self.ticks_ns.is_empty() {
                    self.breaks_at_arming = false;
                    board.drive_break(at, true);
                    board.drive_break(at, false);
                }
                self.coupling.duty_written(board, at);
            }
            (AccessKind::Read, TIM2_CNT) => {
                self.ticks_ns.push(at.0);
                self.coupling.counter_read(board, value as u32, at);
            }
            (AccessKind::Read, TIM11_CCR1) => {
                board.capture_crystal(at);
                return;
            }
            _ => return,
        }
        session.run_until(self.next());
    }

    fn stopped(&mut self, session: &mut Session<EmulatedBoard>, host: &mut dyn Host, stop: &Stop) {
        let board = session.board_mut();
        board.settle();
        self.spans.look(board, stop.at);
        let resets = session.resets().len();
        if resets > self.resets {
            self.resets = resets;
            session.board_mut().reconnect(stop.at);
            self.coupling.reset(session.board_mut(), stop.at);
            // Any reset ends a stall.
            host.hold(false);
        }
        if let Some(StopCondition::Frame(_)) = self.until
            && self.is_there(stop.at)
        {
            session.run_until(stop.at);
        }
    }
}

impl<C: PlantCoupling> Driver<EmulatedBoard> for Harness<C> {
    fn on_settled(
        &mut self,
        session: &mut Session<EmulatedBoard>,
        host: &mut dyn Host,
        settled: Settled,
    ) {
        match settled {
            Settled::Hit(hit) => {
                if let Some(probe) = &mut self.probe {
                    probe.hit(&hit);
                }
            }
            Settled::Access { access, value } => self.accessed(session, &access, value),
            Settled::Stop(stop) => self.stopped(session, host, &stop),
            _ => session.board_mut().settle(),
        }
    }

    fn on_stop(
        &mut self,
        session: &mut Session<EmulatedBoard>,
        stop: Stop,
        host: &mut dyn Host,
    ) -> Option<VirtualNanos> {
        if let Err(error) = self.act(session.board_mut(), host, stop.at) {
            self.failed = Some(error.to_string());
        } else if let Some(guard) = &self.guard {
            self.failed = guard.polling(&self.image);
        }
        if self.failed.is_some() || !self.obey(session, &stop, host) {
            // The last lines of the log are often the important ones. If they cannot be read, no
            // caller is left for the error.
            let _ = self.log.drain(host, stop.at);
            if let Some(probe) = &mut self.probe
                && let Err(error) = probe.detach(host)
            {
                self.failed.get_or_insert(error.to_string());
            }
            return None;
        }
        Some(self.next())
    }
}

impl<C: std::fmt::Debug> std::fmt::Debug for Harness<C> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Harness").field("coupling", &self.coupling).finish_non_exhaustive()
    }
}
