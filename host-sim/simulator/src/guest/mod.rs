//! Guests: laws of another program, beside the built-in ones.
//!
//! ```text
//! GuestLaw -> register -> GainRule -> ControllerGains -> servo -> tick: update -> Controller::tick
//! ```
//!
//! The inputs of a guest are those of a built-in law, in SI: the joint as in the rule book, counts,
//! the set point, the velocity that the servo measures, and the effort that was applied. The guest
//! returns an effort. Servo, monitors, soft start, noise and walls are those of every law, and the
//! thresholds of the monitors follow from PD's gains on the joint. A law that follows a path of its
//! own states the following error that it needs.
//!
//! In an ensemble a guest runs on the drawn joints. In a machine's file a guest is a controller
//! that lists no law (`Document::add_controllers`), and runs on the joint of the file.
//!
//! A controller lives from its first tick to the end of its case, on one thread. A case can create
//! several: a law starts anew at each arming, and after an effort that is not a number.

mod units;

use std::cell::RefCell;
use std::sync::{Arc, PoisonError, RwLock};
use stiction::control::motor_encoder::MotorEncoder;

use stiction::control::laws::{Gains, Guest, GuestGains, GuestJoint, GuestUpdate, LawInput, Loop};

pub use self::units::{JointFacts, Sample};
use crate::rules::{ControllerGains, GainRule, JointBounds, PdLoop, RULES};
use files::error::Error;

/// A law of another program.
pub trait GuestLaw: Send + Sync {
    /// Returns the name, for tables and rows.
    fn name(&self) -> &str;

    /// Returns the version that the law states, for the header of rows.
    fn version(&self) -> &str;

    /// Returns the following error above which a joint has a fault, rad; 0: the one of PD. A law
    /// that follows a path of its own needs its own value.
    fn following_error(&self, _: &JointFacts) -> f64 {
        0.0
    }

    /// Creates the controller of a joint at rest.
    ///
    /// # Errors
    /// Returns a sentence with the reason.
    fn start(&self, joint: &JointFacts) -> Result<Box<dyn Controller>, String>;

    /// Runs a whole case on this thread. A law that needs a lock in each tick can acquire it here
    /// once.
    fn around_case(&self, case: &mut dyn FnMut()) {
        case();
    }
}

/// Controller of one joint.
pub trait Controller {
    /// Returns the effort of a tick, in the unit of the joint's drive.
    ///
    /// # Errors
    /// Returns a sentence with the reason; the case ends as an error.
    fn tick(&mut self, sample: &Sample) -> Result<f64, String>;
}

/// A law and its rule.
#[derive(Clone)]
struct Registered {
    law: Arc<dyn GuestLaw>,
    rule: &'static GainRule,
}

/// Laws by their number; a law that was released is `None`.
static LAWS: RwLock<Vec<Option<Registered>>> = RwLock::new(Vec::new());

thread_local! {
    /// First error of a guest in the case that this thread runs.
    static FAILED: RefCell<Option<String>> = const { RefCell::new(None) };

    /// Controllers of the case that this thread runs. The number of a controller is its place plus
    /// one.
    static RUNNING: RefCell<Vec<Box<dyn Controller>>> = const { RefCell::new(Vec::new()) };
}

/// Registers a law, and returns its rule. The rule lives as long as the program.
///
/// # Errors
/// Returns an error if a built-in law has that name.
pub fn register(law: Arc<dyn GuestLaw>) -> Result<&'static GainRule, Error> {
    let name = law.name().to_owned();
    if RULES.iter().any(|rule| rule.law == name) {
        return Err(Error::Input(format!("--law: `{name}` is the name of a built-in law")));
    }
    if name.is_empty() || name.contains([',', '\n', '"']) {
        return Err(Error::Input(format!(
            "--law: `{name}` cannot be a name; it must have no comma, quote or line break"
        )));
    }
    let mut laws = LAWS.write().unwrap_or_else(PoisonError::into_inner);
    let number = laws.len() as u32;
    let rule = &*Box::leak(Box::new(GainRule {
        law: Box::leak(name.into_boxed_str()),
        knows: "all that the rule book knows",
        text: "its own",
        // The constant of a rule is a number without a unit: here it is that of the law.
        constant: f64::from(number),
        tried: &[],
        gains_with,
    }));
    laws.push(Some(Registered { law, rule }));
    Ok(rule)
}

/// Returns the rule of the guest with a name; of two, the one that was registered last.
pub fn find(name: &str) -> Option<&'static GainRule> {
    let laws = LAWS.read().unwrap_or_else(PoisonError::into_inner);
    laws.iter().rev().flatten().map(|one| one.rule).find(|rule| rule.law == name)
}

