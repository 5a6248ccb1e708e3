//! The memory across a reset: the last fault, whether the motor was being driven, whether the
//! encoder is in doubt, and the motor's heat.
//!
//! The memory is in RAM that is neither zeroed nor initialised (`NOINIT` of memory.x). After
//! power-on its contents are noise, which the check words distinguish from a record.

use core::cell::UnsafeCell;
use core::mem::MaybeUninit;
use core::ptr;

use stiction::Fault;
use stiction::safety::fault::LatchedFault;

/// Bytes for the end of a source file's name.
const TEXT: usize = 40;
const MAGIC: u32 = 0x5354_4943;
const ARMED: u32 = 0xA12E_D0DE;
const IN_DOUBT: u32 = 0xD00B_7ED1;

/// Largest full scale of a drive, V, and so the largest effort.
const MOST_V: f32 = 1e6;

/// A fault that is kept across a reset, and where it was.
#[derive(Clone, Copy)]
#[repr(C)]
pub struct RetainedFault {
    magic: u32,
    fault: u32,
    /// A panic's line, a hard fault's program counter, or the tick of any other fault.
    pub place: u32,
    /// A hard fault's status register, or the bits of the value that tripped any other fault.
    pub status: u32,
    length: u32,
    text: [u8; TEXT],
    check: u32,
}

#[repr(C)]
struct Memory {
    fault: RetainedFault,
    armed: [u32; 2],
    encoder: [u32; 2],
    /// Bits of the steady effort that would cause the motor's heat, and their complement.
    heat: [u32; 2],
}

/// Contents of the memory before a reset.
pub struct Retained {
    /// The last fault.
    pub fault: Option<RetainedFault>,
    /// Whether the motor was driven.
    pub was_armed: bool,
    /// Whether the encoder is in doubt.
    pub is_encoder_in_doubt: bool,
    /// Heat of the motor, as the steady effort that would cause it, V.
    pub thermal_effort: f32,
}

struct Kept(UnsafeCell<MaybeUninit<Memory>>);

// SAFETY: one core; written by the control task, and by handlers that never return to it.
unsafe impl Sync for Kept {}

#[unsafe(link_section = ".noinit.retained")]
static KEPT: Kept = Kept(UnsafeCell::new(MaybeUninit::uninit()));

impl RetainedFault {
    /// Makes the record of a fault without a place.
    pub const fn of(fault: Fault) -> Self {
        Self {
            magic: MAGIC,
            fault: fault as u32,
            place: 0,
            status: 0,
            length: 0,
            text: [0; TEXT],
            check: 0,
        }
    }

    /// Makes the record of a fault that the servo has latched.
    pub const fn latched(latched: &LatchedFault) -> Self {
        Self::of(latched.fault).at(latched.tick, latched.value.to_bits())
    }

    /// Returns the fault as the servo had latched it before the reset.
    pub fn as_latched(&self) -> Option<LatchedFault> {
        let fault = self.fault()?;
        Some(match fault {
            // These have a place in the program instead.
            Fault::Panic | Fault::HardFault => LatchedFault::from(fault),
            _ => LatchedFault { fault, tick: self.place, value: f32::from_bits(self.status) },
        })
    }

    /// Adds the end of a text: the end of a path identifies the file best.
    pub fn with_text(mut self, text: &str) -> Self {
        let bytes = text.as_bytes();
        let kept = bytes.get(bytes.len().saturating_sub(TEXT)..).unwrap_or(bytes);
        for (to, from) in self.text.iter_mut().zip(kept) {
            *to = *from;
        }
        self.length = kept.len() as u32;
        self
    }

    /// Adds a place in the program and a status.
    pub const fn at(mut self, place: u32, status: u32) -> Self {
        self.place = place;
        self.status = status;
        self
    }

    /// Returns the fault; none if its number is unknown.
    pub fn fault(&self) -> Option<Fault> {
        Fault::from_code(self.fault as u8)
    }

    /// Returns the text; empty if there is none.
    pub fn text(&self) -> &str {
        let kept = self.text.get(..self.length as usize).unwrap_or_default();
        core::str::from_utf8(kept).unwrap_or_default()
    }

    fn sum(&self) -> u32 {
        let words = [self.magic, self.fault, self.place, self.status, self.length];
        let texts = self.text.iter().map(|&byte| u32::from(byte));
        words.into_iter().chain(texts).fold(1, |sum, word| sum.rotate_left(5) ^ word)
    }
}

/// Keeps a record for the time after the next reset.
pub fn keep(mut record: RetainedFault) {
    record.check = record.sum();
    // SAFETY: within the static; see `Kept`.
    unsafe { ptr::write_volatile(&raw mut (*memory()).fault, record) };
}

/// Erases the record: there is nothing to report any more.
pub fn forget() {
    // SAFETY: within the static; see `Kept`.
    unsafe { ptr::write_volatile(&raw mut (*memory()).fault.magic, 0) };
}

/// Remembers whether the motor is driven.
pub fn set_armed(armed: bool) {
    // SAFETY: within the static; see `Kept`.
    unsafe { ptr::write_volatile(&raw mut (*memory()).armed, flag(armed, ARMED)) };
}

/// Remembers whether the encoder is in doubt.
pub fn set_encoder_in_doubt(in_doubt: bool) {
    // SAFETY: within the static; see `Kept`.
    unsafe { ptr::write_volatile(&raw mut (*memory()).encoder, flag(in_doubt, IN_DOUBT)) };
}

/// Remembers the heat of the motor, as the steady effort that would cause it, V.
pub fn set_thermal_effort(effort: f32) {
    let bits = effort.to_bits();
    // SAFETY: within the static; see `Kept`.
    unsafe { ptr::write_volatile(&raw mut (*memory()).heat, [bits, !bits]) };
}

/// Returns the effort that was kept, V; zero after power-on, or if the words are no valid effort.
fn effort([bits, check]: [u32; 2]) -> f32 {
    let effort = f32::from_bits(bits);
    let is_one = check == !bits && (0.0..=MOST_V).contains(&effort);
    if is_one { effort } else { 0.0 }
}

/// Returns the two words that store a flag: `word` (0 if the flag is not set), and its complement.
/// Random bits after power-on are then not read as a set flag.
const fn flag(is_set: bool, word: u32) -> [u32; 2] {
    let word = if is_set { word } else { 0 };
    [word, !word]
}

/// Returns the contents of the memory before this reset, and clears the fault and the flag of a
/// driven motor.
pub fn take() -> Retained {
    // SAFETY: within the static; any bits are a value of these types.
    let Memory { fault: record, armed, encoder, heat } = unsafe { ptr::read_volatile(memory()) };
    let known = record.magic == MAGIC && record.check == record.sum() && record.fault().is_some();
    keep(RetainedFault { magic: 0, ..RetainedFault::of(Fault::Panic) });
    set_armed(false);
    Retained {
        fault: known.then_some(record),
        was_armed: armed == flag(true, ARMED),
        is_encoder_in_doubt: encoder == flag(true, IN_DOUBT),
        thermal_effort: effort(heat),
    }
}

const fn memory() -> *mut Memory {
    KEPT.0.get().cast()
}
