//! What the studio predicts of a joint that a data sheet describes: pulled at, elastic, or with
//! other friction the other way. A second sheet that says the same is the reference.

use std::time::Duration;

use serde_json::{Value, json};
use simulator::draft::{Typical, text};

use super::RESOLUTION;
use super::page::{Page, arm, run, studio_around};
use super::what_if::{foretold, numbers, predicted, wish};

/// The data sheet of the thesis's axis with lines changed, and others at the end.
fn sheet(changed: &[(&str, &str)], more: &str) -> (tempfile::TempDir, &'static str) {
    let typical = Typical::find("thesis").unwrap();
    let mut sheet = text("joint.toml", &typical.answers().unwrap(), Some(&typical)).unwrap();
    for (line, other) in changed {
        assert!(sheet.contains(line), "{line}");
        sheet = sheet.replace(line, other);
    }
    let directory = tempfile::tempdir().unwrap();
    let file = directory.path().join("joint.toml");
    // Limits follow from the friction of a sheet, and a device that probes its encoder moves with
    // them. A slider leaves them as they are.
    let unprobed = "\n[limits]\nbreakaway_min_v = 1000.0\n";
    std::fs::write(&file, sheet + unprobed + more).unwrap();
    (directory, file.to_str().unwrap().to_owned().leak())
}

/// A constant torque, and a load that hangs at 30 deg.
const LOAD: (&str, &str) =
    ("[load]\n", "[load]\nconstant_nm = -30.0\nunbalance_nm = 60.0\nhangs_at_deg = 30.0\n");

/// A joint that hangs, is pulled at, and slides with less friction the faster it is.
#[test]
fn a_joint_that_a_load_pulls_at_does_what_was_predicted_count_by_count() {
    let stribeck = ("[friction]\n", "[friction]\nstribeck_rad_per_s = 0.05\n");
    let (_directory, machine) = sheet(&[LOAD, stribeck], "");
    foretold(|| studio_around(machine, "srnf", &[]), "srnf");
    // The same load, where the move begins: it stands as if it hung so much nearer.
    let held = |machine: &'static str, from: f64| {
        let effort = std::cell::Cell::new(0.0);
        run(async {
            let server = studio_around(machine, "pd", &[]);
            let mut page = Page::open(&server).await;
            let way = json!({ "how": "move", "deg": 2.0 });
            let mut asked = wish(&way, &["pd"], &json!({}), 0);
            asked["wish"]["from_deg"] = from.into();
            let curves = predicted(&mut page, "laws", asked).await;
            effort.set(*numbers(&curves[0], "effort_v").last().unwrap());
        });
        effort.get()
    };
    for from in [90.0, -90.0] {
        let hangs = format!("hangs_at_deg = {:?}", 30.0 - from);
        let load = LOAD.1.replace("hangs_at_deg = 30.0", &hangs);
        let (_directory, there) = sheet(&[(LOAD.0, &load), stribeck], "");
        let [begun, hung] = [held(machine, from), held(there, 0.0)];
        assert_eq!(begun, hung, "{from}");
    }
    // Another place is another effort: the load pulls by 90 N m the one way, 30 N m the other.
    let differ = held(machine, 120.0) - held(machine, -60.0);
    assert!((0.5..1.5).contains(&(differ / (120.0 / 540.0))), "{differ} V");
}

#[test]
fn if_its_load_moves_a_joint_without_effort_nothing_is_predicted_and_the_reason_is_reported() {
    // 400 N m at 90 deg, where 216 N m hold.
    let (_directory, machine) = sheet(&[("[load]\n", "[load]\nunbalance_nm = 400.0\n")], "");
    run(async {
        let server = studio_around(machine, "pd", &[]);
        let mut page = Page::open(&server).await;
        let way = json!({ "how": "move", "deg": 2.0 });
        for (from, falls) in [(0.0, false), (90.0, true)] {
            let mut asked = wish(&way, &["pd"], &json!({}), 0);
            asked["wish"]["from_deg"] = from.into();
            let curves = predicted(&mut page, "laws", asked).await;
            let why = curves[0]["refused"].as_str().unwrap_or_default();
            assert_eq!(why.starts_with("the load moves this joint"), falls, "{from}: {curves}");
            assert_eq!(curves[0]["position_deg"].is_null(), falls, "{from}");
        }
    });
}

