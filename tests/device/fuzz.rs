//! Random bytes, messages and parameters are given to the properties of `simulator::properties`,
//! which the targets of `fuzz/` call as well. `STICTION_FUZZ` is the number of messages through the
//! state machine: 100 000 in a test run, a million in `cargo xtask reliability`. These tests are
//! blind to what a coverage-guided fuzzer would find behind a checksum: messages are made with a
//! good one, bytes with mostly bad ones. `fuzz/` is for that.

use proptest::collection::vec;
use proptest::prelude::*;
use simulator::properties::session::CheckedDevice;
use simulator::properties::{file, frame, record, session};
use stiction::Motion;
use stiction::control::laws::{Gains, MAX_TERMS, ResetIntegralGains, SmoothRobustNonlinearGains};
use stiction::control::pd::PdGains;
use stiction::identification;
use stiction::link::{CHUNK, NO_SESSION, PROTOCOL, Request, encode_request};
use stiction::motion::home::HomeRequest;
use stiction::motion::jog::JogRequest;
use stiction::motion::winding::WindingRequest;
use stiction::parameters::{ROOM, record as form};
use stiction::units::position::Position;
use stiction::units::value::Key;

use crate::fixture::srnf;

/// Cases of everything random but the messages, in every test run.
const CASES: u32 = 2000;

fn config(cases: u32) -> ProptestConfig {
    ProptestConfig { cases, failure_persistence: None, ..ProptestConfig::default() }
}

proptest! {
    #![proptest_config(config(CASES))]

    #[test]
    fn any_bytes_make_no_message_but_a_whole_one_and_cost_only_themselves(
        bytes in vec(any::<u8>(), 0..600),
    ) {
        // The checksum has 32 bits: one frame of 2^32 would pass.
        prop_assert_eq!(frame::holds(&bytes), 0);
    }

    #[test]
    fn any_bytes_are_parameters_or_a_reason(bytes in vec(any::<u8>(), 0..ROOM)) {
        record::holds(&bytes);
    }

    /// The record has a good checksum, so that its body is looked at.
    #[test]
    fn any_change_of_a_body_gives_valid_parameters_or_a_reason(
        changes in vec((20usize..ROOM, any::<u8>()), 1..4),
    ) {
        let mut room = [0; ROOM];
        let length = srnf(&[]).encode(1, &mut room).unwrap().len();
        for (at, byte) in changes {
            room[20 + (at - 20) % (length - 20)] = byte;
        }
        record::holds(&room[..length]);
    }

    #[test]
    fn any_script_leaves_a_drive_within_its_limits(script in vec(any::<u8>(), 0..200)) {
        session::holds(&srnf(&[]), &script);
    }
}

proptest! {
    #![proptest_config(config(300))]

    /// The text is a machine's file with characters changed, lines doubled and lines left out.
    #[test]
    fn any_change_of_a_file_gives_a_machine_or_one_sentence(
        changes in vec((any::<prop::sample::Index>(), "[ -~]{0,3}", 0..3u8), 1..6),
    ) {
        let mut lines: Vec<String> =
            simulator::experiment::find("step-response")
                .unwrap()
                .toml
                .lines()
                .map(str::to_owned)
                .collect();
        for (at, text, how) in changes {
            let at = at.index(lines.len());
            match how {
                0 => lines[at] = format!("{text}{}", lines[at]),
                1 => lines.insert(at, lines[at].clone()),
                _ => drop(lines.remove(at)),
            }
        }
        file::holds(&lines.join("\n"));
    }
}

/// The random generator xorshift64 (Marsaglia 2003): ten million messages need no shrinking, but a
/// seed.
pub struct Random(pub u64);

impl Random {
    pub fn next(&mut self) -> u64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        self.0
    }

    pub fn below(&mut self, end: u64) -> u64 {
        (self.next() >> 11) % end
    }

    fn real(&mut self) -> f32 {
        match self.below(8) {
            0 => f32::from_bits(self.next() as u32),
            _ => self.below(1000) as f32 / 100.0,
        }
    }
}

/// Makes other gains and other laws, and now and then one value that may be anything.
fn entries(random: &mut Random) -> heapless::Vec<u8, CHUNK> {
    let srnf = SmoothRobustNonlinearGains { v_ms: random.real(), alpha: random.real() };
    let ri = ResetIntegralGains { ki: random.real(), theta_ri: random.real() };
    let one = [Gains::SmoothRobustNonlinear(srnf), Gains::ResetIntegral(ri)];
    let laws: heapless::Vec<_, MAX_TERMS> =
        one.into_iter().take(random.below(3) as usize).collect();
    let pd = PdGains { kp: random.real(), kd: random.real() };
    let mut room = [0; CHUNK];
    let mut length = form::write(&pd, &mut room).unwrap();
    length += form::write(&laws, &mut room[length..]).unwrap();
    if random.below(8) == 0 {
        let key = Key((random.below(0x18) << 8 | random.below(0x10)) as u16);
        form::put(&mut room, &mut length, key, random.next() as u32).unwrap();
    }
    room.into_iter().take(length).collect()
}

