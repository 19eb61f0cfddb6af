//! What is said in a DBC file is found, however it is written, and a statement
//! that makes no sense costs no more than itself.

use std::path::Path;

use canloop::config::{Problem, Severity, Source};
use canloop::schema::{Dbc, MessageLayout};

fn file(name: &str) -> Dbc {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/dbc").join(name);
    Dbc::parse(&Dbc::read_source(&path).unwrap()).unwrap_or_else(|problems| panic!("{problems}"))
}

fn read(text: &str) -> (Dbc, Vec<Problem>) {
    Dbc::parse_leniently(&Source::new("file.dbc", text))
}

/// The one finding of `text`, and what it says.
#[track_caller]
fn finding(text: &str) -> (Dbc, Severity, String) {
    let (dbc, findings) = read(text);
    let [problem] = findings.as_slice() else { panic!("expected one finding, found {findings:#?}") };
    (dbc, problem.severity, problem.to_string())
}

#[track_caller]
fn assert_warning(text: &str, part: &str) -> Dbc {
    let (dbc, severity, message) = finding(text);
    assert!(message.contains(part), "no {part:?} in:\n{message}");
    assert!(severity == Severity::Warning && message.starts_with("warning: "), "{message}");
    assert!(Dbc::parse(&Source::new("file.dbc", text)).is_ok());
    dbc
}

fn signal_names(message: &MessageLayout) -> Vec<&str> {
    message.signals.iter().map(|signal| signal.name.as_str()).collect()
}

const ONE: &str = "BU_: A B\n\nBO_ 1 One: 8 A\n SG_ First : 0|16@1+ (1,0) [0|0] \"\" B\n";

#[test]
fn blanks_line_ends_and_statements_of_no_use_are_no_matter() {
    let (dbc, findings) = read(&file("quirks.dbc").source.text);
    assert!(findings.is_empty(), "{findings:#?}");
    let names: Vec<_> = dbc.messages.iter().map(|message| message.name.as_str()).collect();
    assert_eq!(names, ["Tight", "Empty", "Extended"]);
    assert_eq!(signal_names(&dbc.messages[0]), ["One", "Two", "Three"]);
    assert_eq!(dbc.messages[0].signals[0].value_names, [(0, "Off".to_owned()), (1, "On".to_owned())]);
    assert_eq!(dbc.messages[0].signals[2].unit, "// no comment");
}

#[test]
fn signals_of_no_message_are_kept_apart() {
    let parked = file("quirks.dbc").independent_signals;
    assert_eq!(parked.iter().map(|signal| signal.name.as_str()).collect::<Vec<_>>(), ["Parked", "ParkedToo"]);
}

#[test]
fn old_text_is_windows_1252() {
    let dbc = file("windows_1252.dbc");
    let signal = dbc.messages[0].signal("Kuehlwasser").unwrap();
    assert_eq!((signal.unit.as_str(), signal.comment.as_str()), ("°C", "Kühlwasser – gemessen"));
    assert_eq!(dbc.messages[0].signals[1].value_names[1].1, "heiß");
}

#[test]
fn text_may_begin_with_a_byte_order_mark() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("marked.dbc");
    let utf_16: Vec<u8> = format!("\u{FEFF}{ONE}").encode_utf16().flat_map(u16::to_le_bytes).collect();
    for bytes in [format!("\u{FEFF}{ONE}").into_bytes(), utf_16] {
        std::fs::write(&path, bytes).unwrap();
        let dbc = Dbc::parse(&Dbc::read_source(&path).unwrap()).unwrap();
        assert_eq!(dbc.messages[0].name, "One");
    }
}

#[test]
fn long_names_take_the_place_of_short_ones_which_still_find_them() {
    let dbc = file("long_names.dbc");
    let message = dbc.message("AVeryLongMessageNameThatIsCutShortByOlderTools").unwrap();
    assert_eq!(dbc.message("AVeryLongMessageNameThatIsCut_00"), Some(message));
    assert_eq!(message.sender, "AVeryLongNodeNameThatIsCutShortByOlderTools");
    let signal = message.signal("AVeryLongSignalNameThatIsCutShortByOlderTools").unwrap();
    assert_eq!(message.signal("AVeryLongSignalNameThatIsCut_000"), Some(signal));
    assert_eq!(signal.comment, "Said of the short name.");
}

