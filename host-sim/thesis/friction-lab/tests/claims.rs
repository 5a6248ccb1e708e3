//! What the thesis's Chapter 2 says of its two models, and whether it holds.

use std::ops::Range;

use dynamics::solver::EventKind::Break;
use friction_lab::solver::banded::{BandCoupling, Banded};
use friction_lab::solver::dynamics::{Dynamics, SingleValuedDynamics};
use friction_lab::solver::fixed_step;
use friction_lab::solver::state::{BodyEvent, BodySample, Observer};
use friction_lab::solver::step_doubling::{self, Accuracy};

use super::common::{
    ARM, ARM_LEVELS, COUPLED, COUPLED_LEVELS, DEG, Everything, OF_ARM, OF_COUPLED, OF_PENDULUM,
    ON_SPRING, PENDULUM, PENDULUM_LEVELS, SPRING_MASS, SPRING_MASS_LEVELS, exact, followed,
};

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
    // The bristle gives way by p_o, and springs back by a part of it at each stop: of the step, 1.2
    // mm, about a percent.
    for (reset, karnopp) in reset.windows(2).zip(karnopp.windows(2)) {
        let ratio = (reset[1] - reset[0]) / (karnopp[1] - karnopp[0]);
        assert!((0.98..1.02).contains(&ratio) && ratio != 1.0, "{ratio}");
    }
}

fn stepped<D: Dynamics<2, 0>>(mut dynamics: D, step_s: f64) -> (Everything<2>, [f64; 2]) {
    let mut everything = Everything::default();
    let finish = fixed_step::run(&mut dynamics, step_s, 5.0, &mut everything).unwrap();
    (everything, finish.q)
}

const fn bands(deg_per_s: f64) -> [f64; 2] {
    [deg_per_s * DEG; 2]
}

/// 2.2.2.2, Fig. 13: "Neglecting these coupled accelerations in the Karnopp model is invalid. The
/// accelerations at approximately t = 1.25 seconds and t = 2.5 seconds ... when both joints are
/// sticking".
#[test]
fn a_stuck_joint_is_accelerated_by_the_other_when_coupling_is_neglected() {
    let kicks = |coupling| {
        let (run, _) = stepped(Banded::new(&ARM, ARM_LEVELS, bands(5.7e-4), coupling), 1e-5);
        let in_bands = run.samples.into_iter().filter(|s| s.slip == [0, 0] && s.a[1].abs() > 1e-3);
        in_bands.map(|s| s.time_s).collect::<Vec<_>>()
    };
    let (right, neglected) = (kicks(BandCoupling::Simultaneous), kicks(BandCoupling::Neglected));
    // Joint 1 turns around there, and joint 2 sticks.
    for around_s in [1.25, 2.56] {
        let near =
            |times_s: &[f64]| times_s.iter().filter(|t| (**t - around_s).abs() < 0.02).count();
        assert!(
            near(&right) == 0 && near(&neglected) > 0,
            "{around_s}: {} {}",
            near(&right),
            near(&neglected)
        );
    }
}

/// 2.2.2.2 expects the accelerations of the step before to be "more accurate than having no
/// acceleration component".
#[test]
fn accelerations_of_the_step_before_are_not_more_accurate_than_none() {
    let right = [0.00449854385477193, 0.0252895664467873];
    let run = |coupling| stepped(Banded::new(&ARM, ARM_LEVELS, bands(5.7e-4), coupling), 1e-5).1;
    let (neglected, previous) = (run(BandCoupling::Neglected), run(BandCoupling::PreviousStep));
    for i in 0..2 {
        let error = |q: [f64; 2]| (q[i] / right[i] - 1.0).abs();
        assert!(error(neglected) < 0.01, "{neglected:?}");
        assert!(error(previous) > 5.0 * error(neglected), "{previous:?}");
        // An independent simulation.
        assert!((previous[i] / [0.00412, 0.02733][i] - 1.0).abs() < 0.015, "{previous:?}");
    }
}

fn adaptive<const N: usize, const Z: usize, D: Dynamics<N, Z> + Clone, O: Observer<N>>(
    dynamics: &D,
    eps: f64,
    duration_s: f64,
    observer: &mut O,
) -> u64 {
    let accuracy = Accuracy { eps, max_evaluations: 1_000_000_000 };
    step_doubling::run(&mut dynamics.clone(), accuracy, duration_s, observer).unwrap().evaluations
}

/// How often each friction is found on its other side while both joints are in their bands, if it
/// has a part of its limits there.
struct Sides {
    /// T_d and T_s.
    levels: [[f64; 2]; 2],
    /// The last side on which each friction was, at each level.
    sides: [[f64; 2]; 2],
    changes: [[u32; 2]; 2],
}

impl Observer<2> for Sides {
    fn sample(&mut self, sample: &BodySample<2>) {
        if sample.slip != [0, 0] {
            return;
        }
        for (level, limits) in self.levels.iter().enumerate() {
            for joint in 0..2 {
                let side = sample.friction[joint].signum();
                if sample.friction[joint].abs() > 0.99 * limits[joint] {
                    self.changes[level][joint] += u32::from(self.sides[level][joint] == -side);
                    self.sides[level][joint] = side;
                }
            }
        }
    }

