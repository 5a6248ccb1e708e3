//! The report as a whole, made once.

use std::collections::BTreeSet;
use std::sync::LazyLock;

use indicatif::ProgressBar;
use resvg::usvg::roxmltree::{Document, Node, ParsingOptions};

use super::claims::{ClaimVerdict, SECTIONS};
use super::evidence::{ReportEvidence, ReportPlans};
use super::{Rendered, content, rendered, write};
use simulator::output::OverwriteGuard;

static REPORT: LazyLock<Rendered> = LazyLock::new(|| {
    let texts = content::figures().unwrap();
    rendered(ReportPlans::new().unwrap(), &texts, &ProgressBar::hidden()).unwrap()
});

/// Parses the page as XML, which also checks that every element is closed.
fn page() -> Document<'static> {
    let options = ParsingOptions { allow_dtd: true, ..ParsingOptions::default() };
    Document::parse_with_options(&REPORT.page, options).unwrap()
}

fn attributes(name: &'static str) -> Vec<String> {
    let page = page();
    page.descendants().filter_map(|node| node.attribute(name)).map(str::to_owned).collect()
}

/// Returns the text of a node and its descendants.
fn text(node: Node) -> String {
    node.descendants().filter(Node::is_text).filter_map(|node| node.text()).collect()
}

#[test]
fn the_page_needs_nothing_but_itself() {
    for name in ["src", "srcset", "data", "action", "poster", "background"] {
        assert_eq!(attributes(name), Vec::<String>::new(), "{name}");
    }
    let page = page();
    let (scripts, links) =
        (["script", "style"], ["link", "iframe", "object", "embed", "img", "image", "use"]);
    for node in page.descendants().filter(Node::is_element) {
        let name = node.tag_name().name();
        assert!(!links.contains(&name), "{name}");
        if scripts.contains(&name) {
            let text = text(node);
            assert!(!text.contains("//") || !text.contains("http"), "{name}");
            assert!(!text.contains("@import") && !text.contains("fetch("), "{name}");
        }
    }
    for outside in ["http:", "https:", "url(\"", "url('", "url(/"] {
        assert!(!REPORT.page.contains(outside), "{outside}");
    }
}

#[test]
fn every_name_is_given_once_and_every_link_leads_to_one() {
    let ids = attributes("id");
    let names: BTreeSet<&String> = ids.iter().collect();
    assert_eq!(names.len(), ids.len());
    let links = attributes("href");
    assert!(links.len() > 80);
    for link in links {
        let name = link.strip_prefix('#').map(str::to_owned);
        assert!(name.is_some_and(|name| names.contains(&name)), "{link}");
    }
    for clip in attributes("clip-path") {
        let name = clip.trim_start_matches("url(#").trim_end_matches(')').to_owned();
        assert!(names.contains(&name), "{clip}");
    }
}

#[test]
fn every_result_of_the_thesis_is_there_once() {
    let numbers = |name| -> Vec<u32> {
        let all = attributes(name);
        let mut numbers: Vec<u32> = all
            .iter()
            .flat_map(|list| list.split(' '))
            .map(|number| number.parse().unwrap())
            .collect();
        numbers.sort_unstable();
        numbers
    };
    let figures: Vec<u32> =
        [5, 7, 9].into_iter().chain(11..=20).chain(26..=59).chain(61..=67).collect();
    assert_eq!(numbers("data-figures"), figures);
    assert_eq!(numbers("data-table"), (1..=24).collect::<Vec<_>>());
    // Each with a drawing, and each drawing with its two files.
    let page = page();
    for figure in page.descendants().filter(|node| node.has_tag_name("figure")) {
        assert!(
            figure.descendants().any(|node| node.has_tag_name("svg")),
            "{:?}",
            figure.attribute("id")
        );
    }
    let drawings = page.descendants().filter(|node| node.has_tag_name("svg")).count();
    assert_eq!(REPORT.files.len(), drawings);
    for (stem, svg, png) in &REPORT.files {
        assert!(svg.starts_with("<svg ") && png.starts_with(b"\x89PNG"), "{stem}");
    }
}

#[test]
fn the_figures_that_the_thesis_measured_on_its_robot_say_that_ours_are_simulated() {
    let page = page();
    let on_robot = |number: u32| (26..=45).contains(&number) || (63..=67).contains(&number);
    for figure in page.descendants().filter(|node| node.has_tag_name("figure")) {
        // Only what is beyond the thesis has no number in it.
        let is_beyond = figure.ancestors().any(|node| node.attribute("id") == Some("beyond"));
        let numbers = if is_beyond { "0" } else { figure.attribute("data-figures").unwrap() };
        let is_on_robot = numbers.split(' ').any(|number| on_robot(number.parse().unwrap()));
        let text = text(figure);
        assert!(text.contains("Simulated"), "{numbers}");
        assert_eq!(text.contains("on its robot"), is_on_robot, "{numbers}");
    }
}

