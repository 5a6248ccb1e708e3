//! The board: the microcontroller, its crystal, its supply, and what is on its pins.
//!
//! The emulated microcontroller is an STM32F427. It has everything of the STM32F405 that the
//! firmware uses, at the same addresses. An instruction takes one cycle of 168 MHz: there are no
//! wait states, so times measured here are counts of instructions, not cycles.

use std::num::{NonZeroU32, NonZeroU64};

use rigless::chip::uart::Rate;
use rigless::cpu::armv7m::windows;
use rigless::device::Level;
use rigless::machine::{Board, Target, armv7m};
use rigless::mcu::{Mcu, Operate};
use rigless::soc::Width;
use rigless::soc::stm32f427::Stm32f427;
use rigless::soc::stm32f427::generated::{flash, rcc};
use rigless::soc::stm32f427::peripherals::adc::Channel;
use rigless::soc::stm32f427::peripherals::gpio::{Gpio, Pin};
use rigless::store;
use rigless::time::VirtualNanos;

use super::as5047p::As5047p;
use super::uart::{USART1, Uart};
use files::error::Error;

/// Instructions per virtual second: one per cycle of the core's clock.
pub const CLOCK_HZ: NonZeroU64 = NonZeroU64::MIN.saturating_add(167_999_999);

const CRYSTAL_HZ: u64 = 8_000_000;
/// Last capture of TIM11. The crystal, divided as set in RCC_CFGR, triggers it. The emulated
/// microcontroller lacks this connection, and this board adds it.
pub const TIM11_CCR1: u64 = 0x4001_4834;
const TIM11_OR: u64 = 0x4001_4850;
const TIM11_CR1: u64 = 0x4001_4800;
const TIM11_CCMR1: u64 = 0x4001_4818;
const TIM11_CCER: u64 = 0x4001_4820;
/// Frequency of the internal oscillator, Hz, without its error.
const HSI_HZ: u64 = 16_000_000;
/// In RCC_CR: the crystal oscillates, and the PLL has locked.
const HSERDY: u64 = 1 << 17;
const PLLRDY: u64 = 1 << 25;
/// In RCC_PLLCFGR: the PLL runs from the crystal, divided by this.
const PLLSRC: u64 = 1 << 22;
const PLLM: u64 = 63;
/// Input frequencies on which the PLL locks, Hz (data sheet: 0.95 to 2.1 MHz).
const PLL_INPUT_HZ: std::ops::RangeInclusive<u64> = 950_000..=2_100_000;
/// In FLASH_OPTCR: the level of the brown-out reset; if both bits are 0, it is the highest level.
const BOR_LEV: u64 = 0b1100;
/// In RCC_CSR: the flag of a brown-out, and that of the reset pin, which every reset sets.
const BORRSTF: u64 = 1 << 25;
const PADRSTF: u64 = 1 << 26;
/// Typical frequency of the watchdog's oscillator, Hz. The data sheet's limits are 17 and 47 kHz.
const LSI_HZ: u64 = 32_000;
/// Control register, counter, prescaler and reload value of the control tick's timer.
const TIM3_CR1: u64 = 0x4000_0400;
const TIM3_CNT: u64 = 0x4000_0424;
const TIM3_PSC: u64 = 0x4000_0428;
const TIM3_ARR: u64 = 0x4000_042C;
/// Clock of TIM3 with the crystal and without it, as the firmware configures it, Hz.
const TIM3_HZ: [u64; 2] = [84_000_000, 16_000_000];
/// In RCC_CFGR: the processor runs from the PLL.
const RCC_CFGR: u64 = 0x4002_3808;
const SWS_PLL: u32 = 0b10 << 2;
const SWS: u32 = 0b11 << 2;
const RAIL_MV: u32 = 3_300;
/// PC0, which measures the supply of the bridge, is channel 10 of ADC1, and PC1, which measures the
/// motor's current, channel 11.
const SUPPLY_CHANNEL: u8 = 10;
/// PA6, which the contact of the emergency stop lifts.
const CONTACT_PIN: u8 = 6;
/// PA7, which the contact of the homing switch pulls to ground.
const SWITCH_PIN: u8 = 7;
const CURRENT_CHANNEL: u8 = 11;
/// PC2, which measures the motor's temperature.
const TEMPERATURE_CHANNEL: u8 = 12;
/// Control registers, mode of channels 3 and 4, counter and channel 4 of TIM1.
const TIM1_CR1: u64 = 0x4001_0000;
const TIM1_CR2: u64 = 0x4001_0004;
const TIM1_CCMR2: u64 = 0x4001_001C;
const TIM1_CNT: u64 = 0x4001_0024;
const TIM1_ARR: u64 = 0x4001_002C;
const TIM1_CCR4: u64 = 0x4001_0040;
/// Clock of TIM1 with the crystal and without it, as the firmware configures it, Hz.
const TIM1_HZ: [u64; 2] = [168_000_000, 16_000_000];
/// In TIM1_CR1: the timer counts, centre-aligned; and it counts down.
const COUNTS: u32 = 1;
const DOWN: u32 = 1 << 4;
/// In TIM1_CR2 and TIM1_CCMR2: the reference of channel 4, in PWM mode 2, is TRGO.
const MASTER_MODE: u32 = 0b111 << 4;
const OC4REF: u32 = 0b111 << 4;
const OC4_MODE: u32 = 0b111 << 12;
const OC4_PWM2: u32 = 0b111 << 12;
/// Second control register of ADC1. In it: the rising edge of TIM1_TRGO starts the injected group,
/// or a written bit does.
const ADC1_CR2: u64 = 0x4001_2008;
const INJECTED_TRIGGER: u32 = 0b11_1111 << 16;
const RISING_TIM1_TRGO: u32 = 0b01_0001 << 16;
const JSWSTART: u32 = 1 << 22;

