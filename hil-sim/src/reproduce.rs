//! The command that runs a scenario again.

use crate::scenario::Scenario;

/// One line for a shell: the scenario, its seed and the overrides laid over it.
pub fn command(scenario: &Scenario) -> String {
    let mut words = vec!["hil-sim".to_owned(), "run".to_owned(), scenario.given.clone()];
    let is_seed = |set: &String| set.split('=').next().is_some_and(|key| key.trim() == "seed");
    let seed = (!scenario.overrides.iter().any(is_seed)).then(|| format!("seed={}", scenario.seed));
    for set in scenario.overrides.iter().cloned().chain(seed) {
        words.extend(["--set".to_owned(), set]);
    }
    words.iter().map(|word| quoted(word)).collect::<Vec<_>>().join(" ")
}

/// A word as a POSIX shell takes it for itself.
fn quoted(word: &str) -> String {
    let is_plain = |c: char| c.is_ascii_alphanumeric() || "_-./=,:+@%".contains(c);
    if !word.is_empty() && word.chars().all(is_plain) {
        return word.to_owned();
    }
    format!("'{}'", word.replace('\'', r"'\''"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_with_anything_special_in_them_are_quoted() {
        assert_eq!(quoted("a/b.toml"), "a/b.toml");
        assert_eq!(quoted("seed=-1"), "seed=-1");
        assert_eq!(quoted(""), "''");
        assert_eq!(quoted("it's $HOME"), r"'it'\''s $HOME'");
        assert_eq!(quoted("a=\"b\"\n"), "'a=\"b\"\n'");
    }
}
