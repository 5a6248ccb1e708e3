//! Who may say what, in which order, and what a device makes of bytes that are no frame.

use stiction::link::{
    NO_SESSION, PROTOCOL, REQUEST, Reply, Request, RequestRefusal, StateCode, encode,
};

use super::{SESSION, client, frame, frame_of, hello, refused, say, simulated};
use simulator::device::simulated::SimulatedDevice;

#[test]
fn without_a_hello_only_stop_is_obeyed() {
    let mut simulated = simulated();
    assert_eq!(say(&mut simulated, &frame(1, Request::Arm)), refused(1, RequestRefusal::SayHello));
    assert_eq!(say(&mut simulated, &frame(2, Request::Stop)), [(2, Reply::Done)]);
    let other = frame_of(NO_SESSION, 3, Request::Hello { protocol: PROTOCOL + 1, session: 1 });
    let [(3, Reply::Hello(identity))] = &say(&mut simulated, &other)[..] else { panic!() };
    assert_eq!(identity.protocol, PROTOCOL);
    assert_eq!(say(&mut simulated, &frame(4, Request::Arm)), refused(4, RequestRefusal::SayHello));
}

#[test]
fn a_request_that_comes_twice_is_done_once() {
    let mut simulated = simulated();
    say(&mut simulated, &hello(1, 7));
    let arm = frame(2, Request::Arm);
    assert_eq!(say(&mut simulated, &arm), [(2, Reply::Done)]);
    simulated.device.servo().stop();
    // The answer is the same, but the device is not armed again.
    assert_eq!(say(&mut simulated, &arm), [(2, Reply::Done)]);
    assert!(!simulated.tick().enable);
    // A hello that comes twice begins no new session either, in which old requests would count
    // again.
    say(&mut simulated, &frame(3, Request::Status));
    say(&mut simulated, &hello(1, 7));
    assert_eq!(say(&mut simulated, &arm), refused(2, RequestRefusal::OutOfOrder));
}

#[test]
fn a_stop_is_obeyed_however_late_and_an_arm_that_it_overtook_is_not() {
    let mut simulated = simulated();
    say(&mut simulated, &hello(1, 7));
    say(&mut simulated, &frame(9, Request::Arm));
    assert!(simulated.tick().enable);
    assert_eq!(say(&mut simulated, &frame(2, Request::Stop)), [(2, Reply::Done)]);
    assert!(!simulated.tick().enable);
    assert_eq!(say(&mut simulated, &frame(11, Request::Stop)), [(11, Reply::Done)]);
    assert_eq!(
        say(&mut simulated, &frame(10, Request::Arm)),
        refused(10, RequestRefusal::OutOfOrder)
    );
    assert!(!simulated.tick().enable);
}

#[test]
fn garbage_costs_at_most_the_frame_that_it_touches() {
    let status = |number| frame(number, Request::Status);
    let numbers = |simulated: &mut SimulatedDevice, bytes: &[u8]| {
        let replies = say(simulated, bytes);
        replies.into_iter().map(|(number, _)| number).collect::<Vec<_>>()
    };
    let mut simulated = simulated();
    say(&mut simulated, &hello(1, 7));
    let mut number = 1;
    // Every bit of a frame is changed, a frame is cut at every place, and a frame of garbage has no
    // end. The next frame is whole each time.
    let length = status(2).len();
    for bit in 0..8 * length {
        let (mut broken, sound) = (status(number + 1), status(number + 2));
        let at = bit / 8;
        if at >= broken.len() {
            continue;
        }
        broken[at] ^= 1 << (bit % 8);
        number += 2;
        let heard = numbers(&mut simulated, &[broken, vec![0], sound].concat());
        assert_eq!(heard, [number], "bit {bit}");
    }
    for cut in 0..length - 1 {
        let heard = numbers(
            &mut simulated,
            &[&status(number + 1)[..cut], &[0], &status(number + 2)].concat(),
        );
        number += 2;
        assert_eq!(heard, [number], "cut {cut}");
    }
    let heard =
        numbers(&mut simulated, &[vec![0x55; 10_000], vec![0], status(number + 1)].concat());
    assert_eq!(heard, [number + 1]);
    // The frame is whole, but the device does not know the request.
    let strange = encode(&(REQUEST, *SESSION, number + 2, 200u8)).unwrap();
    assert_eq!(say(&mut simulated, &strange), refused(number + 2, RequestRefusal::Unknown));
}

#[test]
fn what_is_no_microcontroller_has_no_brown_out_reset_and_an_armed_device_is_not_asked() {
    let mut client = client();
    let refusal = client.set_brown_out().unwrap_err().to_string();
    assert!(
        refusal.contains("set-brown-out") && refusal.contains("not a microcontroller"),
        "{refusal}"
    );
    client.arm().unwrap();
    let refusal = client.set_brown_out().unwrap_err().to_string();
    assert!(
        !refusal.contains("not a microcontroller") && refusal.contains("motor is driven"),
        "{refusal}"
    );
    assert_eq!(client.status().unwrap().state, StateCode::Armed);
}
