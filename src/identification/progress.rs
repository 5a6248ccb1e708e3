//! The check of a leg: it detects that a joint under an effort beyond its friction travels too
//! little.
//!
//! ```text
//! v     <- (1 - h / T) v + (s u - F) h / J     and no less than zero; s: sense of the leg
//! due   += v h
//! asked += |r'| h                              r': speed of the follower's reference
//! made  += s (travel of the tick)
//! ```
//!
//! `J` is the rough inertia that the sequence has found, and `F` the effort that this sense has
//! needed so far. `T` is 0.2 s. When `due` exceeds a share of the sequence's travel, `made` has to
//! be at least a quarter of the lesser of `due` and `asked`, and the sums start anew. If `made` is
//! less, the caller ends the leg or the sequence.
//!
//! An encoder with an open line counts noise. Below `stall_v`, the servo's monitors mistake such
//! counts for a working encoder, and a leg pushes with up to twice `F`. This check requires counts
//! in the sense of the leg.
//!
//! Guarantees: an encoder whose error stays within n counts is detected when a joint with a
//! mechanical time constant of 0.2 s would have gone the judged share, if 8 n counts are less than
//! `asked`. A joint that follows the reference passes, whatever its friction.
//!
//! Does badly: a joint with a longer time constant goes farther than `due`. An end stop and a place
//! with about twice `F` are detected, too.

/// Mechanical time constant that `due` assumes for the joint, s: as in the servo's monitor.
const TIME: f32 = 0.2;
/// Part of the travel due that the joint has to make.
const SHARE: f32 = 0.25;

/// Travel that was due, requested and made since the sums started, deg.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Progress {
    /// The due speed, deg/s.
    speed: f32,
    due: f32,
    asked: f32,
    made: f32,
}

/// A tick of a leg, in the sense of the leg.
#[derive(Clone, Copy, Debug)]
pub(super) struct LegTick {
    /// The effort that was applied, less the rough friction, V.
    pub excess: f32,
    /// The rough inertia, V/(deg/s^2).
    pub inertia: f32,
    /// Speed of the reference without its sign, deg/s.
    pub speed: f32,
    /// Travel of the tick, deg.
    pub travel: f32,
    /// Length of the tick, s.
    pub tick: f32,
}

impl Progress {
    /// Adds a tick, and returns whether the joint has travelled too little. The travel is judged
    /// when more than `judged` (deg) is due.
    pub fn lacks(&mut self, leg: &LegTick, judged: f32) -> bool {
        let LegTick { excess, inertia, speed, tick, .. } = *leg;
        let left = (1.0 - tick / TIME).max(0.0);
        self.speed = (left * self.speed + excess / inertia * tick).max(0.0);
        self.due += self.speed * tick;
        self.asked += speed * tick;
        self.made += leg.travel;
        if self.due <= judged {
            return false;
        }
        let lacks = self.made < SHARE * self.due.min(self.asked);
        *self = Self { speed: self.speed, ..Self::default() };
        lacks
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A leg of 10 s at 20 deg/s with twice the friction of 0.4 V; the joint makes a share of that
    /// speed. Returns the time at which it ends, s.
    fn ended(share: f32) -> Option<f32> {
        let mut progress = Progress::default();
        let leg = LegTick {
            excess: 0.4,
            inertia: 1.0 / 27.0,
            speed: 20.0,
            travel: share * 20.0 * 0.02,
            tick: 0.02,
        };
        (1..=500).find(|_| progress.lacks(&leg, 5.0)).map(|tick| tick as f32 * 0.02)
    }

    #[test]
    fn a_joint_that_makes_less_than_a_quarter_ends_the_leg_and_one_that_makes_more_does_not() {
        // v = 27 0.4 T (1 - exp(-t / T)): 2.16 deg/s, and 5 deg of it after T + 5 / 2.16 s.
        let time = ended(0.0).unwrap();
        assert!((time - 2.515).abs() < 0.03, "{time}");
        // Of the 5 deg due a quarter is 1.25 deg: 0.0248 of the speed in that time.
        assert!(ended(0.023).is_some());
        assert_eq!(ended(0.027), None);
        assert!(ended(-1.0).is_some());
    }

    #[test]
    fn a_joint_that_follows_the_reference_passes_whatever_its_friction_is() {
        let mut progress = Progress::default();
        // Viscous friction needs three times the breakaway effort; 5 deg/s were requested.
        let leg =
            LegTick { excess: 1.2, inertia: 0.005, speed: 5.0, travel: 5.0 * 0.02, tick: 0.02 };
        assert!((0..5000).all(|_| !progress.lacks(&leg, 5.0)));
    }
}
