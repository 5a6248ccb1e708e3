//! A guest: a law of another program, which a function of the host computes.
//!
//! ```text
//! v_c = update(guest, instance, input)
//! ```
//!
//! The guest is compared with the other laws under the same servo, monitors, soft start and
//! encoder. It replaces PD. The gains of PD still set the monitors, as for every other law. The
//! core stores the number of the guest's instance. At the start and after a reset the number is 0:
//! the host's function then makes an instance, and sets its number. An effort that is not a number
//! is applied as 0 and resets the law, as for every other law.

use core::fmt;

use crate::control::laws::{Law, LawInput, Loop};
use crate::units::error::Allowed;
use crate::units::value::{About, Absent, InvalidBits, Key, Table, Values};

/// Function of the host: guest, number of its instance, input of a tick -> effort, V.
#[derive(Clone, Copy)]
pub struct GuestUpdate(pub fn(&Guest, &mut u32, &LawInput) -> f32);

/// Properties of the joint that a guest gets beside the loop: those that the tuning rules use.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct GuestJoint {
    /// Largest effort of the drive, V: the full scale times `duty_max`.
    pub largest_effort: f32,
    /// Nominal inertia, V s^2/deg.
    pub inertia: f32,
    /// Nominal viscous friction, V s/deg.
    pub viscous: f32,
    /// Bounds of the breakaway effort, V.
    pub breakaway: [f32; 2],
    /// Largest load that drives the joint, V; 0: none does.
    pub load: f32,
    /// Effort that holds the load where the joint is armed, within 20 %, V.
    pub hold_effort: f32,
    /// Counts by which the encoder changes at rest.
    pub jitter: f32,
    /// Whether the encoder is on the load, behind an elastic gear.
    pub encoder_at_load: bool,
}

/// Configuration of a guest.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GuestGains {
    /// Function that computes the law.
    pub update: GuestUpdate,
    /// Number of the law at the host.
    pub law: u32,
    /// The joint.
    pub joint: GuestJoint,
    /// Default of `following_error_deg`, deg, for a law that follows a path of its own; 0: that of
    /// PD.
    pub following_error: f32,
}

/// A guest, prepared for a loop.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Guest {
    /// Configuration.
    pub gains: GuestGains,
    /// The loop around it.
    pub around: Loop,
}

impl Law for Guest {
    type Gains = GuestGains;
    type State = u32;

    const REPLACES_PD: bool = true;
    const ON_THE_DEVICE: bool = false;

    fn new(gains: &GuestGains, around: &Loop) -> Self {
        Self { gains: *gains, around: *around }
    }

    fn update(&self, state: &mut u32, input: &LawInput) -> f32 {
        (self.gains.update.0)(self, state, input)
    }

    fn following_error(gains: &GuestGains, _: &Loop) -> Option<f32> {
        (gains.following_error > 0.0).then_some(gains.following_error)
    }
}

impl PartialEq for GuestUpdate {
    fn eq(&self, other: &Self) -> bool {
        core::ptr::fn_addr_eq(self.0, other.0)
    }
}

impl fmt::Debug for GuestUpdate {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("GuestUpdate")
    }
}

/// No value of a file configures a guest.
impl Values for GuestGains {
    fn nth(&self, _: &mut usize) -> Option<(Key, Absent)> {
        None
    }

    fn get(&self, _: Key) -> Option<u32> {
        None
    }

    fn with_bounds(&self, _: Key) -> Option<(f32, Allowed)> {
        None
    }

    fn set(&mut self, _: Key, _: u32) -> Result<bool, InvalidBits> {
        Ok(false)
    }
}

impl Table for GuestGains {
    const EXAMPLE: Self = Self {
        update: GuestUpdate(|_, _, _| 0.0),
        law: 0,
        joint: GuestJoint {
            largest_effort: 0.0,
            inertia: 0.0,
            viscous: 0.0,
            breakaway: [0.0; 2],
            load: 0.0,
            hold_effort: 0.0,
            jitter: 0.0,
            encoder_at_load: false,
        },
        following_error: 0.0,
    };
    const ABOUT: &'static [About] = &[];
}
