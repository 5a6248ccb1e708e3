//! View of the device: numbers, a plot of position and reference, and a plot of the effort. If the
//! device is not a board, the first line is the warning, at any size of the terminal.

use ratatui::Frame;
use ratatui::layout::{Constraint, Layout, Rect};
use ratatui::style::{Color, Modifier, Style};
use ratatui::symbols::Marker;
use ratatui::text::{Line, Span};
use ratatui::widgets::{Axis, Chart, Dataset, GraphType, Paragraph, Wrap};
use stiction::link::StateCode;

use super::keys::KEYS;
use super::model::{WatchSample, WatchedDevice};
use files::error::shown;
use files::typed_number;
use simulator::device::words;

/// Least height of a plot with its legend, rows. A lower plot is not drawn, since it would show no
/// more than the numbers.
const LEAST_PLOT: u16 = 5;

/// Least span of the position, counts: noise is not stretched over the whole height.
const LEAST_SPAN_COUNTS: f64 = 10.0;

/// Least span of the motor's current, A.
const LEAST_SPAN_A: f64 = 0.1;

/// Least span of the effort, V.
const LEAST_SPAN_V: f64 = 0.1;

const REFERENCE: Color = Color::Yellow;
const POSITION: Color = Color::Cyan;
const EFFORT: Color = Color::Green;
/// Colour of the effort after the drive's limits.
const APPLIED: Color = Color::Magenta;
const CURRENT: Color = Color::Blue;

/// Draws the whole view.
pub fn draw(frame: &mut Frame, watched: &WatchedDevice) {
    // The warning has a row of its own; the other parts shrink where there is no room.
    let area = frame.area();
    let rows = u16::from(watched.warning.is_some()).min(area.height);
    let warning = Rect { height: rows, ..area };
    let below = Rect { y: area.y + rows, height: area.height - rows, ..area };
    let (state_line, noted) = (state_of(watched), note_of(watched));
    // Without room for all, warnings stay, and the plots go first.
    let mut left = below.height;
    let [state, note, keys, title, numbers] = [
        wrapped(&state_line, area.width),
        wrapped(&noted, area.width),
        wrapped(&KEYS.into(), area.width),
        1,
        6 + u16::from(watched.current.is_some()),
    ]
    .map(|rows| {
        let taken = rows.min(left);
        left -= taken;
        Constraint::Length(taken)
    });
    let rows = [title, state, numbers, note, Constraint::Fill(1), keys];
    let [title, state, numbers, note, plots, keys] = Layout::vertical(rows).areas(below);
    if let Some(text) = watched.warning {
        let style = Style::new().fg(Color::White).bg(Color::Red).add_modifier(Modifier::BOLD);
        frame.render_widget(Paragraph::new(text).style(style), warning);
    }
    frame.render_widget(title_of(watched), title);
    let wrap = |line| Paragraph::new::<Line>(line).wrap(Wrap { trim: true });
    frame.render_widget(wrap(state_line), state);
    frame.render_widget(Paragraph::new(numbers_of(watched)), numbers);
    frame.render_widget(wrap(noted), note);
    frame.render_widget(wrap(KEYS.into()).style(Style::new().fg(Color::DarkGray)), keys);
    plots_of(frame, watched, plots);
}

/// Returns the number of rows that a text needs if it is wrapped between words.
fn wrapped(line: &Line, columns: u16) -> u16 {
    let columns = usize::from(columns).max(1);
    let text: String = line.spans.iter().map(|span| span.content.as_ref()).collect();
    let (mut rows, mut at) = (1, 0);
    for word in text.split(' ') {
        let wide = Line::from(word).width();
        if at > 0 && at + wide > columns {
            (rows, at) = (rows + 1, 0);
        }
        // A word that is longer than a row goes on in the next one.
        rows += wide.saturating_sub(1) / columns;
        at += wide.min(columns) + 1;
    }
    rows.try_into().unwrap_or(u16::MAX)
}

