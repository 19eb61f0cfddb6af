//! A client of the protocol.

use std::io::{self, ErrorKind};
use std::net::{TcpStream, ToSocketAddrs};

use rustix::event::{PollFd, PollFlags};

use super::buffers::{Incoming, Outgoing};
use super::endpoint::{Endpoint, check_bus_name};
use super::protocol::{Reply, parse_reply, write_command};
use super::wait::wait;
use crate::bus::{Arrival, Bus, BusError, ControllerState};
use crate::config::Problem;
use crate::frame::Frame;
use crate::run::Clock;
use crate::time::{Duration, Instant};

/// How long a server may take to let us in.
const HANDSHAKE: Duration = Duration::from_millis(3_000);
/// What waits when the network does not take it: some hundreds of frames,
/// far beyond the transmit queue of a CAN interface.
const QUEUE_BYTES: usize = 32 * 1024;
/// Class bits of an error frame (`linux/can/error.h`).
const ERROR_BUS_OFF: u32 = 0x40;
const ERROR_RESTARTED: u32 = 0x100;

/// A bus that a server of the socketcand protocol lends us.
///
/// Frames carry the moment at which they reached us, by our clock: the
/// server's stamps are of a clock that may be another machine's. A connection
/// that ends is [`BusError::Gone`], after everything that had arrived.
pub struct Socketcand {
    stream: TcpStream,
    /// For messages: where the bus is.
    endpoint: Endpoint,
    clock: Clock,
    incoming: Incoming,
    outgoing: Outgoing,
    /// When what is in `incoming` was read.
    read_at: Instant,
    /// Messages that made no sense.
    malformed: u64,
    /// Why the connection has ended.
    ended: Option<(ErrorKind, String)>,
}

impl Socketcand {
    /// Connects, opens the bus and switches to raw mode; takes 3 s at most,
    /// and what a name server needs.
    ///
    /// # Errors
    /// Nobody listens there, the server does not know the bus, speaks
    /// something else, or is silent.
    pub fn connect(host: &str, port: u16, bus_name: &str, clock: Clock) -> Result<Self, Problem> {
        check_bus_name(bus_name)?;
        let endpoint = Endpoint { host: host.to_owned(), port, bus_name: bus_name.to_owned() };
        let deadline = clock.now() + HANDSHAKE;
        let stream = open_stream(&endpoint, &clock, deadline)?;
        let mut client = Self {
            stream,
            endpoint,
            clock,
            incoming: Incoming::new(),
            outgoing: Outgoing::with_room(QUEUE_BYTES),
            read_at: deadline,
            malformed: 0,
            ended: None,
        };
        client.expect("hi", deadline)?;
        client.ask(&format!("< open {bus_name} >"), deadline)?;
        client.ask("< rawmode >", deadline)?;
        Ok(client)
    }

    /// How many messages, or pieces of text outside of any, made no sense.
    pub fn malformed(&self) -> u64 {
        self.malformed + self.incoming.junk()
    }

    fn ask(&mut self, command: &str, deadline: Instant) -> Result<(), Problem> {
        self.outgoing.push(command.as_bytes());
        self.flush().map_err(|error| self.problem(&format!("{error} after `{command}`")))?;
        self.expect("ok", deadline)
    }

    /// Waits for the reply `< {wanted} >`.
    fn expect(&mut self, wanted: &str, deadline: Instant) -> Result<(), Problem> {
        let expected = format!("expected `< {wanted} >`");
        loop {
            if let Some(message) = self.incoming.next_message() {
                let said = show(message);
                return match parse_reply(message) {
                    Some(Reply::Hi) if wanted == "hi" => Ok(()),
                    Some(Reply::Ok) if wanted == "ok" => Ok(()),
                    Some(Reply::Refused(_)) => Err(self.refusal(&said)),
                    _ => Err(self.problem(&format!("found `<{said}>`, {expected}"))),
                };
            }
            if self.clock.now() >= deadline {
                return Err(self.problem(&format!("found nothing for 3 s, {expected}")));
            }
            self.read(deadline).map_err(|error| self.problem(&format!("{error}, {expected}")))?;
            // Whatever speaks first and is no server of ours.
            let said = self.incoming.unfinished();
            if said.first().is_some_and(|&byte| byte != b'<' && !byte.is_ascii_whitespace()) {
                let said = show(&said[..said.len().min(40)]);
                return Err(self.problem(&format!("found `{said}`, {expected}")));
            }
        }
    }

    fn refusal(&self, why: &str) -> Problem {
        let Endpoint { bus_name, .. } = &self.endpoint;
        Problem::bare(format!("{}: the server does not open `{bus_name}`, it says `<{why}>`", self.endpoint))
            .help(format!("does the server offer a bus of the name `{bus_name}`?"))
    }

    fn problem(&self, what: &str) -> Problem {
        Problem::bare(format!("{}: no server of the socketcand protocol: {what}", self.endpoint))
            .help("a server that lends CAN buses greets with `< hi >`; is this the right port?")
    }

