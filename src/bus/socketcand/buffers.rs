//! Bytes on their way between a stream and its messages. A stream knows no
//! messages: they arrive in pieces, or several at once.

use std::collections::VecDeque;
use std::io::{ErrorKind, Read, Write};

/// Room for what one read brings.
const READ_BYTES: usize = 16 * 1024;
/// No message that we understand is longer; a longer one without an end is
/// thrown away instead of being waited for.
const LONGEST_MESSAGE: usize = 1024;

/// What has arrived and not been looked at. Never allocates after the start.
pub(super) struct Incoming {
    bytes: Box<[u8]>,
    /// Where what has not been looked at begins.
    start: usize,
    /// Where it ends.
    end: usize,
    /// How often there was text between messages that belonged to none.
    junk: u64,
    /// Whether there has been such text since the last message.
    in_junk: bool,
}

/// What waits to be sent, up to a limit.
pub(super) struct Outgoing {
    bytes: VecDeque<u8>,
    limit_bytes: usize,
}

impl Incoming {
    pub fn new() -> Self {
        Self { bytes: vec![0; READ_BYTES].into(), start: 0, end: 0, junk: 0, in_junk: false }
    }

    /// Reads once. `Ok(0)` means the end of the stream. To be called when
    /// [`Self::next_message`] has no more, so that there is room.
    pub fn read_from(&mut self, source: &mut impl Read) -> std::io::Result<usize> {
        self.bytes.copy_within(self.start..self.end, 0);
        (self.start, self.end) = (0, self.end - self.start);
        let count = source.read(&mut self.bytes[self.end..])?;
        self.end += count;
        Ok(count)
    }

    /// The next whole message, without its angle brackets. Text outside of
    /// brackets is skipped, and so is a message that another one interrupts.
    pub fn next_message(&mut self) -> Option<&[u8]> {
        loop {
            let unread = &self.bytes[self.start..self.end];
            let Some(close) = unread.iter().position(|&byte| byte == b'>') else {
                self.keep_unfinished();
                return None;
            };
            let open = unread[..close].iter().rposition(|&byte| byte == b'<');
            let (from, to) = (self.start, self.start + close);
            self.start = to + 1;
            self.note_junk(from, open.map_or(to + 1, |open| from + open));
            if let Some(open) = open {
                self.in_junk = false;
                return Some(&self.bytes[from + open + 1..to]);
            }
        }
    }

    /// What has come and is no whole message yet.
    pub fn unfinished(&self) -> &[u8] {
        &self.bytes[self.start..self.end]
    }

    /// How often there was text between messages that belonged to none.
    pub fn junk(&self) -> u64 {
        self.junk
    }

    /// Drops what cannot become a message.
    fn keep_unfinished(&mut self) {
        let unread = &self.bytes[self.start..self.end];
        let open = unread.iter().rposition(|&byte| byte == b'<');
        let open = open.filter(|open| unread.len() - open <= LONGEST_MESSAGE).unwrap_or(unread.len());
        let from = self.start;
        self.start += open;
        self.note_junk(from, self.start);
    }

    fn note_junk(&mut self, from: usize, to: usize) {
        if !self.bytes[from..to].trim_ascii().is_empty() {
            // However many pieces it comes in.
            self.junk += u64::from(!self.in_junk);
            self.in_junk = true;
        }
    }
}

impl Outgoing {
    /// With all its room from the start.
    pub fn with_room(limit_bytes: usize) -> Self {
        Self { bytes: VecDeque::with_capacity(limit_bytes), limit_bytes }
    }

    /// Takes room when it is needed.
    pub fn growing(limit_bytes: usize) -> Self {
        Self { bytes: VecDeque::new(), limit_bytes }
    }

    /// Takes all of `text` or, when there is no room, nothing.
    pub fn push(&mut self, text: &[u8]) -> bool {
        let fits = self.bytes.len() + text.len() <= self.limit_bytes;
        if fits {
            self.bytes.extend(text);
        }
        fits
    }

    pub fn is_empty(&self) -> bool {
        self.bytes.is_empty()
    }

    /// Writes as much as goes without waiting.
    pub fn flush_to(&mut self, sink: &mut impl Write) -> std::io::Result<()> {
        while !self.bytes.is_empty() {
            match sink.write(self.bytes.as_slices().0) {
                Ok(0) => return Err(ErrorKind::WriteZero.into()),
                Ok(count) => drop(self.bytes.drain(..count)),
                Err(error) if error.kind() == ErrorKind::WouldBlock => return Ok(()),
                Err(error) if error.kind() == ErrorKind::Interrupted => {}
                Err(error) => return Err(error),
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Feeds `text` in pieces of `size` bytes and collects the messages.
    fn messages(text: &[u8], size: usize) -> (Vec<Vec<u8>>, u64) {
        let mut incoming = Incoming::new();
        let mut found = Vec::new();
        for mut piece in text.chunks(size) {
            while !piece.is_empty() {
                incoming.read_from(&mut piece).unwrap();
                while let Some(message) = incoming.next_message() {
                    found.push(message.to_vec());
                }
            }
        }
        (found, incoming.junk())
    }

    #[test]
    fn messages_come_out_whole_however_they_are_cut() {
        let text = b"< hi >< ok >\n < frame 123 1.0 11 >< send 1 0 >";
        for size in 1..=text.len() {
            let (found, junk) = messages(text, size);
            assert_eq!(found, [&b" hi "[..], b" ok ", b" frame 123 1.0 11 ", b" send 1 0 "], "pieces of {size}");
            assert_eq!(junk, 0);
        }
    }

    #[test]
    fn text_between_messages_is_skipped_and_counted() {
        for size in [1, 2, 5, 1000] {
            let (found, junk) = messages(b"HTTP/1.1 400 Bad > < fra< ok > < hi >junk< hi >", size);
            assert_eq!(found, [b" ok ", b" hi ", b" hi "], "pieces of {size}");
            assert_eq!(junk, 2, "pieces of {size}");
        }
    }

    #[test]
    fn a_message_without_end_is_not_waited_for() {
        let endless = [b"<".as_slice(), &[b'x'; 5 * READ_BYTES], b"< ok >"].concat();
        for size in [1, 100, 100_000] {
            let (found, junk) = messages(&endless, size);
            assert_eq!(found, [b" ok "]);
            assert!(junk > 0);
        }
    }

    #[test]
    fn a_full_queue_takes_whole_messages_or_nothing() {
        let mut outgoing = Outgoing::with_room(10);
        assert!(outgoing.push(b"< ok >"));
        assert!(!outgoing.push(b"< hi >"));
        let mut sink = Vec::new();
        outgoing.flush_to(&mut sink).unwrap();
        assert_eq!(sink, b"< ok >");
        assert!(outgoing.is_empty() && outgoing.push(b"< hi >"));
    }
}
