//! The page: texts, drawings and verdicts put into its template.

use minijinja::value::Serde;
use minijinja::{AutoEscape, Environment, Value, context};
use serde::Serialize;

use super::beyond::UntunedChapter;
use super::claims::{Claim, ClaimVerdict, Criterion, SECTIONS};
use super::content::{FigureText, Misprint};
use super::evidence::ReportEvidence;
use super::tables::ThesisTable;
use figure::page::DrawingView;
use files::error::Error;

/// Parts of the page.
pub struct PageParts<'a> {
    /// The runs.
    pub evidence: &'a ReportEvidence,
    /// Captions.
    pub figures: &'a [FigureText],
    /// The inline drawings of each figure.
    pub drawings: &'a [Vec<DrawingView>],
    /// The thesis's tables.
    pub tables: &'a [ThesisTable],
    /// Misprints.
    pub misprints: &'a [Misprint],
    /// Laws beyond the thesis.
    pub beyond: &'a UntunedChapter,
    /// The inline drawing of the laws on joints for which they are untuned.
    pub untuned: &'a str,
    /// Time of the runs, s.
    pub runs_s: f64,
}

#[derive(Serialize)]
struct SectionView {
    title: &'static str,
    claims: Vec<ClaimView>,
}

#[derive(Serialize)]
struct ClaimView {
    id: usize,
    source: &'static str,
    says: &'static str,
    quantity: &'static str,
    measured: String,
    holds_if: String,
    verdict: ClaimVerdict,
    said: &'static str,
    remark: &'static str,
}

#[derive(Serialize)]
struct FigureView<'a> {
    id: String,
    anchors: Vec<String>,
    heading: String,
    title: &'a str,
    caption: &'a str,
    note: String,
    drawings: &'a [DrawingView],
}

/// Number of claims that hold, hold in part, fail and are not measured.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Tally {
    /// Every value supports the claim.
    pub holds: usize,
    /// Some values support it.
    pub in_part: usize,
    /// No value supports it.
    pub fails: usize,
    /// A run is missing.
    pub not_measured: usize,
}

/// Returns the page, and the number of claims by their verdicts.
///
/// # Errors
/// Returns an error if the built-in template is invalid.
pub fn page(parts: &PageParts) -> Result<(String, Tally), Error> {
    let sections = sections(parts.evidence);
    let mut tally = Tally::default();
    for claim in sections.iter().flat_map(|section| &section.claims) {
        match claim.verdict {
            ClaimVerdict::Holds => tally.holds += 1,
            ClaimVerdict::InPart => tally.in_part += 1,
            ClaimVerdict::Fails => tally.fails += 1,
            ClaimVerdict::NotMeasured => tally.not_measured += 1,
        }
    }
    let figures: Vec<FigureView> = parts.figures.iter().zip(parts.drawings).map(figure).collect();
    let broken = |error: minijinja::Error| Error::Figure(format!("the report's page: {error}"));
    let mut environment = Environment::new();
    environment.set_auto_escape_callback(|_| AutoEscape::Html);
    let template =
        environment.template_from_str(include_str!("../../page/page.html")).map_err(broken)?;
    let page = template.render(context! {
        style => Value::from_safe_string(figure::page::STYLE.into()),
        script => Value::from_safe_string(figure::page::SCRIPT.into()),
        version => env!("CARGO_PKG_VERSION"),
        runs => parts.evidence.len(),
        runs_s => format!("{:.1}", parts.runs_s),
        tally => Value::from(Serde(tally)),
        sections => Value::from(Serde(&sections)),
        figures => Value::from(Serde(&figures)),
        tables => Value::from(Serde(parts.tables)),
        misprints => Value::from(Serde(parts.misprints)),
        beyond => Value::from(Serde(parts.beyond)),
        untuned => parts.untuned,
    });
    Ok((page.map_err(broken)?, tally))
}

fn sections(evidence: &ReportEvidence) -> Vec<SectionView> {
    let mut ids = 1..;
    let section = |section: &super::claims::Section| SectionView {
        title: section.title,
        claims: ids.by_ref().zip(section.claims).map(|claim| view(claim, evidence)).collect(),
    };
    SECTIONS.iter().map(section).collect()
}

fn view((id, claim): (usize, &Claim), evidence: &ReportEvidence) -> ClaimView {
    let (values, verdict) = claim.judge(evidence);
    ClaimView {
        id,
        source: claim.source,
        says: claim.says,
        quantity: claim.quantity,
        measured: values.into_iter().map(digits).collect::<Vec<_>>().join("; "),
        holds_if: match claim.holds {
            Criterion::Above(bound) => format!("above {}", digits(bound)),
            Criterion::Below(bound) => format!("below {}", digits(bound)),
            Criterion::Between(least, most) if least == most => digits(least),
            Criterion::Between(least, most) => format!("{} to {}", digits(least), digits(most)),
        },
        verdict,
        said: match verdict {
            ClaimVerdict::Holds => "holds",
            ClaimVerdict::InPart => "in part",
            ClaimVerdict::Fails => "does not hold",
            ClaimVerdict::NotMeasured => "not measured",
        },
        remark: claim.remark,
    }
}

/// Formats a value with four digits, without trailing zeros.
fn digits(value: f64) -> String {
    if !value.is_finite() {
        return "not finite".into();
    }
    let size = value.abs();
    let text = match size {
        // Rounding of equal numbers leaves this.
        _ if size < 1e-12 => "0".into(),
        // The shortest form, with joiners so that a line does not break within it.
        _ if !(1e-3..1e5).contains(&size) => format!("{value:.2e}")
            .replace(".00e", "e")
            .replace("0e", "e")
            .replace("e-", "e\u{2060}-\u{2060}"),
        _ => {
            let decimals = (3 - size.log10().floor() as i32).max(0) as usize;
            let text = format!("{value:.decimals$}");
            if text.contains('.') {
                text.trim_end_matches('0').trim_end_matches('.').into()
            } else {
                text
            }
        }
    };
    text.replace('-', "\u{2212}")
}

fn figure<'a>((text, drawings): (&'a FigureText, &'a Vec<DrawingView>)) -> FigureView<'a> {
    let numbers: Vec<String> = text.numbers.iter().map(u32::to_string).collect();
    let heading = match numbers.len() {
        1 => format!("Fig. {}", numbers.join("")),
        _ => format!("Figs. {}", numbers.join(" and ")),
    };
    let simulated: Vec<String> = text
        .numbers
        .iter()
        .filter(|number| !text.robot.contains(number))
        .map(u32::to_string)
        .collect();
    let note = match (text.robot.first(), simulated.first()) {
        (None, _) => "Simulated, as in the thesis.".into(),
        (Some(robot), None) => {
            format!(
                "Simulated. The thesis measured Fig. {robot} on its robot; nothing here ran on \
                one."
            )
        }
        (Some(robot), Some(simulated)) => {
            format!(
                "Simulated, as Fig. {simulated}. The thesis measured Fig. {robot} on its robot; \
                 nothing here ran on one."
            )
        }
    };
    FigureView {
        id: format!("fig-{}", numbers.join("-")),
        anchors: numbers,
        heading,
        title: &text.title,
        caption: &text.caption,
        note,
        drawings,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn measured_values_have_four_digits() {
        let shown = [0.0, 0.48012, -139.64, 12345.6, 2.0, 1.2e-7, 0.1, 100.0].map(digits);
        assert_eq!(
            shown,
            [
                "0",
                "0.4801",
                "\u{2212}139.6",
                "12346",
                "2",
                "1.2e\u{2060}\u{2212}\u{2060}7",
                "0.1",
                "100"
            ]
        );
    }
}
