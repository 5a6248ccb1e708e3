//! Property of frames: garbage does not damage the next frame.

use stiction::link::{Deframer, MAX_MESSAGE, NumberedMessage, Request, encode};

/// Returns the number of whole messages in the bytes.
pub fn holds(bytes: &[u8]) -> usize {
    let mut deframer = Deframer::default();
    let mut whole = 0;
    for &byte in bytes {
        if let Some(message) = deframer.push(byte) {
            assert!(message.len() <= MAX_MESSAGE);
            whole += 1;
        }
    }
    // A zero ends a frame, whole or not; a frame that is too long counts before its end.
    let ends = bytes.iter().filter(|&&byte| byte == 0).count();
    assert!(whole + deframer.bad() as usize <= ends + 1);

    let after = NumberedMessage { number: 0x1234, content: Request::Status };
    let frame = encode(&after).unwrap_or_default();
    deframer.push(0);
    let found = frame.iter().filter_map(|&byte| deframer.push(byte).map(<[u8]>::to_vec)).last();
    let found =
        found.and_then(|message| postcard::from_bytes::<NumberedMessage<Request>>(&message).ok());
    assert_eq!(found, Some(after), "a whole frame after garbage and a zero");
    whole
}
