//! Which frames are wanted, in the notation of candump.

use crate::traffic::{Content, ErrorFrame, RecordedFrame};

/// A filter as candump's command line has it: conditions in hexadecimal with
/// commas between, `ID:MASK` for ids that are ID where MASK has ones,
/// `ID~MASK` for those that are not, `#MASK` for classes of error frames, `j`
/// for frames that meet all conditions and not just one.
///
/// An id of eight digits has 29 bits; one of up to three fits ids of both kinds
/// if only MASK does not say otherwise. Without a condition on ids every frame
/// is wanted, and without one on errors every error frame.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Filter {
    ids: Vec<Condition>,
    must_meet_all: bool,
    error_mask: Option<u32>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Condition {
    id: u32,
    mask: u32,
    is_inverted: bool,
}

/// Bit of an id word that says that it has 29 bits, and of one that it is a
/// remote request (`linux/can.h`).
const EXTENDED: u32 = 0x8000_0000;
const REMOTE: u32 = 0x4000_0000;
/// Digits of an id of 29 bits.
const EXTENDED_DIGITS: usize = 8;

impl Filter {
    /// Reads a filter.
    ///
    /// # Errors
    /// The condition that will not do, and what was expected.
    pub fn parse(text: &str) -> Result<Self, String> {
        let mut filter = Self::default();
        for condition in text.split(',').filter(|condition| !condition.is_empty()) {
            filter.add(condition).ok_or_else(|| {
                format!("found {condition:?}, expected ID:MASK, ID~MASK, #ERRORMASK, in hexadecimal, or j")
            })?;
        }
        Ok(filter)
    }

    /// Whether this is wanted.
    pub fn wants(&self, content: &Content) -> bool {
        match content {
            Content::Frame(recorded) => self.wants_frame(recorded),
            Content::Error(ErrorFrame { class, .. }) => self.error_mask.is_none_or(|mask| class & mask != 0),
            Content::Lost(_) => true,
        }
    }

    fn wants_frame(&self, recorded: &RecordedFrame) -> bool {
        if self.ids.is_empty() {
            return true;
        }
        let frame = &recorded.frame;
        let extended = if frame.id.is_extended() { EXTENDED } else { 0 };
        let remote = if frame.kind == crate::frame::FrameKind::Remote { REMOTE } else { 0 };
        let word = frame.id.raw() | extended | remote;
        let meets = |condition: &Condition| condition.is_met_by(word);
        if self.must_meet_all { self.ids.iter().all(meets) } else { self.ids.iter().any(meets) }
    }

    fn add(&mut self, condition: &str) -> Option<()> {
        if condition.eq_ignore_ascii_case("j") {
            self.must_meet_all = true;
            return Some(());
        }
        if let Some(mask) = condition.strip_prefix('#') {
            self.error_mask = Some(hexadecimal(mask)?);
            return Some(());
        }
        let (at, is_inverted) = match (condition.find(':'), condition.find('~')) {
            (Some(at), None) => (at, false),
            (None, Some(at)) => (at, true),
            _ => return None,
        };
        let (id, mask) = (&condition[..at], hexadecimal(&condition[at + 1..])?);
        let extended = if id.len() == EXTENDED_DIGITS { EXTENDED } else { 0 };
        self.ids.push(Condition { id: hexadecimal(id)? | extended, mask, is_inverted });
        Some(())
    }
}

impl Condition {
    /// As the kernel compares (`can_rcv_filter`).
    const fn is_met_by(&self, word: u32) -> bool {
        ((word & self.mask) == (self.id & self.mask)) != self.is_inverted
    }
}

fn hexadecimal(digits: &str) -> Option<u32> {
    let is_plain = !digits.is_empty() && digits.chars().all(|digit| digit.is_ascii_hexdigit());
    if is_plain { u32::from_str_radix(digits, 16).ok() } else { None }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::frame::{CanId, Frame};

    fn wants(filter: &str, id: CanId) -> bool {
        Filter::parse(filter).expect(filter).wants(&Content::Frame(Frame::classic(id, &[]).into()))
    }

    #[test]
    fn ids_are_compared_under_their_mask() {
        let standard = CanId::Standard;
        assert!(wants("", standard(0x123)) && wants("123:7FF", standard(0x123)) && !wants("123:7FF", standard(0x124)));
        assert!(wants("120:7F0,400:7FF", standard(0x12A)) && wants("120:7F0,400:7FF", standard(0x400)));
        assert!(!wants("123~7FF", standard(0x123)) && wants("123~7FF", standard(0x124)));
        assert!(!wants("0~0,#FF", standard(5)), "nothing but errors, as candump's manual has it");
    }

    #[test]
    fn an_id_of_eight_digits_has_29_bits() {
        assert!(
            wants("00000123:9FFFFFFF", CanId::Extended(0x123)) && !wants("00000123:9FFFFFFF", CanId::Standard(0x123))
        );
        assert!(wants("123:1FFFFFFF", CanId::Extended(0x123)), "no mask asks for the kind of the id");
    }

    #[test]
    fn joined_conditions_must_all_be_met() {
        assert!(wants("100:700,105~7FF", CanId::Standard(0x105)));
        assert!(
            !wants("100:700,105~7FF,j", CanId::Standard(0x105)) && wants("100:700,105~7FF,j", CanId::Standard(0x106))
        );
    }

    #[test]
    fn error_frames_are_chosen_by_their_class() {
        let wants = |filter: &str| {
            let error = ErrorFrame { class: 0x40, data: [0; 8] };
            Filter::parse(filter).expect(filter).wants(&Content::Error(error))
        };
        assert!(wants("") && wants("#40") && wants("#FF") && !wants("#4") && wants("123:7FF"));
    }

    #[test]
    fn other_text_is_refused_with_what_was_expected() {
        for text in ["123", "123:", ":7FF", "12G:7FF", "123:7FF~1", "+1:2", "#", "111111111:1"] {
            assert!(Filter::parse(text).expect_err(text).contains("expected ID:MASK"), "{text}");
        }
    }
}
