//! A `[spread]` from which no joint can be drawn is refused by its own name, by every command that
//! reads its file.

use super::refusal::assert_all_refused;
use super::{shown, stiction};

#[test]
fn a_bad_spread_is_named_with_its_file_before_anything_is_drawn() {
    let directory = tempfile::tempdir().unwrap();
    let file = directory.path().join("mine.toml").to_str().unwrap().to_owned();
    let machine = shown("step-response");
    for (line, fragments) in [
        ("\"joint.friction.slip_v\" = [0.4, 0.3]", &["slip_v", "the lower one first"][..]),
        (
            "\"controller.pd.kp_v_per_deg\" = [1, 2]",
            &["only keys of [joint], [motor], [gear], [load] and [friction] can vary"],
        ),
        ("\"joint.friction.stik_v\" = [0.3, 0.4]", &["unknown key", "did you mean `stick_v`?"]),
    ] {
        std::fs::write(&file, format!("{machine}\n[spread]\n{line}\n")).unwrap();
        let key = line.split(' ').next().unwrap();
        let spread = format!("mine.toml: `spread.{key}`");
        let wanted: Vec<&str> = fragments.iter().copied().chain([&*spread]).collect();
        let commands: [&[&str]; 4] = [
            &["run", &file],
            &["tune", &file, "--cases", "1"],
            &["ensemble", "--plant", &file, "--cases", "1"],
            &["benchmark", &file, "--tuned"],
        ];
        assert_all_refused(
            commands
                .map(|command| (format!("{command:?} {line}"), stiction(command), wanted.clone())),
        );
    }
    // A value that only shows when a joint is drawn is the spread's.
    let line = "\"joint.friction.slip_v\" = [-0.2, -0.1]";
    std::fs::write(&file, format!("{machine}\n[spread]\n{line}\n")).unwrap();
    let command = stiction(&["ensemble", "--plant", &file, "--cases", "1"]);
    let wanted = vec!["mine.toml: its spread gives joint.friction.slip_v=-0.1"];
    assert_all_refused([("slip below zero".to_owned(), command, wanted)]);
}
