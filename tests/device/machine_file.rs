//! Parameters as a machine's file: a file that is pulled says what was pushed.

use experiments::both_encoders::both_encoders;
use files::hardware::STM32F405;
use proptest::collection::vec;
use proptest::prelude::*;
use proptest::sample::subsequence;
use simulator::device::machine_file::{changes, read, render};
use simulator::experiment::{Document, Experiment, builtins, position};
use stiction::control::device_config::{HomeSwitch, PositionReference};
use stiction::control::drive::{DriveConfig, PwmMode};
use stiction::control::encoder::{CounterBits, Direction};
use stiction::control::laws::Gains;
use stiction::control::reference::Corner;
use stiction::parameters::names::ValuePath;
use stiction::units::position::Position;
use stiction::units::value::{Key, Kind, Values};
use stiction::{Motion, Parameters, ProfileLimits, parameters};

use crate::fixture::{parameters, plans, srnf};

fn again(parameters: &Parameters) -> Result<Parameters, String> {
    let joint = Document::open("step-response").unwrap().machine().unwrap().joint;
    let text = render(parameters, &joint, "step-response").map_err(|error| error.to_string())?;
    read("pulled.toml", &text).map_err(|error| error.to_string())
}

/// A limit that is off is written as the word, is read back as the same, and a change to it is
/// reported.
#[test]
fn a_limit_that_is_off_says_so() {
    let (on, off) = (srnf(&[]), srnf(&["limits.stall_v=off", "limits.link_timeout_s=0"]));
    let joint = plans("step-response", &[])[0].machine.joint.clone();
    let text = render(&off, &joint, "step-response").unwrap();
    for line in ["stall_v = \"off\"", "link_timeout_s = \"off\"", "supply_min_v = \"off\""] {
        assert!(text.contains(line), "{line}: {text}");
    }
    assert!(!text.contains("stall_s = \"off\""), "{text}");
    assert_eq!(read("off", &text).unwrap(), off);
    let changed = changes(&on, &off).unwrap();
    assert!(changed.contains(&"limits.stall_v: 0.8 -> \"off\"".to_owned()), "{changed:?}");
}

#[test]
fn every_run_of_every_experiment_is_read_back_bit_for_bit() {
    let mut runs = 0;
    for builtin in builtins().iter().filter(|b| !Document::open(b.name).unwrap().is_lab()) {
        for plan in plans(builtin.name, &[]) {
            let found = parameters(&plan);
            assert_eq!(again(&found), Ok(found), "{} {}", builtin.name, plan.label);
            runs += 1;
        }
    }
    // These are all experiments and all controllers: step-response alone has 21 runs and 7
    // variants.
    assert!(runs > 80, "{runs}");
}

#[test]
fn decimals_are_those_that_a_person_has_written() {
    let joint = Document::open("step-response").unwrap().machine().unwrap().joint;
    let text = render(&srnf(&[]), &joint, "step-response").unwrap();
    for line in [
        "resolution_deg = 0.00242",
        "lsb_v = 0.00488",
        "pwm_hz = 22000.0",
        "sample_time_s = 0.02",
        "controller = \"srnf\"",
        "alpha_per_deg = 100.0",
        "steps_deg = [5.0]",
        "overspeed_deg_per_s = 50.0",
    ] {
        assert!(text.lines().any(|found| found == line), "{line}: {text}");
    }
}

#[test]
fn what_no_file_can_say_is_refused_and_not_changed() {
    let hold = Parameters { motion: Motion::Hold, ..srnf(&[]) };
    let said = again(&hold).unwrap_err();
    assert!(said.contains("nothing to run") && said.contains("the binary record"), "{said}");
    let mut between = srnf(&[]);
    between.motion = Motion::Step(Position { counts: 1000, fraction: 1e-20 });
    assert!(again(&between).unwrap_err().contains("a value cannot be written exactly"));
}

