//! Resistance and inductance of a winding, from the currents that pulses of voltage cause at
//! standstill.
//!
//! ```text
//! L di/dt + R i = +-U - V_d sgn(i)                V_d: lost to dead time and brushes
//! i(t) = B - (I + B) exp(-t / tau)  for t < t_0,  B = (U + V_d) / R,  tau = L / R
//!      = A (1 - (I + B) / B exp(-t / tau))        A = (U - V_d) / R,  t_0 = tau ln((I + B) / B)
//! I = A (1 - E) / (1 + A E / B)                   E = exp(-H / tau): i(H) = I = -i(0)
//! ```
//!
//! The device sums the readings of all half cycles H, group by group
//! ([`winding_pulses`](stiction::control::winding_pulses)). R, tau and V_d are the least squares of
//! ten such measurements with different voltages: one alone does not separate R from V_d, and each
//! has another error of quantisation. Gauss and Newton's iteration solves for ln R, ln tau and V_d.
//!
//! The error bars are two standard deviations of the fit, whose residuals may be the same within a
//! measurement. That of R also includes the back-EMF of a joint that has moved by the measured
//! distance in each half cycle; that of L a loss whose sign follows the current's half a period of
//! the PWM late. They do not include the tolerance of shunt and supply, which are
//! errors of R in full. A time constant of less than a quarter of the PWM's period is not resolved.

use std::time::Duration;

use serde_json::{Value, json};
use stiction::Parameters;
use stiction::control::controller::EffortMode;
use stiction::control::drive::pwm_top;
use stiction::control::winding_pulses::{GROUPS, GroupSums, MOST_CYCLES, MOST_PERIODS};
use stiction::link::StateCode;
use stiction::motion::winding::{WindingEnd, WindingFindings, WindingRequest};

use crate::log_identification::least_squares::{Fit, MOST, RegressionRow};
use files::error::{Error, rounded, shown};
use files::hardware::STM32F405;
use files::written::single;
use simulator::device::client::Client;
use simulator::device::wire::Wire;

/// Default voltage, as a part of the largest effort of a jog, which is one and a half times the
/// breakaway effort: 0.9 of it do not move the joint.
const OF_JOG: f32 = 0.6;

/// Number of voltages, and the smallest of them as a part of the largest.
const VOLTAGES: usize = 10;
const SMALLEST: f32 = 0.4;

/// Parts of the largest voltage with which the measurement begins, and cycles at each: 25 ms.
const APPROACH: [f32; 4] = [0.1, 0.2, 0.4, 0.8];
const SHORT_CYCLES: u16 = 8;

/// Time of one measurement, s.
const TIME_S: f64 = 0.2;

/// Smallest time constant that is resolved, in periods of the PWM: the first reading, after half a
/// period, is then 13 % of the way from the last one.
const RESOLVED: f64 = 0.25;

/// Largest rise of the current in the last quarter of a half cycle, as a part of it, for the
/// current to count as settled: it is at 2.2 time constants there.
const RISES: f64 = 0.1;

/// Smallest settled current, readings. Their quantisation is half of one.
const LEAST_READINGS: f64 = 20.0;

/// Readings of one measurement.
#[derive(Clone, Debug, PartialEq)]
pub struct Readings {
    /// Voltage, V.
    pub effort_v: f64,
    /// Period of the PWM, s.
    pub period_s: f64,
    /// Periods in a group.
    pub periods: u8,
    /// Mean current of each group, A.
    pub currents_a: [f64; GROUPS],
}

impl Readings {
    /// Returns the currents of a device's findings.
    pub fn of(found: &WindingFindings, asked: &WindingRequest, period_s: f64) -> Self {
        let readings = 2.0 * f64::from(asked.cycles) * f64::from(asked.periods);
        let unit_a = f64::from(found.unit);
        let sums: GroupSums = found.sums;
        let currents_a = sums.map(|sum| f64::from(sum) * unit_a / readings);
        Self { effort_v: found.effort.into(), period_s, periods: asked.periods, currents_a }
    }

    fn half_cycle_s(&self) -> f64 {
        GROUPS as f64 * f64::from(self.periods) * self.period_s
    }

