//! `cargo xtask words` counts the words to avoid in sources and pages. No count may rise.
//!
//! `xtask/words-to-avoid.txt` holds the words and, for each file that still has some, their number.
//! A file that is not listed must have none. A word is found in any case and only as a whole, so
//! the check is blind to a word inside a longer identifier. A phrase is found across a line break.

use std::collections::BTreeMap;
use std::fs;
use std::process::Command;

use crate::job::root;

/// The words, a blank line, and the counts: `NUMBER FILE` a line, sorted by file.
const LIST: &str = "xtask/words-to-avoid.txt";

/// The files that are searched.
const SEARCHED: [&str; 4] = ["*.rs", "*.md", "*.ts", "*.py"];

#[derive(Debug, Default, clap::Args)]
pub struct WordsJobArguments {
    /// Store the counts where they have fallen
    #[arg(long)]
    bless: bool,
}

/// Counts by file; a file without a match has no entry.
type Counts = BTreeMap<String, usize>;

/// Words and phrases, in lower case, and the largest count that each file may have.
#[derive(Debug, PartialEq)]
struct Avoided {
    head: String,
    phrases: Vec<Vec<String>>,
    limits: Counts,
}

pub fn check(arguments: &WordsJobArguments) -> Result<(), String> {
    let avoided = Avoided::read(&read(LIST)?)?;
    let mut found = Counts::new();
    for file in files()? {
        let count = avoided.count(&read(&file)?);
        if count > 0 {
            found.insert(file, count);
        }
    }
    let risen = avoided.risen(&found);
    if !risen.is_empty() {
        return Err(format!("words to avoid ({LIST} lists them):\n{}", risen.join("\n")));
    }
    let total: usize = found.values().sum();
    println!("{total} words to avoid are left, in {} files", found.len());
    if arguments.bless {
        let text = avoided.head + &lines(&found);
        return fs::write(root().join(LIST), text)
            .map_err(|error| format!("cannot write {LIST}: {error}"));
    }
    Ok(())
}

impl Avoided {
    fn read(text: &str) -> Result<Self, String> {
        let (words, counts) =
            text.split_once("\n\n").ok_or_else(|| format!("{LIST} has no blank line"))?;
        let count = |line: &str| {
            let (number, file) = line.split_once(' ')?;
            Some((file.to_owned(), number.parse().ok()?))
        };
        let limits = counts
            .lines()
            .map(|line| count(line).ok_or_else(|| format!("{LIST}: no `NUMBER FILE`: {line}")))
            .collect::<Result<Counts, String>>()?;
        let phrases = words.lines().filter(|line| !line.starts_with('#')).map(split).collect();
        Ok(Self { head: format!("{words}\n\n"), phrases, limits })
    }

    /// Returns the number of matches in a text.
    fn count(&self, text: &str) -> usize {
        let words = split(text);
        let of = |phrase: &Vec<String>| words.windows(phrase.len()).filter(|w| w == phrase).count();
        self.phrases.iter().filter(|phrase| !phrase.is_empty()).map(of).sum()
    }

    /// Returns a line for each file that has more than its limit.
    fn risen(&self, found: &Counts) -> Vec<String> {
        let limit = |file| self.limits.get(file).copied().unwrap_or(0);
        found
            .iter()
            .filter(|(file, count)| **count > limit(*file))
            .map(|(file, count)| format!("    {file}: {count}, at most {}", limit(file)))
            .collect()
    }
}

fn lines(counts: &Counts) -> String {
    counts.iter().map(|(file, count)| format!("{count} {file}\n")).collect()
}

/// Returns the words of a text in lower case, without punctuation and line breaks.
fn split(text: &str) -> Vec<String> {
    text.split(|c: char| !c.is_alphanumeric() && c != '_')
        .filter(|word| !word.is_empty())
        .map(str::to_lowercase)
        .collect()
}

fn files() -> Result<Vec<String>, String> {
    let output = Command::new("git")
        .args(["ls-files", "--"])
        .args(SEARCHED)
        .current_dir(root())
        .output()
        .map_err(|error| format!("cannot start git: {error}"))?;
    if !output.status.success() {
        return Err("git cannot list the files of this checkout".into());
    }
    let names = String::from_utf8_lossy(&output.stdout);
    let exists = |file: &&str| root().join(file).exists();
    Ok(names.lines().filter(exists).map(str::to_owned).collect())
}

fn read(file: &str) -> Result<String, String> {
    fs::read_to_string(root().join(file)).map_err(|error| format!("cannot read {file}: {error}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    const TEXT: &str = "# Comment.\nred\ndark blue\n\n2 a.rs\n1 b.md\n";

    #[test]
    fn a_word_is_found_whole_in_any_case_and_a_phrase_across_lines() {
        let avoided = Avoided::read(TEXT).unwrap();
        let found = "Red, infrared; red_shift: case.red is dark\n/// blue, not dark-red blue";
        // `Red`, `case.red`, `dark-red`, and `dark blue` over the break.
        assert_eq!(avoided.count(found), 4);
        assert_eq!(avoided.count(""), 0);
    }

    #[test]
    fn a_count_may_fall_and_may_not_rise() {
        let avoided = Avoided::read(TEXT).unwrap();
        let of = |counts: &[(&str, usize)]| {
            let found = counts.iter().map(|(file, count)| ((*file).to_owned(), *count)).collect();
            avoided.risen(&found).len()
        };
        assert_eq!(of(&[("a.rs", 2), ("b.md", 1)]), 0);
        assert_eq!(of(&[("a.rs", 1)]), 0);
        assert_eq!(of(&[("a.rs", 3)]), 1);
        assert_eq!(of(&[("c.ts", 1), ("b.md", 2)]), 2);
    }

    #[test]
    fn a_list_that_cannot_be_read_is_refused() {
        assert!(Avoided::read("red\n").is_err());
        assert!(Avoided::read("red\n\nmany a.rs\n").unwrap_err().contains("many a.rs"));
    }
}
