//! Forms of a log's text and of its times.

use crate::log_identification::gate;
use crate::log_identification::reading::{LogColumns, MOST, MotionLog, read_from};
use crate::log_identification::time_grid::{Stretch, TimeGrid};

fn columns(time: &str, position: &str, effort: &str) -> LogColumns {
    LogColumns {
        time: time.into(),
        position: position.into(),
        effort: effort.into(),
        motor: None,
        has_motor_current: false,
    }
}

fn read(text: &str, names: [&str; 3]) -> Result<MotionLog, String> {
    read_from("log", text.as_bytes(), &columns(names[0], names[1], names[2]))
        .map_err(|error| error.to_string())
}

/// Returns `count` rows of time, position and effort, each formatted by `row`.
fn rows(count: u32, row: impl Fn(f64) -> String) -> String {
    (0..count).map(|i| row(f64::from(i)) + "\n").collect()
}

#[test]
fn columns_are_found_in_any_order_and_form() {
    let plain = read(
        &("t,q,u\n".to_owned() + &rows(200, |i| format!("{},{},{}", 0.5 * i, 2.0 * i, -i))),
        ["t", "q", "u"],
    )
    .unwrap();
    let foreign = read(
        &("\u{feff}# a comment\nStrom; Weg ;Zeit\nA;mm;s\n".to_owned()
            + &rows(200, |i| {
                format!("{};{};{}", -i, 2.0 * i, format!("{:.1}", 0.5 * i).replace('.', ","))
            })),
        ["zeit", "Weg", "Strom"],
    )
    .unwrap();
    assert!(foreign.has_units_row && !plain.has_units_row);
    assert_eq!(foreign.time_digit, 0.1);
    let bare = read(&rows(200, |i| format!("{}\t{}\t{}", 2.0 * i, 0.5 * i, -i)), ["2", "1", "3"]);
    for other in [foreign, bare.unwrap()] {
        assert_eq!(
            [&plain.time, &plain.position, &plain.effort],
            [&other.time, &other.position, &other.effort]
        );
    }
}

/// With decimal commas a row of numbers has more commas than semicolons.
#[test]
fn a_first_row_of_numbers_is_data_with_decimal_commas_and_with_an_empty_cell() {
    let number = |of: f64| format!("{of:.2}").replace('.', ",");
    let of = |first: &str, separator: &str| {
        let data = |i: f64| [0.25 * i, -1.5 * i, 0.75 - i].map(number).join(separator);
        read(&(first.to_owned() + &rows(200, data)), ["1", "2", "3"]).unwrap()
    };
    for separator in [";", "\t"] {
        let whole = of("", separator);
        assert_eq!((whole.rows, whole.missing, whole.time_digit), (200, 0, 0.01));
        assert_eq!([whole.time[3], whole.position[3], whole.effort[3]], [0.75, -4.5, -2.25]);
        for first in ["", "NaN"] {
            let holed = of(&format!("{first}{separator}1,5{separator}2,5\n"), separator);
            assert_eq!((holed.missing, holed.first_missing), (1, Some(1)), "{first:?}");
            assert_eq!([&holed.time, &holed.effort], [&whole.time, &whole.effort]);
        }
    }
    // Where commas separate, an empty cell is one too.
    let data = |i: f64| format!("{i},{},{}", 2.0 * i, -i);
    let holed = read(&(",1,2\n".to_owned() + &rows(200, data)), ["1", "2", "3"]).unwrap();
    assert_eq!((holed.rows, holed.first_missing, holed.effort[7]), (200, Some(1), -7.0));
}

#[test]
fn a_log_that_is_longer_than_the_memory_is_averaged_in_pairs() {
    let count = 2 * MOST as u32 + 1000;
    let log = read(
        &("t,q,u\n".to_owned() + &rows(count, |i| format!("{},{},{}", i, 3.0 * i, 7.0 - i))),
        ["t", "q", "u"],
    )
    .unwrap();
    assert_eq!((log.rows, log.folded), (count.into(), 4));
    assert!(log.time.len() < MOST && log.time.len() >= MOST / 2);
    for ((t, q), u) in log.time.iter().zip(&log.position).zip(&log.effort) {
        assert!(*q == 3.0 * t && *u == 7.0 - t, "{t}, {q}, {u}");
    }
    assert_eq!(log.time[0], 1.5);
}

