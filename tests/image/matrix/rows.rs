//! What is done to joint, wires and board, and within how many ticks it has to be seen.

use emulator::board_under_test::HaltedBoard;
use emulator::fault_injection::Injection;
use files::encoder::Wires;
use stiction::Fault;
use stiction::control::laws::Gains;

use crate::fault_injection::MS;

/// What the bridge's supply has to be measured for: 12 V are half of the pin's range.
const SUPPLY: &[&str] = &["device.supply_full_scale_v=24", "device.nominal_supply_v=12"];

pub struct Row {
    pub fault: Fault,
    pub what: &'static str,
    /// Keys that take the row's fault out of the shadow of those that would be seen earlier.
    pub set: &'static [&'static str],
    /// What is done in every tick from the injection on.
    pub inject: fn(&mut HaltedBoard<'_>, u32),
    /// Ticks from the injection to the detection, at least and at most, by situation; or why it
    /// cannot be.
    pub within: [Result<[u32; 2], &'static str>; 3],
    /// What the value that tripped it may be, without its sign.
    pub value: [f32; 2],
}

/// A fault that has no value keeps zero.
const NONE: [f32; 2] = [0.0, 0.0];

const fn all(within: [u32; 2]) -> [Result<[u32; 2], &'static str>; 3] {
    [Ok(within), Ok(within), Ok(within)]
}

const NO_EDGE: &str = "at rest it is seen at the next move: a row of its own";

pub const STALL: Row = Row {
    fault: Fault::Stall,
    what: "the joint is blocked",
    set: &[],
    inject: |halted, _| halted.plant().brake_v = 100.0,
    within: [
        Err("a joint at rest is not asked to move: blocked or not is the same"),
        // 41 counts a tick and more, none two ticks later; the tick in which the block is hit, and
        // the one before it is noticed, may have some.
        Ok([2, 3]),
        Ok([2, 3]),
    ],
    // Whatever effort there is.
    value: [0.0, 5.0],
};

pub const HELD: Row = Row {
    what: "the joint is blocked, and the stop may be as hard as it likes",
    set: &["limits.stop_gain_deg_per_s2_per_v=0"],
    within: [
        STALL.within[0],
        // From 0.5 V of cruising effort to 0.8 V at 5 deg/s is up to 0.3 s; then 0.2 s, or 0.125 s
        // of 2 V and more.
        Ok([7, 25]),
        Ok([7, 12]),
    ],
    // Twice the breakaway effort of 0.4 V, to the full scale.
    value: [0.8 - 0.005, 5.0],
    ..STALL
};

pub const CUT: Row = Row {
    what: "both encoder wires cut",
    inject: |halted, tick| {
        if tick == 0 {
            halted.rewire(Wires::Cut);
        }
    },
    // Counts two ticks ago and none now, but for those before the cut in the first tick.
    within: [Err(NO_EDGE), Ok([1, 2]), Ok([1, 2])],
    ..STALL
};

pub const ONE_CUT: Row = Row {
    what: "one encoder wire cut",
    inject: |halted, tick| {
        if tick == 0 {
            halted.rewire(Wires::OneCut);
        }
    },
    ..CUT
};

/// From rest, and the injection is the step: its error asks for hardly more than the breakaway.
pub const DEAD: Row = Row {
    what: "both encoder wires cut at rest, then a step of 0.41 deg",
    inject: |_, _| {},
    within: [
        // 0.2 V s are 2049 codes of a tick, and the least excess that counts is 10 of them, an
        // eighth of 0.4 V: 205 ticks. A tick may be under way when the step is taken.
        Ok([1, 206]),
        Err("both wires cut, in a row of its own"),
        Err("both wires cut, in a row of its own"),
    ],
    ..STALL
};

pub const JUMP: Row = Row {
    fault: Fault::EncoderJump,
    what: "3000 edges of noise within a tick",
    set: &[],
    inject: |halted, tick| {
        if tick == 0 {
            halted.jump(3000);
        }
    },
    within: all([1, 1]),
    // 3000 counts of 0.00242 deg, and what the joint moves in a tick: 20 deg/s at most.
    value: [7.26 - 0.4, 7.26 + 0.4],
};

pub const FOLLOWING: Row = Row {
    fault: Fault::FollowingError,
    what: "pushed away from its set point, 15 deg/s",
    // PD's own limit, under every law: the one that `robust` derives is 2.76 deg.
    set: &["limits.stall_v=0", "limits.following_error_deg=5"],
    inject: |halted, _| {
        let position = halted.plant().position_deg();
        halted.push(position - 0.3, -15.0);
    },
    within: [
        // 5 deg at 0.3 deg a tick, less what the joint gives way by itself.
        Ok([8, 18]),
        Ok([6, 18]),
        // Also the way that it had gone since the jump.
        Ok([8, 40]),
    ],
    // The full scale's 5 deg at 1 V/deg, to a tick's way beyond, and the step of 20 deg.
    value: [5.0, 26.0],
};

pub const OVERSPEED: Row = Row {
    fault: Fault::Overspeed,
    what: "driven to 1.3 times the limit from outside",
    set: &["limits.overspeed_deg_per_s=40", "limits.encoder_jump_deg=3"],
    inject: |halted, _| {
        let position = halted.plant().position_deg();
        halted.push(position, 52.0);
    },
    within: [
        Err("a joint at rest has no speed; one that is thrown is not at rest: the next column"),
        // Within the window of the regression.
        Ok([2, 6]),
        Ok([2, 6]),
    ],
    value: [40.0, 60.0],
};

pub const POSITION: Row = Row {
    fault: Fault::PositionLimit,
    what: "put beyond the range",
    set: &[
        "limits.position_min_deg=-30",
        "limits.position_max_deg=30",
        "encoder.counter_bits=32",
        "limits.encoder_jump_deg=0",
        "limits.overspeed_deg_per_s=0",
        "limits.following_error_deg=0",
    ],
    inject: |halted, tick| {
        if tick == 0 {
            halted.push(30.1, 0.0);
        }
    },
    within: all([1, 1]),
    value: [30.0, 30.2],
};

pub const SUPPLY_LOW: Row = Row {
    fault: Fault::SupplyLow,
    what: "6 V of 12 V",
    set: SUPPLY,
    inject: |halted, _| halted.board().supply(825),
    // Three readings in a row, and the one that had been taken before.
    within: all([4, 4]),
    value: [5.99, 6.01],
};

pub const SUPPLY_HIGH: Row = Row {
    fault: Fault::SupplyHigh,
    what: "18 V of 12 V",
    inject: |halted, _| halted.board().supply(2475),
    value: [17.99, 18.01],
    ..SUPPLY_LOW
};

pub const OVERHEAT: Row = Row {
    fault: Fault::Overheat,
    what: "full effort against a block",
    set: &["limits.stall_v=0", "limits.thermal_s=1", "limits.continuous_v=2.5"],
    inject: |halted, _| halted.plant().brake_v = 100.0,
    within: [
        Err("the effort that a joint can rest with is less than any motor bears for ever"),
        Err("a blocked joint is saturated in the end: the next column"),
        // 1 s ln(1 / (1 - 1/4)) = 0.288 s from cold; some heat is there already.
        Ok([8, 16]),
    ],
    value: [2.5, 2.6],
};

pub const NON_FINITE: Row = Row {
    fault: Fault::NonFinite,
    what: "a bit error in the RAM makes a gain not a number",
    set: &[],
    inject: |halted, tick| {
        if tick == 0 {
            spoil_gain(halted);
        }
    },
    within: all([1, 1]),
    value: NONE,
};

/// Kd of PD, of SRNF, and of the other laws, V s/deg.
const KD: [f32; 3] = [0.15, 0.25, 0.17];

/// Returns whether a word is a gain that the law in the drive computes with: Kd, and the inertia
/// that `robust` has in its place.
fn is_gain(word: u32) -> bool {
    let gain = f32::from_bits(word);
    let inertia = Gains::EXAMPLES.iter().find_map(|law| match law {
        Gains::Robust(gains) => Some(gains.inertia),
        _ => None,
    });
    KD.contains(&gain) || Some(gain) == inertia
}

/// No parameters that are accepted lead to a value that is not finite, so the servo's own copy of a
/// gain is changed.
fn spoil_gain(halted: &mut HaltedBoard<'_>) {
    let mut spoiled = 0;
    for (address, length) in crate::common::firmware().variable("_servo") {
        let words = halted.words(address, length / 4).unwrap();
        for (index, _) in words.iter().enumerate().filter(|(_, word)| is_gain(**word)) {
            halted.overwrite(address + 4 * index as u64, f32::NAN.to_bits()).unwrap();
            spoiled += 1;
        }
    }
    assert!(spoiled > 0, "the servo holds no gain");
}

pub const SILENCE: Row = Row {
    fault: Fault::LinkTimeout,
    what: "the link is silent",
    set: &["limits.overspeed_deg_per_s=0", "limits.encoder_jump_deg=0"],
    inject: |_, _| {},
    // 0.5 s of 20 ms; the last word was said just after a tick.
    within: all([26, 26]),
    value: [0.49, 0.53],
};

/// What the board reports itself.
pub struct Reported {
    pub fault: Fault,
    /// What happens, each so long after the first, ns.
    pub injections: Vec<(u64, Injection)>,
    /// Within what time the bridge has to be off, ns.
    pub limit: u64,
}

pub fn reported() -> Vec<Reported> {
    let corrupt = |(address, length)| (0, Injection::Corrupts { address, length, to: 1 });
    let lock: Vec<_> =
        crate::common::firmware().variable("RTT_ENCODER").into_iter().map(corrupt).collect();
    let row = |fault, injections: &[(u64, Injection)], limit| Reported {
        fault,
        injections: injections.to_vec(),
        limit,
    };
    let broken = [(0, Injection::Break), (100 * MS, Injection::BreakReleased)];
    let stalled = [(0, Injection::CoreStalls), (30 * MS, Injection::CoreGoesOn)];
    vec![
        // In hardware.
        row(Fault::BreakInput, &broken, 0),
        // The first control tick after the stall is reported as late.
        row(Fault::Overrun, &stalled, 30 * MS + super::INTERRUPT_NS),
        // 60 ms of the fastest oscillator are 88 ms of a typical one.
        row(Fault::Watchdog, &[(0, Injection::TickStops)], 89 * MS),
        // The next control tick's first access.
        row(Fault::HardFault, &[(0, Injection::BusError { address: 0x4000_0024 })], 20 * MS),
        // The next line of the log, of which there are ten a second.
        row(Fault::Panic, &lock, 120 * MS),
        row(Fault::ResetWhileArmed, &[(0, Injection::Reset)], 0),
        row(Fault::BrownOut, &[(0, Injection::BrownOut)], 0),
        // In hardware; the clock security system takes a few cycles. The last one: the crystal is
        // gone for good.
        row(Fault::ClockLost, &[(0, Injection::CrystalLost)], 100),
    ]
}
