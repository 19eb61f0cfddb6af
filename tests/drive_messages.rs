//! What one end of the bus says, the other understands, and damaged or
//! foreign frames are refused.

use canloop::config::{Document, Source};
use canloop::frame::{CanId, Frame, FrameKind};
use canloop::schema::{Command, DecodeError, FaultCode, Feedback, Heartbeat, Message, Profile, StateId};
use canloop::wheels::Wheel;
use proptest::prelude::*;

fn profile() -> Profile {
    Profile::builtin("wheel_drive").unwrap()
}

fn messages() -> impl Strategy<Value = Message> {
    let wheels = prop::sample::select(Wheel::BOTH.to_vec());
    let conversation = profile().conversation;
    let words = prop::sample::select(["disable", "enable", "clear_fault"].map(|name| conversation.word(name)).to_vec());
    let calm = prop::sample::select(["boot", "ready", "enabled"].map(|name| conversation.state(name)).to_vec());
    let failed = conversation.state("fault");
    let states = prop_oneof![calm.clone(), Just(failed)];
    let faults = prop::sample::select(vec![
        FaultCode::CommandTimeout,
        FaultCode::CommandCorrupt,
        FaultCode::OverCurrent,
        FaultCode::OverTemperature,
        FaultCode::UnderVoltage,
        FaultCode::Encoder,
    ]);
    let torques = (i16::MIN..=i16::MAX).prop_map(|raw| f64::from(raw) * 0.005);
    prop_oneof![
        any::<u8>().prop_map(|counter| Message::Sync { counter }),
        (wheels.clone(), torques.clone(), words, 0..16_u8).prop_map(|(wheel, torque_nm, word, counter)| {
            Message::Command(wheel, Command { torque_nm, word, counter })
        }),
        (wheels.clone(), any::<i32>(), torques, states, 0..16_u8).prop_map(
            |(wheel, position, torque_nm, state, counter)| {
                Message::Feedback(wheel, reported(position, torque_nm, state, counter))
            }
        ),
        (wheels.clone(), calm)
            .prop_map(|(wheel, state)| Message::Heartbeat(wheel, Heartbeat { state, fault: FaultCode::None })),
        (wheels.clone(), faults.clone())
            .prop_map(move |(wheel, fault)| Message::Heartbeat(wheel, Heartbeat { state: failed, fault })),
        (wheels, faults).prop_map(|(wheel, fault)| Message::Fault(wheel, fault)),
    ]
}

fn reported(position: i32, torque_nm: f64, state: Option<StateId>, counter: u8) -> Feedback {
    Feedback {
        position: Some(f64::from(position)),
        torque_applied_nm: Some(torque_nm),
        state,
        counter: Some(counter),
        ..Feedback::default()
    }
}

fn command(torque_nm: f64) -> Message {
    Message::Command(Wheel::Right, Command { torque_nm, word: profile().conversation.word("enable"), counter: 5 })
}

fn feedback() -> Message {
    Message::Feedback(Wheel::Left, reported(-123_456, -12.345, profile().conversation.state("enabled"), 9))
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn every_message_comes_back_as_it_was_sent(message in messages()) {
        let profile = profile();
        prop_assert_eq!(profile.decode(&profile.encode(&message)), Ok(message));
    }

    #[test]
    fn no_frame_and_no_number_makes_it_panic(
        id in 0..0x800_u16,
        payload in prop::collection::vec(any::<u8>(), 0..=8),
        torque_nm in any::<f64>(),
        counter in any::<u8>(),
    ) {
        let profile = profile();
        let _ = profile.decode(&Frame::classic(CanId::Standard(id), &payload));
        let sent = Command { torque_nm, word: profile.conversation.word("enable"), counter };
        let frame = profile.encode(&Message::Command(Wheel::Right, sent));
        let Ok(Message::Command(_, got)) = profile.decode(&frame) else { panic!("{frame} is a command") };
        prop_assert!((-163.84..=163.835).contains(&got.torque_nm));
        prop_assert_eq!(got.counter, counter % 16);
    }
}

#[test]
fn a_flipped_bit_anywhere_in_a_command_or_feedback_is_refused() {
    let profile = profile();
    for message in [command(12.0), feedback()] {
        let frame = profile.encode(&message);
        for bit in 0..8 * frame.len() {
            let mut damaged = frame;
            damaged.payload_mut()[bit / 8] ^= 1 << (bit % 8);
            let refused = profile.decode(&damaged);
            assert!(matches!(refused, Err(DecodeError::WrongCrc { .. })), "bit {bit} of {message:?}: {refused:?}");
        }
        for bit in 0..11 {
            let mut damaged = frame;
            damaged.id = CanId::Standard(frame.id.raw() as u16 ^ 1 << bit);
            assert!(profile.decode(&damaged).is_err(), "bit {bit} of the id of {message:?}");
        }
    }
}

#[test]
fn a_frame_sent_under_the_other_wheel_s_id_is_refused() {
    let profile = profile();
    for (message, other) in [(command(1.0), 0x202), (feedback(), 0x181)] {
        let mut frame = profile.encode(&message);
        frame.id = CanId::Standard(other);
        assert!(matches!(profile.decode(&frame), Err(DecodeError::WrongCrc { .. })));
    }
}

