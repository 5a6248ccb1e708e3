#![allow(clippy::unwrap_used)]

use super::draw::wrapped;
use super::results::figures;
use super::shape::{Axis, extent, visible};
use super::{Figure, FigureError, InsetRange, Panel, PlotCurve, Style};

fn figure(panels: Vec<Panel>) -> Figure {
    Figure {
        title: "Step & hold".into(),
        subtitle: "simulated".into(),
        x_label: "time (s)".into(),
        panels,
    }
}

fn ramp(gain: f64) -> Vec<(f64, f64)> {
    (-50..=50).map(|k| (f64::from(k) * 0.02, gain * f64::from(k))).collect()
}

fn panel(label: &str, gain: f64) -> Panel {
    Panel::new(label, vec![PlotCurve::new("PD", Style::Primary, ramp(gain))])
}

/// Returns the points of each path, in the order of drawing.
fn paths(svg: &str) -> Vec<Vec<(f64, f64)>> {
    let data = svg.split("<path d=\"").skip(1);
    let data = data.filter_map(|rest| rest.split('"').next());
    let numbers = data.map(|d| d.split_whitespace().filter_map(|n| n.parse::<f64>().ok()));
    let flat = numbers.map(Iterator::collect::<Vec<_>>);
    flat.map(|n| n.chunks(2).map(|p| (p[0], p[1])).collect()).collect()
}

#[test]
fn every_label_is_in_the_drawing() -> Result<(), FigureError> {
    let svg = figure(vec![panel("angle (deg)", 1.0), panel("error (deg)", 1e-3)]).to_svg()?;
    for label in ["Step &amp; hold", "simulated", "time (s)", "angle (deg)", "error (deg)"] {
        assert_eq!(svg.matches(&format!(">{label}<")).count(), 1, "{label}");
    }
    assert_eq!(svg.matches(">PD<").count(), 2);
    Ok(())
}

#[test]
fn cut_curves_stay_in_the_frame() -> Result<(), FigureError> {
    let mut cut = panel("control signal (V)", 1.0);
    cut.lines[0].points[10].1 = 1e300;
    cut.lines.push(PlotCurve::new("total", Style::Total, ramp(-1.0)).held());
    cut.y_range = Some((-5.0, 5.0));
    let svg = figure(vec![cut]).to_svg()?;
    let frame =
        svg.split("<clipPath id=\"panel-0\"><rect ").nth(1).and_then(|r| r.split("/>").next());
    let frame: Vec<f64> =
        frame.unwrap_or_default().split('"').filter_map(|n| n.parse().ok()).collect();
    let [x, y, width, height] = frame[..] else { panic!("no frame in {svg}") };
    for (px, py) in paths(&svg).into_iter().flatten() {
        assert!(px >= x - 0.01 && px <= x + width + 0.01, "{px}");
        assert!(py >= y - 0.01 && py <= y + height + 0.01, "{py}");
    }
    assert!(svg.contains("(cut; data from \u{2212}50.0 to 1.0e300)"));
    Ok(())
}

#[test]
fn points_that_are_not_finite_leave_a_gap() -> Result<(), FigureError> {
    let whole = figure(vec![panel("angle (deg)", 1.0)]);
    let mut broken = whole.clone();
    let points = &mut broken.panels[0].lines[0].points;
    points[20].1 = f64::NAN;
    points[40].0 = f64::INFINITY;
    points[41].1 = f64::NEG_INFINITY;
    let (whole, broken) = (whole.to_svg()?, broken.to_svg()?);
    assert!(!broken.contains("NaN") && !broken.contains("inf"));
    assert_eq!(paths(&broken).len(), paths(&whole).len() + 2);
    Ok(())
}

#[test]
fn a_held_line_keeps_each_value_until_the_next() {
    let line = PlotCurve::new("u", Style::Total, vec![(0.0, 1.0), (1.0, 3.0), (2.0, 3.0)]).held();
    let whole = vec![(0.0, 1.0), (1.0, 1.0), (1.0, 3.0), (2.0, 3.0)];
    assert_eq!(visible(&line, 0.0, 4.0), [whole]);
    let cut = vec![(0.0, 1.0), (1.0, 1.0), (1.0, 2.0)];
    assert_eq!(visible(&line, 0.0, 2.0), [cut]);
}

#[test]
fn ticks_are_round_and_flat_signals_get_an_axis() -> Result<(), FigureError> {
    let axis = Axis::new((-0.3, 0.31), 7.0)?;
    assert_eq!(axis.step, 0.1);
    assert_eq!(axis.number(-0.1, 0), "\u{2212}0.1");
    assert_eq!(axis.number(-0.0, 0), "0.0");
    assert_eq!(extent([5.0, 5.0 + 1e-15].into_iter()), Some((4.5, 5.5 + 1e-15)));
    assert_eq!(extent([0.0, 1e-17].into_iter()), Some((-1.0, 1.0)));
    figure(vec![panel("error (deg)", 0.0)]).to_svg().map(drop)
}

