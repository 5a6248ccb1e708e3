//! Identification of the ensemble's joints, whose true parameters are known, by the servo's own
//! sequence.
//!
//! The servo runs the core's sequence as a device does, with all monitors and the default bounds.
//! The limits follow from the bounds of the breakaway effort and the nominal inertia, as for a law.

use rayon::prelude::*;
use stiction::identification::{IdentificationRequest, MapPoint, Outcome, SPEEDS, Summary};
use stiction::servo::{Boot, Input, Servo, State};

use super::assemble::parameters;
use super::drawn_case::{Case, DrawOptions};
use super::family::Family;
use dynamics::joint::{Body, CountNoise, Joint as _, Ripple, Train};
use files::error::{Error, suggestion};
use files::hardware::STM32F405;
use simulator::device::identified::breakaway_deviation;
use simulator::output::grid;
use simulator::plant::DelayLine;
use simulator::rules::RULES;

/// Name of rigid joints whose friction varies with the angle. They are none of the ensemble's
/// families.
pub const UNEVEN: &str = "rigid-uneven";

/// True parameters of a joint, in volts, degrees and seconds of the core.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TrueJoint {
    /// Inertia, V/(deg/s^2).
    pub inertia: f64,
    /// Viscous friction, V/(deg/s).
    pub viscous: f64,
    /// Slip friction, V.
    pub slip: f64,
    /// Stick friction, V.
    pub stick: f64,
    /// Constant load that the effort has to hold, V.
    pub load: f64,
}

/// Result of the identification of one joint.
#[derive(Clone, Debug)]
pub struct IdentifiedCase {
    /// Number of the case.
    pub number: u64,
    /// True parameters of the joint.
    pub truth: TrueJoint,
    /// Summary of the findings; `None` if the servo refused the sequence or a fault ended it.
    pub summary: Option<Summary>,
    /// Mean effort over velocity: each speed in both senses, the fastest first.
    pub map: [[MapPoint; 2]; SPEEDS],
    /// Fault with which the servo ended the sequence, if any.
    pub fault: Option<stiction::Fault>,
    /// Duration of the sequence, s.
    pub time_s: f64,
    /// Largest distance from the start, counts.
    pub farthest: u32,
    /// Step of the drive, V.
    pub lsb: f64,
}

/// Identifies the joint of a case. If the servo refuses because a load moves the joint, the result
/// has no summary.
///
/// # Errors
/// If a bound is not allowed.
pub fn identify(case: &Case, asked: &IdentificationRequest) -> Result<IdentifiedCase, Error> {
    let mut joint = case.joint.build()?;
    let pd = RULES.iter().find(|rule| rule.law == "pd");
    let pd = pd.ok_or_else(|| Error::Input("there is no rule for pd".into()))?;
    let parameters = parameters(&case.bounds, &pd.gains(&case.bounds));
    let refused = |why: String| Error::Input(format!("case {}: {why}", case.number));
    let settings = parameters.identify(asked).map_err(|error| refused(error.to_string()))?;
    let mut servo = Servo::new(Ok(&parameters), Boot::at_zero(), &STM32F405);
    let supply = STM32F405.supply_top / 2;
    let mut delay = DelayLine::new(case.delay);
    let per_code = case.bounds.sampled.lsb * case.scale.effort;
    let (mut ticks, mut farthest) = (0u32, 0);
    let mut noise = case.family.has_noise().then(|| CountNoise::new(case.number));
    let mut tick = |servo: &mut Servo| {
        servo.heard();
        let noise = noise.as_mut().map_or(0, CountNoise::next);
        let counter = case.encoder.read(&joint).wrapping_add(noise) as u32;
        let output = servo.tick(Input { counter, supply, lines: 0, ..Input::default() });
        let code = if output.enable { delay.put(output.tick.code) } else { delay.put(0) };
        joint.hold(f64::from(code) * per_code, case.bounds.sampled.sample_time);
    };
    for _ in 0..1000 {
        tick(&mut servo);
        if servo.is_at_rest() {
            break;
        }
    }
    // A joint that a load moves is refused: it is never at rest.
    let is_armed = servo.identify(&settings).is_ok();
    let start = servo.position();
    // The sequence ends automatically; the time limit is only a safeguard.
    while servo.state() == State::Armed
        && f64::from(ticks) * case.bounds.sampled.sample_time < 3600.0
    {
        tick(&mut servo);
        ticks += 1;
        farthest = farthest.max(servo.position().wrapping_sub(start).unsigned_abs());
    }
    let found = servo.identified().filter(|_| is_armed);
    Ok(IdentifiedCase {
        number: case.number,
        truth: TrueJoint::of(case),
        summary: found.map(stiction::identification::Findings::summary),
        map: found.map_or_else(Default::default, |found| found.map),
        fault: servo.latched().map(|latched| latched.fault),
        time_s: f64::from(ticks) * case.bounds.sampled.sample_time,
        farthest,
        lsb: case.bounds.sampled.lsb,
    })
}

