//! Each friction model by itself against its closed forms.

use std::f64::consts::PI;

use dynamics::friction::{Coulomb, SetValued};
use dynamics::mechanism::{Mechanism, Terms};
use friction_lab::friction::{
    Dahl, ElasticCoulomb, Implicit, LuGre, MaxwellSlip, SingleValued, Stribeck, Tanh,
};
use friction_lab::solver::dynamics::SingleValuedDynamics;
use friction_lab::solver::state::BodyEvent;
use friction_lab::solver::{fixed_step, nonsmooth};

use super::common::{SPRING_MASS, SPRING_MASS_LEVELS};

/// Friction along a prescribed motion, by Runge-Kutta steps of the model's own rates.
fn along<const Z: usize>(
    friction: &impl SingleValued<Z>,
    z: &mut [f64; Z],
    velocity: impl Fn(f64) -> f64,
    duration_s: f64,
    steps: u32,
    mut each: impl FnMut(f64, f64),
) {
    let h = duration_s / f64::from(steps);
    let plus = |z: &[f64; Z], h: f64, rate: &[f64; Z]| std::array::from_fn(|i| z[i] + h * rate[i]);
    for i in 0..steps {
        let t = f64::from(i) * h;
        let v = [t, t + 0.5 * h, t + h].map(&velocity);
        let first = friction.rate(friction.piece(v[0], z), v[0], z);
        let second = friction.rate(0, v[1], &plus(z, 0.5 * h, &first));
        let third = friction.rate(0, v[1], &plus(z, 0.5 * h, &second));
        let fourth = friction.rate(0, v[2], &plus(z, h, &third));
        let mean = std::array::from_fn(|i| {
            (first[i] + 2.0 * second[i] + 2.0 * third[i] + fourth[i]) / 6.0
        });
        *z = plus(z, h, &mean);
        friction.settle(z);
        each(t + h, friction.force(0, v[2], z));
    }
}

/// Friction along a path in steps, by the model's implicit step.
fn stepped_along<const Z: usize>(
    friction: &impl Implicit<Z>,
    z: &mut [f64; Z],
    path: &[f64],
) -> Vec<f64> {
    let mut v = 0.0;
    let step = |pair: &[f64]| {
        let v_end = pair[1] - pair[0];
        let force = friction.friction(1.0, v, z, v_end).0;
        *z = friction.states(1.0, v, z, v_end);
        v = v_end;
        force
    };
    path.windows(2).map(step).collect()
}

const LEVELS: Coulomb = Coulomb { stick: 0.2, slip: 0.2 };

#[test]
fn dahl_s_friction_is_exponential_in_the_path_however_long_the_steps() {
    let dahl = Dahl::by_rules(LEVELS, 1e-5, 0.1);
    let closed = |x: f64| 0.2 * (1.0 - (-x / 1e-5_f64).exp());
    for steps in [1, 3, 100] {
        let path: Vec<f64> =
            (0..=steps).map(|i| 2.5e-5 * f64::from(i) / f64::from(steps)).collect();
        let forces = stepped_along(&dahl, &mut [0.0], &path);
        for (force, x) in forces.iter().zip(&path[1..]) {
            assert!((force - closed(*x)).abs() < 1e-14, "{force} at {x}");
        }
    }
    // The same by its rates, at two speeds: time does not matter.
    for speed in [1e-3, 1e-6] {
        along(
            &dahl,
            &mut [0.0],
            |_| speed,
            2.5e-5 / speed,
            2000,
            |t, force| {
                assert!((force - closed(speed * t)).abs() < 1e-9, "{force} at {}", speed * t);
            },
        );
    }
}

/// Between +-A the steady loop has its tips at F_c tanh(sigma0 A / F_c) and the area 4 F_c A - 4
/// F_c^2/sigma0 tanh(sigma0 A / F_c).
#[test]
fn hysteresis_loops_have_the_closed_form_s_tips_and_area() {
    fn of(name: &str, friction: impl SingleValued<1>) {
        let (amplitude, stiffness) = (1.5e-5, 2e4);
        let steps = 20_000;
        let velocity = |t: f64| amplitude * 2.0 * PI * (2.0 * PI * t).cos();
        let mut z = [0.0];
        // Swing in.
        along(&friction, &mut z, velocity, 8.0, 8 * steps, |_, _| {});
        let (mut area, mut tip, mut before) = (0.0, 0.0_f64, (0.0, stiffness * z[0]));
        along(&friction, &mut z, velocity, 1.0, steps, |t, force| {
            let x = amplitude * (2.0 * PI * t).sin();
            area += 0.5 * (force + before.1) * (x - before.0);
            tip = tip.max(force);
            before = (x, force);
        });
        let expected_tip = 0.2 * (stiffness * amplitude / 0.2_f64).tanh();
        let expected_area = 4.0 * 0.2 * amplitude - 4.0 * 0.2 / stiffness * expected_tip;
        assert!((tip / expected_tip - 1.0).abs() < 1e-5, "{name}: tip {tip}, not {expected_tip}");
        assert!(
            (area / expected_area - 1.0).abs() < 1e-5,
            "{name}: area {area:e}, not \
            {expected_area:e}"
        );
    }
    of("dahl", Dahl::by_rules(LEVELS, 1e-5, 0.1));
    // With one level and no damping LuGre's bristle is Dahl's.
    of("lugre", LuGre { damping: 0.0, ..LuGre::by_rules(LEVELS, 1e-5, 0.1) });
}

