//! A bad DBC is refused with the line and the column of what is wrong in it.

use canloop::config::{Problems, Source};
use canloop::schema::Dbc;
use proptest::prelude::*;

fn problems(text: &str) -> Problems {
    Dbc::parse(&Source::new("bad.dbc", text)).expect_err("this DBC is bad")
}

/// The one problem of `text`: where, and its whole message.
fn problem(text: &str) -> (String, String) {
    let Problems(list) = problems(text);
    let [problem] = list.as_slice() else { panic!("expected one problem:\n{}", Problems(list)) };
    (problem.position().unwrap(), problem.to_string())
}

#[track_caller]
fn assert_problem(text: &str, position: &str, parts: &[&str]) {
    let (found, message) = problem(text);
    assert_eq!(found, position, "{message}");
    for part in parts {
        assert!(message.contains(part), "no {part:?} in:\n{message}");
    }
}

const ONE: &str = "VERSION \"\"\n\nBU_: A B\n\nBO_ 1 One: 8 A\n SG_ First : 0|16@1+ (1,0) [0|0] \"\" B\n";

#[test]
fn a_good_one_is_taken() {
    let dbc = Dbc::parse(&Source::new("good.dbc", ONE)).unwrap();
    assert_eq!(dbc.messages[0].signals[0].name, "First");
}

#[test]
fn a_syntax_error_has_its_place_and_says_what_was_expected() {
    let text = ONE.replace("(1,0)", "(1;0)");
    assert_problem(&text, "bad.dbc:6:24", &["not a valid DBC", "found `;0)`", "`,`"]);
}

#[test]
fn a_syntax_error_at_the_beginning_of_a_statement_has_its_place() {
    assert_problem(&format!("{ONE}\nBOO_ 2 Two: 8 A\n"), "bad.dbc:8:1", &["found `BOO_`", "a DBC statement"]);
}

#[test]
fn a_number_that_cannot_be_converted_has_its_line() {
    assert_problem(&format!("{ONE}\nBO_ 2 Two: -8 A\n\nBO_ 3 Three: 8 A\n"), "bad.dbc:8:1", &["-8"]);
}

#[test]
fn an_empty_file_has_no_messages() {
    assert!(Dbc::parse(&Source::new("empty.dbc", "")).unwrap().messages.is_empty());
}

#[test]
fn a_signal_past_the_end_of_its_message_is_refused() {
    let text = format!("{ONE} SG_ Late : 56|9@1+ (1,0) [0|0] \"\" B\n");
    assert_problem(&text, "bad.dbc:7:2", &["One.Late does not fit", "byte 9", "byte 8"]);
    let text = format!("{ONE} SG_ Late : 56|2@0+ (1,0) [0|0] \"\" B\n");
    assert_problem(&text, "bad.dbc:7:2", &["One.Late does not fit", "byte 9"]);
}

#[test]
fn a_signal_without_bits_or_with_too_many_is_refused() {
    assert_problem(&ONE.replace("0|16", "0|0"), "bad.dbc:6:2", &["found 0 bits", "1 to 64"]);
    assert_problem(&ONE.replace("0|16", "0|65").replace(": 8 A", ": 16 A"), "bad.dbc:6:2", &["found 65 bits"]);
}

#[test]
fn a_factor_that_cannot_be_divided_by_is_refused() {
    assert_problem(&ONE.replace("(1,0)", "(0,0)"), "bad.dbc:6:2", &["factor", "(0,0)"]);
    assert_problem(&ONE.replace("(1,0)", "(1e999,0)"), "bad.dbc:6:2", &["factor", "inf"]);
}

#[test]
fn a_float_of_the_wrong_size_is_refused() {
    let text = format!("{ONE}\nSIG_VALTYPE_ 1 First : 1;\n");
    assert_problem(&text, "bad.dbc:6:2", &["floating-point", "found 16 bits, expected 32"]);
}

#[test]
fn ids_and_names_must_not_be_given_twice() {
    assert_problem(&format!("{ONE}\nBO_ 1 Two: 8 A\n"), "bad.dbc:8:1", &["id 001 is given twice", "line 5"]);
    assert_problem(&format!("{ONE}\nBO_ 2 One: 8 A\n"), "bad.dbc:8:1", &["name One is given twice", "line 5"]);
    let text = format!("{ONE} SG_ First : 16|8@1+ (1,0) [0|0] \"\" B\n");
    assert_problem(&text, "bad.dbc:7:2", &["signal name First is given twice", "line 6"]);
}

#[test]
fn a_standard_and_an_extended_id_of_the_same_number_are_two() {
    assert!(Dbc::parse(&Source::new("good.dbc", format!("{ONE}\nBO_ 2147483649 Two: 8 A\n"))).is_ok());
}

#[test]
fn an_id_that_no_frame_can_have_is_refused() {
    for id in ["2048", "65537", "2684354560", "4294967296", "99999999999999999999"] {
        let (position, message) = problem(&format!("{ONE}\nBO_ {id} Two: 8 A\n"));
        assert_eq!(position, "bad.dbc:8:1", "{message}");
        assert!(message.contains(id), "{message}");
    }
}

#[test]
fn a_message_longer_than_a_frame_is_refused() {
    assert_problem(&format!("{ONE}\nBO_ 2 Two: 65 A\n"), "bad.dbc:8:1", &["found 65 bytes, expected at most 64"]);
}

#[test]
fn all_problems_of_meaning_come_together() {
    let text = ONE.replace("(1,0)", "(0,0)") + "\nBO_ 2 Two: 65 A\n\nBO_ 2048 Three: 8 A\n";
    assert_eq!(problems(&text).0.len(), 3);
}

#[test]
fn vector_s_parked_signals_and_a_byte_order_mark_are_no_problem() {
    let text =
        format!("\u{FEFF}{ONE}\nBO_ 3221225472 VECTOR__INDEPENDENT_SIG_MSG: 0 A\n SG_ P : 0|8@1+ (1,0) [0|0] \"\" B\n");
    let dbc = Dbc::parse(&Source::new("good.dbc", text)).unwrap();
    assert_eq!(dbc.messages.len(), 1);
}

#[test]
fn a_statement_inside_a_comment_moves_no_line_number() {
    let text = format!("{ONE}\nCM_ \"\nBO_ 9 Nine: 8 A\n\";\n\nBO_ 2 Two: 65 A\n");
    assert_problem(&text, "bad.dbc:12:1", &["Two"]);
}

const WHEEL_DRIVE: &str = include_str!("../dbc/wheel_drive.dbc");

proptest! {
    #![proptest_config(ProptestConfig { cases: 300, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn no_damage_makes_the_reader_panic(
        at in 0..WHEEL_DRIVE.len(),
        removed in 0..40_usize,
        added in "[ -~\n\"é\u{FEFF}]{0,6}|-?[0-9]{1,25}|BO_ |SG_ |//",
    ) {
        let damaged = format!("{}{added}{}", &WHEEL_DRIVE[..at], WHEEL_DRIVE.get(at + removed..).unwrap_or(""));
        if let Err(problems) = Dbc::parse(&Source::new("damaged.dbc", damaged)) {
            prop_assert!(problems.0.iter().all(|problem| problem.position().is_some()));
            prop_assert!(!problems.to_string().is_empty());
        }
    }
}
