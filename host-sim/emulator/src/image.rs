//! Reads a flash image, and checks its chip and the version of its core.
//!
//! The firmware carries an ELF note, section `.note.stiction`: name `stiction`, type 1, and as its
//! description four texts that end in a zero byte each: version of the core, commit, chip, number
//! of encoders.

use std::fs;
use std::path::{Path, PathBuf};

use defmt_decoder::{Encoding, Table};
use object::{Architecture, Object, ObjectSection, ObjectSymbol};

use super::last_tick;
use files::error::Error;
use simulator::experiment::RunPlan;

/// Microcontroller of the board.
const CHIP: &str = "STM32F405";
/// Version of the core with which this program was built.
const VERSION: &str = env!("CARGO_PKG_VERSION");
const SECTION: &str = ".note.stiction";
const NOTE_NAME: &[u8] = b"stiction\0";
const NOTE_TYPE: u32 = 1;
/// Symbol of the log's buffers in a firmware with defmt-rtt.
const RTT_SYMBOL: &str = "_SEGGER_RTT";

/// Path of the image that `cargo xtask firmware` builds for one encoder.
pub const DEFAULT_IMAGE: &str = "target/firmware/stiction-firmware.elf";
/// Path of the image that it builds for an encoder on the motor and one on the load.
pub const TWO_ENCODERS_IMAGE: &str = "target/firmware/stiction-two-encoders.elf";

/// Advice on how to build an image, for every message about an invalid one.
const BUILD: &str = "build it with `cargo xtask firmware`";

/// Flash image that has been checked and can be run.
#[derive(Debug)]
pub struct FirmwareImage {
    /// Path of its file.
    pub path: PathBuf,
    /// The whole ELF file.
    pub elf: Vec<u8>,
    /// Note in the image.
    pub note: ImageNote,
    /// The log's format strings.
    pub formats: Table,
    /// Address of the log's buffers.
    pub rtt: u64,
    /// Address of the last tick that the image has computed.
    pub last_tick: u64,
}

/// Note in an image: version of the core, commit, chip, and encoders.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ImageNote {
    /// Version of the core.
    pub version: String,
    /// Commit that it was built from.
    pub commit: String,
    /// Chip that it was built for.
    pub chip: String,
    /// Number of encoders that it reads: 1 or 2.
    pub encoders: u8,
}

impl FirmwareImage {
    /// Reads the file at `path`, or else the image that `cargo xtask firmware` builds for as many
    /// encoders as the loop of a plan has.
    ///
    /// # Errors
    /// As [`open`](Self::open) and [`fits`](Self::fits).
    pub fn for_plan(path: Option<&Path>, plan: &RunPlan) -> Result<Self, Error> {
        let built = if plan.has_two_encoders() { TWO_ENCODERS_IMAGE } else { DEFAULT_IMAGE };
        let image = Self::open(path.unwrap_or(Path::new(built)))?;
        image.fits(plan)?;
        Ok(image)
    }

    /// Rejects a plan whose loop has an encoder that the image does not read.
    ///
    /// # Errors
    /// Returns an error with the image for two encoders.
    pub fn fits(&self, plan: &RunPlan) -> Result<(), Error> {
        if self.note.encoders > 1 || !plan.has_two_encoders() {
            return Ok(());
        }
        Err(refuse(
            &self.path,
            &format!(
                "it reads one encoder, and the file has a `[load_encoder]`; use \
                 {TWO_ENCODERS_IMAGE}, which `cargo xtask firmware` builds as well, or set \
                 `loop.position` to \"motor\""
            ),
        ))
    }

    /// Reads a file, and rejects an image that cannot run on the board.
    ///
    /// # Errors
    /// Returns why the file is not a valid image, and how to build one.
    pub fn open(path: &Path) -> Result<Self, Error> {
        let elf = fs::read(path).map_err(|source| {
            let why = if source.kind() == std::io::ErrorKind::NotFound {
                format!("there is no such file; {BUILD}, or name another with --image")
            } else {
                source.to_string()
            };
            refuse(path, &why)
        })?;
        Self::parse(path, elf)
    }

