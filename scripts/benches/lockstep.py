"""Simulated seconds a second: whole processes of hil-sim, and the same scenario
written with cantools, python-can and numpy."""

import json
import pathlib
import tempfile

from . import common
from .figures import Row, Section, ratios

SIMULATED_S = 150.0
FAST_BUS = ["--set", "period_s=0.001", "--set", "bus.bitrate_bit_s=1000000"]
IDEAL = ["--set", 'bus.link="ideal"', "--set", "period_s=0.001"]
UNLOGGED = ["--no-log", "--no-report"]
PEER = common.ROOT / "scripts/peers/lockstep.py"
# The peer takes minutes for all of the scenario, so that it is timed for its first
# seconds; what it does in a period is much the same later.
PEER_S, PEER_QUICK_S = 10.0, 4.0
# A peer that simulates something else, or less, is no peer.
AGREEMENT = 0.1


def real_times(arguments, folder, core=None):
    command = [common.HIL_SIM, "run", "dac-friction", "--out", folder, *arguments]
    return SIMULATED_S / common.spend(command, core)[0]


def peer(period_s, duration_s, core):
    return json.loads(common.told([common.PYTHON, PEER, str(period_s), str(duration_s)], core))


def rms_m(folder, period_s, duration_s):
    arguments = ["--set", f"period_s={period_s}", "--set", f"duration_s={duration_s}", "--set", "expect=[]"]
    common.spend([common.HIL_SIM, "run", "dac-friction", "--out", folder, *UNLOGGED, *arguments])
    return json.loads((pathlib.Path(folder) / "summary.json").read_text())["tracking"]["rms_m"]


def check_agreement(peer_m, our_m):
    if abs(peer_m - our_m) > AGREEMENT * our_m:
        raise SystemExit(
            f"scripts/bench: {PEER.name} is {1e3 * peer_m:.3f} mm off the path (rms) where hil-sim is {1e3 * our_m:.3f} mm:"
            " they do not simulate the same, so their speeds cannot be compared"
        )


def run(turns, is_quick):
    core, peer_s = common.last_core(), PEER_QUICK_S if is_quick else PEER_S
    over_can, logged, bare, theirs = [], [], [], []
    with tempfile.TemporaryDirectory() as folder:
        expected_m = rms_m(folder, 0.001, peer_s)
        if not is_quick:
            common.progress("lockstep: whether the peer agrees")
            check_agreement(peer(0.005, SIMULATED_S, core)["rms_m"], rms_m(folder, 0.005, SIMULATED_S))
        for turn in range(turns):
            common.progress(f"lockstep: turn {turn + 1} of {turns}")
            over_can.append(real_times([*FAST_BUS, *UNLOGGED], folder, core))
            bare.append(real_times([*IDEAL, *UNLOGGED], folder, core))
            said = peer(0.001, peer_s, core)
            check_agreement(said["rms_m"], expected_m)
            theirs.append(said["times_real_time"])
            if not is_quick:
                logged.append(real_times([*FAST_BUS, "--no-report"], folder))
    common.progress("")
    rows = [
        Row("cost over CAN, times plant and law alone", ratios(bare, over_can), at_most=2.5, guarded=True),
        Row("over CAN, times as fast as the Python peer", ratios(over_can, theirs), at_least=300, guarded=True),
    ]
    how = (
        f"{SIMULATED_S:.0f} s of `dac-friction` at T = 1 ms and 1 Mbit/s, whole process from start to exit, on one core unless"
        f" logged; the peer is `scripts/peers/lockstep.py`, {peer_s:.0f} s of the same without its start-up, whose distance"
        f" from the path (rms) must agree with hil-sim's to {100 * AGREEMENT:.0f} %."
    )
    return Section("lockstep", how, rows, [] if is_quick else figures(over_can, logged, bare, theirs))


def figures(over_can, logged, bare, theirs):
    return [
        Row("over CAN, with the wire, no log", over_can, "times real time", at_least=2000),
        Row("over CAN, with the wire, everything logged", logged, "times real time"),
        Row("plant and law alone, no log", bare, "times real time"),
        Row("the peer: cantools, python-can and numpy", theirs, "times real time"),
    ]
