//! A law in C, compiled and run beside the built-in ones.

use std::mem::offset_of;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::Mutex;

use super::open;
use simulator::guest::{GuestLaw, JointFacts, Sample, register};
use simulator::progress::Silent;
use simulator::rules::{GainRule, rules};
use studies::ensemble::{
    Approach, CaseResult, DrawOptions, Ensemble, EnsembleHeader, Family, run, sort_rows,
};

/// Compiles a source in C into a shared library; definitions are `-D` options.
fn compiled(source: &str, definitions: &[&str]) -> (tempfile::TempDir, PathBuf) {
    let here = PathBuf::from(env!("CARGO_MANIFEST_DIR"));
    let directory = tempfile::tempdir().unwrap();
    compile(&here.join(source), definitions, directory)
}

fn compile(
    source: &Path,
    definitions: &[&str],
    directory: tempfile::TempDir,
) -> (tempfile::TempDir, PathBuf) {
    let here = PathBuf::from(env!("CARGO_MANIFEST_DIR"));
    let library = directory.path().join("law.so");
    let made = Command::new("cc")
        .args(["-std=c99", "-Wall", "-Wextra", "-Werror", "-O2", "-shared", "-fPIC"])
        .arg("-ffp-contract=off")
        .args(definitions)
        .arg("-I")
        .arg(&here)
        .arg(source)
        .args(["-lm", "-o"])
        .arg(&library)
        .output()
        .unwrap();
    assert!(made.status.success(), "{}", String::from_utf8_lossy(&made.stderr));
    (directory, library)
}

fn ensemble(rules: Vec<&'static GainRule>, family: Family, cases: u64) -> Ensemble {
    Ensemble {
        seed: 5,
        cases,
        kind: DrawOptions::ORDINARY,
        approach: Approach::Profiled,
        moves: 0,
        families: vec![family],
        rules,
    }
}

fn rows(ensemble: &Ensemble) -> Result<Vec<CaseResult>, files::Error> {
    let rows = Mutex::new(Vec::new());
    run(
        ensemble,
        &Silent,
        |_, _, _| true,
        |row| {
            rows.lock().unwrap().push(row);
            Ok(())
        },
    )?;
    let mut rows = rows.into_inner().unwrap();
    sort_rows(&EnsembleHeader::of(ensemble), &mut rows);
    Ok(rows)
}

/// The built-in law is the second opinion: PD with the gains that the rule book gives.
#[test]
fn pd_as_a_guest_moves_each_joint_as_the_built_in_pd_does() {
    let (_directory, library) = compiled("example/pd_with_friction.c", &["-DPD_ALONE"]);
    let guest = register(open(&library).unwrap()).unwrap();
    let pd = rules(&["pd".into()]).unwrap()[0];
    let joints = ensemble(vec![pd, guest], Family::Rigid, 20);
    let rows = rows(&joints).unwrap();
    let (built_in, guests) = rows.split_at(20);
    let [mut tripped, mut close] = [0; 2];
    for (one, other) in built_in.iter().zip(guests) {
        assert_eq!((one.law.as_str(), other.law.as_str()), ("pd", "pd-with-friction"));
        // The rule rounds to four digits, and PD adds in single precision: a few codes differ.
        close += u32::from((one.rest_counts - other.rest_counts).abs() < 2.0);
        tripped += u32::from(one.step_fault != other.step_fault);
        let [a, b] = [one, other].map(|row| row.tracking_rms.unwrap());
        assert!((a - b).abs() < 0.01 * a, "{a} {b}");
    }
    assert!(close >= 18 && tripped == 0, "{close} {tripped}");
    let header = EnsembleHeader::of(&joints);
    assert_eq!(header.guests.get("pd-with-friction").map(String::as_str), Some("1"));
    assert_eq!(header.laws, ["pd", "pd-with-friction"]);
}

#[test]
fn a_guest_s_rows_depend_on_the_seed_alone_and_arms_have_two_controllers() {
    let (_directory, library) = compiled("example/pd_with_friction.c", &[]);
    let law = open(&library).unwrap();
    let guest = register(law).unwrap();
    for (family, cases) in [(Family::Rigid, 6), (Family::Arm, 2)] {
        let joints = ensemble(vec![guest], family, cases);
        let first = rows(&joints).unwrap();
        assert_eq!(first, rows(&joints).unwrap());
        assert_eq!(first.len() as u64, cases);
        // It is no PD: its friction compensation brings the joints nearer.
        assert!(first.iter().all(|row| row.step_fault.is_none() && row.rest_counts < 40.0));
    }
}

