//! Validation: which values are refused, and under which key.

use stiction::control::laws::RobustGains;
use stiction::parameters;
use stiction::{Allowed, InvalidValue};

use super::fixture::*;

/// What is meant to be allowed for every number: the law whose gain it is, its name, and its
/// bounds. The bounds of the drive's LSB and of its PWM come from elsewhere, those of a breakaway
/// range from each other, and have tests of their own.
const BOUNDS: [(&str, &str, Allowed); 42] = [
    ("", "sample_time_s", Allowed::Above(0.0, 1.0)),
    ("", "resolution_deg", Allowed::Above(0.0, LARGEST)),
    ("", "full_scale_v", Allowed::Above(0.0, LARGEST)),
    ("", "kp_v_per_deg", Allowed::Between(0.0, LARGEST)),
    ("", "kd_v_per_deg_per_s", Allowed::Between(0.0, LARGEST)),
    ("ri", "ki_v_per_deg_s", Allowed::Between(0.0, LARGEST)),
    ("ri", "theta_ri_deg", Allowed::Between(0.0, LARGEST)),
    ("rvi", "ki_v_per_deg_s", Allowed::Between(0.0, LARGEST)),
    ("rvi", "gamma_deg2_per_s2", Allowed::Above(0.0, LARGEST)),
    ("roi", "t_roi_s", Allowed::Between(0.0, LARGEST)),
    ("", "duty_max", Allowed::Above(0.0, 1.0)),
    ("roi", "v_roi_deg_per_s", Allowed::Between(0.0, LARGEST)),
    ("feedforward", "v_slip_v", Allowed::Between(0.0, LARGEST)),
    ("feedforward", "v_ff_deg_per_s", Allowed::Between(0.0, LARGEST)),
    ("feedforward", "viscous_v_per_deg_per_s", Allowed::Between(0.0, LARGEST)),
    ("feedforward", "inertia_v_per_deg_per_s2", Allowed::Between(0.0, LARGEST)),
    ("dnpf", "theta_b_deg", Allowed::Between(0.0, LARGEST)),
    ("srnf", "v_ms_v", Allowed::Between(0.0, LARGEST)),
    ("srnf", "alpha_per_deg", Allowed::Between(0.0, LARGEST)),
    ("observer", "observer_bandwidth_rad_per_s", Allowed::Above(0.0, LARGEST)),
    ("observer", "observer_inertia_v_per_deg_per_s2", Allowed::Above(0.0, LARGEST)),
    ("observer", "observer_viscous_v_per_deg_per_s", Allowed::Between(0.0, LARGEST)),
    ("observer", "observer_slip_v", Allowed::Between(0.0, LARGEST)),
    ("observer", "observer_band_deg", Allowed::Between(0.0, LARGEST)),
    ("observer", "observer_ramp_v_per_s", Allowed::Between(0.0, LARGEST)),
    ("observer", "observer_largest_v", Allowed::Between(0.0, LARGEST)),
    ("robust", "inertia_v_s2_per_deg", Allowed::Above(0.0, LARGEST)),
    ("robust", "viscous_v_s_per_deg", Allowed::Between(0.0, LARGEST)),
    ("robust", "jitter_counts", Allowed::Between(0.0, 100.0)),
    ("robust", "load_v", Allowed::OrOff(0.0, LARGEST)),
    ("robust", "hold_effort_v", Allowed::Between(-LARGEST, LARGEST)),
    ("robust", "bandwidth_rad_per_s", Allowed::Between(0.0, LARGEST)),
    ("robust", "damping_ratio", Allowed::Between(0.0, LARGEST)),
    ("robust", "observer_rad_per_s", Allowed::Between(0.0, LARGEST)),
    ("robust", "acceleration_deg_per_s2", Allowed::Between(0.0, LARGEST)),
    ("robust", "speed_deg_per_s", Allowed::Between(0.0, LARGEST)),
    ("robust", "friction_learned_to_deg_per_s", Allowed::Between(0.0, LARGEST)),
    ("robust", "tracking_observer_rad_per_s", Allowed::Between(0.0, LARGEST)),
    ("robust", "stop_band_counts", Allowed::Between(0.0, LARGEST)),
    ("robust", "hold_step_v", Allowed::Between(0.0, LARGEST)),
    ("robust", "least_gain", Allowed::Between(0.0, 1.0)),
    ("robust", "coast_s", Allowed::Between(0.0, 10.0)),
];

