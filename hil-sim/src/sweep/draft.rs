//! A file that nobody sees until it is whole.

use std::fs::File;
use std::io;
use std::path::{Path, PathBuf};

/// A file that is written under another name, and is gone if it is not finished.
pub struct Draft {
    /// Where it will be.
    pub path: PathBuf,
    draft: PathBuf,
}

impl Draft {
    /// What is to be at `path`.
    pub fn of(path: &Path) -> Self {
        let mut draft = path.as_os_str().to_owned();
        draft.push(".part");
        Self { path: path.to_owned(), draft: draft.into() }
    }

    /// Begins it.
    ///
    /// # Errors
    /// The system says no.
    pub fn create(&self) -> io::Result<File> {
        File::create(&self.draft)
    }

    /// Gives it its name, once what was written to `file` is on the disk.
    ///
    /// # Errors
    /// The system says no.
    pub fn publish(&self, file: &File) -> io::Result<()> {
        file.sync_all()?;
        std::fs::rename(&self.draft, &self.path)
    }
}

impl Drop for Draft {
    fn drop(&mut self) {
        // Nothing is left of what was published; of anything else nothing should be.
        let _ = std::fs::remove_file(&self.draft);
    }
}
