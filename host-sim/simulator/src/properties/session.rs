//! Property of a session with a device: with any input, a faulted drive is not armed, and no drive
//! leaves its limits.

use stiction::control::drive::Drive;
use stiction::device::Device;
use stiction::link::{Deframer, NO_SESSION, Request, decode_request, encode};
use stiction::parameters::store::Store;
use stiction::safety::fault::LatchedFault;
use stiction::servo::{Boot, EncoderReading, Input, State};
use stiction::{Fault, Parameters};

use crate::flash::{SECTOR, SimulatedFlash};
use files::hardware::STM32F405;

/// A device whose properties are checked in every tick.
#[derive(Debug)]
pub struct CheckedDevice {
    device: Option<Device<SimulatedFlash>>,
    /// Decoder of the same bytes, which detects requests that end a fault.
    deframer: Deframer,
    counter: u32,
    /// Ticks with the output on.
    pub armed: u64,
    /// Ticks with the output on during a move.
    pub moved: u64,
    /// Ticks with a fault.
    pub faulted: u64,
}

impl CheckedDevice {
    /// Powers a device up.
    pub fn new(parameters: &Parameters) -> Self {
        let mut store = Store::new(SimulatedFlash::new(2), [0, SECTOR]);
        // Cannot fail: the flash is new.
        let _ = store.save(parameters);
        let device = Some(Device::start(store, Boot::at_zero(), STM32F405));
        Self { device, deframer: Deframer::default(), counter: 0, armed: 0, moved: 0, faulted: 0 }
    }

    fn state(&mut self) -> State {
        self.device.as_mut().map_or(State::Boot, |device| device.servo().state())
    }

    /// Returns the number of the session.
    pub fn session(&self) -> u32 {
        self.device.as_ref().map_or(NO_SESSION, Device::session)
    }

    /// Resets the device if no command can clear its fault.
    pub fn revive(&mut self) {
        if let State::Faulted(fault) = self.state()
            && !fault.is_clearable()
            && let Some(device) = self.device.take()
        {
            self.device = Some(Device::start(device.end(), Boot::at_zero(), STM32F405));
        }
    }

    /// Receives bytes from the wire, and asserts that only a clear request or new parameters end a
    /// fault, and that no bytes latch one but an emergency stop behind it.
    pub fn receive(&mut self, bytes: &[u8]) {
        let before = self.state();
        let mut may_clear = false;
        for &byte in bytes {
            if let Some(message) = self.deframer.push(byte) {
                let request = decode_request(message).and_then(|request| request.content);
                may_clear |= matches!(
                    request,
                    Some(Request::Clear | Request::TakeParameters { .. } | Request::Change { .. })
                );
            }
        }
        if let Some(device) = &mut self.device {
            device.receive(bytes);
        }
        let after = self.state();
        if matches!(before, State::Faulted(_)) && after != before {
            assert!(
                may_clear && after != State::Boot,
                "{before:?} -> {after:?} without a clear request"
            );
        }
        // An emergency stop behind the fault is the fault after it.
        let was_behind = may_clear && after == State::Faulted(Fault::EmergencyStop);
        assert!(
            after == before || was_behind || !matches!(after, State::Faulted(_)),
            "{before:?} -> {after:?}"
        );
    }

    /// Latches a fault from the board.
    pub fn latch(&mut self, which: usize) {
        let Some(fault) = Fault::ALL.get(which % Fault::ALL.len()) else { return };
        if let Some(device) = &mut self.device {
            device.servo().latch(LatchedFault::from(*fault));
        }
    }

