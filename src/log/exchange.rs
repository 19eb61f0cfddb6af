//! `canloop.Exchange`: what went into a stack and came out of it, as protobuf.

use prost_types::field_descriptor_proto::Type;

use super::protobuf::{Value, put_bytes, put_fixed, put_unsigned, read_fields};
use crate::exchange::Exchange;
use crate::frame::{CanId, Frame, FrameKind};
use crate::safety::{Operator, Reason};
use crate::time::Instant;

/// Its fields, in the order of [`put_exchange`]. `what` says which of the others
/// there are.
pub(super) const EXCHANGE_FIELDS: [(&str, Type); 8] = [
    ("what", Type::String),
    ("at_ns", Type::Sfixed64),
    ("id", Type::Uint32),
    ("is_extended", Type::Bool),
    ("kind", Type::Uint32),
    ("data", Type::Bytes),
    ("which", Type::String),
    ("event", Type::Uint32),
];

/// A frame's kind is its index here.
const KINDS: [FrameKind; 4] = [FrameKind::Classic, FrameKind::Remote, FrameKind::Fd, FrameKind::FdBitRateSwitch];

/// Appends an exchange.
pub(super) fn put_exchange(out: &mut Vec<u8>, exchange: &Exchange) {
    put_bytes(out, 1, exchange.word().as_bytes());
    match exchange {
        Exchange::Begin(at) | Exchange::Wakeup(at) => put_fixed(out, 2, at.as_nanos()),
        Exchange::Frame(at, frame) => {
            put_fixed(out, 2, at.as_nanos());
            put_frame(out, frame);
        }
        Exchange::Sent(frame) => put_frame(out, frame),
        Exchange::Operate(wish) => put_bytes(out, 7, wish.name().as_bytes()),
        Exchange::Trip(reason) => put_bytes(out, 7, reason.name().as_bytes()),
        Exchange::Follow(event) => put_unsigned(out, 8, u64::from(*event)),
        Exchange::Farewell => {}
    }
}

fn put_frame(out: &mut Vec<u8>, frame: &Frame) {
    put_unsigned(out, 3, u64::from(frame.id.raw()));
    put_unsigned(out, 4, u64::from(frame.id.is_extended()));
    put_unsigned(out, 5, KINDS.iter().position(|&kind| kind == frame.kind).unwrap_or(0) as u64);
    put_bytes(out, 6, frame.payload());
}

/// The exchange that a message of `/canloop/exchange` holds.
///
/// # Errors
/// What is wrong with it.
pub fn exchange_from(message: &[u8]) -> Result<Exchange, String> {
    let mut fields = Fields::default();
    read_fields(message, |number, value| match (number, value) {
        (1, Value::Bytes(what)) => fields.what = what,
        (2, Value::Fixed(at_ns)) => fields.at_ns = at_ns.cast_signed(),
        (3, Value::Number(id)) => fields.id = u32::try_from(id).unwrap_or(u32::MAX),
        (4, Value::Number(is_extended)) => fields.is_extended = is_extended != 0,
        (5, Value::Number(kind)) => fields.kind = usize::try_from(kind).unwrap_or(usize::MAX),
        (6, Value::Bytes(data)) => fields.data = data,
        (7, Value::Bytes(which)) => fields.which = which,
        (8, Value::Number(event)) => fields.event = event as u16,
        _ => {}
    })?;
    fields.exchange()
}

#[derive(Default)]
struct Fields<'m> {
    what: &'m [u8],
    at_ns: i64,
    id: u32,
    is_extended: bool,
    kind: usize,
    data: &'m [u8],
    which: &'m [u8],
    event: u16,
}

impl Fields<'_> {
    fn exchange(&self) -> Result<Exchange, String> {
        let at = Instant::from_nanos(self.at_ns);
        let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
        let unknown = |expected: &str| format!("found {:?}, expected {expected}", text(self.which));
        match self.what {
            b"begin" => Ok(Exchange::Begin(at)),
            b"frame" => Ok(Exchange::Frame(at, self.frame()?)),
            b"wakeup" => Ok(Exchange::Wakeup(at)),
            b"sent" => Ok(Exchange::Sent(self.frame()?)),
            b"farewell" => Ok(Exchange::Farewell),
            b"follow" => Ok(Exchange::Follow(self.event)),
            b"operate" => {
                let wish = Operator::ALL.into_iter().find(|wish| wish.name().as_bytes() == self.which);
                wish.map(Exchange::Operate).ok_or_else(|| unknown("what an operator can want"))
            }
            b"trip" => {
                let reason = Reason::ALL.into_iter().find(|reason| reason.name().as_bytes() == self.which);
                reason.map(Exchange::Trip).ok_or_else(|| unknown("a reason to trip"))
            }
            other => Err(format!("found {:?}, expected what goes into a stack or comes out of it", text(other))),
        }
    }

    fn frame(&self) -> Result<Frame, String> {
        let kind = KINDS.get(self.kind).copied();
        let kind = kind.ok_or_else(|| format!("found a frame of kind {}, expected 0 to 3", self.kind))?;
        let most = if matches!(kind, FrameKind::Fd | FrameKind::FdBitRateSwitch) { Frame::CAPACITY } else { 8 };
        if self.data.len() > most {
            return Err(format!("found a frame of {} bytes, expected up to {most}", self.data.len()));
        }
        let id = match (self.is_extended, u16::try_from(self.id)) {
            (true, _) if self.id < 1 << 29 => CanId::Extended(self.id),
            (false, Ok(id)) if id < 1 << 11 => CanId::Standard(id),
            _ => return Err(format!("found the arbitration id {:#x}, which is too large", self.id)),
        };
        let mut frame = Frame::zeroed(id, self.data.len());
        frame.payload_mut().copy_from_slice(self.data);
        frame.kind = kind;
        Ok(frame)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn any_frame() -> impl Strategy<Value = Frame> {
        let id = prop_oneof![(0_u16..1 << 11).prop_map(CanId::Standard), (0_u32..1 << 29).prop_map(CanId::Extended)];
        (id, 0..KINDS.len(), prop::collection::vec(any::<u8>(), 0..=8)).prop_map(|(id, kind, data)| {
            let mut frame = Frame::classic(id, &data);
            frame.kind = KINDS[kind];
            frame
        })
    }

    fn any_exchange() -> impl Strategy<Value = Exchange> {
        let instant = || any::<i64>().prop_map(Instant::from_nanos);
        prop_oneof![
            instant().prop_map(Exchange::Begin),
            instant().prop_map(Exchange::Wakeup),
            (instant(), any_frame()).prop_map(|(at, frame)| Exchange::Frame(at, frame)),
            any_frame().prop_map(Exchange::Sent),
            any::<u16>().prop_map(Exchange::Follow),
            prop::sample::select(Operator::ALL.to_vec()).prop_map(Exchange::Operate),
            prop::sample::select(Reason::ALL.to_vec()).prop_map(Exchange::Trip),
            Just(Exchange::Farewell),
        ]
    }

    proptest! {
        #[test]
        fn what_is_written_is_read_again(exchange in any_exchange()) {
            let mut message = Vec::new();
            put_exchange(&mut message, &exchange);
            prop_assert_eq!(exchange_from(&message), Ok(exchange));
        }

        #[test]
        fn bytes_of_any_kind_are_read_or_refused(message in prop::collection::vec(any::<u8>(), 0..60)) {
            let _ = exchange_from(&message);
        }
    }
}