    /// Returns the mean current of the last quarter of a half cycle, A, and its rise there, as a
    /// part of it.
    fn settled(&self) -> (f64, f64) {
        let mean = |groups: &[f64]| groups.iter().sum::<f64>() / groups.len() as f64;
        let quarter = &self.currents_a[3 * GROUPS / 4..];
        let (early, late) = quarter.split_at(quarter.len() / 2);
        (mean(quarter), (mean(late) - mean(early)) / mean(quarter).abs().max(f64::MIN_POSITIVE))
    }

    /// Returns the mean current of a group under these values, A.
    fn modelled(&self, group: usize, [log_ohm, log_tau, lost_v]: [f64; 3]) -> f64 {
        let (ohm, tau_s) = (log_ohm.exp(), log_tau.exp());
        let (towards, against) = ((self.effort_v + lost_v) / ohm, (self.effort_v - lost_v) / ohm);
        let decay = (-self.half_cycle_s() / tau_s).exp();
        let end = against * (1.0 - decay) / (1.0 + against * decay / towards);
        let ratio = (end + towards) / towards;
        let current = |time_s: f64| {
            let decay = (-time_s / tau_s).exp();
            if ratio * decay > 1.0 {
                towards - (end + towards) * decay
            } else {
                against * (1.0 - ratio * decay)
            }
        };
        let periods = usize::from(self.periods);
        let times = (0..periods).map(|period| (group * periods + period) as f64 + 0.5);
        times.map(|time| current(time * self.period_s)).sum::<f64>() / periods as f64
    }
}

/// A value with its error bar.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Estimate {
    /// Value.
    pub value: f64,
    /// Half the width of its error bar.
    pub error: f64,
}

/// Resistance and inductance of a winding.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Winding {
    /// Resistance, ohm.
    pub resistance_ohm: Estimate,
    /// Inductance, H.
    pub inductance_h: Estimate,
    /// Voltage that dead time and brushes lose, V.
    pub lost_v: Estimate,
}

impl Winding {
    /// Fits measurements with different voltages, the largest first. `moved_v` is the back-EMF of
    /// the joint's motion in them, V. None if no winding fits.
    pub fn fit(measured: &[Readings], moved_v: f64) -> Option<Self> {
        let [first, .., last] = measured else { return None };
        let [(one_a, _), (other_a, _)] = [first.settled(), last.settled()];
        let ohm = (first.effort_v - last.effort_v) / (one_a - other_a);
        let lost_v = (first.effort_v - ohm * one_a).max(0.0);
        // Without losses, the current is zero after tau ln 2.
        let crosses = first.currents_a.iter().position(|current| *current > 0.0)?;
        let crosses_s = (crosses as f64 + 0.5) * f64::from(first.periods) * first.period_s;
        let tau_s = crosses_s / std::f64::consts::LN_2;
        if !(ohm > 0.0 && ohm.is_finite()) {
            return None;
        }
        let mut values = [ohm.ln(), tau_s.ln(), lost_v];
        let mut fit = None;
        let all = || measured.iter().flat_map(|one| &one.currents_a);
        let squares: f64 = all().map(|current| current * current).sum();
        let least_s: f64 = RESOLVED * first.period_s;
        for _ in 0..STEPS {
            values[1] = values[1].max(least_s.ln());
            let before = values;
            let linear = linearised(measured, values, 3)?;
            let step = [0, 1, 2].map(|column| linear.values[column].clamp(-1.0, 1.0));
            values = [0, 1, 2].map(|column| values[column] + step[column]);
            let free = values[2];
            values[2] = free.clamp(0.0, 0.9 * last.effort_v);
            if values[2] != free {
                // At the bound, the loss is no value of the fit any more.
                let fixed =
                    linearised(measured, [values[0] - step[0], values[1] - step[1], values[2]], 2)?;
                values[0] += fixed.values[0].clamp(-1.0, 1.0) - step[0];
                values[1] += fixed.values[1].clamp(-1.0, 1.0) - step[1];
            }
            let residual = (linear.residual / squares).sqrt();
            fit = Some((linear, residual));
            if (0..3).all(|place| (values[place] - before[place]).abs() < CONVERGED) {
                break;
            }
        }
        let (fit, residual) = fit?;
        if residual > EXPLAINS {
            return None;
        }
        let covariance = fit.covariance;
        let (ohm, tau_s) = (values[0].exp(), values[1].exp());
        let moved = moved_v / last.effort_v;
        let error = |value: f64, variance: f64| 2.0 * value * variance.max(0.0).sqrt();
        let of_product = covariance[0][0] + covariance[1][1] + 2.0 * covariance[0][1];
        let inductance_h = if tau_s > least_s {
            let late = values[2] / last.effort_v * 0.5 * first.period_s / tau_s;
            let henry = ohm * tau_s;
            Estimate { value: henry, error: error(henry, of_product) + henry * late }
        } else {
            Estimate { value: 0.0, error: ohm * least_s }
        };
        Some(Self {
            resistance_ohm: Estimate {
                value: ohm,
                error: error(ohm, covariance[0][0]) + ohm * moved,
            },
            inductance_h,
            lost_v: Estimate { value: values[2], error: error(1.0, covariance[2][2]) + moved_v },
        })
    }
}