#[test]
fn changes_are_named_by_their_keys() {
    let (before, after) =
        (srnf(&[]), srnf(&["controller.srnf.kp_v_per_deg=2", "limits.stall_v=1.5"]));
    let found = changes(&before, &after).unwrap();
    assert_eq!(changes(&before, &before).unwrap(), Vec::<String>::new());
    // A value that is derived from Kp changes with it, and is reported.
    let expected = [
        "controller.srnf.kp_v_per_deg: 1.0 -> 2.0",
        "limits.stall_v: 0.8 -> 1.5",
        "limits.following_error_deg: 5.0 -> 2.5",
    ];
    assert!(expected.iter().all(|line| found.iter().any(|found| found == line)), "{found:?}");
}

fn names(law: &Gains) -> Vec<Key> {
    let mut keys = Vec::new();
    let _ = law.each(&mut |key, _| -> Result<(), ()> {
        keys.push(key);
        Ok(())
    });
    keys
}

/// Makes up to four laws with any gains, in any order. RI and RVI have a key in common, so a file
/// has one of them.
fn gains() -> impl Strategy<Value = Vec<Gains>> {
    let on_the_device = Gains::EXAMPLES.iter().copied().filter(Gains::on_the_device);
    let some = subsequence(on_the_device.collect::<Vec<_>>(), 0..=4).prop_shuffle();
    (some, vec(0u32..100_000, 64)).prop_map(|(laws, numbers)| {
        let mut numbers = numbers.into_iter();
        let (mut used, mut all) = (Vec::new(), Vec::new());
        for mut law in laws {
            if law.replaces_pd() && !all.is_empty() {
                continue;
            }
            let keys = names(&law);
            let texts: Vec<String> = keys.iter().map(|key| ValuePath(*key).to_string()).collect();
            if texts.iter().any(|text| used.contains(text)) {
                continue;
            }
            used.extend(texts);
            for (key, n) in keys.into_iter().zip(&mut numbers) {
                // A time between increments is not shorter than a sample.
                let least =
                    if parameters::about(key).unwrap().name == "t_roi_s" { 0.1 } else { 0.0 };
                let (x, before) = (n as f32 / 997.0 + least, law);
                let bits = match parameters::about(key).unwrap().kind {
                    Kind::Number => x.to_bits(),
                    Kind::Whole => n,
                    Kind::Flag | Kind::Choice(_) => n % 2,
                };
                assert_eq!(law.set(key, bits), Ok(true));
                if law.validate().is_err() {
                    law = before;
                }
            }
            all.push(law);
            if law.replaces_pd() {
                break;
            }
        }
        all
    })
}

/// Makes corners of ticks and degrees, as a file has them; a single one is a step, and of two the
/// first is the amplitude of a sine.
fn motion() -> impl Strategy<Value = (Vec<(u32, f64)>, u32)> {
    (vec((1u32..2000, -1e4..1e4f64), 1..6), 1u32..50)
}

/// A motion in the sample time of `machine`, below.
fn asked((lines, blend): (Vec<(u32, f64)>, u32), resolution: f32) -> Motion {
    // This is the resolution as a file says it.
    let resolution_deg: f64 = resolution.to_string().parse().unwrap();
    let to = |deg: f64| position(deg / resolution_deg);
    if let [(_, deg)] = lines[..] {
        return Motion::Step(to(deg));
    }
    if let [(_, deg), _] = lines[..] {
        let amplitude = (0.5 * deg / resolution_deg) as f32;
        let frequency = (f64::from(blend) * 0.01) as f32;
        return Motion::Sine { from: Position::default(), amplitude, frequency };
    }
    let mut tick = 0;
    let corners = lines.into_iter().map(|(ticks, deg)| {
        tick += ticks + 2 * blend;
        Corner { tick, position: to(deg) }
    });
    Motion::Trajectory { corners: corners.collect(), half_blend: blend as f32 * 0.005 }
}

