//! A whole data sheet: its tables, with every angle in radians.

use serde::Deserialize;

use super::refusal::SheetRefusal;
use super::tables::{
    DrivenBy, EncoderPlace, Gear, JointFriction, LoadEncoder, LoadTable, Motor, SupplyTable,
};

/// Keys of `[encoder]` that only the simulator has.
#[derive(Clone, Debug, Default, PartialEq, Deserialize)]
pub struct Mount {
    /// Lines of the disc.
    pub lines: Option<u32>,
    /// Place of the disc.
    pub at: Option<EncoderPlace>,
    /// Noise of a reading, counts.
    #[serde(default)]
    pub noise_counts: u32,
}

/// Key of `[loop]` that belongs to a joint with two encoders.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
pub struct LoopSide {
    /// Side of the gear whose encoder closes the position loop.
    pub position: Option<EncoderPlace>,
}

/// Tables of a data sheet in a file; other tables are ignored.
#[derive(Clone, Debug, PartialEq, Deserialize)]
pub struct SheetTables {
    /// `[motor]`.
    pub motor: Option<Motor>,
    /// `[gear]`.
    pub gear: Option<Gear>,
    /// `[load]`.
    pub load: Option<LoadTable>,
    /// `[friction]`.
    pub friction: Option<JointFriction>,
    /// `[supply]`.
    pub supply: Option<SupplyTable>,
    /// Simulator's keys of `[encoder]`.
    #[serde(default)]
    pub encoder: Mount,
    /// `[load_encoder]`.
    pub load_encoder: Option<LoadEncoder>,
    /// Simulator's key of `[loop]`.
    #[serde(rename = "loop", default)]
    pub sampling: LoopSide,
}

/// A data sheet in SI, checked.
#[derive(Clone, Debug, PartialEq)]
pub struct DataSheet {
    /// `[motor]`.
    pub motor: Motor,
    /// `[gear]`.
    pub gear: Gear,
    /// `[load]`.
    pub load: LoadTable,
    /// `[friction]`.
    pub friction: JointFriction,
    /// `[supply]`.
    pub supply: Option<SupplyTable>,
    /// Simulator's keys of `[encoder]`.
    pub encoder: Mount,
    /// `[load_encoder]`.
    pub load_encoder: Option<LoadEncoder>,
    /// Simulator's key of `[loop]`.
    pub sampling: LoopSide,
}

impl SheetTables {
    /// Returns the checked data sheet; `None` if the file has none of its tables.
    ///
    /// # Errors
    /// Returns an error with the missing table, or with the key, the value found and the allowed
    /// values.
    pub fn sheet(self) -> Result<Option<DataSheet>, SheetRefusal> {
        let Self { motor, gear, load, friction, supply, encoder, load_encoder, sampling } = self;
        let others = [
            ("gear", gear.is_some()),
            ("load", load.is_some()),
            ("friction", friction.is_some()),
            ("supply", supply.is_some()),
        ];
        let first = others.iter().find(|(_, there)| *there);
        let Some(motor) = motor else {
            let of_encoder = [
                ("encoder.lines", encoder.lines.is_some()),
                ("encoder.at", encoder.at.is_some()),
                ("encoder.noise_counts", encoder.noise_counts > 0),
                ("load_encoder", load_encoder.is_some()),
                ("loop.position", sampling.position.is_some()),
            ];
            let stray = of_encoder.iter().find(|(_, there)| *there);
            return match first {
                None if stray.is_none() => Ok(None),
                None => {
                    let key = stray.map_or("", |(key, _)| *key);
                    let why = "but the table `[motor]` is missing";
                    Err(SheetRefusal::of(key, format!("`{key}` belongs to a data sheet, {why}")))
                }
                Some((table, _)) => Err(SheetRefusal::of(
                    "motor",
                    format!(
                        "the table `[motor]` is missing; `[{table}]` belongs to a data sheet, \
                         which needs it"
                    ),
                )),
            };
        };
        let missing = |table: &'static str| {
            SheetRefusal::of(table, format!("the table `[{table}]` is missing in the data sheet"))
        };
        if supply.is_none() && motor.driven_by == DrivenBy::Voltage {
            return Err(missing("supply"));
        }
        let sheet = DataSheet {
            motor,
            gear: gear.unwrap_or_default(),
            load: load.ok_or_else(|| missing("load"))?,
            friction: friction.ok_or_else(|| missing("friction"))?,
            supply,
            encoder,
            load_encoder,
            sampling,
        };
        sheet.check()?;
        Ok(Some(sheet))
    }
}

/// Returns an angle or a speed, set in one of two units, in rad.
fn angle(in_deg: Option<f64>, in_rad: Option<f64>) -> Option<f64> {
    in_rad.or(in_deg.map(f64::to_radians))
}

/// Returns a coefficient per angle, set in one of two units, per rad.
fn per_angle(per_deg: Option<f64>, per_rad: Option<f64>) -> Option<f64> {
    per_rad.or(per_deg.map(f64::to_degrees))
}

impl DataSheet {
    /// Returns the speed of the motor without load, rad/s.
    pub fn no_load(&self) -> Option<f64> {
        let rpm = self.motor.no_load_rpm.map(|rpm| rpm * std::f64::consts::TAU / 60.0);
        self.motor.no_load_rad_per_s.or(rpm)
    }

    /// Returns the backlash at the joint, rad.
    pub fn backlash(&self) -> Option<f64> {
        angle(self.gear.backlash_deg, self.gear.backlash_rad)
    }