/// The same of the laws that live on the host.
const RIVALS: &[(&str, &str, Allowed)] = if cfg!(feature = "rivals") {
    &[
        ("pid", "ki_v_per_deg_s", Allowed::Between(0.0, LARGEST)),
        ("two-reset-pid", "ki_v_per_deg_s", Allowed::Between(0.0, LARGEST)),
        ("two-reset-pid", "load_time_s", Allowed::Above(0.0, LARGEST)),
        ("impulsive", "pulse_inertia_v_per_deg_per_s2", Allowed::Above(0.0, LARGEST)),
        ("impulsive", "pulse_friction_low_v", Allowed::Above(0.0, LARGEST)),
        ("impulsive", "pulse_friction_high_v", Allowed::Above(0.0, LARGEST)),
        ("impulsive", "pulse_effort_v", Allowed::Between(0.0, LARGEST)),
        ("proxy-sliding-mode", "proxy_stiffness_v_per_deg", Allowed::Above(0.0, LARGEST)),
        ("proxy-sliding-mode", "proxy_damping_v_per_deg_per_s", Allowed::Between(0.0, LARGEST)),
        ("proxy-sliding-mode", "proxy_integral_v_per_deg_s", Allowed::Between(0.0, LARGEST)),
        ("proxy-sliding-mode", "proxy_surface_time_s", Allowed::Between(0.0, LARGEST)),
    ]
} else {
    &[]
};

const ELSEWHERE: [&str; 4] = ["lsb_v", "pwm_hz", "breakaway_low_v", "breakaway_high_v"];

#[test]
fn every_number_is_refused_just_outside_its_range_and_taken_at_its_ends() {
    let mut seen = 0;
    let plain = configured(0.17, &[]);
    let of_loop = keys(&plain).into_iter().map(|key| ("", key, plain.clone()));
    // A law stands second, behind one that is in order.
    let of_laws = laws().flat_map(|(name, _, law)| {
        let before = if law == SRNF { RI } else { SRNF };
        let sum = if law.replaces_pd() { vec![law] } else { vec![before, law] };
        let config = configured(0.17, &sum);
        keys(&law).into_iter().map(move |key| (name, key, config.clone()))
    });
    for (law, key, base) in of_loop.chain(of_laws) {
        let Some(about) = parameters::about(key).filter(|about| about.kind == Kind::Number) else {
            continue;
        };
        let name = about.name;
        if ELSEWHERE.contains(&name) {
            continue;
        }
        seen += 1;
        let meant = BOUNDS.iter().chain(RIVALS).find(|(of, value, _)| (*of, *value) == (law, name));
        let (_, _, allowed) =
            *meant.unwrap_or_else(|| panic!("{law} {name}: say above what is allowed"));
        let with = |x: f32| {
            let mut config = base.clone();
            assert_eq!(config.set(key, x.to_bits()), Ok(true));
            if name == "full_scale_v" {
                config.drive.lsb = x;
            }
            Controller::new(&config, &STM32F405)
        };
        let (smallest, largest) = match allowed {
            Allowed::Between(low, high) | Allowed::OrOff(low, high) => (low, high),
            Allowed::Above(low, high) => (low.next_up(), high),
            other => panic!("{other:?}"),
        };
        assert!(
            with(smallest).is_ok() && with(largest).is_ok(),
            "{law} `{name}` is refused at the ends of its range"
        );
        let outside = [
            f32::NAN,
            f32::INFINITY,
            f32::NEG_INFINITY,
            -1.0,
            smallest.next_down(),
            largest.next_up(),
        ];
        // A step down from zero is the smallest negative number, one from that is zero.
        for x in outside.into_iter().filter(|x| !allowed.includes(*x)) {
            let error = with(x).expect_err(name);
            assert_eq!((error.key, error.allowed), (key, allowed), "{law} `{name}`: {x}");
            assert_eq!(error.found.to_bits(), x.to_bits(), "{law} `{name}`");
        }
    }
    assert_eq!(seen, BOUNDS.len() + RIVALS.len());
}

#[test]
fn breakaway_range_is_refused_unless_it_is_in_order_and_above_zero() {
    let Some((_, _, Gains::Robust(example))) = laws().find(|law| law.0 == "robust") else {
        unreachable!()
    };
    let refused = |breakaway_low: f32, breakaway_high: f32| {
        let law = Gains::Robust(RobustGains { breakaway_low, breakaway_high, ..example });
        Controller::new(&configured(0.17, &[law]), &STM32F405).err().map(name_of)
    };
    assert_eq!(refused(2.0, 2.0), None);
    assert_eq!(refused(0f32.next_up(), LARGEST), None);
    assert_eq!(refused(2.0, 2f32.next_down()), Some("breakaway_high_v"));
    assert_eq!(refused(2.0, LARGEST.next_up()), Some("breakaway_high_v"));
    assert_eq!(refused(2.0, f32::NAN), Some("breakaway_high_v"));
    assert_eq!(refused(0.0, 2.0), Some("breakaway_low_v"));
    assert_eq!(refused(f32::NAN, 2.0), Some("breakaway_low_v"));
}

