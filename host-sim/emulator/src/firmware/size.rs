//! Memory used by an image.

use object::{Object, ObjectSection, ObjectSegment, SectionFlags};

/// Addresses from sector 0 to the end of the flash.
const FLASH: std::ops::Range<u64> = 0x0800_0000..0x0810_0000;
const SHF_ALLOC: u64 = 2;

/// Memory used by an image, bytes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Size {
    /// Machine code.
    pub code: u64,
    /// All that is programmed into the flash: code, constants, first values of variables.
    pub flash: u64,
    /// Variables.
    pub variables: u64,
}

impl Size {
    /// Returns the memory used by an ELF file; `None` if it is not a valid one.
    pub fn of(elf: &[u8]) -> Option<Self> {
        let file = object::File::parse(elf).ok()?;
        let is_loaded =
            |flags| matches!(flags, SectionFlags::Elf { sh_flags } if sh_flags & SHF_ALLOC != 0);
        let loaded = file.sections().filter(|section| is_loaded(section.flags()));
        let variables =
            loaded.filter(|section| !FLASH.contains(&section.address())).map(|s| s.size()).sum();
        let in_file = file.segments().map(|segment| segment.file_range().1).sum();
        Some(Self { code: file.section_by_name(".text")?.size(), flash: in_file, variables })
    }
}
