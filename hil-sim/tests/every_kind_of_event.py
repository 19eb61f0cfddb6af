"""Runs a scenario for each kind of event and finds in its log, with readers that
we did not write and formulas of its own, that the event did what it says.

usage: every_kind_of_event.py HIL_SIM FOLDER
"""

import json
import math
import subprocess
import sys
from pathlib import Path

import cantools
from mcap.reader import make_reader
from mcap_protobuf.decoder import DecoderFactory as ProtobufFactory
from mcap_ros2.decoder import DecoderFactory as Ros2Factory

PERIOD_S = 0.005
# By then both wheels have broken loose.
BEFORE_S, BEGIN_S, END_S, DURATION_S = 2.5, 3.0, 3.5, 5.0
COUNTS_PER_RAD = 65536 * 3 / (2 * math.pi)

# The robot of the scenario `dac-friction`, for formulas of eq 1 to 8.
HALF_TRACK_M, RADIUS_M, GRAVITY_M_S2 = 0.27, 0.122, 9.80665
ROBOT_KG, ROBOT_KG_M2, LOAD_KG, COG_M, COG_RAD = 46.5, 1.3133, 80.0, 0.2, 2.0943951023931953
TURNING_KG_M2 = 0.0144 + 3.0**2 * 0.0125

BASE = f"""
base = "{{base}}"
name = "{{name}}"
duration_s = {DURATION_S}
expect = []
path.duration_s = 40.0
safety.encoder_jump_rad = 100.0
[[event]]
kind = "{{kind}}"
at_s = {BEGIN_S}
{{keys}}
"""
FOR_A_WHILE = f"until_s = {END_S}\n"
SMOOTH_FLOOR = "dac-no-friction"


def main(hil_sim, folder):
    names = {kind: kind.replace(" ", "-") for kind in KINDS}
    for kind, (keys, _, settings) in KINDS.items():
        text = BASE.format(name=names[kind], kind=kind.split()[0], keys=keys, base=settings or "dac-friction")
        (folder / f"{names[kind]}.toml").write_text(text)
    files = [f"{name}.toml" for name in names.values()]
    subprocess.run([hil_sim, "run", "--no-report", *files], cwd=folder, check=True, stdout=subprocess.DEVNULL)
    for kind, (_, check, _) in KINDS.items():
        try:
            check(Run(folder / "runs" / names[kind]))
        except AssertionError as error:
            raise AssertionError(f"{kind}: {error}") from error
    print(" ".join(sorted({kind.split()[0] for kind in KINDS})))


class Run:
    """What the log of a run holds."""

    def __init__(self, folder):
        self.summary = json.loads((folder / "summary.json").read_text())
        self.frames, self.messages, self.stack, self.truth, self.notices = [], {}, [], [], []
        with open(folder / "run.mcap", "rb") as log:
            reader = make_reader(log, decoder_factories=[ProtobufFactory(), Ros2Factory()])
            dbc = next(a for a in reader.iter_attachments() if a.name.endswith(".dbc"))
            self.dbc = cantools.database.load_string(dbc.data.decode())
            for _, channel, message, value in reader.iter_decoded_messages():
                self.take(message.log_time / 1e9, channel.topic, value)

    def take(self, at_s, topic, value):
        if topic == "/can/can0":
            data = bytes(value.data[: value.dlc])
            self.frames.append((at_s, value.id, data))
            try:
                message = self.dbc.get_message_by_frame_id(value.id)
            except KeyError:
                return
            signals = message.decode(data, decode_choices=False)
            self.messages.setdefault(message.name, []).append((at_s, signals, data))
        elif topic == "/canloop/stack":
            self.stack.append((at_s, value))
        elif topic == "/canloop/truth":
            self.truth.append((at_s, value))
        elif topic == "/canloop/notices":
            self.notices.append((at_s, value))

    def during(self, name, begin_s=BEGIN_S, end_s=END_S):
        """A message's frames while the event goes on; its edges are left out."""
        return [entry for entry in self.messages.get(name, []) if begin_s + 2 * PERIOD_S < entry[0] < end_s - PERIOD_S]

    def before(self, name):
        return self.during(name, BEFORE_S, BEGIN_S)

    def after_sync_s(self, entries):
        """How long after the SYNC before it each frame came."""
        syncs = [at_s for at_s, *_ in self.messages["Sync"]]
        return [min(at_s - sync for sync in syncs if sync <= at_s) for at_s, *_ in entries]

    def state_at(self, t_s):
        return next(value.state for at_s, value in self.stack if at_s >= t_s)

    def motion(self, begin_s, end_s):
        """Torque, speed and acceleration of both wheels in each period, right first."""
        truths = [value for at_s, value in self.truth if begin_s + 3 * PERIOD_S < at_s < end_s - PERIOD_S]
        for one, next_one in zip(truths, truths[1:]):
            torque = (next_one.torque_right_nm, next_one.torque_left_nm)
            before = (one.true_speed_right_rad_s, one.true_speed_left_rad_s)
            after = (next_one.true_speed_right_rad_s, next_one.true_speed_left_rad_s)
            yield torque, [0.5 * (a + b) for a, b in zip(before, after)], [(a - b) / PERIOD_S for a, b in zip(after, before)]


