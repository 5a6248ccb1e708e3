//! What the link acts on: the drive, locked for as short as can be.
//!
//! While the link holds it, the control task waits. The longest that it holds it for is
//! the copying of a joint that has been prepared outside (`Servo::install`): see `docs/cost.md` for its instructions. The
//! deadline allows a tick to begin a quarter of a period late, 25 us at 10 kHz, which are 4200 instructions.

use rtic::Mutex;
use stiction::link::Machine;
use stiction::store::SaveError;
use stiction::{Parameters, Servo};

use super::bridge;
use super::drive::Drive;
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
}

impl<D: Mutex<T = Drive>, W: Mutex<T = Independent>> Machine for BoardMachine<'_, D, W> {
    fn servo<R>(&mut self, act: impl FnOnce(&mut Servo) -> R) -> R {
        self.drive.lock(|drive| {
            let done = act(drive.servo);
            drive.mend();
            done
        })
    }

    fn save(&mut self, _: &Parameters) -> Result<(), SaveError> {
        Err(SaveError::Flash)
    }

    fn reconfigure(&mut self, parameters: &Parameters) {
        let sample_time = parameters.controller.sample_time;
        let (bridge, period) = (bridge::Settings::of(parameters), Period::new(sample_time, self.clock));
        self.drive.lock(|drive| drive.reconfigure(&bridge, &period));
        self.watchdog.lock(|watchdog| watchdog.set(Timeout::of_loop(sample_time)));
    }
}
