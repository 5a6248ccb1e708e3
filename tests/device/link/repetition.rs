//! Answers that are lost or late: the client repeats its request, and the device does it once.

use std::time::Duration;

use simulator::device::client::Client;
use simulator::device::simulated::SimulatedDevice;
use simulator::device::wire::{SimulatedWire, Wire};
use stiction::link::{Reply, Request};
use stiction::servo::{Boot, State};

use super::{frame, hello, say, simulated};
use crate::fixture::{blank, plans, srnf};

/// Answers wait in a ring of 2 KiB. An answer that finds no room there is lost. The request is done
/// all the same, and a client that repeats it gets its answer.
#[test]
fn an_answer_that_found_no_room_comes_when_the_request_is_repeated() {
    let mut simulated = simulated();
    say(&mut simulated, &hello(1, 7));
    // 14 answers of some 140 bytes each fill the ring; then comes a request that counts.
    for number in 2..40 {
        simulated.device.receive(&frame(number, Request::ReadParameters { offset: 0 }));
    }
    simulated.device.receive(&frame(40, Request::Arm));
    assert!(simulated.tick().enable, "done, though no client hears of it");
    let mut sink = [0; 4096];
    let waited = simulated.device.transmit(&mut sink);
    assert!((1800..=2048).contains(&waited), "{waited}");
    simulated.device.servo().stop();
    // The same number brings the answer, and nothing is done a second time.
    assert_eq!(say(&mut simulated, &frame(40, Request::Arm)), [(40, Reply::Done)]);
    assert!(!simulated.tick().enable);
    let [(41, Reply::Status(status))] = &say(&mut simulated, &frame(41, Request::Status))[..]
    else {
        panic!()
    };
    assert!((20..30).contains(&status.dropped), "{}", status.dropped);
}

/// A wire that loses the first answer to every request.
struct Lossy {
    wire: SimulatedWire,
    said: Vec<u8>,
    lost: u32,
}

impl Wire for Lossy {
    fn send(&mut self, bytes: &[u8]) -> Result<(), files::Error> {
        self.wire.send(bytes)?;
        if self.said != bytes {
            self.said = bytes.to_vec();
            self.lost += u32::from(!self.wire.receive(Duration::ZERO)?.is_empty());
        }
        Ok(())
    }

    fn receive(&mut self, at_most: Duration) -> Result<Vec<u8>, files::Error> {
        self.wire.receive(at_most)
    }

    fn name(&self) -> String {
        "a lossy wire".into()
    }

    fn warning(&self) -> Option<&'static str> {
        None
    }
}

#[test]
fn a_client_repeats_itself_until_it_is_answered_and_nothing_is_done_twice() {
    let wire = Lossy { wire: SimulatedWire::new(simulated()), said: vec![], lost: 0 };
    let mut client = Client::connect(wire).unwrap();
    client.arm().unwrap();
    client.step_to(2.5).unwrap();
    client.pass(Duration::from_secs(3)).unwrap();
    let position = client.wire().wire.simulated.position_deg();
    assert!((position - 2.5).abs() < 0.03, "{position}");
    client.set_parameters(&srnf(&[])).unwrap_err();
    client.stop().unwrap();
    client.set_parameters(&srnf(&[])).unwrap();
    assert_eq!(client.status().unwrap().bad_frames, 0);
    let lost = client.wire().lost;
    assert!(lost > 20, "{lost}");
}

#[test]
fn a_device_without_parameters_is_waited_for_as_long_as_was_asked() {
    struct Clock(SimulatedWire, Duration);
    impl Wire for Clock {
        fn send(&mut self, bytes: &[u8]) -> Result<(), files::Error> {
            self.0.send(bytes)
        }
        fn receive(&mut self, at_most: Duration) -> Result<Vec<u8>, files::Error> {
            self.1 += at_most;
            self.0.receive(at_most)
        }
        fn now(&self) -> Duration {
            self.1
        }
        fn name(&self) -> String {
            self.0.name()
        }
        fn warning(&self) -> Option<&'static str> {
            None
        }
    }
    let plan = &plans("step-response", &["loop.controller=srnf"])[0];
    let simulated = SimulatedDevice::with(plan, blank(), Boot::default()).unwrap();
    let mut client = Client::connect(Clock(SimulatedWire::new(simulated), Duration::ZERO)).unwrap();
    let begin = client.wire().now();
    client.pass(Duration::from_secs(10)).unwrap();
    let took = (client.wire().now() - begin).as_secs_f64();
    // The requests for the status take some time, too.
    assert!((10.0..11.0).contains(&took), "{took}");
}

/// Another client counts its requests from one on, too.
#[test]
fn a_stop_with_the_number_of_another_request_is_obeyed() {
    let mut simulated = simulated();
    say(&mut simulated, &hello(1, 7));
    say(&mut simulated, &frame(2, Request::Arm));
    assert_eq!(simulated.tick().state, State::Armed);
    assert_eq!(say(&mut simulated, &frame(2, Request::Stop)), [(2, Reply::Done)]);
    assert_eq!(simulated.tick().state, State::Stopped);
}
