//! A difference between image and core is found, in whatever term it is, and shown with both ticks.
//!
//! The image gets the parameters of one plan, and the core beside it is that of another. What has
//! to be found is what two runs on the host differ in first.

use std::sync::atomic::AtomicU32;

use emulator::parameters::blob;
use emulator::{Difference, FirmwareImage, first_difference};
use simulator::experiment::RunPlan;
use simulator::run::{RunResult, RunTrace, run_all};
use stiction::Tick;

use crate::common::{emulation, image, plans};

/// Runs the image with the parameters of one plan beside the core of another.
fn refusal(image: &RunPlan, beside: &RunPlan, free_running: bool) -> String {
    let mut emulation = emulation();
    emulation.free_running = free_running;
    match emulation.run_with_record(blob(image).unwrap(), beside, &AtomicU32::default()) {
        Ok(_) => panic!("nothing was found"),
        Err(error) => error.to_string(),
    }
}

fn plan(name: &str, controller: &str, set: &[&str]) -> RunPlan {
    plans(name, &[controller], set).remove(0)
}

/// Where the two part on the host.
fn expected(image: &RunPlan, host: &RunPlan) -> Difference {
    let results = run_all(&[host.clone(), image.clone()]).unwrap();
    let moments = |result: &RunResult| match &result.trace {
        RunTrace::Loop(moments) => moments.clone(),
        RunTrace::Ramp(_) => panic!("{} is a ramp", result.plan.label),
    };
    first_difference(&moments(&results[0]), &moments(&results[1])).unwrap()
}

fn assert_found(message: &str, difference: &Difference) {
    assert!(message.ends_with(difference.to_string().trim_end()), "{message}\n{difference}");
    let commit = FirmwareImage::open(&image()).unwrap().note.commit;
    let Difference { index, host, image } = difference;
    for part in [
        format!("of commit {commit};"),
        format!("from tick {index} on"),
        format!("host  {:?}", host.unwrap()),
        format!("image {:?}", image.unwrap()),
    ] {
        assert!(message.contains(&part), "{message}\n{part}");
    }
}

const KP: &str = "controller.pd.kp_v_per_deg";
const KD: &str = "controller.pd.kd_v_per_deg_per_s";

/// Returns whether both show the same on their pins, as a voltmeter would see it.
fn same_pins(host: &Tick, image: &Tick) -> bool {
    (host.counts, host.duty()) == (image.counts, image.duty())
}

#[test]
fn the_last_bit_of_a_gain_is_seen_in_a_term_that_no_pin_shows() {
    // One unit in the last place of a single-precision 0.15, and of 1: neither moves the output by
    // a code at once.
    for (key, value, bit) in [(KD, 0.15f32, 1), (KP, 1.0, 1)] {
        let next = f32::from_bits(value.to_bits() + bit);
        let host = plan("step-response", "pd", &["run.duration_s=1", &format!("{key}={value}")]);
        let image = plan(
            "step-response",
            "pd",
            &["run.duration_s=1", &format!("{key}={}", f64::from(next))],
        );
        let difference = expected(&image, &host);
        let (a, b) = (difference.host.unwrap(), difference.image.unwrap());
        assert!(same_pins(&a, &b) && a.v_pd.to_bits() != b.v_pd.to_bits(), "{difference}");
        // A derivative needs a joint that moves, a proportion only an error.
        assert_eq!(difference.index > 0, key == KD, "{difference}");
        assert_found(&refusal(&image, &host, false), &difference);
    }
}

#[test]
fn a_term_that_no_law_uses_is_compared_as_well() {
    // Feedforward of acceleration does not exist, so the acceleration of the blend changes nothing
    // at the first tick of it but itself and the set point; with gains of zero nothing at all is on
    // the pins.
    let gains = ["controller.pd.kp_v_per_deg=0", "controller.pd.kd_v_per_deg_per_s=0"];
    let with = |half_blend: &str| {
        let corners = "corner_times_s = [0.5, 2.0], corner_positions_deg = [0.0, 1.0]";
        let trajectory =
            format!("reference.trajectories=[{{ {corners}, half_blend_s = {half_blend} }}]");
        plan("trajectory", "pd", &[gains[0], gains[1], &trajectory])
    };
    let (host, image) = (with("0.25"), with("0.24"));
    let difference = expected(&image, &host);
    let (a, b) = (difference.host.unwrap(), difference.image.unwrap());
    assert_eq!((a.duty(), a.v, a.counts), (b.duty(), b.v, b.counts));
    assert!(a.reference_acceleration != b.reference_acceleration, "{difference}");
    assert_found(&refusal(&image, &host, false), &difference);
}

#[test]
fn a_difference_that_the_pins_show_is_found_in_either_mode() {
    let host = plan("step-response", "pd", &["run.duration_s=1"]);
    let image =
        plan("step-response", "pd", &["run.duration_s=1", "controller.pd.kp_v_per_deg=0.9"]);
    let difference = expected(&image, &host);
    assert!(!same_pins(&difference.host.unwrap(), &difference.image.unwrap()));
    for free_running in [false, true] {
        assert_found(&refusal(&image, &host, free_running), &difference);
    }
}

#[test]
fn the_last_bit_of_a_gain_is_seen_in_free_running_too() {
    let host = plan("step-response", "srnf", &["run.duration_s=1"]);
    let next = f64::from(f32::from_bits(100f32.to_bits() + 1));
    let alpha = format!("controller.srnf.alpha_per_deg={next}");
    let image = plan("step-response", "srnf", &["run.duration_s=1", &alpha]);
    // When it comes to that depends on the times of the edges; that both ticks are shown does not.
    let message = refusal(&image, &host, true);
    let ticks: Vec<&str> = message.lines().filter(|line| line.contains("Tick {")).collect();
    assert_eq!(ticks.len(), 2, "{message}");
    let terms =
        |line: &str| line.trim_start_matches("  host  ").trim_start_matches("  image ").to_owned();
    assert_ne!(terms(ticks[0]), terms(ticks[1]), "{message}");
    assert!(message.contains("differ from tick"), "{message}");
}

#[test]
fn a_ramp_of_another_rate_is_found() {
    let ramp = |rate: &str| {
        let rates = format!("identification.ramp_rates_v_per_s=[{rate}]");
        plans("friction-identification", &[], &[&rates]).remove(0)
    };
    // The first rung is 2 mV, and half an LSB 2.44 mV: no pin shows it.
    let message = refusal(&ramp("0.1000001"), &ramp("0.1"), false);
    assert!(message.contains("differ from tick 0 on") && message.contains("code: 0"), "{message}");
}
