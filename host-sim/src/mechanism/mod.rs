//! Mechanisms: what friction acts on.

mod robot_axis;

pub use robot_axis::RobotAxis;
