//! What the thesis's Chapter 2 says of its two models, and whether it holds.

use host_sim::friction::{Coulomb, ResetIntegrator};
use host_sim::mechanism::{Mechanism, Shape};
use host_sim::solver::EventKind::{Break, Reverse, Stick};
use host_sim::solver::banded::{Banded, Coupling};
use host_sim::solver::dynamics::{Dynamics, SingleValuedDynamics};
use host_sim::solver::state::{BodyEvent, Observer, Sample};
use host_sim::solver::step_doubling::{self, Accuracy};
use host_sim::solver::{fixed, pieces};

use super::common::{
    ARM, ARM_LEVELS, COUPLED, COUPLED_LEVELS, PENDULUM, PENDULUM_LEVELS, SPRING_MASS, SPRING_MASS_LEVELS,
    block, exact,
};

/// One degree.
const DEG: f64 = std::f64::consts::PI / 180.0;

/// Every sample and event.
#[derive(Default)]
struct Everything<const N: usize> {
    samples: Vec<Sample<N>>,
    events: Vec<BodyEvent>,
}

impl<const N: usize> Observer<N> for Everything<N> {
    fn sample(&mut self, sample: &Sample<N>) {
        self.samples.push(*sample);
    }

    fn event(&mut self, event: BodyEvent) {
        self.events.push(event);
    }
}

const fn reset_integrator(
    levels: Coulomb,
    range: f64,
    stiffness: f64,
    damping: f64,
    a: f64,
) -> ResetIntegrator {
    ResetIntegrator { levels, range, stiffness, damping, gradient: a }
}

/// Tables 2, 8, 11, 15.
const ON_SPRING: [ResetIntegrator; 1] = [reset_integrator(SPRING_MASS_LEVELS[0], 1e-5, 2e4, 30.0, 0.25)];
const OF_PENDULUM: [ResetIntegrator; 1] =
    [reset_integrator(PENDULUM_LEVELS[0], 5.7e-4 * DEG, 0.96 / (5.7e-4 * DEG), 246.0, 0.25)];
const OF_ARM: [ResetIntegrator; 2] = [
    reset_integrator(ARM_LEVELS[0], 5.7e-5 * DEG, 0.08 / (5.7e-5 * DEG), 217.7, 0.25),
    reset_integrator(ARM_LEVELS[1], 5.7e-5 * DEG, 0.06 / (5.7e-5 * DEG), 189.1, 0.25),
];
const OF_BLOCK: [ResetIntegrator; 1] =
    [reset_integrator(Coulomb { stick: 0.8, slip: 0.6 }, 1e-4, 6000.0, 55.0, 1.0 / 3.0)];

fn followed<const N: usize, M: Mechanism<N>>(
    mechanism: &M,
    friction: &[ResetIntegrator; N],
    duration_s: f64,
) -> Everything<N> {
    let mut everything = Everything { samples: Vec::new(), events: Vec::new() };
    pieces::run(mechanism, friction, 1e-10, duration_s, &mut everything).unwrap();
    everything
}

fn peak<const N: usize>(samples: &[Sample<N>]) -> f64 {
    samples.iter().map(|s| s.friction[0].abs()).fold(0.0, f64::max)
}

/// 2.2.1.1: "both models exhibit the same staircase behaviour".
#[test]
fn both_models_climb_the_same_staircase() {
    let reset = followed(&SPRING_MASS, &ON_SPRING, 5.0);
    let (karnopp, _) = exact(&SPRING_MASS, &SPRING_MASS_LEVELS, 1e-9, 5.0);
    let breaks = |events: &[BodyEvent]| -> Vec<f64> {
        events.iter().filter(|e| e.kind == Break).map(|e| e.time_s).collect()
    };
    let (reset, karnopp) = (breaks(&reset.events), breaks(&karnopp));
    assert_eq!((reset.len(), karnopp.len()), (7, 7));
    // The bristle gives way by p_o, and springs back by a part of it at each stop: of the step, 1.2 mm, about a percent.
    for (reset, karnopp) in reset.windows(2).zip(karnopp.windows(2)) {
        let ratio = (reset[1] - reset[0]) / (karnopp[1] - karnopp[0]);
        assert!((0.98..1.02).contains(&ratio) && ratio != 1.0, "{ratio}");
    }
}

