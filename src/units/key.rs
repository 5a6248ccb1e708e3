//! The number that identifies a configured value in a record, over the link and in an error.

/// The number of a value, in records and over the link. A number is never reused for another value.
///
/// The high byte is the table: 1 loop, 2 encoder, 3 drive, 4 PD, 5 list of laws, 6 motion, 7
/// corners, 8 device, 9 limits, 10 profile, 11 jog, 12 the motor's own encoder, and 16 plus the
/// law's number for its gains.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
#[cfg_attr(feature = "device", derive(serde::Serialize, serde::Deserialize))]
pub struct Key(pub u16);
