"""The scenario dac-friction as one would write it today with cantools, python-can's
virtual bus and numpy: what hil-sim's lock-step runs are compared with.

usage: lockstep.py PERIOD_S DURATION_S
Prints, as JSON, simulated seconds a second and the rms of the position error.
"""

import json
import math
import pathlib
import sys
import time
import tomllib

import can
import cantools
import numpy as np

from wheel_plant import Lag, Plant, mass_matrix

ROOT = pathlib.Path(__file__).resolve().parents[2]
SCENARIO = tomllib.loads((ROOT / "hil-sim/scenarios/dac-friction.toml").read_text())
DBC = cantools.database.load_file(ROOT / "dbc/wheel_drive.dbc")
NAMES = ("Right", "Left")
HEARTBEAT_S = 0.1
WATCHDOG_PERIODS = 4


def crc_table(polynomial=0x1D):
    table = []
    for byte in range(256):
        for _ in range(8):
            byte = (byte << 1) ^ polynomial if byte & 0x80 else byte << 1
        table.append(byte & 0xFF)
    return table


CRC_TABLE = crc_table()


def crc8(arbitration_id, data):
    """SAE J1850 over the id, low byte first, and the data."""
    crc = 0xFF
    for byte in arbitration_id.to_bytes(2, "little") + data:
        crc = CRC_TABLE[crc ^ byte]
    return crc ^ 0xFF


def send(bus, name, signals):
    message = DBC.get_message_by_name(name)
    data = message.encode(signals)
    if "Crc" in signals:
        data = data[:-1] + bytes([crc8(message.frame_id, data[:-1])])
    bus.send(can.Message(arbitration_id=message.frame_id, data=data, is_extended_id=False))


def received(bus):
    """Names and signals of all that waits on this bus."""
    while (frame := bus.recv(timeout=0)) is not None:
        message = DBC.get_message_by_frame_id(frame.arbitration_id)
        signals = message.decode(frame.data)
        if "Crc" in signals and signals["Crc"] != crc8(frame.arbitration_id, bytes(frame.data[:-1])):
            raise RuntimeError(f"{message.name} is damaged")
        yield message.name, signals


class Drives:
    """Both motor drives, with the robot behind them."""

    def __init__(self, bus, period_s):
        drive = SCENARIO["drive"]
        self.bus, self.period_s = bus, period_s
        self.plant = Plant(SCENARIO["robot"], SCENARIO["start"])
        self.counts_per_rad = drive["counts_per_turn"] * SCENARIO["robot"]["gear_ratio"] / (2.0 * math.pi)
        self.limit_nm, self.lag_s = drive["torque_limit_nm"], drive["current_loop_s"]
        self.torque = Lag(np.zeros(2), np.zeros(2), self.lag_s)
        self.states = ["Boot", "Boot"]
        self.commands = [None, None]
        self.silent_periods = [0, 0]
        self.periods = 0

    def answer(self):
        for name, signals in received(self.bus):
            if name == "Sync":
                self.sync(signals["Counter"])
            else:
                self.commands[name == "LeftCommand"] = signals

    def sync(self, counter):
        applied_nm = np.zeros(2)
        if self.periods > 0:
            self.plant.advance(self.period_s, self.torque)
            applied_nm = self.torque.mean(self.period_s)
        self.take_commands()
        self.beat()
        self.periods += 1
        counts = np.floor(self.plant.angles_rad * self.counts_per_rad).astype(np.int64)
        for wheel, name in enumerate(NAMES):
            feedback = {"Position": (int(counts[wheel]) + 2**31) % 2**32 - 2**31, "TorqueApplied": applied_nm[wheel]}
            feedback |= {"State": self.states[wheel], "Counter": counter % 16, "Crc": 0}
            send(self.bus, f"{name}Feedback", feedback)

    def take_commands(self):
        """What the last commands asked for is in force from now on."""
        now_nm = self.torque.at(self.period_s)
        wanted_nm = self.torque.final_nm.copy()
        for wheel, command in enumerate(self.commands):
            self.step_state(wheel, command)
            if self.states[wheel] != "Enabled":
                now_nm[wheel] = wanted_nm[wheel] = 0.0
            elif command is not None:
                wanted_nm[wheel] = command["Torque"]
        self.torque = Lag(now_nm, np.clip(wanted_nm, -self.limit_nm, self.limit_nm), self.lag_s)
        self.commands = [None, None]

    def step_state(self, wheel, command):
        self.silent_periods[wheel] = 0 if command else self.silent_periods[wheel] + 1
        if self.states[wheel] == "Boot":
            self.states[wheel] = "Ready"
        elif self.states[wheel] == "Enabled" and self.silent_periods[wheel] > WATCHDOG_PERIODS:
            self.states[wheel] = "Fault"
        elif command is not None:
            asked = {("Ready", "Enable"): "Enabled", ("Enabled", "Disable"): "Ready", ("Fault", "ClearFault"): "Ready"}
            self.states[wheel] = asked.get((self.states[wheel], str(command["Request"])), self.states[wheel])

    def beat(self):
        if self.periods % round(HEARTBEAT_S / self.period_s) == 0:
            for wheel, name in enumerate(NAMES):
                send(self.bus, f"{name}Heartbeat", {"State": self.states[wheel], "FaultCode": "None"})


