//! The marker that ends a step of a lock-step run, `dbc/sim.dbc`.

use super::dbc::Dbc;
use super::signal::Signal;
use crate::config::Source;
use crate::frame::{CanId, Frame, FrameKind};

/// "The drives have answered; nothing more comes until the next SYNC."
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct StepEnd {
    /// Periods since the first SYNC; wraps at 32 bits.
    pub tick: u32,
    /// The run is over.
    pub last: bool,
}

/// Speaks [`StepEnd`].
#[derive(Clone, Debug)]
pub struct StepEndCodec {
    id: CanId,
    len: usize,
    tick: Signal,
    last: Signal,
}

impl StepEndCodec {
    /// The codec compiled from the DBC that the program brings along.
    pub fn builtin() -> Self {
        let source = Source::new("sim.dbc", include_str!("../../dbc/sim.dbc"));
        let dbc = Dbc::parse(&source).unwrap_or_else(|problems| panic!("sim.dbc is broken:\n{problems}"));
        let message = dbc.message("StepEnd").expect("sim.dbc has StepEnd");
        let signal = |name: &str| message.signal(name).expect("sim.dbc has the signals of StepEnd").clone();
        Self { id: message.id, len: message.len, tick: signal("Tick"), last: signal("Last") }
    }

    /// Its arbitration id.
    pub const fn id(&self) -> CanId {
        self.id
    }

    /// The frame that says so.
    pub fn encode(&self, step_end: StepEnd) -> Frame {
        let mut frame = Frame::zeroed(self.id, self.len);
        self.tick.encode(frame.payload_mut(), f64::from(step_end.tick));
        self.last.encode(frame.payload_mut(), f64::from(u8::from(step_end.last)));
        frame
    }

    /// What a frame says, if it is a marker.
    pub fn decode(&self, frame: &Frame) -> Option<StepEnd> {
        let is_marker = frame.id == self.id && frame.len() == self.len && frame.kind != FrameKind::Remote;
        is_marker.then(|| StepEnd {
            tick: self.tick.decode(frame.storage()) as u32,
            last: self.last.decode(frame.storage()) != 0.0,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_marker_comes_back_as_it_was() {
        let codec = StepEndCodec::builtin();
        for step_end in [StepEnd { tick: 0, last: false }, StepEnd { tick: u32::MAX, last: true }] {
            assert_eq!(codec.decode(&codec.encode(step_end)), Some(step_end));
        }
        assert_eq!(codec.decode(&Frame::zeroed(codec.id(), 8)), None);
    }
}
