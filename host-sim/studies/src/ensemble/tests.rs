//! Tests of whole ensembles: cases with a known result, and reports that depend on the seed only.

use std::path::Path;
use std::sync::Mutex;

use stiction::control::laws::Gains;
use stiction::control::laws::robust::EncoderSide;

use super::case;
use super::case_result::CaseResult;
use super::drawn_case::{Case, DrawOptions};
use super::family::Family;
use super::machine_file::{MachineEnsemble, MachineOptions};
use super::motions::{Approach, Motions};
use super::rows::{self, EnsembleHeader, ResumeFile, Shard};
use super::run::{Ensemble, run};
use super::{json, summary};
use dynamics::joint::{Body, Description, Train};
use simulator::output::{OutputFile, OverwriteGuard};
use simulator::progress::Silent;
use simulator::rules::{GainRule, rules};

const EASY: DrawOptions = DrawOptions::ORDINARY;

const STEPPED: Motions = Motions { approach: Approach::Step, seed: 1, moves: 0 };

fn output(path: &Path) -> OutputFile {
    OverwriteGuard::default().results("--resume", path).unwrap()
}

fn rule(law: &str) -> &'static GainRule {
    rules(&[law.into()]).unwrap()[0]
}

fn ran(case: &Case, law: &str) -> CaseResult {
    let rule = rule(law);
    case::run(case, law, &case.gains(rule), STEPPED).unwrap()
}

/// Returns a rigid joint whose Coulomb and stick friction are `friction`, N m, with a step of
/// `step`, rad. It has no load, lag or delay and starts on a count.
fn joint(friction: f64, step: f64) -> Case {
    let mut case = Case::draw(1, Family::Rigid, 0, EASY);
    let Train::Rigid(mut body) = case.joint.train else { panic!("{case:?}") };
    let curve = &mut body.friction.curve;
    (curve.coulomb, curve.stick) = (friction, friction);
    body.inertia = 0.34;
    case.joint = Description { lag_s: 0.0, start: 0.0, train: Train::Rigid(body), ..case.joint };
    case.delay = simulator::plant::Delay::None;
    case.step = step;
    case
}

#[test]
fn pd_stops_short_by_the_whole_step_while_its_effort_is_less_than_the_friction() {
    // Kp = J w^2 = 0.34 (2 pi 8)^2 = 859 N m/rad: 10 N m hold against a step of 11.6 mrad.
    let kp = 0.34 * (std::f64::consts::TAU * 8.0).powi(2);
    let case = joint(10.0, 0.99 * 10.0 / kp);
    let row = ran(&case, "pd");
    assert!((row.rest_counts - case.step / case.count()).abs() < 1e-3, "{row:?}");
    assert_eq!((row.settled_s, row.reversals), (None, 0));
    assert!((row.held_effort / 9.9 - 1.0).abs() < 0.01, "{row:?}");
    assert!(!row.is_success(5.0) && row.faults().next().is_none(), "{row:?}");
    // A little more, and it moves.
    let case = joint(10.0, 1.02 * 10.0 / kp);
    assert!(ran(&case, "pd").rest_counts < 0.99 * case.step / case.count());
}

#[test]
fn pd_settles_a_joint_with_hardly_any_friction_as_its_poles_say() {
    // The effort within which it rests is 2 counts of 859 N m/rad: 0.1 N m.
    let case = joint(1e-3, 0.02);
    let row = ran(&case, "pd");
    // Poles at w (-0.9 +- 0.44 i), w = 50.3/s: 318 counts fall to 2 in ln(159)/45 = 0.112 s, twice
    // that with the phase that 3 ms of velocity window cost.
    let settled_s = row.settled_s.unwrap();
    assert!((0.05..0.25).contains(&settled_s), "{row:?}");
    assert!(row.rest_counts < 1.0 && row.is_success(5.0) && row.reversals == 0, "{row:?}");
    assert!(!row.is_success(0.9 * settled_s));
    // Without friction PD trails by B v/Kp = 1.3 * 0.5/859 rad: 0.76 mrad on the way, and by
    // nothing while it rests half a second of 2.75 s.
    let trail = row.tracking_rms.unwrap() * 1e3;
    assert!((0.2..1.5).contains(&trail), "{row:?}");
}