impl TrueJoint {
    /// Returns the true parameters of a case's joint; for two bodies, their sums.
    pub fn of(case: &Case) -> Self {
        let [effort, angle] = [case.scale.effort, case.scale.angle];
        let of = |bodies: &[Body]| {
            let sum = |of: fn(&Body) -> f64| bodies.iter().map(of).sum::<f64>();
            Self {
                inertia: sum(|body| body.inertia) * angle / effort,
                viscous: sum(|body| body.friction.curve.viscous) * angle / effort,
                slip: sum(|body| body.friction.curve.coulomb) / effort,
                stick: sum(|body| body.friction.curve.stick) / effort,
                load: -case.joint.load.constant / effort,
            }
        };
        match &case.joint.train {
            Train::Rigid(body) => of(&[*body]),
            Train::LuGre { inertia, curve, .. } => {
                of(&[Body { inertia: *inertia, friction: (*curve).into() }])
            }
            Train::Flexible { motor, load, .. } => of(&[*motor, *load]),
        }
    }
}

/// Returns the names of those families whose joints can be identified, and [`UNEVEN`].
pub fn identified_names(families: impl IntoIterator<Item = Family>) -> Vec<&'static str> {
    let single = families.into_iter().filter(|family| !family.is_arm());
    single.map(Family::name).chain([UNEVEN]).collect()
}

/// Draws a joint of a family, or a rigid one whose friction varies with the angle.
///
/// # Errors
/// If there is no such family, or it has two joints.
pub fn drawn(name: &str, seed: u64, number: u64) -> Result<Case, Error> {
    let kind = DrawOptions::ORDINARY;
    if name != UNEVEN {
        let names = identified_names(Family::all());
        let family = Family::all().find(|family| family.name() == name);
        let family = family.ok_or_else(|| {
            let near = suggestion(name, names);
            Error::Input(format!("--plant {name}: there is no family of that name{near}"))
        })?;
        if family.is_arm() {
            return Err(Error::Input(format!(
                "--plant {name}: an arm has two joints that move each other, and the sequence \
                 identifies one; take a family with one joint"
            )));
        }
        return Ok(Case::draw(seed, family, number, kind));
    }
    let mut case = Case::draw(seed, Family::Rigid, number, kind);
    if let Train::Rigid(body) = &mut case.joint.train {
        // Periods from those of an eccentric gear to the waves of a harmonic drive. The depth is at
        // most the published quarter.
        let place = number as f64;
        let depth = 0.15 + 0.1 * (place * 0.618).fract();
        let cycles = 2.0 * 50f64.powf((place * 0.414).fract());
        body.friction.ripple = Some(Ripple { depth, cycles, phase: place });
    }
    Ok(case)
}

/// Results over the joints of a family: numbers of joints, out of `cases`.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Rates {
    /// Name of the family.
    pub family: String,
    /// Number of joints.
    pub cases: usize,
    /// Joints whose sequence did all of its steps.
    pub done: usize,
    /// Joints whose result is doubted, or whose sequence did not do all of its steps.
    pub flagged: usize,
    /// Joints whose breakaway, slip level, viscous friction and inertia are within 3 %, 3 %, 10 %
    /// and 5 % of the truth: one number for each of the four values.
    pub within: [usize; 4],
    /// Joints whose true value is within two standard deviations of the estimate: one number for
    /// each value of `within`.
    pub held: [usize; 4],
    /// Joints that are not flagged although one of the four values is out of its bound.
    pub unseen: usize,
    /// Joints of `unseen` with a value that is out of its error bar as well as its bound: such a
    /// result is misleading.
    pub misled: usize,
    /// Mean time of a sequence, s.
    pub time_s: f64,
}

