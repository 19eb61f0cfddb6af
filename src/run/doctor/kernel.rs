//! The kernel and its clock.

use std::env::consts::ARCH;

use rustix::time::{ClockId, clock_getres};

use super::{Check, Machine};

const KERNEL: &str = "kernel";
const CLOCK_SOURCE: &str = "clock source";
/// What `uname -r` and `uname -v` show. `/sys/kernel/realtime` is gone from
/// newer kernels.
const RELEASE: &str = "proc/sys/kernel/osrelease";
const VERSION: &str = "proc/sys/kernel/version";
const CURRENT_SOURCE: &str = "sys/devices/system/clocksource/clocksource0/current_clocksource";
const AVAILABLE_SOURCES: &str = "sys/devices/system/clocksource/clocksource0/available_clocksource";
/// Coarser than this, timers run by the scheduler's tick, which takes
/// milliseconds.
const COARSEST_RESOLUTION_NANOS: i64 = 1_000;

pub(super) fn checks(machine: &Machine) -> Vec<Check> {
    let resolution = clock_getres(ClockId::Monotonic);
    let resolution_nanos = resolution.tv_sec * 1_000_000_000 + resolution.tv_nsec;
    let kernel = match (release(machine), machine.text(VERSION)) {
        (Some(release), Some(version)) => {
            let distribution = machine.text("etc/os-release").unwrap_or_default();
            preemption(&release, &version, &install_real_time_kernel(&distribution, ARCH))
        }
        _ => Check::untold(KERNEL, VERSION),
    };
    let clock_source = match machine.text(CURRENT_SOURCE) {
        Some(current) => clock_source(&current, &machine.text(AVAILABLE_SOURCES).unwrap_or_default(), resolution_nanos),
        None => Check::untold(CLOCK_SOURCE, CURRENT_SOURCE),
    };
    vec![kernel, clock_source]
}

/// What `uname -r` shows.
pub(super) fn release(machine: &Machine) -> Option<String> {
    machine.text(RELEASE)
}

/// Judges by `uname -v`, such as `#1 SMP PREEMPT_RT Debian 6.12.43-1`.
fn preemption(release: &str, version: &str, mend: &str) -> Check {
    let words: Vec<_> = version.split_whitespace().collect();
    // The patches that were before PREEMPT_RT became a part of Linux.
    let patched = words.windows(2).any(|pair| pair == ["PREEMPT", "RT"]);
    if patched || words.contains(&"PREEMPT_RT") {
        return Check::ok(KERNEL, format!("{release} with PREEMPT_RT"));
    }
    let found = match words.iter().find(|word| word.starts_with("PREEMPT")) {
        Some(word) => format!("{release} with {word}, not PREEMPT_RT"),
        None => format!("{release} is not preemptible, let alone PREEMPT_RT"),
    };
    Check::degraded(KERNEL, found, mend)
}

/// `distribution` is the text of `/etc/os-release`.
fn install_real_time_kernel(distribution: &str, arch: &str) -> String {
    let id = distribution.lines().find_map(|line| line.strip_prefix("ID=")).map(|id| id.trim_matches('"'));
    match (id, arch) {
        (Some("debian"), "x86_64") => "apt-get install linux-image-rt-amd64 # then start it".into(),
        (Some("debian"), "aarch64") => "apt-get install linux-image-rt-arm64 # then start it".into(),
        (Some("ubuntu"), _) => "pro enable realtime-kernel # then start it".into(),
        (Some("rhel"), _) => "dnf install kernel-rt # then start it".into(),
        (Some("arch"), _) => "pacman -S linux-rt # then start it".into(),
        _ => "make menuconfig # General setup: Fully Preemptible Kernel, a part of Linux since 6.12".into(),
    }
}

