//! Gates of the flash image: no floating point in software, no panic and no call through a register
//! in the control path, and a stack that fits its room.

use std::collections::BTreeSet;
use std::path::Path;

use emulator::FirmwareImage;
use emulator::firmware::stack::StackBound;
use emulator::firmware::{Code, routines};
use files::Error;

use crate::measure::stack_room;

/// Handlers on which the motion depends: the control interrupt, the break input, and the
/// converter's watchdog over the current.
const CONTROL: [&str; 3] = ["TIM3", "TIM1_BRK_TIM9", "ADC"];
/// Other handlers with a higher priority than the tasks of log and link: a panic in them would stop
/// the motion as well. SPI1, which runs those tasks, may panic, since the log can panic.
const ABOVE_TASKS: [&str; 3] = ["USART1", "SPI2", "SysTick"];
/// The function in which every panic ends.
const PANIC: &str = "rust_begin_unwind";

/// Checks an image against all gates, and prints the results. Returns an error that names the first
/// violation.
pub fn pass(image: &Path) -> Result<(), Error> {
    let FirmwareImage { elf, note, .. } = FirmwareImage::open(image)?;
    println!("{}: commit {}, encoders: {}", image.display(), note.commit, note.encoders);
    let code = Code::read(image, &elf)?;
    let functions = code.functions().count();

    let routines = routines::forbidden(&code);
    if !routines.is_empty() {
        let names = routines.join(", ");
        return Err(Error::Emulator(format!(
            "the image computes in software what the processor cannot: {names}; something uses f64"
        )));
    }
    println!("no floating point in software: none of its routines among {functions} functions");

    let mut control = BTreeSet::new();
    for name in CONTROL.into_iter().chain(ABOVE_TASKS) {
        for function in code.reachable(code.function(name)?) {
            if function.name.contains(PANIC) {
                return Err(Error::Emulator(format!("{name} can panic")));
            }
            if !function.indirect.is_empty() {
                let name = &function.name;
                return Err(Error::Emulator(format!(
                    "{name}, in the control path, calls a function by an address in a register, so \
                     panics below it cannot be searched for; call the function by its name"
                )));
            }
            control.insert(function.address);
        }
    }
    // Without a panic handler in the image, the search below would always pass.
    if !code.functions().any(|function| function.name.contains(PANIC)) {
        return Err(Error::Emulator(format!(
            "the image has no {PANIC}: panics cannot be looked for"
        )));
    }
    let (names, count) = ([&CONTROL[..], &ABOVE_TASKS].concat().join(", "), control.len());
    println!("no panic in the image's control path: {count} functions below {names}");

    let room = stack_room(&code);
    let bound = StackBound::of(&code)?;
    println!("stack: at most {} of {room} bytes", bound.total());
    println!("  {:>5} the start, with interrupts masked; or, all at once:", bound.start);
    for (name, bytes) in &bound.entries {
        println!("  {bytes:>5} {name}");
    }
    for (function, reached) in code.indirect() {
        let how = if reached { "reached" } else { "which nothing calls by name" };
        println!(
            "  calls through a register: {} in {}, {how}",
            function.indirect.len(),
            function.name
        );
    }
    if bound.total() > room {
        return Err(Error::Emulator(format!(
            "the stack may need {} bytes and has {room}",
            bound.total()
        )));
    }
    Ok(())
}
