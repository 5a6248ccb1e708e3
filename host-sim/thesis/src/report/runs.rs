//! Runs that the report needs.

/// Runs of the robot's axis.
pub struct AxisRuns {
    /// Name in the report.
    pub name: &'static str,
    /// The built-in experiment.
    pub experiment: &'static str,
    /// Controllers; none selects all.
    pub controllers: &'static [&'static str],
    /// Keys set as by `--set`.
    pub set: &'static [&'static str],
}

/// A run of the friction lab.
pub struct LabRun {
    /// Name in the report.
    pub name: &'static str,
    /// The built-in experiment.
    pub experiment: &'static str,
    /// Friction model, as for `--friction`.
    pub model: &'static str,
    /// Solver, as for `--solver`.
    pub solver: &'static str,
    /// Keys set as by `--set`.
    pub set: &'static [&'static str],
}

/// eps of the runs whose work is counted: the thesis's first, then four values about it. The number
/// of steps that a switch takes varies by chance, so a single run says little.
pub const EPS: [&str; 5] = ["2e-4", "1.6e-4", "1.8e-4", "2.2e-4", "2.4e-4"];

impl LabRun {
    /// Returns whether the run's work is counted at every [`EPS`].
    pub fn is_scanned(&self) -> bool {
        self.name.ends_with("-work")
    }
}

const fn axis(
    name: &'static str,
    experiment: &'static str,
    controllers: &'static [&'static str],
    set: &'static [&'static str],
) -> AxisRuns {
    AxisRuns { name, experiment, controllers, set }
}

const fn lab(
    name: &'static str,
    experiment: &'static str,
    model: &'static str,
    solver: &'static str,
    set: &'static [&'static str],
) -> LabRun {
    LabRun { name, experiment, model, solver, set }
}

/// Runs of chapter 3 and appendix A.2, and of three joints beyond them.
pub const AXIS: &[AxisRuns] = &[
    axis("step-response", "step-response", &[], &[]),
    axis("trajectory", "trajectory", &[], &[]),
    axis("step-added-friction", "step-added-friction", &[], &[]),
    axis("srnf-robustness", "srnf-robustness", &[], &[]),
    axis("srnf-added-friction", "srnf-added-friction", &[], &[]),
    axis("high-gain", "high-gain", &[], &[]),
    axis("friction-identification", "friction-identification", &[], &[]),
    axis("untuned-joints", "untuned-joints", &[], &[]),
    // Hunting is slow.
    axis("long", "step-response", &[], &["run.duration_s=120"]),
    axis(
        "ri-without-drop",
        "step-response",
        &["ri"],
        &["joint.friction.stick_v=0.38", "run.duration_s=120"],
    ),
    axis(
        "ri-larger-drop",
        "step-response",
        &["ri"],
        &["joint.friction.stick_v=0.50", "run.duration_s=120"],
    ),
    axis(
        "ri-fast-step",
        "step-response",
        &["ri"],
        &["controller.ri.ki_v_per_deg_s=40", "run.duration_s=120"],
    ),
    axis("ri-fast-trajectory", "trajectory", &["ri"], &["controller.ri.ki_v_per_deg_s=40"]),
    axis("dnpf-short", "step-response", &["dnpf"], &["controller.dnpf.theta_b_deg=0.375"]),
    axis("dnpf-enough", "step-response", &["dnpf"], &["controller.dnpf.theta_b_deg=0.39"]),
];

/// Runs of chapter 2 and appendix A.1.
pub const LAB: &[LabRun] = &[
    lab("spring/karnopp", "spring-mass", "karnopp", "exact", &[]),
    lab("spring/ri", "spring-mass", "reset-integrator", "exact", &[]),
    lab(
        "spring/ri-damped-less",
        "spring-mass",
        "reset-integrator",
        "exact",
        &["friction.reset-integrator.damping_n_s_per_m=[15.0]"],
    ),
    lab(
        "spring/ri-damped-more",
        "spring-mass",
        "reset-integrator",
        "exact",
        &["friction.reset-integrator.damping_n_s_per_m=[60.0]"],
    ),
    lab("spring/banded-work", "spring-mass", "karnopp-banded", "rk4-adaptive", &[]),
    lab("spring/ri-work", "spring-mass", "reset-integrator", "rk4-adaptive", &[]),
    lab("blocks/karnopp", "spring-mass-2dof", "karnopp", "exact", &[]),
    lab("blocks/ri", "spring-mass-2dof", "reset-integrator", "exact", &[]),
    lab("blocks/banded-work", "spring-mass-2dof", "karnopp-banded", "rk4-adaptive", &[]),
    lab("blocks/ri-work", "spring-mass-2dof", "reset-integrator", "rk4-adaptive", &[]),
    lab("pendulum/karnopp", "manipulator-1dof", "karnopp", "exact", &[]),
    lab("pendulum/ri", "manipulator-1dof", "reset-integrator", "exact", &[]),
    lab("pendulum/banded-work", "manipulator-1dof", "karnopp-banded", "rk4-adaptive", &[]),
    lab("pendulum/ri-work", "manipulator-1dof", "reset-integrator", "rk4-adaptive", &[]),
    lab("arm/karnopp", "manipulator-2dof", "karnopp", "exact", &[]),
    lab("arm/ri", "manipulator-2dof", "reset-integrator", "exact", &[]),
    lab(
        "arm/banded-work",
        "manipulator-2dof",
        "karnopp-banded",
        "rk4-adaptive",
        &["run.coupling=neglected"],
    ),
    lab("arm/at-once-work", "manipulator-2dof", "karnopp-banded", "rk4-adaptive", &[]),
    lab("arm/ri-work", "manipulator-2dof", "reset-integrator", "rk4-adaptive", &[]),
    // Fig. 14, and the run that it is compared with, at the same D_v.
    lab(
        "arm/wide-neglected",
        "manipulator-2dof",
        "karnopp-banded",
        "rk4-adaptive",
        &["run.coupling=neglected", "friction.karnopp-banded.band_rad_per_s=[9.948e-5, 9.948e-5]"],
    ),
    lab(
        "arm/previous-step",
        "manipulator-2dof",
        "karnopp-banded",
        "rk4-adaptive",
        &[
            "run.coupling=previous-step",
            "friction.karnopp-banded.band_rad_per_s=[9.948e-5, 9.948e-5]",
        ],
    ),
    // In short steps: step doubling is fooled at the band's edge, where the stages of a long step,
    // now on this side of the band and now on that, add up to nothing.
    lab("square/banded", "square-wave", "karnopp-banded", "rk4", &[]),
    lab(
        "square/narrow",
        "square-wave",
        "karnopp-banded",
        "rk4",
        &["friction.karnopp-banded.band_m_per_s=[1e-4]"],
    ),
    lab("square/karnopp", "square-wave", "karnopp", "exact", &[]),
    lab("square/ri", "square-wave", "reset-integrator", "exact", &[]),
    lab("triangle/banded", "triangle-wave", "karnopp-banded", "rk4", &[]),
    lab("triangle/karnopp", "triangle-wave", "karnopp", "exact", &[]),
    lab("triangle/ri", "triangle-wave", "reset-integrator", "exact", &[]),
    lab("revisited/karnopp", "spring-mass-revisited", "karnopp", "exact", &[]),
    lab("revisited/ri", "spring-mass-revisited", "reset-integrator", "exact", &[]),
    lab("independent/karnopp", "spring-mass-independent", "karnopp", "exact", &[]),
    lab("independent/ri", "spring-mass-independent", "reset-integrator", "exact", &[]),
];