fn clock_source(current: &str, available: &str, resolution_nanos: i64) -> Check {
    if resolution_nanos > COARSEST_RESOLUTION_NANOS {
        let found = format!("{current}, resolution {} us: timers wait for a tick", resolution_nanos / 1_000);
        let mend = "cat /proc/cmdline # start without highres=off, with CONFIG_HIGH_RES_TIMERS=y";
        return Check::degraded(CLOCK_SOURCE, found, mend);
    }
    // Devices that are read over a slow bus, each time by a system call.
    let slow = ["hpet", "acpi_pm", "pit", "jiffies", "refined-jiffies"].contains(&current);
    if !slow {
        return Check::ok(CLOCK_SOURCE, format!("{current}, resolution {resolution_nanos} ns"));
    }
    let better = available.split_whitespace().find(|name| ["tsc", "kvm-clock", "arch_sys_counter"].contains(name));
    let mend = match better {
        Some(name) => format!("echo {name} > /{CURRENT_SOURCE}"),
        None => "dmesg | grep -i clocksource # tells why none is faster; tsc=reliable on the kernel's command line \
                 keeps the processor's"
            .into(),
    };
    Check::degraded(CLOCK_SOURCE, format!("{current}: slow to read, resolution {resolution_nanos} ns"), mend)
}

#[cfg(test)]
mod tests {
    use super::super::Outcome;
    use super::*;

    #[test]
    fn a_real_time_kernel_is_known_by_its_version() {
        for version in [
            "#1 SMP PREEMPT_RT Debian 6.12.43-1 (2025-08-27)",
            "#1 SMP PREEMPT RT Fri Jun 14 12:00:00 UTC 2019",
            "#7~22.04.1-Ubuntu SMP PREEMPT_RT Wed Oct 1 10:00:00 UTC 2025",
        ] {
            assert_eq!(preemption("6.12.43", version, "").outcome, Outcome::Ok, "{version}");
        }
    }

    #[test]
    fn a_stock_kernel_is_degraded_and_said_to_be_what_it_is() {
        for (version, expected) in [
            ("#1 SMP PREEMPT_DYNAMIC Debian 6.12.43-1", "with PREEMPT_DYNAMIC"),
            ("#1 SMP PREEMPT Tue Mar 5 00:00:00 UTC 2024", "with PREEMPT,"),
            ("#1 SMP Debian 5.10.1 RT-free", "not preemptible"),
        ] {
            let check = preemption("6.1.0", version, "install it");
            assert_eq!((check.outcome, check.mend.as_deref()), (Outcome::Degraded, Some("install it")));
            assert!(check.found.contains("6.1.0") && check.found.contains(expected), "{}", check.found);
        }
    }

    #[test]
    fn the_command_for_a_real_time_kernel_is_the_distribution_s() {
        let debian = "PRETTY_NAME=\"Debian GNU/Linux 13\"\nID=debian\n";
        assert!(install_real_time_kernel(debian, "x86_64").contains("linux-image-rt-amd64"));
        assert!(install_real_time_kernel(debian, "aarch64").contains("linux-image-rt-arm64"));
        assert!(install_real_time_kernel("ID=ubuntu", "x86_64").starts_with("pro enable"));
        assert!(install_real_time_kernel("ID=\"rhel\"", "x86_64").contains("kernel-rt"));
        assert!(install_real_time_kernel("", "riscv64").contains("Preemptible"));
    }

    #[test]
    fn a_slow_clock_is_degraded_with_the_command_that_changes_it() {
        assert_eq!(clock_source("tsc", "tsc hpet", 1).outcome, Outcome::Ok);
        assert_eq!(clock_source("kvm-clock", "", 1).outcome, Outcome::Ok);
        let check = clock_source("hpet", "hpet acpi_pm tsc", 1);
        assert_eq!(check.outcome, Outcome::Degraded);
        assert!(check.mend.unwrap().starts_with("echo tsc > /sys/"));
        assert!(clock_source("acpi_pm", "acpi_pm", 1).mend.unwrap().contains("tsc=reliable"));
    }

    #[test]
    fn timers_that_wait_for_a_tick_are_degraded() {
        let check = clock_source("tsc", "tsc", 4_000_000);
        assert_eq!(check.outcome, Outcome::Degraded);
        assert!(check.found.contains("4000 us"), "{}", check.found);
    }
}
