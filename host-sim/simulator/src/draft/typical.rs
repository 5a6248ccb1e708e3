//! Three typical joints, with the source of each number.

use super::answers::Answers;
use super::questions::QUESTIONS;
use files::error::{Error, suggestion};

/// A typical joint.
#[derive(Clone, Copy, Debug)]
pub struct Typical {
    /// Name on the command line.
    pub name: &'static str,
    /// Description in a few words.
    pub title: &'static str,
    /// Source of the data of the joint.
    pub source: &'static str,
    /// Key, answer, and source of the answer.
    answers: &'static [(&'static str, &'static str, &'static str)],
    /// Further lines of `[drive]`.
    pub drive: &'static str,
}

/// The typical joints of `stiction new --typical`.
pub const TYPICAL: [Typical; 3] = [
    Typical {
        name: "harmonic",
        title: "A harmonic-drive joint like an eRob80:50",
        source: "Rhoban BAM (arXiv 2410.08650), identified Coulomb and viscous model of eRob80:50",
        answers: &[
            ("motor.driven_by", "voltage", ""),
            ("motor.resistance_ohm", "2.51", "identified"),
            ("motor.kt_nm_per_a", "0.0909", "identified at the joint: 4.54 N m/A"),
            ("motor.rotor_inertia_kg_m2", "1.348e-4", "identified at the joint: 0.337 kg m^2"),
            ("motor.current_limit_a", "12.0", "of the identification's drive"),
            ("gear.ratio", "50.0", "name plate"),
            ("gear.efficiency", "1.0", "its losses are in the friction"),
            ("load.inertia_kg_m2", "0.1", "an arm of 0.3 m with 1 kg at its end; yours differs"),
            ("friction.stick_nm", "4.9", "assumed: 1.2 times the slip friction"),
            ("friction.slip_nm", "4.10", "identified"),
            ("friction.viscous_nm_s_per_rad", "1.30", "identified"),
            ("supply.voltage_v", "48.0", "of the identification's drive"),
            ("encoder.lines", "500", "assumed: 100000 counts in a turn of the joint"),
            ("encoder.at", "motor", ""),
            ("loop.sample_time_s", "0.001", "assumed"),
        ],
        drive: "",
    },
    Typical {
        name: "gimbal",
        title: "A geared DC gimbal with a small gearmotor",
        source: "Data sheet of the Pololu 37D 50:1 gearmotor, 12 V, with encoder",
        answers: &[
            ("motor.driven_by", "voltage", ""),
            ("motor.resistance_ohm", "2.18", "12 V / 5.5 A at stall"),
            ("motor.kt_nm_per_a", "0.0110", "(12 V - 0.2 A R) / 10000 1/min without load"),
            ("motor.rotor_inertia_kg_m2", "7e-6", "assumed; the data sheet has none"),
            ("motor.current_limit_a", "2.0", "assumed; a stalled one burns at 5.5 A"),
            ("gear.ratio", "50.0", "data sheet"),
            ("gear.efficiency", "0.68", "2.06 N m at stall / (50 K_t 5.5 A)"),
            ("load.inertia_kg_m2", "0.005", "a camera of 0.5 kg; yours differs"),
            ("friction.stick_nm", "0.08", "assumed"),
            ("friction.slip_nm", "0.06", "assumed; 0.2 A without load are 0.075 N m in all"),
            ("friction.viscous_nm_s_per_rad", "7e-4", "the rest of those 0.075 N m at 200 1/min"),
            ("supply.voltage_v", "12.0", "data sheet"),
            ("encoder.lines", "16", "data sheet: 64 counts in a turn of the motor"),
            ("encoder.at", "motor", ""),
            ("loop.sample_time_s", "0.005", "longer than usual: the counts are coarse"),
        ],
        drive: "",
    },
    Typical {
        name: "thesis",
        title: "The base axis of the thesis's robot",
        source: "Tables 20 and 21, section 3.2",
        answers: &[
            ("motor.driven_by", "current", "section 3.2"),
            ("motor.amplifier_a_per_v", "3.0", "K_a, Table 20"),
            ("motor.kt_nm_per_a", "0.10", "Table 20"),
            ("motor.rotor_inertia_kg_m2", "0.0", "is in that of the load"),
            ("motor.current_limit_a", "15.0", "5 V of the D/A (section 3.2)"),
            ("gear.ratio", "1800.0", "Table 20"),
            ("gear.efficiency", "1.0", "Table 20 has none"),
            (
                "load.inertia_kg_m2",
                "1145.9155902616465",
                "20 (Table 20) x 180/pi: kappa is read in degrees",
            ),
            ("friction.stick_nm", "216.0", "0.40 V (Table 21) x 540 N m/V"),
            ("friction.slip_nm", "205.2", "0.38 V (Table 21) x 540 N m/V"),
            (
                "friction.viscous_nm_s_per_rad",
                "618.7944187412891",
                "0.02 V s/deg (Table 20) x 540 x 180/pi",
            ),
            ("encoder.lines", "37190", "0.00242 deg a count (section 3.2)"),
            ("encoder.at", "load", ""),
            ("loop.sample_time_s", "0.02", "section 3.2"),
        ],
        drive: "lsb_v = 0.00488                     # 10 V / 2048 (section 3.2)\n",
    },
];

