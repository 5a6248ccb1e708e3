//! What no closed form gives: the exact solver against a second method, at a tolerance at least ten
//! times tighter.
//!
//! The second method knows nothing of the first one's files. Blocks on springs are linear while no
//! mode is switched: each scan of 10 us follows the Taylor series of order 30, whose remainder is
//! rounding; switches are found by bisection on that series; who sticks comes from force balances
//! written out by hand. Blocks under waves follow parabolas and cubics.

use dynamics::mechanism::Mechanism;
use dynamics::solver::EventKind::{self, Break, Reverse, Stick};
use friction_lab::mechanism::Shape;
use friction_lab::solver::banded::{BandCoupling, Banded};
use friction_lab::solver::fixed_step;

use super::common::{
    ARM, ARM_LEVELS, BLOCK_LEVELS, COUPLED, COUPLED_LEVELS, DEG, INDEPENDENT_LEVELS, assert_events,
    block, exact, independent,
};

/// Under the square wave all motion is at constant acceleration: 1 s of (1 - 0.6) m/s^2, then 0.6
/// m/s^2 to the halt.
#[test]
fn the_square_wave_moves_the_block_along_parabolas() {
    let (events, finish) = exact(&block(Shape::Square), &BLOCK_LEVELS, 1e-10, 8.0);
    let slips_s = 1.0 + 0.4 / 0.6;
    let expected: Vec<(f64, usize, EventKind)> = [0.0, 2.0, 4.0, 6.0]
        .into_iter()
        .flat_map(|begin_s| [(begin_s, 1, Break), (begin_s + slips_s, 1, Stick)])
        .collect();
    assert_events(&events, &expected, 1e-10);
    // There and back again.
    assert!(finish.q[0].abs() < 1e-12 && finish.v[0] == 0.0);
    let (_, there) = exact(&block(Shape::Square), &BLOCK_LEVELS, 1e-10, 2.0);
    assert!((there.q[0] - (0.5 * 0.4 + 0.5 * 0.4 * 0.4 / 0.6)).abs() < 1e-12);
}

/// Under the triangle wave the block breaks away at 0.8 N; with s the time since, V = 0.2 s + s^2/2
/// up to the peak of the wave at s = 0.2, then V = 0.06 + 0.4 u - u^2/2 with u since the peak, zero
/// at u = 0.4 + sqrt(0.28).
#[test]
fn the_triangle_wave_moves_the_block_along_cubics() {
    let (events, finish) = exact(&block(Shape::Triangle), &BLOCK_LEVELS, 1e-10, 8.0);
    let halt_s = 1.0 + 0.4 + 0.28_f64.sqrt();
    let expected: Vec<(f64, usize, EventKind)> = (0..4)
        .map(f64::from)
        .flat_map(|half| [(2.0 * half + 0.8, 1, Break), (2.0 * half + halt_s, 1, Stick)])
        .collect();
    assert_events(&events, &expected, 1e-10);
    assert!(finish.q[0].abs() < 1e-12 && finish.v[0] == 0.0);
    let u = 0.4 + 0.28_f64.sqrt();
    let height = 0.1 * 0.04 + 0.008 / 6.0 + 0.06 * u + 0.2 * u * u - u.powi(3) / 6.0;
    let (_, there) = exact(&block(Shape::Triangle), &BLOCK_LEVELS, 1e-10, 2.5);
    assert!((there.q[0] - height).abs() < 1e-12, "{there:?}");
}

/// x1, x2, V1, V2 of two blocks on two springs.
type Blocks = [f64; 4];

/// Two blocks on springs, of which some slide and some stick.
struct TwoBlocks {
    mass: [f64; 2],
    stiffness: [f64; 2],
    stick: [f64; 2],
    slip: [f64; 2],
    /// Friction 1 between the blocks, or on the floor.
    between: bool,
    /// Where the far end is: x_in = pull * t until `until_s`, or pull sin(omega t).
    pull: f64,
    until_s: f64,
    omega: f64,
}