/// The curve of a joint of a data sheet under PD.
fn of_a_sheet(changed: &[(&str, &str)], how: &str, values: &Value) -> Value {
    let (_directory, machine) = sheet(changed, "");
    let found = std::cell::RefCell::new(Value::Null);
    run(async {
        let server = studio_around(machine, "pd", &[]);
        let mut page = Page::open(&server).await;
        let way = json!({ "how": how, "deg": 5.0 });
        let mut curves = predicted(&mut page, "laws", wish(&way, &["pd"], values, 0)).await;
        found.replace(curves[0].take());
    });
    found.into_inner()
}

/// More friction the negative way.
const UNEVEN: (&str, &str) =
    ("[friction]\n", "[friction]\nstick_reverse_nm = 290.8\nslip_reverse_nm = 280.0\n");

/// A slider makes another joint of a data sheet's: the one whose sheet says so.
#[test]
fn a_slider_turns_what_is_elastic_or_pulled_at_as_another_data_sheet_would() {
    let bristles = (
        "[friction]\n",
        "[friction]\nbristle_stiffness_nm_per_rad = 4e5\n\
         bristle_damping_nm_s_per_rad = 3e4\nstribeck_rad_per_s = 0.05\n",
    );
    let shaft = ("# stiffness_nm_per_rad = 1e4 ", "stiffness_nm_per_rad = 4e5 # ");
    let rotor = ("rotor_inertia_kg_m2 = 0.0 ", "rotor_inertia_kg_m2 = 1e-4 ");
    let twice = ("rotor_inertia_kg_m2 = 0.0 ", "rotor_inertia_kg_m2 = 2e-4 ");
    let reverse = |stick: &str, slip: &str| {
        let levels = format!("[friction]\nstick_reverse_nm = {stick}\nslip_reverse_nm = {slip}\n");
        (UNEVEN.0, &*levels.leak())
    };
    let sticks = ("stick_nm = 216.0 ", "stick_nm = 432.0 ");
    let turned = [
        ("stick_nm = 216.0 ", "stick_nm = 270.0 "),
        ("slip_nm = 205.2 ", "slip_nm = 256.5 "),
        ("inertia_kg_m2 = 1145.9155902616465 ", "inertia_kg_m2 = 2291.831180523293 "),
        ("rad = 618.7944187412891 ", "rad = 928.1916281119337 "),
    ];
    let all = json!({
        "inertia": 2.0, "joint.friction.stick_v": 0.5, "joint.friction.slip_v": 0.475,
        "joint.viscous_v_per_deg_per_s": 0.03,
    });
    let stick_alone = json!({ "joint.friction.stick_v": 0.8 });
    for (name, before, after, turned, values) in [
        ("pulled at", vec![LOAD, UNEVEN], vec![LOAD, reverse("363.5", "350.0")], &turned[..], &all),
        // Both ways differ by what their slip levels differ by.
        ("stuck", vec![UNEVEN], vec![reverse("506.8", "280.0")], &[sticks], &stick_alone),
        ("on bristles", vec![bristles], vec![bristles], &turned, &all),
        ("on a shaft", vec![shaft, rotor], vec![shaft, twice], &turned, &all),
    ] {
        // Who breaks away from rest slowly shows the stick level.
        let how = if name == "stuck" { "move" } else { "step" };
        let position = |changed: &[(&str, &str)], values: &Value| {
            numbers(&of_a_sheet(changed, how, values), "position_deg")
        };
        let wanted = position(&[&after, turned].concat(), &json!({}));
        let [plain, found] = [&json!({}), values].map(|values| position(&before, values));
        assert_eq!(found.len(), wanted.len(), "{name}");
        let off = |one: &[f64]| {
            one.iter().zip(&wanted).map(|(is, to)| (is - to).abs()).fold(0.0, f64::max)
        };
        assert!(off(&found) <= 1.5 * RESOLUTION, "{name}: {} deg", off(&found));
        // As it was it goes elsewhere.
        assert!(off(&plain) > 4.0 * RESOLUTION, "{name}: {} deg", off(&plain));
    }
}

