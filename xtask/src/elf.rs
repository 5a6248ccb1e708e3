//! Reads the contents of the flash from an ELF file: the bytes that a programmer without ELF
//! support writes at its start.

/// The type of a segment that is loaded, `PT_LOAD` of the ELF specification.
const LOAD: u32 = 1;

/// The address at which the flash begins.
const FLASH: u32 = 0x0800_0000;

/// Largest gap that is filled, bytes: an image within the flash has none larger.
const FLASH_SIZE: u32 = 1 << 20;

/// Joins the loaded segments of a 32-bit little-endian ELF from the start of the flash on, and
/// fills gaps with 0xFF.
pub fn flash_contents(elf: &[u8]) -> Result<Vec<u8>, String> {
    let half =
        |at: usize| elf.get(at..at + 2).map(|b| usize::from(u16::from_le_bytes([b[0], b[1]])));
    let word =
        |at: usize| elf.get(at..at + 4).map(|b| u32::from_le_bytes([b[0], b[1], b[2], b[3]]));
    let short = || "the image is not a whole 32-bit ELF file".to_owned();
    if !elf.starts_with(b"\x7fELF\x01\x01") {
        return Err(short());
    }
    let table = word(28).ok_or_else(short)? as usize;
    let (size, count) = (half(42).ok_or_else(short)?, half(44).ok_or_else(short)?);
    let mut flash = Vec::new();
    for i in 0..count {
        let header = table + i * size;
        let field = |at: usize| word(header + at).ok_or_else(short);
        let (kind, from, address, length) =
            (field(0)?, field(4)? as usize, field(12)?, field(16)? as usize);
        if kind != LOAD || length == 0 {
            continue;
        }
        let at = address.checked_sub(FLASH).filter(|at| *at < FLASH_SIZE);
        let at = at
            .ok_or_else(|| format!("the image loads to {address:#x}, outside of the flash"))?
            as usize;
        let bytes = elf.get(from..from + length).ok_or_else(short)?;
        if flash.len() < at + length {
            flash.resize(at + length, 0xFF);
        }
        flash[at..at + length].copy_from_slice(bytes);
    }
    Ok(flash)
}
