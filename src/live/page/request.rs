//! What a request asks for, and whether it gets it.

use hyper::{HeaderMap, Method, StatusCode, header};

/// An answer to be given.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Answer {
    /// The page itself.
    Document,
    /// What is new, as long as the viewer stays.
    Updates,
    /// Nothing, and why.
    Refusal(StatusCode, &'static str),
}

impl Answer {
    /// The answer to a request. Nothing that it says is acted on.
    pub fn to(method: &Method, path: &str, headers: &HeaderMap) -> Self {
        if method != Method::GET {
            return Self::Refusal(
                StatusCode::METHOD_NOT_ALLOWED,
                "this page looks on and takes no commands: GET only\n",
            );
        }
        if !is_for_loopback(headers) {
            let text = "ask for it as localhost or by a loopback address\n";
            return Self::Refusal(StatusCode::MISDIRECTED_REQUEST, text);
        }
        match path {
            "/" => Self::Document,
            "/updates" => Self::Updates,
            _ => Self::Refusal(StatusCode::NOT_FOUND, "there is only one page here: /\n"),
        }
    }
}

/// Whether a browser believes that it speaks with this machine. One that was
/// led here by somebody else's name would show them what it gets.
fn is_for_loopback(headers: &HeaderMap) -> bool {
    let host = headers.get(header::HOST).and_then(|host| host.to_str().ok()).unwrap_or_default();
    let name = match host.rsplit_once(':') {
        Some((name, port)) if port.bytes().all(|byte| byte.is_ascii_digit()) => name,
        _ => host,
    };
    let bare = name.strip_prefix('[').and_then(|name| name.strip_suffix(']')).unwrap_or(name);
    name.eq_ignore_ascii_case("localhost") || bare.parse().is_ok_and(|ip: std::net::IpAddr| ip.is_loopback())
}

#[cfg(test)]
mod tests {
    use hyper::header::HeaderValue;

    use super::*;

    fn answer(method: &Method, path: &str, host: &str) -> Answer {
        let host = HeaderValue::from_str(host).expect("a header");
        Answer::to(method, path, &HeaderMap::from_iter([(header::HOST, host)]))
    }

    fn status(answer: Answer) -> u16 {
        match answer {
            Answer::Refusal(status, _) => status.as_u16(),
            Answer::Document | Answer::Updates => 200,
        }
    }

    #[test]
    fn there_is_a_page_and_its_updates_and_nothing_else() {
        assert_eq!(answer(&Method::GET, "/", "127.0.0.1:8766"), Answer::Document);
        assert_eq!(answer(&Method::GET, "/updates", "127.0.0.1:8766"), Answer::Updates);
        for path in ["/favicon.ico", "/updates/", "//", "/../etc/passwd", "*"] {
            assert_eq!(status(answer(&Method::GET, path, "127.0.0.1:8766")), 404, "{path}");
        }
    }

    #[test]
    fn no_method_but_get_is_allowed_anywhere() {
        for method in [Method::POST, Method::PUT, Method::DELETE, Method::HEAD, Method::OPTIONS, Method::CONNECT] {
            for path in ["/", "/updates", "/stop"] {
                assert_eq!(status(answer(&method, path, "localhost")), 405, "{method} {path}");
            }
        }
    }

    #[test]
    fn a_browser_that_somebody_elses_name_led_here_is_sent_away() {
        for host in ["localhost", "LOCALHOST:1", "127.0.0.1", "127.0.0.1:8766", "127.9.9.9:1", "[::1]", "[::1]:8766"] {
            assert_eq!(status(answer(&Method::GET, "/", host)), 200, "{host}");
        }
        for host in ["", "example.org", "example.org:8766", "localhost.example.org", "10.0.0.1:8766", "[::2]:1", ":1"] {
            assert_eq!(status(answer(&Method::GET, "/", host)), 421, "{host}");
        }
        assert_eq!(status(Answer::to(&Method::GET, "/", &HeaderMap::new())), 421);
    }
}
