//! The functions of C against the positioner, and what they do with bad pointers.

use core::ptr;

use stiction::positioner::{
    EncoderSide, Mode, Positioner, PositionerConfig, RunawayMonitors, Target,
};

use crate::*;

const CONFIG: StictionConfig = StictionConfig {
    size: size_of::<StictionConfig>() as u32,
    sample_time: 1e-3,
    counts_per_turn: 100_000.0,
    largest_effort: 16.0,
    effort_step: 0.015_625,
    inertia: 0.12,
    viscous: 0.9,
    breakaway_low: 0.9,
    breakaway_high: 3.0,
    load: 0.5,
    hold_effort: 0.25,
    jitter: 2.0,
    speed: 1.5,
    acceleration: 20.0,
    encoder_side: STICTION_ENCODER_AT_LOAD,
};

const MONITORS: StictionMonitorConfig = StictionMonitorConfig {
    size: size_of::<StictionMonitorConfig>() as u32,
    range_low: -1.0,
    range_high: 1.5,
    continuous_effort: 6.0,
    thermal_time: 10.0,
};

/// The same in Rust: each field has a value of its own, so that none can be taken for another.
const SAME: PositionerConfig = PositionerConfig {
    sample_time: 1e-3,
    counts_per_turn: 100_000.0,
    largest_effort: 16.0,
    effort_step: 0.015_625,
    inertia: 0.12,
    viscous: 0.9,
    breakaway: [0.9, 3.0],
    load: 0.5,
    hold_effort: 0.25,
    jitter: 2.0,
    speed: 1.5,
    acceleration: 20.0,
    encoder_side: EncoderSide::Load,
};

const fn empty() -> Stiction {
    Stiction::EMPTY
}

/// Counter of a joint that follows each effort beyond its friction: of no physics, but in motion.
fn moved(counts: i32, effort: f32) -> i32 {
    if effort.abs() > 2.0 { counts + (effort * 4.0) as i32 } else { counts }
}

#[test]
fn efforts_modes_and_faults_are_those_of_rust_to_the_last_bit() {
    let positioner = Positioner::new(&SAME).unwrap();
    let monitors = RunawayMonitors::new(
        &SAME,
        &stiction::positioner::MonitorConfig {
            range: [-1.0, 1.5],
            continuous_effort: 6.0,
            thermal_time: 10.0,
        },
    )
    .unwrap();
    let mut state = positioner.start();
    let mut seen = monitors.start(0);
    let mut joint = empty();
    let mut watch = StictionMonitors::EMPTY;
    let (mut counts, mut modes, mut fault) = (0, [0; 6], 0);
    // SAFETY: all memory is this test's.
    unsafe {
        assert_eq!(stiction_init(&mut joint, &CONFIG, ptr::null_mut()), STICTION_OK);
        let made = stiction_monitors_init(&mut watch, &CONFIG, &MONITORS, 0, ptr::null_mut());
        assert_eq!(made, STICTION_OK);
        for tick in 0..3000 {
            let angle = if tick < 1500 { 0.4 } else { -0.2 };
            let target = Target::at_rest(positioner.position(angle));
            let mut same =
                StictionTarget { counts: 0, fraction: 0.0, velocity: 9.0, acceleration: 9.0 };
            assert_eq!(stiction_target(&joint, angle, &mut same), STICTION_OK);
            // Each way to ask for the same.
            let effort = match tick % 3 {
                0 => stiction_tick(&mut joint, counts, angle),
                1 => stiction_follow(&mut joint, counts, &same),
                _ => stiction_follow_applied(&mut joint, counts, &same, 1.25),
            };
            let expected = match tick % 3 {
                2 => positioner.tick_applied(&mut state, counts, target, 1.25),
                _ => positioner.tick(&mut state, counts, target),
            };
            assert_eq!(effort.to_bits(), expected.to_bits(), "{tick}");
            let mode = stiction_mode(&joint);
            assert_eq!(mode, positioner.mode(&state) as i32, "{tick}");
            modes[mode as usize] += 1;
            let mut value = 0.0;
            let tripped = stiction_monitors_check(&mut watch, counts, &same, effort, &mut value);
            let trip = monitors.check(&mut seen, counts, target, expected);
            assert_eq!(tripped, trip.map_or(0, |trip| trip.fault as i32), "{tick}");
            assert_eq!(value.to_bits(), trip.map_or(0.0, |trip| trip.value).to_bits(), "{tick}");
            if tick == 2801 {
                fault = tripped;
            }
            counts = moved(counts, effort);
            if tick == 2800 {
                counts += 20_000;
            }
            if tick == 2500 {
                assert_eq!(stiction_restart(&mut joint), STICTION_OK);
                positioner.restart(&mut state);
                assert_eq!(stiction_monitors_idle(&mut watch, counts), STICTION_OK);
                monitors.idle(&mut seen, counts);
                assert_eq!(stiction_monitors_arm(&mut watch, counts), STICTION_OK);
                seen = monitors.armed(&seen, counts);
            }
        }
    }
    assert!(modes[Mode::Move as usize] > 100 && modes[Mode::Stuck as usize] > 0, "{modes:?}");
    assert_eq!(fault, STICTION_ENCODER_JUMP);
}

