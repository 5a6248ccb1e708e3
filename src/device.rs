//! A whole device without a chip: it receives and sends bytes, and runs ticks.
//!
//! A host runs it as a simulated device, and tests of the link, the faults and the parameters run
//! it. A board has the same parts, each in the task where it belongs.

use embedded_storage::nor_flash::NorFlash;

use crate::control::brake_resistor::BrakeResistorLaw;
use crate::control::hardware::Hardware;
use crate::link::{DeviceKind, Machine, RequestRefusal, Session};
use crate::parameters::Parameters;
use crate::parameters::store::Store;
use crate::servo::{Boot, Input, Output, Servo};

/// A device without a chip: servo, link and parameter store.
#[derive(Debug)]
pub struct Device<F> {
    session: Session,
    parts: Parts<F>,
}

#[derive(Debug)]
struct Parts<F> {
    hardware: Hardware,
    servo: Servo,
    brake_resistor: Option<BrakeResistorLaw>,
    store: Store<F>,
}

impl<F: NorFlash> Device<F> {
    /// Starts a device as power-on does: the parameters are read, and nothing moves.
    pub fn start(mut store: Store<F>, boot: Boot, hardware: Hardware) -> Self {
        let is_damaged = boot.is_damaged || store.is_damaged();
        let boot = Boot { is_damaged, ..boot };
        let found = store.load().and_then(|found| found.fits(&hardware).map(|()| found));
        let servo = Servo::new(found.as_ref().map_err(|error| *error), boot, &hardware);
        let law = |parameters: &Parameters| parameters.brake_resistor_law(&hardware);
        let brake_resistor = found.as_ref().ok().and_then(law);
        let mut session = Session::new(DeviceKind::Simulated, found.ok());
        session.report_damage(boot.is_damaged);
        session.report_saves(store.saves());
        Self { session, parts: Parts { hardware, servo, brake_resistor, store } }
    }

    /// Receives bytes from the wire, and handles the requests in them.
    pub fn receive(&mut self, bytes: &[u8]) {
        self.session.receive(bytes, &mut self.parts);
        while self.session.work(&mut self.parts) {}
    }

    /// Fills `bytes` with bytes for the wire, and returns their number.
    pub fn transmit(&mut self, bytes: &mut [u8]) -> usize {
        self.session.transmit(bytes)
    }

    /// Runs one tick, which is due once a sample time.
    pub fn tick(&mut self, input: Input) -> Output {
        let output = self.parts.servo.tick(input);
        self.session.queue_sample(&output);
        output
    }

    /// Returns the duty of the brake resistor until the next tick, in
    /// [`STEPS`](crate::control::brake_resistor::STEPS) of the tick, for the converter's reading of
    /// the supply; zero without a resistor. It is due once a sample time, in every state.
    pub fn brake_resistor(&mut self, supply: u16) -> u16 {
        self.parts.brake_resistor.as_mut().map_or(0, |law| law.step(supply))
    }

    /// Returns the servo.
    pub const fn servo(&mut self) -> &mut Servo {
        &mut self.parts.servo
    }

    /// Returns the number of the link's session, as the client that began the session receives it.
    pub const fn session(&self) -> u32 {
        self.session.number()
    }

    /// Returns the parameters in use, if there are any.
    pub const fn parameters(&self) -> Option<&Parameters> {
        self.session.parameters()
    }

    /// Ends a device as power-off does: only the flash is left.
    pub fn end(self) -> Store<F> {
        self.parts.store
    }
}

impl<F: NorFlash> Machine for Parts<F> {
    fn servo<R>(&mut self, act: impl FnOnce(&mut Servo) -> R) -> R {
        act(&mut self.servo)
    }

    fn hardware(&self) -> Hardware {
        self.hardware
    }

    fn save(&mut self, parameters: &Parameters) -> Result<u32, RequestRefusal> {
        self.store.save(parameters)?;
        self.store.erase_damaged()?;
        Ok(self.store.saves())
    }

    /// Sets the brake resistor. There is no timer to set, and the caller of a tick reads the
    /// [`parameters`](Device::parameters).
    fn reconfigure(&mut self, parameters: &Parameters) -> Result<(), RequestRefusal> {
        let law = parameters.brake_resistor_law(&self.hardware);
        self.brake_resistor = law.map(|law| law.after(self.brake_resistor.as_ref()));
        Ok(())
    }
}
