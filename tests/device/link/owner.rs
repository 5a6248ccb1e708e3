//! Whose requests a device does: those of its session, whose number it has chosen. While the motor
//! is driven for a link, others read and stop; or they take over, which stops the motor first.

use simulator::device::client::Client;
use simulator::device::simulated::SimulatedDevice;
use simulator::device::wire::SimulatedWire;
use stiction::Fault;
use stiction::link::{NO_SESSION, Reply, Request, RequestRefusal};
use stiction::motion::Motion;
use stiction::motion::home::HomeRequest;
use stiction::motion::winding::WindingRequest;
use stiction::servo::State;
use stiction::units::position::Position;

use super::{frame, frame_of, hello, refused, say, simulated};

/// A request of a client that has no session.
fn of_a_guest(number: u16, content: Request) -> Vec<u8> {
    frame_of(NO_SESSION, number, content)
}

/// A device that its owner has armed, by the requests 1 and 2.
fn owned() -> SimulatedDevice {
    let mut simulated = simulated();
    say(&mut simulated, &hello(1, 7));
    assert_eq!(say(&mut simulated, &frame(2, Request::Arm)), [(2, Reply::Done)]);
    simulated.tick();
    simulated
}

fn state(simulated: &mut SimulatedDevice) -> State {
    simulated.device.servo().state()
}

/// The recording clears a fault, arms and moves. The same bytes come again a second later, after
/// another client's hello, or after a reset at any other tick.
#[test]
fn bytes_that_were_recorded_in_a_session_clear_arm_and_move_nothing_later() {
    let faulted = |ticks: u32| {
        let mut simulated = simulated();
        simulated.device.servo().fault(Fault::BreakInput);
        simulated.ticks(ticks);
        simulated
    };
    let mut first = faulted(100);
    let mut recorded = hello(1, 7);
    say(&mut first, &recorded);
    let session = first.device.session();
    let to = Position::from_counts(1000);
    for (number, request) in [
        (2, Request::Open { hello: 7 }),
        (3, Request::Clear),
        (4, Request::Arm),
        (5, Request::Move(Motion::Step(to))),
    ] {
        let session = if number == 2 { NO_SESSION } else { session };
        let bytes = frame_of(session, number, request);
        say(&mut first, &bytes);
        recorded.extend(bytes);
    }
    assert_eq!(state(&mut first), State::Armed, "the recording does what it says");
    for ticks in (0..400).filter(|ticks| *ticks != 100) {
        let mut later = faulted(ticks);
        say(&mut later, &recorded);
        assert_eq!(state(&mut later), State::Faulted(Fault::BreakInput), "{ticks} ticks");
    }
    // On the same device, with and without the hello of another client in between.
    for other in [&[][..], &hello(9, 8)] {
        first.device.servo().fault(Fault::BreakInput);
        first.ticks(50);
        say(&mut first, other);
        say(&mut first, &recorded);
        assert_eq!(state(&mut first), State::Faulted(Fault::BreakInput));
    }
}

/// Each of these would change something, or would keep the motor driven.
#[test]
fn while_the_motor_is_driven_another_client_only_reads() {
    let mut simulated = owned();
    let [(1, Reply::Hello(_))] = say(&mut simulated, &hello(1, 8))[..] else { panic!() };
    let changes = [
        Request::Open { hello: 8 },
        Request::Arm,
        Request::Move(Motion::Hold),
        Request::Clear,
        Request::Save,
        Request::WriteParameters { offset: 0, bytes: Default::default() },
        Request::TakeParameters { length: 100 },
        Request::Change { entries: Default::default() },
        Request::Subscribe { signals: 1, every: 1 },
        Request::SetReference { position: 0 },
        Request::Home(HomeRequest::default()),
        Request::MeasureWinding(WindingRequest::default()),
        Request::SetBrownOut,
        Request::ReadIdentification,
    ];
    for (number, request) in (2..).zip(changes) {
        let name = format!("{request:?}");
        let answer = say(&mut simulated, &of_a_guest(number, request));
        assert_eq!(answer, refused(number, RequestRefusal::NotOwner), "{name}");
    }
    let reads = [
        Request::Status,
        Request::ReadParameters { offset: 0 },
        Request::Signal { index: 0 },
        Request::ReadJog,
        Request::ReadHome,
        Request::ReadWinding,
    ];
    for (number, request) in (30..).zip(reads) {
        let [(answered, reply)] = &say(&mut simulated, &of_a_guest(number, request))[..] else {
            panic!()
        };
        assert!(*answered == number && !matches!(reply, Reply::Refused(_)), "{reply:?}");
    }
    // The owner has noticed nothing of it.
    assert!(matches!(say(&mut simulated, &frame(3, Request::Status))[..], [(3, Reply::Status(_))]));
    assert_eq!(state(&mut simulated), State::Armed);
}

