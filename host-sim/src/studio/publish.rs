//! Events on the device: its identity, its status, its faults.

use std::sync::atomic::Ordering;

use serde_json::{Value, json};
use stiction::control::signal::name;
use stiction::link::{DeviceKind, Sample, StateCode, Status};

use super::form;
use super::pending_gear::PendingGear;
use super::request::RequestedMotion;
use super::worker::Worker;
use files::error::Error;
use simulator::device::shown_current::ShownCurrent;
use simulator::device::signals::{OF_THE_LOOP, Signals};
use simulator::device::travel::Travel;
use simulator::device::wire::Wire;
use simulator::device::words;
use studies::{device_gear, selftest};

/// Bytes per second for samples on a wire of 921 600 baud; a quarter of its capacity is left for
/// answers.
const CARRIED: f64 = 0.75 * 92_160.0;

/// Bytes of a sample without its values: numbers, mask, length, checksum and stuffing.
const AROUND: usize = 30;

impl<W: Wire> Worker<'_, W> {
    pub(super) fn publish_status(&self, status: &Status) {
        let fault =
            (status.fault.code != 0).then(|| words::fault_json(&status.fault, status.sample_time));
        self.shared.news.publish(
            "status",
            json!({
                "state": words::state(status.state),
                "driven": status.state == StateCode::Armed,
                "clock": status.clock,
                "at_rest": status.at_rest,
                "since_power_on_counts": status.position,
                "unsaved": status.unsaved,
                "wound_up": status.wound_up,
                "gave_up": status.gave_up,
                "oscillates": status.oscillates,
                "referenced": status.is_referenced,
                "testing": status.is_testing,
                "gear": self.gear.as_ref().map(PendingGear::progress),
                "encoder_in_doubt": status.is_encoder_in_doubt,
                "guest": self.client.is_guest(),
                "heat_v": status.thermal_effort,
                "faults": status.faults,
                "fault": fault,
                "text": words::status(status),
                "lost": self.client.lost(),
                "link_timeout_s": self.link_timeout,
                "targets_deg": self.travel.and_then(|travel| travel.targets_deg()),
            }),
        );
    }

    pub(super) fn publish_faults(&mut self, status: &Status) -> Result<(), Error> {
        let faults = self.client.faults()?;
        let faults = faults.iter().map(|fault| words::fault_json(fault, status.sample_time));
        let faults: Vec<Value> = faults.collect();
        self.shared.news.publish("faults", json!({ "faults": faults }));
        Ok(())
    }

    /// Returns the signals to subscribe to as a mask, and the ticks from one sample to the next:
    /// those of the pages, or those of the moves for the gear if the wire cannot carry both.
    pub(super) fn wanted_subscription(&self) -> (u64, u16) {
        let (mask, every) = self.of_pages;
        match self.gear.as_ref().map(PendingGear::subscription) {
            Some((needed, fast)) if mask & needed != needed || every > fast => (needed, fast),
            _ => (mask, every),
        }
    }

    /// Requests identity, signals and parameters of the device, and publishes them.
    pub(super) fn publish_device(&mut self) -> Result<(), Error> {
        let status = self.client.status()?;
        let announced = self.client.signals()?;
        let signals = Signals::new(announced.clone());
        let law: Vec<String> = signals.of_law().map(str::to_owned).collect();
        // The signals of a self-test are included, so that its start needs no new `hello`.
        let named = OF_THE_LOOP.into_iter().chain(selftest::SIGNALS);
        let parameters = self.client.parameters().ok();
        let current = parameters.as_ref().and_then(ShownCurrent::of);
        let named = named.chain(current.map(|_| const { name("current") }));
        // As are those of the moves for the gear.
        let motor_count_deg = parameters.as_ref().and_then(|all| all.controller.motor.count());
        let of_gear = device_gear::SIGNALS.into_iter().filter(|_| motor_count_deg.is_some());
        let named = named.chain(of_gear);
        let mask = signals.mask(named.chain(law.iter().map(String::as_str)));
        let columns = mask.count_ones() as usize;
        let every = if self.about.every_tick {
            1
        } else {
            let took_s = (AROUND + 4 * columns) as f64 / CARRIED;
            (took_s / f64::from(status.sample_time).max(1e-6)).ceil().clamp(1.0, 1000.0) as u16
        };
        self.of_pages = (mask, every);
        let (mask, every) = self.wanted_subscription();
        self.travel = parameters.as_ref().map(Travel::new);
        self.link_timeout = parameters.as_ref().map_or(0.0, |all| all.limits.link_timeout);
        self.frame.flush(&self.shared.news);
        // Only the client that owns the session selects samples.
        if !self.client.is_guest() {
            self.client.subscribe(mask, every)?;
            self.subscribed = (mask, every);
        }
        self.signals = signals;
        self.frame.generation = self.shared.generation.fetch_add(1, Ordering::Relaxed) + 1;
        self.frame.places =
            (0..u64::BITS as usize).filter(|place| mask >> place & 1 == 1).collect();
        let shown = self.frame.places.iter().filter_map(|place| announced.get(*place));
        let columns: Vec<Value> = shown
            .map(|signal| {
                json!({
                    "name": signal.name.as_str(),
                    "unit": signal.unit.as_str(),
                    "form": format!("{:?}", signal.form).to_lowercase(),
                })
            })
            .collect();
        let warning = self.client.warning();
        let identity = self.client.identity();
        let kind = match identity.map(|identity| identity.kind) {
            Some(DeviceKind::Simulated) => "simulated",
            _ if warning.is_some() => "emulated",
            _ => "board",
        };
        let version = identity.map_or(String::new(), |identity| identity.version.as_str().into());
        self.shared.news.publish(
            "hello",
            json!({
                "generation": self.frame.generation,
                "device": self.client.wire().name(),
                "firmware": version,
                "program": env!("CARGO_PKG_VERSION"),
                "kind": kind,
                "warning": warning,
                "sample_time_s": files::written::single(status.sample_time),
                "resolution_deg": files::written::single(status.resolution),
                "motor_resolution_deg": motor_count_deg.map(files::written::single),
                "every": every,
                "signals": columns,
                "law": law,
                "target_a_per_v": current.and_then(|current| current.target_a_per_v),
            }),
        );
        self.shared.set_in_use(parameters.clone());
        if let Some(parameters) = parameters {
            let rows = form::rows(&parameters, self.saved.as_ref())?;
            // A file that cannot be written cannot be pulled either.
            let file = form::file(&parameters, &self.about.machine, warning).ok();
            self.shared.news.publish(
                "parameters",
                json!({ "rows": rows, "file": file, "undo": self.before.len() }),
            );
        }
        Ok(())
    }

    /// Publishes a move that has just started, with the clock and the set point of the last sample
    /// before the request, so that a page can draw a prediction beside it. The joint starts after
    /// that sample, even if the answer is late.
    pub(super) fn publish_motion(&self, way: &RequestedMotion) {
        let reference = |sample: &Sample| {
            let whole = self.signals.number(sample, const { name("reference_counts") });
            whole + self.signals.number(sample, const { name("reference_fraction") })
        };
        let clock = self.last.as_ref().map_or(0, |sample| sample.clock);
        let armed = self.last.as_ref().filter(|sample| self.signals.is_armed(sample));
        self.shared.news.publish(
            "motion",
            json!({ "way": way, "clock": clock, "from_counts": armed.map_or(0.0, reference) }),
        );
    }
}
