//! Figs. 5 to 14, as data: blocks on springs and manipulators.

use super::panels::Quantity::{Acceleration, Friction, Position, Velocity};
use super::panels::{Curve, PanelText};
use super::waves::FIGURES as WAVES;
use crate::figure::{Figure, NamedFigure};
use crate::report::evidence::Evidence;

/// A figure of runs of the friction lab.
pub struct FigureOf {
    /// What `figures.toml` calls it.
    pub stem: &'static str,
    /// The figure of the thesis.
    pub thesis: &'static str,
    /// Title of the files.
    pub title: &'static str,
    /// From top to bottom.
    pub panels: &'static [PanelText],
}

/// All that the runs allow.
pub fn figures(evidence: &Evidence) -> Vec<NamedFigure> {
    let figure = |of: &FigureOf| {
        let panels = of.panels.iter().map(|panel| panel.panel(evidence)).collect::<Option<_>>()?;
        let subtitle = format!("simulated; to compare with {} of the thesis", of.thesis);
        let figure = Figure { title: of.title.into(), subtitle, x_label: "time (s)".into(), panels };
        Some(NamedFigure { stem: of.stem.into(), figure })
    };
    FIGURES.iter().chain(WAVES).filter_map(figure).collect()
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
];
