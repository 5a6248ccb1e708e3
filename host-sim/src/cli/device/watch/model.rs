//! Model of the view: the last status, and the samples of the last seconds.

use std::collections::VecDeque;

use stiction::Parameters;
use stiction::control::signal::name;
use stiction::link::{Sample, StateCode, Status};

use files::error::Error;
use simulator::device::shown_current::ShownCurrent;
use simulator::device::signals::{OF_THE_LOOP, Signals};
use simulator::device::travel::Travel;

/// Length of the plotted past, s, unless a move takes longer.
pub const WINDOW_S: f64 = 10.0;

/// Longest plotted past, s; at 50 samples a second, it bounds the number of stored samples.
const LONGEST_WINDOW_S: f64 = 300.0;

/// Signals that the view subscribes to in addition to those of the loop: duty and current.
const OF_THE_MOTOR: [&str; 3] = [name("compare"), name("reverse"), name("current")];

/// The signals that the view subscribes to.
pub fn subscribed() -> impl Iterator<Item = &'static str> {
    OF_THE_LOOP.into_iter().chain(OF_THE_MOTOR)
}

/// Signals of one tick, in the user's units.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct WatchSample {
    /// Time of the device, s.
    pub time_s: f64,
    /// theta_d from the zero of the arming, deg.
    pub reference_deg: f64,
    /// theta_a, deg.
    pub position_deg: f64,
    /// theta_e, deg.
    pub error_deg: f64,
    /// theta_a', deg/s.
    pub velocity_deg_per_s: f64,
    /// Output of the PD loop, V.
    pub v_pd: f64,
    /// Effort of the compensator, V.
    pub v_c: f64,
    /// Sum of both, limited to the full scale, V.
    pub v: f64,
    /// Effort after the drive's limits, V.
    pub v_applied: f64,
    /// Measured current of the motor, A; zero without a sensor.
    pub current_a: f64,
    /// Target of a current loop, A; zero without one.
    pub target_a: f64,
    /// Code of the drive.
    pub code: i32,
    /// Compare value, with its sign.
    pub duty: i32,
    /// Whether the device was armed in this tick; otherwise the view does not show the signals
    /// above.
    pub armed: bool,
    /// Whether the output is at its limit.
    pub saturated: bool,
}

impl WatchSample {
    fn new(signals: &Signals, sample: &Sample, sample_time_s: f64, resolution_deg: f64) -> Self {
        let value = |signal| signals.number(sample, signal);
        let flags = value(const { name("status") }) as u32;
        let reference =
            value(const { name("reference_counts") }) + value(const { name("reference_fraction") });
        let compare = value(const { name("compare") }) as i32;
        Self {
            time_s: f64::from(sample.clock) * sample_time_s,
            reference_deg: reference * resolution_deg,
            position_deg: value(const { name("counts") }) * resolution_deg,
            error_deg: value(const { name("error") }),
            velocity_deg_per_s: value(const { name("velocity") }),
            v_pd: value(const { name("v_pd") }),
            v_c: value(const { name("v_c") }),
            v: value(const { name("v") }),
            v_applied: value(const { name("v_applied") }),
            target_a: 0.0,
            current_a: value(const { name("current") }),
            code: value(const { name("code") }) as i32,
            duty: if value(const { name("reverse") }) == 0.0 { compare } else { -compare },
            armed: flags & 0xFF == 2,
            saturated: flags & (1 << 16) != 0,
        }
    }
}

/// Samples and status of a device that is watched.
#[derive(Clone, Debug)]
pub struct WatchedDevice {
    /// Warning in the first line of the view; a board needs none.
    pub warning: Option<&'static str>,
    /// The name of the device, and its firmware.
    pub name: String,
    /// The signals that the device can send.
    pub signals: Signals,
    /// The answer to the last request for the status.
    pub status: Status,
    /// Length of the past that is kept, s: that of the last move, in whole tens of seconds.
    pub kept_s: f64,
    /// Samples of the past that is kept.
    pub moments: VecDeque<WatchSample>,
    /// Number of samples that did not arrive.
    pub lost: u64,
    /// Whether this program has armed the drive.
    pub armed_here: bool,
    /// Range of the targets that can be typed; none before the parameters are read.
    pub travel: Option<Travel>,
    /// The motor's current; none without a sensor, or before the parameters are read.
    pub current: Option<ShownCurrent>,
    /// A position that is being typed.
    pub entry: String,
    /// A sentence on what the last key did, or why it did nothing.
    pub note: String,
}

