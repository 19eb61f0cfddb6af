//! Whether the bus can carry what the run will put on it.

use crate::budget::{Budget, Report, Terms};
#[cfg(target_os = "linux")]
use crate::bus::{Address, CanLink};
use crate::config::Problem;
use crate::stack::RobotFile;
use crate::time::Duration;

/// Refuses a robot whose traffic its bus cannot carry in time. A bus whose bit
/// rate neither the configuration nor the kernel knows is not judged.
pub fn refuse(robot: &RobotFile, bus: &str) -> Result<(), Problem> {
    let Some(bit_rate_bit_s) = robot.bit_rate_bit_s.or_else(|| bit_rate_of(bus)) else { return Ok(()) };
    let stack = &robot.stack;
    let terms = Terms { period: stack.period, bit_rate_bit_s, lateness: Duration::ZERO, answer: Duration::ZERO };
    let budget = Budget::of(&stack.profile, &terms);
    if budget.holds() {
        return Ok(());
    }
    let report = Report::of(&stack.profile, budget);
    let title = format!("a bus of {bit_rate_bit_s} bit/s cannot carry this in time: {}", report.failures[0]);
    let help = format!("{}; canloop budget shows all of it, --over-budget drives all the same", report.remedy());
    Err(Problem::bare(title).help(help))
}

/// What the kernel says of an interface.
#[cfg(target_os = "linux")]
fn bit_rate_of(bus: &str) -> Option<u32> {
    match Address::parse(bus).ok()? {
        Address::Interface(name) => CanLink::read(&name).ok()?.bit_rate_bit_s,
        Address::Server(_) | Address::Listen(_) => None,
    }
}

#[cfg(not(target_os = "linux"))]
fn bit_rate_of(_: &str) -> Option<u32> {
    None
}
