//! `$STARTTIME`: days since 30 December 1899, as a decimal number.

const DAY_NS: i128 = 86_400_000_000_000;
const MILLISECOND_NS: i128 = 1_000_000;
/// Days from there to the Unix epoch.
const EPOCH_DAYS: i128 = 25_569;
/// As many decimals as tell milliseconds apart for good.
const DECIMALS: u32 = 12;
/// More say nothing that nanoseconds could.
const MOST_DECIMALS: usize = 18;

/// Nanoseconds since the epoch. So many decimals stand for any moment within
/// half of their last digit; a whole millisecond in that span is meant.
pub(super) fn parse(text: &str) -> Option<i64> {
    let (days, decimals) = text.split_once(['.', ',']).unwrap_or((text, ""));
    let decimals = decimals.get(..decimals.len().min(MOST_DECIMALS))?;
    let is_number = |text: &str| text.bytes().all(|byte| byte.is_ascii_digit());
    if days.is_empty() || days.len() > 6 || !is_number(days) || !is_number(decimals) {
        return None;
    }
    let scale = 10_i128.pow(decimals.len() as u32);
    let fraction = if decimals.is_empty() { 0 } else { decimals.parse::<i128>().ok()? };
    let of_day = fraction * DAY_NS / scale;
    let nanos = (days.parse::<i128>().ok()? - EPOCH_DAYS) * DAY_NS + of_day;
    let whole = (nanos + MILLISECOND_NS / 2).div_euclid(MILLISECOND_NS) * MILLISECOND_NS;
    let tolerance = DAY_NS / scale / 2 + 1;
    let meant = if (whole - nanos).abs() <= tolerance { whole } else { nanos };
    i64::try_from(meant).ok()
}

/// The text for a moment since 1899.
pub(super) fn text(nanos: i64) -> String {
    let since_1899 = i128::from(nanos) + EPOCH_DAYS * DAY_NS;
    let scale = 10_i128.pow(DECIMALS);
    let days = (since_1899 * scale + DAY_NS / 2) / DAY_NS;
    format!("{}.{:012}", days / scale, days % scale)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_millisecond_comes_back() {
        for nanos in (0..2_000_000_000_000_000_000).step_by(13_337_077_001_000_000) {
            assert_eq!(parse(&text(nanos)), Some(nanos), "{}", text(nanos));
        }
        assert_eq!(text(0), "25569.000000000000");
    }

    #[test]
    fn other_tools_write_fewer_decimals() {
        // 9 September 2020, 14:11:56.600, of PCAN-View.
        assert_eq!(parse("44083.5916273148"), Some(1_599_660_716_600_000_000));
        assert_eq!(parse("25569"), Some(0));
        for bad in ["", ".5", "1e5", "-1", "99999999.0"] {
            assert_eq!(parse(bad), None, "{bad}");
        }
    }
}
