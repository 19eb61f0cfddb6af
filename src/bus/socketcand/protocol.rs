//! The messages of the protocol, read and written: pure functions of bytes.
//!
//! A message is what stands between `<` and `>`; here it comes and goes
//! without them on the way in ([`parse_command`], [`parse_reply`]) and with
//! them on the way out ([`write_command`], [`write_reply`]).

use crate::frame::{CanId, Frame, FrameKind};
use crate::time::Instant;

/// The flag of a CAN FD frame that switches to the data rate, as Linux has it
/// (`CANFD_BRS`).
const BIT_RATE_SWITCH: u32 = 0x01;

/// What a client says.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Command<'a> {
    /// Chooses the bus by its name.
    Open(&'a [u8]),
    /// Asks for every frame of the bus.
    RawMode,
    /// Goes back to the mode in which frames come only by subscription.
    BcmMode,
    /// Asks for the same message back.
    Echo,
    /// Sends a frame.
    Send(Frame),
    /// Something that is not needed to exchange frames.
    Other,
}

/// What a server says.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Reply<'a> {
    /// The greeting.
    Hi,
    /// The last command was carried out.
    Ok,
    /// The answer to an echo.
    Echo,
    /// A frame that somebody else sent, and the server's stamp in Unix time.
    Frame(Instant, Frame),
    /// An error frame: its class bits as Linux numbers them
    /// (`linux/can/error.h`).
    ErrorFrame(u32),
    /// A command was refused, with the server's words.
    Refused(&'a [u8]),
    /// Something that is not needed to exchange frames.
    Other,
}

/// A message on its way out: text of bounded length, on the stack.
#[derive(Clone, Copy, Debug)]
pub struct Text {
    bytes: [u8; Self::CAPACITY],
    len: usize,
}

/// Reads a client's message, without its angle brackets. `None` when the
/// command is known but not what follows it.
///
/// As lenient as the original in what is harmless: any white space, hexadecimal
/// digits of either case, bytes with or without leading zero.
pub fn parse_command(message: &[u8]) -> Option<Command<'_>> {
    let mut words = words(message);
    let command = match words.next().unwrap_or(b"") {
        b"open" => Command::Open(words.next()?),
        b"rawmode" => Command::RawMode,
        b"bcmmode" => Command::BcmMode,
        b"echo" => Command::Echo,
        b"send" => Command::Send(parse_send(words, FrameKind::Classic)?),
        b"sendrtr" => Command::Send(parse_send(words, FrameKind::Remote)?),
        b"fdsend" => Command::Send(parse_send(words, FrameKind::Fd)?),
        _ => Command::Other,
    };
    Some(command)
}

/// Reads a server's message, without its angle brackets. `None` when the kind
/// of message is known but not what follows it.
pub fn parse_reply(message: &[u8]) -> Option<Reply<'_>> {
    let message = message.trim_ascii();
    let mut words = words(message);
    let reply = match words.next().unwrap_or(b"") {
        b"hi" => Reply::Hi,
        b"ok" => Reply::Ok,
        b"echo" => Reply::Echo,
        b"frame" => parse_frame(words, FrameKind::Classic)?,
        b"rtr" => parse_frame(words, FrameKind::Remote)?,
        b"fdframe" => parse_frame(words, FrameKind::Fd)?,
        b"error" => parse_error(&message[b"error".len()..]),
        _ => Reply::Other,
    };
    Some(reply)
}

/// The command that sends `frame`.
pub fn write_command(frame: &Frame) -> Text {
    let mut text = Text::new();
    text.push(match frame.kind {
        FrameKind::Classic => b"< send ",
        FrameKind::Remote => b"< sendrtr ",
        FrameKind::Fd | FrameKind::FdBitRateSwitch => b"< fdsend ",
    });
    text.push_id(frame.id);
    text.push_flags(frame.kind);
    text.push_decimal(frame.len() as u64, 1);
    text.push(b" ");
    if frame.kind != FrameKind::Remote {
        for &byte in frame.payload() {
            text.push_byte(byte);
            text.push(b" ");
        }
    }
    text.push(b">");
    text
}

