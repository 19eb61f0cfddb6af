//! The processors: how fast they run, and which are kept free.

use std::collections::BTreeMap;

use super::{Check, Machine};

const GOVERNOR: &str = "CPU governor";
const ISOLATED: &str = "isolated CPUs";
const ONLINE_FILE: &str = "sys/devices/system/cpu/online";
const ISOLATED_FILE: &str = "sys/devices/system/cpu/isolated";
/// More than Linux can be built for (`CONFIG_NR_CPUS`).
const CPUS_MAX: usize = 8192;

pub(super) fn checks(machine: &Machine) -> Vec<Check> {
    let governor = match machine.text(ONLINE_FILE) {
        Some(online) => {
            let file = |cpu| format!("sys/devices/system/cpu/cpu{cpu}/cpufreq/scaling_governor");
            let governors: Vec<_> =
                cpu_list(&online).into_iter().filter_map(|cpu| Some((cpu, machine.text(&file(cpu))?))).collect();
            governor(&governors)
        }
        None => Check::untold(GOVERNOR, ONLINE_FILE),
    };
    let isolated = match machine.text(ISOLATED_FILE) {
        Some(cpus) if cpus.is_empty() => Check::ok(ISOLATED, "none"),
        Some(cpus) => Check::ok(ISOLATED, cpus),
        None => Check::untold(ISOLATED, ISOLATED_FILE),
    };
    vec![governor, isolated]
}

/// Judges the governors of the CPUs that have one: what lowers the clock wakes
/// up slowly.
fn governor(governors: &[(usize, String)]) -> Check {
    let mut cpus_of: BTreeMap<&str, Vec<usize>> = BTreeMap::new();
    for (cpu, governor) in governors {
        cpus_of.entry(governor).or_default().push(*cpu);
    }
    let found: Vec<_> = cpus_of.iter().map(|(governor, cpus)| format!("{governor} on {}", ranges(cpus))).collect();
    let found = found.join(", ");
    match cpus_of.keys().all(|governor| *governor == "performance") {
        _ if governors.is_empty() => Check::ok(GOVERNOR, "none here: the frequency is fixed, or the host's affair"),
        true => Check::ok(GOVERNOR, found),
        false => {
            let mend = "echo performance | tee /sys/devices/system/cpu/cpu*/cpufreq/scaling_governor";
            Check::degraded(GOVERNOR, found, mend)
        }
    }
}

/// Reads a list as the kernel writes it, such as `0-3,6`; leaves out what
/// makes no sense.
fn cpu_list(text: &str) -> Vec<usize> {
    let range = |part: &str| {
        let (first, last) = part.split_once('-').unwrap_or((part, part));
        Some(first.trim().parse().ok()?..=last.trim().parse::<usize>().ok()?.min(CPUS_MAX))
    };
    text.split(',').filter_map(range).flatten().collect()
}

/// Writes CPUs in rising order as the kernel does.
fn ranges(cpus: &[usize]) -> String {
    let runs = cpus.chunk_by(|one, next| one + 1 == *next).filter_map(|run| Some((run.first()?, run.last()?)));
    let texts = runs.map(|(first, last)| match first == last {
        true => first.to_string(),
        false => format!("{first}-{last}"),
    });
    texts.collect::<Vec<_>>().join(",")
}

#[cfg(test)]
mod tests {
    use super::super::Outcome;
    use super::*;

    fn judge(governors: &[&str]) -> Check {
        let governors: Vec<_> = governors.iter().map(|governor| governor.to_string()).enumerate().collect();
        governor(&governors)
    }

    #[test]
    fn lists_are_read_and_written_as_the_kernel_does() {
        for text in ["0", "0-3", "0-3,6,8-9"] {
            assert_eq!(ranges(&cpu_list(text)), text);
        }
        assert!(cpu_list("").is_empty());
        assert_eq!(cpu_list("x,3-1,2"), [2]);
        assert!(cpu_list("0-18446744073709551615").len() <= CPUS_MAX + 1);
    }

    #[test]
    fn performance_everywhere_or_no_governor_is_all_right() {
        assert_eq!(judge(&["performance", "performance"]), Check::ok(GOVERNOR, "performance on 0-1"));
        assert_eq!(judge(&[]).outcome, Outcome::Ok);
    }

    #[test]
    fn one_cpu_that_saves_power_is_named() {
        let check = judge(&["performance", "powersave", "performance"]);
        assert_eq!(check.outcome, Outcome::Degraded);
        assert_eq!(check.found, "performance on 0,2, powersave on 1");
        assert!(check.mend.unwrap().starts_with("echo performance | tee"));
    }
}
