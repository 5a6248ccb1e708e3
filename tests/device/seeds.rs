//! Every seed of the fuzzer (`fuzz/seeds/TARGET/`) goes through the function that its target calls.
//! The seeds called `made-*` are made here, from real messages: `STICTION_SEEDS=write cargo test
//! --test device seeds` renews them. The others are inputs that the fuzzer found and that were
//! worth keeping.

use std::fs;
use std::path::{Path, PathBuf};

use simulator::properties::{self, file, frame, session};
use stiction::Motion;
use stiction::control::laws::FIRST_LAW;
use stiction::control::pd::PdGains;
use stiction::control::signal::SIGNALS;
use stiction::identification;
use stiction::link::{
    CHUNK, NO_SESSION, NumberedMessage, PROTOCOL, REQUEST, Request, encode_request,
};
use stiction::motion::home::HomeRequest;
use stiction::motion::jog::JogRequest;
use stiction::motion::winding::WindingRequest;
use stiction::parameters::{ROOM, record};
use stiction::units::position::Position;

use crate::fixture::{parameters, plans, srnf};

const TARGETS: [&str; 4] = ["frame", "session", "parameters", "machine"];

fn folder(target: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../fuzz/seeds").join(target)
}

fn message(session: u32, number: u16, content: Request) -> Vec<u8> {
    let is_hello = matches!(content, Request::Hello { .. });
    let mut room = [0; 512];
    let message = NumberedMessage { number, content };
    if is_hello {
        return postcard::to_slice(&message, &mut room).unwrap().to_vec();
    }
    postcard::to_slice(&(REQUEST, session, message), &mut room).unwrap().to_vec()
}

/// Makes one request of every kind, in an order in which the device does most of them.
fn requests() -> Vec<Request> {
    let mut room = [0; ROOM];
    let record = srnf(&[]).encode(0, &mut room).unwrap().to_vec();
    // This is plain PD without gains.
    let mut entries = [0; CHUNK];
    let mut length = record::write(&PdGains::default(), &mut entries).unwrap();
    record::put(&mut entries, &mut length, FIRST_LAW, 0).unwrap();
    let entries = entries.into_iter().take(length).collect();
    let mut all = vec![
        Request::Hello { protocol: PROTOCOL, session: 1 },
        Request::Status,
        Request::ReadParameters { offset: 0 },
        Request::Signal { index: 0 },
        Request::Signal { index: SIGNALS.len() as u8 },
        Request::Change { entries },
    ];
    all.extend(record.chunks(128).enumerate().map(|(i, piece)| Request::WriteParameters {
        offset: 128 * i as u16,
        bytes: piece.iter().copied().collect(),
    }));
    all.extend([
        Request::TakeParameters { length: record.len() as u16 },
        Request::Save,
        Request::Subscribe { signals: (1 << SIGNALS.len()) - 1, every: 2 },
        Request::Arm,
        Request::Move(Motion::Step(Position { counts: 1000, fraction: 0.5 })),
        Request::Move(Motion::Profiled(Position { counts: -2000, fraction: 0.25 })),
        Request::Move(Motion::Hold),
        Request::Stop,
        Request::Identify { rate: 0.5, hold: 0.1 },
        Request::Stop,
        Request::ReadLevels,
        Request::Jog(JogRequest { effort: Some(0.5), ..JogRequest::default() }),
        Request::Stop,
        Request::ReadJog,
        Request::IdentifyJoint(identification::IdentificationRequest {
            time: Some(2.0),
            ..Default::default()
        }),
        Request::Stop,
        Request::ReadIdentification,
        Request::ReadMap,
        Request::Home(HomeRequest { time: Some(2.0), ..HomeRequest::default() }),
        Request::Stop,
        Request::ReadHome,
        Request::MeasureWinding(WindingRequest { effort: 0.5, periods: 1, cycles: 10 }),
        Request::Stop,
        Request::ReadWinding,
        Request::Clear,
        Request::Fault { index: 0 },
    ]);
    all
}

/// Returns the number of the session that a device begins after its first ticks at rest.
fn session_of_the_script(ticks: u8) -> u32 {
    let mut device = session::CheckedDevice::new(&srnf(&[]));
    (0..ticks).for_each(|_| device.tick(0, 2048));
    let hello = requests().swap_remove(0);
    device.receive(&encode_request(NO_SESSION, 1, hello).unwrap());
    device.session()
}

/// Writes every request as a frame of the script, with half a second after each.
fn script() -> Vec<u8> {
    let rest = [b't', 25, 0];
    let session = session_of_the_script(rest[1]);
    let said = requests().into_iter().zip(1..).flat_map(|(request, number)| {
        // On a move the joint follows; one that stands still would stall.
        let travel = if let Request::Move(Motion::Step(_)) = request { 40 } else { 0 };
        let message = message(session, number, request);
        [&[b'm', message.len() as u8], &message[..], &[b't', 25, travel]].concat()
    });
    rest.into_iter().chain(said).chain(*b"f\x05t\x0A\x01d\x40").collect()
}

/// The seeds that are made here: target, name and content of each.
fn made() -> Vec<(&'static str, &'static str, Vec<u8>)> {
    let frames = requests().into_iter().zip(1..);
    let frames = frames.flat_map(|(content, number)| encode_request(1, number, content).unwrap());
    let ramp = &plans("friction-identification", &[])[0];
    let trajectory = &plans("trajectory", &[])[0];
    let record =
        |parameters: &stiction::Parameters| parameters.encode(1, &mut [0; ROOM]).unwrap().to_vec();
    let toml = |name| simulator::experiment::find(name).unwrap().toml.as_bytes().to_vec();
    vec![
        ("frame", "made-requests", frames.collect()),
        ("session", "made-one-of-each", script()),
        ("parameters", "made-srnf", record(&srnf(&[]))),
        ("parameters", "made-trajectory", record(&parameters(trajectory))),
        ("parameters", "made-ramp", record(&parameters(ramp))),
        ("machine", "made-step-response", toml("step-response")),
        ("machine", "made-trajectory", toml("trajectory")),
        ("machine", "made-friction-identification", toml("friction-identification")),
    ]
}

#[test]
fn the_seeds_are_those_of_the_messages_as_they_are() {
    let write = std::env::var("STICTION_SEEDS").is_ok_and(|how| how == "write");
    for (target, name, content) in made() {
        let path = folder(target).join(name);
        if write {
            fs::create_dir_all(folder(target)).unwrap();
            fs::write(&path, &content).unwrap();
        }
        let kept = fs::read(&path).unwrap_or_default();
        assert!(kept == content, "{}: renew it with STICTION_SEEDS=write", path.display());
    }
}

#[test]
fn every_seed_holds() {
    let parameters = srnf(&[]);
    let mut worth = [0; TARGETS.len()];
    for (target, worth) in TARGETS.into_iter().zip(&mut worth) {
        for entry in fs::read_dir(folder(target)).unwrap() {
            let bytes = fs::read(entry.unwrap().path()).unwrap();
            *worth += match target {
                "frame" => frame::holds(&bytes) as u64,
                "session" => session::holds(&parameters, &bytes).moved,
                "parameters" => u64::from(properties::record::holds(&bytes)),
                _ => std::str::from_utf8(&bytes).map_or(0, |text| u64::from(file::holds(text))),
            };
        }
    }
    // Some seeds of each kind get through: whole frames, moves that are made, and valid records and
    // files.
    assert!(worth[0] >= 18 && worth[1] >= 25 && worth[2] >= 3 && worth[3] >= 3, "{worth:?}");
}
