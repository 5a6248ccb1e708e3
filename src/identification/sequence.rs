//! The identification of a joint: a bounded sequence of motions, one state machine in the tick.
//!
//! ```text
//! try + -     the effort rises from zero until the joint leaves its place: direction, encoder,
//!             and a rough breakaway effort F
//! pulses      1.5 F and 2.5 F each way from rest: a rough inertia, for the loop of what follows
//! legs + -    at six speeds in the ratio 0.45: the map of the friction  -+-> rows of the
//! swings + -  at a speed that goes to and fro between 0.4 and 1.6        +   regression
//! places      at five places, each way: breakaway at a fast rate, then at a slow one
//! return      to where it began
//! ```
//!
//! The sequence tries to stay within the speed bound. A pulse ends at 0.6 of the bound, however
//! short the pulse is then. If the joint has come to the bound, the loop no longer drives it on: a
//! joint whose friction falls breaks free faster than any loop of 20 rad/s can catch it. Some
//! joints exceed the bound all the same, which ends the sequence (docs/how-to/identify.md has the
//! share).
//!
//! Every effort goes through [`Bounds::admit`](crate::safety::open_loop::Bounds), which ends the
//! sequence at the bounds of travel, speed and time, and a push at the effort bound. So the
//! guarantees are those of `open_loop.rs`. The servo's monitors stay on.
//!
//! A broken encoder ends the sequence as well, and never as [`Outcome::Done`]: legs and the return
//! have to make progress (`progress.rs`), and a push whose counts go to and fro ends at 1.75 times
//! the effort that the joint has needed before.
//!
//! Between two steps the effort is zero until the joint has rested. The rates of the breakaway are
//! `F / 5` and `F / 20` a second: at the slow rate, a reading that is a tenth of a second late is
//! high by half a percent, and the reading at the fast rate corrects most of that.
//!
//! Does badly: a load that moves the joint without effort ends the sequence. A joint that slips and
//! sticks at the slow speeds has no point of the map there, and its Stribeck curve is not found.

use super::breakaway::{Breakaway, Push};
use super::findings::{Findings, GIVES_WAY, Outcome};
use super::follower::Follower;
use super::model::Model;
use super::plan::{FIRST_SWING, SPEEDS, Task, at, share};
use super::progress::{LegTick, Progress};
use super::pulses::{Next, Pulse, Pulses};
use super::settings::IdentificationPlan;
use super::window::{RegressionRow, Window};
use crate::safety::monitor::Standstill;
use crate::safety::open_loop::{Bound, OpenLoopState};
use crate::units::saturation::bounded;

/// Time in which the effort of the first pushes rises to its bound, s.
const RISE_S: f32 = 8.0;
/// Rates of the fast and of the slow push, in rough breakaway efforts a second.
const RATES: [f32; 2] = [0.2, 0.05];
/// First effort of the fast push, in rough breakaway efforts, and of the slow push, in readings of
/// the fast one. A slow reading more than 15 % below the fast one shows lost motion, so the slow
/// push begins there. It creeps up for 3 s; the stall monitor tolerates the part of that time
/// beyond `limits.breakaway_v`.
const FROM: [f32; 2] = [0.5, 0.85];
/// Time without effort after which a joint that still moves counts as running on, s.
const RUNS_ON_S: f32 = 5.0;
/// Share of the target speed below which the joint does not slide evenly.
const SLIDES: f32 = 0.25;
/// Largest deviation of a window's mean speed from the target speed, as a share of it, for the map
/// to include the window.
const EVEN: f32 = 0.2;
/// Shares of the travel bound that must be due before the progress is judged: of a motion whose
/// failure ends the sequence, and of a slow leg.
const DUE: [f32; 2] = [0.25, 0.05];
/// First speed of the map, by its index, at which a joint that sticks does not end the sequence.
const SLOW: usize = 2;
/// Multiple of the needed effort beyond which a noisy fast push has no reading, and multiple of the
/// fast reading beyond which a noisy slow push has none.
const BEYOND: [f32; 2] = [1.75, 1.25];
/// Shares of the mean speed between which a swing alternates, and the time of each in windows.
const SWING: [f32; 2] = [0.4, 1.6];
const SWING_WINDOWS: f32 = 1.25;