fn request(random: &mut Random, record: &[u8]) -> Request {
    match random.below(17) {
        0 => Request::Stop,
        1 => Request::Status,
        2 => Request::Clear,
        3 | 4 => Request::Arm,
        5 => Request::Move(Motion::Hold),
        kind @ (6 | 7) => {
            let position = Position { counts: random.below(40_000) as i32 - 20_000, fraction: 0.0 };
            let motion = if kind == 6 { Motion::Step } else { Motion::Profiled };
            Request::Move(motion(position))
        }
        8 => Request::ReadParameters { offset: random.below(600) as u16 },
        9 => {
            let offset = random.below(record.len() as u64) as usize;
            let bytes = record[offset..].iter().copied().take(128).collect();
            Request::WriteParameters { offset: offset as u16, bytes }
        }
        10 => Request::TakeParameters { length: record.len() as u16 },
        11 => Request::Signal { index: random.below(40) as u8 },
        12 => Request::Change { entries: entries(random) },
        13 => {
            // Masks have every length, so that the device knows some as a whole.
            let signals = random.next() >> random.below(64);
            Request::Subscribe { signals, every: random.below(20) as u16 }
        }
        14 => Request::Fault { index: random.next() as u8 },
        15 => match random.below(12) {
            0 => Request::ReadLevels,
            4 => Request::ReadIdentification,
            5 => Request::ReadMap,
            6 => Request::IdentifyJoint(identification::IdentificationRequest {
                time: Some(random.real()),
                ..identification::IdentificationRequest::default()
            }),
            1 => Request::ReadJog,
            8 => Request::ReadHome,
            10 => Request::ReadWinding,
            11 => Request::MeasureWinding(WindingRequest {
                effort: random.real(),
                periods: random.next() as u8,
                cycles: random.next() as u16,
            }),
            9 => Request::Home(HomeRequest { time: Some(random.real()), ..HomeRequest::default() }),
            3 => Request::SetBrownOut,
            2 => Request::Jog(JogRequest { effort: Some(random.real()), ..JogRequest::default() }),
            _ => Request::Identify { rate: random.real(), hold: random.real() },
        },
        _ => Request::Hello { protocol: PROTOCOL, session: random.below(3) as u32 },
    }
}

#[test]
fn random_messages_never_arm_a_faulted_drive_nor_drive_it_out_of_its_limits() {
    let messages: u64 =
        std::env::var("STICTION_FUZZ").ok().and_then(|count| count.parse().ok()).unwrap_or(100_000);
    let parameters = srnf(&[]);
    let mut room = [0; ROOM];
    let record = parameters.encode(0, &mut room).unwrap().to_vec();
    let mut watched = CheckedDevice::new(&parameters);
    let mut random = Random(0x5713_C710_0000_0001);
    let mut number = 0u16;
    for _ in 0..messages {
        watched.revive();
        let content = request(&mut random, &record);
        // Most numbers are in order; some come twice, late or early.
        number = number.wrapping_add([1, 1, 1, 1, 0, 2, 0xFFFF, 7][random.below(8) as usize]);
        // Some are of an earlier session, and some of none.
        let session = match random.below(16) {
            0 => NO_SESSION,
            1 => random.next() as u32,
            _ => watched.session(),
        };
        let mut frame = encode_request(session, number, content).unwrap();
        if random.below(16) == 0 {
            let at = random.below(frame.len() as u64) as usize;
            frame[at] ^= 1 << random.below(8);
        }
        watched.receive(&frame);
        for _ in 0..random.below(8) {
            // The joint rests for the most part, and wanders now and then.
            let travel = if random.below(64) == 0 { random.below(40) as i32 - 20 } else { 0 };
            if random.below(4096) == 0 {
                watched.latch(random.below(64) as usize);
            }
            watched.tick(travel, random.next() as u16);
        }
        // The wire takes most of what is sent.
        if random.below(4) != 0 {
            watched.drain(512);
        }
    }
    let CheckedDevice { armed, moved, faulted, .. } = watched;
    reliability!("messages", messages, armed, moved, faulted, cases = CASES);
    // The random messages have reached what they are to test.
    assert!(
        armed > messages / 20 && faulted > messages / 20 && moved > messages / 50,
        "{armed} {moved} {faulted}"
    );
}
