//! The pulse planner: the shortest pulse that moves a joint with friction by a distance.
//!
//! A joint at rest gets `A` for the time `T`, slides, and is stopped by its friction `f`. It moves
//! by `x = A (A - f) T^2 / (2 J f)`: the work of the pulse is that of the friction. So the effort
//! `A` for a given time, and the shortest time that the limit `u_m` allows, are
//!
//! ```text
//! N = ceil(sqrt(2 J f x / (u_m (u_m - f))) / h - 1e-4),  1 to 40,    T = N h
//! A = (f + sqrt(f^2 + 8 J f x / T^2)) / 2,                   A = min(max(A, A_i), u_m)
//! ```
//!
//! with `f = min(R_i, 0.7 u_m)` and `x = k_i |e|`. After the joint has come to rest, the distance
//! `m` that it moved, and the farthest one on its way, update the direction's gain `k_i` and its
//! least effort `A_i`:
//!
//! ```text
//! m < 0.5 |e_b|:  k_i = min(1.25 k_i, 10)            too short
//! m > 1.2 |e_b|:  k_i = max(c k_i, 0.01)             too far: c = 0.8, and 0.6 beyond 2 |e_b|
//! peak < q / 2:   A_i = min(1.2 A_i, u_m)            it did not move at all
//! otherwise, too far:  A_i = max(c A_i, A_0)
//! ```
//!
//! The first least effort `A_0` moves the loosest joint of half the inertia by one count in one
//! tick: `A_0 = (F_lo + sqrt(F_lo^2 + 4 J F_lo q / h^2)) / 2`, at least `1.05 F_lo`, then at most
//! `0.9 F_hi`.
//!
//! Why this form: impulsive control (S. Yang and M. Tomizuka, *Adaptive pulse width control for
//! precise positioning under the influence of stiction and Coulomb friction*, ASME J. Dynamic
//! Systems, Measurement and Control 110 (1988), 221; B. Armstrong-Hélouvry, *Control of Machines
//! with Friction*, 1991) does not need the friction to be known well: a pulse that was too short
//! leaves the joint at rest, nearer. The shortest pulse is the one that the stiffness of the
//! transmission changes least.
//!
//! Guarantees: `N` and `A` are bounded, whatever was learned. Without friction in the plan's way
//! the distance is that of the closed form. Does badly: a spring moves the joint back (then
//! [`hold_effort`](super::hold_effort) takes over), and below the smallest move of a tick,
//! `(F_s/F_c)(F_s - F_c) h^2 / (2 J)`, no pulse lands.

/// The longest pulse, ticks.
const LONGEST: u8 = 40;

/// The planner, prepared for a joint and a sample time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PulsePlanner {
    sample_time: f32,
    per_sample_time: f32,
    /// 2 J, V s^2/deg.
    twice_inertia: f32,
    /// Half a count, deg.
    half_count: f32,
    /// The largest effort u_m, V.
    pub limit: f32,
    /// The first least effort A_0, V.
    pub least: f32,
}

/// Values learned from the pulses in one direction.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PulseMemory {
    /// Factor k_i between the error and the planned travel x of a pulse: x = k_i |e|.
    pub gain: f32,
    /// Least effort A_i, V.
    pub least: f32,
}

/// A pulse: its effort and how long it lasts.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Pulse {
    /// Effort A, V, positive.
    pub effort: f32,
    /// Length N, ticks.
    pub ticks: u8,
}

impl PulsePlanner {
    /// Prepares the planner for ticks of `sample_time` (s), an inertia (V s^2/deg), a range of
    /// breakaway efforts (V), the largest effort (V) and the angle of a count (deg).
    pub fn new(
        sample_time: f32,
        inertia: f32,
        [low, high]: [f32; 2],
        limit: f32,
        count: f32,
    ) -> Self {
        let twice_inertia = 2.0 * inertia;
        let per_sample_time = 1.0 / sample_time;
        let one_count =
            effort(low, inertia * low * count, per_sample_time * per_sample_time).max(1.05 * low);
        let least = one_count.min(0.9 * high);
        let half_count = 0.5 * count;
        Self { sample_time, per_sample_time, twice_inertia, half_count, limit, least }
    }

    /// Plans the pulse that moves a joint with a friction (V) by a distance (deg), with an effort
    /// of at least `least` (V).
    #[inline]
    pub fn plan(&self, friction: f32, distance: f32, least: f32) -> Pulse {
        let limit = self.limit;
        let most = 0.7 * limit;
        let friction = if friction < most { friction } else { most };
        let work = self.twice_inertia * friction * distance;
        let time = libm::sqrtf(work / (limit * (limit - friction)));
        let ticks = whole_ticks(time * self.per_sample_time - 1e-4);
        let time = f32::from(ticks) * self.sample_time;
        let needed = effort(friction, work, 1.0 / (time * time));
        let wanted = if needed > least { needed } else { least };
        Pulse { effort: if wanted < limit { wanted } else { limit }, ticks }
    }

    /// Learns from a pulse for an error of `wanted` (deg, positive): the joint went as far as
    /// `peak` towards the target, and rests at `moved` (deg).
    pub fn learn(&self, learned: &mut PulseMemory, wanted: f32, moved: f32, peak: f32) {
        let much = if moved > 2.0 * wanted { 0.6 } else { 0.8 };
        let too_far = moved > 1.2 * wanted;
        if moved < 0.5 * wanted {
            learned.gain = (1.25 * learned.gain).min(10.0);
        } else if too_far {
            learned.gain = (much * learned.gain).max(0.01);
        }
        if peak < self.half_count {
            learned.least = (1.2 * learned.least).min(self.limit);
        } else if too_far {
            learned.least = (much * learned.least).max(self.least);
        }
    }
}

