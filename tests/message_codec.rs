//! A message is read and written as a whole: exactly the signals that a frame
//! carries, and values kept or refused as the caller says.

use std::path::Path;

use canloop::config::Source;
use canloop::frame::{CanId, Frame, FrameKind};
use canloop::schema::{
    Absence, Dbc, EncodeError, Encoding, MessageLayout, OutOfRange, Raw, Rounding, Signal, Value, Within,
};
use proptest::prelude::*;

fn message(file: &str, name: &str) -> MessageLayout {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/dbc").join(file);
    let dbc = Dbc::parse(&Dbc::read_source(&path).unwrap()).unwrap_or_else(|problems| panic!("{problems}"));
    dbc.message(name).unwrap().clone()
}

fn decoded<'m>(message: &'m MessageLayout, payload: &[u8]) -> Vec<(&'m str, f64)> {
    let mut frame = Frame::zeroed(message.id, payload.len());
    frame.payload_mut().copy_from_slice(payload);
    message.decode(&frame).map(|(signal, value)| (message.signal(&signal.name).unwrap().name.as_str(), value)).collect()
}

fn encoded(message: &MessageLayout, values: &[(&str, Value<'_>)]) -> Result<Vec<u8>, EncodeError> {
    message.encode(values, Encoding::default()).map(|frame| frame.payload().to_vec())
}

/// Of one signal, in its own message.
fn signal(statement: &str) -> Signal {
    let text = format!("BO_ 1 M: 64 A\n SG_ S : {statement} \"N m\" A\nBA_ \"GenSigStartValue\" SG_ 1 S 3;\n");
    Dbc::parse(&Source::new("signal.dbc", text)).unwrap().messages[0].signals[0].clone()
}

fn number(raw: Result<Raw, EncodeError>) -> f64 {
    raw.unwrap().as_f64()
}

#[test]
fn a_switch_says_which_signals_are_there() {
    let measured = message("multiplexed.dbc", "Measured");
    assert_eq!(
        decoded(&measured, &[0, 20, 0x10, 0x27, 1, 2, 3, 4]),
        [("Kind", 0.0), ("Always", 0.0), ("Speed", 100.0)]
    );
    assert_eq!(
        decoded(&measured, &[1, 22, 0xE8, 0x03, 0xE8, 0x03, 0, 0]),
        [("Kind", 1.0), ("Always", 1.0), ("Current", 1.0), ("Voltage", 10.0)]
    );
    assert_eq!(decoded(&measured, &[77, 20, 1, 2, 3, 4, 5, 6]), [("Kind", 77.0), ("Always", 0.0)]);
}

#[test]
fn switches_may_stand_behind_switches() {
    let nested = message("extended_multiplexing.dbc", "Nested");
    let names = |switches: u8, deep: u8| {
        let mut payload = [0; 16];
        // Deep runs from the lowest bit of one byte to the highest two of the next.
        (payload[0], payload[1], payload[2]) = (switches, deep >> 2, deep << 6);
        decoded(&nested, &payload).into_iter().map(|(name, _)| name).collect::<Vec<_>>().join(" ")
    };
    assert_eq!(names(0x00, 0), "Outer OuterFew Plain");
    assert_eq!(names(0x01, 0), "Outer Inner InnerRange Plain");
    assert_eq!(names(0x27, 0), "Outer Inner Deep DeepValue Plain");
    assert_eq!(names(0x27, 5), "Outer Inner Deep DeepValue DeepFloat Plain");
    assert_eq!(names(0x27, 7), "Outer Inner Deep DeepFloat Plain");
    assert_eq!(names(0x08, 7), "Outer OuterFew Plain");
}

#[test]
fn a_frame_cut_short_carries_the_signals_wholly_inside_it() {
    let measured = message("multiplexed.dbc", "Measured");
    assert_eq!(decoded(&measured, &[1, 22, 0xE8, 0x03, 0xE8]), [("Kind", 1.0), ("Always", 1.0), ("Current", 1.0)]);
    let absent: Vec<_> = measured.absent(&[1, 22, 0xE8]).map(|(signal, why)| (signal.name.clone(), why)).collect();
    let (cut, other) = (Absence::TooShort, Absence::NotSelected);
    let expected = [("Speed", cut), ("Current", cut), ("Voltage", cut), ("Serial", cut)];
    assert_eq!(absent, expected.map(|(name, why)| (name.to_owned(), why)));
    assert_eq!(measured.absence(measured.signal("Speed").unwrap(), &[1; 8]), Some(other));
    // The switch itself is past the end: nobody knows what is there.
    assert_eq!(decoded(&message("multiplexed.dbc", "SwitchLast"), &[1, 2, 3, 4]), []);
}

#[test]
fn a_frame_longer_than_the_layout_carries_all_of_it() {
    let named = message("values.dbc", "Named");
    assert_eq!(decoded(&named, &[1; 12]).len(), 4);
}

#[test]
fn a_remote_request_carries_nothing() {
    let named = message("values.dbc", "Named");
    let mut request = Frame::zeroed(named.id, 8);
    request.kind = FrameKind::Remote;
    assert_eq!(named.decode(&request).count(), 0);
}

#[test]
fn messages_longer_than_a_frame_are_read_and_written_as_payloads() {
    let segmented = message("can_fd.dbc", "Segmented");
    let mut payload = vec![0xFF; 120];
    let values = [("Late", Value::Physical(-2.0)), ("End", Value::Physical(258.0))];
    segmented.encode_payload(&mut payload, &values, Encoding::default()).unwrap();
    let decoded: Vec<f64> = segmented.decode_payload(&payload).map(|(_, value)| value).collect();
    assert_eq!(decoded, [0.0, -2.0, 258.0]);
    assert_eq!((payload[98], payload[99]), (1, 2));
    assert!(matches!(encoded(&segmented, &[]), Err(EncodeError::NoRoom { expected: 100, found: 64, .. })));
}

#[test]
fn encoding_writes_the_signals_that_the_switch_selects() {
    let measured = message("multiplexed.dbc", "Measured");
    let values = [("Voltage", 10.0.into()), ("Kind", "Power".into()), ("Always", (-9.0).into())];
    assert_eq!(encoded(&measured, &values).unwrap(), [1, 2, 0, 0, 0xE8, 0x03, 0, 0]);
    let last = message("multiplexed.dbc", "SwitchLast");
    assert_eq!(encoded(&last, &[("Upper", 2748.0.into()), ("Which", 1.0.into())]).unwrap()[..2], [0xAB, 0xC0]);
}

#[test]
fn a_value_that_the_switch_leaves_no_room_for_is_refused() {
    let measured = message("multiplexed.dbc", "Measured");
    let error = encoded(&measured, &[("Kind", 1.0.into()), ("Speed", 3.0.into())]).unwrap_err();
    assert_eq!(error.to_string(), "Speed is not in the frame when Kind is 1");
}

#[test]
fn what_is_not_given_starts_as_the_dbc_says() {
    let named = message("values.dbc", "Named");
    // Raw 1, raw -3, raw 1 by default, raw 250.
    assert_eq!(encoded(&named, &[]).unwrap(), [1, 0xFD, 1, 0, 250, 0, 0, 0]);
    assert_eq!(encoded(&named, &[("State", "Enabled".into())]).unwrap()[0], 2);
}

#[test]
fn names_that_are_unknown_are_refused_with_the_nearest() {
    let named = message("values.dbc", "Named");
    let error = encoded(&named, &[("Stat", 1.0.into())]).unwrap_err();
    assert_eq!(error.to_string(), "Named has no signal `Stat`; did you mean `State`?");
    let error = encoded(&named, &[("State", "enabled".into())]).unwrap_err();
    assert_eq!(error.to_string(), "State has no value named `enabled`; did you mean `Enabled`?");
}

#[test]
fn fd_frames_are_what_the_dbc_says_or_what_it_takes() {
    let kind = |name: &str| message("can_fd.dbc", name).encode(&[], Encoding::default()).unwrap().kind;
    assert_eq!((kind("Full"), kind("ShortFd"), kind("Nothing")), (FrameKind::Fd, FrameKind::Fd, FrameKind::Classic));
    let frame = message("can_fd.dbc", "ShortFd").encode(&[], Encoding::default()).unwrap();
    assert_eq!((frame.id, frame.len()), (CanId::Extended(3), 8));
}

#[test]
fn rounding_is_to_the_nearest_or_towards_zero() {
    let signal = signal("0|16@1- (0.5,10) [0|0]");
    let raw = |physical, rounding| {
        number(signal.quantise(Value::Physical(physical), Encoding { rounding, ..Encoding::default() }))
    };
    for (physical, nearest, towards_zero) in
        [(10.2, 0.0, 0.0), (10.3, 1.0, 0.0), (10.99, 2.0, 1.0), (9.75, -1.0, 0.0), (9.01, -2.0, -1.0)]
    {
        assert_eq!(raw(physical, Rounding::Nearest), nearest, "{physical}");
        assert_eq!(raw(physical, Rounding::TowardsZero), towards_zero, "{physical}");
    }
}

#[test]
fn truncation_is_that_of_a_drive_maker_s_code() {
    // (int)((x - x_min) * (2^n - 1) / span), as in the T-Motor and MIT drives: 12 bits from -18 to 18 N m.
    let (minimum, span) = (-18.0, 36.0);
    let signal = signal(&format!("0|12@1+ ({},{minimum}) [0|0]", span / 4095.0));
    let how = Encoding { rounding: Rounding::TowardsZero, ..Encoding::default() };
    for step in 0..4095 {
        // Not on a step itself, where the last bit of the division decides.
        let torque_nm = minimum + (f64::from(step) + 0.37) * span / 4095.0;
        let theirs = ((torque_nm - minimum) * 4095.0 / span) as i32;
        assert_eq!(number(signal.quantise(Value::Physical(torque_nm), how)), f64::from(theirs));
    }
}

#[test]
fn out_of_range_is_refused_by_name_value_and_range_or_saturates() {
    let signal = signal("0|8@1- (0.5,0) [-20|20]");
    let quantise = |physical, out_of_range, within| {
        signal.quantise(Value::Physical(physical), Encoding { out_of_range, within, ..Encoding::default() })
    };
    let error = quantise(64.0, OutOfRange::Refuse, Within::Bits).unwrap_err();
    assert_eq!(error.to_string(), "S cannot be 64 N m, expected -64 to 63.5 N m");
    let error = quantise(-20.5, OutOfRange::Refuse, Within::Limits).unwrap_err();
    assert_eq!(error.to_string(), "S cannot be -20.5 N m, expected -20 to 20 N m");
    assert_eq!(number(quantise(-20.5, OutOfRange::Refuse, Within::Bits)), -41.0);
    assert_eq!(number(quantise(-20.5, OutOfRange::Saturate, Within::Limits)), -40.0);
    assert!(quantise(f64::NAN, OutOfRange::Refuse, Within::Bits).is_err());
    assert_eq!(number(quantise(f64::NAN, OutOfRange::Saturate, Within::Bits)), 0.0);
    let error = signal.quantise(Value::Raw(Raw::Unsigned(200)), Encoding::default()).unwrap_err();
    assert_eq!(error.to_string(), "S cannot be 100 N m, expected -64 to 63.5 N m");
}

#[test]
fn whole_numbers_of_64_bits_lose_nothing() {
    let wide = message("values.dbc", "Wide");
    let raw = [Raw::Unsigned(u64::MAX - 1), Raw::Signed(i64::MIN + 1), Raw::Unsigned(1 << 63 | 1)];
    let values: Vec<_> =
        ["Unsigned", "Signed", "Scaled"].into_iter().zip(raw).map(|(name, raw)| (name, Value::Raw(raw))).collect();
    let payload = encoded(&wide, &values).unwrap();
    let read: Vec<_> = wide.signals[..3].iter().map(|signal| signal.decode_raw(&payload)).collect();
    assert_eq!(read, raw);
    // 3 * (2^63 + 1) - 7, rounded once.
    assert_eq!(wide.signals[2].decode(&payload), (3 * ((1_i128 << 63) + 1) - 7) as f64);
    for (limit, name) in [(u64::MAX as f64, "Unsigned"), (i64::MAX as f64, "Signed"), (-1.0, "Unsigned")] {
        assert!(encoded(&wide, &[(name, limit.into())]).is_err(), "{name} {limit}");
    }
}

#[test]
fn floats_take_any_number_that_they_can_hold() {
    let short = message("can_fd.dbc", "ShortFd");
    for physical in [f64::INFINITY, f64::NEG_INFINITY] {
        let payload = encoded(&short, &[("Float", physical.into())]).unwrap();
        assert_eq!(short.signal("Float").unwrap().decode(&payload), physical);
    }
    assert!(encoded(&short, &[("Float", 1e300.into())]).is_err());
    let how = Encoding { out_of_range: OutOfRange::Saturate, ..Encoding::default() };
    let frame = short.encode(&[("Float", 1e300.into())], how).unwrap();
    assert_eq!(short.signals[0].decode_raw(frame.payload()), Raw::Real(f32::MAX.into()));
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn a_payload_comes_back_as_it_was(payload in prop::collection::vec(any::<u8>(), 64)) {
        for file in ["multiplexed.dbc", "extended_multiplexing.dbc", "can_fd.dbc", "values.dbc"] {
            let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/dbc").join(file);
            let dbc = Dbc::parse(&Dbc::read_source(&path).unwrap()).unwrap();
            for message in dbc.messages.iter().filter(|message| message.len <= 64) {
                let payload = &payload[..message.len];
                let values: Vec<_> = message
                    .decode_payload(payload)
                    .filter(|(_, value)| !value.is_nan())
                    .map(|(signal, _)| (signal.name.as_str(), Value::Raw(signal.decode_raw(payload))))
                    .collect();
                let written = encoded(message, &values).unwrap();
                for (signal, value) in message.decode_payload(payload).filter(|(_, value)| !value.is_nan()) {
                    prop_assert_eq!(value.to_bits(), signal.decode(&written).to_bits());
                }
            }
        }
    }

    #[test]
    fn no_value_writes_outside_of_its_bits(physical in any::<f64>(), kind in 0..4_u8) {
        let measured = message("multiplexed.dbc", "Measured");
        let how = Encoding { out_of_range: OutOfRange::Saturate, ..Encoding::default() };
        let frame = measured.encode(&[("Kind", f64::from(kind).into()), ("Always", physical.into())], how).unwrap();
        prop_assert_eq!(frame.payload()[0], kind);
        prop_assert_eq!(&frame.payload()[2..], &[0; 6]);
    }
}
