//! Binary logs as other tools write them, byte by byte.

use std::io::Write as _;

use flate2::Compression;
use flate2::write::ZlibEncoder;

use crate::rig::read_text;

/// A BLF object: its head in version 1 or 2, its stamp, its body.
fn object(kind: u32, version: u16, flags: u32, stamp: u64, body: &[u8]) -> Vec<u8> {
    let head: u16 = if version == 1 { 32 } else { 40 };
    let mut out = b"LOBJ".to_vec();
    out.extend(head.to_le_bytes());
    out.extend(version.to_le_bytes());
    out.extend((u32::from(head) + body.len() as u32).to_le_bytes());
    out.extend(kind.to_le_bytes());
    out.extend(flags.to_le_bytes());
    out.extend([0; 4]);
    out.extend(stamp.to_le_bytes());
    if version == 2 {
        out.extend([0; 8]);
    }
    out.extend(body);
    out.resize(out.len() + body.len() % 4, 0);
    out
}

/// A container with `bytes`.
fn container(bytes: &[u8], method: u16) -> Vec<u8> {
    let content = match method {
        0 => bytes.to_vec(),
        _ => {
            let mut encoder = ZlibEncoder::new(Vec::new(), Compression::default());
            encoder.write_all(bytes).unwrap();
            encoder.finish().unwrap()
        }
    };
    let mut out = b"LOBJ\x10\0\x01\0".to_vec();
    out.extend((32 + content.len() as u32).to_le_bytes());
    out.extend(10_u32.to_le_bytes());
    out.extend(method.to_le_bytes());
    out.extend([0; 6]);
    out.extend((bytes.len() as u32).to_le_bytes());
    out.extend([0; 4]);
    out.extend(&content);
    out.resize(out.len() + content.len() % 4, 0);
    out
}

/// The header of a file whose measurement began on 30 September 2017.
fn header() -> Vec<u8> {
    let mut out = b"LOGG\x90\0\0\0\x02\0\0\0\x04\x07\x06\0".to_vec();
    out.resize(40, 0);
    let start: [u16; 8] = [2017, 9, 6, 30, 15, 6, 13, 191];
    out.extend(start.iter().flat_map(|part| part.to_le_bytes()));
    out.resize(144, 0);
    out
}

fn classic(channel: u16, flags: u8, dlc: u8, id: u32) -> Vec<u8> {
    let mut body = channel.to_le_bytes().to_vec();
    body.extend([flags, dlc]);
    body.extend(id.to_le_bytes());
    body.extend([1, 2, 3, 4, 5, 6, 7, 8]);
    body
}

/// CAN_FD_MESSAGE_64 with `data`, of which `valid` bytes count, and perhaps
/// more behind it.
fn fd_64(dlc: u8, valid: u8, flags: u32, direction: u8, data: &[u8], more: &[u8]) -> Vec<u8> {
    let mut body = vec![2, dlc, valid, 0];
    body.extend((0x123_u32).to_le_bytes());
    body.extend([0; 4]);
    body.extend(flags.to_le_bytes());
    body.extend([0; 16]);
    body.extend([0, 0, direction, if more.is_empty() { 0 } else { 32 + 40 + data.len() as u8 }]);
    body.extend([0; 4]);
    body.extend(data);
    body.extend(more);
    body
}

