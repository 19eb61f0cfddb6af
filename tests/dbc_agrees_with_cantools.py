"""What cantools makes of DBC files: python dbc_agrees_with_cantools.py COUNT FILE...

Prints a line of JSON a file: null where cantools does not load it even when it
is not strict, else a list of its messages with their signals and, of messages
that are sound, COUNT random payloads, decoded and encoded again. Half of the
payloads of a multiplexed message have switch values that select something.
Decoded numbers are the 16 hex digits of a binary64, to lose none of them."""

import json
import logging
import pathlib
import random
import struct
import sys

import cantools


def to_hex(number):
    try:
        return struct.pack(">d", float(number)).hex()
    except OverflowError:
        return None


def places(signal):
    """Where the bits lie, highest first, as (byte, bit)."""
    if signal.byte_order == "little_endian":
        bits = [divmod(signal.start + index, 8) for index in range(signal.length)]
        return bits[::-1]
    first = signal.start // 8 * 8 + 7 - signal.start % 8
    return [(bit // 8, 7 - bit % 8) for bit in range(first, first + signal.length)]


def put(payload, signal, raw):
    for at, (byte, bit) in enumerate(places(signal)):
        level = raw >> (signal.length - 1 - at) & 1
        payload[byte] = payload[byte] & ~(1 << bit) | level << bit


def select(chance, payload, message, tree):
    for node in tree:
        if isinstance(node, dict):
            (name, children), = node.items()
            value = chance.choice(sorted(children))
            put(payload, message.get_signal_by_name(name), value)
            select(chance, payload, message, children[value])


def payloads(chance, message, count):
    for index in range(count):
        payload = bytearray(chance.randbytes(message.length))
        if message.is_multiplexed() and index % 2:
            select(chance, payload, message, message.signal_tree)
        yield bytes(payload)


def exchanges(chance, message, count):
    try:
        message.refresh(strict=True)
    except cantools.database.errors.Error:
        return None
    found = []
    for payload in payloads(chance, message, count):
        try:
            decoded = message.decode(payload, decode_choices=False)
        except cantools.database.errors.DecodeError:
            found.append([payload.hex(), None, None])
            continue
        try:
            encoded = message.encode(decoded, strict=False).hex()
        except Exception:
            encoded = None
        found.append([payload.hex(), {name: to_hex(value) for name, value in decoded.items()}, encoded])
    return found


def signal(signal):
    return {
        "name": signal.name,
        "start": signal.start,
        "length": signal.length,
        "motorola": signal.byte_order == "big_endian",
        "signed": signal.is_signed and not signal.is_float,
        "float": signal.is_float,
        "factor": to_hex(signal.scale),
        "offset": to_hex(signal.offset),
        "range": None if signal.minimum is None else [to_hex(signal.minimum), to_hex(signal.maximum)],
        "unit": signal.unit or "",
        "start_value": None if signal.raw_initial is None else to_hex(signal.raw_initial),
        "names": sorted([str(value), str(name)] for value, name in (signal.choices or {}).items()),
        "switch": signal.multiplexer_signal,
        "switch_values": sorted(signal.multiplexer_ids or []) if signal.multiplexer_signal else [],
    }


def encoding(path):
    """Windows-1252 is what they take all files for."""
    try:
        pathlib.Path(path).read_text("utf-8")
        return "utf-8"
    except UnicodeDecodeError:
        return "cp1252"


def messages(path, count):
    chance = random.Random(1)
    try:
        database = cantools.database.load_file(path, encoding=encoding(path), strict=False)
    except Exception:
        return None
    return [
        {
            "name": message.name,
            "id": message.frame_id,
            "extended": message.is_extended_frame,
            "fd": message.is_fd,
            "length": message.length,
            "cycle_ms": message.cycle_time,
            "signals": [signal(one) for one in message.signals],
            "exchanges": exchanges(chance, message, count),
        }
        for message in database.messages
    ]


logging.disable(logging.CRITICAL)
for path in sys.argv[2:]:
    print(json.dumps(messages(path, int(sys.argv[1]))))
