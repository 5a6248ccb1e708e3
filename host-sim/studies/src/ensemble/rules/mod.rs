//! The tuning rules: for each law, its gains from what it is told of a joint, in a file each.
//!
//! A rule sees the nominal joint and the bounds of its friction, never the joint that is drawn.
//! What it has beside them is at most one constant without a unit, picked among those that are
//! listed as tried, on joints of the [tuning seeds](TUNING_SEEDS), which do not score:
//! `stiction ensemble tune` runs that again. Each rule is written down as a sentence, which reports
//! print beside the law.
//!
//! A law gets a rule by a file here and its line in [`RULES`].

mod discontinuous_nonlinear_proportional;
mod feedforward;
mod impulsive;
mod observer;
mod pd;
mod pid;
mod proxy_sliding_mode;
mod rate_variable_integral;
mod reset_integral;
mod reset_offset_integral;
mod robust;
mod smooth_robust_nonlinear;
mod two_reset_pid;

use std::ops::RangeInclusive;

use stiction::control::laws::Gains;
use stiction::control::pd::PdGains;

use crate::error::{Error, suggestion};

/// The seeds on which the constants of the rules were picked. A report on one of them says so.
pub const TUNING_SEEDS: RangeInclusive<u64> = 1_000_000..=1_999_999;

/// What a law is told of a joint, in the core's units.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Told {
    /// Nominal inertia J, V s^2/deg.
    pub inertia: f64,
    /// Nominal viscous friction B, V s/deg.
    pub viscous: f64,
    /// Bounds of the breakaway effort F_lo and F_hi, V.
    pub breakaway: [f64; 2],
    /// Largest load that may drive the joint, V; 0: none does.
    pub load: f64,
    /// Effort that holds the load where the joint is armed, within 20 %, V; 0: none is needed.
    pub hold_effort: f64,
    /// Largest effort, V.
    pub full_scale: f64,
    /// Step of the effort, V.
    pub lsb: f64,
    /// Angle of a count q, deg.
    pub count: f64,
    /// Time between samples h, s.
    pub sample_time: f64,
    /// Whether the encoder sits on the load, behind an elastic gear.
    pub encoder_at_load: bool,
    /// Counts by which the encoder changes at rest.
    pub jitter: f64,
}

impl Told {
    /// Returns the natural frequency w_n of the loop, rad/s: 8 Hz (2 Hz with the encoder on the
    /// load), and no more than 0.1/h.
    ///
    /// The velocity is (N - 1)/2 = 2 samples late, a held output half a sample, and the ensemble's
    /// delay one more. On a joint of half the nominal inertia, the damping crosses over at 4 zeta
    /// w_n: at 0.1/h these 3.5 samples turn its phase by 1.26 rad of the pi/2 that there are. The
    /// thesis's own loop has 0.104/h. The 8 Hz leave a motor of a quarter of the nominal inertia as
    /// much at 1 kHz.
    pub fn natural_frequency(&self) -> f64 {
        let hertz = if self.encoder_at_load { 2.0 } else { 8.0 };
        (std::f64::consts::TAU * hertz).min(0.1 / self.sample_time)
    }

    /// Returns the geometric middle of the told breakaway efforts, V.
    pub fn middle_breakaway(&self) -> f64 {
        (self.breakaway[0] * self.breakaway[1]).sqrt()
    }

    /// Returns Kp = J w_n^2, V/deg.
    pub fn kp(&self) -> f64 {
        self.inertia * self.natural_frequency().powi(2)
    }

    /// Returns Kd = 2 zeta J w_n - B, V s/deg, with zeta = 0.9, and no less than 0.
    pub fn kd(&self) -> f64 {
        (1.8 * self.inertia * self.natural_frequency() - self.viscous).max(0.0)
    }
}

/// The gains of a law and of the PD loop around it.
#[derive(Clone, Debug, PartialEq)]
pub struct Tuned {
    /// The PD loop; without effect under a law that replaces it.
    pub pd: PdGains,
    /// Positions in the velocity's regression.
    pub velocity_window: u32,
    /// The laws that are added to PD; none is plain PD.
    pub laws: Vec<Gains>,
}

/// Positions in the velocity's regression if a rule has no reason for others: the thesis's.
const VELOCITY_WINDOW: u32 = 5;

