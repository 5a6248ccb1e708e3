use heapless::Vec;

use super::record::ROOM;
use super::*;
use crate::control::brake_resistor::BrakeResistor;
use crate::control::current_sensor::CurrentSensor;
use crate::control::drive::{DriveConfig, PwmMode};
use crate::control::encoder::{CounterBits, Direction, Encoder, EncoderOutput};
use crate::control::laws::{FIRST_LAW, Gains};
use crate::control::motor_encoder::MotorEncoder;
use crate::control::motor_ntc::MotorNtc;
use crate::control::reference::{Corner, MAX_CORNERS};
use crate::units::error::Allowed;
use crate::units::position::Position;
use crate::units::value::{Key, key};

fn example() -> Parameters {
    let controller = ControllerConfig {
        sample_time: 0.02,
        encoder: Encoder {
            resolution: 0.00242,
            counter_bits: CounterBits::Sixteen,
            direction: Direction::Reverse,
            output: EncoderOutput::PushPull,
        },
        velocity_window: 5,
        effort: EffortMode::Voltage,
        pd: PdGains { kp: 1.0, kd: 0.25 },
        compensator: Gains::EXAMPLES.iter().copied().take(4).collect(),
        motor: MotorEncoder::NONE,
        drive: DriveConfig {
            full_scale: 5.0,
            lsb: 0.00488,
            mode: PwmMode::SignMagnitude,
            pwm_hz: 1300.0,
            duty_max: 1.0,
        },
    };
    let corner =
        |k: u32| Corner { tick: 1000 * k, position: Position { counts: i32::MIN, fraction: 0.5 } };
    let motion = Motion::Trajectory {
        corners: (1..=MAX_CORNERS as u32).map(corner).collect(),
        half_blend: 0.25,
    };
    let limits = Limits::derived(&controller, &DeviceConfig::CAUTIOUS, 0.4);
    let profile = ProfileLimits::derived(&controller, limits.overspeed, 0.0);
    let jog = JogBounds::derived(&controller, &DeviceConfig::CAUTIOUS, 0.4);
    Parameters {
        controller,
        motion,
        device: DeviceConfig::CAUTIOUS,
        limits,
        profile,
        jog,
        current: CurrentSensor::NONE,
        brake_resistor: BrakeResistor::NONE,
        motor_ntc: MotorNtc::NONE,
    }
}

#[test]
fn the_longest_record_fits_and_comes_back() {
    let mut room = [0; ROOM];
    let record = example().encode(7, &mut room).unwrap();
    assert_eq!(Parameters::decode(record), Ok((example(), 7)));
}

#[test]
fn a_record_of_another_format_is_refused_by_its_version() {
    for version in [0, 3, 5] {
        let mut record = record_of(&body_of(&example()));
        record[4..8].copy_from_slice(&u32::to_le_bytes(version));
        reseal(&mut record);
        assert_eq!(Parameters::decode(&record), Err(DecodeError::Version(version)));
    }
}

/// Sets the checksum of a record to that of its contents.
fn reseal(bytes: &mut [u8]) {
    let (header, body) = bytes.split_at(record::HEADER);
    let sum = record::checksum(header, body);
    bytes[16..20].copy_from_slice(&sum.to_le_bytes());
}

/// Makes a record of entries with a good checksum.
fn record_of(body: &[u8]) -> Vec<u8, ROOM> {
    let mut bytes = Vec::new();
    for part in [
        &b"STIC"[..],
        &4u32.to_le_bytes(),
        &[0; 4],
        &(body.len() as u32).to_le_bytes(),
        &[0; 4],
        body,
    ] {
        bytes.extend_from_slice(part).unwrap();
    }
    reseal(&mut bytes);
    bytes
}

fn body_of(parameters: &Parameters) -> Vec<u8, ROOM> {
    let mut room = [0; ROOM];
    let length = record::write(parameters, &mut room).unwrap();
    room.iter().copied().take(length).collect()
}

