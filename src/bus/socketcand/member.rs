//! One client of a hub: what it has said, and what waits for it.

use std::io::{self, ErrorKind};
use std::net::TcpStream;

use rustix::event::{PollFd, PollFlags};

use super::buffers::{Incoming, Outgoing};
use super::protocol::{Command, parse_command};
use crate::frame::Frame;
use crate::time::{Duration, Instant};

/// What may wait for a client that does not read: 64 Ki frames of 64 bytes
/// of text, more of the usual ones.
pub(super) const QUEUE_BYTES: usize = 64 * 1024 * 64;
/// What the kernel keeps for a client on top of that. Set so that it does not
/// grow by itself to many times as much.
const KERNEL_BYTES: usize = 256 * 1024;
/// How long the frames for a new client are kept back unless it speaks first.
/// python-can takes what it gets in one piece for the answer to `< rawmode >`
/// and refuses an `< ok >` with a frame behind it.
const SETTLING: Duration = Duration::from_millis(100);

/// A client.
pub(super) struct Member {
    stream: TcpStream,
    incoming: Incoming,
    outgoing: Outgoing,
    stage: Stage,
    /// Commands that made no sense.
    malformed: u64,
}

/// How far a client has come.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Stage {
    /// It has been greeted and has not named the bus.
    Greeted,
    /// It may send but gets no frames.
    Open,
    /// It has just asked for frames; they wait until then.
    Settling(Instant),
    /// It gets every frame.
    Raw,
    /// It has been told that it cannot stay.
    Refused,
    /// It has gone.
    Left,
    /// It did not read what it got.
    CutOff,
}

impl Member {
    /// Greets a client that has just connected.
    pub fn greet(stream: TcpStream) -> io::Result<Self> {
        stream.set_nonblocking(true)?;
        stream.set_nodelay(true)?;
        rustix::net::sockopt::set_socket_send_buffer_size(&stream, KERNEL_BYTES)?;
        let mut member = Self {
            stream,
            incoming: Incoming::new(),
            outgoing: Outgoing::growing(QUEUE_BYTES),
            stage: Stage::Greeted,
            malformed: 0,
        };
        member.say(b"< hi >");
        Ok(member)
    }

    /// What to wait for on its socket at `now`.
    pub fn poll_fd(&self, now: Instant) -> PollFd<'_> {
        let write = if self.outgoing.is_empty() || self.held_until(now).is_some() {
            PollFlags::empty()
        } else {
            PollFlags::OUT
        };
        PollFd::new(&self.stream, PollFlags::IN | write)
    }

    /// When frames that are kept back for it become due, if any are.
    pub fn held_until(&self, now: Instant) -> Option<Instant> {
        match self.stage {
            Stage::Settling(until) if now < until => Some(until).filter(|_| !self.outgoing.is_empty()),
            _ => None,
        }
    }

    /// Whether it gets frames.
    pub fn listens(&self) -> bool {
        matches!(self.stage, Stage::Settling(_) | Stage::Raw)
    }

    /// Whether there is nothing left to do for it.
    pub fn is_gone(&self) -> bool {
        matches!(self.stage, Stage::Refused | Stage::Left | Stage::CutOff)
    }

    /// Whether it was cut off for not reading.
    pub fn is_cut_off(&self) -> bool {
        self.stage == Stage::CutOff
    }

    /// How many of its messages made no sense.
    pub fn malformed(&self) -> u64 {
        self.malformed + self.incoming.junk()
    }

    /// Reads once what has come.
    pub fn read(&mut self) {
        match self.incoming.read_from(&mut &self.stream) {
            Ok(0) => self.stage = Stage::Left,
            Ok(_) => {}
            Err(error) if matches!(error.kind(), ErrorKind::WouldBlock | ErrorKind::Interrupted) => {}
            Err(_) => self.stage = Stage::Left,
        }
    }

    /// The next frame it sends, after the other messages before it have been
    /// answered.
    pub fn next_frame(&mut self, bus_name: &str, now: Instant) -> Option<Frame> {
        while !self.is_gone() {
            let command = parse_command(self.incoming.next_message()?);
            let Some(command) = command else {
                self.malformed += 1;
                continue;
            };
            match (self.stage, command) {
                (Stage::Greeted, Command::Open(name)) if name == bus_name.as_bytes() => self.answer(Stage::Open),
                (Stage::Greeted, Command::Open(_)) => self.refuse(b"< error could not open bus >"),
                (Stage::Greeted, _) => self.refuse(b"< error unknown command >"),
                (_, Command::Send(frame)) => {
                    self.settle(now);
                    return Some(frame);
                }
                (Stage::Open, Command::RawMode) => self.answer(Stage::Settling(now + SETTLING)),
                (_, Command::BcmMode) => self.answer(Stage::Open),
                (_, Command::Echo) => self.say(b"< echo >"),
                (_, Command::RawMode) => {}
                (_, Command::Open(_) | Command::Other) => self.say(b"< error unknown command >"),
            }
        }
        None
    }

    /// Takes a message for it; a client whose queue is full is cut off.
    pub fn push(&mut self, text: &[u8]) {
        if !self.outgoing.push(text) {
            self.stage = Stage::CutOff;
        }
    }

    /// Writes what goes without waiting.
    pub fn flush(&mut self, now: Instant) {
        if self.held_until(now).is_some() || self.is_gone() {
            return;
        }
        if self.outgoing.flush_to(&mut &self.stream).is_err() {
            self.stage = Stage::Left;
        }
    }

    /// Writes what goes without waiting, kept back or not: the hub ends.
    pub fn flush_last(&mut self) {
        // Who does not take it now never will.
        let _ = self.outgoing.flush_to(&mut &self.stream);
    }

    /// Tells it why it cannot stay.
    pub fn refuse(&mut self, why: &[u8]) {
        self.say(why);
        self.stage = Stage::Refused;
    }

    fn answer(&mut self, next: Stage) {
        self.say(b"< ok >");
        if !self.is_gone() {
            self.stage = next;
        }
    }

    /// Says something now, behind what waits.
    fn say(&mut self, text: &[u8]) {
        self.push(text);
        if !self.is_gone() && self.outgoing.flush_to(&mut &self.stream).is_err() {
            self.stage = Stage::Left;
        }
    }

    /// A client that sends has read the answer to `< rawmode >`.
    fn settle(&mut self, now: Instant) {
        if let Stage::Settling(_) = self.stage {
            self.stage = Stage::Raw;
            self.flush(now);
        }
    }
}
