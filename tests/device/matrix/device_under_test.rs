//! A device that a client has armed and brought into a situation.

use files::hardware::STM32F405;
use simulator::device::client::Client;
use simulator::device::simulated::SimulatedDevice;
use simulator::device::wire::SimulatedWire;
use stiction::control::drive::{Drive, Duty};
use stiction::control::reference::Corner;
use stiction::servo::{Output, State};
use stiction::units::position::Position;
use stiction::{Fault, Motion};

use super::Situation::{self, Moving, Rest, Saturated};
use crate::fixture::plans;

/// Gains by which a law is [`Saturated`] as the others are on the way to a far
/// target. The profile within `robust` asks for a quarter of the full scale otherwise, and for the
/// friction: here it is the whole, 5 V of 27 deg/s^2 each.
pub fn harder(law: &str, situation: Situation) -> &'static [&'static str] {
    match (law, situation) {
        ("robust", Saturated) => &["controller.robust.acceleration_deg_per_s2=135"],
        _ => &[],
    }
}

pub struct DeviceUnderTest {
    pub client: Client<SimulatedWire>,
    pub neutral: Duty,
}

impl DeviceUnderTest {
    pub fn new(law: &str, set: &[&str]) -> Self {
        let law = format!("loop.controller={law}");
        let set = [&[&*law, "reference.steps_deg=[5.0]"], set].concat();
        let plan = &plans("step-response", &set)[0];
        let simulated = SimulatedDevice::new(plan).unwrap();
        let drive = &simulated.device.parameters().unwrap().controller.drive;
        let drive = Drive::new(drive, &STM32F405).unwrap();
        let client = Client::connect(SimulatedWire::new(simulated)).unwrap();
        Self { client, neutral: drive.duty(0) }
    }

    pub fn simulated(&mut self) -> &mut SimulatedDevice {
        &mut self.client.wire().simulated
    }

    /// Runs ticks with a client that is there.
    pub fn pass(&mut self, ticks: u32) -> Output {
        let mut output = self.simulated().tick();
        for _ in 1..ticks {
            self.simulated().device.servo().heard();
            output = self.simulated().tick();
        }
        output
    }

    /// Brings the joint into a situation, after a first move.
    pub fn bring(&mut self, situation: Situation) {
        self.client.arm().unwrap();
        self.client.step_to(3.0).unwrap();
        self.pass(400);
        let corner = |tick, counts| Corner { tick, position: Position::from_counts(counts) };
        match situation {
            Rest => {}
            Moving => {
                let corners = [corner(25, 1240), corner(1025, 1240 + 41_322)].into_iter().collect();
                self.client.move_along(Motion::Trajectory { corners, half_blend: 0.25 }).unwrap();
                let output = self.pass(100);
                assert!((output.tick.velocity - 5.0).abs() < 1.5, "{}", output.tick.velocity);
            }
            Saturated => {
                self.client.step_to(90.0).unwrap();
                let output = self.pass(4);
                assert_eq!(output.tick.code.abs(), 1024);
            }
        }
        let output = self.pass(1);
        assert_eq!((output.state, output.enable), (State::Armed, true), "{situation:?}");
    }

    /// Checks that nothing is driven, whatever is asked, and that arming again takes what it
    /// should.
    pub fn check_latched(&mut self, row: &str, fault: Fault, mend: fn(&mut SimulatedDevice)) {
        assert!(self.client.arm().is_err(), "{row}");
        assert!(self.client.step_to(1.0).is_err() && self.client.hold().is_err(), "{row}");
        for _ in 0..50 {
            let output = self.pass(1);
            assert_eq!((output.enable, output.duty()), (false, self.neutral), "{row}");
            assert_eq!(output.state, State::Faulted(fault), "{row}");
        }
        let fault_report = self.client.status().unwrap().fault;
        assert_eq!(fault_report.code, fault as u8, "{row}");
        assert!(fault_report.tick > 0, "{row}");
        mend(self.simulated());
        if !fault.is_clearable() {
            assert!(self.client.clear().is_err(), "{row}");
            return;
        }
        self.client.clear().unwrap();
        // A cleared device is not armed, and a joint that moves cannot be armed.
        assert_eq!(self.pass(1).state, State::Stopped, "{row}");
        let position = self.simulated().position_deg();
        self.simulated().push(position, 5.0);
        self.pass(2);
        assert!(self.client.arm().unwrap_err().to_string().contains("at rest"), "{row}");
        self.simulated().push(position, 0.0);
        self.pass(10);
        self.client.arm().unwrap();
        let output = self.pass(1);
        // The law has forgotten its state: on target, a fresh law has nothing to add.
        let tick = &output.tick;
        assert_eq!((output.enable, tick.error, tick.v_c, tick.code), (true, 0.0, 0.0, 0), "{row}");
    }
}