    /// Waits for bytes, until `deadline` at the latest, and reads them.
    fn read(&mut self, deadline: Instant) -> io::Result<()> {
        let write = if self.outgoing.is_empty() { PollFlags::empty() } else { PollFlags::OUT };
        let mut sockets = [PollFd::new(&self.stream, PollFlags::IN | write)];
        wait(&mut sockets, &self.clock, deadline)?;
        let ready = sockets[0].revents();
        if ready.contains(PollFlags::OUT) {
            self.flush()?;
        }
        if (ready - PollFlags::OUT).is_empty() {
            return Ok(());
        }
        match self.incoming.read_from(&mut &self.stream) {
            Ok(0) => Err(io::Error::new(ErrorKind::UnexpectedEof, "the server closed the connection")),
            Ok(_) => {
                self.read_at = self.clock.now();
                Ok(())
            }
            Err(error) if matches!(error.kind(), ErrorKind::WouldBlock | ErrorKind::Interrupted) => Ok(()),
            Err(error) => Err(error),
        }
    }

    fn flush(&mut self) -> io::Result<()> {
        self.outgoing.flush_to(&mut &self.stream)
    }

    /// What the messages that have come say, up to the first that matters.
    fn next_arrival(&mut self) -> Result<Option<Arrival>, io::Error> {
        while let Some(message) = self.incoming.next_message() {
            match parse_reply(message) {
                Some(Reply::Frame(_, frame)) => return Ok(Some(Arrival::Frame(frame))),
                Some(Reply::ErrorFrame(class)) if class & ERROR_BUS_OFF != 0 => {
                    return Ok(Some(Arrival::State(ControllerState::BusOff)));
                }
                Some(Reply::ErrorFrame(class)) if class & ERROR_RESTARTED != 0 => {
                    return Ok(Some(Arrival::State(ControllerState::ErrorActive)));
                }
                Some(Reply::Refused(why)) => {
                    let what = format!(
                        "the server refused a frame: {} (old servers know neither CAN FD nor remote requests)",
                        show(why)
                    );
                    return Err(io::Error::new(ErrorKind::Unsupported, what));
                }
                Some(_) => {}
                None => self.malformed += 1,
            }
        }
        Ok(None)
    }

    /// Notes that the connection is over and says so.
    fn end(&mut self, error: &io::Error) -> BusError {
        let (kind, what) = self.ended.get_or_insert_with(|| (error.kind(), error.to_string()));
        BusError::Gone(self.endpoint.to_string(), io::Error::new(*kind, what.clone()))
    }

    fn check_alive(&self) -> Result<(), BusError> {
        match &self.ended {
            None => Ok(()),
            Some((kind, what)) => Err(BusError::Gone(self.endpoint.to_string(), io::Error::new(*kind, what.clone()))),
        }
    }
}

impl Bus for Socketcand {
    /// Writes at once: a command for zero torque must not wait for company.
    fn send(&mut self, frame: &Frame) -> Result<(), BusError> {
        self.check_alive()?;
        if !self.outgoing.push(write_command(frame).as_bytes()) {
            self.flush().map_err(|error| self.end(&error))?;
            if !self.outgoing.push(write_command(frame).as_bytes()) {
                return Err(BusError::Full);
            }
        }
        self.flush().map_err(|error| self.end(&error))
    }

    fn receive(&mut self, deadline: Instant) -> Result<Option<(Instant, Arrival)>, BusError> {
        let mut looked = false;
        loop {
            self.check_alive()?;
            match self.next_arrival() {
                Ok(Some(arrival)) => return Ok(Some((self.read_at, arrival))),
                Ok(None) if looked && self.clock.now() >= deadline => return Ok(None),
                Ok(None) => {}
                Err(error) => return Err(self.end(&error)),
            }
            self.read(deadline).map_err(|error| self.end(&error))?;
            looked = true;
        }
    }
}

fn open_stream(endpoint: &Endpoint, clock: &Clock, deadline: Instant) -> Result<TcpStream, Problem> {
    let host = endpoint.host.as_str();
    let addresses = (host, endpoint.port).to_socket_addrs().map_err(|error| {
        Problem::bare(format!("{endpoint}: the host `{host}` is not known: {error}")).help("write its address instead")
    })?;
    let mut last = io::Error::new(ErrorKind::AddrNotAvailable, "the name has no address");
    for address in addresses {
        // A wait of zero would be refused as an argument.
        let left = (deadline - clock.now()).as_nanos().max(1_000_000).unsigned_abs();
        match TcpStream::connect_timeout(&address, std::time::Duration::from_nanos(left)) {
            Ok(stream) => {
                let ready = stream.set_nonblocking(true).and_then(|()| stream.set_nodelay(true));
                return ready.map(|()| stream).map_err(|error| Problem::bare(format!("{endpoint}: {error}")));
            }
            Err(error) => last = error,
        }
    }
    let problem = match last.kind() {
        ErrorKind::ConnectionRefused => Problem::bare(format!("{endpoint}: nobody listens there (connection refused)")),
        ErrorKind::TimedOut => Problem::bare(format!("{endpoint}: the host does not answer (waited 3 s)")),
        _ => Problem::bare(format!("{endpoint}: cannot connect: {last}")),
    };
    Err(problem
        .help("start the other side first, such as `hil-sim serve` with `--bus tcp-listen://...`, or socketcand"))
}

/// Foreign bytes as one printable line.
fn show(bytes: &[u8]) -> String {
    bytes.escape_ascii().to_string()
}
