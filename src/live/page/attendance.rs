//! Who keeps up: a viewer who reads too slowly goes without updates, and is
//! counted when that happens, for it may never come back to be told.

use std::sync::atomic::{AtomicU64, Ordering};

/// Viewers, and which of them have taken the newest update.
#[derive(Debug, Default)]
pub(super) struct Attendance {
    present: AtomicU64,
    taken: AtomicU64,
}

impl Attendance {
    /// A viewer takes the newest update, its first or another one.
    pub fn take(&self, is_first: bool) {
        self.taken.fetch_add(1, Ordering::Relaxed);
        self.present.fetch_add(u64::from(is_first), Ordering::Relaxed);
    }

    /// A viewer who has taken an update leaves.
    pub fn leave(&self) {
        self.present.fetch_sub(1, Ordering::Relaxed);
    }

    /// The next update is there; tells how many viewers have not taken the one
    /// before, and never will.
    pub fn next_update(&self) -> u64 {
        let taken = self.taken.swap(0, Ordering::Relaxed);
        self.present.load(Ordering::Relaxed).saturating_sub(taken)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn who_has_not_taken_an_update_when_the_next_comes_has_missed_it() {
        let attendance = Attendance::default();
        assert_eq!(attendance.next_update(), 0);
        attendance.take(true);
        attendance.take(true);
        assert_eq!(attendance.next_update(), 0);
        attendance.take(false);
        assert_eq!(attendance.next_update(), 1);
        assert_eq!(attendance.next_update(), 2);
        attendance.leave();
        assert_eq!(attendance.next_update(), 1);
        attendance.take(false);
        attendance.leave();
        assert_eq!(attendance.next_update(), 0);
    }
}
