//! What `identify --plot` and `tune --plot` draw, read back as XML: which files there are, what
//! they say they show, and that the points of a curve are where the numbers are.
#![cfg(feature = "figures")]

use std::collections::BTreeSet;
use std::fs;
use std::path::Path;

use resvg::usvg::roxmltree::{Document, Node};
use serde_json::Value;

use super::stiction;

/// The names of the files of a directory.
fn files(directory: &Path) -> BTreeSet<String> {
    let entries = fs::read_dir(directory).unwrap();
    entries.map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect()
}

/// The names of these figures, each as SVG and PNG.
fn both(stems: &[&str]) -> BTreeSet<String> {
    stems.iter().flat_map(|stem| ["svg", "png"].map(|kind| format!("{stem}.{kind}"))).collect()
}

/// What a figure says, text by text.
fn texts(svg: &Document) -> Vec<String> {
    let all = svg.descendants().filter(|node| node.has_tag_name("text"));
    let said = |node: Node| {
        node.descendants().filter(Node::is_text).filter_map(|part| part.text()).collect()
    };
    all.map(said).collect()
}

/// Points of a curve, which has nothing but moves and lines to places.
fn points(node: &Node) -> Vec<[f64; 2]> {
    let data = node.attribute("d").unwrap().replace(['M', 'L', ','], " ");
    let numbers: Vec<f64> = data.split_whitespace().map(|word| word.parse().unwrap()).collect();
    assert!(
        numbers.len().is_multiple_of(2) && numbers.iter().all(|number| number.is_finite()),
        "{data}"
    );
    numbers.chunks(2).map(|two| [two[0], two[1]]).collect()
}

/// Whether a picture is a whole PNG: it begins and ends as such a file does.
fn is_whole_png(path: &Path) -> bool {
    let bytes = fs::read(path).unwrap();
    bytes.starts_with(b"\x89PNG\r\n\x1a\n") && bytes.ends_with(b"IEND\xaeB`\x82")
}

/// Ten swings, so the curve of the position turns twenty times over the width of its panel.
#[test]
fn the_figures_of_an_identified_log_are_whole_and_name_what_they_show() {
    let directory = tempfile::tempdir().unwrap();
    let [log, out] = ["swing.csv", "drawn"].map(|name| directory.path().join(name));
    let mut text = "t,q_rad,tau\n".to_owned();
    let w = std::f64::consts::PI;
    for i in 0..20_000u32 {
        let t = 1e-3 * f64::from(i);
        let (sine, cosine) = (w * t).sin_cos();
        // A second speed distinguishes viscous friction from Coulomb's.
        let (slow_sine, slow_cosine) = (0.3 * w * t).sin_cos();
        let v = 0.3 * w * cosine + 0.03 * w * slow_cosine;
        let a = -0.3 * w * w * sine - 0.009 * w * w * slow_sine;
        let tau = 0.5 * a + 0.8 * v + 1.5 * v.signum();
        text += &format!("{t:.3},{:.8},{tau:.6}\n", 0.3 * sine + 0.1 * slow_sine);
    }
    fs::write(&log, text).unwrap();
    let [log, into] = [&log, &out].map(|path| path.to_str().unwrap());
    let columns = ["--time", "t", "--position", "q_rad", "--effort", "tau"];
    stiction(&[&["identify", log], &columns[..], &["--plot", into]].concat());
    assert_eq!(files(&out), both(&["swing-fit", "swing-friction"]));
    for (stem, says) in [
        (
            "swing-fit",
            &[
                "swing: logged and identified",
                "effort (effort)",
                "residual (effort)",
                "position (rad)",
                "logged, in motion",
                "identified",
                "identified, driven by the logged effort",
                "time (s)",
            ][..],
        ),
        (
            "swing-friction",
            &[
                "swing: friction over velocity",
                "effort without inertia (effort)",
                "logged, median",
                "logged, 10 to 90 %",
                "velocity (rad/s)",
            ],
        ),
    ] {
        let svg = fs::read_to_string(out.join(format!("{stem}.svg"))).unwrap();
        let svg = Document::parse(&svg).unwrap();
        let said = texts(&svg);
        for text in says {
            assert!(said.iter().any(|one| one == text), "{stem}: no `{text}` in {said:?}");
        }
        // The subtitle has what was found.
        let names =
            |one: &String| one.starts_with("inertia 0.5") || one.starts_with("inertia 0.49");
        assert!(said.iter().any(names), "{stem}: {said:?}");
        let curves = svg.descendants().filter(|node| node.has_tag_name("path"));
        let curves: Vec<Vec<[f64; 2]>> = curves.map(|node| points(&node)).collect();
        if stem == "swing-fit" {
            let turns = |curve: &Vec<[f64; 2]>| {
                let of = |at: &[[f64; 2]]| (at[1][1] - at[0][1]) * (at[2][1] - at[1][1]) < 0.0;
                let width = curve.last().unwrap()[0] - curve[0][0];
                curve.windows(3).filter(|at| of(at)).count() == 20 && width > 500.0
            };
            assert!(curves.iter().any(turns), "{}", curves.len());
        } else {
            // Some cells of the velocity, each way.
            assert!(curves.iter().filter(|curve| curve.len() >= 5).count() >= 4);
        }
        assert!(is_whole_png(&out.join(format!("{stem}.png"))), "{stem}");
    }
}

