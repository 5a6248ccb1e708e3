//! Gear between two encoders, as it was measured.

/// Measured gear, each value with its error bar; `None` for a value that was not identified.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct MeasuredGear {
    /// Stiffness, N m/rad.
    pub stiffness: Option<[f64; 2]>,
    /// Slack, deg.
    pub slack_deg: Option<[f64; 2]>,
}
