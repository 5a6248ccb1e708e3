//! Keys of the view. Stop, hold and quit always work. A typed position takes effect at Enter. A
//! key that is not part of a number is shown as typed, and Enter refuses the text.

use ratatui::crossterm::event::{KeyCode, KeyEvent, KeyModifiers};

use super::model::WatchedDevice;
use files::error::Error;
use files::typed_number;
use simulator::device::client::Client;
use simulator::device::wire::Wire;

/// Longest text of a typed position, characters.
const LONGEST_ENTRY: usize = 32;

/// The text of the last line, which names the keys.
pub const KEYS: &str = "q quit  s stop  a arm  h hold  c clear fault  NUMBER Enter move to, deg";

/// Whether the view goes on after a key.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum WatchFlow {
    /// The view goes on.
    Go,
    /// The view ends.
    Quit,
}

/// Executes the command of a key. If the device refuses, the note shows the refusal.
///
/// # Errors
/// Returns an error if the device does not answer.
pub fn press<W: Wire>(
    key: KeyEvent,
    watched: &mut WatchedDevice,
    client: &mut Client<W>,
) -> Result<WatchFlow, Error> {
    let control = key.modifiers.contains(KeyModifiers::CONTROL);
    let plain = !key.modifiers.intersects(KeyModifiers::CONTROL | KeyModifiers::ALT);
    let done = match key.code {
        KeyCode::Char('c' | 'd') if control => return Ok(WatchFlow::Quit),
        // The stop key works with any modifier.
        KeyCode::Char('s' | 'S' | ' ') => {
            client.stop().map(|()| "stopped: the motor is off".to_owned())
        }
        // A terminal, a multiplexer or a typing error can send these keys: Ctrl-A must not arm.
        KeyCode::Char(_) if !plain => return Ok(WatchFlow::Go),
        KeyCode::Char('q') => return Ok(WatchFlow::Quit),
        KeyCode::Char('h') => client.hold().map(|()| "stops here, and is held".to_owned()),
        // A key that is dropped inside a number would change the number: `4,5` would become 45.
        KeyCode::Char(c) if begins_a_number(c) || !watched.entry.is_empty() => {
            watched.entry.push(c);
            if watched.entry.chars().count() > LONGEST_ENTRY {
                watched.entry.clear();
                watched.note = format!("longer than {LONGEST_ENTRY} characters: discarded");
            }
            return Ok(WatchFlow::Go);
        }
        KeyCode::Char('a') => arm(watched, client),
        KeyCode::Char('c') => client.clear().map(|()| "cleared: `a` arms again".to_owned()),
        KeyCode::Backspace => {
            watched.entry.pop();
            return Ok(WatchFlow::Go);
        }
        KeyCode::Enter if !watched.entry.is_empty() => go(watched, client),
        KeyCode::Esc => Ok(String::new()),
        _ => return Ok(WatchFlow::Go),
    };
    watched.entry.clear();
    watched.note = match done {
        Ok(note) => note,
        Err(error @ (Error::Refused(_) | Error::Input(_))) => error.to_string(),
        Err(error) => return Err(error),
    };
    watched.status = client.status()?;
    Ok(WatchFlow::Go)
}

/// Returns whether a character starts a typed position. Each later character is added to it, except
/// the keys that always work.
const fn begins_a_number(c: char) -> bool {
    matches!(c, '0'..='9' | '.' | ',' | '-' | '+' | '\u{2212}')
}

fn arm<W: Wire>(watched: &mut WatchedDevice, client: &mut Client<W>) -> Result<String, Error> {
    let (before, armed_here) = (watched.is_armed(), watched.armed_here);
    // Set before the answer: if the answer is lost, the drive may be armed.
    watched.armed_here |= !before;
    let answer = client.arm();
    if matches!(answer, Err(Error::Refused(_))) {
        watched.armed_here = armed_here;
    }
    answer?;
    Ok(if before {
        "it is armed already"
    } else {
        "armed: the motor is driven, and this position is 0 deg"
    }
    .into())
}

/// Moves to the typed position, which counts from the zero of the arming. Without that zero there
/// is no target.
fn go<W: Wire>(watched: &mut WatchedDevice, client: &mut Client<W>) -> Result<String, Error> {
    let deg = typed_number::parse(&watched.entry)
        .map_err(|why| Error::Input(format!("no move: {why}")))?;
    // Another program may have set other limits meanwhile.
    watched.configure(&client.parameters()?);
    watched.follow(client.status()?);
    watched.check(deg)?;
    client.move_to(deg)?;
    watched.show(client.longest_s(deg - watched.now().reference_deg)?);
    Ok(format!("to {deg} deg"))
}