fn title_of(watched: &WatchedDevice) -> Paragraph<'_> {
    let status = &watched.status;
    let time_s = f64::from(status.clock) * f64::from(status.sample_time);
    Paragraph::new(format!("{}, on for {time_s:.1} s", watched.name))
}

fn state_of(watched: &WatchedDevice) -> Line<'static> {
    let status = &watched.status;
    let color = match status.state {
        StateCode::Armed => Color::Green,
        StateCode::Faulted(_) => Color::Red,
        StateCode::Boot | StateCode::Stopped => Color::Gray,
    };
    let badge = Style::new().fg(Color::Black).bg(color).add_modifier(Modifier::BOLD);
    let mut line =
        vec![Span::styled(format!(" {} ", words::state(status.state).to_uppercase()), badge)];
    let mut say =
        |text: String, color| line.push(Span::styled(format!("  {text}"), Style::new().fg(color)));
    if status.fault.code != 0 {
        say(words::fault(&status.fault, status.sample_time), Color::Red);
        say(words::remedy(status.fault.code, "key c"), Color::Red);
    }
    if status.has_failed_test {
        say(words::IN_THE_TEST.into(), Color::Red);
    }
    // Dangerous conditions come first. Those that change from tick to tick come last, so that they
    // shift nothing else.
    let warnings = [
        (
            status.wound_up,
            "pushes a joint that does not move: the motor gets warm; if it lasts, key s",
            Color::Yellow,
        ),
        (status.oscillates, "swings around its target: key s, and check gains", Color::Yellow),
        (
            status.gave_up,
            "given up: not at its target (an obstacle, or a soft gear)",
            Color::Yellow,
        ),
        (
            status.is_encoder_in_doubt,
            "encoder in doubt: turn the joint by hand by 16 counts, or `jog`, before arming",
            Color::Yellow,
        ),
        (status.is_testing, "test at arming: the motion starts after it", Color::Yellow),
        (
            !status.is_referenced,
            "position unknown: with limits, only `jog` and `home` run until it is set",
            Color::Yellow,
        ),
        (status.is_damaged, "a saved set of parameters is damaged: see `status`", Color::Red),
        (
            status.crystal_not_measured,
            "crystal not measured: times are right only if it has 8 MHz",
            Color::Yellow,
        ),
        (!status.has_brown_out, "brown-out reset off: `set-brown-out` turns it on", Color::Yellow),
        (status.unsaved, "parameters not saved", Color::Yellow),
    ];
    for (_, text, color) in warnings.into_iter().filter(|(is_so, ..)| *is_so) {
        say(text.into(), color);
    }
    if watched.lost > 0 {
        say(format!("{} samples lost", watched.lost), Color::Yellow);
    }
    if watched.now().saturated {
        say("saturated: no more effort".into(), Color::Yellow);
    }
    Line::from(line)
}

