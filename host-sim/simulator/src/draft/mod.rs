//! A first file of a user's own joint: answers, controllers by rule, and comments.
//!
//! ```text
//! typical joint, flags, a terminal -> Answers -> data sheet -> rules/: gains -> text of a file
//! ```
//!
//! [`questions`] lists the questions, [`answers`] holds the answers, [`trial`] checks each of them,
//! [`typical`] answers all for three joints, [`range`] reads ranges, [`text`](text()) writes the
//! file with the gains of the [rule book](crate::rules), and [`spread`] has the ranges of its
//! joint. [`written`](written()) checks that the file runs.

pub mod answers;
mod both_encoders;
pub mod questions;
pub mod range;
pub mod spread;
mod text;
pub mod trial;
#[cfg(test)]
mod two_encoders_tests;
pub mod typical;
mod written;

pub use answers::{Answer, Answers};
pub use both_encoders::both_encoders;
pub use questions::{QUESTIONS, Question};
pub use text::{DraftStyle, Sources, text, text_with};
pub use typical::{TYPICAL, Typical};
pub use written::{Written, complete, written};
