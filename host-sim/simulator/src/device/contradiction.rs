//! Comparison of a key of a machine's file with a measurement.

use files::error::shown;

/// A key of a machine's file whose value lies outside the error bar of the measured value.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub struct Contradiction {
    /// Key; its unit is that of the numbers.
    pub key: String,
    /// Value in the file.
    pub in_file: f64,
    /// Value measured.
    pub measured: f64,
    /// Width of the error bar to either side: two standard deviations or more; 0 if unknown.
    pub off: f64,
}

impl Contradiction {
    /// Creates a contradiction; the last argument is the measured value and the width of its bar.
    pub fn new(key: &str, in_file: f64, [measured, off]: [f64; 2]) -> Self {
        Self { key: key.to_owned(), in_file, measured, off }
    }

    /// Compares a value of a file, or its range in the file, with a measured range; `None` if they
    /// overlap.
    pub fn between(
        key: &str,
        (in_file, range): (f64, Option<[f64; 2]>),
        (measured, [low, high]): (f64, [f64; 2]),
    ) -> Option<Self> {
        let [least, most] = range.unwrap_or([in_file; 2]);
        if least <= high && low <= most {
            return None;
        }
        let off = (measured - low).max(high - measured);
        Some(Self::new(key, in_file, [measured, off]))
    }

    /// Returns the sentence: `friction.stick_nm is 0.35 in joint.toml, 0.28 +- 0.01 measured`.
    pub fn words(&self, file: &str) -> String {
        let Self { key, in_file, measured, off } = self;
        let digits = |value: f64, digits: usize| {
            shown(format!("{value:.*e}", digits - 1).parse().unwrap_or(value))
        };
        let bar = if *off > 0.0 { format!(" +- {}", digits(*off, 2)) } else { String::new() };
        let [in_file, measured] = [digits(*in_file, 5), digits(*measured, 3)];
        format!("{key} is {in_file} in {file}, {measured}{bar} measured")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_is_contradicted_by_a_range_that_has_no_value_in_common_with_it() {
        let of = |in_file: f64, range: Option<[f64; 2]>| {
            Contradiction::between("friction.stick_nm", (in_file, range), (0.28, [0.27, 0.29]))
        };
        let found = of(0.35, None).unwrap();
        assert_eq!(
            found.words("bl.toml"),
            "friction.stick_nm is 0.35 in bl.toml, 0.28 +- 0.01 measured"
        );
        assert_eq!(of(0.285, None), None);
        // The user's range contains the measured one, although the value in the file differs.
        assert_eq!(of(0.35, Some([0.15, 0.4])), None);
        assert!(of(0.35, Some([0.3, 0.4])).is_some());
        assert!(of(0.2, Some([0.1, 0.269])).is_some());
    }
}
