//! Ratio, slack and stiffness of a gear, from a log with an encoder on either side of it.
//!
//! y, v and a are position, velocity and acceleration of the motor, l is the position of the load,
//! all in units of the joint; u is the effort:
//!
//! ```text
//! u = J a + B v + F sgn v + c + K z(y - l) + D dz/dt    z(w) = max(w - w+, 0) + min(w - w-, 0)
//! ```
//!
//! The gear is a damped spring behind a dead zone from w- to w+, whose width is the slack. Source:
//! M. Nordin and P.-O. Gutman, *Automatica* 38 (2002), 1633. The equation is that of the motor's
//! body alone, so it needs no data of the load: J, B and F are the motor's part. Without slack, c
//! is a shift of the dead zone, and is left out.
//!
//! J, B, F, c, K and D are linear. w-, w+, the ratio and the delay of the effort are searched: the
//! slope of the load over the motor and a coarse grid first, then Gauss and Newton's method, which
//! regresses u on the columns' derivatives and on du/dt as well. All columns pass one low-pass. The
//! dead zone is that of the logged positions, and its column is filtered afterwards.
//!
//! Counts bias the dead zone: their noise in z makes K too small (errors in variables), so that
//! more of the twist counts as wind-up, and less as slack. The bias is of second order in the count
//! c, as its noise power c^2/12. Twice the count is read exactly from a position in counts, in two
//! phases, so the bias is extrapolated to c = 0 (L. F. Richardson, *Phil. Trans. A* 210 (1911),
//! 307; with noise instead of a step, J. R. Cook and L. A. Stefanski, *JASA* 89 (1994), 1314):
//!
//! ```text
//! b(c) = b + q c^2      b = b(c) + (b(c) - b(2c))/3
//! ```
//!
//! The standard deviations are those of [`least_squares`](super::least_squares), which include that
//! of the delay. They are widened by the extrapolation, by half of the difference of its phases,
//! and by half of the change with a cut-off a third lower and three times the creeping speed, and
//! with samples twice as far from a slow one. The low-pass mixes the last ones with sticking.
//!
//! If the gear explains the effort, the rest of the identification treats the joint as one rigid
//! body that moves like the load. The effort for the motion of the motor's body beyond that of the
//! load, `J (a - a_l) + B (v - v_l) + F (sgn v - sgn v_l)`, is subtracted from the logged effort.
//! Without this correction, a rigid body fits a joint with a soft gear poorly.
//!
//! Limits: a counter that restarts in a gap of the log looks like a slip of the gear. Friction and
//! torque of the gear often have the same sign; then slack looks like more friction, and the error
//! bars become wide. Slow reversals, and a motor that slows down faster than the friction of its
//! load, separate both. Samples in which the motor sticks are left out.

use rayon::prelude::*;

use super::FitSettings;
use super::butterworth::LowPass;
use super::cut_off;
use super::derivative::derivatives;
use super::gate;
use super::least_squares::{Fit, MOST, RegressionRow};
use super::model::FittedParameter;
use super::moments::{self, FilteredLog};
use super::regression;
use super::time_grid::{Stretch, TimeGrid};
use super::units::LogUnits;
use files::error::rounded;
use simulator::device::measured_gear::MeasuredGear;

/// Creeping speed as a share of the fast speed. A motor is slow while it crosses the slack.
const CREEPING: f64 = gate::CREEPING_WITH_STRIBECK;

/// Ratio of a higher creeping speed, at which the values are compared, to the ordinary one.
const FASTER: f64 = 3.0;

/// Number of quantiles of the twist that are tried as ends of the dead zone.
const PLACES: usize = 13;

/// Number of dead zones from which the search starts.
const BEGINS: usize = 8;

/// Largest number of steps of the search, and of lengths that are tried for each, by halving.
const STEPS: usize = 30;
const HALVINGS: i32 = 8;

/// Least reduction of the residual's power by a step, as a share; the search ends below it.
const GAIN: f64 = 1e-9;

/// Least number of rows.
const FEWEST: usize = 60;

/// Least range of the twist, in counts of the coarser encoder.
const FEWEST_COUNTS: f64 = 4.0;

/// Largest standard deviation of a value that counts as identified, as a share of the value.
const UNSURE: f64 = 0.25;

/// Ratio of the cut-off for the correction of the effort to that of the regression, which filters
/// the corrected effort again.
const WIDER: f64 = 3.0;

