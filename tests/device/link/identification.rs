//! The identification of a joint, asked for over the link. The joint is the thesis's: 27 deg/s^2
//! per V, 0.02 V s/deg, 0.40 V to start it and 0.38 V to keep it moving.

use std::time::Duration;

use files::hardware::STM32F405;
use simulator::device::client::Client;
use simulator::device::identified::IdentifiedJoint;
use simulator::device::into;
use simulator::device::simulated::{SimulatedDevice, Wires};
use simulator::device::wire::SimulatedWire;
use simulator::experiment::Document;
use stiction::identification::{IdentificationRequest, Outcome, Summary};
use stiction::link::{DeviceKind, Machine, Reply, Request, RequestRefusal, Session, StateCode};
use stiction::parameters::Parameters;
use stiction::servo::Servo;
use stiction::{Fault, Hardware};

use super::{client, frame_of, hello, refused, replies};
use crate::fixture::plans;

fn identified(client: &mut Client<SimulatedWire>, asked: IdentificationRequest) -> Option<Summary> {
    client.identify_joint(asked).unwrap();
    while client.pass(Duration::from_secs(1)).unwrap().state == StateCode::Armed {}
    client.identified().unwrap().map(|(summary, _)| summary)
}

#[test]
fn a_joint_is_found_within_the_bounds_of_the_proof_and_the_output_is_off() {
    let mut client = client();
    assert_eq!(client.identified().unwrap(), None);
    let summary = identified(&mut client, IdentificationRequest::default()).unwrap();
    let status = client.status().unwrap();
    assert_eq!((status.state, status.faults, status.at_rest), (StateCode::Stopped, 0, true));
    assert_eq!((summary.outcome, summary.doubts.is_none()), (Outcome::Done, true), "{summary:?}");
    let estimate = summary.estimate.unwrap();
    for (found, truth, share) in [
        (summary.breakaway[0].median, 0.40, 0.03),
        (summary.breakaway[1].median, 0.40, 0.03),
        (estimate.coulomb[0], 0.38, 0.03),
        (estimate.viscous[0], 0.02, 0.1),
        (estimate.inertia[0], 1.0 / 27.0, 0.05),
    ] {
        assert!((found / truth - 1.0).abs() < share, "{found} {truth} {summary:?}");
    }
    // It stays within its travel of 45 deg, and says so.
    assert!((30.0..90.0).contains(&summary.range), "{summary:?}");
    // Whatever arms next takes its place.
    client.arm().unwrap();
    assert_eq!(client.identified().unwrap(), None);
}

#[test]
fn it_begins_like_arming_refuses_more_than_the_device_allows_and_obeys_nothing_but_a_stop() {
    let said = |error: files::Error| error.to_string();
    let mut client = client();
    let ask =
        |asked| IdentificationRequest { effort: Some(asked), ..IdentificationRequest::default() };
    let message = said(client.identify_joint(ask(5.1)).unwrap_err());
    assert!(
        message.contains("`identification.effort_v` is 5.1; must be a number above 0, up to 5"),
        "{message}"
    );
    for asked in [
        ask(0.0),
        ask(f32::NAN),
        IdentificationRequest { travel: Some(721.0), ..IdentificationRequest::default() },
        IdentificationRequest { travel: Some(0.1), ..IdentificationRequest::default() },
        IdentificationRequest { speed: Some(1e5), ..IdentificationRequest::default() },
        IdentificationRequest { time: Some(1801.0), ..IdentificationRequest::default() },
    ] {
        assert!(client.identify_joint(asked).is_err(), "{asked:?}");
    }
    client.identify_joint(IdentificationRequest::default()).unwrap();
    client.pass(Duration::from_secs(5)).unwrap();
    assert!(said(client.move_to(1.0).unwrap_err()).contains("stop"));
    assert!(client.arm().is_err());
    client.stop().unwrap();
    assert_eq!(client.status().unwrap().state, StateCode::Stopped);
    assert_eq!(client.identified().unwrap(), None);
}

