//! The rows of the motor's current: a joint whose bench has a sensor of it.

use simulator::device::simulated::{MotorWires, ShuntState};
use stiction::Fault;

use super::bench::Bench;
use super::rows::Row;

/// Keys of a sensor of +-3 A, which 5 V through 2 ohm do not reach. Its limit of the current is
/// off, so that a law is saturated as without it.
pub const SENSOR: &[&str] = &[
    "current_sensor.full_scale_a=3",
    "current_sensor.resistance_ohm=2",
    "current_sensor.peak_a=off",
    "limits.back_emf_v_per_deg_per_s=0.01",
    "limits.progress_gain_deg_per_s2_per_v=off",
    "limits.stop_gain_deg_per_s2_per_v=0",
    "limits.following_error_deg=0",
];

const NO_EFFORT: &str = "an effort below 1.1 V, which brushes may lose, shows no missing current";

/// Returns the rows that every bench with this sensor can show. A condition has to hold for five
/// ticks, as long as the velocity window; the lag of 20 ms is one tick.
pub fn current_rows<B: Bench>() -> Vec<Row<B>> {
    let row = |fault, what, inject, within, value| Row {
        fault,
        what,
        set: SENSOR,
        inject,
        within,
        // A board has converted the current before its wires change.
        late: [0, 1],
        value,
        cannot: |_, _| false,
    };
    vec![
        row(
            Fault::OverCurrent,
            "a short of 0.1 ohm in the motor",
            |bench, _| bench.motor(MotorWires::Shorted, ShuntState::Sound),
            [
                Err("the effort of a joint at rest can be zero"),
                // 0.48 V of friction cause 4.8 A, or 5 V 50 A; the next tick reads it.
                Ok([1, 2]),
                Ok([1, 2]),
            ],
            // `trip_a`, to the end of the range.
            [2.7, 3.01],
        ),
        row(
            Fault::CurrentSensor,
            "the wires of the shunt are swapped",
            |bench, _| bench.motor(MotorWires::Sound, ShuntState::Reversed),
            [
                Err(NO_EFFORT),
                Err(NO_EFFORT),
                // From 2.5 A to -2.5 A in two ticks of the lag, and five ticks.
                Ok([5, 9]),
            ],
            [0.06, 2.51],
        ),
        row(
            Fault::MotorOpen,
            "a wire of the motor is cut, and the joint has 0.8 V more friction",
            |bench, _| {
                // So it loses a tenth of its speed: else its sensor is dead.
                bench.brake(0.8);
                bench.motor(MotorWires::Open, ShuntState::Sound);
            },
            [
                Err(NO_EFFORT),
                Err(NO_EFFORT),
                // 2.5 A fall to a quarter of what 3.5 V cause in two ticks or three, and five.
                Ok([5, 9]),
            ],
            [0.0, 0.5],
        ),
        row(
            Fault::MotorShorted,
            "1.5 A, whatever the effort is",
            // 2475 mV are 1.5 times the middle.
            |bench, _| bench.motor(MotorWires::Sound, ShuntState::Stuck(2475)),
            [
                // Twice 0.2 A, or twice what 0.5 V and a law's corrections cause.
                Ok([5, 8]),
                Ok([5, 9]),
                Err("twice the current of 5 V is beyond the range: over-current"),
            ],
            [0.7, 1.51],
        ),
    ]
}
