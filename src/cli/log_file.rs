//! What commands on logs share: opening one, and saying what is wrong with it.

use std::fs::File;
use std::io::Read;
use std::path::Path;

use indicatif::{ProgressBar, ProgressStyle};

use crate::config::Problem;
use crate::traffic::{self, Conversion, Format, Reader};

/// A file shorter than this is read before anybody could look at a bar.
const LONG_BYTES: u64 = 32 << 20;

/// Opens the log at `path`, `-` for standard input, in the format called
/// `from` or in what it shows itself to be. A long one has a progress bar, if
/// somebody watches.
pub fn open_log(path: &Path, from: Option<&str>) -> Result<(Format, Box<dyn Reader>), Problem> {
    let from = from.map(Format::parse).transpose()?;
    if path == Path::new("-") {
        return traffic::read(std::io::stdin(), path, from);
    }
    let cannot = |error| Problem::bare(format!("cannot open {}: {error}", path.display()));
    let file = File::open(path).map_err(cannot)?;
    let about = file.metadata().map_err(cannot)?;
    if about.is_dir() {
        return Err(Problem::bare(format!("{} is a folder, expected a log", path.display())));
    }
    let input: Box<dyn Read> = match about.len() {
        LONG_BYTES.. => Box::new(bar(about.len()).wrap_read(file)),
        _ => Box::new(file),
    };
    traffic::read(input, path, from)
}

/// The path for messages.
pub fn named(path: &Path) -> String {
    if path == Path::new("-") { "standard input".to_owned() } else { path.display().to_string() }
}

/// Says what was found wrong with the log called `name`.
pub fn complain(name: &str, done: &Conversion) {
    for finding in &done.findings {
        eprintln!("{}", finding.of(name));
    }
    let more = done.errors + done.warnings - done.findings.len() as u64;
    if more > 0 {
        eprintln!("... and {more} more like that");
    }
    if done.errors > 0 {
        eprintln!("{name}: {} records were read in spite of {} errors", done.records, done.errors);
    }
}

fn bar(bytes: u64) -> ProgressBar {
    let style = ProgressStyle::with_template("{bar:40} {bytes} of {total_bytes}, {eta} left");
    let bar = ProgressBar::new(bytes);
    // A template that did not parse would only look different.
    style.map_or(bar.clone(), |style| bar.with_style(style))
}