fn numbers_of(watched: &WatchedDevice) -> Vec<Line<'static>> {
    let (now, status) = (watched.now(), &watched.status);
    let deg = f64::from(status.position) * f64::from(status.resolution);
    // A drive that is not armed has neither a zero nor an effort.
    let armed = |number: f64, decimals: usize| {
        if now.armed { format!("{number:.decimals$}") } else { "-".into() }
    };
    let code = if now.armed { now.code.to_string() } else { "-".into() };
    let duty = if now.armed { now.duty.to_string() } else { "-".into() };
    let left = [
        ("reference", armed(now.reference_deg, 4), "deg", REFERENCE),
        ("position", armed(now.position_deg, 4), "deg", POSITION),
        ("error", armed(now.error_deg, 4), "deg", Color::Reset),
        ("velocity", armed(now.velocity_deg_per_s, 3), "deg/s", Color::Reset),
        ("from power-on", format!("{deg:.4}"), "deg", Color::Reset),
    ];
    let right = [
        ("v_PD", armed(now.v_pd, 4), "V", Color::Reset),
        ("v_c", armed(now.v_c, 4), "V", Color::Reset),
        ("effort v", armed(now.v, 4), "V", EFFORT),
        ("applied", armed(now.v_applied, 4), "V", APPLIED),
        ("code, duty", format!("{code}, {duty}"), "", Color::Reset),
    ];
    let rows = left.into_iter().zip(right);
    let entry = |(name, value, unit, color): (&'static str, String, &'static str, Color)| {
        [
            Span::styled(format!("{name:<14}"), Style::new().fg(color)),
            Span::raw(format!("{value:>9} {unit:<6}")),
        ]
    };
    let current = watched.current.map(|current| {
        let measured = armed(now.current_a, 3);
        let target = current.target_a_per_v.map(|_| armed(now.target_a, 3));
        let target = target.map_or(String::new(), |target| format!(" A, target {target}"));
        format!("{measured:>9}{target} A")
    });
    let motor = status.motor_temperature.map_or(String::new(), |c| format!("; motor {c:.0} deg C"));
    let heat =
        format!("as if driven with {:.3} V for long (a model){motor}", status.thermal_effort);
    rows.map(|(left, right)| Line::from([entry(left), entry(right)].concat()))
        .chain(current.map(|text| Line::from(format!("{:<14}{text}", "motor current"))))
        .chain([Line::from(format!("{:<14}{heat}", "heat"))])
        .collect()
}

/// Returns the last note. While a position is typed, returns the typed text and the number that it
/// is read as, so that the user sees the number before Enter starts the move.
fn note_of(watched: &WatchedDevice) -> Line<'_> {
    let entry = watched.entry.as_str();
    if entry.is_empty() {
        return Line::from(watched.note.as_str());
    }
    let read = typed_number::parse(entry).and_then(|deg| {
        let checked = watched.check(deg).map_err(|error| error.to_string());
        checked.map(|()| format!("move to {entry}_  read as {} deg", shown(deg)))
    });
    match read {
        Ok(text) => Line::from(format!("{text}   (Enter moves; Esc discards it)")),
        Err(why) => {
            let text = format!("{entry}_  {why}   (Esc discards it)");
            Line::styled(text, Style::new().fg(Color::Yellow))
        }
    }
}

fn plots_of(frame: &mut Frame, watched: &WatchedDevice, area: Rect) {
    if area.height < LEAST_PLOT {
        return;
    }
    // Without room for all plots, that of the current goes first, and the position stays.
    let below = if area.height >= 2 * LEAST_PLOT { area.height * 2 / 5 } else { 0 };
    let sensed = watched.current.filter(|_| area.height >= 3 * LEAST_PLOT);
    let lowest = if sensed.is_some() { area.height / 3 } else { 0 };
    let below = if sensed.is_some() { lowest } else { below };
    let rows = [Constraint::Fill(1), Constraint::Length(below), Constraint::Length(lowest)];
    let [position, effort, current] = Layout::vertical(rows).areas(area);
    let least = LEAST_SPAN_COUNTS * f64::from(watched.status.resolution);
    let curves: [Curve; 2] =
        [("reference", REFERENCE, |m| m.reference_deg), ("position", POSITION, |m| m.position_deg)];
    // Only the lower plot has the times.
    plot(frame, watched, &curves, ("deg", least), below == 0, position);
    if below > 0 {
        plot(
            frame,
            watched,
            &[("applied", APPLIED, |m| m.v_applied), ("effort", EFFORT, |m| m.v)],
            ("V", LEAST_SPAN_V),
            lowest == 0,
            effort,
        );
    }
    if let Some(sensed) = sensed {
        let curves: [Curve; 2] =
            [("target", REFERENCE, |m| m.target_a), ("current", CURRENT, |m| m.current_a)];
        // Without a current loop there is no target.
        let curves = if sensed.target_a_per_v.is_some() { &curves[..] } else { &curves[1..] };
        plot(frame, watched, curves, ("A", LEAST_SPAN_A), true, current);
    }
}