/// The laws of the thesis have its gains (Tables 17 and 18) by default.
#[test]
fn examples_of_the_laws_are_the_gains_of_the_thesis() {
    assert_eq!(Gains::EXAMPLES[..6], [RI, RVI, ROI, FEEDFORWARD, DNPF, SRNF]);
}

/// Returns the name of the value that was refused.
fn name_of(error: InvalidValue) -> &'static str {
    parameters::about(error.key).unwrap().name
}

#[test]
fn drive_and_window_are_refused_just_outside_their_ranges() {
    let refused = |change: &dyn Fn(&mut ControllerConfig)| {
        Controller::new(&changed(&configured(0.17, &[RI]), change), &STM32F405).err().map(name_of)
    };
    for lsb in [f32::NAN, -0.00488, 0.0, 5.0 / 32_768.0, 5f32.next_up()] {
        assert_eq!(refused(&|config| config.drive.lsb = lsb), Some("lsb_v"), "{lsb}");
    }
    for lsb in [(5f32 / 32_768.0).next_up(), 5.0] {
        assert_eq!(refused(&|config| config.drive.lsb = lsb), None, "{lsb}");
    }
    // 168 MHz / 32 is the highest of which 16 duties are left; the lowest is a top of 16 bits, in
    // whole hundreds.
    for hz in [f32::NAN, -22e3, 0.0, 1300f32.next_down(), 5.25e6f32.next_up(), 1e9f32.next_up()] {
        let config = changed(&configured(0.17, &[RI]), |config| config.drive.pwm_hz = hz);
        let error = Controller::new(&config, &STM32F405).unwrap_err();
        assert_eq!(
            (name_of(error), error.allowed),
            ("pwm_hz", Allowed::Between(1300.0, 5.25e6)),
            "{hz}"
        );
    }
    for hz in [1300.0, 5.25e6] {
        assert_eq!(refused(&|config| config.drive.pwm_hz = hz), None, "{hz}");
    }
    for window in [0, 1, 17, u32::MAX] {
        assert_eq!(
            refused(&|config| config.velocity_window = window),
            Some("velocity_window"),
            "{window}"
        );
    }
    for window in [2, 16] {
        assert_eq!(refused(&|config| config.velocity_window = window), None, "{window}");
    }
}

#[test]
fn trajectory_is_refused_unless_its_blends_have_room() {
    // Blends of 12.5 ticks on either side.
    let refused = |ticks: &[u32], half_blend_s, sample_time, resolution| -> Option<InvalidValue> {
        let corners: Vec<_> = ticks.iter().map(|&tick| corner(tick, Position::default())).collect();
        Trajectory::new(&corners, half_blend_s, sample_time, resolution).err()
    };
    let key_of = |ticks: &[u32]| refused(ticks, 0.25, SAMPLE_TIME, RESOLUTION).map(name_of);
    assert_eq!(key_of(&[13]), None);
    assert_eq!(key_of(&[12]), Some("corner_times_s"));
    assert_eq!(key_of(&[50, 75, 100]), None);
    for overlapping in [&[50, 75, 99], &[50, 74, 100], &[50, 50, 100], &[50, 100, 60]] {
        assert_eq!(key_of(overlapping), Some("corner_times_s"), "{overlapping:?}");
    }
    let evenly = |n: u32| (1..=n).map(|i| 25 * i).collect::<Vec<_>>();
    assert_eq!(key_of(&[]), Some("corner_times_s"));
    assert_eq!(key_of(&evenly(16)), None);
    assert_eq!(key_of(&evenly(17)), Some("corner_times_s"));

    let overlap = refused(&[50, 74], 0.25, SAMPLE_TIME, RESOLUTION).unwrap();
    assert_eq!((overlap.found, overlap.allowed), (74.0 * SAMPLE_TIME, Allowed::LaterBy(0.5)));

    let key_of = |half_blend_s, sample_time, resolution| {
        refused(&[1_000_000], half_blend_s, sample_time, resolution).map(name_of)
    };
    assert_eq!(key_of(0.01, SAMPLE_TIME, RESOLUTION), None);
    for half_blend_s in [f32::NAN, -0.25, 0.0, (0.5 * SAMPLE_TIME).next_down(), f32::INFINITY] {
        assert_eq!(
            key_of(half_blend_s, SAMPLE_TIME, RESOLUTION),
            Some("half_blend_s"),
            "{half_blend_s}"
        );
    }
    for sample_time in [f32::NAN, -0.02, 0.0, 1f32.next_up()] {
        assert_eq!(key_of(0.25, sample_time, RESOLUTION), Some("sample_time_s"), "{sample_time}");
    }
    for resolution in [f32::NAN, -0.00242, 0.0, LARGEST.next_up()] {
        assert_eq!(key_of(0.25, SAMPLE_TIME, resolution), Some("resolution_deg"), "{resolution}");
    }
}
