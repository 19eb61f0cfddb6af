//! The files in which a Linux machine tells of itself.

use std::path::{Path, PathBuf};

/// A machine, as the files under its root folder show it.
#[derive(Clone, Debug)]
pub struct Machine {
    root: PathBuf,
}

impl Machine {
    /// This machine.
    pub fn here() -> Self {
        Self::at(Path::new("/"))
    }

    /// A machine whose `proc`, `sys`, `etc` and `lib` lie in the folder `root`.
    pub fn at(root: &Path) -> Self {
        Self { root: root.to_owned() }
    }

    /// The text of a file without white space at its ends; `path` has no
    /// leading slash. `None` when it cannot be read.
    pub fn text(&self, path: &str) -> Option<String> {
        let bytes = std::fs::read(self.root.join(path)).ok()?;
        Some(String::from_utf8_lossy(&bytes).trim().to_owned())
    }
}
