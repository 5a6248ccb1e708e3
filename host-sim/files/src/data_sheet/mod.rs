//! Data sheet of a joint, in SI: motor, gear, load, friction, supply, encoder.
//!
//! ```text
//! [motor], [gear], .. -> Tables -> DataSheet (checked) -> Mapping -> [joint], [drive], [encoder]
//! ```
//!
//! [`units`] has the mapping, and [`derive()`] writes its numbers into the tables that the core
//! reads. A file that sets a derived key is refused, so that a file cannot contradict itself.
//! [`tables`] has the keys.

mod axis;
mod check;
mod derived;
mod doubts;
mod drive;
mod motor_heat;
pub mod overview;
mod refusal;
mod resting_torque;
mod sheet;
mod simulated;
mod suspect;
pub mod tables;
pub mod units;
mod unseen_slack;

pub use axis::{SheetAxis, SheetFactors};
pub use derived::{OF_A_SHEET, derive, mapping};
pub use drive::shrink;
pub use motor_heat::MotorHeat;
pub use refusal::SheetRefusal;
pub use resting_torque::resting_torque;
pub use sheet::{DataSheet, LoopSide, Mount, SheetTables};
pub use suspect::Suspect;
pub use units::{Mapping, WrittenDrive};
pub use unseen_slack::UnseenSlack;

#[cfg(test)]
mod tests;
