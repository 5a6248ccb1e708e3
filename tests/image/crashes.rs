//! The program stops doing its work while the motor is driven. The image is the product's own, to
//! the byte, but for one test that says so; what goes wrong is done to the part around it.
//!
//! Blind to what a real part does in the same distress: a RAM that forgets, a bus that hangs, a
//! supply that sags slowly.

use std::sync::Arc;

use emulator::FirmwareImage;
use emulator::board::FittedParts;
use emulator::fault_injection::{BoardObservation, Injection, converse, observe};

use emulator::parameters::everything_on;
use emulator::setup::Partner;

use crate::common::{firmware, image, plans};
use crate::fault_injection::{
    AT, MS, UNTIL, assert_off_after, inject, parameters, parameters_with,
};
use crate::stuck::{function, patched};

/// One instruction at 168 MHz, rounded up.
const AN_INSTRUCTION_NS: u64 = 6;
/// What the control task reads first.
const TIM2_CNT: u64 = 0x4000_0024;
/// Data sheet, the oscillator of the watchdog: slowest, typical, fastest, Hz.
const LSI_HZ: [u64; 3] = [17_000, 32_000, 47_000];

fn crash(injections: &[(u64, Injection)]) -> BoardObservation {
    let observed = inject(Some(&parameters()), FittedParts::default(), injections);
    assert_driven_before(&observed);
    observed
}

/// The motor was not only enabled but pulled when the bridge was turned off.
fn assert_driven_before(observed: &BoardObservation) {
    let neutral = observed.last.top / 2;
    assert!(observed.last.compare.abs_diff(neutral) > neutral / 10, "{:?}", observed.last);
}

/// One reset, and the bridge was off before it: the handler did it, not the reset.
fn assert_off_before_the_reset(observed: &BoardObservation) {
    let [reset] = observed.resets[..] else { panic!("{:?}", observed.resets) };
    let off = observed.off_at_ns().unwrap();
    assert!(off < reset.at.0, "off at {off}, reset at {}", reset.at.0);
    // By both: the outputs and the enable pin. Each alone turns a bridge off, if it is wired.
    assert!(
        observed.any_ns < reset.at.0,
        "by half at {}, reset at {}",
        observed.any_ns,
        reset.at.0
    );
}

/// The watchdog is no longer fed: the reset comes when `watchdog.rs` says, counted from the last
/// time that it was fed, which is a tick before `AT` at most, or `later` ms later. The bridge is
/// off from then on.
fn assert_starved(sample_time_ms: u64, lsi_hz: u64, injection: Injection, later: u64) {
    let parameters = parameters_with(&[&format!("loop.sample_time_s={}e-3", sample_time_ms)]);
    let fitted = FittedParts { lsi_hz, ..FittedParts::default() };
    let observed = inject(Some(&parameters), fitted, &[(AT, injection)]);
    let case = format!("{injection:?}, {sample_time_ms} ms, {lsi_hz} Hz");
    let reset_ns = assert_ended(&observed, &case, sample_time_ms, lsi_hz, later);
    if injection == Injection::TickStops {
        let (khz, ms) = (lsi_hz / 1000, (reset_ns - AT) as f64 / MS as f64);
        // For tests/evidence/reliability.md, as `cargo xtask reliability` reads it.
        println!("reliability: watchdog | sample_ms={sample_time_ms} | khz={khz} | ms={ms:.1}");
    }
}

/// See [`assert_starved`]; returns when the reset came, ns.
fn assert_ended(
    observed: &BoardObservation,
    case: &str,
    sample_time_ms: u64,
    lsi_hz: u64,
    later: u64,
) -> u64 {
    assert_driven_before(observed);
    let [reset] = observed.resets[..] else { panic!("{case}: resets {:?}", observed.resets) };
    let shortest_ms = (3 * sample_time_ms).max(10);
    let timeout = shortest_ms * MS * LSI_HZ[2] / lsi_hz;
    let fed = AT - sample_time_ms * MS..AT + later * sample_time_ms * MS + MS;
    let allowed = fed.start + timeout..fed.end + timeout;
    assert!(allowed.contains(&reset.at.0), "{case}: {reset:?}");
    assert_off_after(observed, reset.at.0, 0);
    assert!(observed.says("reset by watchdog"), "{case}: {:?}", observed.log);
    assert!(observed.says("faulted: watchdog reset"), "{case}: {:?}", observed.log);
    reset.at.0
}

#[test]
fn a_tick_that_stops_is_ended_by_the_watchdog() {
    for sample_time_ms in [20, 1] {
        for lsi_hz in LSI_HZ {
            assert_starved(sample_time_ms, lsi_hz, Injection::TickStops, 0);
        }
    }
}

#[test]
fn a_processor_that_stands_still_is_ended_by_the_watchdog() {
    assert_starved(20, LSI_HZ[1], Injection::CoreStalls, 0);
    assert_starved(1, LSI_HZ[1], Injection::CoreStalls, 0);
}

