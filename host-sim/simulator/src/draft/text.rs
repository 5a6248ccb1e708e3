//! The text of a first file.

use toml::Value;

use super::answers::{Answer, Answers};
use super::gains::{DAMPING_RATIO, FirstGains, Profile, Told, Worst};
use super::questions::{Question, typed};
use super::range;
use super::spread;
use super::typical::Typical;
use crate::document::Document;
use crate::error::{Error, rounded};
use crate::experiment::Experiment;

/// Where the comments of a line begin.
const COMMENT_AT: usize = 36;

/// Why `robust` is told what it is told: inertia, viscous friction, lowest and highest breakaway.
pub type Whys = [&'static str; 4];

/// What a file says of a joint beside the answers.
#[derive(Clone, Debug)]
pub struct Words {
    /// How the first comment begins: who has written the file.
    pub begin: String,
    /// The title.
    pub title: String,
    /// Where the joint is from, if it is known.
    pub source: Option<&'static str>,
    /// Further lines of `[drive]`.
    pub drive: &'static str,
    /// Further numbers, by table (one that has answers, or `limits`) and key, with a comment each.
    pub more: Vec<Line>,
    /// What `robust` is told, and why; none: what the data sheet says.
    pub told: Option<(Told, Whys)>,
}

impl Words {
    /// Those of `stiction new`; a typical joint is named as its source.
    pub fn of(like: Option<&Typical>) -> Self {
        Self {
            begin: "# Written by `stiction new`. ".into(),
            title: like.map_or("A joint of my own", |typical| typical.title).into(),
            source: like.map(|typical| typical.source),
            drive: like.map_or("", |typical| typical.drive),
            more: vec![],
            told: None,
        }
    }
}

/// Writes the file `name` of a joint; a typical joint is named as its source.
///
/// # Errors
/// Names an answer with which no joint can be simulated.
pub fn text(name: &str, answers: &Answers, like: Option<&Typical>) -> Result<String, Error> {
    text_with(name, answers, &Words::of(like))
}

/// Writes the file `name` of a joint with words of its own.
///
/// # Errors
/// Names an answer with which no joint can be simulated.
pub fn text_with(name: &str, answers: &Answers, words: &Words) -> Result<String, Error> {
    let answers = &answers.with_assumptions();
    let Words { begin, title, source, drive, more, told } = words;
    let title = answers.get("title").and_then(|answer| answer.value.as_str()).unwrap_or(title);
    let mut further = more.clone();
    further.extend(of_the_gear(answers));
    let mut text = format!(
        "{begin}Change what differs on your joint, and run it:\n\
         #   stiction run FILE            stiction benchmark FILE\n\
         #   stiction show --units FILE   tells it in the core's volts and degrees\n\
         #   stiction keys                explains every key, and those that are not here\n\
         # The gains are by rule (docs/units.md). Nothing of this has been tried on a motor.\n\
         title = {}\n",
        Value::String(title.into())
    );
    if let Some(source) = source {
        text += &format!("source = {source:?}\n");
    }
    for table in ["motor", "gear", "load", "friction", "supply", "encoder"] {
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
                "a board takes 0.0001 to 0.02"
            ),
            commented(&format!("controller = [{names}]"), "a device runs the first"),
        )
    };
    let gains = gains(name, &(text.clone() + &loops("\"pd\"")), sample_time_s, answers)?;
    further.extend(of_the_limits(answers, &gains));
    let (told, whys) = told.unwrap_or((gains.robust, BY_SHEET));
    // Without friction there is nothing that `robust` could be told.
    let sticks = told.breakaway[0] > 0.0;
    let first = if sticks { "\"robust\", " } else { "" };
    text += &loops(&format!("{first}\"srnf\", \"both\", \"pd\""));
    let [law, limits] = if sticks {
        [robust(&told, &whys), profile(&gains.profile)]
    } else {
        [String::new(), String::new()]
    };
    let of_limits = further.iter().filter(|(of, ..)| *of == "limits");
    let thresholds: String = of_limits
        .map(|(_, key, value, why)| commented(&format!("{key} = {value:?}"), why))
        .collect();
    let thresholds =
        if thresholds.is_empty() { thresholds } else { format!("\n[limits]\n{thresholds}") };
    let spread = spread::answered(answers).map(spread::commented).unwrap_or_default();
    let motions = reference(answers);
    let text = text + &law + &controllers(&gains) + &limits + &thresholds + &motions + &spread;
    by_answers(name, &text)?;
    Ok(text)
}

/// Refuses gains that no controller may have, by the answer that they follow from.
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

/// Returns the damping that is assumed of a gear with a stiffness, `2 zeta sqrt(K J)`.
fn of_the_gear(answers: &Answers) -> Option<Line> {
    let [stiffness, inertia] = ["gear.stiffness_nm_per_rad", "load.inertia_kg_m2"]
        .map(|key| answers.number(key).filter(|number| *number > 0.0));
    let damping = 2.0 * GEAR_DAMPING * (stiffness? * inertia?).sqrt();
    let damping = format!("{damping:.1e}").parse().unwrap_or(damping);
    Some(("gear", "damping_nm_s_per_rad", damping, "assumed: 5 % of critical, of the load"))
}

/// Returns the limits that follow from the answers: travel, and the breakaway effort of a joint that
/// is known within ranges. The effort that is derived without it is that of the
/// nominal friction, under which a joint at the upper end would count as stalled.
fn of_the_limits(answers: &Answers, gains: &FirstGains) -> Vec<Line> {
    let mut lines = Vec::new();
    if let Some([low, high]) = answers.range("limits.travel_deg") {
        lines.push(("limits", "position_min_deg", low, "from the position at power-on"));
        lines.push(("limits", "position_max_deg", high, ""));
    }
    if spread::highest_stick(answers).is_some() {
        let breakaway = rounded(gains.breakaway).parse().unwrap_or(gains.breakaway);
        lines.push(("limits", "breakaway_v", breakaway, "the highest friction and gravity"));
    }
    lines
}