/// 2.2.1.1: "the static friction force peaks are at uniform values each time the block sticks ... the extra static friction
/// is developing from the damping coefficient". While it loads, the bristle creeps at K V_o / (K_r (1 + a) + K), and
/// at p_o it has F_s + beta times that.
#[test]
fn reset_integrator_peaks_are_uniform_in_double_precision_and_above_the_static_friction() {
    let run = followed(&SPRING_MASS, &ON_SPRING, 5.0);
    let expected = 0.25 + 30.0 * 100.0 * 0.002 / (2e4 * 1.25 + 100.0);
    let breaks = run.events.iter().filter(|e| e.kind == Break).map(|e| e.time_s);
    for break_s in breaks {
        let near: Vec<_> =
            run.samples.iter().filter(|s| (s.time_s - break_s).abs() < 0.02).copied().collect();
        let ratio = peak(&near) / expected;
        assert!((ratio - 1.0).abs() < 1e-6, "at {break_s}: {ratio}");
    }
}

/// Where a force that jumps to `load` breaks the bristle: a damped oscillator from rest, F at the first p = p_o.
fn peak_under_a_jump(friction: &ResetIntegrator, mass: f64, load: f64) -> f64 {
    let k = friction.stiffness * (1.0 + friction.gradient);
    let decay = friction.damping / (2.0 * mass);
    let omega = (k / mass - decay * decay).sqrt();
    let p = |t: f64| {
        load / k * (1.0 - (-decay * t).exp() * ((omega * t).cos() + decay / omega * (omega * t).sin()))
    };
    let (mut low, mut high) = (0.0, std::f64::consts::PI / omega);
    for _ in 0..80 {
        let middle = 0.5 * (low + high);
        if p(middle) < friction.range { low = middle } else { high = middle }
    }
    let v = load / k * (-decay * low).exp() * (decay * decay + omega * omega) / omega * (omega * low).sin();
    k * friction.range + friction.damping * v
}

/// 2.3.2.1: "the combination of these two variables caused the resultant stick friction to be greater than the given stick
/// friction value"; closed form.
#[test]
fn a_jump_of_force_takes_the_reset_integrator_far_above_its_static_friction() {
    let run = followed(&block(Shape::Square), &OF_BLOCK, 1.0);
    let expected = peak_under_a_jump(&OF_BLOCK[0], 1.0, 1.0);
    assert!(expected > 1.4 * 0.8);
    assert!((peak(&run.samples) / expected - 1.0).abs() < 1e-7, "{} not {expected}", peak(&run.samples));
    // The pendulum's gravity has nothing to say within 5.7e-4 deg.
    let run = followed(&PENDULUM, &OF_PENDULUM, 0.5);
    let expected = peak_under_a_jump(&OF_PENDULUM[0], 1.0, 6.0);
    assert!(expected > 2.5 * 1.2);
    assert!((peak(&run.samples) / expected - 1.0).abs() < 1e-4, "{} not {expected}", peak(&run.samples));
}