/// Bounds of the proof, as largest relative errors: of breakaway, slip level, viscous friction and
/// inertia.
const WITHIN: [f64; 4] = [0.03, 0.03, 0.1, 0.05];

impl IdentifiedCase {
    /// Returns whether the result is doubted, or the sequence did not do all of its steps.
    pub fn is_flagged(&self) -> bool {
        self.summary
            .as_ref()
            .is_none_or(|summary| summary.outcome != Outcome::Done || !summary.doubts.is_none())
    }

    /// Returns estimate, standard deviation and true value of breakaway, slip level, viscous
    /// friction and inertia. The breakaway is the mean of both senses, because of loaded joints.
    /// Its deviation is the mean as well, since most of it is common to both senses.
    fn against_the_truth(&self) -> Option<[[f64; 3]; 4]> {
        let summary = self.summary.as_ref()?;
        let estimate = summary.estimate.as_ref()?;
        let TrueJoint { inertia, viscous, slip, stick, .. } = self.truth;
        let half = |of: [f64; 2]| 0.5 * (of[0] + of[1]);
        let level = half(summary.breakaway.map(|way| f64::from(way.median)));
        // A single place has no deviation, so its value never counts as held.
        let deviation = half(
            summary.breakaway.map(|way| breakaway_deviation(&way, self.lsb).unwrap_or(f64::NAN)),
        );
        let of = |[value, deviation]: [f32; 2], truth| [value.into(), deviation.into(), truth];
        Some([
            [level, deviation, stick],
            of(estimate.coulomb, slip),
            of(estimate.viscous, viscous),
            of(estimate.inertia, inertia),
        ])
    }
}

impl Rates {
    /// Adds the result of a joint.
    pub fn count(&mut self, found: &IdentifiedCase) {
        self.cases += 1;
        self.time_s += (found.time_s - self.time_s) / self.cases as f64;
        let is_done =
            found.summary.as_ref().is_some_and(|summary| summary.outcome == Outcome::Done);
        self.done += usize::from(is_done);
        self.flagged += usize::from(found.is_flagged());
        let Some(all) = found.against_the_truth() else { return };
        let [mut is_out, mut is_misled] = [false; 2];
        for (index, [value, deviation, truth]) in all.into_iter().enumerate() {
            let error = (value - truth).abs();
            let is_within = error <= WITHIN[index] * truth;
            let is_held = error <= 2.0 * deviation;
            self.within[index] += usize::from(is_within);
            self.held[index] += usize::from(is_held);
            is_out |= !is_within;
            is_misled |= !is_within && !is_held;
        }
        self.unseen += usize::from(is_out && !found.is_flagged());
        self.misled += usize::from(is_misled && !found.is_flagged());
    }
}

/// Identifies joints of a family within the default bounds, on all cores.
///
/// # Errors
/// If there is no such family.
pub fn rates(family: &str, seed: u64, cases: u64) -> Result<Rates, Error> {
    rates_within(&IdentificationRequest::default(), family, seed, cases)
}

/// Identifies joints of a family within bounds, on all cores.
///
/// # Errors
/// If there is no such family, or a bound is not allowed.
pub fn rates_within(
    asked: &IdentificationRequest,
    family: &str,
    seed: u64,
    cases: u64,
) -> Result<Rates, Error> {
    let one = |number| identify(&drawn(family, seed, number)?, asked);
    let all = (0..cases).into_par_iter().map(one).collect::<Result<Vec<_>, Error>>()?;
    let mut rates = Rates { family: family.into(), ..Rates::default() };
    all.iter().for_each(|found| rates.count(found));
    Ok(rates)
}

