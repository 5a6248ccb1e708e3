//! What can be said of a flash image without running it: its functions and who calls whom, the
//! stack that this takes at most, the cycles of its instructions, the memory that it fills, and the
//! routines that it must not have.

pub mod blocks;
pub mod budgets;
pub mod code;
pub mod cycles;
pub mod routines;
pub mod size;
pub mod stack;
pub mod thumb;

pub use code::{Code, Function};
