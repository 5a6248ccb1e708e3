//! The keys of the view. The stop key always works; a position is typed and takes effect with Enter
//! only.

use ratatui::crossterm::event::{KeyCode, KeyEvent, KeyModifiers};

use super::model::Watched;
use crate::device::client::Client;
use crate::device::wire::Wire;
use crate::error::Error;

/// Most characters of a position that is typed, more than any that makes sense has.
const LONGEST_ENTRY: usize = 12;

/// The text of the last line, which names the keys.
pub const KEYS: &str = "q quit  s stop  a arm  h hold  c clear fault  NUMBER Enter move to, deg";

/// Whether the view goes on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Flow {
    /// The view goes on.
    Go,
    /// The view ends.
    Quit,
}

/// Does what a key asks for. What the device refuses is noted.
///
/// # Errors
/// Says that the device does not answer.
pub fn press<W: Wire>(
    key: KeyEvent,
    watched: &mut Watched,
    client: &mut Client<W>,
) -> Result<Flow, Error> {
    let control = key.modifiers.contains(KeyModifiers::CONTROL);
    let plain = !key.modifiers.intersects(KeyModifiers::CONTROL | KeyModifiers::ALT);
    let done = match key.code {
        KeyCode::Char('c' | 'd') if control => return Ok(Flow::Quit),
        // The stop key works however it is pressed.
        KeyCode::Char('s' | 'S' | ' ') => {
            client.stop().map(|()| "stopped: the motor is off".to_owned())
        }
        // A terminal, a multiplexer or a slip of the hand sends these: Ctrl-A is no arming.
        KeyCode::Char(_) if !plain => return Ok(Flow::Go),
        KeyCode::Char('q') => return Ok(Flow::Quit),
        KeyCode::Char('a') => arm(watched, client),
        KeyCode::Char('h') => client.hold().map(|()| "stops here, and is held".to_owned()),
        KeyCode::Char('c') => client.clear().map(|()| "cleared: `a` arms again".to_owned()),
        KeyCode::Char(c) if c.is_ascii_digit() || c == '.' || c == '-' => {
            if watched.entry.len() < LONGEST_ENTRY {
                watched.entry.push(c);
            }
            return Ok(Flow::Go);
        }
        KeyCode::Backspace => {
            watched.entry.pop();
            return Ok(Flow::Go);
        }
        KeyCode::Enter if !watched.entry.is_empty() => go(watched, client),
        KeyCode::Esc => Ok(String::new()),
        _ => return Ok(Flow::Go),
    };
    watched.entry.clear();
    watched.note = match done {
        Ok(note) => note,
        Err(error @ (Error::Refused(_) | Error::Input(_))) => error.to_string(),
        Err(error) => return Err(error),
    };
    watched.status = client.status()?;
    Ok(Flow::Go)
}

fn arm<W: Wire>(watched: &mut Watched, client: &mut Client<W>) -> Result<String, Error> {
    let (before, armed_here) = (watched.is_armed(), watched.armed_here);
    // This is noted before the answer: one that is lost does not disarm the drive.
    watched.armed_here |= !before;
    let answer = client.arm();
    if matches!(answer, Err(Error::Refused(_))) {
        watched.armed_here = armed_here;
    }
    answer?;
    Ok(if before { "it is armed already" } else { "armed: the motor is driven, and here is zero" }
        .into())
}

/// Moves to the typed position, which counts from the zero of the arming: without that zero there
/// is no place to move to.
fn go<W: Wire>(watched: &mut Watched, client: &mut Client<W>) -> Result<String, Error> {
    let deg: f64 = watched.entry.parse().map_err(|_| {
        Error::Input(format!("move {}: allowed is a number, as in -2.5", watched.entry))
    })?;
    client.move_to(deg)?;
    watched.show(client.longest_s(deg - watched.now().reference_deg)?);
    Ok(format!("to {deg} deg"))
}
