//! The bridge on TIM1: PA8 and its complement PB13, enable PB0, direction PB1, break input PB12.
//! And PB14, which opens the holding brake.
//!
//! The PWM is centre-aligned: the counter runs up to the top and down again, so that a change of
//! duty moves both edges and current is best sampled at the ends. A new compare value takes effect
//! where the counter turns, at either end. The direction pin changes at once, so that on a reversal
//! the old magnitude has the new sign for half a period.
//!
//! Off means three things at once: the enable pin low, both outputs low (`MOE` clear, `OSSI`), and
//! a neutral duty preloaded. With an analog amplifier, off means only the enable pin low, with the
//! neutral duty on the output. [`super::output_control`] has the reason, and what each mode does
//! when the hardware ends the PWM.
//!
//! The break input is active low with a pull-up, to suit the open-drain fault output of a bridge
//! driver, and the contact of an emergency stop. It ends the PWM in hardware, without a clock, and
//! the PWM stays off. A cut wire is not detected. If a driver's fault output needs blanking
//! (`fault_blanking_s`), the input is off while the output is off and until the blanking is over,
//! which is before the first duty.

use core::convert::Infallible;

use embedded_hal::pwm::{ErrorType, SetDutyCycle};
use stiction::control::drive::{Drive, Duty, pwm_top};
use stiction::servo::BrakeCommand;
use stiction::{Parameters, Tick};
use stm32f4xx_hal::gpio::{Alternate, Output, PA8, PB0, PB1, PB12, PB13, PB14, PushPull};
use stm32f4xx_hal::pac;
use stm32f4xx_hal::rcc::{Enable, Rcc, Reset};

use super::HARDWARE;
use super::output_control::OutputControl;
use super::traits::Bridge;

/// The pins of the bridge.
pub struct Pins {
    /// Output of the PWM.
    pub high: PA8<Alternate<1>>,
    /// Complementary output of the PWM.
    pub low: PB13<Alternate<1>>,
    /// Break input, from the fault output of the bridge's driver.
    pub fault: PB12<Alternate<1>>,
    /// Enable output, which turns the bridge on.
    pub enable: PB0<Output<PushPull>>,
    /// Direction output: the sign, for a sign-magnitude bridge.
    pub direction: PB1<Output<PushPull>>,
    /// Output that opens the holding brake.
    pub brake: PB14<Output<PushPull>>,
}

/// The bridge: the PWM of TIM1 and the pins around it.
pub struct TimerBridge {
    pwm: Pwm,
    pins: Pins,
    neutral: Duty,
    neutral_when_off: bool,
    /// Time after the rise of the enable pin in which the break input (PB12) is disabled, ticks of
    /// the control loop.
    blanking: u32,
    /// Rest of that time, ticks.
    blanked: u32,
    has_brake: bool,
    /// [`OFF`], or while the outputs are on, whether the brake is closed ([`Tick::HELD`]).
    on: u32,
}

/// The outputs are off, and the brake is closed unless the bridge wakes up.
const OFF: u32 = 2;

/// The PWM on TIM1's first channel.
pub struct Pwm {
    timer: pac::TIM1,
    top: u16,
}

impl TimerBridge {
    /// Sets the PWM and the pins up with a neutral duty and the outputs off.
    pub fn new(timer: pac::TIM1, pins: Pins, settings: &BridgeSettings, rcc: &mut Rcc) -> Self {
        pac::TIM1::enable(rcc);
        pac::TIM1::reset(rcc);
        timer.ccmr1_output().write(|w| w.oc1m().pwm_mode1().oc1pe().enabled());
        // Channel 4 drives no pin. Its reference rises one count before the upper end, and is the
        // trigger of the current's conversion.
        timer.ccmr2_output().write(|w| w.oc4m().pwm_mode2().oc4pe().enabled());
        timer.cr2().write(|w| w.mms().compare_oc4());
        let pwm = Pwm { timer, top: settings.top };
        let mut bridge = Self {
            pwm,
            pins,
            neutral: settings.neutral,
            neutral_when_off: false,
            blanking: 0,
            blanked: 0,
            has_brake: false,
            on: OFF,
        };
        bridge.reconfigure(settings);
        let timer = &bridge.pwm.timer;
        timer.sr().write(|w| w.bif().clear_bit());
        timer.dier().write(|w| w.bie().set_bit());
        timer.cr1().write(|w| w.cms().center_aligned1().arpe().set_bit().cen().enabled());
        bridge
    }