/// One panel of a law has a point for each set of gains that was tried, and over them the front,
/// the gains of the file and those that stay, named once in a legend.
#[test]
fn the_planes_of_a_tuning_have_a_point_for_each_set_of_gains_that_was_tried() {
    let directory = tempfile::tempdir().unwrap();
    let path = |name: &str| directory.path().join(name);
    let joint = path("joint.toml");
    let joint = joint.to_str().unwrap();
    stiction(&["new", joint, "--typical", "thesis"]);
    let (out, drawn) = (path("tuned.toml"), path("drawn"));
    let [out, into] = [&out, &drawn].map(|path| path.to_str().unwrap());
    let tune = ["tune", joint, "--controller", "srnf", "--cases", "2", "--json"];
    let report = stiction(&[&tune[..], &["--out", out, "--plot", into]].concat());
    let report: Value = serde_json::from_str(&report).unwrap();
    let tried = report["controllers"]["srnf"]["tried"].as_u64().unwrap() as usize;
    assert!(tried > 10, "{report}");
    assert_eq!(files(&drawn), both(&["tuning", "tuning-chatter", "tuning-heat"]));
    for (stem, across, up) in [
        ("tuning", "settling (s)", "tracking error (counts)"),
        ("tuning-chatter", "settling (s)", "chatter (V/s)"),
        ("tuning-heat", "rest error (counts)", "held effort (V)"),
    ] {
        let svg = fs::read_to_string(drawn.join(format!("{stem}.svg"))).unwrap();
        let svg = Document::parse(&svg).unwrap();
        let said = texts(&svg);
        for text in [across, up, "srnf", "tried", "Pareto front", "kept", "the file's"] {
            assert!(said.iter().any(|one| one.contains(text)), "{stem}: no `{text}` in {said:?}");
        }
        assert!(said.iter().any(|one| one.contains("Gains tried on")), "{stem}: {said:?}");
        let circles: Vec<[f64; 2]> = svg
            .descendants()
            .filter(|node| node.has_tag_name("circle"))
            .map(|node| ["cx", "cy"].map(|of| node.attribute(of).unwrap().parse().unwrap()))
            .collect();
        // And one in the legend.
        assert_eq!(circles.len(), tried + 1, "{stem}");
        assert!(circles.iter().flatten().all(|place| place.is_finite()), "{stem}");
        assert!(is_whole_png(&drawn.join(format!("{stem}.png"))), "{stem}");
    }
}

/// A run with an encoder on either side of a gear has a panel of the twist between them; one with
/// the motor's encoder alone has none.
#[test]
fn the_twist_of_a_gear_is_drawn_where_both_encoders_are_read() {
    let directory = tempfile::tempdir().unwrap();
    let path = |name: &str| directory.path().join(name).to_str().unwrap().to_owned();
    let file = path("two.toml");
    let new = ["new", &file, "--typical", "harmonic", "--counts-per-turn", "16384"];
    stiction(&[&new[..], &["--stiffness", "1000", "--backlash", "0.3"]].concat());
    for (side, is_drawn) in [("load", true), ("motor", false)] {
        let (out, side) = (path(side), format!("loop.position={side}"));
        let run = ["run", &file, "--controller", "pd", "--plot", &out, "--set", &side];
        stiction(&[&run[..], &["--set", "reference.trajectories=[]"]].concat());
        let svg = fs::read_to_string(Path::new(&out).join("two-pd-steps.svg")).unwrap();
        let svg = Document::parse(&svg).unwrap();
        let labels = texts(&svg);
        let is_there = labels.iter().any(|text| text == "motor less load (deg)");
        assert_eq!(is_there, is_drawn, "{side}: {labels:?}");
    }
}
