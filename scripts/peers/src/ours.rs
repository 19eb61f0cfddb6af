//! canloop, which reads the DBC at run time.

use canloop::config::Source;
use canloop::frame::Frame;
use canloop::schema::{Dbc, Encoding, MessageLayout, Value};

use crate::FRAMES;

/// Millions of frames a second.
pub fn rate(work: &str, seconds: f64) -> f64 {
    let dbc = Dbc::parse(&Source::new("bench.dbc", include_str!("../bench.dbc"))).expect("bench.dbc is right");
    let (layout, values): (_, fn(usize) -> [f64; 6]) = match work {
        work if work.ends_with("feedback") => (dbc.message("Feedback").unwrap(), feedback),
        _ => (dbc.message("Measured").unwrap(), measured),
    };
    let mut frames = vec![Frame::zeroed(layout.id, layout.len); FRAMES];
    frames.iter_mut().enumerate().for_each(|(index, frame)| encode(layout, values(index), frame));
    match work {
        "decode-feedback" | "decode-measured" => {
            crate::rate(seconds, |index| layout.decode(&frames[index]).map(|(_, value)| value).sum())
        }
        "encode-feedback" => crate::rate(seconds, |index| {
            encode(layout, feedback(index), &mut frames[index]);
            f64::from(frames[index].payload()[0])
        }),
        "encode-measured" => crate::rate(seconds, |index| {
            encode(layout, measured(index), &mut frames[index]);
            f64::from(frames[index].payload()[0])
        }),
        "encode-by-name-feedback" => crate::rate(seconds, |index| {
            let [position, torque, state, counter, temperature, _] = feedback(index).map(Value::Physical);
            let named = [
                ("Position", position),
                ("TorqueApplied", torque),
                ("State", state),
                ("Counter", counter),
                ("Temperature", temperature),
            ];
            f64::from(layout.encode(&named, Encoding::default()).unwrap().payload()[0])
        }),
        _ => panic!("unknown work {work}"),
    }
}

fn encode(layout: &MessageLayout, values: [f64; 6], frame: &mut Frame) {
    let value_of = |index: usize, _: &_| Some(Value::Physical(values[index])).filter(|_| !values[index].is_nan());
    layout.encode_each(frame.payload_mut(), Encoding::default(), value_of).expect("the values fit");
}

fn feedback(index: usize) -> [f64; 6] {
    let number = index as f64;
    let low = (index & 15) as f64;
    [1000.0 * number, 0.1 * number, low, low, 20.0, f64::NAN]
}

fn measured(index: usize) -> [f64; 6] {
    const NONE: f64 = f64::NAN;
    let number = index as f64;
    match index % 3 {
        0 => [0.0, 20.0, 0.1 * number, NONE, NONE, NONE],
        1 => [1.0, 20.0, NONE, 0.01 * number, 48.0, NONE],
        _ => [2.0, 20.0, NONE, NONE, NONE, 100.0 * number],
    }
}
