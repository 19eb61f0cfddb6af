//! Dates of the Gregorian calendar, without a time zone.

use super::number;

/// A moment as people write it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Date {
    pub year: i64,
    /// 1 to 12.
    pub month: u32,
    /// 1 to 31.
    pub day: u32,
    pub hour: u32,
    pub minute: u32,
    pub second: u32,
    pub nanos: u32,
}

const MONTHS: [&str; 12] = ["Jan", "Feb", "Mar", "Apr", "May", "Jun", "Jul", "Aug", "Sep", "Oct", "Nov", "Dec"];
const WEEKDAYS: [&str; 7] = ["Sun", "Mon", "Tue", "Wed", "Thu", "Fri", "Sat"];
const DAY_S: i64 = 86_400;
const NANOS_IN_S: i64 = 1_000_000_000;

impl Date {
    /// The moment so many nanoseconds after the Unix epoch.
    pub fn from_nanos(nanos: i64) -> Self {
        let (seconds, nanos) = (nanos.div_euclid(NANOS_IN_S), nanos.rem_euclid(NANOS_IN_S) as u32);
        let (days, of_day) = (seconds.div_euclid(DAY_S), seconds.rem_euclid(DAY_S) as u32);
        // Years begin in March here, so that the leap day comes last.
        let days = days + 719_468;
        let (era, of_era) = (days.div_euclid(146_097), days.rem_euclid(146_097));
        let year_of_era = (of_era - of_era / 1_460 + of_era / 36_524 - of_era / 146_096) / 365;
        let of_year = of_era - (365 * year_of_era + year_of_era / 4 - year_of_era / 100);
        let from_march = (5 * of_year + 2) / 153;
        let month = (if from_march < 10 { from_march + 3 } else { from_march - 9 }) as u32;
        Self {
            year: year_of_era + era * 400 + i64::from(month <= 2),
            month,
            day: (of_year - (153 * from_march + 2) / 5 + 1) as u32,
            hour: of_day / 3_600,
            minute: of_day / 60 % 60,
            second: of_day % 60,
            nanos,
        }
    }

    /// Nanoseconds since the Unix epoch; `None` where it is no date, or one
    /// that 64 bits do not reach.
    pub fn to_nanos(self) -> Option<i64> {
        let in_range = (1..=12).contains(&self.month) && (1..=31).contains(&self.day);
        if !in_range || self.hour > 23 || self.minute > 59 || self.second > 60 || !(1_600..2_400).contains(&self.year) {
            return None;
        }
        let year = self.year - i64::from(self.month <= 2);
        let (era, of_era) = (year.div_euclid(400), year.rem_euclid(400));
        let from_march = i64::from((self.month + 9) % 12);
        let of_year = (153 * from_march + 2) / 5 + i64::from(self.day) - 1;
        let days = era * 146_097 + of_era * 365 + of_era / 4 - of_era / 100 + of_year - 719_468;
        let seconds = days * DAY_S + i64::from(self.hour * 3_600 + self.minute * 60 + self.second);
        seconds.checked_mul(NANOS_IN_S)?.checked_add(i64::from(self.nanos))
    }

    /// Days since Sunday.
    pub fn weekday(self) -> u32 {
        let days = self.to_nanos().map_or(0, |nanos| nanos.div_euclid(DAY_S * NANOS_IN_S));
        (days + 4).rem_euclid(7) as u32
    }

    /// `Thu Jul 10 08:17:32.249 2015`, as in Vector's logs.
    pub fn english(self) -> String {
        let Self { year, month, day, hour, minute, second, nanos } = self;
        let (weekday, month) = (WEEKDAYS[self.weekday() as usize], MONTHS[(month - 1) as usize]);
        format!("{weekday} {month} {day:02} {hour:02}:{minute:02}:{second:02}.{:03} {year}", nanos / 1_000_000)
    }

