//! The laws of others, to compare with: a law a file, as those beside it.
//!
//! They are compiled with the feature `rivals` alone, and no image has them
//! ([`Law::ON_THE_DEVICE`](super::Law::ON_THE_DEVICE)). What gains a joint gets from its data sheet
//! is said by the tuning rules of the simulator, so that each law is judged at its best. A
//! [`guest`] is computed by another program.

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
