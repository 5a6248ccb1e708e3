//! Every term of a tick is held against the thesis's equations in `f64`, and the laws are tested at
//! their thresholds.

use proptest::prelude::*;

use super::fixture::*;
use super::observer_equation::ObserverEquation;
#[cfg(feature = "rivals")]
use super::rival_equations::RivalEquation;

/// The laws by the thesis's eqs. 29 to 35 in `f64`, from a tick's inputs.
struct Equation {
    gains: Gains,
    h: f64,
    kp: f64,
    v_c: f64,
    /// Ticks in which ROI has been active without a break.
    active: u32,
    observer: ObserverEquation,
    #[cfg(feature = "rivals")]
    rival: RivalEquation,
}

impl Equation {
    const FULL_SCALE: f64 = 5.0;

    fn new(gains: Gains, h: f64, kp: f64) -> Self {
        Self {
            gains,
            h,
            kp,
            v_c: 0.0,
            active: 0,
            observer: ObserverEquation::default(),
            #[cfg(feature = "rivals")]
            rival: RivalEquation::default(),
        }
    }

    fn evaluate(&mut self, tick: &Tick) -> f64 {
        let error = f64::from(tick.error);
        let velocity_error = tick.reference_velocity - tick.velocity;
        self.v_c = match self.gains {
            Gains::ResetIntegral(ResetIntegralGains { ki, theta_ri }) => {
                if tick.error.abs() <= theta_ri {
                    self.v_c + f64::from(ki) * error * self.h
                } else {
                    0.0
                }
            }
            Gains::RateVariableIntegral(RateVariableIntegralGains { ki, gamma }) => {
                let gamma_h = f64::from(gamma) * 0.02 / self.h;
                let leak = gamma_h / (gamma_h + f64::from(tick.velocity).powi(2));
                (self.v_c + f64::from(ki) * error * self.h) * leak
            }
            Gains::ResetOffsetIntegral(ResetOffsetIntegralGains { t_roi, v_roi }) => {
                let period = (f64::from(t_roi) / self.h).round() as u32;
                if velocity_error.abs() < v_roi {
                    let due = self.active > 0 && self.active.is_multiple_of(period);
                    self.active += 1;
                    self.v_c + if due { f64::from(tick.v_pd) } else { 0.0 }
                } else {
                    self.active = 0;
                    0.0
                }
            }
            Gains::Feedforward(FeedforwardGains { v_slip, v_ff, viscous, inertia }) => {
                let speed = tick.reference_velocity;
                let slips = speed.abs() > v_ff;
                let slip = if slips { f64::from(v_slip) * f64::from(speed.signum()) } else { 0.0 };
                let acceleration = f64::from(tick.reference_acceleration);
                slip + f64::from(viscous) * f64::from(speed) + f64::from(inertia) * acceleration
            }
            Gains::DiscontinuousNonlinearProportional(
                DiscontinuousNonlinearProportionalGains { theta_b },
            ) => {
                if tick.error.abs() > theta_b || tick.error == 0.0 {
                    0.0
                } else {
                    self.kp * (f64::from(theta_b) * error.signum() - error)
                }
            }
            Gains::SmoothRobustNonlinear(SmoothRobustNonlinearGains { v_ms, alpha }) => {
                f64::from(v_ms) * (f64::from(alpha) * error).tanh()
            }
            Gains::DisturbanceObserver(gains) => self.observer.evaluate(&gains, tick, self.h),
            // Its second version are the traces of `tests/robust/`.
            Gains::Robust(_) => f64::from(tick.v_c),
            #[cfg(feature = "two-encoders")]
            Gains::RobustDual(_) => f64::from(tick.v_c),
            #[cfg(feature = "rivals")]
            Gains::Pid(_)
            | Gains::TwoResetPid(_)
            | Gains::Impulsive(_)
            | Gains::ProxySlidingMode(_) => return self.rival.evaluate(&self.gains, tick, self.h),
            // A function of the host; the tests of `shared-law` compare one with PD.
            #[cfg(feature = "rivals")]
            Gains::Guest(_) => f64::from(tick.v_c),
        };
        self.v_c = self.v_c.clamp(-Self::FULL_SCALE, Self::FULL_SCALE);
        self.v_c
    }
}

/// Volts by which `f32` may differ from `f64` after some hundred sums: a fiftieth of the drive's
/// LSB.
const ROUNDING_V: f64 = 1e-4;