/// Column of the tables: its title and its number of joints.
type Column = (&'static str, fn(&Rates) -> usize);
const COLUMNS: [Column; 12] = [
    ("whole", |rates| rates.done),
    ("flagged", |rates| rates.flagged),
    ("stick\n3 %", |rates| rates.within[0]),
    ("slip\n3 %", |rates| rates.within[1]),
    ("viscous\n10 %", |rates| rates.within[2]),
    ("inertia\n5 %", |rates| rates.within[3]),
    ("stick\n2 sd", |rates| rates.held[0]),
    ("slip\n2 sd", |rates| rates.held[1]),
    ("viscous\n2 sd", |rates| rates.held[2]),
    ("inertia\n2 sd", |rates| rates.held[3]),
    ("unseen", |rates| rates.unseen),
    ("misled", |rates| rates.misled),
];

impl Rates {
    /// Returns the cells of a row: family, number of joints, shares in percent, and mean time in s.
    fn cells(&self) -> Vec<String> {
        let share = |count: usize| format!("{:.1}", 100.0 * count as f64 / self.cases as f64);
        let mut cells = vec![self.family.clone(), self.cases.to_string()];
        cells.extend(COLUMNS.iter().map(|(_, of)| share(of(self))));
        cells.push(format!("{:.0}", self.time_s));
        cells
    }
}

fn heads() -> Vec<&'static str> {
    let of = COLUMNS.iter().map(|(name, _)| *name);
    ["family", "joints"].into_iter().chain(of).chain(["time\ns"]).collect()
}

/// Returns the tables of some families, within 80 columns: how often an identification succeeded,
/// then how far its values are off.
pub fn rates_table(all: &[Rates]) -> String {
    /// Columns of the whole table that each of both tables has.
    const PARTS: [&[usize]; 2] = [&[0, 1, 2, 3, 12, 13, 14], &[0, 4, 5, 6, 7, 8, 9, 10, 11]];
    // Shorter words, so that none is broken by the width.
    let short = |head: &str| head.replace("viscous", "vis-\ncous").replace("inertia", "iner-\ntia");
    let heads: Vec<String> = heads().into_iter().map(short).collect();
    let part = |columns: &[usize]| {
        let of = |cells: &[String]| -> Vec<String> {
            columns.iter().filter_map(|column| cells.get(*column)).cloned().collect()
        };
        let heads: Vec<&str> =
            columns.iter().filter_map(|column| heads.get(*column)).map(String::as_str).collect();
        let mut table = grid::new(&heads);
        all.iter().for_each(|rates| {
            table.add_row(of(&rates.cells()));
        });
        table.trim_fmt()
    };
    format!("{}\n\n{}\n", part(PARTS[0]), part(PARTS[1]))
}

