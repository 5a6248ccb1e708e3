//! Whether the control task keeps its time.
//!
//! A free-running cycle counter is read on entry and on exit. A tick is late if it begins more than a quarter of
//! a period behind the one before, and long if it takes more than half a period. Both are overruns: a law whose
//! constants depend on the sample time is then not the one that was configured. The counter may wrap; a period is at
//! most 3.4 million cycles.

/// A deadline, in cycles of the processor.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Deadline {
    latest: u32,
    longest: u32,
    entered: Option<u32>,
}

impl Deadline {
    /// For a tick of `period` cycles.
    pub const fn new(period: u32) -> Self {
        Self { latest: period.saturating_add(period / 4), longest: period / 2, entered: None }
    }

    /// A tick begins at `cycle`; whether it is in time.
    ///
    /// ```
    /// let mut deadline = stiction::deadline::Deadline::new(1000);
    /// assert!(deadline.enter(u32::MAX - 499)); // the first has nothing to be late for
    /// assert!(deadline.enter(700)); // 1200 cycles later
    /// assert!(!deadline.enter(2000)); // 1300
    /// ```
    pub fn enter(&mut self, cycle: u32) -> bool {
        let in_time = self.entered.is_none_or(|before| cycle.wrapping_sub(before) <= self.latest);
        self.entered = Some(cycle);
        in_time
    }

    /// The tick ends at `cycle`; whether it was short enough.
    ///
    /// ```
    /// let mut deadline = stiction::deadline::Deadline::new(1000);
    /// deadline.enter(100);
    /// assert!(deadline.leave(600) && !deadline.leave(601));
    /// ```
    pub fn leave(&self, cycle: u32) -> bool {
        self.entered.is_none_or(|entered| cycle.wrapping_sub(entered) <= self.longest)
    }
}
