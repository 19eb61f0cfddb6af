//! All that was looked at, for people and for programs.

use std::fmt;

use super::{Check, Outcome, WakeUps};

/// All that was looked at.
#[derive(Clone, Debug, serde::Serialize)]
pub struct Report {
    /// The worst of all outcomes.
    pub outcome: Outcome,
    /// In the order in which they are shown.
    pub checks: Vec<Check>,
    /// The figures behind the checks of wake-ups.
    pub wake_ups: WakeUps,
}

impl Report {
    /// A report on these.
    pub fn new(checks: Vec<Check>, wake_ups: WakeUps) -> Self {
        let outcome = checks.iter().map(|check| check.outcome).max().unwrap_or(Outcome::Ok);
        Self { outcome, checks, wake_ups }
    }
}

/// Aligned lines, one a check, each followed by the command that mends it.
impl fmt::Display for Report {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        let width = self.checks.iter().map(|check| check.name.len()).max().unwrap_or(0);
        for check in &self.checks {
            writeln!(out, "{:width$}  {:8}  {}", check.name, check.outcome, check.found)?;
            if let Some(mend) = &check.mend {
                writeln!(out, "{:width$}  {:8}  $ {mend}", "", "")?;
            }
        }
        let count = |outcome| self.checks.iter().filter(|check| check.outcome == outcome).count();
        let (ok, degraded, missing) = (count(Outcome::Ok), count(Outcome::Degraded), count(Outcome::Missing));
        write!(out, "\n{ok} OK, {degraded} degraded, {missing} missing")?;
        if degraded + missing > 0 {
            write!(out, "; the commands after $ mend it, most of them as root")?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn report(checks: Vec<Check>) -> Report {
        let wake_ups = WakeUps {
            count: 100,
            scheduling: "SCHED_OTHER".into(),
            p50_us: 1.0,
            p99_us: 2.0,
            max_us: 3.0,
            fine_from_period_ms: 1.0,
        };
        Report::new(checks, wake_ups)
    }

    #[test]
    fn lines_are_aligned_and_each_command_stands_below_its_check() {
        let report = report(vec![
            Check::ok("kernel", "6.12"),
            Check::degraded("txqueuelen", "10 frames", "make it longer"),
            Check::missing("can0", "it is down", "bring it up"),
        ]);
        let expected = "\
kernel      OK        6.12
txqueuelen  degraded  10 frames
                      $ make it longer
can0        missing   it is down
                      $ bring it up

1 OK, 1 degraded, 1 missing; the commands after $ mend it, most of them as root";
        assert_eq!(report.to_string(), expected);
    }

    #[test]
    fn the_worst_outcome_is_that_of_the_whole() {
        let (ok, degraded) = (Check::ok("a", ""), Check::degraded("b", "", ""));
        let missing = Check::missing("c", "", "");
        assert_eq!(report(vec![ok.clone()]).outcome, Outcome::Ok);
        assert_eq!(report(vec![degraded.clone(), ok]).outcome, Outcome::Degraded);
        assert_eq!(report(vec![missing, degraded]).outcome, Outcome::Missing);
    }
}