/// Returns the effort that does a work `2 J f x` against a friction in a time, given as 1/T^2.
fn effort(friction: f32, work: f32, per_square: f32) -> f32 {
    0.5 * (friction + libm::sqrtf(friction * friction + 4.0 * work * per_square))
}

/// Returns the least whole number that is not below `ticks`, from 1 to [`LONGEST`].
fn whole_ticks(ticks: f32) -> u8 {
    let whole = ticks as u8;
    let up = whole.saturating_add(u8::from(ticks > f32::from(whole)));
    up.clamp(1, LONGEST)
}

#[cfg(test)]
mod tests {
    use super::*;

    const H: f32 = 0.001;
    const INERTIA: f32 = 2e-5;

    fn planner() -> PulsePlanner {
        PulsePlanner::new(H, INERTIA, [2.0, 12.0], 60.0, 1.0)
    }

    /// The distance by the energy: the pulse's end speed is (A - f) T / J, and the friction takes
    /// the same momentum afterwards.
    fn distance(Pulse { effort, ticks }: Pulse, friction: f64) -> f64 {
        let (a, t, j) = (f64::from(effort), f64::from(ticks) * f64::from(H), f64::from(INERTIA));
        let speed = (a - friction) * t / j;
        speed * t / 2.0 + speed * speed * j / (2.0 * friction)
    }

    #[test]
    fn a_pulse_moves_a_rigid_joint_as_far_as_is_wanted() {
        for wanted in [0.3f32, 1.0, 30.0, 1000.0, 20_000.0] {
            let pulse = planner().plan(5.0, wanted, 0.0);
            let found = distance(pulse, 5.0);
            assert!((found / f64::from(wanted) - 1.0).abs() < 1e-3, "{pulse:?}: {found}");
            assert!(pulse.effort <= 60.0);
        }
    }

    #[test]
    fn a_pulse_is_as_short_as_the_limit_allows_and_no_longer_than_forty_ticks() {
        // One tick of 60 V moves it by 60 * 55 * 1e-6 / (2 * 2e-5 * 5) counts.
        let one_tick = 60.0 * 55.0 * 1e-6 / (2.0 * 2e-5 * 5.0);
        for (share, ticks) in [(0.99f32, 1), (1.01, 2), (3.99, 2), (4.01, 3), (1e6, 40)] {
            assert_eq!(planner().plan(5.0, share * one_tick, 0.0).ticks, ticks, "{share}");
        }
        assert_eq!(planner().plan(5.0, 1e9, 0.0).effort, 60.0);
        // A learned friction can exceed the limit; the plan does not.
        assert!(planner().plan(1e6, 10.0, 0.0).effort.is_finite());
    }

    #[test]
    fn least_effort_moves_half_the_inertia_by_a_count_in_a_tick() {
        let least = planner().least;
        let pulse = Pulse { effort: least, ticks: 1 };
        // Half the inertia goes twice as far.
        assert!((2.0 * distance(pulse, 2.0) - 1.0).abs() < 1e-4);
        let heavy = PulsePlanner::new(H, 1.0, [2.0, 12.0], 60.0, 1.0);
        assert_eq!(heavy.least, 0.9 * 12.0);
        let light = PulsePlanner::new(0.1, INERTIA, [2.0, 12.0], 60.0, 1.0);
        assert_eq!(light.least, 1.05 * 2.0);
        // A range of one effort: first the lower bound, then the upper one.
        assert_eq!(PulsePlanner::new(0.1, INERTIA, [2.0, 2.0], 60.0, 1.0).least, 0.9 * 2.0);
        assert_eq!(planner().plan(5.0, 0.1, 20.0).effort, 20.0);
    }

    #[test]
    fn pulses_teach_by_how_far_the_joint_went() {
        let planner = planner();
        let start = PulseMemory { gain: 1.0, least: 20.0 };
        let taught = |moved: f32, peak: f32| {
            let mut learned = start;
            planner.learn(&mut learned, 10.0, moved, peak);
            [learned.gain, learned.least]
        };
        assert_eq!(taught(4.9, 5.0), [1.25, 20.0]);
        assert_eq!(taught(5.1, 5.1), [1.0, 20.0]);
        assert_eq!(taught(11.9, 12.0), [1.0, 20.0]);
        assert_eq!(taught(12.1, 13.0), [0.8, 16.0]);
        assert_eq!(taught(20.1, 21.0), [0.6, 12.0]);
        assert_eq!(taught(0.0, 0.4), [1.25, 24.0]);
    }

    #[test]
    fn what_is_learned_stays_within_its_bounds() {
        let planner = planner();
        let mut learned = PulseMemory { gain: 1.0, least: 20.0 };
        (0..50).for_each(|_| planner.learn(&mut learned, 10.0, 0.0, 0.0));
        assert_eq!(learned, PulseMemory { gain: 10.0, least: 60.0 });
        (0..50).for_each(|_| planner.learn(&mut learned, 10.0, 100.0, 100.0));
        assert_eq!(learned, PulseMemory { gain: 0.01, least: planner.least });
    }
}