/// The facts of a joint in SI are those of its draw: the nominal joint of the family.
#[test]
fn a_guest_sees_the_nominal_joint_in_si() {
    struct Facts(Mutex<Vec<JointFacts>>);
    impl GuestLaw for Facts {
        fn name(&self) -> &'static str {
            "facts"
        }
        fn version(&self) -> &'static str {
            "0"
        }
        fn start(
            &self,
            joint: &JointFacts,
        ) -> Result<Box<dyn simulator::guest::Controller>, String> {
            self.0.lock().unwrap().push(*joint);
            Err("it only looks".into())
        }
    }
    let facts = std::sync::Arc::new(Facts(Mutex::new(Vec::new())));
    let guest = register(facts.clone()).unwrap();
    let error = rows(&ensemble(vec![guest], Family::Rigid, 1)).unwrap_err().to_string();
    assert_eq!(error, "the law `facts`: it only looks");
    let joint = facts.0.lock().unwrap()[0];
    // 60 N m in steps of 0.06; 0.34 kg m^2 and 1.3 N m s/rad (drawn_case.rs), in volts of 12 N m.
    let per_volt = 60.0 / joint.largest_effort;
    let close = |a: f64, b: f64| assert!((a - b).abs() < 1e-4 * b, "{a} {b}");
    close(per_volt * joint.inertia, 0.34);
    close(per_volt * joint.viscous, 1.3);
    close(per_volt * joint.effort_step, 0.06);
    close(joint.sample_time, 1e-3);
    let turn = std::f64::consts::TAU / joint.count;
    assert!((turn - 1e5).abs() < 1.0 || (turn - 1e4).abs() < 0.1, "{turn}");
    assert!(joint.breakaway_low < joint.breakaway_high && !joint.encoder_at_load);
}

#[test]
fn what_is_no_law_is_refused_with_its_reason() {
    let refused = |source: &str, definitions: &[&str]| {
        let (_directory, library) = compiled(source, definitions);
        open(&library).map(|_| ()).unwrap_err().to_string()
    };
    let error = refused("example/pd_with_friction.c", &["-DSTICTION_LAW_ABI_OF_TEST=7"]);
    assert!(error.ends_with("its functions are of version 7; must be 2"), "{error}");
    let error = refused("example/pd_with_friction.c", &["-Dstiction_law_tick=another"]);
    assert!(error.contains("it has no function `stiction_law_tick`"), "{error}");
    let missing = open(std::path::Path::new("none.so")).map(|_| ()).unwrap_err().to_string();
    assert!(missing.starts_with("--law none.so: "), "{missing}");
    // A built-in name.
    struct Pid;
    impl GuestLaw for Pid {
        fn name(&self) -> &'static str {
            "pid"
        }
        fn version(&self) -> &'static str {
            "0"
        }
        fn start(&self, _: &JointFacts) -> Result<Box<dyn simulator::guest::Controller>, String> {
            Err(String::new())
        }
    }
    let error = register(std::sync::Arc::new(Pid)).map(|_| ()).unwrap_err().to_string();
    assert!(error.contains("`pid` is the name of a built-in law"), "{error}");
}

/// A law whose source asserts that C has each field where Rust has it, and that has a following
/// error of its own: the angle of a count.
#[test]
fn c_has_joint_and_sample_as_rust_has_them_and_states_its_following_error() {
    macro_rules! offsets {
        ($Type:ident as $c:literal: $($field:ident),+) => {
            [$(format!(
                "_Static_assert(offsetof({}, {}) == {}, \"\");\n",
                $c, stringify!($field), offset_of!($Type, $field)
            )),+, format!("_Static_assert(sizeof({}) == {}, \"\");\n", $c, size_of::<$Type>())]
            .concat()
        };
    }
    let joint = offsets!(JointFacts as "StictionLawJoint":
        sample_time, count, largest_effort, effort_step, inertia, viscous, breakaway_low,
        breakaway_high, load, hold_effort, jitter, encoder_at_load);
    let sample = offsets!(Sample as "StictionLawSample":
        counts, saturated, target_counts, error, velocity, target_velocity, target_acceleration,
        applied);
    let own = "double stiction_law_following_error(const StictionLawJoint *joint) {\n\
               return joint->count;\n}\n";
    let example = include_str!("../example/pd_with_friction.c");
    let directory = tempfile::tempdir().unwrap();
    let source = directory.path().join("law.c");
    let text = format!("#include <stddef.h>\n{example}{joint}{sample}{own}");
    std::fs::write(&source, text).unwrap();
    let (_directory, library) = compile(&source, &["-std=c11"], directory);
    let law = open(&library).unwrap();
    let facts = JointFacts {
        sample_time: 1e-3,
        count: 6e-5,
        largest_effort: 16.0,
        effort_step: 0.016,
        inertia: 0.12,
        viscous: 0.9,
        breakaway_low: 0.9,
        breakaway_high: 3.0,
        load: 0.0,
        hold_effort: 0.0,
        jitter: 0.0,
        encoder_at_load: true,
    };
    assert_eq!(law.following_error(&facts), 6e-5);
    let (_directory, without) = compiled("example/pd_with_friction.c", &[]);
    assert_eq!(open(&without).unwrap().following_error(&facts), 0.0);
}
