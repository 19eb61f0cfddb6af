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
    /// The stack's controller is off the simulated bus.
    pub bus_off: bool,
}

/// Speaks [`StepEnd`].
#[derive(Clone, Debug)]
pub struct StepEndCodec {
    id: CanId,
    len: usize,
    tick: Signal,
    last: Signal,
    bus_off: Signal,
}

impl StepEndCodec {
    /// The codec compiled from the DBC that the program brings along.
    pub fn builtin() -> Self {
        let source = Source::new("sim.dbc", include_str!("../../dbc/sim.dbc"));
        let dbc = Dbc::parse(&source).unwrap_or_else(|problems| panic!("sim.dbc is broken:\n{problems}"));
        let message = dbc.message("StepEnd").expect("sim.dbc has StepEnd");
        let signal = |name: &str| message.signal(name).expect("sim.dbc has the signals of StepEnd").clone();
        let (tick, last, bus_off) = (signal("Tick"), signal("Last"), signal("BusOff"));
        Self { id: message.id, len: message.len, tick, last, bus_off }
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
        self.bus_off.encode(frame.payload_mut(), f64::from(u8::from(step_end.bus_off)));
        frame
    }

    /// What a frame says, if it is a marker.
    pub fn decode(&self, frame: &Frame) -> Option<StepEnd> {
        let is_marker = frame.id == self.id && frame.len() == self.len && frame.kind != FrameKind::Remote;
        is_marker.then(|| StepEnd {
            tick: self.tick.decode(frame.storage()) as u32,
            last: self.last.decode(frame.storage()) != 0.0,
            bus_off: self.bus_off.decode(frame.storage()) != 0.0,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_marker_comes_back_as_it_was() {
        let codec = StepEndCodec::builtin();
        let flags = [(0, false, false), (u32::MAX, true, false), (7, false, true)];
        for step_end in flags.map(|(tick, last, bus_off)| StepEnd { tick, last, bus_off }) {
            assert_eq!(codec.decode(&codec.encode(step_end)), Some(step_end));
        }
        assert_eq!(codec.decode(&Frame::zeroed(codec.id(), 8)), None);
    }
}
