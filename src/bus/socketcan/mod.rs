//! A CAN interface of the Linux kernel.
//!
//! **Stamps** are the kernel's (`SO_TIMESTAMPNS`), taken when the driver hands
//! the frame over. Where the card stamps too, its stamps are used once they
//! are brought to the system's clock; [`hardware_clock`] tells how.
//!
//! **Outages.** An interface that went down, was removed, or is bus-off is
//! looked for every 50 ms, by name, and taken again when it is as it had to be
//! at the start: also one that was made anew. One that comes back with another
//! bit rate stays down for us.

mod error_frame;
mod hardware_clock;
mod refusal;
mod socket;
mod wire;

use std::collections::VecDeque;
use std::io;

use rustix::io::Errno;
use socketcan::CanFilter;

use self::refusal::Requirements;
use self::socket::{Arrived, Socket};
use self::wire::{Outgoing, Received};
use super::{Arrival, Bus, BusError, CanLink, ControllerState, OpenOptions};
use crate::config::Problem;
use crate::frame::Frame;
use crate::run::{Clock, RealtimeStamps};
use crate::time::{Duration, Instant};
use crate::traffic::{Content, Direction, ErrorFrame};

/// How often an interface that is away is looked for.
const LOOK_EVERY: Duration = Duration::from_millis(50);
/// Filters that a socket holds (`CAN_RAW_FILTER_MAX`).
const FILTERS_MAX: usize = 512;

/// A CAN interface of the Linux kernel. After opening, sending and receiving
/// neither allocate nor lock, save when an interface that was away is opened
/// again.
pub struct SocketCan {
    name: String,
    clock: Clock,
    stamps: RealtimeStamps,
    requirements: Requirements,
    listens: bool,
    filters: Vec<CanFilter>,
    socket: Socket,
    carries_fd: bool,
    state: ControllerState,
    outage: Option<Outage>,
    /// What was found along with something else, and is to be told next.
    waiting: VecDeque<(Instant, Arrival)>,
    /// The moment last told; those of arrivals never go back.
    last_told: Instant,
    counts: SocketCanCounts,
}

/// What passed through a [`SocketCan`] since it was opened.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct SocketCanCounts {
    /// Frames that the interface's queue took.
    pub sent: u64,
    /// Frames received.
    pub received: u64,
    /// Times that the queue had no room for a frame.
    pub full: u64,
    /// Frames lost on the way to us, for want of room.
    pub lost: u64,
    /// Messages of the driver about errors on the bus.
    pub errors: u64,
}

/// Why nothing can be sent at present.
#[derive(Clone, Copy, Debug)]
struct Outage {
    kind: OutageKind,
    next_look: Instant,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum OutageKind {
    /// The interface is down or gone; the socket may be bound to nothing.
    Interface,
    /// The controller is bus-off. The kernel would drop what is sent without
    /// a word.
    BusOff,
}

impl SocketCan {
    /// Opens the interface called `name`. A controller that is not
    /// error-active is told of by the first arrival. With more than 512 ids
    /// to receive, all are received.
    ///
    /// # Errors
    /// A kernel without CAN, an interface that does not exist, is no CAN
    /// interface, is down, or is not as `options` want it.
    pub fn open(name: &str, options: &OpenOptions, clock: Clock) -> Result<Self, Problem> {
        let requirements = Requirements { bit_rate_bit_s: options.bit_rate_bit_s, needs_fd: options.needs_fd };
        refusal::check_kernel()?;
        let link = refusal::find(name, requirements)?;
        let ids = if options.receive.len() > FILTERS_MAX { &[] } else { options.receive };
        let filters: Vec<_> =
            ids.iter().map(|id| CanFilter::new(wire::kernel_id(*id), wire::kernel_id_mask(*id))).collect();
        let socket =
            Socket::open(link.index, &filters, options.listens).map_err(|error| refusal::without_socket(&error))?;
        let mut bus = Self {
            name: name.to_owned(),
            clock,
            stamps: RealtimeStamps::new(clock),
            requirements,
            listens: options.listens,
            filters,
            socket,
            carries_fd: link.carries_fd,
            state: ControllerState::default(),
            outage: None,
            waiting: VecDeque::with_capacity(8),
            last_told: clock.now(),
            counts: SocketCanCounts::default(),
        };
        bus.enter_state(bus.last_told, link.state.unwrap_or_default());
        Ok(bus)
    }

    /// What passed through so far.
    pub fn counts(&self) -> SocketCanCounts {
        self.counts
    }