/// The phases of a step.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
enum Phase {
    /// No effort, until the joint rests.
    #[default]
    Resting,
    Pushing,
    Pulsing,
    Leading,
    Over,
}

/// An identification with its state.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Identification {
    settings: IdentificationPlan,
    open_loop: OpenLoopState,
    standstill: Standstill,
    phase: Phase,
    /// Ticks since the phase began.
    elapsed: u32,
    /// Position at the start of the phase, and the lowest and the highest position so far, counts.
    origin: i32,
    range: [i32; 2],
    /// The effort that has been held since the last tick, V.
    applied: f32,
    /// Rough breakaway effort in each sense, V, and the sign of the joint's travel in that push.
    rough: [f32; 2],
    went: [i32; 2],
    pulses: Pulses,
    push: Push,
    breakaway: Breakaway,
    /// Breakaway reading at the fast rate, V; zero: none.
    fast: f32,
    follower: Follower,
    /// Speed of the leg, deg/s, and its length, deg. At length zero the leg comes to its end.
    speed: f32,
    way: f32,
    progress: Progress,
    /// Position at the previous tick, counts.
    before: i32,
    window: Window,
    findings: Findings,
}

impl Identification {
    /// Returns an identification before its first tick.
    pub fn new(settings: &IdentificationPlan) -> Self {
        let slow = settings.slow.max(share(SPEEDS - 1) * settings.fast);
        let model = Model::new(slow, settings.fast);
        Self {
            settings: *settings,
            open_loop: OpenLoopState::start(0),
            standstill: Standstill::default(),
            phase: Phase::Resting,
            elapsed: 0,
            origin: 0,
            range: [0; 2],
            applied: 0.0,
            rough: [0.0; 2],
            went: [0; 2],
            pulses: Pulses::default(),
            push: Push { from: 0.0, rung: 0.0, reverse: false },
            breakaway: Breakaway::default(),
            fast: 0.0,
            follower: Follower::default(),
            speed: 0.0,
            way: 0.0,
            progress: Progress::default(),
            before: 0,
            window: Window::default(),
            findings: Findings { model, ..Findings::default() },
        }
    }

    /// Restarts the identification, with the joint at rest at zero.
    #[inline(never)]
    pub fn restart(&mut self) {
        let settings = self.settings;
        *self = Self::new(&settings);
    }

    /// Returns whether the identification has ended. Its effort is zero then.
    pub const fn is_over(&self) -> bool {
        matches!(self.phase, Phase::Over)
    }

    /// Returns the plan of the identification, with its bounds.
    pub const fn settings(&self) -> &IdentificationPlan {
        &self.settings
    }

    /// Returns the findings so far.
    pub const fn findings(&self) -> &Findings {
        &self.findings
    }

    /// Stores the effort that is applied to the joint until the next tick, V.
    pub const fn applied(&mut self, effort: f32) {
        self.applied = effort;
    }

    /// Called when less effort is applied than requested: a push then ends without a reading.
    pub fn capped(&mut self) {
        if self.phase == Phase::Pushing {
            self.not_found();
        }
    }

    /// Runs one tick with the joint at `counts`, and returns the effort from now on, V.
    #[inline(never)]
    pub fn update(&mut self, counts: i32) -> f32 {
        if self.is_over() {
            return 0.0;
        }
        let IdentificationPlan { tick, count, .. } = self.settings;
        let still = self.standstill.update(counts);
        let [low, high] = &mut self.range;
        (*low, *high) = ((*low).min(counts), (*high).max(counts));
        self.follower.observe(counts, [tick, count]);
        self.elapsed = self.elapsed.saturating_add(1);
        let effort = match self.phase {
            Phase::Resting => self.rest(counts, still),
            Phase::Pushing => self.push(counts),
            Phase::Pulsing => self.pulse(counts),
            Phase::Leading => self.lead(counts),
            Phase::Over => 0.0,
        };
        self.before = counts;
        match self.settings.bounds.admit(&mut self.open_loop, counts, effort) {
            // The loop does not drive on a joint that has come to the speed bound.
            Ok(effort) if self.phase == Phase::Leading && self.open_loop.drives_on(effort) => 0.0,
            Ok(effort) => effort,
            Err(Bound::Effort) if self.phase == Phase::Pushing => {
                self.not_found();
                0.0
            }
            Err(bound) => self.end(bound.into()),
        }
    }

