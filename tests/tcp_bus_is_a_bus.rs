//! A bus over TCP behaves as a bus: every frame reaches every other
//! participant, in one order, and nothing is lost.

mod tcp_bus;

use canloop::bus::socketcand::Socketcand;
use canloop::bus::{Arrival, Bus, BusError};
use canloop::frame::{CanId, Frame, FrameKind};
use canloop::run::Clock;
use canloop::time::Duration;
use tcp_bus::{PATIENCE, RunningHub, classic_frames, frame, hub, is_quiet, join, next_frame, numbered};

#[test]
fn frames_of_every_kind_arrive_as_they_were_sent() {
    let hub = RunningHub::start();
    let (mut sender, mut receiver) = (hub.join(), hub.join());
    let (standard, extended) = (CanId::Standard(0x123), CanId::Extended(0x123));
    let mut frames = classic_frames();
    frames.extend([0, 8].map(|len| frame(standard, FrameKind::Remote, &vec![0; len])));
    for len in [0, 1, 8, 12, 16, 20, 24, 32, 48, 64] {
        frames.push(frame(standard, FrameKind::Fd, &vec![0xA5; len]));
        frames.push(frame(extended, FrameKind::FdBitRateSwitch, &vec![0x5A; len]));
    }
    for sent in &frames {
        sender.send(sent).expect("there is room");
    }
    for sent in &frames {
        assert_eq!(next_frame(&mut receiver), *sent);
    }
    assert!(is_quiet(&mut sender), "a sender does not hear itself");
    let (counts, heard) = hub.stop();
    assert_eq!(heard, frames, "the owner of the hub hears them too");
    assert_eq!((counts.joined, counts.malformed), (2, 0));
}

#[test]
fn the_owner_of_the_hub_takes_part() {
    let mut hub = hub();
    let address = hub.address();
    let client = std::thread::spawn(move || {
        let mut client = join(address);
        let greeting = numbered(1, 1);
        client.send(&greeting).expect("there is room");
        let answers = [next_frame(&mut client), next_frame(&mut client)];
        (greeting, answers)
    });
    let asked = next_frame(&mut hub);
    let answers = [numbered(2, 2), numbered(3, 3)];
    answers.iter().for_each(|answer| hub.send(answer).expect("a hub has room"));
    // The hub works for its clients while its owner waits.
    while !client.is_finished() {
        assert_eq!(hub.receive(Clock::new().now() + Duration::from_millis(5)).expect("the hub serves"), None);
    }
    assert_eq!(client.join().expect("the client got its answers"), (asked, answers));
}

#[test]
fn all_see_the_frames_in_one_order() {
    const EACH: u32 = 2_000;
    let hub = RunningHub::start();
    let clients: Vec<Socketcand> = (0..3).map(|_| hub.join()).collect();
    let mut witness = hub.join();
    let threads: Vec<_> = clients
        .into_iter()
        .enumerate()
        .map(|(id, mut client)| std::thread::spawn(move || talk_and_listen(&mut client, id as u16, EACH)))
        .collect();
    let order: Vec<Frame> = (0..3 * EACH).map(|_| next_frame(&mut witness)).collect();
    for (id, thread) in threads.into_iter().enumerate() {
        let without_own: Vec<Frame> =
            order.iter().filter(|frame| frame.id != CanId::Standard(id as u16)).copied().collect();
        assert!(thread.join().expect("a client did its work") == without_own, "client {id} saw another order");
    }
    assert!(order == hub.stop().1, "the owner saw another order");
    let changes = order.windows(2).filter(|pair| pair[0].id != pair[1].id).count();
    assert!(changes > 3, "the clients took turns, so this shows nothing: {changes} changes of sender");
}

