//! What the system lets this program do: run before others, keep its memory,
//! be woken on time.

use super::{Check, Machine};
use crate::run::priority::FIFO_PRIORITY;

const FIFO: &str = "SCHED_FIFO";
const LOCKED_MEMORY: &str = "locked memory";
const TIMER_SLACK: &str = "timer slack";
const LIMITS: &str = "proc/self/limits";
const STATUS: &str = "proc/self/status";
const TIMER_SLACK_FILE: &str = "proc/self/timerslack_ns";

/// The priority that the loop asks for.
const PRIORITY: u64 = FIFO_PRIORITY as u64;
/// Room for the program, the stacks of its threads and what the allocator
/// holds in reserve, all of which counts as locked.
const LOCKED_MEMORY_BYTES: u64 = 256 << 20;
/// Slack that no loop notices.
const SLACK_NANOS: u64 = 1_000;
// `linux/capability.h`
const CAP_IPC_LOCK: u32 = 14;
const CAP_SYS_NICE: u32 = 23;

pub(super) fn checks(machine: &Machine) -> Vec<Check> {
    let limits = machine.text(LIMITS);
    let capabilities = machine.text(STATUS).and_then(|status| Capabilities::read(&status)).unwrap_or_default();
    let limit = |name| limits.as_deref().and_then(|limits| Limit::read(limits, name));
    let fifo = match limit("Max realtime priority") {
        Some(limit) => fifo(limit, capabilities),
        None => Check::untold(FIFO, LIMITS),
    };
    let memory = match limit("Max locked memory") {
        Some(limit) => locked_memory(limit, capabilities),
        None => Check::untold(LOCKED_MEMORY, LIMITS),
    };
    let may_use_fifo = fifo.mend.is_none();
    let slack = match machine.text(TIMER_SLACK_FILE).and_then(|text| text.parse().ok()) {
        Some(slack_nanos) => timer_slack(slack_nanos, may_use_fifo),
        None => Check::untold(TIMER_SLACK, TIMER_SLACK_FILE),
    };
    vec![fifo, memory, slack]
}

/// A limit of this process (getrlimit(2)). A program may raise the one in
/// force up to the highest.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Limit {
    in_force: u64,
    highest: u64,
}

impl Limit {
    /// From `/proc/self/limits`; `None` when `name` has no sound line there.
    fn read(limits: &str, name: &str) -> Option<Self> {
        let line = limits.lines().find_map(|line| line.strip_prefix(name))?;
        let mut values = line.split_whitespace().map(|text| match text {
            "unlimited" => Some(u64::MAX),
            number => number.parse().ok(),
        });
        Some(Self { in_force: values.next()??, highest: values.next()?? })
    }
}

/// Effective capabilities (capabilities(7)), a bit each.
#[derive(Clone, Copy, Debug, Default)]
struct Capabilities(u64);

impl Capabilities {
    /// From `/proc/self/status`.
    fn read(status: &str) -> Option<Self> {
        let text = status.lines().find_map(|line| line.strip_prefix("CapEff:"))?;
        u64::from_str_radix(text.trim(), 16).ok().map(Self)
    }

    fn has(self, capability: u32) -> bool {
        self.0 >> capability & 1 == 1
    }
}

fn fifo(limit: Limit, capabilities: Capabilities) -> Check {
    if capabilities.has(CAP_SYS_NICE) {
        return Check::ok(FIFO, "allowed by CAP_SYS_NICE");
    }
    if limit.in_force >= PRIORITY {
        return Check::ok(FIFO, format!("allowed up to priority {}", limit.in_force));
    }
    let found = match limit.in_force {
        0 => "not allowed: the loop waits for ordinary programs".to_owned(),
        priority => format!("allowed up to priority {priority}, the loop asks for {PRIORITY}"),
    };
    let mend = match limit.highest >= PRIORITY {
        true => format!("ulimit -r {PRIORITY}"),
        false => format!("prlimit --pid $$ --rtprio={PRIORITY} # this shell; {}", for_good("rtprio", PRIORITY)),
    };
    Check::degraded(FIFO, found, mend)
}

fn locked_memory(limit: Limit, capabilities: Capabilities) -> Check {
    if capabilities.has(CAP_IPC_LOCK) {
        return Check::ok(LOCKED_MEMORY, "allowed by CAP_IPC_LOCK");
    }
    if limit.in_force == u64::MAX {
        return Check::ok(LOCKED_MEMORY, "unlimited");
    }
    let found = match limit.in_force {
        bytes @ 0..0x10_0000 => format!("{} KiB", bytes >> 10),
        bytes => format!("{} MiB", bytes >> 20),
    };
    if limit.in_force >= LOCKED_MEMORY_BYTES {
        return Check::ok(LOCKED_MEMORY, found);
    }
    let mend = match limit.highest {
        u64::MAX => "ulimit -l unlimited".to_owned(),
        _ => format!("prlimit --pid $$ --memlock=unlimited # this shell; {}", for_good("memlock", "unlimited")),
    };
    let found = format!("{found}, less than {} MiB: the loop may wait for swapped memory", LOCKED_MEMORY_BYTES >> 20);
    Check::degraded(LOCKED_MEMORY, found, mend)
}