/// Largest residual of a fit that is not doubted, %.
const DOUBTED_PERCENT: f64 = 10.0;

/// Ratio of the bias that twice the count adds to that of one count: 2^2 - 1.
const COARSER: f64 = 3.0;

/// Reaches of the low-pass, in periods of the cut-off, of samples that are farther from slow ones.
/// The next one is used if too few samples are left.
const FARTHER: [f64; 3] = [1.0, 0.7, 0.5];

/// Largest number of steps of the delay, and the step at which they end, samples.
const DELAY_STEPS: usize = 6;
const SMALL_DELAY: f64 = 0.003;

/// Earliest and latest delay of the effort, samples.
const DELAYS: [f64; 2] = [-2.0, 3.0];

/// Columns of the linear terms: a, v, sgn v, z and dz/dt; c is behind all others.
const LINEAR: usize = 5;
const STIFFNESS: usize = 3;
const DAMPING: usize = 4;
const MIDDLE: usize = 5;
const WIDTH: usize = 6;
const RATIO: usize = 7;
const DELAY: usize = 8;

/// A gear that was identified from a log.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub struct IdentifiedGear {
    /// Ratio: turns or counts of the motor per turn of the joint, or rad or counts per metre.
    pub ratio: FittedParameter,
    /// Stiffness, effort per unit of the joint.
    pub stiffness: FittedParameter,
    /// Damping of the gear in contact, effort per speed of the joint.
    pub damping: FittedParameter,
    /// Width of the dead zone, units of the joint.
    pub slack: FittedParameter,
    /// The motor's part of the inertia.
    pub motor_inertia: FittedParameter,
    /// The motor's part of the viscous friction.
    pub motor_viscous: FittedParameter,
    /// The motor's part of the Coulomb friction.
    pub motor_coulomb: FittedParameter,
    /// Time after which the logged effort acts, s.
    pub effort_delay_s: f64,
    /// Distance between the largest and the smallest twist, units of the joint.
    pub twist: f64,
    /// Ratio of residual to effort, both as root mean squares, %.
    pub relative_residual_percent: f64,
    /// Sentences that doubt a value.
    pub doubts: Vec<String>,
}

impl IdentifiedGear {
    const fn parameters(&self) -> [FittedParameter; 7] {
        [
            self.ratio,
            self.stiffness,
            self.damping,
            self.slack,
            self.motor_inertia,
            self.motor_viscous,
            self.motor_coulomb,
        ]
    }

    const fn parameters_mut(&mut self) -> [&mut FittedParameter; 7] {
        [
            &mut self.ratio,
            &mut self.stiffness,
            &mut self.damping,
            &mut self.slack,
            &mut self.motor_inertia,
            &mut self.motor_viscous,
            &mut self.motor_coulomb,
        ]
    }

    /// Adds half of the difference from another result to the standard deviations.
    fn widen(&mut self, other: &Self) {
        for (one, other) in self.parameters_mut().into_iter().zip(other.parameters()) {
            one.sd = one.sd.hypot(0.5 * (one.value - other.value));
        }
    }

    /// Extrapolates the values to encoders without counts. `coarse` are the results with twice the
    /// count, in both phases.
    fn extrapolate(&mut self, coarse: [&Self; 2]) {
        let coarse = coarse.map(Self::parameters);
        for (place, one) in self.parameters_mut().into_iter().enumerate() {
            let [even, odd] = [0, 1].map(|phase: usize| coarse[phase][place].value);
            let step = (one.value - 0.5 * (even + odd)) / COARSER;
            one.value += step;
            one.sd = one.sd.hypot(step).hypot(0.5 * (even - odd) / COARSER);
        }
    }

