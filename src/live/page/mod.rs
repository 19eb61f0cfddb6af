//! The page: one HTML file, and a stream of updates to whoever has it open.

mod attendance;
mod connection;
mod document;
mod request;
mod viewer;

use std::net::{SocketAddr, TcpListener};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread::{Builder, JoinHandle};

use tokio::sync::{Semaphore, watch};

use super::Run;
use super::outlet::Outlet;
use super::view::View;
use crate::config::Problem;
use crate::event::{Event, Sink};
use crate::time::Instant;
use attendance::Attendance;
use document::Document;

/// Those who may look on at once.
const VIEWERS: usize = 16;

/// Serves the page on a thread of its own.
pub(super) struct Page {
    shared: Arc<Shared>,
    address: SocketAddr,
    /// Runs so far.
    runs: u64,
    thread: Option<JoinHandle<()>>,
}

/// What the page's thread and the feed's thread have in common.
struct Shared {
    document: Document,
    view: Mutex<Option<View>>,
    pulse: watch::Sender<Pulse>,
    viewers: Arc<Semaphore>,
    attendance: Attendance,
}

/// Tells viewers that there is news.
#[derive(Clone, Copy, Debug, Default)]
struct Pulse {
    /// Counts the updates.
    update: u64,
    /// This is the last one.
    is_last: bool,
}

impl Page {
    /// Serves at `address`, and nothing else there.
    pub fn serve(address: SocketAddr) -> Result<Self, Problem> {
        let cannot = |error: std::io::Error| {
            Problem::bare(format!("cannot serve the live view at {address}: {error}")).help(format!(
                "choose another address, such as --live {}:{}; port 0 takes one that is free",
                address.ip(),
                address.port().wrapping_add(1)
            ))
        };
        let listener = TcpListener::bind(address).map_err(cannot)?;
        listener.set_nonblocking(true).map_err(cannot)?;
        let address = listener.local_addr().map_err(cannot)?;
        let shared = Arc::new(Shared {
            document: Document::new(),
            view: Mutex::new(None),
            pulse: watch::Sender::new(Pulse::default()),
            viewers: Arc::new(Semaphore::new(VIEWERS)),
            attendance: Attendance::default(),
        });
        let runtime =
            tokio::runtime::Builder::new_current_thread().enable_io().enable_time().build().map_err(cannot)?;
        let serve = {
            let shared = Arc::clone(&shared);
            move || runtime.block_on(connection::serve(listener, shared))
        };
        let thread = Builder::new().name("live-page".to_owned()).spawn(serve).map_err(cannot)?;
        Ok(Self { shared, address, runs: 0, thread: Some(thread) })
    }

    /// Where it is, for people.
    pub fn url(&self) -> String {
        format!("http://{}/", self.address)
    }
}

impl Shared {
    fn view(&self) -> MutexGuard<'_, Option<View>> {
        self.view.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn change(&self, change: impl FnOnce(&mut View)) {
        if let Some(view) = self.view().as_mut() {
            change(view);
        }
    }

    fn update(&self, is_last: bool) {
        let missed = self.attendance.next_update();
        self.change(|view| view.miss_updates(missed));
        self.pulse.send_modify(|pulse| *pulse = Pulse { update: pulse.update + 1, is_last });
    }
}

impl Outlet for Page {
    fn begin(&mut self, run: &Run<'_>) {
        self.runs += 1;
        *self.shared.view() = Some(View::new(run, self.runs));
        self.show();
    }

    fn take(&mut self, events: &[(Instant, Event)]) {
        self.shared.change(|view| events.iter().for_each(|(at, event)| view.event(*at, event)));
    }

    fn lose(&mut self, events: u64) {
        self.shared.change(|view| view.lose_events(events));
    }

    fn show(&mut self) {
        self.shared.update(false);
    }

    fn end(&mut self, verdict: &str) {
        self.shared.change(|view| view.end(verdict));
        self.show();
    }
}

impl Drop for Page {
    fn drop(&mut self) {
        self.shared.update(true);
        if let Some(thread) = self.thread.take() {
            // A thread that panicked has said so itself.
            let _ = thread.join();
        }
    }
}