    fn end(&mut self, outcome: Outcome) -> f32 {
        let [low, high] = self.range;
        self.findings.range = high.wrapping_sub(low) as f32 * self.settings.count;
        self.findings.outcome = outcome;
        self.phase = Phase::Over;
        0.0
    }

    /// Sets the effort to zero until the joint rests, after which the next step begins.
    fn settle(&mut self) -> f32 {
        self.findings.steps = self.findings.steps.saturating_add(1);
        self.again()
    }

    /// Sets the effort to zero until the joint rests, after which the same step is repeated.
    fn again(&mut self) -> f32 {
        (self.phase, self.elapsed) = (Phase::Resting, 0);
        // Counted from now on: the joint may have stood still at the start of a push.
        self.standstill = Standstill::default();
        0.0
    }

    fn task(&self) -> Option<Task> {
        Task::of(self.findings.steps as usize)
    }

    fn rest(&mut self, counts: i32, still: u32) -> f32 {
        if still < self.settings.quiet {
            if self.elapsed > self.settings.ticks(RUNS_ON_S) {
                return self.end(Outcome::RunsOn);
            }
            return 0.0;
        }
        (self.origin, self.elapsed) = (counts, 0);
        self.follower = Follower::begin(counts);
        match self.task() {
            None => return self.end(Outcome::Done),
            Some(Task::Try { reverse }) => {
                let rung = self.settings.bounds.effort / RISE_S * self.settings.tick;
                self.begin_push(Push { from: 0.0, rung, reverse });
            }
            Some(Task::Pulse { .. }) => match self.direction() {
                Outcome::Running => self.phase = Phase::Pulsing,
                wrong => return self.end(wrong),
            },
            Some(Task::Leg { speed, reverse }) => {
                let speed = share(speed) * self.settings.fast;
                self.begin_leg(speed, self.settings.way(speed), reverse);
            }
            Some(Task::Swing { reverse }) => {
                let speed = 0.5 * self.settings.fast;
                self.begin_leg(speed, 2.0 * self.settings.way(speed), reverse);
            }
            Some(Task::Go { place }) => {
                let way = at(place) * self.settings.room() - self.position();
                self.begin_leg(0.5 * self.settings.fast, way.abs(), way < 0.0);
            }
            Some(Task::Return) => {
                let way = -self.position();
                self.begin_leg(0.5 * self.settings.fast, way.abs(), way < 0.0);
            }
            Some(Task::Push { reverse, slow: false, .. }) => {
                let rough = self.rough_friction(reverse);
                let [rate, _] = RATES.map(|rate| rate * rough * self.settings.tick);
                self.begin_push(Push { from: FROM[0] * rough, rung: rate, reverse });
            }
            Some(Task::Push { reverse, .. }) => {
                if self.fast <= 0.0 {
                    return self.settle();
                }
                let rate = RATES[1] * self.rough_friction(reverse) * self.settings.tick;
                self.begin_push(Push { from: FROM[1] * self.fast, rung: rate, reverse });
            }
        }
        0.0
    }

    /// Returns the outcome that the directions of the first two pushes show; `Running` if they are
    /// right.
    const fn direction(&self) -> Outcome {
        match self.went {
            [1, -1] => Outcome::Running,
            [-1, 1] => Outcome::Reversed,
            [0, _] | [_, 0] => Outcome::Still,
            _ => Outcome::Pulled,
        }
    }

    const fn rough_friction(&self, reverse: bool) -> f32 {
        self.rough[reverse as usize]
    }

    /// Returns the least and the largest effort (V) that the legs have needed in a sense so far.
    /// Neither is less than the rough breakaway effort, to which only a bristle or a shaft may have
    /// given way.
    #[inline(never)]
    fn needed(&self, reverse: bool) -> [f32; 2] {
        let rough = self.rough_friction(reverse);
        let (mut least, mut most) = (f32::MAX, rough);
        for [positive, negative] in &self.findings.map {
            let point = if reverse { negative } else { positive };
            if point.windows > 0 {
                least = least.min(point.effort.abs());
                most = most.max(point.effort.abs());
            }
        }
        [if least < f32::MAX { least.max(rough) } else { rough }, most]
    }

