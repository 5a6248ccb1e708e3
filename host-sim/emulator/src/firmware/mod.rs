//! Static analysis of a flash image: functions and their calls, largest stack, cycles of
//! instructions, memory, and forbidden routines.

pub mod blocks;
pub mod budgets;
pub mod code;
pub mod cycles;
pub mod routines;
pub mod size;
pub mod stack;
pub mod thumb;

pub use code::{Code, Function};
