//! What the thesis says of the Reset Integrator's friction at rest: peaks that are uniform, above F_s, and at every stop.

use std::f64::consts::PI;

use host_sim::friction::ResetIntegrator;
use host_sim::mechanism::Shape;
use host_sim::solver::dynamics::SingleValuedDynamics;
use host_sim::solver::state::{BodyEvent, Observer, Sample};
use host_sim::solver::{fixed, located, pieces};

use super::common::{BLOCK_LEVELS, PENDULUM, PENDULUM_LEVELS, SPRING_MASS, SPRING_MASS_LEVELS, block};

/// Where friction is largest, between each two changes of sticking and slipping.
struct Peaks {
    stuck: Vec<f64>,
    now: f64,
    slip: i8,
}

impl Peaks {
    const NONE: Self = Self { stuck: Vec::new(), now: 0.0, slip: 0 };
}

impl Observer<1> for Peaks {
    fn sample(&mut self, sample: &Sample<1>) {
        if sample.slip == [0] {
            self.now = self.now.max(sample.friction[0]);
        } else if self.slip == 0 {
            self.stuck.push(self.now);
            self.now = 0.0;
        }
        self.slip = sample.slip[0];
    }

    fn event(&mut self, _: BodyEvent) {}
}

/// Table 2's Reset Integrator; beta as the table has it.
fn table_2() -> ResetIntegrator {
    ResetIntegrator { damping: 30.0, ..ResetIntegrator::by_rules(SPRING_MASS_LEVELS[0], 1e-5, 0.1) }
}

/// Thesis section 2.2.1.1: in double precision the peaks are uniform. They are F_s + beta V, and V the steady creep of
/// the two springs in a row, K V_o / (K + K_r (1 + a)), once the swing after the stick has died away.
#[test]
fn the_reset_integrator_s_peaks_are_uniform_and_known() {
    let model = table_2();
    let creep = 100.0 * 0.002 / (100.0 + model.stiffness * (1.0 + model.gradient));
    let expected = 0.25 + 30.0 * creep;
    let mut located = Peaks::NONE;
    pieces::run(&SPRING_MASS, &[model], 1e-10, 5.0, &mut located).unwrap();
    let mut stepped = Peaks::NONE;
    let mut dynamics = SingleValuedDynamics { mechanism: &SPRING_MASS, friction: [model] };
    fixed::run(&mut dynamics, 1e-5, 5.0, &mut stepped).unwrap();
    assert_eq!((located.stuck.len(), stepped.stuck.len()), (7, 7));
    for (located, stepped) in located.stuck.iter().zip(&stepped.stuck) {
        assert!((located - expected).abs() < 1e-8, "{located}, not {expected}");
        // The last step before the break sees less, by at most h K V_o.
        assert!((-2.1e-6..1e-7).contains(&(stepped - expected)), "{stepped}, not {expected}");
    }
}

/// Thesis section 2.3.2.1: a blow makes the friction at rest exceed F_s. Closed form of spring and damper under a
/// constant force, up to the instant at which p = p_o.
#[test]
fn a_blow_takes_the_reset_integrator_above_its_largest_friction() {
    let mut model = ResetIntegrator::by_rules(BLOCK_LEVELS[0], 1e-4, 1.0);
    model.damping = 55.0;
    let mut peaks = Peaks::NONE;
    pieces::run(&block(Shape::Square), &[model], 1e-10, 0.5, &mut peaks).unwrap();
    // x'' + 2 d x' + w0^2 x = 1 N/kg from rest: x' = sin(w t) exp(-d t) / w.
    let (decay, stiffness): (f64, f64) = (27.5, 8000.0);
    let w = (stiffness - decay * decay).sqrt();
    let x = |t: f64| (1.0 - (-decay * t).exp() * ((w * t).cos() + decay / w * (w * t).sin())) / stiffness;
    let (mut early, mut late) = (0.0, PI / w);
    for _ in 0..60 {
        let middle = 0.5 * (early + late);
        if x(middle) < 1e-4 { early = middle } else { late = middle }
    }
    let v = (-decay * early).exp() * (w * early).sin() / w;
    let expected = 0.8 + 55.0 * v;
    assert!(expected > 1.1, "the blow is no blow");
    assert!((peaks.stuck[0] - expected).abs() < 1e-8, "{:?}, not {expected}", peaks.stuck);
}

/// Thesis section 2.2.2.1: the Reset Integrator's friction at rest exceeds T_d at every stop of the pendulum,
/// Karnopp's at the first two only (there it is T_s, and the pendulum turns back at once).
#[test]
fn at_every_stop_of_the_pendulum_the_reset_integrator_exceeds_friction_in_motion() {
    /// The largest friction of each stay at rest, without the direction.
    struct Stops(Vec<f64>, bool);

    impl Observer<1> for Stops {
        fn sample(&mut self, sample: &Sample<1>) {
            let (rests, friction) = (sample.slip == [0], sample.friction[0].abs());
            match self.0.last_mut() {
                Some(largest) if rests && self.1 => *largest = largest.max(friction),
                _ if rests => self.0.push(friction),
                _ => {}
            }
            self.1 = rests;
        }

        fn event(&mut self, _: BodyEvent) {}
    }

    let levels = PENDULUM_LEVELS[0];
    let model = ResetIntegrator::by_rules(levels, 5.7e-4_f64.to_radians(), 1.0);
    let mut stops = Stops(Vec::new(), false);
    let mut dynamics = SingleValuedDynamics { mechanism: &PENDULUM, friction: [model] };
    fixed::run(&mut dynamics, 5e-6, 5.0, &mut stops).unwrap();
    // At the start and the two turns friction goes on to beta V beyond T_s. At the last stop it begins at T_s, when p
    // = p_o.
    let [turns @ .., last] = stops.0.as_slice() else { panic!("it stops") };
    assert_eq!(turns.len(), 3, "{:?}", stops.0);
    assert!(turns.iter().all(|largest| *largest > levels.stick), "{:?}", stops.0);
    assert!(*last < levels.stick && *last > 0.99 * levels.stick, "{:?}", stops.0);

    let mut exact = Stops(Vec::new(), false);
    located::run(&PENDULUM, &[levels], 1e-9, 5.0, &mut exact).unwrap();
    // Karnopp's turns take no time: the one stay at rest holds the weight against the torque.
    let holding = 6.0 - 9.81 * 0.611246279747176_f64.sin();
    let stay = exact.0[exact.0.len() - 1];
    assert!((stay - holding).abs() < 1e-6 && stay < levels.slip, "{:?}", exact.0);
}