    /// Sets another PWM, mode and dead time, with a neutral duty and the outputs off.
    pub fn reconfigure(&mut self, settings: &BridgeSettings) {
        let BridgeSettings { top, neutral, control, blanking, has_brake } = *settings;
        // Until the new mode is set, the pins are off as in the old mode.
        self.neutral_when_off = false;
        // The top takes effect where the counter turns, as the compare value does.
        self.pwm.timer.arr().write(|w| w.arr().set(top));
        self.pwm.timer.ccr4().write(|w| w.ccr().set(top.saturating_sub(1)));
        // Compare 0 would be full negative effort in locked antiphase, from the enabling of the
        // outputs to the first tick.
        self.off(neutral);
        (self.pwm.top, self.neutral) = (top, neutral);
        let timer = &self.pwm.timer;
        // Both outputs are active high, and low when idle: the reset values of the other bits.
        timer.ccer().write(|w| w.cc1e().set_bit().cc1ne().bit(control.complement));
        timer.bdtr().write(|w| {
            w.dtg()
                .set(control.dead_time_code)
                .ossi()
                .bit(control.driven_when_off)
                .ossr()
                .idle_level()
                .bke()
                .bit(blanking == 0)
                .bkp()
                .clear_bit()
        });
        timer.egr().write(|w| w.ug().set_bit());
        (self.neutral_when_off, self.blanking) = (control.neutral_when_off, blanking);
        self.has_brake = has_brake;
        self.rest();
    }

    /// Restarts the count at its lower end, with the output off.
    pub fn restart(&mut self) {
        self.pwm.timer.egr().write(|w| w.ug().set_bit());
    }

    /// Returns whether the outputs are on, as far as the program has set them.
    pub const fn is_on(&self) -> bool {
        self.on != OFF
    }

    /// As [`Bridge::drive`], for a duty that the current loop sets. The first one is neutral, as it
    /// was left.
    pub fn drive_regulated(&mut self, status: u32) -> bool {
        self.on != held(status) && self.change(status)
    }

    /// Turns the outputs off, whatever the last tick has set.
    pub fn rest(&mut self) {
        self.off(self.neutral);
    }

    /// Ends the duty: the outputs are off, or at the neutral duty with an analog amplifier.
    /// `breaks` turns the break input on or off.
    #[inline]
    fn release(&mut self, neutral: Duty, breaks: bool) {
        let neutral_when_off = self.neutral_when_off;
        self.pwm.timer.bdtr().modify(|_, w| w.moe().bit(neutral_when_off).bke().bit(breaks));
        self.pins.direction.set_low();
        let Ok(()) = self.pwm.set_duty_cycle(neutral.compare);
        self.on = OFF;
    }

    /// Turns the outputs on if they are off, and opens or closes the holding brake. Returns whether
    /// the outputs were off.
    #[cold]
    #[inline(never)]
    fn change(&mut self, status: u32) -> bool {
        let turns_on = self.on == OFF;
        self.on = held(status);
        if turns_on {
            // The same write turns the break input on and the outputs on with the first duty.
            self.pwm.timer.bdtr().modify(|_, w| w.moe().enabled().bke().enabled());
            self.pins.enable.set_high();
        }
        self.set_brake(if self.on == 0 { BrakeCommand::Open } else { BrakeCommand::Closed });
        turns_on
    }

    fn set_brake(&mut self, brake: BrakeCommand) {
        let opens = self.has_brake && brake == BrakeCommand::Open;
        self.pins.brake.set_state(opens.into());
    }

    /// Clears the flag of the break input, and returns whether the input has been released. The
    /// flag cannot be cleared while the input is active.
    pub fn break_is_over(&self) -> bool {
        let timer = &self.pwm.timer;
        timer.sr().write(|w| w.bif().clear_bit());
        timer.sr().read().bif().bit_is_clear()
    }
}

/// The settings of a bridge.
#[derive(Clone, Copy)]
pub struct BridgeSettings {
    /// Compare value of full duty.
    pub top: u16,
    /// Duty of no effort.
    pub neutral: Duty,
    /// Control of the outputs.
    pub control: OutputControl,
    /// Time after the rise of the enable pin in which the break input (PB12) is disabled, ticks of
    /// the control loop; 0: the break input is always enabled.
    pub blanking: u32,
    /// Whether there is a holding brake. Its output stays low otherwise.
    pub has_brake: bool,
}

impl BridgeSettings {
    /// Settings of a board without parameters: 22 kHz, with the output off.
    pub const IDLE: Self = Self {
        top: 3818,
        neutral: Duty { compare: 1909, reverse: false },
        control: OutputControl::UNKNOWN,
        blanking: 0,
        has_brake: false,
    };