impl TwoBlocks {
    fn x_in(&self, t: f64) -> f64 {
        if self.omega > 0.0 {
            self.pull * (self.omega * t).sin()
        } else {
            self.pull * t.min(self.until_s)
        }
    }

    /// Accelerations of both blocks from Newton's law with given frictions on coordinates.
    fn forces(&self, t: f64, s: &Blocks) -> [f64; 2] {
        let spring = self.stiffness[1] * (s[0] - s[1]);
        [self.stiffness[0] * (self.x_in(t) - s[0]) - spring, spring]
    }

    /// Friction velocities: what each friction sees.
    fn sliding(&self, s: &Blocks) -> [f64; 2] {
        if self.between { [s[2] - s[3], s[3]] } else { [s[2], s[3]] }
    }

    /// Accelerations of the blocks, and both frictions, in a mode (0 stuck, +-1).
    fn newton(&self, t: f64, s: &Blocks, mode: [i32; 2]) -> ([f64; 2], [f64; 2]) {
        let (f, [m1, m2]) = (self.forces(t, s), self.mass);
        let dynamic = |i: usize| f64::from(mode[i]) * self.slip[i];
        if !self.between {
            let one = |i: usize, m: f64| {
                if mode[i] == 0 { (0.0, f[i]) } else { ((f[i] - dynamic(i)) / m, dynamic(i)) }
            };
            let ((a1, r1), (a2, r2)) = (one(0, m1), one(1, m2));
            return ([a1, a2], [r1, r2]);
        }
        match (mode[0] == 0, mode[1] == 0) {
            (true, true) => ([0.0, 0.0], [f[0], f[0] + f[1]]),
            // Both blocks move as one.
            (true, false) => {
                let a = (f[0] + f[1] - dynamic(1)) / (m1 + m2);
                ([a, a], [f[0] - m1 * a, dynamic(1)])
            }
            (false, true) => ([(f[0] - dynamic(0)) / m1, 0.0], [dynamic(0), f[1] + dynamic(0)]),
            (false, false) => (
                [(f[0] - dynamic(0)) / m1, (f[1] + dynamic(0) - dynamic(1)) / m2],
                [dynamic(0), dynamic(1)],
            ),
        }
    }

    /// The state after `tau`, by a Taylor series of order 30: the motion is linear, so every
    /// derivative follows from the two before it. `tau` is short against the periods, so that the
    /// series ends in rounding.
    fn after(&self, t: f64, s: &Blocks, mode: [i32; 2], tau: f64) -> Blocks {
        // Derivatives of the far end.
        let drive = |n: usize| {
            if self.omega > 0.0 {
                let phase = self.omega * t + std::f64::consts::FRAC_PI_2 * n as f64;
                self.pull * self.omega.powi(n as i32) * phase.sin()
            } else {
                match n {
                    0 => self.x_in(t),
                    1 if t < self.until_s => self.pull,
                    _ => 0.0,
                }
            }
        };
        let mut d = vec![[s[0], s[1]], [s[2], s[3]]];
        for n in 0..30 {
            // The second derivative is Newton's law; higher ones are linear in the same way,
            // without constants.
            let spring = self.stiffness[1] * (d[n][0] - d[n][1]);
            let f = [self.stiffness[0] * (drive(n) - d[n][0]) - spring, spring];
            let constant = |i: usize| if n == 0 { f64::from(mode[i]) * self.slip[i] } else { 0.0 };
            let [m1, m2] = self.mass;
            let a = match (self.between, mode[0] == 0, mode[1] == 0) {
                (false, one, two) => [
                    if one { 0.0 } else { (f[0] - constant(0)) / m1 },
                    if two { 0.0 } else { (f[1] - constant(1)) / m2 },
                ],
                (true, true, true) => [0.0, 0.0],
                (true, true, false) => [(f[0] + f[1] - constant(1)) / (m1 + m2); 2],
                (true, false, true) => [(f[0] - constant(0)) / m1, 0.0],
                (true, false, false) => {
                    [(f[0] - constant(0)) / m1, (f[1] + constant(0) - constant(1)) / m2]
                }
            };
            d.push(a);
        }
        let sum = |i: usize, first: usize| {
            let (mut total, mut power) = (0.0, 1.0);
            for (n, derivative) in d[first..].iter().enumerate() {
                total += derivative[i] * power;
                power *= tau / (n + 1) as f64;
            }
            total
        };
        [sum(0, 0), sum(1, 0), sum(0, 1), sum(1, 1)]
    }

