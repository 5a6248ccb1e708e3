//! Shows by linking that the library fits into the program of another board, and cannot panic.
//!
//! The program has a start-up, a memory and a critical section of its own, so it does not link if
//! the library brings one. Its panic handler calls a function that is not defined, as that of
//! `no-panic` does. It is never run, and on a host it only says what it is. `cargo xtask gates`
//! links it.
#![cfg_attr(target_os = "none", no_std, no_main)]
// Memory that the optimiser must not see through, and the function that is not there.
#![cfg_attr(target_os = "none", allow(unsafe_code))]

#[cfg(not(target_os = "none"))]
fn main() {
    println!("This is linked for the microcontroller and never run: `cargo xtask gates`.");
}

#[cfg(target_os = "none")]
mod program {
    use core::hint::black_box;

    use cortex_m_rt::entry;
    use critical_section::{Impl, RawRestoreState};
    unsafe extern "C" {
        fn the_positioner_can_panic() -> !;
    }

    #[panic_handler]
    fn panic(_: &core::panic::PanicInfo<'_>) -> ! {
        // SAFETY: it never runs: a program that holds this call cannot be linked.
        unsafe { the_positioner_can_panic() }
    }

    struct NoInterrupts;
    critical_section::set_impl!(NoInterrupts);

    // SAFETY: this program has no interrupts.
    unsafe impl Impl for NoInterrupts {
        unsafe fn acquire() -> RawRestoreState {
            Default::default()
        }

        unsafe fn release(_: RawRestoreState) {}
    }

    #[entry]
    fn main() -> ! {
        critical_section::with(|_| ());
        #[cfg(feature = "robust")]
        super::robust::run();
        #[cfg(feature = "pd")]
        super::pd::run();
        #[cfg(feature = "path")]
        super::path::run();
        #[cfg(feature = "deliberate-panic")]
        assert!(black_box(true));
        loop {
            black_box(());
        }
    }
}

/// A configuration, counters and targets that the optimiser knows nothing about.
#[cfg(all(target_os = "none", any(feature = "robust", feature = "pd")))]
mod unknown {
    use core::hint::black_box;

    use stiction::positioner::{Position, Target};

    pub fn target() -> Target {
        Target {
            position: Position { counts: black_box(0), fraction: black_box(0.0) },
            velocity: black_box(0.0),
            acceleration: black_box(0.0),
        }
    }
}

#[cfg(all(target_os = "none", feature = "robust"))]
mod robust {
    use core::hint::black_box;

    use stiction::positioner::{EncoderSide, Positioner, PositionerConfig};

    pub fn run() {
        let [low, high, other] = black_box([0.0; 3]);
        let config = black_box(PositionerConfig {
            sample_time: other,
            counts_per_turn: other,
            largest_effort: other,
            effort_step: other,
            inertia: other,
            viscous: other,
            breakaway: [low, high],
            load: other,
            hold_effort: other,
            jitter: other,
            speed: other,
            acceleration: other,
            encoder_side: EncoderSide::Motor,
        });
        let Ok(positioner) = Positioner::new(&config) else { return };
        let mut state = positioner.start();
        #[cfg(feature = "monitors")]
        let mut watch = super::monitors::Watch::new(&config);
        while black_box(true) {
            if black_box(false) {
                positioner.restart(&mut state);
                positioner.try_again(&mut state);
            }
            let (counts, applied) = black_box((0, 0.0));
            let target = super::unknown::target();
            let effort = positioner.tick_applied(&mut state, counts, target, applied);
            #[cfg(feature = "monitors")]
            watch.look(counts, target, effort);
            black_box(effort);
            black_box(positioner.mode(&state));
        }
    }
}

#[cfg(all(target_os = "none", feature = "monitors"))]
mod monitors {
    use core::hint::black_box;

    use stiction::positioner::{
        MonitorConfig, PositionerConfig, RunawayMonitors, RunawayState, Target,
    };

    pub struct Watch(Option<(RunawayMonitors, RunawayState)>);

    impl Watch {
        pub fn new(joint: &PositionerConfig) -> Self {
            let [low, high, other] = black_box([0.0; 3]);
            let config =
                MonitorConfig { range: [low, high], continuous_effort: other, thermal_time: other };
            let monitors = RunawayMonitors::new(joint, &config).ok();
            Self(monitors.map(|monitors| {
                let state = monitors.start(black_box(0));
                (monitors, state)
            }))
        }

        pub fn look(&mut self, counts: i32, target: Target, effort: f32) {
            let Some((monitors, state)) = &mut self.0 else { return };
            if black_box(false) {
                monitors.idle(state, counts);
                *state = monitors.armed(state, counts);
            }
            black_box(monitors.check(state, counts, target, effort));
        }
    }
}

#[cfg(all(target_os = "none", feature = "pd"))]
mod pd {
    use core::hint::black_box;

    use stiction::control::laws::{SmoothRobustNonlinear, SmoothRobustNonlinearGains};
    use stiction::positioner::{PdConfig, PdPositioner};

    pub fn run() {
        let other = black_box(0.0);
        let config = black_box(PdConfig {
            sample_time: other,
            counts_per_turn: other,
            largest_effort: other,
            effort_step: other,
            kp: other,
            kd: other,
            velocity_window: 5,
        });
        let gains = SmoothRobustNonlinearGains { v_ms: other, alpha: other };
        let Ok(positioner) = PdPositioner::<SmoothRobustNonlinear>::new(&config, &gains) else {
            return;
        };
        let mut state = positioner.start();
        while black_box(true) {
            if black_box(false) {
                positioner.restart(&mut state);
            }
            black_box(positioner.tick(&mut state, black_box(0), super::unknown::target()));
        }
    }
}

#[cfg(all(target_os = "none", feature = "path"))]
mod path {
    use core::hint::black_box;

    use stiction::positioner::{
        Counter, CounterBits, Direction, MoveConfig, MoveProfile, Position,
    };

    pub fn run() {
        let other = black_box(0.0);
        let config = black_box(MoveConfig {
            sample_time: other,
            counts_per_turn: other,
            speed: other,
            acceleration: other,
            jerk: other,
        });
        let mut counter = Counter::new(CounterBits::Sixteen, Direction::Forward, black_box(0));
        let at = Position::from_counts(counter.position());
        let Ok(mut path) = MoveProfile::new(&config, at) else { return };
        path.aim(black_box(at));
        while path.is_moving() {
            black_box(counter.update(black_box(0)));
            black_box(path.update());
            if black_box(false) {
                path.stop();
            }
        }
        counter.set_position(black_box(0));
        path.restart(at);
        black_box((&counter, &path));
    }
}