#[test]
fn a_switch_with_a_long_name_still_switches() {
    let text = file("long_names.dbc")
        .source
        .text
        .replace("VAL_ 1", "BA_ \"SystemSignalLongSymbol\" SG_ 1 AVeryLongSwitchNameThatIsCut_000 \"Switch\";\nVAL_ 1");
    let dbc = Dbc::parse(&Source::new("long.dbc", text)).unwrap();
    let names = |payload: [u8; 8]| {
        dbc.messages[0].decode_payload(&payload).map(|(signal, _)| signal.name.clone()).collect::<Vec<_>>()
    };
    assert_eq!(names([0; 8]), ["Switch", "AVeryLongSignalNameThatIsCutShortByOlderTools"]);
    assert_eq!(names([1; 8]), ["Switch", "AVeryLongSignalNameThatIsCutShortToo"]);
}

#[test]
fn attributes_have_defaults() {
    let dbc = file("values.dbc");
    assert_eq!(dbc.messages[0].cycle.unwrap().as_nanos(), 20_000_000);
    assert_eq!(dbc.messages[1].cycle.unwrap().as_nanos(), 1_000_000_000);
    assert_eq!(dbc.messages[1].signal("State").unwrap().start_value, Some(1.0));
    assert_eq!(dbc.messages[1].signal("Start").unwrap().start_value, Some(250.0));
}

#[test]
fn a_value_named_twice_has_the_last_name() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/dbc/values.dbc");
    let (_, severity, message) = finding(&Dbc::read_source(&path).unwrap().text);
    assert!(severity == Severity::Warning && message.contains("a value of Named.State is named twice"), "{message}");
    assert_eq!(file("values.dbc").messages[1].signals[0].decode_name(&[0; 8]), Some("Booting"));
}

#[test]
fn values_may_refer_to_a_table() {
    let text = format!("VAL_TABLE_ OnOff 1 \"On\" 0 \"Off\" ;\n{ONE}VAL_ 1 First OnOff ;\n");
    assert_eq!(read(&text).0.messages[0].signals[0].decode_name(&[1, 0]), Some("On"));
    assert_warning(&format!("{ONE}VAL_ 1 First OnOff ;\n"), "no value table `OnOff`");
}

#[test]
fn values_of_64_bits_have_names_too() {
    let dbc = file("values.dbc");
    assert_eq!(dbc.messages[0].signals[0].decode_name(&[0xFF; 32]), Some("Not available"));
}

#[test]
fn a_bad_statement_costs_no_more_than_itself() {
    let text =
        format!("{ONE} SG_ Bad : 16|8@1 (1,0) [0|0] \"\" B\n SG_ Good : 24|8@1+ (1,0) [0|0] \"\" B\nBO_ 2 Two: 8 A\n");
    let (dbc, severity, message) = finding(&text);
    assert!(severity == Severity::Error && message.contains("found `(`, expected `+` or `-`"), "{message}");
    assert_eq!(signal_names(&dbc.messages[0]), ["First", "Good"]);
    assert_eq!(dbc.messages.len(), 2);
}

#[test]
fn signals_of_a_bad_message_are_nobody_s() {
    let text = format!("{ONE}BO_ Two: 8 A\n SG_ Lost : 0|8@1+ (1,0) [0|0] \"\" B\nBO_ 3 Three: 8 A\n");
    let (dbc, severity, _) = finding(&text);
    assert_eq!(severity, Severity::Error);
    assert_eq!(signal_names(&dbc.messages[0]), ["First"]);
    assert_eq!(dbc.messages[1].name, "Three");
}

#[test]
fn what_nobody_knows_is_passed_over() {
    let dbc = assert_warning(&format!("{ONE}XYZ_ 1 2 \"3\" ;\nBO_ 2 Two: 8 A\n"), "`XYZ_` is no DBC statement");
    assert_eq!(dbc.messages.len(), 2);
}

#[test]
fn a_string_that_nothing_ends_ends_with_its_line() {
    let dbc = assert_warning(&format!("{ONE}CM_ BO_ 1 \"open;\nBO_ 2 Two: 8 A\n"), "closing `\"`");
    assert_eq!(dbc.messages.len(), 2);
}

#[test]
fn a_missing_semicolon_is_read_over() {
    let dbc = assert_warning(&format!("{ONE}CM_ BO_ 1 \"What it is.\"\nBO_ 2 Two: 8 A\n"), "expected `;`");
    assert_eq!((dbc.messages.len(), dbc.messages[0].comment.as_str()), (2, "What it is."));
}

