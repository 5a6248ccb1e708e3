//! A trajectory whose set point moves more than half of the limit of the following error in each
//! tick makes no room for an error.

use simulator::device::simulated::SimulatedDevice;
use stiction::Fault;
use stiction::control::reference::{Corner, Reference, Trajectory};
use stiction::servo::State;
use stiction::units::position::Position;

use crate::fixture::plans;

const COUNT: f32 = 0.00242;
const TICK_S: f32 = 0.02;
/// Speed of the set point, deg/s, and limit of the error, deg.
const SPEED: f32 = 15.0;
const LIMIT: f32 = 0.5;
/// The tick in which the joint is blocked: the blend at the begin is over, and half of the way is
/// to come.
const BLOCKED: u32 = 250;

/// Follows the line with PD, a block from a tick on, and nothing else that could see it; returns
/// the state, the ticks from the block on, and the largest error before it and at all, deg.
fn followed(blocked_from: u32) -> (State, u32, [f32; 2]) {
    let set = [
        "loop.controller=pd",
        "controller.pd.kp_v_per_deg=4",
        "controller.pd.kd_v_per_deg_per_s=0.6",
        "limits.following_error_deg=0.5",
        "limits.stall_v=0",
        "limits.stop_gain_deg_per_s2_per_v=0",
        "limits.continuous_v=0",
        "reference.steps_deg=[5.0]",
    ];
    let mut device = SimulatedDevice::new(&plans("step-response", &set)[0]).unwrap();
    device.ticks(50);
    device.device.servo().arm_for_link(None).unwrap();
    device.tick();
    let corner = |tick: u32, deg: f32| Corner {
        tick,
        position: Position::from_counts((deg / COUNT) as i32),
    };
    let corners = [corner(50, 0.0), corner(450, 400.0 * TICK_S * SPEED)];
    let trajectory = Trajectory::new(&corners, 0.5, TICK_S, COUNT).unwrap();
    device.device.servo().follow(Reference::Trajectory(trajectory)).unwrap();
    let mut errors = [0.0f32; 2];
    for tick in 0..550 {
        if tick >= blocked_from {
            device.brake_v = 100.0;
            device.push(device.position_deg(), 0.0);
        } else {
            errors[0] = errors[1];
        }
        device.device.servo().heard();
        let output = device.tick();
        if output.state != State::Armed {
            return (output.state, tick - blocked_from.min(tick), errors);
        }
        errors[1] = errors[1].max(output.tick.error.abs());
    }
    (State::Armed, 0, errors)
}

#[test]
fn a_joint_that_is_blocked_on_a_fast_line_is_seen_at_the_limit_of_its_error() {
    // The set point travels more than half of the limit in a tick.
    const { assert!(SPEED * TICK_S > LIMIT / 2.0) };
    let (state, _, [_, error]) = followed(u32::MAX);
    assert_eq!(state, State::Armed);
    assert!(error < LIMIT, "{error} deg without a block");

    let (state, ticks, [before, error]) = followed(BLOCKED);
    assert_eq!(state, State::Faulted(Fault::FollowingError), "{error} deg");
    // No tick with more than the limit went by, but for the rounding to a count.
    assert!(error <= LIMIT + COUNT, "{error} deg");
    // From an error of up to `before` of either sign, 0.3 deg a tick.
    let ticks_of = |way: f32| (way / (SPEED * TICK_S)).ceil() as u32;
    let expected = ticks_of(LIMIT - before)..=ticks_of(LIMIT + before) + 1;
    assert!(expected.contains(&ticks), "{ticks} of {expected:?} ticks");
}