/// The message by which a server passes on a `frame` that it accepted at `at`
/// (Unix time).
///
/// A frame without data leaves two blanks before the bracket, as the original
/// does: python-can counts on it.
pub fn write_reply(at: Instant, frame: &Frame) -> Text {
    let mut text = Text::new();
    text.push(match frame.kind {
        FrameKind::Classic => b"< frame ",
        FrameKind::Remote => b"< rtr ",
        FrameKind::Fd | FrameKind::FdBitRateSwitch => b"< fdframe ",
    });
    text.push_id(frame.id);
    text.push_flags(frame.kind);
    let micros = at.as_nanos().max(0).unsigned_abs() / 1_000;
    text.push_decimal(micros / 1_000_000, 1);
    text.push(b".");
    text.push_decimal(micros % 1_000_000, 6);
    text.push(b" ");
    if frame.kind == FrameKind::Remote {
        text.push_decimal(frame.len() as u64, 1);
    } else {
        frame.payload().iter().for_each(|&byte| text.push_byte(byte));
    }
    text.push(b" >");
    text
}

impl Text {
    /// Holds the longest message, a CAN FD frame with 64 bytes each followed
    /// by a blank: 24 + 64 x 3 + 1.
    const CAPACITY: usize = 224;

    const fn new() -> Self {
        Self { bytes: [0; Self::CAPACITY], len: 0 }
    }

    /// The message, brackets and all.
    pub fn as_bytes(&self) -> &[u8] {
        &self.bytes[..self.len]
    }

    fn push(&mut self, text: &[u8]) {
        self.bytes[self.len..][..text.len()].copy_from_slice(text);
        self.len += text.len();
    }

    fn push_id(&mut self, id: CanId) {
        let digits = if id.is_extended() { 8 } else { 3 };
        for digit in (0..digits).rev() {
            self.push(&[hex_digit(id.raw() >> (4 * digit))]);
        }
        self.push(b" ");
    }

    fn push_flags(&mut self, kind: FrameKind) {
        match kind {
            FrameKind::Classic | FrameKind::Remote => {}
            FrameKind::Fd => self.push(b"00 "),
            FrameKind::FdBitRateSwitch => self.push(b"01 "),
        }
    }

    fn push_byte(&mut self, byte: u8) {
        self.push(&[hex_digit(u32::from(byte) >> 4), hex_digit(u32::from(byte))]);
    }

    fn push_decimal(&mut self, mut number: u64, least_digits: usize) {
        let mut digits = [b'0'; 20];
        let mut first = digits.len();
        while number > 0 || digits.len() - first < least_digits {
            first -= 1;
            digits[first] = b'0' + (number % 10) as u8;
            number /= 10;
        }
        self.push(&digits[first..]);
    }
}

fn words(message: &[u8]) -> impl Iterator<Item = &[u8]> {
    message.split(u8::is_ascii_whitespace).filter(|word| !word.is_empty())
}

/// `ID LEN BYTE...`, for CAN FD `ID FLAGS LEN BYTE...`.
fn parse_send<'a>(mut words: impl Iterator<Item = &'a [u8]>, kind: FrameKind) -> Option<Frame> {
    let id = parse_id(words.next()?)?;
    let kind = parse_flags(&mut words, kind)?;
    let len = parse_decimal(words.next()?)?;
    let data = Data::parse(words)?;
    match kind {
        FrameKind::Remote => (data.len == 0).then(|| remote(id, len))?,
        _ => (data.len == len).then(|| data.into_frame(id, kind))?,
    }
}

/// `ID STAMP BYTES`, for CAN FD `ID FLAGS STAMP BYTES`, for remote requests
/// `ID STAMP LEN`.
fn parse_frame<'a>(mut words: impl Iterator<Item = &'a [u8]>, kind: FrameKind) -> Option<Reply<'a>> {
    let id = parse_id(words.next()?)?;
    let kind = parse_flags(&mut words, kind)?;
    let at = parse_stamp(words.next()?)?;
    let frame = match kind {
        FrameKind::Remote => remote(id, parse_decimal(words.next()?)?),
        _ => Data::parse(words)?.into_frame(id, kind),
    }?;
    Some(Reply::Frame(at, frame))
}

