//! The rate limit of saves: twenty at once, and one more every ten minutes.
//!
//! A sector of the flash withstands ten thousand erases (data sheet), and a save erases one of two
//! sectors. A client that changes and saves without end, at two seconds a save, would wear both out
//! in 11 hours. With this limit, that needs 139 days.
//!
//! Does badly: the budget is full again after a reset.

use super::RequestRefusal;

/// Largest number of saves at once.
const FULL: u8 = 20;

/// Time after which one more save is possible, s.
const REFILL_S: f32 = 600.0;

/// The number of saves that are left, with its refills.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct SaveBudget {
    left: u8,
    /// The tick up to which the saves have been refilled.
    since: u32,
}

impl SaveBudget {
    /// All saves are left.
    pub const FULL: Self = Self { left: FULL, since: 0 };

    /// Uses up one save, at the tick `clock`; ticks are `sample_time` (s) apart.
    ///
    /// # Errors
    /// Returns the time until the next save is possible, if none is left.
    pub fn take(&mut self, clock: u32, sample_time: f32) -> Result<(), RequestRefusal> {
        // The conversion saturates: ten minutes are 6 000 000 ticks at most.
        let refill = ((REFILL_S / sample_time) as u32).max(1);
        let elapsed = clock.wrapping_sub(self.since);
        let gained = elapsed / refill;
        self.left = u32::from(self.left).saturating_add(gained).min(FULL.into()) as u8;
        self.since = self.since.wrapping_add(gained.wrapping_mul(refill));
        if self.left == 0 {
            let wait = refill.saturating_sub(elapsed % refill) as f32 * sample_time;
            return Err(RequestRefusal::SaveLater(libm::ceilf(wait) as u16));
        }
        if self.left == FULL {
            // Time counts for a refill once one is missing.
            self.since = clock;
        }
        self.left -= 1;
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn twenty_saves_are_possible_at_once_and_one_more_every_ten_minutes() {
        let mut budget = SaveBudget::FULL;
        // A clock that wraps on the way.
        let begin = u32::MAX - 1000;
        let mut take = |ticks: u32| budget.take(begin.wrapping_add(ticks), 0.02);
        assert!((0..20).all(|save| take(save).is_ok()));
        // 30 000 ticks of 20 ms are ten minutes, since the first save.
        assert_eq!(take(100), Err(RequestRefusal::SaveLater(598)));
        assert_eq!(take(29_999), Err(RequestRefusal::SaveLater(1)));
        assert_eq!(take(30_000), Ok(()));
        assert_eq!(take(30_001), Err(RequestRefusal::SaveLater(600)));
        assert_eq!([take(90_000), take(90_001)], [Ok(()), Ok(())]);
        assert!(take(90_002).is_err());
        // Hours do not save up more than twenty.
        let much: u32 = (0..40).map(|save| u32::from(take(10_000_000 + save).is_ok())).sum();
        assert_eq!(much, 20);
    }
}
