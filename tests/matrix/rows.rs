//! The rows of the matrix: the cause of a fault, and the ticks that its detection can take.

use files::encoder::Wires;
use stiction::Fault;

use super::bench::{Bench, Situation};

/// Ticks from the injection to the detection, at least and at most, for each situation; or the
/// reason why the fault cannot be there.
pub type Within = [Result<[u32; 2], &'static str>; 3];

/// One cause of a fault.
pub struct Row<B> {
    /// The fault that has to be reported.
    pub fault: Fault,
    /// The cause in words.
    pub what: &'static str,
    /// Keys that keep other monitors from detecting the cause earlier.
    pub set: &'static [&'static str],
    /// Injects the cause. Called before every tick from the injection on.
    pub inject: fn(&mut B, u32),
    /// Bounds of the detection.
    pub within: Within,
    /// Ticks that a bench which reads its inputs late can add to the bounds, at least and at most.
    pub late: [u32; 2],
    /// Bounds of the report's value, without its sign.
    pub value: [f32; 2],
    /// Returns whether a law cannot show the fault in a situation.
    pub cannot: fn(&str, Situation) -> bool,
}

/// Returns the same bounds for every situation.
pub const fn all(within: [u32; 2]) -> Within {
    [Ok(within), Ok(within), Ok(within)]
}

const SUPPLY: &[&str] = &["device.supply_full_scale_v=24", "device.nominal_supply_v=12"];
const NO_DEMAND: &str = "a joint at rest is not driven: a block changes nothing";
const NO_EDGE: &str = "at rest it is detected at the next move: tests of dead encoders";

/// Returns the rows that every bench can show. The position comes first: noise of the later rows
/// moves the place that the device calls zero.
pub fn rows<B: Bench>() -> Vec<Row<B>> {
    let row = |fault, what, inject, within, value| Row {
        fault,
        what,
        set: &[],
        inject,
        within,
        late: [0, 0],
        value,
        cannot: |_, _| false,
    };
    let block: fn(&mut B, u32) = |bench, _| bench.brake(100.0);
    vec![
        Row {
            set: &[
                "limits.position_min_deg=-30",
                "limits.position_max_deg=30",
                "encoder.counter_bits=32",
                "limits.encoder_jump_deg=0",
                "limits.overspeed_deg_per_s=0",
                "limits.following_error_deg=0",
            ],
            ..row(
                Fault::PositionLimit,
                "put beyond the range",
                |bench, tick| {
                    if tick == 0 {
                        bench.push(30.1, 0.0);
                    }
                },
                all([1, 1]),
                [30.0, 30.2],
            )
        },
        Row {
            set: &["limits.overspeed_deg_per_s=40", "limits.encoder_jump_deg=3"],
            ..row(
                Fault::Overspeed,
                "driven to 1.3 times the limit from outside",
                |bench, _| {
                    let position = bench.position_deg();
                    bench.push(position, 52.0);
                },
                [
                    Err("a joint at rest has no speed; one that is thrown is not at rest: the \
                         next column"),
                    // The velocity shows it within the window of the regression.
                    Ok([2, 6]),
                    Ok([2, 6]),
                ],
                [40.0, 60.0],
            )
        },
        row(
            Fault::Stall,
            "the joint is blocked",
            block,
            [
                Err(NO_DEMAND),
                // 41 counts a tick and more, none two ticks later. A block is hit between two
                // ticks, so the tick in which it is hit can have some.
                Ok([2, 3]),
                Ok([2, 3]),
            ],
            // Any effort of the drive.
            [0.0, 5.0],
        ),
        Row {
            set: &["limits.stop_gain_deg_per_s2_per_v=0"],
            ..row(
                Fault::Stall,
                "the joint is blocked, and the stop may be as hard as it likes",
                block,
                [
                    Err(NO_DEMAND),
                    // From 0.5 V of cruising effort to 0.8 V at 5 deg/s is up to 0.3 s; then 0.2 s,
                    // or 0.125 s of 2 V and more.
                    Ok([7, 25]),
                    Ok([7, 12]),
                ],
                // Twice the breakaway effort of 0.4 V, to the full scale.
                [0.8 - 0.005, 5.0],
            )
        },
        Row {
            late: [0, 1],
            ..row(
                Fault::Stall,
                "both encoder wires cut",
                |bench, tick| {
                    if tick == 0 {
                        bench.rewire(Wires::Cut);
                    }
                },
                // Counts two ticks ago, and none now.
                [Err(NO_EDGE), Ok([1, 1]), Ok([1, 1])],
                [0.0, 5.0],
            )
        },
        Row {
            late: [0, 1],
            ..row(
                Fault::Stall,
                "one encoder wire cut",
                |bench, tick| {
                    if tick == 0 {
                        bench.rewire(Wires::OneCut);
                    }
                },
                [Err(NO_EDGE), Ok([1, 1]), Ok([1, 1])],
                [0.0, 5.0],
            )
        },
        row(
            Fault::EncoderJump,
            "3000 edges of noise within a tick",
            |bench, tick| {
                if tick == 0 {
                    bench.jump(3000);
                }
            },
            all([1, 1]),
            // 3000 counts of 0.00242 deg, and what the joint moves in a tick: 20 deg/s at most.
            [7.26 - 0.4, 7.26 + 0.4],
        ),
        Row {
            // PD's own limit, under every law: the one that `robust` derives is 2.76 deg.
            set: &["limits.stall_v=0", "limits.following_error_deg=5"],
            ..row(
                Fault::FollowingError,
                "pushed away from its set point, 15 deg/s",
                |bench, _| {
                    let position = bench.position_deg();
                    bench.push(position - 0.3, -15.0);
                },
                [
                    // It takes 5 deg at 0.3 deg a tick, less what the joint gives way by itself.
                    Ok([8, 18]),
                    Ok([6, 18]),
                    // The way that the joint had gone since the jump counts, too.
                    Ok([8, 40]),
                ],
                // The full scale's 5 deg at 1 V/deg, to a tick's way beyond, and the step of 20
                // deg.
                [5.0, 26.0],
            )
        },
        Row {
            set: SUPPLY,
            // Three readings in a row; a board has taken one of them before the change.
            late: [1, 1],
            ..row(
                Fault::SupplyLow,
                "6 V of 12 V",
                |bench, _| bench.supply(0.25),
                all([3, 3]),
                [5.99, 6.01],
            )
        },
        Row {
            set: SUPPLY,
            late: [1, 1],
            ..row(
                Fault::SupplyHigh,
                "18 V of 12 V",
                |bench, _| bench.supply(0.75),
                all([3, 3]),
                [17.99, 18.01],
            )
        },
        Row {
            set: &["limits.stall_v=0", "limits.thermal_s=1", "limits.continuous_v=2.5"],
            ..row(
                Fault::Overheat,
                "full effort against a block",
                block,
                [
                    Err("the effort that a joint can rest with heats no motor beyond its limit"),
                    Err("a blocked joint is saturated in the end: the next column"),
                    // 1 s ln(1 / (1 - 1/4)) = 0.288 s from cold; some heat is there already.
                    Ok([8, 16]),
                ],
                [2.5, 2.6],
            )
        },
        Row {
            // A joint that moves would brake before the bridge is off.
            set: &["limits.overspeed_deg_per_s=0", "limits.encoder_jump_deg=0", "device.stop_s=0"],
            ..row(
                Fault::LinkTimeout,
                "the link is silent",
                |_, _| {},
                // 0.5 s of 20 ms; the last message came just after a tick.
                all([26, 26]),
                [0.49, 0.53],
            )
        },
    ]
}
