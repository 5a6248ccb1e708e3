//! The law `robust`, held against the traces of its prototype and run around simple joints. What a
//! test knows of the law is its input and output, and its signals. The parts have tests of their
//! own, in their files; the contracts of every law are in `tests/contracts/`.

// The fixtures of tests may panic like the tests themselves.
#![allow(clippy::unwrap_used)]

mod beyond;
mod closed_loop;
mod golden;
mod joint;
