//! Range of targets of a typed move.
//!
//! With `limits.position_min_deg` and `limits.position_max_deg` the device itself refuses targets
//! outside of them. The hosts check a target first, so that the message has the range in the
//! coordinates in which targets are typed: from the zero of the arming. Without these limits the
//! device accepts 2^30 counts, which is thousands of turns. A host then refuses more than one turn:
//! few joints turn further, and a target beyond one turn is more often a typing error.

use stiction::Parameters;
use stiction::link::{StateCode, Status};

use super::client::position_of;
use files::error::{Error, shown};

/// Largest target without limits of travel, deg from the zero of the arming.
pub const ONE_TURN_DEG: f64 = 360.0;

/// Largest age of a sample that shows the same position as a status at rest, s. The device reports
/// rest after 50 ms without a count.
const SAME_POSITION_S: f64 = 0.05;

/// Range of targets: the limits of travel, and the zero of the arming if it is known.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Travel {
    /// Lowest and highest position, counts from the reference; `None` without limits.
    limits: Option<[i32; 2]>,
    resolution_deg: f64,
    /// Position of the zero of the arming, counts from the reference; `None` if it is unknown.
    zero: Option<i32>,
}

impl Travel {
    /// Creates the range from the limits of these parameters; the zero of the arming is still
    /// unknown.
    pub fn new(parameters: &Parameters) -> Self {
        let (min, max) = (parameters.limits.position_min, parameters.limits.position_max);
        let resolution = parameters.controller.encoder.resolution;
        // As the device rounds them.
        let counts = |deg: f32| (deg / resolution).round() as i32;
        let is_limited = min != 0.0 || max != 0.0;
        Self {
            limits: is_limited.then(|| [counts(min), counts(max)]),
            resolution_deg: resolution.into(),
            zero: None,
        }
    }

    /// Updates the zero of the arming from a status and the newest sample of the closed loop: its
    /// age (s) and its position in counts from that zero.
    pub fn follow(&mut self, status: &Status, sample: Option<(f64, i32)>) {
        if status.state != StateCode::Armed {
            self.zero = None;
        } else if let Some((age_s, counts)) = sample
            && status.at_rest
            && age_s.abs() <= SAME_POSITION_S
        {
            self.zero = Some(status.position.wrapping_sub(counts));
        }
    }

    /// Returns whether the device has limits of travel.
    pub const fn is_limited(&self) -> bool {
        self.limits.is_some()
    }

    /// Returns the lowest and the highest target, deg from the zero of the arming. `None` if the
    /// device has limits of travel and that zero is unknown.
    pub fn targets_deg(&self) -> Option<[f64; 2]> {
        let Some(limits) = self.limits else { return Some([-ONE_TURN_DEG, ONE_TURN_DEG]) };
        let zero = self.zero?;
        let deg = |counts: i32| {
            let exact = f64::from(counts.saturating_sub(zero)) * self.resolution_deg;
            (exact * 1e4).round() / 1e4
        };
        Some(limits.map(deg))
    }