proptest! {
    #![proptest_config(config())]

    #[test]
    fn every_term_follows_its_equation(
        reference in reference(),
        lags in lags(),
        sample_time in prop_oneof![Just(0.02f32), Just(0.005), Just(0.001)],
        kp in prop_oneof![Just(1.0f32), Just(2.5)],
    ) {
        let counts = near(&reference, &lags);
        for (name, config) in controllers() {
            let config = changed(&config, |config| {
                (config.sample_time, config.pd.kp) = (sample_time, kp);
            });
            let controller = Controller::new(&config, &STM32F405).unwrap();
            let (h, kp) = (f64::from(sample_time), f64::from(kp));
            let mut law = config.compensator.first().map(|&gains| Equation::new(gains, h, kp));
            let replaces_pd = config.compensator.first().is_some_and(Gains::replaces_pd);
            let ticks = run(&controller, &reference, &counts, low_half);
            for (number, (&counts, tick)) in (0..).zip(counts.iter().zip(ticks)) {
                prop_assert_eq!((tick.tick, tick.counts), (number, counts), "{}", name);
                prop_assert_eq!(tick.setpoint(), reference.at(number), "{}", name);
                let Setpoint { position, velocity, .. } = tick.setpoint();
                let ahead = f64::from(position.counts) - f64::from(counts)
                    + f64::from(position.fraction);
                let error = ahead * f64::from(RESOLUTION);
                let off = (f64::from(tick.error) - error).abs();
                prop_assert!(off <= 1e-6 * error.abs(), "{name}: {tick:?}");
                let kd = f64::from(config.pd.kd);
                let v_pd = kp * error + kd * (f64::from(velocity) - f64::from(tick.velocity));
                let v_pd = if replaces_pd { 0.0 } else { v_pd };
                let v_c = law.as_mut().map_or(0.0, |law| law.evaluate(&tick));
                for (found, expected) in [(tick.v_pd, v_pd), (tick.v_c, v_c)] {
                    let off = (f64::from(found) - expected).abs();
                    prop_assert!(off <= ROUNDING_V, "{name}: {tick:?}, not {expected}");
                }
            }
        }
    }
}

/// An error that stays for 40 s asks RI and RVI for many times the full scale.
#[test]
fn integral_stops_at_the_full_scale_and_leaves_it_at_once() {
    let around = configured(0.17, &[]).around();
    for (law, gain_v_per_deg) in [(RI, 4.0 * 0.02), (RVI, 150.0 * 0.02)] {
        let law = PreparedLaw::new(&law, &around).unwrap();
        for sign in [1.0, -1.0] {
            let mut state = law.rest();
            let sample = LawInput { error: 0.45 * sign, ..LawInput::default() };
            for k in 1..=2000 {
                let v_c = law.update(&mut state, &sample) * sign;
                let integral = gain_v_per_deg * 0.45 * k as f32;
                assert!(
                    (v_c - integral.min(5.0)).abs() < 1e-3,
                    "{law:?}: {v_c} at sample {k}, not {integral}"
                );
            }
            assert_eq!(law.update(&mut state, &sample), 5.0 * sign);
            let back = law.update(&mut state, &LawInput { error: -0.01 * sign, ..sample });
            assert!((back * sign - (5.0 - gain_v_per_deg * 0.01)).abs() < 1e-6, "{law:?}: {back}");
        }
    }
    let law = PreparedLaw::new(&ROI, &around).unwrap();
    let mut state = law.rest();
    let pushing = LawInput { v_pd: 2.0, ..LawInput::default() };
    // Increments fall due after 7, 14 and 21 samples, and give 2 V, 4 V, and no more than the full
    // scale.
    let v_c: Vec<_> = (0..=29).map(|_| law.update(&mut state, &pushing)).collect();
    assert_eq!(
        [6, 7, 13, 14, 20, 21, 28].map(|k: usize| v_c[k]),
        [0.0, 2.0, 2.0, 4.0, 4.0, 5.0, 5.0]
    );
}

/// An equation with a threshold says to which side it belongs.
#[test]
fn laws_switch_at_their_thresholds_and_not_beside_them() {
    let around = configured(0.17, &[]).around();
    for sign in [1.0, -1.0] {
        let acts = |law: Gains, sample: LawInput| {
            let law = PreparedLaw::new(&law, &around).unwrap();
            let mut state = law.rest();
            // ROI's first increment falls due after seven samples.
            (0..=7).map(|_| law.update(&mut state, &sample)).last() != Some(0.0)
        };
        let error = |size: f32| LawInput { error: size * sign, ..LawInput::default() };
        assert_eq!([0.5f32, 0.5f32.next_up()].map(|e| acts(RI, error(e))), [true, false]);
        // At the threshold itself the equation gives zero from either side.
        assert_eq!(
            [0f32, 0.39, 0.4, 0.41].map(|e| acts(DNPF, error(e))),
            [false, true, false, false]
        );

        let velocity_error =
            |size: f32| LawInput { velocity_error: size * sign, v_pd: 0.1, ..LawInput::default() };
        assert_eq!(
            [2.33f32.next_down(), 2.33].map(|v| acts(ROI, velocity_error(v))),
            [true, false]
        );

        let reference = |size: f32| {
            let setpoint = Setpoint { velocity: size * sign, ..Setpoint::default() };
            LawInput { setpoint, ..LawInput::default() }
        };
        assert_eq!(
            [0.001f32, 0.001f32.next_up()].map(|v| acts(FEEDFORWARD, reference(v))),
            [false, true]
        );
    }
}
