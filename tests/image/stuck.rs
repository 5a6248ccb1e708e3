//! A part that does not get anywhere ends its run: with the register that it polls, or with its
//! last words.

use std::fs;

use emulator::{Emulation, FirmwareImage};

use crate::common::{image, plans};

/// ldr r0, [pc, #4]; ldr r1, [r0]; b to the second; nop; the address of RCC_CR.
const POLL_RCC_CR: [u8; 12] =
    [0x01, 0x48, 0x01, 0x68, 0xFD, 0xE7, 0x00, 0xBF, 0x00, 0x38, 0x02, 0x40];

/// The image with other instructions at an address; `at` gets the ELF file.
pub fn patched(at: impl Fn(&[u8]) -> u32, code: &[u8]) -> Vec<u8> {
    let mut bytes = fs::read(image()).unwrap();
    let code_at = at(&bytes) & !1;
    let word = |at: usize| u32::from_le_bytes(bytes[at..at + 4].try_into().unwrap());
    let half = |at: usize| usize::from(u16::from_le_bytes(bytes[at..at + 2].try_into().unwrap()));
    // ELF header: offset, size and number of the program headers.
    let (table, size, count) = (word(28) as usize, half(42), half(44));
    let place = (0..count)
        .map(|i| table + i * size)
        .find_map(|at| {
            let (offset, address, length) = (word(at + 4), word(at + 8), word(at + 16));
            (address..address + length)
                .contains(&code_at)
                .then(|| (offset + code_at - address) as usize)
        })
        .unwrap();
    bytes[place..place + code.len()].copy_from_slice(code);
    bytes
}

/// What a run of such an image says.
fn with_code(at: impl Fn(&[u8]) -> u32, code: &[u8], controller: &str, duration_s: u32) -> String {
    let directory = tempfile::tempdir().unwrap();
    let path = directory.path().join("stuck");
    fs::write(&path, patched(at, code)).unwrap();
    let plans = plans("step-response", &[controller], &[&format!("run.duration_s={duration_s}")]);
    Emulation::new(Some(&path)).unwrap().run_all(&plans[..1]).unwrap_err().to_string()
}

/// The entry point; the lowest bit says Thumb.
fn entry(elf: &[u8]) -> u32 {
    u32::from_le_bytes(elf[24..28].try_into().unwrap())
}

/// A function of the image; `name` is a piece of its mangled name.
pub fn function(name: &str) -> u32 {
    let found = FirmwareImage::open(&image()).unwrap().functions(name);
    assert_eq!(found.len(), 1, "{name}: {found:x?}");
    found[0] as u32
}

#[test]
fn a_loop_around_one_register_is_named() {
    let error = with_code(entry, &POLL_RCC_CR, "pd", 1);
    assert!(error.contains("stuck") && error.contains("0x40023800"), "{error}");
}

#[test]
fn a_loop_around_nothing_ends_as_well() {
    let error = with_code(entry, &[0xFE, 0xE7], "pd", 1);
    assert!(
        error.contains("not turned its bridge on") && error.contains("logged nothing"),
        "{error}"
    );
}

#[test]
fn a_control_task_that_polls_in_mid_move_is_ended_within_a_tick() {
    // SRNF's hyperbolic tangent needs the exponential near the target only: the joint has been on
    // its way for a while.
    let error = with_code(|_| function("expm1f"), &POLL_RCC_CR, "srnf", 10);
    // Its duty is still that of the tick before, or the tick is missed.
    assert!(error.contains("tick") && !error.contains("not turned its bridge on"), "{error}");
}

#[test]
fn a_task_that_polls_below_a_healthy_control_task_is_named() {
    // The dispatcher of the log: control and watchdog go on above it, and the motor with them.
    let error = with_code(|_| function("SPI1"), &POLL_RCC_CR, "pd", 10);
    assert!(
        error.contains("stuck") && error.contains("0x40023800") && error.contains("(SPI1)"),
        "{error}"
    );
}