/// Largest residual, as a part of the currents, of a winding that explains them.
const EXPLAINS: f64 = 0.05;

/// Largest number of iterations, and step of each value below which they end.
const STEPS: usize = 50;
const CONVERGED: f64 = 1e-9;

/// Step of a value for its derivative: the root of the precision of a double, times ten.
const DERIVES: f64 = 1e-7;

/// Returns the fit of the model around these values: the step to the least squares.
fn linearised(measured: &[Readings], values: [f64; 3], columns: usize) -> Option<Fit> {
    let rows = || {
        measured.iter().flat_map(move |readings| {
            (0..GROUPS).map(move |group| {
                let at = readings.modelled(group, values);
                let mut row: RegressionRow = [0.0; MOST];
                for (column, place) in row.iter_mut().zip(0..columns) {
                    let mut moved = values;
                    moved[place] += DERIVES;
                    *column = (readings.modelled(group, moved) - at) / DERIVES;
                }
                (row, readings.currents_a[group] - at)
            })
        })
    };
    Fit::of(columns, rows).ok()
}

/// Result of a measurement of the winding.
#[derive(Clone, Debug, PartialEq)]
pub struct WindingResult {
    /// Winding.
    pub winding: Winding,
    /// Settled current of the larger voltage, A.
    pub current_a: f64,
    /// Larger voltage, V.
    pub effort_v: f64,
    /// Largest distance of the joint from its place, deg.
    pub moved_deg: f64,
    /// Configured resistance, ohm, and inductance, H; zero if unknown.
    pub configured: [f64; 2],
}

/// Measures the winding of a device's motor, with `effort_v` or 0.6 of the largest effort of a jog.
/// A device whose efforts are voltages works with a current loop meanwhile, and has its parameters
/// back afterwards.
///
/// # Errors
/// Returns why the device refuses, what has ended the measurement, or why its readings are not
/// enough.
pub fn measure<W: Wire>(
    client: &mut Client<W>,
    effort_v: Option<f32>,
) -> Result<WindingResult, Error> {
    let before = client.parameters()?;
    let regulated = with_current_loop(&before)?;
    let mut found = match &regulated {
        None => with_parameters(client, &before, effort_v),
        Some(regulated) => {
            let set = client.set_parameters(regulated);
            let found = set.and_then(|()| with_parameters(client, regulated, effort_v));
            restored(client, &before, found)
        }
    }?;
    let sensor = &before.current;
    found.configured = [single(sensor.resistance), single(sensor.inductance)];
    Ok(found)
}

/// Gives a device its parameters back, also after an error: the device may have taken the others
/// although its answer was lost. The output must be off for that.
fn restored<W: Wire, T>(
    client: &mut Client<W>,
    before: &Parameters,
    found: Result<T, Error>,
) -> Result<T, Error> {
    let mut restore = || client.stop().and_then(|()| client.set_parameters(before));
    let Err(failed) = restore().or_else(|_| restore()) else { return found };
    let why = found.err().map_or(String::new(), |why| format!("{why}; "));
    Err(Error::Device(format!(
        "{why}the device still has loop.effort = \"current\", with an inductance that was not \
         measured: do not save, push the machine's file again ({failed})"
    )))
}

