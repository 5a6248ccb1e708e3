//! The rule book: computes the gains of every law from the known bounds of a joint. Each law has a
//! file.
//!
//! ```text
//! data sheet, identification, drawn family -> JointBounds -> PdLoop, GainRule -> ControllerGains
//!                                                         -> MoveProfile
//! ```
//!
//! `new`, `identify --into`, `tune`, `benchmark`, `ensemble`, the self-test and the studio use
//! these gains. The input of a rule is [`JointBounds`]: the nominal joint and bounds of its
//! friction, never the simulated joint. In addition, a rule has at most one constant without a
//! unit. It was picked among the listed candidates (`tried`) on joints of the [tuning
//! seeds](TUNING_SEEDS), which do not count as results; `stiction ensemble tune` repeats the
//! choice.
//!
//! Gains have four significant digits, because the joint is not known more exactly. They are
//! rounded here, so that a file and a computation have identical gains, bit for bit.
//!
//! To add a rule, add its file here and its line in [`RULES`].

mod discontinuous_nonlinear_proportional;
mod feedforward;
mod feedforward_and_srnf;
mod impulsive;
mod joint_bounds;
mod move_profile;
mod observer;
mod pd;
mod pd_loop;
mod pid;
mod proxy_sliding_mode;
mod rate_variable_integral;
mod reset_integral;
mod reset_offset_integral;
pub mod robust;
mod smooth_robust_nonlinear;
mod two_reset_pid;

use std::ops::RangeInclusive;

use stiction::control::laws::Gains;
use stiction::control::pd::PdGains;

pub use self::joint_bounds::{GearBounds, JointBounds, JointEstimate, MotorEncoder, SampledLoop};
pub use self::move_profile::MoveProfile;
pub use self::pd_loop::{DAMPING_RATIO, PdLoop};
use files::error::{Error, suggestion};

/// The seeds on which the constants of the rules were picked. A report on one of them says so.
pub const TUNING_SEEDS: RangeInclusive<u64> = 1_000_000..=1_999_999;

/// Gains of a law and of the PD loop around it.
#[derive(Clone, Debug, PartialEq)]
pub struct ControllerGains {
    /// Gains of the PD loop; zero or without effect under a law that replaces PD.
    pub pd: PdGains,
    /// Number of positions in the velocity's regression.
    pub velocity_window: u32,
    /// The laws that are added to PD; empty for plain PD.
    pub laws: Vec<Gains>,
}

/// Rule for the gains of a law.
#[derive(Debug)]
pub struct GainRule {
    /// Name of the law in a machine's file; `pd` is plain PD.
    pub law: &'static str,
    /// Values of the joint that the rule uses, in words.
    pub knows: &'static str,
    /// The rule in words.
    pub text: &'static str,
    /// The constant c of the rule.
    pub constant: f64,
    /// The constants that were tried on the tuning seeds; empty if there was no choice.
    pub tried: &'static [f64],
    /// Function that returns the gains for a joint and a constant.
    pub gains_with: fn(&JointBounds, f64) -> ControllerGains,
}

impl GainRule {
    /// Returns the gains of the law for a joint.
    pub fn gains(&self, joint: &JointBounds) -> ControllerGains {
        (self.gains_with)(joint, self.constant)
    }
}

/// Every rule, in the order of reports.
pub const RULES: &[GainRule] = &[
    pd::RULE,
    reset_integral::RULE,
    rate_variable_integral::RULE,
    reset_offset_integral::RULE,
    feedforward::RULE,
    discontinuous_nonlinear_proportional::RULE,
    smooth_robust_nonlinear::RULE,
    feedforward_and_srnf::RULE,
    robust::RULE,
    observer::ALONE,
    observer::WITH_FEEDFORWARD,
    observer::WITH_SRNF,
    pid::RULE,
    two_reset_pid::RULE,
    impulsive::RULE,
    proxy_sliding_mode::RULE,
];

