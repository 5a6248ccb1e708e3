//! A joint that sticks, positioned in an application of RTIC 2 on an STM32F405.
//!
//! An encoder of 1024 lines at the motor, a gear of 50, a DC motor at 24 V behind a bridge with
//! inputs for PWM and direction. Each input has a pull-down: until the program has set its pins,
//! they are open. It has been compiled, and has run on no board.
#![no_std]
#![no_main]

use panic_halt as _;

#[rtic::app(device = stm32f4xx_hal::pac, peripherals = true)]
mod app {
    use stiction::positioner::{
        Counter, CounterBits, Direction, EncoderSide, MonitorConfig, Positioner, PositionerConfig,
        PositionerState, RunawayMonitors, RunawayState, Target,
    };
    use stm32f4xx_hal::gpio::{Output, PA4, PushPull};
    use stm32f4xx_hal::pac::{TIM1, TIM2, TIM3};
    use stm32f4xx_hal::prelude::*;
    use stm32f4xx_hal::qei::Qei;
    use stm32f4xx_hal::rcc::Config;
    use stm32f4xx_hal::timer::{CounterHz, Event, PwmChannel};

    const SUPPLY: f32 = 24.0;
    const TICKS_PER_S: u32 = 1000;

    /// In volts. `stiction new` and `stiction identify` find inertia and friction.
    const JOINT: PositionerConfig = PositionerConfig {
        sample_time: 1.0 / TICKS_PER_S as f32,
        counts_per_turn: 4.0 * 1024.0 * 50.0,
        largest_effort: SUPPLY,
        // 168 MHz by 20 kHz.
        effort_step: SUPPLY / 8400.0,
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

    #[shared]
    struct Shared {
        /// Where the joint should be, rad.
        angle: f32,
    }

    #[local]
    struct Local {
        positioner: Positioner,
        state: PositionerState,
        monitors: RunawayMonitors,
        watch: RunawayState,
        counter: Counter,
        encoder: Qei<TIM2>,
        pwm: PwmChannel<TIM1, 0>,
        direction: PA4<Output<PushPull>>,
        timer: CounterHz<TIM3>,
    }

    #[init]
    fn init(cx: init::Context) -> (Shared, Local) {
        let device = cx.device;
        let mut rcc = device.RCC.freeze(Config::hse(8.MHz()).sysclk(168.MHz()));
        let pins = device.GPIOA.split(&mut rcc);

        let encoder = Qei::new(device.TIM2, (pins.pa0, pins.pa1), &mut rcc);
        let (_, (channel, ..)) = device.TIM1.pwm_hz(20.kHz(), &mut rcc);
        let mut pwm = channel.with(pins.pa8);
        pwm.set_duty(0);
        pwm.enable();
        let direction = pins.pa4.into_push_pull_output();

        let mut timer = device.TIM3.counter_hz(&mut rcc);
        timer.start(TICKS_PER_S.Hz()).ok();
        timer.listen(Event::Update);

        // A refused configuration is a mistake of this file: the motor stays off.
        let Ok(positioner) = Positioner::new(&JOINT) else { cortex_m::asm::udf() };
        let Ok(monitors) = RunawayMonitors::new(&JOINT, &WATCH) else { cortex_m::asm::udf() };
        let counter = Counter::new(CounterBits::ThirtyTwo, Direction::Forward, encoder.count());
        let local = Local {
            state: positioner.start(),
            watch: monitors.start(counter.position()),
            positioner,
            monitors,
            counter,
            encoder,
            pwm,
            direction,
            timer,
        };
        (Shared { angle: 0.0 }, local)
    }

    /// The control task. Nothing has a higher priority.
    #[task(
        binds = TIM3,
        priority = 2,
        shared = [angle],
        local = [
            positioner, state, monitors, watch, counter, encoder, pwm, direction, timer,
            is_off: bool = false,
        ],
    )]
    fn tick(mut cx: tick::Context) {
        let local = cx.local;
        local.timer.clear_all_flags();
        let angle = cx.shared.angle.lock(|angle| *angle);
        let counts = local.counter.update(local.encoder.count());
        if *local.is_off {
            // The motor cools.
            local.monitors.idle(local.watch, counts);
            return;
        }
        let target = Target::at_rest(local.positioner.position(angle));
        let effort = local.positioner.tick(local.state, counts, target);
        let runaway = local.monitors.check(local.watch, counts, target, effort);
        if runaway.is_some() {
            // Until a reset.
            *local.is_off = true;
            // The channel stays on: one that is off would leave the bridge's input open.
            local.pwm.set_duty(0);
            return;
        }
        local.direction.set_state((effort < 0.0).into());
        let duty = effort.abs() / SUPPLY * f32::from(local.pwm.get_max_duty());
        local.pwm.set_duty(duty as u16);
    }

    /// Half a radian to either side.
    #[idle(shared = [angle])]
    fn idle(mut cx: idle::Context) -> ! {
        loop {
            for angle in [0.5, -0.5] {
                cx.shared.angle.lock(|target| *target = angle);
                cortex_m::asm::delay(2 * 168_000_000);
            }
        }
    }
}
