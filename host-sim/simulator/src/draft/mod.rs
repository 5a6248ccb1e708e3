//! A first file of somebody's own joint: a dozen answers, controllers by rule, and comments.
//!
//! ```text
//! typical joint, flags, a terminal -> Answers -> data sheet -> gains by rule -> text of a file
//! ```
//!
//! [`questions`] are what has to be known of a joint, [`typical`] answers them for three joints,
//! [`gains`] has the rules, [`text`](text()) the file, and [`spread`] how far its joint may be off.

pub mod gains;
pub mod questions;
pub mod spread;
mod text;
pub mod typical;

pub use gains::Told;
pub use questions::{Answer, Answers, QUESTIONS, Question};
pub use text::{Whys, Words, text, text_with};
pub use typical::{TYPICAL, Typical};
