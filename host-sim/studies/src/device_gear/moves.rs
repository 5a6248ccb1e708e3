//! Moves of a device that show the gear between its two encoders.
//!
//! Three trajectories about the place where the loop closes, with the shares of the speed v:
//!
//! ```text
//! half of the way    w = min(5 deg, 0.2 s v, 0.8 of the room)      shares 1, 1/2, 1/4, 1/10
//! then               0.4 w                                         shares 1, 1, 1, 3/10
//! then               0.2 w                                         shares 1, 1, 1, 1
//! half blend         v / A: the set point turns round with the acceleration A
//! ```
//!
//! v and A are those of the device's `[profile]`; v can be bounded. Several speeds separate viscous
//! friction, slack and friction; the fast reversals wind up the gear by the inertia of its load. A
//! single speed is not enough: behind 5000 N m/rad and 0.1 deg of slack, the fit then shows 0.19
//! deg.

use stiction::control::reference::Corner;
use stiction::{Motion, Parameters};

use simulator::device::client::position_of;

/// Largest half of the way, deg.
const MOST_DEG: f64 = 5.0;

/// Time of half of the way at the full speed, s.
const HALF_WAY_S: f64 = 0.2;

/// Share of the room that the moves use. The joint may overshoot.
const OF_ROOM: f64 = 0.8;

/// Share of the way, and shares of the speed, of each trajectory. A leg each way has each share.
const TRAJECTORIES: [(f64, [f64; 4]); 3] =
    [(1.0, [1.0, 0.5, 0.25, 0.1]), (0.4, [1.0, 1.0, 1.0, 0.3]), (0.2, [1.0; 4])];

/// Rest of the set point before the first corner, beyond the soft start, and after the last one, s.
const RESTS_S: f64 = 0.3;

/// Least half of the way, counts of the load's encoder.
const FEWEST_COUNTS: f64 = 16.0;

/// A trajectory of the device, and its time.
#[derive(Clone, Debug, PartialEq)]
pub struct GearMove {
    /// Trajectory, from the zero of arming and back to it.
    pub motion: Motion,
    /// Time until the set point has rested, s.
    pub time_s: f64,
}

/// Bounds of the moves, beside those of the device.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GearBounds {
    /// Distance that the joint may go to either side of its place, deg.
    pub room_deg: f64,
    /// Largest speed, deg/s.
    pub speed: f32,
}

/// Returns the moves of a device with these parameters.
///
/// # Errors
/// Returns half a sentence with the reason if the room is too small.
pub fn moves(parameters: &Parameters, bounds: GearBounds) -> Result<Vec<GearMove>, String> {
    let resolution_deg = f64::from(parameters.controller.encoder.resolution);
    let room_deg = bounds.room_deg.max(0.0);
    let velocity = parameters.profile.velocity.min(bounds.speed);
    let speed = f64::from(velocity);
    let way_deg = MOST_DEG.min(HALF_WAY_S * speed).min(OF_ROOM * room_deg);
    let least_deg = FEWEST_COUNTS * resolution_deg;
    if way_deg < least_deg {
        return Err(format!(
            "the moves may go {} deg to either side, but need {}: raise the travel or \
             profile.velocity_deg_per_s, or start farther from the limits of the position",
            files::error::rounded(way_deg),
            files::error::rounded(least_deg)
        ));
    }
    let device = &parameters.device;
    // The first motion waits for the bridge's driver and the holding brake.
    let mut wait_s = f64::from(device.reset_pulse + device.wake_up + device.brake_open);
    let one = |(of_way, shares): &(f64, [f64; 4])| {
        let mut one = one(parameters, [of_way * way_deg, speed], shares)?;
        one.time_s += core::mem::take(&mut wait_s);
        Ok(one)
    };
    TRAJECTORIES.iter().map(one).collect()
}

fn one(
    parameters: &Parameters,
    [way_deg, speed]: [f64; 2],
    shares: &[f64],
) -> Result<GearMove, String> {
    let resolution_deg = f64::from(parameters.controller.encoder.resolution);
    let tick_s = files::written::single(parameters.controller.sample_time);
    let acceleration = f64::from(parameters.profile.acceleration);
    // A reversal changes the speed by 2 v in two half blends.
    let half_blend_s = (speed / acceleration).max(tick_s);
    let mut corners = Vec::new();
    let mut end_s = f64::from(parameters.device.soft_start) + RESTS_S + half_blend_s;
    let mut place_deg = 0.0;
    let legs = shares.iter().flat_map(|share| [(way_deg, share), (-way_deg, share)]);
    let back = shares.last().map(|share| (0.0, share));
    let start = std::iter::once((0.0, &1.0));
    for (to_deg, share) in start.chain(legs).chain(back) {
        if !corners.is_empty() {
            let leg_s: f64 = (to_deg - place_deg).abs() / (share * speed);
            // Two blends must fit, rounded to ticks.
            end_s += leg_s.max(2.0 * half_blend_s + 2.0 * tick_s);
        }
        place_deg = to_deg;
        let position = position_of(to_deg, resolution_deg).map_err(|error| error.to_string())?;
        corners.push(Corner { tick: (end_s / tick_s).round() as u32, position });
    }
    let corners = corners.into_iter().collect();
    let motion = Motion::Trajectory { corners, half_blend: half_blend_s as f32 };
    Ok(GearMove { motion, time_s: end_s + half_blend_s + RESTS_S })
}
