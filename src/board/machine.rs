//! The board as the machine that the link acts on: the control task's parts, locked as briefly as
//! possible.
//!
//! While the link holds the parts, the control task waits. Two requests hold them for longer. Their
//! instructions were counted in the image's code, and the times assume one cycle for each:
//!
//! - another motion, also while armed: about 360 instructions, 2.1 us, of which two copies of half
//!   a KiB are 180;
//! - the exchange of a control loop that has been prepared outside (`Servo::install`), with the
//!   output off: about 1250 instructions, 7.4 us, of which a swap of a KiB, 9 instructions for 8
//!   bytes, is 1180.
//!
//! Everything else is less than 200 instructions: reading a status, arming, the registers of
//! another PWM. The deadline allows a tick to begin a quarter of a period late, 25 us at 10 kHz.

use rtic::Mutex;
use stiction::link::{Machine, RequestRefusal};
use stiction::parameters::store::Store;
use stiction::{Hardware, Parameters, Servo};

use super::HARDWARE;
use super::brake_resistor::BrakeResistorSettings;
use super::bridge;
use super::control_task::{ControlTask, CurrentUse};
use super::sectors::{Sectors, Unset};
use super::tick::Period;
use super::traits::Watchdog;
use super::voltage_detector;
use super::watchdog::{CROSSING, Independent, Timeout};

/// The shared parts of the board, as the link's task may lock them.
pub struct BoardMachine<'a, C, W> {
    /// The control task's parts.
    pub control_task: &'a mut C,
    /// The watchdog, whose timeout follows the sample time.
    pub watchdog: &'a mut W,
    /// Clock of the timers on APB1, Hz.
    pub clock: u32,
    /// The parameter sectors.
    pub store: &'a mut Store<Sectors>,
}

impl<C: Mutex<T = ControlTask>, W: Mutex<T = Independent>> BoardMachine<'_, C, W> {
    /// Sets another timeout of the watchdog, and waits until this timeout and those set before it
    /// have crossed to the oscillator. Meanwhile it feeds the watchdog, since the other watched
    /// tasks wait as well. The timeout is in effect from the last of these feeds on.
    fn feed_with(&mut self, timeout: Timeout) -> Result<(), RequestRefusal> {
        let longest = (CROSSING * self.clock as f32) as u32;
        let begin = self.now();
        self.watchdog.lock(|watchdog| watchdog.set(timeout));
        loop {
            let is_set = self.watchdog.lock(|watchdog| {
                watchdog.feed();
                watchdog.is_set()
            });
            if is_set {
                break;
            }
            if self.now().wrapping_sub(begin) > longest {
                return Err(RequestRefusal::Watchdog);
            }
        }
        self.watchdog.lock(Watchdog::feed);
        Ok(())
    }

    /// Runs `act` on the flash, during which the processor stands still for seconds: the ticks are
    /// stopped, the output is off, and the watchdog has a longer timeout, with `after` set at the
    /// end. Nothing can arm meanwhile, since neither a tick nor another request comes before the
    /// end. Bytes received meanwhile are lost if they are more than the ring holds.
    fn stand_still(
        &mut self,
        after: Timeout,
        act: impl FnOnce(&mut Store<Sectors>) -> Result<(), RequestRefusal>,
    ) -> Result<(), RequestRefusal> {
        // If the supply failed during an erase, the contents of the sector would be lost.
        if voltage_detector::is_low() {
            return Err(RequestRefusal::SupplyTooLow);
        }
        let done = self.feed_with(Timeout::ERASE).and_then(|()| {
            self.control_task.lock(ControlTask::pause);
            let done = act(self.store);
            self.control_task.lock(|parts| {
                #[cfg(feature = "two-encoders")]
                parts.check_pause();
                parts.resume();
                // What was seen of joint and supply is seconds old.
                parts.servo.unsettle();
            });
            done
        });
        // If the timeout does not take effect in time, each of the next feeds tries again.
        let restored = self.feed_with(after);
        done.and(restored)
    }

    fn now(&mut self) -> u32 {
        self.control_task.lock(|parts| parts.stopwatch.now())
    }
}

impl<C: Mutex<T = ControlTask>, W: Mutex<T = Independent>> Machine for BoardMachine<'_, C, W> {
    fn servo<R>(&mut self, act: impl FnOnce(&mut Servo) -> R) -> R {
        self.control_task.lock(|parts| {
            parts.latch_break();
            let done = act(parts.servo);
            parts.mend();
            parts.watch_index();
            done
        })
    }

    fn hardware(&self) -> Hardware {
        HARDWARE
    }

    #[inline(never)]
    fn save(&mut self, parameters: &Parameters) -> Result<u32, RequestRefusal> {
        let after = Timeout::of_loop(parameters.controller.sample_time);
        self.stand_still(after, |store| Ok(store.save(parameters)?))?;
        if self.store.is_damaged() {
            self.stand_still(after, |store| Ok(store.erase_damaged()?))?;
        }
        Ok(self.store.saves())
    }

    #[inline(never)]
    fn set_brown_out(&mut self) -> Result<(), RequestRefusal> {
        let after = self.watchdog.lock(|watchdog| watchdog.timeout());
        self.stand_still(after, |store| {
            store.flash().set_brown_out().map_err(|unset| match unset {
                Unset::Untouchable(_) => RequestRefusal::Untouchable,
                Unset::Failed(_) => RequestRefusal::Flash,
            })
        })
    }

    #[inline(never)]
    fn reconfigure(&mut self, parameters: &Parameters) -> Result<(), RequestRefusal> {
        let sample_time = parameters.controller.sample_time;
        let (bridge, period) =
            (bridge::BridgeSettings::of(parameters), Period::new(sample_time, self.clock));
        // The watchdog comes first: the next tick, which lets the feeder run, may come later than
        // the old timeout.
        let before = self.watchdog.lock(|watchdog| watchdog.timeout());
        if let Err(refused) = self.feed_with(Timeout::of_loop(sample_time)) {
            self.watchdog.lock(|watchdog| watchdog.set(before));
            return Err(refused);
        }
        let current = CurrentUse::of(parameters);
        let brake_resistor = BrakeResistorSettings::of(parameters);
        self.control_task
            .lock(|parts| parts.reconfigure(&bridge, &period, current, &brake_resistor));
        Ok(())
    }
}
