//! The reader of records in the formats 1 to 3, which had their values one after the other in
//! postcard, without numbers.
//!
//! ```text
//! sample time, resolution, counter bits, direction, window, Kp, Kd,
//! laws: how many, and of each which, and its gains; full scale, LSB, PWM mode, PWM top;
//! motion: which, and its values;
//! autostart, its delay, soft start, dead time, nominal supply, supply's full scale;
//! in format 3, the fifteen limits
//! ```
//!
//! The layout is history and does not follow the core any more: what is read is put under today's
//! numbers. Formats 1 and 2 knew no limits; their records get those that can be derived.

use serde::Deserialize;

use super::Parameters;
use super::record::DecodeError;
use crate::compensator::{FIRST_LAW, MAX_TERMS};
use crate::jog::JogBounds;
use crate::monitor::Limits;
use crate::profile::ProfileLimits;
use crate::value::{Key, Values};

/// The values at the head of every former record, in their order there.
const HEAD: [(Key, Type); 7] = [
    (Key(0x0101), Type::Number),
    (Key(0x0201), Type::Number),
    (Key(0x0202), Type::Whole),
    (Key(0x0203), Type::Whole),
    (Key(0x0102), Type::Whole),
    (Key(0x0401), Type::Number),
    (Key(0x0402), Type::Number),
];
/// The values of the device, in their order in every former record.
const DEVICE: [(Key, Type); 6] = [
    (Key(0x0801), Type::Flag),
    (Key(0x0802), Type::Number),
    (Key(0x0803), Type::Number),
    (Key(0x0804), Type::Number),
    (Key(0x0805), Type::Number),
    (Key(0x0806), Type::Number),
];

/// The number of the first limit; fourteen follow.
const FIRST_LIMIT: u16 = 0x0901;
const LIMITS: u16 = 15;

/// Clock of the timer that made the PWM, Hz. It was 168 MHz on every board of that time.
const PWM_CLOCK_HZ: f32 = 168e6;

/// The type in which a value was written.
#[derive(Clone, Copy)]
enum Type {
    Number,
    Whole,
    Flag,
}

/// A former record that is being read: the bytes that are left, and the parameters that they are
/// put into.
struct Former<'a> {
    body: &'a [u8],
    into: &'a mut Parameters,
}

/// Reads the body of a record in a former format.
#[inline(never)]
pub(super) fn read(
    body: &[u8],
    has_limits: bool,
    into: &mut Parameters,
) -> Result<(), DecodeError> {
    let mut former = Former { body, into };
    former.values(&HEAD)?;
    former.laws()?;
    for key in [Key(0x0301), Key(0x0302)] {
        former.value(key, Type::Number)?;
    }
    former.value(Key(0x0304), Type::Whole)?;
    let top: u16 = former.next()?;
    former.put(Key(0x0303), (PWM_CLOCK_HZ / (2.0 * f32::from(top))).to_bits())?;
    former.motion()?;
    former.values(&DEVICE)?;
    let mut breakaway = 0.0;
    if has_limits {
        for key in (FIRST_LIMIT..).take(LIMITS.into()).map(Key) {
            former.value(key, Type::Number)?;
        }
        let Parameters { controller, device, limits, .. } = &mut *former.into;
        breakaway = 0.5 * limits.stall_effort;
        let derived = Limits::derived(controller, device, breakaway);
        limits.breakaway_effort = derived.breakaway_effort;
        limits.stall_impulse = derived.stall_impulse;
        limits.stop_gain = derived.stop_gain;
        // Without Kd these were derived as zero, which is off, and was in no file.
        if controller.pd.kd == 0.0 {
            for (limit, derived) in [
                (&mut limits.overspeed, derived.overspeed),
                (&mut limits.encoder_jump, derived.encoder_jump),
            ] {
                if *limit == 0.0 {
                    *limit = derived;
                }
            }
        }
    } else {
        let limits = Limits::derived(&former.into.controller, &former.into.device, 0.0);
        former.into.limits = limits;
    }
    let Parameters { controller, device, limits, profile, jog, .. } = &mut *former.into;
    *profile = ProfileLimits::derived(controller, limits, 0.0);
    *jog = JogBounds::derived(controller, device, breakaway);
    if former.body.is_empty() { Ok(()) } else { Err(DecodeError::Malformed) }
}

impl<'a> Former<'a> {
    // Not copied to each of its callers: old records need no speed.
    #[inline(never)]
    fn next<T: Deserialize<'a>>(&mut self) -> Result<T, DecodeError> {
        let (value, rest) =
            postcard::take_from_bytes(self.body).map_err(|_| DecodeError::Malformed)?;
        self.body = rest;
        Ok(value)
    }

    fn put(&mut self, key: Key, bits: u32) -> Result<(), DecodeError> {
        match self.into.set(key, bits) {
            Ok(true) => Ok(()),
            _ => Err(DecodeError::Malformed),
        }
    }

    fn value(&mut self, key: Key, of: Type) -> Result<(), DecodeError> {
        let bits = match of {
            Type::Number => self.next::<f32>()?.to_bits(),
            Type::Whole => self.next::<u32>()?,
            Type::Flag => self.next::<bool>()?.into(),
        };
        self.put(key, bits)
    }

    fn values(&mut self, values: &[(Key, Type)]) -> Result<(), DecodeError> {
        values.iter().try_for_each(|&(key, of)| self.value(key, of))
    }

    /// Reads the laws. They were numbered from zero, in the order of today's numbers, and DNPF
    /// alone has one gain.
    fn laws(&mut self) -> Result<(), DecodeError> {
        let count = self.next::<u32>()?;
        if count > MAX_TERMS as u32 {
            return Err(DecodeError::Malformed);
        }
        for term in 0..count as u16 {
            let law = self.next::<u32>()?.checked_add(1).filter(|law| *law <= 6);
            let law = law.ok_or(DecodeError::Malformed)? as u16;
            self.put(Key(FIRST_LAW.0 + term), law.into())?;
            for gain in 1..=if law == 5 { 1 } else { 2 } {
                self.value(Key(0x1000 + 0x100 * law + gain), Type::Number)?;
            }
        }
        Ok(())
    }

    fn motion(&mut self) -> Result<(), DecodeError> {
        let kind = self.next::<u32>()?;
        self.put(Key(0x0600), kind)?;
        match kind {
            1 => {
                let (counts, fraction) = (self.next::<i32>()?, self.next::<f32>()?);
                self.put(Key(0x0601), counts as u32)?;
                self.put(Key(0x0602), fraction.to_bits())
            }
            2 => {
                let count = self.next::<u32>()?.min(crate::reference::MAX_CORNERS as u32 + 1);
                for first in (0x0700..).step_by(4).take(count as usize) {
                    let (tick, counts) = (self.next::<u32>()?, self.next::<i32>()?);
                    self.put(Key(first), tick)?;
                    self.put(Key(first + 1), counts as u32)?;
                    self.value(Key(first + 2), Type::Number)?;
                }
                self.value(Key(0x0603), Type::Number)
            }
            3 => self.values(&[(Key(0x0604), Type::Number), (Key(0x0605), Type::Number)]),
            _ => Ok(()),
        }
    }
}
