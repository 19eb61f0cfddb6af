//! Many runs in which something goes wrong, and what must hold in all of them.

mod judge;
mod log_check;
mod plan;

use std::ops::ControlFlow;
use std::panic::{AssertUnwindSafe, catch_unwind};

use canloop::config::Problems;

use crate::bench;
use crate::parallel;
use crate::reproduce;
use crate::scenario::Scenario;

use log_check::Logged;

pub use judge::{Invariants, Judge, Verdict};
pub use plan::{Case, Plan, SHIPPED};

/// A run and what came of it.
#[derive(Clone, Debug)]
pub struct Tried {
    /// The kind of fault.
    pub kind: String,
    /// How it ended.
    pub verdict: Verdict,
    /// The command that runs it again.
    pub reproduce: String,
}

/// Runs all cases of a plan on so many threads; the results are in the plan's
/// order, whichever was done first. `progress` is told how many are done, and
/// says whether to go on: what was not run then is left out.
///
/// # Errors
/// A case whose scenario will not do; the rest is left alone.
pub fn run(plan: &Plan, threads: usize, mut progress: impl FnMut(usize) -> bool) -> Result<Vec<Tried>, Problems> {
    let (mut tried, mut failed) = (Vec::new(), None);
    let work = |nth: u64| {
        let nth = nth as usize;
        let checks_log = nth.is_multiple_of(plan.invariants.log_of_every);
        try_one(&plan.cases[nth], &plan.invariants, checks_log.then_some(nth))
    };
    parallel::in_order(plan.cases.len() as u64, threads, work, |_, one| {
        match one {
            Ok(one) => tried.push(one),
            Err(problems) => failed = Some(problems),
        }
        if failed.is_none() && progress(tried.len()) { ControlFlow::Continue(()) } else { ControlFlow::Break(()) }
    });
    failed.map_or(Ok(tried), Err)
}

/// One run. A panic is a violation as well. With a number for its name the log is
/// written and read again, too.
fn try_one(case: &Case, invariants: &Invariants, log: Option<usize>) -> Result<Tried, Problems> {
    let scenario = Scenario::load(&case.scenario, &case.overrides)?;
    let judged = catch_unwind(AssertUnwindSafe(|| {
        let judge = Judge::new(*invariants, &scenario);
        match log {
            Some(nth) => run_logged(&scenario, judge, nth),
            None => run_unlogged(&scenario, judge),
        }
    }));
    let verdict = judged.unwrap_or_else(|_| Verdict::Violated("it panicked".to_owned()));
    Ok(Tried { kind: case.kind.clone(), verdict, reproduce: reproduce::command(&scenario) })
}

fn run_unlogged(scenario: &Scenario, mut judge: Judge) -> Verdict {
    let outcome = bench::run(scenario, &mut judge, |_| ControlFlow::Continue(()));
    judge.verdict(&outcome)
}

fn run_logged(scenario: &Scenario, judge: Judge, nth: usize) -> Verdict {
    let path = std::env::temp_dir().join(format!("hil-sim-campaign-{}-{nth}.mcap", std::process::id()));
    let mut logged = match Logged::new(scenario, &path, judge) {
        Ok(logged) => logged,
        Err(what) => return Verdict::Violated(what),
    };
    let outcome = bench::run(scenario, &mut logged, |_| ControlFlow::Continue(()));
    let (mut judge, wrong) = logged.finish(&outcome, &path);
    // What is left of it is the system's to clear away.
    let _ = std::fs::remove_file(&path);
    wrong.into_iter().for_each(|what| judge.violate(what));
    judge.verdict(&outcome)
}
