//! Random bytes, random messages, random parameters. The number of cases is `STICTION_FUZZ` (messages of the state
//! machine; the test run takes 100 000). Ten million:
//! `STICTION_FUZZ=10000000 cargo test --release --test device random_messages -- --nocapture`.
//!
//! Blind to what a coverage-guided fuzzer would find behind a checksum: messages are made with a good one, bytes with
//! mostly bad ones.

use proptest::collection::vec;
use proptest::prelude::*;
use stiction::compensator::{Gains, ResetIntegralGains, SmoothRobustNonlinearGains};
use stiction::device::Device;
use stiction::fault::Latched;
use stiction::link::{Deframer, Law, Move, Numbered, PROTOCOL, Request, encode};
use stiction::parameters::{Motion, ROOM};
use stiction::pd::PdGains;
use stiction::position::Position;
use stiction::servo::{Boot, Input, State};
use stiction::{Fault, Parameters};

use crate::fixture::{srnf, stored};

fn config(cases: u32) -> ProptestConfig {
    ProptestConfig { cases, failure_persistence: None, ..ProptestConfig::default() }
}

proptest! {
    #![proptest_config(config(2000))]

    #[test]
    fn any_bytes_make_no_message_but_a_whole_one(bytes in vec(any::<u8>(), 0..600)) {
        let mut deframer = Deframer::default();
        let messages = bytes.iter().filter(|&&byte| deframer.push(byte).is_some()).count();
        // A checksum of 32 bits: one of 2^32 would pass.
        prop_assert_eq!(messages, 0);
    }

    #[test]
    fn a_message_survives_whatever_came_before_its_zero(garbage in vec(any::<u8>(), 0..600), number: u16) {
        let message = Numbered { number, content: Request::Status };
        let frame = encode(&message).unwrap();
        let mut deframer = Deframer::default();
        for byte in garbage.into_iter().chain([0]) {
            deframer.push(byte);
        }
        let found = frame.iter().filter_map(|&byte| deframer.push(byte).map(<[u8]>::to_vec)).last().unwrap();
        prop_assert_eq!(postcard::from_bytes::<Numbered<Request>>(&found).unwrap(), message);
    }

    #[test]
    fn any_bytes_are_parameters_or_a_reason(bytes in vec(any::<u8>(), 0..ROOM)) {
        prop_assert!(Parameters::decode(&bytes).is_err());
    }

    /// With a good checksum over it, so that the body is looked at.
    #[test]
    fn any_change_of_a_body_gives_valid_parameters_or_a_reason(
        changes in vec((20usize..150, any::<u8>()), 1..4),
    ) {
        let mut room = [0; ROOM];
        let length = srnf(&[]).encode(1, &mut room).unwrap().len();
        for (at, byte) in changes {
            room[20 + (at - 20) % (length - 20)] = byte;
        }
        let digest = crc::Crc::<u32>::new(&crc::CRC_32_ISO_HDLC);
        let mut sum = digest.digest();
        sum.update(&room[4..16]);
        sum.update(&room[20..length]);
        room[16..20].copy_from_slice(&sum.finalize().to_le_bytes());
        if let Ok((parameters, _)) = Parameters::decode(&room[..length]) {
            prop_assert!(parameters.prepare().is_ok());
        }
    }
}

proptest! {
    #![proptest_config(config(300))]

    /// A machine's file with characters changed, lines doubled and lines left out.
    #[test]
    fn any_change_of_a_file_gives_a_machine_or_one_sentence(
        changes in vec((any::<prop::sample::Index>(), "[ -~]{0,3}", 0..3u8), 1..6),
    ) {
        let mut lines: Vec<String> =
            host_sim::experiment::find("step-response").unwrap().toml.lines().map(str::to_owned).collect();
        for (at, text, how) in changes {
            let at = at.index(lines.len());
            match how {
                0 => lines[at] = format!("{text}{}", lines[at]),
                1 => lines.insert(at, lines[at].clone()),
                _ => drop(lines.remove(at)),
            }
        }
        let file = host_sim::experiment::Document::parse("joint.toml", &lines.join("\n"));
        if let Err(error) = file.and_then(|document| document.machine()) {
            let said = error.to_string();
            prop_assert!(said.starts_with("joint.toml") && said.lines().count() == 1, "{}", said);
        }
    }
}

/// xorshift64 (Marsaglia 2003): ten million messages need no shrinking, but a seed.
struct Random(u64);

impl Random {
    fn next(&mut self) -> u64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        self.0
    }

    fn below(&mut self, end: u64) -> u64 {
        (self.next() >> 11) % end
    }

    fn real(&mut self) -> f32 {
        match self.below(8) {
            0 => f32::from_bits(self.next() as u32),
            _ => self.below(1000) as f32 / 100.0,
        }
    }
}

