//! Plausibility of a data sheet: warnings before a run, and an error if the joint cannot move.

use super::refusal::{RefusalCause, SheetRefusal};
use super::sheet::DataSheet;
use super::suspect::Suspect;
use super::tables::DrivenBy;
use super::units::Mapping;
use crate::error::{rounded, shown};

/// Largest relative deviation, on real motors, between the speed without load and V / K_t:
/// manufacturers round both, and measure one of them on a warm motor.
const NO_LOAD_TOLERANCE: f64 = 0.2;

/// Largest usual ratio between the inertias of rotor and load at the joint.
const INERTIA_RATIO: f64 = 1000.0;

/// Largest ratio of stick to slip friction on measured joints.
const STICK_TO_SLIP: f64 = 4.0;

/// Keys that determine the stall torque at the joint.
const STALL_TORQUE: [&str; 7] = [
    "supply.voltage_v",
    "motor.resistance_ohm",
    "motor.kt_nm_per_a",
    "motor.current_limit_a",
    "motor.amplifier_a_per_v",
    "gear.ratio",
    "gear.efficiency",
];

impl DataSheet {
    /// Checks that the motor is strong enough to move the joint.
    ///
    /// # Errors
    /// Returns an error with the friction or load, and the motor's stall torque.
    pub fn can_move(&self, mapping: &Mapping) -> Result<(), SheetRefusal> {
        let (stall, constant) = (mapping.stall(), self.load.constant_nm);
        // Torque that each direction needs; a constant load helps in one of them.
        let [forward, backward] = [self.stick()[0] - constant, self.stick()[1] + constant];
        let (key, needed) = if forward <= backward || self.friction.stick_reverse_nm.is_none() {
            ("friction.stick_nm", forward.min(backward))
        } else {
            ("friction.stick_reverse_nm", backward)
        };
        if needed < stall {
            return Ok(());
        }
        let found = if key == "friction.stick_nm" { self.stick()[0] } else { self.stick()[1] };
        let of_the_stall = |suspect: &Suspect| STALL_TORQUE.contains(&suspect.key);
        let follows = format!(
            "the joint cannot move, since the motor's stall torque at the joint is {} N m and the \
             static friction (`{key}`) is {} N m",
            rounded(stall),
            shown(found),
        );
        if let Some(suspect) = self.suspects().find(of_the_stall) {
            return Err(SheetRefusal::of(suspect.key, format!("{suspect}: {follows}")));
        }
        let allowed = format!(
            "a number below {}, since the motor's stall torque at the joint is {} N m and the \
             joint could not move; it follows from {}",
            rounded(found - needed + stall),
            rounded(stall),
            self.listed(&STALL_TORQUE),
        );
        let cause = Some(RefusalCause { keys: &STALL_TORQUE, sentence: follows });
        Err(SheetRefusal { cause, ..SheetRefusal::number(key, found, &allowed) })
    }

    /// Returns the implausible values, one sentence each.
    pub fn doubts(&self, mapping: &Mapping) -> Vec<String> {
        [
            self.unit_is_doubtful(),
            self.no_load_contradicts(mapping),
            self.inertia_is_off(mapping),
            self.little_is_left(mapping),
            self.stick_is_high(),
            self.load_wins(mapping),
            self.duty_is_bold(mapping),
            self.load_heats(mapping),
        ]
        .into_iter()
        .flatten()
        .collect()
    }

    /// Compares the speed without load with (V - R i) / K_t, where i is the current for the
    /// friction.
    fn no_load_contradicts(&self, mapping: &Mapping) -> Option<String> {
        let (said, supply) = (self.no_load()?, self.supply.as_ref()?);
        let at_most = supply.voltage_v / self.motor.kt_nm_per_a;
        let lost = if self.motor.driven_by == DrivenBy::Voltage {
            mapping.volts(self.slip()[0]) / supply.voltage_v
        } else {
            0.0
        };
        // The speed without load is often that of the motor without its gear.
        let range = (at_most * (1.0 - lost).max(0.0) * (1.0 - NO_LOAD_TOLERANCE))
            ..=(at_most * (1.0 + NO_LOAD_TOLERANCE));
        if range.contains(&said) {
            return None;
        }
        let (key, unit, found, by_kt) = match self.motor.no_load_rpm {
            Some(rpm) => ("no_load_rpm", "1/min", rpm, at_most / said * rpm),
            None => ("no_load_rad_per_s", "rad/s", said, at_most),
        };
        Some(format!(
            "`motor.{key}` is {}, but `motor.kt_nm_per_a` ({}) and `supply.voltage_v` ({}) give \
             {} {unit}: one of the three is off by a factor of {}",
            shown(found),
            shown(self.motor.kt_nm_per_a),
            shown(supply.voltage_v),
            rounded(by_kt),
            rounded((by_kt / found).max(found / by_kt)),
        ))
    }