#[test]
fn png_shows_the_text_and_has_the_asked_size() -> Result<(), FigureError> {
    let with_title = figure(vec![panel("angle (deg)", 1.0)]);
    let mut without = with_title.clone();
    without.title.clear();
    let (with_title, without) = (with_title.to_png(2.0)?, without.to_png(2.0)?);
    assert_ne!(with_title, without);
    assert_eq!(with_title[..8], *b"\x89PNG\r\n\x1a\n");
    assert_eq!(with_title[16..20], 1800_u32.to_be_bytes());
    Ok(())
}

#[test]
fn equal_figures_give_equal_files() {
    let figure = figure(vec![panel("angle (deg)", 1.0), panel("error (deg)", 0.1)]);
    assert_eq!(figure.to_svg(), figure.to_svg());
}

#[test]
fn what_cannot_be_drawn_is_refused() {
    let whole = panel("angle (deg)", 1.0);
    let with_range = |range| Panel { y_range: Some(range), ..whole.clone() };
    let with_height = |height| Panel { height, ..whole.clone() };
    let refusal = |panel| figure(vec![panel]).to_svg().err();
    assert_eq!(figure(vec![]).to_svg(), Err(FigureError::Empty));
    assert_eq!(refusal(Panel::new("none", vec![])), Some(FigureError::Empty));
    assert_eq!(refusal(with_range((1.0, -1.0))), Some(FigureError::Range));
    assert_eq!(refusal(with_range((0.0, f64::NAN))), Some(FigureError::Range));
    assert_eq!(refusal(panel("huge", 1e307)), Some(FigureError::Range));
    assert_eq!(refusal(with_height(0.0)), Some(FigureError::Size));
    assert_eq!(refusal(with_height(f64::NAN)), Some(FigureError::Size));
    let mut crowded = with_height(0.4);
    crowded.lines = vec![crowded.lines[0].clone(); 40];
    assert_eq!(refusal(crowded), Some(FigureError::Size));
    let scaled = figure(vec![whole.clone()]).to_png(f32::NAN);
    assert_eq!(scaled.err(), Some(FigureError::Size));
}

#[test]
fn a_title_that_is_too_long_for_a_line_takes_two_and_the_page_grows() -> Result<(), FigureError> {
    assert_eq!(wrapped("one two three", 7), ["one two", "three"]);
    assert_eq!(wrapped("one two three", 6), ["one", "two", "three"]);
    assert_eq!(wrapped("unbreakable", 3), ["unbreakable"]);
    let height = |figure: &Figure| -> Result<f64, FigureError> {
        let svg = figure.to_svg()?;
        let text = svg.split("height=\"").nth(1).and_then(|rest| rest.split('"').next());
        Ok(text.and_then(|text| text.parse().ok()).unwrap_or_default())
    };
    let short = figure(vec![panel("angle (deg)", 1.0)]);
    // 78 letters of size 22 fit into 856 units at half of their size each.
    let long = Figure { title: "seven letters ".repeat(6), ..short.clone() };
    assert_eq!(height(&long)? - height(&short)?, 29.0);
    // Five times two words and one word are 75 letters; with one more word they would be 83.
    assert!(long.to_svg()?.contains(">letters<"));
    Ok(())
}

#[test]
fn an_inset_shows_its_window_where_the_curves_leave_room() -> Result<(), FigureError> {
    // Falls from 5 to 0.01 within the first fifth, and stays there.
    let fall =
        |k: i32| (f64::from(k) * 0.01, if k < 20 { 5.0 - 0.25 * f64::from(k) } else { 0.01 });
    let step = |y: fn(f64) -> f64| {
        let points = (0..=100).map(fall).map(|(t, v)| (t, y(v))).collect();
        Panel::new("error (deg)", vec![PlotCurve::new("PD", Style::Primary, points)])
    };
    let window = InsetRange { time: (0.5, 1.0), values: (-0.02, 0.02) };
    let with = |panel: Panel| figure(vec![Panel { inset: Some(window), ..panel }]).to_svg();
    for sign in [|v: f64| v, |v: f64| -v] {
        let svg = with(step(sign))?;
        assert!(svg.contains("\"panel-0-inset\""));
        assert!(svg.contains(">0.02<") && svg.contains(">\u{2212}0.02<"));
    }
    // A signal that fills its panel to the end leaves no room.
    let full = (0..=100).map(|k| (f64::from(k) * 0.01, f64::from(k % 2))).collect();
    let full = Panel::new("v (V)", vec![PlotCurve::new("v", Style::Total, full)]);
    assert!(!with(full)?.contains("panel-0-inset"));
    Ok(())
}

/// Returns the figures of the runs of a built-in experiment whose labels contain `label`.
fn drawn(experiment: &str, label: &str) -> Vec<Figure> {
    drawn_of(&files::document::Document::open(experiment).unwrap(), experiment, label)
}

