"""Two look at the same run: one never reads, one reads to the end.

usage: live_viewers.py ADDRESS
"""

import json
import socket
import sys


def main(address):
    stuck = ask_for_updates(address, receive_bytes=1)
    reads = ask_for_updates(address)
    last = None
    for line in reads.makefile("r", encoding="utf-8"):
        if line.startswith("data: "):
            last = json.loads(line.removeprefix("data: "))
    missed = last["viewing"]["updates_missed"]
    assert missed > 0, last["viewing"]
    assert 20 <= last["now"]["time_s"] < 20.01 and last["now"]["lost"]["periods_unanswered"] == 0, last["now"]
    print(last["ended"], missed, "updates missed")
    stuck.close()


def ask_for_updates(address, receive_bytes=None):
    host, port = address.rsplit(":", 1)
    viewer = socket.socket()
    if receive_bytes:
        viewer.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, receive_bytes)
    viewer.connect((host, int(port)))
    viewer.sendall(f"GET /updates HTTP/1.1\r\nHost: {address}\r\n\r\n".encode())
    return viewer


main(sys.argv[1])