#[test]
fn every_claim_has_a_measured_value_and_a_verdict() {
    let page = page();
    let rows: Vec<Node> =
        page.descendants().filter(|node| node.attribute("class") == Some("claim")).collect();
    assert_eq!(rows.len(), SECTIONS.iter().map(|section| section.claims.len()).sum::<usize>());
    assert!(rows.len() > 60);
    let mut holds = 0;
    for row in rows {
        let cell = |label: &str| {
            text(row.children().find(|cell| cell.attribute("data-label") == Some(label)).unwrap())
        };
        assert!(
            cell("Value").contains(|c: char| c.is_ascii_digit()),
            "{}",
            cell("The thesis says")
        );
        let verdict = cell("Verdict");
        assert!(["holds", "in part", "does not hold"].contains(&verdict.as_str()), "{verdict}");
        holds += usize::from(verdict == "holds");
    }
    assert_eq!((holds, REPORT.claims.not_measured), (REPORT.claims.holds, 0));
}

/// A law, a model or a solver that changes a verdict changes this list, which is reviewed.
#[test]
fn every_verdict_is_the_reviewed_one() {
    let evidence = ReportPlans::new().unwrap().run(&ProgressBar::hidden()).unwrap();
    let claims = SECTIONS.iter().flat_map(|section| section.claims);
    let lines = claims.map(|claim| format!("{:?}: {}", claim.judge(&evidence).1, claim.says));
    insta::assert_snapshot!("verdicts", lines.collect::<Vec<_>>().join("\n"));
}

#[test]
fn the_law_beyond_the_thesis_stands_beside_the_thesis_s_own_in_each_family() {
    let page = page();
    let section = page.descendants().find(|node| node.attribute("id") == Some("beyond")).unwrap();
    let rows = section.descendants().filter(|node| node.has_tag_name("tr")).skip(1);
    let cells = rows.map(|row| {
        let cells = row.children().filter(Node::is_element).map(text);
        cells.collect::<Vec<_>>().try_into().unwrap()
    });
    let rows: Vec<[String; 7]> = cells.collect();
    assert_eq!(rows.len(), 16);
    // PD's interval ends where that of `robust` has not begun.
    let interval = |family: &str, law: &str| -> [f64; 2] {
        let row = rows.iter().find(|row| row[0] == family && row[1] == law).unwrap();
        let (low, high) = row[3].split_once(" to ").unwrap();
        [low, high].map(|end| end.parse().unwrap())
    };
    for family in ["rigid", "lugre", "flexible-motor", "thesis-axis"] {
        let (pd, robust) = (interval(family, "pd"), interval(family, "robust"));
        assert!(pd[1] < robust[0], "{family}: {pd:?}, {robust:?}");
    }
}

#[test]
fn a_verdict_changes_with_its_measurement() {
    let claim = SECTIONS.iter().flat_map(|section| section.claims);
    let claim =
        claim.into_iter().find(|claim| claim.says.starts_with("PD ends each step")).unwrap();
    let mut evidence: ReportEvidence =
        ReportPlans::only("step-response").unwrap().run(&ProgressBar::hidden()).unwrap();
    assert_eq!(claim.judge(&evidence).1, ClaimVerdict::Holds);
    for (label, verdict) in [
        ("pd/step-5.0", ClaimVerdict::InPart),
        ("pd/step-2.5", ClaimVerdict::InPart),
        ("pd/step-1.0", ClaimVerdict::Fails),
    ] {
        evidence.run_mut("step-response", label).unwrap().metrics.rest_error_counts = Some(0.5);
        assert_eq!(claim.judge(&evidence).1, verdict, "{label}");
    }
    evidence.run_mut("step-response", "pd/step-5.0").unwrap().metrics.rest_error_counts = None;
    assert_eq!(claim.judge(&evidence), (vec![], ClaimVerdict::NotMeasured));
}

#[test]
fn the_page_and_two_files_of_each_drawing_are_written() {
    let directory = tempfile::tempdir().unwrap();
    let guarded = OverwriteGuard::default().directory("--out", directory.path()).unwrap();
    let page = write(&guarded, &REPORT).unwrap();
    assert_eq!(std::fs::read_to_string(page).unwrap(), REPORT.page);
    let files = std::fs::read_dir(directory.path()).unwrap().count();
    assert_eq!(files, 1 + 2 * REPORT.files.len());
    assert!(
        directory.path().join("figure-05.svg").is_file()
            && directory.path().join("figure-28-48.png").is_file()
    );
}