    /// What must stay above zero in a mode.
    fn margins(&self, t: f64, s: &Blocks, mode: [i32; 2]) -> [f64; 2] {
        let ((_, r), v) = (self.newton(t, s, mode), self.sliding(s));
        std::array::from_fn(|i| {
            if mode[i] == 0 { self.stick[i] - r[i].abs() } else { f64::from(mode[i]) * v[i] }
        })
    }

    /// The mode at an instant; `still` says which frictions are at zero velocity, `broken` which
    /// may not stick.
    fn mode(&self, t: f64, s: &Blocks, still: [bool; 2], broken: [bool; 2]) -> [i32; 2] {
        let v = self.sliding(s);
        let choices = |i: usize| match still[i] {
            true if broken[i] => vec![1, -1],
            true => vec![0, 1, -1],
            false => vec![if v[i] > 0.0 { 1 } else { -1 }],
        };
        let mut consistent = Vec::new();
        for one in choices(0) {
            for two in choices(1) {
                let (a, r) = self.newton(t, s, [one, two]);
                let ahead = if self.between { [a[0] - a[1], a[1]] } else { a };
                let fits = |i: usize, mode: i32| match mode {
                    0 => r[i].abs() <= self.stick[i],
                    sign => !still[i] || f64::from(sign) * ahead[i] > 0.0,
                };
                if fits(0, one) && fits(1, two) {
                    consistent.push([one, two]);
                }
            }
        }
        // With F_s > F_d there may be several: a body at rest stays there if it can.
        let stuck = |mode: &[i32; 2]| mode.iter().filter(|sign| **sign == 0).count();
        let most = consistent.iter().map(stuck).max().unwrap();
        consistent.retain(|mode| stuck(mode) == most);
        assert_eq!(consistent.len(), 1, "at {t}: {consistent:?}");
        consistent[0]
    }

    fn run(&self, duration_s: f64) -> (Vec<(f64, usize, EventKind)>, Blocks) {
        const SCAN: f64 = 1e-5;
        let (mut t, mut s, mut events) = (0.0, [0.0; 4], Vec::new());
        let mut mode = self.mode(t, &s, [true; 2], [false; 2]);
        let record = |events: &mut Vec<_>, t: f64, before: [i32; 2], after: [i32; 2]| {
            for i in 0..2 {
                match (before[i], after[i]) {
                    (b, a) if a == b => {}
                    (0, _) => events.push((t, i + 1, Break)),
                    (_, 0) => events.push((t, i + 1, Stick)),
                    _ => events.push((t, i + 1, Reverse)),
                }
            }
        };
        record(&mut events, t, [0; 2], mode);
        while t < duration_s {
            let corner = if t < self.until_s { self.until_s.min(duration_s) } else { duration_s };
            let h = SCAN.min(corner - t);
            let next = self.after(t, &s, mode, h);
            let Some(i) = (0..2).find(|i| self.margins(t + h, &next, mode)[*i] < 0.0) else {
                (t, s) = (if h < SCAN { corner } else { t + h }, next);
                continue;
            };
            let (mut low, mut high) = (0.0, h);
            for _ in 0..60 {
                let middle = 0.5 * (low + high);
                let there = self.after(t, &s, mode, middle);
                if self.margins(t + middle, &there, mode)[i] > 0.0 {
                    low = middle
                } else {
                    high = middle
                }
            }
            s = self.after(t, &s, mode, high);
            t += high;
            let mut still = [mode[0] == 0, mode[1] == 0];
            let mut broken = [false; 2];
            broken[i] = still[i];
            still[i] = true;
            // Exactly at rest.
            match (self.between, still) {
                (true, [one, true]) => {
                    s[3] = 0.0;
                    if one {
                        s[2] = 0.0;
                    }
                }
                (true, [true, false]) => s[2] = s[3],
                (false, [one, two]) => {
                    if one {
                        s[2] = 0.0;
                    }
                    if two {
                        s[3] = 0.0;
                    }
                }
                _ => {}
            }
            let before = mode;
            mode = self.mode(t, &s, still, broken);
            record(&mut events, t, before, mode);
        }
        (events, s)
    }
}