    /// Sets the correction of a log's effort to that of one rigid body that moves like the load.
    /// `cut_off_hz` is the cut-off of the regression. Returns the delay of the effort, s; `None`,
    /// without a correction, if the motor's part of the effort is uncertain.
    pub fn carry(
        &self,
        grid: &mut TimeGrid,
        scale: &LogUnits,
        counts: SideCounts,
        cut_off_hz: f64,
    ) -> Option<f64> {
        if !self.is_motor_sure() {
            return None;
        }
        let n = scale.motor_of_a_turn() / self.ratio.value;
        let hz = (WIDER * cut_off_hz).min(cut_off::highest(grid.step_s));
        let low_pass = LowPass::new(hz * grid.step_s);
        let motion = |side: &[f64]| derivatives(&low_pass.apply(side), grid.step_s);
        let turned = |one: &Stretch| one.beside.iter().map(|motor| motor * n).collect::<Vec<f64>>();
        let of_motor: Vec<_> = grid.stretches.iter().map(|one| motion(&turned(one))).collect();
        let of_load: Vec<_> = grid.stretches.iter().map(|one| motion(&one.position)).collect();
        let [slow_motor, slow_load] =
            [(&of_motor, counts.motor * n.abs()), (&of_load, counts.load)].map(|(side, count)| {
                let velocities: Vec<&[f64]> = side.iter().map(|one| &one[0][..]).collect();
                gate::creeping(&velocities, CREEPING, count, hz)
            });
        let later = self.effort_delay_s / grid.step_s;
        for (one, (motor, load)) in grid.stretches.iter_mut().zip(of_motor.iter().zip(&of_load)) {
            // Below the creeping speed a side can stick; its friction then balances the effort.
            let friction = |v: f64, slow: f64| {
                let part = if slow > 0.0 { v / slow } else { 0.0 };
                self.motor_coulomb.value * part.clamp(-1.0, 1.0)
            };
            let beyond = |i: usize| {
                let [v, a] = [0, 1].map(|order| [motor[order][i], load[order][i]]);
                self.motor_inertia.value * (a[0] - a[1])
                    + self.motor_viscous.value * (v[0] - v[1])
                    + friction(v[0], slow_motor)
                    - friction(v[1], slow_load)
            };
            let all: Vec<f64> = (0..one.beside.len()).map(|i| -beyond(i)).collect();
            one.carried = (0..all.len()).map(|i| moments::earlier(&all, i, -later)).collect();
        }
        Some(self.effort_delay_s)
    }

    /// Returns whether the fit explains the effort; a poor fit identifies nothing.
    pub fn explains_effort(&self) -> bool {
        self.relative_residual_percent <= DOUBTED_PERCENT
    }

    /// Returns whether the log identifies the motor's part of the effort.
    fn is_motor_sure(&self) -> bool {
        self.explains_effort()
            && self.motor_inertia.sd <= UNSURE * self.motor_inertia.value
            && self.motor_coulomb.value >= 0.0
    }

    /// Returns whether the log identifies the stiffness.
    pub fn is_stiffness_sure(&self) -> bool {
        self.stiffness.sd <= UNSURE * self.stiffness.value
    }

    /// Returns whether the log identifies the slack: its standard deviation is small in comparison
    /// with the slack or with the twist, and the stiffness is identified. Otherwise the slack can
    /// include the twist by which the gear is wound up.
    pub fn is_slack_sure(&self) -> bool {
        self.is_stiffness_sure()
            && self.slack.sd <= (UNSURE * self.slack.value).max(0.05 * self.twist)
    }

    /// Returns the identified values with two standard deviations, for a machine's file. `effort`
    /// is the torque of a unit of the effort, N m.
    pub fn measured(&self, effort: f64) -> MeasuredGear {
        let both = |value: &FittedParameter, factor: f64| {
            [value.value, 2.0 * value.sd].map(|one| one * factor)
        };
        MeasuredGear {
            stiffness: self.is_stiffness_sure().then(|| both(&self.stiffness, effort)),
            slack_deg: self.is_slack_sure().then(|| both(&self.slack, 1f64.to_degrees())),
        }
    }
}

