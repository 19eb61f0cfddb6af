//! Writes SVG, HTML and XML. Every text and attribute passes through here, so this
//! is the one place where escaping is done.

use std::fmt::Write as _;

/// A document being written.
#[derive(Debug, Default)]
pub struct Markup {
    written: String,
}

impl Markup {
    /// `<tag a="b">`.
    pub fn open(&mut self, tag: &str, attributes: &[(&str, &str)]) {
        self.start(tag, attributes);
        self.written.push_str(">\n");
    }

    /// `</tag>`.
    pub fn close(&mut self, tag: &str) {
        _ = writeln!(self.written, "</{tag}>");
    }

    /// `<tag a="b"/>`, which HTML allows for void elements and SVG for all.
    pub fn empty(&mut self, tag: &str, attributes: &[(&str, &str)]) {
        self.start(tag, attributes);
        self.written.push_str("/>\n");
    }

    /// `<tag a="b">text</tag>`.
    pub fn leaf(&mut self, tag: &str, attributes: &[(&str, &str)], text: &str) {
        self.start(tag, attributes);
        self.written.push('>');
        self.text(text);
        self.close(tag);
    }

    /// Text from anywhere.
    pub fn text(&mut self, text: &str) {
        for character in text.chars() {
            match character {
                '&' => self.written.push_str("&amp;"),
                '<' => self.written.push_str("&lt;"),
                '>' => self.written.push_str("&gt;"),
                '"' => self.written.push_str("&quot;"),
                // XML has no way to write most control characters, not even escaped.
                '\u{fffe}' | '\u{ffff}' => self.written.push(char::REPLACEMENT_CHARACTER),
                control if control.is_control() && !matches!(control, '\n' | '\t') => {
                    self.written.push(char::REPLACEMENT_CHARACTER);
                }
                plain => self.written.push(plain),
            }
        }
    }

    /// Our own style sheets and preambles, as they are.
    pub fn trusted(&mut self, markup: &str) {
        self.written.push_str(markup);
    }

    /// The document.
    pub fn finish(self) -> String {
        self.written
    }

    fn start(&mut self, tag: &str, attributes: &[(&str, &str)]) {
        _ = write!(self.written, "<{tag}");
        for (name, value) in attributes {
            _ = write!(self.written, " {name}=\"");
            self.text(value);
            self.written.push('"');
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn text_and_attributes_are_escaped() {
        let mut markup = Markup::default();
        markup.leaf("p", &[("class", "\"><script>")], "a < b && c > \"d\"");
        assert_eq!(
            markup.finish(),
            "<p class=\"&quot;&gt;&lt;script&gt;\">a &lt; b &amp;&amp; c &gt; &quot;d&quot;</p>\n"
        );
    }

    #[test]
    fn control_characters_that_xml_forbids_are_replaced() {
        let mut markup = Markup::default();
        markup.text("a\0b\u{1b}c\td\n");
        assert_eq!(markup.finish(), "a\u{fffd}b\u{fffd}c\td\n");
    }
}
