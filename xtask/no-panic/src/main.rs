//! Shows by linking that the control path and the link cannot panic.
//!
//! The panic handler calls a function that is not defined. If the optimiser can show that no panic
//! is left, the handler goes, and its call with it, and the program links; if it cannot, the linker
//! names the function. The program is never run, and on a host it only says what it is. The control
//! path is everything that the control interrupt calls in the core, and the set-up before it: a
//! record is decoded, a servo is made, armed, ticked and stopped, and the deadline is entered and
//! left. `cargo xtask gates` looks at what the firmware adds around it in the image itself, by its
//! calls. For the link, a session is given any byte and any tick, and parameters are saved in a
//! flash that answers anything.
#![cfg_attr(target_os = "none", no_std, no_main)]
// Memory that the optimiser must not see through, and the function that is not there.
#![cfg_attr(target_os = "none", allow(unsafe_code))]

#[cfg(not(target_os = "none"))]
fn main() {
    println!("This is linked for the microcontroller and never run: `cargo xtask gates`.");
}

#[cfg(target_os = "none")]
mod path {
    use core::hint::black_box;

    use embedded_storage::nor_flash::{ErrorType, NorFlash, NorFlashErrorKind, ReadNorFlash};
    use stiction::link::{DeviceKind, Machine, RequestRefusal, Session};
    use stiction::parameters::store::Store;
    use stiction::safety::deadline::Deadline;
    use stiction::servo::{Boot, Input, Output};
    use stiction::{Fault, Hardware, Parameters, Servo};

    unsafe extern "C" {
        fn the_control_path_can_panic() -> !;
    }

    #[panic_handler]
    fn panic(_: &core::panic::PanicInfo<'_>) -> ! {
        // SAFETY: it never runs: a program that holds this call cannot be linked.
        unsafe { the_control_path_can_panic() }
    }

    /// A flash that answers anything.
    struct AnyFlash;

    impl ErrorType for AnyFlash {
        type Error = NorFlashErrorKind;
    }

    impl ReadNorFlash for AnyFlash {
        const READ_SIZE: usize = 1;

        fn read(&mut self, _: u32, bytes: &mut [u8]) -> Result<(), NorFlashErrorKind> {
            black_box(bytes);
            black_box(Ok(()))
        }

        fn capacity(&self) -> usize {
            black_box(0)
        }
    }

    impl NorFlash for AnyFlash {
        const WRITE_SIZE: usize = 4;
        const ERASE_SIZE: usize = 128 * 1024;

        fn erase(&mut self, _: u32, _: u32) -> Result<(), NorFlashErrorKind> {
            black_box(Ok(()))
        }

        fn write(&mut self, _: u32, bytes: &[u8]) -> Result<(), NorFlashErrorKind> {
            black_box(bytes);
            black_box(Ok(()))
        }
    }

    /// Any board.
    fn hardware() -> Hardware {
        black_box(Hardware {
            pwm_clock_hz: 168e6,
            supply_top: 4095,
            dead_time_max: 6e-6,
            sample_time: [1e-4, 0.02],
        })
    }

    /// The machine that a session acts on.
    struct Parts {
        servo: Servo,
        store: Store<AnyFlash>,
    }

    impl Machine for Parts {
        fn servo<R>(&mut self, act: impl FnOnce(&mut Servo) -> R) -> R {
            act(black_box(&mut self.servo))
        }

        fn hardware(&self) -> Hardware {
            hardware()
        }

        fn save(&mut self, parameters: &Parameters) -> Result<u32, RequestRefusal> {
            self.store.save(parameters)?;
            if self.store.is_damaged() {
                self.store.erase_damaged()?;
            }
            Ok(self.store.saves())
        }

        fn reconfigure(&mut self, parameters: &Parameters) -> Result<(), RequestRefusal> {
            black_box(parameters);
            black_box(Ok(()))
        }
    }

    /// The other place where the linker begins.
    #[unsafe(no_mangle)]
    extern "C" fn link_path() {
        let servo = black_box(Servo::blank());
        let mut parts = Parts { servo, store: Store::new(AnyFlash, black_box([0; 2])) };
        let mut session = Session::<768>::new(DeviceKind::Board, None);
        loop {
            let bytes: &[u8] = black_box(&[0; 16]);
            black_box(&mut session).receive(bytes, &mut parts);
            black_box(black_box(&mut session).work(&mut parts));
            let output: Output = black_box(parts.servo.tick(black_box(Input::default())));
            session.queue_sample(&output);
            black_box(session.transmit(black_box(&mut [0; 16])));
        }
    }

    /// Where the linker begins.
    #[unsafe(no_mangle)]
    extern "C" fn control_path() {
        // The optimiser knows nothing of what goes through the black box, and must assume any value
        // of it.
        let sector: &[u8] = black_box(&[0; 512]);
        let decoded = black_box(Parameters::decode(sector));
        let parameters = decoded.as_ref().map(|(parameters, _)| parameters).map_err(|error| *error);
        let boot: Boot = black_box(Boot::default());
        let mut servo = black_box(Servo::new(parameters, boot, &hardware()));
        let mut deadline = black_box(Deadline::new(black_box(1)));
        loop {
            let in_time = deadline.enter(black_box(1));
            let input: Input = black_box(Input::default());
            #[cfg(feature = "deliberate-panic")]
            black_box([1, 2, 3][black_box(3)]);
            black_box(servo.tick(input));
            if !in_time || !deadline.leave(black_box(1)) {
                servo.fault(black_box(Fault::Overrun));
            }
            if black_box(false) {
                let _ = black_box((servo.arm(), servo.arm_for_link(black_box(None))));
            }
            if black_box(false) {
                let _ = black_box((servo.clear(), servo.hold()));
                servo.heard();
            }
            if black_box(false) {
                servo.come_to_rest();
                servo.stop();
            }
            black_box((servo.state(), &servo));
            // Whatever state the servo may be in.
            servo = black_box(servo);
        }
    }
}