#[test]
fn wires_that_are_wrong_end_it_at_the_first_step_in_words() {
    for (wires, outcome) in [(Wires::Swapped, Outcome::Reversed), (Wires::Cut, Outcome::Still)] {
        let mut device = SimulatedDevice::new(&plans("step-response", &[])[0]).unwrap();
        device.wires = wires;
        device.ticks(10);
        let mut client = Client::connect(SimulatedWire::new(device)).unwrap();
        // As much effort as starts it, so that the stall's monitor does not come first.
        let asked = IdentificationRequest { effort: Some(0.6), ..IdentificationRequest::default() };
        let found = identified(&mut client, asked);
        let status = client.status().unwrap();
        match found {
            Some(summary) => {
                assert_eq!(summary.outcome, outcome, "{wires:?}: {summary:?}");
                assert!(summary.steps <= 2 && summary.range < 1.0, "{summary:?}");
            }
            // A dead encoder at more than the breakaway effort is a stall.
            None => assert_eq!((wires, status.fault.code), (Wires::Cut, Fault::Stall as u8)),
        }
        assert_ne!(status.state, StateCode::Armed);
    }
}

/// In the second of a pulse of 0.63 V it goes 27 (0.63 - 0.38) / 2 deg less what is viscous: 3 deg,
/// which are 50 counts.
#[test]
fn a_joint_of_few_counts_that_slides_is_not_taken_for_one_that_stands() {
    let coarse = "encoder.resolution_deg=0.06";
    let mut device = SimulatedDevice::new(&plans("step-response", &[coarse])[0]).unwrap();
    device.ticks(10);
    let mut client = Client::connect(SimulatedWire::new(device)).unwrap();
    let asked = IdentificationRequest {
        effort: Some(0.7),
        travel: Some(60.0),
        ..IdentificationRequest::default()
    };
    let found = identified(&mut client, asked);
    let summary = found.unwrap_or_else(|| panic!("{:?}", client.status().unwrap()));
    assert_eq!(summary.outcome, Outcome::Done, "{summary:?}");
    let [inertia, deviation] = summary.estimate.unwrap().inertia;
    assert!((inertia - 1.0 / 27.0).abs() < 4.0 * deviation.max(0.0025), "{summary:?}");
}

/// A servo with nothing around it.
struct Bare<'a>(&'a mut Servo);

impl Machine for Bare<'_> {
    fn servo<R>(&mut self, act: impl FnOnce(&mut Servo) -> R) -> R {
        act(self.0)
    }

    fn hardware(&self) -> Hardware {
        STM32F405
    }

    fn save(&mut self, _: &Parameters) -> Result<u32, RequestRefusal> {
        Ok(0)
    }

    fn reconfigure(&mut self, _: &Parameters) -> Result<(), RequestRefusal> {
        Ok(())
    }
}

/// A session whose answer with the fits is looked at piece by piece, as a board makes it.
struct Piecewise<'a> {
    session: Session,
    bare: Bare<'a>,
}

impl Piecewise<'_> {
    fn ask(&mut self, number: u16, request: Request) -> Vec<(u16, Reply)> {
        let frame = frame_of(self.session.number(), number, request);
        self.session.receive(&frame, &mut self.bare);
        self.said()
    }

    fn said(&mut self) -> Vec<(u16, Reply)> {
        let mut buffer = [0; 4096];
        let count = self.session.transmit(&mut buffer);
        replies(&buffer[..count])
    }

    /// Makes a number of pieces, none of which is the last one.
    fn pieces(&mut self, count: u32) {
        for _ in 0..count {
            assert!(self.session.work(&mut self.bare));
            assert_eq!(self.said(), []);
        }
    }

    /// Makes what is left, and returns the answer and the number of pieces.
    fn rest(&mut self) -> (Vec<(u16, Reply)>, u32) {
        let mut pieces = 1;
        while self.session.work(&mut self.bare) {
            assert_eq!(self.said(), []);
            pieces += 1;
        }
        (self.said(), pieces)
    }
}

