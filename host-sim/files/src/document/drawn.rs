//! Sets keys to values that were drawn within a spread.

use super::Document;
use super::wording::brief;
use crate::error::Error;

impl Document {
    /// Sets keys that were drawn within a spread. Slip friction drawn above the stick friction is
    /// lowered to it, since no joint has more. The difference between the friction of the negative
    /// and of the positive direction is that of the file.
    ///
    /// # Errors
    /// Returns an error that names the spread.
    pub fn draw(&mut self, assignments: &[String]) -> Result<(), Error> {
        let assignments = &*self.with_slip_below_stick(assignments);
        let assignments = &*self.with_both_ways(assignments);
        for assignment in assignments {
            self.assign(assignment).map_err(|why| {
                let drawn = brief(assignment);
                Error::Input(format!("{}: its spread gives {drawn}: {why}", self.origin))
            })?;
            self.origin.drawn.push(assignment.clone());
        }
        self.check()
    }

    /// Lowers a drawn slip friction to the stick friction. A level that was not drawn is that of
    /// the file.
    fn with_slip_below_stick(&self, drawn: &[String]) -> Vec<String> {
        const LEVELS: [[&str; 2]; 3] = [
            ["joint.friction.slip_v", "joint.friction.stick_v"],
            ["friction.slip_nm", "friction.stick_nm"],
            ["friction.slip_reverse_nm", "friction.stick_reverse_nm"],
        ];
        let mut all = drawn.to_vec();
        for [slip, stick] in LEVELS {
            let place = |key: &str| {
                let is = |one: &String| one.split('=').next().unwrap_or_default().trim() == key;
                drawn.iter().position(is)
            };
            let level = |key: &str| match place(key) {
                Some(at) => drawn[at].split_once('=')?.1.trim().parse::<f64>().ok(),
                None => self.number(key),
            };
            let (Some(slips), Some(sticks)) = (level(slip), level(stick)) else { continue };
            if slips <= sticks {
                continue;
            }
            let lowered = format!("{slip}={sticks:?}");
            match place(slip) {
                Some(at) => all[at] = lowered,
                None => all.push(lowered),
            }
        }
        all
    }

    /// Adds the friction levels of the negative direction to the drawn ones. Static and dynamic
    /// friction must differ from those of the positive direction by the same amount.
    fn with_both_ways(&self, drawn: &[String]) -> Vec<String> {
        const WAYS: [[&str; 2]; 2] = [
            ["friction.slip_nm", "friction.slip_reverse_nm"],
            ["friction.stick_nm", "friction.stick_reverse_nm"],
        ];
        let of_file = |key: &str| self.number(key);
        let of_joint = |key: &str| {
            let value = drawn.iter().find_map(|one| one.strip_prefix(key)?.strip_prefix('='));
            value.map_or_else(|| of_file(key), |value| value.trim().parse().ok())
        };
        let is_drawn = |key: &str| {
            drawn.iter().any(|one| one.starts_with(key) && one[key.len()..].starts_with('='))
        };
        let mut all = drawn.to_vec();
        if WAYS.iter().any(|[_, reverse]| is_drawn(reverse))
            || !WAYS.iter().any(|[forward, _]| is_drawn(forward))
        {
            return all;
        }
        let difference =
            WAYS.iter().find_map(|[forward, reverse]| Some(of_file(reverse)? - of_file(forward)?));
        let Some(difference) = difference else { return all };
        for [forward, reverse] in WAYS {
            let level =
                of_joint(forward).map(|level| format!("{reverse}={:?}", level + difference));
            all.extend(level);
        }
        all
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used, clippy::float_cmp)]
mod tests {
    use super::*;
    use crate::document::find;

    fn thesis() -> Document {
        Document::parse("step-response", find("step-response").unwrap().toml).unwrap()
    }

    /// The stick friction of this experiment is 0.4 V, and its slip friction 0.38 V.
    #[test]
    fn slip_that_is_drawn_above_stick_is_lowered_to_it() {
        for (drawn, [slip, stick]) in [
            (&["joint.friction.slip_v=0.42"][..], [0.4, 0.4]),
            (&["joint.friction.stick_v=0.3"], [0.3, 0.3]),
            (&["joint.friction.slip_v=0.5", "joint.friction.stick_v=0.45"], [0.45, 0.45]),
            (&["joint.friction.slip_v=0.3"], [0.3, 0.4]),
        ] {
            let mut document = thesis();
            let drawn: Vec<String> = drawn.iter().map(|one| (*one).to_owned()).collect();
            document.draw(&drawn).unwrap();
            let friction = document.machine().unwrap().joint.friction;
            assert_eq!([friction.slip_v, friction.stick_v], [slip, stick], "{drawn:?}");
        }
    }
}
