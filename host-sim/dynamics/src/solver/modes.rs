//! Decides which bodies stick and which slip, for all bodies at once.
//!
//! A body at zero velocity sticks, or slips one way or the other; one in motion slips the way it
//! moves. A choice for all bodies (a mode) is consistent if
//!
//! - each stuck body needs no more than its largest friction at rest, with the accelerations that
//!   the *others* have in this mode, and
//! - each body that starts to slip accelerates the way it slips, against its friction in motion.
//!
//! Deciding body by body gets this wrong: at the start of the thesis's two-link arm both torques
//! exceed their `T_s`, and the only consistent mode is joint 1 *stuck* with joint 2 slipping. There
//! are `3^n` modes for `n` bodies at rest, each a small linear system; they are all tried. With
//! `F_s > F_d` several may be consistent: the one with the most bodies stuck is taken, as a body at
//! rest stays there if it can.

use super::linear::solve;
use crate::friction::SetValued;
use crate::mechanism::Terms;

/// Mode of each body: 0 if it sticks, or else the sign of its slip.
pub type BodyMode<const N: usize> = [i8; N];

/// Returns the sign of a velocity; 0 for 0.
pub fn direction(v: f64) -> i8 {
    if v > 0.0 {
        1
    } else if v < 0.0 {
        -1
    } else {
        0
    }
}

/// Returns accelerations and frictions in a mode. The friction of a stuck body is the force that
/// holds it.
#[inline(always)]
pub fn accelerations<const N: usize, F: SetValued>(
    terms: &Terms<N>,
    friction: &[F; N],
    v: &[f64; N],
    mode: &BodyMode<N>,
) -> ([f64; N], [f64; N]) {
    let mut forces = [0.0; N];
    let mut net = terms.force;
    let mut held = [false; N];
    for i in 0..N {
        let sign = f64::from(mode[i]);
        held[i] = mode[i] == 0;
        if !held[i] {
            // If a body reverses within a step, its friction continues from the former direction.
            forces[i] = sign * friction[i].slip((sign * v[i]).max(0.0));
            net[i] -= forces[i];
        }
    }
    let a = solve(&terms.mass, &net, &held);
    for i in 0..N {
        if held[i] {
            forces[i] = terms.force[i] - dot(&terms.mass[i], &a);
        }
    }
    (a, forces)
}

/// Returns the consistent mode with the most bodies stuck; `None` if no mode is consistent. A body
/// whose entry in `breaking` is not zero has just reached its largest friction: it slips in either
/// direction, but does not stick.
pub fn decide<const N: usize, F: SetValued>(
    terms: &Terms<N>,
    friction: &[F; N],
    v: &[f64; N],
    breaking: &BodyMode<N>,
) -> Option<BodyMode<N>> {
    let at_rest = v.iter().filter(|v| **v == 0.0).count();
    let mut best: Option<(usize, BodyMode<N>)> = None;
    for code in 0..3_usize.pow(at_rest as u32) {
        let mode = decode(code, v);
        let stuck = mode.iter().filter(|sign| **sign == 0).count();
        let better = best.is_none_or(|(most, _)| stuck > most);
        if better && is_consistent(terms, friction, v, &mode, breaking) {
            best = Some((stuck, mode));
        }
    }
    best.map(|(_, mode)| mode)
}

/// Returns mode number `code` of the bodies at rest. A body in motion has its own direction.
fn decode<const N: usize>(mut code: usize, v: &[f64; N]) -> BodyMode<N> {
    v.map(|v| {
        if v != 0.0 {
            return direction(v);
        }
        let digit = code % 3;
        code /= 3;
        [0, 1, -1][digit]
    })
}

fn is_consistent<const N: usize, F: SetValued>(
    terms: &Terms<N>,
    friction: &[F; N],
    v: &[f64; N],
    mode: &BodyMode<N>,
    breaking: &BodyMode<N>,
) -> bool {
    let (a, forces) = accelerations(terms, friction, v, mode);
    (0..N).all(|i| {
        if mode[i] == 0 {
            return breaking[i] == 0 && forces[i].abs() <= friction[i].stick();
        }
        // At the very instant of breaking away with F_s = F_d the acceleration is zero, and grows.
        let rounding = 1e-9 * friction[i].stick() / terms.mass[i][i];
        let least = if breaking[i] == mode[i] { -rounding } else { 0.0 };
        let ahead = f64::from(mode[i]) * a[i];
        v[i] != 0.0 || ahead > least
    })
}

fn dot<const N: usize>(row: &[f64; N], x: &[f64; N]) -> f64 {
    row.iter().zip(x).map(|(a, b)| a * b).sum()
}