/// The fits take a board longer than its watchdog waits. So it makes them piece by piece, and hears
/// what else is said in between.
#[test]
fn the_answer_with_the_fits_comes_once_at_its_end_and_not_after_another_request() {
    let mut client = client();
    identified(&mut client, IdentificationRequest::default()).unwrap();
    let servo = client.wire().simulated.device.servo();
    let summary = servo.identified().unwrap().summary();
    let mut session = Session::new(DeviceKind::Simulated, None);
    let mut bare = Bare(servo);
    session.receive(&hello(1, 7), &mut bare);
    let mut device = Piecewise { session, bare };
    device.said();
    let read = || Request::ReadIdentification;
    let answer = |number| vec![(number, Reply::Identification(Some(summary)))];
    // One pass of six pieces at least, and two of them and a look at most.
    assert_eq!(device.ask(2, read()), []);
    let (said, pieces) = device.rest();
    assert!(said == answer(2) && (6..=13).contains(&pieces), "{pieces}: {said:?}");
    // Once more after the answer, and again before another one.
    assert_eq!(device.ask(2, read()), answer(2));
    assert!(!device.session.work(&mut device.bare));
    assert_eq!(device.ask(3, read()), []);
    device.pieces(3);
    assert_eq!(device.ask(3, read()), []);
    let (said, left) = device.rest();
    assert_eq!((said, left), (answer(3), pieces - 3), "it has begun anew");
    // What was overtaken by it is not done, and an old stop leaves it alone.
    device.ask(8, read());
    device.pieces(2);
    assert_eq!(device.ask(7, Request::Arm), refused(7, RequestRefusal::OutOfOrder));
    assert_eq!(device.ask(6, Request::Stop), [(6, Reply::Done)]);
    assert_eq!(device.rest().0, answer(8));
    assert_eq!(device.ask(7, Request::Arm), refused(7, RequestRefusal::OutOfOrder));
    // Another request cancels it.
    for (number, other) in [(10, Request::Stop), (12, Request::Clear)] {
        device.ask(number - 1, read());
        device.pieces(2);
        assert_eq!(device.ask(number, other), [(number, Reply::Done)]);
        assert!(!device.session.work(&mut device.bare));
        assert_eq!(device.ask(number - 1, read()), refused(number - 1, RequestRefusal::OutOfOrder));
    }
}

/// What a sequence did until it ended.
struct Course {
    summary: Summary,
    /// Time and true position at ticks until the output was off, s and deg.
    path: Vec<[f64; 2]>,
    /// The fastest that it was then, deg/s.
    fastest: f64,
    /// What a file would be made of.
    found: IdentifiedJoint,
    tick_s: f64,
    count_deg: f64,
}

/// Runs a sequence tick by tick; `hand` may do something to the joint at a time, s. The output is
/// off in the tick in which it ends.
fn course(
    set: &[&str],
    asked: IdentificationRequest,
    mut hand: impl FnMut(&mut SimulatedDevice, f64),
) -> Course {
    let plan = &plans("step-response", set)[0];
    let mut device = SimulatedDevice::new(plan).unwrap();
    device.ticks(10);
    let mut client = Client::connect(SimulatedWire::new(device)).unwrap();
    client.identify_joint(asked).unwrap();
    let tick_s = client.wire().simulated.sample_time_s();
    let begin = client.status().unwrap().clock;
    let (mut path, mut fastest) = (Vec::new(), 0.0f64);
    loop {
        // A question takes ticks of its own, and keeps the link alive.
        let status = client.status().unwrap();
        let mut time_s = tick_s * f64::from(status.clock.wrapping_sub(begin));
        let simulated = &mut client.wire().simulated;
        path.push([time_s, simulated.position_deg()]);
        if status.state != StateCode::Armed {
            break;
        }
        for _ in 0..5 {
            hand(simulated, time_s);
            fastest = fastest.max(simulated.velocity_deg_per_s().abs());
            if !simulated.tick().enable {
                break;
            }
            time_s += tick_s;
            path.push([time_s, simulated.position_deg()]);
        }
        assert!(time_s < 1800.0, "it does not end");
    }
    let status = client.status().unwrap();
    assert_eq!((status.state, status.faults), (StateCode::Stopped, 0), "{status:?}");
    let output = client.wire().simulated.tick();
    assert!(!output.enable && output.tick.code == 0, "{output:?}");
    let (summary, map) = client.identified().unwrap().unwrap();
    let parameters = client.parameters().unwrap();
    let count_deg = f64::from(parameters.controller.encoder.resolution);
    let found = IdentifiedJoint { summary, map, parameters, units: None, gear: None };
    Course { summary, path, fastest, found, tick_s, count_deg }
}

impl Course {
    /// So far the joint is beyond a bound that has ended it, deg: the travel of a tick, and what a
    /// count does not show. The question that finds it stopped takes a tick more.
    fn beyond(&self) -> f64 {
        2.0 * self.fastest * self.tick_s + 2.0 * self.count_deg
    }

    fn farthest(&self) -> f64 {
        self.path.iter().map(|[_, at]| (at - self.path[0][1]).abs()).fold(0.0, f64::max)
    }

