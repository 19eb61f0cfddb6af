//! One thing looked at, and what came of it.

use std::fmt;

/// How a thing is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, serde::Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Outcome {
    /// As it should be.
    Ok,
    /// The loop runs without it, but may be late or lose frames.
    Degraded,
    /// The loop does not run without it.
    Missing,
}

/// One thing looked at.
#[derive(Clone, Debug, PartialEq, Eq, serde::Serialize)]
pub struct Check {
    /// What was looked at.
    pub name: &'static str,
    /// How it is.
    pub outcome: Outcome,
    /// What was found, with the measured value.
    pub found: String,
    /// A line for the shell that mends it, where it is not as it should be;
    /// what follows ` # ` is for the reader.
    pub mend: Option<String>,
}

impl Check {
    /// A thing as it should be.
    pub fn ok(name: &'static str, found: impl Into<String>) -> Self {
        Self { name, outcome: Outcome::Ok, found: found.into(), mend: None }
    }

    /// A thing that the loop can do without.
    pub fn degraded(name: &'static str, found: impl Into<String>, mend: impl Into<String>) -> Self {
        Self { name, outcome: Outcome::Degraded, found: found.into(), mend: Some(mend.into()) }
    }

    /// A thing that the loop cannot do without.
    pub fn missing(name: &'static str, found: impl Into<String>, mend: impl Into<String>) -> Self {
        Self { name, outcome: Outcome::Missing, found: found.into(), mend: Some(mend.into()) }
    }

    /// A thing of which the system does not tell: the file at `path`, without
    /// its leading slash, cannot be read or makes no sense.
    pub fn untold(name: &'static str, path: &str) -> Self {
        let mend = match path.starts_with("sys/") {
            true => "mount -t sysfs sysfs /sys",
            false => "mount -t proc proc /proc",
        };
        Self::degraded(name, format!("not known: cannot read /{path}"), mend)
    }
}

impl fmt::Display for Outcome {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        out.pad(match self {
            Self::Ok => "OK",
            Self::Degraded => "degraded",
            Self::Missing => "missing",
        })
    }
}
