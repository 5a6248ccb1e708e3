//! The studio in the page itself: [`Playground`] as WebAssembly (wasm32-wasip1).
//!
//! The page's worker (`studio-page/src/playground/worker.ts`) provides the program's environment:
//! arguments, a file, a clock, standard input and output. Only bytes cross the border, no
//! addresses.
//!
//! ```text
//! arguments        the machine: the name of a built-in experiment, of a typical joint, or a file
//! standard input   requests of the page, a line of JSON each
//! standard output  messages to the page: `t` or `b`, length (u32, little endian), text or frame
//! playground_pass  executes the requests, and advances the device until it waits. The page's
//!                  clock stands still meanwhile, except for that wait
//! ```

use std::cell::RefCell;
use std::io::{BufRead as _, Write as _, stdin, stdout};

use files::Error;
use host_sim::studio::{Playground, StudioMessage};
use serde_json::json;
use simulator::draft::{TYPICAL, text};

/// The controller that a built-in experiment starts with, as in `stiction studio`.
const USUAL: &str = "srnf";

thread_local! {
    /// The playground that the page has opened.
    static OPEN: RefCell<Option<Playground>> = const { RefCell::new(None) };
}

/// Opens the machine that the arguments name, and returns whether that was possible. If not, the
/// page has received the reason.
#[unsafe(no_mangle)]
#[allow(unsafe_code, reason = "a name that the page calls, and no other item has it")]
pub extern "C" fn playground_open() -> bool {
    let machine = std::env::args().nth(1).unwrap_or_default();
    match opened(&machine) {
        Ok(playground) => {
            OPEN.set(Some(playground));
            true
        }
        Err(error) => {
            let why = json!({ "event": "not-opened", "said": error.to_string() });
            send(b't', why.to_string().as_bytes());
            false
        }
    }
}

fn opened(machine: &str) -> Result<Playground, Error> {
    let Some(typical) = TYPICAL.iter().find(|typical| typical.name == machine) else {
        let is_file = machine.ends_with(".toml");
        return Playground::open(machine, (!is_file).then_some(USUAL));
    };
    let file = format!("/{machine}.toml");
    let written = text(&file, &typical.answers()?, Some(typical))?;
    std::fs::write(&file, written).map_err(|error| Error::Input(format!("{file}: {error}")))?;
    Playground::open(&file, None)
}

/// Reads the page's requests, advances the device for a moment, and sends the messages to the page.
#[unsafe(no_mangle)]
#[allow(unsafe_code, reason = "a name that the page calls, and no other item has it")]
pub extern "C" fn playground_pass() {
    OPEN.with_borrow_mut(|open| {
        let Some(playground) = open else { return };
        for line in stdin().lock().lines().map_while(Result::ok) {
            playground.ask(&line);
        }
        playground.pass();
        for news in playground.by_ref() {
            match news {
                StudioMessage::Event(text) => send(b't', text.as_bytes()),
                StudioMessage::Samples(frame) => send(b'b', &frame),
            }
        }
    });
}

/// Sends a message to the page.
fn send(kind: u8, bytes: &[u8]) {
    let mut out = stdout().lock();
    let length = (bytes.len() as u32).to_le_bytes();
    let _ = out.write_all(&[kind]).and_then(|()| out.write_all(&length));
    let _ = out.write_all(bytes).and_then(|()| out.flush());
}
