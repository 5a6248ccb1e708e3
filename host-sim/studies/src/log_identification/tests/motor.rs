//! The constants of a motor with known ones, from its voltage and its current in closed form.

use super::super::reading::of_series;
use super::super::{FitSettings, IdentifiedMachine, identify};
use super::machines::request;

/// Resistance, ohm; back-EMF constant, V s/rad; voltage that is lost, V.
const TRUE: [f64; 3] = [2.51, 4.545, 0.4];

/// Two sines each way: position, rad, and its derivatives.
fn position(t: f64) -> [f64; 3] {
    let mut all = [0.0; 3];
    for (a, w) in [(0.8, 3.1), (0.3, 8.3)] {
        let (sin, cos) = f64::sin_cos(w * t);
        let of = [a * sin, a * w * cos, -a * w * w * sin];
        (0..3).for_each(|place| all[place] += of[place]);
    }
    all
}

/// Identifies 20 s at 1 kHz of a joint with inertia and friction, in amperes. The current is in
/// whole readings of 15 mA, the position in counts of 0.2 mrad.
fn identified(inertia: f64) -> IdentifiedMachine {
    let [ohm, back_emf, lost_v] = TRUE;
    let times: Vec<f64> = (0..20_000).map(|k| 1e-3 * f64::from(k)).collect();
    let (mut positions, mut volts, mut currents) = (Vec::new(), Vec::new(), Vec::new());
    for t in &times {
        let [q, v, a] = position(*t);
        let ampere = inertia * a + 0.08 * v + 0.3 * v.signum();
        positions.push((q / 2e-4).round() * 2e-4);
        volts.push(ohm * ampere + back_emf * v + lost_v * ampere.signum());
        currents.push((ampere / 0.015).round() * 0.015);
    }
    let mut log = of_series([&times, &positions, &volts]).unwrap();
    log.motor = currents;
    identify(log, &FitSettings { has_motor_current: true, ..request() }).unwrap()
}

#[test]
fn resistance_and_back_emf_constant_are_those_of_the_motor() {
    let found = identified(0.06);
    assert!(found.gear.is_none());
    // A step of the current is none of the position.
    assert!(found.warnings.iter().all(|words| !words.contains("jumps")), "{:?}", found.warnings);
    let motor = found.motor.unwrap().unwrap();
    for (name, parameter, truth) in [
        ("R", motor.resistance_ohm, TRUE[0]),
        ("k", motor.back_emf, TRUE[1]),
        ("V_d", motor.lost_v, TRUE[2]),
    ] {
        let error = (parameter.value - truth).abs();
        assert!(error < 3.0 * parameter.sd, "{name}: {parameter:?}");
        assert!(parameter.sd < 0.02 * truth, "{name}: {parameter:?}");
    }
}

/// Without an inertia, the current is a sum of speed and direction.
#[test]
fn constants_that_the_motion_does_not_separate_are_refused() {
    let why = identified(0.0).motor.unwrap().unwrap_err();
    assert!(why.contains("more acceleration"), "{why}");
}
