//! Peers that are absent, foreign, hostile or dead: one clear message or a
//! prompt end, never a panic, and nobody else suffers.

mod tcp_bus;

use std::io::{Read, Write};
use std::net::{SocketAddr, TcpListener, TcpStream};
use std::thread::JoinHandle;

use canloop::bus::socketcand::{Hub, Socketcand};
use canloop::bus::{Arrival, Bus, BusError, ControllerState};
use canloop::config::Problem;
use canloop::frame::{CanId, Frame, FrameKind};
use canloop::run::Clock;
use canloop::time::Duration;
use proptest::prelude::*;
use proptest::strategy::ValueTree;
use proptest::test_runner::{Config, TestRunner};
use tcp_bus::{PATIENCE, RunningHub, frame, hub, join, next_frame, numbered};

/// A server that greets and lets a client in, as `replies`, one to each of its
/// messages, say; then says `rest` in pieces of `size` bytes and closes.
fn fake_server(replies: &[&'static str], rest: &[u8], size: usize) -> (SocketAddr, JoinHandle<()>) {
    let listener = TcpListener::bind("127.0.0.1:0").expect("a free port");
    let address = listener.local_addr().expect("an address");
    let (replies, rest) = (replies.to_vec(), rest.to_vec());
    let thread = std::thread::spawn(move || {
        let (mut stream, _) = listener.accept().expect("a client comes");
        stream.set_nodelay(true).expect("a socket option");
        for (index, reply) in replies.iter().enumerate() {
            if index > 0 && stream.read(&mut [0; 256]).is_ok_and(|count| count == 0) {
                return;
            }
            let _ = stream.write_all(reply.as_bytes());
        }
        for piece in rest.chunks(size) {
            let _ = stream.write_all(piece);
        }
        let _ = stream.shutdown(std::net::Shutdown::Write);
        // Until the client is done, so that nothing it was told is taken back.
        let _ = stream.read_to_end(&mut Vec::new());
    });
    (address, thread)
}

const WELCOME: [&str; 3] = ["< hi >", "< ok >", "< ok >"];

fn connect(address: SocketAddr) -> Result<Socketcand, Problem> {
    Socketcand::connect("127.0.0.1", address.port(), "can0", Clock::new())
}

fn refusal(address: SocketAddr) -> String {
    match connect(address) {
        Ok(_) => panic!("it connected"),
        Err(problem) => problem.to_string(),
    }
}

fn free_address() -> SocketAddr {
    TcpListener::bind("127.0.0.1:0").and_then(|listener| listener.local_addr()).expect("a free port")
}

#[track_caller]
fn assert_says(text: &str, parts: &[&str]) {
    for part in parts {
        assert!(text.contains(part), "no `{part}` in: {text}");
    }
}

#[test]
fn nobody_listens() {
    let address = free_address();
    assert_says(&refusal(address), &[&format!("tcp://{address}/can0"), "refused", "hil-sim serve"]);
}

#[test]
fn the_host_is_not_known() {
    let problem = Socketcand::connect("no-such-host.invalid", 29536, "can0", Clock::new()).err().expect("no such host");
    assert_says(&problem.to_string(), &["no-such-host.invalid", "not known"]);
}

#[test]
fn the_server_does_not_know_the_bus() {
    let hub = RunningHub::start();
    let problem =
        Socketcand::connect("127.0.0.1", hub.address.port(), "can7", Clock::new()).err().expect("no such bus");
    assert_says(&problem.to_string(), &["can7", "error could not open bus"]);
    hub.stop();
}

#[test]
fn the_server_speaks_first_and_something_else() {
    let (address, server) = fake_server(&["HTTP/1.1 400 Bad Request\r\n\r\n<html></html>"], b"", 1);
    assert_says(&refusal(address), &["found `HTTP/1.1 400 Bad Request", "expected `< hi >`"]);
    server.join().expect("the server ended");
    let (address, server) = fake_server(&["<html>"], b"", 1);
    assert_says(&refusal(address), &["found `<html>`", "expected `< hi >`"]);
    server.join().expect("the server ended");
}

#[test]
fn the_server_says_nothing() {
    let listener = TcpListener::bind("127.0.0.1:0").expect("a free port");
    let (clock, address) = (Clock::new(), listener.local_addr().expect("an address"));
    let start = clock.now();
    assert_says(&refusal(address), &["found nothing for 3 s", "expected `< hi >`"]);
    assert!(clock.now() - start < Duration::from_millis(6_000));
}

#[test]
fn the_server_hangs_up() {
    for (replies, expected) in [(&[][..], "`< hi >`"), (&["< hi >"], "`< ok >`"), (&["< hi >", "< ok >"], "`< ok >`")] {
        let (address, server) = fake_server(replies, b"", 1);
        assert_says(&refusal(address), &["closed the connection", &format!("expected {expected}")]);
        server.join().expect("the server ended");
    }
}

#[test]
fn the_name_of_the_bus_cannot_be_sent() {
    for name in ["", "can 0", "can0>", "a_name_that_is_too_long"] {
        let problem = Socketcand::connect("127.0.0.1", 1, name, Clock::new()).err().expect("no such name");
        assert_says(&problem.to_string(), &[&format!("`{name}`")]);
        assert!(Hub::listen(free_address(), name, Clock::new(), false).is_err());
    }
}

#[test]
fn the_port_is_taken() {
    let taken = hub();
    let problem = Hub::listen(taken.address(), "can0", Clock::new(), false).err().expect("the port is taken");
    assert_says(&problem.to_string(), &[&taken.address().to_string(), "another program", "ss -ltnp"]);
}

#[test]
fn an_address_that_others_reach_has_to_be_asked_for() {
    let everywhere = SocketAddr::new("0.0.0.0".parse().expect("an address"), 0);
    let problem = Hub::listen(everywhere, "can0", Clock::new(), false).err().expect("others are not allowed");
    assert_says(&problem.to_string(), &["0.0.0.0", "other machines", "127.0.0.1"]);
    assert!(Hub::listen(everywhere, "can0", Clock::new(), true).is_ok());
}

#[test]
fn an_address_of_another_machine_cannot_be_listened_at() {
    let elsewhere = "192.0.2.1:29536".parse().expect("an address");
    let problem = Hub::listen(elsewhere, "can0", Clock::new(), true).err().expect("not ours");
    assert_says(&problem.to_string(), &["192.0.2.1", "no address of this machine"]);
}

#[test]
fn a_bus_whose_server_dies_is_gone_at_once_and_for_good() {
    let mut hub = hub();
    let address = hub.address();
    let client = std::thread::spawn(move || {
        let mut client = join(address);
        let last = next_frame(&mut client);
        let clock = Clock::new();
        let start = clock.now();
        for _ in 0..2 {
            let error = client.receive(start + PATIENCE).expect_err("the server is gone");
            assert_says(&error.to_string(), &[&format!("tcp://{address}/can0 is gone")]);
        }
        assert!(matches!(client.send(&last), Err(BusError::Gone(..))));
        assert!(clock.now() - start < Duration::from_millis(2_000));
        last
    });
    while hub.clients() == 0 {
        hub.receive(Clock::new().now() + Duration::from_millis(5)).expect("the hub serves");
    }
    hub.send(&numbered(1, 1)).expect("a hub has room");
    drop(hub);
    assert_eq!(client.join().expect("the client ended well"), numbered(1, 1), "what was sent before still arrives");
}

#[test]
fn frames_behind_the_last_answer_are_not_lost_however_they_are_cut() {
    let text =
        b"< frame 123 23.424242 11 22 >\n< error 040 1.0 >< frame 00000123 23.424242 >junk< frame x >< stat 1 2 3 4 >\
        < error 100 1.0 >< fdframe 7FF 01 1.5 0102030405060708090A0B0C >< rtr 001 1.5 3 >";
    let expected = [
        Arrival::Frame(Frame::classic(CanId::Standard(0x123), &[0x11, 0x22])),
        Arrival::State(ControllerState::BusOff),
        Arrival::Frame(Frame::classic(CanId::Extended(0x123), &[])),
        Arrival::State(ControllerState::ErrorActive),
        Arrival::Frame(frame(
            CanId::Standard(0x7FF),
            FrameKind::FdBitRateSwitch,
            &[1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12],
        )),
        Arrival::Frame(frame(CanId::Standard(1), FrameKind::Remote, &[0; 3])),
    ];
    for size in [1, 2, 3, 7, 29, text.len()] {
        let (address, server) = fake_server(&WELCOME, text, size);
        let mut client = connect(address).unwrap_or_else(|problem| panic!("{problem}"));
        let arrivals =
            expected.map(|_| client.receive(Clock::new().now() + PATIENCE).expect("it works").expect("it comes").1);
        assert_eq!(arrivals, expected, "in pieces of {size}");
        assert_eq!(client.malformed(), 2);
        assert!(matches!(client.receive(Clock::new().now() + PATIENCE), Err(BusError::Gone(..))));
        drop(client);
        server.join().expect("the server ended");
    }
}

#[test]
fn a_server_too_old_for_a_frame_ends_the_bus_with_its_words() {
    let (address, server) = fake_server(&["< hi >", "< ok >", "< ok >", "< error unknown command >"], b"", 1);
    let mut client = connect(address).unwrap_or_else(|problem| panic!("{problem}"));
    client.send(&frame(CanId::Standard(1), FrameKind::Fd, &[0; 12])).expect("it is on its way");
    let error = client.receive(Clock::new().now() + PATIENCE).expect_err("the frame was refused");
    assert_says(&error.to_string(), &["unknown command", "CAN FD"]);
    drop(client);
    server.join().expect("the server ended");
}

#[test]
fn a_network_that_takes_nothing_is_a_full_queue() {
    let (address, _server) = {
        let listener = TcpListener::bind("127.0.0.1:0").expect("a free port");
        let address = listener.local_addr().expect("an address");
        let thread = std::thread::spawn(move || {
            let (mut stream, _) = listener.accept().expect("a client comes");
            stream.write_all(WELCOME.concat().as_bytes()).expect("the client listens");
            // Reads no more, but stays.
            std::thread::park_timeout(std::time::Duration::from_secs(10));
            drop(stream);
        });
        (address, thread)
    };
    let mut client = connect(address).unwrap_or_else(|problem| panic!("{problem}"));
    let full = (0..1_000_000).find_map(|number| client.send(&numbered(1, number)).err());
    assert!(matches!(full, Some(BusError::Full)), "{full:?}");
}

/// Random bytes, and messages that are nearly right.
fn garbage() -> impl Strategy<Value = Vec<u8>> {
    let words =
        "<?( ?(hi|ok|open|can0|rawmode|bcmmode|echo|send|fdsend|sendrtr|frame|error|[0-9A-F]{1,9}|[.x>-])){0,12} ?>?";
    prop::collection::vec(
        prop_oneof![prop::collection::vec(any::<u8>(), 0..60), words.prop_map(String::into_bytes)],
        0..20,
    )
    .prop_map(|pieces| pieces.concat())
}

fn many_kinds_of_garbage(count: u32) -> Vec<Vec<u8>> {
    let mut runner = TestRunner::new_with_rng(
        Config::default(),
        proptest::test_runner::TestRng::deterministic_rng(proptest::test_runner::RngAlgorithm::ChaCha),
    );
    (0..count).map(|_| garbage().new_tree(&mut runner).expect("it makes one").current()).collect()
}

#[test]
fn garbage_from_clients_harms_nobody() {
    let hub = RunningHub::start();
    let (mut sender, mut receiver) = (hub.join(), hub.join());
    for (number, garbage) in many_kinds_of_garbage(200).iter().enumerate() {
        let mut vandal = TcpStream::connect(hub.address).expect("the hub listens");
        if number % 2 == 0 {
            let _ = vandal.write_all(b"< open can0 >< rawmode >");
        }
        let _ = vandal.set_nodelay(true);
        for piece in garbage.chunks(1 + number % 50) {
            let _ = vandal.write_all(piece);
        }
        // Some of it may be a frame.
        let sent = numbered(0x155, number as u32);
        sender.send(&sent).expect("there is room");
        while next_frame(&mut receiver) != sent {}
        while sender.receive(Clock::new().now()).expect("the bus works").is_some() {}
    }
    let (counts, _) = hub.stop();
    assert!(counts.malformed > 0, "{counts:?}");
}

#[test]
fn garbage_from_a_server_ends_in_an_error_and_not_in_a_panic() {
    let mut malformed = 0;
    for (number, garbage) in many_kinds_of_garbage(200).iter().enumerate() {
        let (address, server) = fake_server(&WELCOME, garbage, 1 + number % 50);
        let mut client = connect(address).unwrap_or_else(|problem| panic!("{problem}"));
        let error = loop {
            match client.receive(Clock::new().now() + PATIENCE) {
                Ok(Some(_)) => {}
                Ok(None) => panic!("the end of the connection was not seen"),
                Err(error) => break error,
            }
        };
        assert!(matches!(error, BusError::Gone(..)), "{error}");
        malformed += client.malformed();
        drop(client);
        server.join().expect("the server ended");
    }
    assert!(malformed > 0);
}

#[test]
fn garbage_instead_of_a_greeting_is_refused() {
    for (number, garbage) in many_kinds_of_garbage(50).iter().enumerate() {
        let (address, server) = fake_server(&[], garbage, 1 + number % 50);
        let _ = connect(address);
        server.join().expect("the server ended");
    }
}

#[test]
fn the_hub_has_room_for_so_many_and_says_so() {
    let hub = RunningHub::start();
    let clients: Vec<Socketcand> = (0..32).map(|_| hub.join()).collect();
    let problem = Socketcand::connect("127.0.0.1", hub.address.port(), "can0", Clock::new()).err();
    assert_says(&problem.expect("it is full").to_string(), &["too many clients"]);
    drop(clients);
    // They have to be seen leaving first.
    let free = (0..100).any(|_| connect(hub.address).is_ok());
    assert!(free, "who left still takes room");
    hub.stop();
}
