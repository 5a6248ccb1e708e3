//! Figs. 15 to 20, 61 and 62, as data: what each part of the models does.

use super::chapter2::FigureOf;
use super::panels::Quantity::{
    Acceleration, Deflection, DeflectionRate, FarEnd, Friction, Input, Position, Velocity,
};
use super::panels::{Curve, PanelText};

/// In the thesis's order.
pub const FIGURES: &[FigureOf] = &[
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
