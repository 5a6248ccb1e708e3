//! Slack of a gear that the encoder does not measure.

use toml::Table;

use super::sheet;
use crate::data_sheet::{SheetTables, UnseenSlack};

/// Data sheet of a joint with backlash that several tests share.
const GEAR: &str = include_str!("../../../../tests/joints_under_test/gear_with_backlash.toml");

#[test]
fn the_slack_of_a_gear_is_its_backlash_and_the_wind_up_of_what_holds_it_at_rest() {
    let tables: SheetTables = GEAR.parse::<Table>().unwrap().try_into().unwrap();
    let slack = UnseenSlack::of(&tables.sheet().unwrap().unwrap(), 360.0 / 102_400.0).unwrap();
    // 0.6 deg of 102 400 counts in 360 deg.
    assert!((slack.backlash_counts - 0.6 * 102_400.0 / 360.0).abs() < 1e-9, "{slack:?}");
    // The load has 0.3 of 0.35 N m of static friction, and 0.25 N m of unbalance; 200 N m/rad.
    let wind_up = ((0.3 * 0.35 + 0.25) / 200.0_f64).to_degrees();
    assert!((slack.wind_up_deg - wind_up).abs() < 1e-12, "{slack:?}");
    assert_eq!(
        slack.to_string(),
        "this encoder cannot see 171 counts of backlash; the load can be up to 0.6 deg off, plus \
         the wind-up of the gear (up to 0.1017 deg at rest)"
    );
}

#[test]
fn only_an_elastic_gear_behind_an_encoder_on_the_motor_has_unseen_slack() {
    let of = |set: &[(&str, &str)]| UnseenSlack::of(&sheet(set).0, 0.0018);
    assert_eq!(of(&[]), None);
    let stiff = ("gear.stiffness_nm_per_rad", "1000.0");
    assert_eq!(of(&[stiff, ("encoder.at", "'load'")]), None);
    let second = ("load_encoder.counts_per_turn", "16384");
    assert_eq!(of(&[stiff, second]), None);
    assert!(of(&[stiff, second, ("loop.position", "'motor'")]).is_some());
    let slack = of(&[stiff, ("load.constant_nm", "-2.0")]).unwrap();
    assert_eq!(slack.backlash_counts, 0.0);
    // 0.3 of 5 N m and 2 N m behind 1000 N m/rad.
    assert!((slack.wind_up_deg - 3.5e-3_f64.to_degrees()).abs() < 1e-12);
    let sentence = slack.to_string();
    assert!(sentence.contains("the wind-up of the gear; the load can be up to 0.2005 deg off"));
}
