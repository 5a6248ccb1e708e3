//! The signals of a tick, declared once.
//!
//! The list generates [`Tick`], which the controller fills. From the same list, a subscriber gets
//! the signals' descriptions ([`describe`]) and their values ([`value`]). A host uses the list to
//! write columns and to compare the ticks of an image with its own.
//!
//! A law publishes up to [`MAX_LAW_SIGNALS`] signals of its own, which follow those of the list.
//! They are declared in the law's own file ([`Law::SIGNALS`](crate::control::laws::Law::SIGNALS)).

use crate::control::drive::Duty;
use crate::control::reference::Setpoint;
use crate::units::position::Position;

/// Largest number of signals that a law publishes.
pub const MAX_LAW_SIGNALS: usize = 8;

/// The form of a signal's value: how its 32 bits are read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "device", derive(serde::Serialize, serde::Deserialize))]
pub enum Form {
    /// The bits are an `f32`.
    Number,
    /// The bits are an `i32`.
    Whole,
    /// The bits are a `u32`; a flag is 0 or 1.
    Bits,
}

/// A signal of a tick: its name, its unit and how it is read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Signal {
    /// The column's name, with its unit.
    pub name: &'static str,
    /// The unit alone; empty if there is none.
    pub unit: &'static str,
    /// How the signal's values are read.
    pub form: Form,
}

/// Signal that a law publishes; its values are `f32` numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct LawSignal {
    /// The column's name, with its unit.
    pub name: &'static str,
    /// The unit alone; empty if there is none.
    pub unit: &'static str,
}

/// Type that a signal can have.
pub trait Value: Copy {
    /// How the bits of a value of the type are read.
    const FORM: Form;

    /// Returns the value's 32 bits.
    fn bits(self) -> u32;

    /// Returns the value with these bits. A type of 16 bits uses the lowest 16.
    fn from_bits(bits: u32) -> Self;
}

impl Value for f32 {
    const FORM: Form = Form::Number;

    fn bits(self) -> u32 {
        self.to_bits()
    }

    fn from_bits(bits: u32) -> Self {
        Self::from_bits(bits)
    }
}

impl Value for i32 {
    const FORM: Form = Form::Whole;

    fn bits(self) -> u32 {
        self as u32
    }

    fn from_bits(bits: u32) -> Self {
        bits as i32
    }
}

impl Value for i16 {
    const FORM: Form = Form::Whole;

    fn bits(self) -> u32 {
        i32::from(self) as u32
    }

    fn from_bits(bits: u32) -> Self {
        bits as i16
    }
}

impl Value for u16 {
    const FORM: Form = Form::Bits;

    fn bits(self) -> u32 {
        self.into()
    }

    fn from_bits(bits: u32) -> Self {
        bits as u16
    }
}

impl Value for u32 {
    const FORM: Form = Form::Bits;

    fn bits(self) -> u32 {
        self
    }

    fn from_bits(bits: u32) -> Self {
        bits
    }
}

impl Value for bool {
    const FORM: Form = Form::Bits;

    fn bits(self) -> u32 {
        self.into()
    }

    fn from_bits(bits: u32) -> Self {
        bits != 0
    }
}