/// A log of q = sin t with the given times.
fn sine(times: impl Iterator<Item = f64>) -> MotionLog {
    let time: Vec<f64> = times.collect();
    let position = time.iter().map(|t| t.sin()).collect();
    let effort = time.clone();
    MotionLog { rows: time.len() as u64, time, position, effort, folded: 1, ..MotionLog::default() }
}

#[test]
fn rounded_times_are_even_and_jitter_is_interpolated() {
    let n = 2000;
    let round = |i: u32| (f64::from(i) * 0.7e-3 * 1e3).round() / 1e3;
    let log = MotionLog { first_equal: Some(2), ..sine((0..n).map(round)) };
    let grid = TimeGrid::of(&log, 1e-3).unwrap();
    assert!(!grid.is_interpolated && grid.gaps == 0);
    assert!((grid.step_s - 0.7e-3).abs() < 1e-6, "{}", grid.step_s);
    // The same times, written as finely as they are, do not increase.
    let why = TimeGrid::of(&log, 1e-9).unwrap_err();
    assert!(why.contains("row 2"), "{why}");
    // A third of a step of jitter, deterministic.
    let jitter = |i: u32| 1e-2 * (f64::from(i) + 0.33 * (f64::from(i) * 2.4).sin());
    let grid = TimeGrid::of(&sine((0..n).map(jitter)), 1e-9).unwrap();
    assert!(grid.is_interpolated);
    let Stretch { begin_s, position, effort, .. } = &grid.stretches[0];
    for (i, (q, u)) in position.iter().zip(effort).enumerate().take(n as usize - 4).skip(2) {
        let t = begin_s + grid.step_s * i as f64;
        // The cubic's error, 3 h^4/128 with steps of up to 1.7 h, and that of a straight line.
        assert!((q - t.sin()).abs() < 2e-9 && (u - t).abs() < 1e-9, "{i}: {q}, {}", t.sin());
    }
}

#[test]
fn a_gap_parts_a_log_and_lost_rows_do_not() {
    let kept = (0..3000u32).filter(|i| ![7, 8, 900].contains(i) && !(1000..1200).contains(i));
    let grid = TimeGrid::of(&sine(kept.map(|i| 1e-3 * f64::from(i))), 1e-9).unwrap();
    assert_eq!((grid.gaps, grid.stretches.len()), (1, 2));
    assert!((grid.first_gap_s.unwrap() - 0.999).abs() < 1e-9);
    assert_eq!(grid.stretches[0].position.len(), 1000);
    assert_eq!(grid.stretches[1].position.len(), 1800);
}

#[test]
fn a_counter_that_runs_over_parts_a_log_and_a_quick_motion_does_not() {
    let mut log = sine((0..6000u32).map(|i| 1e-3 * f64::from(i)));
    // A stroke within 20 ms, as quick as machines are.
    let stroke = |t: f64| if t < 3.0 { 0.0 } else { 1.0 - (-(t - 3.0) / 0.005).exp() };
    log.position = log.time.iter().map(|t| t.sin() + stroke(*t)).collect();
    assert!(TimeGrid::of(&log, 1e-9).unwrap().jumps_s.is_empty());
    log.position.iter_mut().skip(2000).for_each(|q| *q -= 4.0);
    let grid = TimeGrid::of(&log, 1e-9).unwrap();
    assert_eq!((grid.gaps, grid.jumps_s, grid.stretches.len()), (0, vec![2.0], 2));
}

#[test]
fn an_effort_is_saturated_where_it_is_cut_and_not_where_it_turns_or_is_switched() {
    let grid = |of: fn(f64) -> f64| TimeGrid {
        step_s: 1e-3,
        stretches: vec![Stretch {
            begin_s: 0.0,
            position: vec![0.0; 10_000],
            effort: (0..10_000).map(|i| of(f64::from(i) * 1e-3)).collect(),
            beside: Vec::new(),
            carried: Vec::new(),
        }],
        gaps: 0,
        first_gap_s: None,
        jumps_s: Vec::new(),
        is_interpolated: false,
    };
    let cut = grid(|t| (6.0 * t).sin().min(0.95));
    assert_eq!(gate::saturated(&cut), [None, Some(0.95)]);
    assert_eq!(gate::saturated(&grid(|t| (6.0 * t).sin())), [None; 2]);
    // A sine of 100 codes lies longest at its ends, and is not cut.
    assert_eq!(gate::saturated(&grid(|t| (100.0 * (6.0 * t).sin()).round())), [None; 2]);
    assert_eq!(gate::saturated(&grid(|t| (6.0 * t).sin().signum())), [None; 2]);
}
