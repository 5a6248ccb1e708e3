//! The friction compensators: the laws around the PD loop.
//!
//! Each law is one module that begins with its equation, and implements [`Law`]. The user sets its
//! gains, in the thesis's units; they are declared as a table. The law itself is prepared once from
//! its gains, for a sample time, and holds the values that a tick needs. Its state is a separate
//! type, is `Copy`, and starts as its `Default`. The list in this file registers the laws:
//! [`Gains`], [`PreparedLaw`] and [`LawState`] are the closed sets of them. A [`Compensator`] is a
//! sum of up to [`MAX_TERMS`] laws (none: plain PD). A law that [replaces](Law::REPLACES_PD) the PD
//! loop stands alone.
//!
//! The laws in `rival/` are by other authors, for comparison. They are compiled with the feature
//! `rivals` alone, which the simulator turns on and an image never has.
//!
//! Compensators switch on the error, on the reference velocity or on the velocity error. Only RVI
//! uses measured velocity, squared: a law that switches on its sign chatters at standstill.

pub mod discontinuous_nonlinear_proportional;
pub mod disturbance_observer;
pub mod feedforward;
mod law;
pub mod rate_variable_integral;
pub mod reset_integral;
pub mod reset_offset_integral;
#[cfg(feature = "rivals")]
pub mod rival;
pub mod robust;
#[cfg(feature = "two-encoders")]
pub mod robust_dual;
pub mod smooth_robust_nonlinear;
mod sum;

use heapless::Vec;

pub use discontinuous_nonlinear_proportional::{
    DiscontinuousNonlinearProportional, DiscontinuousNonlinearProportionalGains,
};
pub use disturbance_observer::{DisturbanceObserver, DisturbanceObserverGains};
pub use feedforward::{Feedforward, FeedforwardGains};
pub use law::{Law, LawInput, Loop};
pub use rate_variable_integral::{RateVariableIntegral, RateVariableIntegralGains};
pub use reset_integral::{ResetIntegral, ResetIntegralGains};
pub use reset_offset_integral::{ResetOffsetIntegral, ResetOffsetIntegralGains};
#[cfg(feature = "rivals")]
pub use rival::{
    Guest, GuestGains, GuestJoint, GuestUpdate, Impulsive, ImpulsiveGains, Pid, PidGains,
    ProxySlidingMode, ProxySlidingModeGains, TwoResetPid, TwoResetPidGains,
};
pub use robust::{Robust, RobustGains};
#[cfg(feature = "two-encoders")]
pub use robust_dual::{RobustDual, RobustDualGains};
pub use smooth_robust_nonlinear::{SmoothRobustNonlinear, SmoothRobustNonlinearGains};
pub use sum::{Compensator, CompensatorState};

use crate::control::signal::{LawSignal, MAX_LAW_SIGNALS};
use crate::units::error::Allowed;
use crate::units::value::{About, Absent, InvalidBits, Key, Kind, Table, Values};

/// The largest number of laws in a sum.
pub const MAX_TERMS: usize = 4;

