//! Friction compensators: what is added to the PD loop's output.
//!
//! Each law is one module that begins with its equation. Its `Gains` are what a user sets, in the thesis's units;
//! the law itself is made of them once, for a sample time, and holds what a tick needs; its state is apart,
//! `Copy`, and starts as its `Default`. [`Law`] is the closed set of them, chosen at run time, and a
//! [`Compensator`] is a sum of up to [`MAX_TERMS`] laws (none: plain PD).
//!
//! Compensators switch on the error, on the reference velocity or on the velocity error. Only RVI uses measured
//! velocity, squared: a law that switches on its sign chatters at standstill.

pub mod discontinuous_nonlinear_proportional;
pub mod feedforward;
pub mod rate_variable_integral;
pub mod reset_integral;
pub mod reset_offset_integral;
pub mod smooth_robust_nonlinear;

use heapless::Vec;
use serde::{Deserialize, Serialize};

pub use discontinuous_nonlinear_proportional::{
    DiscontinuousNonlinearProportional, DiscontinuousNonlinearProportionalGains,
};
pub use feedforward::{Feedforward, FeedforwardGains};
pub use rate_variable_integral::{RateVariableIntegral, RateVariableIntegralGains};
pub use reset_integral::{ResetIntegral, ResetIntegralGains};
pub use reset_offset_integral::{ResetOffsetIntegral, ResetOffsetIntegralGains};
pub use smooth_robust_nonlinear::{SmoothRobustNonlinear, SmoothRobustNonlinearGains};

use crate::error::Error;

/// The largest number of laws in a sum.
pub const MAX_TERMS: usize = 4;

/// What a law sees of one tick.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Sample {
    /// theta_e = theta_d - theta_a, deg.
    pub error: f32,
    /// theta_a', measured, deg/s.
    pub velocity: f32,
    /// theta_d', deg/s.
    pub reference_velocity: f32,
    /// theta_d' - theta_a', deg/s.
    pub velocity_error: f32,
    /// Output of the PD loop, V.
    pub v_pd: f32,
}

/// What the laws take from the loop around them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Loop {
    /// Time between samples h, s.
    pub sample_time: f32,
    /// Largest output, V: no integral grows beyond it.
    pub full_scale: f32,
    /// Proportional gain of the PD loop, V/deg.
    pub kp: f32,
}

/// The gains of one law.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum Gains {
    /// RI, eq. 29.
    ResetIntegral(ResetIntegralGains),
    /// RVI, eq. 30.
    RateVariableIntegral(RateVariableIntegralGains),
    /// ROI, eq. 31.
    ResetOffsetIntegral(ResetOffsetIntegralGains),
    /// Slip friction feedforward, eq. 32.
    Feedforward(FeedforwardGains),
    /// DNPF, eq. 33.
    DiscontinuousNonlinearProportional(DiscontinuousNonlinearProportionalGains),
    /// SRNF, eq. 35.
    SmoothRobustNonlinear(SmoothRobustNonlinearGains),
}

/// One law, ready to be used.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Law {
    /// RI, eq. 29.
    ResetIntegral(ResetIntegral),
    /// RVI, eq. 30.
    RateVariableIntegral(RateVariableIntegral),
    /// ROI, eq. 31.
    ResetOffsetIntegral(ResetOffsetIntegral),
    /// Slip friction feedforward, eq. 32.
    Feedforward(Feedforward),
    /// DNPF, eq. 33.
    DiscontinuousNonlinearProportional(DiscontinuousNonlinearProportional),
    /// SRNF, eq. 35.
    SmoothRobustNonlinear(SmoothRobustNonlinear),
}

/// The state of one law.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum LawState {
    /// Of a law that remembers nothing.
    #[default]
    Memoryless,
    /// Of RI.
    ResetIntegral(reset_integral::State),
    /// Of RVI.
    RateVariableIntegral(rate_variable_integral::State),
    /// Of ROI.
    ResetOffsetIntegral(reset_offset_integral::State),
}

