//! The guarded jog in the image: it finds what a simulated device finds, ends by itself with the
//! bridge off, and the guide of docs/reference/wiring.md leads to a first move.

use emulator::board_under_test::{BoardUnderTest, PlantInLockstep};
use emulator::wire::EmulatedWire;
use files::encoder::Wires;
use simulator::device::client::Client;
use simulator::device::simulated::SimulatedDevice;
use simulator::device::wire::SimulatedWire;
use simulator::experiment::RunPlan;
use stiction::Fault;
use stiction::link::StateCode;
use stiction::motion::jog::{JogEnd, JogFindings, JogRequest, Verdict};

use crate::common::{firmware, plans};
use crate::first_run::{Bench, follow, jogged};

/// The thesis's joint with gains that do nothing; a slower PWM costs the emulator less time.
fn untuned() -> RunPlan {
    let set =
        ["drive.pwm_hz=2000", "controller.pd.kp_v_per_deg=0", "controller.pd.kd_v_per_deg_per_s=0"];
    plans("step-response", &["pd"], &set).remove(0)
}

fn board(wires: Wires, brake_v: f64) -> Client<EmulatedWire> {
    let mut wire = EmulatedWire::with(&firmware(), &untuned()).unwrap();
    let act = wire.board.act(move |halted| {
        halted.rewire(wires);
        halted.plant().brake_v = brake_v;
    });
    act.unwrap();
    Client::connect(wire).unwrap()
}

#[test]
fn a_jog_finds_what_a_simulated_device_finds_and_leaves_the_bridge_off() {
    for (wires, brake_v, verdict) in [
        (Wires::Sound, 0.0, Verdict::Agrees),
        (Wires::Swapped, 0.0, Verdict::Reversed),
        (Wires::Cut, 0.0, Verdict::Still),
        (Wires::OneCut, 0.0, Verdict::Noise),
        (Wires::Sound, 9.0, Verdict::Still),
    ] {
        let mut simulated = SimulatedDevice::new(&untuned()).unwrap();
        simulated.ticks(10);
        (simulated.wires, simulated.brake_v) = (wires, brake_v);
        let here = jogged(&mut Client::connect(SimulatedWire::new(simulated)).unwrap()).unwrap();
        let mut client = board(wires, brake_v);
        let there = jogged(&mut client).unwrap();
        assert_eq!(there.verdict(), verdict, "{wires:?}: {there:?}");
        if matches!(wires, Wires::Cut | Wires::OneCut) {
            // A pulled-up pin whose wire is cut rises once: a count, which a simulated device has
            // not.
            let ends = |found: JogFindings| found.ways.map(|way| (way.effort, way.ended));
            assert_eq!(ends(there), ends(here));
            assert!(there.ways.iter().all(|way| way.moved.abs() <= 2), "{there:?}");
        } else {
            assert_eq!(there, here, "{wires:?}");
        }
        assert_eq!(client.status().unwrap().faults, 0, "{wires:?}");
        let board = &mut client.wire().board;
        said_begin_and_end(board, &there);
        assert!(!board.samples(2).unwrap().bridge.is_on(), "{wires:?}");
        // The closed form of tests/device/jog.rs gives 0.23 deg each way of a dead encoder.
        let travel = board.act(|halted| halted.plant().position_deg()).unwrap().abs();
        assert!(travel < 0.46, "{wires:?}: {travel} deg");
    }
}

/// The log has a line for the begin of the jog and one for its end, with what was found.
#[track_caller]
fn said_begin_and_end(board: &mut BoardUnderTest<PlantInLockstep>, found: &JogFindings) {
    board.samples(20).unwrap();
    let log = board.act(|halted| halted.harness.log.lines.clone()).unwrap();
    let [begin, end] = ["jog: pushes", "counts by"].map(|text| {
        let mut lines = log.iter().filter(|line| line.text.contains(text));
        let line = lines.next().unwrap_or_else(|| panic!("{text}: {log:?}"));
        assert!(lines.next().is_none(), "{text} twice: {log:?}");
        line
    });
    assert!(begin.text.starts_with("jog: ") && end.text.starts_with("jog: "), "{log:?}");
    let moved = found.ways.map(|way| format!("{} counts", way.moved));
    assert!(moved.iter().all(|moved| end.text.contains(moved)), "{end:?}, {found:?}");
    let verdict = match found.verdict() {
        Verdict::Agrees => "in the sense of the effort",
        Verdict::Reversed => "AGAINST the effort",
        Verdict::Still => "nothing moved",
        Verdict::Noise => "to and fro",
        other => panic!("{other:?}"),
    };
    assert!(end.text.ends_with(verdict), "{end:?}");
}

#[test]
fn a_link_that_is_cut_in_the_middle_of_a_jog_turns_the_bridge_off() {
    let mut client = board(Wires::Sound, 9.0);
    // 0.05 V/s: it would take 10 s.
    client.jog(JogRequest { rate: Some(0.05), ..JogRequest::default() }).unwrap();
    let board = &mut client.wire().board;
    assert!(board.samples(20).unwrap().bridge.is_on());
    // 0.5 s of silence are 25 ticks.
    assert!(!board.samples(7).unwrap().bridge.is_on());
    let status = client.status().unwrap();
    assert_eq!(status.state, StateCode::Faulted(Fault::LinkTimeout as u8));
    assert_eq!(client.jogged().unwrap(), None);
    // The time ends it if nothing else does.
    client.clear().unwrap();
    client.jog(JogRequest { rate: Some(0.05), time: Some(0.4), ..JogRequest::default() }).unwrap();
    client.pass_armed(std::time::Duration::from_secs(1)).unwrap();
    assert_eq!(client.jogged().unwrap().unwrap().ways[0].ended, JogEnd::Time);
}

impl Bench for EmulatedWire {
    // The emulator models no contents of the flash.
    const KEEPS: bool = false;

    fn truth_deg(&mut self) -> f64 {
        self.board.act(|halted| halted.plant().position_deg()).unwrap()
    }
}

#[test]
fn the_first_run_can_be_followed_on_the_emulated_board() {
    let tuned = plans("step-response", &["srnf"], &["drive.pwm_hz=2000"]).remove(0);
    let tuned = simulator::device::parameters(&tuned).unwrap();
    follow(&mut board(Wires::Swapped, 0.0), &tuned, true);
}
