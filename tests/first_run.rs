//! The first run of docs/wiring.md, step by step, with a client of any device whose joint is sound
//! and whose encoder may be reversed.

use std::time::Duration;

use simulator::device::client::Client;
use simulator::device::wire::Wire;
use stiction::Parameters;
use stiction::encoder::{Direction, Encoder};
use stiction::jog::{Asked, Found, Verdict};
use stiction::link::StateCode;
use stiction::pd::PdGains;
use stiction::value::{Table, key};

/// Gains that do nothing: nobody has chosen any.
pub fn untuned(tuned: &Parameters) -> Parameters {
    let mut parameters = tuned.clone();
    parameters.controller.compensator.clear();
    parameters.controller.pd = PdGains { kp: 0.0, kd: 0.0 };
    parameters
}

pub fn jogged<W: Wire>(client: &mut Client<W>) -> Option<Found> {
    if !client.status().unwrap().at_rest {
        client.pass(Duration::from_millis(100)).unwrap();
    }
    client.jog(Asked::default()).unwrap();
    while client.pass(Duration::from_millis(500)).unwrap().state == StateCode::Armed {}
    client.jogged().unwrap()
}

/// Follows the guide with parameters of which only the gains and the direction are still missing.
pub fn follow<W: Wire>(client: &mut Client<W>, tuned: &Parameters, is_reversed: bool) {
    // 1, 2: the machine's file, and a status without a fault.
    client.set_parameters(&untuned(tuned)).unwrap();
    client.pass(Duration::from_millis(100)).unwrap();
    let status = client.status().unwrap();
    assert_eq!((status.state, status.faults), (StateCode::Stopped, 0));

    // 3: jog; set what it says; jog again.
    let found = jogged(client).unwrap();
    let expected = if is_reversed { Verdict::Reversed } else { Verdict::Agrees };
    assert_eq!(found.verdict(), expected, "{found:?}");
    if is_reversed {
        let direction = key(Encoder::ABOUT, "direction");
        client.change(&[(direction, Direction::Reverse as u32)]).unwrap();
    }
    for _ in 0..2 {
        let again = jogged(client).unwrap();
        assert_eq!(again.verdict(), Verdict::Agrees, "{again:?}");
    }

    // 4: the friction. The ramp is faster than the guide's, and so reads stick higher.
    client.pass(Duration::from_millis(100)).unwrap();
    client.identify(0.1, 1.0).unwrap();
    while client.pass(Duration::from_secs(1)).unwrap().state == StateCode::Armed {}
    let levels = client.levels().unwrap().unwrap();
    assert!((0.39..0.47).contains(&levels.stick.unwrap()), "{levels:?}");

    // 5: the gains, and a small move.
    let direction = client.parameters().unwrap().controller.encoder.direction;
    let mut parameters = tuned.clone();
    parameters.controller.encoder.direction = direction;
    client.set_parameters(&parameters).unwrap();
    client.pass(Duration::from_millis(100)).unwrap();
    client.arm().unwrap();
    client.step_to(1.0).unwrap();
    let status = client.pass_armed(Duration::from_secs(4)).unwrap();
    assert_eq!((status.state, status.faults), (StateCode::Armed, 0));
    client.stop().unwrap();
}