    /// Runs one tick, after the joint has moved by `travel` counts, and asserts the limits of the
    /// output.
    pub fn tick(&mut self, travel: i32, supply: u16) {
        self.counter = self.counter.wrapping_add_signed(travel);
        let before = self.state();
        let Some(device) = &mut self.device else { return };
        // A load that moves as its motor does, if the parameters have two encoders.
        let load = EncoderReading { counter: self.counter, ..EncoderReading::default() };
        let output = device.tick(Input { counter: self.counter, supply, load, ..Input::default() });
        let Some(drive) =
            device.parameters().and_then(|p| Drive::new(&p.controller.drive, &STM32F405).ok())
        else {
            assert!(!output.enable, "without parameters the output is off");
            return;
        };
        // With the output off, the duty is neutral.
        assert!(output.enable || output.duty() == drive.duty(0));
        // Armed means on, except while a driver wakes up or is reset before its first duty.
        let times = device.parameters().map(|parameters| &parameters.device);
        let may_wait = times.is_some_and(|times| times.wake_up + times.reset_pulse > 0.0);
        let is_armed = output.state == State::Armed;
        // A fault may be followed by a short brake, whose duty is neutral.
        let brakes = output.enable && matches!(output.state, State::Faulted(_));
        assert!(!brakes || times.is_some_and(|times| times.short_brake > 0.0));
        assert!(!brakes || output.duty() == drive.duty(0));
        assert!(brakes || output.enable == is_armed || (is_armed && may_wait));
        assert!(!output.wakes || (is_armed && !output.enable && may_wait));
        let was_off = !matches!(before, State::Armed | State::Stopped);
        assert!(brakes || !output.enable || !was_off, "{before:?}");
        assert!(
            output.tick.code.abs() <= drive.max_code() && output.duty().compare <= drive.pwm_top()
        );
        assert!(!output.enable || output.duty() == drive.duty(output.tick.code));
        self.armed += u64::from(output.enable);
        self.moved += u64::from(output.enable && output.tick.reference_counts != 0);
        self.faulted += u64::from(matches!(output.state, State::Faulted(_)));
    }

    /// Sends up to `at_most` bytes of the device to the wire.
    pub fn drain(&mut self, at_most: usize) {
        if let Some(device) = &mut self.device {
            device.transmit(&mut vec![0; at_most]);
        }
    }
}

/// Runs a script from bytes: a letter for each action, and its arguments. Any bytes are a script.
///
/// ```text
/// m LENGTH MESSAGE   receive a message in a frame with a valid checksum
/// t TICKS TRAVEL     run TICKS ticks; the joint moves by TRAVEL counts in each
/// r LENGTH BYTES     receive raw bytes
/// f FAULT            latch a fault from the board
/// d LENGTH           let the wire send 4 LENGTH bytes
/// others             no action
/// ```
pub fn holds(parameters: &Parameters, script: &[u8]) -> CheckedDevice {
    let mut watched = CheckedDevice::new(parameters);
    let mut rest = script.iter();
    let mut next = || rest.next().copied();
    while let Some(letter) = next() {
        let Some(argument) = next() else { break };
        match letter {
            b'm' | b'r' => {
                let bytes: Vec<u8> = std::iter::from_fn(&mut next).take(argument.into()).collect();
                watched.revive();
                if letter == b'r' {
                    watched.receive(&bytes);
                } else if let Some(frame) = framed(&bytes) {
                    watched.receive(&frame);
                }
            }
            b't' => {
                let travel = i32::from(next().unwrap_or_default() as i8);
                (0..argument % 64).for_each(|_| watched.tick(travel, 2048));
            }
            b'f' => watched.latch(argument.into()),
            b'd' => watched.drain(4 * usize::from(argument)),
            _ => {}
        }
    }
    watched
}

/// Returns the frame of a message encoded in postcard.
fn framed(message: &[u8]) -> Option<Vec<u8>> {
    struct Raw<'a>(&'a [u8]);
    impl serde::Serialize for Raw<'_> {
        fn serialize<S: serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
            use serde::ser::SerializeTuple;
            // As a tuple of bytes: postcard writes no length before it.
            let mut tuple = serializer.serialize_tuple(self.0.len())?;
            self.0.iter().try_for_each(|byte| tuple.serialize_element(byte))?;
            tuple.end()
        }
    }
    encode(&Raw(message)).map(|frame| frame.to_vec())
}
