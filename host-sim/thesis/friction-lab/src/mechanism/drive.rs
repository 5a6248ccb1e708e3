//! What drives blocks: the far end of a spring that moves, and waves of force.

/// How the far end of a spring moves: `x_in`, the integral of the thesis's input velocity V_o.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Pull {
    /// At constant speed until an instant (which may be infinite), then not at all.
    Ramp {
        /// V_o, m/s.
        speed: f64,
        /// When it stops, s.
        until_s: f64,
    },
    /// `V_o = speed cos(omega t)`.
    Cosine {
        /// Largest speed, m/s.
        speed: f64,
        /// omega, rad/s.
        frequency: f64,
    },
}

impl Pull {
    /// At constant speed for ever.
    pub const fn steady(speed: f64) -> Self {
        Self::Ramp { speed, until_s: f64::INFINITY }
    }

    /// x_in, m.
    #[inline]
    pub fn position(&self, t: f64) -> f64 {
        match *self {
            Self::Ramp { speed, until_s } => speed * t.min(until_s),
            Self::Cosine { speed, frequency } => speed / frequency * (frequency * t).sin(),
        }
    }

    /// The first bend after `t`.
    pub fn next_corner(&self, t: f64) -> f64 {
        match *self {
            Self::Ramp { until_s, .. } if t < until_s => until_s,
            _ => f64::INFINITY,
        }
    }
}

/// Shape of a periodic force; the thesis's timing is in its prose (section 2.3.1).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Shape {
    /// +1, 0, -1, 0, each for a quarter of the period.
    Square,
    /// From 0 to +1 in the first quarter, to -1 in the next two, to 0 in the last.
    Triangle,
}

/// A periodic force.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Wave {
    /// Its shape.
    pub shape: Shape,
    /// Largest force, N.
    pub amplitude: f64,
    /// Period, s.
    pub period_s: f64,
}

impl Wave {
    /// The force, N; at a jump the one after it.
    #[inline]
    pub fn force(&self, t: f64) -> f64 {
        let quarter = self.quarter(t);
        match self.shape {
            Shape::Square => self.amplitude * [1.0, 0.0, -1.0, 0.0][quarter as usize % 4],
            Shape::Triangle => {
                let part = 4.0 * t / self.period_s - quarter as f64;
                self.amplitude * [part, 1.0 - part, -part, part - 1.0][quarter as usize % 4]
            }
        }
    }

    /// Returns the first jump or bend after `t`, s; infinity if the resolution of the time is
    /// coarser than a quarter of the wave.
    pub fn next_corner(&self, t: f64) -> f64 {
        let corner = self.begin_of(self.quarter(t).saturating_add(1));
        if corner > t { corner } else { f64::INFINITY }
    }

    /// The quarter that `t` is in, counted from zero. Compared with the very instants that are
    /// named as corners, so that rounding cannot put a corner into the quarter before it.
    fn quarter(&self, t: f64) -> u64 {
        let near = (4.0 * t / self.period_s) as u64;
        if t < self.begin_of(near) {
            near.saturating_sub(1)
        } else if t >= self.begin_of(near.saturating_add(1)) {
            near.saturating_add(1)
        } else {
            near
        }
    }

    fn begin_of(&self, quarter: u64) -> f64 {
        quarter as f64 * self.period_s / 4.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn waves_are_those_of_the_thesis_s_prose_and_their_corners_belong_to_what_follows() {
        for period_s in [4.0, 0.7] {
            let at =
                |shape, part: f64| Wave { shape, amplitude: 2.0, period_s }.force(part * period_s);
            for (part, square, triangle) in [
                (0.0, 2.0, 0.0),
                (0.2, 2.0, 1.6),
                (0.3, 0.0, 1.6),
                (0.6, -2.0, -0.8),
                (0.9, 0.0, -0.8),
                (1.1, 2.0, 0.8),
            ] {
                assert_eq!(at(Shape::Square, part), square);
                assert!((at(Shape::Triangle, part) - triangle).abs() < 1e-12);
            }
            let wave = Wave { shape: Shape::Square, amplitude: 1.0, period_s };
            let mut t = 0.0;
            for quarter in 1..200_usize {
                let corner = wave.next_corner(t);
                assert_eq!(wave.force(corner), [1.0, 0.0, -1.0, 0.0][quarter % 4]);
                assert_eq!(
                    wave.force(corner.next_down()),
                    [1.0, 0.0, -1.0, 0.0][(quarter + 3) % 4]
                );
                t = corner;
            }
        }
    }

    /// A solver asks for corners until there are none: each is later than the one before, wherever
    /// it stands.
    #[test]
    fn corners_go_on_or_end_but_never_stand_still() {
        for period_s in [f64::MIN_POSITIVE, 1e-300, 1e-9, 4.0, 1e300, f64::MAX] {
            for t in [0.0, f64::MIN_POSITIVE, 1e-9, 1.0, 2.0_f64.powi(53), 1e19, 1e300, f64::MAX] {
                for shape in [Shape::Square, Shape::Triangle] {
                    let wave = Wave { shape, amplitude: 1.0, period_s };
                    let corner = wave.next_corner(t);
                    assert!(corner > t, "{period_s:e} s, {t:e} s: {corner:e} s");
                    assert!(!wave.force(t).is_nan(), "{period_s:e} s, {t:e} s");
                }
            }
        }
    }
}