/// Returns the parameters with a current loop, which makes the board work in each period of the
/// PWM; none if they have one. The loop never runs, so its inductance is any valid one.
fn with_current_loop(parameters: &Parameters) -> Result<Option<Parameters>, Error> {
    if !parameters.current.is_there() {
        return Err(Error::Refused(
            "winding: the device has no [current_sensor], so nothing measures the current".into(),
        ));
    }
    if parameters.controller.effort == EffortMode::Current {
        return Ok(None);
    }
    let mut regulated = parameters.clone();
    regulated.controller.effort = EffortMode::Current;
    let sensor = &mut regulated.current;
    if sensor.inductance <= 0.0 {
        sensor.inductance = 5e-4 * sensor.resistance;
    }
    sensor.bandwidth = sensor.bandwidth.min(0.05 * regulated.controller.drive.pwm_hz);
    Ok(Some(regulated))
}

fn with_parameters<W: Wire>(
    client: &mut Client<W>,
    parameters: &Parameters,
    effort_v: Option<f32>,
) -> Result<WindingResult, Error> {
    let most = parameters.jog.effort;
    let effort = effort_v.unwrap_or(OF_JOG * most);
    if !(effort > 0.0 && effort <= most) {
        return Err(Error::Input(format!(
            "winding --effort {}: must be a number above 0, up to the device's jog.effort_v, {} V",
            shown(single(effort)),
            shown(single(most))
        )));
    }
    let top = pwm_top(&STM32F405, parameters.controller.drive.pwm_hz)
        .map_err(|_| Error::Refused("winding: the PWM of the device has no period".into()))?;
    let period_s = 2.0 * f64::from(top) / f64::from(STM32F405.pwm_clock_hz);
    let cycles = |periods: u8| {
        let cycle_s = 2.0 * GROUPS as f64 * f64::from(periods) * period_s;
        let most = 0.8 * f64::from(parameters.jog.time) / cycle_s;
        (TIME_S / cycle_s).min(most).clamp(1.0, f64::from(MOST_CYCLES)) as u16
    };
    // A winding with a short shows it at a small voltage.
    for share in APPROACH {
        let asked = WindingRequest { effort: share * effort, periods: 1, cycles: SHORT_CYCLES };
        once(client, asked, period_s)?;
    }
    let mut periods = 1;
    loop {
        let asked = WindingRequest { effort, periods, cycles: cycles(periods) };
        let (found, trial) = once(client, asked, period_s)?;
        let (current_a, rises) = trial.settled();
        let least_a = LEAST_READINGS * f64::from(found.unit).abs();
        let is_large = current_a.abs() >= least_a;
        if is_large && rises < RISES {
            if current_a > 0.0 {
                break;
            }
            return Err(Error::Device(
                "winding: the current has the other sign than the voltage; set the other \
                 current_sensor.direction"
                    .into(),
            ));
        }
        if periods >= MOST_PERIODS {
            return Err(Error::Device(if is_large {
                "winding: the current still rises after 0.1 s; is that a motor?".into()
            } else {
                format!(
                    "winding: {} V cause a current of {} A; a measurement needs {} A. Allow a \
                     larger effort ([jog] effort_v), or check supply and wires",
                    rounded(trial.effort_v),
                    rounded(current_a),
                    rounded(least_a)
                )
            }));
        }
        periods *= 2;
    }
    let cycles = cycles(periods);
    let (mut measured, mut moved) = (Vec::new(), 0);
    for place in 0..VOLTAGES {
        let less = (1.0 - SMALLEST) * place as f32 / (VOLTAGES - 1) as f32;
        let asked = WindingRequest { effort: (1.0 - less) * effort, periods, cycles };
        let (found, readings) = once(client, asked, period_s)?;
        measured.push(readings);
        moved = moved.max(found.moved);
    }
    let moved_deg = f64::from(moved) * f64::from(parameters.controller.encoder.resolution);
    let half_s = measured[0].half_cycle_s();
    let moved_v = f64::from(parameters.limits.back_emf) * moved_deg / half_s;
    let winding = Winding::fit(&measured, moved_v).ok_or_else(|| {
        Error::Device(
            "winding: no winding explains the currents; does something else load the supply, or \
             does the joint move?"
                .into(),
        )
    })?;
    let (current_a, effort_v) = (measured[0].settled().0, measured[0].effort_v);
    Ok(WindingResult { winding, current_a, effort_v, moved_deg, configured: [0.0; 2] })
}

