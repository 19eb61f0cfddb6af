"""Lets several loggers log the same frames on vcan0, one after the other.

usage: capture.py CANLOOP COUNT
Prints the logger, its CPU seconds a million frames, and the share that it kept.
"""

import os
import pathlib
import signal
import socket
import struct
import subprocess
import sys
import tempfile
import time

CANLOOP, COUNT = sys.argv[1], int(sys.argv[2])
PYTHON = os.environ["PYTHON_CAN"]
# A full bus of 1 Mbit/s brings some 8 000 frames of 8 bytes a second.
FRAMES_S = 8000
LOGGER = "import can, sys\nfrom can.io import Logger\nbus = can.Bus('vcan0', interface='socketcan')\n" \
    "writer = Logger('python.log')\ntry:\n    while True:\n        message = bus.recv(1)\n" \
    "        if message: writer(message)\nexcept KeyboardInterrupt:\n    writer.stop()"
COUNT_MCAP = "import sys\nfrom mcap.reader import make_reader\n" \
    "print(sum(1 for _ in make_reader(open(sys.argv[1], 'rb')).iter_messages(topics=['/can/vcan0'])))"


def listeners():
    listed = pathlib.Path("/proc/net/can/rcvlist_all").read_text().splitlines()
    return sum(line.strip().startswith("vcan0") for line in listed)


def send(bus):
    began = time.perf_counter()
    for number in range(COUNT):
        data = struct.pack(">II", number, number * 2654435761 % 2**32)
        bus.send(struct.pack("=IB3x8s", 0x100 + number % 8, 8, data))
        if number % 80 == 0:
            time.sleep(max(0.0, began + number / FRAMES_S - time.perf_counter()))


def log(command, folder):
    logging = subprocess.Popen(command, cwd=folder, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    while listeners() < 1:
        time.sleep(0.05)
    with socket.socket(socket.PF_CAN, socket.SOCK_RAW, socket.CAN_RAW) as bus:
        bus.setsockopt(socket.SOL_CAN_RAW, socket.CAN_RAW_FILTER, b"")
        bus.bind(("vcan0",))
        send(bus)
    time.sleep(1.5)
    logging.send_signal(signal.SIGINT)
    _, _, usage = os.wait4(logging.pid, 0)
    return usage.ru_utime + usage.ru_stime


def main():
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        cpu_s = log([CANLOOP, "log", "--bus", "vcan0", "-o", "canloop.mcap"], folder)
        counted = subprocess.run([PYTHON, "-c", COUNT_MCAP, folder / "canloop.mcap"], capture_output=True, check=True)
        tell("canloop", cpu_s, int(counted.stdout))
        cpu_s = log(["candump", "-l", "vcan0"], folder)
        tell("candump", cpu_s, sum(len(path.read_text().splitlines()) for path in folder.glob("candump-*")))
        cpu_s = log([PYTHON, "-c", LOGGER], folder)
        tell("python-can", cpu_s, len((folder / "python.log").read_text().splitlines()))


def tell(logger, cpu_s, kept):
    print(logger, cpu_s * 1e6 / COUNT, kept / COUNT, flush=True)


main()
