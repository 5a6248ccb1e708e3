//! The limit of the controller's output.

/// `v` limited to `[-limit, limit]`, and whether it had to be. `v` must not be NaN.
#[cfg_attr(not(target_os = "none"), inline)]
pub(crate) fn saturate(v: f32, limit: f32) -> (f32, bool) {
    if v > limit {
        (limit, true)
    } else if v < -limit {
        (-limit, true)
    } else {
        (v, false)
    }
}