    /// Returns the position in which the joint rests, deg.
    const fn position(&self) -> f32 {
        self.origin as f32 * self.settings.count
    }

    fn begin_push(&mut self, push: Push) {
        self.push = push;
        self.breakaway = Breakaway::begin(self.origin);
        self.phase = Phase::Pushing;
    }

    /// Returns the effort (V) beyond which a push whose counts go to and fro has no reading: such
    /// counts do not show that the joint broke away.
    fn most_of_push(&self) -> f32 {
        match self.task() {
            Some(Task::Push { slow: true, .. }) => BEYOND[1] * self.fast,
            Some(Task::Push { reverse, .. }) => BEYOND[0] * self.needed(reverse)[0],
            _ => f32::MAX,
        }
    }

    fn push(&mut self, counts: i32) -> f32 {
        let reading = match self.breakaway.update(&self.push, counts, self.settings.tick) {
            Ok(effort) if self.breakaway.is_noisy() && effort.abs() > self.most_of_push() => {
                self.not_found();
                return 0.0;
            }
            Ok(effort) => return effort,
            Err(reading) => reading,
        };
        let side = usize::from(self.push.reverse);
        match self.task() {
            Some(Task::Try { .. }) => {
                self.rough[side] = reading;
                self.went[side] = self.breakaway.travel().signum();
            }
            Some(Task::Push { place, slow, .. }) => {
                let gave_way = self.breakaway.gave_way() >= GIVES_WAY;
                self.findings.gave_way = self.findings.gave_way.saturating_add(gave_way.into());
                if !slow {
                    self.fast = reading;
                    return self.settle();
                }
                let rates = RATES.map(|rate| rate * self.rough[side]);
                let level = Breakaway::at_rest([self.fast, reading], rates);
                if let Some(found) = self.findings.levels[side].get_mut(place) {
                    *found = level;
                }
                let lost = (self.fast / reading - 1.0).abs();
                self.findings.lost = self.findings.lost.max(lost);
            }
            _ => {}
        }
        self.settle()
    }

    /// Ends a push without a reading.
    fn not_found(&mut self) {
        self.fast = 0.0;
        self.settle();
    }

    fn pulse(&mut self, counts: i32) -> f32 {
        let Some(Task::Pulse { strong, reverse }) = self.task() else { return self.settle() };
        let side = usize::from(reverse);
        let size = Pulse::size(strong, self.rough[side], self.settings.bounds.effort);
        let moved = counts.wrapping_sub(self.origin).unsigned_abs();
        let pulse = Pulse { strong, reverse, size, elapsed: self.elapsed, moved };
        match self.pulses.update(&pulse, counts, &self.settings) {
            Next::Lasts if reverse => -size,
            Next::Lasts => size,
            Next::Measured => {
                self.findings.met = self.pulses.met();
                self.settle()
            }
            Next::Again => {
                self.rough[side] = size;
                self.again()
            }
            Next::Still => self.end(Outcome::Still),
        }
    }

    /// Returns the acceleration of the legs, deg/s^2.
    fn acceleration(&self) -> f32 {
        let IdentificationPlan { bounds, fast, .. } = self.settings;
        let [positive, negative] = self.rough;
        let left = (bounds.effort - positive.max(negative)).max(0.0);
        (fast / self.settings.window_time()).min(0.5 * left / self.pulses.inertia)
    }

    fn begin_leg(&mut self, speed: f32, way: f32, reverse: bool) {
        let sign = if reverse { -1.0 } else { 1.0 };
        let brakes = 0.5 * speed * speed / self.acceleration();
        let room = self.settings.room() - sign * self.position() - brakes;
        self.way = way.min(room);
        self.speed = sign * speed;
        self.window = Window::begin(self.origin);
        self.progress = Progress::default();
        // The leg is skipped without a way to go, or if the encoder would not show that the joint
        // slides.
        if self.way > 0.0 && speed >= self.settings.slow {
            self.phase = Phase::Leading;
        } else {
            self.settle();
        }
    }