    fn event(&mut self, _: BodyEvent) {}
}

/// Fig. 14, 70 minutes on a workstation: D_v = 5.7e-3 deg/s, accelerations of the step before, eps
/// = 2e-4. It ends, after hundreds of times the work of the simultaneous decision. The frictions
/// "oscillate between the maximum values of stick friction ... switching back and forth from limit
/// to limit"; they do switch from side to side, but at the level of slip, which a joint brings
/// along into its band: of the switches at that level, few are between the limits at rest.
#[test]
fn the_run_of_seventy_minutes_ends_and_its_frictions_switch_from_side_to_side() {
    let banded = |coupling| Banded::new(&ARM, ARM_LEVELS, bands(5.7e-3), coupling);
    let levels = [ARM_LEVELS.map(|f| f.slip), ARM_LEVELS.map(|f| f.stick)];
    let mut sides = Sides { levels, sides: [[0.0; 2]; 2], changes: [[0; 2]; 2] };
    let previous = adaptive(&banded(BandCoupling::PreviousStep), 2e-4, 5.0, &mut sides);
    let ratio =
        previous / adaptive(&banded(BandCoupling::Simultaneous), 2e-4, 5.0, &mut Vec::new());
    assert!((500..100_000).contains(&ratio), "{ratio}");
    let [slip, stick] = sides.changes;
    assert!(slip.iter().all(|changes| *changes > 10), "{slip:?}");
    assert!((0..2).all(|joint| stick[joint] < slip[joint] / 10), "{stick:?} of {slip:?}");
}

/// Tables 3, 6, 9, 12: seconds of a 486, here derivative evaluations, at several eps about the
/// thesis's 2e-4, since how many steps a switch takes is a matter of luck. The Reset Integrator is
/// the dearer one in three, by the printed ratio within a factor of two; on the arm with the
/// thesis's own coupling and with the simultaneous decision. In Table 6 (the coupled blocks) the
/// thesis has Karnopp dearer, 0.44 to 0.38 s; here it is the other way around at every eps, though
/// within that factor of two.
///
/// It depends on the bound of `step_doubling`, by which a rejected step becomes no shorter than a
/// tenth of it: without one (the book's first edition) the arm with neglected coupling chatters,
/// and the order of Table 12 is not the thesis's at every eps.
#[test]
fn the_reset_integrator_costs_more_than_karnopp() {
    const EPS: [f64; 5] = [1.6e-4, 1.8e-4, 2.0e-4, 2.2e-4, 2.4e-4];
    fn ratios<const N: usize>(
        reset: &(impl Dynamics<N, 1> + Clone),
        karnopp: &(impl Dynamics<N, 0> + Clone),
        duration_s: f64,
    ) -> [f64; 5] {
        let quiet = &mut Vec::new();
        EPS.map(|eps| {
            adaptive(reset, eps, duration_s, quiet) as f64
                / adaptive(karnopp, eps, duration_s, quiet) as f64
        })
    }
    let about = |printed: f64| 0.5 * printed..2.0 * printed;
    let check = |table: &str, ratios: [f64; 5], range: Range<f64>| {
        assert!(
            ratios.iter().all(|ratio| *ratio > 1.0 && range.contains(ratio)),
            "{table}: \
            {ratios:?}"
        );
    };
    let simultaneous = BandCoupling::Simultaneous;
    let of_spring = ratios(
        &SingleValuedDynamics { mechanism: &SPRING_MASS, friction: ON_SPRING },
        &Banded::new(&SPRING_MASS, SPRING_MASS_LEVELS, [2e-5], simultaneous),
        5.0,
    );
    check("Table 3", of_spring, about(0.99 / 0.44));
    let of_blocks = ratios(
        &SingleValuedDynamics { mechanism: &COUPLED, friction: OF_COUPLED },
        &Banded::new(&COUPLED, COUPLED_LEVELS, [1e-4; 2], simultaneous),
        0.5,
    );
    check("Table 6", of_blocks, about(0.38 / 0.44));
    let of_pendulum = ratios(
        &SingleValuedDynamics { mechanism: &PENDULUM, friction: OF_PENDULUM },
        &Banded::new(&PENDULUM, PENDULUM_LEVELS, [5.7e-4 * DEG], simultaneous),
        5.0,
    );
    check("Table 9", of_pendulum, about(0.44 / 0.16));
    let on_arm = SingleValuedDynamics { mechanism: &ARM, friction: OF_ARM };
    for coupling in [BandCoupling::Neglected, simultaneous] {
        let karnopp = Banded::new(&ARM, ARM_LEVELS, bands(5.7e-4), coupling);
        check("Table 12", ratios(&on_arm, &karnopp, 5.0), about(3.46 / 1.10));
    }
}