impl Law {
    /// Validates gains and prepares the law for a loop.
    ///
    /// # Errors
    /// Names the gain.
    pub fn new(gains: &Gains, around: &Loop) -> Result<Self, Error> {
        Ok(match gains {
            Gains::ResetIntegral(gains) => Self::ResetIntegral(ResetIntegral::new(gains, around)?),
            Gains::RateVariableIntegral(gains) => {
                Self::RateVariableIntegral(RateVariableIntegral::new(gains, around)?)
            }
            Gains::ResetOffsetIntegral(gains) => {
                Self::ResetOffsetIntegral(ResetOffsetIntegral::new(gains, around)?)
            }
            Gains::Feedforward(gains) => Self::Feedforward(Feedforward::new(gains)?),
            Gains::DiscontinuousNonlinearProportional(gains) => Self::DiscontinuousNonlinearProportional(
                DiscontinuousNonlinearProportional::new(gains, around)?,
            ),
            Gains::SmoothRobustNonlinear(gains) => {
                Self::SmoothRobustNonlinear(SmoothRobustNonlinear::new(gains)?)
            }
        })
    }

    /// The state that the law starts from.
    pub const fn rest(&self) -> LawState {
        match self {
            Self::ResetIntegral(_) => LawState::ResetIntegral(reset_integral::State::REST),
            Self::RateVariableIntegral(_) => {
                LawState::RateVariableIntegral(rate_variable_integral::State::REST)
            }
            Self::ResetOffsetIntegral(_) => LawState::ResetOffsetIntegral(reset_offset_integral::State::REST),
            Self::Feedforward(_)
            | Self::DiscontinuousNonlinearProportional(_)
            | Self::SmoothRobustNonlinear(_) => LawState::Memoryless,
        }
    }

    /// The law's part of v_c for one sample, V.
    ///
    /// A state that another law left behind is replaced, and the law contributes nothing in that tick.
    #[cfg_attr(not(target_os = "none"), inline)]
    pub fn update(&self, state: &mut LawState, sample: &Sample) -> f32 {
        match (self, &mut *state) {
            (Self::ResetIntegral(law), LawState::ResetIntegral(state)) => law.update(state, sample),
            (Self::RateVariableIntegral(law), LawState::RateVariableIntegral(state)) => {
                law.update(state, sample)
            }
            (Self::ResetOffsetIntegral(law), LawState::ResetOffsetIntegral(state)) => {
                law.update(state, sample)
            }
            (Self::Feedforward(law), _) => law.update(sample),
            (Self::DiscontinuousNonlinearProportional(law), _) => law.update(sample),
            (Self::SmoothRobustNonlinear(law), _) => law.update(sample),
            _ => {
                *state = self.rest();
                0.0
            }
        }
    }
}

/// A sum of laws; the empty sum is plain PD.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Compensator {
    terms: Vec<Law, MAX_TERMS>,
}

/// The states of a sum's terms.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct CompensatorState {
    terms: [LawState; MAX_TERMS],
}

impl Compensator {
    /// Validates the gains of every term and prepares the sum for a loop.
    ///
    /// # Errors
    /// Names the gain.
    pub fn new(gains: &Vec<Gains, MAX_TERMS>, around: &Loop) -> Result<Self, Error> {
        let mut terms = Vec::new();
        for gains in gains {
            // Cannot fail: both vectors have the same capacity.
            let _ = terms.push(Law::new(gains, around)?);
        }
        Ok(Self { terms })
    }

    /// The state that the sum starts from.
    pub fn rest(&self) -> CompensatorState {
        let mut state = CompensatorState::default();
        for (law, state) in self.terms.iter().zip(&mut state.terms) {
            *state = law.rest();
        }
        state
    }

    /// v_c for one sample, V.
    #[cfg_attr(not(target_os = "none"), inline)]
    pub fn update(&self, state: &mut CompensatorState, sample: &Sample) -> f32 {
        let mut v_c = 0.0;
        for (law, state) in self.terms.iter().zip(&mut state.terms) {
            v_c += law.update(state, sample);
        }
        v_c
    }
}
