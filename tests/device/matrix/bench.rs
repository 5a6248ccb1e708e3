//! The bench of the matrix in process: the device around the simulated joint.

use experiments::matrix::{Bench, BenchSample, Situation, plan};
use files::hardware::STM32F405;
use simulator::device::client::Client;
use simulator::device::simulated::{MotorWires, ShuntState, SimulatedDevice, Wires};
use simulator::device::wire::SimulatedWire;
use stiction::control::drive::{Drive, Duty};
use stiction::link::FaultReport;
use stiction::servo::{Output, State};
use stiction::{Fault, Tick};

/// The converter's full scale.
const SUPPLY_FULL_SCALE: f64 = 4096.0;

/// The device around the simulated joint.
pub struct DeviceBench {
    client: Client<SimulatedWire>,
    neutral: Duty,
    last: Output,
    detection: Option<u32>,
}

impl DeviceBench {
    pub fn new() -> Self {
        Self::with(&[])
    }

    /// A device whose joint has keys set.
    pub fn with(set: &[&str]) -> Self {
        let mut simulated = SimulatedDevice::new(&plan::<Self>("pd", set)).unwrap();
        let drive = &simulated.device.parameters().unwrap().controller.drive;
        let neutral = Drive::new(drive, &STM32F405).unwrap().duty(0);
        let last = simulated.tick();
        let client = Client::connect(SimulatedWire::new(simulated)).unwrap();
        Self { client, neutral, last, detection: None }
    }

    pub fn simulated(&mut self) -> &mut SimulatedDevice {
        &mut self.client.wire().simulated
    }

    pub fn state(&self) -> State {
        self.last.state
    }
}

impl Bench for DeviceBench {
    type Wire = SimulatedWire;
    // The board's timer. The simulated counter keeps the width that it starts with.
    const SET: &'static [&'static str] = &["encoder.counter_bits=32"];
    const LATE: u32 = 0;

    fn client(&mut self) -> &mut Client<SimulatedWire> {
        &mut self.client
    }

    fn ticks(&mut self, count: u32) -> BenchSample {
        for _ in 0..count {
            let was_on = self.last.enable;
            self.last = self.simulated().tick();
            if !self.last.enable {
                assert_eq!(self.last.duty(), self.neutral, "{:?}", self.last.state);
                if was_on {
                    self.detection = Some(self.last.clock);
                }
            }
        }
        BenchSample { is_on: self.last.enable, code: self.last.tick.code }
    }

    fn heard(&mut self, _: u32) {
        self.simulated().device.servo().heard();
    }

    fn last_tick(&mut self) -> Tick {
        self.last.tick
    }

    fn rewire(&mut self, wires: Wires) {
        self.simulated().wires = wires;
    }

    fn jump(&mut self, counts: i32) {
        self.simulated().jump(counts);
    }

    fn supply(&mut self, of_full_scale: f64) {
        self.simulated().supply = (of_full_scale * SUPPLY_FULL_SCALE) as u16;
    }

    fn brake(&mut self, volts: f64) {
        self.simulated().brake_v = volts;
    }

    fn motor(&mut self, wires: MotorWires, sensor: ShuntState) {
        // Until the bridge is off, the simulated converter compares with the window of the loop,
        // and that of new parameters has no offset yet.
        if self.last.enable && self.simulated().device.servo().state() != State::Armed {
            self.ticks(1);
        }
        let simulated = self.simulated();
        simulated.motor_wires = wires;
        if let Some(shunt) = &mut simulated.shunt {
            shunt.state = sensor;
        }
    }

    fn position_deg(&mut self) -> f64 {
        self.simulated().position_deg()
    }

    fn push(&mut self, position_deg: f64, velocity_deg_per_s: f64) {
        self.simulated().push(position_deg, velocity_deg_per_s);
    }

    fn assert_off_since_detection(&mut self, name: &str, _: &str) {
        // `ticks` asserts the neutral duty of every tick that is off.
        assert!(!self.last.enable && matches!(self.last.state, State::Faulted(_)), "{name}");
    }

    fn assert_kept(&mut self, name: &str, report: &FaultReport) {
        // What the board reports comes between two ticks, and has the number of the earlier one.
        let detection = self.detection.unwrap();
        assert!((detection - 1..=detection).contains(&report.tick), "{name}: {report:?}");
    }

    // A reset starts a new device here; the flash image's bench has one.
    fn assert_kept_across_a_reset(&mut self, _: &str, _: Fault) {}

    fn report(fault: Fault, what: &str, situation: Situation, _: usize, [slowest, most]: [u32; 2]) {
        let (fault, situation) = (fault.describe(), format!("{situation:?}").to_lowercase());
        reliability!("latency", fault, what, situation, slowest, most);
    }
}