/// A curve: its name in the legend, its colour and its signal.
type Curve = (&'static str, Color, fn(&WatchSample) -> f64);

fn plot(
    frame: &mut Frame,
    watched: &WatchedDevice,
    curves: &[Curve],
    (unit, least): (&str, f64),
    with_times: bool,
    area: Rect,
) {
    let pieces: Vec<(Color, Vec<(f64, f64)>)> = curves
        .iter()
        .flat_map(|(_, color, term)| watched.curves(term).into_iter().map(|piece| (*color, piece)))
        .collect();
    let legend = curves.iter().flat_map(|(name, color, _)| {
        let style = Style::new().fg(*color);
        [Span::styled("   -- ", style), Span::raw(*name)]
    });
    let title = Span::styled(format!("{unit:>9}"), Style::new().fg(Color::DarkGray));
    let legend: Vec<Span> = std::iter::once(title).chain(legend).collect();
    let above = Rect { height: 1.min(area.height), ..area };
    let area = Rect { y: area.y + above.height, height: area.height - above.height, ..area };
    frame.render_widget(Paragraph::new(Line::from(legend)), above);
    let values =
        pieces.iter().flat_map(|(_, piece)| piece).map(|point| point.1).filter(|v| v.is_finite());
    let (bounds, decimals) = bounds(values, least);
    let datasets = pieces.iter().map(|(color, piece)| {
        let style = Style::new().fg(*color);
        Dataset::default()
            .marker(Marker::Braille)
            .graph_type(GraphType::Line)
            .style(style)
            .data(piece)
    });
    let axis = Style::new().fg(Color::DarkGray);
    // The margin is the same for every plot, so that their times are below one another.
    let label = |value: f64| format!("{value:>9.decimals$}");
    let ([low, high], window_s) = (bounds, watched.window_s());
    let x = Axis::default().style(axis).bounds([-window_s, 0.0]);
    let y = Axis::default().style(axis).bounds(bounds).labels([
        label(low),
        label(0.5 * (low + high)),
        label(high),
    ]);
    let x = if with_times { x.labels([format!("{:.0} s", -window_s), "now".into()]) } else { x };
    frame.render_widget(Chart::new(datasets.collect()).x_axis(x).y_axis(y), area);
}

/// Returns the range of an axis that holds all values and is at least `least` wide, and the
/// decimals of its labels. Its ends and its middle are multiples of 1, 2 or 5 times a power of ten.
pub(super) fn bounds(values: impl Iterator<Item = f64>, least: f64) -> ([f64; 2], usize) {
    let range = values.fold(None, |range: Option<[f64; 2]>, value| match range {
        None => Some([value; 2]),
        Some([low, high]) => Some([low.min(value), high.max(value)]),
    });
    let [low, high] = range.unwrap_or_default();
    let (middle, span) = (0.5 * (low + high), (high - low).max(least));
    let [low, high] = [middle - 0.5 * span, middle + 0.5 * span];
    // A quarter of the span, so that the two steps on either side of the middle are few.
    let least_step = 0.25 * span;
    let power = least_step.log10().floor();
    let steps = [1.0, 2.0, 5.0, 10.0].map(|factor| factor * 10f64.powf(power));
    let step = steps.into_iter().find(|step| *step >= least_step).unwrap_or(span);
    // An even number of steps, so that the middle is a multiple of a step, too. A rounding error
    // must not add a step.
    let [low, high] = [(low / step + 1e-9).floor(), (high / step - 1e-9).ceil()];
    let high = high + (high - low).rem_euclid(2.0);
    // The labels are multiples of 10^power, so `-power` decimals are enough.
    ([low * step, high * step], (-power).max(0.0) as usize)
}