#[test]
fn in_steady_sliding_every_model_has_the_stribeck_curve() {
    fn of<const Z: usize>(name: &str, friction: impl SingleValued<Z>, curve: &Stribeck) {
        for speed in [2e-4_f64, 1e-3, 0.05] {
            for sign in [1.0, -1.0] {
                let mut last = 0.0;
                let mut z = [0.0; Z];
                along(
                    &friction,
                    &mut z,
                    |_| sign * speed,
                    0.5 + 1e-3 / speed,
                    1_000_000,
                    |_, force| last = force,
                );
                let expected = sign * curve.slip(speed);
                assert!(
                    (last / expected - 1.0).abs() < 1e-6,
                    "{name} at {speed}: {last}, not \
                    {expected}"
                );
            }
        }
    }
    let sliding = Stribeck { viscous: 0.3, ..Stribeck::by_rules(SPRING_MASS_LEVELS[0], 1e-5, 0.1) };
    of("lugre", LuGre { sliding, ..LuGre::by_rules(SPRING_MASS_LEVELS[0], 1e-5, 0.1) }, &sliding);
    let elastic = ElasticCoulomb::by_rules(SPRING_MASS_LEVELS[0], 1e-5, 0.1);
    of("elastic-coulomb", ElasticCoulomb { sliding, ..elastic }, &sliding);
    let maxwell = MaxwellSlip::<3>::by_rules(SPRING_MASS_LEVELS[0], 1e-5, 0.1);
    of("maxwell-slip", MaxwellSlip { sliding, ..maxwell }, &sliding);
}

/// Virgin curve sum min(k_i x, a_i F_s); after a reversal Masing's rule: the same curve, twice as
/// large in both directions.
#[test]
fn maxwell_slip_follows_its_virgin_curve_and_masing_s_rule() {
    let model = MaxwellSlip::<4>::by_rules(LEVELS, 1e-5, 0.1);
    let virgin = |x: f64| -> f64 {
        (0..4).map(|i| (model.stiffness[i] * x).min(model.share[i] * 0.2)).sum()
    };
    assert!(
        (virgin(1e-5) - 0.2).abs() < 1e-15 && virgin(0.99e-5) < 0.2,
        "all slip at p_o, and not \
        before"
    );
    let top = 0.8e-5;
    let up = (0..=80).map(|i| f64::from(i) * 1e-7);
    let path: Vec<f64> =
        up.clone().chain(up.clone().rev().skip(1)).chain(up.clone().skip(1).map(|x| -x)).collect();
    let forces = stepped_along(&model, &mut [0.0; 4], &path);
    let tip = virgin(top);
    for (i, (force, x)) in forces.iter().zip(&path[1..]).enumerate() {
        let expected = if i < 80 { virgin(*x) } else { tip - 2.0 * virgin(0.5 * (top - x)) };
        assert!((force - expected).abs() < 1e-14, "{force}, not {expected} at {x}");
    }
    // The same by its rates, slowly; the slip law pulls back what a step overshoots.
    let speed = 1e-5;
    along(
        &model,
        &mut [0.0; 4],
        |_| speed,
        1.2,
        120_000,
        |t, force| {
            let expected = virgin(speed * t);
            assert!((force - expected).abs() < 1e-5, "{force}, not {expected} at {}", speed * t);
        },
    );
}

/// A block under a force that swings between zero and `peak`, slowly.
struct Ripple {
    peak: f64,
    period_s: f64,
}

impl Mechanism<1> for Ripple {
    fn terms(&self, t: f64, _: &[f64; 1], _: &[f64; 1]) -> Terms<1> {
        Terms {
            mass: [[0.1]],
            force: [0.5 * self.peak * (1.0 - (2.0 * PI * t / self.period_s).cos())],
        }
    }
}