/// A tuning rule.
#[derive(Debug)]
pub struct Rule {
    /// Name of the law in a machine's file; `pd` is plain PD.
    pub law: &'static str,
    /// The rule in words.
    pub text: &'static str,
    /// The constant c of the rule.
    pub constant: f64,
    /// The constants that were tried on the tuning seeds; none if there was no choice.
    pub tried: &'static [f64],
    /// Makes the gains with a constant.
    pub tune: fn(&Told, f64) -> Tuned,
}

impl Rule {
    /// Makes the gains of the law for a joint.
    pub fn gains(&self, told: &Told) -> Tuned {
        (self.tune)(told, self.constant)
    }
}

/// Every rule, in the order of reports.
pub const RULES: &[Rule] = &[
    pd::RULE,
    reset_integral::RULE,
    rate_variable_integral::RULE,
    reset_offset_integral::RULE,
    feedforward::RULE,
    discontinuous_nonlinear_proportional::RULE,
    smooth_robust_nonlinear::RULE,
    robust::RULE,
    observer::ALONE,
    observer::WITH_FEEDFORWARD,
    observer::WITH_SRNF,
    pid::RULE,
    two_reset_pid::RULE,
    impulsive::RULE,
    proxy_sliding_mode::RULE,
];

/// Returns the rules of the laws that are named, or all of them if none is.
///
/// # Errors
/// Names a law that has no rule, with the nearest one that has.
pub fn rules(names: &[String]) -> Result<Vec<&'static Rule>, Error> {
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

/// Returns the PD loop's gains, and a law's.
fn around_pd(told: &Told, law: Option<Gains>) -> Tuned {
    let pd = PdGains { kp: told.kp() as f32, kd: told.kd() as f32 };
    Tuned { pd, velocity_window: VELOCITY_WINDOW, laws: law.into_iter().collect() }
}

/// Returns w_n of a loop that is no faster than 0.1/h, rad/s. It is PD's own at 1 kHz.
///
/// Faster ones ring on the lightest joints of the thesis's axis with a sample of delay; under a law
/// that adds effort they do not come to rest.
fn slower(told: &Told) -> f64 {
    told.natural_frequency().min(0.1 / told.sample_time)
}

/// Returns the gains of that loop, and a law's.
fn around_slower_pd(told: &Told, law: Gains) -> Tuned {
    let w = slower(told);
    let kd = (1.8 * told.inertia * w - told.viscous).max(0.0);
    let pd = PdGains { kp: (told.inertia * w * w) as f32, kd: kd as f32 };
    Tuned { pd, velocity_window: VELOCITY_WINDOW, laws: vec![law] }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The nominal joint of the SI families at 1 kHz with 100,000 counts a turn, in volts of 12 N m
    /// and degrees.
    pub const NOMINAL: Told = {
        let scale = std::f64::consts::PI / 180.0 / 12.0;
        Told {
            inertia: 0.34 * scale,
            viscous: 1.3 * scale,
            breakaway: [2.0 / 12.0, 1.0],
            load: 0.0,
            hold_effort: 0.0,
            full_scale: 5.0,
            lsb: 0.005,
            count: 0.0036,
            sample_time: 1e-3,
            encoder_at_load: false,
            jitter: 0.0,
        }
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
        // Plain PD, and two sums.
        assert_eq!(RULES.len(), Gains::NAMES.len() + 3);
    }

    #[test]
    fn the_rules_give_the_thesis_s_own_gains_nearly_where_they_are_told_the_thesis_s_joint() {
        // Table 17 and section 3.3: J = 1/27, B = 0.02, stick 0.40 V, h = 20 ms; Kp 1, Kd 0.15.
        // The rule is no more than half as fast or twice as fast, so the gains are within a factor
        // of four.
        let told = Told {
            inertia: 1.0 / 27.0,
            viscous: 0.02,
            breakaway: [0.37, 0.40],
            count: 0.00242,
            sample_time: 0.02,
            lsb: 0.00488,
            ..NOMINAL
        };
        assert!((told.natural_frequency() - 5.0).abs() < 1e-9);
        assert!((0.25..4.0).contains(&told.kp()), "{}", told.kp());
        assert!((0.0375..0.6).contains(&told.kd()), "{}", told.kd());
    }
}