/// `CLASS STAMP` is an error frame, anything else a refusal in words.
fn parse_error(rest: &[u8]) -> Reply<'_> {
    let mut words = words(rest);
    let class = words.next().and_then(parse_hex);
    let stamp = words.next().and_then(parse_stamp);
    match (class, stamp, words.next()) {
        (Some(class), Some(_), None) => Reply::ErrorFrame(class),
        _ => Reply::Refused(rest.trim_ascii()),
    }
}

/// Eight digits make an extended id, as the original tells them apart; a
/// shorter number that needs more than 11 bits can be nothing else.
fn parse_id(word: &[u8]) -> Option<CanId> {
    let raw = parse_hex(word)?;
    match u16::try_from(raw) {
        Ok(id @ 0..=0x7FF) if word.len() < 8 => Some(CanId::Standard(id)),
        _ => (raw <= 0x1FFF_FFFF).then_some(CanId::Extended(raw)),
    }
}

fn parse_flags<'a>(words: &mut impl Iterator<Item = &'a [u8]>, kind: FrameKind) -> Option<FrameKind> {
    if kind != FrameKind::Fd {
        return Some(kind);
    }
    let flags = parse_hex(words.next()?)?;
    Some(if flags & BIT_RATE_SWITCH == 0 { FrameKind::Fd } else { FrameKind::FdBitRateSwitch })
}

/// `SECONDS.FRACTION`; digits past the nanosecond are dropped.
fn parse_stamp(word: &[u8]) -> Option<Instant> {
    let point = word.iter().position(|&byte| byte == b'.').unwrap_or(word.len());
    let seconds = i64::try_from(parse_decimal(&word[..point])?).ok()?;
    let fraction = word.get(point + 1..).unwrap_or(b"");
    let mut nanos = 0;
    for at in 0..9 {
        let digit =
            fraction.get(at).map_or(Some(0), |&digit| digit.is_ascii_digit().then(|| i64::from(digit - b'0')))?;
        nanos = nanos * 10 + digit;
    }
    Some(Instant::from_nanos(seconds.checked_mul(1_000_000_000)?.checked_add(nanos)?))
}

fn parse_decimal(word: &[u8]) -> Option<usize> {
    let number = word.iter().try_fold(0_usize, |number, &digit| {
        let digit = digit.is_ascii_digit().then(|| usize::from(digit - b'0'))?;
        number.checked_mul(10)?.checked_add(digit)
    })?;
    (!word.is_empty()).then_some(number)
}

fn parse_hex(word: &[u8]) -> Option<u32> {
    if word.is_empty() || word.len() > 8 {
        return None;
    }
    word.iter().try_fold(0, |number, &digit| Some(number << 4 | u32::from(nibble(digit)?)))
}

fn nibble(digit: u8) -> Option<u8> {
    match digit {
        b'0'..=b'9' => Some(digit - b'0'),
        b'a'..=b'f' => Some(digit - b'a' + 10),
        b'A'..=b'F' => Some(digit - b'A' + 10),
        _ => None,
    }
}

fn hex_digit(nibble: u32) -> u8 {
    b"0123456789ABCDEF"[(nibble & 0xF) as usize]
}

fn remote(id: CanId, len: usize) -> Option<Frame> {
    (len <= 8).then(|| zeroed(id, FrameKind::Remote, len))
}

fn zeroed(id: CanId, kind: FrameKind, len: usize) -> Frame {
    let mut frame = Frame::zeroed(id, len);
    frame.kind = kind;
    frame
}

/// The bytes of a frame while they are read.
struct Data {
    bytes: [u8; Frame::CAPACITY],
    len: usize,
}

