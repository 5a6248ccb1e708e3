//! The first move of docs/reference/wiring.md, step by step, with a client of any device whose
//! joint is sound and whose encoder may be reversed. The joint is the thesis's. It is not turned by
//! hand, and what `identify` finds is compared with the joint that the tuned parameters are for.

use std::time::Duration;

use simulator::device::client::Client;
use simulator::device::wire::Wire;
use stiction::Parameters;
use stiction::control::encoder::{Direction, Encoder};
use stiction::control::pd::PdGains;
use stiction::identification::{self, Outcome};
use stiction::link::StateCode;
use stiction::motion::jog::{JogFindings, JogRequest, Verdict};
use stiction::units::value::{Table, key};

/// Gains that do nothing, as before tuning.
pub fn untuned(tuned: &Parameters) -> Parameters {
    let mut parameters = tuned.clone();
    parameters.controller.compensator.clear();
    parameters.controller.pd = PdGains { kp: 0.0, kd: 0.0 };
    parameters
}

pub fn jogged<W: Wire>(client: &mut Client<W>) -> Option<JogFindings> {
    if !client.status().unwrap().at_rest {
        client.pass(Duration::from_millis(100)).unwrap();
    }
    client.jog(JogRequest::default()).unwrap();
    while client.pass(Duration::from_millis(500)).unwrap().state == StateCode::Armed {}
    client.jogged().unwrap()
}

/// What the reader of the page sees at the bench, and the link does not report.
pub trait Bench: Wire {
    /// Whether its flash keeps what is saved.
    const KEEPS: bool;

    /// Where the joint really is, deg.
    fn truth_deg(&mut self) -> f64;
}

fn save<W: Bench>(client: &mut Client<W>) {
    let saved = client.save();
    if W::KEEPS {
        saved.unwrap();
        assert!(!client.status().unwrap().unsaved);
    } else {
        let refusal = saved.unwrap_err().to_string();
        assert!(refusal.contains("models no contents of the flash"), "{refusal}");
    }
}

/// Follows the page with parameters of which only the gains and the direction are still missing.
pub fn follow<W: Bench>(client: &mut Client<W>, tuned: &Parameters, is_reversed: bool) {
    // 1, 2: the machine's file, and a status without a fault.
    client.set_parameters(&untuned(tuned)).unwrap();
    save(client);
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

    // 4: `identify --travel 20 --speed 10`.
    client.pass(Duration::from_millis(100)).unwrap();
    let asked = identification::IdentificationRequest {
        travel: Some(20.0),
        speed: Some(10.0),
        ..Default::default()
    };
    client.check_identification(&asked).unwrap();
    client.identify_joint(asked).unwrap();
    while client.pass(Duration::from_secs(1)).unwrap().state == StateCode::Armed {}
    assert_eq!(client.status().unwrap().faults, 0);
    let (summary, _) = client.identified().unwrap().unwrap();
    assert_eq!((summary.outcome, summary.doubts.is_none()), (Outcome::Done, true), "{summary:?}");
    assert!(summary.range <= 40.0, "{summary:?}");
    let estimate = summary.estimate.unwrap();
    for (found, truth, share) in [
        (summary.breakaway[0].median, 0.40, 0.03),
        (summary.breakaway[1].median, 0.40, 0.03),
        (estimate.coulomb[0], 0.38, 0.03),
        (estimate.inertia[0], 1.0 / 27.0, 0.05),
    ] {
        assert!((found / truth - 1.0).abs() < share, "{found}, not {truth}: {summary:?}");
    }

    // 5: the gains, `move 1`, and what has proved itself is kept.
    let direction = client.parameters().unwrap().controller.encoder.direction;
    let mut parameters = tuned.clone();
    parameters.controller.encoder.direction = direction;
    client.set_parameters(&parameters).unwrap();
    client.pass(Duration::from_millis(100)).unwrap();
    let (before, from) = (client.status().unwrap(), client.wire().truth_deg());
    client.arm().unwrap();
    client.move_to(1.0).unwrap();
    let time = Duration::from_secs_f64(client.longest_s(1.0).unwrap() + 2.0);
    let status = client.pass_armed(time).unwrap();
    assert_eq!((status.state, status.faults), (StateCode::Armed, 0));
    // The status counts from power-on, and a move from where the joint was armed.
    let deg = f64::from(status.position - before.position) * f64::from(before.resolution);
    let truly = client.wire().truth_deg() - from;
    assert!((deg - 1.0).abs() < 0.05 && (truly - deg).abs() < 0.01, "{deg} deg, truly {truly}");
    client.stop().unwrap();
    save(client);
    let status = client.status().unwrap();
    assert_eq!((status.state, status.faults), (StateCode::Stopped, 0));
}
