//! A run as it goes on, for people who look on: a page in their browser, and
//! the Foxglove app.
//!
//! A loop gives its events to a [`Feed`], which is a queue without locks; a
//! thread of the feed's own hands them to whoever shows them. Nothing comes
//! back: who looks on cannot command, and who looks on slowly misses updates,
//! which are counted, and never holds up the loop.

mod address;
mod feed;
#[cfg(feature = "foxglove")]
mod foxglove;
mod outlet;
#[cfg(feature = "live")]
mod page;
pub mod view;

use std::fmt;
use std::net::SocketAddr;
use std::sync::{Arc, Mutex};

pub use address::{FOXGLOVE_ADDRESS, PAGE_ADDRESS, parse_address};
pub use feed::Feed;

use crate::config::Problem;
use crate::log::LogContents;
use crate::stack::StackConfig;
use crate::time::Instant;
use outlet::{Outlet, Outlets};

/// What those who look on are told of a run before its first event.
#[derive(Clone, Copy, Debug)]
pub struct Run<'a> {
    /// What it is called, such as the scenario's name.
    pub name: &'a str,
    /// The program that it runs in.
    pub program: &'static str,
    /// The moment that its time is counted from.
    pub start: Instant,
    /// How long it is to last, s; none where nobody knows.
    pub duration_s: Option<f64>,
    /// What its stack is made from, or would be.
    pub stack: &'a StackConfig,
    /// The nominal bit rate of its bus, where there is a bus and it is known.
    pub bit_rate_bit_s: Option<u32>,
    /// Its buses, and the names of what is planned.
    pub contents: &'a LogContents<'a>,
}

/// Where to serve what; both are loopback addresses.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Addresses {
    /// The page.
    pub page: Option<SocketAddr>,
    /// The Foxglove app's server.
    pub foxglove: Option<SocketAddr>,
}

/// Serves runs, one after the other, to whoever looks on.
pub struct Live {
    outlets: Outlets,
    /// For people: what can be seen where.
    places: Vec<String>,
}

impl Live {
    /// Starts to serve.
    ///
    /// # Errors
    /// An address that cannot be had, or a view that this program was built
    /// without.
    pub fn open(addresses: &Addresses) -> Result<Self, Problem> {
        let mut live = Self { outlets: Arc::new(Mutex::new(Vec::new())), places: Vec::new() };
        if let Some(address) = addresses.page {
            live.add("live view", open_page(address)?);
        }
        if let Some(address) = addresses.foxglove {
            live.add("foxglove", open_foxglove(address)?);
        }
        Ok(live)
    }

    /// What can be seen where, a line each: a name and a URL.
    pub fn places(&self) -> &[String] {
        &self.places
    }

    /// Whether anything is served.
    pub fn is_watched(&self) -> bool {
        !self.places.is_empty()
    }

    /// A run begins: its events go into the feed. The feed's memory is taken
    /// and its thread started now, so a loop in real time begins before it
    /// raises its own priority, which the thread would inherit.
    pub fn begin(&self, run: &Run<'_>) -> Feed {
        outlet::lock(&self.outlets).iter_mut().for_each(|outlet| outlet.begin(run));
        Feed::start(Arc::clone(&self.outlets))
    }

    fn add(&mut self, name: &str, (outlet, url): (Box<dyn Outlet>, String)) {
        outlet::lock(&self.outlets).push(outlet);
        self.places.push(format!("{name:<16} {url}"));
    }
}

impl fmt::Debug for Live {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        out.debug_struct("Live").field("places", &self.places).finish_non_exhaustive()
    }
}

#[cfg(feature = "live")]
fn open_page(address: SocketAddr) -> Result<(Box<dyn Outlet>, String), Problem> {
    let page = page::Page::serve(address)?;
    let url = page.url();
    Ok((Box::new(page), url))
}

#[cfg(not(feature = "live"))]
fn open_page(_: SocketAddr) -> Result<(Box<dyn Outlet>, String), Problem> {
    Err(not_built("live", "live view"))
}

#[cfg(feature = "foxglove")]
fn open_foxglove(address: SocketAddr) -> Result<(Box<dyn Outlet>, String), Problem> {
    let foxglove = foxglove::Foxglove::serve(address)?;
    let url = foxglove.url();
    Ok((Box::new(foxglove), url))
}

#[cfg(not(feature = "foxglove"))]
fn open_foxglove(_: SocketAddr) -> Result<(Box<dyn Outlet>, String), Problem> {
    Err(not_built("foxglove", "server for the Foxglove app"))
}

#[cfg(not(all(feature = "live", feature = "foxglove")))]
fn not_built(feature: &str, what: &str) -> Problem {
    Problem::bare(format!("--{feature}: this program was built without the {what}"))
        .help(format!("build it with it: cargo install --path . --features {feature} (or --path hil-sim)"))
}
