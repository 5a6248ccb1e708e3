//! What the link acts on: the drive, locked for as short as can be.
//!
//! While the link holds it, the control task waits. The longest that it holds it for is the exchange of a joint that has
//! been prepared outside (`Servo::install`): 1090 instructions, counted in the image's code, 6.5 us if each takes one cycle.
//! Everything else is less than 200: reading a status, arming, another reference, the registers of another PWM. The deadline
//! allows a tick to begin a quarter of a period late, 25 us at 10 kHz.

use rtic::Mutex;
use stiction::link::Machine;
use stiction::store::{SaveError, Store};
use stiction::{Parameters, Servo};

use super::bridge;
use super::drive::Drive;
use super::seams::Watchdog;
use super::sectors::Sectors;
use super::tick::Period;
use super::watchdog::{Independent, Timeout};

/// The shared parts of the board, as the link's task may lock them.
pub struct BoardMachine<'a, D, W> {
    /// Servo and bridge.
    pub drive: &'a mut D,
    /// The watchdog, whose timeout follows the sample time.
    pub watchdog: &'a mut W,
    /// Clock of the timers on APB1, Hz.
    pub clock: u32,
    /// The parameter sectors.
    pub store: &'a mut Store<Sectors>,
}

/// Looks at the watchdog's status until a timeout has crossed to its oscillator: five clocks of the slowest are 0.3 ms, in
/// which no program looks ten thousand times.
const LOOKS: u32 = 10_000;

impl<D, W: Mutex<T = Independent>> BoardMachine<'_, D, W> {
    /// Feeds the watchdog with another timeout; whether it is in use.
    fn feed_with(&mut self, timeout: Timeout) -> bool {
        self.watchdog.lock(|watchdog| {
            watchdog.set(timeout);
            watchdog.feed();
        });
        let is_set = (0..LOOKS).any(|_| self.watchdog.lock(|watchdog| watchdog.is_set()));
        self.watchdog.lock(Watchdog::feed);
        is_set
    }
}

impl<D: Mutex<T = Drive>, W: Mutex<T = Independent>> Machine for BoardMachine<'_, D, W> {
    fn servo<R>(&mut self, act: impl FnOnce(&mut Servo) -> R) -> R {
        self.drive.lock(|drive| {
            drive.latch_break();
            let done = act(drive.servo);
            drive.mend();
            done
        })
    }

    /// The processor stands still for seconds: no ticks, nothing driven, a watchdog that waits. Nothing can arm meanwhile,
    /// since neither a tick nor another request comes before the end. Whatever came over the wire meanwhile is lost.
    fn save(&mut self, parameters: &Parameters) -> Result<(), SaveError> {
        let timeout = Timeout::of_loop(parameters.controller.sample_time);
        let saved = if self.feed_with(Timeout::ERASE) {
            self.drive.lock(Drive::pause);
            let saved = self.store.save(parameters);
            self.drive.lock(Drive::resume);
            saved
        } else {
            Err(SaveError::Flash)
        };
        self.watchdog.lock(|watchdog| {
            watchdog.set(timeout);
            watchdog.feed();
        });
        saved
    }

    fn reconfigure(&mut self, parameters: &Parameters) {
        let sample_time = parameters.controller.sample_time;
        let (bridge, period) = (bridge::Settings::of(parameters), Period::new(sample_time, self.clock));
        // First: the next tick, which lets the feeder run, may come later than the old timeout.
        self.feed_with(Timeout::of_loop(sample_time));
        self.drive.lock(|drive| drive.reconfigure(&bridge, &period));
    }
}