/// Returns the rules of the named laws, or all rules if no law is named.
///
/// # Errors
/// Returns an error that names a law without a rule, and the most similar law with one.
pub fn rules(names: &[String]) -> Result<Vec<&'static GainRule>, Error> {
    if names.is_empty() {
        return Ok(RULES.iter().collect());
    }
    let rule = |name: &String| {
        RULES.iter().find(|rule| rule.law == name).ok_or_else(|| {
            let near = suggestion(name, RULES.iter().map(|rule| rule.law));
            Error::Input(format!("--controller {name}: no law of that name has a rule{near}"))
        })
    };
    names.iter().map(rule).collect()
}

/// Rounds to four significant digits.
fn four_digits(value: f64) -> f64 {
    format!("{value:.3e}").parse().unwrap_or(value)
}

/// Rounds to four significant digits, in the core's precision.
fn four_digits_single(value: f64) -> f32 {
    four_digits(value) as f32
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The nominal joint of the SI families at 1 kHz with 100,000 counts a turn, in volts of 12 N m
    /// and degrees.
    const NOMINAL: JointBounds = {
        let scale = std::f64::consts::PI / 180.0 / 12.0;
        let sampled =
            SampledLoop { largest_effort: 5.0, lsb: 0.005, count: 0.0036, sample_time: 1e-3 };
        let joint = JointEstimate {
            inertia: 0.34 * scale,
            viscous: 1.3 * scale,
            friction: [4.0 / 12.0, 0.5],
            load: 0.0,
            holds: 0.0,
        };
        JointBounds::of(&joint, sampled)
    };

    #[test]
    fn every_law_of_the_core_has_one_rule_and_every_rule_its_law() {
        for name in Gains::NAMES {
            assert_eq!(RULES.iter().filter(|rule| rule.law == *name).count(), 1, "{name}");
        }
        for rule in RULES {
            let tuned = rule.gains(&NOMINAL);
            let names: Vec<_> = tuned.laws.iter().map(Gains::name).collect();
            assert_eq!(if names.is_empty() { "pd".into() } else { names.join("+") }, rule.law);
            assert!(rule.tried.is_empty() || rule.tried.contains(&rule.constant), "{}", rule.law);
        }
        // Plain PD, and three sums.
        assert_eq!(RULES.len(), Gains::NAMES.len() + 4);
    }

    #[test]
    fn the_rules_give_the_thesis_s_own_gains_nearly_for_the_thesis_s_joint() {
        // Table 17 and section 3.3: J = 1/27, B = 0.02, stick 0.40 V, h = 20 ms; Kp 1, Kd 0.15.
        // The rule is no more than half as fast or twice as fast, so the gains are within a factor
        // of four.
        let sampled =
            SampledLoop { largest_effort: 5.0, lsb: 0.00488, count: 0.00242, sample_time: 0.02 };
        let axis = JointEstimate {
            inertia: 1.0 / 27.0,
            viscous: 0.02,
            friction: [0.38, 0.40],
            load: 0.0,
            holds: 0.38,
        };
        let joint = JointBounds::of(&axis, sampled);
        let PdLoop { natural_frequency, kp, kd } = PdLoop::of(&joint);
        assert!((natural_frequency - 5.0).abs() < 1e-9);
        assert!((0.25..4.0).contains(&kp), "{kp}");
        assert!((0.0375..0.6).contains(&kd), "{kd}");
    }

    #[test]
    fn gains_have_four_digits_whatever_their_size() {
        for (value, expected) in [
            (0.123_456, 0.1235_f32),
            (-98_765.0, -98_760.0),
            (1.234_5e-7, 1.234e-7),
            (0.0, 0.0),
            (9.999_6, 10.0),
        ] {
            let off = (four_digits_single(value) - expected).abs();
            assert!(off <= 1e-3 * expected.abs(), "{value}");
            let again = four_digits_single(four_digits_single(value).into());
            assert_eq!(again.to_bits(), four_digits_single(value).to_bits(), "{value}");
        }
    }
}