/// Whether a file may ask for the motion: neither a step nowhere nor a way from nowhere to nowhere
/// is one.
fn moves(motion: &Motion) -> bool {
    match motion {
        Motion::Step(to) => *to != Position::default(),
        Motion::Trajectory { corners, .. } => {
            corners.windows(2).any(|pair| pair[0].position != pair[1].position)
        }
        Motion::Sine { amplitude, .. } => *amplitude != 0.0,
        Motion::Hold | Motion::Ramp { .. } | Motion::Profiled(_) => false,
    }
}

fn machine() -> impl Strategy<Value = Parameters> {
    let numbers = vec(0.0f32..1.0, 30);
    (numbers, gains(), motion(), any::<[bool; 4]>(), 1300.0f32..5.25e6).prop_map(
        |(n, gains, motion, flags, pwm_hz)| {
            let mut machine = srnf(&[]);
            let config = &mut machine.controller;
            config.sample_time = 0.005;
            config.velocity_window = 2 + (n[0] * 14.0) as u32;
            config.encoder.resolution = 1e-4 + n[1];
            config.encoder.counter_bits =
                if flags[0] { CounterBits::Sixteen } else { CounterBits::ThirtyTwo };
            config.encoder.direction =
                if flags[1] { Direction::Forward } else { Direction::Reverse };
            let full_scale = 0.1 + 50.0 * n[2];
            config.drive = DriveConfig {
                full_scale,
                lsb: full_scale / (2.0 + 30_000.0 * n[3]),
                mode: match (flags[2], n[3] < 0.5) {
                    (true, true) => PwmMode::LockedAntiphase,
                    (true, false) => PwmMode::Analog,
                    (false, _) => PwmMode::SignMagnitude,
                },
                pwm_hz,
                duty_max: 1.0 - n[26],
            };
            (config.pd.kp, config.pd.kd) = (10.0 * n[4], n[5]);
            config.compensator = gains.into_iter().collect();
            machine.motion = asked(motion, config.encoder.resolution);
            machine.device = stiction::parameters::DeviceConfig {
                autostart: flags[3],
                autostart_delay: 60.0 * n[6],
                soft_start: 10.0 * n[7],
                dead_time: 6e-6 * n[8],
                nominal_supply: 20.0 * n[9],
                supply_full_scale: 20.0 + 80.0 * n[10],
                wake_up: n[27],
                fault_blanking: n[27] * n[28],
                reset_pulse: n[29],
                autostart_after_dip: flags[2],
                stop_time: 10.0 * n[28],
                bootstrapped: false,
                emergency_stop: flags[1],
                brake_open: 2.0 * n[8],
                brake_close: 2.0 * n[9],
                short_brake: 10.0 * n[7],
                arming_test: if flags[2] { 90.0 } else { 0.0 },
                home_switch: if flags[1] { HomeSwitch::NormallyOpen } else { HomeSwitch::None },
                home_switch_filter: 0.1 * n[7],
                index_counts: if flags[2] { 64 + (1e6 * n[8]) as u32 } else { 0 },
                index_width: (8.0 * n[9]) as u32,
                reference: if flags[3] {
                    PositionReference::PowerOn
                } else {
                    PositionReference::Command
                },
            };
            machine.limits = stiction::Limits {
                encoder_jump: 100.0 * n[11],
                stall_effort: n[12],
                stall_time: n[13],
                reversal: n[14],
                following_error: 1e3 * n[15],
                overspeed: 1e4 * n[16],
                position_min: -360.0 * n[17],
                position_max: 360.0 * n[18],
                supply_min: n[19],
                supply_max: 100.0 * n[20],
                continuous_effort: n[21],
                thermal_time: 0.1 + 90.0 * n[22],
                link_timeout: 600.0 * n[23],
                wind_up_effort: n[24],
                wind_up_time: n[25],
                breakaway_effort: n[27],
                stall_impulse: n[28],
                stop_gain: 1e3 * n[29],
                progress_gain: 1e2 * n[29],
                oscillation_time: 100.0 * n[28],
                breakaway_min: 0.5 * n[27],
                probe_error: n[14],
                back_emf: n[15],
                play: 360.0 * n[16],
            };
            machine.profile =
                ProfileLimits::derived(&machine.controller, machine.limits.overspeed, 0.0);
            machine.profile.velocity *= 0.5 + 0.5 * n[29];
            machine
        },
    )
}

