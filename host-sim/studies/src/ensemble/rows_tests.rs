//! Files of rows that are refused, and reports on files and families that are not taken for one
//! another.

use super::case::Row;
use super::draw::Kind;
use super::family::Family;
use super::machine_file::{Around, MachineEnsemble};
use super::rows::{self, Header};
use super::rules::rules;
use super::run::Ensemble;
use super::{summary, table};
use crate::experiment::Document;

fn header(families: &[Family]) -> Header {
    Header::of(&Ensemble {
        seed: 5,
        cases: 1,
        kind: Kind { hard: false, rate_hz: 1000.0 },
        moves: 0,
        families: families.to_vec(),
        rules: rules(&["pd".into()]).unwrap(),
    })
}

fn row(family: &str) -> Row {
    Row { family: family.into(), law: "pd".into(), ..Row::default() }
}

/// A column of another name would be read as one in which nothing is.
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

/// A machine's file has the name that its user gave it.
#[test]
fn a_file_with_the_name_of_a_family_is_no_such_family() {
    let laws = ["pd".to_owned()];
    for name in ["end-stop.toml", "thesis-axis.toml"] {
        let document = Document::open("step-response").unwrap();
        let around = Around { controllers: &laws, ..Around::default() };
        let machine = MachineEnsemble::around(name, document, around, 15.0).unwrap();
        let header = Header::of_machine(&machine, 1, 1);
        let families = summary::summaries(&header, &machine.run(1, 1).unwrap());
        let found = &families[0].1[0];
        assert!(found.gave_up_s.max().is_none() && found.near_s.max().is_none(), "{name}");
        let text = table::render(&header, &families);
        assert!(text.contains("The gains are those of the file."), "{text}");
    }
}

#[test]
fn what_never_happens_is_told_without_a_unit() {
    let header = header(&[Family::ThesisAxis, Family::EndStop]);
    let rows = ["thesis-axis", "end-stop"].map(row);
    let text = table::render(&header, &summary::summaries(&header, &rows));
    assert!(text.contains("is within 0.05 deg: never (p50), never (p90)"), "{text}");
    assert!(text.contains("before 0 of 1 walls: never (p50)"), "{text}");
    assert!(!text.contains("never s"), "{text}");
}