def near(found, expected, within):
    assert abs(found - expected) <= within, f"found {found}, expected {expected} within {within}"


# The bus.


def drop(run):
    assert len(run.before("RightFeedback")) > 90 and not run.during("RightFeedback"), "right feedback is gone"
    assert len(run.during("LeftFeedback")) > 90, "left feedback is there"


def delay(run):
    before, during = (run.after_sync_s(entries("RightFeedback")) for entries in (run.before, run.during))
    near(min(during) - min(before), 0.002, 2e-4)


def duplicate(run):
    near(len(run.during("RightCommand")) / len(run.during("LeftCommand")), 3.0, 0.05)


def reorder(run):
    def right_is_first(entries):
        order = sorted((at_s, name) for name in ("RightCommand", "LeftCommand") for at_s, *_ in entries(name))
        return [name for _, name in order][0] == "RightCommand"

    assert right_is_first(run.before) and not right_is_first(run.during)


def crc8(frame_id, data):
    remainder = 0xFF
    for byte in frame_id.to_bytes(2, "little") + data:
        remainder ^= byte
        for _ in range(8):
            remainder = (remainder << 1 ^ (0x1D if remainder & 0x80 else 0)) & 0xFF
    return remainder ^ 0xFF


def corrupt_missed(run):
    def wrong(entries):
        return sum(crc8(0x182, data[:7]) != data[7] for _, _, data in entries)

    assert wrong(run.before("LeftFeedback")) == 0
    during = run.during("LeftFeedback")
    assert wrong(during) == len(during) > 90, "each is damaged, and the drive's own CRC shows it"


def corrupt_caught(run):
    before, during = (run.after_sync_s(entries("LeftFeedback")) for entries in (run.before, run.during))
    assert all(crc8(0x182, data[:7]) == data[7] for _, _, data in run.during("LeftFeedback"))
    late = sum(after_s > min(before) + 1e-4 for after_s in during)
    assert late >= run.summary["bus"]["error_frames"] > 4, "some took another try"


def left_is_gone(run):
    gone = [name for name in run.messages if name.startswith("Left") and name != "LeftCommand"]
    assert gone and not any(run.during(name) for name in gone)
    assert len(run.during("RightFeedback")) > 90


def bus_off(run):
    left_is_gone(run)
    assert run.summary["bus"]["nodes"]["left"]["bus_off"] == 1
    assert len(run.during("LeftFeedback", END_S, DURATION_S)) > 200, "and comes back"


def no_acknowledge(run):
    assert not run.during("RightFeedback")
    assert run.summary["bus"]["nodes"]["right"]["failed"] > 100, "it tries again and again"


def babble(run):
    at_s = [at_s for at_s, frame_id, _ in run.frames if frame_id == 7]
    assert at_s and BEGIN_S <= min(at_s) and max(at_s) < END_S + PERIOD_S
    near(len(at_s), 50, 2)


def bit_errors(run):
    # Half a second at 500 kbit/s and about a fifth of load: some 50 000 bits.
    assert 20 < run.summary["bus"]["error_frames"] < 150, run.summary["bus"]


def bursty_loss(run):
    lost = 100 - len(run.during("RightFeedback"))
    assert 10 < lost < 90, lost
    near(len(run.before("RightFeedback")), 98, 2)


# Drives.


def power_loss(run):
    assert not any(run.during(name) for name in ("RightFeedback", "RightHeartbeat"))
    back = run.during("RightHeartbeat", END_S, DURATION_S)
    # Boot or Ready: it has forgotten that it was enabled.
    assert all(signals["State"] in (0, 1) for _, signals, _ in back) and back


def feedback_dropout(run):
    assert not run.during("LeftFeedback") and run.during("LeftHeartbeat")


