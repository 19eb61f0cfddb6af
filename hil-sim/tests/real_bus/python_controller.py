"""A controller on python-can and cantools that knows the drives from their DBC
alone: it enables them, tries torques, and lets go.

usage: python_controller.py DBC_FOLDER vcan0|tcp://HOST:PORT/NAME
"""

import logging
import sys
from pathlib import Path
from urllib.parse import urlsplit

import can
import cantools

# It warns of messages that come in two pieces, which is nothing to warn of.
logging.getLogger("can.interfaces.socketcand.socketcand").addFilter(
    lambda record: "incomplete message =>" not in record.getMessage()
)

WHEELS = ("Right", "Left")
PERIODS = 50


class Controller:
    def __init__(self, dbc_folder, address):
        self.drives = cantools.database.load_file(dbc_folder / "wheel_drive.dbc")
        self.marker = cantools.database.load_file(dbc_folder / "sim.dbc").get_message_by_name("StepEnd")
        self.bus = join(address)
        self.sync_counter = 0
        self.command_counter = 0
        self.over = False

    def period(self, request, torque_nm):
        """Sends commands and the SYNC that puts them into force; gives the
        feedback of both drives, by wheel."""
        for wheel, torque in zip(WHEELS, torque_nm):
            signals = {"Torque": torque, "Request": request, "Counter": self.command_counter, "Crc": 0}
            self.send(f"{wheel}Command", signals)
        self.command_counter = (self.command_counter + 1) % 16
        self.send("Sync", {"Counter": self.sync_counter})
        self.sync_counter = (self.sync_counter + 1) % 256
        return self.listen()

    def send(self, name, signals):
        message = self.drives.get_message_by_name(name)
        data = message.encode(signals)
        if "Crc" in signals:
            data = data[:-1] + bytes([crc(message.frame_id, data[:-1])])
        self.bus.send(can.Message(arbitration_id=message.frame_id, data=data, is_extended_id=False))

    def listen(self):
        """What the drives say, up to the marker that ends the step."""
        feedback = {}
        while True:
            frame = self.bus.recv(timeout=1)
            if frame is None:
                continue
            if frame.arbitration_id == self.marker.frame_id:
                self.over = self.marker.decode(frame.data)["Last"] == "Over"
                return feedback
            message = self.drives.get_message_by_frame_id(frame.arbitration_id)
            if message.name.endswith("Feedback"):
                assert frame.data[-1] == crc(frame.arbitration_id, frame.data[:-1]), frame
                feedback[message.name.removesuffix("Feedback")] = message.decode(frame.data)


def join(address):
    url = urlsplit(address)
    if url.scheme == "tcp":
        return can.Bus(interface="socketcand", host=url.hostname, port=url.port, channel=url.path.lstrip("/"))
    return can.Bus(interface="socketcan", channel=address)


def crc(frame_id, data):
    """SAE J1850 CRC-8 over the id, low byte first, and the bytes."""
    register = 0xFF
    for byte in frame_id.to_bytes(2, "little") + bytes(data):
        register ^= byte
        for _ in range(8):
            register = (register << 1 ^ 0x1D if register & 0x80 else register << 1) & 0xFF
    return register ^ 0xFF


def main(dbc_folder, address):
    controller = Controller(dbc_folder, address)

    def hold(request, torque_nm=(0, 0)):
        for _ in range(PERIODS):
            feedback = controller.period(request, torque_nm)
        return [feedback[wheel] for wheel in WHEELS]

    def check(feedback, state, torque_nm=(0, 0)):
        assert [drive["State"] for drive in feedback] == [state] * 2, feedback
        assert all(abs(drive["TorqueApplied"] - wanted) < 0.003 for drive, wanted in zip(feedback, torque_nm)), feedback
        return [drive["Position"] for drive in feedback]

    at_rest = check(hold("Disable", (80, 80)), "Ready")
    assert check(hold("Enable"), "Enabled") == at_rest
    # Friction holds the wheels up to 60 N m.
    assert check(hold("Enable", (40, -30)), "Enabled", (40, -30)) == at_rest
    moved = check(hold("Enable", (75, 70)), "Enabled", (75, 70))
    assert all(after > before for before, after in zip(at_rest, moved)), (at_rest, moved)
    check(hold("Disable", (75, 70)), "Ready")
    while not controller.over:
        controller.period("Disable", (0, 0))
    controller.bus.shutdown()
    print("the drives did as they were told")


main(Path(sys.argv[1]), sys.argv[2])