    /// What [`Self::english`] writes, with German names, am and pm too, and
    /// `10.07.2015 08:17:32.249`. The name of the weekday is passed over.
    pub fn parse(text: &[u8]) -> Option<Self> {
        let mut date = Self::default();
        let (mut afternoon, mut has_time) = (None, false);
        for word in text.split(u8::is_ascii_whitespace).filter(|word| !word.is_empty()) {
            if word.contains(&b':') {
                date.set_time(word)?;
                has_time = true;
            } else if word.eq_ignore_ascii_case(b"am") || word.eq_ignore_ascii_case(b"pm") {
                afternoon = Some(word.eq_ignore_ascii_case(b"pm"));
            } else if let Some(month) = month(word) {
                date.month = month;
            } else if word.contains(&b'.') || word.contains(&b'-') {
                let _ = date.set_day(word);
            } else if let Some(number) = number::decimal(word) {
                match number {
                    1..=31 => date.day = number as u32,
                    _ => date.year = number as i64,
                }
            }
        }
        match afternoon {
            Some(true) if date.hour < 12 => date.hour += 12,
            Some(false) if date.hour == 12 => date.hour = 0,
            _ => {}
        }
        (has_time && date.to_nanos().is_some()).then_some(date)
    }

    fn set_time(&mut self, text: &[u8]) -> Option<()> {
        let mut parts = text.splitn(3, |&byte| byte == b':');
        self.hour = u32::try_from(number::decimal(parts.next()?)?).ok()?;
        self.minute = u32::try_from(number::decimal(parts.next()?)?).ok()?;
        let nanos = match parts.next() {
            // PCAN writes milliseconds and, behind another point, their tenths.
            Some(seconds) => {
                let mut seconds = seconds.to_vec();
                let mut points = seconds.iter().enumerate().filter(|(_, byte)| **byte == b'.').map(|(at, _)| at);
                if let (Some(_), Some(second)) = (points.next(), points.next()) {
                    seconds.remove(second);
                }
                number::nanos(&seconds, 0).filter(|nanos| (0..=60 * NANOS_IN_S).contains(nanos))?
            }
            None => 0,
        };
        self.second = (nanos / NANOS_IN_S) as u32;
        self.nanos = (nanos % NANOS_IN_S) as u32;
        Some(())
    }

    /// `10.07.2015` or `2015-07-10`.
    fn set_day(&mut self, text: &[u8]) -> Option<()> {
        let mut parts = text.split(|byte| matches!(byte, b'.' | b'-')).map(number::decimal);
        let (first, month, last) = (parts.next()??, parts.next()??, parts.next()??);
        let (year, day) = if first > 31 { (first, last) } else { (last, first) };
        self.year = i64::try_from(year).ok()?;
        self.month = u32::try_from(month).ok()?;
        self.day = u32::try_from(day).ok()?;
        Some(())
    }
}

/// The number of a month by the beginning of its name.
fn month(word: &[u8]) -> Option<u32> {
    let german: [(&[u8], u32); 5] = [(b"M\xC3\xA4r", 3), (b"M\xE4r", 3), (b"Mai", 5), (b"Okt", 10), (b"Dez", 12)];
    let english = (1..).zip(MONTHS).map(|(number, name)| (name.as_bytes(), number));
    english.chain(german).find(|(name, _)| word.starts_with(name)).map(|(_, number)| number)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_day_is_read_as_it_is_written() {
        for day in (-30_000..60_000).step_by(13) {
            let nanos = day * DAY_S * NANOS_IN_S + 45_296_789_000_000;
            let date = Date::from_nanos(nanos);
            assert_eq!(date.to_nanos(), Some(nanos), "{date:?}");
            assert_eq!(Date::parse(date.english().as_bytes()), Some(date));
        }
        assert_eq!(Date::from_nanos(1_436_509_052_249_000_000).english(), "Fri Jul 10 06:17:32.249 2015");
    }

    #[test]
    fn dates_are_read_in_the_ways_that_tools_write_them() {
        let wanted = Some("Sat Sep 30 15:06:13.191 2017".to_owned());
        for text in [
            "Sam Sep 30 15:06:13.191 2017",
            "Sat Sep 30 03:06:13.191 pm 2017",
            "30.09.2017 15:06:13.191",
            "30.09.2017 15:06:13.191.0",
            "2017-09-30 15:06:13.191000",
        ] {
            assert_eq!(Date::parse(text.as_bytes()).map(Date::english), wanted, "{text}");
        }
        let december = Date::parse("Die Dez 5 12:00:01 am 2017".as_bytes()).map(Date::english);
        assert_eq!(december, Some("Tue Dec 05 00:00:01.000 2017".to_owned()));
        for text in ["", "Sat", "Sep 30 2017", "Sep 31 99:00:00 2017", "\u{0}"] {
            assert_eq!(Date::parse(text.as_bytes()), None, "{text}");
        }
    }
}