/// Declares the signals: `field: type = "name with unit", "unit"`.
macro_rules! signals {
    (
        $(#[$meta:meta])*
        pub struct $Tick:ident {
            $(
                $(#[$field_meta:meta])*
                $field:ident: $type:ty = $name:literal, $unit:literal;
            )+
        }
    ) => {
        $(#[$meta])*
        #[derive(Clone, Copy, Debug, Default, PartialEq)]
        #[repr(C)]
        pub struct $Tick {
            $(
                $(#[$field_meta])*
                pub $field: $type,
            )+
            /// Values of the signals that the law publishes; unused entries are zero.
            pub law: [f32; MAX_LAW_SIGNALS],
        }

        /// The signals of every loop, in the order of their indices.
        pub const SIGNALS: &[Signal] =
            &[$(Signal { name: $name, unit: $unit, form: <$type as Value>::FORM }),+];

        /// Offset of each of [`SIGNALS`] in a [`Tick`] and size of the signal, bytes. The last
        /// entry covers all signals of the law.
        pub const LAYOUT: &[(usize, usize)] = &[
            $((core::mem::offset_of!($Tick, $field), size_of::<$type>()),)+
            (core::mem::offset_of!($Tick, law), 4 * MAX_LAW_SIGNALS),
        ];

        /// Returns the bits of a signal's value. `index` is the signal's place in [`SIGNALS`]; the
        /// signals of the law follow.
        pub fn value(tick: &$Tick, index: usize) -> Option<u32> {
            let mut i = 0;
            $(
                if index == i {
                    return Some(Value::bits(tick.$field));
                }
                i += 1;
            )+
            tick.law.get(index.checked_sub(i)?).map(|value| value.to_bits())
        }

        /// Sets the value of a signal, with the `index` of [`value`]. A host that reads a tick from
        /// the memory of an image needs it.
        pub fn set(tick: &mut $Tick, index: usize, bits: u32) {
            let mut i = 0;
            $(
                if index == i {
                    tick.$field = Value::from_bits(bits);
                    return;
                }
                i += 1;
            )+
            if let Some(own) = index.checked_sub(i).and_then(|own| tick.law.get_mut(own)) {
                *own = f32::from_bits(bits);
            }
        }

        /// Returns the place in [`SIGNALS`] of the signal with the field name `field`. It is for
        /// constants: a field that does not exist does not compile.
        pub const fn index(field: &str) -> usize {
            const FIELDS: &[&str] = &[$(stringify!($field)),+];
            let mut i = 0;
            while i < FIELDS.len() {
                if crate::units::value::equal(FIELDS[i].as_bytes(), field.as_bytes()) {
                    return i;
                }
                i += 1;
            }
            assert!(i < FIELDS.len(), "no signal has that name");
            i
        }
    };
}

signals! {
    /// The signals of one tick. The struct is laid out as in C: a host reads it from the memory of
    /// a running image.
    pub struct Tick {
        /// Ticks since the motion began.
        tick: u32 = "tick", "";
        /// theta_a, counts.
        counts: i32 = "counts", "counts";
        /// theta_d, whole counts.
        reference_counts: i32 = "reference_counts", "counts";
        /// theta_d, the rest in `[0, 1)` counts.
        reference_fraction: f32 = "reference_fraction_counts", "counts";
        /// theta_d', deg/s.
        reference_velocity: f32 = "reference_velocity_deg_per_s", "deg/s";
        /// theta_d'', deg/s^2.
        reference_acceleration: f32 = "reference_acceleration_deg_per_s2", "deg/s^2";
        /// theta_e, deg.
        error: f32 = "error_deg", "deg";
        /// theta_a', measured, deg/s.
        velocity: f32 = "velocity_deg_per_s", "deg/s";
        /// Output of the PD loop, V; zero if the law replaces it.
        v_pd: f32 = "v_pd_v", "V";
        /// Output of the compensator, V.
        v_c: f32 = "v_c_v", "V";
        /// Sum of `v_pd` and `v_c`, limited to the full scale, V: what the loop asks for.
        v: f32 = "v_v", "V";
        /// Effort that the joint gets from now on, V, at the nominal supply: `code` after scaling,
        /// soft start and cap.
        v_applied: f32 = "v_applied_v", "V";
        /// The drive's code, as it is applied.
        code: i16 = "code", "";
        /// The PWM's compare value.
        compare: u16 = "compare", "";
        /// The bridge drives the other way.
        reverse: bool = "reverse", "";
        /// What is applied is less than what was asked for.
        saturated: bool = "saturated", "";
        /// A term was not a finite number: the output is zero and the compensator starts afresh.
        non_finite: bool = "non_finite", "";
        /// The servo: bits 0 to 7 the state (0 boot, 1 stopped, 2 armed, 3 faulted), 8 to 15 the
        /// fault's code, 16 saturated, 17 wound up, 18 bridge on, 19 the law has given up, 31 a
        /// holding brake is closed while the bridge is on. Zero in a loop without a servo.
        status: u32 = "status", "";
        /// Current of the motor, measured, A; zero without a sensor.
        current: f32 = "current_a", "A";
        /// Position of the motor, counts of its own encoder, for a joint with an encoder on either
        /// side; zero with one encoder. Arming does not shift it, other than `counts`: only its
        /// changes have a meaning.
        motor_counts: i32 = "motor_counts", "counts";
    }
}

/// Returns the name, with its unit, of the signal with the field name `field`. It is for constants,
/// as [`index`] is.
pub const fn name(field: &str) -> &'static str {
    SIGNALS[index(field)].name
}

impl Tick {
    /// Bit of `status` that is set once the law has ended its attempts to reach the set point.
    pub const GAVE_UP: u32 = 1 << 19;

    /// Bit of `status` that is set while the output is on, or the bridge's driver wakes up, and the
    /// holding brake is commanded to be closed.
    pub const HELD: u32 = 1 << 31;

    /// Returns the set point theta_d of the tick, with its derivatives.
    pub const fn setpoint(&self) -> Setpoint {
        let position =
            Position { counts: self.reference_counts, fraction: self.reference_fraction };
        let (velocity, acceleration) = (self.reference_velocity, self.reference_acceleration);
        Setpoint { position, velocity, acceleration }
    }

    /// Returns the PWM setting of the tick.
    pub const fn duty(&self) -> Duty {
        Duty { compare: self.compare, reverse: self.reverse }
    }
}

/// Returns the description of the signal at a place: the signals of every loop come first, then
/// those of the law.
pub fn describe(index: usize, law: &[LawSignal]) -> Option<Signal> {
    SIGNALS.get(index).copied().or_else(|| {
        let own = law.get(index.checked_sub(SIGNALS.len())?)?;
        Some(Signal { name: own.name, unit: own.unit, form: Form::Number })
    })
}
