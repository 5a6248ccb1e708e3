//! Every parameter has an effect, and no state is large.

use std::fs;
use std::mem::size_of;
use std::path::Path;

use stiction::control::laws::{
    FIRST_LAW, disturbance_observer, rate_variable_integral, reset_integral, reset_offset_integral,
    robust,
};
use stiction::parameters;

use super::fixture::*;

/// A joint that wanders about a trajectory, always the same way: within half a degree for the most
/// part, so that every threshold is crossed both ways, and once so far away that the drive
/// saturates.
fn excitation() -> (Reference, Vec<i32>) {
    let corners = [(50, 0), (300, 10_331), (350, 10_331), (600, 0)]
        .map(|(tick, counts)| corner(tick, Position::from_counts(counts)));
    let reference = through(&corners, 0.25);
    let (mut random, mut lag, mut increment) = (1u32, 0i32, 0i32);
    let lags: Vec<_> = (0..700)
        .map(|k| {
            random = random.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            match random >> 29 {
                0 => increment = 0,
                1 => increment = (random >> 8) as i32 % 60 - 30,
                _ => {}
            }
            if (lag + increment).abs() > 280 {
                increment = -increment;
            }
            lag += increment;
            if (400..420).contains(&k) { lag + 2600 } else { lag }
        })
        .collect();
    let counts = near(&reference, &lags);
    (reference, counts)
}

/// Another value: a twentieth more, or less where more is not allowed, or the next one of those
/// that there are.
fn a_little_else(values: &impl Values, key: Key) -> u32 {
    let bits = values.get(key).unwrap();
    match parameters::about(key).unwrap().kind {
        Kind::Number => {
            let (found, allowed) = values.with_bounds(key).unwrap();
            (found * if allowed.includes(1.05 * found) { 1.05 } else { 0.95 }).to_bits()
        }
        Kind::Whole => bits + 1,
        Kind::Flag => 1 - bits,
        Kind::Choice(words) => (bits + 1) % words.len() as u32,
    }
}

#[test]
fn every_parameter_of_the_controller_changes_the_output() {
    let (reference, counts) = excitation();
    let output = |config: &ControllerConfig| {
        outputs(&run(&Controller::new(config, &STM32F405).unwrap(), &reference, &counts, low_half))
    };
    // The gains of laws come next; which laws there are, is the list itself.
    let parameters: Vec<_> =
        keys(&configured(0.17, &[])).into_iter().filter(|key| *key < FIRST_LAW).collect();
    // The loop has 3, the encoder 4, the drive 5, PD 2.
    assert_eq!(parameters.len(), 14);
    for (name, config) in controllers() {
        let unchanged = output(&config);
        assert_eq!(output(&config), unchanged);
        let replaces_pd = config.compensator.first().is_some_and(Gains::replaces_pd);
        // The gains of a PD that is not there do nothing, and `robust` measures no speed. The
        // encoder's output is the servo's: tests/device/open_line.rs. What an effort is concerns
        // servo and board: tests/device/current_loop.rs.
        let has_effect = |key: &&Key| {
            let is_of_pd = replaces_pd && keys(&config.pd).contains(key);
            let field = parameters::about(**key).unwrap().name;
            let is_elsewhere = ["output", "effort"].contains(&field);
            !(is_of_pd || is_elsewhere || name == "robust" && field == "velocity_window")
        };
        for key in parameters.iter().filter(has_effect) {
            let mut changed = config.clone();
            assert_eq!(changed.set(*key, a_little_else(&config, *key)), Ok(true));
            assert_ne!(output(&changed), unchanged, "{name}: {key:?} does nothing");
        }
    }
}

