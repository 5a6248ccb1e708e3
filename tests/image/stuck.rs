//! A part that does not get anywhere ends its run: with the register that it polls, or with its last words.

use std::fs;

use host_sim::emulator::Emulation;

use crate::common::{image, plans};

/// The image with other instructions at its entry point.
fn with_entry(code: &[u8]) -> String {
    let mut bytes = fs::read(image()).unwrap();
    let word = |at: usize| u32::from_le_bytes(bytes[at..at + 4].try_into().unwrap());
    let half = |at: usize| usize::from(u16::from_le_bytes(bytes[at..at + 2].try_into().unwrap()));
    // ELF header: entry point, offset, size and number of the program headers; the lowest bit says Thumb.
    let (entry, table, size, count) = (word(24) & !1, word(28) as usize, half(42), half(44));
    let place = (0..count)
        .map(|i| table + i * size)
        .find_map(|at| {
            let (offset, address, length) = (word(at + 4), word(at + 8), word(at + 16));
            (address..address + length).contains(&entry).then(|| (offset + entry - address) as usize)
        })
        .unwrap();
    bytes[place..place + code.len()].copy_from_slice(code);
    let directory = tempfile::tempdir().unwrap();
    let path = directory.path().join("stuck");
    fs::write(&path, bytes).unwrap();
    let plans = plans("step-response", &["pd"], &["run.duration_s=1"]);
    Emulation::new(Some(&path)).unwrap().run_all(&plans[..1]).unwrap_err().to_string()
}

#[test]
fn a_loop_around_one_register_is_named() {
    // ldr r0, [pc, #4]; ldr r1, [r0]; b to the second; nop; the address of RCC_CR.
    let code = [0x01, 0x48, 0x01, 0x68, 0xFD, 0xE7, 0x00, 0xBF, 0x00, 0x38, 0x02, 0x40];
    let error = with_entry(&code);
    assert!(error.contains("stuck") && error.contains("0x40023800"), "{error}");
}

#[test]
fn a_loop_around_nothing_ends_as_well() {
    let error = with_entry(&[0xFE, 0xE7]);
    assert!(error.contains("not turned its bridge on") && error.contains("logged nothing"), "{error}");
}