#[test]
fn a_list_of_new_symbols_ends_where_statements_begin() {
    for list in [
        "NS_ :\n\tCM_\n\tBA_\n\n",
        "NS_ : CM_ BA_ VAL_\n",
        "NS_:\n",
        "NS_ :\n CM_\n BS_:\n",
        "NS_ :\n CM_\n CM_ BO_ 1 \"x\";\n",
    ] {
        let (dbc, findings) = read(&format!("{list}{ONE}"));
        assert!(findings.is_empty(), "{list:?}: {findings:#?}");
        assert_eq!(dbc.messages.len(), 1, "{list:?}");
    }
}

#[test]
fn notes_of_what_is_not_there_are_warned_of() {
    for note in [
        "CM_ BU_ C \"x\";",
        "CM_ BO_ 2 \"x\";",
        "CM_ SG_ 1 Second \"x\";",
        "BA_ \"GenMsgCycleTime\" BO_ 2 10;",
        "VAL_ 1 Second 0 \"x\";",
        "SIG_VALTYPE_ 2 First : 1;",
        "SG_MUL_VAL_ 1 Second First 0-1;",
    ] {
        assert_warning(&format!("{ONE}{note}\n"), "speaks of something that is not there");
    }
}

#[test]
fn a_range_without_sense_is_no_range() {
    for range in ["[1.#QNAN|-1.#IND]", "[5|1]", "[NaN|inf]"] {
        let (dbc, findings) = read(&ONE.replace("[0|0]", range));
        let signal = &dbc.messages[0].signals[0];
        assert_eq!((signal.minimum, signal.maximum), (0.0, 0.0), "{range}");
        assert!(findings.iter().all(|problem| problem.severity == Severity::Warning), "{findings:#?}");
    }
}

#[test]
fn a_message_longer_than_a_frame_is_taken_for_segmented() {
    assert_warning(&format!("{ONE}BO_ 2 Two: 1785 A\n"), "found 1785 bytes");
}

#[test]
fn a_signal_wider_than_a_number_is_there_but_has_no_value() {
    let text = format!(
        "{ONE}BO_ 2 Two: 64 A\n SG_ Text : 0|400@1+ (1,0) [0|0] \"\" B\n SG_ After : 400|8@1+ (1,0) [0|0] \"\" B\n"
    );
    let dbc = assert_warning(&text, "found 400 bits");
    let values: Vec<_> =
        dbc.messages[1].decode_payload(&[7; 64]).map(|(signal, value)| (&*signal.name, value)).collect();
    assert_eq!(values, [("After", 7.0)]);
}

#[test]
fn a_signal_past_the_end_is_there_when_the_frame_is_long_enough() {
    let text = ONE.replace("0|16", "56|16");
    let (dbc, severity, _) = finding(&text);
    assert_eq!(severity, Severity::Error);
    assert_eq!(dbc.messages[0].decode_payload(&[1; 8]).count(), 0);
    assert_eq!(dbc.messages[0].decode_payload(&[1; 9]).next().unwrap().1, 257.0);
}

#[test]
fn a_multiplexed_signal_without_a_switch_is_always_there() {
    for marks in [["", " m0"], [" M", " m"], [" M", " x1"], ["", " m1"]] {
        let text = ONE.replace("First :", &format!("First{} :", marks[0]))
            + &format!(" SG_ Second{} : 16|8@1+ (1,0) [0|0] \"\" B\n", marks[1]);
        let dbc = assert_warning(&text, "taken to be there always");
        assert_eq!(dbc.messages[0].decode_payload(&[9; 8]).count(), 2, "{marks:?}");
    }
}

#[test]
fn switches_in_a_circle_are_always_there() {
    let text = "BO_ 1 One: 8 A\n SG_ A m0M : 0|8@1+ (1,0) [0|0] \"\" B\n SG_ B m0M : 8|8@1+ (1,0) [0|0] \"\" B\n\
                SG_MUL_VAL_ 1 A B 0-0;\nSG_MUL_VAL_ 1 B A 0-0;\n";
    let (dbc, findings) = read(text);
    assert!(findings.iter().any(|problem| problem.title.contains("switches itself")), "{findings:#?}");
    assert_eq!(dbc.messages[0].decode_payload(&[0; 8]).count(), 2);
}