#[test]
fn a_link_that_never_ends_is_ended_by_the_watchdog_though_the_control_task_goes_on() {
    // A copy of the image whose session goes around in a circle as soon as a byte has come.
    let path = image();
    let circle = [0xFE, 0xE7];
    let receive = patched(|_| function("Session$LT$_$GT$7receive"), &circle);
    let image = Arc::new(FirmwareImage::parse(&path, receive).unwrap());
    for sample_time_ms in [20, 1] {
        let record = parameters_with(&[&format!("loop.sample_time_s={sample_time_ms}e-3")]);
        let mut says = Some(0);
        let partner = move |at: u64, _: &[u8]| {
            if at < AT { Vec::new() } else { says.take().into_iter().collect() }
        };
        let (records, fitted) = ([Some(&record[..]), None], FittedParts::default());
        let observed = converse(&image, records, fitted, &[], UNTIL, Box::new(partner)).unwrap();
        let case = format!("a circle, {sample_time_ms} ms");
        // Fed by the next tick once more, since link and log have run after the one before.
        assert_ended(&observed, &case, sample_time_ms, LSI_HZ[1], 1);
        // The control task went on all the while, and drove the motor.
        let ticks = observed.ticks_ns.iter().filter(|at| **at > AT).count();
        assert!(ticks as u64 >= 50 / sample_time_ms, "{case}: {ticks} ticks");
    }
}

#[test]
fn a_panic_turns_the_bridge_off_and_is_reported() {
    // The logger's own lock looks taken: its next line, within a tenth of a second, panics with all
    // interrupts masked.
    let lock = firmware().variable("RTT_ENCODER");
    assert!(!lock.is_empty());
    let injections: Vec<_> = lock
        .into_iter()
        .map(|(address, length)| (AT, Injection::Corrupts { address, length, to: 1 }))
        .collect();
    let observed = crash(&injections);
    assert_off_after(&observed, AT, 120 * MS);
    assert_off_before_the_reset(&observed);
    // What takes long is the wait for the next line: the task of the log writes it after a tick.
    let off = observed.any_ns;
    let tick = observed.ticks_ns.iter().rfind(|at| **at < off).unwrap();
    assert_pins_in_time("panic", &observed, *tick);
    assert!(observed.says("panic in") && observed.says("line"), "{:?}", observed.log);
    assert!(observed.says("faulted: panic"), "{:?}", observed.log);
}

#[test]
fn a_hard_fault_turns_the_bridge_off_and_is_reported() {
    let observed = crash(&[(AT, Injection::BusError { address: TIM2_CNT })]);
    assert_off_after(&observed, AT, 20 * MS);
    assert_off_before_the_reset(&observed);
    // What takes long is the wait for the next reading of the encoder, which fails. It is due 20 ms
    // after the last one.
    let due = observed.ticks_ns.iter().rfind(|at| **at < AT).unwrap() + 20 * MS;
    let late = observed.any_ns.abs_diff(due);
    assert!(late < PINS_NS, "{late} ns");
    // CFSR: a precise data bus error with a valid address.
    assert!(
        observed.says("hard fault at 0x80") && observed.says("status 0x8200"),
        "{:?}",
        observed.log
    );
    assert!(observed.says("faulted: hard fault"), "{:?}", observed.log);
}

/// Time from a crash to the pins, ns.
const PINS_NS: u64 = 10_000;

/// `push {r0-r7, lr}` without an end: 36 bytes of the stack each.
const PUSH_FOR_EVER: [u8; 4] = [0xFF, 0xB5, 0xFD, 0xE7];

/// The stack has 18 KiB (memory.x). A push of nine words and a branch take 13 cycles at most at 168
/// MHz, so it is full after 40 us. The processor is in the handler 12 cycles later, and 9
/// instructions turn the pins off. The control task is within its 1415 instructions before, 8 us,
/// and the link begins within 10 us after it.
const OVERFLOW_NS: u64 = 50_000;

/// Runs a copy of the image in which a function pushes until the stack is full. Asserts that the
/// bridge is off before the reset, and within [`OVERFLOW_NS`] of what called the function.
fn overflow(name: &str, record: &[u8], until: u64, partner: Partner) -> BoardObservation {
    let bytes = patched(|_| function(name), &PUSH_FOR_EVER);
    let image = Arc::new(FirmwareImage::parse(&image(), bytes).unwrap());
    let (records, fitted) = ([Some(record), None], FittedParts::default());
    let injections = [(0, Injection::NothingBelowRam)];
    let observed = converse(&image, records, fitted, &injections, until, partner).unwrap();
    assert_driven_before(&observed);
    let reset = observed.resets[0].at.0;
    let (off, any) = (observed.on_ns[0][1], observed.any_ns);
    // By both: the outputs and the enable pin. Nothing turns them on again.
    assert!(observed.on_ns.len() == 1 && off <= any && any < reset, "{off}, {any}, {reset}");
    observed
}

