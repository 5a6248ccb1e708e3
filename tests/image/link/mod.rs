//! The command link on the image's own USART: a script of requests, each at its time, and the
//! answers.
//!
//! The joint is blocked: what is looked at are the answers, and the bridge.

mod commands;
mod parameters;
mod receiving;
mod saving;
mod telemetry;

use std::sync::{Arc, Mutex};

use emulator::board::FittedParts;
use emulator::fault_injection::{BoardObservation, Injection, converse};
use stiction::link::{
    CHUNK, Deframer, Message, NO_SESSION, NumberedMessage, PROTOCOL, Reply, Request,
    RequestRefusal, Sample, StateCode, Status, encode_request,
};
use stiction::parameters::ROOM;
use stiction::{Fault, Parameters};

use crate::common::firmware;
use crate::fault_injection::{MS, parameters};

/// By then a board has ticked long enough to be armed at 20 ms.
const READY: u64 = 200 * MS;

/// Parameters of a board that waits for commands and watches for a silent link alone.
fn commanded(change: impl Fn(&mut Parameters)) -> Parameters {
    let (mut parameters, _) = Parameters::decode(&parameters()).unwrap();
    parameters.device.autostart = false;
    parameters.limits.link_timeout = 0.5;
    change(&mut parameters);
    parameters
}

fn record(parameters: &Parameters) -> Vec<u8> {
    parameters.encode(1, &mut [0; ROOM]).unwrap().to_vec()
}

/// What a client says, each at its time (ns), numbered in this order from 1 on: the first is a
/// hello.
struct Script {
    says: Vec<(u64, Say)>,
    number: u16,
}

/// What a client says. A request is encoded when it is due: by then the device has chosen the
/// number of the session.
enum Say {
    Bytes(Vec<u8>),
    Request(u16, Request),
}

impl Say {
    fn frame(self, session: u32) -> Vec<u8> {
        match self {
            Self::Bytes(bytes) => bytes,
            Self::Request(number, request) => {
                // It asks for the number.
                let is_open = matches!(request, Request::Open { .. });
                let session = if is_open { NO_SESSION } else { session };
                encode_request(session, number, request).unwrap().to_vec()
            }
        }
    }
}

/// A number of a session, as long on the wire as nearly every other one.
const SESSION: u32 = u32::MAX;

impl Script {
    fn new() -> Self {
        let mut script = Self { says: vec![], number: 0 };
        script.hello(READY, 7);
        script
    }

    /// A hello, and the request for the number of the session.
    fn hello(&mut self, at: u64, hello: u32) {
        self.garbage(at, &[0]);
        self.say(at, Request::Hello { protocol: PROTOCOL, session: hello });
        self.say(at, Request::Open { hello });
    }

    /// Bytes on the wire in all.
    fn bytes(&self) -> usize {
        let frame = |request: &Request, number| {
            encode_request(SESSION, number, request.clone()).unwrap().len()
        };
        let lengths = self.says.iter().map(|(_, say)| match say {
            Say::Bytes(bytes) => bytes.len(),
            Say::Request(number, request) => frame(request, *number),
        });
        lengths.sum()
    }

    /// Returns the number that the answer will have.
    fn say(&mut self, at: u64, request: Request) -> u16 {
        self.number += 1;
        self.says.push((at, Say::Request(self.number, request)));
        self.number
    }

    fn garbage(&mut self, at: u64, bytes: &[u8]) {
        self.says.push((at, Say::Bytes(bytes.to_vec())));
    }

    /// A status now and then, so that the link does not fall silent.
    fn status(&mut self, at: std::ops::Range<u64>) -> u16 {
        at.step_by(100 * MS as usize).map(|at| self.say(at, Request::Status)).last().unwrap()
    }

    /// A record in pieces; the number of the answer to its taking.
    fn push(&mut self, at: u64, record: &[u8]) -> u16 {
        for (i, piece) in record.chunks(CHUNK).enumerate() {
            let (offset, bytes) = ((i * CHUNK) as u16, piece.iter().copied().collect());
            self.say(at + i as u64 * 4 * MS, Request::WriteParameters { offset, bytes });
        }
        self.say(at + 20 * MS, Request::TakeParameters { length: record.len() as u16 })
    }

    /// All at once.
    fn burst(&mut self, at: u64, requests: impl IntoIterator<Item = Request>) -> Vec<u16> {
        requests.into_iter().map(|request| self.say(at, request)).collect()
    }

    fn run(self, records: Option<&[u8]>, injections: &[(u64, Injection)], until: u64) -> Talked {
        self.run_on(FittedParts::default(), records, injections, until)
    }

    fn run_on(
        self,
        fitted: FittedParts,
        first: Option<&[u8]>,
        injections: &[(u64, Injection)],
        until: u64,
    ) -> Talked {
        let heard = Arc::new(Mutex::new((Deframer::default(), vec![])));
        let (mut says, into) = (self.says.into_iter().peekable(), heard.clone());
        let mut session = NO_SESSION;
        let partner = move |at: u64, bytes: &[u8]| {
            let (deframer, messages) = &mut *into.lock().unwrap();
            for &byte in bytes {
                if let Some(message) = deframer.push(byte) {
                    let message = postcard::from_bytes::<Message>(message).unwrap();
                    if let Message::Reply(NumberedMessage {
                        content: Reply::Session(number), ..
                    }) = message
                    {
                        session = number;
                    }
                    messages.push((at, message));
                }
            }
            let due = std::iter::from_fn(|| says.next_if(|(due, _)| *due <= at));
            due.flat_map(|(_, say)| say.frame(session)).collect()
        };
        let board = firmware();
        let observed =
            converse(&board, [first, None], fitted, injections, until, Box::new(partner)).unwrap();
        let (deframer, messages) = &*heard.lock().unwrap();
        assert_eq!(deframer.bad(), 0);
        let mut talked = Talked { observed, replies: vec![], samples: vec![] };
        for (at, message) in messages {
            match message.clone() {
                Message::Reply(NumberedMessage { number, content }) => {
                    talked.replies.push((*at, number, content))
                }
                Message::Sample(sample) => talked.samples.push(sample),
            }
        }
        talked
    }
}

struct Talked {
    observed: BoardObservation,
    replies: Vec<(u64, u16, Reply)>,
    samples: Vec<Sample>,
}

impl Talked {
    /// The only answer to a request.
    #[track_caller]
    fn reply(&self, number: u16) -> &Reply {
        let mut replies = self.replies.iter().filter(|(_, of, _)| *of == number);
        match (replies.next(), replies.next()) {
            (Some((.., reply)), None) => reply,
            _ => panic!("{number}: {:?}, log {:?}", self.replies, self.observed.log),
        }
    }

    #[track_caller]
    fn status(&self, number: u16) -> Status {
        let Reply::Status(status) = self.reply(number) else {
            panic!(
                "{:?}, log {:?}, {:?}",
                self.reply(number),
                self.observed.log,
                self.observed.resets
            )
        };
        *status
    }

    #[track_caller]
    fn assert_done(&self, number: u16) {
        assert_eq!(*self.reply(number), Reply::Done, "{:?}", self.observed.log);
    }

    #[track_caller]
    fn assert_refused(&self, number: u16, why: RequestRefusal) {
        assert_eq!(*self.reply(number), Reply::Refused(why));
    }
}

const fn faulted(fault: Fault) -> StateCode {
    StateCode::Faulted(fault as u8)
}