/// 2.2.2.1: "static friction being greater than the dynamic friction only occurred on the first two instances where the
/// manipulator entered the static region. The Reset Integrator on the other hand ... every time".
#[test]
fn static_friction_exceeds_dynamic_at_the_first_two_stops_with_karnopp_and_at_all_with_reset_integrator() {
    let (events, _) = exact(&PENDULUM, &PENDULUM_LEVELS, 1e-10, 5.0);
    let stops: Vec<_> = events.iter().filter(|e| e.kind != Break).collect();
    let applied = |time_s: f64| {
        let (_, there) = exact(&PENDULUM, &PENDULUM_LEVELS, 1e-10, time_s);
        (6.0 - 9.81 * there.q[0].sin()).abs()
    };
    let found: Vec<_> = stops.iter().map(|e| (e.kind, applied(e.time_s))).collect();
    assert!(
        matches!(found[..], [(Reverse, a), (Reverse, b), (Stick, c)] if a > 1.2 && b > 1.2 && c < 0.96),
        "{found:?}"
    );
    let reset = followed(&PENDULUM, &OF_PENDULUM, 5.0);
    let entries = reset.events.iter().filter(|e| e.kind == Stick);
    for entry in entries.clone() {
        let near: Vec<_> =
            reset.samples.iter().filter(|s| (s.time_s - entry.time_s).abs() < 1e-3).copied().collect();
        assert!(peak(&near) > 1.199, "at {}: {}", entry.time_s, peak(&near));
    }
    assert_eq!(entries.count(), 3);
}

fn stepped<D: Dynamics<2, 0>>(mut dynamics: D, step_s: f64) -> (Everything<2>, [f64; 2]) {
    let mut everything = Everything { samples: Vec::new(), events: Vec::new() };
    let finish = fixed::run(&mut dynamics, step_s, 5.0, &mut everything).unwrap();
    (everything, finish.q)
}

const fn bands(deg_per_s: f64) -> [f64; 2] {
    [deg_per_s * DEG; 2]
}

/// 2.2.2.2, Fig. 13: "Neglecting these coupled accelerations in the Karnopp model is invalid. The accelerations at
/// approximately t = 1.25 seconds and t = 2.5 seconds ... when both joints are sticking".
#[test]
fn a_stuck_joint_is_accelerated_by_the_other_when_coupling_is_neglected() {
    let kicks = |coupling| {
        let (run, _) = stepped(Banded::new(&ARM, ARM_LEVELS, bands(5.7e-4), coupling), 1e-5);
        let in_bands = run.samples.into_iter().filter(|s| s.slip == [0, 0] && s.a[1].abs() > 1e-3);
        in_bands.map(|s| s.time_s).collect::<Vec<_>>()
    };
    let (right, neglected) = (kicks(Coupling::Simultaneous), kicks(Coupling::Neglected));
    // Joint 1 turns around there, and joint 2 sticks.
    for around_s in [1.25, 2.56] {
        let near = |times_s: &[f64]| times_s.iter().filter(|t| (**t - around_s).abs() < 0.02).count();
        assert!(
            near(&right) == 0 && near(&neglected) > 0,
            "{around_s}: {} {}",
            near(&right),
            near(&neglected)
        );
    }
}

/// 2.2.2.2 expects the accelerations of the step before to be "more accurate than having no acceleration component", and
/// tells of frictions that switch "back and forth from limit to limit". They do switch from side to side, at the level of
/// slip rather than at its limit at rest; more accurate they are not.
#[test]
fn accelerations_of_the_step_before_are_not_more_accurate_than_none() {
    let right = [0.00449854385477193, 0.0252895664467873];
    let run = |coupling| stepped(Banded::new(&ARM, ARM_LEVELS, bands(5.7e-4), coupling), 1e-5);
    let (neglected, previous) = (run(Coupling::Neglected), run(Coupling::PreviousStep));
    for i in 0..2 {
        let error = |q: [f64; 2]| (q[i] / right[i] - 1.0).abs();
        assert!(error(neglected.1) < 0.01, "{:?}", neglected.1);
        assert!(error(previous.1) > 5.0 * error(neglected.1), "{:?}", previous.1);
        // An independent simulation.
        assert!((previous.1[i] / [0.00412, 0.02733][i] - 1.0).abs() < 0.015, "{:?}", previous.1);
    }
    // Each switch leaves the band or comes back into it.
    let switches = [neglected.0.events.len(), previous.0.events.len()];
    assert!(switches[0] < 100 && switches[1] > 10_000, "{switches:?}");
}

