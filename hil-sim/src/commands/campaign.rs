//! `hil-sim campaign`: whatever goes wrong, some things must hold.

use std::collections::BTreeMap;
use std::process::ExitCode;

use super::progress::Progress;
use super::{FAILED, Failure, HELD, INTERRUPTED, interrupt, say};
use crate::campaign::{self, Plan, Tried, Verdict};

/// What `hil-sim campaign` is given.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
Examples:
  hil-sim campaign                    the campaign that ships, `faults`
  hil-sim campaign my-campaign.toml   one of your own
  hil-sim campaign --print > my-campaign.toml

Each fault is tried at each moment, in each size that is listed, with each
scenario and seed. A run is survived, tripped safely, or violates what must hold;
violations come with the command that runs them again.
Exit status: 0 nothing was violated, 1 something was, 2 bad input, 130 ended by
Ctrl-C.")]
pub struct Args {
    /// Name of a shipped campaign, or path of a campaign file ending in .toml
    #[arg(value_name = "CAMPAIGN", default_value = "faults")]
    campaign: String,
    /// Threads; without it, as many as there are processors
    #[arg(long, value_name = "N")]
    threads: Option<usize>,
    /// Print the campaign that ships and end
    #[arg(long)]
    print: bool,
}

/// Violations that are told one by one.
const MOST_TOLD: usize = 20;

/// Runs the command.
pub fn run(args: &Args) -> Result<ExitCode, Failure> {
    if args.print {
        let [(_, text), ..] = campaign::SHIPPED else { return Ok(ExitCode::from(HELD)) };
        say(text.trim_end());
        return Ok(ExitCode::from(HELD));
    }
    let plan = Plan::load(&args.campaign)?;
    let threads = args.threads.unwrap_or_else(|| std::thread::available_parallelism().map_or(1, usize::from));
    interrupt::listen();
    let mut progress = Progress::new(plan.name.clone(), plan.cases.len() as u64);
    let tried = campaign::run(&plan, threads, |done| {
        progress.at(done as u64);
        interrupt::check().is_continue()
    })?;
    progress.done();
    let violated = print(&plan, &tried);
    say(format_args!("{} runs in {:.1} s", tried.len(), progress.elapsed_s()));
    Ok(ExitCode::from(match violated {
        _ if interrupt::check().is_break() => INTERRUPTED,
        0 => HELD,
        _ => FAILED,
    }))
}

/// Prints a table of kinds and the violations; says how many there are.
fn print(plan: &Plan, tried: &[Tried]) -> usize {
    let mut kinds: BTreeMap<&str, [usize; 3]> = BTreeMap::new();
    for one in tried {
        let column = match one.verdict {
            Verdict::Survived => 0,
            Verdict::TrippedSafely => 1,
            Verdict::Violated(_) => 2,
        };
        kinds.entry(&one.kind).or_default()[column] += 1;
    }
    say(format_args!("{:<20} {:>9} {:>15} {:>9}", plan.name, "survived", "tripped safely", "violated"));
    let row = |name: &str, [survived, tripped, violated]: [usize; 3]| {
        say(format_args!("{name:<20} {survived:>9} {tripped:>15} {violated:>9}"));
    };
    kinds.iter().for_each(|(kind, counts)| row(kind, *counts));
    let total = kinds.values().fold([0; 3], |sum, counts| std::array::from_fn(|nth| sum[nth] + counts[nth]));
    row("in all", total);
    let violations = tried.iter().filter_map(|one| match &one.verdict {
        Verdict::Violated(what) => Some((what, &one.reproduce)),
        _ => None,
    });
    for (what, reproduce) in violations.take(MOST_TOLD) {
        say(format_args!("violated: {what}\n  {reproduce}"));
    }
    if total[2] > MOST_TOLD {
        say(format_args!("... and {} more", total[2] - MOST_TOLD));
    }
    total[2]
}