fn drawn_of(document: &files::document::Document, experiment: &str, label: &str) -> Vec<Figure> {
    let mut plan = simulator::experiment::Experiment::plan(document, &[], &[]).unwrap();
    plan.runs.retain(|run| run.label.contains(label));
    assert!(!plan.runs.is_empty());
    let results = simulator::run::run_all(&plan.runs).unwrap();
    let sources = document.machine().unwrap().figures;
    figures(experiment, &results, &sources).into_iter().map(|named| named.figure).collect()
}

fn end_of(figure: &Figure) -> f64 {
    figure.panels[0].lines[0].points.last().unwrap().0
}

#[test]
fn the_time_axis_ends_when_the_motion_is_over() {
    // SRNF rests after 0.8 s of 10.
    let steps = &drawn("step-response", "srnf/step")[0];
    assert!((0.8..=1.5).contains(&end_of(steps)), "{}", end_of(steps));
    assert!(steps.subtitle.ends_with("of 10 s, when the motion is over"), "{}", steps.subtitle);
    // The reference of the trajectory moves until 23 s, and a trajectory's figure has no less.
    let trajectories = &drawn("trajectory", "srnf/traj")[0];
    assert!(end_of(trajectories) >= 23.0);
}

#[test]
fn a_ramp_shows_the_levels_that_it_found() {
    for figure in drawn("friction-identification", "rate-0.02") {
        let names: Vec<&str> = figure.panels[0].lines.iter().map(|line| &*line.name).collect();
        assert!(
            names
                .iter()
                .any(|name| name.starts_with("stick: 0.39") || name.starts_with("stick: 0.40")),
            "{names:?}"
        );
        assert!(names.iter().any(|name| name.starts_with("slip, as read: 0.3")), "{names:?}");
    }
}

/// Three laws on three joints: every curve is in the panel for at least half of its axis, even if
/// one rests far from the target.
#[test]
fn the_figure_of_several_laws_is_never_cut_to_nothing() {
    let named = drawn("untuned-joints", "/step");
    let compared: Vec<&Figure> =
        named.iter().filter(|figure| figure.title.starts_with("How far the joint is")).collect();
    assert!(!compared.is_empty());
    for figure in &compared {
        for panel in &figure.panels {
            let (_, most) = panel.y_range.unwrap();
            for line in panel.lines.iter().filter(|line| line.style != Style::Limit) {
                let end_s = line.points.last().unwrap().0;
                let late = line.points.iter().filter(|(time_s, _)| *time_s >= 0.5 * end_s);
                let inside = late.clone().filter(|(_, error)| error.abs() <= most).count();
                assert_eq!(inside, late.count(), "{}: {most}", line.name);
            }
        }
    }
}

#[test]
fn the_figure_of_several_laws_has_the_goal_of_the_file() {
    let toml = simulator::experiment::find("untuned-joints").unwrap().toml;
    let goal = "\n[goal]\ntolerance_deg = 0.5\n";
    for (goal, name, deg) in [("", "2 counts", None), (goal, "0.5 deg", Some(0.5))] {
        let document =
            files::document::Document::parse("joint.toml", &format!("{toml}{goal}")).unwrap();
        let count_deg = document.machine().unwrap().encoder.resolution_deg();
        let counts = deg.map_or(2.0, |deg: f64| deg / count_deg);
        let figures = drawn_of(&document, "joint", "/step");
        let compared =
            figures.iter().find(|figure| figure.title.starts_with("How far the joint is")).unwrap();
        let limits: Vec<&PlotCurve> =
            compared.panels[0].lines.iter().filter(|line| line.style == Style::Limit).collect();
        assert_eq!(limits.iter().map(|line| &*line.name).collect::<Vec<_>>(), [name, ""]);
        for (line, sign) in limits.iter().zip([1.0, -1.0]) {
            assert!(line.points.iter().all(|(_, bound)| (bound - sign * counts).abs() < 1e-9));
        }
        assert!(compared.panels[0].y_range.unwrap().1 >= 1.5 * counts);
    }
}

/// Feedforward adds nothing while the set point rests, so its part of a step is zero.
#[test]
fn a_panel_whose_data_are_all_zero_is_left_out() {
    let zero = Panel::new("v_c (V)", vec![PlotCurve::new("v_c", Style::Total, vec![(0.0, 0.0)])]);
    let limit = PlotCurve::new("", Style::Limit, vec![(0.0, 2.0)]);
    assert!(zero.is_zero() && !panel("v (V)", 1.0).is_zero());
    assert!(Panel { lines: vec![zero.lines[0].clone(), limit], ..zero.clone() }.is_zero());
    assert!(!Panel::new("empty", vec![]).is_zero());
    let figures = drawn("step-response", "feedforward/step");
    assert!(!figures.is_empty());
    for figure in figures {
        let labels: Vec<&str> = figure.panels.iter().map(|one| &*one.y_label).collect();
        assert!(figure.panels.iter().all(|one| !one.is_zero()), "{labels:?}");
        assert!(labels.contains(&"error (deg)"), "{labels:?}");
    }
}