/// The owner has gone. The link timeout of 0.5 s is 25 ticks.
#[test]
fn the_polls_of_another_client_do_not_keep_the_motor_driven() {
    let mut simulated = owned();
    for number in 2..60 {
        say(&mut simulated, &hello(number, 8));
        say(&mut simulated, &of_a_guest(number, Request::Status));
        simulated.tick();
    }
    assert_eq!(state(&mut simulated), State::Faulted(Fault::LinkTimeout));
    // Now it may begin a session of its own.
    say(&mut simulated, &hello(60, 9));
    let [(61, Reply::Session(session))] =
        say(&mut simulated, &of_a_guest(61, Request::Open { hello: 9 }))[..]
    else {
        panic!()
    };
    let clear = frame_of(session, 62, Request::Clear);
    assert_eq!(say(&mut simulated, &clear), [(62, Reply::Done)]);
}

#[test]
fn who_takes_over_stops_the_motor_first_and_the_other_client_notices() {
    let mut simulated = owned();
    say(&mut simulated, &frame(3, Request::Move(Motion::Profiled(Position::from_counts(20_000)))));
    for number in 4..60 {
        say(&mut simulated, &frame(number, Request::Status));
        simulated.tick();
    }
    assert!(simulated.velocity_deg_per_s() > 1.0, "{}", simulated.velocity_deg_per_s());
    // It comes twice, and is one stop: the joint brakes.
    for number in [1, 1] {
        assert_eq!(
            say(&mut simulated, &of_a_guest(number, Request::TakeOver)),
            [(number, Reply::Done)]
        );
    }
    assert!(simulated.device.servo().is_stopping());
    assert_eq!(
        say(&mut simulated, &frame(60, Request::Status)),
        refused(60, RequestRefusal::SayHello)
    );
    say(&mut simulated, &hello(2, 8));
    let session = simulated.device.session();
    assert_eq!(
        say(&mut simulated, &frame_of(session, 3, Request::Arm)),
        refused(3, RequestRefusal::Stopping)
    );
    simulated.ticks(100);
    assert_eq!(state(&mut simulated), State::Stopped);
    assert_eq!(say(&mut simulated, &frame_of(session, 4, Request::Arm)), [(4, Reply::Done)]);
    assert_eq!(
        say(&mut simulated, &frame(61, Request::Move(Motion::Hold))),
        refused(61, RequestRefusal::SayHello)
    );
}

/// The client of the commands, on a device that another client has armed.
#[test]
fn a_client_reads_as_a_guest_and_is_the_owner_once_it_has_taken_over() {
    let mut client = Client::connect(SimulatedWire::new(owned())).unwrap();
    assert!(client.is_guest());
    client.status().unwrap();
    let why = client.arm().unwrap_err().to_string();
    assert!(why.contains("another client") && why.contains("`take-over`"), "{why}");
    client.take_over().unwrap();
    assert!(!client.is_guest());
    client.pass(std::time::Duration::from_millis(200)).unwrap();
    client.arm().unwrap();
    // One that was a guest begins a session by itself once there is no owner any more.
    let mut guest = Client::connect(SimulatedWire::new(owned())).unwrap();
    guest.pass(std::time::Duration::from_secs(1)).unwrap();
    assert_eq!(guest.status().unwrap().fault.code, Fault::LinkTimeout as u8);
    guest.clear().unwrap();
    assert!(!guest.is_guest());
}
