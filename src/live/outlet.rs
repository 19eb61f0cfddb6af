//! What a feed's thread hands events to.

use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use super::Run;
use crate::event::Event;
use crate::time::Instant;

/// Shows runs, one after the other, to whoever looks on.
pub(super) trait Outlet: Send {
    /// A run begins.
    fn begin(&mut self, run: &Run<'_>);

    /// Whether it has a use for [`Event::Exchange`].
    fn wants_exchange(&self) -> bool {
        false
    }

    /// Things happened, in the order of their times.
    fn take(&mut self, events: &[(Instant, Event)]);

    /// So many more events found no room on their way here.
    fn lose(&mut self, events: u64);

    /// Time has come to show what is new.
    fn show(&mut self);

    /// The run is over; says how it ended.
    fn end(&mut self, verdict: &str);
}

/// All that a run is shown by.
pub(super) type Outlets = Arc<Mutex<Vec<Box<dyn Outlet>>>>;

/// The outlets; one that has panicked keeps nobody from the others.
pub(super) fn lock(outlets: &Outlets) -> MutexGuard<'_, Vec<Box<dyn Outlet>>> {
    outlets.lock().unwrap_or_else(PoisonError::into_inner)
}
