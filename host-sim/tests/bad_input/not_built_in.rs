//! Parts of the program that a build may leave out.

use std::fs;

use super::refusal::assert_all_refused;
#[cfg(not(feature = "emulator"))]
use super::refusal::complaint;
use super::stiction;

#[cfg(not(feature = "emulator"))]
#[test]
fn the_emulator_is_named_with_the_command_that_builds_it_in() {
    let command = stiction(&["run", "step-response", "--target", "emulator"]);
    let complaint = complaint(
        command,
        &["--target emulator", "cargo install --path host-sim", "--features emulator"],
    );
    assert_eq!(complaint, None);
}

#[test]
fn what_is_not_built_in_is_named_with_the_command_that_builds_it_in() {
    let directory = tempfile::tempdir().unwrap();
    let out = directory.path().join("out");
    let out = out.to_str().unwrap();
    let cases: [(bool, &str, &[&str]); 4] = [
        (
            cfg!(feature = "figures"),
            "figures",
            &["run", "step-response", "--controller", "pd", "--plot", out],
        ),
        (cfg!(feature = "figures"), "figures", &["benchmark", "--plot", out]),
        (cfg!(feature = "report"), "report", &["report", "--out", out]),
        (cfg!(feature = "watch"), "watch", &["device", "--simulated", "watch"]),
    ];
    assert_all_refused(cases.into_iter().filter(|(is_built_in, ..)| !is_built_in).map(
        |(_, feature, arguments)| {
            (
                arguments.join(" "),
                stiction(arguments),
                vec!["cargo install --path host-sim", "--features", feature],
            )
        },
    ));
    assert_eq!(fs::read_dir(directory.path()).unwrap().count(), 0);
}