/// Registers the laws. An entry is a comment with the law's name, the feature under which the law
/// is compiled if it is not always, then `number "name in a machine's file" Type;`. After `alone`
/// comes the law that replaces PD and is too large to have room in each place of a sum. After
/// `unlisted` come the laws that no file can name: the program that runs them makes their gains.
/// The first of these stands alone, too, and a record can have it.
macro_rules! laws {
    ($(
        $(#[doc = $doc:literal])* $(#[cfg($feature:meta)])?
        $number:literal $name:literal $Law:ident;
     )+
     alone $(#[doc = $alone_doc:literal])* $alone_number:literal $alone_name:literal $Alone:ident;
     unlisted
     $(#[doc = $dual_doc:literal])* #[cfg($dual_feature:meta)]
     $dual_number:literal $dual_name:literal $Dual:ident;
     $(#[doc = $guest_doc:literal])* #[cfg($guest_feature:meta)]
     $guest_number:literal $guest_name:literal $Guest:ident;) => {
        gains! {
            listed {
                $($(#[cfg($feature)])? $number $name $Law;)+
                $alone_number $alone_name $Alone;
            }
            otherwise_named { #[cfg($dual_feature)] $dual_number $Dual; }
            all {
                $($(#[doc = $doc])* $(#[cfg($feature)])? $number $name $Law;)+
                $(#[doc = $alone_doc])* $alone_number $alone_name $Alone;
                $(#[doc = $dual_doc])* #[cfg($dual_feature)] $dual_number $dual_name $Dual;
                $(#[doc = $guest_doc])* #[cfg($guest_feature)] $guest_number $guest_name $Guest;
            }
        }
        prepared! {
            alone {
                $(#[doc = $alone_doc])* $Alone;
                $(#[doc = $dual_doc])* #[cfg($dual_feature)] $Dual;
            }
            $($(#[doc = $doc])* $(#[cfg($feature)])? $Law;)+
            $(#[doc = $guest_doc])* #[cfg($guest_feature)] $Guest;
        }
    };
}

/// Generates the gains of every law.
macro_rules! gains {
    (listed {$(
        $(#[cfg($listed_feature:meta)])?
        $listed_number:literal $listed_name:literal $Listed:ident;
    )+}
    otherwise_named {#[cfg($dual_feature:meta)] $dual_number:literal $Dual:ident;}
    all {$(
        $(#[doc = $doc:literal])* $(#[cfg($feature:meta)])?
        $number:literal $name:literal $Law:ident;
    )+}) => {
        /// The gains of one law.
        #[derive(Clone, Copy, Debug, PartialEq)]
        pub enum Gains {
            $($(#[doc = $doc])* $(#[cfg($feature)])? $Law(<$Law as Law>::Gains),)+
        }

        impl Gains {
            /// Every listed law, with its gains as a typical machine has them.
            pub const EXAMPLES: &'static [Self] = &[
                $(
                    $(#[cfg($listed_feature)])?
                    Self::$Listed(<$Listed as Law>::Gains::EXAMPLE),
                )+
            ];

            /// The declarations of the gains of every law, in the order of
            /// [`EXAMPLES`](Self::EXAMPLES).
            pub const ABOUT: &'static [&'static [About]] = &[
                $($(#[cfg($listed_feature)])? <$Listed as Law>::Gains::ABOUT,)+
            ];

            /// The names of the laws in a machine's file, in the order of
            /// [`EXAMPLES`](Self::EXAMPLES).
            pub const NAMES: &'static [&'static str] =
                &[$($(#[cfg($listed_feature)])? $listed_name,)+];

            /// Returns the law's number in records.
            pub const fn id(&self) -> u8 {
                match self {
                    $($(#[cfg($feature)])? Self::$Law(_) => $number,)+
                }
            }

            /// Returns the law with this number, with the gains of its example.
            pub const fn from_id(id: u32) -> Option<Self> {
                match id {
                    $(
                        $(#[cfg($listed_feature)])?
                        $listed_number => Some(Self::$Listed(<$Listed as Law>::Gains::EXAMPLE)),
                    )+
                    #[cfg($dual_feature)]
                    $dual_number => Some(Self::$Dual(<$Dual as Law>::Gains::EXAMPLE)),
                    _ => None,
                }
            }

            /// Returns the law's name in a machine's file.
            pub const fn name(&self) -> &'static str {
                match self {
                    $($(#[cfg($feature)])? Self::$Law(_) => $name,)+
                }
            }

            /// Returns whether the law replaces PD.
            pub const fn replaces_pd(&self) -> bool {
                match self {
                    $($(#[cfg($feature)])? Self::$Law(_) => <$Law as Law>::REPLACES_PD,)+
                }
            }

            /// Returns whether the law is in the image of a device; otherwise only a host has it.
            pub const fn on_the_device(&self) -> bool {
                match self {
                    $($(#[cfg($feature)])? Self::$Law(_) => <$Law as Law>::ON_THE_DEVICE,)+
                }
            }

            /// Returns the size of the law's state, bytes. Its fields are numbers of 32 bits and
            /// smaller, so that the size is the same on a host and on the microcontroller.
            pub const fn state_bytes(&self) -> usize {
                match self {
                    $($(#[cfg($feature)])? Self::$Law(_) => size_of::<<$Law as Law>::State>(),)+
                }
            }

            /// Returns the signals that the law publishes.
            pub const fn signals(&self) -> &'static [LawSignal] {
                match self {
                    $($(#[cfg($feature)])? Self::$Law(_) => <$Law as Law>::SIGNALS,)+
                }
            }

            /// Returns the law's default of `overspeed_deg_per_s`; see [`Law::overspeed`].
            pub fn overspeed(&self, around: &Loop) -> Option<f32> {
                match self {
                    $(
                        $(#[cfg($feature)])?
                        Self::$Law(gains) => <$Law as Law>::overspeed(gains, around),
                    )+
                }
            }

            /// Returns the time for which the law handles swings itself, s; see
            /// [`Law::swing_time`].
            pub fn swing_time(&self, around: &Loop) -> Option<f32> {
                match self {
                    $(
                        $(#[cfg($feature)])?
                        Self::$Law(gains) => <$Law as Law>::swing_time(gains, around),
                    )+
                }
            }

            /// Returns the law's default of `following_error_deg`; see [`Law::following_error`].
            pub fn following_error(&self, around: &Loop) -> Option<f32> {
                match self {
                    $(
                        $(#[cfg($feature)])?
                        Self::$Law(gains) => <$Law as Law>::following_error(gains, around),
                    )+
                }
            }

            /// Returns the error at which the law requests the full scale, deg; see
            /// [`Law::saturating_error`].
            pub fn saturating_error(&self, around: &Loop) -> Option<f32> {
                match self {
                    $(
                        $(#[cfg($feature)])?
                        Self::$Law(gains) => <$Law as Law>::saturating_error(gains, around),
                    )+
                }
            }
        }

        impl Values for Gains {
            fn nth(&self, place: &mut usize) -> Option<(Key, Absent)> {
                match self {
                    $($(#[cfg($feature)])? Self::$Law(gains) => gains.nth(place),)+
                }
            }

            fn get(&self, key: Key) -> Option<u32> {
                match self {
                    $($(#[cfg($feature)])? Self::$Law(gains) => gains.get(key),)+
                }
            }

            fn with_bounds(&self, key: Key) -> Option<(f32, Allowed)> {
                match self {
                    $($(#[cfg($feature)])? Self::$Law(gains) => gains.with_bounds(key),)+
                }
            }

            fn set(&mut self, key: Key, bits: u32) -> Result<bool, InvalidBits> {
                match self {
                    $($(#[cfg($feature)])? Self::$Law(gains) => gains.set(key, bits),)+
                }
            }
        }

    };
}

/// Generates the types of the laws that stand alone, and of those that have a place in a sum.
macro_rules! prepared {
    (
        alone {
            $($(#[doc = $alone_doc:literal])* $(#[cfg($alone_feature:meta)])? $Alone:ident;)+
        }
        $($(#[doc = $doc:literal])* $(#[cfg($feature:meta)])? $Law:ident;)+
    ) => {
        /// A law that is too large for a sum, prepared for a loop.
        #[derive(Clone, Copy, Debug, PartialEq)]
        enum Alone {
            $($(#[doc = $alone_doc])* $(#[cfg($alone_feature)])? $Alone($Alone),)+
        }

        /// The state, from tick to tick, of a law that is too large for a sum.
        // An image has one of them.
        #[allow(clippy::large_enum_variant)]
        #[derive(Clone, Copy, Debug, PartialEq)]
        enum AloneState {
            $($(#[doc = $alone_doc])* $(#[cfg($alone_feature)])? $Alone(<$Alone as Law>::State),)+
        }

        impl AloneState {
            /// Resets the state, in place.
            #[inline]
            fn forget(&mut self) {
                match self {
                    $($(#[cfg($alone_feature)])? Self::$Alone(state) => state.forget(),)+
                }
            }

            /// Called when a motion starts.
            #[inline]
            fn begin_motion(&mut self) {
                match self {
                    $(
                        $(#[cfg($alone_feature)])?
                        Self::$Alone(state) => $Alone::begin_motion(state),
                    )+
                }
            }
        }

        impl Alone {
            /// Prepares the law for a loop, if the gains are those of a law that stands alone.
            fn new(gains: &Gains, around: &Loop) -> Option<Self> {
                match gains {
                    $(
                        $(#[cfg($alone_feature)])?
                        Gains::$Alone(gains) => Some(Self::$Alone($Alone::new(gains, around))),
                    )+
                    _ => None,
                }
            }

            /// Returns the state that the law starts from.
            fn rest(&self) -> AloneState {
                match self {
                    $(
                        $(#[cfg($alone_feature)])?
                        Self::$Alone(_) => AloneState::$Alone(Default::default()),
                    )+
                }
            }

            /// Returns the law's v_c for one tick, V. A state that another law left behind is
            /// replaced, and the law contributes nothing in that tick.
            // An image has one such law, so no state is that of another law.
            #[allow(unreachable_patterns)]
            #[inline]
            fn update(&self, state: &mut AloneState, input: &LawInput) -> f32 {
                match (self, &mut *state) {
                    $(
                        $(#[cfg($alone_feature)])?
                        (Self::$Alone(law), AloneState::$Alone(state)) => law.update(state, input),
                    )+
                    _ => {
                        *state = self.rest();
                        0.0
                    }
                }
            }

            /// Returns whether the law has ended its attempts to reach the set point.
            #[allow(unreachable_patterns)]
            #[inline]
            fn has_given_up(&self, state: &AloneState) -> bool {
                match (self, state) {
                    $(
                        $(#[cfg($alone_feature)])?
                        (Self::$Alone(_), AloneState::$Alone(state)) => {
                            $Alone::has_given_up(state)
                        }
                    )+
                    _ => false,
                }
            }

            /// Returns the values of the signals that the law publishes.
            #[allow(unreachable_patterns)]
            #[inline]
            fn signals(&self, state: &AloneState) -> Option<[f32; MAX_LAW_SIGNALS]> {
                match (self, state) {
                    $(
                        $(#[cfg($alone_feature)])?
                        (Self::$Alone(law), AloneState::$Alone(state)) => Some(law.signals(state)),
                    )+
                    _ => None,
                }
            }
        }

        /// A law that is prepared for a loop, and has a place in a sum.
        #[derive(Clone, Copy, Debug, PartialEq)]
        pub enum PreparedLaw {
            $($(#[doc = $doc])* $(#[cfg($feature)])? $Law($Law),)+
        }

        /// The state of one law from tick to tick.
        #[derive(Clone, Copy, Debug, Default, PartialEq)]
        pub enum LawState {
            /// No law.
            #[default]
            None,
            $($(#[doc = $doc])* $(#[cfg($feature)])? $Law(<$Law as Law>::State),)+
        }

        impl PreparedLaw {
            /// Prepares the law for a loop, if it has a place in a sum. The gains have been
            /// validated.
            pub fn new(gains: &Gains, around: &Loop) -> Option<Self> {
                match gains {
                    $(
                        $(#[cfg($feature)])?
                        Gains::$Law(gains) => Some(Self::$Law($Law::new(gains, around))),
                    )+
                    $($(#[cfg($alone_feature)])? Gains::$Alone(_) => None,)+
                }
            }

            /// Returns the state that the law starts from.
            pub fn rest(&self) -> LawState {
                match self {
                    $($(#[cfg($feature)])? Self::$Law(_) => LawState::$Law(Default::default()),)+
                }
            }

            /// Returns the law's part of v_c for one tick, V.
            ///
            /// A state that another law left behind is replaced, and the law contributes nothing in
            /// that tick.
            pub fn update(&self, state: &mut LawState, input: &LawInput) -> f32 {
                match (self, &mut *state) {
                    $(
                        $(#[cfg($feature)])?
                        (Self::$Law(law), LawState::$Law(state)) => law.update(state, input),
                    )+
                    _ => {
                        *state = self.rest();
                        0.0
                    }
                }
            }

            /// Returns the values of the signals that the law publishes after an update, if it
            /// publishes any.
            #[inline]
            fn signals(&self, state: &LawState) -> Option<[f32; MAX_LAW_SIGNALS]> {
                match (self, state) {
                    $(
                        $(#[cfg($feature)])?
                        (Self::$Law(law), LawState::$Law(state))
                            if !<$Law as Law>::SIGNALS.is_empty() => Some(law.signals(state)),
                    )+
                    _ => None,
                }
            }
        }
    };
}

laws! {
    /// RI, eq. 29.
    1 "ri" ResetIntegral;
    /// RVI, eq. 30.
    2 "rvi" RateVariableIntegral;
    /// ROI, eq. 31.
    3 "roi" ResetOffsetIntegral;
    /// Slip friction feedforward, eq. 32.
    4 "feedforward" Feedforward;
    /// DNPF, eq. 33.
    5 "dnpf" DiscontinuousNonlinearProportional;
    /// SRNF, eq. 35.
    6 "srnf" SmoothRobustNonlinear;
    /// Disturbance observer.
    8 "observer" DisturbanceObserver;
    /// PID: PD with an integral that stops at the drive's limits.
    #[cfg(feature = "rivals")]
    32 "pid" Pid;
    /// PID whose integral is reset where the error and where the velocity crosses zero.
    #[cfg(feature = "rivals")]
    33 "two-reset-pid" TwoResetPid;
    /// Adaptive impulsive positioner.
    #[cfg(feature = "rivals")]
    34 "impulsive" Impulsive;
    /// Proxy-based sliding mode control.
    #[cfg(feature = "rivals")]
    35 "proxy-sliding-mode" ProxySlidingMode;
    alone
    /// `robust`, the supervisor.
    7 "robust" Robust;
    unlisted
    /// `robust` with an encoder on the motor and one on the load.
    #[cfg(feature = "two-encoders")]
    9 "robust-dual" RobustDual;
    /// A guest: a law of another program.
    #[cfg(feature = "rivals")]
    36 "guest" Guest;
}

/// Key of the first law of a sum; the keys of the other laws follow. The value is the number of the
/// law; zero: no law there, nor after it.
pub const FIRST_LAW: Key = Key(0x0500);

/// Declaration of the values with a sum's laws by number, for hosts. A machine's file has the names
/// of the laws instead.
pub(crate) const ABOUT: &[About] = &[About {
    key: FIRST_LAW,
    table: "controller",
    name: "laws",
    field: "",
    text: " Number of a law, in the order of the sum; 0: no more.",
    bounds: "",
    kind: Kind::Whole,
    absent: Absent::Needed,
}];

/// Returns the key under which a value is declared: for every law of a sum, the key of the first
/// law.
pub(crate) fn declared(key: Key) -> Key {
    term(key).map_or(key, |_| FIRST_LAW)
}

/// The laws of a sum as values: which laws they are, and their gains. A sum has each law once at
/// most, and a law that replaces PD stands alone.
impl Values for Vec<Gains, MAX_TERMS> {
    fn nth(&self, place: &mut usize) -> Option<(Key, Absent)> {
        if *place < MAX_TERMS {
            return Some((Key(FIRST_LAW.0 + *place as u16), Absent::Needed));
        }
        *place -= MAX_TERMS;
        self.iter().find_map(|gains| gains.nth(place))
    }

    fn get(&self, key: Key) -> Option<u32> {
        match term(key) {
            Some(term) => Some(self.as_slice().get(term).map_or(0, |gains| gains.id().into())),
            None => self.iter().find_map(|gains| gains.get(key)),
        }
    }

    fn with_bounds(&self, key: Key) -> Option<(f32, Allowed)> {
        let Some(term) = term(key) else {
            return self.iter().find_map(|gains| gains.with_bounds(key));
        };
        let Some(gains) = self.as_slice().get(term) else { return Some((0.0, Allowed::Any)) };
        let alone = gains.replaces_pd() && self.len() > 1;
        let twice = self.iter().take(term).any(|other| other.id() == gains.id());
        let allowed = if alone || twice { Allowed::AnotherLaw } else { Allowed::Any };
        Some((gains.id().into(), allowed))
    }

    fn set(&mut self, key: Key, bits: u32) -> Result<bool, InvalidBits> {
        let Some(term) = term(key) else {
            for gains in self.iter_mut() {
                if gains.set(key, bits)? {
                    return Ok(true);
                }
            }
            return Ok(false);
        };
        if self.as_slice().get(term).is_some_and(|gains| u32::from(gains.id()) == bits) {
            return Ok(true);
        }
        self.truncate(term);
        if bits != 0 {
            let gains = Gains::from_id(bits).filter(|_| self.len() == term).ok_or(InvalidBits)?;
            self.push(gains).map_err(|_| InvalidBits)?;
        }
        Ok(true)
    }
}

/// Returns the place in a sum that belongs to a key, if the key is that of a law.
fn term(key: Key) -> Option<usize> {
    let term = usize::from(key.0.checked_sub(FIRST_LAW.0)?);
    (term < MAX_TERMS).then_some(term)
}
