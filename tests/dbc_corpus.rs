//! DBC files from elsewhere are read, in spite of what is wrong with them; none
//! makes the reader panic, and none makes it write where it should not.

#[path = "dbc_files/mod.rs"]
mod dbc_files;

use canloop::schema::Dbc;

#[test]
fn no_file_of_the_corpus_makes_it_panic() {
    let Some(files) = dbc_files::corpus() else { return };
    let mut refused = 0;
    for file in &files {
        let source = Dbc::read_source(file).unwrap_or_else(|problem| panic!("{problem}"));
        let (dbc, findings) = Dbc::parse_leniently(&source);
        assert!(findings.iter().all(|problem| problem.position().is_some()), "{}", file.display());
        read_and_write_all_signals(&dbc);
        refused += usize::from(Dbc::parse(&source).is_err());
    }
    // Real files have mistakes, but few of them.
    assert!(refused * 5 < files.len(), "{refused} of {} files refused", files.len());
}

fn read_and_write_all_signals(dbc: &Dbc) {
    for message in &dbc.messages {
        assert_eq!(dbc.message_by_id(message.id).map(|found| found.id), Some(message.id));
        let mut data = [0xA5; 300];
        for signal in &message.signals {
            signal.encode(&mut data[..message.len], signal.maximum);
            signal.decode_name(&data);
            let _ = signal.decode(&data);
        }
        assert!(data[message.len..].iter().all(|&byte| byte == 0xA5), "{} writes past its end", message.name);
        for len in 0..message.len {
            let carried = message.decode_payload(&data[..len]).count();
            assert_eq!(carried + message.absent(&data[..len]).count(), message.signals.len());
        }
    }
}
