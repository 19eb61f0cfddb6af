//! Vector's binary logs, `.blf`: a header, then objects, most of them in
//! containers that zlib has compressed. The layouts are those of Vector's
//! `binlog.h` as vector_blf and python-can have them.
//!
//! Read by our own code: the `ablf` crate stops or skips without a word where
//! a file is damaged, keeps no offsets, and does not write.

mod containers;
mod header;
mod objects;
mod reader;
mod writer;

pub(super) use reader::BlfReader;
pub(super) use writer::BlfWriter;

/// Begins every object.
const MARK: &[u8; 4] = b"LOBJ";
/// Mark, header size, header version, object size, object type.
const OBJECT_BASE_BYTES: usize = 4 + 2 + 2 + 4 + 4;
/// Behind that flags, client, version, time.
const OBJECT_HEADER_BYTES: usize = OBJECT_BASE_BYTES + 4 + 2 + 2 + 8;

/// Object types that we know.
mod kind {
    pub const CAN_MESSAGE: u32 = 1;
    pub const CAN_ERROR: u32 = 2;
    pub const CONTAINER: u32 = 10;
    pub const APP_TEXT: u32 = 65;
    pub const CAN_ERROR_EXT: u32 = 73;
    pub const CAN_MESSAGE2: u32 = 86;
    pub const CAN_FD_MESSAGE: u32 = 100;
    pub const CAN_FD_MESSAGE_64: u32 = 101;
    pub const CAN_FD_ERROR_64: u32 = 104;
}
