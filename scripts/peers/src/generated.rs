//! What dbc-codegen generates.

use std::hint::black_box;

use messages::Feedback;

use crate::FRAMES;

#[allow(warnings, clippy::all)]
mod messages {
    include!(concat!(env!("OUT_DIR"), "/messages.rs"));
}

/// Reads all signals of a frame.
pub fn decode_feedback() -> impl FnMut(usize) -> f64 {
    let frames: Vec<[u8; 8]> = (0..FRAMES).map(|index| *message(index).raw()).collect();
    move |index| {
        let message = Feedback::try_from(black_box(frames[index].as_slice())).expect("8 bytes");
        f64::from(message.position())
            + f64::from(message.torque_applied())
            + f64::from(message.state())
            + f64::from(message.counter())
            + f64::from(message.temperature())
    }
}

/// Writes all signals of a frame.
pub fn encode_feedback() -> impl FnMut(usize) -> f64 {
    |index| f64::from(black_box(message(index).raw())[0])
}

fn message(index: usize) -> Feedback {
    let number = index as f32;
    let low = (index & 15) as u8;
    Feedback::new(1000 * index as i32, 0.1 * number, low, low, 20.0).expect("the values fit")
}
