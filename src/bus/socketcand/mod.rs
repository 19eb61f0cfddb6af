//! A bus without kernel CAN: the public socketcand protocol over TCP.
//!
//! [`Socketcand`] is a client, of a real socketcand gateway or of ours.
//! [`Hub`] is ours: a user-space bus for several clients, on which the program
//! that hosts it takes part too. Both are a [`crate::bus::Bus`].
//!
//! The protocol is text, `< hi >` and the like; a client opens a bus by name,
//! switches to raw mode, and from then on each side writes frames:
//!
//! ```text
//! server: < hi >
//! client: < open can0 >        server: < ok >
//! client: < rawmode >          server: < ok >
//! client: < send 123 2 11 f2 >
//! server: < frame 123 1700000000.123456 11F2 >
//! ```
//!
//! Source: `doc/protocol.md` of the socketcand project, and what its server
//! really writes where the two differ. CAN FD frames travel as its newer
//! versions write them (`fdsend`, `fdframe`); a server that is too old for
//! them, or for remote requests, answers with an error, which ends the
//! connection with a message instead of losing frames in silence.

mod buffers;
mod client;
mod endpoint;
mod hub;
mod member;
pub mod protocol;
mod wait;

pub use client::Socketcand;
pub use endpoint::{DEFAULT_PORT, Endpoint};
pub use hub::{Hub, HubCounts};