/// Limits of a move: `robust` has no gains of which a device could derive them.
fn profile(profile: &Profile) -> String {
    let line = |key: &str, value: f64, why: &str| {
        commented(&format!("{key} = {:?}", rounded(value).parse().unwrap_or(value)), why)
    };
    "\n[profile]                           # of moves and of `device identify`, at most\n"
        .to_owned()
        + &line("velocity_deg_per_s", profile.velocity, profile.why)
        + &line(
            "acceleration_deg_per_s2",
            profile.acceleration,
            "an eighth of the full effort at most",
        )
        + &line("jerk_deg_per_s3", profile.jerk, "reaches that within 0.1 s")
}

/// The gains for what has been written so far.
fn gains(
    name: &str,
    begun: &str,
    sample_time_s: f64,
    answers: &Answers,
) -> Result<FirstGains, Error> {
    // A controller, so that the rest is a whole machine and told what is wrong with it.
    let whole = format!("{begun}[controller.pd]\nkp_v_per_deg = 0.0\nkd_v_per_deg_per_s = 0.0\n");
    let document = Document::parse(name, &whole)?;
    let count_deg = document.machine()?.encoder.resolution_deg();
    match document.mapping()? {
        Some((sheet, mapping)) => {
            let end = |key: &str, end: usize| answers.only_range(key).map(|ends| ends[end]);
            let worst = Worst {
                slip_nm: end("friction.slip_nm", 0),
                stick_nm: end("friction.stick_nm", 1),
                unbalance_nm: end("load.unbalance_nm", 1),
                drawn_nm: spread::highest_stick(answers),
            };
            Ok(FirstGains::of(&sheet, &mapping, [sample_time_s, count_deg])
                .within(&sheet, &mapping, worst))
        }
        None => Err(Error::Input(format!("{name}: the table `[motor]` is missing"))),
    }
}

fn controllers(gains: &FirstGains) -> String {
    let line = |key: &str, value: f64, why: &str| {
        let number = rounded(value);
        let point = if number.contains(['.', 'e']) { "" } else { ".0" };
        commented(&format!("{key} = {number}{point}"), why)
    };
    let rule = format!("J w_n^2, w_n = {} rad/s", rounded(gains.natural_frequency));
    let pd = line("kp_v_per_deg", gains.kp, &rule)
        + &line(
            "kd_v_per_deg_per_s",
            gains.kd,
            &format!("2 zeta J w_n - b, zeta = {DAMPING_RATIO}"),
        );
    let srnf = line("v_ms_v", gains.v_ms, "what starts the joint")
        + &line("alpha_per_deg", gains.alpha, "as steep as counts and samples allow");
    let feedforward = line("v_slip_v", gains.v_slip, "0.9 of the slip friction")
        + &line("v_ff_deg_per_s", gains.v_ff, "one count a second");
    format!(
        "\n[controller.srnf]                   # rests within a few counts\n{pd}{srnf}\
         \n[controller.both]                   # tracks best, and chatters more\n\
         laws = [\"feedforward\", \"srnf\"]\n{pd}{srnf}{feedforward}\
         \n[controller.pd]                     # to compare with: stops where it sticks\n{pd}"
    )
}

/// Why `robust` is told what it is told of a data sheet.
const BY_SHEET: Whys = [
    "30 % off costs tracking, not the rest",
    "the slope of effort over speed",
    "half of the lowest friction",
    "twice the highest",
];

/// Writes what the law is told that knows neither friction nor inertia well, with why.
fn robust(told: &Told, whys: &Whys) -> String {
    let line = |key: &str, value: f64, why: &str| {
        commented(&format!("{key} = {:?}", rounded(value).parse().unwrap_or(value)), why)
    };
    let [low, high] = told.breakaway;
    let [of_inertia, of_viscous, of_low, of_high] = *whys;
    let mut text = "\n[controller.robust]                 # rests on the count in simulation\n"
        .to_owned()
        + &line("inertia_v_s2_per_deg", told.inertia, of_inertia)
        + &line("viscous_v_s_per_deg", told.viscous, of_viscous)
        + &line("breakaway_low_v", low, of_low)
        + &line("breakaway_high_v", high, of_high);
    if told.behind_a_spring {
        text += &commented("encoder_side = \"load\"", "the transmission springs");
    }
    if told.load > 0.0 {
        text += &line("load_v", told.load, "the friction does not hold it");
    }
    text
}

/// Keys that a joint may have beside those that are asked for, with their tables.
const MORE: [(&str, &str, &str); 9] = [
    ("motor", "inductance_h = 1e-3", "the current lags"),
    ("motor", "no_load_rpm = 5000.0", "checks kt_nm_per_a"),
    ("gear", "stiffness_nm_per_rad = 1e4", "elastic; with it also damping_ and backlash_"),
    ("load", "constant_nm = 0.0", "a torque on the joint, as of a spring"),
    ("load", "unbalance_nm = 0.0", "gravity; hangs_at_deg is where it hangs down"),
    ("friction", "stribeck_rad_per_s = 0.05", "the friction falls over this speed"),
    ("friction", "ripple = 0.1", "part that repeats ripple_per_turn times a turn"),
    ("supply", "internal_resistance_ohm = 0.1", "the voltage gives way under load"),
    ("encoder", "noise_counts = 1", "readings are a count off"),
];

/// Largest position of the motion, deg, and the largest share of the travel that a motion takes.
const FARTHEST_DEG: f64 = 25.0;
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
