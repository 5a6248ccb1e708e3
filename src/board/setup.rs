//! The setup of the board, which starts every part in an order in which nothing can move by
//! accident.

use core::mem::MaybeUninit;

use stiction::parameters::DecodeError;
use stiction::parameters::store::Store;
use stiction::safety::deadline::Deadline;
use stiction::servo::Boot;
use stiction::{Parameters, Servo};
#[cfg(feature = "two-encoders")]
use stm32f4xx_hal::gpio::Speed;
use stm32f4xx_hal::gpio::{Alternate, PA2, PinState, Pull};
use stm32f4xx_hal::pac;
use stm32f4xx_hal::prelude::*;

use super::HARDWARE;
#[cfg(feature = "two-encoders")]
use super::absolute_encoder::AbsoluteEncoder;
use super::brake_resistor::{BrakeResistorOutput, BrakeResistorSettings};
use super::bridge::{self, Pins, TimerBridge};
use super::control_task::{ControlTask, CurrentUse};
use super::converter::Converter;
use super::crystal::Crystal;
use super::debugger::FreezeBits;
#[cfg(feature = "two-encoders")]
use super::encoder::LoadQuadrature;
use super::encoder::Quadrature;
use super::ntc::NtcInput;
use super::sectors::{SLOTS, Sectors};
use super::stopwatch::Stopwatch;
use super::tick::{Period, TickTimer};
use super::traits::IndexInput;
use super::usart::{Port, ReceiveQueue};
use super::watchdog::{Independent, Timeout};
use super::{clock, sectors, voltage_detector};

/// Sample time without parameters, s.
const IDLE_SAMPLE_TIME: f32 = 0.001;

/// The settings of the board: the parameters that the sectors hold, or the reason why there are
/// none.
pub struct BoardSettings {
    found: Result<(Parameters, u32, u8), DecodeError>,
    /// Whether a sector holds data that is no valid record.
    pub is_damaged: bool,
}

/// The board with every part running and the outputs off.
pub struct Board {
    /// The servo and the parts that a tick needs.
    pub control_task: ControlTask,
    /// The watchdog, which a task feeds.
    pub watchdog: Independent,
    /// The port of the link's wire.
    pub port: Port,
    /// Bytes received over the wire.
    pub received: ReceiveQueue,
    /// The input of the motor's NTC.
    pub ntc: NtcInput,
    /// The store in which parameters are saved.
    pub store: Store<Sectors>,
    /// State of the crystal.
    pub crystal: Crystal,
    /// Clock of the processor, Hz.
    pub clock: u32,
    /// Clock of the timers on APB1, Hz.
    pub timer_clock: u32,
}

impl BoardSettings {
    /// Reads the parameters, and refuses those that are not for this board.
    #[inline(never)]
    pub fn read() -> Self {
        let mut found = sectors::read();
        if let Ok((parameters, ..)) = &found
            && let Err(error) = parameters.fits(&HARDWARE)
        {
            found = Err(error);
        }
        Self { found, is_damaged: sectors::are_damaged() }
    }

    /// Returns how often parameters have been saved.
    pub fn saves(&self) -> u32 {
        self.found.as_ref().map_or(0, |(_, saves, _)| *saves)
    }

    /// Returns the parameters, or the reason why there are none.
    pub fn parameters(&self) -> Result<&Parameters, DecodeError> {
        self.found.as_ref().map(|(parameters, ..)| parameters).map_err(|error| *error)
    }

    /// Returns the number of the sector that the parameters are in.
    pub fn sector(&self) -> Option<u8> {
        self.found.as_ref().ok().map(|(.., sector)| *sector)
    }

    /// Returns the time between ticks, s.
    pub fn sample_time(&self) -> f32 {
        self.parameters().map_or(IDLE_SAMPLE_TIME, |parameters| parameters.controller.sample_time)
    }

    fn bridge(&self) -> bridge::BridgeSettings {
        self.parameters().map_or(bridge::BridgeSettings::IDLE, bridge::BridgeSettings::of)
    }
}

