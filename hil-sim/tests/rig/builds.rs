//! The program as other builds make it.

use std::path::PathBuf;
use std::process::Command;

use serde_json::Value;

use super::finish;

/// The program built with the profile that this test was not built with. The
/// command is that of `scripts/test`, so where everything is up to date cargo
/// only says where it lies.
pub fn other_build() -> PathBuf {
    build(if cfg!(debug_assertions) { "release" } else { "dev" })
}

/// The program as users have it.
pub fn release_build() -> PathBuf {
    build("release")
}

fn build(profile: &str) -> PathBuf {
    let mut cargo = Command::new(env!("CARGO"));
    cargo.args(["build", "--workspace", "--locked", "--profile", profile, "--message-format=json-render-diagnostics"]);
    let built = finish(cargo.current_dir(env!("CARGO_MANIFEST_DIR"))).expect_status(0);
    let messages = built.stdout.lines().filter_map(|line| serde_json::from_str::<Value>(line).ok());
    let mut programs = messages.filter(|message| message["target"]["name"] == "hil-sim");
    let path = programs.find_map(|message| message["executable"].as_str().map(PathBuf::from));
    path.unwrap_or_else(|| panic!("cargo built no program:\n{}", built.stdout))
}
