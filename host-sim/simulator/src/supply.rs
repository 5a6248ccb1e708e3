//! Supply of a bridge over a run: off by a factor, and sagging for a time.
//!
//! ```text
//! u = r(t) d V        r = ratio, and ratio times that of the sag in [from, from + duration)
//! ```
//!
//! V is the nominal supply, d the duty. A tick reads the supply of the tick before, as a board
//! does. Does badly: the supply steps, and does not depend on the current.

use files::error::Error;

/// Bounds of a ratio.
const RATIOS: [f64; 2] = [0.1, 2.0];

/// A supply that differs from the nominal one.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub struct SupplyCourse {
    /// Supply over the nominal one.
    pub ratio: f64,
    /// Sag of that supply, if it has one.
    pub sag: Option<Sag>,
}

/// A sag of the supply.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub struct Sag {
    /// Supply in the sag over the supply before it.
    pub ratio: f64,
    /// Time of its start, s.
    pub from_s: f64,
    /// Duration, s.
    pub duration_s: f64,
}

impl SupplyCourse {
    /// Reads the options of a command: a ratio, and the ratio, start and duration of a sag. `None`
    /// without either.
    ///
    /// # Errors
    /// Returns an error that names the option, the value found and the allowed values.
    pub fn of_options(supply: Option<f64>, sag: &[f64]) -> Result<Option<Self>, Error> {
        let refused = |option: &str, found: f64, allowed: &str| {
            Err(Error::Input(format!("{option}: {found}; must be {allowed}")))
        };
        let [least, most] = RATIOS;
        if let Some(ratio) = supply.filter(|ratio| !(least..=most).contains(ratio)) {
            return refused("--supply", ratio, "a number from 0.1 to 2, over the nominal supply");
        }
        let sag = match *sag {
            [] => None,
            [ratio, ..] if !(least..=1.0).contains(&ratio) => {
                return refused("--sag", ratio, "a number from 0.1 to 1, over the supply before");
            }
            [_, from_s, _] if !(from_s >= 0.0 && from_s.is_finite()) => {
                return refused("--sag", from_s, "a finite number not below 0, the start in s");
            }
            [_, _, duration_s] if !(duration_s > 0.0 && duration_s.is_finite()) => {
                return refused("--sag", duration_s, "a finite number above 0, the duration in s");
            }
            [ratio, from_s, duration_s] => Some(Sag { ratio, from_s, duration_s }),
            _ => {
                let needed = "must be RATIO,FROM_S,FOR_S, as in 0.7,0.5,0.1";
                return Err(Error::Input(format!("--sag has {} numbers; {needed}", sag.len())));
            }
        };
        let is_nominal = supply.is_none() && sag.is_none();
        Ok((!is_nominal).then(|| Self { ratio: supply.unwrap_or(1.0), sag }))
    }

    /// Returns the supply at a time (s) over the nominal one.
    pub fn ratio_at(&self, time_s: f64) -> f64 {
        match self.sag {
            // A sample at the end of a decimal number of seconds can differ in its last bit.
            Some(Sag { ratio, from_s, duration_s })
                if (from_s - 1e-9..from_s + duration_s - 1e-9).contains(&time_s) =>
            {
                self.ratio * ratio
            }
            _ => self.ratio,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_sag_begins_and_ends_at_its_times_and_multiplies_the_ratio() {
        let supply = SupplyCourse::of_options(Some(0.8), &[0.7, 0.5, 0.1]).unwrap().unwrap();
        let at = |ticks: u32| supply.ratio_at(f64::from(ticks) * 1e-3);
        assert_eq!([0, 499, 600, 900].map(at), [0.8; 4]);
        assert_eq!([500, 550, 599].map(at), [0.8 * 0.7; 3]);
        assert_eq!(SupplyCourse::of_options(None, &[]).unwrap(), None);
    }

    #[test]
    fn numbers_out_of_range_are_refused_with_their_option() {
        for (supply, sag, fragment) in [
            (Some(0.05), &[][..], "--supply: 0.05; must be a number from 0.1 to 2"),
            (Some(f64::NAN), &[], "--supply: NaN"),
            (None, &[0.7, 0.5], "--sag has 2 numbers"),
            (None, &[1.2, 0.5, 0.1], "--sag: 1.2"),
            (None, &[0.7, -0.5, 0.1], "--sag: -0.5"),
            (None, &[0.7, 0.5, 0.0], "--sag: 0; must be a finite number above 0"),
        ] {
            let message = SupplyCourse::of_options(supply, sag).unwrap_err().to_string();
            assert!(message.contains(fragment), "{message}");
        }
    }
}