/// Gains for which a twentieth more is the same, with a value that is not: a time of whole ticks,
/// a speed that the first blend passes in its first tick, terms that are zero, a band within which
/// it does not rest or between whole counts, a limit or a number of attempts that is not reached,
/// and zeros that stand for a rule or for none.
const COARSE: [(&str, &str, f32); 20] = [
    ("roi", "t_roi_s", 0.16),
    ("feedforward", "v_ff_deg_per_s", 0.2),
    ("feedforward", "viscous_v_per_deg_per_s", 0.02),
    ("feedforward", "inertia_v_per_deg_per_s2", 0.037),
    ("impulsive", "pulse_effort_v", 1.0),
    ("observer", "observer_band_deg", 0.3),
    ("robust", "jitter_counts", 60.0),
    ("robust", "load_v", 1.0),
    ("robust", "hold_effort_v", 0.3),
    ("robust", "bandwidth_rad_per_s", 5.0),
    ("robust", "observer_rad_per_s", 20.0),
    ("robust", "acceleration_deg_per_s2", 20.0),
    ("robust", "speed_deg_per_s", 3.0),
    ("robust", "stop_band_counts", 3.0),
    ("robust", "hold_step_v", 0.1),
    ("robust", "least_gain", 0.9),
    ("robust", "coast_s", 0.2),
    ("robust", "give_up_attempts", 1.0),
    ("robust", "friction_learned_to_deg_per_s", 1.0),
    ("robust", "tracking_observer_rad_per_s", 20.0),
];

/// Gains for which a joint has to answer the effort: that they do something is seen in
/// `tests/robust/`.
const ANSWERED: [(&str, &str); 3] =
    [("robust", "stop_band_counts"), ("robust", "hold_step_v"), ("robust", "least_gain")];

#[test]
fn every_gain_of_a_law_changes_the_output() {
    let (reference, counts) = excitation();
    let output = |laws: &[Gains]| {
        let controller = Controller::new(&configured(0.17, laws), &STM32F405).unwrap();
        outputs(&run(&controller, &reference, &counts, low_half))
    };
    let pd = output(&[]);
    let mut idle = Vec::new();
    for (name, _, law) in laws() {
        assert_ne!(output(&[law]), pd, "{name} does nothing");
        for key in keys(&law) {
            let coarse = COARSE
                .iter()
                .find(|(of, gain, _)| (*of, *gain) == (name, parameters::about(key).unwrap().name));
            let bits = match (coarse, parameters::about(key).unwrap().kind) {
                (None, _) => a_little_else(&law, key),
                (Some((_, _, value)), Kind::Whole) => *value as u32,
                (Some((_, _, value)), _) => value.to_bits(),
            };
            let mut changed = law;
            assert_eq!(changed.set(key, bits), Ok(true));
            if output(&[law]) == output(&[changed]) {
                idle.push((name, parameters::about(key).unwrap().name));
            }
        }
    }
    assert_eq!(idle, ANSWERED, "these do nothing");
}

/// The values that a law takes from the loop around it, apart from what the loop does by itself.
#[test]
fn laws_depend_on_their_loop_where_their_equations_say_so() {
    let (reference, counts) = excitation();
    let pd = Controller::new(&configured(0.17, &[]), &STM32F405).unwrap();
    let samples = samples_of(&run(&pd, &reference, &counts, low_half));
    let output = |law: &Gains, around: &Loop| {
        let law = Compensator::new(&[*law].into_iter().collect(), around);
        let mut state = law.rest();
        samples.iter().map(|sample| law.update(&mut state, sample)).collect::<Vec<_>>()
    };
    let base = Loop { sample_time: 0.02, full_scale: 0.5, kp: 1.0, ..Loop::EXAMPLE };
    let changes = [
        Loop { sample_time: 0.018, ..base },
        Loop { full_scale: 0.45, ..base },
        Loop { kp: 1.05, ..base },
        // A band of counts is passed over by most ticks of the excitation, unless it is wide.
        Loop { resolution: 100.0 * base.resolution, ..base },
        Loop { lsb: 1.05 * base.lsb, ..base },
    ];
    for (name, _, law) in laws() {
        // The columns are sample time, full scale, Kp, resolution and LSB.
        let expected = match name {
            "ri" | "rvi" | "roi" => [true, true, false, false, false],
            "feedforward" | "srnf" => [false; 5],
            "dnpf" => [false, false, true, false, false],
            "pid" | "two-reset-pid" | "proxy-sliding-mode" => [true, true, false, false, false],
            "impulsive" | "observer" => [true, true, false, true, false],
            // A code is the least step of the hold effort, unless 0.03 F_lo is more, as here.
            "robust" => [true, true, false, true, false],
            other => unreachable!("{other}: say here what it takes from its loop"),
        };
        let depends = changes.map(|around| output(&law, &around) != output(&law, &base));
        assert_eq!(depends, expected, "{law:?}");
    }
}

