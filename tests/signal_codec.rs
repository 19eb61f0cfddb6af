//! Any signal of any layout is read from and written to exactly its bits.

use canloop::config::Source;
use canloop::schema::{ByteOrder, Dbc, Raw, RawKind, Signal};
use proptest::prelude::*;

/// A signal as a DBC describes it.
#[derive(Clone, Debug)]
struct Layout {
    start: usize,
    len: usize,
    order: ByteOrder,
    kind: RawKind,
    factor: f64,
    offset: f64,
}

impl Layout {
    fn compile(&self) -> Signal {
        let order = if self.order == ByteOrder::Intel { 1 } else { 0 };
        let sign = if self.kind == RawKind::Unsigned { '+' } else { '-' };
        let Self { start, len, factor, offset, .. } = self;
        let mut text =
            format!("BO_ 1 M: 64 X\n SG_ S : {start}|{len}@{order}{sign} ({factor},{offset}) [0|0] \"\" X\n");
        match self.kind {
            RawKind::Float32 => text += "\nSIG_VALTYPE_ 1 S : 1;\n",
            RawKind::Float64 => text += "\nSIG_VALTYPE_ 1 S : 2;\n",
            RawKind::Unsigned | RawKind::Signed => {}
        }
        let dbc = Dbc::parse(&Source::new("layout.dbc", text)).unwrap_or_else(|problems| panic!("{problems}"));
        dbc.messages[0].signals[0].clone()
    }

    /// Where the bits lie, lowest first, counted as a DBC does: step by step,
    /// with none of the codec's arithmetic.
    fn places(&self) -> Vec<usize> {
        let mut places = vec![self.start];
        while places.len() < self.len {
            let last = places[places.len() - 1];
            places.push(match self.order {
                ByteOrder::Intel => last + 1,
                ByteOrder::Motorola if last % 8 == 0 => last + 15,
                ByteOrder::Motorola => last - 1,
            });
        }
        if self.order == ByteOrder::Motorola {
            places.reverse();
        }
        places
    }

    fn read(&self, data: &[u8; 64]) -> u64 {
        self.places().iter().rev().fold(0, |bits, &at| bits << 1 | u64::from(data[at / 8] >> (at % 8) & 1))
    }

    fn write(&self, data: &mut [u8; 64], bits: u64) {
        for (index, at) in self.places().into_iter().enumerate() {
            data[at / 8] = data[at / 8] & !(1 << (at % 8)) | ((bits >> index & 1) as u8) << (at % 8);
        }
    }

    /// The raw whole number nearest to `physical`, halves away from zero.
    fn nearest(&self, physical: f64) -> i128 {
        let span = 1_i128 << self.len;
        let (least, most) = if self.kind == RawKind::Signed { (-span / 2, span / 2 - 1) } else { (0, span - 1) };
        let raw = (physical - self.offset) / self.factor;
        let whole = raw.trunc() as i128;
        let away = if (raw - raw.trunc()).abs() >= 0.5 { raw.signum() as i128 } else { 0 };
        whole.saturating_add(away).clamp(least, most)
    }
}

fn layouts() -> impl Strategy<Value = Layout> {
    let kinds = prop_oneof![
        4 => Just(RawKind::Unsigned),
        4 => Just(RawKind::Signed),
        1 => Just(RawKind::Float32),
        1 => Just(RawKind::Float64),
    ];
    let orders = prop_oneof![Just(ByteOrder::Intel), Just(ByteOrder::Motorola)];
    let factors = prop_oneof![Just(1.0), Just(0.005), Just(-0.25), 1e-6..1e6];
    let offsets = prop_oneof![Just(0.0), -1e3..1e3];
    (0..512_usize, 1..=64_usize, orders, kinds, factors, offsets)
        .prop_map(|(start, len, order, kind, factor, offset)| {
            let len = match kind {
                RawKind::Float32 => 32,
                RawKind::Float64 => 64,
                RawKind::Unsigned | RawKind::Signed => len,
            };
            Layout { start, len, order, kind, factor, offset }
        })
        .prop_filter("past the end", |layout| layout.places().iter().all(|&place| place < 512))
}

