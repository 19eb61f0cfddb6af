//! What this machine, and a bus, allow a control loop. It looks and changes
//! nothing.
//!
//! Each check is a function of texts and values, which a thin reader gets from
//! `/proc`, `/sys` and the kernel: so every outcome is tested without the
//! machine that has it.
//!
//! What only makes the loop later is [`Outcome::Degraded`]; without what is
//! [`Outcome::Missing`] it does not run on that bus at all.

mod check;
mod cpus;
mod interface;
mod kernel;
mod kernel_can;
mod machine;
mod privileges;
mod report;
mod server;
mod wakeups;

pub use check::{Check, Outcome};
pub use machine::Machine;
pub use report::Report;
pub use wakeups::{PERIOD, WakeUps};

use crate::bus::Address;
use crate::run::Clock;

/// Looks at the machine, and at the bus if one is given, and measures
/// `wake_ups` wake-ups, one every [`PERIOD`].
pub fn examine(machine: &Machine, bus: Option<&Address>, wake_ups: usize) -> Report {
    let clock = Clock::new();
    let mut checks = machine_checks(machine);
    let needs_kernel_can = matches!(bus, Some(Address::Interface(_)));
    checks.push(kernel_can::check(machine, needs_kernel_can));
    match bus {
        Some(Address::Interface(name)) => checks.extend(interface::checks(machine, name)),
        Some(Address::Server(endpoint) | Address::Listen(endpoint)) => checks.push(server::check(endpoint, clock)),
        None => {}
    }
    let wake_ups = WakeUps::measure(machine, clock, wake_ups);
    checks.extend(wake_ups.checks());
    Report::new(checks, wake_ups)
}

/// What only files tell.
fn machine_checks(machine: &Machine) -> Vec<Check> {
    [kernel::checks(machine), privileges::checks(machine), cpus::checks(machine)].concat()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn outcomes(machine: &Machine) -> Vec<(&'static str, Outcome)> {
        machine_checks(machine).iter().map(|check| (check.name, check.outcome)).collect()
    }

    fn write(root: &std::path::Path, files: &[(&str, &str)]) {
        for (path, text) in files {
            let path = root.join(path);
            std::fs::create_dir_all(path.parent().unwrap()).unwrap();
            std::fs::write(path, text).unwrap();
        }
    }

    #[test]
    fn a_machine_made_for_it_is_all_right() {
        let root = tempfile::tempdir().unwrap();
        write(
            root.path(),
            &[
                ("proc/sys/kernel/osrelease", "6.12.43-rt-amd64\n"),
                ("proc/sys/kernel/version", "#1 SMP PREEMPT_RT Debian 6.12.43-1 (2025-08-27)\n"),
                ("sys/devices/system/clocksource/clocksource0/current_clocksource", "tsc\n"),
                ("sys/devices/system/clocksource/clocksource0/available_clocksource", "tsc hpet acpi_pm \n"),
                (
                    "proc/self/limits",
                    "Max locked memory         unlimited            unlimited            bytes     \n\
                     Max realtime priority     80                   80                   \n",
                ),
                ("proc/self/status", "Name:\tcanloop\nCapEff:\t0000000000000000\n"),
                ("proc/self/timerslack_ns", "50000\n"),
                ("sys/devices/system/cpu/online", "0-1\n"),
                ("sys/devices/system/cpu/isolated", "1\n"),
                ("sys/devices/system/cpu/cpu0/cpufreq/scaling_governor", "performance\n"),
                ("sys/devices/system/cpu/cpu1/cpufreq/scaling_governor", "performance\n"),
            ],
        );
        let outcomes = outcomes(&Machine::at(root.path()));
        assert_eq!(outcomes.len(), 7);
        assert!(outcomes.iter().all(|(_, outcome)| *outcome == Outcome::Ok), "{outcomes:?}");
    }

    #[test]
    fn a_machine_that_tells_nothing_is_degraded_and_no_panic() {
        let root = tempfile::tempdir().unwrap();
        let outcomes = outcomes(&Machine::at(root.path()));
        assert!(outcomes.iter().all(|(_, outcome)| *outcome == Outcome::Degraded), "{outcomes:?}");
    }
}
