//! The thesis's mechanisms and frictions, as the tests use them.

use dynamics::friction::Coulomb;
use dynamics::mechanism::{Mechanism, TwoLinkArm};
use dynamics::solver::EventKind;
use friction_lab::friction::ResetIntegrator;
use friction_lab::mechanism::{
    CoupledBlocks, DrivenBlock, IndependentBlocks, Pendulum, Pull, Shape, SpringMass, TwoBlocks,
    Wave,
};
use friction_lab::solver::state::{BodyEvent, BodySample, Finish, Observer};
use friction_lab::solver::{event_driven, piecewise_smooth};

/// Table 1.
pub const SPRING_MASS: SpringMass =
    SpringMass { mass: 0.1, stiffness: 100.0, pull: Pull::steady(0.002) };
pub const SPRING_MASS_LEVELS: [Coulomb; 1] = [Coulomb { stick: 0.25, slip: 0.20 }];

/// Table 4.
pub const COUPLED: CoupledBlocks = CoupledBlocks(TwoBlocks {
    mass: [0.1, 0.1],
    stiffness: [100.0, 200.0],
    pull: Pull::Ramp { speed: 0.2, until_s: 0.25 },
});
pub const COUPLED_LEVELS: [Coulomb; 2] =
    [Coulomb { stick: 0.15, slip: 0.10 }, Coulomb { stick: 0.30, slip: 0.20 }];

/// Table 7, with stick and slip the right way around.
pub const PENDULUM: Pendulum = Pendulum { mass: 1.0, length: 1.0, torque: 6.0, start: 0.0 };
pub const PENDULUM_LEVELS: [Coulomb; 1] = [Coulomb { stick: 1.2, slip: 0.96 }];

/// Table 10.
pub const ARM: TwoLinkArm =
    TwoLinkArm { mass: [1.0, 1.0], length: [1.0, 1.0], torque: [0.4, 0.3], start: [0.0, 0.0] };
pub const ARM_LEVELS: [Coulomb; 2] =
    [Coulomb { stick: 0.10, slip: 0.08 }, Coulomb { stick: 0.075, slip: 0.06 }];

/// Tables 13 and 14.
pub const fn block(shape: Shape) -> DrivenBlock {
    DrivenBlock { mass: 1.0, push: Wave { shape, amplitude: 1.0, period_s: 4.0 } }
}
pub const BLOCK_LEVELS: [Coulomb; 1] = [Coulomb { stick: 0.8, slip: 0.6 }];

/// Table 22.
pub fn independent() -> IndependentBlocks {
    use std::f64::consts::PI;
    let pull = Pull::Cosine { speed: PI / 5.0, frequency: 4.0 * PI };
    IndependentBlocks(TwoBlocks { mass: [0.1, 0.1], stiffness: [100.0, 100.0], pull })
}
pub const INDEPENDENT_LEVELS: [Coulomb; 2] = [Coulomb { stick: 2.4, slip: 1.6 }; 2];

/// One degree.
pub const DEG: f64 = std::f64::consts::PI / 180.0;

const fn reset_integrator(
    levels: Coulomb,
    range: f64,
    stiffness: f64,
    damping: f64,
    a: f64,
) -> ResetIntegrator {
    ResetIntegrator { levels, range, stiffness, damping, gradient: a }
}

/// The Reset Integrator of Tables 2, 5, 8, 11 and 15.
pub const ON_SPRING: [ResetIntegrator; 1] =
    [reset_integrator(SPRING_MASS_LEVELS[0], 1e-5, 2e4, 30.0, 0.25)];
pub const OF_PENDULUM: [ResetIntegrator; 1] =
    [reset_integrator(PENDULUM_LEVELS[0], 5.7e-4 * DEG, 0.96 / (5.7e-4 * DEG), 246.0, 0.25)];
pub const OF_BLOCK: [ResetIntegrator; 1] =
    [reset_integrator(BLOCK_LEVELS[0], 1e-4, 6000.0, 55.0, 1.0 / 3.0)];
/// Every sample and event.
#[derive(Default)]
pub struct Everything<const N: usize> {
    pub samples: Vec<BodySample<N>>,
    pub events: Vec<BodyEvent>,
}

impl<const N: usize> Observer<N> for Everything<N> {
    fn sample(&mut self, sample: &BodySample<N>) {
        self.samples.push(*sample);
    }

    fn event(&mut self, event: BodyEvent) {
        self.events.push(event);
    }
}

/// A run of the Reset Integrator with its switches located.
pub fn followed<const N: usize, M: Mechanism<N>>(
    mechanism: &M,
    friction: &[ResetIntegrator; N],
    duration_s: f64,
) -> Everything<N> {
    let mut everything = Everything::default();
    piecewise_smooth::run(mechanism, friction, 1e-10, duration_s, &mut everything).unwrap();
    everything
}

/// Events and end of an exact run.
pub fn exact<const N: usize, M: Mechanism<N>>(
    mechanism: &M,
    levels: &[Coulomb; N],
    tolerance: f64,
    duration_s: f64,
) -> (Vec<BodyEvent>, Finish<N>) {
    let mut events = Vec::new();
    let finish = event_driven::run(mechanism, levels, tolerance, duration_s, &mut events).unwrap();
    (events, finish)
}

/// Whether the events are these, body counted from 1, each time within `tolerance`.
#[track_caller]
pub fn assert_events(events: &[BodyEvent], expected: &[(f64, usize, EventKind)], tolerance: f64) {
    let found: Vec<_> = events.iter().map(|e| (e.time_s, e.body + 1, e.kind)).collect();
    assert_eq!(found.len(), expected.len(), "{found:?}");
    for (found, expected) in found.iter().zip(expected) {
        assert!((found.1, found.2) == (expected.1, expected.2), "{found:?}, not {expected:?}");
        assert!((found.0 - expected.0).abs() < tolerance, "{found:?}, not {expected:?}");
    }
}
