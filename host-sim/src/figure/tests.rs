use super::shape::{Axis, extent, visible};
use super::{Error, Figure, Line, Panel, Style};

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
    Panel::new(label, vec![Line::new("PD", Style::Primary, ramp(gain))])
}

/// Points of the curves: of each path in the order of drawing.
fn paths(svg: &str) -> Vec<Vec<(f64, f64)>> {
    let data = svg.split("<path d=\"").skip(1);
    let data = data.filter_map(|rest| rest.split('"').next());
    let numbers = data.map(|d| d.split_whitespace().filter_map(|n| n.parse::<f64>().ok()));
    let flat = numbers.map(Iterator::collect::<Vec<_>>);
    flat.map(|n| n.chunks(2).map(|p| (p[0], p[1])).collect()).collect()
}

#[test]
fn every_label_is_in_the_drawing() -> Result<(), Error> {
    let svg = figure(vec![panel("angle (deg)", 1.0), panel("error (deg)", 1e-3)]).to_svg()?;
    for label in ["Step &amp; hold", "simulated", "time (s)", "angle (deg)", "error (deg)"] {
        assert_eq!(svg.matches(&format!(">{label}<")).count(), 1, "{label}");
    }
    assert_eq!(svg.matches(">PD<").count(), 2);
    Ok(())
}

#[test]
fn cut_curves_stay_in_the_frame() -> Result<(), Error> {
    let mut cut = panel("control signal (V)", 1.0);
    cut.lines[0].points[10].1 = 1e300;
    cut.lines.push(Line::new("total", Style::Total, ramp(-1.0)).held());
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
fn points_that_are_not_finite_leave_a_gap() -> Result<(), Error> {
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
    let line = Line::new("u", Style::Total, vec![(0.0, 1.0), (1.0, 3.0), (2.0, 3.0)]).held();
    let whole = vec![(0.0, 1.0), (1.0, 1.0), (1.0, 3.0), (2.0, 3.0)];
    assert_eq!(visible(&line, 0.0, 4.0), [whole]);
    let cut = vec![(0.0, 1.0), (1.0, 1.0), (1.0, 2.0)];
    assert_eq!(visible(&line, 0.0, 2.0), [cut]);
}

#[test]
fn ticks_are_round_and_flat_signals_get_an_axis() -> Result<(), Error> {
    let axis = Axis::new((-0.3, 0.31), 7.0)?;
    assert_eq!(axis.step, 0.1);
    assert_eq!(axis.number(-0.1, 0), "\u{2212}0.1");
    assert_eq!(axis.number(-0.0, 0), "0.0");
    assert_eq!(extent([5.0, 5.0 + 1e-15].into_iter()), Some((4.5, 5.5 + 1e-15)));
    assert_eq!(extent([0.0, 1e-17].into_iter()), Some((-1.0, 1.0)));
    figure(vec![panel("error (deg)", 0.0)]).to_svg().map(drop)
}

#[test]
fn png_shows_the_text_and_has_the_asked_size() -> Result<(), Error> {
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
    assert_eq!(figure(vec![]).to_svg(), Err(Error::Empty));
    assert_eq!(refusal(Panel::new("none", vec![])), Some(Error::Empty));
    assert_eq!(refusal(with_range((1.0, -1.0))), Some(Error::Range));
    assert_eq!(refusal(with_range((0.0, f64::NAN))), Some(Error::Range));
    assert_eq!(refusal(panel("huge", 1e307)), Some(Error::Range));
    assert_eq!(refusal(with_height(0.0)), Some(Error::Size));
    assert_eq!(refusal(with_height(f64::NAN)), Some(Error::Size));
    let mut crowded = with_height(0.4);
    crowded.lines = vec![crowded.lines[0].clone(); 40];
    assert_eq!(refusal(crowded), Some(Error::Size));
    let scaled = figure(vec![whole.clone()]).to_png(f32::NAN);
    assert_eq!(scaled.err(), Some(Error::Size));
}
