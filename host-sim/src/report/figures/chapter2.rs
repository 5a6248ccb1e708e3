//! Figs. 5 to 20, 61 and 62, as data.

use super::panels::Quantity::{
    Acceleration, Deflection, DeflectionRate, FarEnd, Friction, Input, Position, Velocity,
};
use super::panels::{Curve, PanelText};
use crate::figure::{Figure, NamedFigure};
use crate::report::evidence::Evidence;

struct FigureOf {
    stem: &'static str,
    thesis: &'static str,
    title: &'static str,
    panels: &'static [PanelText],
}

/// All that the runs allow.
pub fn figures(evidence: &Evidence) -> Vec<NamedFigure> {
    let figure = |of: &FigureOf| {
        let panels = of.panels.iter().map(|panel| panel.panel(evidence)).collect::<Option<_>>()?;
        let subtitle = format!("simulated; to compare with {} of the thesis", of.thesis);
        let figure = Figure { title: of.title.into(), subtitle, x_label: "time (s)".into(), panels };
        Some(NamedFigure { stem: of.stem.into(), figure })
    };
    FIGURES.iter().filter_map(figure).collect()
}

const FIGURES: &[FigureOf] = &[
    FigureOf {
        stem: "fig-5",
        thesis: "Fig. 5",
        title: "One block on a spring",
        panels: &[
            PanelText(
                "displacement (m)",
                1.0,
                &[
                    Curve("Karnopp", "spring/karnopp", 0, Position),
                    Curve("Reset Integrator", "spring/ri", 0, Position),
                ],
            ),
            PanelText("friction (N)", 0.8, &[Curve("Karnopp", "spring/karnopp", 0, Friction)]),
            PanelText("friction (N)", 0.8, &[Curve("Reset Integrator", "spring/ri", 0, Friction)]),
        ],
    },
    FigureOf {
        stem: "fig-7a",
        thesis: "Fig. 7a",
        title: "Two coupled blocks, Karnopp",
        panels: &[
            PanelText(
                "displacement (m)",
                0.8,
                &[
                    Curve("block 1", "blocks/karnopp", 0, Position),
                    Curve("block 2", "blocks/karnopp", 1, Position),
                ],
            ),
            PanelText(
                "velocity (m/s)",
                0.8,
                &[
                    Curve("block 1", "blocks/karnopp", 0, Velocity),
                    Curve("block 2", "blocks/karnopp", 1, Velocity),
                ],
            ),
            PanelText("friction 1 (N)", 0.7, &[Curve("between the blocks", "blocks/karnopp", 0, Friction)]),
            PanelText("friction 2 (N)", 0.7, &[Curve("to the floor", "blocks/karnopp", 1, Friction)]),
        ],
    },
    FigureOf {
        stem: "fig-7b",
        thesis: "Fig. 7b",
        title: "Two coupled blocks, Reset Integrator",
        panels: &[
            PanelText(
                "displacement (m)",
                0.8,
                &[Curve("block 1", "blocks/ri", 0, Position), Curve("block 2", "blocks/ri", 1, Position)],
            ),
            PanelText(
                "velocity (m/s)",
                0.8,
                &[Curve("block 1", "blocks/ri", 0, Velocity), Curve("block 2", "blocks/ri", 1, Velocity)],
            ),
            PanelText("friction 1 (N)", 0.7, &[Curve("between the blocks", "blocks/ri", 0, Friction)]),
            PanelText("friction 2 (N)", 0.7, &[Curve("to the floor", "blocks/ri", 1, Friction)]),
        ],
    },
    FigureOf {
        stem: "fig-9",
        thesis: "Fig. 9",
        title: "Pendulum manipulator",
        panels: &[
            PanelText(
                "velocity (rad/s)",
                1.0,
                &[
                    Curve("Karnopp", "pendulum/karnopp", 0, Velocity),
                    Curve("Reset Integrator", "pendulum/ri", 0, Velocity),
                ],
            ),
            PanelText("friction (N m)", 0.8, &[Curve("Karnopp", "pendulum/karnopp", 0, Friction)]),
            PanelText("friction (N m)", 0.8, &[Curve("Reset Integrator", "pendulum/ri", 0, Friction)]),
        ],
    },
    FigureOf {
        stem: "fig-11",
        thesis: "Fig. 11",
        title: "Two-link manipulator, link 1",
        panels: &[
            PanelText(
                "velocity (rad/s)",
                1.0,
                &[
                    Curve("Karnopp", "arm/karnopp", 0, Velocity),
                    Curve("Reset Integrator", "arm/ri", 0, Velocity),
                ],
            ),
            PanelText("friction (N m)", 0.8, &[Curve("Karnopp", "arm/karnopp", 0, Friction)]),
            PanelText("friction (N m)", 0.8, &[Curve("Reset Integrator", "arm/ri", 0, Friction)]),
        ],
    },
    FigureOf {
        stem: "fig-12",
        thesis: "Fig. 12",
        title: "Two-link manipulator, link 2",
        panels: &[
            PanelText(
                "velocity (rad/s)",
                1.0,
                &[
                    Curve("Karnopp", "arm/karnopp", 1, Velocity),
                    Curve("Reset Integrator", "arm/ri", 1, Velocity),
                ],
            ),
            PanelText("friction (N m)", 0.8, &[Curve("Karnopp", "arm/karnopp", 1, Friction)]),
            PanelText("friction (N m)", 0.8, &[Curve("Reset Integrator", "arm/ri", 1, Friction)]),
        ],
    },
    FigureOf {
        stem: "fig-13",
        thesis: "Fig. 13",
        title: "Two-link manipulator, coupling neglected",
        panels: &[
            PanelText("velocity (rad/s)", 0.7, &[Curve("link 1", "arm/banded-work", 0, Velocity)]),
            PanelText(
                "acceleration (rad/s\u{b2})",
                0.7,
                &[Curve("link 1", "arm/banded-work", 0, Acceleration)],
            ),
            PanelText("velocity (rad/s)", 0.7, &[Curve("link 2", "arm/banded-work", 1, Velocity)]),
            PanelText(
                "acceleration (rad/s\u{b2})",
                0.7,
                &[Curve("link 2", "arm/banded-work", 1, Acceleration)],
            ),
        ],
    },
    FigureOf {
        stem: "fig-14",
        thesis: "Fig. 14",
        title: "Two-link manipulator, accelerations of the previous step",
        panels: &[
            PanelText(
                "velocity (rad/s)",
                0.8,
                &[
                    Curve("link 1", "arm/previous-step", 0, Velocity),
                    Curve("exact", "arm/karnopp", 0, Velocity),
                ],
            ),
            PanelText("friction (N m)", 0.7, &[Curve("link 1", "arm/previous-step", 0, Friction)]),
            PanelText(
                "velocity (rad/s)",
                0.8,
                &[
                    Curve("link 2", "arm/previous-step", 1, Velocity),
                    Curve("exact", "arm/karnopp", 1, Velocity),
                ],
            ),
            PanelText("friction (N m)", 0.7, &[Curve("link 2", "arm/previous-step", 1, Friction)]),
        ],
    },
    FigureOf {
        stem: "fig-15",
        thesis: "Fig. 15",
        title: "Square wave of force, banded Karnopp",
        panels: &[
            PanelText("input (N)", 0.6, &[Curve("F_i", "square/banded", 0, Input)]),
            PanelText("acc. (m/s\u{b2})", 0.6, &[Curve("acceleration", "square/banded", 0, Acceleration)]),
            PanelText("velocity (m/s)", 0.6, &[Curve("V", "square/banded", 0, Velocity)]),
            PanelText("friction (N)", 0.7, &[Curve("F_f", "square/banded", 0, Friction)]),
        ],
    },
    FigureOf {
        stem: "fig-16",
        thesis: "Fig. 16",
        title: "Triangle wave of force, banded Karnopp",
        panels: &[
            PanelText("input (N)", 0.6, &[Curve("F_i", "triangle/banded", 0, Input)]),
            PanelText("acc. (m/s\u{b2})", 0.6, &[Curve("acceleration", "triangle/banded", 0, Acceleration)]),
            PanelText("velocity (m/s)", 0.6, &[Curve("V", "triangle/banded", 0, Velocity)]),
            PanelText("friction (N)", 0.7, &[Curve("F_f", "triangle/banded", 0, Friction)]),
        ],
    },
    FigureOf {
        stem: "fig-17",
        thesis: "Fig. 17",
        title: "The block on a spring, Karnopp",
        panels: &[
            PanelText(
                "displacement (m)",
                0.8,
                &[
                    Curve("block", "revisited/karnopp", 0, Position),
                    Curve("end of the spring", "revisited/karnopp", 0, FarEnd),
                ],
            ),
            PanelText("input (N)", 0.6, &[Curve("F_i", "revisited/karnopp", 0, Input)]),
            PanelText(
                "acc. (m/s\u{b2})",
                0.6,
                &[Curve("acceleration", "revisited/karnopp", 0, Acceleration)],
            ),
            PanelText("velocity (m/s)", 0.6, &[Curve("V", "revisited/karnopp", 0, Velocity)]),
            PanelText("friction (N)", 0.7, &[Curve("F_f", "revisited/karnopp", 0, Friction)]),
        ],
    },
    FigureOf {
        stem: "fig-18",
        thesis: "Fig. 18",
        title: "Square wave of force, Reset Integrator",
        panels: &[
            PanelText("input (N)", 0.6, &[Curve("F_i", "square/ri", 0, Input)]),
            PanelText("acc. (m/s\u{b2})", 0.6, &[Curve("acceleration", "square/ri", 0, Acceleration)]),
            PanelText("velocity (m/s)", 0.6, &[Curve("V", "square/ri", 0, Velocity)]),
            PanelText("p-dot (mm/s)", 0.6, &[Curve("rate of p", "square/ri", 0, DeflectionRate)]),
            PanelText("p (\u{b5}m)", 0.6, &[Curve("p", "square/ri", 0, Deflection)]),
            PanelText("friction (N)", 0.7, &[Curve("F_f", "square/ri", 0, Friction)]),
        ],
    },
    FigureOf {
        stem: "fig-19",
        thesis: "Fig. 19",
        title: "Triangle wave of force, Reset Integrator",
        panels: &[
            PanelText("input (N)", 0.6, &[Curve("F_i", "triangle/ri", 0, Input)]),
            PanelText("acc. (m/s\u{b2})", 0.6, &[Curve("acceleration", "triangle/ri", 0, Acceleration)]),
            PanelText("velocity (m/s)", 0.6, &[Curve("V", "triangle/ri", 0, Velocity)]),
            PanelText("p-dot (mm/s)", 0.6, &[Curve("rate of p", "triangle/ri", 0, DeflectionRate)]),
            PanelText("p (\u{b5}m)", 0.6, &[Curve("p", "triangle/ri", 0, Deflection)]),
            PanelText("friction (N)", 0.7, &[Curve("F_f", "triangle/ri", 0, Friction)]),
        ],
    },
    FigureOf {
        stem: "fig-20",
        thesis: "Fig. 20",
        title: "The block on a spring, Reset Integrator",
        panels: &[
            PanelText(
                "displacement (m)",
                0.8,
                &[
                    Curve("block", "revisited/ri", 0, Position),
                    Curve("end of the spring", "revisited/ri", 0, FarEnd),
                ],
            ),
            PanelText("input (N)", 0.6, &[Curve("F_i", "revisited/ri", 0, Input)]),
            PanelText("acc. (m/s\u{b2})", 0.6, &[Curve("acceleration", "revisited/ri", 0, Acceleration)]),
            PanelText("velocity (m/s)", 0.6, &[Curve("V", "revisited/ri", 0, Velocity)]),
            PanelText("p-dot (mm/s)", 0.6, &[Curve("rate of p", "revisited/ri", 0, DeflectionRate)]),
            PanelText("p (\u{b5}m)", 0.6, &[Curve("p", "revisited/ri", 0, Deflection)]),
            PanelText("friction (N)", 0.7, &[Curve("F_f", "revisited/ri", 0, Friction)]),
        ],
    },
    FigureOf {
        stem: "fig-61",
        thesis: "Fig. 61",
        title: "Two independent blocks, Karnopp",
        panels: &[
            PanelText(
                "displacement (m)",
                0.8,
                &[
                    Curve("block 1", "independent/karnopp", 0, Position),
                    Curve("block 2", "independent/karnopp", 1, Position),
                ],
            ),
            PanelText(
                "input (N)",
                0.7,
                &[
                    Curve("block 1", "independent/karnopp", 0, Input),
                    Curve("block 2", "independent/karnopp", 1, Input),
                ],
            ),
            PanelText(
                "acc. (m/s\u{b2})",
                0.7,
                &[
                    Curve("block 1", "independent/karnopp", 0, Acceleration),
                    Curve("block 2", "independent/karnopp", 1, Acceleration),
                ],
            ),
            PanelText(
                "velocity (m/s)",
                0.7,
                &[
                    Curve("block 1", "independent/karnopp", 0, Velocity),
                    Curve("block 2", "independent/karnopp", 1, Velocity),
                ],
            ),
            PanelText(
                "friction (N)",
                0.8,
                &[
                    Curve("block 1", "independent/karnopp", 0, Friction),
                    Curve("block 2", "independent/karnopp", 1, Friction),
                ],
            ),
        ],
    },
    FigureOf {
        stem: "fig-62",
        thesis: "Fig. 62",
        title: "Two independent blocks, Reset Integrator",
        panels: &[
            PanelText(
                "displacement (m)",
                0.8,
                &[
                    Curve("block 1", "independent/ri", 0, Position),
                    Curve("block 2", "independent/ri", 1, Position),
                ],
            ),
            PanelText(
                "input (N)",
                0.7,
                &[Curve("block 1", "independent/ri", 0, Input), Curve("block 2", "independent/ri", 1, Input)],
            ),
            PanelText(
                "acc. (m/s\u{b2})",
                0.7,
                &[
                    Curve("block 1", "independent/ri", 0, Acceleration),
                    Curve("block 2", "independent/ri", 1, Acceleration),
                ],
            ),
            PanelText(
                "velocity (m/s)",
                0.7,
                &[
                    Curve("block 1", "independent/ri", 0, Velocity),
                    Curve("block 2", "independent/ri", 1, Velocity),
                ],
            ),
            PanelText(
                "p-dot (mm/s)",
                0.7,
                &[
                    Curve("block 1", "independent/ri", 0, DeflectionRate),
                    Curve("block 2", "independent/ri", 1, DeflectionRate),
                ],
            ),
            PanelText(
                "p (\u{b5}m)",
                0.7,
                &[
                    Curve("block 1", "independent/ri", 0, Deflection),
                    Curve("block 2", "independent/ri", 1, Deflection),
                ],
            ),
            PanelText(
                "friction (N)",
                0.8,
                &[
                    Curve("block 1", "independent/ri", 0, Friction),
                    Curve("block 2", "independent/ri", 1, Friction),
                ],
            ),
        ],
    },
];
