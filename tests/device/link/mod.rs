//! The command link around a whole device: each request is done once, and a garbled frame costs at
//! most itself.

use std::sync::LazyLock;

use simulator::device::client::Client;
use simulator::device::simulated::SimulatedDevice;
use simulator::device::wire::SimulatedWire;
use stiction::control::signal::SIGNALS;
use stiction::link::{
    Deframer, Message, NO_SESSION, NumberedMessage, PROTOCOL, Reply, Request, RequestRefusal,
    encode_request,
};

use crate::fixture::plans;

mod bandwidth;
mod change;
mod identification;
mod motion;
mod owner;
mod parameters;
mod ramp;
mod repetition;
mod session;
mod sign_of_life;
mod telemetry;

/// The mask of every signal that a loop has.
const ALL: u64 = (1 << SIGNALS.len()) - 1;

fn simulated() -> SimulatedDevice {
    let plan = &plans("step-response", &["loop.controller=srnf", "reference.steps_deg=[5.0]"])[0];
    let mut simulated = SimulatedDevice::new(plan).unwrap();
    simulated.ticks(10);
    simulated
}

fn client() -> Client<SimulatedWire> {
    Client::connect(SimulatedWire::new(simulated())).unwrap()
}

/// The number of the session that [`simulated`] begins with the hello of number 1 and session 7.
static SESSION: LazyLock<u32> = LazyLock::new(|| {
    let mut simulated = simulated();
    say(&mut simulated, &hello(1, 7));
    simulated.device.session()
});

/// A request of that session.
fn frame(number: u16, content: Request) -> Vec<u8> {
    frame_of(*SESSION, number, content)
}

fn frame_of(session: u32, number: u16, content: Request) -> Vec<u8> {
    encode_request(session, number, content).unwrap().to_vec()
}

fn hello(number: u16, session: u32) -> Vec<u8> {
    frame_of(NO_SESSION, number, Request::Hello { protocol: PROTOCOL, session })
}

/// Hands bytes to a device, and returns its answers.
fn say(simulated: &mut SimulatedDevice, bytes: &[u8]) -> Vec<(u16, Reply)> {
    simulated.device.receive(bytes);
    let mut buffer = [0; 4096];
    let count = simulated.device.transmit(&mut buffer);
    replies(&buffer[..count])
}

/// Reads the answers in what a device has sent.
fn replies(bytes: &[u8]) -> Vec<(u16, Reply)> {
    let (mut deframer, mut replies) = (Deframer::default(), vec![]);
    for &byte in bytes {
        if let Some(message) = deframer.push(byte)
            && let Message::Reply(NumberedMessage { number, content }) =
                postcard::from_bytes(message).unwrap()
        {
            replies.push((number, content));
        }
    }
    assert_eq!(deframer.bad(), 0);
    replies
}

fn refused(number: u16, why: RequestRefusal) -> Vec<(u16, Reply)> {
    vec![(number, Reply::Refused(why))]
}
