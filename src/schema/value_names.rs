//! A value table's numbers and what they mean to us.

use super::signal::{Raw, Signal};

/// Which raw value of a signal stands for which meaning.
#[derive(Clone, Debug)]
pub(super) struct ValueNames<T> {
    /// A handful: looking through them is faster than any index.
    entries: Vec<(i64, T)>,
}

impl<T: Copy + PartialEq> ValueNames<T> {
    /// Joins raw values with their meanings.
    pub const fn new(entries: Vec<(i64, T)>) -> Self {
        Self { entries }
    }

    /// Writes the raw value of `meaning` into `data`.
    #[inline]
    pub fn encode(&self, signal: &Signal, data: &mut [u8], meaning: T) {
        let entry = self.entries.iter().find(|(_, known)| *known == meaning);
        let (raw, _) = entry.expect("a profile is loaded only when all meanings have a raw value");
        signal.encode_raw(data, Raw::Signed(*raw));
    }

    /// The meaning of the raw value in `data`; if it has none, that value.
    #[inline]
    pub fn decode(&self, signal: &Signal, data: &[u8; 64]) -> Result<T, i64> {
        let found = whole_number(signal.decode_raw(data));
        self.entries.iter().find(|(raw, _)| *raw == found).map(|(_, meaning)| *meaning).ok_or(found)
    }
}

const fn whole_number(raw: Raw) -> i64 {
    match raw {
        Raw::Unsigned(raw) => raw as i64,
        Raw::Signed(raw) => raw,
        Raw::Real(raw) => raw as i64,
    }
}
