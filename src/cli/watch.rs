//! `--live` and `--foxglove`: looking on while something runs.

use std::net::SocketAddr;

use super::say;
use crate::config::Problem;
use crate::live::{Addresses, FOXGLOVE_ADDRESS, Live, PAGE_ADDRESS, parse_address};

/// Where to look on, if anybody wants to.
#[derive(Clone, Copy, Debug, clap::Args)]
pub struct WatchArgs {
    /// Serve a page that shows the run as it goes on, on this machine only [default address: 127.0.0.1:8766]
    #[arg(long, value_name = "ADDR:PORT", num_args = 0..=1, default_missing_value = PAGE_ADDRESS,
          value_parser = parse_address)]
    live: Option<SocketAddr>,
    /// Serve the Foxglove app, on this machine only [default address: 127.0.0.1:8765]
    #[arg(long, value_name = "ADDR:PORT", num_args = 0..=1, default_missing_value = FOXGLOVE_ADDRESS,
          value_parser = parse_address)]
    foxglove: Option<SocketAddr>,
}

impl WatchArgs {
    /// Whether anybody wants to look on.
    pub const fn is_watched(&self) -> bool {
        self.live.is_some() || self.foxglove.is_some()
    }

    /// Starts to serve what is wanted, and says where.
    ///
    /// # Errors
    /// An address that cannot be had, or a view that this program was built
    /// without.
    pub fn open(&self) -> Result<Live, Problem> {
        let live = Live::open(&Addresses { page: self.live, foxglove: self.foxglove })?;
        live.places().iter().for_each(say);
        Ok(live)
    }
}
