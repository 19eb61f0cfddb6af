//! When a log goes on in another file, and what that is called.

use std::path::{Path, PathBuf};

use crate::time::{Duration, Instant};

/// How much goes into one file.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Rotation {
    /// Bytes, more or less a chunk.
    pub bytes: Option<u64>,
    /// Time, by the stamps.
    pub span: Option<Duration>,
}

impl Rotation {
    /// Whether there is more than one file.
    pub const fn is_wanted(&self) -> bool {
        self.bytes.is_some() || self.span.is_some()
    }

    /// Whether a file that began at `begun` and has so many bytes is full at
    /// `now`.
    pub fn is_due(&self, begun: Instant, now: Instant, bytes: u64) -> bool {
        self.bytes.is_some_and(|most| bytes >= most) || self.span.is_some_and(|most| now - begun >= most)
    }

    /// The name of the `nth` file, counted from 1: `bus.mcap`, or `bus-0001.mcap`
    /// and so on.
    pub fn path(&self, path: &Path, nth: u32) -> PathBuf {
        if !self.is_wanted() {
            return path.to_owned();
        }
        let stem = path.file_stem().unwrap_or_default().to_string_lossy();
        path.with_file_name(format!("{stem}-{nth:04}.mcap"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn files_are_numbered_where_there_may_be_several() {
        let path = Path::new("logs/bus.mcap");
        assert_eq!(Rotation::default().path(path, 1), path);
        let rotation = Rotation { bytes: Some(1), span: None };
        assert_eq!(rotation.path(path, 12), Path::new("logs/bus-0012.mcap"));
    }

    #[test]
    fn a_file_is_full_by_its_bytes_or_its_time() {
        let after = |seconds| Instant::ZERO + Duration::from_secs_f64(seconds);
        let both = Rotation { bytes: Some(1000), span: Some(Duration::from_secs_f64(60.0)) };
        assert!(!both.is_due(Instant::ZERO, after(59.9), 999));
        assert!(both.is_due(Instant::ZERO, after(60.0), 0) && both.is_due(Instant::ZERO, after(0.0), 1000));
        assert!(!Rotation::default().is_due(Instant::ZERO, after(1e6), u64::MAX));
    }
}
