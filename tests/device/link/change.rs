//! Single values that are changed by their numbers in records, and the laws of a sum with their
//! gains.

use std::time::Duration;

use simulator::device::client::Client;
use simulator::device::wire::SimulatedWire;
use stiction::control::laws::{
    FIRST_LAW, Gains, ResetIntegralGains, ResetOffsetIntegralGains, SmoothRobustNonlinearGains,
};
use stiction::control::pd::PdGains;
use stiction::link::StateCode;
use stiction::parameters::DeviceConfig;
use stiction::units::value::{Key, Table, key};
use stiction::{Limits, ProfileLimits};

use super::client;

fn gains(v_ms: f32, alpha: f32) -> Gains {
    Gains::SmoothRobustNonlinear(SmoothRobustNonlinearGains { v_ms, alpha })
}

const RI: Gains = Gains::ResetIntegral(ResetIntegralGains { ki: 3.0, theta_ri: 0.25 });
const ROI: Gains = Gains::ResetOffsetIntegral(ResetOffsetIntegralGains { t_roi: 0.2, v_roi: 1.5 });

/// The value that puts a law in a place of the sum, by its number; zero is no law.
fn law(place: u16, law: Option<Gains>) -> (Key, u32) {
    (Key(FIRST_LAW.0 + place), law.map_or(0, |law| law.id().into()))
}

fn number(key: Key, value: f32) -> (Key, u32) {
    (key, value.to_bits())
}

const KP: Key = key(PdGains::ABOUT, "kp");
const KI: Key = key(ResetIntegralGains::ABOUT, "ki");
const THETA_RI: Key = key(ResetIntegralGains::ABOUT, "theta_ri");

#[test]
fn values_are_changed_by_their_numbers_while_stopped_and_the_others_stay() {
    let mut client = client();
    let before = client.parameters().unwrap();
    let soft_start = key(DeviceConfig::ABOUT, "soft_start");
    client.change(&[number(KP, 2.0), number(soft_start, 0.25)]).unwrap();
    let mut expected = before;
    (expected.controller.pd.kp, expected.device.soft_start) = (2.0, 0.25);
    assert_eq!(client.parameters().unwrap(), expected);
    let status = client.status().unwrap();
    assert_eq!((status.state, status.unsaved), (StateCode::Stopped, true));

    // The loop runs with the new gain: 1.5 deg under 2 V/deg.
    client.change(&[law(0, None)]).unwrap();
    client.pass(Duration::from_millis(200)).unwrap();
    client.arm().unwrap();
    assert!(client.change(&[number(KP, 1.0)]).unwrap_err().to_string().contains("`stop` first"));
    client.step_to(1.5).unwrap();
    let output = client.wire().simulated.tick();
    assert!((output.tick.v_pd - 3.0).abs() < 1e-5, "{}", output.tick.v_pd);
}

#[test]
fn a_change_with_a_value_that_is_not_allowed_changes_nothing() {
    let mut client = client();
    let before = client.parameters().unwrap();
    let thermal = key(Limits::ABOUT, "thermal_time");
    let overspeed = key(Limits::ABOUT, "overspeed");
    for (entries, said) in [
        (
            vec![number(KP, f32::NAN)],
            "`controller.NAME.kp_v_per_deg` is NaN; must be a number from 0 to 1000000",
        ),
        (
            vec![number(KP, 2.0), number(thermal, -1.0)],
            "`limits.thermal_s` is -1; must be a number from 0.1 to 100",
        ),
        (
            vec![number(thermal, 0.0), number(KP, 2.0)],
            "`limits.thermal_s` is 0; must be a number from 0.1 to 100",
        ),
        // The derived velocity is half of the derived overspeed, 83.3 deg/s times 0.6 under SRNF.
        (
            vec![number(overspeed, 20.0)],
            "`profile.velocity_deg_per_s` is 25; must be a number above 0, up to \
             `limits.overspeed_deg_per_s`, which is 20",
        ),
        (vec![number(KP, 2.0), (Key(0x087F), 0)], "does not have `value 0x087f`"),
        // The gain belongs to a law that is not in use.
        (vec![number(KP, 2.0), number(KI, 1.0)], "does not have `controller.NAME.ki_v_per_deg_s`"),
        (vec![number(KP, 2.0), law(1, Some(gains(0.4, 100.0)))], "is 6; must be"),
    ] {
        let message = client.change(&entries).unwrap_err().to_string();
        assert!(message.contains(said), "{said}: {message}");
        assert_eq!(client.parameters().unwrap(), before, "{said}");
    }
    assert!(!client.status().unwrap().unsaved);
    // Both together are allowed, the velocity up to the limit; and so is a limit that is off.
    let velocity = key(ProfileLimits::ABOUT, "velocity");
    client.change(&[number(overspeed, 20.0), number(velocity, 20.0)]).unwrap();
    client.change(&[number(overspeed, 0.0), number(velocity, 40.0)]).unwrap();
}

#[test]
fn a_law_is_replaced_by_its_number_with_all_of_its_gains() {
    let mut client = client();
    let laws = |client: &mut Client<SimulatedWire>| {
        let parameters = client.parameters().unwrap();
        parameters.controller.compensator.iter().copied().collect::<Vec<_>>()
    };
    assert_eq!(laws(&mut client), [gains(0.4, 100.0)]);
    let message = client.change(&[law(0, Some(RI)), number(KI, 3.0)]).unwrap_err().to_string();
    assert!(message.contains("`controller.NAME.theta_ri_deg` is missing"), "{message}");
    assert_eq!(laws(&mut client), [gains(0.4, 100.0)]);
    client.change(&[law(0, Some(RI)), number(KI, 3.0), number(THETA_RI, 0.25)]).unwrap();
    assert_eq!(laws(&mut client), [RI]);
    // One gain changes alone, and none of the others.
    client.change(&[number(THETA_RI, 0.5)]).unwrap();
    let wider = Gains::ResetIntegral(ResetIntegralGains { ki: 3.0, theta_ri: 0.5 });
    assert_eq!(laws(&mut client), [wider]);
    client.change(&[law(0, None)]).unwrap();
    assert_eq!(laws(&mut client), []);
}

#[test]
fn a_law_of_a_sum_keeps_its_gains_in_another_place_and_its_place_when_another_law_is_replaced() {
    let mut client = client();
    let laws = |client: &mut Client<SimulatedWire>| {
        let parameters = client.parameters().unwrap();
        parameters.controller.compensator.iter().copied().collect::<Vec<_>>()
    };
    let srnf = gains(0.3, 50.0);
    let mut three = client.parameters().unwrap();
    three.controller.compensator = [srnf, RI, ROI].into_iter().collect();
    client.set_parameters(&three).unwrap();
    client.change(&[law(0, Some(ROI)), law(1, Some(srnf)), law(2, Some(RI))]).unwrap();
    assert_eq!(laws(&mut client), [ROI, srnf, RI]);
    client.change(&[law(1, Some(RI)), law(2, None)]).unwrap();
    assert_eq!(laws(&mut client), [ROI, RI]);
    let [v_ms, alpha] =
        ["v_ms", "alpha"].map(|field| key(SmoothRobustNonlinearGains::ABOUT, field));
    client.change(&[law(0, Some(srnf)), number(v_ms, 0.3), number(alpha, 50.0)]).unwrap();
    assert_eq!(laws(&mut client), [srnf, RI]);
}