#[test]
fn a_monitor_that_trips_is_no_success_and_is_counted() {
    // Friction like a brake that never opens: SRNF commands more than should start the joint.
    let mut case = joint(1.0, 0.02);
    let Train::Rigid(Body { friction, .. }) = &mut case.joint.train else { panic!() };
    (friction.curve.coulomb, friction.curve.stick) = (100.0, 100.0);
    let row = ran(&case, "srnf");
    assert!(row.step_fault.as_deref().is_some_and(|fault| fault.contains("stall")), "{row:?}");
    assert!(!row.is_success(5.0) && row.tracking_rms.is_none(), "{row:?}");
    assert!((row.rest_counts - 0.02 / case.count()).abs() < 1.0, "{row:?}");
}

/// 0.5 rad at 60 N m and 0.34 kg m^2: a step reaches some 9 rad/s, and the monitor of PD's Kd (29.5
/// N m s/rad) trips at 2.5 x 60/29.5 = 5.1 rad/s. A profile stays within half of 3 rad/s.
#[test]
fn a_profiled_move_stays_below_the_speed_at_which_a_step_trips() {
    let case = joint(1.0, 0.5);
    let under = |law: &str, approach: Approach| {
        let motions = Motions { approach, ..STEPPED };
        case::run(&case, law, &case.gains(rule(law)), motions).unwrap()
    };
    for law in ["pd", "srnf", "pid", "feedforward+observer"] {
        let stepped = under(law, Approach::Step);
        assert_eq!(stepped.step_fault.as_deref(), Some("overspeed"), "{stepped:?}");
        let profiled = under(law, Approach::Profiled);
        assert_eq!(profiled.step_fault, None, "{profiled:?}");
        // 0.5 rad at 1.5 rad/s take 0.33 s, and 1.5 rad/s at 22 rad/s^2 0.07 s more, with an
        // average over 0.1 s.
        let rests_s = profiled.set_point_rests_s;
        assert!((0.4..0.6).contains(&rests_s) && stepped.set_point_rests_s == 0.0, "{profiled:?}");
        assert!(profiled.settled_s.is_none_or(|settled_s| settled_s >= rests_s), "{profiled:?}");
    }
    assert!(under("pid", Approach::Profiled).is_success(5.0));
}

#[test]
fn no_overhauled_joint_spins_away_without_a_fault() {
    for number in 0..12 {
        let case = Case::draw(3, Family::Overhauling, number, EASY);
        for law in ["pd", "roi", "srnf", "dnpf"] {
            let row = ran(&case, law);
            // PD holds a load within (F + load)/Kp: 48 N m are 890 counts of 1e5 a turn.
            assert!(row.step_fault.is_some() || row.rest_counts < 1000.0, "{row:?}");
        }
    }
}

/// With the encoder on the load, a fast observer feeds a load that swings behind its transmission.
/// So the observer is slower there while the joint moves, unless its bandwidth is set.
#[test]
fn loads_swing_less_on_their_way_under_the_observer_of_their_side_than_under_the_motors() {
    let tracked = |observer: f32| {
        let mut rms: Vec<f64> = (0..30)
            .map(|number| {
                let case = Case::draw(11, Family::FlexibleLoad, number, EASY);
                let mut gains = case.gains(rule("robust"));
                for law in gains.iter_mut().flat_map(|gains| &mut gains.laws) {
                    let Gains::Robust(gains) = law else { panic!("{law:?}") };
                    assert_eq!(gains.encoder_side, EncoderSide::Load);
                    gains.observer = observer;
                }
                let row = case::run(&case, "robust", &gains, STEPPED).unwrap();
                // A joint that trips counts as not tracking.
                row.tracking_rms.unwrap_or(f64::INFINITY)
            })
            .collect();
        rms.sort_by(f64::total_cmp);
        rms
    };
    let (own, motors) = (tracked(0.0), tracked(110.0));
    // On other joints the 90 % quantiles are 29 and 334 mrad; here a third of the joints with the
    // motor's bandwidth trip.
    assert!(own[26] < 0.05 && own[29].is_finite(), "{own:?}");
    assert!(motors[26] > 0.2, "{motors:?}");
    // The price: a fifth of the joints, whose loads do not swing, are tracked less closely.
    assert!(motors[5] < 0.5 * own[5], "{own:?} {motors:?}");
}