#[test]
fn blf_of_canoe() {
    let mut second = classic(3, 0x80, 8, 0x8000_0456);
    second.extend([0; 8]);
    let objects = [
        object(1, 1, 2, 1_000, &classic(1, 0, 3, 0x123)),
        // In tens of microseconds, with the longer head of CAN_MESSAGE2.
        object(86, 2, 1, 5, &second),
        // A kind that nobody here knows, of a length that fills up oddly.
        object(200, 1, 2, 0, b"12345"),
        object(101, 1, 2, 3_000, &fd_64(9, 12, 0x3000, 1, &[0xAA; 12], &[])),
        // Fewer bytes than the length code says, and bit timing behind them.
        object(101, 1, 2, 4_000, &fd_64(15, 64, 0x5000, 0, &[0xBB; 4], &[9; 8])),
        object(101, 1, 2, 5_000, &fd_64(4, 0, 0x10, 0, &[], &[])),
        object(2, 1, 2, 6_000, &[1, 0, 0, 0, 0, 0, 0, 0]),
        object(104, 1, 2, 7_000, &[2; 60]),
        object(1, 1, 2, 8_000, &classic(1, 1, 12, 0x7FF)),
    ]
    .concat();
    let expected = [
        "1506783973191001000 can0 Received 123#010203".to_owned(),
        "1506783973191050000 can2 Received 00000456#R8".to_owned(),
        "1506783973191003000 can1 Sent 123##1AAAAAAAAAAAAAAAAAAAAAAAA".to_owned(),
        format!("1506783973191004000 can1 Received 123##0BBBBBBBB{} ESI", "00".repeat(60)),
        "1506783973191005000 can1 Received 123#R4".to_owned(),
        "1506783973191006000 can0 Received error 80 [00, 00, 00, 00, 00, 00, 00, 00]".to_owned(),
        "1506783973191007000 can1 Received error 80 [00, 00, 00, 00, 00, 00, 00, 00]".to_owned(),
        "1506783973191008000 can0 Sent 7FF#0102030405060708_C".to_owned(),
    ];
    // Without containers; in one; cut across the objects, stored and compressed.
    let bare = objects.clone();
    let whole = container(&objects, 2);
    let pieces: Vec<u8> = objects
        .chunks(37)
        .enumerate()
        .flat_map(|(at, piece)| container(piece, if at % 2 == 0 { 2 } else { 0 }))
        .collect();
    for body in [bare, whole, pieces] {
        let log = read_text("x.blf", [header(), body].concat());
        assert_eq!(log.lines(), expected);
    }
}

/// A packet of a `.pcap` file, big-endian and in microseconds.
fn packet(micros: u32, bytes: &[u8]) -> Vec<u8> {
    let len = bytes.len() as u32;
    let mut out: Vec<u8> = [1_436_509_052, micros, len, len].iter().flat_map(|word: &u32| word.to_be_bytes()).collect();
    out.extend(bytes);
    out
}

fn pcap_header(link: u32) -> Vec<u8> {
    let mut out = b"\xA1\xB2\xC3\xD4\0\x02\0\x04\0\0\0\0\0\0\0\0\0\x04\0\0".to_vec();
    out.extend(link.to_be_bytes());
    out
}

#[test]
fn pcap_of_tcpdump() {
    let classic = b"\0\0\x01\x23\x02\0\0\0\xAA\xBB\0\0\0\0\0\0";
    let short = b"\x80\0\x01\x23\x01\0\0\0\xCC";
    let mut fd = b"\0\0\x01\x23\x0C\x01\0\0".to_vec();
    fd.extend([7; 64]);
    let body = [packet(1, classic), packet(2, short), packet(3, &fd)].concat();
    let expected = [
        "1436509052000001000 can0 Received 123#AABB",
        "1436509052000002000 can0 Received 00000123#CC",
        "1436509052000003000 can0 Received 123##1070707070707070707070707",
    ];
    assert_eq!(read_text("x.pcap", [pcap_header(227), body].concat()).lines(), expected);

    // Captured on all interfaces: 4 is outgoing, 280 a CAN interface, 0x0C its protocol.
    let cooked = |kind: u8, protocol: u8, frame: &[u8]| {
        [&[0, kind, 1, 0x18, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, protocol], frame].concat()
    };
    let body = [packet(1, &cooked(4, 0x0C, classic)), packet(2, &cooked(1, 0x0D, &fd))].concat();
    let expected =
        ["1436509052000001000 can0 Sent 123#AABB", "1436509052000002000 can0 Received 123##1070707070707070707070707"];
    assert_eq!(read_text("x.pcap", [pcap_header(113), body].concat()).lines(), expected);
}
