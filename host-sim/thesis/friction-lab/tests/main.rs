//! The friction lab (thesis Chapter 2 and Appendix A.1): every expected value is a closed form, a
//! published number or the result of a second method at a tighter tolerance.
#![allow(
    missing_docs,
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    clippy::needless_range_loop
)]

mod arm;
mod common;
mod models;
mod no_hang;
mod nonsmooth;
mod published;
mod reset_integrator;
mod second_method;
