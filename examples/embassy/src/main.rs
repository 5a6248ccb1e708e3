//! A joint that sticks, positioned in a program of embassy on an STM32G431.
//!
//! An encoder of 1024 lines at the motor, a gear of 50, a DC motor at 24 V behind a bridge with
//! inputs for PWM and direction. Each input has a pull-down: until the program has set its pins,
//! they are open. It has been compiled, and has run on no board.
#![no_std]
#![no_main]

use embassy_executor::Spawner;
use embassy_stm32::gpio::{Level, Output, OutputType, Speed};
use embassy_stm32::peripherals::{TIM1, TIM3};
use embassy_stm32::time::khz;
use embassy_stm32::timer::qei::{Config, Qei};
use embassy_stm32::timer::simple_pwm::{PwmPin, SimplePwm};
use embassy_sync::blocking_mutex::raw::CriticalSectionRawMutex;
use embassy_sync::signal::Signal;
use embassy_time::{Duration, Ticker, Timer};
use panic_halt as _;
use stiction::positioner::{
    Counter, CounterBits, Direction, EncoderSide, MonitorConfig, Positioner, PositionerConfig,
    RunawayMonitors, Target,
};

const SUPPLY: f32 = 24.0;
const TICKS_PER_S: u64 = 1000;

/// In volts. `stiction new` and `stiction identify` find inertia and friction.
const JOINT: PositionerConfig = PositionerConfig {
    sample_time: 1.0 / TICKS_PER_S as f32,
    counts_per_turn: 4.0 * 1024.0 * 50.0,
    largest_effort: SUPPLY,
    // 16 MHz by 20 kHz.
    effort_step: SUPPLY / 800.0,
    inertia: 0.12,
    viscous: 0.9,
    breakaway: [0.9, 3.0],
    load: 0.0,
    hold_effort: 0.0,
    jitter: 0.0,
    speed: 0.0,
    acceleration: 0.0,
    encoder_side: EncoderSide::Motor,
};

const WATCH: MonitorConfig =
    MonitorConfig { range: [-1.5, 1.5], continuous_effort: 6.0, thermal_time: 10.0 };

/// Where the joint should be, rad.
static ANGLE: Signal<CriticalSectionRawMutex, f32> = Signal::new();

/// Half a radian to either side.
#[embassy_executor::main]
async fn main(spawner: Spawner) {
    let chip = embassy_stm32::init(embassy_stm32::Config::default());
    let encoder = Qei::new(chip.TIM3, chip.PA6, chip.PA7, Config::default());
    let pin = PwmPin::new(chip.PA8, OutputType::PushPull);
    let pwm = SimplePwm::new(chip.TIM1, Some(pin), None, None, None, khz(20), Default::default());
    let direction = Output::new(chip.PA4, Level::Low, Speed::Low);
    let Ok(task) = control(encoder, pwm, direction) else { return };
    spawner.spawn(task);
    loop {
        for angle in [0.5, -0.5] {
            ANGLE.signal(angle);
            Timer::after_secs(2).await;
        }
    }
}

/// The control loop; the motor is off after a monitor has tripped. Here it shares the executor with
/// everything else. Where another task can take longer than a fraction of a tick, give it an
/// executor of its own at an interrupt.
#[embassy_executor::task]
async fn control(
    encoder: Qei<'static, TIM3>,
    mut pwm: SimplePwm<'static, TIM1>,
    mut direction: Output<'static>,
) {
    // A refused configuration is a mistake of this file. It ends before the bridge gets a pulse.
    let Ok(positioner) = Positioner::new(&JOINT) else { cortex_m::asm::udf() };
    let Ok(monitors) = RunawayMonitors::new(&JOINT, &WATCH) else { cortex_m::asm::udf() };
    let reading = || u32::from(encoder.count());
    let mut counter = Counter::new(CounterBits::Sixteen, Direction::Forward, reading());
    let mut state = positioner.start();
    let mut watch = monitors.start(counter.position());
    let mut angle = 0.0;

    let mut channel = pwm.ch1();
    channel.set_duty_cycle_fully_off();
    channel.enable();
    let largest = channel.max_duty_cycle() as f32;
    let mut ticker = Ticker::every(Duration::from_hz(TICKS_PER_S));
    let mut is_off = false;
    loop {
        ticker.next().await;
        angle = ANGLE.try_take().unwrap_or(angle);
        let counts = counter.update(reading());
        if is_off {
            // The motor cools. The pins are held: a task that ends would let them go.
            monitors.idle(&mut watch, counts);
            continue;
        }
        let target = Target::at_rest(positioner.position(angle));
        let effort = positioner.tick(&mut state, counts, target);
        if monitors.check(&mut watch, counts, target, effort).is_some() {
            // Until a reset.
            is_off = true;
            channel.set_duty_cycle_fully_off();
            continue;
        }
        direction.set_level((effort < 0.0).into());
        channel.set_duty_cycle((effort.abs() / SUPPLY * largest) as u32);
    }
}
