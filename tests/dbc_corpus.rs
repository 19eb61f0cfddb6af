//! DBC files from elsewhere are read, or refused with a reason; none makes the
//! reader panic.

use std::io::Write;
use std::path::{Path, PathBuf};

use canloop::schema::Dbc;

#[test]
fn no_file_of_the_corpus_makes_it_panic() {
    let folder = std::env::var_os("CANLOOP_CORPUS")
        .map_or_else(|| Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared/corpus/dbc"), PathBuf::from);
    if !folder.is_dir() {
        // Not eprintln, which the test harness swallows.
        let stderr = &mut std::io::stderr();
        writeln!(stderr, "no DBC files in {}; set CANLOOP_CORPUS to a folder of some", folder.display()).unwrap();
        return;
    }
    let files = dbc_files(&folder);
    let mut refused = 0;
    for file in &files {
        let source = Dbc::read_source(file).unwrap_or_else(|problem| panic!("{problem}"));
        match Dbc::parse(&source) {
            Ok(dbc) => read_all_signals(&dbc),
            Err(problems) => {
                refused += 1;
                assert!(problems.0.iter().all(|problem| problem.position().is_some()), "{problems}");
            }
        }
    }
    assert!(!files.is_empty(), "no .dbc file below {}", folder.display());
    // Real files have mistakes, but few of them.
    assert!(refused * 5 < files.len(), "{refused} of {} files refused", files.len());
}

fn read_all_signals(dbc: &Dbc) {
    for message in &dbc.messages {
        assert_eq!(dbc.message_by_id(message.id), Some(message));
        let mut data = [0xA5; 64];
        for signal in &message.signals {
            signal.encode(&mut data[..message.len], signal.maximum);
            signal.decode_name(&data);
            let _ = signal.decode(&data);
        }
        assert!(data[message.len..].iter().all(|&byte| byte == 0xA5), "{} writes past its end", message.name);
    }
}

fn dbc_files(folder: &Path) -> Vec<PathBuf> {
    let mut files = Vec::new();
    for entry in std::fs::read_dir(folder).expect("the corpus can be listed") {
        let path = entry.expect("the corpus can be listed").path();
        if path.is_dir() {
            files.extend(dbc_files(&path));
        } else if path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("dbc")) {
            files.push(path);
        }
    }
    files
}
