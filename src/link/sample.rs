//! Terms of ticks, as they are sent to those who have subscribed.

use heapless::Vec;
use serde::{Deserialize, Serialize};

/// Terms of one tick.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Sample {
    /// Counts every sample that was due: a gap says how many were lost.
    pub number: u32,
    /// Ticks since power-on.
    pub clock: u32,
    /// Which terms.
    pub terms: u16,
    /// Their values in the order of [`Term::ALL`], four bytes each, little endian.
    pub values: Vec<u8, 64>,
}

/// A term of a tick.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub enum Term {
    /// Whole counts of theta_d; `i32`.
    SetpointCounts = 0,
    /// The fraction of a count; `f32`, as all that follow unless they say otherwise.
    SetpointFraction = 1,
    /// theta_d', deg/s.
    SetpointVelocity = 2,
    /// theta_a, counts; `i32`.
    Counts = 3,
    /// theta_e, deg.
    Error = 4,
    /// theta_a', deg/s.
    Velocity = 5,
    /// v_PD, V.
    Pd = 6,
    /// v_c, V.
    Compensator = 7,
    /// v, V.
    Output = 8,
    /// The drive's code, as it was applied; `i32`.
    Code = 9,
    /// Compare value; `i32`, negative if the direction is reverse.
    Duty = 10,
    /// `u32`: bits 0 to 7 the state (0 boot, 1 stopped, 2 armed, 3 faulted), 8 to 15 the fault's code, 16 saturated, 17 wound
    /// up, 18 bridge on.
    Flags = 11,
}

impl Term {
    /// All of them, in the order of their values in a sample.
    pub const ALL: [Self; 12] = [
        Self::SetpointCounts,
        Self::SetpointFraction,
        Self::SetpointVelocity,
        Self::Counts,
        Self::Error,
        Self::Velocity,
        Self::Pd,
        Self::Compensator,
        Self::Output,
        Self::Code,
        Self::Duty,
        Self::Flags,
    ];

    /// Its bit in a subscription.
    pub const fn bit(self) -> u16 {
        1 << self as u8
    }
}

impl Sample {
    /// The value of a term, if the sample has it.
    ///
    /// ```
    /// use stiction::link::{Sample, Term};
    /// let terms = Term::Counts.bit() | Term::Code.bit();
    /// let values = [1, 0, 0, 0, 254, 255, 255, 255].into_iter().collect();
    /// let sample = Sample { number: 0, clock: 0, terms, values };
    /// let term = |term| sample.value(term).map(i32::from_le_bytes);
    /// assert_eq!([Term::Counts, Term::Error, Term::Code].map(term), [Some(1), None, Some(-2)]);
    /// ```
    pub fn value(&self, term: Term) -> Option<[u8; 4]> {
        if self.terms & term.bit() == 0 {
            return None;
        }
        let before = (self.terms & (term.bit() - 1)).count_ones() as usize;
        self.values.get(4 * before..)?.first_chunk().copied()
    }
}
