//! Whether a bus can carry what a robot's stack and drives say to each other,
//! in time: each message's longest time on the wire, the load, how late each
//! message can be, and how long a period's whole exchange can take.
//!
//! # Each message
//!
//! Its worst-case response is that of [`response`], from the moment at which it
//! is due to the end of its frame. All messages may come at once, behind the
//! longest frame of lower priority. Of two frames with the same id the data
//! frame goes before the remote request.
//!
//! The stack's frames wait in one queue. SocketCAN's is first in, first out:
//! whoever waits there behind a frame of lower priority waits with its
//! priority, as in Davis, Kollmann, Pollex and Slomka, "Controller Area Network
//! (CAN) schedulability analysis with FIFO queues", ECRTS 2011. The order in
//! which the stack queues its frames is known, so only those that really are
//! before a frame count so; those of higher priority count in any case, for
//! queues that sort. Drives are taken to send their most urgent frame first, as
//! their controllers' mailboxes do.
//!
//! # The exchange
//!
//! In every period the stack begins, the drives answer, and where torques act
//! at SYNC the stack answers them. All of that must be over when the next
//! period begins, or the loop does not hold its period. Of two bounds the lower
//! one is taken:
//!
//! - While a frame of the exchange waits, the bus is busy, whoever's turn it
//!   is. So the exchange takes no longer than all its frames together, once
//!   each, and all that drives send by their own clocks meanwhile or had still
//!   to send.
//! - Each step takes no longer than the slowest of its messages' responses.
//!
//! For both, drives may send first what came first: each of their messages then
//! waits with the lowest priority of all that its drive sends.
//!
//! To this the stack's lateness comes, once for each time it speaks, and the
//! time that drives take to answer. When the exchange fits into the period, no
//! frame of one period meets one of the next, so the exchange's messages do not
//! push each other any further than they do here. What drives send by their own
//! clocks sees the exchange's messages anywhere between the beginning and the
//! end of the exchange: that is their jitter there.
//!
//! Not counted are errors on the bus, others' messages, and what is said once:
//! a fault, a word that enables a drive.

mod advice;
mod exchange;
pub mod response;
mod table;

use crate::bus::worst_case_frame_bits;
use crate::frame::{CanId, FrameKind};
use crate::schema::{Cause, Profile, Recurring};
use crate::time::Duration;

pub use advice::{STANDARD_BIT_RATES_BIT_S, lowest_bit_rate, shortest_period};
pub use table::Report;

/// What a budget is made for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Terms {
    /// The stack's period T.
    pub period: Duration,
    /// Nominal bit rate of the bus.
    pub bit_rate_bit_s: u32,
    /// How late the stack's frames leave at most, each time that it speaks.
    pub lateness: Duration,
    /// How late drives' frames leave at most: after what they answer, or after
    /// their own clock says so.
    pub answer: Duration,
}

/// What the bus has to carry, and how late it can be.
#[derive(Clone, Debug, PartialEq)]
pub struct Budget {
    /// What it was made for.
    pub terms: Terms,
    /// Every message that is sent again and again, the most urgent first.
    pub rows: Vec<Row>,
    /// The share of the bus's time that is taken when all frames are as long
    /// as they can be: 1 is all of it.
    pub load: f64,
    /// How long a period's exchange can take, from the moment at which the
    /// period should begin. Nothing when the bus can keep it waiting for ever.
    pub exchange: Option<Duration>,
}

/// One message.
#[derive(Clone, Debug, PartialEq)]
pub struct Row {
    /// Arbitration id.
    pub id: CanId,
    /// Data frame or remote request.
    pub kind: FrameKind,
    /// What makes its sender send it.
    pub cause: Cause,
    /// The DBC's name.
    pub name: String,
    /// Who sends it, as the DBC has it.
    pub sender: String,
    /// Bytes of payload.
    pub bytes: usize,
    /// How often it is sent. It must be through before the next is due.
    pub period: Duration,
    /// For how long it occupies the bus at most.
    pub transmission: Duration,
    /// How long it can take from when it is due to the end of its frame.
    /// Nothing when the bus can keep it waiting for ever.
    pub response: Option<Duration>,
}

impl Budget {
    /// The budget of drives of this profile.
    pub fn of(profile: &Profile, terms: &Terms) -> Self {
        let mut rows: Vec<Row> =
            profile.traffic(terms.period).iter().map(|message| Row::of(profile, message, terms)).collect();
        let load = rows.iter().map(|row| row.transmission.as_secs_f64() / row.period.as_secs_f64()).sum();
        let (exchange, responses) = exchange::bounds(&rows, terms);
        rows.iter_mut().zip(responses).for_each(|(row, response)| row.response = response);
        rows.sort_by_key(Row::order);
        Self { terms: *terms, rows, load, exchange }
    }

    /// Whether everything is in time.
    pub fn holds(&self) -> bool {
        self.exchange_holds() && self.rows.iter().all(Row::holds)
    }

    /// Whether a period's exchange fits into the period.
    pub fn exchange_holds(&self) -> bool {
        self.exchange.is_some_and(|exchange| exchange <= self.terms.period)
    }
}

impl Row {
    fn of(profile: &Profile, message: &Recurring, terms: &Terms) -> Self {
        let Recurring { id, kind, cycle, cause } = *message;
        let layout = profile.dbc.message_by_id(id).expect("a profile's messages are in its DBC");
        let (bytes, sender) = match kind {
            FrameKind::Remote => (0, stack_name(profile)),
            _ => (layout.len, layout.sender.clone()),
        };
        // As `Frame::zeroed` has it: what no classic frame can hold.
        let kind = if bytes > 8 { FrameKind::Fd } else { kind };
        let transmission = bits(worst_case_frame_bits(id, bytes, kind), terms.bit_rate_bit_s);
        let name = layout.name.clone();
        Self { id, kind, cause, name, sender, bytes, period: cycle, transmission, response: None }
    }

    /// Whether it is always through before the next one is due.
    pub fn holds(&self) -> bool {
        self.response.is_some_and(|response| response <= self.period)
    }

    /// Whether it belongs to the exchange of a period.
    pub fn is_of_exchange(&self) -> bool {
        self.cause != Cause::OwnClock
    }

    /// Whether the stack sends it.
    pub fn is_stack_s(&self) -> bool {
        matches!(self.cause, Cause::Beginning | Cause::Answered)
    }

    /// Lower goes first: a data frame's RTR bit is dominant, a request's is
    /// not (ISO 11898-1, 10.4.2).
    pub fn order(&self) -> u64 {
        u64::from(self.id.arbitration_order()) << 1 | u64::from(self.kind == FrameKind::Remote)
    }
}

/// The time that so many bits take, rounded up to a nanosecond.
fn bits(count: u32, bit_rate_bit_s: u32) -> Duration {
    let nanos = (u64::from(count) * 1_000_000_000).div_ceil(u64::from(bit_rate_bit_s));
    Duration::from_nanos(nanos as i64)
}

/// What the DBC calls the node that sends commands.
fn stack_name(profile: &Profile) -> String {
    let begins = profile.traffic(Duration::from_millis(1)).into_iter();
    let own = begins.filter(|message| message.kind != FrameKind::Remote && message.cause != Cause::OwnClock);
    let of_stack = own.filter(|message| message.cause != Cause::Asked);
    let layouts = of_stack.filter_map(|message| profile.dbc.message_by_id(message.id));
    layouts.map(|layout| layout.sender.clone()).next().unwrap_or_default()
}