impl Data {
    /// Bytes one a word, or all in one word of two digits each: clients write
    /// the one, servers the other.
    fn parse<'a>(words: impl Iterator<Item = &'a [u8]>) -> Option<Self> {
        let mut data = Self { bytes: [0; Frame::CAPACITY], len: 0 };
        for word in words {
            match *word {
                [digit] => data.push(nibble(digit)?)?,
                _ if word.len() % 2 == 1 => return None,
                _ => {
                    for pair in word.chunks_exact(2) {
                        data.push(nibble(pair[0])? << 4 | nibble(pair[1])?)?;
                    }
                }
            }
        }
        Some(data)
    }

    fn push(&mut self, byte: u8) -> Option<()> {
        *self.bytes.get_mut(self.len)? = byte;
        self.len += 1;
        Some(())
    }

    /// `None` when a classic frame has more than 8 bytes.
    fn into_frame(self, id: CanId, kind: FrameKind) -> Option<Frame> {
        if kind == FrameKind::Classic && self.len > 8 {
            return None;
        }
        let mut frame = zeroed(id, kind, self.len);
        frame.payload_mut().copy_from_slice(&self.bytes[..self.len]);
        Some(frame)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const STANDARD: CanId = CanId::Standard(0x123);
    const EXTENDED: CanId = CanId::Extended(0x1AA_AAAA);

    fn fd(id: CanId, kind: FrameKind, payload: &[u8]) -> Frame {
        let mut frame = zeroed(id, kind, payload.len());
        frame.payload_mut().copy_from_slice(payload);
        frame
    }

    fn sent(message: &[u8]) -> Option<Frame> {
        match parse_command(message) {
            Some(Command::Send(frame)) => Some(frame),
            _ => None,
        }
    }

    fn passed_on(message: &[u8]) -> Option<(i64, Frame)> {
        match parse_reply(message) {
            Some(Reply::Frame(at, frame)) => Some((at.as_nanos(), frame)),
            _ => None,
        }
    }

    #[test]
    fn commands_are_read_as_the_protocol_document_writes_them() {
        assert_eq!(parse_command(b" open can0 "), Some(Command::Open(b"can0")));
        assert_eq!(parse_command(b" rawmode "), Some(Command::RawMode));
        assert_eq!(parse_command(b" echo "), Some(Command::Echo));
        assert_eq!(sent(b" send 123 0 "), Some(Frame::classic(STANDARD, &[])));
        let extended = CanId::Extended(0x1AAA_AAAA);
        assert_eq!(sent(b" send 1AAAAAAA 2 1 F1 "), Some(Frame::classic(extended, &[0x01, 0xF1])));
        assert_eq!(sent(b" sendrtr 1AAAAAAA 2 "), remote(extended, 2));
        assert_eq!(parse_command(b" subscribe 0 0 123 "), Some(Command::Other));
    }

    #[test]
    fn frames_are_read_as_the_original_and_its_document_write_them() {
        let frame = Frame::classic(STANDARD, &[0x11, 0x22, 0x33, 0x44]);
        assert_eq!(passed_on(b" frame 123 23.424242 11 22 33 44 "), Some((23_424_242_000, frame)));
        assert_eq!(passed_on(b" frame 123 23.424242 11223344 "), Some((23_424_242_000, frame)));
        assert_eq!(passed_on(b" frame 123 0.5  "), Some((500_000_000, Frame::classic(STANDARD, &[]))));
        assert_eq!(passed_on(b" rtr 123 23.424242 4 "), Some((23_424_242_000, remote(STANDARD, 4).unwrap())));
        let switched = fd(STANDARD, FrameKind::FdBitRateSwitch, &[7; 12]);
        assert_eq!(passed_on(b" fdframe 123 05 1.0 070707070707070707070707 "), Some((1_000_000_000, switched)));
    }

    #[test]
    fn the_width_of_an_id_tells_standard_from_extended() {
        assert_eq!(parse_id(b"001"), Some(CanId::Standard(1)));
        assert_eq!(parse_id(b"7ff"), Some(CanId::Standard(0x7FF)));
        assert_eq!(parse_id(b"00000001"), Some(CanId::Extended(1)));
        assert_eq!(parse_id(b"800"), Some(CanId::Extended(0x800)));
        assert_eq!(parse_id(b"20000000"), None);
        assert_eq!(parse_id(b"000000001"), None);
        assert_eq!(parse_id(b""), None);
    }

    #[test]
    fn an_error_frame_is_told_from_a_refusal() {
        assert_eq!(parse_reply(b" error 040 12.000001 "), Some(Reply::ErrorFrame(0x40)));
        assert_eq!(parse_reply(b" error unknown command "), Some(Reply::Refused(b"unknown command")));
        assert_eq!(parse_reply(b" error "), Some(Reply::Refused(b"")));
    }

    #[test]
    fn lengths_and_bytes_that_do_not_fit_are_refused() {
        for wrong in [
            "send 123 3 11 22",
            "send 123 1 11 22",
            "send 123 9 1 2 3 4 5 6 7 8 9",
            "send 123 1 1G",
            "send 123 1 111",
            "send 123",
            "send",
            "send -1 0",
            "sendrtr 123 9",
            "sendrtr 123 1 11",
            "fdsend 123 0 65",
            "open",
        ] {
            assert_eq!(parse_command(wrong.as_bytes()), None, "{wrong}");
        }
        for wrong in
            ["frame 123", "frame 123 x 11", "frame 123 1.0 112", "frame 123 1.0 112233445566778899", "rtr 1 1.0"]
        {
            assert_eq!(parse_reply(wrong.as_bytes()), None, "{wrong}");
        }
        assert_eq!(parse_reply(b"frame 123 99999999999999999999.0 11"), None);
        assert_eq!(parse_command(&[b"fdsend 123 0 65".as_slice(), &b" 11".repeat(65)].concat()), None);
    }

    #[test]
    fn messages_are_written_as_the_original_writes_them() {
        let at = Instant::from_nanos(23_000_042_999);
        let text = |text: Text| String::from_utf8(text.as_bytes().to_vec()).unwrap();
        let frame = Frame::classic(EXTENDED, &[0x01, 0xF1]);
        assert_eq!(text(write_command(&frame)), "< send 01AAAAAA 2 01 F1 >");
        assert_eq!(text(write_reply(at, &frame)), "< frame 01AAAAAA 23.000042 01F1 >");
        assert_eq!(text(write_command(&Frame::classic(CanId::Standard(1), &[]))), "< send 001 0 >");
        assert_eq!(text(write_reply(at, &Frame::classic(CanId::Standard(1), &[]))), "< frame 001 23.000042  >");
        assert_eq!(text(write_reply(at, &remote(STANDARD, 4).unwrap())), "< rtr 123 23.000042 4 >");
        assert_eq!(text(write_command(&fd(STANDARD, FrameKind::Fd, &[1]))), "< fdsend 123 00 1 01 >");
        let switched = fd(STANDARD, FrameKind::FdBitRateSwitch, &[1]);
        assert_eq!(text(write_reply(at, &switched)), "< fdframe 123 01 23.000042 01 >");
        assert!(text(write_reply(Instant::from_nanos(-1), &frame)).contains(" 0.000000 "));
    }

    fn any_frame() -> impl Strategy<Value = Frame> {
        let id =
            prop_oneof![(0..=0x7FF_u16).prop_map(CanId::Standard), (0..=0x1FFF_FFFF_u32).prop_map(CanId::Extended)];
        let classic = prop::collection::vec(any::<u8>(), 0..=8).prop_map(|data| (FrameKind::Classic, data));
        let request = (0..=8_usize).prop_map(|len| (FrameKind::Remote, vec![0; len]));
        let kind = prop_oneof![Just(FrameKind::Fd), Just(FrameKind::FdBitRateSwitch)];
        let long = (kind, prop::collection::vec(any::<u8>(), 0..=64));
        (id, prop_oneof![classic, request, long]).prop_map(|(id, (kind, data))| fd(id, kind, &data))
    }

    fn inside(text: &Text) -> &[u8] {
        text.as_bytes().strip_prefix(b"<").unwrap().strip_suffix(b">").unwrap()
    }

    proptest! {
        #[test]
        fn a_frame_comes_back_from_its_text(frame in any_frame(), micros in 0..i64::MAX / 1_000) {
            prop_assert_eq!(sent(inside(&write_command(&frame))), Some(frame));
            let at = Instant::from_nanos(micros * 1_000);
            prop_assert_eq!(passed_on(inside(&write_reply(at, &frame))), Some((micros * 1_000, frame)));
        }

        #[test]
        fn no_text_makes_a_parser_panic(
            text in prop_oneof![
                prop::collection::vec(any::<u8>(), 0..300),
                "(send|sendrtr|fdsend|frame|fdframe|rtr|error)( [0-9A-Fa-f.x-]{0,12}){0,70}".prop_map(String::into_bytes),
            ]
        ) {
            let _ = (parse_command(&text), parse_reply(&text));
        }
    }
}