fn frames() -> impl Strategy<Value = [u8; 64]> {
    prop::collection::vec(any::<u8>(), 64).prop_map(|bytes| bytes.try_into().unwrap())
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 2000, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn decoding_reads_the_signal_s_bits(layout in layouts(), data in frames()) {
        let signal = layout.compile();
        let bits = layout.read(&data);
        let unused = 64 - layout.len;
        let expected = match layout.kind {
            RawKind::Unsigned => Raw::Unsigned(bits),
            RawKind::Signed => Raw::Signed((bits << unused) as i64 >> unused),
            RawKind::Float32 => Raw::Real(f32::from_bits(bits as u32).into()),
            RawKind::Float64 => Raw::Real(f64::from_bits(bits)),
        };
        prop_assert_eq!(format!("{:?}", signal.decode_raw(&data)), format!("{expected:?}"));
        let physical = expected.as_f64() * layout.factor + layout.offset;
        prop_assert!(signal.decode(&data) == physical || physical.is_nan());
    }

    #[test]
    fn encoding_writes_the_signal_s_bits_and_no_other(layout in layouts(), data in frames(), bits in any::<u64>()) {
        let signal = layout.compile();
        let mut source = [0; 64];
        layout.write(&mut source, bits);
        let raw = signal.decode_raw(&source);
        prop_assume!(!raw.as_f64().is_nan());
        let (mut written, mut expected) = (data, data);
        signal.encode_raw(&mut written, raw);
        layout.write(&mut expected, bits);
        prop_assert_eq!(written, expected);
    }

    #[test]
    fn encoding_rounds_half_away_from_zero_and_saturates(
        layout in layouts(),
        data in frames(),
        physical in prop_oneof![any::<f64>(), -1e4..1e4, (-1000..1000_i32).prop_map(|halves| f64::from(halves) / 2.0)],
    ) {
        let signal = layout.compile();
        prop_assume!(!signal.is_float() && !physical.is_nan());
        let (mut written, mut expected) = (data, data);
        signal.encode(&mut written, physical);
        layout.write(&mut expected, layout.nearest(physical) as u64);
        prop_assert_eq!(written, expected);
    }

    #[test]
    fn a_buffer_that_is_too_short_is_written_as_far_as_it_goes(
        layout in layouts(),
        data in frames(),
        len in 0..64_usize,
        physical in any::<f64>(),
    ) {
        let signal = layout.compile();
        let (mut short, mut whole) = (data, data);
        signal.encode(&mut short[..len], physical);
        signal.encode(&mut whole, physical);
        prop_assert_eq!(&short[..len], &whole[..len]);
        prop_assert_eq!(&short[len..], &data[len..]);
    }
}

#[test]
fn what_is_no_number_becomes_raw_zero_in_a_whole_number_signal() {
    for kind in [RawKind::Unsigned, RawKind::Signed] {
        let layout = Layout { start: 8, len: 16, order: ByteOrder::Intel, kind, factor: 0.1, offset: 3.0 };
        let mut data = [0xFF; 64];
        layout.compile().encode(&mut data, f64::NAN);
        assert_eq!(data[..4], [0xFF, 0, 0, 0xFF]);
    }
}

#[test]
fn infinities_become_the_ends_of_the_range() {
    let kind = RawKind::Signed;
    let signal = Layout { start: 0, len: 16, order: ByteOrder::Intel, kind, factor: 0.005, offset: 0.0 }.compile();
    let mut data = [0; 64];
    signal.encode(&mut data, f64::INFINITY);
    assert_eq!(signal.decode_raw(&data), Raw::Signed(i16::MAX.into()));
    signal.encode(&mut data, f64::NEG_INFINITY);
    assert_eq!(signal.decode_raw(&data), Raw::Signed(i16::MIN.into()));
}

#[test]
fn a_finite_number_stays_finite_in_a_float32_signal() {
    let kind = RawKind::Float32;
    let signal = Layout { start: 0, len: 32, order: ByteOrder::Intel, kind, factor: 1.0, offset: 0.0 }.compile();
    let mut data = [0; 64];
    signal.encode(&mut data, -1e300);
    assert_eq!(signal.decode(&data), f64::from(f32::MIN));
}
