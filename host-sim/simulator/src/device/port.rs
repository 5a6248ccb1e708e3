//! The wire to a board on a serial port.

use std::io::{ErrorKind, Read, Write};
use std::path::Path;
use std::time::Duration;

use serialport::SerialPort;

use super::wire::Wire;
use files::error::Error;

/// Bits per second of the link, 8N1. A byte takes ten bits, so a millisecond carries 92 bytes.
pub const BAUD: u32 = 921_600;

/// Timeout for sending a frame. A frame is on the wire within 3 ms; a port without room for it
/// after this time is blocked.
const TO_SEND: Duration = Duration::from_millis(200);

/// An open port.
pub struct SerialWire {
    port: Box<dyn SerialPort>,
    name: String,
}

impl std::fmt::Debug for SerialWire {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("SerialWire").field("name", &self.name).finish_non_exhaustive()
    }
}

impl SerialWire {
    /// Opens a port.
    ///
    /// # Errors
    /// Returns whether the port is missing, busy or forbidden, and which ports there are.
    pub fn open(path: &Path) -> Result<Self, Error> {
        let name = path.display().to_string();
        let opened = serialport::new(name.as_str(), BAUD).timeout(Duration::from_millis(1)).open();
        let port = opened.map_err(|error| Error::Device(refusal(&name, &error)))?;
        Ok(Self { port, name })
    }

    fn gone(&self, error: &std::io::Error) -> Error {
        let name = &self.name;
        Error::Device(format!(
            "--port {name}: the port is gone ({error}); an armed board turns the motor off after \
             `limits.link_timeout_s` (docs/reference/link.md)"
        ))
    }
}

fn refusal(name: &str, error: &serialport::Error) -> String {
    let why = match error.kind() {
        // On Unix the port is in use; other systems report a missing port as well.
        serialport::ErrorKind::NoDevice if cfg!(unix) => "another program has it open".into(),
        serialport::ErrorKind::NoDevice => {
            "there is no such port, or another program has it open".into()
        }
        serialport::ErrorKind::Io(ErrorKind::NotFound) => "there is no such port".into(),
        serialport::ErrorKind::Io(ErrorKind::PermissionDenied) => {
            "you have no permission to open it (on Linux: join the group of the port, often \
             dialout)"
                .into()
        }
        _ => format!("it cannot be used as a serial port: {}", error.description),
    };
    let found = serialport::available_ports().unwrap_or_default();
    let names: Vec<&str> = found.iter().map(|port| port.port_name.as_str()).collect();
    let others = if names.is_empty() { "none".into() } else { names.join(", ") };
    format!("--port {name}: {why}; available ports: {others} (docs/reference/link.md)")
}

impl Wire for SerialWire {
    fn send(&mut self, bytes: &[u8]) -> Result<(), Error> {
        // A flush would wait for the last bit, forever if the other end accepts none.
        let sent = self.port.set_timeout(TO_SEND).map_err(std::io::Error::from);
        sent.and_then(|()| self.port.write_all(bytes)).map_err(|error| self.gone(&error))
    }

    fn receive(&mut self, at_most: Duration) -> Result<Vec<u8>, Error> {
        let mut buffer = [0; 512];
        let timeout = at_most.max(Duration::from_millis(1));
        if let Err(error) = self.port.set_timeout(timeout) {
            return Err(self.gone(&error.into()));
        }
        match self.port.read(&mut buffer) {
            Ok(0) => Err(self.gone(&ErrorKind::UnexpectedEof.into())),
            Ok(count) => Ok(buffer.iter().take(count).copied().collect()),
            Err(error) if matches!(error.kind(), ErrorKind::TimedOut | ErrorKind::Interrupted) => {
                Ok(vec![])
            }
            Err(error) => Err(self.gone(&error)),
        }
    }

    fn name(&self) -> String {
        format!("the device on {}", self.name)
    }

    fn warning(&self) -> Option<&'static str> {
        None
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Tests that run as root can open every port, so this refusal is constructed.
    #[test]
    fn a_port_without_permission_is_reported_as_such() {
        let forbidden = serialport::ErrorKind::Io(ErrorKind::PermissionDenied);
        let said = refusal("/dev/ttyUSB0", &serialport::Error::new(forbidden, "Permission denied"));
        assert!(said.starts_with("--port /dev/ttyUSB0: you have no permission"), "{said}");
        assert!(said.contains("dialout") && said.ends_with("(docs/reference/link.md)"), "{said}");
    }
}