/// Identifies the gear of a log whose stretches have the motor's position in `beside`.
///
/// # Errors
/// Returns a sentence with the reason why the log does not identify its gear.
pub fn identify(
    grid: &TimeGrid,
    counts: SideCounts,
    request: &FitSettings,
) -> Result<IdentifiedGear, String> {
    let stretches = of_one_zero(grid);
    let slope = slope(&stretches).ok_or("the motor's position does not change")?;
    let counts = [counts.motor * slope.abs(), counts.load];
    let stretches = of_the_motor(stretches, slope);
    let motor = TimeGrid { stretches, ..grid.clone() };
    let cut_off = cut_off::choose(&motor, counts[0], request.cut_off_hz);
    let filter = |slow: f64, part: f64, reaches: &[f64]| {
        FilteredLog::within(&motor, [slow, counts[0], cut_off.hz / part], reaches)
    };
    let filtered = filter(CREEPING, 1.0, &gate::MIXED);
    let delay_s = request.effort_delay_s.unwrap_or(0.0);
    let mut problem = Problem {
        grid: &motor,
        filtered: &filtered,
        rows: filtered.places(),
        delay_s,
        is_delay_free: request.effort_delay_s.is_none(),
    };
    if problem.rows.len() < FEWEST {
        return Err(format!(
            "the motor turns steadily in only {} samples, at least {FEWEST} are needed",
            problem.rows.len()
        ));
    }
    let twists = problem.twists();
    let coarser = counts[0].max(counts[1]);
    let range = twists.last().zip(twists.first()).map_or(0.0, |(high, low)| high - low);
    if range < FEWEST_COUNTS * coarser {
        return Err(format!(
            "both encoders agree within {} counts: the gear is stiffer than they can show",
            rounded(range / coarser)
        ));
    }
    let mut solved = problem.search(&twists)?;
    if problem.is_delay_free {
        problem.delay_s = problem.delay(&solved.zone).unwrap_or(0.0);
        solved = problem.solve(solved.zone).unwrap_or(solved);
        solved = problem.with_delay(solved);
    }
    if solved.fit.values[STIFFNESS] <= 0.0 {
        return Err(
            "the effort falls while the twist of the gear grows: one side slips, or the log \
                    hardly twists the gear"
                .into(),
        );
    }
    let per_turn = request.scale.motor_of_a_turn() / slope;
    let mut gear = solved.gear(per_turn);
    // A value that depends on the selection of samples is uncertain by that much.
    let lower = filter(FASTER * CREEPING, super::LOWER, &gate::MIXED);
    let farther = filter(CREEPING, 1.0, &FARTHER);
    for filtered in [&lower, &farther] {
        let other = Problem { filtered, rows: filtered.places(), ..problem };
        if let Ok(other) = other.solve(solved.zone) {
            gear.widen(&other.gear(per_turn));
        }
    }
    let coarse = [0.0, 1.0].map(|phase| {
        let grid = of_twice_the_count(&motor, counts, phase);
        let other = Problem { grid: &grid, rows: problem.rows.clone(), ..problem };
        other.solve(solved.zone).map(|one| one.gear(per_turn))
    });
    match &coarse {
        [Ok(even), Ok(odd)] => gear.extrapolate([even, odd]),
        // Twice the count hides the dead zone, so this one is doubtful as well.
        _ => gear.stiffness.sd = gear.stiffness.sd.max(gear.stiffness.value),
    }
    gear.effort_delay_s = problem.delay_s;
    gear.twist = range;
    gear.doubts = doubts(&gear);
    Ok(gear)
}

/// Returns doubts about the values of a gear, one sentence each.
fn doubts(gear: &IdentifiedGear) -> Vec<String> {
    let mut doubts = Vec::new();
    if gear.relative_residual_percent > DOUBTED_PERCENT {
        doubts.push(format!(
            "the gear's equation leaves {} % of the effort unexplained",
            rounded(gear.relative_residual_percent)
        ));
    }
    if !gear.is_motor_sure() {
        doubts.push(
            "the motor's part of the effort is uncertain: the joint is identified as if the \
             motor's position were not in the log"
                .into(),
        );
    }
    if !gear.is_stiffness_sure() {
        doubts.push(
            "the log winds up the gear too little for its stiffness, so the slack is uncertain, \
             too: log faster reversals, or push the load"
                .into(),
        );
    }
    if gear.is_stiffness_sure() && !gear.is_slack_sure() {
        doubts.push(
            "the log cannot separate the slack from friction: log slow reversals, one after the \
             other"
                .into(),
        );
    }
    doubts
}

/// Size of a count on both sides, each in the unit of its position; 0 if there are no counts.
#[derive(Clone, Copy, Debug)]
pub struct SideCounts {
    /// Count of the motor's position.
    pub motor: f64,
    /// Count of the load's position.
    pub load: f64,
}

