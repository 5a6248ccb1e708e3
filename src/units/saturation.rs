//! Limiting of a number to a symmetric range.

/// Returns `v` limited to `[-limit, limit]`, and whether it had to be limited. `v` must not be NaN.
#[inline]
pub(crate) fn saturate(v: f32, limit: f32) -> (f32, bool) {
    let limited = if v > limit {
        limit
    } else if v < -limit {
        -limit
    } else {
        v
    };
    (limited, limited != v)
}

/// Returns `x` limited to `[-bound, bound]`, as [`saturate`] does.
#[inline]
pub(crate) fn bounded(x: f32, bound: f32) -> f32 {
    saturate(x, bound).0
}
