//! Whether a bus can carry its messages: each at its cycle, as long as it can
//! be.

use crate::budget::{Budget, Report, Terms};
use crate::bus::worst_case_frame_bits;
use crate::config::{Document, Problem};
use crate::frame::{CanId, FrameKind};
use crate::schema::{Dbc, MessageLayout};
use crate::stack::StackConfig;
use crate::time::Duration;

/// What a segmenting transport protocol leaves of a frame's 8 bytes.
const SEGMENT_BYTES: usize = 7;

/// A problem when the messages of a DBC that have a cycle are more than the
/// bus carries.
pub(super) fn of_dbc(dbc: &Dbc, bitrate_bit_s: u32) -> Option<Problem> {
    let loads = dbc
        .messages
        .iter()
        .filter_map(|message| Some((message.name.as_str(), bits(message) / message.cycle?.as_secs_f64())));
    let load = Load::of(loads.collect(), bitrate_bit_s)?;
    // CAN FD may send most of a frame much faster; how fast, no DBC says.
    let is_certain = dbc.messages.iter().all(|message| !message.is_fd);
    let at = place(dbc, load.heaviest);
    let problem = Problem::at(&dbc.source, at, load.title(), load.label())
        .help("send some of the messages less often, or take a faster bus");
    Some(if is_certain { problem } else { problem.warning() })
}

/// A problem when the bus cannot carry in time what the stack and its drives
/// say to each other. More than the bus carries is an error; what can be late
/// only when all comes together is a warning.
pub(super) fn of_stack(document: &Document, stack: &StackConfig, bit_rate_bit_s: u32) -> Option<Problem> {
    let profile = &stack.profile;
    let terms = Terms { period: stack.period, bit_rate_bit_s, lateness: Duration::ZERO, answer: Duration::ZERO };
    let budget = Budget::of(profile, &terms);
    if budget.holds() {
        return None;
    }
    let report = Report::of(profile, budget);
    let load = report.budget.load;
    let percent = 100.0 * load;
    let found = format!("found that {}", report.failures[0]);
    let problem = if load > 1.0 {
        let title = format!("the bus cannot carry this: {percent:.0} % of its {bit_rate_bit_s} bit/s");
        document.problem_at("period_s", title, found)
    } else {
        document.problem_at("period_s", "the bus cannot always carry this in time", found).warning()
    };
    Some(problem.help(report.remedy()))
}

/// More than a bus carries.
struct Load<'n> {
    heaviest: &'n str,
    heaviest_bit_s: f64,
    bit_s: f64,
    bitrate_bit_s: u32,
}

impl<'n> Load<'n> {
    fn of(loads: Vec<(&'n str, f64)>, bitrate_bit_s: u32) -> Option<Self> {
        let (heaviest, heaviest_bit_s) = *loads.iter().max_by(|(_, a), (_, b)| a.total_cmp(b))?;
        let bit_s = loads.iter().map(|(_, bit_s)| bit_s).sum();
        (bit_s > f64::from(bitrate_bit_s)).then_some(Self { heaviest, heaviest_bit_s, bit_s, bitrate_bit_s })
    }

    fn title(&self) -> String {
        let percent = 100.0 * self.bit_s / f64::from(self.bitrate_bit_s);
        format!("the bus cannot carry this: {percent:.0} % of its {} bit/s", self.bitrate_bit_s)
    }

    fn label(&self) -> String {
        let Self { heaviest, heaviest_bit_s, bit_s, .. } = self;
        format!(
            "found {bit_s:.0} bit/s in all when frames are as long as they can be, {heaviest_bit_s:.0} of {heaviest}"
        )
    }
}

/// At most so many bits on the wire, over several frames where one is too
/// short.
fn bits(message: &MessageLayout) -> f64 {
    let worst = |id: CanId, len, kind| f64::from(worst_case_frame_bits(id, len, kind));
    match message.len {
        len @ 0..=64 if message.is_fd => worst(message.id, len, FrameKind::Fd),
        len @ 0..=8 => worst(message.id, len, FrameKind::Classic),
        len => (1 + len.div_ceil(SEGMENT_BYTES)) as f64 * worst(message.id, 8, FrameKind::Classic),
    }
}

/// Where the message's name is in the DBC.
fn place(dbc: &Dbc, name: &str) -> std::ops::Range<usize> {
    let text = &dbc.source.text;
    let short = dbc.message(name).map_or(name, |message| message.short_name.as_str());
    let begins = |line: &str| line.split_whitespace().nth(2).is_some_and(|word| word.trim_end_matches(':') == short);
    let mut start = 0;
    for line in text.split_inclusive('\n') {
        if line.starts_with("BO_") && begins(line) {
            return start..start + line.trim_end().len();
        }
        start += line.len();
    }
    0..0
}