#[test]
fn states_are_small_enough_to_be_copied_in_a_tick() {
    // These are the sizes without any padding: an integral, an integral, an offset and a timer.
    assert_eq!(size_of::<reset_integral::ResetIntegralState>(), 4);
    assert_eq!(size_of::<rate_variable_integral::RateVariableIntegralState>(), 4);
    assert_eq!(size_of::<reset_offset_integral::ResetOffsetIntegralState>(), 8);
    // Three estimates, and a count of ticks.
    assert_eq!(size_of::<disturbance_observer::DisturbanceObserverState>(), 16);
    // A sum has room for the largest of them, and for which it is. Of the laws that live on the
    // host, the impulsive one has the largest state: six numbers and a flag.
    let largest = if cfg!(feature = "rivals") { 28 } else { 20 };
    assert_eq!(size_of::<LawState>(), largest);
    // Those that are too large for a sum share a place, which the larger one fills. An image has
    // one of them.
    #[cfg(not(feature = "two-encoders"))]
    let alone = size_of::<robust::RobustState>();
    #[cfg(feature = "two-encoders")]
    let alone = size_of::<stiction::control::laws::robust_dual::RobustDualState>();
    assert_eq!(size_of::<CompensatorState>(), MAX_TERMS * largest + alone);
    // Besides these a controller has the position, the velocity's fifteen increments, the tick, and
    // four words of the output stage: the ticks of the soft start, what is applied, whether that is
    // less than was asked for, and the least code of a probe.
    let of_motor = if cfg!(feature = "two-encoders") { 2 } else { 0 };
    let besides = 4 * (1 + 15 + 1 + 4 + of_motor);
    assert_eq!(size_of::<ControllerState>(), MAX_TERMS * largest + besides + alone);
    const { assert!(size_of::<LawState>() <= 64 && size_of::<robust::RobustState>() <= 256) };
    // That of an image, also where this is compiled with both laws.
    assert!(
        size_of::<ControllerState>() - alone - 4 * of_motor + size_of::<robust::RobustState>()
            <= 448
    );
}

/// A module whose law is not registered compiles, since it is public, and does nothing.
#[test]
fn every_law_that_there_is_stands_in_the_list() {
    let directory = Path::new(env!("CARGO_MANIFEST_DIR")).join("src/control/laws");
    let list = fs::read_to_string(directory.join("mod.rs")).unwrap();
    let (_, list) = list.split_once("\nlaws! {").unwrap();
    let list = list.split("\n}").next().unwrap();
    let mut laws = 0;
    for folder in [".", "rival", "robust", "robust_dual"] {
        for entry in fs::read_dir(directory.join(folder)).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                continue;
            }
            let text = fs::read_to_string(&path).unwrap();
            for rest in text.split("\nimpl Law for ").skip(1) {
                let law = rest.split(' ').next().unwrap();
                assert!(list.contains(&format!(" {law};")), "{law} of {}", path.display());
                laws += 1;
            }
        }
    }
    let numbered = |line: &&str| line.trim().starts_with(|c: char| c.is_ascii_digit());
    assert_eq!(laws, list.lines().filter(numbered).count());
}
