//! Where the `BO_` and `SG_` statements of a DBC file stand. The parser keeps
//! no places, and problems of meaning need them.

use std::ops::Range;

/// A `BO_` statement and the `SG_` statements below it.
pub(super) struct MessageStatement<'t> {
    /// All of its line.
    pub span: Range<usize>,
    /// The id with its flag bits, as written.
    pub id: &'t str,
    pub signals: Vec<Range<usize>>,
}

/// A line, with the lines that its last string runs on to.
pub(super) struct Line<'t> {
    /// The line, without blanks around it.
    pub span: Range<usize>,
    /// What `span` covers.
    pub text: &'t str,
    /// Where the next line begins: the text can be cut here without cutting
    /// a statement in two.
    pub end: usize,
}

/// Finds the messages of `text` in order.
pub(super) fn messages(text: &str) -> Vec<MessageStatement<'_>> {
    let mut found: Vec<MessageStatement<'_>> = Vec::new();
    for line in lines_outside_strings(text) {
        let mut words = line.text.split_whitespace();
        match words.next() {
            Some("BO_") => {
                let id = words.next().unwrap_or("");
                found.push(MessageStatement { span: line.span, id, signals: Vec::new() });
            }
            Some("SG_") => {
                if let Some(message) = found.last_mut() {
                    message.signals.push(line.span);
                }
            }
            _ => {}
        }
    }
    found
}

/// The lines that begin outside of any string.
pub(super) fn lines_outside_strings(text: &str) -> Vec<Line<'_>> {
    let mut lines: Vec<Line<'_>> = Vec::new();
    let mut in_string = false;
    let mut start = 0;
    for line in text.split_inclusive('\n') {
        let end = start + line.len();
        if !in_string {
            let shown = line.trim();
            let indent = line.len() - line.trim_start().len();
            lines.push(Line { span: start + indent..start + indent + shown.len(), text: shown, end });
        } else if let Some(first) = lines.last_mut() {
            first.end = end;
        }
        in_string = ends_in_string(line, in_string);
        start = end;
    }
    lines
}

/// Whether a string is open at the end of `line`; strings may run over lines.
fn ends_in_string(line: &str, mut in_string: bool) -> bool {
    let mut rest = line.chars();
    while let Some(char) = rest.next() {
        match char {
            '\\' if in_string && rest.as_str().starts_with('"') => {
                rest.next();
            }
            '"' => in_string = !in_string,
            '/' if !in_string && rest.as_str().starts_with('/') => return false,
            _ => {}
        }
    }
    in_string
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn statements_inside_comments_do_not_count() {
        let text = "BO_ 1 A: 8 X\n SG_ S : 0|8@1+ (1,0) [0|0] \"\" X // \" \nCM_ \"one \\\" line\nBO_ 2 B: 8 X\n\";\nBO_ 3 C: 1 X\n";
        let found = messages(text);
        assert_eq!(found.iter().map(|message| message.id).collect::<Vec<_>>(), ["1", "3"]);
        assert_eq!(&text[found[0].signals[0].start..][..5], "SG_ S");
    }
}
