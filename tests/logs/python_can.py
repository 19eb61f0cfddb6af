"""Reads and writes logs with python-can.

usage: python_can.py read FILE...   prints a line of JSON for each message
       python_can.py write FOLDER   makes logs of the messages on stdin, the same lines
"""

import json
import os
import sys
import time

os.environ["TZ"] = "UTC"
time.tzset()

import can  # noqa: E402


def reader(path):
    if path.endswith(".asc"):
        return can.ASCReader(path, relative_timestamp=False)
    return can.LogReader(path)


def as_json(message):
    return {
        "time": message.timestamp,
        "channel": message.channel,
        "id": message.arbitration_id,
        "extended": message.is_extended_id,
        "remote": message.is_remote_frame,
        "error": message.is_error_frame,
        "fd": message.is_fd,
        "switch": message.bitrate_switch,
        "passive": message.error_state_indicator,
        "received": message.is_rx,
        "data": bytes(message.data).hex(),
    }


def of_json(line):
    known = json.loads(line)
    return can.Message(
        timestamp=known["time"],
        channel=known["channel"],
        arbitration_id=known["id"],
        is_extended_id=known["extended"],
        is_remote_frame=known["remote"],
        is_error_frame=known["error"],
        is_fd=known["fd"],
        bitrate_switch=known["switch"],
        error_state_indicator=known["passive"],
        is_rx=known["received"],
        data=bytes.fromhex(known["data"]),
    )


if sys.argv[1] == "read":
    for path in sys.argv[2:]:
        for message in reader(path):
            print(json.dumps({"file": os.path.basename(path), **as_json(message)}))
else:
    messages = [of_json(line) for line in sys.stdin]
    for name in ("p.asc", "p.blf", "p.trc", "p.log", "p.csv"):
        with can.Logger(os.path.join(sys.argv[2], name)) as log:
            for message in messages:
                is_plain = not (message.is_fd or message.is_remote_frame or message.is_error_frame)
                if is_plain or name in ("p.asc", "p.blf", "p.log"):
                    log.on_message_received(message)
