//! Numbers for buses, in formats that call them by number.

use super::Buses;

/// Which number each bus has, from 1.
#[derive(Default)]
pub(super) struct Numbering {
    /// By index of the bus.
    numbers: Vec<Option<u32>>,
}

/// A bus's number, and whether it must be said what it is called.
pub(super) struct Numbered {
    pub number: u32,
    /// It has just got that number, and a reader would take it for another.
    pub is_news: bool,
}

impl Numbering {
    /// The number of a bus: one more than that in its name, if it is called
    /// `can` and a number and the number is free; else the lowest free one.
    pub fn of(&mut self, bus: u16, buses: &Buses) -> Numbered {
        let index = usize::from(bus);
        if let Some(&Some(number)) = self.numbers.get(index) {
            return Numbered { number, is_news: false };
        }
        let wanted = buses.name(bus).strip_prefix("can").and_then(canonical).map(|from_0| from_0 + 1);
        let is_free = |number: &u32| !self.numbers.contains(&Some(*number));
        let number = wanted.filter(is_free).or_else(|| (1..).find(is_free)).unwrap_or(1);
        self.numbers.resize(self.numbers.len().max(index + 1), None);
        self.numbers[index] = Some(number);
        Numbered { number, is_news: wanted != Some(number) }
    }
}

/// A number of at most 255 written without leading zeros.
fn canonical(digits: &str) -> Option<u32> {
    digits.parse().ok().filter(|number: &u32| *number < 255 && number.to_string() == digits)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn can0_is_number_1_and_others_take_what_is_free() {
        let mut buses = Buses::default();
        let names = ["can1", "vcan0", "can0", "can00", "can7"];
        names.iter().for_each(|name| assert!(buses.index(name).is_ok()));
        let mut numbering = Numbering::default();
        let numbers: Vec<_> = (0..5).map(|bus| numbering.of(bus, &buses)).map(|n| (n.number, n.is_news)).collect();
        assert_eq!(numbers, [(2, false), (1, true), (3, true), (4, true), (8, false)]);
        assert!(!numbering.of(1, &buses).is_news);
    }
}
