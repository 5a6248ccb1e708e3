//! Verdicts at the encoder and at the load, and false trips by name.

use super::case;
use super::case_result::CaseResult;
use super::drawn_case::{Case, DrawOptions, GEAR_BACKLASH_DEG};
use super::family::Family;
use super::machine_file::{MachineEnsemble, MachineOptions};
use super::motions::{Approach, Motions};
use super::rows::{self, EnsembleHeader};
use super::run::Ensemble;
use super::{json, markdown, summary, table};
use dynamics::joint::Train;
use files::goal::PositionGoal;
use simulator::experiment::Document;
use simulator::rules::rules;

const EASY: DrawOptions = DrawOptions::ORDINARY;

const STEPPED: Motions = Motions { approach: Approach::Step, seed: 1, moves: 0 };

const GEAR: &str = include_str!("../../../tests/joints_under_test/gear_with_backlash.toml");

fn backlash(case: &Case) -> f64 {
    let Train::Flexible { shaft, .. } = &case.joint.train else { panic!("{case:?}") };
    shaft.backlash
}

fn ran(case: &Case, law: &str) -> CaseResult {
    let rule = rules(&[law.into()]).unwrap()[0];
    case::run(case, law, &case.gains(rule), STEPPED).unwrap()
}

#[test]
fn gear_backlash_is_drawn_log_uniform_within_a_tenth_of_a_degree_and_one() {
    const CASES: u64 = 4000;
    let drawn: Vec<f64> = (0..CASES)
        .map(|number| Case::draw(1, Family::GearBacklash, number, EASY))
        .map(|case| backlash(&case).to_degrees())
        .collect();
    let [least, most] = GEAR_BACKLASH_DEG;
    let ends = [
        drawn.iter().copied().fold(f64::INFINITY, f64::min),
        drawn.iter().copied().fold(0.0, f64::max),
    ];
    assert!(least - 1e-12 <= ends[0] && ends[0] < 1.01 * least, "{ends:?}");
    assert!(ends[1] <= most + 1e-12 && ends[1] > 0.99 * most, "{ends:?}");
    // Half of the logarithms are below the middle, within five standard errors.
    let middle = (least * most).sqrt();
    let below = drawn.iter().filter(|deg| **deg < middle).count() as f64 / CASES as f64;
    assert!((below - 0.5).abs() < 2.5 / (CASES as f64).sqrt(), "{below}");
    // The limit of `flexible-backlash` is still twenty counts.
    for number in 0..200 {
        let case = Case::draw(1, Family::FlexibleBacklash, number, EASY);
        assert!(backlash(&case) <= 20.0 * case.count());
    }
}

/// The load is off by at most the backlash and the wind-up of the shaft under the load's friction.
#[test]
fn behind_a_real_gear_the_encoder_succeeds_and_the_load_is_off_by_up_to_the_backlash() {
    let mut off = 0;
    for number in 0..8 {
        let case = Case::draw(2, Family::GearBacklash, number, EASY);
        let Train::Flexible { load, shaft, .. } = &case.joint.train else { panic!("{case:?}") };
        let wind_up = load.friction.curve.stick / shaft.stiffness;
        let most = (shaft.backlash + wind_up) / case.count() + 2.0;
        let row = ran(&case, "robust");
        assert!(row.success_at_encoder && row.is_success(5.0), "{row:?}");
        assert!(row.rest_at_encoder_counts <= 2.0, "{row:?}");
        assert!(row.rest_at_load_counts <= most, "{most}: {row:?}");
        assert_eq!(row.load_rest_counts, Some(row.rest_at_load_counts));
        assert_eq!(row.success_at_load, row.settled_at_load_s.is_some_and(|s| s <= 5.0), "{row:?}");
        off += u32::from(!row.success_at_load);
    }
    assert!(off >= 4, "{off} of 8 loads are off");
}

