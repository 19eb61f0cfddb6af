//! The server that the Foxglove app connects to: the channels of a log, as
//! messages come.

use std::collections::BTreeMap;
use std::net::SocketAddr;
use std::sync::Arc;
use std::time::Duration;

use foxglove::websocket::Status;
use foxglove::{ChannelBuilder, Context, PartialMetadata, RawChannel, Schema, WebSocketServer, WebSocketServerHandle};
use tokio::runtime::{Builder, Runtime};

use super::Run;
use super::outlet::Outlet;
use crate::config::Problem;
use crate::event::Event;
use crate::log::{Catalogue, LogError, Medium, Messages};
use crate::time::Instant;

/// How long the last messages may take to arrive.
const GOODBYE: Duration = Duration::from_millis(300);

/// Foxglove's own server, on a thread of its own. An app that reads too slowly
/// loses the oldest messages.
pub(super) struct Foxglove {
    runtime: Option<Runtime>,
    server: Option<WebSocketServerHandle>,
    address: SocketAddr,
    context: Arc<Context>,
    run: Option<(Messages, Channels)>,
}

impl Foxglove {
    /// Serves at `address`.
    pub fn serve(address: SocketAddr) -> Result<Self, Problem> {
        let context = Context::new();
        let runtime = Builder::new_multi_thread()
            .worker_threads(1)
            .thread_name("live-foxglove")
            .enable_all()
            .build()
            .map_err(|error| cannot(address, &error))?;
        // It advertises no capability: there is nothing that an app could ask for.
        let server = WebSocketServer::new()
            .name(concat!("canloop ", env!("CARGO_PKG_VERSION")))
            .context(&context)
            .bind(address.ip().to_string(), address.port());
        let server = runtime.block_on(server.start()).map_err(|error| cannot(address, &error))?;
        let address = SocketAddr::new(address.ip(), server.port());
        Ok(Self { runtime: Some(runtime), server: Some(server), address, context, run: None })
    }

    /// Where it is, for people: the app is told so under "Open connection".
    pub fn url(&self) -> String {
        format!("ws://{}", self.address)
    }
}

fn cannot(address: SocketAddr, error: &dyn std::fmt::Display) -> Problem {
    Problem::bare(format!("cannot serve the Foxglove app at {address}: {error}")).help(format!(
        "choose another address, such as --foxglove {}:{}; port 0 takes one that is free",
        address.ip(),
        address.port().wrapping_add(1)
    ))
}

impl Outlet for Foxglove {
    fn begin(&mut self, run: &Run<'_>) {
        self.run = None;
        let mut channels = Channels::new(&self.context);
        match (Messages::new(run.contents, &mut channels), &self.server) {
            (Ok(messages), _) => self.run = Some((messages, channels)),
            (Err(error), Some(server)) => server.publish_status(Status::error(error.to_string())),
            (Err(_), None) => {}
        }
    }

    fn wants_exchange(&self) -> bool {
        true
    }

    fn take(&mut self, events: &[(Instant, Event)]) {
        if let Some((messages, channels)) = &mut self.run {
            events.iter().for_each(|(at, event)| messages.put(channels, *at, event));
        }
    }

    fn lose(&mut self, events: u64) {
        if let Some((messages, channels)) = &mut self.run {
            messages.put_lost(channels, None, events);
        }
    }

    fn show(&mut self) {}

    fn end(&mut self, _: &str) {}
}

impl Drop for Foxglove {
    fn drop(&mut self) {
        let (Some(runtime), Some(server)) = (self.runtime.take(), self.server.take()) else { return };
        runtime.block_on(async {
            // The messages are out with their clients' tasks, which stop when asked to.
            tokio::time::sleep(GOODBYE / 3).await;
            let _ = tokio::time::timeout(GOODBYE, server.stop().wait()).await;
        });
        runtime.shutdown_background();
    }
}

/// The channels of a run. As in a log, each is there from its first message on.
struct Channels {
    context: Arc<Context>,
    /// The schema with id n is at n.
    schemas: Vec<Schema>,
    /// By channel id.
    channels: Vec<Channel>,
    /// A message in the making.
    message: Vec<u8>,
}

struct Channel {
    schema_id: u16,
    topic: String,
    message_encoding: String,
    metadata: BTreeMap<String, String>,
    raw: Option<Arc<RawChannel>>,
}

impl Channels {
    fn new(context: &Arc<Context>) -> Self {
        Self { context: Arc::clone(context), schemas: Vec::new(), channels: Vec::new(), message: Vec::new() }
    }
}

impl Catalogue for Channels {
    fn schema(&mut self, name: &str, encoding: &str, data: &[u8]) -> Result<u16, LogError> {
        let id = u16::try_from(self.schemas.len()).map_err(|_| LogError::TooManyChannels)?;
        self.schemas.push(Schema::new(name, encoding, data.to_vec()));
        Ok(id)
    }

    fn channel(
        &mut self,
        schema_id: u16,
        topic: String,
        message_encoding: &str,
        metadata: BTreeMap<String, String>,
    ) -> Result<u16, LogError> {
        let id = u16::try_from(self.channels.len()).map_err(|_| LogError::TooManyChannels)?;
        let message_encoding = message_encoding.to_owned();
        self.channels.push(Channel { schema_id, topic, message_encoding, metadata, raw: None });
        Ok(id)
    }
}

impl Medium for Channels {
    fn message(&mut self, channel_id: u16, at: Instant, write: impl FnOnce(&mut Vec<u8>)) {
        let channel = &mut self.channels[usize::from(channel_id)];
        let schema = &self.schemas[usize::from(channel.schema_id)];
        let raw = channel.raw.get_or_insert_with(|| {
            ChannelBuilder::new(&channel.topic)
                .context(&self.context)
                .message_encoding(&channel.message_encoding)
                .schema(schema.clone())
                .metadata(channel.metadata.clone())
                .build_raw()
                .expect("it has an encoding")
        });
        if raw.has_sinks() {
            self.message.clear();
            write(&mut self.message);
            let log_time = u64::try_from(at.as_nanos()).unwrap_or(0);
            raw.log_with_meta(&self.message, PartialMetadata::with_log_time(log_time));
        }
    }
}

impl Drop for Channels {
    fn drop(&mut self) {
        self.channels.iter().filter_map(|channel| channel.raw.as_ref()).for_each(|raw| raw.close());
    }
}
