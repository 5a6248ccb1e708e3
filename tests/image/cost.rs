//! Counting, and looking through the image: that both see what is there.

use std::sync::Arc;

use host_sim::emulator::probe::{Points, TickCost};
use host_sim::firmware::stack::Bound;
use host_sim::firmware::{Code, routines};

use crate::common::{emulation, image, plans};

fn elf() -> Vec<u8> {
    std::fs::read(image()).unwrap()
}

fn code(elf: &[u8]) -> Result<Code, host_sim::Error> {
    Code::read(&image(), elf)
}

/// Sections of this type are not seen any more.
fn without_sections_of(kind: u32, mut elf: Vec<u8>) -> Vec<u8> {
    let word = |elf: &[u8], at: usize| u32::from_le_bytes(elf[at..at + 4].try_into().unwrap());
    let (table, count) = (word(&elf, 32) as usize, usize::from(elf[48]));
    for header in (0..count).map(|i| table + 40 * i) {
        if word(&elf, header + 4) == kind {
            elf[header + 4..header + 8].fill(0);
        }
    }
    elf
}

#[test]
fn the_same_run_costs_the_same_in_every_tick() {
    let run = || -> (Vec<TickCost>, u32) {
        let mut emulation = emulation();
        emulation.points = Some(Arc::new(Points::of(&code(&elf()).unwrap()).unwrap()));
        let plans = plans("step-response", &["srnf"], &["run.duration_s=1"]);
        let run = emulation.run_all(&plans[..1]).unwrap().remove(0);
        let probe = run.probe.unwrap();
        assert!(!probe.disturbed);
        // 50 samples after the first; the last interrupt may be cut off.
        assert!((50..=52).contains(&probe.ticks.len()), "{}", probe.ticks.len());
        (probe.ticks, probe.stack)
    };
    let (ticks, stack) = run();
    for tick in &ticks {
        // Servo, monitors, bridge and queue are more than a hundred instructions around the core's tick, and the whole is
        // within its budget.
        assert!(tick.interrupt - tick.core > 100 && tick.core > 100, "{tick:?}");
        assert!(tick.interrupt <= 900, "{tick:?}");
    }
    let bound = Bound::of(&code(&elf()).unwrap()).unwrap().total();
    assert!(stack > 1000 && stack <= bound, "{stack} bytes seen, {bound} at most");
    assert_eq!((ticks, stack), run());
}

#[test]
fn an_image_whose_symbols_are_stripped_passes_no_gate() {
    const SYMTAB: u32 = 2;
    assert!(routines::forbidden(&code(&elf()).unwrap()).is_empty());
    let error = code(&without_sections_of(SYMTAB, elf())).unwrap_err().to_string();
    assert!(error.contains("stripped"), "{error}");
}

#[test]
fn a_routine_of_double_precision_is_found() {
    let mut elf = elf();
    let (innocent, guilty) = (b"\0__aeabi_memclr4\0", b"\0__aeabi_dmul\0\0\0\0");
    let at = elf.windows(innocent.len()).position(|window| window == innocent).unwrap();
    elf[at..at + guilty.len()].copy_from_slice(guilty);
    assert_eq!(routines::forbidden(&code(&elf).unwrap()), ["__aeabi_dmul"]);
}

#[test]
fn the_control_interrupt_calls_the_core_and_cannot_reach_a_panic() {
    let code = code(&elf()).unwrap();
    let reachable = |name: &str| -> Vec<String> {
        code.reachable(code.function(name).unwrap()).into_iter().map(|f| f.name.clone()).collect()
    };
    let names = reachable("TIM3");
    assert!(names.iter().any(|name| name.contains("7control")), "{names:?}");
    assert!(!names.iter().any(|name| name.contains("rust_begin_unwind")), "{names:?}");
    // The log may: the same search finds it there.
    assert!(reachable("SPI1").iter().any(|name| name.contains("rust_begin_unwind")));
}