#[test]
fn a_value_that_a_record_lacks_is_its_default_or_derived_or_named() {
    let example = Parameters {
        device: DeviceConfig { soft_start: 0.1, ..DeviceConfig::CAUTIOUS },
        ..example()
    };
    let body = body_of(&example);
    let without_all = |keys: &[Key]| {
        let is_left =
            |entry: &&[u8]| !keys.iter().any(|key| entry.starts_with(&key.0.to_le_bytes()));
        let left: Vec<u8, ROOM> = body.chunks(6).filter(is_left).flatten().copied().collect();
        assert_eq!(left.len() + 6 * keys.len(), body.len(), "{keys:?}");
        Parameters::decode(&record_of(&left)).map(|(parameters, _)| parameters)
    };
    let without = |key: Key| without_all(&[key]);
    let soft_start = key(DeviceConfig::ABOUT, "soft_start");
    assert_eq!(without(soft_start).unwrap().device, DeviceConfig::CAUTIOUS);
    let derived = Limits::derived(&example.controller, &example.device, 0.0);
    // The stall follows from the breakaway, and the other way around; both, from the drive.
    let [stall, breakaway] =
        ["stall_effort", "breakaway_effort"].map(|field| key(Limits::ABOUT, field));
    for known in [stall, breakaway] {
        assert_eq!(without(known).unwrap().limits, example.limits);
    }
    let Limits { stall_effort, breakaway_effort, .. } = derived;
    let neither = without_all(&[stall, breakaway]).unwrap().limits;
    assert_eq!(neither, Limits { stall_effort, breakaway_effort, ..example.limits });
    assert_ne!(derived.stall_effort, example.limits.stall_effort);
    let kp = key(PdGains::ABOUT, "kp");
    assert_eq!(without(kp), Err(DecodeError::Missing(kp)));
    let theta_ri = Key(0x1102);
    assert_eq!(without(theta_ri), Err(DecodeError::Missing(theta_ri)));
}

#[test]
fn a_value_of_a_later_version_is_refused_by_its_number() {
    let mut body = body_of(&example());
    body.extend_from_slice(&[0x7F, 0x08, 1, 0, 0, 0]).unwrap();
    assert_eq!(Parameters::decode(&record_of(&body)), Err(DecodeError::Unknown(Key(0x087F))));
    // The gain of a law that is not in the sum.
    let mut body = body_of(&example());
    body.extend_from_slice(&[0x01, 0x16, 0, 0, 0, 0]).unwrap();
    assert_eq!(Parameters::decode(&record_of(&body)), Err(DecodeError::Unknown(Key(0x1601))));
}

#[test]
fn a_law_that_is_there_twice_is_refused() {
    let mut parameters = example();
    let [first, ..] = *Gains::EXAMPLES else { unreachable!() };
    parameters.controller.compensator = [first, first].into_iter().collect();
    let error = parameters.validate().unwrap_err();
    assert_eq!((error.key, error.found), (Key(FIRST_LAW.0 + 1), 1.0));
    assert_eq!((name(error.key), error.allowed), ("laws", Allowed::AnotherLaw));
}

#[test]
fn entries_of_which_one_undoes_another_are_refused() {
    let example = example();
    let body = body_of(&example);
    let entry = |key: Key| {
        let entries = body.chunks(6).filter(|entry| entry.starts_with(&key.0.to_le_bytes()));
        entries.flatten().copied().collect::<Vec<u8, 6>>()
    };
    let changed = |entries: &[&[u8]]| {
        let entries: Vec<u8, 64> = entries.iter().copied().flatten().copied().collect();
        let mut parameters = example.clone();
        parameters.change(&entries, &example).map(|()| assert_eq!(parameters, example))
    };
    let (kp, theta_ri) = (entry(key(PdGains::ABOUT, "kp")), entry(Key(0x1102)));
    let (law, none) = (entry(FIRST_LAW), [0x00, 0x05, 0, 0, 0, 0]);
    assert_eq!(changed(&[&kp, &law, &theta_ri]), Ok(()));
    assert_eq!(changed(&[&theta_ri, &none, &law]), Err(DecodeError::Malformed));
    assert_eq!(changed(&[&kp, &[0x01, 0x04, 0, 0, 0, 0]]), Err(DecodeError::Malformed));
    // A whole record is refused for the same: a corner before the kind of its motion.
    let kind = body.chunks(6).position(|entry| entry.starts_with(&[0x00, 0x06])).unwrap();
    let mut turned = body.clone();
    turned[6 * kind..].rotate_left(6);
    assert!(matches!(
        Parameters::decode(&record_of(&turned)),
        Err(DecodeError::Unknown(_) | DecodeError::Malformed)
    ));
}