/// Starts every peripheral of the board. `boot` returns how the microcontroller came out of its
/// reset, given the state of the crystal.
pub fn start(
    device: pac::Peripherals,
    mut core: cortex_m::Peripherals,
    settings: &BoardSettings,
    place: &'static mut MaybeUninit<Servo>,
    boot: impl FnOnce(Crystal) -> Boot,
) -> Board {
    core.DCB.enable_trace();
    core.DWT.enable_cycle_counter();
    let freeze_bits = FreezeBits::new(device.DBGMCU);
    let timeout = Timeout::of_loop(settings.sample_time());
    let watchdog = Independent::start(device.IWDG, freeze_bits, timeout);
    voltage_detector::start(&device.RCC, &device.PWR);
    let (mut rcc, crystal) = clock::start(device.RCC, &device.TIM11);

    let a = device.GPIOA.split(&mut rcc);
    let b = device.GPIOB.split(&mut rcc);
    let c = device.GPIOC.split(&mut rcc);
    let pins = Pins {
        // The enable pin comes first: taking the port has reset it, and for an instant the pin's
        // resistor alone holds it.
        enable: b.pb0.into_push_pull_output_in_state(PinState::Low),
        brake: b.pb14.into_push_pull_output_in_state(PinState::Low),
        direction: b.pb1.into_push_pull_output_in_state(PinState::Low),
        high: a.pa8.into_alternate(),
        low: b.pb13.into_alternate(),
        fault: b.pb12.into_alternate().internal_resistor(Pull::Up),
    };
    // The contact of an emergency stop lifts it: an open wire is a stop.
    a.pa6.into_pull_down_input();
    // The contact of a homing switch pulls it to ground.
    a.pa7.into_pull_up_input();
    let bridge = TimerBridge::new(device.TIM1, pins, &settings.bridge(), &mut rcc);
    let brake_resistor = BrakeResistorOutput::start(
        device.TIM8,
        c.pc6.into_alternate().internal_resistor(Pull::Down),
        &mut rcc,
    );
    let encoder = Quadrature::start(
        device.TIM2,
        a.pa0.into_alternate().internal_resistor(Pull::Up),
        a.pa1.into_alternate().internal_resistor(Pull::Up),
        &mut rcc,
    );
    // An open wire is no index.
    let index: PA2<Alternate<1>> = a.pa2.into_alternate().internal_resistor(Pull::Down);
    encoder.capture_index(&index);
    #[cfg(feature = "two-encoders")]
    let load_encoder = LoadQuadrature::start(
        device.TIM4,
        b.pb6.into_alternate().internal_resistor(Pull::Up),
        b.pb7.into_alternate().internal_resistor(Pull::Up),
        &mut rcc,
    );
    #[cfg(feature = "two-encoders")]
    let absolute_encoder = AbsoluteEncoder::start(
        device.SPI3,
        // The slowest setting has edges as long as half a clock of the bus.
        c.pc8.into_push_pull_output_in_state(PinState::High).speed(Speed::Medium),
        (
            c.pc10.into_alternate().speed(Speed::Medium),
            // An open line reads as ones, which no angle is.
            c.pc11.into_alternate().internal_resistor(Pull::Up),
            c.pc12.into_alternate().speed(Speed::Medium),
        ),
        &mut rcc,
    );
    let converter_pins = (c.pc0.into_analog(), c.pc1.into_analog());
    let converter = Converter::start(device.ADC1, converter_pins, &mut rcc);
    let ntc = NtcInput::start(device.ADC2, c.pc2.into_analog(), &mut rcc);
    let timer_clock = rcc.clocks.timclk1().raw();
    let period = Period::new(settings.sample_time(), timer_clock);
    let timer = TickTimer::start(device.TIM3, &period, &mut rcc);
    let stopwatch = Stopwatch::start(device.TIM5, &mut rcc);
    let into = a.pa10.into_alternate().internal_resistor(Pull::Up);
    let out = a.pa9.into_alternate();
    let (port, received) = Port::start(device.USART1, device.DMA2, out, into, &mut rcc);
    let clock = rcc.clocks.sysclk().raw();
    let servo = blank(place);
    servo.boot(settings.parameters(), boot(crystal), &HARDWARE);
    let deadline = Deadline::new(period.clocks);
    let mut control_task = ControlTask {
        servo,
        deadline,
        encoder,
        #[cfg(feature = "two-encoders")]
        load_encoder,
        #[cfg(feature = "two-encoders")]
        absolute_encoder,
        #[cfg(feature = "two-encoders")]
        paused_at: 0,
        bridge,
        brake_resistor,
        converter,
        is_regulated: false,
        timer,
        stopwatch,
        period,
    };
    control_task.sense(settings.parameters().map_or(CurrentUse::None, CurrentUse::of));
    let of_file =
        settings.parameters().map_or(BrakeResistorSettings::NONE, BrakeResistorSettings::of);
    control_task.set_brake_resistor(&of_file);
    control_task.watch_index();
    if control_task.is_regulated {
        // The phase of the ticks to the PWM.
        control_task.resume();
    }
    let store = Store::new(Sectors::new(device.FLASH, core.SYST), SLOTS);
    Board { control_task, watchdog, port, received, ntc, store, crystal, clock, timer_clock }
}

/// Writes a blank servo to `place`. As a separate function, it frees its stack for the code that
/// follows.
#[inline(never)]
fn blank(place: &'static mut MaybeUninit<Servo>) -> &'static mut Servo {
    place.write(Servo::blank())
}