class Circle:
    """Eq 19: speeds up evenly for half the time, and slows down for the other half."""

    def __init__(self, path):
        self.center_m, self.radius_m, self.duration_s = path["center_m"], path["radius_m"], path["duration_s"]
        self.acceleration_m_s2 = 2.0 * math.pi * self.radius_m / (0.5 * self.duration_s) ** 2

    def along(self, t_s):
        """Distance and speed."""
        if t_s <= 0.5 * self.duration_s:
            return 0.5 * self.acceleration_m_s2 * t_s**2, self.acceleration_m_s2 * t_s
        left_s = max(0.0, self.duration_s - t_s)
        length_m = 2.0 * math.pi * self.radius_m
        return length_m - 0.5 * self.acceleration_m_s2 * left_s**2, self.acceleration_m_s2 * left_s

    def place_m(self, t_s):
        angle_rad = self.along(t_s)[0] / self.radius_m
        return (
            self.center_m[0] + self.radius_m * math.cos(angle_rad),
            self.center_m[1] + self.radius_m * math.sin(angle_rad),
        )


class Stack:
    """Guidance and digital acceleration control, fed with the torque that was applied."""

    def __init__(self, bus, period_s):
        robot, controller = SCENARIO["robot"], SCENARIO["controller"]
        self.bus, self.period_s = bus, period_s
        self.path = Circle(SCENARIO["path"])
        self.believed_mass = mass_matrix(robot, robot["load"] | controller["model"]["load"])
        self.kd, self.kp, self.filter = controller["kd_per_s"], controller["kp_per_s2"], controller["filter"]
        sides_m = np.array([robot["half_track_m"], -robot["half_track_m"]])
        # What each wheel turns for a metre along the circle, rad.
        self.rad_per_m = (1.0 + sides_m / self.path.radius_m) / robot["wheel_radius_m"]
        self.rad_per_count = 2.0 * math.pi / (SCENARIO["drive"]["counts_per_turn"] * robot["gear_ratio"])
        self.limit_nm = SCENARIO["drive"]["torque_limit_nm"]
        self.periods, self.running_since = 0, None
        self.counts, self.travelled = None, np.zeros(2, dtype=np.int64)
        self.speed_rad_s, self.applied_nm = np.zeros(2), np.zeros(2)
        self.target_rad, self.disturbance_nm = np.zeros(2), np.zeros(2)

    def sync(self):
        send(self.bus, "Sync", {"Counter": self.periods % 256})

    def path_s(self):
        """Time on the path."""
        return 0.0 if self.running_since is None else (self.periods - self.running_since) * self.period_s

    def control(self):
        """Takes the feedback of this period and answers with torques."""
        feedback = {}
        for name, signals in received(self.bus):
            if name.endswith("Feedback"):
                if signals["Counter"] != self.periods % 16:
                    raise RuntimeError(f"{name} answers another period")
                feedback[name] = signals
            if signals["State"] == "Fault":
                raise RuntimeError(f"{name} tells of a fault")
        both = [feedback[f"{name}Feedback"] for name in NAMES]
        measured = self.measure(both)
        if self.running_since is None and all(side["State"] == "Enabled" for side in both):
            self.running_since, self.travelled = self.periods, np.zeros(2, dtype=np.int64)
        torque_nm = np.zeros(2) if self.running_since is None else self.law_nm(*measured)
        self.command(np.clip(torque_nm, -self.limit_nm, self.limit_nm), both)
        self.periods += 1

    def measure(self, both):
        """Acceleration, and the torque that acted while it happened."""
        counts = np.array([side["Position"] for side in both], dtype=np.int64)
        moved = (counts - (counts if self.counts is None else self.counts) + 2**31) % 2**32 - 2**31
        self.counts, self.travelled = counts, self.travelled + moved
        before_rad_s, self.speed_rad_s = self.speed_rad_s, moved * self.rad_per_count / self.period_s
        before_nm, self.applied_nm = self.applied_nm, np.array([side["TorqueApplied"] for side in both])
        return (self.speed_rad_s - before_rad_s) / self.period_s, 0.5 * (self.applied_nm + before_nm)

    def law_nm(self, acceleration_rad_s2, applied_nm):
        t_s, period_s = self.path_s(), self.period_s
        target_rad = self.path.along(t_s)[0] * self.rad_per_m
        target_rad_s = (target_rad - self.target_rad) / period_s
        gained_m_s = self.path.along(t_s + 2.0 * period_s)[1] - self.path.along(t_s + period_s)[1]
        self.target_rad = target_rad
        error_rad = target_rad - self.travelled * self.rad_per_count
        error_rad_s = target_rad_s - self.speed_rad_s
        wanted_rad_s2 = gained_m_s / period_s * self.rad_per_m + self.kd * error_rad_s + self.kp * error_rad
        unexplained_nm = applied_nm - self.believed_mass @ acceleration_rad_s2
        self.disturbance_nm = self.disturbance_nm + self.filter * (unexplained_nm - self.disturbance_nm)
        return self.disturbance_nm + self.believed_mass @ wanted_rad_s2

    def command(self, torque_nm, both):
        for wheel, name in enumerate(NAMES):
            request = "Disable" if both[wheel]["State"] == "Boot" else "Enable"
            command = {"Torque": torque_nm[wheel], "Request": request, "Counter": self.periods % 16, "Crc": 0}
            send(self.bus, f"{name}Command", command)


def run(period_s, duration_s):
    periods, squares_m2 = round(duration_s / period_s), 0.0
    with can.Bus("lockstep", interface="virtual") as near, can.Bus("lockstep", interface="virtual") as far:
        stack, drives = Stack(near, period_s), Drives(far, period_s)
        before = time.perf_counter()
        for _ in range(periods):
            stack.sync()
            drives.answer()
            x_m, y_m = stack.path.place_m(stack.path_s())
            squares_m2 += (drives.plant.state[4] - x_m) ** 2 + (drives.plant.state[5] - y_m) ** 2
            stack.control()
        elapsed_s = time.perf_counter() - before
    return {"times_real_time": duration_s / elapsed_s, "rms_m": math.sqrt(squares_m2 / periods)}


if __name__ == "__main__":
    print(json.dumps(run(float(sys.argv[1]), float(sys.argv[2]))))