/// Port of the microcontroller, by its place in the emulator's table.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum GpioPort {
    /// GPIOA.
    A = 0,
    /// GPIOB.
    B = 1,
    /// GPIOC.
    C = 2,
}

/// Components on the board; the default is a complete board.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct FittedParts {
    /// Whether the 8 MHz crystal is fitted and oscillates.
    pub crystal: bool,
    /// The frequency of the crystal, Hz.
    pub crystal_hz: u64,
    /// Whether the option bytes enable the brown-out reset, at 2.7 V. As delivered, it is off.
    pub brown_out: bool,
    /// Voltage on the pin that measures the bridge's supply, mV.
    pub supply_pin_mv: u32,
    /// Frequency of the oscillator that the watchdog counts, 17 to 47 kHz.
    pub lsi_hz: u64,
    /// Bytes that noise changes, of a million that the command link's port receives.
    pub noisy_bytes: u32,
}

impl Default for FittedParts {
    fn default() -> Self {
        Self {
            crystal: true,
            crystal_hz: CRYSTAL_HZ,
            brown_out: false,
            supply_pin_mv: RAIL_MV / 2,
            lsi_hz: LSI_HZ,
            noisy_bytes: 0,
        }
    }
}

/// The emulated microcontroller with what is wired to its pins.
#[derive(Debug)]
pub struct EmulatedBoard {
    /// The microcontroller.
    pub mcu: Stm32f427,
    crystal: bool,
    crystal_hz: u64,
    /// Whether the bridge's driver pulls the break input low.
    breaks: bool,
    /// Whether the contact of the emergency stop is open.
    is_contact_open: bool,
    noisy_bytes: u32,
}

store!(EmulatedBoard {
    values: [crystal, crystal_hz, breaks, is_contact_open, noisy_bytes],
    parts: [mcu],
    built: []
});