#[test]
fn one_inertia_has_the_same_verdict_at_both_sides() {
    for (family, law) in [(Family::Rigid, "pd"), (Family::LuGre, "robust"), (Family::Arm, "pd")] {
        let row = ran(&Case::draw(2, family, 1, EASY), law);
        assert_eq!(row.success_at_encoder, row.is_success(5.0), "{row:?}");
        assert_eq!(row.success_at_load, row.success_at_encoder, "{row:?}");
        assert_eq!([row.settled_at_encoder_s, row.settled_at_load_s], [row.settled_s; 2]);
        assert_eq!([row.rest_at_encoder_counts, row.rest_at_load_counts], [row.rest_counts; 2]);
        assert_eq!([row.tracking_at_encoder_rms, row.tracking_at_load_rms], [row.tracking_rms; 2]);
    }
}

fn around_the_gear(set: &[&str]) -> (EnsembleHeader, Vec<CaseResult>) {
    let mut document = Document::parse("gear.toml", GEAR).unwrap();
    // Enough for friction and unbalance together, whatever is derived.
    let all = set.iter().copied().chain(["limits.breakaway_v=2.5"]);
    document.set(&all.map(str::to_owned).collect::<Vec<_>>()).unwrap();
    let controllers = ["robust".to_owned()];
    let around = MachineOptions { controllers: &controllers, ..MachineOptions::default() };
    let machine = MachineEnsemble::around("gear.toml", document, around, 15.0).unwrap();
    (EnsembleHeader::of_machine(&machine, 1, 1), machine.run(1, 1).unwrap())
}

/// 0.6 deg of backlash are 171 counts: the encoder is within two, the load is not.
#[test]
fn a_file_s_joint_is_judged_at_both_sides_and_its_success_is_the_load_s() {
    let (header, rows) = around_the_gear(&[]);
    let row = &rows[0];
    assert!(row.success_at_encoder && !row.success_at_load && !row.is_success(5.0), "{row:?}");
    assert!(row.rest_at_encoder_counts <= 2.0 && row.rest_counts > 20.0, "{row:?}");
    assert_eq!((row.settled_s, row.rest_counts), (None, row.rest_at_load_counts));
    let families = summary::summaries(&header, &rows);
    let text = table::render(&header, &families);
    assert!(text.contains("at the\nencoder") || text.contains("at the load"), "{text}");
    let object = json::object(&header, &families);
    let law = &object["families"]["gear"]["robust"];
    assert_eq!(
        (law["success_at_encoder"].as_f64(), law["success_at_load"].as_f64()),
        (Some(1.0), Some(0.0))
    );
    assert_eq!(law["success"], law["success_at_load"]);
    let counts = object["unseen_slack"]["gear"]["backlash_counts"].as_f64().unwrap();
    assert!((counts - 0.6 / (360.0 / 102_400.0)).abs() < 0.01, "{counts}");
}

/// The load of the law `chance` is at its target by chance: the law misses at the encoder.
#[test]
fn laws_on_a_file_whose_encoder_cannot_see_slack_are_ranked_at_the_encoder() {
    let (mut header, rows) = around_the_gear(&[]);
    let chance = CaseResult {
        law: "chance".into(),
        success_at_encoder: false,
        settled_at_encoder_s: None,
        success_at_load: true,
        settled_at_load_s: Some(0.5),
        settled_s: Some(0.5),
        ..rows[0].clone()
    };
    header.laws = ["chance", "robust"].map(str::to_owned).into();
    let rows = [chance, rows[0].clone()];
    let first = |header: &EnsembleHeader| {
        let text = table::render(header, &summary::summaries(header, &rows));
        let laws = text.lines().filter_map(|line| line.split_whitespace().next());
        laws.into_iter().find(|one| ["chance", "robust"].contains(one)).unwrap().to_owned()
    };
    assert_eq!(first(&header), "robust");
    header.families[0].unseen_slack = None;
    assert_eq!(first(&header), "chance");
}

