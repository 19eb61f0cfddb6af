//! Frames that nobody meant to send: from any at all to some that only the
//! sender's name tells from real ones.

use canloop::frame::{CanId, Frame, FrameKind};
use canloop::schema::{
    Command, DriveState, FaultCode, Feedback, Heartbeat, Message, Profile, Request, StateId, WordId,
};
use canloop::wheels::Wheels;

use crate::harness::Chance;

/// Any frame, of kinds and lengths that go together or not.
pub fn any(chance: &mut Chance) -> Frame {
    let raw = chance.below(1 << 29) as u32;
    let id = if chance.below(2) == 0 { CanId::Standard((raw & 0x7FF) as u16) } else { CanId::Extended(raw) };
    with_any_contents(id, chance)
}

/// A frame with the id of a message in the profile's DBC, and any contents.
pub fn in_a_known_name(profile: &Profile, chance: &mut Chance) -> Frame {
    let message = &profile.dbc.messages[chance.below(profile.dbc.messages.len())];
    let mut frame = with_any_contents(message.id, chance);
    if chance.below(4) > 0 {
        let mut right = Frame::zeroed(message.id, message.len);
        let len = right.len().min(frame.len());
        right.payload_mut()[..len].copy_from_slice(&frame.payload()[..len]);
        frame = right;
    }
    frame
}

/// A frame that was sent, damaged: a checksum will tell if there is one.
pub fn damaged(frame: &Frame, chance: &mut Chance) -> Frame {
    let mut len = frame.len();
    if chance.below(4) == 0 {
        len = chance.below(9);
    }
    let mut damaged = Frame::zeroed(frame.id, len);
    damaged.kind = frame.kind;
    let kept = len.min(frame.len());
    damaged.payload_mut()[..kept].copy_from_slice(&frame.payload()[..kept]);
    for _ in 0..=chance.below(3) {
        if len > 0 {
            damaged.payload_mut()[chance.below(len)] ^= 1 << chance.below(8);
        }
    }
    if chance.below(8) == 0 {
        damaged.kind = any_kind(chance);
    }
    damaged
}

/// A frame that was sent, saying something else, with everything that makes it
/// valid. None where nothing can be made of it.
pub fn forged(profile: &Profile, frame: &Frame, chance: &mut Chance) -> Option<Frame> {
    let first = otherwise(profile, profile.decode(frame).ok()?, chance);
    Some(match profile.decode_other(frame) {
        Some(other) => profile.encode_shared(&Wheels { right: first, left: otherwise(profile, other, chance) }),
        None => profile.encode(&first),
    })
}

fn with_any_contents(id: CanId, chance: &mut Chance) -> Frame {
    let longest = if chance.below(4) == 0 { Frame::CAPACITY } else { 8 };
    let mut frame = Frame::zeroed(id, chance.below(longest + 1));
    frame.payload_mut().iter_mut().for_each(|byte| *byte = chance.below(256) as u8);
    if chance.below(4) == 0 {
        frame.kind = any_kind(chance);
    }
    frame
}

fn any_kind(chance: &mut Chance) -> FrameKind {
    [FrameKind::Classic, FrameKind::Remote, FrameKind::Fd, FrameKind::FdBitRateSwitch][chance.below(4)]
}

/// The same message with other contents; what it does not carry stays away.
fn otherwise(profile: &Profile, message: Message, chance: &mut Chance) -> Message {
    match message {
        Message::Sync { counter } => Message::Sync { counter: count(counter, chance) },
        Message::Command(wheel, command) => Message::Command(wheel, command_of(profile, command, chance)),
        Message::Feedback(wheel, feedback) => Message::Feedback(wheel, feedback_of(profile, feedback, chance)),
        Message::Heartbeat(wheel, heartbeat) => {
            let state = heartbeat.state.and_then(|_| state(profile, chance));
            Message::Heartbeat(wheel, Heartbeat { state: state.or(heartbeat.state), fault: fault(chance) })
        }
        Message::Fault(wheel, _) => Message::Fault(wheel, fault(chance)),
        Message::Poll(..) | Message::Word(..) => message,
    }
}

fn command_of(profile: &Profile, command: Command, chance: &mut Chance) -> Command {
    let torque_nm = if chance.below(2) == 0 { number(command.torque_nm, chance) } else { command.torque_nm };
    let word = if chance.below(2) == 0 { word(profile, chance) } else { command.word };
    Command { torque_nm, word, counter: count(command.counter, chance) }
}

fn feedback_of(profile: &Profile, feedback: Feedback, chance: &mut Chance) -> Feedback {
    let mut other = feedback;
    for _ in 0..=chance.below(2) {
        match chance.below(6) {
            0 => other.position = feedback.position.map(|position| number(position, chance)),
            1 => other.speed_rad_s = feedback.speed_rad_s.map(|speed_rad_s| number(speed_rad_s, chance)),
            2 => other.torque_applied_nm = feedback.torque_applied_nm.map(|torque_nm| number(torque_nm, chance)),
            3 => other.state = feedback.state.and_then(|_| state(profile, chance)).or(feedback.state),
            4 => other.fault = feedback.fault.map(|_| fault(chance)),
            _ => other.counter = feedback.counter.map(|counter| count(counter, chance)),
        }
    }
    other
}

/// Mostly the next one, now and then any.
fn count(counter: u8, chance: &mut Chance) -> u8 {
    let step = if chance.below(4) == 0 { chance.below(256) } else { chance.below(3) };
    counter.wrapping_add(step as u8)
}

/// Near the one there was, or far from all.
fn number(real: f64, chance: &mut Chance) -> f64 {
    let far = [0.0, -1.0, 1e3, -1e6, 1e-300, f64::MAX, f64::MIN, f64::INFINITY, f64::NEG_INFINITY, f64::NAN];
    match chance.below(3) {
        0 => far[chance.below(far.len())],
        1 => real + chance.below(2001) as f64 - 1000.0,
        _ => real + (chance.below(2001) as f64 - 1000.0) * 1e-3,
    }
}

fn state(profile: &Profile, chance: &mut Chance) -> Option<StateId> {
    let meanings = [DriveState::Boot, DriveState::Ready, DriveState::Enabled, DriveState::Fault];
    profile.conversation.state_meaning(meanings[chance.below(4)])
}

fn word(profile: &Profile, chance: &mut Chance) -> Option<WordId> {
    let requests = [Request::Disable, Request::Enable, Request::ClearFault];
    profile.conversation.word_in_command(state(profile, chance)?, requests[chance.below(3)])
}

fn fault(chance: &mut Chance) -> FaultCode {
    let faults = [
        FaultCode::None,
        FaultCode::CommandTimeout,
        FaultCode::OverCurrent,
        FaultCode::EmergencyStop,
        FaultCode::Other,
    ];
    faults[chance.below(faults.len())]
}
