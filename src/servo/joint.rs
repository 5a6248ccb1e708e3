//! A joint's controller with all that a tick needs, made of parameters once.

use super::{Arming, Input, control};
use crate::controller::{Controller, Tick};
use crate::course::{Course, CourseState};
use crate::drive::Drive;
use crate::encoder::Encoder;
use crate::error::Error;
use crate::monitor::{MonitorState, Monitors};
use crate::parameters::{Parameters, SUPPLY_FULL_SCALE};
use crate::position::Position;
use crate::reference::{Reference, Step};
use crate::saturation::saturate;

/// A joint's controller with what it needs to run, made of parameters ([`Joint::prepare`]).
#[derive(Clone, Debug)]
pub struct Joint {
    pub(super) controller: Controller,
    /// What is run: the motion of the parameters, until a link asks for another one. There is no room for both.
    pub(super) course: Course,
    /// A link has done so.
    pub(super) replaced: bool,
    pub(super) state: CourseState,
    soft_start: SoftStart,
    /// Nominal supply in the converter's units; 0: the output is left alone.
    nominal_supply: f32,
    pub(super) encoder: Encoder,
    /// Where it was armed, counts since power-on.
    pub(super) zero: i32,
    pub(super) monitors: Monitors,
    pub(super) watch: MonitorState,
    /// Ticks from the first one to arming by itself.
    pub(super) autostart: Option<u32>,
}

/// A rising limit of the code, in whole ticks.
#[derive(Clone, Copy, Debug)]
struct SoftStart {
    ticks: u32,
    elapsed: u32,
}

impl Joint {
    /// Validates parameters and prepares all that a tick needs, in its place: a joint is a kilobyte, and the stack of a
    /// board has no room for two.
    ///
    /// # Errors
    /// As [`Parameters::prepare`]; nothing is changed then.
    pub fn prepare(place: &mut Option<Self>, parameters: &Parameters) -> Result<(), Error> {
        parameters.validate()?;
        Self::begin_with(place, parameters)?;
        match place {
            Some(joint) => parameters.motion.set(&parameters.controller, &mut joint.course),
            None => Ok(()),
        }
    }

    /// All but the motion. A function of its own, so that what it needs of the stack is free again for the motion.
    #[inline(never)]
    fn begin_with(place: &mut Option<Self>, parameters: &Parameters) -> Result<(), Error> {
        let Parameters { device, limits, controller: config, .. } = parameters;
        let in_ticks = |s: f32| libm::roundf(s / config.sample_time) as u32;
        let nominal_supply = match device.supply_full_scale {
            full_scale if full_scale > 0.0 => {
                device.nominal_supply / full_scale * f32::from(SUPPLY_FULL_SCALE)
            }
            _ => 0.0,
        };
        *place = Some(Self {
            controller: Controller::new(config)?,
            course: Course::default(),
            replaced: false,
            state: CourseState::default(),
            soft_start: SoftStart { ticks: in_ticks(device.soft_start), elapsed: 0 },
            nominal_supply,
            encoder: config.encoder,
            zero: 0,
            monitors: Monitors::new(limits, config, device),
            watch: MonitorState::default(),
            autostart: device.autostart.then(|| in_ticks(device.autostart_delay)),
        });
        Ok(())
    }

    /// Begins with the counter at `counter`, which becomes zero.
    pub(super) fn arm(&mut self, counter: u32, arming: Arming) {
        match arming {
            Arming::Motion => {}
            Arming::ByLink => self.begin(Course::Follow(Reference::Step(Step::default()))),
            Arming::Ramp(ramp) => self.begin(Course::Ramp(ramp)),
        }
        self.state = CourseState::start(&self.controller, counter, 0);
        self.watch = self.monitors.armed(&self.watch, arming != Arming::Motion);
        self.soft_start.elapsed = 0;
    }

    /// Forgets what the law and the monitors remember, but for the heat, and for what a ramp has found.
    pub(super) fn rest(&mut self) {
        if !self.is_over() {
            self.state = CourseState::default();
        }
        self.watch = self.monitors.armed(&self.watch, false);
    }

    /// What a link asks for instead of the motion of the parameters.
    pub(super) fn begin(&mut self, course: Course) {
        self.course = course;
        self.replaced = true;
        self.watch.listen();
        self.state.begin_motion();
    }

    /// Whether a position in the zero of this arming is out of the range.
    pub(super) const fn is_out_of_range(&self, position: Position) -> bool {
        self.monitors.is_out_of_range(self.zero.wrapping_add(position.counts))
    }

    #[inline]
    pub(super) fn tick(&mut self, input: Input) -> Tick {
        let mut tick = control(&self.course, &self.controller, &mut self.state, input.counter);
        let drive = self.controller.drive();
        let mut code = tick.code;
        if self.nominal_supply > 0.0 {
            let v = tick.v * supply_ratio(self.nominal_supply, input.supply);
            let (v, saturated) = saturate(v, self.controller.full_scale());
            tick.saturated |= saturated;
            code = drive.code(v);
        }
        let limit = match self.course {
            Course::Follow(_) => self.soft_start.limit(drive),
            Course::Ramp(_) => drive.max_code(),
        };
        let limited = code.max(-limit).min(limit);
        if limited != tick.code {
            tick.saturated |= limited != code;
            tick.code = limited;
            tick.duty = drive.duty(limited);
        }
        if let Course::Ramp(_) = self.course
            && tick.saturated
        {
            self.state.ramp_mut().abandon();
        }
        tick
    }

    /// Of a ramp only: a reference has no end.
    pub(super) const fn is_over(&self) -> bool {
        matches!(self.course, Course::Ramp(_)) && self.state.ramp().is_over()
    }
}

impl SoftStart {
    /// The largest code of this tick.
    fn limit(&mut self, drive: &Drive) -> i16 {
        let max = drive.max_code();
        if self.elapsed >= self.ticks {
            return max;
        }
        // 10 s at 10 kHz, and 32 767 codes: the product fits.
        let scaled = self.elapsed.wrapping_mul(u32::from(max.unsigned_abs()));
        self.elapsed += 1;
        scaled.checked_div(self.ticks).unwrap_or(0) as i16
    }
}

/// How much more duty the present supply needs, within a factor of two either way: a broken divider must not turn
/// into full effort.
fn supply_ratio(nominal: f32, measured: u16) -> f32 {
    (nominal / f32::from(measured.max(1))).clamp(0.5, 2.0)
}