fn assert_pins_in_time(name: &str, observed: &BoardObservation, called: u64) {
    let [pins, reset] = [observed.any_ns, observed.resets[0].at.0].map(|at| at - called);
    let [pins_us, reset_us] = [pins, reset].map(|ns| ns as f64 / 1000.0);
    println!("reliability: pins | after={name} | pins_us={pins_us:.1} | reset_us={reset_us:.1}");
    assert!(pins < OVERFLOW_NS, "{name}: {pins_us} us");
}

#[test]
fn a_stack_that_overflows_in_the_control_task_turns_the_bridge_off() {
    // The blocked joint stalls while the motor is driven, and the control task latches that. The
    // copy latches at each start, too, and resets again and again: the first time is looked at.
    let record = everything_on(&plans("step-response", &["pd"], &[])[0]).unwrap();
    let silent = Box::new(|_: u64, _: &[u8]| Vec::new());
    let observed = overflow("Servo$GT$5latch", &record, 342 * MS, silent);
    let tick = observed.ticks_ns.iter().rfind(|at| **at < observed.any_ns).unwrap();
    assert_pins_in_time("control", &observed, *tick);
}

#[test]
fn a_stack_that_overflows_in_the_link_turns_the_bridge_off_and_is_reported() {
    let mut byte = Some(0);
    let partner = move |at: u64, _: &[u8]| {
        if at < AT { Vec::new() } else { byte.take().into_iter().collect() }
    };
    let observed = overflow("Session$LT$_$GT$7receive", &parameters(), UNTIL, Box::new(partner));
    // 10 bits of a byte take 10 us at 1 Mbit/s; the partner is asked every 50 us.
    assert_pins_in_time("link", &observed, AT);
    assert!(observed.says("hard fault after a stack overflow"), "{:?}", observed.log);
    assert!(observed.says("faulted: hard fault"), "{:?}", observed.log);
}

#[test]
fn an_exception_without_a_handler_is_reported() {
    // A copy of the image whose task of the log makes a supervisor call (11 in the vector table),
    // at each start.
    let path = image();
    let supervisor_call = [0x00, 0xDF];
    let image =
        FirmwareImage::parse(&path, patched(|_| function("SPI1"), &supervisor_call)).unwrap();
    let records = [Some(&parameters()[..]), None];
    let observed =
        observe(&Arc::new(image), records, FittedParts::default(), &[], 100 * MS).unwrap();
    assert!(
        observed.says("panic in an exception without a handler, line 11"),
        "{:?}",
        observed.log
    );
    assert!(observed.resets.len() > 1 && observed.on_ns.is_empty(), "{observed:?}");
}

#[test]
fn an_overrun_is_latched_and_a_short_stall_is_not_one() {
    // 30 ms: at least one tick of 20 ms begins more than a quarter of a period late, and the
    // watchdog does not mind yet.
    let stall =
        |ms: u64| crash(&[(AT, Injection::CoreStalls), (AT + ms * MS, Injection::CoreGoesOn)]);
    let observed = stall(30);
    assert!(observed.resets.is_empty(), "{:?}", observed.resets);
    assert_off_after(&observed, AT + 30 * MS, MS);
    assert!(observed.says("faulted: control overrun"), "{:?}", observed.log);
    // By both: the outputs and the enable pin. Each alone turns a bridge off, if it is wired.
    assert!(observed.any_ns < AT + 31 * MS, "by half until {} ns", observed.any_ns);
    // 4 ms of 20: late, if it hits the tick at all, but by less than a quarter.
    let observed = stall(4);
    assert!(observed.on_after(UNTIL - MS) && observed.on_ns.len() == 1, "{observed:?}");
}

#[test]
fn a_brown_out_is_reported_whether_or_not_the_memory_survives() {
    let forgets: Vec<_> = firmware()
        .variable("KEPT")
        .into_iter()
        .map(|(address, length)| (AT, Injection::Corrupts { address, length, to: 0xA5 }))
        .collect();
    assert!(!forgets.is_empty());
    for after in [Vec::new(), forgets] {
        let mut injections = vec![(AT, Injection::BrownOut)];
        injections.extend(after);
        let observed = crash(&injections);
        // The part can be stopped between two instructions only.
        assert_off_after(&observed, AT, AN_INSTRUCTION_NS);
        assert!(observed.says("reset by brown-out"), "{:?}", observed.log);
        assert!(observed.says("faulted: brown-out"), "{:?}", observed.log);
    }
}

/// The button that resets the part a second time has no fault of its own, and autostart is on.
#[test]
fn a_second_reset_does_not_arm_after_a_crash_that_was_not_cleared() {
    let observed = crash(&[
        (AT, Injection::BusError { address: TIM2_CNT }),
        (AT + 300 * MS, Injection::Reset),
    ]);
    assert_eq!(observed.resets.len(), 2, "{:?}", observed.resets);
    let [[_, off]] = observed.on_ns[..] else { panic!("{:?}", observed.on_ns) };
    assert!(off < observed.resets[0].at.0, "{off}, {:?}", observed.resets);
}