/// In a slow loop a pulse is planned with the friction that was learned in motion. If it is learned
/// at full speed, it contains the error of the viscous friction, and a loose joint goes to and fro.
/// These are the thirteen of 500 joints that miss moves if friction is learned up to 9.64 deg/s.
#[test]
fn loose_joints_of_a_slow_loop_miss_no_move_with_friction_that_is_learned_at_low_speed() {
    for number in [83, 95, 126, 132, 165, 215, 231, 265, 315, 411, 414, 431, 452] {
        let missed = |learned_to: f32| {
            let case = Case::draw(11, Family::ThesisAxis, number, EASY);
            let mut gains = case.gains(rule("robust"));
            for law in gains.iter_mut().flat_map(|gains| &mut gains.laws) {
                let Gains::Robust(gains) = law else { panic!("{law:?}") };
                // Not rounded, as when the thirteen were found: others miss under a fifth digit.
                gains.inertia = case.bounds.inertia as f32;
                gains.learned_to = learned_to;
            }
            case::run(&case, "robust", &gains, Motions { seed: 11, moves: 200, ..STEPPED })
                .unwrap()
                .missed
        };
        assert!(missed(9.64) > 0, "joint {number}");
        assert_eq!(missed(0.0), 0, "joint {number}");
    }
}

fn small(laws: &[&str]) -> Ensemble {
    Ensemble {
        seed: 5,
        cases: 5,
        kind: EASY,
        approach: Approach::Step,
        moves: 2,
        families: vec![Family::ThesisAxis, Family::Rigid],
        rules: laws.iter().map(|law| rule(law)).collect(),
    }
}

fn collect(ensemble: &Ensemble, wanted: impl Fn(u64) -> bool + Sync) -> Vec<CaseResult> {
    let rows = Mutex::new(Vec::new());
    run(
        ensemble,
        &Silent,
        |_, case, _| wanted(case),
        |row| {
            rows.lock().unwrap().push(row);
            Ok(())
        },
    )
    .unwrap();
    let mut rows = rows.into_inner().unwrap();
    rows::sort(&EnsembleHeader::of(ensemble), &mut rows);
    rows
}

fn report(header: &EnsembleHeader, rows: &[CaseResult]) -> String {
    json::object(header, &summary::summaries(header, rows)).to_string()
}

#[test]
fn rows_do_not_depend_on_the_number_of_threads_nor_a_law_on_the_others() {
    let ensemble = small(&["pd", "roi"]);
    let on = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| collect(&ensemble, |_| true))
    };
    let alone = on(1);
    assert_eq!(alone.len(), 20);
    assert_eq!(alone, on(3));
    let of_roi: Vec<CaseResult> = alone.iter().filter(|row| row.law == "roi").cloned().collect();
    assert_eq!(of_roi, collect(&small(&["roi"]), |_| true));
}

#[test]
fn shards_put_together_are_the_whole_to_the_bit_also_through_their_files() {
    let ensemble = small(&["pd", "srnf"]);
    let header = EnsembleHeader::of(&ensemble);
    let whole = collect(&ensemble, |_| true);
    let shards: Vec<Vec<CaseResult>> = (1..=3)
        .map(|k| Shard::read(&format!("{k}/3")).unwrap())
        .map(|shard| collect(&ensemble, |case| shard.has(case)))
        .collect();
    assert!(shards.iter().all(|rows| !rows.is_empty() && rows.len() < whole.len()));
    let directory = tempfile::tempdir().unwrap();
    let files: Vec<(String, EnsembleHeader, Vec<CaseResult>)> = shards
        .iter()
        .enumerate()
        .map(|(k, rows)| {
            let path = directory.path().join(format!("{k}.csv"));
            std::fs::write(&path, rows::render(&header, rows).unwrap()).unwrap();
            let (header, rows) = rows::read(&path).unwrap();
            (path.display().to_string(), header, rows)
        })
        .collect();
    let (found, merged) = rows::merge(&files).unwrap();
    assert_eq!((&found, &merged), (&header, &whole));
    assert_eq!(report(&found, &merged), report(&header, &whole));
    assert_eq!(rows::render(&found, &merged).unwrap(), rows::render(&header, &whole).unwrap());

    let refusal = |files: &[(String, EnsembleHeader, Vec<CaseResult>)]| {
        rows::merge(files).unwrap_err().to_string()
    };
    let missing = refusal(&files[..2]);
    assert!(missing.contains("of 20 rows are there; the first that is missing is"), "{missing}");
    let mut other = files.clone();
    other[1].1.seed = 6;
    assert!(refusal(&other).contains("its `seed` is 6, not 5"), "{}", refusal(&other));
    let mut released = files.clone();
    released[1].1.commit = Some("a1".into());
    let refused = refusal(&released);
    assert!(refused.contains("its `commit` is \"a1\", not none"), "{refused}");
    let mut changed = files.clone();
    changed.push((
        "again".into(),
        header,
        vec![CaseResult { rest_counts: 0.1, ..whole[0].clone() }],
    ));
    assert!(refusal(&changed).contains("with other values"), "{}", refusal(&changed));
}

