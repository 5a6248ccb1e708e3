//! Bit for bit: where two runs of the same experiment part.

use std::fmt;

use stiction::Tick;

use crate::closed_loop::Moment;

/// The first tick at which two runs differ.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Difference {
    /// Which tick of the motion.
    pub index: usize,
    /// What the host computed; nothing if its run had ended.
    pub host: Option<Tick>,
    /// What the image computed; nothing if its run had ended.
    pub image: Option<Tick>,
}

impl fmt::Display for Difference {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "host and image differ from tick {} on", self.index)?;
        for (who, tick) in [("host ", &self.host), ("image", &self.image)] {
            match tick {
                Some(tick) => writeln!(f, "  {who} {tick:?}")?,
                None => writeln!(f, "  {who} has ended")?,
            }
        }
        Ok(())
    }
}

/// Finds the first tick that is not the same to the bit. Two runs that end at different ticks differ there.
pub fn first_difference(host: &[Moment], image: &[Moment]) -> Option<Difference> {
    (0..host.len().max(image.len())).find_map(|index| {
        let tick = |moments: &[Moment]| moments.get(index).map(|moment| moment.tick);
        let (host, image) = (tick(host), tick(image));
        let same = match (&host, &image) {
            (Some(host), Some(image)) => same_bits(host, image),
            _ => false,
        };
        (!same).then_some(Difference { index, host, image })
    })
}

/// Whether every term of two ticks has the same bits; `==` would take -0 for 0 and refuse equal NaNs.
pub fn same_bits(a: &Tick, b: &Tick) -> bool {
    bits(a) == bits(b)
}

type Bits = (u32, [i32; 2], [u32; 8], i16, (u16, bool), [bool; 2]);

fn bits(tick: &Tick) -> Bits {
    // Taken apart by name: a term that is added to `Tick` does not compile until it is compared.
    let Tick { tick, counts, setpoint, error, velocity, v_pd, v_c, v, code, duty, saturated, non_finite } =
        *tick;
    let floats =
        [setpoint.position.fraction, setpoint.velocity, setpoint.acceleration, error, velocity, v_pd, v_c, v];
    (
        tick,
        [counts, setpoint.position.counts],
        floats.map(f32::to_bits),
        code,
        (duty.compare, duty.reverse),
        [saturated, non_finite],
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    fn moment(tick: Tick) -> Moment {
        Moment {
            time_s: 0.0,
            tick,
            reference_deg: 0.0,
            position_deg: 0.0,
            velocity_deg_per_s: 0.0,
            applied_v: 0.0,
            stuck: true,
        }
    }

    #[test]
    fn equal_runs_have_no_difference() {
        let run = [moment(Tick::default()), moment(Tick { tick: 1, v: f32::NAN, ..Tick::default() })];
        assert_eq!(first_difference(&run, &run), None);
    }

    #[test]
    fn the_first_different_tick_is_shown_with_both_sides() {
        let host: Vec<Moment> = (0..5).map(|tick| moment(Tick { tick, ..Tick::default() })).collect();
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
