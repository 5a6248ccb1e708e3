//! The rows of the matrix: one way to cause a fault, and the ticks that its detection may take.

use simulator::device::simulated::{SimulatedDevice, Wires};
use stiction::Fault;

/// The cause of a fault, applied in every tick from the injection on.
pub type Inject = fn(&mut SimulatedDevice, u32);

pub struct Row {
    pub fault: Fault,
    pub what: &'static str,
    /// Keys that take the row's fault out of the shadow of those that would be seen earlier.
    pub set: &'static [&'static str],
    pub inject: Inject,
    /// What ends the cause again.
    pub mend: fn(&mut SimulatedDevice),
    /// Ticks from the injection to the detection, at least and at most, for each situation; or the
    /// reason why the fault cannot be there.
    pub within: [Result<[u32; 2], &'static str>; 3],
}

const SUPPLY: &[&str] = &["device.supply_full_scale_v=24", "device.nominal_supply_v=12"];

pub fn sound(simulated: &mut SimulatedDevice) {
    simulated.wires = Wires::Sound;
    simulated.supply = 2048;
    simulated.brake_v = 0.0;
}

pub fn rows() -> Vec<Row> {
    let all = |within| [Ok(within), Ok(within), Ok(within)];
    vec![
        Row {
            fault: Fault::EncoderJump,
            what: "3000 counts at once",
            set: &[],
            inject: |simulated, tick| {
                if tick == 0 {
                    simulated.jump(3000);
                }
            },
            mend: sound,
            within: all([1, 1]),
        },
        Row {
            fault: Fault::Stall,
            what: "the joint is blocked",
            set: &[],
            inject: |simulated, _| simulated.brake_v = 100.0,
            mend: sound,
            within: [
                Err("a joint at rest is not asked to move: blocked or not is the same"),
                // 41 counts a tick and more, none two ticks later. A block is hit between two
                // ticks, so the tick in which it is hit may have some.
                Ok([2, 3]),
                Ok([2, 3]),
            ],
        },
        Row {
            fault: Fault::Stall,
            what: "the joint is blocked, and the stop may be as hard as it likes",
            set: &["limits.stop_gain_deg_per_s2_per_v=0"],
            inject: |simulated, _| simulated.brake_v = 100.0,
            mend: sound,
            within: [
                Err("a joint at rest is not asked to move: blocked or not is the same"),
                // From 0.5 V of cruising effort to 0.8 V at 5 deg/s is up to 0.3 s; then 0.2 s, or
                // 0.125 s of 2 V and more.
                Ok([7, 25]),
                Ok([7, 12]),
            ],
        },
        Row {
            fault: Fault::Stall,
            what: "both encoder wires cut",
            set: &[],
            inject: |simulated, _| simulated.wires = Wires::Cut,
            mend: sound,
            within: [
                Err("at rest it is seen at the next move: dead_encoder.rs"),
                // Counts two ticks ago, and none now.
                Ok([1, 1]),
                Ok([1, 1]),
            ],
        },
        Row {
            fault: Fault::Stall,
            what: "one encoder wire cut",
            set: &[],
            inject: |simulated, _| simulated.wires = Wires::OneCut,
            mend: sound,
            within: [
                Err("at rest it is seen at the next move: dead_encoder.rs"),
                // Counts two ticks ago, and none now.
                Ok([1, 1]),
                Ok([1, 1]),
            ],
        },
        Row {
            fault: Fault::FollowingError,
            what: "pushed away from its set point, 15 deg/s",
            // PD's own limit, under every law: the one that `robust` derives is 2.76 deg.
            set: &["limits.stall_v=0", "limits.following_error_deg=5"],
            inject: |simulated, _| {
                let position = simulated.position_deg();
                simulated.push(position - 0.3, -15.0);
            },
            mend: sound,
            within: [
                // It takes 5 deg at 0.3 deg a tick, less what the joint gives way by itself.
                Ok([8, 18]),
                Ok([6, 18]),
                // The way that the joint had gone since the jump counts, too.
                Ok([8, 40]),
            ],
        },
        Row {
            fault: Fault::Overspeed,
            what: "driven to 1.3 times the limit from outside",
            set: &["limits.overspeed_deg_per_s=40", "limits.encoder_jump_deg=3"],
            inject: |simulated, _| {
                let position = simulated.position_deg();
                simulated.push(position, 52.0);
            },
            mend: sound,
            within: [
                Err("a joint at rest has no speed; one that is thrown is not at rest: the next \
                     column"),
                // The velocity shows it within the window of the regression.
                Ok([2, 6]),
                Ok([2, 6]),
            ],
        },
        Row {
            fault: Fault::PositionLimit,
            what: "put beyond the range",
            set: &[
                "limits.position_min_deg=-100",
                "limits.position_max_deg=110",
                "encoder.counter_bits=32",
                "limits.encoder_jump_deg=0",
                "limits.overspeed_deg_per_s=0",
                "limits.following_error_deg=0",
            ],
            inject: |simulated, _| simulated.push(110.1, 0.0),
            mend: |simulated| simulated.push(50.0, 0.0),
            within: all([1, 1]),
        },
        Row {
            fault: Fault::SupplyLow,
            what: "6 V of 12 V",
            set: SUPPLY,
            inject: |simulated, _| simulated.supply = 1024,
            mend: sound,
            within: all([3, 3]),
        },
        Row {
            fault: Fault::SupplyHigh,
            what: "18 V of 12 V",
            set: SUPPLY,
            inject: |simulated, _| simulated.supply = 3072,
            mend: sound,
            within: all([3, 3]),
        },
        Row {
            fault: Fault::Overheat,
            what: "full effort against a block",
            set: &["limits.stall_v=0", "limits.thermal_s=1", "limits.continuous_v=2.5"],
            inject: |simulated, _| simulated.brake_v = 100.0,
            mend: |simulated| {
                sound(simulated);
                simulated.ticks(200);
            },
            within: [
                Err("the effort that a joint can rest with is less than any motor bears for ever"),
                Err("a blocked joint is saturated in the end: the next column"),
                // 1 s ln(1 / (1 - 1/4)) = 0.288 s from cold; some heat is there already.
                Ok([8, 16]),
            ],
        },
        Row {
            fault: Fault::LinkTimeout,
            what: "the link is silent",
            set: &["limits.overspeed_deg_per_s=0", "limits.encoder_jump_deg=0"],
            inject: |_, _| {},
            mend: sound,
            // That is 0.5 s of 20 ms; the last word was said in the tick before.
            within: all([26, 26]),
        },
    ]
}

/// The faults that the board reports. The core has to obey at once.
pub const FROM_THE_BOARD: [Fault; 5] =
    [Fault::Overrun, Fault::BreakInput, Fault::ClockLost, Fault::Panic, Fault::Watchdog];

/// The other faults, and why they are in no row.
pub const ELSEWHERE: [(Fault, &str); 9] = [
    (Fault::NonFinite, "no parameters that are accepted lead there (src/servo/tests.rs)"),
    (
        Fault::NoParameters,
        "only at boot: parameters cannot go while it is armed (tests/device/link/parameters.rs)",
    ),
    (Fault::BadParameters, "the same"),
    (Fault::ClockAbsent, "only at boot; tests/image/hardware_faults.rs"),
    (Fault::ClockWrong, "only at boot; tests/image/supply_and_crystal.rs"),
    (Fault::BrownOut, "the part is reset: nothing runs that could detect it"),
    (Fault::ResetWhileArmed, "reported after the reset; tests/image/hardware_faults.rs"),
    (Fault::HardFault, "the part is reset"),
    (Fault::EncoderReversed, "only in the first move: tests of its own, in reversed_encoder.rs"),
];
