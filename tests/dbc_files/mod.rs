//! DBC files to try readers on.

use std::io::Write;
use std::path::{Path, PathBuf};

/// Those of a corpus of other people's, if there is one here.
pub fn corpus() -> Option<Vec<PathBuf>> {
    let folder = std::env::var_os("CANLOOP_CORPUS")
        .map_or_else(|| Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared/corpus/dbc"), PathBuf::from);
    if !folder.is_dir() {
        // Not eprintln, which the test harness swallows.
        let stderr = &mut std::io::stderr();
        writeln!(stderr, "no DBC files in {}; set CANLOOP_CORPUS to a folder of some", folder.display()).unwrap();
        return None;
    }
    Some(below(&folder))
}

/// All below `folder`, at least one.
pub fn below(folder: &Path) -> Vec<PathBuf> {
    let mut files = Vec::new();
    gather(folder, &mut files);
    assert!(!files.is_empty(), "no .dbc file below {}", folder.display());
    files.sort();
    files
}

fn gather(folder: &Path, files: &mut Vec<PathBuf>) {
    for entry in std::fs::read_dir(folder).expect("the folder can be listed") {
        let path = entry.expect("the folder can be listed").path();
        if path.is_dir() {
            gather(&path, files);
        } else if path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("dbc")) {
            files.push(path);
        }
    }
}