/// Renders all columns as one table in Markdown.
pub fn rates_markdown(all: &[Rates]) -> String {
    let row = |cells: &[String]| format!("| {} |\n", cells.join(" | "));
    let heads = heads().iter().map(|head| head.replace('\n', " ")).collect::<Vec<_>>();
    let rule = vec!["---".to_owned(); heads.len()];
    let rows = all.iter().map(|rates| row(&rates.cells()));
    row(&heads) + &row(&rule) + &rows.collect::<String>()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The proof of docs/how-to/identify.md, on its joints: at least nine of ten are within each
    /// bound.
    #[test]
    fn joints_of_the_model_are_found_within_the_bounds_of_the_proof_and_are_not_doubted() {
        for family in ["rigid", "loaded", "gravity", "thesis-axis"] {
            let found = rates(family, 1, 200).unwrap();
            println!("{found:?}");
            assert_eq!((found.cases, found.done), (200, 200));
            assert!(found.within.iter().all(|within| *within >= 180), "{found:?}");
            assert!(found.flagged <= 2 && found.misled <= 4, "{found:?}");
            // The inertia of `loaded` misses nine of ten, as the page says.
            let asked = if family == "loaded" { [180, 180, 180, 176] } else { [180; 4] };
            let is_held = found.held.iter().zip(asked).all(|(held, asked)| *held >= asked);
            assert!(is_held, "{family}: {found:?}");
            // Error bars that hold the truth of all joints are too wide. Those of the breakaway
            // are, as the page says: their rounding is evenly distributed.
            assert!(found.held[1..].iter().all(|held| *held < 198), "{found:?}");
        }
    }

    #[test]
    fn a_load_is_distinguished_from_the_friction() {
        for number in 0..3 {
            let case = drawn("loaded", 3, number).unwrap();
            let IdentifiedCase { truth, summary, .. } =
                identify(&case, &IdentificationRequest::default()).unwrap();
            let estimate = summary.unwrap().estimate.unwrap();
            let off = (f64::from(estimate.offset[0]) - truth.load).abs();
            assert!(off < 0.03 * truth.slip, "{truth:?} {estimate:?}");
        }
    }

    /// Bristles and shafts give way before the joint breaks away. An identification that took this
    /// for friction would push too weakly, find too large an inertia, and heat the motor.
    #[test]
    fn joints_on_bristles_and_shafts_are_reported_as_such_and_overheat_no_motor() {
        for family in ["lugre", "flexible-motor", "flexible-backlash"] {
            let (mut done, mut flagged) = (0, 0);
            for number in 0..6 {
                let case = drawn(family, 3, number).unwrap();
                let found = identify(&case, &IdentificationRequest::default()).unwrap();
                assert_eq!(found.fault, None, "{family} {number}");
                done += usize::from(found.summary.is_some_and(|one| one.outcome == Outcome::Done));
                flagged += usize::from(found.is_flagged());
            }
            println!("{family}: {done} whole, {flagged} flagged of 6");
            assert!(done >= 4 && flagged >= 5, "{family}: {done} whole, {flagged} flagged of 6");
        }
    }

    #[test]
    fn an_arm_is_refused_noise_is_simulated_and_uneven_joints_are_among_the_names() {
        let why = |name: &str| drawn(name, 1, 0).unwrap_err().to_string();
        assert!(why("arm").contains("two joints"), "{}", why("arm"));
        assert!(why("rigid-unevn").contains("`rigid-uneven`"), "{}", why("rigid-unevn"));
        // The same joints, whose encoder is a count off now and then.
        let found = |noisy: bool| {
            let mut case = drawn("noisy", 3, 0).unwrap();
            case.family = if noisy { Family::Noisy } else { Family::Rigid };
            identify(
                &case,
                &IdentificationRequest { time: Some(5.0), ..IdentificationRequest::default() },
            )
            .unwrap()
            .farthest
        };
        assert_ne!(found(true), found(false));
    }

    #[test]
    fn no_word_of_the_tables_is_broken() {
        let rates = Rates {
            family: "overhauling-flexible".into(),
            cases: 1000,
            done: 1000,
            within: [1000; 4],
            held: [1000; 4],
            ..Rates::default()
        };
        let text = rates_table(&[rates]);
        assert!(text.lines().all(|line| line.chars().count() <= 80), "{text}");
        // Two tables: two and three lines of titles, a row each, and a line between them.
        assert_eq!(text.lines().count(), 2 + 1 + 1 + 3 + 1, "{text}");
        let rows: Vec<&str> = text.lines().filter(|line| line.contains("overhauling")).collect();
        let cells = |row: &str| row.split_whitespace().count();
        assert_eq!([cells(rows[0]), cells(rows[1])], [7, 9], "{text}");
        let whole = ["flagged", "unseen", "misled", "vis-", "iner-"];
        assert!(whole.iter().all(|word| text.contains(word)), "{text}");
    }

    #[test]
    fn friction_that_varies_with_the_angle_is_doubted() {
        let found = rates(UNEVEN, 3, 6).unwrap();
        println!("{found:?}");
        assert!(found.flagged >= 5, "{found:?}");
    }

    /// The bounds are the device's: they hold whatever the joint does.
    #[test]
    fn no_joint_goes_farther_than_it_may_and_a_narrow_bound_ends_it_in_words() {
        let case = drawn("rigid", 3, 1).unwrap();
        let asked = IdentificationRequest {
            travel: Some(20.0),
            time: Some(4.0),
            ..IdentificationRequest::default()
        };
        let found = identify(&case, &asked).unwrap();
        let travel = 20f64.to_radians() / case.count();
        assert!(f64::from(found.farthest) <= travel + 1.0, "{} {travel}", found.farthest);
        assert_eq!(found.summary.map(|summary| summary.outcome), Some(Outcome::Time));
        assert!((3.9..4.3).contains(&found.time_s), "{}", found.time_s);
        // Less effort than starts the joint.
        let weak = IdentificationRequest {
            effort: Some(0.5 * found.truth.stick as f32),
            ..IdentificationRequest::default()
        };
        let found = identify(&case, &weak).unwrap();
        assert_eq!(found.summary.map(|summary| summary.outcome), Some(Outcome::Still));
        assert!(found.farthest <= 2, "{}", found.farthest);
    }
}