impl EmulatedBoard {
    /// Creates a board as delivered, without power.
    ///
    /// # Errors
    /// Returns an error if the emulator's description of the microcontroller contradicts itself.
    pub fn new(fitted: FittedParts) -> Result<Self, Error> {
        let mut mcu = Stm32f427::new().map_err(|error| Error::Emulator(error.to_string()))?;
        mcu.rcc.attach_crystals(if fitted.crystal { fitted.crystal_hz } else { 0 }, 0);
        mcu.rcc.calibrate_lsi(fitted.lsi_hz);
        mcu.set_supply(RAIL_MV);
        for converter in &mut mcu.adc {
            converter.set_reference(RAIL_MV);
        }
        let FittedParts { crystal, crystal_hz, brown_out, noisy_bytes, .. } = fitted;
        let mut board =
            Self { mcu, crystal, crystal_hz, breaks: false, is_contact_open: false, noisy_bytes };
        As5047p::fit(&mut board.mcu);
        if brown_out {
            let factory = board.option_bytes();
            board.set_option_bytes(factory & !BOR_LEV);
        }
        board.supply(fitted.supply_pin_mv);
        board.current(RAIL_MV / 2);
        // Its pull-up: the input is active low, and a cut wire must not turn the bridge off.
        board.drive_contact(VirtualNanos(0), false);
        Ok(board)
    }

    /// Returns FLASH_OPTCR: the option bytes in use.
    pub fn option_bytes(&mut self) -> u64 {
        self.mcu.program().1.get(flash::Register::Optcr)
    }

    /// Programs the option bytes, as a probe does.
    pub fn set_option_bytes(&mut self, word: u64) {
        let (program, registers) = self.mcu.program();
        let more = registers.get(flash::Register::Optcr1);
        program.keep_options(word, more, registers);
    }

    /// Returns the alternate function of a pin; `None` if it is a plain input or output.
    pub fn function(&mut self, port: GpioPort, pin: u8) -> Option<u8> {
        let (_, registers) = self.mcu.port(port as usize);
        Gpio::function(Pin::new(pin)?, registers)
    }

    /// Returns whether the level of a pin is high.
    pub fn is_high(&mut self, port: GpioPort, pin: u8) -> bool {
        let (port, registers) = self.mcu.port(port as usize);
        Pin::new(pin).is_some_and(|pin| port.level(pin, registers) == Level::High)
    }

    /// Pulls the break input of TIM1 low, as the fault output of a bridge's driver does, or
    /// releases it.
    pub fn drive_break(&mut self, at: VirtualNanos, active: bool) {
        self.breaks = active;
        // The contact of the emergency stop pulls the same input.
        let level = if active || self.is_contact_open { Level::Low } else { Level::High };
        self.mcu.drive_advanced_timer(at, 0, |timer, registers, context| {
            timer.drive_break(level, registers, context);
        });
    }

    /// Opens or closes the contact of the emergency stop. It lifts PA6; open, it pulls the break
    /// input low, and a gate behind PB0 keeps the bridge disabled, whatever the program does.
    pub fn drive_contact(&mut self, at: VirtualNanos, is_open: bool) {
        self.is_contact_open = is_open;
        let level = if is_open { Level::Low } else { Level::High };
        if let Some(pin) = Pin::new(CONTACT_PIN) {
            self.mcu.drive_port(at, GpioPort::A as usize, |port, registers, context| {
                port.drive(pin, Some(level), registers, context);
            });
        }
        self.drive_break(at, self.breaks);
    }

    /// Closes the contact of the homing switch, which pulls PA7 to ground, or opens it: PA7 then
    /// follows the resistor that the firmware has set.
    pub fn drive_switch(&mut self, at: VirtualNanos, is_open: bool) {
        let level = if is_open { None } else { Some(Level::Low) };
        if let Some(pin) = Pin::new(SWITCH_PIN) {
            self.mcu.drive_port(at, GpioPort::A as usize, |port, registers, context| {
                port.drive(pin, level, registers, context);
            });
        }
    }

    /// Returns whether the contact of the emergency stop is open.
    pub const fn is_contact_open(&self) -> bool {
        self.is_contact_open
    }

    /// Connects the far end of a wire to the command link's port.
    pub fn connect(&mut self, uart: &Uart) {
        if let Some(port) = self.mcu.usart.get_mut(USART1) {
            port.attach(uart.clone());
            port.errors_mut().noise = Rate { name: "noise", per_million: self.noisy_bytes };
        }
    }

    /// Restores the levels of the emergency stop's input and of the break input. Must be called
    /// after a reset of the emulated microcontroller, which loses these levels.
    pub fn reconnect(&mut self, at: VirtualNanos) {
        self.drive_contact(at, self.is_contact_open);
    }

