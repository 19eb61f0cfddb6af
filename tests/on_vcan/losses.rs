//! What finds no room is counted.

use canloop::bus::{Arrival, Bus as _};

use crate::rig::{Vcan, drain, next, numbered};

/// More than any receive buffer of the kernel holds by default.
const FLOOD: u32 = 5_000;

#[test]
#[ignore = "needs a kernel with CAN"]
fn frames_that_the_receive_buffer_has_no_room_for_are_lost_and_counted() {
    let vcan = Vcan::new("flood0");
    let (mut bus, mut other) = (vcan.open(), vcan.open());
    let (mut received, mut lost) = (0, 0);
    for round in 1..=3 {
        (0..FLOOD).for_each(|number| other.send(&numbered(1, number)).unwrap());
        // Once with a frame behind the loss, and then with none.
        for arrival in drain(&mut bus) {
            match arrival {
                Arrival::Frame(_) => received += 1,
                Arrival::Lost(frames) => lost += frames,
                other => panic!("{other:?}"),
            }
        }
        assert_eq!(received + lost, round * FLOOD);
        assert!(lost > 0 && received > 0);
    }
    assert_eq!((bus.counts().received, bus.counts().lost), (received.into(), lost.into()));
}

#[test]
#[ignore = "needs a kernel with CAN"]
fn a_loss_is_told_before_the_frame_that_follows_it() {
    let vcan = Vcan::new("gap0");
    let (mut bus, mut other) = (vcan.open(), vcan.open());
    (0..FLOOD).for_each(|number| other.send(&numbered(1, number)).unwrap());
    // Room for one more, which then stands behind the gap.
    assert_eq!(next(&mut bus).1, Arrival::Frame(numbered(1, 0)));
    other.send(&numbered(2, 0)).unwrap();
    let arrivals = drain(&mut bus);
    let [.., before, Arrival::Lost(lost), last] = arrivals[..] else { panic!("{:?}", arrivals.last()) };
    assert_eq!(last, Arrival::Frame(numbered(2, 0)));
    assert_eq!(before, Arrival::Frame(numbered(1, FLOOD - lost - 1)));
}
