//! Requests that read, write, change and save the parameters of the device.

use stiction::Parameters;
use stiction::link::{CHUNK, Reply, Request};
use stiction::parameters::{ROOM, record};
use stiction::units::value::Key;

use super::Client;
use crate::device::wire::Wire;
use files::error::Error;

impl<W: Wire> Client<W> {
    /// Reads the parameters in use.
    ///
    /// # Errors
    /// Returns an error if the device has none.
    pub fn parameters(&mut self) -> Result<Parameters, Error> {
        let mut record: Vec<u8> = Vec::new();
        loop {
            let offset = record.len() as u16;
            let Reply::Parameters { length, offset: at, bytes } =
                self.ask(Request::ReadParameters { offset })?
            else {
                return Err(self.unexpected());
            };
            if at != offset || bytes.is_empty() {
                return Err(self.unexpected());
            }
            record.extend_from_slice(&bytes);
            if record.len() >= usize::from(length) {
                break;
            }
        }
        let decoded = Parameters::decode(&record);
        decoded.map(|(parameters, _)| parameters).map_err(|_| self.unexpected())
    }

    /// Sends parameters. The device validates all of them before it uses any. A reset restores the
    /// saved ones, unless these are [saved](Self::save).
    ///
    /// # Errors
    /// Returns why the device refuses; the old parameters stay in use.
    pub fn set_parameters(&mut self, parameters: &Parameters) -> Result<(), Error> {
        let mut room = [0; ROOM];
        let record = parameters.encode(0, &mut room).unwrap_or_default();
        for (i, piece) in record.chunks(CHUNK).enumerate() {
            let (offset, bytes) = ((i * CHUNK) as u16, piece.iter().copied().collect());
            self.done("params push", Request::WriteParameters { offset, bytes })?;
        }
        self.done("params push", Request::TakeParameters { length: record.len() as u16 })
    }

    /// Changes some parameters, each given as its key and the bits of its value. The device
    /// validates the whole result.
    ///
    /// # Errors
    /// Returns why the device refuses; no value is changed then.
    pub fn change(&mut self, values: &[(Key, u32)]) -> Result<(), Error> {
        let (mut room, mut length) = ([0; CHUNK], 0);
        // The laws come before their gains, as in a record.
        let mut values = values.to_vec();
        values.sort_unstable_by_key(|(key, _)| *key);
        for (key, bits) in values {
            let put = record::put(&mut room, &mut length, key, bits);
            put.ok_or_else(|| Error::Input("params: too many values for one change".into()))?;
        }
        let entries = room.iter().copied().take(length).collect();
        self.done("params", Request::Change { entries })
    }

    /// Saves the parameters in use to flash. A board takes seconds for that.
    ///
    /// # Errors
    /// Returns an error if the device is armed or its flash fails.
    pub fn save(&mut self) -> Result<(), Error> {
        self.done("params save", Request::Save)
    }

    /// Turns the brown-out reset of the microcontroller on permanently, at its highest level. It
    /// takes effect at the next reset. The device does not run while it writes, up to seconds.
    ///
    /// # Errors
    /// Returns an error if the device is armed, has no brown-out reset, or cannot change it.
    pub fn set_brown_out(&mut self) -> Result<(), Error> {
        self.done("set-brown-out", Request::SetBrownOut)
    }
}
