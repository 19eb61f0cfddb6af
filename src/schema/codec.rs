//! Whole messages: which signals a frame carries, what they say, and the frame
//! that says it. Made ready once, when the DBC is read; nothing here allocates
//! but to tell what is wrong.

use super::dbc::MessageLayout;
use super::encoding::{EncodeError, Encoding, Value, Within};
use super::signal::Signal;
use super::slot::{Head, Slot};
use crate::config::nearest;
use crate::frame::{Frame, FrameKind};

/// What is worked out of a layout beforehand.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Plan {
    /// One for each signal.
    slots: Vec<Slot>,
    /// Indices of the signals, each after the switch that selects it.
    encode_order: Vec<usize>,
}

/// Why a payload does not carry a signal.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Absence {
    /// A multiplexer switch says otherwise.
    NotSelected,
    /// The payload ends before the signal does, or before a switch that it
    /// depends on.
    TooShort,
    /// The signal has more than 64 bits, which make no number.
    TooWide,
}

impl MessageLayout {
    /// Works out what decoding and encoding need.
    pub(super) fn compiled(mut self) -> Self {
        let depth = |index: usize| std::iter::successors(Some(index), |&at| self.switch_of(at)).count();
        let mut encode_order: Vec<usize> = (0..self.signals.len()).collect();
        encode_order.sort_by_key(|&index| depth(index));
        let slots = self.signals.iter().map(Slot::new).collect();
        self.plan = Plan { slots, encode_order };
        self
    }