impl WatchedDevice {
    /// Returns a device without samples.
    pub fn new(
        warning: Option<&'static str>,
        name: String,
        signals: Signals,
        status: Status,
    ) -> Self {
        Self {
            warning,
            name,
            signals,
            status,
            kept_s: WINDOW_S,
            moments: VecDeque::new(),
            lost: 0,
            armed_here: false,
            travel: None,
            current: None,
            entry: String::new(),
            note: String::new(),
        }
    }

    /// Stores a sample, and drops those that are too old.
    pub fn take(&mut self, sample: &Sample) {
        let Status { sample_time, resolution, .. } = self.status;
        let mut moment =
            WatchSample::new(&self.signals, sample, sample_time.into(), resolution.into());
        let a_per_v = self.current.and_then(|current| current.target_a_per_v);
        moment.target_a = a_per_v.map_or(0.0, |a_per_v| a_per_v * moment.v_applied);
        // A device that was reset restarts its clock.
        if self.moments.back().is_some_and(|last| last.time_s > moment.time_s) {
            self.moments.clear();
        }
        self.moments.push_back(moment);
        while self.moments.front().is_some_and(|first| first.time_s < moment.time_s - self.kept_s) {
            self.moments.pop_front();
        }
    }

    /// Stores an answer to a request for the status. Clears `armed_here` if the drive is not armed.
    pub fn follow(&mut self, status: Status) {
        self.armed_here &= matches!(status.state, StateCode::Armed);
        self.status = status;
        let resolution_deg = f64::from(status.resolution);
        let clock_s = f64::from(status.clock) * f64::from(status.sample_time);
        let last = self.moments.back().filter(|moment| moment.armed);
        let sample = last.map(|moment| {
            let counts = (moment.position_deg / resolution_deg).round() as i32;
            (clock_s - moment.time_s, counts)
        });
        if let Some(travel) = &mut self.travel {
            travel.follow(&status, sample);
        }
    }

    /// Reads travel and current from the parameters of the device.
    pub fn configure(&mut self, parameters: &Parameters) {
        self.travel = Some(Travel::new(parameters));
        self.current = ShownCurrent::of(parameters);
    }

    /// Checks a target, deg from the zero of the arming.
    ///
    /// # Errors
    /// Names the range of targets.
    pub fn check(&self, deg: f64) -> Result<(), Error> {
        self.travel.map_or(Ok(()), |travel| travel.check("move", deg))
    }

    /// Sets the plotted past to the length of a move, in whole tens of seconds.
    pub fn show(&mut self, move_s: f64) {
        self.kept_s = (10.0 * (move_s / 10.0).ceil()).clamp(WINDOW_S, LONGEST_WINDOW_S);
    }

    /// Returns the last sample; zeros if there is none.
    pub fn now(&self) -> WatchSample {
        self.moments.back().copied().unwrap_or_default()
    }

    /// Returns whether the drive was armed in the last status.
    pub const fn is_armed(&self) -> bool {
        matches!(self.status.state, StateCode::Armed)
    }

    /// Returns the time that the plots show, s: the time since the first kept sample of an armed
    /// device, rounded up to 1, 2 or 5 s or else to `kept_s`, so that a short move fills the plots.
    pub fn window_s(&self) -> f64 {
        let now_s = self.now().time_s;
        let first = self.moments.iter().find(|moment| moment.armed);
        let length_s = first.map_or(WINDOW_S, |first| now_s - first.time_s);
        [1.0, 2.0, 5.0].into_iter().find(|window_s| length_s <= *window_s).unwrap_or(self.kept_s)
    }

    /// Returns a signal over time, in pieces during which the device stayed armed. Time counts back
    /// from the last sample, s.
    pub fn curves(&self, term: impl Fn(&WatchSample) -> f64) -> Vec<Vec<(f64, f64)>> {
        let now_s = self.now().time_s;
        let moments: Vec<&WatchSample> = self.moments.iter().collect();
        let armed = moments.split(|moment| !moment.armed).filter(|piece| !piece.is_empty());
        armed.map(|piece| piece.iter().map(|m| (m.time_s - now_s, term(m))).collect()).collect()
    }
}
