//! Checks how a refusal looks: one line, exit code 2, no jargon.

use std::process::{Command, Output, Stdio};
use std::thread::sleep;
use std::time::{Duration, Instant};

/// Words of the language that the program is written in, and of a program that has lost its head. A
/// user must not see them.
const JARGON: [&str; 14] = [
    "f64",
    "u8",
    "usize",
    "i64",
    "i128",
    "struct",
    "serde",
    "invalid type",
    "invalid value",
    "expected a",
    "unit variant",
    "floating point",
    "os error",
    "panicked",
];

/// Returns what a command printed, which is little. A command that takes longer than any mistake
/// may take is stopped.
pub fn answer(mut command: Command) -> Result<Output, String> {
    let mut child = command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    let begin = Instant::now();
    while child.try_wait().unwrap().is_none() {
        if begin.elapsed() > Duration::from_secs(60) {
            child.kill().unwrap();
            return Err("is still running after a minute".into());
        }
        sleep(Duration::from_millis(2));
    }
    Ok(child.wait_with_output().unwrap())
}

/// Says why a command was not refused as it should be, if so.
pub fn complaint(command: Command, fragments: &[&str]) -> Option<String> {
    let output = match answer(command) {
        Ok(output) => output,
        Err(why) => return Some(why),
    };
    let said = String::from_utf8(output.stderr).unwrap();
    let missing: Vec<_> = fragments.iter().filter(|fragment| !said.contains(**fragment)).collect();
    // The name of a temporary directory is any letters.
    let directory = std::env::temp_dir().display().to_string();
    let words: Vec<_> = said.split(' ').filter(|word| !word.contains(&directory)).collect();
    let words = words.join(" ");
    let jargon: Vec<_> = JARGON.iter().filter(|word| words.contains(**word)).collect();
    let why = if output.status.code() != Some(2) {
        format!("ended with {}", output.status)
    } else if !output.stdout.is_empty() {
        "printed on the standard output".into()
    } else if !(said.starts_with("stiction: ") && said.ends_with('\n') && said.lines().count() == 1)
    {
        "is not answered in one line".into()
    } else if said.matches("stiction: ").count() + said.matches(": --set").count() > 2 {
        "is answered with a prefix twice".into()
    } else if !missing.is_empty() {
        format!("lacks {missing:?}")
    } else if !jargon.is_empty() {
        format!("says {jargon:?}")
    } else {
        return None;
    };
    Some(format!("{why}: {said}"))
}

/// Names every case that is not refused as it should be.
pub fn assert_all_refused<'a>(cases: impl IntoIterator<Item = (String, Command, Vec<&'a str>)>) {
    let complaints: Vec<String> = cases
        .into_iter()
        .filter_map(|(name, command, fragments)| {
            complaint(command, &fragments).map(|why| format!("{name}: {why}"))
        })
        .collect();
    assert!(complaints.is_empty(), "\n{}", complaints.join("\n"));
}