/// Returns the stretches with positions relative to the first sample: all of them, or only the
/// longest one if a position jumps.
fn of_one_zero(grid: &TimeGrid) -> Vec<Stretch> {
    let mut stretches = match grid.stretches.iter().max_by_key(|one| one.position.len()) {
        Some(longest) if !grid.jumps_s.is_empty() => vec![longest.clone()],
        _ => grid.stretches.clone(),
    };
    let first = |series: &Vec<f64>| series.first().copied().unwrap_or(0.0);
    let zero = stretches.first().map_or([0.0; 2], |one| [&one.position, &one.beside].map(first));
    for one in &mut stretches {
        one.position.iter_mut().for_each(|load| *load -= zero[0]);
        one.beside.iter_mut().for_each(|motor| *motor -= zero[1]);
    }
    stretches
}

/// Returns a log as encoders with twice the count read it, `phase` counts later: 0 or 1. A position
/// without counts stays.
fn of_twice_the_count(grid: &TimeGrid, counts: [f64; 2], phase: f64) -> TimeGrid {
    let side = |series: &[f64], count: f64| {
        let coarse = |at: &f64| 2.0 * count * ((at / count).round() + phase).div_euclid(2.0);
        if count > 0.0 { series.iter().map(coarse).collect() } else { series.to_vec() }
    };
    let stretches = grid.stretches.iter().map(|one| Stretch {
        position: side(&one.position, counts[0]),
        beside: side(&one.beside, counts[1]),
        ..one.clone()
    });
    TimeGrid { stretches: stretches.collect(), ..grid.clone() }
}

/// Returns the slope of the load's position over the motor's; `None` if it is 0 or not finite.
fn slope(stretches: &[Stretch]) -> Option<f64> {
    let both = || stretches.iter().flat_map(|one| one.beside.iter().zip(&one.position));
    let count = both().count() as f64;
    let sums = both().fold([0.0; 2], |[motor, load], (y, l)| [motor + y, load + l]);
    let means = sums.map(|sum| sum / count);
    let (over, under) = both().fold((0.0, 0.0), |(over, under), (y, l)| {
        let motor = y - means[0];
        (over + motor * (l - means[1]), under + motor * motor)
    });
    let slope = over / under;
    (slope.is_finite() && slope != 0.0).then_some(slope)
}

/// Returns the stretches with the sides exchanged: the motor's position in units of the joint in
/// `position`, and the load's in `beside`.
fn of_the_motor(stretches: Vec<Stretch>, slope: f64) -> Vec<Stretch> {
    let swapped = stretches.into_iter().map(|one| {
        let position = one.beside.iter().map(|motor| motor * slope).collect();
        Stretch { position, beside: one.position, ..one }
    });
    swapped.collect()
}

/// Dead zone of the gear, units of the joint, and factor on the motor's position.
#[derive(Clone, Copy, Debug, PartialEq)]
struct DeadZone {
    lower: f64,
    upper: f64,
    scale: f64,
}

impl DeadZone {
    fn twist(&self, motor: f64, load: f64) -> f64 {
        self.scale * motor - load
    }

    fn pressed(&self, twist: f64) -> f64 {
        (twist - self.upper).max(0.0) + (twist - self.lower).min(0.0)
    }

    /// Returns this zone after a part of a step of the search. The width is never below zero.
    fn after(self, [middle, width, scale]: [f64; 3], part: f64) -> Self {
        let middle = 0.5 * (self.lower + self.upper) + part * middle;
        let half = 0.5 * (self.upper - self.lower + part * width).max(0.0);
        Self { lower: middle - half, upper: middle + half, scale: self.scale + part * scale }
    }
}

/// The best dead zone, and its fit of all terms.
struct Solved {
    zone: DeadZone,
    fit: Fit,
}

impl Solved {
    /// Returns the gear; `per_turn` is its ratio by the slope of the positions.
    fn gear(&self, per_turn: f64) -> IdentifiedGear {
        let Self { zone, fit } = self;
        let of =
            |place: usize| FittedParameter { value: fit.values[place], sd: fit.deviation(place) };
        let stiffness = of(STIFFNESS);
        let per = |variance: f64| variance.max(0.0).sqrt() / stiffness.value.abs();
        let slack = FittedParameter {
            value: zone.upper - zone.lower,
            sd: per(fit.covariance[WIDTH][WIDTH]),
        };
        let value = per_turn / zone.scale;
        let sd = value.abs() * per(fit.covariance[RATIO][RATIO]) / zone.scale;
        // The columns of the motor's motion are those of the slope of the positions.
        let moved = |place: usize| {
            let FittedParameter { value, sd } = of(place);
            FittedParameter { value: value / zone.scale, sd: sd / zone.scale }
        };
        IdentifiedGear {
            ratio: FittedParameter { value, sd },
            stiffness,
            damping: of(DAMPING),
            slack,
            motor_inertia: moved(0),
            motor_viscous: moved(1),
            motor_coulomb: of(2),
            effort_delay_s: 0.0,
            twist: 0.0,
            relative_residual_percent: 100.0 * (fit.residual / fit.total).sqrt(),
            doubts: Vec::new(),
        }
    }
}