proptest! {
    #![proptest_config(ProptestConfig {
        cases: 2000,
        failure_persistence: None,
        ..ProptestConfig::default()
    })]

    #[test]
    fn any_valid_parameters_are_read_back_bit_for_bit(machine in machine()) {
        prop_assume!(machine.prepare(&STM32F405).is_ok() && moves(&machine.motion));
        prop_assert_eq!(again(&machine), Ok(machine));
    }
}

/// File -> parameters -> file -> parameters, and the file again.
#[test]
fn a_file_of_a_device_with_two_encoders_has_both() {
    let chip = [
        "load_encoder.kind=as5047p",
        "load_encoder.zero_counts=5210",
        "load_encoder.direction=reverse",
    ];
    let incremental = [
        "load_encoder.counts_per_turn=40000",
        "encoder.direction=reverse",
        "encoder.output=push-pull",
        "load_encoder.output=open-collector",
    ];
    for (laws, set) in [
        (&["robust"][..], &[][..]),
        (&["robust", "srnf", "pd"], &chip),
        (&["robust", "both"], &incremental),
        (&["robust"], &["loop.position=motor"]),
    ] {
        for plan in both_encoders(laws, set) {
            let found = parameters(&plan);
            let joint = &plan.machine.joint;
            let text = render(&found, joint, "two.toml").unwrap();
            let read_back = read("pulled.toml", &text).unwrap();
            assert_eq!(read_back, found, "{set:?}: {text}");
            assert_eq!(render(&read_back, joint, "two.toml").unwrap(), text);
            let has_two = found.controller.motor.count().is_some();
            assert_eq!(text.contains("[motor_encoder]"), has_two, "{text}");
            assert_eq!(has_two, !set.contains(&"loop.position=motor"));
        }
    }
}

/// Its joint has both encoders on one rigid axis.
#[test]
fn a_file_of_a_device_with_two_encoders_can_be_edited_pushed_and_simulated() {
    let plan = &both_encoders(&["robust"], &["reference.steps_deg=[5.0]"])[0];
    let text = render(&parameters(plan), &plan.machine.joint, "two.toml").unwrap();
    let edited = text.replacen("twist_deg = ", "twist_deg = 1", 1);
    let twist = |text: &str| read("edited.toml", text).unwrap().controller.motor.twist;
    assert!(twist(&edited) > 10.0 && twist(&text) < 10.0, "{} {}", twist(&edited), twist(&text));
    let changed = changes(&read("", &text).unwrap(), &read("", &edited).unwrap()).unwrap();
    assert!(
        changed.len() == 1 && changed[0].starts_with("motor_encoder.twist_deg: "),
        "{changed:?}"
    );
    let document = Document::parse("pulled", &text).unwrap();
    let plans = Experiment::plan(&document, &[], &[]).unwrap().runs;
    let run = &simulator::run::run_all(&plans).unwrap()[0];
    let simulator::run::RunTrace::Loop(samples) = &run.trace else { panic!("a ramp") };
    let off = samples.last().unwrap().tick.counts - (5.0 * 16384.0 / 360.0_f64).round() as i32;
    assert!(off.abs() <= 2, "{off} counts off");
    // A count of zero would be a joint with one encoder.
    let line = text.split("[motor_encoder]").nth(1).unwrap();
    let line = line.lines().find(|line| line.starts_with("resolution_deg")).unwrap();
    let zero = text.replacen(line, "resolution_deg = 0.0", 1);
    let why = read("zero.toml", &zero).unwrap_err().to_string();
    assert!(why.contains("motor_encoder.resolution_deg") && why.contains("above 0"), "{why}");
}
