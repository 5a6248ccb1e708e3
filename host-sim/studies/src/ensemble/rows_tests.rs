//! Files of rows that are refused, and reports that must not confuse a machine's file with a
//! family.

use super::case_result::CaseResult;
use super::drawn_case::DrawOptions;
use super::family::Family;
use super::machine_file::{MachineEnsemble, MachineOptions};
use super::motions::Approach;
use super::rows::{self, EnsembleHeader};
use super::run::Ensemble;
use super::{summary, table};
use simulator::experiment::Document;
use simulator::rules::rules;

fn header(families: &[Family]) -> EnsembleHeader {
    EnsembleHeader::of(&Ensemble {
        seed: 5,
        cases: 1,
        kind: DrawOptions::ORDINARY,
        approach: Approach::Step,
        moves: 0,
        families: families.to_vec(),
        rules: rules(&["pd".into()]).unwrap(),
    })
}

fn row(family: &str) -> CaseResult {
    CaseResult { family: family.into(), law: "pd".into(), ..CaseResult::default() }
}

/// A column of another name would be read as an empty one.
#[test]
fn a_file_that_lacks_a_column_or_has_another_form_is_refused() {
    let directory = tempfile::tempdir().unwrap();
    let path = directory.path().join("rows.csv");
    let header = header(&[Family::Rigid]);
    let text = rows::render(&header, &[row("rigid")]).unwrap();
    let text = String::from_utf8(text).unwrap();
    std::fs::write(&path, &text).unwrap();
    assert_eq!(rows::read(&path).unwrap(), (header, vec![row("rigid")]));
    for (from, to, said) in [
        (",settled_s,", ",settling_s,", "line 2: the column `settled_s` is missing"),
        (",near_s,", ",near_s,more,", "line 3: "),
        ("#{\"schema\":4,", "#{\"schema\":3,", "the form 3, and this program reads the form 4"),
        (",success_at_load,", ",success,", "line 2: the column `success_at_load` is missing"),
    ] {
        std::fs::write(&path, text.replacen(from, to, 1)).unwrap();
        let refusal = rows::read(&path).unwrap_err().to_string();
        assert!(refusal.contains("rows.csv") && refusal.contains(said), "{refusal}");
    }
}

/// Files of the same form from before the profiled move: their set points stepped.
#[test]
fn a_file_without_a_motion_is_read_as_one_of_steps() {
    let directory = tempfile::tempdir().unwrap();
    let path = directory.path().join("rows.csv");
    let header = header(&[Family::Rigid]);
    let text = rows::render(&header, &[row("rigid")]).unwrap();
    let text = String::from_utf8(text).unwrap();
    let older = text.replacen(",\"motion\":\"step\"", "", 1);
    let older: Vec<String> = older
        .lines()
        .map(|line| match line.strip_suffix(",set_point_rests_s") {
            Some(titles) => titles.to_owned(),
            None => line.strip_suffix(",0.0").unwrap_or(line).to_owned(),
        })
        .collect();
    let older = older.join("\n") + "\n";
    let is_older = !older.contains("\"motion\"") && !older.contains("set_point_rests_s");
    assert!(is_older, "{older}");
    std::fs::write(&path, older).unwrap();
    assert_eq!(rows::read(&path).unwrap(), (header.clone(), vec![row("rigid")]));
    let profiled = EnsembleHeader { motion: Approach::Profiled, ..header };
    std::fs::write(&path, rows::render(&profiled, &[row("rigid")]).unwrap()).unwrap();
    assert_eq!(rows::read(&path).unwrap().0.motion, Approach::Profiled);
}

/// The user names a machine's file, possibly like a family.
#[test]
fn a_file_with_the_name_of_a_family_is_no_such_family() {
    let laws = ["pd".to_owned()];
    for name in ["end-stop.toml", "thesis-axis.toml"] {
        let document = Document::open("step-response").unwrap();
        let around = MachineOptions { controllers: &laws, ..MachineOptions::default() };
        let machine = MachineEnsemble::around(name, document, around, 15.0).unwrap();
        let header = EnsembleHeader::of_machine(&machine, 1, 1);
        let families = summary::summaries(&header, &machine.run(1, 1).unwrap());
        let found = &families[0].1[0];
        assert!(found.gave_up_s.max().is_none() && found.near_s.max().is_none(), "{name}");
        let text = table::render(&header, &families);
        assert!(text.contains("The gains are those of the file."), "{text}");
    }
}

#[test]
fn what_never_happens_is_reported_without_a_unit() {
    let header = header(&[Family::ThesisAxis, Family::EndStop]);
    let rows = ["thesis-axis", "end-stop"].map(row);
    let text = table::render(&header, &summary::summaries(&header, &rows));
    assert!(text.contains("is within 0.05 deg: never (p50), never (p90)"), "{text}");
    assert!(text.contains("before 0 of 1 walls: never (p50)"), "{text}");
    assert!(!text.contains("never s"), "{text}");
}