/// Evaluations at several eps about the thesis's 2e-4: a single run's are a matter of luck at each switch.
fn work<const N: usize, const Z: usize, D: Dynamics<N, Z> + Clone>(dynamics: &D, duration_s: f64) -> u64 {
    let once = |eps: f64| {
        let accuracy = Accuracy { eps, max_evaluations: 1_000_000_000 };
        let run = step_doubling::run(&mut dynamics.clone(), accuracy, duration_s, &mut Vec::new());
        run.unwrap().evaluations
    };
    [1.6e-4, 1.8e-4, 2.0e-4, 2.2e-4, 2.4e-4].map(once).iter().sum()
}

/// Tables 3, 6, 9, 12: seconds of a 486, here evaluations. The Reset Integrator is the dearer one in three. In Table 6 (the
/// coupled blocks) the thesis has Karnopp dearer, 0.44 to 0.38 s; here the two come nearest in that one, but in the
/// same order as in the others. All with the simultaneous decision: with the coupling neglected, as in the
/// thesis, an arm that chatters now and then costs a hundred times as much.
#[test]
fn the_reset_integrator_costs_more_than_karnopp_least_so_on_the_coupled_blocks() {
    let on_blocks = [
        reset_integrator(COUPLED_LEVELS[0], 1e-5, 1e4, 40.0, 0.5),
        reset_integrator(COUPLED_LEVELS[1], 1e-5, 2e4, 40.0, 0.5),
    ];
    let simultaneous = Coupling::Simultaneous;
    let ratio = |reset: u64, karnopp: u64| reset as f64 / karnopp as f64;
    let table_3 = ratio(
        work(&SingleValuedDynamics { mechanism: &SPRING_MASS, friction: ON_SPRING }, 5.0),
        work(&Banded::new(&SPRING_MASS, SPRING_MASS_LEVELS, [2e-5], simultaneous), 5.0),
    );
    let table_6 = ratio(
        work(&SingleValuedDynamics { mechanism: &COUPLED, friction: on_blocks }, 0.5),
        work(&Banded::new(&COUPLED, COUPLED_LEVELS, [1e-4; 2], simultaneous), 0.5),
    );
    let table_9 = ratio(
        work(&SingleValuedDynamics { mechanism: &PENDULUM, friction: OF_PENDULUM }, 5.0),
        work(&Banded::new(&PENDULUM, PENDULUM_LEVELS, [5.7e-4 * DEG], simultaneous), 5.0),
    );
    let table_12 = ratio(
        work(&SingleValuedDynamics { mechanism: &ARM, friction: OF_ARM }, 5.0),
        work(&Banded::new(&ARM, ARM_LEVELS, bands(5.7e-4), simultaneous), 5.0),
    );
    let ratios = [table_3, table_6, table_9, table_12];
    println!("{ratios:?}");
    assert!([table_3, table_9, table_12].iter().all(|ratio| (1.6..6.0).contains(ratio)), "{ratios:?}");
    assert!((1.0..1.6).contains(&table_6), "{ratios:?}");
}

/// Fig. 14, 70 minutes on a workstation: D_v = 5.7e-3 deg/s, accelerations of the step before, eps = 2e-4. It ends, after
/// thousands of times the work of the simultaneous decision.
#[test]
fn the_run_of_seventy_minutes_ends() {
    let banded = |coupling| Banded::new(&ARM, ARM_LEVELS, bands(5.7e-3), coupling);
    let once = |coupling| {
        let accuracy = Accuracy { eps: 2e-4, max_evaluations: 1_000_000_000 };
        step_doubling::run(&mut banded(coupling), accuracy, 5.0, &mut Vec::new()).unwrap().evaluations
    };
    let ratio = once(Coupling::PreviousStep) / once(Coupling::Simultaneous);
    assert!((500..100_000).contains(&ratio), "{ratio}");
}