    /// Parses an image from the bytes of its file.
    ///
    /// # Errors
    /// As [`open`](Self::open).
    pub fn parse(path: &Path, elf: Vec<u8>) -> Result<Self, Error> {
        let no = |why: String| refuse(path, &why);
        let file = object::File::parse(&*elf)
            .map_err(|_| no(format!("it is not an ELF file; {BUILD}")))?;
        if file.architecture() != Architecture::Arm || file.is_64() || !file.is_little_endian() {
            let found = file.architecture();
            return Err(no(format!(
                "it is built for {found:?}, not for the Cortex-M4 of an {CHIP}; {BUILD}"
            )));
        }
        let section = file.section_by_name(SECTION).and_then(|section| section.data().ok());
        let note = section.and_then(ImageNote::parse).ok_or_else(|| {
            no(format!(
                "it has no note of this project (section {SECTION}), so it is another program; \
                 {BUILD}"
            ))
        })?;
        if note.chip != CHIP {
            return Err(no(format!(
                "it is built for an {}, but the board has an {CHIP}; {BUILD}",
                note.chip
            )));
        }
        if note.version != VERSION {
            let ImageNote { version, commit, .. } = &note;
            return Err(no(format!(
                "it holds version {version} of the core (commit {commit}), and this program \
                 version \
                 {VERSION}; {BUILD} from the same sources"
            )));
        }
        let rtt = file
            .symbols()
            .find(|symbol| symbol.name() == Ok(RTT_SYMBOL))
            .map(|symbol| symbol.address())
            .ok_or_else(|| {
                no(format!("it has no symbol {RTT_SYMBOL}, so its log cannot be read; {BUILD}"))
            })?;
        let symbol = file.symbols().find(|symbol| symbol.name() == Ok(last_tick::SYMBOL));
        let last_tick = match symbol.map(|symbol| (symbol.address(), symbol.size() as usize)) {
            Some((address, last_tick::PUBLISHED)) => address,
            _ => {
                let symbol = last_tick::SYMBOL;
                return Err(no(format!(
                    "it does not keep its last tick (symbol {symbol}) as this program knows it; \
                     {BUILD} from the same sources"
                )));
            }
        };
        let formats = Table::parse(&elf)
            .map_err(|why| no(format!("its log cannot be decoded: {why}")))?
            .ok_or_else(|| {
                no(format!("it has no section .defmt, so its log cannot be decoded; {BUILD}"))
            })?;
        if formats.encoding() != Encoding::Rzcobs {
            return Err(no(format!("its log is in another encoding than rzcobs; {BUILD}")));
        }
        Ok(Self { path: path.into(), note, formats, rtt, last_tick, elf })
    }

    /// Returns address and size of each part of a variable, which the compiler may have split.
    /// `name` is a piece of its mangled name.
    pub fn variable(&self, name: &str) -> Vec<(u64, u64)> {
        self.symbols(name, object::SymbolKind::Data)
    }

    /// Returns the addresses of the functions whose mangled names contain `name`.
    pub fn functions(&self, name: &str) -> Vec<u64> {
        self.symbols(name, object::SymbolKind::Text)
            .into_iter()
            .map(|(address, _)| address & !1)
            .collect()
    }

    fn symbols(&self, name: &str, kind: object::SymbolKind) -> Vec<(u64, u64)> {
        let Ok(file) = object::File::parse(&*self.elf) else { return Vec::new() };
        file.symbols()
            .filter(|symbol| {
                symbol.kind() == kind && symbol.name().is_ok_and(|found| found.contains(name))
            })
            .map(|symbol| (symbol.address(), symbol.size()))
            .collect()
    }