/// Runs one measurement to its end.
fn once<W: Wire>(
    client: &mut Client<W>,
    asked: WindingRequest,
    period_s: f64,
) -> Result<(WindingFindings, Readings), Error> {
    client.wait_at_rest()?;
    client.measure_winding(asked)?;
    // The device ends it by the time of a jog, at most a minute.
    let status = client.pass_armed(Duration::from_secs(61))?;
    let ended = |why: &str| Err(Error::Device(format!("winding: {why}")));
    match (status.state, client.winding()?) {
        (StateCode::Armed, _) => ended("the device did not end the measurement in time"),
        (_, None) => ended("a stop or a fault has ended the measurement (device faults)"),
        (_, Some(found)) => match found.ended {
            WindingEnd::Done => Ok((found, Readings::of(&found, &asked, period_s))),
            WindingEnd::Travel => ended(
                "the joint has moved by more than jog.travel_deg: less --effort, or hold the joint",
            ),
            WindingEnd::Time | WindingEnd::Not => ended("jog.time_s was over"),
            WindingEnd::Current => ended(
                "the current was beyond current_sensor.peak_a by a quarter: less --effort, or \
                 check the winding for a short",
            ),
        },
    }
}

impl WindingResult {
    /// Returns the result as text.
    pub fn words(&self) -> String {
        let Winding { resistance_ohm, inductance_h, lost_v } = self.winding;
        let [ohm, henry] = self.configured;
        let bar = |estimate: Estimate, factor: f64, unit: &str| {
            let Estimate { value, error } = estimate;
            // Two digits of the error bar.
            let error = format!("{:.1e}", factor * error).parse().unwrap_or(factor * error);
            format!("{} +- {} {unit}", rounded(factor * value), shown(error))
        };
        let against = |name: &str, configured: f64, measured: Estimate| match configured {
            known if known > 0.0 => {
                let percent = 100.0 * (measured.value / known - 1.0);
                format!("{name} = {}: measured {percent:+.1} %", rounded(known))
            }
            _ => format!("{name}: not set"),
        };
        let inductance = if inductance_h.value > 0.0 {
            let time_constant_ms = 1e3 * inductance_h.value / resistance_ohm.value;
            format!("{}, L / R {} ms", bar(inductance_h, 1e3, "mH"), rounded(time_constant_ms))
        } else {
            let (least_h, tau_s) = (inductance_h.error, inductance_h.error / resistance_ohm.value);
            let (least_mh, tau_ms) = (rounded(1e3 * least_h), rounded(1e3 * tau_s));
            format!("below {least_mh} mH, L / R below {tau_ms} ms")
        };
        format!(
            "resistance {}\ninductance {inductance}\nlost       {}, to dead time and \
             brushes\nconfigured {}\n           {}\ncurrent    {} A by {} V; the joint moved by {} \
             deg\n",
            bar(resistance_ohm, 1.0, "ohm"),
            bar(lost_v, 1.0, "V"),
            against("current_sensor.resistance_ohm", ohm, resistance_ohm),
            against("current_sensor.inductance_h", henry, inductance_h),
            rounded(self.current_a),
            rounded(self.effort_v),
            rounded(self.moved_deg),
        )
    }

    /// Returns the JSON object for scripts.
    pub fn json(&self, warning: Option<&str>) -> Value {
        let Winding { resistance_ohm, inductance_h, lost_v } = self.winding;
        let [ohm, henry] = self.configured;
        json!({
            "schema": 1,
            "warning": warning,
            "resistance_ohm": resistance_ohm.value,
            "resistance_error_ohm": resistance_ohm.error,
            "inductance_h": inductance_h.value,
            "inductance_error_h": inductance_h.error,
            "lost_v": lost_v.value,
            "lost_error_v": lost_v.error,
            "configured_resistance_ohm": (ohm > 0.0).then_some(ohm),
            "configured_inductance_h": (henry > 0.0).then_some(henry),
            "current_a": self.current_a,
            "effort_v": self.effort_v,
            "moved_deg": self.moved_deg,
        })
    }
}

#[cfg(test)]
mod tests;
