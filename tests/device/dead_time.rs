//! The dead time of a bridge: what it takes from an effort, and from none.

use crate::current_sensor::heard;
use crate::winding_heat::blocked;

/// Of the file: resistance, ohm. 1 us twice in a period of 50 us is 4 % of 48 V.
const R: f64 = 2.51;
const LOST_V: f64 = 2.0 * 1e-6 * 20e3 * 48.0;

const DEAD_TIME: [&str; 3] =
    ["motor.dead_time_s=1e-6", "drive.mode=locked-antiphase", "drive.pwm_hz=20000"];

/// The loop holds a step against a block, either way.
#[test]
fn a_constant_effort_loses_the_dead_time_against_its_current() {
    for to_deg in [6.0, -6.0] {
        let mut device = blocked(&DEAD_TIME, to_deg);
        (0..50).for_each(|_| {
            heard(&mut device);
        });
        let lsb = f64::from(device.device.parameters().unwrap().controller.drive.lsb);
        let volts = lsb * f64::from(heard(&mut device).tick.code);
        assert!(volts.abs() > 2.0 * LOST_V, "{volts} V");
        let expected = (volts - LOST_V.copysign(volts)) / R;
        let found = device.current_a();
        assert!((found - expected).abs() < 1e-6, "{to_deg} deg: {found} A, not {expected} A");
    }
}
