//! Clients that misbehave: frames of other sessions, replayed, garbled, cut and in floods, random
//! commands, takeovers and silence. Travel, heat and duty stay within the bounds of `hostile.rs`,
//! and only a request of the session, in order, arms.
//!
//! The wires are sound. `fuzz.rs` has random parameters, jogs and identifications, whose travel has
//! other bounds.

use simulator::device::simulated::SimulatedDevice;
use stiction::Motion;
use stiction::link::{NO_SESSION, PROTOCOL, Request, encode_request};
use stiction::servo::State;
use stiction::units::position::Position;

use crate::hostile::{COUNT, Hostile, law_plan};
use experiments::controllers;

/// Frames, or floods of them, to a device with one law.
const TURNS: u32 = 4000;

/// Frames that a replay has to choose from.
const KEPT: usize = 64;

/// Ticks of the link timeout of 0.5 s.
const TIMEOUT: u32 = 25;

/// Clients on one wire.
struct Clients {
    number: u16,
    sessions: [u32; 2],
    kept: Vec<Vec<u8>>,
    /// Ticks since the last frame that the device may take for a sign of life.
    silent: u32,
    /// Whether the last frame had no end: the next one is lost with it.
    is_cut: bool,
    replays: u32,
    strangers: u32,
}

/// What a frame may do.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Origin {
    /// A new frame of the session, or one that any client may send.
    Valid,
    /// A frame of another session, or one that has come before.
    Foreign,
    /// A frame that was damaged.
    Damaged,
}

impl Clients {
    fn request(hostile: &mut Hostile) -> Request {
        let random = &mut hostile.random;
        match random.below(20) {
            0..=5 => Request::Arm,
            6..=8 => Request::Clear,
            9..=13 => {
                let to_deg = random.below(8000) as f64 / 200.0 - 20.0;
                let to = Position::from_counts((to_deg / COUNT) as i32);
                let motion = if random.below(2) == 0 { Motion::Step } else { Motion::Profiled };
                Request::Move(motion(to))
            }
            14 => Request::Move(Motion::Hold),
            15 => Request::Stop,
            16 => Request::Status,
            17 => Request::Save,
            18 => Request::SetReference { position: random.next() as i32 },
            _ => Request::Subscribe { signals: random.next(), every: 1 },
        }
    }

    /// Makes the next frame.
    fn frame(&mut self, hostile: &mut Hostile) -> (Origin, Vec<u8>) {
        let follows_cut = std::mem::take(&mut self.is_cut);
        if !self.kept.is_empty() && hostile.random.below(6) == 0 {
            self.replays += 1;
            let which = hostile.random.below(self.kept.len() as u64) as usize;
            return (Origin::Foreign, self.kept[which].clone());
        }
        self.number = self.number.wrapping_add(1);
        let current = hostile.device.device.session();
        if current != self.sessions[1] {
            self.sessions = [self.sessions[1], current];
        }
        let (session, request) = match hostile.random.below(24) {
            0 => {
                let hello = hostile.random.next() as u32;
                (NO_SESSION, Request::Hello { protocol: PROTOCOL, session: hello })
            }
            1 if hostile.random.below(4) == 0 => (NO_SESSION, Request::TakeOver),
            2 => (NO_SESSION, Self::request(hostile)),
            3 => (hostile.random.next() as u32 | 1, Self::request(hostile)),
            4 => (self.sessions[0], Self::request(hostile)),
            _ => (current, Self::request(hostile)),
        };
        let is_for_all = matches!(request, Request::Hello { .. } | Request::TakeOver);
        let is_foreign = !is_for_all && (session != current || session == NO_SESSION);
        self.strangers += u32::from(is_foreign);
        let mut frame = encode_request(session, self.number, request).unwrap().to_vec();
        let origin = if is_foreign { Origin::Foreign } else { Origin::Valid };
        match hostile.random.below(24) {
            0 => {
                let at = hostile.random.below(frame.len() as u64) as usize;
                frame[at] ^= 1 << hostile.random.below(8);
                (Origin::Damaged, frame)
            }
            1 => {
                frame.truncate(hostile.random.below(frame.len() as u64) as usize);
                self.is_cut = true;
                (Origin::Damaged, frame)
            }
            // It may be lost, or not: nothing may have been left of the frame before.
            _ if follows_cut => (origin, frame),
            _ => {
                // A hello that comes again is a new one, once another has ended its session. A
                // frame that was lost before is no replay, but a client's second try.
                if !is_for_all {
                    if self.kept.len() == KEPT {
                        self.kept.remove(0);
                    }
                    self.kept.push(frame.clone());
                }
                (origin, frame)
            }
        }
    }

    /// Sends a frame, and checks that nothing but a new frame of the session arms.
    fn send(&mut self, hostile: &mut Hostile, name: &str) {
        let (origin, frame) = self.frame(hostile);
        let before = hostile.device.device.servo().state();
        hostile.device.device.receive(&frame);
        let after = hostile.device.device.servo().state();
        if origin == Origin::Valid {
            self.silent = 0;
        } else {
            assert!(before == State::Armed || after != State::Armed, "{name}: {origin:?}");
        }
        let mut answers = [0; 4096];
        hostile.device.device.transmit(&mut answers);
    }
}

#[test]
fn clients_that_misbehave_move_heat_and_drive_no_further_than_the_bounds_of_one_that_does_not() {
    for law in controllers() {
        let device = SimulatedDevice::new(&law_plan(law, &[])).unwrap();
        let (following, stop_s) = {
            let parameters = device.device.parameters().unwrap();
            let limits = &parameters.limits;
            (f64::from(limits.following_error + limits.encoder_jump), parameters.device.stop_time)
        };
        let mut hostile = Hostile::new(device, law.len() as u64);
        let mut clients = Clients {
            number: 0,
            sessions: [NO_SESSION; 2],
            kept: vec![],
            silent: 0,
            is_cut: false,
            replays: 0,
            strangers: 0,
        };
        // Silence, the controlled stop, and the tick of each.
        let longest = TIMEOUT + (stop_s / 0.02).ceil() as u32 + 2;
        for turn in 0..TURNS {
            let name = format!("{law}, turn {turn}");
            hostile.turn_by_hand(&name);
            let flood = if hostile.random.below(8) == 0 { 20 } else { 1 };
            for _ in 0..flood {
                clients.send(&mut hostile, &name);
            }
            let is_silent = hostile.random.below(16) == 0;
            let ticks = if is_silent { 60 } else { 1 + hostile.random.below(20) };
            for _ in 0..ticks {
                clients.silent += 1;
                let Some(outside) = hostile.tick(&name) else { continue };
                assert!(outside <= following, "{name}: {outside} of {following} deg");
                assert!(clients.silent <= longest, "{name}: {} ticks", clients.silent);
                hostile.outside_sound = hostile.outside_sound.max(outside);
            }
        }
        let Hostile { armed, trips, .. } = hostile;
        let Clients { replays, strangers, .. } = clients;
        assert!(armed > TURNS && trips > TURNS / 100, "{law}: {armed}, {trips}");
        assert!(replays > TURNS / 10 && strangers > TURNS / 20, "{law}: {replays}, {strangers}");
        let [outside_deg, hottest_v] =
            [hostile.outside_sound, hostile.hottest].map(|v| format!("{v:.1}"));
        reliability!(
            "misbehaving-client",
            law,
            armed,
            trips,
            replays,
            strangers,
            outside_deg,
            hottest_v
        );
    }
}
