//! `stiction device ... watch` shows a device live in a terminal.

mod keys;
mod model;
#[cfg(test)]
mod tests;
mod view;

use std::io::{IsTerminal, stdin, stdout};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use ratatui::crossterm::event::{self, Event, KeyEventKind};
use stiction::link::{StateCode, Status};

use super::PERHAPS_ARMED;
use files::error::Error;
use keys::WatchFlow;
use model::{WINDOW_S, WatchedDevice, subscribed};
use simulator::device::client::Client;
use simulator::device::signals::Signals;
use simulator::device::wire::Wire;
use simulator::device::words;

/// Number of samples in a plot: two for every dot of a wide terminal.
const SAMPLES: f64 = 500.0;

/// Time between two drawings of the view.
const DRAWN: Duration = Duration::from_millis(50);

/// Time between two requests for the status: a fifth of the default link timeout. Each request is a
/// keep-alive as well.
const ASKED: Duration = Duration::from_millis(100);

/// Longest wait for a key.
const SLICE: Duration = Duration::from_millis(20);

/// Refuses an output that cannot show the view, before the device receives anything.
///
/// # Errors
/// Returns an error if input or output is not a terminal.
pub fn on_a_terminal() -> Result<(), Error> {
    if stdin().is_terminal() && stdout().is_terminal() {
        return Ok(());
    }
    Err(Error::Input(
        "device watch needs a terminal; without one, use `device status` or `device log FILE.csv`"
            .into(),
    ))
}

/// Shows the device until `q` or a signal that ends programs, and returns a text on its last state.
///
/// # Errors
/// Returns an error if the device no longer answers or the terminal fails. A drive that was armed
/// here is stopped before, if the device can be reached.
pub fn watch<W: Wire>(client: &mut Client<W>) -> Result<String, Error> {
    client.wire().real_time();
    let ending = endings()?;
    let status = client.status()?;
    let version =
        client.identity().map_or(String::new(), |identity| identity.version.as_str().into());
    let name = format!("{}, firmware {version}", client.wire().name());
    let signals = Signals::new(client.signals()?);
    let mask = signals.mask(subscribed());
    let mut watched = WatchedDevice::new(client.warning(), name, signals, status);
    // A device without parameters cannot be armed, and has no travel.
    if let Ok(parameters) = client.parameters() {
        watched.configure(&parameters);
    }
    let seen = client.subscribe(mask, every(&status));
    let seen = seen.and_then(|()| on_screen(client, &mut watched, &ending));
    match (seen, leave(client, &watched)) {
        (Ok(()), left) => {
            let left = left?;
            Ok(words::status(&client.status()?) + left + "\n")
        }
        // The first error is the cause.
        (Err(error), Ok(left)) => Err(Error::Device(format!("{error}; {left}"))),
        (Err(error), Err(_)) => Err(unheard(&error, &watched)),
    }
}

/// Returns a flag that SIGTERM, SIGHUP and SIGINT set. Without the flag, these signals would end
/// the program, and leave the terminal unrestored and the drive armed.
fn endings() -> Result<Arc<AtomicBool>, Error> {
    let ending = Arc::new(AtomicBool::new(false));
    #[cfg(unix)]
    for signal in
        [signal_hook::consts::SIGTERM, signal_hook::consts::SIGHUP, signal_hook::consts::SIGINT]
    {
        signal_hook::flag::register(signal, ending.clone())?;
    }
    Ok(ending)
}

fn every(status: &Status) -> u16 {
    let sample_time_s = f64::from(status.sample_time);
    if sample_time_s > 0.0 {
        (WINDOW_S / sample_time_s / SAMPLES).clamp(1.0, 1000.0) as u16
    } else {
        1
    }
}

/// Screen of the terminal. The terminal is restored when this is dropped; after a panic, a hook
/// restores it.
struct Screen(ratatui::DefaultTerminal);

impl Drop for Screen {
    fn drop(&mut self) {
        ratatui::restore();
    }
}

fn on_screen<W: Wire>(
    client: &mut Client<W>,
    watched: &mut WatchedDevice,
    ending: &AtomicBool,
) -> Result<(), Error> {
    let mut screen = Screen(ratatui::try_init()?);
    let (mut drawn, mut asked) = (None, Instant::now());
    while !ending.load(Ordering::Relaxed) {
        while let Some(sample) = client.sample(Duration::ZERO)? {
            watched.take(&sample);
        }
        watched.lost = client.lost();
        if asked.elapsed() >= ASKED {
            asked = Instant::now();
            watched.follow(client.status()?);
        }
        if drawn.is_none_or(|drawn: Instant| drawn.elapsed() >= DRAWN) {
            screen.0.draw(|frame| view::draw(frame, watched))?;
            drawn = Some(Instant::now());
        }
        if event::poll(Duration::ZERO)? {
            if let Event::Key(key) = event::read()?
                && key.kind != KeyEventKind::Release
                && keys::press(key, watched, client)? == WatchFlow::Quit
            {
                return Ok(());
            }
            drawn = None;
        } else if let Some(sample) = client.sample(SLICE)? {
            watched.take(&sample);
        }
    }
    Ok(())
}

/// Turns off a drive that was armed here, and returns a sentence on its state.
fn leave<W: Wire>(client: &mut Client<W>, watched: &WatchedDevice) -> Result<&'static str, Error> {
    if watched.armed_here {
        client.stop().map_err(|error| unheard(&error, watched))?;
    }
    // The view needs no more samples. If this fails, it does no harm.
    let _ = client.subscribe(0, 0);
    let left = client.status().map_err(|error| unheard(&error, watched))?;
    Ok(match left.state {
        StateCode::Armed => {
            "THE MOTOR IS STILL DRIVEN: it was driven before you watched; `stop` turns it off"
        }
        StateCode::Faulted(_) => "left faulted: the motor is off",
        StateCode::Stopped | StateCode::Boot => "left stopped: the motor is off",
    })
}

/// Returns the error for a device that cannot be reached, with a warning if the drive may be armed.
fn unheard(error: &Error, watched: &WatchedDevice) -> Error {
    let armed = watched.armed_here || watched.is_armed();
    Error::Device(if armed { format!("{error}; {PERHAPS_ARMED}") } else { error.to_string() })
}
