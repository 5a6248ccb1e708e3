//! What is refused, and under which key.

use stiction::{Allowed, Error};

use super::fixture::*;

/// A key, whether zero is allowed, the largest value that is, and how to set it.
type Key = (&'static str, bool, f32, fn(&mut ControllerConfig, f32));

/// Laws are put second, behind one that is in order.
fn put(config: &mut ControllerConfig, law: Gains) {
    config.compensator = [SRNF, law].into_iter().collect();
}

#[test]
fn every_number_is_refused_just_outside_its_range_and_taken_at_its_ends() {
    let keys: [Key; 16] = [
        ("sample_time_s", false, 1.0, |config, x| config.sample_time = x),
        ("resolution_deg", false, LARGEST, |config, x| config.encoder.resolution = x),
        ("kp_v_per_deg", true, LARGEST, |config, x| config.pd.kp = x),
        ("kd_v_per_deg_per_s", true, LARGEST, |config, x| config.pd.kd = x),
        ("full_scale_v", false, LARGEST, |config, x| (config.drive.full_scale, config.drive.lsb) = (x, x)),
        ("ki_v_per_deg_s", true, LARGEST, |config, ki| {
            put(config, Gains::ResetIntegral(ResetIntegralGains { ki, theta_ri: 0.5 }));
        }),
        ("theta_ri_deg", true, LARGEST, |config, theta_ri| {
            put(config, Gains::ResetIntegral(ResetIntegralGains { ki: 4.0, theta_ri }));
        }),
        ("ki_v_per_deg_s", true, LARGEST, |config, ki| {
            put(config, Gains::RateVariableIntegral(RateVariableIntegralGains { ki, gamma: 0.05 }));
        }),
        ("gamma_deg2_per_s2", false, LARGEST, |config, gamma| {
            put(config, Gains::RateVariableIntegral(RateVariableIntegralGains { ki: 150.0, gamma }));
        }),
        ("t_roi_s", true, LARGEST, |config, t_roi| {
            put(config, Gains::ResetOffsetIntegral(ResetOffsetIntegralGains { t_roi, v_roi: 2.33 }));
        }),
        ("v_roi_deg_per_s", true, LARGEST, |config, v_roi| {
            put(config, Gains::ResetOffsetIntegral(ResetOffsetIntegralGains { t_roi: 0.14, v_roi }));
        }),
        ("v_slip_v", true, LARGEST, |config, v_slip| {
            put(config, Gains::Feedforward(FeedforwardGains { v_slip, v_ff: 0.001 }));
        }),
        ("v_ff_deg_per_s", true, LARGEST, |config, v_ff| {
            put(config, Gains::Feedforward(FeedforwardGains { v_slip: 0.37, v_ff }));
        }),
        ("theta_b_deg", true, LARGEST, |config, theta_b| {
            let gains = DiscontinuousNonlinearProportionalGains { theta_b };
            put(config, Gains::DiscontinuousNonlinearProportional(gains));
        }),
        ("v_ms_v", true, LARGEST, |config, v_ms| {
            put(config, Gains::SmoothRobustNonlinear(SmoothRobustNonlinearGains { v_ms, alpha: 100.0 }));
        }),
        ("alpha_per_deg", true, LARGEST, |config, alpha| {
            put(config, Gains::SmoothRobustNonlinear(SmoothRobustNonlinearGains { v_ms: 0.40, alpha }));
        }),
    ];
    let base = configured(0.17, &[]);
    for (key, zero_allowed, largest, set) in keys {
        let with = |x| Controller::new(&changed(&base, |config| set(config, x)));
        let smallest = if zero_allowed { 0.0 } else { 0f32.next_up() };
        assert!(
            with(smallest).is_ok() && with(largest).is_ok(),
            "`{key}` is refused at the ends of its range"
        );
        let outside =
            [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, -1.0, smallest.next_down(), largest.next_up()];
        for x in outside {
            // A step down from zero is the smallest negative number, one from that is zero.
            let error = with(x).expect_err(key);
            assert_eq!(error.key, key, "{x}");
            assert_eq!(error.found.to_bits(), x.to_bits(), "`{key}`");
            let allowed = match zero_allowed {
                true => Allowed::Between(0.0, largest),
                false => Allowed::Above(0.0, largest),
            };
            assert_eq!(error.allowed, allowed, "`{key}`");
        }
    }
}

#[test]
fn drive_and_window_are_refused_just_outside_their_ranges() {
    let refused = |change: &dyn Fn(&mut ControllerConfig)| {
        Controller::new(&changed(&configured(0.17, &[RI]), change)).err().map(|error| error.key)
    };
    for lsb in [f32::NAN, -0.00488, 0.0, 5.0 / 32_768.0, 5f32.next_up()] {
        assert_eq!(refused(&|config| config.drive.lsb = lsb), Some("lsb_v"), "{lsb}");
    }
    for lsb in [(5f32 / 32_768.0).next_up(), 5.0] {
        assert_eq!(refused(&|config| config.drive.lsb = lsb), None, "{lsb}");
    }
    for top in [0, 1, 3817, 65_535] {
        assert_eq!(refused(&|config| config.drive.pwm_top = top), Some("pwm_top"), "{top}");
    }
    for top in [2, 65_534] {
        assert_eq!(refused(&|config| config.drive.pwm_top = top), None, "{top}");
    }
    for window in [0, 1, 17, usize::MAX] {
        assert_eq!(refused(&|config| config.velocity_window = window), Some("velocity_window"), "{window}");
    }
    for window in [2, 16] {
        assert_eq!(refused(&|config| config.velocity_window = window), None, "{window}");
    }
}

#[test]
fn trajectory_is_refused_unless_its_blends_have_room() {
    // Blends of 12.5 ticks on either side.
    let refused = |ticks: &[u32], half_blend_s, sample_time, resolution| -> Option<Error> {
        let corners: Vec<_> = ticks.iter().map(|&tick| corner(tick, Position::default())).collect();
        Trajectory::new(&corners, half_blend_s, sample_time, resolution).err()
    };
    let key_of = |ticks: &[u32]| refused(ticks, 0.25, SAMPLE_TIME, RESOLUTION).map(|error| error.key);
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
        refused(&[1_000_000], half_blend_s, sample_time, resolution).map(|error| error.key)
    };
    assert_eq!(key_of(0.01, SAMPLE_TIME, RESOLUTION), None);
    for half_blend_s in [f32::NAN, -0.25, 0.0, (0.5 * SAMPLE_TIME).next_down(), f32::INFINITY] {
        assert_eq!(key_of(half_blend_s, SAMPLE_TIME, RESOLUTION), Some("half_blend_s"), "{half_blend_s}");
    }
    for sample_time in [f32::NAN, -0.02, 0.0, 1f32.next_up()] {
        assert_eq!(key_of(0.25, sample_time, RESOLUTION), Some("sample_time_s"), "{sample_time}");
    }
    for resolution in [f32::NAN, -0.00242, 0.0, LARGEST.next_up()] {
        assert_eq!(key_of(0.25, SAMPLE_TIME, resolution), Some("resolution_deg"), "{resolution}");
    }
}
