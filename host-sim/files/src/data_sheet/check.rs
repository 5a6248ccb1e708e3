//! Checks the range of each key of a data sheet.

use super::refusal::SheetRefusal;
use super::sheet::DataSheet;
use super::tables::{DrivenBy, EncoderPlace, LoadEncoderKind, LoadEncoderOutput};
use crate::error::shown;

/// Range of a number.
#[derive(Clone, Copy)]
enum May {
    Positive,
    Negative,
    NotNegative,
    Finite,
}

impl May {
    fn check(self, key: &str, found: f64) -> Result<(), SheetRefusal> {
        let (is_allowed, what) = match self {
            Self::Positive => (found > 0.0, "a finite number above 0"),
            Self::Negative => (found < 0.0, "a finite number below 0"),
            Self::NotNegative => (found >= 0.0, "a finite number not below 0"),
            Self::Finite => (true, "a finite number"),
        };
        if is_allowed && found.is_finite() {
            return Ok(());
        }
        Err(SheetRefusal::number(key, found, what))
    }
}

/// Fewest and most counts of a load's encoder in a turn. With fewer, a step of a degree is below a
/// count; the most is 2^26, the finest encoders that are sold.
const MIN_COUNTS: u32 = 360;
const MAX_COUNTS: u32 = 1 << 26;
/// Least time constant of the heat, s: the simulator computes temperatures once a sample.
const MIN_HEAT_S: f64 = 0.1;
/// Counts of an AS5047P in a turn: 14 bits.
const AS5047P_COUNTS: u32 = 1 << 14;

impl DataSheet {
    /// Checks the range of every key, and that keys that need each other are present.
    pub(super) fn check(&self) -> Result<(), SheetRefusal> {
        if let Some([one, other]) = self.doubled() {
            let sentence = format!("`{one}` and `{other}` are the same quantity; set only one");
            return Err(SheetRefusal::of(other, sentence));
        }
        self.check_numbers()?;
        self.check_motor()?;
        self.check_heat()?;
        self.check_gear()?;
        self.check_friction()?;
        self.check_encoder()
    }

    fn check_numbers(&self) -> Result<(), SheetRefusal> {
        use May::{Finite, Negative, NotNegative, Positive};
        let (motor, gear, load, friction) = (&self.motor, &self.gear, &self.load, &self.friction);
        let supply = self.supply.as_ref();
        let all = [
            ("motor.kt_nm_per_a", Some(motor.kt_nm_per_a), Positive),
            ("motor.resistance_ohm", motor.resistance_ohm, Positive),
            ("motor.inductance_h", Some(motor.inductance_h), NotNegative),
            ("motor.rotor_inertia_kg_m2", Some(motor.rotor_inertia_kg_m2), NotNegative),
            ("motor.current_limit_a", motor.current_limit_a, Positive),
            ("motor.rated_current_a", motor.rated_current_a, Positive),
            ("motor.amplifier_a_per_v", motor.amplifier_a_per_v, Positive),
            (
                "motor.thermal_resistance_winding_k_per_w",
                motor.thermal_resistance_winding_k_per_w,
                Positive,
            ),
            (
                "motor.thermal_resistance_case_k_per_w",
                motor.thermal_resistance_case_k_per_w,
                Positive,
            ),
            ("motor.no_load_rpm", motor.no_load_rpm, Positive),
            ("motor.no_load_rad_per_s", motor.no_load_rad_per_s, Positive),
            ("gear.ratio", Some(gear.ratio), Positive),
            ("gear.backlash_deg", gear.backlash_deg, NotNegative),
            ("gear.backlash_rad", gear.backlash_rad, NotNegative),
            ("gear.stiffness_nm_per_rad", gear.stiffness_nm_per_rad, Positive),
            ("gear.stiffness_nm_per_deg", gear.stiffness_nm_per_deg, Positive),
            ("gear.damping_nm_s_per_rad", gear.damping_nm_s_per_rad, NotNegative),
            ("gear.damping_nm_s_per_deg", gear.damping_nm_s_per_deg, NotNegative),
            ("load.inertia_kg_m2", Some(load.inertia_kg_m2), NotNegative),
            ("load.constant_nm", Some(load.constant_nm), Finite),
            ("load.unbalance_nm", Some(load.unbalance_nm), NotNegative),
            ("load.hangs_at_deg", load.hangs_at_deg, Finite),
            ("load.hangs_at_rad", load.hangs_at_rad, Finite),
            ("load.stop_min_deg", load.stop_min_deg, Negative),
            ("load.stop_max_deg", load.stop_max_deg, Positive),
            ("load.home_switch_deg", load.home_switch_deg, Finite),
            ("load.home_switch_hysteresis_deg", load.home_switch_hysteresis_deg, NotNegative),
            ("load.home_switch_bounce_s", load.home_switch_bounce_s, NotNegative),
            ("friction.slip_nm", Some(friction.slip_nm), NotNegative),
            ("friction.slip_reverse_nm", friction.slip_reverse_nm, NotNegative),
            ("friction.stribeck_deg_per_s", friction.stribeck_deg_per_s, NotNegative),
            ("friction.stribeck_rad_per_s", friction.stribeck_rad_per_s, NotNegative),
            ("friction.viscous_nm_s_per_rad", friction.viscous_nm_s_per_rad, NotNegative),
            ("friction.viscous_nm_s_per_deg", friction.viscous_nm_s_per_deg, NotNegative),
            (
                "friction.bristle_stiffness_nm_per_rad",
                friction.bristle_stiffness_nm_per_rad,
                Positive,
            ),
            (
                "friction.bristle_stiffness_nm_per_deg",
                friction.bristle_stiffness_nm_per_deg,
                Positive,
            ),
            (
                "friction.bristle_damping_nm_s_per_rad",
                friction.bristle_damping_nm_s_per_rad,
                NotNegative,
            ),
            (
                "friction.bristle_damping_nm_s_per_deg",
                friction.bristle_damping_nm_s_per_deg,
                NotNegative,
            ),
            ("friction.ripple_per_turn", friction.ripple_per_turn, Positive),
            ("friction.ripple_phase_deg", Some(friction.ripple_phase_deg), Finite),
            ("supply.voltage_v", supply.map(|supply| supply.voltage_v), Positive),
            (
                "supply.internal_resistance_ohm",
                supply.map(|supply| supply.internal_resistance_ohm),
                NotNegative,
            ),
            ("supply.capacitance_f", supply.map(|supply| supply.capacitance_f), NotNegative),
        ];
        all.iter().try_for_each(|(key, found, may)| match found {
            Some(found) => may.check(key, *found),
            None => Ok(()),
        })
    }

