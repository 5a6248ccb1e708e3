//! Controllers by references in one table, reviewed like code: a change of behaviour shows as a
//! change of this table.
//!
//! It proves nothing by itself (the expected values are our own output) and is blind to whatever
//! the other tests are blind to. The tails of RI, RVI, ROI and DNPF are chaotic: a change in
//! rounding may move them, and then the question is whether the claims of `chapter3.rs` still hold.
//! Accept a change with `INSTA_UPDATE=always`.

use std::fmt::Write;

#[test]
fn controllers_by_references() {
    let mut table = String::from(
        "run                             rest    rms  cruise  chatter   \
        hunts\n",
    );
    table += "                              counts    deg     deg      V/s  counts\n";
    for controller in experiments::controllers() {
        for (experiment, duration) in
            [("step-response", "run.duration_s=120"), ("trajectory", "run.duration_s=26")]
        {
            for result in super::common::run(experiment, controller, &[duration]) {
                if !result.plan.variant.is_empty() {
                    continue;
                }
                let m = &result.metrics;
                let cell = |value: Option<f64>, digits| {
                    value.map_or("-".into(), |v| format!("{v:.digits$}"))
                };
                writeln!(
                    table,
                    "{:28}{:>8}{:>7}{:>8}{:>9}{:>8}",
                    result.plan.label,
                    cell(m.rest_error_counts, 1),
                    cell(m.rms_error_deg, 3),
                    cell(m.cruise_error_deg, 3),
                    cell(m.control_total_variation_v_per_s, 2),
                    cell(m.hunting_peak_to_peak_deg.map(|deg| deg / 0.00242), 1),
                )
                .unwrap();
            }
        }
    }
    insta::assert_snapshot!(table);
}
