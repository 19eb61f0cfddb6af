//! A server of the protocol: a bus in user space.

use std::array;
use std::collections::VecDeque;
use std::io::{self, ErrorKind};
use std::net::{SocketAddr, TcpListener};

use rustix::event::{PollFd, PollFlags};

use super::endpoint::check_bus_name;
use super::member::Member;
use super::protocol::write_reply;
use super::wait::wait;
use crate::bus::{Arrival, Bus, BusError};
use crate::config::Problem;
use crate::frame::Frame;
use crate::run::Clock;
use crate::time::Instant;

/// How many clients fit; more than nodes on a usual CAN bus.
const MOST_MEMBERS: usize = 32;

/// A bus for the program that owns it and for every client that connects.
///
/// Each frame goes to every other participant, and all see the frames in the
/// one order in which the hub accepted them. Nothing is lost, but for a client
/// that does not read: when 4 MiB of text (64 Ki frames and more) wait for it,
/// it is disconnected. The others never wait for it.
///
/// All work is done inside [`Bus::receive`], so the owner has to call it for
/// the clients to hear each other. While the owner does not, clients are not
/// read, and TCP makes them wait.
pub struct Hub {
    listener: TcpListener,
    address: SocketAddr,
    bus_name: String,
    clock: Clock,
    members: Vec<Member>,
    /// Frames from clients that the owner has not taken.
    inbox: VecDeque<(Instant, Frame)>,
    counts: HubCounts,
}

/// What has happened on a hub.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct HubCounts {
    /// Clients that connected and were greeted.
    pub joined: u64,
    /// Clients that were disconnected because they did not read.
    pub cut_off: u64,
    /// Messages of clients that made no sense.
    pub malformed: u64,
}

impl Hub {
    /// Listens at `address` (port 0 for any free one) and offers one bus.
    ///
    /// Anybody who can connect can send frames, so an address that other
    /// machines reach has to be asked for with `allow_others`.
    ///
    /// # Errors
    /// The port is taken or not permitted, the address is not one of this
    /// machine, or others could reach it and that was not asked for.
    pub fn listen(address: SocketAddr, bus_name: &str, clock: Clock, allow_others: bool) -> Result<Self, Problem> {
        check_bus_name(bus_name)?;
        if !address.ip().is_loopback() && !allow_others {
            let what = format!("at {address} other machines could send frames on this bus");
            let help = format!("listen at 127.0.0.1:{}, or allow it: `hil-sim serve --allow-others`", address.port());
            return Err(Problem::bare(what).help(help));
        }
        let listener = TcpListener::bind(address).map_err(|error| cannot_listen(address, &error))?;
        let ready = listener.set_nonblocking(true).and_then(|()| listener.local_addr());
        let address = ready.map_err(|error| cannot_listen(address, &error))?;
        Ok(Self {
            listener,
            address,
            bus_name: bus_name.to_owned(),
            clock,
            members: Vec::with_capacity(MOST_MEMBERS),
            inbox: VecDeque::new(),
            counts: HubCounts::default(),
        })
    }

    /// Where clients connect.
    pub fn address(&self) -> SocketAddr {
        self.address
    }

    /// How many clients take part: get frames of the bus.
    pub fn clients(&self) -> usize {
        self.members.iter().filter(|member| member.listens()).count()
    }

    /// What has happened so far.
    pub fn counts(&self) -> HubCounts {
        let of_members: u64 = self.members.iter().map(Member::malformed).sum();
        HubCounts { malformed: self.counts.malformed + of_members, ..self.counts }
    }

    /// One round: waits until a client wants something, until `deadline` at
    /// the latest, and does it.
    fn serve(&mut self, deadline: Instant) -> io::Result<()> {
        let count = self.members.len();
        let ready = self.wait(deadline)?;
        for (index, _) in ready[..count].iter().enumerate().filter(|(_, ready)| **ready) {
            self.hear(index);
        }
        if ready[count] {
            self.welcome();
        }
        self.flush();
        Ok(())
    }

