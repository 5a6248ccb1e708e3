//! What of a data sheet cannot be simulated yet: refused, never ignored.

use super::refusal::Refusal;
use super::sheet::DataSheet;

impl DataSheet {
    /// Refuses what no plant of the simulator has.
    ///
    /// # Errors
    /// Names the key and what it would need.
    pub fn can_be_simulated(&self) -> Result<(), Refusal> {
        let friction = &self.friction;
        let supply = self.supply.as_ref();
        let ways = |[one, other]: [f64; 2]| one == other;
        let asked = [
            ("gear.stiffness_nm_per_rad", self.stiffness().is_some(), "an elastic gear"),
            ("load.constant_nm", self.load.constant_nm != 0.0, "a constant load"),
            ("load.unbalance_nm", self.load.unbalance_nm != 0.0, "gravity"),
            (
                "friction.stick_reverse_nm",
                !ways(self.stick()) || !ways(self.slip()),
                "friction that differs between the two ways",
            ),
            (
                "friction.stribeck_rad_per_s",
                self.stribeck().is_some_and(|speed| speed > 0.0),
                "a Stribeck velocity",
            ),
            (
                "friction.bristle_stiffness_nm_per_rad",
                self.bristle_stiffness().is_some(),
                "a bristle",
            ),
            ("friction.ripple", friction.ripple > 0.0, "friction that varies with the angle"),
            (
                "supply.internal_resistance_ohm",
                supply.is_some_and(|supply| supply.internal_resistance_ohm > 0.0),
                "a supply that gives way",
            ),
            (
                "supply.takes_current_back",
                supply.is_some_and(|supply| !supply.takes_current_back),
                "a supply that takes no current back",
            ),
            ("motor.dead_time_s", self.motor.dead_time_s > 0.0, "a bridge with a dead time"),
            ("encoder.noise_counts", self.encoder.noise_counts > 0, "a noisy encoder"),
        ];
        match asked.into_iter().find(|(_, is_asked, _)| *is_asked) {
            None => Ok(()),
            Some((key, _, what)) => Err(Refusal::of(
                key,
                format!("`{key}` asks for {what}, which cannot be simulated yet; leave it out"),
            )),
        }
    }
}
