//! Control steps to be counted by `cargo xtask cost` as the core's tick is. On a host this program
//! only says so.
//!
//! Two are steps that a reader may know: the `pid` crate, and a textbook PD loop with a `tanh` of
//! the error against friction. Both take the set point and the position in degrees and give volts.
//! Neither has what the core's tick does besides: a counter that wraps, velocity by least squares,
//! a reference that is computed, checks for finite numbers, a drive code and a compare value.
//!
//! Three are the face for a firmware of your own (`face.rs`): `robust`, its monitors, and PD with
//! a law, around a joint that sticks.
#![cfg_attr(target_os = "none", no_std, no_main)]
// Memory that the emulator writes to and reads.
#![cfg_attr(target_os = "none", allow(unsafe_code))]

#[cfg(not(target_os = "none"))]
fn main() {
    println!("This runs on the emulated microcontroller: `cargo xtask cost`.");
}

#[cfg(target_os = "none")]
mod face;

#[cfg(target_os = "none")]
mod steps {
    use core::cell::UnsafeCell;

    use cortex_m as _;
    use cortex_m_rt::entry;
    use pid::Pid;

    /// The gains of the thesis's SRNF, as far as there are any; the integral is the yardstick's
    /// own.
    const KP: f32 = 1.0;
    const KI: f32 = 0.01;
    const KD_PER_TICK: f32 = 0.25 / 0.02;
    const V_SLIP: f32 = 0.37;
    const ALPHA: f32 = 100.0;
    const FULL_SCALE: f32 = 5.0;

    /// A cell that the emulator looks into.
    struct Window(UnsafeCell<[f32; 2]>);

    // SAFETY: there is one thread and no interrupt; the emulator writes between two instructions.
    unsafe impl Sync for Window {}

    /// Set point and position, deg.
    static INPUT: Window = Window(UnsafeCell::new([0.0; 2]));
    /// Outputs of both steps, V.
    static OUTPUT: Window = Window(UnsafeCell::new([0.0; 2]));

    #[entry]
    fn main() -> ! {
        let mut pid = Pid::new(0.0, FULL_SCALE);
        pid.p(KP, FULL_SCALE).i(KI, FULL_SCALE).d(KD_PER_TICK, FULL_SCALE);
        let mut last = 0.0;
        let mut face = crate::face::Face::new();
        loop {
            // SAFETY: reads and writes of statics that nothing in the program borrows.
            let [setpoint, position] = unsafe { INPUT.0.get().read_volatile() };
            let v = [
                pid_step(&mut pid, setpoint, position),
                pd_tanh_step(&mut last, setpoint, position),
            ];
            // SAFETY: as above.
            unsafe { OUTPUT.0.get().write_volatile(v) };
            if let Some(face) = &mut face {
                face.step();
            }
        }
    }

    #[inline(never)]
    fn pid_step(pid: &mut Pid<f32>, setpoint: f32, position: f32) -> f32 {
        pid.setpoint = setpoint;
        pid.next_control_output(position).output
    }

    #[inline(never)]
    fn pd_tanh_step(last: &mut f32, setpoint: f32, position: f32) -> f32 {
        let error = setpoint - position;
        let change = error - *last;
        *last = error;
        let v = KP * error + KD_PER_TICK * change + V_SLIP * libm::tanhf(ALPHA * error);
        v.clamp(-FULL_SCALE, FULL_SCALE)
    }

    #[panic_handler]
    fn panic(_: &core::panic::PanicInfo<'_>) -> ! {
        loop {
            cortex_m::asm::nop();
        }
    }
}