/// Regression of the motor's equation over the rows of a log.
struct Problem<'a> {
    grid: &'a TimeGrid,
    filtered: &'a FilteredLog,
    /// Stretch and sample of each row.
    rows: Vec<[usize; 2]>,
    /// Time after which the logged effort acts, s.
    delay_s: f64,
    /// Whether the delay is searched; otherwise it is that of the user.
    is_delay_free: bool,
}

impl Problem<'_> {
    /// Returns the twists of all rows, in rising order.
    fn twists(&self) -> Vec<f64> {
        let twist = |[stretch, i]: &[usize; 2]| {
            let one = &self.grid.stretches[*stretch];
            one.position[*i] - one.beside[*i]
        };
        let mut twists: Vec<f64> = self.rows.iter().map(twist).collect();
        twists.sort_by(f64::total_cmp);
        twists
    }

    /// Returns a function of the motor's and the load's position, filtered, at each row.
    fn column(&self, of: impl Fn(f64, f64) -> f64) -> Vec<f64> {
        let stretches = self.grid.stretches.iter();
        let series: Vec<Vec<f64>> = stretches
            .map(|one| {
                let both = one.position.iter().zip(&one.beside);
                self.filtered.low_pass(&both.map(|(y, l)| of(*y, *l)).collect::<Vec<f64>>())
            })
            .collect();
        self.rows.iter().map(|[stretch, i]| series[*stretch][*i]).collect()
    }

    /// Returns the columns of the linear terms of a dead zone: z and dz/dt.
    fn of_zone(&self, zone: &DeadZone) -> Vec<Vec<f64>> {
        let stretches = self.grid.stretches.iter();
        let both: Vec<[Vec<f64>; 2]> = stretches
            .map(|one| {
                let twists = one.position.iter().zip(&one.beside).map(|(y, l)| zone.twist(*y, *l));
                let pressed: Vec<f64> = twists.map(|twist| zone.pressed(twist)).collect();
                let pressed = self.filtered.low_pass(&pressed);
                let [rate, _] = derivatives(&pressed, self.grid.step_s);
                [pressed, rate]
            })
            .collect();
        let at = |which: usize| self.rows.iter().map(move |[stretch, i]| [*stretch, which, *i]);
        [0, 1].map(|which| at(which).map(|[s, which, i]| both[s][which][i]).collect()).into()
    }

    /// Fits the terms of the motor, those of the dead zone, and a constant. If the columns are not
    /// independent, the constant is left out.
    fn fit(&self, of_zone: &[Vec<f64>]) -> Result<Fit, usize> {
        let columns = 3 + of_zone.len();
        let rows = || {
            self.rows.iter().enumerate().map(|(row, [stretch, i])| {
                let one = &self.filtered.stretches[*stretch];
                let mut line: RegressionRow = [0.0; MOST];
                line[..3].copy_from_slice(&[
                    one.acceleration[*i],
                    one.velocity[*i],
                    one.direction[*i],
                ]);
                for (value, column) in line[3..].iter_mut().zip(of_zone) {
                    *value = column[row];
                }
                line[columns] = 1.0;
                (line, self.filtered.effort([*stretch, *i], self.delay_s))
            })
        };
        Fit::of(columns + 1, rows).or_else(|_| Fit::of(columns, rows))
    }

    /// Returns the dead zone with the least residual. The search begins from several zones between
    /// quantiles of the twist, since a single one can lead to a local minimum.
    fn search(&self, twists: &[f64]) -> Result<Solved, String> {
        let place = |i: usize| twists[i * (twists.len() - 1) / (PLACES - 1)];
        // The best zone of each lower end, since searches from neighbouring zones end alike.
        let best = (0..PLACES).into_par_iter().filter_map(|i| {
            let zones = (i..PLACES)
                .map(|j| DeadZone { lower: place(i), upper: place(j), scale: 1.0 })
                .map(|zone| (self.residual(&zone), zone));
            zones.min_by(|(one, _), (other, _)| one.total_cmp(other))
        });
        let mut tried: Vec<(f64, DeadZone)> = best.collect();
        tried.sort_by(|(one, _), (other, _)| one.total_cmp(other));
        tried.truncate(BEGINS);
        let found = tried.into_par_iter().filter_map(|(_, zone)| self.solve(zone).ok());
        found.min_by(|one, other| one.fit.residual.total_cmp(&other.fit.residual)).ok_or_else(|| {
            "the gear presses one way only, or its twist follows the motion: log several speeds \
             and reversals"
                .into()
        })
    }

    /// Returns the dead zone with the least residual near another one.
    fn solve(&self, mut zone: DeadZone) -> Result<Solved, usize> {
        let mut fit = self.whole(&zone)?;
        let mut here = self.residual(&zone);
        for _ in 0..STEPS {
            let stiffness = fit.values[STIFFNESS];
            let step = [MIDDLE, WIDTH, RATIO].map(|place| fit.values[place] / stiffness);
            let mut shorter = (0..HALVINGS)
                .map(|halvings| zone.after(step, 0.5f64.powi(halvings)))
                .map(|next| (self.residual(&next), next));
            let Some((residual, next)) = shorter.find(|(residual, _)| *residual < here) else {
                break;
            };
            let is_done = here - residual < GAIN * here;
            (zone, here) = (next, residual);
            fit = self.whole(&zone)?;
            if is_done {
                break;
            }
        }
        // The values of the linear terms without a further step.
        let linear = self.fit(&self.of_zone(&zone))?;
        fit.values[..LINEAR].copy_from_slice(&linear.values[..LINEAR]);
        fit.residual = linear.residual;
        Ok(Solved { zone, fit })
    }

    /// Returns the delay of the effort with the least residual, s.
    fn delay(&self, zone: &DeadZone) -> Result<f64, usize> {
        let of_zone = self.of_zone(zone);
        regression::delay(self.grid.step_s, |delay_s| {
            let delayed = Problem { rows: self.rows.clone(), delay_s, ..*self };
            Ok(delayed.fit(&of_zone)?.residual)
        })
    }

    /// Returns the best dead zone together with the best delay near a dead zone and this delay.
    fn with_delay(&mut self, mut solved: Solved) -> Solved {
        let step_s = self.grid.step_s;
        for _ in 0..DELAY_STEPS {
            let Ok(fit) = self.whole(&solved.zone) else { break };
            let former_s = self.delay_s;
            let next_s = former_s + fit.values[DELAY];
            self.delay_s = next_s.clamp(DELAYS[0] * step_s, DELAYS[1] * step_s);
            solved = self.solve(solved.zone).unwrap_or(solved);
            if (self.delay_s - former_s).abs() < SMALL_DELAY * step_s {
                break;
            }
        }
        solved
    }

    fn residual(&self, zone: &DeadZone) -> f64 {
        self.fit(&self.of_zone(zone)).map_or(f64::INFINITY, |fit| fit.residual)
    }

    /// Fits all terms, including those for a step of middle, width, ratio and delay.
    fn whole(&self, zone: &DeadZone) -> Result<Fit, usize> {
        let is = |is: bool| f64::from(u8::from(is));
        let mut columns = self.of_zone(zone);
        let sides = |y: f64, l: f64| {
            let twist = zone.twist(y, l);
            [is(twist > zone.upper), is(twist <= zone.lower)]
        };
        columns.push(self.column(|y, l| -sides(y, l).iter().sum::<f64>()));
        columns.push(self.column(|y, l| {
            let [upper, lower] = sides(y, l);
            0.5 * (lower - upper)
        }));
        columns.push(self.column(|y, l| y * sides(y, l).iter().sum::<f64>()));
        if self.is_delay_free {
            let h = self.grid.step_s;
            let effort =
                |place, samples: f64| self.filtered.effort(place, self.delay_s + samples * h);
            let rate = |place: &[usize; 2]| (effort(*place, -0.5) - effort(*place, 0.5)) / h;
            columns.push(self.rows.iter().map(rate).collect());
        }
        self.fit(&columns)
    }
}