#[test]
fn a_run_that_was_cut_off_goes_on_from_its_file() {
    let ensemble = small(&["pd"]);
    let header = EnsembleHeader::of(&ensemble);
    let whole = collect(&ensemble, |_| true);
    let directory = tempfile::tempdir().unwrap();
    let path = directory.path().join("rows.csv");
    let (mut kept, there) = ResumeFile::open(&output(&path), &header).unwrap();
    assert!(there.is_empty());
    whole[..4].iter().for_each(|row| kept.add(row).unwrap());
    drop(kept);
    // In the middle of a line.
    let mut text = std::fs::read_to_string(&path).unwrap();
    text.truncate(text.len() - 9);
    std::fs::write(&path, &text).unwrap();
    let (mut kept, there) = ResumeFile::open(&output(&path), &header).unwrap();
    assert_eq!(there, whole[..3]);
    whole[3..].iter().for_each(|row| kept.add(row).unwrap());
    assert_eq!(rows::read(&path).unwrap(), (header.clone(), whole));
    let other = EnsembleHeader { cases: 6, ..header };
    let refusal = ResumeFile::open(&output(&path), &other).unwrap_err().to_string();
    assert!(refusal.contains("its `cases` is 5, not 6"), "{refusal}");
    std::fs::write(&path, "time_s,error_deg\n").unwrap();
    let refusal = ResumeFile::open(&output(&path), &other).unwrap_err().to_string();
    assert!(refusal.contains("these are no rows of an ensemble"), "{refusal}");
}

#[test]
fn the_object_has_the_keys_that_are_promised() {
    let ensemble = small(&["pd"]);
    let header = EnsembleHeader::of(&ensemble);
    let rows = collect(&ensemble, |_| true);
    let object = json::object(&header, &summary::summaries(&header, &rows));
    assert_eq!((&object["schema"], &object["seed"]), (&1.into(), &5.into()));
    let of = |key: &str| object["families"]["rigid"]["pd"][key].clone();
    assert_eq!(object["families"]["thesis-axis"]["unit"], "deg");
    assert_eq!(object["families"]["rigid"]["unit"], "rad");
    assert_eq!(of("cases"), 5);
    for (key, inner) in [
        ("settling_s", &["p50", "p95", "max"][..]),
        ("rest_counts", &["p50", "p90", "max"]),
        ("hunting_counts", &["p50", "max"]),
        ("tracking_rms", &["p50", "p90", "max"]),
        ("sticks_in_motion", &["p50", "max"]),
        ("settled_at_encoder_s", &["p50", "p95", "max"]),
        ("settled_at_load_s", &["p50", "p95", "max"]),
        ("rest_at_encoder_counts", &["p50", "p90", "max"]),
        ("rest_at_load_counts", &["p50", "p90", "max"]),
    ] {
        let found: Vec<String> = of(key).as_object().unwrap().keys().cloned().collect();
        let mut expected: Vec<&str> = inner.to_vec();
        expected.sort_unstable();
        let mut found: Vec<&str> = found.iter().map(String::as_str).collect();
        found.sort_unstable();
        assert_eq!(found, expected, "{key}");
    }
    // One inertia has the same result at both sides.
    for side in ["encoder", "load"] {
        assert_eq!(of(&format!("success_at_{side}")), of("success"));
        assert_eq!(of(&format!("successes_at_{side}")), of("successes"));
        assert_eq!(of(&format!("success_at_{side}_ci")), of("success_ci"));
    }
    assert!(of("trips").is_array());
    for key in ["success", "hunting_cases", "false_trips", "total_variation_rest_per_s"] {
        assert!(of(key).is_number(), "{key}");
    }
    assert!(of("total_variation_motion_per_s").as_f64().unwrap() > 0.0);
    assert_eq!(of("success_ci").as_array().unwrap().len(), 2);
    let share = of("successes").as_f64().unwrap() / of("cases").as_f64().unwrap();
    assert_eq!(of("success").as_f64(), Some(share));
    assert_eq!(of("worst").as_array().unwrap().len(), 5);
    // A row of two moves: one is a tenth, rounded up.
    assert_eq!(of("moves")["first"]["moves"], 5);
}