#[test]
fn a_refusal_names_the_field_with_its_range_and_leaves_a_joint_without_effort() {
    let mut joint = empty();
    let nothing = StictionRefusal { field: [1; 24], found: 0.0, low: 0.0, high: 0.0 };
    let wrong = [
        (StictionConfig { breakaway_high: 30.0, ..CONFIG }, "breakaway_high", [30.0, 0.9, 16.0]),
        (StictionConfig { size: 8, ..CONFIG }, "size", [8.0, 60.0, 60.0]),
        (StictionConfig { encoder_side: 2, ..CONFIG }, "encoder_side", [2.0, 0.0, 1.0]),
    ];
    for (config, field, [found, low, high]) in wrong {
        let mut why = nothing;
        // SAFETY: all memory is this test's.
        unsafe {
            assert_eq!(stiction_init(&mut joint, &CONFIG, &mut why), STICTION_OK);
            assert_eq!(stiction_init(&mut joint, &config, &mut why), STICTION_REFUSED);
            let end = why.field.iter().position(|byte| *byte == 0).unwrap();
            assert_eq!(core::str::from_utf8(&why.field[..end]).unwrap(), field);
            assert_eq!((why.found, why.low, why.high), (found, low, high));
            // Also with a valid joint before.
            assert_eq!(stiction_tick(&mut joint, 0, 1.0), 0.0);
            assert_eq!(stiction_mode(&joint), STICTION_NOT_READY);
        }
    }
    let monitors = StictionMonitorConfig { range_low: 2.0, ..MONITORS };
    let (mut watch, mut why) = (StictionMonitors::EMPTY, nothing);
    // SAFETY: all memory is this test's.
    let code = unsafe { stiction_monitors_init(&mut watch, &CONFIG, &monitors, 0, &mut why) };
    assert_eq!(code, STICTION_REFUSED);
    assert_eq!(&why.field[..11], b"range_high\0");
}

#[test]
fn null_misaligned_and_uninitialised_memory_gives_codes_and_no_effort() {
    let (mut joint, mut watch) = (empty(), StictionMonitors::EMPTY);
    let target = StictionTarget { counts: 9, fraction: 0.0, velocity: 0.0, acceleration: 0.0 };
    let nowhere = ptr::null_mut();
    // SAFETY: all memory is this test's; the functions do not follow the other pointers.
    unsafe {
        let odd = ptr::from_mut(&mut joint).cast::<u8>().add(1).cast::<Stiction>();
        for bad in [ptr::null_mut(), odd] {
            assert_eq!(stiction_init(bad, &CONFIG, nowhere), STICTION_BAD_POINTER);
            assert_eq!(stiction_tick(bad, 0, 1.0), 0.0);
            assert_eq!(stiction_mode(bad), STICTION_NOT_READY);
        }
        assert_eq!(stiction_init(&mut joint, ptr::null(), nowhere), STICTION_BAD_POINTER);
        assert_eq!(stiction_follow(&mut joint, 0, &target), 0.0);
        assert_eq!(stiction_restart(&mut joint), STICTION_NOT_READY);
        // Monitors that do not work are no permission to go on.
        let check = stiction_monitors_check(&mut watch, 0, &target, 0.0, ptr::null_mut());
        assert_eq!(check, STICTION_NOT_READY);
        assert_eq!(stiction_init(&mut joint, &CONFIG, nowhere), STICTION_OK);
        assert_eq!(stiction_follow(&mut joint, 0, ptr::null()), 0.0);
        assert!(stiction_follow(&mut joint, 0, &StictionTarget { counts: 900, ..target }) != 0.0);
    }
}
