//! Joints in the place of a machine's axis: in a run, under the servo, and in a simulated device.
#![allow(clippy::unwrap_used)]

use dynamics::joint::{
    Body, CoreUnits, Description, DiscSide, Gravity, LoadTorque, ShaftDescription, StribeckCurve,
    Substitute, Train, presets,
};
use simulator::device::simulated::SimulatedDevice;
use simulator::experiment::{Document, Experiment, RunPlan};
use simulator::run::{RunDriver, RunTrace, run_driven};

/// One count of the thesis's encoder, rad.
const COUNT: f64 = 0.00242 * std::f64::consts::PI / 180.0;

/// Any effort gain, N m/V: the core does not see it.
const UNITS: CoreUnits = CoreUnits { effort_gain: 12.5 };

fn plan(controller: &str) -> RunPlan {
    let mut document = Document::open("step-response").unwrap();
    document.set(&["reference.steps_deg=[2.5]".into()]).unwrap();
    Experiment::plan(&document, &[controller.into()], &[]).unwrap().runs.remove(0)
}

/// The thesis's axis in SI.
fn axis() -> Body {
    let per_degree = UNITS.effort_gain * 1.0_f64.to_degrees();
    let body = presets::thesis_axis();
    let curve = body.friction.curve;
    let curve = StribeckCurve {
        coulomb: curve.coulomb * UNITS.effort_gain,
        stick: curve.stick * UNITS.effort_gain,
        viscous: curve.viscous * per_degree,
        ..curve
    };
    Body { inertia: body.inertia * per_degree, friction: curve.into() }
}

fn on(plan: RunPlan, joint: Description) -> RunPlan {
    let substitute = Some(Substitute { joint, units: UNITS, side: DiscSide::Motor });
    RunPlan { substitute, ..plan }
}

fn last_position_deg(plan: &RunPlan, driven: RunDriver) -> f64 {
    let result = run_driven(plan, driven).unwrap();
    assert_eq!(result.fault, None, "{}", result.plan.label);
    let (RunTrace::Loop(moments) | RunTrace::Ramp(moments)) = result.trace;
    moments.last().unwrap().position_deg
}

#[test]
fn the_thesis_s_axis_is_that_of_its_experiments() {
    let (axis, preset) = (plan("pd").axis().unwrap(), presets::thesis_axis());
    let curve = preset.friction.curve;
    assert_eq!(preset.inertia, 1.0 / axis.gain);
    assert_eq!(curve.viscous, axis.viscous);
    assert_eq!([curve.coulomb, curve.stick], [axis.friction.slip, axis.friction.stick]);
}

#[test]
fn the_axis_in_si_takes_the_place_of_the_axis_in_degrees() {
    let same = Description::of(Train::Rigid(axis()), COUNT);
    for driven in [RunDriver::ByLoop, RunDriver::ByServo] {
        let wanted = last_position_deg(&plan("pd"), driven);
        let found = last_position_deg(&on(plan("pd"), same), driven);
        assert!((found - wanted).abs() < 1e-6, "{driven:?}: {found} instead of {wanted} deg");
        assert!(wanted > 2.0);
    }
}

#[test]
fn a_load_and_a_shaft_change_where_a_run_ends() {
    let bare = last_position_deg(&plan("pd"), RunDriver::ByLoop);
    let amplitude = 0.5 * UNITS.effort_gain;
    let gravity = Some(Gravity { amplitude, angle: 1.5 });
    let load = LoadTorque { constant: 0.0, gravity };
    let hanging = Description { load, ..Description::of(Train::Rigid(axis()), COUNT) };
    let hanging = last_position_deg(&on(plan("pd"), hanging), RunDriver::ByLoop);
    // PD rests lower under a pendulum that pulls back, by about its torque over the gain.
    assert!(hanging < bare - 0.1, "{hanging} and {bare} deg");
    let half = |share: f64| {
        let Body { inertia, friction } = axis();
        let mut curve = friction.curve;
        curve.coulomb *= share;
        curve.stick *= share;
        curve.viscous *= share;
        Body { inertia: inertia * share, friction: curve.into() }
    };
    let shaft = ShaftDescription { stiffness: 5e4, damping: 20.0, backlash: 10.0 * COUNT };
    let train = Train::Flexible { motor: half(0.5), load: half(0.5), shaft };
    let flexible = on(plan("srnf"), Description::of(train, COUNT));
    let mut device = SimulatedDevice::new(&flexible).unwrap();
    device.push(1.0, 0.0);
    device.ticks(50);
    assert!((device.position_deg() - 1.0).abs() < 1e-9);
    assert!((last_position_deg(&flexible, RunDriver::ByLoop) - 2.5).abs() < 0.1);
}