#[test]
fn a_record_that_is_valid_may_not_fit_a_board() {
    let board = Hardware {
        pwm_clock_hz: 168e6,
        supply_top: 4095,
        dead_time_max: 6e-6,
        sample_time: [1e-4, 0.02],
    };
    let mut parameters = example();
    assert_eq!(parameters.fits(&board), Ok(()));
    parameters.controller.drive.pwm_hz = 1299.0;
    assert_eq!(parameters.validate(), Ok(()));
    let found = parameters.fits(&board);
    assert!(matches!(found, Err(DecodeError::Value(error)) if name(error.key) == "pwm_hz"));
    // The longest dead time is the board's, too: of half the clock, twice as long.
    let mut parameters = example();
    parameters.device.dead_time = 6.001e-6;
    assert_eq!(parameters.validate(), Ok(()));
    let slower = Hardware { dead_time_max: 12e-6, ..board };
    assert_eq!(parameters.fits(&slower), Ok(()));
    let Err(DecodeError::Value(error)) = parameters.fits(&board) else { panic!() };
    assert_eq!((name(error.key), error.allowed), ("dead_time_s", Allowed::Between(0.0, 6e-6)));
    assert_eq!(parameters.prepare(&board).unwrap_err(), error);
    // So are the shortest and the longest sample time.
    for (sample_time, fits) in [(0.99e-4, false), (1e-4, true), (0.02, true), (0.0201, false)] {
        let mut parameters = example();
        parameters.controller.sample_time = sample_time;
        let found = parameters.fits(&board).map_err(|error| match error {
            DecodeError::Value(error) => (name(error.key), error.allowed),
            other => panic!("{other:?}"),
        });
        let refused = ("sample_time_s", Allowed::Between(1e-4, 0.02));
        assert_eq!(found, if fits { Ok(()) } else { Err(refused) }, "{sample_time}");
        if !fits {
            let error = parameters.prepare(&board).unwrap_err();
            assert_eq!((name(error.key), error.allowed), refused);
        }
    }
    parameters = example();
    parameters.controller.sample_time = 0.04;
    assert_eq!(parameters.fits(&Hardware { sample_time: [1e-3, 0.04], ..board }), Ok(()));
}

/// At 22 kHz a period has 45.45 us. In locked antiphase a leg that conducts for 44 us of it charges
/// for 1.45 us less two dead times.
#[test]
fn a_bootstrapped_bridge_has_no_duty_under_which_its_capacitors_do_not_charge() {
    let of = |mode: PwmMode, dead_time: f32, duty_max: f32, bootstrapped: bool| {
        let mut parameters = example();
        let drive = &mut parameters.controller.drive;
        (drive.mode, drive.pwm_hz, drive.duty_max) = (mode, 22e3, duty_max);
        (parameters.device.dead_time, parameters.device.bootstrapped) = (dead_time, bootstrapped);
        parameters.check().map_err(|error| (error.key, error.allowed))
    };
    use PwmMode::{Analog, LockedAntiphase, SignMagnitude};
    let at_most =
        |most: f32| Err((key(DriveConfig::ABOUT, "duty_max"), Allowed::DueTo(most, BOOTSTRAPPED)));
    // 1 - 2 x 2 us x 22 kHz, 1 - 2 x 4 us x 22 kHz and 1 - 2 us x 22 kHz.
    assert_eq!(of(LockedAntiphase, 0.0, 0.912, true), Ok(()));
    assert_eq!(of(LockedAntiphase, 0.0, 0.913, true), at_most(0.912));
    assert_eq!(of(LockedAntiphase, 1e-6, 0.824, true), Ok(()));
    assert_eq!(of(LockedAntiphase, 1e-6, 1.0, true), at_most(0.824));
    assert_eq!(of(SignMagnitude, 1e-6, 0.956, true), Ok(()));
    assert_eq!(of(SignMagnitude, 1e-6, 0.957, true), at_most(0.956));
    assert_eq!(of(Analog, 1e-6, 1.0, true), Ok(()));
    assert_eq!(of(LockedAntiphase, 1e-6, 1.0, false), Ok(()));
}