    /// The signals that `frame` carries, in the order of the DBC, with their
    /// physical values. A remote request carries none.
    ///
    /// Of a frame shorter than the layout, that is the signals wholly inside
    /// it; of multiplexed signals, those that the switches select.
    #[inline]
    pub fn decode<'a>(&'a self, frame: &'a Frame) -> impl Iterator<Item = (&'a Signal, f64)> {
        let len = if frame.kind == FrameKind::Remote { 0 } else { frame.len() };
        self.decoded(frame.storage(), len)
    }

    /// As [`Self::decode`], of a payload of any length.
    #[inline]
    pub fn decode_payload<'a>(&'a self, payload: &'a [u8]) -> impl Iterator<Item = (&'a Signal, f64)> {
        self.decoded(payload, payload.len())
    }

    /// The signals that `frame` carries, in the order of the DBC, each with its
    /// index in [`Self::signals`]; their values are in the frame's storage.
    #[inline]
    pub fn carried<'a>(&'a self, frame: &'a Frame) -> impl Iterator<Item = (usize, &'a Signal)> {
        // A remote request has a length but no data.
        let (data, len) = (frame.storage(), if frame.kind == FrameKind::Remote { 0 } else { frame.len() });
        let all = self.signals.iter().zip(&self.plan.slots).enumerate();
        all.filter(move |(_, (signal, slot))| slot.is_there(len) || self.absence_of(signal, data, len).is_none())
            .map(|(index, (signal, _))| (index, signal))
    }

    /// Why `payload` does not carry `signal`, which is one of this message;
    /// `None` when it does.
    #[inline]
    pub fn absence(&self, signal: &Signal, payload: &[u8]) -> Option<Absence> {
        self.absence_of(signal, payload, payload.len())
    }

    /// The signals that `payload` does not carry, and why.
    pub fn absent<'a>(&'a self, payload: &'a [u8]) -> impl Iterator<Item = (&'a Signal, Absence)> {
        self.signals.iter().filter_map(|signal| Some((signal, self.absence(signal, payload)?)))
    }

    /// The frame that says `values`, pairs of signal names and values: CAN FD
    /// where the DBC says so or more than 8 bytes do not fit otherwise.
    ///
    /// A signal without a value starts as the DBC says (`GenSigStartValue`), or
    /// as raw 0. The values of multiplexer switches decide which multiplexed
    /// signals are in the frame; to give one that is not is an error.
    pub fn encode(&self, values: &[(&str, Value<'_>)], how: Encoding) -> Result<Frame, EncodeError> {
        if self.len > Frame::CAPACITY {
            return Err(self.no_room(Frame::CAPACITY));
        }
        let mut frame = Frame::zeroed(self.id, self.len);
        if self.is_fd {
            frame.kind = FrameKind::Fd;
        }
        self.encode_payload(frame.payload_mut(), values, how)?;
        Ok(frame)
    }

    /// As [`Self::encode`], into a payload of at least the message's length,
    /// all of which is written.
    pub fn encode_payload(
        &self,
        payload: &mut [u8],
        values: &[(&str, Value<'_>)],
        how: Encoding,
    ) -> Result<(), EncodeError> {
        if let Some((name, _)) = values.iter().find(|(name, _)| self.signal(name).is_none()) {
            let names = self.signals.iter().map(|signal| signal.name.as_str());
            return Err(EncodeError::UnknownSignal {
                message: self.name.clone(),
                signal: (*name).to_owned(),
                nearest: nearest(name, names).map(str::to_owned),
            });
        }
        self.encode_each(payload, how, |_, signal| {
            let given = values.iter().find(|(name, _)| *name == signal.name || *name == signal.short_name);
            given.map(|(_, value)| *value)
        })
    }

    /// As [`Self::encode_payload`], with values from a function that is asked
    /// for each signal once, switches first, by its index and itself.
    #[inline]
    pub fn encode_each<'v>(
        &self,
        payload: &mut [u8],
        how: Encoding,
        mut value_of: impl FnMut(usize, &Signal) -> Option<Value<'v>>,
    ) -> Result<(), EncodeError> {
        if payload.len() < self.len {
            return Err(self.no_room(payload.len()));
        }
        payload.fill(0);
        let (is_plain, rounding) = (how.within == Within::Bits, how.rounding.before_cut());
        // The first bytes stay in a register: through memory, every signal
        // would have to wait for the one before it.
        let mut head = Head::default();
        for &index in &self.plan.encode_order {
            let (signal, slot) = (&self.signals[index], &self.plan.slots[index]);
            let value = value_of(index, signal);
            if value.is_none() && slot.starts_at_zero {
                continue;
            }
            if !slot.is_there(payload.len()) {
                head.write(payload);
                match (self.absence(signal, payload), value) {
                    (None, _) => {}
                    (Some(_), None) => continue,
                    (Some(absence), Some(_)) => return Err(self.no_place(signal, absence, payload)),
                }
            }
            match value {
                Some(Value::Physical(physical)) if is_plain && slot.encode(&mut head, physical, rounding) => {}
                value => {
                    head.write(payload);
                    signal.encode_with_care(payload, value, how)?;
                    head = Head::read(payload);
                }
            }
        }
        head.write(payload);
        Ok(())
    }

    /// Signals and values of the first `len` bytes of `data`.
    #[inline]
    fn decoded<'a>(&'a self, data: &'a [u8], len: usize) -> impl Iterator<Item = (&'a Signal, f64)> {
        let all = self.signals.iter().zip(&self.plan.slots);
        all.filter(move |(signal, slot)| slot.is_there(len) || self.absence_of(signal, data, len).is_none())
            .map(|(signal, slot)| (signal, slot.decode(signal, data)))
    }

    #[inline]
    fn absence_of(&self, signal: &Signal, data: &[u8], len: usize) -> Option<Absence> {
        if signal.is_wide() {
            return Some(Absence::TooWide);
        }
        if signal.end_byte() > len {
            return Some(Absence::TooShort);
        }
        let mut next = signal.selector.as_ref();
        while let Some(selector) = next {
            let switch = &self.signals[selector.switch];
            if switch.end_byte() > len {
                return Some(Absence::TooShort);
            }
            let value = switch.decode_bits(data);
            if !selector.values.iter().any(|range| range.contains(&value)) {
                return Some(Absence::NotSelected);
            }
            next = switch.selector.as_ref();
        }
        None
    }

    fn switch_of(&self, index: usize) -> Option<usize> {
        self.signals[index].selector.as_ref().map(|selector| selector.switch)
    }

    #[cold]
    fn no_room(&self, found: usize) -> EncodeError {
        EncodeError::NoRoom { message: self.name.clone(), expected: self.len, found }
    }

    #[cold]
    fn no_place(&self, signal: &Signal, absence: Absence, payload: &[u8]) -> EncodeError {
        let name = signal.name.clone();
        match (absence, &signal.selector) {
            (Absence::NotSelected, Some(selector)) => {
                let switch = &self.signals[selector.switch];
                EncodeError::NotSelected {
                    signal: name,
                    switch: switch.name.clone(),
                    value: switch.decode_bits(payload),
                }
            }
            (Absence::TooWide, _) => EncodeError::TooWide { signal: name, bits: signal.bit_count() },
            _ => EncodeError::NoRoom { message: name, expected: signal.end_byte(), found: payload.len() },
        }
    }
}
