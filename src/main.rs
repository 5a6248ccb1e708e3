//! The firmware. On a host this program only says how to build it.
//!
//! RTIC 2: the control task owns the servo and has the highest priority; it is bounded, and its deadline is checked.
//! Everything slow is async below it.
#![cfg_attr(target_os = "none", no_std, no_main)]
// Registers, the parameter sectors and the memory that survives a reset; each use says why it is sound.
#![cfg_attr(target_os = "none", allow(unsafe_code))]

#[cfg(target_os = "none")]
mod board;
#[cfg(target_os = "none")]
mod report;

#[cfg(not(target_os = "none"))]
fn main() {
    println!(
        "This is the firmware: build it with `cargo xtask firmware`, flash it with `cargo xtask flash`."
    );
}

#[cfg(target_os = "none")]
#[rtic::app(device = stm32f4xx_hal::pac, peripherals = true, dispatchers = [SPI1, SPI2])]
mod app {
    use core::sync::atomic::{AtomicBool, Ordering};

    use heapless::spsc::{Consumer, Producer, Queue};
    use stiction::deadline::Deadline;
    use stiction::fault::Latched;
    use stiction::servo::{Boot, Input, Levels, Output, State};
    use stiction::{Fault, Servo};

    use crate::board::bridge::{self, TimerBridge};
    use crate::board::clock;
    use crate::board::encoder::Quadrature;
    use crate::board::published;
    use crate::board::record::{self, Record};
    use crate::board::seams::{Bridge, Encoder, Watchdog};
    use crate::board::setup::{self, Board};
    use crate::board::stopwatch::Stopwatch;
    use crate::board::supply::Supply;
    use crate::board::tick::TickTimer;
    use crate::board::watchdog::Independent;
    use crate::board::{fatal, reset};
    use crate::report::Report;

    /// Ticks that the log may lag behind; beyond it, it misses some.
    const QUEUE: usize = 16;

    /// The bridge's driver pulled the break input: set by its interrupt, taken by the control task.
    static TRIPPED: AtomicBool = AtomicBool::new(false);

    #[shared]
    struct Shared {
        /// What a ramp has found, until it has been told.
        levels: Option<Levels>,
    }

    #[local]
    struct Local {
        servo: Servo,
        before: State,
        deadline: Deadline,
        encoder: Quadrature,
        bridge: TimerBridge,
        supply: Supply,
        timer: TickTimer,
        stopwatch: Stopwatch,
        watchdog: Independent,
        ticks: Producer<'static, Output>,
        trace: Consumer<'static, Output>,
        report: Report,
    }

    #[init(local = [queue: Queue<Output, QUEUE> = Queue::new()])]
    fn init(cx: init::Context) -> (Shared, Local) {
        let (ticks, trace) = cx.local.queue.split();
        let (told, was_armed) = record::take();
        let cause = reset::Cause::take(&cx.device.RCC);
        let settings = setup::Settings::read();
        let board = setup::start(cx.device, cx.core, &settings);

        let fault = told.and_then(|record| record.fault()).or(cause.fault(was_armed));
        let absent = (!board.crystal).then_some(Fault::ClockAbsent);
        let before = told.and_then(|record| record.as_latched()).or(fault.map(Latched::from));
        // An absent crystal must not hide behind an old fault that a command may clear.
        let lasting = before.filter(|latched| !latched.fault.is_clearable());
        let latched = lasting.or(absent.map(Latched::from)).or(before);
        let servo = Servo::new(settings.parameters(), Boot { fault: latched });
        let report = Report::new(&settings);
        report.banner(&board, cause, told.as_ref(), fault, &settings);

        let Board { encoder, bridge, supply, timer, stopwatch, watchdog, period, .. } = board;
        let (before, deadline) = (servo.state(), Deadline::new(period));
        let local = Local {
            servo,
            before,
            deadline,
            encoder,
            bridge,
            supply,
            timer,
            stopwatch,
            watchdog,
            ticks,
            trace,
            report,
        };
        (Shared { levels: None }, local)
    }

    #[idle]
    fn idle(_: idle::Context) -> ! {
        loop {
            cortex_m::asm::wfi();
        }
    }

    /// One tick of the loop.
    ///
    /// Its budget is 900 instructions from entry to exit (docs/cost.md): a twentieth of the shortest sample time, if each
    /// took one cycle. If it begins late or takes more than half the sample time, the output is turned off for good.
    #[task(
        binds = TIM3,
        priority = 3,
        local = [servo, before, deadline, encoder, bridge, supply, timer, stopwatch, ticks],
        shared = [levels]
    )]
    fn control(mut cx: control::Context) {
        let local = cx.local;
        let in_time = local.deadline.enter(local.stopwatch.now());
        local.timer.acknowledge();
        if !in_time {
            local.servo.fault(Fault::Overrun);
        }
        if TRIPPED.load(Ordering::Relaxed) {
            local.servo.fault(Fault::BreakInput);
        }

        let input = Input { counter: local.encoder.counter(), supply: local.supply.read() };
        let output = local.servo.tick(input);
        if output.enable {
            local.bridge.drive(output.duty);
        } else {
            local.bridge.off(output.duty);
        }

        if output.state != *local.before {
            remember(output.state, local.servo.latched());
            *local.before = output.state;
            cx.shared.levels.lock(|levels| *levels = local.servo.levels());
        }
        published::publish(&output.tick);
        // A full queue loses a line of the log, nothing else.
        let _ = local.ticks.enqueue(output);
        // Still busy with the last tick: it takes this one, too.
        let _ = feed::spawn();
        if !local.deadline.leave(local.stopwatch.now()) {
            local.servo.fault(Fault::Overrun);
        }
    }

    /// Keeps for the next reset what this one must not forget.
    fn remember(state: State, latched: Option<Latched>) {
        record::set_armed(state == State::Armed);
        if let Some(latched) = latched {
            record::keep(Record::latched(&latched));
        }
    }

    /// The outputs are off already, in hardware, because the bridge or the clock failed. What is left is the enable
    /// pin, and to remember.
    ///
    /// It has the control task's priority, so that neither interrupts the other. Above it, this task could run between
    /// the control task's decision to turn the outputs on and the writing of it, and a break input that is active only
    /// for an instant would leave them on for a whole tick. So it waits for the end of a control task, whose
    /// budget is 900 instructions; of two that wait, it is the first (its interrupt has the lower number).
    #[task(binds = TIM1_BRK_TIM9, priority = 3)]
    fn outputs_broken(_: outputs_broken::Context) {
        bridge::off_now();
        bridge::silence_break();
        if clock::has_lost_crystal() {
            // The clocks are wrong from here on: begin anew on the internal oscillator, and tell it there.
            fatal::stop(Record::of(Fault::ClockLost));
        }
        TRIPPED.store(true, Ordering::Relaxed);
    }

    /// Runs only after a control tick, and only if nothing above hogs the processor. It wakes the log, which the control
    /// task has no time for.
    #[task(priority = 2, local = [watchdog])]
    async fn feed(cx: feed::Context) {
        cx.local.watchdog.feed();
        let _ = report::spawn();
    }

    /// Log and trace.
    #[task(priority = 1, local = [trace, report], shared = [levels])]
    async fn report(mut cx: report::Context) {
        while let Some(output) = cx.local.trace.dequeue() {
            cx.local.report.tick(&output);
        }
        if let Some(levels) = cx.shared.levels.lock(Option::take) {
            cx.local.report.levels(&levels);
        }
    }
}
