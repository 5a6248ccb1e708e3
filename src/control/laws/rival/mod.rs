//! Laws by other authors, for comparison: one law a file, as in the folder above.
//!
//! They are compiled with the feature `rivals` alone, and no image has them
//! ([`Law::ON_THE_DEVICE`](super::Law::ON_THE_DEVICE)). The tuning rules of the simulator set the
//! gains for a joint from its data sheet, so that each law is judged at its best. A [`guest`] is
//! computed by another program.

pub mod guest;
pub mod impulsive;
pub mod pid;
pub mod proxy_sliding_mode;
pub mod two_reset_pid;

pub use guest::{Guest, GuestGains, GuestJoint, GuestUpdate};
pub use impulsive::{Impulsive, ImpulsiveGains};
pub use pid::{Pid, PidGains};
pub use proxy_sliding_mode::{ProxySlidingMode, ProxySlidingModeGains};
pub use two_reset_pid::{TwoResetPid, TwoResetPidGains};