    fn inertia_is_off(&self, mapping: &Mapping) -> Option<String> {
        let load = self.load.inertia_kg_m2;
        let rotor = mapping.inertia - load;
        if load == 0.0 || rotor <= 0.0 {
            return None;
        }
        let ratio = (load / rotor).max(rotor / load);
        (ratio > INERTIA_RATIO).then(|| {
            let larger = if load > rotor { "more" } else { "less" };
            format!(
                "`load.inertia_kg_m2` is {}, {} times {larger} than the rotor's at the joint ({} \
                 kg m^2, by `motor.rotor_inertia_kg_m2` and `gear.ratio`): one of them may be in \
                 another unit",
                shown(load),
                rounded(ratio),
                rounded(rotor),
            )
        })
    }

    fn little_is_left(&self, mapping: &Mapping) -> Option<String> {
        let stall = mapping.stall();
        let against = self.load.constant_nm.abs() + self.load.unbalance_nm;
        let worst = self.stick()[0].max(self.stick()[1]) + against;
        if worst <= 0.5 * stall {
            return None;
        }
        let what =
            if against > 0.0 { "static friction and load need" } else { "static friction needs" };
        let end = if worst >= stall {
            ": at some positions or in one direction, the joint cannot start"
        } else {
            ""
        };
        Some(format!(
            "{what} up to {} N m at the joint, and the motor's stall torque is {} N m{end}",
            rounded(worst),
            rounded(stall),
        ))
    }

    fn stick_is_high(&self) -> Option<String> {
        let friction = &self.friction;
        let of = |key, reverse_key, reverse: Option<f64>| {
            [key, if reverse.is_some() { reverse_key } else { key }]
        };
        let sticks = of("stick_nm", "stick_reverse_nm", friction.stick_reverse_nm);
        let slips = of("slip_nm", "slip_reverse_nm", friction.slip_reverse_nm);
        let (stick, slip) = (self.stick(), self.slip());
        let side = (0..2).find(|side| stick[*side] > STICK_TO_SLIP * slip[*side])?;
        Some(format!(
            "`friction.{}` is {} and `{}` {}; check both: on measured joints, stick friction is \
             at most {} times slip friction",
            sticks[side],
            shown(stick[side]),
            slips[side],
            shown(slip[side]),
            shown(STICK_TO_SLIP)
        ))
    }

    fn load_wins(&self, mapping: &Mapping) -> Option<String> {
        let pull = self.load.constant_nm.abs() + self.load.unbalance_nm;
        let least = self.stick()[0].min(self.stick()[1]);
        (pull > least && pull < mapping.stall()).then(|| {
            format!(
                "the load's torque ({} N m) is more than the static friction ({} N m): the joint \
                 moves when the motor is off",
                rounded(pull),
                rounded(least)
            )
        })
    }

    /// Compares the effort that holds the load, less the static friction, with the effort that the
    /// motor can hold forever.
    fn load_heats(&self, mapping: &Mapping) -> Option<String> {
        let pull = self.load.constant_nm.abs() + self.load.unbalance_nm;
        let needed_v = mapping.volts(pull - self.stick()[0].min(self.stick()[1]));
        let continuous_v = self.motor_heat()?.continuous_v;
        let then = match self.motor.rated_current_a {
            Some(_) => {
                "(from `motor.rated_current_a`): unless `limits.continuous_v` is off, it turns the \
                 motor off"
            }
            None => "(guessed from its stall current): it may burn; set `motor.rated_current_a`",
        };
        (needed_v > continuous_v).then(|| {
            format!(
                "the load takes {} V to hold, but the motor tolerates only {} V forever {then}",
                rounded(needed_v),
                rounded(continuous_v)
            )
        })
    }

    fn duty_is_bold(&self, mapping: &Mapping) -> Option<String> {
        let limit = self.motor.current_limit_a?;
        let per_volt = match self.motor.driven_by {
            DrivenBy::Voltage => 1.0 / self.motor.resistance_ohm?,
            DrivenBy::Current => self.motor.amplifier_a_per_v?,
        };
        let current = mapping.full_scale_v * mapping.duty_max * per_volt;
        (current > 1.001 * limit).then(|| {
            format!(
                "`drive.duty_max` allows {} A at standstill, more than `motor.current_limit_a` ({} \
                 A): lower `drive.duty_max`",
                rounded(current),
                shown(limit)
            )
        })
    }
}
