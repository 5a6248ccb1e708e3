//! The text of a first file.

use stiction::control::laws::Gains;
use stiction::control::pd::PdGains;
use stiction::units::value::{About, Absent, Kind, Table as _, Values};
use toml::Value;

use super::answers::{Answer, Answers};
use super::questions::{Question, typed};
use super::typical::Typical;
use super::{range, spread};
use crate::experiment::{Experiment, about_law};
use crate::rules::{
    ControllerGains, DAMPING_RATIO, JointBounds, JointEstimate, MoveProfile, PdLoop, SampledLoop,
    rules,
};
use files::data_sheet::{DataSheet, Mapping};
use files::document::Document;
use files::error::{Error, rounded};
use files::written::{laws, single};

/// Number of columns before the comment of a line.
const COMMENT_AT: usize = 36;

/// Sources of inertia, viscous friction, lowest and highest breakaway effort, in words.
pub type Sources = [&'static str; 4];

/// Text of a first file in addition to the answers.
#[derive(Clone, Debug)]
pub struct DraftStyle {
    /// Start of the first comment: the command that has written the file.
    pub begin: String,
    /// Title, unless an answer sets it.
    pub title: String,
    /// Source of the joint, if it is known.
    pub source: Option<&'static str>,
    /// Further lines of `[drive]`.
    pub drive: &'static str,
    /// Further numbers, by table (one that has answers, or `limits`) and key, with a comment each.
    pub more: Vec<Line>,
    /// Joint from which the gains follow, and the sources of its values; `None`: the joint of the
    /// data sheet.
    pub joint: Option<(JointEstimate, Sources)>,
}

impl DraftStyle {
    /// Returns the style of `stiction new`; a typical joint is named as the source.
    pub fn of(like: Option<&Typical>) -> Self {
        Self {
            begin: "# Written by `stiction new`. ".into(),
            title: like.map_or("A joint of my own", |typical| typical.title).into(),
            source: like.map(|typical| typical.source),
            drive: like.map_or("", |typical| typical.drive),
            more: vec![],
            joint: None,
        }
    }
}

/// Returns the text of the file `name` of a joint; a typical joint is named as its source.
///
/// # Errors
/// Returns an error that names an answer with which no joint can be simulated.
pub fn text(name: &str, answers: &Answers, like: Option<&Typical>) -> Result<String, Error> {
    text_with(name, answers, &DraftStyle::of(like))
}

/// Returns the text of the file `name` of a joint, in the given style.
///
/// # Errors
/// Returns an error that names an answer with which no joint can be simulated.
pub fn text_with(name: &str, answers: &Answers, style: &DraftStyle) -> Result<String, Error> {
    let answers = &answers.with_assumptions();
    let DraftStyle { begin, title, source, drive, more, joint } = style;
    let title = answers.get("title").and_then(|answer| answer.value.as_str()).unwrap_or(title);
    let mut further = more.clone();
    further.extend(of_the_gear(answers));
    let mut text = format!(
        "{begin}Change what differs on your joint, and run it:\n\
         #   stiction run FILE            stiction benchmark FILE\n\
         #   stiction show --units FILE   shows it in the core's volts and degrees\n\
         #   stiction keys                explains every key, and those that are not here\n\
         # The gains are by rule (docs/reference/units.md). Nothing of this has been tried on \
         a motor.\n\
         title = {}\n",
        Value::String(title.into())
    );
    if let Some(source) = source {
        text += &format!("source = {source:?}\n");
    }
    for table in ["motor", "gear", "load", "friction", "supply", "encoder", "load_encoder"] {
        let lines: String = answers
            .given()
            .filter_map(|(question, answer)| {
                let (of, key) = question.key.split_once('.')?;
                let (value, why) = written(question, answer);
                (of == table).then(|| commented(&format!("{key} = {value}"), &why))
            })
            .collect();
        if !lines.is_empty() {
            let further = further.iter().filter(|(of, ..)| *of == table);
            let answered = answers
                .given()
                .filter_map(|(question, _)| question.key.strip_prefix(table)?.strip_prefix('.'));
            let written: Vec<&str> =
                further.clone().map(|(_, key, ..)| *key).chain(answered).collect();
            let lines: String = lines
                + &further
                    .map(|(_, key, value, why)| commented(&format!("{key} = {value:?}"), why))
                    .collect::<String>();
            let more = MORE.iter().filter(|(of, line, _)| {
                *of == table && !written.iter().any(|key| line.starts_with(key))
            });
            let more: String =
                more.map(|(_, line, why)| commented(&format!("# {line}"), why)).collect();
            // The counter of the board.
            let counter = if table == "encoder" { "counter_bits = 32\n" } else { "" };
            text += &format!("\n[{table}]\n{lines}{counter}{more}");
        }
    }
    text += "\n[drive]                             # its volts follow from the tables above\n";
    text += "mode = \"locked-antiphase\"\n";
    text += &commented("pwm_hz = 20000.0", "assumed; above what is heard");
    text += drive;
    let sample_time_s = answers.get("loop.sample_time_s").map(|answer| &answer.value);
    let sample_time_s = sample_time_s.and_then(Value::as_float).unwrap_or_default();
    let loops = |names: &str| {
        format!(
            "\n[loop]\n{}{}",
            commented(
                &format!("sample_time_s = {sample_time_s:?}"),
                "a board accepts 0.0001 to 0.02 s"
            ),
            commented(&format!("controller = [{names}]"), "a device runs the first"),
        )
    };
    let begun = text.clone() + &loops("\"pd\"");
    let estimate = joint.as_ref().map(|(estimate, _)| estimate);
    let (joint, breakaway) = known(name, &begun, answers, estimate)?;
    further.extend(of_the_limits(answers, breakaway));
    let sources = style.joint.as_ref().map_or(&BY_SHEET, |(_, sources)| sources);
    // `robust` needs a friction.
    let sticks = joint.breakaway[0] > 0.0;
    let first = if sticks { "\"robust\", " } else { "" };
    text += &loops(&format!("{first}\"srnf\", \"both\", \"pd\""));
    let limits = if sticks { profile(&MoveProfile::of(&joint)) } else { String::new() };
    let of_limits = further.iter().filter(|(of, ..)| *of == "limits");
    let thresholds: String = of_limits
        .map(|(_, key, value, why)| commented(&format!("{key} = {value:?}"), why))
        .collect();
    let thresholds =
        if thresholds.is_empty() { thresholds } else { format!("\n[limits]\n{thresholds}") };
    let device = match answers.range("limits.travel_deg") {
        Some(_) => {
            "\n[device]\n".to_owned()
                + &commented(
                    "reference = \"command\"",
                    "after a reset, `device home` or `reference`",
                )
        }
        None => String::new(),
    };
    let spread = spread::answered(answers).map(spread::commented).unwrap_or_default();
    let motions = reference(answers);
    let controllers = controllers(&joint, sources)?;
    let text = text + &controllers + &limits + &thresholds + &device + &motions + &spread;
    by_answers(name, &text)?;
    Ok(text)
}

/// Checks the runs of a file whose data sheet has an unusual value; the error names that value as
/// the cause.
fn by_answers(name: &str, text: &str) -> Result<(), Error> {
    let document = Document::parse(name, text)?;
    let Some(suspect) = document.data_sheet()?.and_then(|sheet| sheet.suspect()) else {
        return Ok(());
    };
    Experiment::plan(&document, &[], &[]).map(|_| ()).map_err(|why| {
        let why = why.to_string();
        let why = why.replace(&format!(" ({suspect})"), "");
        let why = why.strip_prefix(&format!("{name}: ")).unwrap_or(&why);
        Error::Input(format!("{name}: {suspect}. With it, {why}"))
    })
}

/// Returns the value of a key and its comment.
fn written(question: &Question, Answer { value, source }: &Answer) -> (String, String) {
    let why = if source.is_empty() { question.what } else { source };
    match value {
        Value::String(word) => (format!("{word:?}"), why.into()),
        Value::Float(number) => (format!("{number:?}"), why.into()),
        Value::Array(ends) => {
            let [low, high] =
                [0, 1].map(|end| ends.get(end).and_then(Value::as_float).unwrap_or_default());
            let from = format!("{} of {}", range::rule([low, high]), typed(value));
            (format!("{:?}", range::nominal([low, high])), from)
        }
        other => (typed(other), why.into()),
    }
}

/// A number of a file: table, key, value and comment.
type Line = (&'static str, &'static str, f64, &'static str);

/// Share of critical damping of a load on its gear.
const GEAR_DAMPING: f64 = 0.05;

/// Returns the assumed damping of an elastic gear, `2 zeta sqrt(K J)`.
fn of_the_gear(answers: &Answers) -> Option<Line> {
    let [stiffness, inertia] = ["gear.stiffness_nm_per_rad", "load.inertia_kg_m2"]
        .map(|key| answers.number(key).filter(|number| *number > 0.0));
    let damping = 2.0 * GEAR_DAMPING * (stiffness? * inertia?).sqrt();
    let damping = format!("{damping:.1e}").parse().unwrap_or(damping);
    Some(("gear", "damping_nm_s_per_rad", damping, "assumed: 5 % of critical, of the load"))
}

/// Returns the limits that follow from the answers: the travel, and the breakaway effort if the
/// answers have ranges. The default breakaway effort follows from the nominal friction; with it, a
/// joint at the upper end of its range would count as stalled.
fn of_the_limits(answers: &Answers, breakaway: f64) -> Vec<Line> {
    let mut lines = Vec::new();
    if let Some([low, high]) = answers.range("limits.travel_deg") {
        lines.push((
            "limits",
            "position_min_deg",
            low,
            "from the position that `home` or `reference` sets",
        ));
        lines.push(("limits", "position_max_deg", high, ""));
    }
    if spread::highest_stick(answers).is_some() {
        let breakaway = rounded(breakaway).parse().unwrap_or(breakaway);
        lines.push(("limits", "breakaway_v", breakaway, "the highest friction and gravity"));
    }
    lines
}

/// Writes `[profile]`, the limits of a move: `robust` has no gains from which a device could derive
/// them.
fn profile(MoveProfile { limits, limited_by }: &MoveProfile) -> String {
    let line =
        |key: &str, value: f32, why: &str| commented(&format!("{key} = {:?}", single(value)), why);
    "\n[profile]                           # of moves and of `device identify`, at most\n"
        .to_owned()
        + &line("velocity_deg_per_s", limits.velocity, limited_by)
        + &line(
            "acceleration_deg_per_s2",
            limits.acceleration,
            "an eighth of the full effort at most",
        )
        + &line("jerk_deg_per_s3", limits.jerk, "reaches that within 0.1 s")
}

/// Returns the bounds of the joint in the text so far, and the largest effort that starts any joint
/// within its ranges against its load, V. The bounds of an identified joint follow from its
/// estimate.
fn known(
    name: &str,
    begun: &str,
    answers: &Answers,
    identified: Option<&JointEstimate>,
) -> Result<(JointBounds, f64), Error> {
    // A controller, so that the rest is a whole machine and is checked.
    let whole = format!("{begun}[controller.pd]\nkp_v_per_deg = 0.0\nkd_v_per_deg_per_s = 0.0\n");
    let document = Document::parse(name, &whole)?;
    let machine = document.machine()?;
    let Some((sheet, mapping)) = document.mapping()? else {
        return Err(Error::Input(format!("{name}: the table `[motor]` is missing")));
    };
    let largest_effort = mapping.full_scale_v * mapping.duty_max;
    let sampled = SampledLoop {
        largest_effort,
        lsb: machine.drive.lsb_v(),
        count: machine.count_deg(),
        sample_time: machine.sampling.sample_time_s(),
    };
    let stiffest = at_the_ends(&sheet, answers);
    let estimate =
        identified.copied().unwrap_or_else(|| JointEstimate::of_sheet(&stiffest, &mapping));
    let count_deg = machine.encoder.resolution_deg();
    let joint = JointBounds::of(&estimate, sampled).with_encoders_of(&sheet, &mapping, count_deg);
    Ok((joint, breakaway(stiffest, &mapping, answers).min(largest_effort)))
}

/// Returns the data sheet with the ends of its ranges that matter to the bounds: the lowest slip
/// friction, the highest stick friction, and the largest gravity.
fn at_the_ends(sheet: &DataSheet, answers: &Answers) -> DataSheet {
    let mut sheet = sheet.clone();
    let [slip, stick] = [&mut sheet.friction.slip_nm, &mut sheet.friction.stick_nm];
    for (value, key, end) in [
        (slip, "friction.slip_nm", 0),
        (stick, "friction.stick_nm", 1),
        (&mut sheet.load.unbalance_nm, "load.unbalance_nm", 1),
    ] {
        if let Some(ends) = answers.only_range(key) {
            *value = ends[end];
        }
    }
    sheet
}

/// Returns the largest effort that starts any of the drawn joints against its load, V.
fn breakaway(mut sheet: DataSheet, mapping: &Mapping, answers: &Answers) -> f64 {
    let drawn = spread::highest_stick(answers).unwrap_or(0.0);
    sheet.friction.stick_nm = sheet.friction.stick_nm.max(drawn);
    mapping.volts(sheet.resting_torque())
}

/// Controllers of a first file: name, law of its rule, and comment on its use.
const CONTROLLERS: [(&str, &str, &str); 4] = [
    ("robust", "robust", "rests on the count in simulation"),
    ("srnf", "srnf", "rests within a few counts"),
    ("both", "feedforward+srnf", "tracks best, and chatters more"),
    ("pd", "pd", "to compare with: stops where it sticks"),
];

/// Writes the controllers with the gains of the rule book.
fn controllers(joint: &JointBounds, sources: &Sources) -> Result<String, Error> {
    let mut text = String::new();
    for (name, law, what) in CONTROLLERS {
        if law == "robust" && joint.breakaway[0] <= 0.0 {
            continue;
        }
        for rule in rules(&[law.to_owned()])? {
            let head = format!("[controller.{name}]");
            text += &format!("\n{}", commented(&head, what));
            text += &controller(&rule.gains(joint), joint, sources);
        }
    }
    Ok(text)
}

/// Writes the table of a controller, with a comment to each gain.
fn controller(gains: &ControllerGains, joint: &JointBounds, sources: &Sources) -> String {
    let mut text = String::new();
    if let [_, _, ..] = gains.laws[..] {
        let names: Vec<&str> = gains.laws.iter().map(Gains::name).collect();
        text += &format!("laws = {names:?}\n");
    }
    let mut add = |about: &About, bits: Option<u32>| {
        if let Some(value) = bits.and_then(|bits| written_value(about, bits)) {
            let why = why(about.name, joint, sources);
            text += &commented(&format!("{} = {value}", about.name), &why);
        }
    };
    if !gains.laws.iter().any(Gains::replaces_pd) {
        PdGains::ABOUT.iter().for_each(|about| add(about, gains.pd.get(about.key)));
    }
    for law in &gains.laws {
        let example = laws().map(|(example, _)| example).find(|example| example.id() == law.id());
        let is_default = |about: &About| {
            about.absent != Absent::Needed
                && example.is_some_and(|example| example.get(about.key) == law.get(about.key))
        };
        let written = about_law(law).iter().filter(|about| !is_default(about));
        written.for_each(|about| add(about, law.get(about.key)));
    }
    text
}

/// Returns a gain in the format of a file; `None` for a flag.
fn written_value(about: &About, bits: u32) -> Option<String> {
    match about.kind {
        Kind::Number => Some(format!("{:?}", single(f32::from_bits(bits)))),
        Kind::Whole => Some(bits.to_string()),
        Kind::Choice(words) => words.get(bits as usize).map(|word| format!("{word:?}")),
        Kind::Flag => None,
    }
}

/// Sources of the values of a data sheet.
const BY_SHEET: Sources = [
    "30 % off costs tracking, not the rest",
    "the slope of effort over speed",
    "half of the lowest friction",
    "twice the highest",
];

/// Returns the comment of a gain.
fn why(key: &str, joint: &JointBounds, sources: &Sources) -> String {
    let [of_inertia, of_viscous, of_low, of_high] = *sources;
    match key {
        "kp_v_per_deg" => {
            let frequency = PdLoop::of(joint).natural_frequency;
            return format!("J w_n^2, w_n = {} rad/s", rounded(frequency));
        }
        "kd_v_per_deg_per_s" => return format!("2 zeta J w_n - b, zeta = {DAMPING_RATIO}"),
        "v_ms_v" => "more than what starts the joint",
        "alpha_per_deg" => "as steep as counts and samples allow",
        "v_slip_v" => "0.9 of the slip friction",
        "v_ff_deg_per_s" => "a fiftieth of a count a sample",
        "inertia_v_s2_per_deg" => of_inertia,
        "viscous_v_s_per_deg" => of_viscous,
        "breakaway_low_v" => of_low,
        "breakaway_high_v" => of_high,
        "encoder_side" => "the transmission springs",
        "jitter_counts" | "motor_jitter_counts" => "a reading is a count off either way",
        "load_v" => "the friction does not hold it",
        _ => "",
    }
    .into()
}

/// Optional keys of a joint that no question covers, which the file has as comments: table, line,
/// and explanation.
const MORE: [(&str, &str, &str); 11] = [
    ("motor", "inductance_h = 1e-3", "the current lags"),
    ("motor", "no_load_rpm = 5000.0", "checks kt_nm_per_a"),
    ("motor", "rated_current_a = 1.0", "borne forever; else a tenth of the stall current"),
    ("gear", "stiffness_nm_per_rad = 1e4", "elastic; with it also damping_ and backlash_"),
    ("load", "constant_nm = 0.0", "a torque on the joint, as of a spring"),
    ("load", "unbalance_nm = 0.0", "gravity; hangs_at_deg is where it hangs down"),
    ("friction", "stribeck_rad_per_s = 0.05", "the friction falls over this speed"),
    ("friction", "ripple = 0.1", "part that repeats ripple_per_turn times a turn"),
    ("supply", "internal_resistance_ohm = 0.1", "the voltage gives way under load"),
    ("encoder", "noise_counts = 1", "readings are a count off"),
    ("encoder", "output = \"push-pull\"", "drives its lines: an open one is found at rest"),
];

/// Largest position of the motion, deg.
const FARTHEST_DEG: f64 = 25.0;
/// Largest share of the travel that a motion uses.
const OF_THE_TRAVEL: f64 = 0.8;

/// Writes steps and a motion that every typical joint can make, within the travel.
fn reference(answers: &Answers) -> String {
    let end = answers.range("limits.travel_deg").map_or(f64::INFINITY, |[_, high]| high);
    let farthest = |deg: f64| {
        let within = deg.min(OF_THE_TRAVEL * end);
        format!("{within:.2e}").parse::<f64>().unwrap_or(within)
    };
    let top = farthest(FARTHEST_DEG);
    let steps = [farthest(FARTHEST_DEG / 25.0), farthest(FARTHEST_DEG / 5.0)];
    // Two equal steps are one.
    let steps = if steps[0] < steps[1] { steps } else { [0.2 * steps[1], steps[1]] };
    let [first, second] = steps.map(|step| format!("{:?}", rounded(step).parse().unwrap_or(step)));
    let speed = format!("# {} deg/s there and back", rounded(top / 10.0));
    format!(
        "\n[reference]\nsteps_deg = [{first}, {second}]\n\n\
         [[reference.trajectories]]          {speed}\n\
         corner_times_s = [1.0, 11.0, 13.0, 23.0]\n\
         corner_positions_deg = [0.0, {top:?}, {top:?}, 0.0]\n\
         half_blend_s = 0.25\n"
    )
}

fn commented(line: &str, why: &str) -> String {
    if why.is_empty() {
        return format!("{line}\n");
    }
    format!("{line:<0$} # {why}\n", COMMENT_AT - 1)
}
