use super::*;
use crate::compensator::{Gains, SmoothRobustNonlinearGains};
use crate::drive::{DriveConfig, PwmMode};
use crate::encoder::{CounterBits, Direction, Encoder};
use crate::pd::PdGains;

fn example() -> Parameters {
    let gains = Gains::SmoothRobustNonlinear(SmoothRobustNonlinearGains { v_ms: 0.4, alpha: 100.0 });
    let controller = ControllerConfig {
        sample_time: 0.02,
        encoder: Encoder {
            resolution: 0.00242,
            counter_bits: CounterBits::Sixteen,
            direction: Direction::Reverse,
        },
        velocity_window: 5,
        pd: PdGains { kp: 1.0, kd: 0.25 },
        compensator: [gains; 4].into_iter().collect(),
        drive: DriveConfig { full_scale: 5.0, lsb: 0.00488, mode: PwmMode::SignMagnitude, pwm_top: 65_534 },
    };
    let corner = |k: u32| Corner { tick: 1000 * k, position: Position { counts: i32::MIN, fraction: 0.5 } };
    let motion =
        Motion::Trajectory { corners: (1..=MAX_CORNERS as u32).map(corner).collect(), half_blend: 0.25 };
    let limits = Limits::derived(&controller, &Device::CAUTIOUS, 0.4);
    Parameters { controller, motion, device: Device::CAUTIOUS, limits }
}

#[test]
fn the_longest_record_fits_and_comes_back() {
    let mut room = [0; ROOM];
    let record = example().encode(7, &mut room).unwrap();
    assert_eq!(Parameters::decode(record), Ok((example(), 7)));
}

/// A record as version 1 of the format had it: the same without limits.
fn first_version(parameters: &Parameters, sequence: u32, room: &mut [u8]) -> usize {
    let Parameters { controller, motion, device, .. } = parameters;
    let length = postcard::to_slice(&(controller, motion, device), &mut room[HEADER..]).unwrap().len();
    for (at, field) in [(4, 1), (8, sequence), (12, length as u32)] {
        room[at..at + 4].copy_from_slice(&field.to_le_bytes());
    }
    let sum = checksum(&room[..HEADER], &room[HEADER..HEADER + length]);
    room[..4].copy_from_slice(b"STIC");
    room[16..HEADER].copy_from_slice(&sum.to_le_bytes());
    HEADER + length
}

#[test]
fn a_record_of_the_first_version_is_read_and_gets_derived_limits() {
    let mut room = [0; ROOM];
    let length = first_version(&example(), 3, &mut room);
    let (found, sequence) = Parameters::decode(&room[..length]).unwrap();
    let limits = Limits::derived(&found.controller, &found.device, 0.0);
    assert_eq!((found, sequence), (Parameters { limits, ..example() }, 3));
    // It ends where the third version would have its limits.
    room[4] = 3;
    let sum = checksum(&room[..HEADER], &room[HEADER..length]);
    room[16..HEADER].copy_from_slice(&sum.to_le_bytes());
    assert_eq!(Parameters::decode(&room[..length]), Err(DecodeError::Malformed));
    room[4] = 4;
    assert_eq!(Parameters::decode(&room[..length]), Err(DecodeError::Version(4)));
}

#[test]
fn a_ramp_comes_back_and_its_limits_are_checked() {
    let ramp = |rate: f32, hold: f32, soft_start: f32| {
        let device = Device { soft_start, ..Device::CAUTIOUS };
        let parameters = Parameters { motion: Motion::Ramp { rate, hold }, device, ..example() };
        let mut room = [0; ROOM];
        let decoded = Parameters::decode(parameters.encode(0, &mut room).unwrap());
        decoded.map(|(found, _)| assert_eq!(found, parameters)).map_err(|error| match error {
            DecodeError::Value(error) => error.key,
            other => panic!("{other:?}"),
        })
    };
    assert_eq!(ramp(0.001, 10.0, 0.5), Ok(()));
    assert_eq!(ramp(f32::NAN, 10.0, 0.5), Err("ramp_rates_v_per_s"));
    assert_eq!(ramp(0.001, -1.0, 0.5), Err("hold_s"));
    // 5 V in half a second; without a soft start, 5 V in a tick of 20 ms.
    assert_eq!((ramp(10.0, 1.0, 0.5), ramp(10.1, 1.0, 0.5)), (Ok(()), Err("ramp_rates_v_per_s")));
    assert_eq!((ramp(250.0, 1.0, 0.0), ramp(251.0, 1.0, 0.0)), (Ok(()), Err("ramp_rates_v_per_s")));
}

#[test]
fn every_changed_bit_and_every_cut_is_refused() {
    let mut room = [0; ROOM];
    let length = example().encode(7, &mut room).unwrap().len();
    for bit in 0..8 * length {
        let mut changed = room;
        changed[bit / 8] ^= 1 << (bit % 8);
        assert!(Parameters::decode(&changed).is_err(), "bit {bit}");
    }
    for cut in 0..length {
        assert!(Parameters::decode(&room[..cut]).is_err(), "{cut} bytes");
    }
}

#[test]
fn a_bad_value_with_a_good_checksum_names_its_key() {
    let refused = |change: fn(&mut Parameters)| {
        let mut parameters = example();
        change(&mut parameters);
        let mut room = [0; ROOM];
        match Parameters::decode(parameters.encode(0, &mut room).unwrap()) {
            Err(DecodeError::Value(error)) => error.key,
            other => panic!("{other:?}"),
        }
    };
    assert_eq!(refused(|p| p.controller.sample_time = 0.021), "sample_time_s");
    assert_eq!(refused(|p| p.controller.pd.kp = f32::NAN), "kp_v_per_deg");
    assert_eq!(refused(|p| p.controller.velocity_window = 17), "velocity_window");
    assert_eq!(refused(|p| p.controller.drive.pwm_top = 3), "pwm_top");
    assert_eq!(refused(|p| p.device.dead_time = 1.0), "dead_time_s");
    assert_eq!(refused(|p| p.device.nominal_supply = 1.0), "nominal_supply_v");
    assert_eq!(refused(|p| p.limits.overspeed = -1.0), "overspeed_deg_per_s");
    assert_eq!(refused(|p| p.limits.position_max = -1.0), "position_max_deg");
    assert_eq!(refused(|p| p.motion = Motion::Step(Position { counts: 0, fraction: 1.0 })), "steps_deg");
    assert_eq!(refused(|p| p.controller.drive.lsb = f32::INFINITY), "lsb_v");
}

#[test]
fn the_newest_valid_sector_is_taken() {
    let (mut a, mut b) = ([0xFF; ROOM], [0xFF; ROOM]);
    assert_eq!(Parameters::newest([&a, &b]), Err(DecodeError::Blank));
    example().encode(u32::MAX, &mut a).unwrap();
    assert_eq!(Parameters::newest([&a, &b]).unwrap().1, 0);
    example().encode(0, &mut b).unwrap(); // one later
    assert_eq!(Parameters::newest([&a, &b]).unwrap().1, 1);
    b[30] ^= 1;
    assert_eq!(Parameters::newest([&a, &b]).unwrap().1, 0);
    a[30] ^= 1;
    assert_eq!(Parameters::newest([&a, &b]), Err(DecodeError::Checksum));
}
