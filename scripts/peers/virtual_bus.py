"""Frames a second through python-can's virtual bus, from one bus object to
another in one process: the least that a test written with it pays.

usage: virtual_bus.py COUNT
"""

import sys
import time

import can

count = int(sys.argv[1])
with can.Bus("bench", interface="virtual") as sender, can.Bus("bench", interface="virtual") as receiver:
    before = time.perf_counter()
    for number in range(count):
        sender.send(can.Message(arbitration_id=number % 0x800, data=bytes(8), is_extended_id=False))
        assert receiver.recv(1.0) is not None
    print(count / (time.perf_counter() - before))
