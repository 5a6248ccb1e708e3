//! Panels of the friction lab's runs.

use crate::figure::{Line, Panel, Style};
use crate::lab::{LabResult, Row};
use crate::report::evidence::Evidence;

/// What a curve shows of a body.
#[derive(Clone, Copy)]
pub enum Quantity {
    Position,
    /// Of the spring's far end, which moves at constant speed.
    FarEnd,
    Velocity,
    Acceleration,
    Input,
    Friction,
    /// p of the Reset Integrator, µm.
    Deflection,
    /// Its rate, mm/s: that of the body while it sticks, else zero (eq. 2).
    DeflectionRate,
}

/// A curve: its name, its run, its body and what of it.
pub struct Curve(pub &'static str, pub &'static str, pub usize, pub Quantity);

/// A panel: its label, its height relative to an ordinary one, and its curves.
pub struct PanelText(pub &'static str, pub f64, pub &'static [Curve]);

const STYLES: [Style; 3] = [Style::Primary, Style::Second, Style::Third];

impl PanelText {
    /// The panel; nothing if a run is missing.
    pub fn panel(&self, evidence: &Evidence) -> Option<Panel> {
        let line = |(curve, style): (&Curve, Style)| {
            let Curve(name, run, body, quantity) = *curve;
            Some(Line::new(name, style, points(evidence.lab(run)?, body, quantity)?))
        };
        let lines = self.2.iter().zip(STYLES).map(line).collect::<Option<_>>()?;
        Some(Panel { height: self.1, ..Panel::new(self.0, lines) })
    }
}

fn points(result: &LabResult, body: usize, quantity: Quantity) -> Option<Vec<(f64, f64)>> {
    let speed = || result.plan.setup.mechanism.pull.as_ref().map(|pull| pull.speed_m_per_s);
    let value = |row: &Row| match quantity {
        Quantity::Position => row.position.get(body).copied(),
        Quantity::FarEnd => speed().map(|speed| speed * row.time_s),
        Quantity::Velocity => row.velocity.get(body).copied(),
        Quantity::Acceleration => row.acceleration.get(body).copied(),
        Quantity::Input => row.input.get(body).copied(),
        Quantity::Friction => row.friction.get(body).copied(),
        Quantity::Deflection => row.deflection.get(body).map(|p| 1e6 * p),
        Quantity::DeflectionRate => {
            let sticks = *row.stuck.get(body)?;
            if sticks { row.velocity.get(body).map(|v| 1e3 * v) } else { Some(0.0) }
        }
    };
    result.rows.iter().map(|row| Some((row.time_s, value(row)?))).collect()
}