/// Per cycle LuGre moves on by F_s/sigma0 ln(1/(1 - u^2)), u the peak over F_s; integrated from z'
/// = V (1 - sgn(V) z sigma0/F_s).
#[test]
fn under_a_ripple_below_break_away_lugre_drifts_and_elastic_coulomb_does_not() {
    let cycles = 10.0;
    let (period_s, h) = (10.0, 5e-4);
    let ripple = Ripple { peak: 0.9 * 0.2, period_s };
    let duration_s = cycles * period_s;
    let lugre = LuGre::by_rules(LEVELS, 1e-5, 0.1);
    let elastic = ElasticCoulomb::by_rules(LEVELS, 1e-5, 0.1);
    let expected = cycles * 1e-5 * -(1.0 - 0.81_f64).ln();
    let mut dynamics = SingleValuedDynamics { mechanism: &ripple, friction: [lugre] };
    let quiet = || -> Vec<BodyEvent> { Vec::new() };
    let by_rates = fixed_step::run(&mut dynamics, h, duration_s, &mut quiet()).unwrap().q[0];
    let by_steps =
        nonsmooth::run_implicit(&ripple, &[lugre], h, duration_s, &mut quiet()).unwrap().q[0];
    // Backward Euler's own error is of the order of the step.
    for (drift, tolerance) in [(by_rates, 5e-4), (by_steps, 5e-3)] {
        assert!((drift / expected - 1.0).abs() < tolerance, "{drift:e}, not {expected:e}");
    }
    let mut dynamics = SingleValuedDynamics { mechanism: &ripple, friction: [elastic] };
    let by_rates = fixed_step::run(&mut dynamics, h, duration_s, &mut quiet()).unwrap().q[0];
    let by_steps =
        nonsmooth::run_implicit(&ripple, &[elastic], h, duration_s, &mut quiet()).unwrap().q[0];
    for drift in [by_rates, by_steps] {
        assert!(drift.abs() < 1e-9, "{drift:e}");
    }
}

/// A block under a constant force.
struct Load(f64);

impl Mechanism<1> for Load {
    fn terms(&self, _: f64, _: &[f64; 1], _: &[f64; 1]) -> Terms<1> {
        Terms { mass: [[0.1]], force: [self.0] }
    }
}

#[test]
fn tanh_creeps_under_a_load_at_the_closed_form_s_speed() {
    let model = Tanh { levels: LEVELS, speed: 1e-3 };
    for part in [0.1, 0.5, 0.9] {
        let load = Load(part * 0.2);
        let expected = 1e-4 * f64::atanh(part);
        let mut dynamics = SingleValuedDynamics { mechanism: &load, friction: [model] };
        let mut quiet = Vec::<BodyEvent>::new();
        let by_rates = fixed_step::run(&mut dynamics, 1e-5, 0.1, &mut quiet).unwrap().v[0];
        let by_steps =
            nonsmooth::run_implicit(&load, &[model], 1e-3, 0.1, &mut quiet).unwrap().v[0];
        for v in [by_rates, by_steps] {
            assert!((v / expected - 1.0).abs() < 1e-6, "{v:e}, not {expected:e}");
        }
        assert!(quiet.is_empty(), "below break-away speed it counts as at rest");
    }
    // Friction peaks at F_s, and at the break-away speed.
    let model = Tanh { levels: SPRING_MASS_LEVELS[0], speed: 1e-3 };
    let at = |v: f64| model.force(0, v, &[]);
    assert!((at(1e-3) - 0.25).abs() < 1e-8 && at(0.95e-3) < at(1e-3) && at(1.05e-3) < at(1e-3));
    assert!((at(0.02) - 0.2).abs() < 1e-9 && at(-0.02) == -at(0.02));
}

/// Within three per cent: LuGre's and Maxwell-slip's bristles already creep when they reach F_s,
/// and g falls with that creep.
#[test]
fn models_with_two_levels_break_away_at_the_upper_one() {
    fn of<const Z: usize>(name: &str, friction: impl Implicit<Z>) {
        let mut events = Vec::new();
        nonsmooth::run_implicit(&SPRING_MASS, &[friction], 2e-5, 2.0, &mut events).unwrap();
        // K V_o t = F_s at 1.25 s.
        let force = 0.2 * events[0].time_s;
        assert!((force / 0.25 - 1.0).abs() < 0.03, "{name}: {events:?}");
    }
    let (levels, range, mass) = (SPRING_MASS_LEVELS[0], 1e-6, 0.1);
    of("tanh", Tanh::by_rules(levels, range, mass));
    of("lugre", LuGre::by_rules(levels, range, mass));
    of("elastic-coulomb", ElasticCoulomb::by_rules(levels, range, mass));
    of("maxwell-slip", MaxwellSlip::<4>::by_rules(levels, range, mass));
}