#[test]
fn a_torque_out_of_range_becomes_the_nearest_that_fits() {
    let profile = profile();
    let sent = |torque_nm| match profile.decode(&profile.encode(&command(torque_nm))) {
        Ok(Message::Command(_, command)) => command.torque_nm,
        other => panic!("{other:?}"),
    };
    let scale = profile.command_torque(Wheel::Right);
    for torque_nm in [163.84, 1e9, f64::INFINITY] {
        assert_eq!(sent(torque_nm), scale.maximum_nm);
    }
    for torque_nm in [-163.85, -1e300, f64::NEG_INFINITY] {
        assert_eq!(sent(torque_nm), scale.minimum_nm);
    }
    assert_eq!(sent(f64::NAN), 0.0);
    assert_eq!((scale.resolution_nm, scale.minimum_nm, scale.maximum_nm), (0.005, -163.84, 163.835));
    assert_eq!(profile.applied_torque(Wheel::Left), Some(scale));
}

/// The wheel drive without CRCs, and with another layout of the commands'
/// torque.
fn with_torque(layout: &str, notes: &str) -> Profile {
    let toml = include_str!("../dbc/wheel_drive.toml").replace("crc = \"Crc\"\n", "");
    let dbc = include_str!("../dbc/wheel_drive.dbc")
        .replace("Torque : 0|16@1- (0.005,0)", &format!("Torque : {layout}"))
        .replace(": 4 Stack", ": 8 Stack");
    let toml = Document::parse("drive.toml", toml).unwrap();
    let dbc = Source::new("drive.dbc", dbc + notes);
    Profile::parse(&toml, &dbc).unwrap_or_else(|problems| panic!("{problems}"))
}

#[test]
fn what_is_no_number_becomes_no_torque_even_where_raw_zero_is_some() {
    let profile = with_torque("0|16@1+ (0.005,-100)", "");
    let Ok(Message::Command(_, sent)) = profile.decode(&profile.encode(&command(f64::NAN))) else { panic!() };
    assert_eq!(sent.torque_nm, 0.0);
}

#[test]
fn a_torque_that_is_no_number_is_refused() {
    let floats = "SIG_VALTYPE_ 513 Torque : 1;\nSIG_VALTYPE_ 514 Torque : 1;\n";
    let profile = with_torque("32|32@1- (1,0)", floats);
    let mut frame = profile.encode(&command(2.5));
    assert!(matches!(profile.decode(&frame), Ok(Message::Command(_, command)) if command.torque_nm == 2.5));
    frame.payload_mut()[4..].copy_from_slice(&f32::NAN.to_le_bytes());
    assert_eq!(profile.decode(&frame), Err(DecodeError::NotFinite { role: "torque" }));
}

#[test]
fn a_frame_of_the_wrong_length_is_refused() {
    let profile = profile();
    let frame = profile.encode(&feedback());
    let cut = Frame::classic(frame.id, &frame.payload()[..7]);
    assert_eq!(profile.decode(&cut), Err(DecodeError::WrongLength { found: 7, expected: 8 }));
    let empty = Frame::classic(CanId::Standard(0x201), &[]);
    assert_eq!(profile.decode(&empty), Err(DecodeError::WrongLength { found: 0, expected: 4 }));
}

#[test]
fn a_frame_of_another_id_and_a_remote_request_are_refused() {
    let profile = profile();
    for id in [CanId::Standard(0x123), CanId::Extended(0x181)] {
        assert_eq!(profile.decode(&Frame::zeroed(id, 8)), Err(DecodeError::UnknownId));
    }
    let mut request = Frame::zeroed(CanId::Standard(0x080), 1);
    request.kind = FrameKind::Remote;
    assert_eq!(profile.decode(&request), Err(DecodeError::RemoteRequest));
}

#[test]
fn a_value_without_a_name_is_refused() {
    let profile = profile();
    let heartbeat = Frame::classic(CanId::Standard(0x701), &[9, 0]);
    let refused = profile.decode(&heartbeat).unwrap_err();
    assert_eq!(refused, DecodeError::UnknownValue { role: "state", found: 9 });
    assert_eq!(refused.to_string(), "state 9, which the profile does not name");
}

#[test]
fn counters_wrap_at_their_signal_s_width() {
    let profile = profile();
    assert_eq!(profile.next_command_counter(Wheel::Right, 14), 15);
    assert_eq!(profile.next_command_counter(Wheel::Right, 15), 0);
    assert_eq!(profile.feedback_counter(Wheel::Left, 0x35), Some(5));
    assert_eq!(profile.next_sync_counter(15), 16);
    assert_eq!(profile.next_sync_counter(255), 0);
}

/// Bytes laid out by hand from dbc/README.md, CRC from an independent
/// implementation.
#[test]
fn a_command_has_the_bytes_that_the_readme_describes() {
    let word = profile().conversation.word("enable");
    let frame = profile().encode(&Message::Command(Wheel::Right, Command { torque_nm: -1.0, word, counter: 10 }));
    assert_eq!(frame.to_string(), "201#38FFA184");
}
