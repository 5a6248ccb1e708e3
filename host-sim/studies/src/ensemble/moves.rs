//! Random moves in a row. The controller keeps its state, so a law whose state degrades misses more
//! of the last tenth.
//!
//! A coin decides whether a move is an [`Approach`](super::Approach) to a target or a trapezoid.
//! Its distance is random. A trapezoid has the speed of the case's own; a short one lasts four half
//! blends. A move is missed if the joint is not within 2 counts 2.5 s after its set point came to
//! rest (thesis-axis: 4 s).

use stiction::control::reference::{Corner, Reference, Trajectory};

use super::distribution::{Draws, Purpose};
use super::drawn_case::Case;
use super::family::Family;
use super::measures::BAND_COUNTS;
use super::motions::Motions;
use super::rig::Rig;
use files::error::Error;
use simulator::experiment::position;
use simulator::rules::ControllerGains;

/// Farthest position of a row, in multiples of the distance of the case's trapezoid.
const FARTHEST: f64 = 2.0;

/// Range of the distance of a move, in multiples of that of the case's trapezoid.
const WAY: [f64; 2] = [2e-3, 1.0];

/// Result of a row of moves. Pairs are of the first tenth and of the last.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Wear {
    /// Number of moves in a tenth.
    pub judged: u32,
    /// Number of missed moves in the first and in the last tenth.
    pub missed: [u32; 2],
    /// Number of missed moves in the whole row.
    pub missed_of_all: u32,
    /// Root mean square of the error while the set point of a trapezoid moved, counts.
    pub rms_counts: [Option<f64>; 2],
    /// Fault that ended the row; every move after it is missed.
    pub fault: Option<String>,
    /// Number of the move in which a fault occurred, from 1; none without a fault.
    pub fault_in: Option<u32>,
}

/// One move, in counts from where the servo was armed.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Move {
    from: f64,
    to: f64,
    is_step: bool,
}

/// Runs the moves of a case.
///
/// # Errors
/// If the core refuses gains or a trajectory.
pub fn run(case: &Case, gains: &ControllerGains, motions: Motions) -> Result<Wear, Error> {
    let Motions { approach, seed, moves } = motions;
    let judged = (moves / 10).max(1);
    let rest_s = if case.family == Family::ThesisAxis { 4.0 } else { 2.5 };
    let rest = (rest_s / case.bounds.sampled.sample_time).round() as u32;
    let draws = &mut Draws::new(seed, case.family.number(), Purpose::Moves, case.number);
    let mut rig = Rig::armed(case, gains)?;
    let mut wear = Wear { judged, ..Wear::default() };
    let mut squares = [(0.0, 0u32); 2];
    let mut from = 0.0;
    for number in 0..moves {
        let next = draw(draws, case, from);
        from = next.to;
        let (follows, motion) = if next.is_step {
            let ticks = approach.ticks(next.to - next.from, &case.bounds)?;
            (rig.go_to(approach, next.to)?, ticks)
        } else {
            let (reference, ticks) = trapezoid(case, &next)?;
            (rig.follow(reference), ticks)
        };
        let tenths = [number < judged, number >= moves - judged];
        let mut error = f64::INFINITY;
        for k in 0..motion + rest {
            if rig.fault().is_some() {
                break;
            }
            error = rig.step().error;
            for (square, is_judged) in squares.iter_mut().zip(tenths) {
                if is_judged && !next.is_step && k < motion {
                    *square = (square.0 + error * error, square.1 + 1);
                }
            }
        }
        if rig.fault().is_some() {
            wear.fault_in.get_or_insert(number + 1);
        }
        // An error that is NaN is a miss.
        let hit = follows && rig.fault().is_none() && error.abs() <= BAND_COUNTS;
        wear.missed_of_all += u32::from(!hit);
        for (missed, is_judged) in wear.missed.iter_mut().zip(tenths) {
            *missed += u32::from(is_judged && !hit);
        }
    }
    wear.fault = rig.failure();
    wear.rms_counts = squares.map(|(sum, n)| (n > 0).then(|| (sum / f64::from(n)).sqrt()));
    Ok(wear)
}

fn draw(draws: &mut Draws, case: &Case, from: f64) -> Move {
    let is_step = draws.coin();
    let unit = case.trapezoid.distance.abs() / case.count();
    let way = draws.sign() * draws.log_uniform(WAY[0], WAY[1]) * unit;
    let to = if (from + way).abs() > FARTHEST * unit { from - way } else { from + way };
    Move { from, to, is_step }
}

/// Returns the trapezoid of a move, and the ticks in which its set point moves.
fn trapezoid(case: &Case, next: &Move) -> Result<(Reference, u32), Error> {
    let h = case.bounds.sampled.sample_time;
    let half_blend_s = case.trapezoid.half_blend_s;
    let way_s = (next.to - next.from).abs() * case.count() / case.trapezoid.speed;
    // Blends must not overlap, even after their ends were rounded to ticks.
    let last_s = half_blend_s + way_s.max(2.0 * half_blend_s + 2.0 * h);
    let corner = |time_s: f64, counts: f64| Corner {
        tick: (time_s / h).ceil() as u32,
        position: position(counts),
    };
    let corners = [corner(half_blend_s, next.from), corner(last_s, next.to)];
    let trajectory =
        Trajectory::new(&corners, half_blend_s as f32, h as f32, case.bounds.sampled.count as f32);
    let trajectory = trajectory.map_err(|error| {
        Error::Input(format!("--rate {}: a move does not fit it: {error:?}", 1.0 / h))
    })?;
    let ticks = ((last_s + half_blend_s) / h).ceil() as u32 + 1;
    Ok((Reference::Trajectory(trajectory), ticks))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ensemble::drawn_case::DrawOptions;

    #[test]
    fn moves_are_of_both_kinds_follow_each_other_and_stay_in_range() {
        let case = Case::draw(1, Family::Rigid, 0, DrawOptions::ORDINARY);
        let draws = &mut Draws::new(1, 1, Purpose::Moves, 0);
        let (mut from, mut steps) = (0.0, 0);
        for _ in 0..2000 {
            let next = draw(draws, &case, from);
            let way = (next.to - from).abs() * case.count();
            assert_eq!(next.from, from);
            assert!((1e-3 * 0.999..=0.5).contains(&way), "{way}");
            assert!((next.to * case.count()).abs() <= 1.0);
            (from, steps) = (next.to, steps + u32::from(next.is_step));
        }
        // Five standard deviations of a coin.
        assert!((888..=1112).contains(&steps), "{steps}");
    }
}
