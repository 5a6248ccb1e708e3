//! Limiting of a number to a range.

/// Returns `v` limited to `[low, high]`, and whether it had to be limited. `v` must not be NaN.
#[inline]
pub(crate) fn saturate_between(v: f32, [low, high]: [f32; 2]) -> (f32, bool) {
    let limited = if v > high {
        high
    } else if v < low {
        low
    } else {
        v
    };
    (limited, limited != v)
}

/// Returns `v` limited to `[-limit, limit]`, as [`saturate_between`] does.
#[inline]
pub(crate) fn saturate(v: f32, limit: f32) -> (f32, bool) {
    saturate_between(v, [-limit, limit])
}

/// Returns `x` limited to `[-bound, bound]`, as [`saturate`] does.
#[inline]
pub(crate) fn bounded(x: f32, bound: f32) -> f32 {
    saturate(x, bound).0
}