    fn lead(&mut self, counts: i32) -> f32 {
        let IdentificationPlan { tick, count, window, .. } = self.settings;
        let task = self.task();
        let speed = self.speed;
        let patience = 3.0 * self.way / speed.abs() + RUNS_ON_S;
        let is_far = self.follower.reference.abs() >= self.way;
        if is_far || self.elapsed > self.settings.ticks(patience) {
            self.way = 0.0;
        }
        let ends = self.way <= 0.0;
        if ends && self.follower.speed == 0.0 {
            return self.settle();
        }
        let reverse = speed < 0.0;
        let friction = match task {
            Some(Task::Leg { .. }) => self.rough_friction(reverse),
            _ => self.needed(reverse)[1],
        };
        let expected = [friction, self.follower.speed.abs()];
        if self.lacks_progress(counts, reverse, expected) {
            return match task {
                // The joint may stick at this speed and at slower ones. The swings have to move it.
                Some(Task::Leg { speed: SLOW.., .. }) => {
                    self.findings.steps = self.findings.steps.max(FIRST_SWING);
                    self.again()
                }
                _ => self.end(Outcome::NoProgress),
            };
        }
        // In a swing, the share is that of its lower speed.
        let share = if let Some(Task::Swing { .. }) = task { SWING[0] * SLIDES } else { SLIDES };
        let slides = self.follower.velocity * speed.signum() > share * speed.abs();
        if slides {
            let row = self.window.update(counts, self.applied, window, [tick, count]);
            if let (Some(row), Some(Task::Leg { .. } | Task::Swing { .. })) = (row, task) {
                self.take(&row);
            }
        } else {
            self.window = Window::begin(counts);
        }
        let towards = match task {
            _ if ends => 0.0,
            Some(Task::Swing { .. }) => {
                let half = self.settings.ticks(SWING_WINDOWS * self.settings.window_time());
                speed * SWING[usize::from(self.elapsed / half.max(1) % 2 == 1)]
            }
            _ => speed,
        };
        let [positive, negative] = self.rough;
        let rough = [self.pulses.inertia, self.rough_friction(speed < 0.0), positive.max(negative)];
        let asked = self.follower.lead(towards, self.acceleration(), tick, rough);
        bounded(asked, self.settings.bounds.effort)
    }

    /// Adds a tick to the check of the progress, and returns whether the joint travels too little
    /// for the applied effort. `friction` (V) is that of this sense; `speed` (deg/s) is the
    /// reference's.
    #[inline(never)]
    fn lacks_progress(&mut self, counts: i32, reverse: bool, [friction, speed]: [f32; 2]) -> bool {
        let IdentificationPlan { tick, count, bounds, .. } = self.settings;
        let sense = if reverse { -1.0 } else { 1.0 };
        let leg = LegTick {
            excess: sense * self.applied - friction,
            inertia: self.pulses.inertia,
            speed,
            travel: sense * counts.wrapping_sub(self.before) as f32 * count,
            tick,
        };
        let share = if matches!(self.task(), Some(Task::Leg { speed: SLOW.., .. })) {
            DUE[1]
        } else {
            DUE[0]
        };
        self.progress.lacks(&leg, share * bounds.travel as f32 * count)
    }

    /// Adds a row to the regression, and to the map if it is of a leg and near the leg's speed.
    fn take(&mut self, row: &RegressionRow) {
        let task = self.task();
        self.findings.model.add(row, matches!(task, Some(Task::Leg { .. })));
        let Some(Task::Leg { speed, reverse }) = task else { return };
        if (row.velocity / self.speed - 1.0).abs() > EVEN {
            return;
        }
        let of_speed = self.findings.map.get_mut(speed);
        if let Some(point) = of_speed.and_then(|both| both.get_mut(usize::from(reverse))) {
            point.windows = point.windows.saturating_add(1);
            let share = 1.0 / f32::from(point.windows);
            point.velocity += share * (row.velocity - point.velocity);
            point.effort += share * (row.effort - point.effort);
        }
    }
}
