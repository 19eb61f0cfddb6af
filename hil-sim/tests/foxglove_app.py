"""Does what the Foxglove app does: connects, sees the channels, subscribes to
all of them, and keeps what it is told.

usage: foxglove_app.py ADDRESS SEEN.json
"""

import base64
import json
import struct
import sys
import time

from websockets.exceptions import WebSocketException
from websockets.sync.client import connect

ENOUGH = 400
# By then everything has been sent that is sent again and again.
LATE_NS = 2_000_000_000


def main(address, path):
    with reach(address) as socket:
        assert socket.subprotocol == "foxglove.sdk.v1", socket.subprotocol
        channels, messages, info = {}, [], None
        while len(messages) < ENOUGH or messages[-1]["log_time"] < LATE_NS:
            heard = socket.recv(timeout=60)
            if isinstance(heard, bytes):
                opcode, subscription, log_time = struct.unpack_from("<BIQ", heard)
                if opcode == 1:
                    data = base64.b64encode(heard[13:]).decode()
                    messages.append({"channel": subscription, "log_time": log_time, "data": data})
                continue
            said = json.loads(heard)
            if said["op"] == "serverInfo":
                info = said
            elif said["op"] == "advertise":
                new = {channel["id"]: channel for channel in said["channels"]}
                channels |= new
                wanted = [{"id": id, "channelId": id} for id in new]
                socket.send(json.dumps({"op": "subscribe", "subscriptions": wanted}))
    assert info["name"].startswith("canloop ") and info["capabilities"] == [], info
    with open(path, "w") as file:
        json.dump({"channels": list(channels.values()), "messages": messages}, file)
    print("seen")


def reach(address):
    """The run may not serve yet."""
    for _ in range(1200):
        try:
            return connect(f"ws://{address}", subprotocols=["foxglove.sdk.v1"])
        except (OSError, WebSocketException):
            time.sleep(0.05)
    raise SystemExit(f"nobody serves at {address}")


main(*sys.argv[1:])
