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
    assert_problem(&text, "bad.dbc:6:24", &["SG_ statement cannot be read", "found `;`, expected `,`"]);
}

#[test]
fn a_length_that_is_no_number_has_its_place() {
    assert_problem(&format!("{ONE}\nBO_ 2 Two: -8 A\n\nBO_ 3 Three: 8 A\n"), "bad.dbc:8:12", &["-8"]);
}

#[test]
fn every_bad_statement_is_reported_and_the_next_is_read() {
    let text = ONE.replace("(1,0)", "(1;0)")
        + "BO_ 2 Two 8 A\n SG_ Lost : 0|8@1+ (1,0) [0|0] \"\" B\nBO_ 3 Three: 8 A\nVAL_ 3 X 0 ;\n";
    let Problems(list) = problems(&text);
    let positions: Vec<_> = list.iter().map(|problem| problem.position().unwrap()).collect();
    assert_eq!(positions, ["bad.dbc:6:24", "bad.dbc:7:11", "bad.dbc:10:12"], "{}", Problems(list));
}

#[test]
fn an_empty_file_has_no_messages() {
    assert!(Dbc::parse(&Source::new("empty.dbc", "")).unwrap().messages.is_empty());
}

#[test]
fn a_signal_past_the_end_of_its_message_is_refused() {
    let text = format!("{ONE} SG_ Late : 56|9@1+ (1,0) [0|0] \"\" B\n");
    assert_problem(&text, "bad.dbc:7:13", &["One.Late does not fit", "byte 9", "byte 8"]);
    let text = format!("{ONE} SG_ Late : 56|2@0+ (1,0) [0|0] \"\" B\n");
    assert_problem(&text, "bad.dbc:7:13", &["One.Late does not fit", "byte 9"]);
}

#[test]
fn a_signal_without_bits_is_refused() {
    assert_problem(&ONE.replace("0|16", "0|0"), "bad.dbc:6:14", &["One.First has no usable size", "found 0 bits"]);
}

#[test]
fn a_factor_that_cannot_be_divided_by_is_refused() {
    assert_problem(&ONE.replace("(1,0)", "(0,0)"), "bad.dbc:6:22", &["factor", "(0,0)"]);
    assert_problem(&ONE.replace("(1,0)", "(1e999,0)"), "bad.dbc:6:22", &["factor", "inf"]);
}

#[test]
fn a_float_of_the_wrong_size_is_refused() {
    let text = format!("{ONE}\nSIG_VALTYPE_ 1 First : 1;\n");
    assert_problem(&text, "bad.dbc:6:14", &["floating-point", "found 16 bits, expected 32"]);
}

#[test]
fn ids_and_names_must_not_be_given_twice() {
    assert_problem(&format!("{ONE}\nBO_ 1 Two: 8 A\n"), "bad.dbc:8:5", &["id 001 is given twice", "line 5"]);
    assert_problem(&format!("{ONE}\nBO_ 2 One: 8 A\n"), "bad.dbc:8:7", &["name One is given twice", "line 5"]);
    let text = format!("{ONE} SG_ First : 16|8@1+ (1,0) [0|0] \"\" B\n");
    assert_problem(&text, "bad.dbc:7:6", &["signal name First is given twice", "line 6"]);
}

#[test]
fn a_standard_and_an_extended_id_of_the_same_number_are_two() {
    assert!(Dbc::parse(&Source::new("good.dbc", format!("{ONE}\nBO_ 2147483649 Two: 8 A\n"))).is_ok());
}

#[test]
fn an_id_that_no_frame_can_have_is_refused() {
    for id in ["2048", "65537", "2684354560", "4294967296", "99999999999999999999"] {
        let (position, message) = problem(&format!("{ONE}\nBO_ {id} Two: 8 A\n"));
        assert_eq!(position, "bad.dbc:8:5", "{message}");
        assert!(message.contains(id), "{message}");
    }
}

#[test]
fn signals_of_one_frame_must_not_overlap() {
    let text = format!("{ONE} SG_ Over : 8|9@1+ (1,0) [0|0] \"\" B\n");
    assert_problem(&text, "bad.dbc:7:13", &["First and Over of One overlap"]);
    let text = format!("{ONE} SG_ Over : 8|1@0+ (1,0) [0|0] \"\" B\n SG_ Clear : 16|1@0+ (1,0) [0|0] \"\" B\n");
    assert_problem(&text, "bad.dbc:7:13", &["First and Over of One overlap"]);
}

#[test]
fn all_problems_of_meaning_come_together() {
    let text = ONE.replace("(1,0)", "(0,0)") + "\nBO_ 2 One: 8 A\n\nBO_ 2048 Three: 8 A\n";
    assert_eq!(problems(&text).0.len(), 3);
}

#[test]
fn vector_s_parked_signals_and_a_byte_order_mark_are_no_problem() {
    let text =
        format!("\u{FEFF}{ONE}\nBO_ 3221225472 VECTOR__INDEPENDENT_SIG_MSG: 0 A\n SG_ P : 0|8@1+ (1,0) [0|0] \"\" B\n");
    let dbc = Dbc::parse(&Source::new("good.dbc", text)).unwrap();
    assert_eq!(dbc.messages.len(), 1);
    assert_eq!(dbc.independent_signals[0].name, "P");
}

#[test]
fn a_statement_inside_a_comment_moves_no_line_number() {
    let text = format!("{ONE}\nCM_ \"\nBO_ 9 Nine: 8 A\n\";\n\nBO_ 2 Two: x A\n");
    assert_problem(&text, "bad.dbc:12:12", &["Two"]);
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