    /// Waits until there is something to do, and tells which members have
    /// something to read; after the last of them, whether somebody connects.
    fn wait(&self, deadline: Instant) -> io::Result<[bool; MOST_MEMBERS + 1]> {
        let now = self.clock.now();
        // On the stack; the places past the listener's are not used.
        let mut sockets: [PollFd<'_>; MOST_MEMBERS + 1] = array::from_fn(|index| match self.members.get(index) {
            Some(member) => member.poll_fd(now),
            None => PollFd::new(&self.listener, PollFlags::IN),
        });
        let sockets = &mut sockets[..=self.members.len()];
        let due = self.members.iter().filter_map(|member| member.held_until(now)).min();
        wait(sockets, &self.clock, due.map_or(deadline, |due| due.min(deadline)))?;
        let readable = |socket: &PollFd<'_>| !(socket.revents() - PollFlags::OUT).is_empty();
        Ok(array::from_fn(|index| sockets.get(index).is_some_and(readable)))
    }

    /// Reads a client and passes its frames on.
    fn hear(&mut self, index: usize) {
        self.members[index].read();
        let now = self.clock.now();
        while let Some(frame) = self.members[index].next_frame(&self.bus_name, now) {
            self.pass_on(now, &frame, Some(index));
            self.inbox.push_back((now, frame));
        }
    }

    /// Queues a frame for everybody but its sender.
    fn pass_on(&mut self, at: Instant, frame: &Frame, sender: Option<usize>) {
        let text = write_reply(at, frame);
        for (index, member) in self.members.iter_mut().enumerate() {
            if member.listens() && Some(index) != sender {
                member.push(text.as_bytes());
            }
        }
    }

    fn welcome(&mut self) {
        // One a round: the next one is still there then.
        let Ok((stream, _)) = self.listener.accept() else { return };
        let Ok(mut member) = Member::greet(stream) else { return };
        if self.members.len() == MOST_MEMBERS {
            member.refuse(b"< error too many clients >");
            return;
        }
        self.counts.joined += 1;
        self.members.push(member);
    }

    /// Writes what goes without waiting and forgets who has gone.
    fn flush(&mut self) {
        let now = self.clock.now();
        for member in &mut self.members {
            member.flush(now);
        }
        for member in self.members.iter().filter(|member| member.is_gone()) {
            self.counts.cut_off += u64::from(member.is_cut_off());
            self.counts.malformed += member.malformed();
        }
        self.members.retain(|member| !member.is_gone());
    }
}

impl Bus for Hub {
    /// To every client, at once; never [`BusError::Full`]. Without a client
    /// the frame is heard by nobody.
    fn send(&mut self, frame: &Frame) -> Result<(), BusError> {
        self.pass_on(self.clock.now(), frame, None);
        self.flush();
        Ok(())
    }

    fn receive(&mut self, deadline: Instant) -> Result<Option<(Instant, Arrival)>, BusError> {
        let mut looked = false;
        loop {
            if let Some((at, frame)) = self.inbox.pop_front() {
                return Ok(Some((at, Arrival::Frame(frame))));
            }
            if looked && self.clock.now() >= deadline {
                return Ok(None);
            }
            self.serve(deadline).map_err(|error| BusError::Gone(format!("the hub at {}", self.address), error))?;
            looked = true;
        }
    }
}

impl Drop for Hub {
    fn drop(&mut self) {
        self.members.iter_mut().for_each(Member::flush_last);
    }
}

fn cannot_listen(address: SocketAddr, error: &io::Error) -> Problem {
    let port = address.port();
    match error.kind() {
        ErrorKind::AddrInUse => Problem::bare(format!("cannot listen at {address}: another program uses port {port}"))
            .help("end that program (`ss -ltnp` names it) or take another port"),
        ErrorKind::PermissionDenied => Problem::bare(format!("cannot listen at {address}: not permitted"))
            .help("ports below 1024 belong to the system; take one above, such as 29536"),
        ErrorKind::AddrNotAvailable => {
            Problem::bare(format!("cannot listen at {address}: {} is no address of this machine", address.ip()))
                .help("listen at 127.0.0.1, or at an address that `ip address` shows")
        }
        _ => Problem::bare(format!("cannot listen at {address}: {error}")),
    }
}
