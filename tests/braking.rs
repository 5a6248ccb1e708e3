//! A heavy joint that brakes into its supply.

use files::document::Document;
use simulator::draft::{Typical, text};
use simulator::experiment::{Experiment, RunPlan};

/// Values of the joint, of the supply with its capacitor, and of the brake resistor.
///
/// Full speed is 6 rad/s. The joint brakes from it with 2.2 rad/s^2, 3 A and up to 60 W into the
/// supply. The resistor takes 111 W at 59 V and 0.9. Without swings of the supply, the capacitor
/// has to be 4 ms 59 V / (28.2 ohm 6 V) = 1.4 mF.
const SET: [&str; 14] = [
    "supply.takes_current_back=false",
    "supply.capacitance_f=2e-3",
    "device.nominal_supply_v=48",
    "device.supply_full_scale_v=66",
    "device.soft_start_s=0.02",
    "limits.supply_max_v=62",
    "profile.velocity_deg_per_s=340",
    "profile.acceleration_deg_per_s2=125",
    "profile.jerk_deg_per_s3=2500",
    "limits.overspeed_deg_per_s=500",
    "limits.continuous_v=30",
    "drive.pwm_hz=20000",
    "drive.duty_max=0.95",
    "limits.link_timeout_s=off",
];

/// The brake resistor.
pub const RESISTOR: [&str; 5] = [
    "brake_resistor.resistance_ohm=28.2",
    "brake_resistor.from_v=53",
    "brake_resistor.full_v=59",
    "brake_resistor.power_w=40",
    "brake_resistor.energy_j=400",
];

/// Plans the run of a typical joint `harmonic` (48 V, 2.51 ohm, 4.545 V s/rad at the joint) under
/// `robust`, with an inertia of 6 kg m^2 and little friction. Keys are set as on the command line.
pub fn braking(set: &[&str]) -> RunPlan {
    let owned = |texts: &[&str]| texts.iter().map(|text| (*text).to_owned()).collect::<Vec<_>>();
    let mut answers = Typical::find("harmonic").unwrap().answers().unwrap();
    for (key, value) in [
        ("load.inertia_kg_m2", 6.0),
        ("friction.stick_nm", 0.6),
        ("friction.slip_nm", 0.5),
        ("friction.viscous_nm_s_per_rad", 0.1),
    ] {
        answers.put(key, value.into(), "assumed");
    }
    let text = text("braking", &answers, None).unwrap();
    let mut document = Document::parse("braking", &text).unwrap();
    document.set(&owned(&[&SET, set].concat())).unwrap();
    Experiment::plan(&document, &owned(&["robust"]), &[]).unwrap().runs.remove(0)
}
