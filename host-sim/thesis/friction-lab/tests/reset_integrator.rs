//! What the thesis says of the Reset Integrator's friction at rest: peaks that are uniform, above
//! F_s, and at every stop.

use dynamics::solver::EventKind::{Break, Reverse, Stick};
use friction_lab::friction::ResetIntegrator;
use friction_lab::mechanism::Shape;
use friction_lab::solver::dynamics::SingleValuedDynamics;
use friction_lab::solver::fixed_step;
use friction_lab::solver::state::BodySample;

use super::common::{
    Everything, OF_BLOCK, OF_PENDULUM, ON_SPRING, PENDULUM, PENDULUM_LEVELS, SPRING_MASS, block,
    exact, followed,
};

fn peak<const N: usize>(samples: &[BodySample<N>]) -> f64 {
    samples.iter().map(|s| s.friction[0].abs()).fold(0.0, f64::max)
}

/// The largest friction of each stay at rest.
fn peaks(run: &Everything<1>) -> Vec<f64> {
    let stays = run.samples.chunk_by(|a, b| a.slip == b.slip).filter(|stay| stay[0].slip == [0]);
    stays.map(peak).collect()
}

/// Thesis section 2.2.1.1: in double precision the peaks are uniform. They are F_s + beta V, and V
/// the steady creep of the two springs in a row, K V_o / (K + K_r (1 + a)), once the swing after
/// the stick has died away.
#[test]
fn the_peaks_are_uniform_and_known() {
    let [model] = ON_SPRING;
    let creep = 100.0 * 0.002 / (100.0 + model.stiffness * (1.0 + model.gradient));
    let expected = 0.25 + model.damping * creep;
    let located = peaks(&followed(&SPRING_MASS, &ON_SPRING, 5.0));
    let mut stepped = Everything::default();
    let mut dynamics = SingleValuedDynamics { mechanism: &SPRING_MASS, friction: ON_SPRING };
    fixed_step::run(&mut dynamics, 1e-5, 5.0, &mut stepped).unwrap();
    let stepped = peaks(&stepped);
    // Six stays between seven breaks, the one before the first and the one after the last.
    assert!(located.len() >= 7 && stepped.len() >= 7, "{located:?} {stepped:?}");
    for (located, stepped) in located.iter().zip(&stepped).take(7) {
        assert!((located - expected).abs() < 1e-8, "{located}, not {expected}");
        // The last step before the break sees less, by at most h K V_o.
        assert!((-2.1e-6..1e-7).contains(&(stepped - expected)), "{stepped}, not {expected}");
    }
}

/// Where a force that jumps to `load` breaks the bristle: a damped oscillator from rest, F at the
/// first p = p_o.
fn peak_under_a_jump(friction: &ResetIntegrator, mass: f64, load: f64) -> f64 {
    let k = friction.stiffness * (1.0 + friction.gradient);
    let decay = friction.damping / (2.0 * mass);
    let omega = (k / mass - decay * decay).sqrt();
    let p = |t: f64| {
        load / k
            * (1.0 - (-decay * t).exp() * ((omega * t).cos() + decay / omega * (omega * t).sin()))
    };
    let (mut low, mut high) = (0.0, std::f64::consts::PI / omega);
    for _ in 0..80 {
        let middle = 0.5 * (low + high);
        if p(middle) < friction.range { low = middle } else { high = middle }
    }
    let v = load / k * (-decay * low).exp() * (decay * decay + omega * omega) / omega
        * (omega * low).sin();
    k * friction.range + friction.damping * v
}

/// 2.3.2.1: "the combination of these two variables caused the resultant stick friction to be
/// greater than the given stick friction value"; closed form.
#[test]
fn a_jump_of_force_takes_it_far_above_its_static_friction() {
    let run = followed(&block(Shape::Square), &OF_BLOCK, 1.0);
    let expected = peak_under_a_jump(&OF_BLOCK[0], 1.0, 1.0);
    assert!(expected > 1.4 * 0.8);
    assert!(
        (peak(&run.samples) / expected - 1.0).abs() < 1e-7,
        "{} not {expected}",
        peak(&run.samples)
    );
    // The pendulum's gravity has nothing to say within 5.7e-4 deg.
    let run = followed(&PENDULUM, &OF_PENDULUM, 0.5);
    let expected = peak_under_a_jump(&OF_PENDULUM[0], 1.0, 6.0);
    assert!(expected > 2.5 * 1.2);
    assert!(
        (peak(&run.samples) / expected - 1.0).abs() < 1e-4,
        "{} not {expected}",
        peak(&run.samples)
    );
}

/// 2.2.2.1: "static friction being greater than the dynamic friction only occurred on the first two
/// instances where the manipulator entered the static region. The Reset Integrator on the other
/// hand ... every time". Karnopp's turns take no time: there the torque would need more than T_s.
/// The one stay at rest holds the weight against the torque.
#[test]
fn static_friction_exceeds_dynamic_at_two_stops_with_karnopp_and_at_all_with_reset_integrator() {
    let (events, _) = exact(&PENDULUM, &PENDULUM_LEVELS, 1e-10, 5.0);
    let stops: Vec<_> = events.iter().filter(|e| e.kind != Break).collect();
    let applied = |time_s: f64| {
        let (_, there) = exact(&PENDULUM, &PENDULUM_LEVELS, 1e-10, time_s);
        (6.0 - 9.81 * there.q[0].sin()).abs()
    };
    let found: Vec<_> = stops.iter().map(|e| (e.kind, applied(e.time_s))).collect();
    assert!(
        matches!(
            found[..],
            [(Reverse, a), (Reverse, b), (Stick, c)] if a > 1.2 && b > 1.2 && c < 0.96
        ),
        "{found:?}"
    );
    // The bristle is bent by p_o when it stops, and has T_s there: with steps that locate nothing,
    // too.
    let located = followed(&PENDULUM, &OF_PENDULUM, 5.0);
    let mut stepped = Everything::default();
    let mut dynamics = SingleValuedDynamics { mechanism: &PENDULUM, friction: OF_PENDULUM };
    fixed_step::run(&mut dynamics, 5e-6, 5.0, &mut stepped).unwrap();
    for run in [located, stepped] {
        let stops: Vec<f64> =
            run.events.iter().filter(|e| e.kind == Stick).map(|e| e.time_s).collect();
        assert_eq!(stops.len(), 3, "{stops:?}");
        for stop_s in stops {
            let near: Vec<_> =
                run.samples.iter().filter(|s| (s.time_s - stop_s).abs() < 1e-3).copied().collect();
            assert!(peak(&near) > 0.99 * 1.2, "at {stop_s}: {}", peak(&near));
        }
    }
}