    /// Returns the settings that the parameters define. The drive has been validated with the rest
    /// of them.
    pub fn of(parameters: &Parameters) -> Self {
        let drive = &parameters.controller.drive;
        let neutral =
            Drive::new(drive, &HARDWARE).map_or(Self::IDLE.neutral, |drive| drive.duty(0));
        Self {
            top: pwm_top(&HARDWARE, drive.pwm_hz).unwrap_or(Self::IDLE.top),
            neutral,
            control: OutputControl::of(
                drive.mode,
                parameters.device.dead_time,
                HARDWARE.pwm_clock_hz,
            ),
            blanking: parameters.ticks_at_least(parameters.device.fault_blanking),
            has_brake: parameters.device.brake_open > 0.0 || parameters.device.brake_close > 0.0,
        }
    }
}

impl ErrorType for Pwm {
    type Error = Infallible;
}

impl SetDutyCycle for Pwm {
    fn max_duty_cycle(&self) -> u16 {
        self.top
    }

    fn set_duty_cycle(&mut self, duty: u16) -> Result<(), Infallible> {
        self.timer.ccr1().write(|w| w.ccr().set(duty));
        Ok(())
    }
}

impl Bridge for TimerBridge {
    #[inline]
    fn drive(&mut self, duty: Duty, status: u32) -> bool {
        self.pins.direction.set_state(duty.reverse.into());
        let Ok(()) = self.pwm.set_duty_cycle(duty.compare);
        self.on != held(status) && self.change(status)
    }

    fn wake(&mut self, neutral: Duty, brake: BrakeCommand) {
        let is_blanked = self.blanked > 0;
        self.blanked = self.blanked.saturating_sub(1);
        self.release(neutral, !is_blanked);
        self.pins.enable.set_high();
        self.set_brake(brake);
    }

    #[inline]
    fn off(&mut self, neutral: Duty) {
        self.blanked = self.blanking;
        // A driver that pulls its fault output as it falls asleep finds the break input off.
        self.release(neutral, self.blanking == 0);
        self.pins.enable.set_low();
        self.pins.brake.set_low();
    }
}

/// Returns 1 if a tick with this status holds the brake closed, otherwise 0. It is the highest bit,
/// which a comparison shifts on the way.
#[inline]
const fn held(status: u32) -> u32 {
    status >> Tick::HELD.trailing_zeros()
}

/// Drives the enable pin and that of the holding brake low, before the parameters are read and
/// before the clock is started, which may wait for a crystal for 50 ms.
/// Before this, and in reset, a resistor of the board holds each pin.
pub fn hold_enable_low(rcc: &pac::RCC, port: &pac::GPIOB) {
    rcc.ahb1enr().modify(|_, w| w.gpioben().enabled());
    // The port's clock has to arrive before the port is written.
    cortex_m::asm::dsb();
    port.bsrr().write(|w| w.br0().set_bit().br14().set_bit());
    port.moder().modify(|_, w| w.moder0().output().moder14().output());
}

/// Turns the bridge off and closes the holding brake from anywhere, whatever state the program is
/// in. With an analog amplifier this also releases the pin of the PWM, and the next [`Bridge::off`]
/// restores the neutral duty.
pub fn off_now() {
    // SAFETY: one write to a set/reset register, which cannot disturb another pin, and one that
    // only clears MOE; neither depends on anything that the program owns.
    unsafe {
        (*pac::GPIOB::ptr()).bsrr().write(|w| w.br0().set_bit().br14().set_bit());
        (*pac::TIM1::ptr()).bdtr().modify(|_, w| w.moe().disabled_idle());
    }
}

/// Sets a duty from the interrupt of the current loop.
#[inline]
pub fn set_duty(duty: Duty) {
    // SAFETY: one write to a set/reset register, and one to the compare value. The control task
    // writes both while the current loop's interrupt is disabled, or before it turns the bridge
    // off.
    unsafe {
        (*pac::GPIOB::ptr()).bsrr().write(|w| match duty.reverse {
            true => w.bs1().set_bit(),
            false => w.br1().set_bit(),
        });
        (*pac::TIM1::ptr()).ccr1().write(|w| w.ccr().set(duty.compare));
    }
}

/// Disables the break interrupt: the input may stay active forever, and its flag with it.
pub fn silence_break() {
    // SAFETY: this register is touched by the task of that interrupt, and by others that have
    // locked it out.
    unsafe { (*pac::TIM1::ptr()).dier().modify(|_, w| w.bie().clear_bit()) };
}

/// Enables the break interrupt again. The caller must have locked out its task.
pub fn hear_break() {
    // SAFETY: as above.
    unsafe { (*pac::TIM1::ptr()).dier().modify(|_, w| w.bie().set_bit()) };
}
