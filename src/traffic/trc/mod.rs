//! PEAK's text logs, `.trc`, of all versions, as PCAN-View, PCAN-Explorer and
//! python-can write them (`PEAK_CAN_TRC_File_Format.pdf`).

mod reader;
mod start_time;
mod writer;

pub(super) use reader::Trc;
pub(super) use writer::TrcWriter;
