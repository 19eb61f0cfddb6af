//! One who looks on: gets what is new each time there is news and room for it.

use std::convert::Infallible;
use std::sync::Arc;

use futures_util::Stream;
use futures_util::stream::unfold;
use hyper::body::{Bytes, Frame};
use tokio::sync::{OwnedSemaphorePermit, watch};

use super::{Pulse, Shared};
use crate::live::view::Seen;

/// A viewer whose browser has asked for updates.
struct Viewer {
    shared: Arc<Shared>,
    pulse: watch::Receiver<Pulse>,
    /// The update before the next.
    last: Option<Pulse>,
    seen: Seen,
    /// Its place among those who may look on.
    _place: OwnedSemaphorePermit,
}

/// How soon a browser is to ask again when the updates end, and a first word.
const HELLO: &str = "retry: 1000\n\n";

/// Updates as server-sent events (<https://html.spec.whatwg.org/multipage/server-sent-events.html>),
/// each made when the connection has room for it. None if all places are taken.
pub(super) fn updates(shared: &Arc<Shared>) -> Option<impl Stream<Item = Result<Frame<Bytes>, Infallible>> + use<>> {
    let place = Arc::clone(&shared.viewers).try_acquire_owned().ok()?;
    let mut pulse = shared.pulse.subscribe();
    // What there is already is news to a new viewer.
    pulse.mark_changed();
    let viewer = Viewer { shared: Arc::clone(shared), pulse, last: None, seen: Seen::default(), _place: place };
    Some(unfold(viewer, Viewer::next))
}

impl Viewer {
    async fn next(mut self) -> Option<(Result<Frame<Bytes>, Infallible>, Self)> {
        if self.last.is_some_and(|pulse| pulse.is_last) {
            return None;
        }
        let pulse = *self.pulse.wait_for(|pulse| self.last.is_none_or(|last| pulse.update > last.update)).await.ok()?;
        let hello = if self.last.is_none() { HELLO } else { "" };
        self.shared.attendance.take(self.last.is_none());
        self.last = Some(pulse);
        let news = self.shared.view().as_ref().map(|view| view.news(&mut self.seen));
        let text = news.map_or_else(|| format!("{hello}:\n\n"), |news| format!("{hello}data: {news}\n\n"));
        Some((Ok(Frame::data(Bytes::from(text))), self))
    }
}

impl Drop for Viewer {
    fn drop(&mut self) {
        if self.last.is_some() {
            self.shared.attendance.leave();
        }
    }
}