    /// Checks a typed target, deg from the zero of the arming. While that zero is unknown, the
    /// device checks the limits of travel. `what` is the motion, for the message.
    ///
    /// # Errors
    /// Returns an error that names the range of targets.
    pub fn check(&self, what: &str, deg: f64) -> Result<(), Error> {
        let position = position_of(deg, self.resolution_deg);
        let is_inside = match (self.limits, self.zero) {
            (None, _) => deg.abs() <= ONE_TURN_DEG,
            (Some([lowest, highest]), Some(zero)) => {
                position.is_ok_and(|to| (lowest..=highest).contains(&zero.wrapping_add(to.counts)))
            }
            (Some(_), None) => return position.map(|_| ()),
        };
        let Some([lowest, highest]) = self.targets_deg().filter(|_| !is_inside) else {
            return Ok(());
        };
        let range = format!("{} to {} deg", shown(lowest), shown(highest));
        let why = if self.limits.is_some() {
            format!(
                "it must be {range} from the zero of the arming (`limits.position_min_deg`, \
                 `limits.position_max_deg`)"
            )
        } else {
            format!(
                "it must be {range} while the device has no limits of travel; set \
                 `limits.position_min_deg` and `limits.position_max_deg` to go further"
            )
        };
        Err(Error::Refused(format!("{what} {}: the target is rejected: {why}", shown(deg))))
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;
    use crate::device::client::Client;
    use crate::device::simulated::SimulatedDevice;
    use crate::device::wire::SimulatedWire;
    use crate::experiment::{Document, Experiment};

    /// A device with these lines under `[limits]`, whose joint was pushed before it was armed.
    fn armed(limits: &str, pushed_deg: f64) -> (Client<SimulatedWire>, Travel) {
        let joint = crate::experiment::find("step-response").unwrap().toml;
        let text = format!("{joint}\n[limits]\n{limits}\n");
        let document = Document::parse("joint.toml", &text).unwrap();
        let plan = Experiment::plan(&document, &["srnf".into()], &[]).unwrap().runs.remove(0);
        let mut simulated = SimulatedDevice::new(&plan).unwrap();
        simulated.tick();
        simulated.push(pushed_deg, 0.0);
        let mut client = Client::connect(SimulatedWire::new(simulated)).unwrap();
        client.arm().unwrap();
        let mut travel = Travel::new(&client.parameters().unwrap());
        let status = client.status().unwrap();
        assert!(status.at_rest);
        travel.follow(&status, Some((0.0, 0)));
        (client, travel)
    }

    /// One count decides, on the host and on the device.
    #[test]
    fn a_host_refuses_what_the_device_would_refuse_and_names_the_range_from_the_arming() {
        for (pushed, end, count, is_out) in [
            (15.0, 20.0, 2, true),
            (15.0, 20.0, -2, false),
            (-4.0, -10.0, -2, true),
            (-4.0, -10.0, 2, false),
        ] {
            let (mut client, travel) =
                armed("position_min_deg = -10.0\nposition_max_deg = 20.0", pushed);
            let status = client.status().unwrap();
            let resolution_deg = f64::from(status.resolution);
            let here_deg = f64::from(status.position) * resolution_deg;
            let deg = end - here_deg + f64::from(count) * resolution_deg;
            assert_eq!(travel.check("move", deg).is_err(), is_out, "{pushed} {end} {count}");
            assert_eq!(client.move_to(deg).is_err(), is_out, "{pushed} {end} {count}");
            let [lowest, highest] = travel.targets_deg().unwrap();
            assert!((lowest - (-10.0 - here_deg)).abs() <= resolution_deg, "{lowest}");
            assert!((highest - (20.0 - here_deg)).abs() <= resolution_deg, "{highest}");
            let range = format!("{} to {} deg from the zero", shown(lowest), shown(highest));
            for far in [99999.0, 1e9] {
                let said = travel.check("move", far).unwrap_err().to_string();
                assert!(said.contains(&range), "{said}");
            }
        }
    }

    #[test]
    fn without_limits_of_travel_a_target_beyond_one_turn_is_refused() {
        let (mut client, travel) = armed("", 0.0);
        for (deg, is_out) in [(360.0, false), (-360.0, false), (360.1, true), (-99999.0, true)] {
            assert_eq!(travel.check("move", deg).is_err(), is_out, "{deg}");
        }
        let said = travel.check("move", 99999.0).unwrap_err().to_string();
        assert!(said.contains("-360 to 360 deg"), "{said}");
        assert!(said.contains("`limits.position_max_deg` to go further"), "{said}");
        // A target beyond every counter of the device is refused as well.
        let said = travel.check("trajectory to", 1e300).unwrap_err().to_string();
        let begin = "trajectory to 1e300: the target is rejected: it must be -360 to 360 deg";
        assert!(said.contains(begin), "{said}");
        // The device itself has no such bound.
        assert!(client.move_to(400.0).is_ok());
    }

    #[test]
    fn the_zero_of_an_arming_is_not_taken_over_into_the_next() {
        let (mut client, mut travel) =
            armed("position_min_deg = -10.0\nposition_max_deg = 20.0", 5.0);
        client.stop().unwrap();
        travel.follow(&client.status().unwrap(), None);
        assert_eq!(travel.targets_deg(), None);
        // The device decides then.
        assert!(travel.check("move", 99.0).is_ok());
        assert!(travel.check("move", 1e300).unwrap_err().to_string().contains("2^30 counts"));
        client.pass(std::time::Duration::from_millis(200)).unwrap();
        client.arm().unwrap();
        let status = client.status().unwrap();
        travel.follow(&status, Some((0.2, 0)));
        assert_eq!(travel.targets_deg(), None, "a sample of the arming before");
    }
}
