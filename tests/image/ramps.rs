//! The ramp that identifies friction, run by the image: the same efforts, counts and levels as on
//! the host.

use simulator::output::json;
use simulator::run::{RunResult, RunTrace, run_all};

use experiments::experiment;

use crate::common::emulation;

/// Two seconds up at the faster rate, and long enough at constant effort for the lag to be
/// corrected.
const FAST: [&str; 2] =
    ["identification.ramp_rates_v_per_s=[0.1, 0.2]", "identification.hold_s=9.5"];

fn trace(result: &RunResult) -> &[simulator::closed_loop::LoopSample] {
    let RunTrace::Ramp(moments) = &result.trace else { panic!("{} is no ramp", result.plan.label) };
    moments
}

#[test]
fn host_and_image_find_the_same_levels_by_the_same_ramp() {
    let backwards =
        ["encoder.direction=\"reverse\"", "encoder.phase=0.7", "drive.mode=sign-magnitude"];
    for set in [FAST.to_vec(), [&FAST[..], &backwards].concat()] {
        let experiment = experiment("friction-identification", &[], &set);
        let host = run_all(&experiment.runs).unwrap();
        let runs = emulation().run_all(&experiment.runs).unwrap();
        for (host, run) in host.iter().zip(&runs) {
            assert_eq!(trace(host), trace(&run.result), "{}", host.plan.label);
            // Ts = 0.40 V; the joint moves half a count in 67 ms, seen up to a sample later.
            let (rate, stick) = (rate_of(host), run.result.metrics.stick_v.unwrap());
            assert!((0.3976..0.4025 + 0.11 * rate).contains(&stick), "{stick}");
            let slip = run.result.metrics.slip_v.unwrap();
            // In single precision on the device.
            let said = levels(&run.log.last().unwrap().text);
            assert!((said[0] - stick).abs() < 1e-6 && (said[1] - slip).abs() < 1e-6, "{said:?}");
        }
        // The same JSON but for the wall time.
        let with_wall = |(run, wall)| RunResult { wall, ..run };
        let image = runs.into_iter().map(|run| run.result).zip(host.iter().map(|run| run.wall));
        let image: Vec<RunResult> = image.map(with_wall).collect();
        assert!(image.iter().all(|run| run.metrics.slip_corrected_v.is_some()));
        let report = |results: &[RunResult]| json::render(&experiment, results).unwrap();
        assert_eq!(report(&host), report(&image));
    }
}

/// The two numbers of the log's last line.
fn levels(said: &str) -> [f64; 2] {
    let volts = |name: &str| {
        let number = said.split_once(name).unwrap_or_else(|| panic!("{said}")).1;
        number.split_whitespace().next().unwrap().parse().unwrap()
    };
    assert!(said.starts_with("friction:"), "{said}");
    [volts("stick"), volts("slip")]
}

fn rate_of(result: &RunResult) -> f64 {
    let simulator::experiment::Task::Ramp(rate) = result.plan.task else { panic!("no ramp") };
    rate
}

#[test]
fn edges_at_their_own_times_move_the_levels_by_less_than_two_rungs() {
    let experiment = experiment("friction-identification", &[], &FAST[..1]);
    let lockstep = run_all(&experiment.runs).unwrap();
    let mut emulation = emulation();
    emulation.free_running = true;
    for (lockstep, free) in lockstep.iter().zip(emulation.run_all(&experiment.runs).unwrap()) {
        let (a, b) = (&lockstep.metrics, &free.result.metrics);
        let rungs = 2.0 * rate_of(lockstep) * 0.02 + 1e-6;
        for (a, b) in [(a.stick_v, b.stick_v), (a.slip_v, b.slip_v)] {
            assert!((a.unwrap() - b.unwrap()).abs() < rungs, "{a:?} {b:?}");
        }
    }
}

#[test]
fn a_joint_that_the_full_scale_does_not_move_has_no_levels() {
    let set = ["identification.ramp_rates_v_per_s=[50]", "joint.friction.stick_v=6"];
    let experiment = experiment("friction-identification", &[], &set);
    let host = run_all(&experiment.runs).unwrap();
    let runs = emulation().run_all(&experiment.runs).unwrap();
    assert_eq!(host[0].metrics.stick_v, None);
    assert_eq!(
        (trace(&host[0]), &host[0].metrics),
        (trace(&runs[0].result), &runs[0].result.metrics)
    );
    assert_eq!(trace(&host[0]).last().map(|moment| moment.tick.code), Some(1024));
    assert!(runs[0].log.iter().any(|line| line.text.contains("did not move")), "{:?}", runs[0].log);
}