#[test]
fn an_ensemble_around_a_file_goes_on_and_is_merged_to_the_bit() {
    let laws = ["pd", "srnf"].map(str::to_owned);
    let spreads = ["joint.friction.slip_v=0.30..0.39".to_owned()];
    let around = MachineOptions {
        controllers: &laws,
        spreads: &spreads,
        rate_hz: Some(100.0),
        ..MachineOptions::default()
    };
    let machine = MachineEnsemble::open("step-response", around).unwrap();
    assert!((machine.rate_hz() - 100.0).abs() < 1e-9);
    let header = EnsembleHeader::of_machine(&machine, 1, 5);
    let collect = |wanted: &(dyn Fn(u64, &str) -> bool + Sync)| {
        let rows = Mutex::new(Vec::new());
        machine
            .run_some([1, 5], wanted, |row| {
                rows.lock().unwrap().push(row);
                Ok(())
            })
            .unwrap();
        let mut rows = rows.into_inner().unwrap();
        rows::sort(&header, &mut rows);
        rows
    };
    let whole = collect(&|_, _| true);
    assert_eq!(whole.len(), 10);
    let directory = tempfile::tempdir().unwrap();
    let shards = [1, 2].map(|k| {
        let shard = Shard::read(&format!("{k}/2")).unwrap();
        let path = directory.path().join(format!("{k}.csv"));
        let rows = collect(&|case, _| shard.has(case));
        std::fs::write(&path, rows::render(&header, &rows).unwrap()).unwrap();
        let (header, rows) = rows::read(&path).unwrap();
        (path.display().to_string(), header, rows)
    });
    let (found, merged) = rows::merge(&shards).unwrap();
    assert_eq!((&found, &merged), (&header, &whole));
    assert_eq!(report(&found, &merged), report(&header, &whole));
    // Existing rows are not run again, and a file of another spread is refused.
    let (mut kept, there) =
        ResumeFile::open(&output(&directory.path().join("1.csv")), &header).unwrap();
    let had = |case: u64, law: &str| there.iter().any(|row| row.case == case && row.law == law);
    let rest = collect(&|case, law| !had(case, law));
    assert_eq!(rest.len() + there.len(), 10);
    rest.iter().for_each(|row| kept.add(row).unwrap());
    let (_, mut all) = rows::read(&directory.path().join("1.csv")).unwrap();
    rows::sort(&header, &mut all);
    assert_eq!(all, whole);
    let other = ["joint.friction.slip_v=0.30..0.38".to_owned()];
    for around in
        [MachineOptions { spreads: &other, ..around }, MachineOptions { rate_hz: None, ..around }]
    {
        let machine = MachineEnsemble::open("step-response", around).unwrap();
        let other = EnsembleHeader {
            rate_hz: header.rate_hz,
            ..EnsembleHeader::of_machine(&machine, 1, 5)
        };
        let refusal = ResumeFile::open(&output(&directory.path().join("1.csv")), &other)
            .unwrap_err()
            .to_string();
        assert!(refusal.contains("rate or spread is another one"), "{refusal}");
    }
}