#[test]
fn a_goal_of_the_file_decides_at_both_sides() {
    let (header, rows) = around_the_gear(&["goal.tolerance_deg=0.7"]);
    let row = &rows[0];
    assert!(row.success_at_encoder && row.success_at_load && row.is_success(5.0), "{row:?}");
    let goal = header.families[0].goal;
    let expected =
        PositionGoal { tolerance_deg: Some(0.7), settle_s: Some(5.0), ..PositionGoal::default() };
    assert_eq!(goal, expected);
    // A time that is too short for the soft start and the step.
    let (_, rows) = around_the_gear(&["goal.tolerance_deg=0.7", "goal.settle_s=0.1"]);
    assert!(!rows[0].success_at_encoder && !rows[0].success_at_load, "{:?}", rows[0]);
    // A settling time and a hold that the joint meets.
    let hold = ["goal.tolerance_deg=0.7", "goal.settle_s=2.0", "goal.hold_s=1.0"];
    let (_, rows) = around_the_gear(&hold);
    assert!(rows[0].success_at_encoder, "{:?}", rows[0]);
}

#[test]
fn reports_have_both_sides_where_they_differ_and_name_each_false_trip() {
    let header = EnsembleHeader::of(&Ensemble {
        seed: 5,
        cases: 2,
        kind: EASY,
        approach: Approach::Step,
        moves: 0,
        families: vec![Family::GearBacklash, Family::Rigid],
        rules: rules(&["pd".into()]).unwrap(),
    });
    let row = |family: Family, case: u64| CaseResult {
        family: family.name().into(),
        law: "pd".into(),
        case,
        settled_s: Some(0.5),
        settled_at_encoder_s: Some(0.5),
        success_at_encoder: true,
        rest_at_encoder_counts: 1.0,
        rest_at_load_counts: if family == Family::Rigid { 1.0 } else { 90.0 },
        settled_at_load_s: (family == Family::Rigid).then_some(0.5),
        success_at_load: family == Family::Rigid,
        tracking_fault: (family == Family::Rigid && case == 1).then(|| "overspeed".into()),
        ..CaseResult::default()
    };
    let all = [Family::GearBacklash, Family::Rigid];
    let rows: Vec<CaseResult> =
        all.iter().flat_map(|one| [0, 1].map(|case| row(*one, case))).collect();
    let families = summary::summaries(&header, &rows);
    let text = table::render(&header, &families);
    let [of_gear, of_rigid] = text.split("rigid: 2 joints").collect::<Vec<_>>()[..] else {
        panic!("{text}")
    };
    assert!(of_gear.contains("at the encoder") && of_gear.contains("load"), "{of_gear}");
    assert!(!of_rigid.contains("at the encoder"), "{of_rigid}");
    assert!(of_rigid.contains("overspeed (17) in joint 1, trajectory (seed 5)"), "{of_rigid}");
    let tables = text.lines().take_while(|line| !line.starts_with("All of it"));
    assert!(tables.into_iter().all(|line| line.chars().count() <= 100), "{text}");
    let page = markdown::markdown(&header, &families);
    assert!(page.contains("| `gear-backlash`, at the encoder | 100 (34-100) |"), "{page}");
    assert!(page.contains("| `gear-backlash`, at the load | 0.0 (0-66) |"), "{page}");
    assert!(page.contains("| `rigid` | 100 (34-100) |"), "{page}");
    let trips = &json::object(&header, &families)["families"]["rigid"]["pd"]["trips"];
    assert_eq!(
        *trips,
        serde_json::json!([{
            "case": 1, "seed": 5, "motion": "trajectory", "move": null, "fault": "overspeed",
            "code": 17,
        }])
    );
}

#[test]
fn both_sides_and_the_goal_are_read_back_to_the_bit() {
    let (header, found) = around_the_gear(&["goal.tolerance_deg=0.7"]);
    let directory = tempfile::tempdir().unwrap();
    let path = directory.path().join("rows.csv");
    std::fs::write(&path, rows::render(&header, &found).unwrap()).unwrap();
    assert_eq!(rows::read(&path).unwrap(), (header, found));
}