fn request(random: &mut Random, record: &[u8]) -> Request {
    match random.below(16) {
        0 => Request::Stop,
        1 => Request::Status,
        2 => Request::Clear,
        3 | 4 => Request::Arm,
        5 => Request::Move(Move::Hold),
        6 | 7 => {
            let position = Position { counts: random.below(40_000) as i32 - 20_000, fraction: 0.0 };
            Request::Move(Move::To(Motion::Step(position)))
        }
        8 => Request::ReadParameters { offset: random.below(600) as u16 },
        9 => {
            let offset = random.below(record.len() as u64) as usize;
            let bytes = record[offset..].iter().copied().take(128).collect();
            Request::WriteParameters { offset: offset as u16, bytes }
        }
        10 => Request::TakeParameters { length: record.len() as u16 },
        11 => Request::ReadLaw,
        12 => {
            let srnf = SmoothRobustNonlinearGains { v_ms: random.real(), alpha: random.real() };
            let ri = ResetIntegralGains { ki: random.real(), theta_ri: random.real() };
            let one = [Gains::SmoothRobustNonlinear(srnf), Gains::ResetIntegral(ri)];
            let pd = PdGains { kp: random.real(), kd: random.real() };
            let take = random.below(3) as usize;
            Request::WriteLaw(Law { pd, compensator: one.into_iter().take(take).collect() })
        }
        13 => Request::Subscribe { terms: random.next() as u16, every: random.below(20) as u16 },
        14 => Request::Fault { index: random.next() as u8 },
        _ => Request::Hello { protocol: PROTOCOL, session: random.below(3) as u32 },
    }
}

#[test]
fn random_messages_never_arm_a_faulted_drive_nor_drive_it_out_of_its_limits() {
    let messages: u32 =
        std::env::var("STICTION_FUZZ").ok().and_then(|count| count.parse().ok()).unwrap_or(100_000);
    let parameters = srnf(&[]);
    let mut room = [0; ROOM];
    let record = parameters.encode(0, &mut room).unwrap().to_vec();
    let mut device = Device::start(stored(&parameters), Boot::default());
    let mut random = Random(0x5713_C710_0000_0001);
    let (mut number, mut counter, mut sink) = (0u16, 0u32, [0; 512]);
    let (mut armed, mut faulted, mut moved) = (0u32, 0u32, 0u32);
    for _ in 0..messages {
        if let State::Faulted(fault) = device.servo().state()
            && !fault.is_clearable()
        {
            // Only a reset ends it.
            device = Device::start(device.end(), Boot::default());
        }
        let before = device.servo().state();
        let content = request(&mut random, &record);
        let cleared = content == Request::Clear || matches!(content, Request::TakeParameters { .. });
        // Mostly in order; some come twice, late or early.
        number = number.wrapping_add([1, 1, 1, 1, 0, 2, 0xFFFF, 7][random.below(8) as usize]);
        let mut frame = encode(&Numbered { number, content }).unwrap();
        if random.below(16) == 0 {
            let at = random.below(frame.len() as u64) as usize;
            frame[at] ^= 1 << random.below(8);
        }
        device.receive(&frame);
        let after = device.servo().state();
        assert!(
            !matches!(before, State::Faulted(_)) || after == before || (cleared && after == State::Stopped),
            "{before:?} -> {after:?} without being cleared"
        );
        for _ in 0..random.below(8) {
            let before = device.servo().state();
            // The joint rests for the most part, and wanders now and then.
            if random.below(64) == 0 {
                counter = counter.wrapping_add(random.below(40) as u32).wrapping_sub(20);
            }
            if random.below(4096) == 0 {
                let fault = Fault::ALL[random.below(Fault::ALL.len() as u64) as usize];
                device.servo().latch(Latched::from(fault));
            }
            let faulted_before = matches!(device.servo().state(), State::Faulted(_));
            let output = device.tick(Input { counter, supply: random.next() as u16 });
            let drive =
                device.parameters().map(|p| stiction::drive::Drive::new(&p.controller.drive).unwrap());
            let drive = drive.unwrap();
            // Off means off: neutral, whatever was said.
            assert!(output.enable || output.duty == drive.duty(0));
            assert_eq!(output.enable, output.state == State::Armed);
            assert!(!(output.enable && (faulted_before || before == State::Boot)));
            assert!(output.tick.code.abs() <= drive.max_code() && output.duty.compare <= drive.pwm_top());
            if output.enable {
                assert_eq!(output.duty, drive.duty(output.tick.code));
            }
            armed += u32::from(output.enable);
            faulted += u32::from(matches!(output.state, State::Faulted(_)));
            moved += u32::from(output.enable && output.tick.setpoint.position.counts != 0);
        }
        // The wire takes most of it.
        if random.below(4) != 0 {
            device.transmit(&mut sink);
        }
    }
    println!("{messages} messages: {armed} ticks armed, {moved} of them on a move, {faulted} faulted");
    // It was worth looking.
    assert!(
        armed > messages / 20 && faulted > messages / 20 && moved > messages / 50,
        "{armed} {faulted} {moved}"
    );
}