    /// Stops the crystal.
    pub fn lose_crystal(&mut self, at: VirtualNanos) {
        self.crystal = false;
        self.mcu.rcc.attach_crystals(0, 0);
        self.mcu.drive_clocks(at, |rcc, registers, context| rcc.fail_hse(registers, context));
    }

    /// Sets the flags of the last reset to those of a brown-out. Must be called at the instant of
    /// that reset.
    pub fn flag_brown_out(&mut self) {
        let (_, registers) = self.mcu.clocks();
        registers.set(rcc::Register::Csr, BORRSTF | PADRSTF);
    }

    /// Sets the supply voltage of the microcontroller, mV.
    pub fn set_rail(&mut self, millivolts: u32) {
        self.mcu.set_supply(millivolts);
    }

    /// Sets the next capture of TIM11. Must be called when the last capture has been read. The
    /// timer counts the internal oscillator, and every eighth edge of the divided crystal captures
    /// the count, if all registers are set up as in RM0090.
    pub fn capture_crystal(&mut self, at: VirtualNanos) {
        let [configuration, remap, control, mode, enable] =
            [RCC_CFGR, TIM11_OR, TIM11_CR1, TIM11_CCMR1, TIM11_CCER]
                .map(|address| self.peek(at, address).unwrap_or(0));
        let divider = u64::from(configuration >> 16 & 31);
        let is_set_up = self.crystal
            && configuration & SWS == 0
            && divider > 1
            && (remap & 3, control & 1, mode & 0xFF, enable & 0xB) == (2, 1, 0b1101, 1);
        if is_set_up {
            let period = 8 * divider * 1_000_000_000 / self.crystal_hz;
            let captured = at.0 / period * period * HSI_HZ / 1_000_000_000;
            self.poke(at, TIM11_CCR1, (captured & 0xFFFF) as u32);
        }
    }

    /// Stops the counter of the control tick's timer.
    pub fn stop_tick(&mut self, at: VirtualNanos) {
        // A timer without a clock does not count either.
        let _ = self.mcu.write(at, TIM3_CR1, Width::W32, 0);
    }

    /// Sets the control tick's timer to its end, so that the tick comes now.
    pub fn early_tick(&mut self, at: VirtualNanos) {
        if let Some(reload) = self.peek(at, TIM3_ARR) {
            // A timer without a clock does not tick either.
            let _ = self.mcu.write(at, TIM3_CNT, Width::W32, reload.into());
        }
    }

    /// Returns the time between two control ticks as their timer is set, ns; `None` if the timer
    /// has no clock.
    pub fn tick_period_ns(&mut self, at: VirtualNanos) -> Option<u64> {
        let [prescaler, reload] = [TIM3_PSC, TIM3_ARR].map(|address| self.peek(at, address));
        let crystal = self.peek(at, RCC_CFGR)? & SWS == SWS_PLL;
        let hz = TIM3_HZ[usize::from(!crystal)];
        let clocks = (u64::from(prescaler?) + 1) * (u64::from(reload?) + 1);
        Some((clocks * 1_000_000_000 + hz / 2) / hz)
    }

    /// Sets the voltage on the pin that measures the bridge's supply, mV.
    pub fn supply(&mut self, pin_mv: u32) {
        self.convert(SUPPLY_CHANNEL, pin_mv);
    }

    /// Sets the voltage on the pin that measures the motor's current, mV.
    pub fn current(&mut self, pin_mv: u32) {
        self.convert(CURRENT_CHANNEL, pin_mv);
    }

    /// Sets the voltage on the pin that measures the motor's temperature, mV.
    pub fn temperature(&mut self, pin_mv: u32) {
        self.convert(TEMPERATURE_CHANNEL, pin_mv);
    }

    /// Sets the voltage on a channel of the converters, mV.
    fn convert(&mut self, channel: u8, pin_mv: u32) {
        for converter in &mut self.mcu.adc {
            if let Some(channel) = Channel::new(channel) {
                converter.set_input(channel, pin_mv);
            }
        }
    }