/// Returns the version of the guest that a rule belongs to; `None` for a built-in or a released
/// law.
pub fn version(rule: &GainRule) -> Option<String> {
    let is_guest = !RULES.iter().any(|one| one.law == rule.law);
    let laws = LAWS.read().unwrap_or_else(PoisonError::into_inner);
    let registered = laws.get(rule.constant as usize).filter(|_| is_guest)?;
    registered.as_ref().map(|one| one.law.version().to_owned())
}

/// Releases the law of a rule that [`register`] returned; the rule can no longer be run.
pub fn release(rule: &GainRule) {
    let mut laws = LAWS.write().unwrap_or_else(PoisonError::into_inner);
    if let Some(registered) = laws.get_mut(rule.constant as usize) {
        *registered = None;
    }
}

fn gains_with(joint: &JointBounds, number: f64) -> ControllerGains {
    let mut gains = GuestGains {
        update: GuestUpdate(update),
        law: number as u32,
        joint: GuestJoint {
            largest_effort: joint.sampled.largest_effort as f32,
            inertia: joint.inertia as f32,
            viscous: joint.viscous as f32,
            breakaway: joint.breakaway.map(|effort| effort as f32),
            load: joint.load as f32,
            hold_effort: joint.hold_effort as f32,
            jitter: joint.jitter as f32,
            encoder_at_load: joint.encoder_at_load,
        },
        following_error: 0.0,
    };
    if let Some(law) = law(gains.law) {
        let around = Loop {
            sample_time: joint.sampled.sample_time as f32,
            resolution: joint.sampled.count as f32,
            full_scale: joint.sampled.largest_effort as f32,
            lsb: joint.sampled.lsb as f32,
            kp: 0.0,
            motor: MotorEncoder::NONE,
        };
        let facts = JointFacts::of(&Guest { gains, around });
        gains.following_error = law.following_error(&facts).to_degrees() as f32;
    }
    PdLoop::of(joint).with_laws(vec![Gains::Guest(gains)])
}

/// Runs a case on this thread, and removes the guest controllers that it created. `gains` are those
/// of the joints of the case.
///
/// # Errors
/// Returns the error of the case, or the first error of a guest in it.
pub fn run_case<T>(
    gains: &[ControllerGains],
    case: impl FnOnce() -> Result<T, Error>,
) -> Result<T, Error> {
    let number = gains.iter().flat_map(|gains| &gains.laws).find_map(|law| match law {
        Gains::Guest(guest) => Some(guest.law),
        _ => None,
    });
    let Some(number) = number else { return case() };
    let law = law(number).ok_or_else(|| Error::Run("a law was released".into()))?;
    let (mut case, mut ended) = (Some(case), None);
    law.around_case(&mut || {
        ended = case.take().map(|case| case());
        RUNNING.with_borrow_mut(Vec::clear);
    });
    if let Some(why) = FAILED.take() {
        return Err(Error::Run(format!("the law `{}`: {why}", law.name())));
    }
    ended.unwrap_or_else(|| Err(Error::Run(format!("the law `{}` ran no case", law.name()))))
}

/// Returns the effort of a guest in a tick; NaN after an error.
fn update(guest: &Guest, instance: &mut u32, input: &LawInput) -> f32 {
    // The case is an error already.
    if FAILED.with_borrow(Option::is_some) {
        return f32::NAN;
    }
    let effort = RUNNING.with_borrow_mut(|running| {
        if *instance == 0 {
            running.push(started(guest)?);
            *instance = running.len() as u32;
        }
        let controller = running.get_mut(*instance as usize - 1);
        controller.ok_or("its case has ended")?.tick(&Sample::of(input, &guest.around))
    });
    effort.map_or_else(
        |why| {
            FAILED.with_borrow_mut(|failed| {
                failed.get_or_insert(why);
            });
            f32::NAN
        },
        |effort| effort as f32,
    )
}

fn law(number: u32) -> Option<Arc<dyn GuestLaw>> {
    let laws = LAWS.read().unwrap_or_else(PoisonError::into_inner);
    laws.get(number as usize).and_then(Option::as_ref).map(|one| Arc::clone(&one.law))
}

fn started(guest: &Guest) -> Result<Box<dyn Controller>, String> {
    let following_error = guest.gains.following_error;
    if !(following_error >= 0.0 && following_error.is_finite()) {
        return Err("its following error (rad) must be a number from 0 on".into());
    }
    law(guest.gains.law).ok_or("it is not registered")?.start(&JointFacts::of(guest))
}