/// Sends frames of one id while listening to two others who do the same.
fn talk_and_listen(client: &mut Socketcand, id: u16, each: u32) -> Vec<Frame> {
    let (clock, mut heard, mut sent) = (Clock::new(), Vec::new(), 0);
    while sent < each || heard.len() < 2 * each as usize {
        if sent < each {
            client.send(&numbered(id, sent)).expect("there is room");
            sent += 1;
        }
        let until = if sent < each { clock.now() } else { clock.now() + PATIENCE };
        match client.receive(until).expect("the bus works") {
            Some((_, Arrival::Frame(frame))) => heard.push(frame),
            other => assert!(sent < each || other.is_some(), "frames are missing"),
        }
    }
    heard
}

#[test]
fn of_a_hundred_thousand_frames_none_is_lost() {
    const FRAMES: u32 = 100_000;
    let hub = RunningHub::start();
    let (mut sender, mut receiver) = (hub.join(), hub.join());
    let listening =
        std::thread::spawn(move || (0..FRAMES).all(|number| next_frame(&mut receiver) == numbered(5, number)));
    let clock = Clock::new();
    for number in 0..FRAMES {
        while let Err(error) = sender.send(&numbered(5, number)) {
            assert!(matches!(error, BusError::Full), "{error}");
            sender.receive(clock.now() + Duration::from_millis(1)).expect("the bus works");
        }
    }
    assert!(listening.join().expect("the receiver ended"), "a frame is missing or out of place");
    let (counts, heard) = hub.stop();
    assert_eq!((heard.len(), counts.cut_off, counts.malformed), (FRAMES as usize, 0, 0));
}

#[test]
fn who_does_not_read_is_cut_off_and_the_others_do_not_wait() {
    let hub = RunningHub::start();
    let (mut sender, mut receiver, mut sleeper) = (hub.join(), hub.join(), hub.join());
    let (clock, mut number, mut slowest) = (Clock::new(), 0, Duration::ZERO);
    // A window keeps the queue of the one who reads short; CAN FD fills the
    // other one sooner.
    let payload = |number: u32| number.to_be_bytes().repeat(16);
    let sent = |number| frame(CanId::Standard(1), FrameKind::Fd, &payload(number));
    let mut is_cut_off = false;
    while !is_cut_off && number < 400_000 {
        let start = clock.now();
        for ahead in number..number + 500 {
            sender.send(&sent(ahead)).expect("there is room");
        }
        for ahead in number..number + 500 {
            assert_eq!(next_frame(&mut receiver), sent(ahead));
        }
        slowest = slowest.max(clock.now() - start);
        number += 500;
        // The sleeper's own writing shows whether the hub still keeps it.
        is_cut_off = sleeper.send(&numbered(2, number)).is_err();
        if !is_cut_off {
            let _ = receiver.receive(clock.now() + Duration::from_millis(100));
        }
    }
    assert!(is_cut_off, "{number} frames wait for somebody who does not read");
    assert!(slowest < Duration::from_millis(2_000), "the others waited {slowest}");
    assert_eq!(hub.stop().0.cut_off, 1);
}

#[test]
fn stamps_are_of_the_moment_and_in_order() {
    let hub = RunningHub::start();
    let (mut sender, mut receiver) = (hub.join(), hub.join());
    let clock = Clock::new();
    let mut last = clock.now() - Duration::from_millis(100);
    for number in 0..20 {
        sender.send(&numbered(1, number)).expect("there is room");
        let (at, _) = receiver.receive(clock.now() + PATIENCE).expect("the bus works").expect("a frame");
        assert!(last <= at && at <= clock.now() + Duration::from_millis(100), "{at} after {last}");
        last = at;
    }
    hub.stop();
}

#[test]
fn a_deadline_is_kept() {
    let hub = RunningHub::start();
    let mut client = hub.join();
    let clock = Clock::new();
    let deadline = clock.now() + Duration::from_millis(30);
    assert_eq!(client.receive(deadline).expect("the bus works"), None);
    let late = clock.now() - deadline;
    assert!(late >= Duration::ZERO && late < Duration::from_millis(500), "{late} late");
    // One that has passed only looks.
    assert_eq!(client.receive(deadline).expect("the bus works"), None);
    hub.stop();
}
