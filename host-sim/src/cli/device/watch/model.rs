//! What is known of a device that is watched, and for how long.

use std::collections::VecDeque;

use stiction::link::{Sample, State, Status, Term};

use crate::device::log::Log;

/// So much of the past is plotted, s.
pub const WINDOW_S: f64 = 10.0;

/// What has to be subscribed: what a log holds, and what a log has no column for.
pub const TERMS: u16 = Log::TERMS | Term::Duty.bit() | Term::Flags.bit();

/// The terms of one tick, in a user's units.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Moment {
    /// Device's time, s.
    pub time_s: f64,
    /// theta_d in the zero of the arming, deg.
    pub reference_deg: f64,
    /// theta_a, deg.
    pub position_deg: f64,
    /// theta_e, deg.
    pub error_deg: f64,
    /// theta_a', deg/s.
    pub velocity_deg_per_s: f64,
    /// V.
    pub v_pd: f64,
    /// V.
    pub v_c: f64,
    /// V.
    pub v: f64,
    /// Code of the drive.
    pub code: i32,
    /// Compare value, with its sign.
    pub duty: i32,
    /// The loop is closed; without it all of the above are zero.
    pub armed: bool,
    /// The output is at its limit.
    pub saturated: bool,
}

impl Moment {
    fn new(sample: &Sample, sample_time_s: f64, resolution_deg: f64) -> Self {
        let whole = |term| sample.value(term).map_or(0, i32::from_le_bytes);
        let real = |term| f64::from(sample.value(term).map_or(0.0, f32::from_le_bytes));
        let flags = whole(Term::Flags) as u32;
        let setpoint = f64::from(whole(Term::SetpointCounts)) + real(Term::SetpointFraction);
        Self {
            time_s: f64::from(sample.clock) * sample_time_s,
            reference_deg: setpoint * resolution_deg,
            position_deg: f64::from(whole(Term::Counts)) * resolution_deg,
            error_deg: real(Term::Error),
            velocity_deg_per_s: real(Term::Velocity),
            v_pd: real(Term::Pd),
            v_c: real(Term::Compensator),
            v: real(Term::Output),
            code: whole(Term::Code),
            duty: whole(Term::Duty),
            armed: flags & 0xFF == 2,
            saturated: flags & (1 << 16) != 0,
        }
    }
}

/// A device that is watched.
#[derive(Clone, Debug)]
pub struct Watched {
    /// What every view of it begins with; nothing for a board.
    pub warning: Option<&'static str>,
    /// What it is, and its firmware.
    pub name: String,
    /// As last asked.
    pub status: Status,
    /// Of the last [`WINDOW_S`].
    pub moments: VecDeque<Moment>,
    /// Samples that did not arrive.
    pub lost: u64,
    /// This program has armed it.
    pub armed_here: bool,
    /// A position that is being typed.
    pub entry: String,
    /// What the last key did, or why it did nothing.
    pub note: String,
}

impl Watched {
    /// Before the first sample.
    pub fn new(warning: Option<&'static str>, name: String, status: Status) -> Self {
        Self {
            warning,
            name,
            status,
            moments: VecDeque::new(),
            lost: 0,
            armed_here: false,
            entry: String::new(),
            note: String::new(),
        }
    }

    /// Takes a sample, and forgets those that are too old.
    pub fn take(&mut self, sample: &Sample) {
        let Status { sample_time, resolution, .. } = self.status;
        let moment = Moment::new(sample, sample_time.into(), resolution.into());
        // A device that was reset begins its time anew.
        if self.moments.back().is_some_and(|last| last.time_s > moment.time_s) {
            self.moments.clear();
        }
        self.moments.push_back(moment);
        while self.moments.front().is_some_and(|first| first.time_s < moment.time_s - WINDOW_S) {
            self.moments.pop_front();
        }
    }

    /// The last moment.
    pub fn now(&self) -> Moment {
        self.moments.back().copied().unwrap_or_default()
    }

    /// Whether it is armed, as far as was last heard.
    pub const fn is_armed(&self) -> bool {
        matches!(self.status.state, State::Armed)
    }

    /// A term over time, in pieces of uninterrupted arming; time counts back from the last moment.
    pub fn curves(&self, term: impl Fn(&Moment) -> f64) -> Vec<Vec<(f64, f64)>> {
        let now_s = self.now().time_s;
        let moments: Vec<&Moment> = self.moments.iter().collect();
        let armed = moments.split(|moment| !moment.armed).filter(|piece| !piece.is_empty());
        armed.map(|piece| piece.iter().map(|m| (m.time_s - now_s, term(m))).collect()).collect()
    }
}