/// The spread of a data sheet is in its own keys, and all of them are drawn at once: a slip level
/// alone may be above the stick level of the file, as in one of a log without a Stribeck curve.
#[test]
fn the_cloud_of_a_data_sheet_is_drawn_from_its_own_keys_and_reported_as_simulated() {
    let spread = "\n[spread]\n\"friction.slip_nm\" = [200.0, 220.0]\n\
                  \"friction.stick_nm\" = [220.0, 240.0]\n\"load.constant_nm\" = [-40.0, -20.0]\n";
    let (_directory, machine) = sheet(&[LOAD, ("slip_nm = 205.2 ", "slip_nm = 216.0 ")], spread);
    let clouds = std::cell::RefCell::new(vec![]);
    run(async {
        let server = studio_around(machine, "pd", &[]);
        let mut page = Page::open(&server).await;
        let way = json!({ "how": "move", "deg": 5.0 });
        for values in [json!({}), json!({ "joint.friction.stick_v": 0.8, "inertia": 3.0 })] {
            let cloud = predicted(&mut page, "cloud", wish(&way, &["pd"], &values, 6)).await;
            clouds.borrow_mut().push(cloud);
        }
        // The file's spread does not keep a device from its motions.
        page.done(arm()).await;
        page.watch(Duration::from_millis(1000)).await;
        let trapezoid = [2.0, 5.0, 0.5, 0.2];
        page.done(json!({ "do": "trajectory", "trapezoid": trapezoid })).await;
    });
    for (cloud, [ratio, inertia]) in clouds.into_inner().iter().zip([[1.0, 1.0], [2.0, 3.0]]) {
        assert_eq!(cloud["is_written"], true, "{cloud}");
        let keys_of_worst = cloud["worst"]["joint"].as_array().unwrap();
        let value = |key: &str| -> f64 {
            let keys = keys_of_worst.iter().filter_map(|one| one.as_str()?.split_once('='));
            let value = keys.clone().find(|(name, _)| *name == key);
            value.unwrap_or_else(|| panic!("{key}: {keys_of_worst:?}")).1.parse().unwrap()
        };
        let [stick, slip, constant] =
            ["joint.friction.stick_v", "joint.friction.slip_v", "load.constant_nm"].map(value);
        let sticks = [220.0, 240.0].map(|nm| ratio * nm / 540.0);
        assert!((sticks[0]..=sticks[1]).contains(&stick), "{stick}: {sticks:?}");
        assert!((200.0 / 540.0..=220.0 / 540.0).contains(&slip), "{slip}");
        assert!((-40.0..=-20.0).contains(&constant), "{constant}");
        // A file with the reported keys has the same joint.
        let load = LOAD.1.replace("-30.0", &format!("{constant:?}"));
        let stick = format!("stick_nm = {:?} ", 540.0 * stick);
        let slip = format!("slip_nm = {:?} ", 540.0 * slip);
        let changed =
            [(LOAD.0, &*load), ("stick_nm = 216.0 ", &*stick), ("slip_nm = 205.2 ", &*slip)];
        let set = json!({
            "run.delay_samples": value("run.delay_samples"), "inertia": inertia,
        });
        let alone = of_a_sheet(&changed, "move", &set);
        let worst = &cloud["curves"][cloud["worst"]["place"].as_u64().unwrap() as usize];
        assert_eq!(worst["settled_s"], alone["settled_s"], "{keys_of_worst:?}");
        // A curve of fewer points keeps its ends.
        let ends = |one: &Value| {
            let errors = numbers(one, "error_counts");
            let last = errors[errors.len() - 1];
            let [least, most] =
                [f64::min, f64::max].map(|end| errors.iter().copied().fold(0.0, end));
            [least, most, last]
        };
        let off = ends(worst).into_iter().zip(ends(&alone)).map(|(is, to)| (is - to).abs());
        assert!(
            off.clone().all(|off| off < 1.5),
            "{:?} counts: {keys_of_worst:?}",
            off.collect::<Vec<_>>()
        );
        assert!(ends(&alone)[1] > 20.0, "{alone}");
    }
}

/// Levels that differ by the direction stay so where they are drawn, and a joint that its load
/// moves is left out and counted.
#[test]
fn a_cloud_has_joints_with_uneven_friction_and_counts_those_that_fall() {
    // Some of these hold less than gravity pulls with.
    let falls = ("[load]\n", "[load]\nunbalance_nm = 300.0\nhangs_at_deg = 90.0\n");
    let spread = "\n[spread]\n\"friction.stick_nm\" = [206.0, 394.0]\n";
    for (changed, spread, some_fall) in [(UNEVEN, "", false), (falls, spread, true)] {
        let (_directory, machine) = sheet(&[changed], spread);
        run(async {
            let server = studio_around(machine, "pd", &[]);
            let mut page = Page::open(&server).await;
            let way = json!({ "how": "move", "deg": 2.0 });
            let cloud = predicted(&mut page, "cloud", wish(&way, &["pd"], &json!({}), 12)).await;
            let count = |key: &str| cloud[key].as_array().map(Vec::len).unwrap_or_default();
            let [went, fell] = ["curves", "refused_joints"].map(count);
            assert_eq!((went + fell, went > 0, fell > 0), (12, true, some_fall), "{cloud}");
        });
    }
}
