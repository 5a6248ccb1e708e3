//! Parameters of a device beyond its loop, and which of two records it believes: the image does it
//! on its own pins.
//!
//! The joint is blocked, so that PD's effort stays where the first error puts it: Kp = 1 V/deg.

use emulator::board::FittedParts;
use emulator::fault_injection::{BoardObservation, observe};
use stiction::Parameters;
use stiction::parameters::ROOM;

use crate::common::firmware;
use crate::fault_injection::{MS, UNTIL, assert_off_after, inject, parameters_with};

const SAMPLE_NS: u64 = 20 * MS;
/// Half of the PWM's top at 22 kHz: 168 MHz / (4 * 22 kHz).
const NEUTRAL: u16 = 1909;
/// Codes of the full scale: 5 V / 0.00488 V, rounded down.
const CODES: f64 = 1024.0;

/// A record with this sequence number, of a step (deg), changed by `change`.
fn record(sequence: u32, step_deg: f64, change: impl Fn(&mut Parameters)) -> Vec<u8> {
    let blob = parameters_with(&[&format!("reference.steps_deg=[{step_deg}]")]);
    let (mut parameters, _) = Parameters::decode(&blob).unwrap();
    change(&mut parameters);
    parameters.encode(sequence, &mut [0; ROOM]).unwrap().to_vec()
}

/// Returns the swing off neutral of an effort, V.
fn swing(v: f64) -> u16 {
    ((v / 0.00488).round() * f64::from(NEUTRAL) / CODES).round() as u16
}

/// The only compare value that the bridge was on with, off neutral.
fn only_swing(observed: &BoardObservation) -> u16 {
    let [(_, compare)] = observed.compares[..] else { panic!("{observed:?}") };
    compare - NEUTRAL
}

#[test]
fn a_lower_supply_is_made_up_for_by_more_duty() {
    let swing_at = |supply_pin_mv: u32, nominal_supply: f32| {
        let record = record(1, 1.0, |parameters| {
            parameters.device.nominal_supply = nominal_supply;
            parameters.device.supply_full_scale = 24.0;
        });
        only_swing(&inject(
            Some(&record),
            FittedParts { supply_pin_mv, ..FittedParts::default() },
            &[],
        ))
    };
    // The pin's 3.3 V are 24 V: 12 V, and a tenth less.
    assert_eq!(swing_at(1650, 12.0), swing(1.0));
    assert_eq!(swing_at(1485, 12.0), swing(1.0 / 0.9));
    assert_ne!(swing(1.0), swing(1.0 / 0.9));
    // Without a nominal supply the reading changes nothing.
    assert_eq!(swing_at(1485, 0.0), swing(1.0));
}

#[test]
fn the_soft_start_lets_the_duty_rise_in_a_straight_line() {
    // An error that asks for the full scale from the first tick on.
    let record = record(1, 5.0, |parameters| parameters.device.soft_start = 0.5);
    let observed = inject(Some(&record), FittedParts::default(), &[]);
    let begin = observed.on_ns[0][0];
    // 25 ticks from nothing to everything.
    assert!((25..=26).contains(&observed.compares.len()), "{observed:?}");
    for (at, compare) in &observed.compares {
        let since_s = (at - begin) as f64 * 1e-9;
        let line = f64::from(NEUTRAL) * (since_s / 0.5).min(1.0);
        // The limit begins at nothing and is rounded down to a code, and that to a compare value.
        let code = f64::from(NEUTRAL) / CODES;
        let off = f64::from(compare - NEUTRAL) - line;
        assert!((-code - 1.0..1.0).contains(&off), "{since_s} s: {compare}, off by {off}");
    }
    assert_eq!(observed.last.compare, 2 * NEUTRAL);
}

#[test]
fn a_blocked_joint_is_a_stall() {
    let with = |stall_effort: f32| {
        let record = record(1, 5.0, |parameters| {
            parameters.limits.stall_effort = stall_effort;
            parameters.limits.stall_time = 0.2;
            // It sees 5 V sooner.
            parameters.limits.stall_impulse = 0.0;
        });
        inject(Some(&record), FittedParts::default(), &[])
    };
    let observed = with(2.0);
    let [[from, until]] = observed.on_ns[..] else { panic!("{observed:?}") };
    // 0.2 s, counted in ticks, the first one included or not.
    let on = until - from;
    assert!((9 * SAMPLE_NS - MS..=11 * SAMPLE_NS).contains(&on), "on for {on} ns");
    assert_off_after(&observed, until, 0);
    assert!(observed.says("faulted: stall: effort, but no count"), "{:?}", observed.log);
    // Off: the same joint under the same effort.
    assert!(with(0.0).on_after(UNTIL - MS));
}

#[test]
fn of_two_records_the_newer_valid_one_counts() {
    let observed = |records: [Option<&[u8]>; 2]| {
        observe(&firmware(), records, FittedParts::default(), &[], 200 * MS).unwrap()
    };
    // Distinguished by what they do, too.
    let (older, newer) = (record(7, 1.0, |_| {}), record(8, 2.0, |_| {}));
    let mut damaged = newer.clone();
    damaged[40] ^= 1;
    for (records, sector, v) in [
        ([None, Some(&older[..])], 11, 1.0),
        ([Some(&older[..]), Some(&newer[..])], 11, 2.0),
        ([Some(&newer[..]), Some(&older[..])], 10, 2.0),
    ] {
        let observed = observed(records);
        assert!(observed.says(&format!("parameters of sector {sector}:")), "{:?}", observed.log);
        assert_eq!(only_swing(&observed), swing(v), "sector {sector}");
    }
    // The older one counts if the newer is damaged, but nothing starts by itself with it.
    let observed = observed([Some(&older[..]), Some(&damaged[..])]);
    assert!(observed.says("parameters of sector 10:"), "{:?}", observed.log);
    assert!(observed.says("a saved set of parameters is damaged"), "{:?}", observed.log);
    assert!(!observed.says("autostart: arms") && observed.on_ns.is_empty(), "{observed:?}");
}
