//! The page's HTML, which holds all it needs.

use std::hash::{BuildHasher, RandomState};

/// The page, and the policy it is served with.
pub(super) struct Document {
    pub html: String,
    /// Content-Security-Policy: the page's own style and script, updates from
    /// where it came from, and nothing else.
    pub policy: String,
}

impl Document {
    /// The page, with a nonce that nobody can guess.
    pub fn new() -> Self {
        let nonce = format!("{:016x}", RandomState::new().hash_one("nonce"));
        let style =
            [include_str!("../../report/page.css"), include_str!("../../report/chart.css"), include_str!("page.css")];
        let html = include_str!("page.html")
            .replace("{nonce}", &nonce)
            .replace("{style}", &style.concat())
            .replace("{script}", include_str!("page.js"));
        let policy = format!(
            "default-src 'none'; style-src 'nonce-{nonce}'; script-src 'nonce-{nonce}'; connect-src 'self'; base-uri \
             'none'; form-action 'none'; frame-ancestors 'none'"
        );
        Self { html, policy }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_page_holds_all_it_needs_and_asks_for_nothing_from_anywhere() {
        let Document { html, policy } = Document::new();
        let html = html.replace("\"http://www.w3.org/2000/svg\"", "");
        for word in
            ["http:", "https:", "src=", "@import", "url(", "<link", "innerHTML", "{nonce}", "{style}", "{script}"]
        {
            assert!(!html.contains(word), "{word}");
        }
        let nonce = policy.split("nonce-").nth(1).and_then(|rest| rest.split('\'').next()).expect("a nonce");
        assert_eq!(html.matches(nonce).count(), 2);
        assert!(!policy.contains("unsafe") && html.contains("prefers-color-scheme: dark"));
    }

    #[test]
    fn each_page_has_a_nonce_of_its_own() {
        assert_ne!(Document::new().policy, Document::new().policy);
    }
}
