//! Setup of a board: program, parameters in its flash, and components.

use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use rigless::image::Image;

use super::board::FittedParts;
use super::image::FirmwareImage;
use super::log::Listener;
use super::probe::Points;

/// Addresses of the parameters: sectors 10 and 11 of the flash.
const SECTORS_AT: [u64; 2] = [0x080C_0000, 0x080E_0000];
/// Address of read-only words of the manufacturer: unique identifier (12 bytes), and the flash's
/// size.
const FACTORY_AT: u64 = 0x1FFF_7A10;
/// Interval at which the log is read, ns. In this time the firmware logs less than the buffer's
/// 1 KiB.
const DRAIN_EVERY_NS: u64 = 5_000_000;

/// Partner at the other end of the command link: gets the time (ns) and what the board has sent
/// since the last call, and returns what is sent to the board.
pub type Partner = Box<dyn FnMut(u64, &[u8]) -> Vec<u8> + Send>;

/// A board without power, and its partner on the command link.
pub struct BoardSetup {
    /// Name of the run, for messages and its log.
    pub label: String,
    /// Program in the flash.
    pub image: Arc<FirmwareImage>,
    /// Contents of the two parameter sectors; one without contents is erased.
    pub records: [Option<Vec<u8>>; 2],
    /// Components on the board.
    pub fitted: FittedParts,
    /// Callback for each line of the log, as soon as it is read.
    pub listener: Option<Listener>,
    /// Functions whose instructions are counted.
    pub points: Option<Arc<Points>>,
    /// Partner at the other end of the command link, which is called every 50 us.
    pub partner: Option<Partner>,
    /// Interval at which the log is read, ns.
    pub drain_every_ns: u64,
    /// Whether the run ends if the firmware polls a register and does little else.
    pub is_guarded: bool,
    /// Flag that ends the run.
    pub interrupt: Arc<AtomicBool>,
}

impl BoardSetup {
    /// Sets up a whole board with an image, and with a record in the first sector.
    pub fn new(label: &str, image: &Arc<FirmwareImage>, record: Vec<u8>) -> Self {
        Self {
            label: label.into(),
            image: image.clone(),
            records: [Some(record), None],
            fitted: FittedParts::default(),
            listener: None,
            points: None,
            partner: None,
            drain_every_ns: DRAIN_EVERY_NS,
            is_guarded: true,
            interrupt: Arc::default(),
        }
    }

    /// Returns the contents of the flash at boot: the program, the two parameter sectors, and the
    /// words of the manufacturer.
    pub(super) fn flash(&self) -> Result<Vec<Image>, String> {
        let image = &self.image;
        let mut factory = b"stiction sim".to_vec();
        factory.resize(18, 0);
        // 1024 KiB.
        factory.extend(1024u16.to_le_bytes());
        let record = |(record, at): (&Option<Vec<u8>>, u64)| {
            record
                .as_ref()
                .map(|record| Image::new("parameters".as_ref(), record.clone(), Some(at)))
        };
        [
            Image::new(&image.path, image.elf.clone(), None),
            Image::new("identity".as_ref(), factory, Some(FACTORY_AT)),
        ]
        .into_iter()
        .chain(self.records.iter().zip(SECTORS_AT).filter_map(record))
        .collect::<Result<_, _>>()
        .map_err(|error| error.to_string())
    }
}