def drive_fault(run):
    [(at_s, signals, _)] = run.messages["LeftFault"]
    near(at_s, BEGIN_S, 2 * PERIOD_S)
    wanted = run.dbc.get_message_by_name("LeftFault").get_signal_by_name("FaultCode").choices
    assert "emp" in str(wanted[signals["FaultCode"]]), wanted
    assert run.state_at(BEGIN_S + 0.1) >= 10


def brown_out(run):
    assert {"RightFault", "LeftFault"} <= set(run.messages)
    at_s = min(at_s for at_s, *_ in run.messages["RightFault"])
    truth = [value for t_s, value in run.truth if t_s <= at_s]
    total = [abs(value.torque_right_nm) + abs(value.torque_left_nm) for value in truth if value.tick >= BEGIN_S / PERIOD_S]
    assert max(total) > 5.0, max(total)


def heartbeat_gaps(run, begin_s, end_s):
    at_s = [at_s for at_s, *_ in run.messages["RightHeartbeat"] if begin_s < at_s < end_s]
    return [b - a for a, b in zip(at_s, at_s[1:])]


def clock_drift(run):
    usual = heartbeat_gaps(run, 0.2, BEGIN_S)
    drifting = heartbeat_gaps(run, BEGIN_S + 0.2, END_S)
    near(drifting[0] / usual[0], 1.5, 0.02)


def clock_phase(run):
    usual = heartbeat_gaps(run, 0.2, BEGIN_S)[0]
    near(max(heartbeat_gaps(run, 0.2, DURATION_S)) - usual, 0.03, 1e-3)
    near(sorted(heartbeat_gaps(run, BEGIN_S + 0.3, DURATION_S))[-1], usual, 1e-3)


def torque_limit(run):
    during = run.during("LeftFeedback")
    assert max(abs(signals["TorqueApplied"]) for _, signals, _ in during[3:]) <= 3.0 + 0.005
    assert max(abs(signals["TorqueApplied"]) for _, signals, _ in run.before("LeftFeedback")) > 5.0


