//! Requests that read, write, change and save the parameters of the device.

use stiction::Parameters;
use stiction::link::{CHUNK, Reply, Request};
use stiction::parameters::{ROOM, record};
use stiction::units::value::Key;

use super::Client;
use crate::device::wire::Wire;
use crate::error::Error;

impl<W: Wire> Client<W> {
    /// Reads the parameters in use.
    ///
    /// # Errors
    /// Says that the device has none.
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

    /// Sends other parameters. The device validates all of them before it takes any, and forgets
    /// them at a reset unless they are [saved](Self::save).
    ///
    /// # Errors
    /// Says why the device refuses; the old parameters stay in use then.
    pub fn set_parameters(&mut self, parameters: &Parameters) -> Result<(), Error> {
        let mut room = [0; ROOM];
        let record = parameters.encode(0, &mut room).unwrap_or_default();
        for (i, piece) in record.chunks(CHUNK).enumerate() {
            let (offset, bytes) = ((i * CHUNK) as u16, piece.iter().copied().collect());
            self.done("params push", Request::WriteParameters { offset, bytes })?;
        }
        self.done("params push", Request::TakeParameters { length: record.len() as u16 })
    }

    /// Changes some of the parameters by their numbers. The device validates the result as a whole.
    ///
    /// # Errors
    /// Says why the device refuses; no value is taken then.
    pub fn change(&mut self, values: &[(Key, u32)]) -> Result<(), Error> {
        let (mut room, mut length) = ([0; CHUNK], 0);
        // Which laws there are comes before their gains, as in a record.
        let mut values = values.to_vec();
        values.sort_unstable_by_key(|(key, _)| *key);
        for (key, bits) in values {
            let put = record::put(&mut room, &mut length, key, bits);
            put.ok_or_else(|| Error::Input("params: too many values for one change".into()))?;
        }
        let entries = room.iter().copied().take(length).collect();
        self.done("params", Request::Change { entries })
    }

    /// Saves the parameters in use, so that they outlast a reset. A board takes seconds for that.
    ///
    /// # Errors
    /// Says that the device is armed, or that its flash fails.
    pub fn save(&mut self) -> Result<(), Error> {
        self.done("params save", Request::Save)
    }

    /// Turns the part's brown-out reset on, at its highest level. The part keeps that for good, and
    /// goes by it after its next reset. It stands still for up to seconds meanwhile.
    ///
    /// # Errors
    /// Says that the device is armed, has no brown-out reset, or may not change it.
    pub fn set_brown_out(&mut self) -> Result<(), Error> {
        self.done("set-brown-out", Request::SetBrownOut)
    }
}
