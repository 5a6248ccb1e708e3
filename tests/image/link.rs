//! The command link on the image's own USART.

use std::sync::{Arc, Mutex};

use host_sim::emulator::bench::converse;
use host_sim::emulator::board::Fitted;
use stiction::link::{Deframer, Message, Numbered, PROTOCOL, Reply, Request, encode};

use crate::bench::{MS, firmware, parameters};

#[test]
fn a_hello_is_answered() {
    let hello = Request::Hello { protocol: PROTOCOL, session: 7 };
    let frame = encode(&Numbered { number: 1, content: hello }).unwrap().to_vec();
    let heard = Arc::new(Mutex::new((Deframer::default(), vec![])));
    let (mut sent, into) = (false, heard.clone());
    let partner = move |at: u64, bytes: &[u8]| {
        let (deframer, replies) = &mut *into.lock().unwrap();
        for &byte in bytes {
            if let Some(message) = deframer.push(byte) {
                replies.push((at, postcard::from_bytes::<Message>(message).unwrap()));
            }
        }
        if at < 100 * MS || std::mem::replace(&mut sent, true) {
            vec![]
        } else {
            [vec![0], frame.clone()].concat()
        }
    };
    let observed = converse(
        &firmware(),
        [Some(&parameters()), None],
        Fitted::default(),
        &[],
        150 * MS,
        Box::new(partner),
    )
    .unwrap();
    let replies = &heard.lock().unwrap().1;
    println!("{replies:?} {:?}", observed.log);
    assert!(
        matches!(replies[..], [(_, Message::Reply(Numbered { number: 1, content: Reply::Hello(_) }))]),
        "{replies:?}"
    );
}