def torque_sensor(run):
    truth = {value.tick: value.torque_left_nm for _, value in run.truth}
    pairs = [(signals["TorqueApplied"], truth[round(at_s / PERIOD_S - 0.2)]) for at_s, signals, _ in run.during("LeftFeedback")]
    ratios = [said / true for said, true in pairs if abs(true) > 1.0]
    near(sorted(ratios)[len(ratios) // 2], 1.25, 0.02)


def encoder_stuck(run):
    positions = {signals["Position"] for _, signals, _ in run.during("RightFeedback")}
    assert len(positions) == 1, positions
    assert len({signals["Position"] for _, signals, _ in run.before("RightFeedback")}) > 90


def offsets(run, name, field, begin_s, end_s, sign=1):
    """Counts reported less those of the true angle."""
    truth = {value.tick: getattr(value, field) for _, value in run.truth}
    entries = run.during(name, begin_s, end_s)
    return [signals["Position"] - sign * truth[round(at_s / PERIOD_S - 0.2)] * COUNTS_PER_RAD for at_s, signals, _ in entries]


def encoder_jump(run):
    before = offsets(run, "LeftFeedback", "true_angle_left_rad", BEFORE_S, BEGIN_S)
    during = offsets(run, "LeftFeedback", "true_angle_left_rad", BEGIN_S, END_S)
    near((during[0] - before[-1]) / COUNTS_PER_RAD, 0.25, 1e-3)
    near((during[-1] - during[0]) / COUNTS_PER_RAD, 0.0, 1e-3)


def encoder_reversed(run):
    truth = {value.tick: value.true_angle_right_rad for _, value in run.truth}
    entries = run.during("RightFeedback")
    said = entries[20][1]["Position"] - entries[0][1]["Position"]
    ticks = [round(entries[n][0] / PERIOD_S - 0.2) for n in (0, 20)]
    true = (truth[ticks[1]] - truth[ticks[0]]) * COUNTS_PER_RAD
    near(said / true, -1.0, 0.01)


# The robot.


def needed_nm(acceleration, load_kg=LOAD_KG):
    """Torque that accelerates the wheels so, eq 5."""
    total_kg, right_m = ROBOT_KG + load_kg, COG_M * math.cos(COG_RAD)
    arms = (HALF_TRACK_M + right_m, HALF_TRACK_M - right_m)
    c = (RADIUS_M / (2 * HALF_TRACK_M)) ** 2
    q = c * (ROBOT_KG_M2 + COG_M**2 * total_kg)
    own = [c * total_kg * arm**2 + q + TURNING_KG_M2 for arm in arms]
    cross = c * total_kg * arms[0] * arms[1] - q
    right, left = acceleration
    return own[0] * right + cross * left, cross * right + own[1] * left


def excess_nm(run, begin_s, end_s, load_kg=LOAD_KG):
    """Torque at each wheel that the acceleration does not explain, N m, in the mean."""
    periods = list(run.motion(begin_s, end_s))
    assert len(periods) > 50
    sums = [0.0, 0.0]
    for torque, _, acceleration in periods:
        for wheel, needed in enumerate(needed_nm(acceleration, load_kg)):
            sums[wheel] += torque[wheel] - needed
    return [total / len(periods) for total in sums]


def load(run):
    for begin_s, end_s, mass_kg in ((BEFORE_S, BEGIN_S, LOAD_KG), (BEGIN_S, END_S, 160.0)):
        for torque, _, acceleration in run.motion(begin_s, end_s):
            for found, needed in zip(torque, needed_nm(acceleration, mass_kg)):
                near(found, needed, 1e-6 + 1e-6 * abs(needed))
    heavier = [abs(t - n) for torque, _, a in run.motion(BEGIN_S, END_S) for t, n in zip(torque, needed_nm(a))]
    assert max(heavier) > 1e-4, "and not with the load that it had"


def friction(run):
    def viscous(begin_s, end_s):
        rows = [(w, t - n) for torque, speed, a in run.motion(begin_s, end_s) for w, t, n in zip(speed, torque, needed_nm(a)) if abs(w) > 0.2]
        assert len(rows) > 50
        for speed, excess in rows:
            yield excess / (0.2 * speed + 6.0)

    near(sum(viscous(BEFORE_S, BEGIN_S)) / len(list(viscous(BEFORE_S, BEGIN_S))), 1.0, 0.02)
    near(sum(viscous(BEGIN_S, END_S)) / len(list(viscous(BEGIN_S, END_S))), 2.0, 0.02)


def push(run):
    right, left = excess_nm(run, BEGIN_S, END_S)
    # The push does what the motors need not: eq 1-2 transposed.
    near(right, -(40.0 * RADIUS_M / 2 + 10.0 * RADIUS_M / (2 * HALF_TRACK_M)), 0.01)
    near(left, -(40.0 * RADIUS_M / 2 - 10.0 * RADIUS_M / (2 * HALF_TRACK_M)), 0.01)
    near(max(map(abs, excess_nm(run, BEFORE_S, BEGIN_S))), 0.0, 1e-6)


def slope(run):
    right, left = excess_nm(run, BEGIN_S, END_S)
    # It looks up the slope, give or take what it has turned by then.
    weight_nm = (ROBOT_KG + LOAD_KG) * GRAVITY_M_S2 * math.sin(0.03) * RADIUS_M / 2
    near(right + left, 2 * weight_nm, 0.05 * weight_nm)


def wheel_lift(run):
    for torque, speed, acceleration in run.motion(BEGIN_S, END_S):
        turns_round = abs(speed[0]) < 0.5 * PERIOD_S * abs(acceleration[0]) + 0.1
        if not turns_round:
            near(torque[0], TURNING_KG_M2 * acceleration[0] + math.copysign(6.0, speed[0]) + 0.2 * speed[0], 0.15)
    truths = [value for at_s, value in run.truth if BEGIN_S < at_s < END_S]
    turned = truths[-1].true_angle_right_rad - truths[0].true_angle_right_rad
    rolled_m = math.dist((truths[-1].x_m, truths[-1].y_m), (truths[0].x_m, truths[0].y_m))
    left = truths[-1].true_angle_left_rad - truths[0].true_angle_left_rad
    assert abs(0.5 * (turned + left) * RADIUS_M - rolled_m) > 0.005, "the robot did not roll as its wheel turned"


# The operator.


def stop(run):
    assert run.state_at(BEGIN_S + 2 * PERIOD_S) == 4, "it brakes"
    assert run.state_at(DURATION_S - 0.1) == 1, "it has stopped"
    last = run.truth[-1][1]
    assert (last.true_speed_right_rad_s, last.true_speed_left_rad_s) == (0.0, 0.0)


def emergency_stop(run):
    assert run.state_at(BEGIN_S + 2 * PERIOD_S) >= 10
    assert all(signals["Torque"] == 0 for _, signals, _ in run.during("RightCommand", BEGIN_S, DURATION_S))


def reset(run):
    assert run.state_at(BEGIN_S - 2 * PERIOD_S) >= 10 and run.state_at(BEGIN_S + 2 * PERIOD_S) == 1


def enable(run):
    assert run.state_at(BEGIN_S - 2 * PERIOD_S) == 1 and run.state_at(BEGIN_S + 0.2) == 3


def new_path(run):
    assert run.state_at(BEGIN_S + 2 * PERIOD_S) == 4, "it stops first"
    tick = run.stack[-1][1]
    assert tick.state == 3, "enabled again"
    near(tick.reference_y_m, 5.5, 1e-9)
    assert 8.0 < tick.reference_x_m < 9.0, "the reference is on the new path"


STOP_BEFORE = '[[event]]\nkind = "{}"\nat_s = 2.5\n'
ENABLE_AFTER = '[[event]]\nkind = "enable"\nat_s = 4.5\n'
NEW_PATH = '[event.path]\nkind = "line"\nfrom_m = [9.0, 5.5]\nto_m = [4.0, 5.5]\nduration_s = 5.0\n'

# Each with its keys, what is to be found, and the scenario that it is based on
# if that is another.
KINDS = {
    "drop": (FOR_A_WHILE + 'message = "RightFeedback"', drop, ""),
    "delay": (FOR_A_WHILE + 'message = "RightFeedback"\nby_s = 0.002', delay, ""),
    "duplicate": (FOR_A_WHILE + 'message = "RightCommand"\ntimes = 2', duplicate, ""),
    "reorder": (FOR_A_WHILE + 'message = "RightCommand"', reorder, ""),
    "corrupt missed": (FOR_A_WHILE + 'message = "LeftFeedback"\ncrc = "missed"', corrupt_missed, ""),
    "corrupt caught": (FOR_A_WHILE + 'message = "LeftFeedback"\nprobability = 0.2', corrupt_caught, ""),
    "silence": (FOR_A_WHILE + 'node = "left"', left_is_gone, ""),
    "bus-off": (FOR_A_WHILE + 'node = "left"', bus_off, ""),
    "cable-cut": (FOR_A_WHILE + 'node = "left"', left_is_gone, ""),
    "no-acknowledge": (FOR_A_WHILE + 'message = "RightFeedback"', no_acknowledge, ""),
    "babble": (FOR_A_WHILE + "id = 7\nperiod_s = 0.01", babble, ""),
    "bit-errors": (FOR_A_WHILE + "rate = 0.001", bit_errors, ""),
    "bursty-loss": (FOR_A_WHILE + "turns_bad = 0.05\nturns_good = 0.1", bursty_loss, ""),
    "power-loss": (FOR_A_WHILE + 'wheel = "right"', power_loss, ""),
    "feedback-dropout": (FOR_A_WHILE + 'wheel = "left"', feedback_dropout, ""),
    "drive-fault": ('fault = "over_temperature"\nwheel = "left"', drive_fault, ""),
    "brown-out": ("above_nm = 5.0", brown_out, ""),
    "clock-drift": (FOR_A_WHILE + "drift = 0.5", clock_drift, ""),
    "clock-phase": ("by_s = 0.03", clock_phase, ""),
    "torque-limit": (FOR_A_WHILE + 'limit_nm = 3.0\nwheel = "left"', torque_limit, ""),
    "torque-sensor": (FOR_A_WHILE + 'gain = 1.25\nwheel = "left"', torque_sensor, ""),
    "encoder-stuck": (FOR_A_WHILE + 'wheel = "right"', encoder_stuck, ""),
    "encoder-jump": (FOR_A_WHILE + 'jump_rad = 0.25\nwheel = "left"', encoder_jump, ""),
    "encoder-reversed": (FOR_A_WHILE + 'wheel = "right"', encoder_reversed, ""),
    "load": (FOR_A_WHILE + "mass_kg = 160.0", load, SMOOTH_FLOOR),
    "friction": (FOR_A_WHILE + "factor = 2.0", friction, ""),
    "push": (FOR_A_WHILE + "force_n = 40.0\nmoment_nm = 10.0", push, SMOOTH_FLOOR),
    "slope": (FOR_A_WHILE + f"angle_rad = 0.03\nuphill_rad = {math.pi / 2}", slope, SMOOTH_FLOOR),
    "wheel-lift": (FOR_A_WHILE + 'wheel = "right"', wheel_lift, ""),
    "stop": ("", stop, ""),
    "emergency-stop": ("", emergency_stop, ""),
    "reset": (STOP_BEFORE.format("emergency-stop"), reset, ""),
    "enable": (STOP_BEFORE.format("stop"), enable, ""),
    "new-path": (NEW_PATH + ENABLE_AFTER, new_path, ""),
}

if __name__ == "__main__":
    main(sys.argv[1], Path(sys.argv[2]))
