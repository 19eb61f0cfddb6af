//! How late this machine wakes a loop up.

use rustix::io::Errno;
use rustix::thread::{ClockId, clock_nanosleep_absolute};

use super::{Check, Machine};
use crate::run::Clock;
use crate::time::Duration;

/// The time from one wake-up to the next.
pub const PERIOD: Duration = Duration::from_millis(1);
/// A period is fine when the latest wake-up was late by no more than this part
/// of it.
const PARTS: i64 = 10;
const WAKE_UPS: &str = "wake-ups";
const PERIOD_T: &str = "period T";

/// How late wake-ups were that were asked for once every [`PERIOD`], by
/// absolute waits on the monotonic clock.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub struct WakeUps {
    /// How many there were.
    pub count: usize,
    /// The class of the thread that was woken up, with its priority if real-time.
    pub scheduling: String,
    /// Half of them were late by no more than this, in microseconds.
    pub p50_us: f64,
    /// 99 in 100 of them were.
    pub p99_us: f64,
    /// All of them were.
    pub max_us: f64,
    /// The shortest period that is fine: ten times the latest wake-up, and no
    /// shorter than the period measured with; in milliseconds.
    pub fine_from_period_ms: f64,
}

impl WakeUps {
    /// Measures `count` wake-ups of the calling thread, at least one.
    pub fn measure(machine: &Machine, clock: Clock, count: usize) -> Self {
        let scheduling = machine.text("proc/self/stat").and_then(|stat| scheduling(&stat));
        let mut late = Vec::with_capacity(count.max(1));
        let mut due = clock.now();
        for _ in 0..count.max(1) {
            due += PERIOD;
            // A signal's handler ends the wait too early.
            while clock_nanosleep_absolute(ClockId::Monotonic, &clock.to_monotonic(due)) == Err(Errno::INTR) {}
            late.push(clock.now() - due);
        }
        Self::of(late, scheduling.unwrap_or_else(|| "an unknown class".into()))
    }

    fn of(mut late: Vec<Duration>, scheduling: String) -> Self {
        late.sort_unstable();
        let max = late.last().copied().unwrap_or_default();
        let micros = |span: Duration| span.as_nanos() as f64 / 1e3;
        Self {
            count: late.len(),
            scheduling,
            p50_us: micros(percentile(&late, 50)),
            p99_us: micros(percentile(&late, 99)),
            max_us: micros(max),
            fine_from_period_ms: fine_from(max).as_nanos() as f64 / 1e6,
        }
    }

    /// For information: how late is too late depends on the robot.
    pub(super) fn checks(&self) -> [Check; 2] {
        let Self { count, scheduling, p50_us, p99_us, max_us, fine_from_period_ms } = self;
        let late = format!(
            "late by p50 {p50_us:.0} us, p99 {p99_us:.0} us, max {max_us:.0} us; {count} at 1 kHz under {scheduling}"
        );
        let fine = format!("fine from {fine_from_period_ms} ms on: {PARTS} times the latest wake-up, at least 1 ms");
        [Check::ok(WAKE_UPS, late), Check::ok(PERIOD_T, fine)]
    }
}

/// The shortest fine period, rounded up to a tenth of a millisecond.
fn fine_from(latest: Duration) -> Duration {
    let nanos = (latest * PARTS).max(PERIOD).as_nanos();
    Duration::from_nanos(nanos.saturating_add(99_999) / 100_000 * 100_000)
}

/// The nearest-rank percentile of sorted spans.
fn percentile(sorted: &[Duration], percent: usize) -> Duration {
    let rank = (sorted.len() * percent).div_ceil(100);
    sorted.get(rank.saturating_sub(1)).copied().unwrap_or_default()
}

/// From `/proc/self/stat` (proc_pid_stat(5)): fields 40 and 41.
fn scheduling(stat: &str) -> Option<String> {
    // The name of the program, in parentheses, may hold anything.
    let (_, fields) = stat.rsplit_once(')')?;
    let mut fields = fields.split_whitespace().skip(40 - 3);
    let (priority, policy) = (fields.next()?, fields.next()?);
    Some(match policy {
        "0" => "SCHED_OTHER".into(),
        "1" => format!("SCHED_FIFO {priority}"),
        "2" => format!("SCHED_RR {priority}"),
        "3" => "SCHED_BATCH".into(),
        "5" => "SCHED_IDLE".into(),
        "6" => "SCHED_DEADLINE".into(),
        other => format!("scheduling class {other}"),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(late_us: impl Iterator<Item = i64>) -> WakeUps {
        WakeUps::of(late_us.map(Duration::from_micros).collect(), "SCHED_OTHER".into())
    }

    #[test]
    fn percentiles_are_those_of_the_nearest_rank() {
        let wake_ups = of((1..=1_000).rev());
        assert_eq!((wake_ups.p50_us, wake_ups.p99_us, wake_ups.max_us), (500.0, 990.0, 1_000.0));
        let one = of([7].into_iter());
        assert_eq!((one.p50_us, one.p99_us, one.max_us), (7.0, 7.0, 7.0));
    }

    #[test]
    fn a_period_is_fine_from_ten_times_the_latest_wake_up() {
        assert_eq!(of([20, 412].into_iter()).fine_from_period_ms, 4.2);
        assert_eq!(of([500].into_iter()).fine_from_period_ms, 5.0);
        assert_eq!(of([3].into_iter()).fine_from_period_ms, 1.0);
    }

    #[test]
    fn wake_ups_are_measured_against_the_clock() {
        let clock = Clock::new();
        let start = clock.now();
        let wake_ups = WakeUps::measure(&Machine::here(), clock, 20);
        assert_eq!(wake_ups.count, 20);
        assert!(clock.now() - start >= PERIOD * 20);
        assert!(0.0 < wake_ups.p50_us && wake_ups.p50_us <= wake_ups.p99_us && wake_ups.p99_us <= wake_ups.max_us);
    }

    #[test]
    fn the_scheduling_class_is_read_past_any_name() {
        let stat = |priority, policy| {
            let before = "0 ".repeat(40 - 4);
            scheduling(&format!("7 (a) b (c) R {before}{priority} {policy} 0 0"))
        };
        assert_eq!(stat(0, 0).as_deref(), Some("SCHED_OTHER"));
        assert_eq!(stat(40, 1).as_deref(), Some("SCHED_FIFO 40"));
        assert_eq!(scheduling("7 (cut) R 1 2"), None);
        assert_eq!(scheduling(""), None);
    }
}
