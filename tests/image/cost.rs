//! Counting, and looking through the image: that both see what is there.

use std::sync::Arc;

use emulator::FirmwareImage;
use emulator::counted::{EVERYTHING_ON, count};
use emulator::firmware::blocks::Blocks;
use emulator::firmware::budgets::INTERRUPT_INSTRUCTIONS;
use emulator::firmware::stack::StackBound;
use emulator::firmware::{Code, routines};
use emulator::probe::{Points, TickCost};

use crate::common::{image, plans};

fn elf() -> Vec<u8> {
    std::fs::read(image()).unwrap()
}

fn code(elf: &[u8]) -> Result<Code, files::Error> {
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

/// A second of SRNF, counted with this said beside what turns everything on.
fn counted(set: &[&str]) -> (Vec<TickCost>, u32) {
    let image = Arc::new(FirmwareImage::open(&image()).unwrap());
    let points = Arc::new(Points::of(&code(&elf()).unwrap()).unwrap());
    let keys = [&EVERYTHING_ON[..], &["run.duration_s=1"], set].concat();
    let plans = plans("step-response", &["srnf"], &keys);
    let probe = count(&image, &points, &plans[0]).unwrap();
    (probe.ticks, probe.stack)
}

#[test]
fn the_same_run_costs_the_same_in_every_tick() {
    let (ticks, stack) = counted(&[]);
    // 50 samples after the first, and the tick whose begin shows that the last of them is over.
    assert_eq!(ticks.len(), 52);
    for tick in &ticks {
        let TickCost { interrupt, core } = tick;
        // Servo, monitors, bridge and queue are more than a hundred instructions around the core's
        // tick, and the whole is within its budget.
        assert!(
            interrupt.instructions - core.instructions > 100 && core.instructions > 100,
            "{tick:?}"
        );
        assert!(interrupt.instructions <= INTERRUPT_INSTRUCTIONS, "{tick:?}");
        // No instruction takes less than a cycle, and the mean of this code is well below three.
        for cost in [interrupt, core] {
            let cycles = cost.cycles;
            assert!((cost.instructions..3 * cost.instructions).contains(&cycles.hits), "{tick:?}");
            assert!((cycles.hits + 1..2 * cycles.hits).contains(&cycles.misses), "{tick:?}");
        }
    }
    let bound = StackBound::of(&code(&elf()).unwrap()).unwrap().total();
    assert!(stack > 1000 && stack <= bound, "{stack} bytes seen, {bound} at most");
    assert_eq!((ticks, stack), counted(&[]));
}

#[test]
fn soft_start_and_supply_are_counted() {
    // Both are a part of the core's tick. Of the least tick: the others depend on how the joint
    // moves, which is not the same without them.
    let least =
        |set: &[&str]| counted(set).0.iter().map(|tick| tick.core.instructions).min().unwrap();
    let everything = least(&[]);
    // Each alone takes some instructions away when it is off.
    let without_supply = least(&["device.nominal_supply_v=0", "device.supply_full_scale_v=0"]);
    let without_soft_start = least(&["device.soft_start_s=0"]);
    assert!(without_supply + 10 < everything, "{without_supply} and {everything}");
    assert!(without_soft_start + 5 < everything, "{without_soft_start} and {everything}");
}

/// So the budget holds with play, too, though everything is counted without it.
#[test]
fn play_costs_no_more_than_the_monitor_that_it_turns_off() {
    let longest =
        |set: &[&str]| counted(set).0.iter().map(|tick| tick.interrupt.instructions).max().unwrap();
    let (without, with) = (longest(&[]), longest(&["limits.play_deg=1"]));
    assert!(with <= without, "{with} instructions with play, {without} without");
}

#[test]
fn every_instruction_below_the_control_interrupt_has_a_time_but_those_that_end_the_program() {
    let code = code(&elf()).unwrap();
    let blocks = Blocks::below(&code, code.function("TIM3").unwrap());
    assert!(blocks.all().count() > 100);
    for (address, block) in blocks.all() {
        // udf, with any constant: where the compiler knows that nothing comes by.
        let known = block.cycles.is_ok_and(|cycles| cycles >= block.instructions);
        let ends = block.cycles.is_err_and(|unknown| unknown.first & 0xFF00 == 0xDE00);
        assert!(known || ends, "{address:#x}: {block:?}");
    }
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