    fn check_motor(&self) -> Result<(), SheetRefusal> {
        let motor = &self.motor;
        match motor.driven_by {
            DrivenBy::Voltage if motor.resistance_ohm.is_none() => {
                let why = "a motor driven by a voltage needs it";
                return Err(SheetRefusal::missing("motor.resistance_ohm", why));
            }
            DrivenBy::Current if motor.amplifier_a_per_v.is_none() => {
                let why = "a motor driven by a current needs it";
                return Err(SheetRefusal::missing("motor.amplifier_a_per_v", why));
            }
            DrivenBy::Voltage if motor.amplifier_a_per_v.is_some() => {
                let key = "motor.amplifier_a_per_v";
                let sentence = format!(
                    "`{key}` belongs to a motor driven by a current, but `motor.driven_by` is \
                     \"voltage\""
                );
                return Err(SheetRefusal::of(key, sentence));
            }
            _ => {}
        }
        self.check_supply()?;
        let dead_time = motor.dead_time_s;
        if !(0.0..=1e-3).contains(&dead_time) {
            return Err(SheetRefusal::number(
                "motor.dead_time_s",
                dead_time,
                "a number from 0 to 0.001",
            ));
        }
        if dead_time > 0.0 && motor.driven_by == DrivenBy::Current {
            let why = "0: an amplifier that sets the current compensates it";
            return Err(SheetRefusal::number("motor.dead_time_s", dead_time, why));
        }
        Ok(())
    }

