//! What keeps a motion going that a link began: new requests of its session, and nothing else that
//! comes over the wire.

use simulator::device::simulated::SimulatedDevice;
use stiction::Fault;
use stiction::link::{Request, encode};
use stiction::servo::State;

use super::{ALL, frame, hello, say, simulated};

/// A device that a session has armed, with every signal of every tick on the wire. The last request
/// had number 3.
fn armed() -> SimulatedDevice {
    let mut simulated = simulated();
    say(&mut simulated, &hello(1, 7));
    say(&mut simulated, &frame(2, Request::Subscribe { signals: ALL, every: 1 }));
    say(&mut simulated, &frame(3, Request::Arm));
    simulated
}

/// Lets 10 s pass with what `wire` makes of the device's bytes in each tick; returns the last
/// state.
fn ten_seconds(
    simulated: &mut SimulatedDevice,
    mut wire: impl FnMut(u16, &[u8]) -> Vec<u8>,
) -> State {
    let mut state = simulated.tick().state;
    for tick in 0..500 {
        let mut bytes = [0; 4096];
        let count = simulated.device.transmit(&mut bytes);
        simulated.device.receive(&wire(tick, &bytes[..count]));
        state = simulated.tick().state;
    }
    state
}

const SILENT: State = State::Faulted(Fault::LinkTimeout);

#[test]
fn new_requests_keep_a_motion_going_and_silence_ends_it() {
    let status = |tick, _: &[u8]| frame(4 + tick, Request::Status);
    assert_eq!(ten_seconds(&mut armed(), status), State::Armed);
    assert_eq!(ten_seconds(&mut armed(), |_, _| vec![]), SILENT);
}

#[test]
fn an_echo_is_neither_a_sign_of_life_nor_answered() {
    let mut echoed = 0;
    let mut simulated = armed();
    let state = ten_seconds(&mut simulated, |tick, bytes| {
        // Once the output is off, what is left are the samples.
        echoed += usize::from(tick > 30) * bytes.len();
        bytes.to_vec()
    });
    assert_eq!(state, SILENT);
    // All was echoed, and the device has made nothing of it: not a request, not a broken frame.
    assert!(echoed > 10_000, "{echoed}");
    let mut deframer = stiction::link::Deframer::default();
    let mut bytes = [0; 4096];
    let count = simulated.device.transmit(&mut bytes);
    for &byte in &bytes[..count] {
        if let Some(message) = deframer.push(byte) {
            assert_eq!(message.first(), Some(&1), "a sample, not a reply");
        }
    }
}

#[test]
fn a_frame_that_comes_again_and_again_is_no_sign_of_life() {
    // The last request, an older one, one of another session's client, and one without its
    // direction.
    let plain = |number| {
        let content = Request::Status;
        encode(&stiction::link::NumberedMessage { number, content }).unwrap().to_vec()
    };
    for stuck in [frame(3, Request::Arm), frame(2, Request::Status), hello(9, 7), plain(4)] {
        let mut simulated = armed();
        assert_eq!(ten_seconds(&mut simulated, |_, _| stuck.clone()), SILENT, "{stuck:?}");
    }
}

#[test]
fn every_client_can_stop_a_device_and_say_hello_to_it() {
    let plain = |number, content| {
        encode(&stiction::link::NumberedMessage { number, content }).unwrap().to_vec()
    };
    let mut simulated = armed();
    let [(4, stiction::link::Reply::Hello(_))] =
        say(&mut simulated, &plain(4, Request::Hello { protocol: 2, session: 1 }))[..]
    else {
        panic!()
    };
    assert_eq!(simulated.tick().state, State::Armed);
    assert_eq!(say(&mut simulated, &plain(5, Request::Stop)).len(), 1);
    assert_eq!(simulated.tick().state, State::Stopped);
}