fn coupled() -> TwoBlocks {
    TwoBlocks {
        mass: [0.1, 0.1],
        stiffness: [100.0, 200.0],
        stick: COUPLED_LEVELS.map(|f| f.stick),
        slip: COUPLED_LEVELS.map(|f| f.slip),
        between: true,
        pull: 0.2,
        until_s: 0.25,
        omega: 0.0,
    }
}

fn on_the_floor() -> TwoBlocks {
    TwoBlocks {
        mass: [0.1, 0.1],
        stiffness: [100.0, 100.0],
        stick: INDEPENDENT_LEVELS.map(|f| f.stick),
        slip: INDEPENDENT_LEVELS.map(|f| f.slip),
        between: false,
        pull: 0.05,
        until_s: f64::INFINITY,
        omega: 4.0 * std::f64::consts::PI,
    }
}

#[test]
fn coupled_blocks_do_what_their_taylor_series_do() {
    let (expected, end) = coupled().run(0.5);
    let (events, finish) = exact(&COUPLED, &COUPLED_LEVELS, 1e-9, 0.5);
    assert!(expected.len() >= 10, "{expected:?}");
    assert_events(&events, &expected, 1e-8);
    let (x, v) = (COUPLED.bodies(&finish.q), COUPLED.bodies(&finish.v));
    for (found, expected) in [x[0], x[1], v[0], v[1]].iter().zip(end) {
        assert!(
            (found - expected).abs() < 1e-7 * expected.abs().max(1e-3),
            "{finish:?}, not \
            {end:?}"
        );
    }
}

#[test]
fn independent_blocks_do_what_their_taylor_series_do() {
    let (expected, end) = on_the_floor().run(0.7);
    let (events, finish) = exact(&independent(), &INDEPENDENT_LEVELS, 1e-9, 0.7);
    assert!(expected.len() >= 10, "{expected:?}");
    assert_events(&events, &expected, 1e-8);
    for (found, expected) in finish.q.iter().chain(&finish.v).zip(end) {
        assert!(
            (found - expected).abs() < 1e-7 * expected.abs().max(1e-3),
            "{finish:?}, not \
            {end:?}"
        );
    }
}

/// Banded Karnopp with the coupling neglected, and with accelerations of the step before: the final
/// angles of the arm, against the exact ones and an independent simulation. `thesis` judges the
/// claim of 2.2.2.2 on it.
#[test]
fn accelerations_of_the_step_before_are_not_more_accurate_than_none() {
    let right = [0.00449854385477193, 0.0252895664467873];
    let run = |coupling| {
        let mut banded = Banded::new(&ARM, ARM_LEVELS, [5.7e-4 * DEG; 2], coupling);
        fixed_step::run(&mut banded, 1e-5, 5.0, &mut Vec::new()).unwrap().q
    };
    let (neglected, previous) = (run(BandCoupling::Neglected), run(BandCoupling::PreviousStep));
    for i in 0..2 {
        let error = |q: [f64; 2]| (q[i] / right[i] - 1.0).abs();
        assert!(error(neglected) < 0.01, "{neglected:?}");
        assert!(error(previous) > 5.0 * error(neglected), "{previous:?}");
        // An independent simulation.
        assert!((previous[i] / [0.00412, 0.02733][i] - 1.0).abs() < 0.015, "{previous:?}");
    }
}