    /// Checks the heat path of the winding: all of its keys are there, or none.
    fn check_heat(&self) -> Result<(), SheetRefusal> {
        let motor = &self.motor;
        let path = [
            ("motor.thermal_resistance_winding_k_per_w", motor.thermal_resistance_winding_k_per_w),
            ("motor.thermal_resistance_case_k_per_w", motor.thermal_resistance_case_k_per_w),
            ("motor.thermal_time_winding_s", motor.thermal_time_winding_s),
            ("motor.thermal_time_motor_s", motor.thermal_time_motor_s),
        ];
        let all = path.iter().copied().chain([("motor.ambient_c", motor.ambient_c)]);
        let Some((first, _)) = all.clone().find(|(_, found)| found.is_some()) else {
            return Ok(());
        };
        if motor.driven_by == DrivenBy::Current {
            let sentence = format!(
                "`{first}` belongs to a motor driven by a voltage, but `motor.driven_by` is \
                 \"current\": an amplifier compensates a hot winding"
            );
            return Err(SheetRefusal::of(first, sentence));
        }
        if let Some((key, _)) = path.iter().find(|(_, found)| found.is_none()) {
            let why = "a winding that heats up needs all four thermal keys";
            return Err(SheetRefusal::missing(key, why));
        }
        for (key, found) in path.iter().skip(2) {
            if let Some(found) = found.filter(|found| !(MIN_HEAT_S..=1e6).contains(found)) {
                return Err(SheetRefusal::number(key, found, "a number from 0.1 to 1000000"));
            }
        }
        match motor.ambient_c {
            Some(found) if !(-60.0..=150.0).contains(&found) => {
                Err(SheetRefusal::number("motor.ambient_c", found, "a number from -60 to 150"))
            }
            _ => Ok(()),
        }
    }

    /// Checks the supply. With an amplifier, the supply limits the current, so the motor's
    /// resistance is needed.
    fn check_supply(&self) -> Result<(), SheetRefusal> {
        let motor = &self.motor;
        let Some(supply) = &self.supply else {
            return match self.no_load() {
                None => Ok(()),
                Some(_) => Err(SheetRefusal::missing(
                    "supply.voltage_v",
                    "the motor's speed without load refers to this voltage",
                )),
            };
        };
        if motor.driven_by == DrivenBy::Voltage {
            return Ok(());
        }
        if motor.resistance_ohm.is_none() {
            let why = "it limits the current of an amplifier on a `[supply]`";
            return Err(SheetRefusal::missing("motor.resistance_ohm", why));
        }
        let resistance = supply.internal_resistance_ohm;
        if resistance > 0.0 {
            let allowed = "0: with `motor.driven_by` = \"current\", it cannot be simulated";
            let key = "supply.internal_resistance_ohm";
            return Err(SheetRefusal::number(key, resistance, allowed));
        }
        if !supply.takes_current_back {
            let key = "supply.takes_current_back";
            let sentence = format!(
                "`{key}` is false; must be true: with `motor.driven_by` = \"current\", false \
                 cannot be simulated"
            );
            return Err(SheetRefusal::of(key, sentence));
        }
        Ok(())
    }

    fn check_gear(&self) -> Result<(), SheetRefusal> {
        let gear = &self.gear;
        if !(gear.efficiency > 0.0 && gear.efficiency <= 1.0) {
            let allowed = "a number above 0, up to 1";
            return Err(SheetRefusal::number("gear.efficiency", gear.efficiency, allowed));
        }
        if self.stiffness().is_none() {
            let needs = "a gear with backlash or damping needs its stiffness";
            if self.backlash().is_some_and(|backlash| backlash > 0.0) || self.damping().is_some() {
                return Err(SheetRefusal::missing("gear.stiffness_nm_per_rad", needs));
            }
        } else if self.motor.rotor_inertia_kg_m2 == 0.0 || self.load.inertia_kg_m2 == 0.0 {
            let key = ["motor.rotor_inertia_kg_m2", "load.inertia_kg_m2"]
                [usize::from(self.motor.rotor_inertia_kg_m2 > 0.0)];
            let why = "a number above 0, since an elastic gear needs an inertia on both sides";
            return Err(SheetRefusal::number(key, 0.0, why));
        }
        if self.motor.rotor_inertia_kg_m2 + self.load.inertia_kg_m2 == 0.0 {
            let why = "a number above 0, since the rotor's inertia is 0 as well";
            return Err(SheetRefusal::number("load.inertia_kg_m2", 0.0, why));
        }
        Ok(())
    }

