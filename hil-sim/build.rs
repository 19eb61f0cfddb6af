//! Lists the shipped scenarios, so that the program finds them by name from
//! any directory.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};

fn main() {
    println!("cargo:rerun-if-changed=scenarios");
    let root = PathBuf::from(std::env::var_os("CARGO_MANIFEST_DIR").expect("cargo sets it"));
    let out = PathBuf::from(std::env::var_os("OUT_DIR").expect("cargo sets it"));
    let mut files: Vec<PathBuf> = std::fs::read_dir(root.join("scenarios"))
        .expect("the scenarios are part of the package")
        .map(|entry| entry.expect("a readable directory").path())
        .filter(|path| path.extension().is_some_and(|extension| extension == "toml"))
        .collect();
    files.sort();
    let mut list = String::from("[\n");
    for file in &files {
        let name = file.file_stem().and_then(|stem| stem.to_str()).expect("a UTF-8 name");
        writeln!(list, "    ({name:?}, include_str!({:?})),", file.display()).expect("a String takes all");
    }
    list.push(']');
    std::fs::write(Path::new(&out).join("scenarios.rs"), list).expect("OUT_DIR is writable");
}