    /// Returns the name of the function that contains an address, for messages.
    pub fn function_at(&self, address: u64) -> Option<String> {
        let file = object::File::parse(&*self.elf).ok()?;
        let function = file.symbols().find(|symbol| {
            // The lowest bit of a function's address marks Thumb code.
            let start = symbol.address() & !1;
            symbol.kind() == object::SymbolKind::Text
                && (start..start + symbol.size()).contains(&address)
        })?;
        Some(function.name().ok()?.to_owned())
    }
}

impl ImageNote {
    fn parse(section: &[u8]) -> Option<Self> {
        let word = |at: usize| {
            let bytes = section.get(at..at + 4)?;
            Some(u32::from_le_bytes(bytes.try_into().ok()?))
        };
        let (name_size, size, kind) = (word(0)? as usize, word(4)? as usize, word(8)?);
        let name = section.get(12..12usize.checked_add(name_size)?)?;
        if name != NOTE_NAME || kind != NOTE_TYPE {
            return None;
        }
        let from = 12 + name_size.next_multiple_of(4);
        let description = section.get(from..from.checked_add(size)?)?;
        let mut texts = description
            .split(|byte| *byte == 0)
            .map(|text| String::from_utf8_lossy(text).trim().to_owned());
        let (version, commit, chip) = (texts.next()?, texts.next()?, texts.next()?);
        let encoders = match texts.next().as_deref() {
            // An image from before the fourth text reads one.
            None | Some("" | "1") => 1,
            Some("2") => 2,
            Some(_) => return None,
        };
        Some(Self { version, commit, chip, encoders })
    }
}

fn refuse(path: &Path, why: &str) -> Error {
    Error::Emulator(format!("{} cannot be run: {why}", path.display()))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn note(name: &[u8], kind: u32, texts: &str) -> Vec<u8> {
        let mut bytes = Vec::new();
        for word in [name.len() as u32, texts.len() as u32, kind] {
            bytes.extend(word.to_le_bytes());
        }
        bytes.extend(name);
        bytes.resize(bytes.len().next_multiple_of(4), 0);
        bytes.extend(texts.as_bytes());
        bytes
    }

    #[test]
    fn a_note_says_version_commit_chip_and_encoders() {
        for (end, encoders) in
            [("2\0\0\0", Some(2)), ("1\0", Some(1)), ("\0", Some(1)), ("3\0", None)]
        {
            let texts = format!("0.1.0\0abc1234\0STM32F405\0{end}");
            let found = ImageNote::parse(&note(b"stiction\0", 1, &texts));
            let expected = encoders.map(|encoders| ImageNote {
                version: "0.1.0".into(),
                commit: "abc1234".into(),
                chip: "STM32F405".into(),
                encoders,
            });
            assert_eq!(found, expected, "{end:?}");
        }
    }

    #[test]
    fn another_note_and_a_cut_note_are_none() {
        assert_eq!(ImageNote::parse(&note(b"GNU\0", 1, "0.1.0\0abc\0STM32F405")), None);
        assert_eq!(ImageNote::parse(&note(b"stiction\0", 2, "0.1.0\0abc\0STM32F405")), None);
        let whole = note(b"stiction\0", 1, "0.1.0\0abc1234\0STM32F405");
        for length in 0..whole.len() {
            assert_eq!(ImageNote::parse(&whole[..length]), None, "{length} bytes");
        }
        let huge = [0xFF; 64];
        assert_eq!(ImageNote::parse(&huge), None);
    }

    #[test]
    fn what_is_no_image_is_refused_with_the_command_that_builds_one() {
        let missing = FirmwareImage::open(Path::new("no/such/file")).unwrap_err().to_string();
        assert!(
            missing.contains("no/such/file") && missing.contains("cargo xtask firmware"),
            "{missing}"
        );
        let text =
            FirmwareImage::parse(Path::new("a.txt"), b"hello".to_vec()).unwrap_err().to_string();
        assert!(text.contains("not an ELF"), "{text}");
        let own = std::env::current_exe().unwrap();
        let host = FirmwareImage::open(&own).unwrap_err().to_string();
        assert!(host.contains("not for the Cortex-M4") || host.contains("not an ELF"), "{host}");
    }
}