    /// The most by which the travel of any time is beyond that of a speed, deg: the largest rise of
    /// what is left, either way.
    fn faster_than(&self, speed: f64) -> f64 {
        let most = |sign: f64| {
            let (mut least, mut most) = (f64::INFINITY, 0.0f64);
            for left in self.path.iter().map(|[time_s, at]| sign * at - speed * time_s) {
                least = least.min(left);
                most = most.max(left - least);
            }
            most
        };
        most(1.0).max(most(-1.0))
    }

    /// No file is made of it, and it is said how it ended.
    fn is_no_file(&self, word: &str) {
        let document = Document::open("step-response").unwrap();
        let why = into::text(&self.found, &document).unwrap_err().to_string();
        assert!(why.contains(word), "{why}");
        assert_ne!(self.found.verdict(), "good", "{:?}", self.summary);
    }
}

/// A joint that hardly rubs once it slides runs far behind a pulse: it goes 0.45 deg with up to
/// 0.55 V, and 0.05 V stop it.
#[test]
fn the_bound_of_the_travel_ends_it_within_a_tick_of_it() {
    let slides = ["joint.friction.slip_v=0.05", "joint.viscous_v_per_deg_per_s=0.0"];
    let asked = IdentificationRequest {
        travel: Some(1.5),
        effort: Some(1.0),
        ..IdentificationRequest::default()
    };
    let course = course(&slides, asked, |_, _| {});
    assert_eq!(course.summary.outcome, Outcome::Travel, "{:?}", course.summary);
    let (farthest, beyond) = (course.farthest(), course.beyond());
    assert!(farthest > 1.5 && farthest <= 1.5 + beyond, "{farthest} {beyond}");
    course.is_no_file("raise the travel");
}

/// A joint that breaks away with 0.4 V and slides without friction gains 0.2 deg/s a tick.
#[test]
fn the_bound_of_the_speed_ends_it_within_its_slack_and_a_tick() {
    let slides = ["joint.friction.slip_v=0.0", "joint.viscous_v_per_deg_per_s=0.0"];
    let asked = IdentificationRequest { speed: Some(0.15), ..IdentificationRequest::default() };
    let course = course(&slides, asked, |_, _| {});
    assert_eq!(course.summary.outcome, Outcome::Speed, "{:?}", course.summary);
    // The slack of the speed is 8 counts.
    let (most, slack) = (course.faster_than(0.15), 8.0 * course.count_deg);
    assert!(most > slack && most <= slack + course.beyond(), "{most} {slack}");
    // It had no time to go far.
    assert!(course.farthest() < 1.0, "{}", course.farthest());
    course.is_no_file("lower the effort");
}

/// The same joint within a wider bound: nothing slows it down behind the first push.
#[test]
fn a_joint_that_goes_on_without_effort_ends_it_after_five_seconds() {
    let slides = ["joint.friction.slip_v=0.0", "joint.viscous_v_per_deg_per_s=0.0"];
    let course = course(&slides, IdentificationRequest::default(), |_, _| {});
    assert_eq!(course.summary.outcome, Outcome::RunsOn, "{:?}", course.summary);
    // Five seconds at the even speed that the push has left it: nothing drives it any more.
    let [end_s, end] = course.path.last().copied().unwrap();
    let last = course.path.iter().filter(|[time_s, _]| (0.5..4.9).contains(&(end_s - time_s)));
    for [time_s, at] in last {
        let slid = course.fastest * (end_s - time_s);
        assert!(((end - at) / slid - 1.0).abs() < 1e-3, "{time_s} {at}");
    }
    assert!(course.fastest > 0.2 && course.farthest() < 45.0, "{}", course.farthest());
    course.is_no_file("a load moves it");
}

/// A second after the first push the effort is small and negative; then a load tears the joint the
/// positive way.
#[test]
fn a_joint_that_is_pulled_the_same_way_twice_ends_it_before_a_pulse() {
    let mut is_pulled = false;
    let course = course(
        &[],
        IdentificationRequest { effort: Some(1.6), ..IdentificationRequest::default() },
        |device, time_s| {
            // 1.6 V in 8 s are 0.4 V after 2 s, and the joint rests by 2.5 s.
            if time_s >= 3.2 && !is_pulled {
                is_pulled = true;
                let at = device.position_deg();
                device.push(at, 1.0);
            }
        },
    );
    assert_eq!(course.summary.outcome, Outcome::Pulled, "{:?}", course.summary);
    assert!(course.summary.steps == 2 && course.farthest() < 1.0, "{:?}", course.summary);
    course.is_no_file("the same way under both efforts");
}