    /// Takes apart what the socket gave.
    fn take(&mut self, arrived: &Arrived) {
        let at = match arrived.realtime_nanos {
            Some(nanos) if self.listens => self.stamps.moment(nanos),
            Some(nanos) => self.stamps.moment(nanos).min(self.clock.now()),
            None => self.clock.now(),
        };
        self.lose(at, arrived.lost);
        match arrived.content {
            Some(Received::Frame(recorded)) => {
                self.counts.received += 1;
                let direction = if arrived.is_from_here { Direction::Sent } else { Direction::Received };
                let heard = Arrival::Heard(direction, Content::Frame(recorded));
                self.tell(at, if self.listens { heard } else { Arrival::Frame(recorded.frame) });
            }
            Some(Received::Error(class, data)) => {
                self.counts.errors += 1;
                if self.listens {
                    self.tell(at, Arrival::Heard(Direction::Received, Content::Error(ErrorFrame { class, data })));
                }
                if error_frame::lost_frame(class, &data) {
                    self.lose(at, 1);
                }
                if let Some(state) = error_frame::controller_state(class, &data) {
                    self.enter_state(at, state);
                }
            }
            None => {}
        }
    }

    fn tell(&mut self, at: Instant, arrival: Arrival) {
        self.last_told = self.last_told.max(at);
        self.waiting.push_back((self.last_told, arrival));
    }

    fn lose(&mut self, at: Instant, frames: u32) {
        if frames > 0 {
            self.counts.lost += u64::from(frames);
            self.tell(at, Arrival::Lost(frames));
        }
    }

    fn enter_state(&mut self, at: Instant, state: ControllerState) {
        if state == self.state {
            return;
        }
        self.state = state;
        self.tell(at, Arrival::State(state));
        match (state, self.outage.map(|outage| outage.kind)) {
            (ControllerState::BusOff, None) => self.begin_outage(OutageKind::BusOff),
            (ControllerState::BusOff, Some(_)) | (_, Some(OutageKind::Interface) | None) => {}
            (_, Some(OutageKind::BusOff)) => self.end_outage(),
        }
    }

    fn begin_outage(&mut self, kind: OutageKind) {
        let now = self.clock.now();
        if self.outage.is_none() {
            self.tell(now, Arrival::Down);
        }
        self.outage = Some(Outage { kind, next_look: now + LOOK_EVERY });
    }

    fn end_outage(&mut self) {
        self.outage = None;
        self.tell(self.clock.now(), Arrival::Up);
    }

    /// Looks whether the outage is over. An error here is one more reason to
    /// look again later.
    fn look_again(&mut self, outage: Outage) {
        self.outage = Some(Outage { next_look: self.clock.now() + LOOK_EVERY, ..outage });
        let Ok(link) = CanLink::read(&self.name) else { return };
        let state = link.state.unwrap_or_default();
        if self.requirements.refusal(&link).is_some() || state == ControllerState::BusOff {
            return;
        }
        if outage.kind == OutageKind::Interface {
            let Ok(socket) = Socket::open(link.index, &self.filters, self.listens) else { return };
            self.socket = socket;
            self.carries_fd = link.carries_fd;
        }
        self.enter_state(self.clock.now(), state);
        if self.outage.is_some() {
            self.end_outage();
        }
    }

    /// Notes that the interface went away, or says that the bus is of no use.
    fn fail(&mut self, error: io::Error) -> BusError {
        match Errno::from_io_error(&error) {
            Some(Errno::NETDOWN | Errno::NODEV | Errno::NXIO) => {
                self.begin_outage(OutageKind::Interface);
                BusError::Down
            }
            _ => BusError::Gone(self.name.clone(), error),
        }
    }
}

impl Bus for SocketCan {
    fn send(&mut self, frame: &Frame) -> Result<(), BusError> {
        if self.outage.is_some() {
            return Err(BusError::Down);
        }
        if wire::is_fd(frame) && !self.carries_fd {
            let error = io::Error::new(io::ErrorKind::Unsupported, "it carries classic frames only, not CAN FD");
            return Err(BusError::Gone(self.name.clone(), error));
        }
        match self.socket.send(&Outgoing::new(frame)) {
            Ok(()) => {
                self.counts.sent += 1;
                Ok(())
            }
            Err(error) => match Errno::from_io_error(&error) {
                Some(Errno::NOBUFS | Errno::AGAIN) => {
                    self.counts.full += 1;
                    Err(BusError::Full)
                }
                _ => Err(self.fail(error)),
            },
        }
    }

    fn receive(&mut self, deadline: Instant) -> Result<Option<(Instant, Arrival)>, BusError> {
        loop {
            if let Some(arrival) = self.waiting.pop_front() {
                return Ok(Some(arrival));
            }
            match self.socket.receive() {
                Ok(Some(arrived)) => {
                    self.take(&arrived);
                    continue;
                }
                Ok(None) => {}
                Err(error) => match self.fail(error) {
                    BusError::Down => continue,
                    error => return Err(error),
                },
            }
            let now = self.clock.now();
            let mut until = deadline;
            if let Some(outage) = self.outage {
                if outage.next_look <= now {
                    self.look_again(outage);
                    continue;
                }
                until = until.min(outage.next_look);
            }
            if now >= deadline {
                let lost = self.socket.lost_since();
                self.lose(now, lost);
                return Ok(self.waiting.pop_front());
            }
            if let Err(error) = self.socket.wait(until - now) {
                return Err(BusError::Gone(self.name.clone(), error));
            }
        }
    }
}
