//! Stamps in parentheses: seconds since the epoch (`-t a`), since the first
//! frame (`-t z`) or since the one before (`-t d`), or a date (`-t A`).

use crate::time::{Duration, Instant};
use crate::traffic::date::Date;
use crate::traffic::number;
use crate::traffic::words::{LineProblem, shown};

/// What the stamps of a screen count from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::traffic) enum Stamps {
    /// Always the same moment.
    Fixed,
    /// The line before.
    Deltas,
}

impl Stamps {
    /// What they seem to be in a file that begins with `head`. Times since the
    /// first frame and since the one before look alike: both begin with
    /// `(000.000000)`. Only the latter decrease, and soon do.
    pub fn guess(head: &[u8]) -> Self {
        let complete = head.iter().rposition(|&byte| byte == b'\n').unwrap_or(0);
        let lines = head[..complete].split(|&byte| byte == b'\n').filter(|line| !line.contains(&b'#'));
        let stamps: Vec<i64> = lines.filter_map(|line| split(line).ok()).map(|(nanos, _)| nanos).collect();
        let begins_at_zero = stamps.first() == Some(&0);
        let decreases = stamps.windows(2).any(|pair| pair[1] < pair[0]);
        if begins_at_zero && decreases { Self::Deltas } else { Self::Fixed }
    }

    /// The moment that a stamp means, after one at `before`.
    pub fn moment(self, before: Instant, nanos: i64) -> Instant {
        match self {
            Self::Fixed => Instant::from_nanos(nanos),
            Self::Deltas => before + Duration::from_nanos(nanos),
        }
    }
}

/// Takes the stamp off a line that begins with one; nanoseconds.
pub(super) fn split(line: &[u8]) -> Result<(i64, &[u8]), LineProblem> {
    let open = line.iter().position(|&byte| byte != b' ').unwrap_or(0);
    let inside = line.get(open + 1..).unwrap_or_default();
    if line.get(open) != Some(&b'(') {
        return Err(LineProblem::new(open as u64 + 1, "expected a time in parentheses"));
    }
    let close = memchr::memchr(b')', inside)
        .ok_or_else(|| LineProblem::new(open as u64 + 1, "a time in parentheses that do not close"))?;
    let (text, rest) = (inside[..close].trim_ascii(), &inside[close + 1..]);
    let nanos = number::nanos(text, 0).or_else(|| Date::parse(text).and_then(Date::to_nanos));
    match nanos {
        Some(nanos) => Ok((nanos, rest)),
        None => {
            let title = format!("found `{}`, expected seconds, as in (1436509052.249713)", shown(text));
            Err(LineProblem::new(open as u64 + 2, title))
        }
    }
}
