"""Decodes and encodes with cantools what the test asks for on stdin, as JSON:
{"dbc": PATH, "decode": [[MESSAGE, HEX], ...], "encode": [[MESSAGE, {SIGNAL: NUMBER}], ...]}.
Numbers go both ways as the 16 hex digits of a binary64, to lose none of them."""

import json
import struct
import sys
import warnings

import cantools


def to_hex(number):
    return struct.pack(">d", float(number)).hex()


def from_hex(digits):
    number = struct.unpack(">d", bytes.fromhex(digits))[0]
    return int(number) if number.is_integer() else number


warnings.simplefilter("error")
asked = json.load(sys.stdin)
database = cantools.database.load_file(asked["dbc"], strict=True)
decoded = []
for name, data in asked["decode"]:
    signals = database.get_message_by_name(name).decode(bytes.fromhex(data), decode_choices=False)
    decoded.append({signal: to_hex(number) for signal, number in signals.items()})
encoded = []
for name, signals in asked["encode"]:
    signals = {signal: from_hex(digits) for signal, digits in signals.items()}
    encoded.append(database.get_message_by_name(name).encode(signals, strict=False).hex())
json.dump({"decode": decoded, "encode": encoded}, sys.stdout)
