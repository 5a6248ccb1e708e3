//! How many samples a wire of 921 600 baud carries, and that the client counts those it does not.

use std::time::Duration;

use simulator::device::client::Client;
use simulator::device::simulated::SimulatedDevice;
use simulator::device::wire::Wire;
use stiction::control::signal::index;

use super::ALL;
use crate::fixture::plans;

/// Bytes that the wire carries in the time of a tick: ten bits a byte at 921 600 baud.
struct Metered {
    simulated: SimulatedDevice,
    bytes_per_tick: f64,
    room: f64,
}

impl Wire for Metered {
    fn send(&mut self, bytes: &[u8]) -> Result<(), files::Error> {
        self.simulated.device.receive(bytes);
        Ok(())
    }

    fn receive(&mut self, at_most: Duration) -> Result<Vec<u8>, files::Error> {
        let ticks = (at_most.as_secs_f64() / self.simulated.sample_time_s()).ceil() as u32;
        let mut taken = vec![];
        for _ in 0..ticks {
            self.simulated.tick();
            // The line does not make up for the time in which there was nothing to send.
            self.room = self.room.fract() + self.bytes_per_tick;
            let mut buffer = vec![0; self.room as usize];
            let count = self.simulated.device.transmit(&mut buffer);
            self.room -= count as f64;
            taken.extend(&buffer[..count]);
        }
        Ok(taken)
    }

    fn name(&self) -> String {
        "a wire of 921 600 baud".into()
    }

    fn warning(&self) -> Option<&'static str> {
        None
    }
}

/// Signals of a joint with one encoder. That of a second one would be more than the wire carries.
const OF_ONE_ENCODER: u64 = ALL & !(1 << index("motor_counts"));

#[test]
fn the_wire_carries_every_signal_of_every_tick_at_1_khz_and_what_it_does_not_at_5_khz_is_counted() {
    let every = |sample_time: f64| {
        let sampled = format!("loop.sample_time_s={sample_time}");
        let set = [&*sampled, "loop.controller=pd", "reference.steps_deg=[5.0]"];
        let mut simulated = SimulatedDevice::new(&plans("step-response", &set)[0]).unwrap();
        simulated.ticks(1000);
        let wire = Metered { simulated, bytes_per_tick: 92_160.0 * sample_time, room: 0.0 };
        let mut client = Client::connect(wire).unwrap();
        client.subscribe(OF_ONE_ENCODER, 1).unwrap();
        client.pass(Duration::from_secs(10)).unwrap();
        let samples: Vec<_> =
            std::iter::from_fn(|| client.sample(Duration::ZERO).unwrap()).collect();
        // The client has counted every gap.
        let span = u64::from(samples[samples.len() - 1].number) + 1;
        assert_eq!(span, samples.len() as u64 + client.lost());
        (samples.len() as f64, client.lost() as f64, f64::from(client.status().unwrap().dropped))
    };
    let (samples, lost, dropped) = every(1e-3);
    reliability!("baud", khz = 1, samples, lost);
    assert!(samples > 9_900.0 && lost == 0.0 && dropped == 0.0, "{samples} {lost}");
    // A sample of 76 bytes of values takes 90 to 93 on the wire: 991 to 1024 go through in a
    // second, less the answers.
    let (samples, lost, dropped) = every(2e-4);
    reliability!("baud", khz = 5, samples, lost);
    assert!((9_750.0..10_240.0).contains(&samples), "{samples}");
    assert!(
        (samples + lost - 50_000.0).abs() < 500.0 && dropped >= lost,
        "{samples} {lost} {dropped}"
    );
}
