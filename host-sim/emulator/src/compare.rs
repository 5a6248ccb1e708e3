//! Compares two runs of the same experiment, bit for bit.

use std::fmt;

use stiction::Tick;
use stiction::control::signal::{MAX_LAW_SIGNALS, SIGNALS, value};

use simulator::closed_loop::LoopSample;

/// The first tick at which two runs differ.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Difference {
    /// Number of the tick in the motion.
    pub index: usize,
    /// Tick of the host; `None` if its run had ended.
    pub host: Option<Tick>,
    /// Tick of the image; `None` if its run had ended.
    pub image: Option<Tick>,
}

impl fmt::Display for Difference {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "host and image differ from tick {} on{}", self.index, self.signals())?;
        for (who, tick) in [("host ", &self.host), ("image", &self.image)] {
            match tick {
                Some(tick) => writeln!(f, "  {who} {tick:?}")?,
                None => writeln!(f, "  {who} has ended")?,
            }
        }
        Ok(())
    }
}

impl Difference {
    /// Returns the names of the signals that differ.
    fn signals(&self) -> String {
        let (Some(host), Some(image)) = (&self.host, &self.image) else { return String::new() };
        let names = SIGNALS.iter().map(|signal| signal.name).chain(["of the law"; MAX_LAW_SIGNALS]);
        let pairs = bits(host).into_iter().zip(bits(image)).zip(names);
        let differ: Vec<&str> = pairs.filter(|((a, b), _)| a != b).map(|(_, name)| name).collect();
        format!(", in {}", differ.join(", "))
    }
}

/// Returns the first tick that differs in a bit. Two runs of different length differ at the end of
/// the shorter one.
pub fn first_difference(host: &[LoopSample], image: &[LoopSample]) -> Option<Difference> {
    (0..host.len().max(image.len())).find_map(|index| {
        let tick = |moments: &[LoopSample]| moments.get(index).map(|moment| moment.tick);
        let (host, image) = (tick(host), tick(image));
        let same = match (&host, &image) {
            (Some(host), Some(image)) => same_bits(host, image),
            _ => false,
        };
        (!same).then_some(Difference { index, host, image })
    })
}

/// Returns whether all signals of two ticks have the same bits. For `==`, -0 would equal 0, and
/// equal NaNs would differ.
pub fn same_bits(a: &Tick, b: &Tick) -> bool {
    bits(a) == bits(b)
}

/// Returns the values of all signals.
fn bits(tick: &Tick) -> Vec<Option<u32>> {
    (0..SIGNALS.len() + MAX_LAW_SIGNALS).map(|place| value(tick, place)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn moment(tick: Tick) -> LoopSample {
        LoopSample {
            time_s: 0.0,
            tick,
            reference_deg: 0.0,
            position_deg: 0.0,
            at_encoder_deg: 0.0,
            at_load_deg: 0.0,
            motor_counts: None,
            velocity_deg_per_s: 0.0,
            applied_v: 0.0,
            stuck: true,
        }
    }

    #[test]
    fn equal_runs_have_no_difference() {
        let run =
            [moment(Tick::default()), moment(Tick { tick: 1, v: f32::NAN, ..Tick::default() })];
        assert_eq!(first_difference(&run, &run), None);
    }

    #[test]
    fn the_first_different_tick_is_shown_with_both_sides() {
        let host: Vec<LoopSample> =
            (0..5).map(|tick| moment(Tick { tick, ..Tick::default() })).collect();
        let mut image = host.clone();
        image[3].tick.code = 7;
        image[4].tick.code = 8;
        let found = first_difference(&host, &image).unwrap();
        assert_eq!(found.index, 3);
        assert_eq!((found.host.unwrap().code, found.image.unwrap().code), (0, 7));
        assert!(found.to_string().contains("from tick 3"), "{found}");
    }

    #[test]
    fn a_sign_of_zero_and_a_missing_end_are_differences() {
        let host = [moment(Tick::default()), moment(Tick { v_c: 0.0, ..Tick::default() })];
        let image = [moment(Tick::default()), moment(Tick { v_c: -0.0, ..Tick::default() })];
        assert_eq!(first_difference(&host, &image).unwrap().index, 1);
        let shorter = first_difference(&host, &image[..1]).unwrap();
        assert_eq!((shorter.index, shorter.image), (1, None));
    }
}
