//! `stiction plot` reads back and draws what `run --csv` and a device's `log` have written.
#![allow(missing_docs, clippy::unwrap_used, clippy::panic)]

use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use simulator::experiment::{Document, Experiment};
use simulator::output::{csv, series};
use simulator::run::{RunTrace, run_all};

fn stiction(arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_stiction")).args(arguments).output().unwrap()
}

fn written(directory: &Path, name: &str, arguments: &[&str]) -> PathBuf {
    let path = directory.join(name);
    let output = stiction(&[arguments, &[path.to_str().unwrap()]].concat());
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    path
}

#[test]
fn every_term_of_every_sample_is_read_as_it_was_written() {
    let directory = tempfile::tempdir().unwrap();
    let document = Document::open("step-response").unwrap();
    let plan = Experiment::plan(&document, &["srnf".into(), "ri".into()], &[]).unwrap();
    let results = run_all(&plan.runs[..4]).unwrap();
    let path = directory.path().join("runs.csv");
    std::fs::write(&path, csv::render(&results).unwrap()).unwrap();
    let found = series::read(&path).unwrap();
    assert_eq!(found.len(), results.len());
    for (series, result) in found.iter().zip(&results) {
        assert_eq!(series.name, format!("runs, {}", result.plan.label));
        let RunTrace::Loop(moments) = &result.trace else { panic!("a ramp") };
        assert_eq!(series.samples.len(), moments.len());
        for (sample, moment) in series.samples.iter().zip(moments) {
            assert!((sample.time_s - moment.time_s).abs() < 1e-9);
            assert_eq!(sample.reference_deg, Some(moment.reference_deg));
            assert_eq!(
                (sample.position_deg, sample.error_deg),
                (moment.position_deg, Some(moment.error_deg()))
            );
            assert_eq!(sample.velocity_deg_per_s, moment.velocity_deg_per_s);
            let parts =
                [sample.v_pd_v.unwrap(), sample.v_c_v.unwrap(), sample.v_v].map(|v| v as f32);
            assert_eq!(parts, [moment.tick.v_pd, moment.tick.v_c, moment.tick.v]);
        }
    }
}

#[test]
fn a_log_is_drawn_over_the_run_that_it_repeats_and_a_ramp_without_a_reference() {
    let directory = tempfile::tempdir().unwrap();
    let out = directory.path();
    let step = [
        "run",
        "step-response",
        "--controller",
        "srnf",
        "--set",
        "reference.steps_deg=[2.5]",
        "--csv",
    ];
    let run = written(out, "run.csv", &step);
    let log = written(out, "log.csv", &["device", "--simulated", "move", "2.5", "--log"]);
    let ramp = [
        "run",
        "friction-identification",
        "--set",
        "identification.ramp_rates_v_per_s=[0.01]",
        "--csv",
    ];
    let ramp = written(out, "ramp.csv", &ramp);
    for (files, stem, panels) in [
        (&[&run, &log][..], "run-and-log", ["error (deg)", "v (V)"]),
        (&[&ramp], "ramp", ["displacement (deg)", "v (V)"]),
    ] {
        let files: Vec<&str> = files.iter().map(|path| path.to_str().unwrap()).collect();
        let output = stiction(&[&["plot", "--out", out.to_str().unwrap()], &files[..]].concat());
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        let svg = std::fs::read_to_string(out.join(format!("{stem}.svg"))).unwrap();
        for text in panels {
            assert!(svg.contains(text), "{stem}: {text}");
        }
        assert_eq!(svg.contains("error (deg)"), stem != "ramp");
        assert!(std::fs::read(out.join(format!("{stem}.png"))).unwrap().starts_with(b"\x89PNG"));
    }
}

#[test]
fn ticks_without_a_loop_are_left_out_and_the_rest_is_drawn() {
    let directory = tempfile::tempdir().unwrap();
    let out = directory.path();
    let header = "time_s,reference_deg,position_deg,error_deg,velocity_deg_per_s,v_pd_v,v_c_v,v_v";
    let (without, armed) = ("0.02,,,,,,,", "0.04,1,0.5,0.5,0,1,0,1\n0.06,1,0.6,0.4,5,1,0,1");
    let log = out.join("log.csv");
    for (rows, is_drawn) in [(format!("{without}\n{armed}"), true), (without.into(), false)] {
        std::fs::write(&log, format!("{header}\n{rows}\n")).unwrap();
        let output = stiction(&["plot", "--out", out.to_str().unwrap(), log.to_str().unwrap()]);
        let said = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(output.status.success(), is_drawn, "{said}");
        assert_eq!(said.contains("no samples"), !is_drawn, "{said}");
    }
}

#[test]
fn what_cannot_be_drawn_is_one_sentence_that_names_the_file() {
    let directory = tempfile::tempdir().unwrap();
    let out = directory.path();
    let lab = written(out, "lab.csv", &["run", "spring-mass", "--friction", "karnopp", "--csv"]);
    let many = written(out, "many.csv", &["run", "step-response", "--csv"]);
    let bad = out.join("bad.csv");
    let row = "time_s,reference_deg,position_deg,error_deg,velocity_deg_per_s,v_pd_v,v_c_v,v_v\n\
               0,1,2,3,4,5,6,x\n";
    std::fs::write(&bad, row).unwrap();
    let empty = out.join("empty.csv");
    std::fs::write(&empty, row.lines().next().unwrap()).unwrap();
    for (file, fragment) in [
        (&out.join("none.csv"), "none.csv"),
        (&lab, "there is no column `"),
        (&many, "at most 3"),
        (&bad, "line: 2"),
        (&empty, "no samples"),
    ] {
        let output = stiction(&["plot", "--out", out.to_str().unwrap(), file.to_str().unwrap()]);
        let said = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(
            (output.status.code(), output.stdout.len(), said.lines().count()),
            (Some(2), 0, 1),
            "{said}"
        );
        assert!(said.contains(fragment), "{said}");
    }
}
