//! Refuses effects of a data sheet that cannot be simulated.

use super::refusal::SheetRefusal;
use super::sheet::DataSheet;

/// Relative tolerance for equal differences of two friction levels.
const SAME: f64 = 1e-9;

impl DataSheet {
    /// Checks that a plant of the simulator has all effects of the data sheet.
    ///
    /// # Errors
    /// Returns an error with the key, the value found and the allowed values.
    pub fn can_be_simulated(&self) -> Result<(), SheetRefusal> {
        let friction = &self.friction;
        if self.bristle_stiffness().is_some() {
            let key = "friction.bristle_stiffness_nm_per_rad";
            let other = [
                ("gear.stiffness_nm_per_rad", self.stiffness().is_some()),
                ("friction.ripple", friction.ripple > 0.0),
            ];
            if let Some((other, _)) = other.iter().find(|(_, there)| *there) {
                let sentence = format!(
                    "`{key}` and `{other}` cannot be simulated together; remove one of them"
                );
                return Err(SheetRefusal::of(key, sentence));
            }
            if self.slip()[0].min(self.slip()[1]) == 0.0 {
                let why = "a number above 0, since a bristle needs it";
                return Err(SheetRefusal::number("friction.slip_nm", 0.0, why));
            }
            let key = "friction.stribeck_rad_per_s";
            match self.stribeck() {
                Some(speed) if speed > 0.0 => {}
                Some(speed) => {
                    let why = "a number above 0: the friction of bristles cannot fall at once";
                    return Err(SheetRefusal::number(key, speed, why));
                }
                None => {
                    let why = "bristles need it: their friction cannot fall at once";
                    return Err(SheetRefusal::missing(key, why));
                }
            }
        }
        let differ = |[forward, backward]: [f64; 2]| forward - backward;
        let [stick, slip] = [differ(self.stick()), differ(self.slip())];
        if (stick - slip).abs() > SAME * self.stick()[0].max(self.stick()[1]) {
            let key = "friction.stick_reverse_nm";
            let allowed = "`stick_nm` - `slip_nm` + `slip_reverse_nm`; other values cannot be \
                           simulated";
            return Err(SheetRefusal::number(key, self.stick()[1], allowed));
        }
        Ok(())
    }
}
