//! The firmware. On a host, this program only says how to build it.
//!
//! It is built on RTIC 2. The control task owns the servo; it is bounded, and its deadline is
//! checked. Above it is only the converter's interrupt, which protects the bridge from the motor's
//! current and runs the current loop. Everything slow is async below it.
#![cfg_attr(target_os = "none", no_std, no_main)]
// Registers, the parameter sectors and the memory that survives a reset need unsafe code; each use
// says why it is sound.
#![cfg_attr(target_os = "none", allow(unsafe_code))]

#[cfg(target_os = "none")]
mod board;

#[cfg(not(target_os = "none"))]
fn main() {
    println!(
        "This is the firmware: build it with `cargo xtask firmware`, flash it with \
         `cargo xtask flash`."
    );
}

#[cfg(target_os = "none")]
#[rtic::app(device = stm32f4xx_hal::pac, peripherals = true, dispatchers = [SPI1])]
mod app {
    use core::mem::MaybeUninit;
    use core::sync::atomic::Ordering;

    use heapless::spsc::{Consumer, Producer, Queue};
    use stiction::link::{DeviceKind, Session};
    use stiction::parameters::store::Store;
    use stiction::safety::fault::LatchedFault;
    use stiction::servo::{Boot, Output, State};
    use stiction::{Fault, Servo};
    use stm32f4xx_hal::pac::Interrupt;

    use crate::board::bridge;
    use crate::board::clock;
    use crate::board::control_task::{BREAK, ControlTask, OVER_CURRENT, TRIPPED};
    use crate::board::converter;
    use crate::board::crystal::Crystal;
    use crate::board::current_loop::RunningLoop;
    use crate::board::last_tick;
    use crate::board::liveness;
    use crate::board::machine::BoardMachine;
    use crate::board::ntc::NtcInput;
    use crate::board::report::Report;
    use crate::board::retained::{self, Retained, RetainedFault};
    use crate::board::sectors::Sectors;
    use crate::board::setup::{self, Board};
    use crate::board::traits::Watchdog;
    use crate::board::usart::{self, Port, ReceiveQueue};
    use crate::board::watchdog::Independent;
    use crate::board::{fatal, reset};

    /// Number of ticks that log and telemetry may lag behind; beyond it, they miss some.
    const OUTPUTS: usize = 16;

    /// Bytes of frames that wait for the wire: two of the longest answers, and a few samples.
    const WAITING: usize = 768;

    /// Bytes on their way to the wire. At half of them the link is asked for more, 0.3 ms before
    /// there are none.
    const TO_WIRE: usize = 64;

    #[shared]
    struct Shared {
        control_task: ControlTask,
        session: &'static mut Session<WAITING>,
        watchdog: Independent,
    }

    #[local]
    struct Local {
        current_loop: RunningLoop,
        before: (State, bool),
        output_producer: Producer<'static, Output>,
        output_consumer: Consumer<'static, Output>,
        report: Report,
        ntc: NtcInput,
        port: Port,
        received: ReceiveQueue,
        to_wire_producer: Producer<'static, u8>,
        to_wire_consumer: Consumer<'static, u8>,
        timer_clock: u32,
        store: Store<Sectors>,
    }

