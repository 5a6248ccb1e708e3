//! The deadline of the control task: it detects ticks that begin too late or take too long.
//!
//! A free-running counter is read on entry and on exit; it must not stop while the processor
//! sleeps. A tick is due a period after the tick before. It is late if it begins more than a
//! quarter of a period after that time, and long if it takes more than half a period. Both are
//! overruns: the law's constants depend on the sample time, which is then not the configured one.
//! The counter may wrap.

/// The deadline of a tick, in clocks of the counter.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Deadline {
    latest: u32,
    longest: u32,
    entered: Option<u32>,
}

impl Deadline {
    /// Makes the deadline of a tick of `period` clocks.
    pub const fn new(period: u32) -> Self {
        Self { latest: period.saturating_add(period / 4), longest: period / 2, entered: None }
    }

    /// Records the start of a tick at `clock`, and returns whether the tick is in time.
    ///
    /// ```
    /// let mut deadline = stiction::safety::deadline::Deadline::new(1000);
    /// assert!(deadline.enter(u32::MAX - 499)); // the first has nothing to be late for
    /// assert!(deadline.enter(700)); // 1200 clocks later
    /// assert!(!deadline.enter(2000)); // 1300
    /// ```
    pub fn enter(&mut self, clock: u32) -> bool {
        let in_time = self.entered.is_none_or(|before| clock.wrapping_sub(before) <= self.latest);
        self.entered = Some(clock);
        in_time
    }

    /// Returns whether the tick, which ends at `clock`, was short enough.
    ///
    /// ```
    /// let mut deadline = stiction::safety::deadline::Deadline::new(1000);
    /// deadline.enter(100);
    /// assert!(deadline.leave(600) && !deadline.leave(601));
    /// ```
    pub fn leave(&self, clock: u32) -> bool {
        self.entered.is_none_or(|entered| clock.wrapping_sub(entered) <= self.longest)
    }
}