fn for_good(item: &str, value: impl std::fmt::Display) -> String {
    format!("for good, the line `* - {item} {value}` in /etc/security/limits.d/canloop.conf")
}

/// How much later than asked the kernel may wake an ordinary thread, to save
/// power (prctl(2), `PR_SET_TIMERSLACK`). Those of SCHED_FIFO have none.
fn timer_slack(slack_nanos: u64, may_use_fifo: bool) -> Check {
    let slack = match slack_nanos {
        0..1_000 => format!("{slack_nanos} ns"),
        _ => format!("{} us", slack_nanos / 1_000),
    };
    if slack_nanos <= SLACK_NANOS {
        return Check::ok(TIMER_SLACK, slack);
    }
    if may_use_fifo {
        return Check::ok(TIMER_SLACK, format!("{slack}, but none under SCHED_FIFO"));
    }
    let mend = "echo 1 > /proc/$$/timerslack_ns # this shell and what it starts";
    Check::degraded(TIMER_SLACK, format!("{slack}: so much later may each wake-up be"), mend)
}

#[cfg(test)]
mod tests {
    use super::super::Outcome;
    use super::*;

    const NONE: Capabilities = Capabilities(0);

    fn limit(in_force: u64, highest: u64) -> Limit {
        Limit { in_force, highest }
    }

    fn mend(check: Check) -> String {
        assert_eq!(check.outcome, Outcome::Degraded, "{check:?}");
        check.mend.expect("what is degraded can be mended")
    }

    #[test]
    fn limits_are_read_as_the_kernel_writes_them() {
        let limits = "Limit                     Soft Limit           Hard Limit           Units     \n\
                      Max locked memory         8388608              unlimited            bytes     \n\
                      Max realtime priority     0                    40                   \n\
                      Max realtime timeout      broken\n";
        assert_eq!(Limit::read(limits, "Max locked memory"), Some(limit(8 << 20, u64::MAX)));
        assert_eq!(Limit::read(limits, "Max realtime priority"), Some(limit(0, 40)));
        assert_eq!(Limit::read(limits, "Max realtime timeout"), None);
        assert_eq!(Limit::read("", "Max locked memory"), None);
    }

    #[test]
    fn sched_fifo_is_allowed_by_limit_or_by_capability() {
        assert_eq!(fifo(limit(40, 40), NONE).outcome, Outcome::Ok);
        let nice = Capabilities::read("Name:\tcanloop\nCapEff:\t0000000000800000\n").unwrap();
        assert_eq!(fifo(limit(0, 0), nice).outcome, Outcome::Ok);
        let lock = Capabilities::read("CapEff:\t0000000000004000").unwrap();
        assert_eq!(fifo(limit(0, 0), lock).outcome, Outcome::Degraded);
    }

    #[test]
    fn a_limit_that_one_may_raise_oneself_needs_no_root() {
        assert_eq!(mend(fifo(limit(0, 99), NONE)), "ulimit -r 40");
        assert_eq!(mend(locked_memory(limit(8 << 20, u64::MAX), NONE)), "ulimit -l unlimited");
    }

    #[test]
    fn other_limits_are_raised_for_this_shell_or_for_good() {
        let command = mend(fifo(limit(20, 39), NONE));
        assert!(command.starts_with("prlimit --pid $$ --rtprio=40") && command.contains("limits.d"), "{command}");
        let command = mend(locked_memory(limit(8 << 20, 8 << 20), NONE));
        assert!(command.starts_with("prlimit --pid $$ --memlock=unlimited"), "{command}");
    }

    #[test]
    fn memory_for_the_whole_program_can_be_locked_or_not() {
        assert_eq!(locked_memory(limit(u64::MAX, u64::MAX), NONE).outcome, Outcome::Ok);
        assert_eq!(locked_memory(limit(256 << 20, 256 << 20), NONE).outcome, Outcome::Ok);
        assert_eq!(locked_memory(limit(0, 0), Capabilities(1 << CAP_IPC_LOCK)).outcome, Outcome::Ok);
        assert!(locked_memory(limit(64 << 10, 64 << 10), NONE).found.starts_with("64 KiB"));
    }

    #[test]
    fn timer_slack_matters_to_ordinary_threads_only() {
        assert_eq!(timer_slack(50_000, true).outcome, Outcome::Ok);
        assert_eq!(timer_slack(1, false).outcome, Outcome::Ok);
        let check = timer_slack(50_000, false);
        assert!(check.found.starts_with("50 us"), "{}", check.found);
        assert!(mend(check).contains("timerslack_ns"));
    }
}
