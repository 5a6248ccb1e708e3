//! The rows of the encoder's index: a joint whose bench has one.

use stiction::Fault;

use super::bench::Bench;
use super::rows::Row;

/// Keys of an encoder with an index in every 800 counts, 1.94 deg, without the monitors that could
/// take false counts for something else.
pub const INDEX: &[&str] = &[
    "device.index_counts=800",
    "limits.encoder_jump_deg=1",
    "limits.following_error_deg=0",
    "limits.progress_gain_deg_per_s2_per_v=off",
    "limits.stop_gain_deg_per_s2_per_v=0",
];

/// Counts that are lost or added in each tick. The index has a width of 4, which false counts of
/// the emulated board must not jump over.
const FALSE: i32 = 3;

/// Returns the rows that every bench with this index can show. Each situation has passed an index
/// before; three ticks have more false counts than the tolerance of 6.
pub fn index_rows<B: Bench>() -> Vec<Row<B>> {
    let row = |what, inject, most| Row {
        fault: Fault::IndexDeviation,
        what,
        set: INDEX,
        inject,
        within: [
            Err("no index passes at rest: it is detected in the next move, within a turn"),
            // An index in the first two ticks is too early, and the next one is a turn later: 5
            // deg/s are 41 counts a tick, 38 to 44 with the false ones.
            Ok([3, 25]),
            // From 12 deg/s on, 100 counts a tick.
            Ok([3, 11]),
        ],
        // The capture of a board is read before the tick after it.
        late: [0, 1],
        value: [7.0, most],
        cannot: |_, _| false,
    };
    let in_ticks = 26.0 * FALSE as f32 + 4.0;
    // With counts that are added, a turn of 806 counts can be over before its index comes. Then the
    // value is that way, and a tick's travel at 25 deg/s.
    let turn = 806.0 + 210.0;
    vec![
        row("3 counts are lost in each tick", |bench: &mut B, _| bench.jump(-FALSE), in_ticks),
        row("3 counts are added in each tick", |bench, _| bench.jump(FALSE), turn),
    ]
}
