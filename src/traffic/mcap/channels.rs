//! Which channels of a file have frames in them.

use std::collections::BTreeMap;

use mcap::records::{Channel, SchemaHeader};

use crate::log::FRAME_NAME;
use crate::traffic::Direction;

/// A channel with frames.
#[derive(Clone, Debug)]
pub(super) struct FrameChannel {
    pub layout: Layout,
    /// The bus, where the messages do not say.
    pub bus: String,
    /// Where the messages do not say.
    pub direction: Direction,
}

/// How a frame lies in a message.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Layout {
    /// `can_msgs/msg/Frame` in CDR.
    Ros,
    /// `ros2_socketcan_msgs/msg/FdFrame` in CDR.
    RosFd,
    /// `canloop.CanFdFrame` in protobuf.
    Fd,
    /// `canloop.Lost` in protobuf.
    Lost,
}

/// What the schemas and channels so far have said.
#[derive(Default)]
pub(super) struct Channels {
    schemas: BTreeMap<u16, Layout>,
    channels: BTreeMap<u16, FrameChannel>,
}

impl Channels {
    /// Hears of a schema.
    pub fn schema(&mut self, header: &SchemaHeader) {
        let layout = match header.name.as_str() {
            FRAME_NAME | "can_msgs/Frame" => Layout::Ros,
            "ros2_socketcan_msgs/msg/FdFrame" => Layout::RosFd,
            "canloop.CanFdFrame" => Layout::Fd,
            "canloop.Lost" => Layout::Lost,
            _ => return,
        };
        self.schemas.insert(header.id, layout);
    }

    /// Hears of a channel.
    pub fn channel(&mut self, channel: &Channel) {
        let encoding = channel.message_encoding.as_str();
        let layout = match self.schemas.get(&channel.schema_id) {
            Some(layout @ (Layout::Ros | Layout::RosFd)) if encoding == "cdr" => *layout,
            Some(layout @ (Layout::Fd | Layout::Lost)) if encoding == "protobuf" => *layout,
            _ => return,
        };
        let sent = channel.metadata.get("direction").is_some_and(|word| word.starts_with("sent"));
        let direction = if sent { Direction::Sent } else { Direction::Received };
        let topic = channel.topic.strip_prefix("/can/").unwrap_or(channel.topic.trim_start_matches('/'));
        let bus = match layout {
            Layout::Fd => topic.strip_suffix("/fd").unwrap_or(topic),
            Layout::Lost => topic.strip_suffix("/lost").unwrap_or(topic),
            Layout::Ros | Layout::RosFd => topic,
        };
        self.channels.insert(channel.id, FrameChannel { layout, bus: bus.to_owned(), direction });
    }

    /// The channel with that id, if it has frames.
    pub fn get(&self, id: u16) -> Option<&FrameChannel> {
        self.channels.get(&id)
    }
}