    #[init(local = [
        outputs: Queue<Output, OUTPUTS> = Queue::new(),
        session: MaybeUninit<Session<WAITING>> = MaybeUninit::uninit(),
        servo: MaybeUninit<Servo> = MaybeUninit::uninit(),
        to_wire: Queue<u8, TO_WIRE> = Queue::new(),
    ])]
    fn init(cx: init::Context) -> (Shared, Local) {
        // First of all: reading the parameters takes longer than any of what follows.
        bridge::hold_enable_low(&cx.device.RCC, &cx.device.GPIOB);
        let init::LocalResources { outputs, session, servo, to_wire, .. } = cx.local;
        let session = session.write(Session::new(DeviceKind::Board, None));
        let (output_producer, output_consumer) = outputs.split();
        let (to_wire_producer, to_wire_consumer) = to_wire.split();
        let Retained { fault: record, was_armed, is_encoder_in_doubt, thermal_effort } =
            retained::take();
        let cause = reset::take_cause(&cx.device.RCC);
        let fault = record.and_then(|record| record.fault()).or(cause.fault(was_armed));
        // The next reset has no cause of its own and could arm: the cause is kept until a command
        // clears it. A button that bounces resets before the first tick.
        if let Some(fault) = fault.filter(|fault| fault.is_clearable()) {
            retained::keep(record.unwrap_or(RetainedFault::of(fault)));
        }
        let brown_out = reset::brown_out(&cx.device.FLASH);
        let may_be_dip = cause.may_be_dip(brown_out);
        let settings = setup::BoardSettings::read();
        let board = setup::start(cx.device, cx.core, &settings, servo, |crystal| {
            let crystal = match crystal {
                Crystal::Measured(_) | Crystal::NotMeasured => None,
                Crystal::Absent => Some(LatchedFault::from(Fault::ClockAbsent)),
                Crystal::Wrong(mhz) => {
                    Some(LatchedFault { value: mhz, ..LatchedFault::from(Fault::ClockWrong) })
                }
            };
            let before =
                record.and_then(|record| record.as_latched()).or(fault.map(LatchedFault::from));
            // A crystal's fault must not hide behind an old fault that a command may clear.
            let lasting = before.filter(|latched| !latched.fault.is_clearable());
            let fault = lasting.or(crystal).or(before);
            Boot {
                fault,
                is_encoder_in_doubt,
                is_damaged: settings.is_damaged,
                may_be_dip,
                is_at_zero: false,
                thermal_effort,
            }
        });
        if let Ok(parameters) = settings.parameters() {
            session.use_saved(parameters);
        }
        session.report_damage(settings.is_damaged);
        session.report_saves(settings.saves());
        session.report_brown_out(brown_out.is_on());
        session.report_crystal(board.crystal == Crystal::NotMeasured);
        let report = Report::new();
        report.banner(&board, (cause, brown_out), record.as_ref(), fault, &settings);

        let Board { control_task, watchdog, port, received, ntc, store, timer_clock, .. } = board;
        let before = (control_task.servo.state(), is_encoder_in_doubt);
        let shared = Shared { control_task, session, watchdog };
        let local = Local {
            current_loop: RunningLoop::NONE,
            before,
            output_producer,
            output_consumer,
            report,
            ntc,
            port,
            received,
            to_wire_producer,
            to_wire_consumer,
            timer_clock,
            store,
        };
        (shared, local)
    }

    #[idle]
    fn idle(_: idle::Context) -> ! {
        loop {
            cortex_m::asm::wfi();
        }
    }

    /// Runs one tick of the loop.
    ///
    /// Its budget is 1400 instructions from entry to exit, 2000 under `robust`, and 220 more with a
    /// sensor of the current (tests/evidence/cost.md). 1400 are a twelfth of the shortest sample
    /// time, if each took one cycle, and by the estimate there more than that. If the task begins
    /// late or takes more than half the sample time, the output is turned off for good.
    #[task(binds = TIM3, priority = 3, local = [before, output_producer], shared = [control_task])]
    fn control(mut cx: control::Context) {
        let local = cx.local;
        // No task that shares the parts is above this one: the lock is there for the types.
        cx.shared.control_task.lock(|parts| {
            parts.enter();
            let output = parts.tick();
            let now = (output.state, parts.servo.is_encoder_in_doubt());
            if now != *local.before {
                remember(parts.servo);
                *local.before = now;
            }
            last_tick::publish(&output);
            // A full queue loses a line of the log and samples of the telemetry, nothing else.
            let _ = local.output_producer.enqueue(output);
            rtic::pend(Interrupt::SPI2);
            parts.leave();
        });
    }

    /// Keeps, for the time after the next reset, whether the servo is armed, what is latched, and
    /// whether the encoder is in doubt.
    fn remember(servo: &Servo) {
        retained::set_armed(servo.state() == State::Armed);
        retained::set_encoder_in_doubt(servo.is_encoder_in_doubt());
        match servo.latched() {
            Some(latched) => retained::keep(RetainedFault::latched(&latched)),
            // The fault has been cleared: the next reset must not report it again.
            None => retained::forget(),
        }
    }

    /// Deals with outputs that the hardware has turned off already, because the bridge or the clock
    /// failed. What is left to do is to pull the enable pin low, and to remember.
    ///
    /// This task has the control task's priority, so that neither interrupts the other. Above it,
    /// this task could run between the control task's decision to turn the outputs on and the
    /// writing of it. A break input that is active only for an instant would then leave them on for
    /// a whole tick. So this task waits for the end of a control task, whose budget is 1400
    /// instructions. Of two tasks that wait, it is the first (its interrupt has the lower number).
    #[task(binds = TIM1_BRK_TIM9, priority = 3)]
    fn outputs_broken(_: outputs_broken::Context) {
        bridge::off_now();
        bridge::silence_break();
        if clock::has_lost_crystal() {
            // The clocks are wrong from here on: start again on the internal oscillator, and
            // report it there.
            fatal::stop(RetainedFault::of(Fault::ClockLost));
        }
        TRIPPED.fetch_or(BREAK, Ordering::Relaxed);
    }

    /// Turns the bridge off if a conversion of the motor's current was beyond its limits. The task
    /// is above the control task: the bridge is off some microseconds after the conversion, and the
    /// next control task latches the fault. Otherwise, runs a period of the current loop.
    #[task(binds = ADC, priority = 4, local = [current_loop])]
    fn converted(cx: converted::Context) {
        match converter::over_current() {
            Some(reading) => {
                TRIPPED.fetch_or(OVER_CURRENT | u32::from(reading), Ordering::Relaxed);
            }
            None => cx.local.current_loop.period(),
        }
    }

    /// Sends a byte of the link, and wakes the link when the line falls idle. The DMA receives. The
    /// task is below the control task, which it cannot hold up.
    #[task(binds = USART1, priority = 2, local = [port, to_wire_consumer])]
    fn wire(cx: wire::Context) {
        let wire::LocalResources { port, to_wire_consumer: to_wire, .. } = cx.local;
        let is_idle = port.serve(|| {
            if to_wire.len() == TO_WIRE / 2 {
                let _ = link::spawn();
            }
            to_wire.dequeue()
        });
        if is_idle {
            let _ = link::spawn();
        }
    }

    /// Looks at the wire when half of the ring has been written, and wakes the link: a client that
    /// does not pause lets the line never fall idle.
    #[task(binds = DMA2_STREAM2, priority = 2)]
    fn half(_: half::Context) {
        usart::acknowledge_half();
        rtic::pend(Interrupt::USART1);
        let _ = link::spawn();
    }

    /// Wakes the link, which sleeps while a sector is erased and then looks for itself.
    #[task(binds = SysTick, priority = 2)]
    fn alarm(_: alarm::Context) {}

    /// Feeds the watchdog. The task runs only after a control tick, and only if nothing above it
    /// hogs the processor. It wakes the log and by it the link, which the control task has no time
    /// for: to pend an interrupt that nothing else uses takes the control task four instructions,
    /// to spawn a task twenty.
    #[task(binds = SPI2, priority = 2, shared = [watchdog])]
    fn feed(mut cx: feed::Context) {
        if liveness::all_have_run() {
            cx.shared.watchdog.lock(Watchdog::feed);
        }
        // If the log is still busy, it takes this tick, too.
        let _ = report::spawn();
    }

    /// Writes log and trace, makes the samples of the telemetry, and reads the motor's temperature.
    /// Then it is the link's turn.
    #[task(priority = 1, local = [output_consumer, report, ntc], shared = [control_task, session])]
    async fn report(mut cx: report::Context) {
        let local = cx.local;
        while let Some(output) = local.output_consumer.dequeue() {
            let sample_time = cx.shared.session.lock(|session| {
                session.queue_sample(&output);
                session.parameters().map(|parameters| parameters.controller.sample_time)
            });
            let before = local.report.report_tick(&output, sample_time.unwrap_or(1.0));
            let servo = &mut cx.shared.control_task;
            let reading = local.ntc.reading();
            retained::set_thermal_effort(servo.lock(|parts| {
                parts.servo.take_ntc(reading);
                parts.servo.thermal_effort()
            }));
            match (before, output.state) {
                (Some(_), State::Armed) => {
                    if servo.lock(|parts| parts.servo.is_jogging()) {
                        local.report.jog_begins();
                    }
                }
                (Some(State::Armed), _) => {
                    let found =
                        |parts: &mut ControlTask| (parts.servo.levels(), parts.servo.jogged());
                    let (levels, jogged) = servo.lock(found);
                    local.report.motion_over(levels, jogged);
                }
                _ => {}
            }
        }
        liveness::REPORT.has_run();
        let _ = link::spawn();
    }

    /// Hears what was said, does it, and answers. It takes one frame, and a piece of an answer that
    /// takes long, since each may take milliseconds: before the next one, the log has its turn, and
    /// the watchdog with it.
    #[task(
        priority = 1,
        local = [received, to_wire_producer, timer_clock, store],
        shared = [control_task, session, watchdog],
    )]
    async fn link(cx: link::Context) {
        let link::LocalResources { received, to_wire_producer, timer_clock, store, .. } = cx.local;
        let link::SharedResources { mut control_task, mut session, mut watchdog, .. } = cx.shared;
        let (control_task, watchdog) = (&mut control_task, &mut watchdog);
        let mut machine = BoardMachine { control_task, watchdog, clock: *timer_clock, store };
        let is_working = session.lock(|session| {
            session.report_wire(received.errors());
            while let Some(byte) = received.next() {
                session.receive(&[byte], &mut machine);
                // The end of a frame.
                if byte == 0 {
                    break;
                }
            }
            let is_working = session.work(&mut machine);
            while to_wire_producer.ready() {
                let mut byte = [0];
                if session.transmit(&mut byte) == 0 {
                    break;
                }
                let _ = to_wire_producer.enqueue(byte[0]);
            }
            is_working
        });
        rtic::pend(Interrupt::USART1);
        liveness::LINK.has_run();
        if received.is_waiting() || is_working {
            let _ = report::spawn();
        }
    }
}