#[test]
fn there_is_room_for_a_few_hundred_values_and_each_number_is_used_once() {
    let used = body_of(&example()).len();
    assert!(used < 2 * ROOM / 5, "{used} bytes of {ROOM} are used");
    let numbers: Vec<Key, 256> = declarations().map(|about| about.key).collect();
    for (i, key) in numbers.iter().enumerate() {
        assert!(!numbers[..i].contains(key), "{:#06x} is used twice", key.0);
        // The list of laws is declared by its first number.
        assert!(!(0x0501..=0x0503).contains(&key.0), "{:#06x} is in the list of laws", key.0);
    }
}

fn name(key: Key) -> &'static str {
    names::about(key).map_or("", |about| about.name)
}

#[test]
fn a_ramp_comes_back_and_its_limits_are_checked() {
    let ramp = |rate: f32, hold: f32, soft_start: f32| {
        let device = DeviceConfig { soft_start, ..DeviceConfig::CAUTIOUS };
        let parameters = Parameters { motion: Motion::Ramp { rate, hold }, device, ..example() };
        let mut room = [0; ROOM];
        let decoded = Parameters::decode(parameters.encode(0, &mut room).unwrap());
        decoded.map(|(found, _)| assert_eq!(found, parameters)).map_err(|error| match error {
            DecodeError::Value(error) => name(error.key),
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
            Err(DecodeError::Value(error)) => name(error.key),
            other => panic!("{other:?}"),
        }
    };
    assert_eq!(refused(|p| p.controller.sample_time = 1.001), "sample_time_s");
    assert_eq!(refused(|p| p.controller.sample_time = 0.0), "sample_time_s");
    assert_eq!(refused(|p| p.controller.pd.kp = f32::NAN), "kp_v_per_deg");
    assert_eq!(refused(|p| p.controller.velocity_window = 17), "velocity_window");
    assert_eq!(refused(|p| p.controller.drive.pwm_hz = 0.0), "pwm_hz");
    assert_eq!(refused(|p| p.device.dead_time = 1.0), "dead_time_s");
    assert_eq!(refused(|p| p.device.nominal_supply = 1.0), "nominal_supply_v");
    assert_eq!(refused(|p| p.limits.overspeed = -1.0), "overspeed_deg_per_s");
    assert_eq!(refused(|p| p.limits.position_max = -1.0), "position_max_deg");
    assert_eq!(
        refused(|p| p.motion = Motion::Step(Position { counts: 0, fraction: 1.0 })),
        "steps_deg"
    );
    assert_eq!(refused(|p| p.controller.drive.lsb = f32::INFINITY), "lsb_v");
}

/// 64 counts are an encoder of 16 lines; an eighth of them is 8. The width counts only with an
/// index.
#[test]
fn an_index_has_enough_counts_for_its_width() {
    let with = |counts: u32, width: u32| {
        let mut parameters = example();
        (parameters.device.index_counts, parameters.device.index_width) = (counts, width);
        parameters.check().map_err(|error| name(error.key))
    };
    for (counts, width) in [(0, 4), (0, 65_536), (64, 8), (2000, 250), (1 << 24, 0)] {
        assert_eq!(with(counts, width), Ok(()), "{counts}, {width}");
    }
    for (counts, width, named) in [
        (63, 4, "index_counts"),
        (1, 0, "index_counts"),
        ((1 << 24) + 2, 4, "index_counts"),
        (64, 9, "index_width_counts"),
        (2000, 251, "index_width_counts"),
    ] {
        assert_eq!(with(counts, width), Err(named), "{counts}, {width}");
    }
}

#[test]
fn an_analog_amplifier_has_no_short_brake() {
    let with = |mode: PwmMode, short_brake: f32| {
        let mut parameters = example();
        (parameters.controller.drive.mode, parameters.device.short_brake) = (mode, short_brake);
        parameters.check().map_err(|error| name(error.key))
    };
    assert_eq!(with(PwmMode::Analog, 0.0), Ok(()));
    assert_eq!(with(PwmMode::Analog, 0.1), Err("short_brake_s"));
    assert_eq!(with(PwmMode::LockedAntiphase, 10.0), Ok(()));
    assert_eq!(with(PwmMode::SignMagnitude, 10.1), Err("short_brake_s"));
}

#[test]
fn the_newest_valid_sector_is_taken() {
    let (mut a, mut b) = ([0xFF; ROOM], [0xFF; ROOM]);
    assert_eq!(Parameters::newest([&a, &b]), Err(DecodeError::Blank));
    example().encode(u32::MAX, &mut a).unwrap();
    assert_eq!(Parameters::newest([&a, &b]).unwrap().2, 0);
    example().encode(0, &mut b).unwrap(); // one later
    assert_eq!(Parameters::newest([&a, &b]).unwrap().2, 1);
    b[30] ^= 1;
    assert_eq!(Parameters::newest([&a, &b]).unwrap().2, 0);
    a[30] ^= 1;
    assert_eq!(Parameters::newest([&a, &b]), Err(DecodeError::Checksum));
}

/// A sensor whose limit of 3.7125 A causes 7.425 V through 2 ohm.
fn sensed() -> Parameters {
    let mut parameters = example();
    parameters.controller.sample_time = 0.001;
    parameters.controller.drive.pwm_hz = 21e3;
    parameters.limits.back_emf = 0.05;
    parameters.current = CurrentSensor::derived(8.25, [2.0, 1e-3]);
    let overspeed = parameters.limits.overspeed;
    parameters.profile = ProfileLimits::derived(&parameters.controller, overspeed, 0.0);
    assert_eq!(parameters.check(), Ok(()));
    parameters
}

#[test]
fn a_stall_threshold_that_the_limit_of_the_current_keeps_away_is_refused() {
    let mut parameters = sensed();
    for (stall, fits) in [(7.42, true), (7.43, false), (0.0, true)] {
        parameters.limits.stall_effort = stall;
        let found = parameters.check().map_err(|error| (name(error.key), error.found));
        assert_eq!(found, if fits { Ok(()) } else { Err(("stall_v", stall)) });
    }
    // Without a limit the effort reaches the full scale.
    (parameters.current.peak, parameters.limits.stall_effort) = (0.0, 7.43);
    assert_eq!(parameters.check(), Ok(()));
}

#[test]
fn a_current_loop_needs_a_sensor_a_winding_and_a_pwm_that_is_fast_and_in_step() {
    let board = Hardware {
        pwm_clock_hz: 168e6,
        supply_top: 4095,
        dead_time_max: 6e-6,
        sample_time: [1e-4, 0.02],
    };
    let mut parameters = sensed();
    parameters.controller.effort = EffortMode::Current;
    assert_eq!(parameters.prepare(&board).map(|_| ()), Ok(()));
    assert_eq!(parameters.periods(&board), Ok(21));
    let refused = |change: &dyn Fn(&mut Parameters)| {
        let mut changed = parameters.clone();
        change(&mut changed);
        let error = changed.prepare(&board).unwrap_err();
        (name(error.key), error.allowed)
    };
    assert_eq!(refused(&|of| of.current = CurrentSensor::NONE).0, "full_scale_a");
    assert_eq!(refused(&|of| of.current.inductance = 0.0).0, "inductance_h");
    let (key, allowed) = refused(&|of| of.current.bandwidth = 2200.0);
    assert_eq!((key, allowed), ("bandwidth_hz", Allowed::DueTo(2100.0, PWM_HZ)));
    let (key, allowed) = refused(&|of| of.controller.drive.pwm_hz = 22e3);
    assert_eq!(key, "pwm_hz");
    let Allowed::SetBy(nearest, SAMPLE_TIME) = allowed else { panic!("{allowed:?}") };
    assert!((nearest - 21e3).abs() < 0.1, "{nearest}");
    // A voltage needs none of it.
    parameters.controller.effort = EffortMode::Voltage;
    (parameters.current.inductance, parameters.controller.drive.pwm_hz) = (0.0, 22e3);
    assert_eq!(parameters.prepare(&board).map(|_| ()), Ok(()));
}

#[test]
fn a_brake_resistor_needs_a_measured_supply_a_monitor_and_room_between_them() {
    let mut parameters = example();
    parameters.device.nominal_supply = 48.0;
    parameters.device.supply_full_scale = 66.0;
    parameters.limits.supply_max = 62.0;
    parameters.brake_resistor =
        BrakeResistor { resistance: 27.0, from: 53.0, full: 59.0, ..BrakeResistor::EXAMPLE };
    assert_eq!(parameters.check(), Ok(()));
    let mut room = [0; ROOM];
    let record = parameters.encode(7, &mut room).unwrap();
    assert_eq!(Parameters::decode(record).unwrap().0, parameters);
    let refused = |change: &dyn Fn(&mut Parameters)| {
        let mut changed = parameters.clone();
        change(&mut changed);
        changed.check().map_err(|error| (name(error.key), error.allowed)).unwrap_err()
    };
    let unmeasured = refused(&|of| {
        (of.device.supply_full_scale, of.device.nominal_supply) = (0.0, 0.0);
    });
    assert_eq!(unmeasured.0, "supply_full_scale_v");
    assert_eq!(refused(&|of| of.limits.supply_max = 0.0).0, "supply_max_v");
    assert_eq!(refused(&|of| of.limits.supply_max = 67.0).0, "supply_max_v");
    let late = refused(&|of| of.limits.supply_max = 58.0);
    assert_eq!(late, ("full_v", Allowed::UpTo(58.0, SUPPLY_MAX)));
    assert_eq!(refused(&|of| of.brake_resistor.full = 53.0).0, "full_v");
    let early = refused(&|of| of.brake_resistor.from = 48.0);
    assert_eq!(early, ("from_v", Allowed::Above(48.0, 59.0)));
    assert_eq!(refused(&|of| of.brake_resistor.duty_max = 0.95).0, "duty_max");
}

/// R(-20 C) / 511 and 511 R(120 C) of an NTC of 10 kOhm and 3950 K: 10 kOhm exp(2.355) / 511 and
/// 511 10 kOhm exp(-3.201).
#[test]
fn a_divider_of_an_ntc_leaves_eight_steps_at_either_end_of_its_range() {
    let check = |divider| {
        let mut parameters = example();
        parameters.motor_ntc = MotorNtc { divider, limit: 120.0, ..MotorNtc::EXAMPLE };
        parameters.check().map_err(|refused| name(refused.key))
    };
    let ends = [10e3 * 2.3550f64.exp() / 511.0, 511.0 * 10e3 * (-3.2013f64).exp()];
    for (end, inwards) in ends.into_iter().zip([1.01, 0.99]) {
        assert_eq!(check((end * inwards) as f32), Ok(()));
        assert_eq!(check((end / inwards) as f32), Err("divider_ohm"));
    }
}