    /// Returns the side of the gear whose encoder closes the position loop. With two encoders, the
    /// default is the load; with one, `None` if the file does not set its place.
    pub fn position_side(&self) -> Option<EncoderPlace> {
        match self.load_encoder {
            Some(_) => self.sampling.position.or(Some(EncoderPlace::Load)),
            None => self.encoder.at,
        }
    }

    /// Returns the encoder of the load if it closes the position loop, beside the motor's encoder.
    pub fn load_encoder_in_loop(&self) -> Option<LoadEncoder> {
        self.load_encoder.filter(|_| self.position_side() == Some(EncoderPlace::Load))
    }

    /// Returns the backlash between the motor and `[encoder]`, rad: 0 if `[encoder]` is on the
    /// motor.
    pub fn backlash_to_encoder(&self) -> f64 {
        match self.encoder.at {
            Some(EncoderPlace::Motor) => 0.0,
            Some(EncoderPlace::Load) | None => self.backlash().unwrap_or(0.0),
        }
    }

    /// Returns the torsional stiffness at the joint, N m/rad.
    pub fn stiffness(&self) -> Option<f64> {
        per_angle(self.gear.stiffness_nm_per_deg, self.gear.stiffness_nm_per_rad)
    }

    /// Returns the torsional damping at the joint, N m s/rad.
    pub fn damping(&self) -> Option<f64> {
        per_angle(self.gear.damping_nm_s_per_deg, self.gear.damping_nm_s_per_rad)
    }

    /// Returns the position at which the load hangs down, rad.
    pub fn hangs_at(&self) -> Option<f64> {
        angle(self.load.hangs_at_deg, self.load.hangs_at_rad)
    }

    /// Returns the Stribeck velocity, rad/s.
    pub fn stribeck(&self) -> Option<f64> {
        angle(self.friction.stribeck_deg_per_s, self.friction.stribeck_rad_per_s)
    }

    /// Returns the viscous friction of the mechanics, without the back-EMF, N m s/rad.
    pub fn viscous(&self) -> f64 {
        let friction = &self.friction;
        per_angle(friction.viscous_nm_s_per_deg, friction.viscous_nm_s_per_rad).unwrap_or(0.0)
    }

    /// Returns the stiffness of the bristles, N m/rad.
    pub fn bristle_stiffness(&self) -> Option<f64> {
        let friction = &self.friction;
        per_angle(friction.bristle_stiffness_nm_per_deg, friction.bristle_stiffness_nm_per_rad)
    }

    /// Returns the damping of the bristles, N m s/rad.
    pub fn bristle_damping(&self) -> Option<f64> {
        let friction = &self.friction;
        per_angle(friction.bristle_damping_nm_s_per_deg, friction.bristle_damping_nm_s_per_rad)
    }

    /// Returns the static friction in the positive and in the negative direction, N m.
    pub fn stick(&self) -> [f64; 2] {
        let friction = &self.friction;
        [friction.stick_nm, friction.stick_reverse_nm.unwrap_or(friction.stick_nm)]
    }

    /// Returns the dynamic friction in the positive and in the negative direction, N m.
    pub fn slip(&self) -> [f64; 2] {
        let friction = &self.friction;
        [friction.slip_nm, friction.slip_reverse_nm.unwrap_or(friction.slip_nm)]
    }

    /// Returns two keys that set the same quantity in two units; `None` if there are none.
    pub(super) fn doubled(&self) -> Option<[&'static str; 2]> {
        let (motor, gear, load, friction) = (&self.motor, &self.gear, &self.load, &self.friction);
        [
            (
                motor.no_load_rpm,
                motor.no_load_rad_per_s,
                ["motor.no_load_rpm", "motor.no_load_rad_per_s"],
            ),
            (gear.backlash_deg, gear.backlash_rad, ["gear.backlash_deg", "gear.backlash_rad"]),
            (
                gear.stiffness_nm_per_deg,
                gear.stiffness_nm_per_rad,
                ["gear.stiffness_nm_per_deg", "gear.stiffness_nm_per_rad"],
            ),
            (
                gear.damping_nm_s_per_deg,
                gear.damping_nm_s_per_rad,
                ["gear.damping_nm_s_per_deg", "gear.damping_nm_s_per_rad"],
            ),
            (load.hangs_at_deg, load.hangs_at_rad, ["load.hangs_at_deg", "load.hangs_at_rad"]),
            (
                friction.stribeck_deg_per_s,
                friction.stribeck_rad_per_s,
                ["friction.stribeck_deg_per_s", "friction.stribeck_rad_per_s"],
            ),
            (
                friction.viscous_nm_s_per_deg,
                friction.viscous_nm_s_per_rad,
                ["friction.viscous_nm_s_per_deg", "friction.viscous_nm_s_per_rad"],
            ),
            (
                friction.bristle_stiffness_nm_per_deg,
                friction.bristle_stiffness_nm_per_rad,
                ["friction.bristle_stiffness_nm_per_deg", "friction.bristle_stiffness_nm_per_rad"],
            ),
            (
                friction.bristle_damping_nm_s_per_deg,
                friction.bristle_damping_nm_s_per_rad,
                ["friction.bristle_damping_nm_s_per_deg", "friction.bristle_damping_nm_s_per_rad"],
            ),
        ]
        .into_iter()
        .find_map(|(one, other, keys)| one.and(other).map(|_| keys))
    }
}