    /// Returns the next time at which TIM1 triggers the conversion of the current: its count rises
    /// to the compare value of channel 4. `None` if timer and converter are not set up for that.
    pub fn next_trigger(&mut self, at: VirtualNanos) -> Option<VirtualNanos> {
        let [control, master, mode, count, compare, converter, clocks] =
            [TIM1_CR1, TIM1_CR2, TIM1_CCMR2, TIM1_CNT, TIM1_CCR4, ADC1_CR2, RCC_CFGR]
                .map(|address| self.peek(at, address).unwrap_or(0));
        let is_set_up = control & COUNTS != 0
            && master & MASTER_MODE == OC4REF
            && mode & OC4_MODE == OC4_PWM2
            && converter & INJECTED_TRIGGER == RISING_TIM1_TRGO;
        let top = self.peek(at, TIM1_ARR).unwrap_or(0);
        let is_rising = control & DOWN == 0;
        let counts = match (is_rising, count < compare) {
            (true, true) => compare - count,
            // Past it: over the top, down to zero, and up again.
            (true, false) => top.saturating_sub(count) + top + compare,
            (false, _) => count + compare,
        };
        let hz = TIM1_HZ[usize::from(clocks & SWS != SWS_PLL)];
        let ns = (u64::from(counts) * 1_000_000_000).div_ceil(hz);
        is_set_up.then_some(VirtualNanos(at.0 + ns))
    }

    /// Triggers the conversion of the current, as TIM1 does. The emulated microcontroller lacks the
    /// line from the timer to the converter, and this board adds it.
    pub fn trigger_current(&mut self, at: VirtualNanos) {
        if let Some(control) = self.peek(at, ADC1_CR2) {
            self.poke(at, ADC1_CR2, control | JSWSTART);
        }
    }

    /// Clears the ready flags of an oscillator without a crystal and of a PLL whose input is out of
    /// its range. The models set these flags after the start-up time, so this must be called
    /// whenever the models have acted.
    pub fn settle(&mut self) {
        let hz = self.crystal_hz;
        let (_, registers) = self.mcu.clocks();
        let [control, pll] =
            [rcc::Register::Cr, rcc::Register::Pllcfgr].map(|register| registers.get(register));
        let mut never = if self.crystal { 0 } else { HSERDY };
        let input = (pll & PLLM > 0 && pll & PLLSRC != 0).then(|| hz / (pll & PLLM));
        if input.is_some_and(|hz| !PLL_INPUT_HZ.contains(&hz)) {
            never |= PLLRDY;
        }
        if control & never != 0 {
            registers.set(rcc::Register::Cr, control & !never);
        }
    }

    /// Writes a register as the core would now.
    pub fn poke(&mut self, at: VirtualNanos, address: u64, value: u32) {
        // A peripheral without a clock ignores the write on the real microcontroller as well.
        let _ = self.mcu.write(at, address, Width::W32, value.into());
    }

    /// Returns a register as the core would read it now; `None` if the peripheral has no clock.
    pub fn peek(&mut self, at: VirtualNanos, address: u64) -> Option<u32> {
        self.mcu.read(at, address, Width::W32).ok().map(|value| value as u32)
    }
}

impl Board for EmulatedBoard {
    fn name(&self) -> &'static str {
        "stiction"
    }

    fn target_names(&self) -> Vec<&'static str> {
        vec!["stm32f405"]
    }

    fn mcu(&mut self, target: usize) -> Option<&mut dyn Mcu> {
        (target == 0).then_some(&mut self.mcu)
    }

    fn targets(&mut self) -> Vec<Target<'_>> {
        let lines = u32::from(Operate::cpu(&self.mcu).interrupt_lines);
        let core = armv7m::Core {
            variant: armv7m::Variant::M4,
            clock_hz: CLOCK_HZ,
            interrupt_lines: NonZeroU32::new(lines).unwrap_or(NonZeroU32::MIN),
            priority_bits: 4,
            refclk_divider: NonZeroU32::MIN.saturating_add(7),
            instructions_per_second: CLOCK_HZ,
            boot: "flash",
        };
        let windows = windows(Mcu::bus(&self.mcu));
        let spec = core.spec_with_parts(&windows, armv7m::Fpu::FpV4Sp, armv7m::MpuRegions::Eight);
        vec![Target::new("stm32f405", &mut self.mcu, spec)]
    }
}
