//! Numbers as logs write them, from bytes and to bytes. Logs have millions,
//! so nothing here allocates or takes a detour over UTF-8 or `f64`.

const NANOS_IN_S: i64 = 1_000_000_000;
/// Digits that always fit into 64 bits.
const SAFE_DIGITS: usize = 19;

/// A whole decimal number.
pub(super) fn decimal(text: &[u8]) -> Option<u64> {
    if text.is_empty() {
        return None;
    }
    let (safe, rest) = text.split_at(text.len().min(SAFE_DIGITS));
    let sum = safe.iter().try_fold(0_u64, |sum, &byte| Some(sum * 10 + digit(byte)?))?;
    rest.iter().try_fold(sum, |sum, &byte| sum.checked_mul(10)?.checked_add(digit(byte)?))
}

/// A hexadecimal number of up to 32 bits.
pub(super) fn hex(text: &[u8]) -> Option<u32> {
    if text.is_empty() || text.len() > 8 {
        return None;
    }
    text.iter().try_fold(0, |sum, &byte| Some(sum << 4 | u32::from(nibble(byte)?)))
}

/// A decimal digit.
fn digit(byte: u8) -> Option<u64> {
    let value = byte.wrapping_sub(b'0');
    (value <= 9).then_some(u64::from(value))
}

/// A hexadecimal digit.
pub(super) fn nibble(digit: u8) -> Option<u8> {
    let value = NIBBLES[usize::from(digit)];
    (value < 16).then_some(value)
}

/// A decimal number in units of 10^`exponent` s, such as seconds with 0 and
/// milliseconds with -3, in nanoseconds. Decimals below a nanosecond are
/// dropped.
pub(super) fn nanos(text: &[u8], exponent: i32) -> Option<i64> {
    let (negative, text) = match text.split_first()? {
        (b'-', rest) => (true, rest),
        _ => (false, text),
    };
    let point = text.iter().position(|byte| matches!(byte, b'.' | b',')).unwrap_or(text.len());
    let (whole, decimals) = (&text[..point], text.get(point + 1..).unwrap_or_default());
    if whole.is_empty() {
        return None;
    }
    let places = usize::try_from(9 + exponent).ok()?;
    let sum = i64::try_from(decimal(whole)?).ok()?.checked_mul(*POWERS_OF_10.get(places)?)?;
    let (kept, dropped) = decimals.split_at(decimals.len().min(places));
    let fraction = kept.iter().try_fold(0, |sum, &byte| Some(sum * 10 + digit(byte)? as i64))?;
    dropped.iter().try_for_each(|&byte| digit(byte).map(drop))?;
    let sum = sum.checked_add(fraction * POWERS_OF_10[places - kept.len()])?;
    Some(if negative { -sum } else { sum })
}

/// Appends seconds with so many decimals, the rest cut off, the whole seconds
/// filled up with zeros to `width` digits.
pub(super) fn put_seconds(out: &mut Vec<u8>, nanos: i64, width: usize, decimals: u32) {
    put_decimal_point(out, nanos, NANOS_IN_S as u64, width, decimals);
}

/// Appends milliseconds with so many decimals, the rest cut off.
pub(super) fn put_millis(out: &mut Vec<u8>, nanos: i64, decimals: u32) {
    put_decimal_point(out, nanos, 1_000_000, 1, decimals);
}

/// Appends a whole number of at least `width` digits.
pub(super) fn put_decimal(out: &mut Vec<u8>, mut number: u64, width: usize) {
    let mut digits = [b'0'; 20];
    let mut start = digits.len();
    while number > 0 {
        start -= 1;
        digits[start] = b'0' + (number % 10) as u8;
        number /= 10;
    }
    out.extend_from_slice(&digits[start.min(digits.len() - width)..]);
}

/// Appends `width` hexadecimal digits.
pub(super) fn put_hex(out: &mut Vec<u8>, number: u32, width: usize) {
    (0..width).rev().for_each(|digit| out.push(DIGITS[(number >> (4 * digit) & 15) as usize]));
}

/// Appends two hexadecimal digits a byte, and `between` them.
pub(super) fn put_bytes(out: &mut Vec<u8>, bytes: &[u8], between: &[u8]) {
    for (index, &byte) in bytes.iter().enumerate() {
        if index > 0 {
            out.extend_from_slice(between);
        }
        out.extend_from_slice(&[DIGITS[usize::from(byte >> 4)], DIGITS[usize::from(byte & 15)]]);
    }
}

const POWERS_OF_10: [i64; 10] = [1, 10, 100, 1_000, 10_000, 100_000, 1_000_000, 10_000_000, 100_000_000, NANOS_IN_S];
const DIGITS: &[u8; 16] = b"0123456789ABCDEF";
/// The value of each hexadecimal digit, 255 for all other bytes.
const NIBBLES: [u8; 256] = {
    let mut table = [255; 256];
    let mut digit = 0;
    while digit < 16 {
        table[DIGITS[digit] as usize] = digit as u8;
        table[DIGITS[digit].to_ascii_lowercase() as usize] = digit as u8;
        digit += 1;
    }
    table
};

fn put_decimal_point(out: &mut Vec<u8>, nanos: i64, unit: u64, width: usize, decimals: u32) {
    if nanos < 0 {
        out.push(b'-');
    }
    let nanos = nanos.unsigned_abs();
    put_decimal(out, nanos / unit, width);
    if decimals > 0 {
        out.push(b'.');
        put_decimal(out, nanos % unit / (unit / 10_u64.pow(decimals)), decimals as usize);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn stamps_keep_every_nanosecond() {
        assert_eq!(nanos(b"1436509052.249713", 0), Some(1_436_509_052_249_713_000));
        assert_eq!(nanos(b"0.000000001", 0), Some(1));
        assert_eq!(nanos(b"0.0000000019", 0), Some(1));
        assert_eq!(nanos(b"-1.5", 0), Some(-1_500_000_000));
        assert_eq!(nanos(b"1059.9", -3), Some(1_059_900_000));
        assert_eq!(nanos(b"17", 0), Some(17_000_000_000));
        assert_eq!(nanos(b"17.25", -9), Some(17));
        assert_eq!(nanos(b"17.x", -9), None);
        assert_eq!(decimal(b"18446744073709551615"), Some(u64::MAX));
        assert_eq!(decimal(b"18446744073709551616"), None);
        for bad in ["", ".", "-", "1.x", "1e3", "99999999999999999999", "9223372037.0"] {
            assert_eq!(nanos(bad.as_bytes(), 0), None, "{bad}");
        }
    }

    #[test]
    fn what_is_put_is_read_back() {
        let mut out = Vec::new();
        put_seconds(&mut out, 1_436_509_052_249_713_042, 10, 9);
        assert_eq!(out, b"1436509052.249713042");
        out.clear();
        put_seconds(&mut out, -1_500_000, 1, 6);
        assert_eq!(out, b"-0.001500");
        out.clear();
        put_millis(&mut out, 1_059_950_000, 1);
        assert_eq!(out, b"1059.9");
        out.clear();
        put_decimal(&mut out, 0, 1);
        put_hex(&mut out, 0x1A2, 3);
        put_bytes(&mut out, &[0xDE, 0xAD], b" ");
        assert_eq!(out, b"01A2DE AD");
    }
}