impl Typical {
    /// Returns the typical joint with a name.
    ///
    /// # Errors
    /// Returns an error that names the nearest one.
    pub fn find(name: &str) -> Result<Self, Error> {
        TYPICAL.iter().copied().find(|typical| typical.name == name).ok_or_else(|| {
            let near = suggestion(name, TYPICAL.iter().map(|typical| typical.name));
            Error::Input(format!("--typical {name}: there is no such joint{near}"))
        })
    }

    /// Returns the answers of the joint.
    ///
    /// # Errors
    /// Returns an error if an answer cannot be parsed; a test parses all of them.
    pub fn answers(&self) -> Result<Answers, Error> {
        let mut answers = Answers::default();
        for (key, typed, source) in self.answers {
            if let Some(question) = QUESTIONS.iter().find(|question| question.key == *key) {
                answers.put(key, question.read(typed).map_err(Error::Input)?, source);
            }
        }
        Ok(answers)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::draft::text;
    use dynamics::joint::presets;
    use files::document::Document;

    /// The identified numbers are in two places: as rotor and gear here, as a joint in `presets`.
    #[test]
    fn the_harmonic_joint_without_its_load_is_the_identified_one() {
        let typical = Typical::find("harmonic").unwrap();
        let text = text("harmonic", &typical.answers().unwrap(), Some(&typical)).unwrap();
        let document = Document::parse("harmonic", &text).unwrap();
        let (sheet, mapping) = document.mapping().unwrap().unwrap();
        let identified = presets::erob80_50();
        let curve = identified.friction.curve;
        assert_eq!((sheet.slip()[0], sheet.viscous()), (curve.coulomb, curve.viscous));
        let rotor = mapping.inertia - sheet.load.inertia_kg_m2;
        assert!((rotor / identified.inertia - 1.0).abs() < 1e-3, "{rotor} kg m^2");
        // BAM's K_t is that at the joint: 4.543 N m/A.
        let kt = sheet.gear.ratio * sheet.motor.kt_nm_per_a;
        assert!((kt / 4.543 - 1.0).abs() < 1e-3, "{kt} N m/A");
    }

    #[test]
    fn every_typical_joint_answers_every_question_that_it_is_asked() {
        for typical in TYPICAL {
            let answers = typical.answers().unwrap();
            assert_eq!(answers.open(), [], "{}", typical.name);
            assert_eq!(answers.given().count(), typical.answers.len(), "{}", typical.name);
        }
    }
}
