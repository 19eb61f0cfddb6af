"""A user's program on python-can. Arguments: PORT COUNT, to send frames of all
lengths, print the COUNT frames that come, and send that count; or PORT join, to
join many times and hear a frame each time."""

import logging
import sys
import time

import can

# It warns of messages that come in two pieces, which is nothing to warn of.
logging.getLogger("can.interfaces.socketcand.socketcand").addFilter(
    lambda record: "incomplete message =>" not in record.getMessage()
)

PAYLOAD = bytes([0x00, 0x01, 0x0F, 0x10, 0x7F, 0x80, 0xF1, 0xFF])
IDS = [(0, False), (0x7FF, False), (1, True), (0x1FFFFFFF, True)]
JOINS = 20


def join(port):
    return can.Bus(interface="socketcand", host="127.0.0.1", port=port, channel="can0")


def receive(bus):
    """The next frame; python-can's recv may return early with nothing."""
    deadline = time.monotonic() + 20
    while time.monotonic() < deadline:
        message = bus.recv(timeout=1)
        if message is not None:
            return message
    sys.exit("no frame came")


def as_candump(message):
    digits = 8 if message.is_extended_id else 3
    return f"{message.arbitration_id:0{digits}X}#{message.data.hex().upper()}"


port = int(sys.argv[1])
if sys.argv[2] == "join":
    for _ in range(JOINS):
        with join(port) as bus:
            receive(bus)
    sys.exit()

count = int(sys.argv[2])
with join(port) as bus:
    for id, extended in IDS:
        for length in range(9):
            bus.send(can.Message(arbitration_id=id, is_extended_id=extended, data=PAYLOAD[:length]))
    for _ in range(count):
        message = receive(bus)
        if abs(message.timestamp - time.time()) > 20:
            sys.exit(f"the stamp {message.timestamp} is not of now")
        print(as_candump(message))
    bus.send(can.Message(arbitration_id=0x7DF, is_extended_id=False, data=count.to_bytes(4, "big")))
    # Closing at once could take the frame back.
    time.sleep(0.2)
