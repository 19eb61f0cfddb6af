//! Logs from elsewhere, if they are here.

use std::io::Write;
use std::path::{Path, PathBuf};

use canloop::traffic::{Content, Format};

use crate::rig::{WRITTEN, folder, path_for, read};

/// Those of a corpus of other people's, if there is one here.
fn corpus() -> Option<Vec<PathBuf>> {
    let folder = std::env::var_os("CANLOOP_LOG_CORPUS")
        .map_or_else(|| Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared/corpus/logs"), PathBuf::from);
    if !folder.is_dir() {
        // Not eprintln, which the test harness swallows.
        let stderr = &mut std::io::stderr();
        writeln!(stderr, "no logs in {}; set CANLOOP_LOG_CORPUS to a folder of some", folder.display()).unwrap();
        return None;
    }
    let mut files = Vec::new();
    gather(&folder, &mut files);
    assert!(!files.is_empty(), "no file below {}", folder.display());
    files.sort();
    Some(files)
}

fn gather(folder: &Path, files: &mut Vec<PathBuf>) {
    for entry in std::fs::read_dir(folder).expect("the folder can be listed") {
        let path = entry.expect("the folder can be listed").path();
        if path.is_dir() { gather(&path, files) } else { files.push(path) }
    }
}

#[test]
fn every_frame_of_the_corpus_survives_every_format() {
    let Some(files) = corpus() else { return };
    let folder = folder();
    for file in files {
        let original = read(&file, None);
        assert!(original.log.records.len() > 10, "{}: {:?}", file.display(), original.findings);
        let frames = |log: &crate::rig::Log| -> Vec<(i64, String)> {
            let frame = |record: &canloop::traffic::Record| match &record.content {
                Content::Frame(recorded) => Some((record.at.as_nanos() / 1_000_000, recorded.frame.to_string())),
                _ => None,
            };
            log.records.iter().filter_map(frame).collect()
        };
        for (format, extension) in WRITTEN {
            let path = path_for(folder.path(), "log", format, extension);
            original.log.write(&path, format);
            let back = read(&path, Some(format));
            assert!(back.findings.is_empty(), "{} as {format}: {:?}", file.display(), back.findings);
            let (was, is) = (frames(&original.log), frames(&back.log));
            assert!(was == is, "{} as {format}", file.display());
        }
    }
}

#[test]
fn the_corpus_cut_short_is_read_up_to_there() {
    let Some(files) = corpus() else { return };
    for file in files {
        let (format, _) = canloop::traffic::open(&file, None).unwrap_or_else(|problem| panic!("{problem}"));
        let all = read(&file, None).log.records;
        let bytes = std::fs::read(&file).expect("it can be read");
        let folder = folder();
        for part in 1..20 {
            let path = folder.path().join(file.file_name().expect("a name"));
            std::fs::write(&path, &bytes[..bytes.len() * part / 20]).expect("it is written");
            let cut = read(&path, Some(format)).log.records;
            let sure = cut.len().saturating_sub(usize::from(format == Format::Candump));
            assert!(cut[..sure] == all[..sure], "{} cut at {part}/20", file.display());
        }
    }
}