    fn check_friction(&self) -> Result<(), SheetRefusal> {
        let friction = &self.friction;
        for (key, of_slip, stick, slip) in [
            ("friction.stick_nm", "slip_nm", self.stick()[0], self.slip()[0]),
            ("friction.stick_reverse_nm", "slip_reverse_nm", self.stick()[1], self.slip()[1]),
        ] {
            if !(stick >= slip && stick.is_finite()) {
                let allowed = format!("a finite number not below `{of_slip}` ({})", shown(slip));
                return Err(SheetRefusal::number(key, stick, &allowed));
            }
        }
        if self.bristle_stiffness().is_none() && self.bristle_damping().is_some() {
            let why = "bristles with damping need it";
            return Err(SheetRefusal::missing("friction.bristle_stiffness_nm_per_rad", why));
        }
        if !(0.0..1.0).contains(&friction.ripple) {
            let allowed = "a number from 0 to below 1";
            return Err(SheetRefusal::number("friction.ripple", friction.ripple, allowed));
        }
        if friction.ripple > 0.0 && friction.ripple_per_turn.is_none() {
            let why = "friction that varies with the gear's angle needs it";
            return Err(SheetRefusal::missing("friction.ripple_per_turn", why));
        }
        match friction.motor_share {
            Some(share) if !(0.0..=1.0).contains(&share) => {
                Err(SheetRefusal::number("friction.motor_share", share, "a number from 0 to 1"))
            }
            Some(share) if self.stiffness().is_none() => {
                let allowed = "left out: the gear has no stiffness, so the joint is one body";
                Err(SheetRefusal::number("friction.motor_share", share, allowed))
            }
            _ => Ok(()),
        }
    }

    fn check_encoder(&self) -> Result<(), SheetRefusal> {
        let encoder = &self.encoder;
        match encoder.lines {
            Some(0) => Err(SheetRefusal::number("encoder.lines", 0.0, "a whole number above 0")),
            Some(_) if encoder.at.is_none() => Err(SheetRefusal::missing(
                "encoder.at",
                "`encoder.lines` needs the place of the disc, \"motor\" or \"load\"",
            )),
            _ if encoder.noise_counts > 1 => Err(SheetRefusal::number(
                "encoder.noise_counts",
                encoder.noise_counts.into(),
                "0 or 1",
            )),
            _ => self.check_load_encoder(),
        }
    }

    fn check_load_encoder(&self) -> Result<(), SheetRefusal> {
        let Some(load) = &self.load_encoder else {
            return match self.sampling.position {
                None => Ok(()),
                Some(_) => Err(SheetRefusal::of(
                    "loop.position",
                    "`loop.position` chooses one of two encoders, but the table `[load_encoder]` \
                     is missing"
                        .into(),
                )),
            };
        };
        if self.encoder.at != Some(EncoderPlace::Motor) {
            let why = "must be \"motor\", since the file has a `[load_encoder]`";
            return Err(SheetRefusal::of(
                "encoder.at",
                match self.encoder.at {
                    Some(_) => format!("`encoder.at` is \"load\"; {why}"),
                    None => format!("`encoder.at` is missing; {why}"),
                },
            ));
        }
        if !(MIN_COUNTS..=MAX_COUNTS).contains(&load.counts_per_turn) {
            let allowed = format!("a whole number from {MIN_COUNTS} to {MAX_COUNTS}");
            let found = load.counts_per_turn.into();
            return Err(SheetRefusal::number("load_encoder.counts_per_turn", found, &allowed));
        }
        if load.noise_counts > 1 {
            let found = load.noise_counts.into();
            return Err(SheetRefusal::number("load_encoder.noise_counts", found, "0 or 1"));
        }
        let is_absolute = load.kind == LoadEncoderKind::As5047p;
        if is_absolute && load.counts_per_turn != AS5047P_COUNTS {
            let found = load.counts_per_turn.into();
            let allowed = "16384, since `load_encoder.kind` is \"as5047p\"";
            return Err(SheetRefusal::number("load_encoder.counts_per_turn", found, allowed));
        }
        if is_absolute && load.output != LoadEncoderOutput::Unknown {
            return Err(SheetRefusal::of(
                "load_encoder.output",
                "`load_encoder.output` belongs to an incremental encoder, whose lines are tested \
                 at rest. An \"as5047p\" reports its own faults: remove the line"
                    .into(),
            ));
        }
        let key = "load_encoder.zero_counts";
        match load.zero_counts {
            None if is_absolute => Err(SheetRefusal::of(
                key,
                format!("`{key}` is missing: the reading of the chip where the joint is at zero"),
            )),
            Some(_) if !is_absolute => {
                Err(SheetRefusal::of(key, format!("`{key}` belongs to `kind = \"as5047p\"`")))
            }
            Some(zero) if zero >= AS5047P_COUNTS => {
                Err(SheetRefusal::number(key, zero.into(), "a whole number from 0 to 16383"))
            }
            _ => Ok(()),
        }
    }
}
